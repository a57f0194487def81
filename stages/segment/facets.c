/* The triangles of a dense mesh as a graph. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/facets.h"

/* An undirected edge and who runs along it. */
struct edge_key {
	idx_t low, high, half; /* half < 0: ~index into dense->edge */
};

static int compare_keys(const void *left, const void *right)
{
	const struct edge_key *a = left, *b = right;
	if (a->low != b->low)
		return a->low < b->low ? -1 : 1;
	if (a->high != b->high)
		return a->high < b->high ? -1 : 1;
	return (a->half > b->half) - (a->half < b->half);
}

static struct edge_key key_of(idx_t a, idx_t b, idx_t half)
{
	return (struct edge_key){a < b ? a : b, a < b ? b : a, half};
}

static idx_t half_start(const struct facets *f, idx_t h)
{
	return f->triangle[h];
}

/* Pair half-edges and mark the sharp ones. */
static void connect(struct facets *f, const struct dense *dense)
{
	const size_t half_count = 3 * f->triangle_count, count = half_count + dense->edge_count;
	struct edge_key *key = mem_array(count, sizeof *key);
	for (size_t h = 0; h < half_count; h++)
		key[h] = key_of(f->triangle[h], f->triangle[h / 3 * 3 + (h + 1) % 3], (idx_t)h);
	for (size_t e = 0; e < dense->edge_count; e++)
		key[half_count + e] = key_of(dense->edge[e].vertex1, dense->edge[e].vertex2, ~(idx_t)e);
	qsort(key, count, sizeof *key, compare_keys);
	for (size_t i = 0, end; i < count; i = end) {
		for (end = i + 1; end < count && key[end].low == key[i].low && key[end].high == key[i].high;)
			end++;
		size_t first = i;
		while (first < end && key[first].half < 0)
			first++;
		const bool is_marked = first > i;
		const bool is_pair = end - first == 2 && half_start(f, key[first].half) != half_start(f, key[first + 1].half);
		for (size_t j = first; j < end; j++) {
			const idx_t h = key[j].half;
			f->twin[h] = is_pair ? key[first + first + 1 - j].half : NO_INDEX;
			f->neighbour[h] = is_pair ? f->twin[h] / 3 : NO_INDEX;
			f->is_sharp[h] = is_marked || !is_pair;
		}
	}
	free(key);
}

static void measure(struct facets *f)
{
	for (size_t t = 0; t < f->triangle_count; t++) {
		const double *p[3];
		double longest = 0;
		for (int k = 0; k < 3; k++)
			p[k] = f->xyz + 3 * f->triangle[3 * t + k];
		for (int k = 0; k < 3; k++) {
			f->length[3 * t + k] = distance3(p[k], p[(k + 1) % 3]);
			longest = fmax(longest, f->length[3 * t + k]);
			f->centroid[3 * t + k] = (p[0][k] + p[1][k] + p[2][k]) / 3;
		}
		area_vector3(f->normal + 3 * t, p[0], p[1], p[2]);
		f->area[t] = normalise3(f->normal + 3 * t) / 2;
		f->height[t] = longest > 0 ? 2 * f->area[t] / longest : 0;
		f->total_area += f->area[t];
	}
	for (size_t h = 0; h < 3 * f->triangle_count; h++) {
		if (f->neighbour[h] == NO_INDEX)
			continue;
		const double *n1 = f->normal + 3 * (h / 3), *n2 = f->normal + 3 * f->neighbour[h];
		double along[3], c[3];
		sub3(along, f->xyz + 3 * f->triangle[h / 3 * 3 + (h + 1) % 3], f->xyz + 3 * f->triangle[h]);
		normalise3(along);
		cross3(c, n1, n2);
		f->bend[h] = atan2(dot3(c, along), dot3(n1, n2));
	}
}

/* By angle, so that the diagonals of a grid do not turn the normal. */
static void average_normals(struct facets *f, size_t wedge_count)
{
	f->wedge_normal = mem_array(3 * wedge_count, sizeof *f->wedge_normal);
	for (size_t c = 0; c < 3 * f->triangle_count; c++) {
		const size_t t = c / 3;
		double u[3], v[3];
		sub3(u, f->xyz + 3 * f->triangle[3 * t + (c - 3 * t + 1) % 3], f->xyz + 3 * f->triangle[c]);
		sub3(v, f->xyz + 3 * f->triangle[3 * t + (c - 3 * t + 2) % 3], f->xyz + 3 * f->triangle[c]);
		add_scaled3(f->wedge_normal + 3 * f->wedge[c], angle3(u, v), f->normal + 3 * t);
	}
	for (size_t w = 0; w < wedge_count; w++)
		normalise3(f->wedge_normal + 3 * w);
}

static void find_smooth_parts(struct facets *f)
{
	idx_t *queue = mem_array(f->triangle_count, sizeof *queue);
	for (size_t t = 0; t < f->triangle_count; t++)
		f->smooth_part[t] = NO_INDEX;
	for (size_t t = 0; t < f->triangle_count; t++) {
		if (f->smooth_part[t] != NO_INDEX)
			continue;
		size_t head = 0, tail = 0;
		queue[tail++] = (idx_t)t;
		f->smooth_part[t] = (idx_t)f->smooth_part_count;
		while (head < tail) {
			const idx_t at = queue[head++];
			for (int k = 0; k < 3; k++) {
				const idx_t to = f->neighbour[3 * at + k];
				if (!f->is_sharp[3 * at + k] && f->smooth_part[to] == NO_INDEX) {
					f->smooth_part[to] = (idx_t)f->smooth_part_count;
					queue[tail++] = to;
				}
			}
		}
		f->smooth_part_count++;
	}
	free(queue);
}

void facets_build(struct facets *f, const struct dense *dense)
{
	const size_t n = dense->triangle_count;
	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
	*f = (struct facets){.vertex_count = dense->vertex_count, .triangle_count = n, .triangle = dense->triangle, .wedge = dense->triangle_wedge};
	for (size_t v = 0; v < dense->vertex_count; v++)
		for (int k = 0; k < 3; k++) {
			low[k] = fmin(low[k], dense->xyz[3 * v + k]);
			high[k] = fmax(high[k], dense->xyz[3 * v + k]);
		}
	for (int k = 0; k < 3; k++) {
		f->centre[k] = dense->vertex_count ? (low[k] + high[k]) / 2 : 0;
		f->side = dense->vertex_count ? fmax(f->side, high[k] - low[k]) : 0;
	}
	if (!(f->side > 0))
		f->side = 1;
	f->xyz = mem_array(3 * f->vertex_count, sizeof *f->xyz);
	for (size_t i = 0; i < 3 * f->vertex_count; i++)
		f->xyz[i] = (dense->xyz[i] - f->centre[i % 3]) / f->side;
	f->neighbour = mem_array(3 * n, sizeof *f->neighbour);
	f->twin = mem_array(3 * n, sizeof *f->twin);
	f->is_sharp = mem_array(3 * n, sizeof *f->is_sharp);
	f->bend = mem_array(3 * n, sizeof *f->bend);
	f->length = mem_array(3 * n, sizeof *f->length);
	f->normal = mem_array(3 * n, sizeof *f->normal);
	f->centroid = mem_array(3 * n, sizeof *f->centroid);
	f->area = mem_array(n, sizeof *f->area);
	f->height = mem_array(n, sizeof *f->height);
	f->smooth_part = mem_array(n, sizeof *f->smooth_part);
	connect(f, dense);
	measure(f);
	average_normals(f, dense->wedge_count);
	find_smooth_parts(f);
}

void facets_free(struct facets *f)
{
	free(f->xyz);
	free(f->neighbour);
	free(f->twin);
	free(f->is_sharp);
	free(f->bend);
	free(f->length);
	free(f->normal);
	free(f->centroid);
	free(f->wedge_normal);
	free(f->area);
	free(f->height);
	free(f->smooth_part);
	*f = (struct facets){0};
}

static void rescale(struct dense_patch *patch, double s)
{
	patch->radius *= s;
	if (patch->kind != PATCH_CONE)
		patch->radius2 *= s;
	patch->area *= s * s;
	patch->residual *= s;
}

void facets_to_model(const struct facets *f, struct dense_patch *patch)
{
	rescale(patch, f->side);
	for (int k = 0; k < 3 && patch->kind != PATCH_FREE; k++)
		patch->point[k] = f->centre[k] + f->side * patch->point[k];
}

void facets_from_model(const struct facets *f, struct dense_patch *patch)
{
	rescale(patch, 1 / f->side);
	for (int k = 0; k < 3 && patch->kind != PATCH_FREE; k++)
		patch->point[k] = (patch->point[k] - f->centre[k]) / f->side;
}
