/* Smooth patch borders by a label energy: see labelsmooth.h. */
#include "stages/rectify/labelsmooth.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/vector.h"
#include "stages/rectify/mincut.h"

#define SHARP_RAD (40 / DEGREES)    /* bends from here on cost a border the least */
#define OMEGA_LOW 0.1
#define LAMBDA 0.6                  /* of the typical width: half the edge of an equilateral triangle of that height */
#define NORMAL_RAD (6 / DEGREES)    /* deviations that count as 1 */
#define DISTANCE 0.0005
#define CURVATURE 0.5
#define SPREADS 2                   /* times the median deviation of a patch's triangles that count as 1, if that is more */
#define COST_MOST 16
#define GAIN_LEAST 1e-9             /* of the energy: less is rounding, and would make a second run move again */
#define PHASE_LIMIT 500
#define REACH_ROUNDS 12

double label_surface_cost(const void *context, idx_t triangle, idx_t label)
{
	const struct partition *p = context;
	const struct dense_patch *patch = &p->patch[label];
	if (patch->kind == PATCH_FREE) {
		const double a = p->curvature[2 * triangle] - p->mean_curvature[2 * label];
		const double b = p->curvature[2 * triangle + 1] - p->mean_curvature[2 * label + 1];
		/* the mean of a patch whose curvature varies says little about one triangle */
		const double spread = CURVATURE * CURVATURE + p->curvature_variance[label];
		return fmin((a * a + b * b) / spread, COST_MOST) * CURVATURE * CURVATURE / spread;
	}
	double angle, distance;
	partition_deviation(&angle, &distance, p, triangle, label);
	/* farther off than all that was in the patch */
	const double excess = distance > fmax(DISTANCE, patch->residual) ? COST_MOST : 0;
	/* a patch that fits its surface loosely cannot ask for more of a triangle */
	angle /= fmax(NORMAL_RAD, SPREADS * p->normal_spread[label]);
	distance /= fmax(DISTANCE, SPREADS * p->distance_spread[label]);
	return fmin(angle * angle + distance * distance, COST_MOST) + excess;
}

/* A border half-edge between two patches, a < b. */
struct border {
	idx_t a, b, half;
};

static int compare_borders(const void *left, const void *right)
{
	const struct border *p = left, *q = right;
	if (p->a != q->a)
		return p->a < q->a ? -1 : 1;
	if (p->b != q->b)
		return p->b < q->b ? -1 : 1;
	return (p->half > q->half) - (p->half < q->half);
}

struct smoother {
	struct partition *p;
	const struct labelsmooth_options *options;
	struct labelsmooth_counts *counts;
	double *area_at_start;  /* a patch */
	idx_t *local;           /* a triangle: node in the band, NO_INDEX outside */
	idx_t *band;            /* triangles of the band */
	double *side_cost;      /* 2 a node */
	unsigned char *side;
	struct mincut_edge *edge;
};

void labelsmooth_fix(unsigned char *fixed, const struct partition *p, double reach)
{
	const struct half *half = &p->half;
	double *distance = mem_array(half->face_count, sizeof *distance);
	idx_t *queue = mem_array(half->face_count, sizeof *queue), *next = mem_array(half->face_count, sizeof *next);
	unsigned char *is_queued = mem_array(half->face_count, 1);
	size_t count = 0;
	for (size_t t = 0; t < half->face_count; t++)
		distance[t] = INFINITY;
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t twin = half->twin[h], t = half->face[h];
		if (twin == NO_INDEX || p->kind[h] || p->group[p->label[t]] == p->group[p->label[half->face[twin]]])
			continue;
		/* from the border's middle */
		double middle[3];
		for (int i = 0; i < 3; i++)
			middle[i] = 0.5 * (p->xyz[3 * half->origin[h] + i] + p->xyz[3 * half->origin[twin] + i]);
		distance[t] = fmin(distance[t], distance3(middle, p->centroid + 3 * t));
		if (distance[t] <= reach && !is_queued[t]) {
			is_queued[t] = 1;
			queue[count++] = t;
		}
	}
	/* a few rounds of relaxation: a longer way through more triangles than that is not looked for */
	for (int round = 0; round < REACH_ROUNDS && count > 0; round++) {
		size_t next_count = 0;
		for (size_t i = 0; i < count; i++)
			is_queued[queue[i]] = 0;
		for (size_t i = 0; i < count; i++)
			for (idx_t h = 3 * queue[i]; h < 3 * queue[i] + 3; h++) {
				if (half->twin[h] == NO_INDEX || p->kind[h])
					continue;
				const idx_t t = half->face[half->twin[h]];
				const double d = distance[queue[i]] + distance3(p->centroid + 3 * queue[i], p->centroid + 3 * t);
				if (d > reach || d >= distance[t])
					continue;
				distance[t] = d;
				if (!is_queued[t]) {
					is_queued[t] = 1;
					next[next_count++] = t;
				}
			}
		idx_t *swap = queue;
		queue = next, next = swap;
		count = next_count;
	}
	for (size_t t = 0; t < half->face_count; t++)
		fixed[t] = distance[t] > reach;
	free(distance);
	free(queue);
	free(next);
	free(is_queued);
}

/* What a border along h costs. Its width counts as that of the narrower triangle beside it, at most a typical one:
 * otherwise the thin end of a patch would cost more border than it has area to speak for it, and be eaten up. Between
 * free patches there is hardly anything else to speak, and only the length may count. */
static double border_weight(const struct smoother *s, idx_t h, idx_t label, bool is_free)
{
	const struct partition *p = s->p;
	if (p->kind[h] || !(p->length[h] > 0))
		return 0;
	const double scale = s->options->scale ? s->options->scale[label] : p->scale;
	const double thinner = fmin(p->area[p->half.face[h]], p->area[p->half.face[p->half.twin[h]]]);
	const double width = is_free ? scale : fmin(scale, 2 * thinner / p->length[h]);
	return LAMBDA * width * p->length[h] * fmax(OMEGA_LOW, 1 - fabs(p->bend[h]) / SHARP_RAD);
}

/* Triangles of the two patches within the rings of their common border, over smooth edges. */
static size_t collect_band(struct smoother *s, const struct border *border, size_t border_count)
{
	const struct partition *p = s->p;
	const struct half *half = &p->half;
	const idx_t a = border[0].a, b = border[0].b;
	const bool is_free = p->patch[a].kind == PATCH_FREE && p->patch[b].kind == PATCH_FREE;
	const unsigned char *fixed = is_free ? s->options->fixed : NULL;
	size_t count = 0;
	for (size_t i = 0; i < border_count; i++) {
		const idx_t both[2] = {half->face[border[i].half], half->face[half->twin[border[i].half]]};
		const idx_t l = p->label[both[0]], r = p->label[both[1]];
		/* an earlier pair of this round may have moved it */
		if (!((l == a && r == b) || (l == b && r == a)))
			continue;
		for (int k = 0; k < 2; k++)
			if (s->local[both[k]] == NO_INDEX && !(fixed && fixed[both[k]])) {
				s->local[both[k]] = (idx_t)count;
				s->band[count++] = both[k];
			}
	}
	size_t ring_start = 0;
	for (int ring = 1; ring < s->options->rings; ring++) {
		const size_t ring_end = count;
		for (size_t i = ring_start; i < ring_end; i++) {
			for (idx_t h = 3 * s->band[i]; h < 3 * s->band[i] + 3; h++) {
				if (half->twin[h] == NO_INDEX || p->kind[h])
					continue;
				const idx_t t = half->face[half->twin[h]];
				if (s->local[t] == NO_INDEX && !(fixed && fixed[t]) && (p->label[t] == a || p->label[t] == b)) {
					s->local[t] = (idx_t)count;
					s->band[count++] = t;
				}
			}
		}
		ring_start = ring_end;
	}
	return count;
}

/* Move the border of one pair to the least energy within its band. */
static size_t smooth_pair(struct smoother *s, const struct border *border, size_t border_count)
{
	struct partition *p = s->p;
	const struct half *half = &p->half;
	const idx_t pair[2] = {border[0].a, border[0].b};
	const bool is_free = p->patch[pair[0]].kind == PATCH_FREE && p->patch[pair[1]].kind == PATCH_FREE;
	const size_t count = collect_band(s, border, border_count);
	size_t edge_count = 0, changed = 0;
	for (size_t i = 0; i < count; i++) {
		const idx_t t = s->band[i];
		for (int k = 0; k < 2; k++)
			s->side_cost[2 * i + k] = p->area[t] * s->options->cost(s->options->context, t, pair[k]);
		for (idx_t h = 3 * t; h < 3 * t + 3; h++) {
			if (half->twin[h] == NO_INDEX)
				continue;
			const idx_t other = half->face[half->twin[h]];
			const double weight = border_weight(s, h, pair[0], is_free);
			if (s->local[other] != NO_INDEX) {
				if (h < half->twin[h] && weight > 0)
					s->edge[edge_count++] = (struct mincut_edge){(idx_t)i, s->local[other], weight};
			} else {
				for (int k = 0; k < 2; k++)
					s->side_cost[2 * i + k] += p->label[other] != pair[k] ? weight : 0;
			}
		}
	}
	if (count > 0 && !mincut_solve(s->side, count, s->side_cost, s->edge, edge_count, PHASE_LIMIT))
		s->counts->unfinished++;
	double before = 0, after = 0, moved[2] = {0, 0}; /* moved[k]: area that leaves pair[k] */
	for (size_t i = 0; i < count; i++) {
		const int old = p->label[s->band[i]] == pair[1];
		before += s->side_cost[2 * i + old];
		after += s->side_cost[2 * i + s->side[i]];
		if (s->side[i] != old)
			moved[old] += p->area[s->band[i]];
	}
	for (size_t e = 0; e < edge_count; e++) {
		const idx_t i = s->edge[e].a, k = s->edge[e].b;
		before += p->label[s->band[i]] != p->label[s->band[k]] ? s->edge[e].weight : 0;
		after += s->side[i] != s->side[k] ? s->edge[e].weight : 0;
	}
	bool is_good = after < before * (1 - GAIN_LEAST);
	for (int k = 0; k < 2; k++) {
		const double area = p->patch_area[pair[k]] - moved[k] + moved[!k];
		is_good = is_good && area >= (1 - s->options->loss_most) * p->patch_area[pair[k]];
		is_good = is_good && area >= (1 - 2 * s->options->loss_most) * s->area_at_start[pair[k]];
	}
	for (size_t i = 0; i < count; i++) {
		const idx_t t = s->band[i], wanted = pair[s->side[i]];
		s->local[t] = NO_INDEX;
		if (is_good && p->label[t] != wanted) {
			p->patch_area[p->label[t]] -= p->area[t];
			p->patch_area[wanted] += p->area[t];
			p->label[t] = wanted;
			changed++;
		}
	}
	return changed;
}

static size_t list_borders(struct border *border, const struct partition *p, const idx_t *family)
{
	const struct half *half = &p->half;
	size_t count = 0;
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t twin = half->twin[h];
		if (twin == NO_INDEX || twin < (idx_t)h || p->kind[h])
			continue;
		const idx_t l = p->label[half->face[h]], r = p->label[half->face[twin]];
		if (l == r || (family ? family[l] != family[r] || family[l] < 0 : p->group[l] == p->group[r]))
			continue;
		border[count++] = (struct border){l < r ? l : r, l < r ? r : l, (idx_t)h};
	}
	qsort(border, count, sizeof *border, compare_borders);
	return count;
}

void labelsmooth(struct partition *p, const struct labelsmooth_options *options, struct labelsmooth_counts *counts)
{
	const size_t n = p->half.face_count;
	struct smoother s = {.p = p, .options = options, .counts = counts};
	s.local = mem_array(n, sizeof *s.local);
	s.band = mem_array(n, sizeof *s.band);
	s.side_cost = mem_array(2 * n, sizeof *s.side_cost);
	s.side = mem_array(n, 1);
	s.edge = mem_array(3 * n, sizeof *s.edge);
	struct border *border = mem_array(3 * n, sizeof *border);
	partition_refresh(p);
	s.area_at_start = mem_copy(p->patch_area, p->patch_count, sizeof *p->patch_area);
	for (size_t t = 0; t < n; t++)
		s.local[t] = NO_INDEX;
	size_t changed = 1;
	for (int round = 0; round < options->rounds && changed > 0; round++) {
		const size_t count = list_borders(border, p, options->family);
		changed = 0;
		for (size_t i = 0, end; i < count; i = end) {
			for (end = i; end < count && border[end].a == border[i].a && border[end].b == border[i].b;)
				end++;
			changed += smooth_pair(&s, border + i, end - i);
		}
		counts->relabelled += changed;
		counts->rounds++;
		partition_refresh(p);
	}
	free(s.area_at_start);
	free(s.local);
	free(s.band);
	free(s.side_cost);
	free(s.side);
	free(s.edge);
	free(border);
}
