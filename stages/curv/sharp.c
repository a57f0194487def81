/* Which edges are sharp: threshold, exception for the regular bends of coarse rounds, cleaning of the chains.
 *
 * A coarse cylinder of 8 facets bends 45 degrees at each edge, as a chamfer does. What tells them apart is that the
 * cylinder does it again and again: four or more parallel bends of one size at one spacing are one round surface. */
#include "stages/curv/sharp.h"

#include <math.h>
#include <stdlib.h>

#include "formats/dense.h"
#include "stages/geometry/vector.h"

#define FLAT_RAD (2 / DEGREES)           /* edges that bend less are inside a facet */
#define REGULAR_HIGH_RAD (58 / DEGREES)  /* below 60: the sides of a hexagon nut are not a round */
#define PARALLEL_RAD (10 / DEGREES)
#define BEND_TOLERANCE 0.2               /* of the larger bend */
#define SPACING_TOLERANCE 0.3            /* of the larger spacing */
#define CHAIN_LEAST 4                    /* edges, with the one in question */
#define FACET_LIMIT 64                   /* triangles of one facet that a step may visit */
#define JOIN_RAD (30 / DEGREES)          /* edges that turn less at a vertex are one chain */
#define SPOKE_LIMIT 16                   /* edges over the angle at one vertex; where there are more, none goes on */
#define EXTENDED_LEAST 3                 /* edges of a chain that may be extended: on rough meshes pairs are chance */
#define TURN_LIMIT_RAD (45 / DEGREES)    /* an extension that turns more is another edge */

struct walk {
	const double *xyz, *bend;
	const struct half *half;
	unsigned *stamp;      /* face_count: visited in step .. */
	unsigned now;
};

static void edge_vector(double out[3], const struct walk *walk, idx_t h)
{
	sub3(out, walk->xyz + 3 * walk->half->origin[walk->half->next[h]], walk->xyz + 3 * walk->half->origin[h]);
}

/* Distance of the lines of two nearly parallel edges, measured at their middles across the first. */
static double line_spacing(const struct walk *walk, idx_t h, idx_t g)
{
	double e[3], d[3], m[2][3];
	const idx_t side[2] = {h, g};
	for (int i = 0; i < 2; i++) {
		const double *a = walk->xyz + 3 * walk->half->origin[side[i]];
		const double *b = walk->xyz + 3 * walk->half->origin[walk->half->next[side[i]]];
		for (int k = 0; k < 3; k++)
			m[i][k] = 0.5 * (a[k] + b[k]);
	}
	edge_vector(e, walk, h);
	normalise3(e);
	sub3(d, m[1], m[0]);
	add_scaled3(d, -dot3(d, e), e);
	return norm3(d);
}

/* Share of the shorter edge that lies beside the other one. */
static double overlap(const struct walk *walk, idx_t h, idx_t g)
{
	double e[3], d[3];
	edge_vector(e, walk, h);
	const double length = normalise3(e);
	const double *from = walk->xyz + 3 * walk->half->origin[h];
	sub3(d, walk->xyz + 3 * walk->half->origin[g], from);
	const double a = dot3(d, e);
	sub3(d, walk->xyz + 3 * walk->half->origin[walk->half->next[g]], from);
	const double b = dot3(d, e);
	const double low = fmax(0, fmin(a, b)), high = fmin(length, fmax(a, b));
	const double shorter = fmin(length, fabs(b - a));
	return shorter > 0 ? (high - low) / shorter : 0;
}

/* The parallel bend of the same size on the other side of the facet at h, seen from that side's neighbour; NO_INDEX
 * when there is none. */
static idx_t next_bend(struct walk *walk, idx_t h)
{
	const struct half *half = walk->half;
	idx_t queue[FACET_LIMIT], best = NO_INDEX;
	size_t tail = 0;
	double e[3], best_overlap = 0.1;
	edge_vector(e, walk, h);
	walk->now++;
	queue[tail++] = half->face[h];
	walk->stamp[half->face[h]] = walk->now;
	for (size_t i = 0; i < tail; i++) {
		for (int k = 0; k < 3; k++) {
			const idx_t g = 3 * queue[i] + k, twin = half->twin[g];
			if (g == h || twin == NO_INDEX)
				continue;
			if (fabs(walk->bend[g]) <= FLAT_RAD) {
				const idx_t other = half->face[twin];
				if (walk->stamp[other] != walk->now && tail < FACET_LIMIT) {
					walk->stamp[other] = walk->now;
					queue[tail++] = other;
				}
				continue;
			}
			const double larger = fmax(fabs(walk->bend[g]), fabs(walk->bend[h]));
			if (fabs(walk->bend[g] - walk->bend[h]) > BEND_TOLERANCE * larger)
				continue;
			double f[3];
			edge_vector(f, walk, g);
			const double angle = angle3(e, f);
			if (fmin(angle, PI - angle) > PARALLEL_RAD)
				continue;
			const double share = overlap(walk, h, g);
			if (share > best_overlap)
				best_overlap = share, best = g;
		}
	}
	return best == NO_INDEX ? NO_INDEX : half->twin[best];
}

/* Bends that follow h on its face's side, at most CHAIN_LEAST - 1, each with the spacing that leads to it. */
static int follow(struct walk *walk, idx_t h, double spacing[CHAIN_LEAST - 1])
{
	const idx_t first = h;
	int count = 0;
	while (count < CHAIN_LEAST - 1) {
		const idx_t g = next_bend(walk, h);
		if (g == NO_INDEX || g == first || fabs(walk->bend[g] - walk->bend[first]) > BEND_TOLERANCE * fabs(walk->bend[first]))
			break;
		spacing[count++] = line_spacing(walk, h, g);
		h = g;
	}
	return count;
}

static int count_alike(const double *spacing, int count, double wanted)
{
	int alike = 0;
	while (alike < count && fabs(spacing[alike] - wanted) <= SPACING_TOLERANCE * fmax(spacing[alike], wanted))
		alike++;
	return alike;
}

static bool is_regular_bend(struct walk *walk, idx_t h)
{
	const double size = fabs(walk->bend[h]);
	if (size > REGULAR_HIGH_RAD)
		return false;
	double left[CHAIN_LEAST - 1], right[CHAIN_LEAST - 1];
	const int left_count = follow(walk, h, left), right_count = follow(walk, walk->half->twin[h], right);
	for (int side = 0; side < 2; side++) {
		if ((side ? right_count : left_count) == 0)
			continue;
		const double wanted = side ? right[0] : left[0];
		if (1 + count_alike(left, left_count, wanted) + count_alike(right, right_count, wanted) >= CHAIN_LEAST)
			return true;
	}
	return false;
}

/* Root of h in a forest of half-edges, with path halving. */
static idx_t root_of(idx_t *parent, idx_t h)
{
	while (parent[h] != h)
		h = parent[h] = parent[parent[h]];
	return h;
}

static idx_t first_side(const struct half *half, idx_t h)
{
	return half->twin[h] != NO_INDEX && half->twin[h] < h ? half->twin[h] : h;
}

/* Join edges over the angle that go on into each other at a vertex: the two that turn least, the same way bent. */
static void join_at_vertex(idx_t *parent, const struct walk *walk, idx_t start, double angle_rad)
{
	const struct half *half = walk->half;
	idx_t spoke[SPOKE_LIMIT];
	int count = 0;
	idx_t h = start;
	do {
		if (fabs(walk->bend[h]) > angle_rad) {
			if (count == SPOKE_LIMIT)
				return;
			spoke[count++] = h;
		}
		h = half->twin[half->previous[h]];
	} while (h != NO_INDEX && h != start);
	for (;;) {
		double best = JOIN_RAD;
		int first = -1, second = -1;
		for (int i = 0; i < count; i++)
			for (int k = i + 1; k < count; k++) {
				double e[3], f[3];
				if (walk->bend[spoke[i]] * walk->bend[spoke[k]] < 0)
					continue;
				edge_vector(e, walk, spoke[i]);
				edge_vector(f, walk, spoke[k]);
				const double turn = PI - angle3(e, f);
				if (turn < best)
					best = turn, first = i, second = k;
			}
		if (first < 0)
			return;
		const idx_t a = root_of(parent, first_side(half, spoke[first])), b = root_of(parent, first_side(half, spoke[second]));
		parent[a > b ? a : b] = a < b ? a : b;
		spoke[second] = spoke[--count];
		spoke[first] = spoke[--count];
	}
}

/* A chain is regular as a whole or not at all: the longer part decides. Else a bead of half an octagon would be round
 * where its triangles happen to lie well, and sharp elsewhere. */
static void vote_along_chains(unsigned char *regular, const struct walk *walk, double angle_rad)
{
	const struct half *half = walk->half;
	idx_t *parent = mem_array(half->half_count, sizeof *parent);
	double *balance = mem_array(half->half_count, sizeof *balance);
	for (size_t h = 0; h < half->half_count; h++)
		parent[h] = (idx_t)h;
	for (size_t v = 0; v < half->vertex_count; v++) {
		idx_t start = half->outgoing[v];
		if (start == NO_INDEX)
			continue;
		/* from the right end of an open fan */
		for (idx_t h = half->twin[start]; h != NO_INDEX && half->next[h] != half->outgoing[v]; h = half->twin[start])
			start = half->next[h];
		join_at_vertex(parent, walk, start, angle_rad);
	}
	for (size_t h = 0; h < half->half_count; h++) {
		if (half->twin[h] == NO_INDEX || half->twin[h] < (idx_t)h || fabs(walk->bend[h]) <= angle_rad)
			continue;
		double e[3];
		edge_vector(e, walk, (idx_t)h);
		balance[root_of(parent, (idx_t)h)] += regular[h] ? norm3(e) : -norm3(e);
	}
	for (size_t h = 0; h < half->half_count; h++)
		if (half->twin[h] != NO_INDEX && fabs(walk->bend[h]) > angle_rad)
			regular[h] = balance[root_of(parent, first_side(half, (idx_t)h))] > 0;
	free(parent);
	free(balance);
}

static void mark(unsigned char *kind, const struct half *half, idx_t h, unsigned char what)
{
	kind[h] = what;
	if (half->twin[h] != NO_INDEX)
		kind[half->twin[h]] = what;
}

/* The half-edge that goes on from h, past its end: the straightest one that bends enough and the same way, and stands
 * alone. One with its like beside it is a facet of a round that the sharp edge runs out into. */
static idx_t extension(struct walk *walk, const unsigned char *kind, const unsigned char *regular, idx_t h, double least_rad)
{
	const struct half *half = walk->half;
	const idx_t first = half->next[h];
	double e[3], best_turn = TURN_LIMIT_RAD;
	idx_t best = NO_INDEX;
	edge_vector(e, walk, h);
	for (idx_t g = first; g != NO_INDEX;) {
		if (!kind[g] && !regular[g] && fabs(walk->bend[g]) > least_rad && walk->bend[g] * walk->bend[h] > 0) {
			double f[3];
			edge_vector(f, walk, g);
			const double turn = angle3(e, f);
			if (turn < best_turn && next_bend(walk, g) == NO_INDEX && next_bend(walk, half->twin[g]) == NO_INDEX)
				best_turn = turn, best = g;
		}
		g = half->twin[half->previous[g]];
		if (g == first)
			break;
	}
	return best;
}

/* True when the chain that ends with h is no chance: it is EXTENDED_LEAST edges long, or leads to a junction, a border or round
 * in a circle. */
static bool is_chain(const unsigned char *kind, const idx_t *degree, const struct half *half, idx_t h)
{
	for (int count = 1; count < EXTENDED_LEAST; count++) {
		const idx_t v = half->origin[h];
		if (degree[v] != 2)
			return degree[v] > 2;
		/* the other feature at v; interior, because a border would raise the degree */
		idx_t g = h, back = NO_INDEX;
		do {
			if (g != h && kind[g])
				back = g;
			g = half->twin[half->previous[g]];
		} while (g != NO_INDEX && g != h);
		if (g == NO_INDEX || back == NO_INDEX)
			return true;
		h = half->twin[back];
	}
	return true;
}

void sharp_edges(unsigned char *kind, struct sharp_counts *counts, const double *xyz, const double *bend, const struct half *half,
                 const struct sharp_options *options)
{
	struct sharp_counts c = {0};
	struct walk walk = {xyz, bend, half, mem_array(half->face_count, sizeof *walk.stamp), 0};
	unsigned char *regular = mem_array(half->half_count, 1);
	idx_t *degree = mem_array(half->vertex_count, sizeof *degree);
	const double least_rad = options->angle_rad / 2;

	if (!options->is_strict) {
		for (size_t h = 0; h < half->half_count; h++) {
			const idx_t twin = half->twin[h];
			if (twin != NO_INDEX && (idx_t)h < twin && fabs(bend[h]) > least_rad)
				regular[h] = regular[twin] = is_regular_bend(&walk, (idx_t)h);
		}
		vote_along_chains(regular, &walk, options->angle_rad);
	}
	for (size_t i = 0; i < half->half_count; i++) {
		const idx_t h = (idx_t)i, twin = half->twin[h];
		if (twin == NO_INDEX) {
			if (kind[h] != EDGE_CUT)
				kind[h] = EDGE_BORDER;
		} else if (h < twin) {
			const bool is_over = fabs(bend[h]) > options->angle_rad;
			c.over_angle += is_over;
			c.regular += is_over && regular[h];
			mark(kind, half, h, is_over && !regular[h] ? EDGE_SHARP : 0);
		}
		if (kind[h] && (twin == NO_INDEX || twin < h)) {
			degree[half->origin[h]]++;
			degree[half->origin[half->next[h]]]++;
		}
	}
	for (size_t i = 0; i < half->half_count; i++) {
		const idx_t h = (idx_t)i;
		if (h < half->twin[h] && kind[h] == EDGE_SHARP && degree[half->origin[h]] == 1 && degree[half->origin[half->next[h]]] == 1) {
			mark(kind, half, h, 0);
			degree[half->origin[h]] = degree[half->origin[half->next[h]]] = 0;
			c.lonely++;
		}
	}
	for (size_t i = 0; i < half->half_count; i++) {
		idx_t h = (idx_t)i;
		/* every step marks one more edge: the loop ends */
		while (kind[h] == EDGE_SHARP && degree[half->origin[half->next[h]]] == 1 && is_chain(kind, degree, half, h)) {
			const idx_t g = extension(&walk, kind, regular, h, least_rad);
			if (g == NO_INDEX)
				break;
			mark(kind, half, g, EDGE_SHARP);
			degree[half->origin[g]]++;
			degree[half->origin[half->next[g]]]++;
			c.extended++;
			h = g;
		}
	}
	for (size_t i = 0; i < half->half_count; i++)
		c.sharp += kind[i] == EDGE_SHARP && (idx_t)i < half->twin[i];
	if (counts)
		*counts = c;
	free(walk.stamp);
	free(regular);
	free(degree);
}
