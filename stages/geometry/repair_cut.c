/* Step 5: over which edges the surface goes on, and a copy of a vertex for each fan of triangles. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"
#include "stages/geometry/vector.h"

/* Angles closer than this are equal, and orientation decides. */
#define ANGLE_STEP 1e-6

/* A half-edge by the angle of its triangle around the edge. */
struct leaf {
	double angle;
	idx_t half;
	bool is_forward; /* runs from the low to the high end; its outside lies towards rising angles */
};

static int compare_leaves(const void *left, const void *right)
{
	const struct leaf *a = left, *b = right;
	if (a->angle != b->angle)
		return a->angle < b->angle ? -1 : 1;
	return (a->half > b->half) - (a->half < b->half);
}

/* Two neighbouring leaves that could go on into each other, better ones first. In a mesh that is oriented, two that run the
 * same way come last, and so do two in one place with their insides away from each other: bodies that touch. */
struct match {
	long long gap; /* in ANGLE_STEPs */
	bool is_unlikely;
	bool is_outside;      /* the gap is outside of the material */
	size_t first, second; /* leaves */
};

static int compare_matches(const void *left, const void *right)
{
	const struct match *a = left, *b = right;
	if (a->is_unlikely != b->is_unlikely)
		return a->is_unlikely ? 1 : -1;
	if (a->gap != b->gap)
		return a->gap < b->gap ? -1 : 1;
	if (a->is_outside != b->is_outside)
		return a->is_outside ? 1 : -1;
	return (a->first > b->first) - (a->first < b->first);
}

static void sort_leaves(struct leaf *leaf, const struct soup *soup, const struct side *side, size_t count)
{
	const double *low = soup->xyz + 3 * (size_t)side->low, *high = soup->xyz + 3 * (size_t)side->high;
	double along[3], across[3] = {0}, third[3];
	sub3(along, high, low);
	normalise3(along);
	for (size_t i = 0; i < count; i++) {
		const size_t h = (size_t)side[i].half;
		double arm[3];
		sub3(arm, soup->xyz + 3 * (size_t)soup->triangle[previous_half(h)], low);
		add_scaled3(arm, -dot3(arm, along), along);
		if (norm3(across) == 0) {
			copy3(across, arm);
			normalise3(across);
		}
		cross3(third, along, across);
		const double angle = atan2(dot3(arm, third), dot3(arm, across));
		leaf[i] = (struct leaf){angle < -ANGLE_STEP ? angle + 2 * PI : angle, (idx_t)h, soup->triangle[h] == side->low};
	}
	qsort(leaf, count, sizeof *leaf, compare_leaves);
	/* Two in one place have no order by angle. As a contact of bodies the forward one comes first; as a fin, behind a
	 * leaf with its outside towards them, the other one does. */
	for (size_t i = 0; i + 1 < count; i++) {
		if (leaf[i + 1].angle - leaf[i].angle >= ANGLE_STEP || leaf[i].is_forward == leaf[i + 1].is_forward)
			continue;
		const struct leaf *const last = &leaf[(i + count - 1) % count], *const before = &leaf[(i + count - 2) % count];
		const bool last_is_single = count > 2 && fabs(last->angle - before->angle) >= ANGLE_STEP;
		const bool is_fin = last_is_single && last->is_forward;
		if (leaf[i].is_forward == is_fin) {
			const struct leaf swap = leaf[i];
			leaf[i] = leaf[i + 1];
			leaf[i + 1] = swap;
		}
		i++;
	}
}

/* Pair neighbours around the edge by smallest gap, drop them, and so on: each round pairs at least a third of what is
 * left. An odd one stays open. */
static void pair_leaves(struct soup *soup, struct leaf *leaf, struct match *match, size_t count, bool is_oriented)
{
	while (count > 1) {
		size_t matches = 0;
		for (size_t i = 0; i < count && !(count == 2 && i == 1); i++) {
			const size_t j = (i + 1) % count;
			double gap = leaf[j].angle - leaf[i].angle;
			if (gap < 0 || j == 0)
				gap += 2 * PI;
			struct match m = {.first = i, .second = j};
			m.is_outside = leaf[i].is_forward;
			m.gap = llround(gap / ANGLE_STEP);
			m.is_unlikely = is_oriented && (leaf[i].is_forward == leaf[j].is_forward || (m.gap == 0 && m.is_outside));
			match[matches++] = m;
		}
		qsort(match, matches, sizeof *match, compare_matches);
		for (size_t m = 0; m < matches; m++) {
			struct leaf *const a = &leaf[match[m].first], *const b = &leaf[match[m].second];
			if (a->half == NO_INDEX || b->half == NO_INDEX)
				continue;
			soup->pair[a->half] = b->half;
			soup->pair[b->half] = a->half;
			a->half = b->half = NO_INDEX;
		}
		size_t left = 0;
		for (size_t i = 0; i < count; i++)
			if (leaf[i].half != NO_INDEX)
				leaf[left++] = leaf[i];
		count = left;
	}
	if (count == 1)
		soup->opened[leaf[0].half] = 1;
}

void soup_pair(struct soup *soup)
{
	const size_t count = 3 * soup->triangle_count;
	soup->pair = mem_array(3 * soup->triangle_room, sizeof *soup->pair);
	soup->opened = mem_array(3 * soup->triangle_room, 1);
	memset(soup->pair, 0xff, count * sizeof *soup->pair);
	struct side *side = soup_sides(soup);
	const bool oriented = soup_is_oriented(soup, side);
	size_t longest = 0;
	for (size_t i = 0, end; i < count; i = end) {
		end = side_run(side, count, i);
		longest = end - i > longest ? end - i : longest;
	}
	struct leaf *leaf = mem_array(longest, sizeof *leaf);
	struct match *match = mem_array(longest, sizeof *match);
	for (size_t i = 0, end; i < count; i = end) {
		end = side_run(side, count, i);
		if (end - i == 2) {
			soup->pair[side[i].half] = side[i + 1].half;
			soup->pair[side[i + 1].half] = side[i].half;
		} else if (end - i > 2) {
			sort_leaves(leaf, soup, side + i, end - i);
			pair_leaves(soup, leaf, match, end - i, oriented);
			soup->report->count[REPAIR_NONMANIFOLD_EDGE_CUT]++;
		}
	}
	free(leaf);
	free(match);
	free(side);
}

/* Put a new vertex m on the edge of half-edge h: its triangle keeps the first part, a new triangle gets the second.
 * Returns the half-edge of the second part, m to the old end. Neither part has a pair yet. */
static size_t split_half(struct soup *soup, size_t h, idx_t m)
{
	const idx_t end = soup->triangle[next_half(h)], apex = soup->triangle[previous_half(h)];
	const size_t t = soup_add_triangle(soup, m, end, apex);
	const size_t onward = next_half(h), second = 3 * t, inherits = 3 * t + 1, inner = 3 * t + 2;
	soup->triangle[onward] = m;
	soup->pair[inherits] = soup->pair[onward];
	if (soup->pair[onward] != NO_INDEX)
		soup->pair[soup->pair[onward]] = (idx_t)inherits;
	soup->opened[inherits] = soup->opened[onward];
	soup->opened[onward] = 0;
	soup->pair[onward] = (idx_t)inner;
	soup->pair[inner] = (idx_t)onward;
	soup->pair[h] = NO_INDEX;
	soup->opened[second] = soup->opened[h];
	return second;
}

/* Sheets that were taken apart at an edge may still share both of its ends, where the surface comes round to the other
 * sheet: one edge by its indices, though two by its pairs. A vertex of its own in the middle tells them apart. */
static bool separate_doubles(struct soup *soup)
{
	const size_t old_triangles = soup->triangle_count, count = 3 * old_triangles;
	struct side *side = soup_sides(soup);
	unsigned char *touched = mem_array(old_triangles, 1); /* whose half-edges are no longer those of side: next time */
	bool found = false;
	for (size_t i = 0, end; i < count; i = end) {
		end = side_run(side, count, i);
		const bool good = end - i == 1 || (end - i == 2 && soup->pair[side[i].half] == side[i + 1].half);
		if (good)
			continue;
		found = true;
		for (size_t k = i + 1; k < end; k++) { /* the first sheet keeps the edge */
			const size_t g = (size_t)side[k].half;
			const idx_t partner = soup->pair[g];
			if (g == (size_t)side[i].half || partner == side[i].half || touched[g / 3] ||
			    (partner != NO_INDEX && ((size_t)partner >= count || touched[partner / 3])))
				continue;
			double middle[3];
			for (size_t c = 0; c < 3; c++)
				middle[c] =
					(soup->xyz[3 * (size_t)side[k].low + c] + soup->xyz[3 * (size_t)side[k].high + c]) / 2;
			const idx_t m = soup_add_vertex(soup, middle), start = soup->triangle[g];
			touched[g / 3] = 1;
			const size_t g2 = split_half(soup, g, m);
			if (partner == NO_INDEX)
				continue;
			touched[partner / 3] = 1;
			const bool same_way = soup->triangle[partner] == start;
			const size_t h = (size_t)partner, h2 = split_half(soup, h, m);
			const size_t first = same_way ? h : h2, second = same_way ? h2 : h;
			soup->pair[g] = (idx_t)first, soup->pair[first] = (idx_t)g;
			soup->pair[g2] = (idx_t)second, soup->pair[second] = (idx_t)g2;
		}
	}
	free(touched);
	free(side);
	return found;
}

void soup_split_fans(struct soup *soup)
{
	const size_t count = 3 * soup->triangle_count, old_vertices = soup->vertex_count;
	idx_t *fan = new_roots(count); /* corners that belong together */
	unsigned char *at_cut = mem_array(old_vertices, 1);
	for (size_t h = 0; h < count; h++) {
		if (soup->opened[h])
			at_cut[soup->triangle[h]] = at_cut[soup->triangle[next_half(h)]] = 1;
		if (soup->pair[h] == NO_INDEX || (size_t)soup->pair[h] < h)
			continue;
		const size_t g = (size_t)soup->pair[h];
		const bool same_way = soup->triangle[g] == soup->triangle[h];
		unite_roots(fan, (idx_t)h, (idx_t)(same_way ? g : next_half(g)));
		unite_roots(fan, (idx_t)next_half(h), (idx_t)(same_way ? next_half(g) : g));
	}
	/* Edges of more than two triangles, all of them paired, count as cuts as well. */
	struct side *side = soup_sides(soup);
	for (size_t i = 0, end; i < count; i = end) {
		end = side_run(side, count, i);
		if (end - i > 2)
			at_cut[side[i].low] = at_cut[side[i].high] = 1;
	}
	free(side);
	idx_t *first = mem_array(old_vertices, sizeof *first), *copy = mem_array(count, sizeof *copy);
	memset(first, 0xff, old_vertices * sizeof *first);
	for (size_t h = 0; h < count; h++) {
		const idx_t root = find_root(fan, (idx_t)h), v = soup->triangle[root < (idx_t)h ? (size_t)root : h];
		if (root == (idx_t)h) { /* the first corner of its fan, which comes before all others */
			if (first[v] == NO_INDEX) {
				first[v] = root;
				copy[h] = v;
			} else {
				copy[h] =
					soup_add_vertex(soup, (double[3]){soup->xyz[3 * (size_t)v], soup->xyz[3 * (size_t)v + 1],
									  soup->xyz[3 * (size_t)v + 2]});
				soup->report->count[REPAIR_NONMANIFOLD_VERTEX_SPLIT] += !at_cut[v];
			}
		}
	}
	for (size_t h = 0; h < count; h++)
		soup->triangle[h] = copy[find_root(fan, (idx_t)h)];
	free(fan), free(at_cut), free(first), free(copy);
	for (int pass = 0; pass < 100 && separate_doubles(soup); pass++)
		;
}
