/* Boundary edges of a labelled mesh: pairs of triangles by counting sort, labels on both sides, sharp or smooth. */
#include "stages/geometry/boundary.h"

#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"

/* One pass over all edges: a sorted list of half-edges and of the file's marked edges. */
struct edge_record {
	idx_t low, high;
	idx_t item; /* half-edge, or half_count + index of a marked edge */
};

/* Stable counting sort by low or high; LSD over (high, low) gives groups of one edge with ascending items. */
static void sort_records(struct edge_record *out, const struct edge_record *in, size_t count, size_t vertex_count, bool by_high)
{
	size_t *at = mem_array(vertex_count + 1, sizeof *at);
	for (size_t i = 0; i < count; i++)
		at[(by_high ? in[i].high : in[i].low) + 1]++;
	for (size_t v = 0; v < vertex_count; v++)
		at[v + 1] += at[v];
	for (size_t i = 0; i < count; i++)
		out[at[by_high ? in[i].high : in[i].low]++] = in[i];
	free(at);
}

static void face_normal(double normal[3], const struct dense *dense, size_t t)
{
	const idx_t *c = dense->triangle + 3 * t;
	area_vector3(normal, dense->xyz + 3 * (size_t)c[0], dense->xyz + 3 * (size_t)c[1], dense->xyz + 3 * (size_t)c[2]);
}

static double bend_deg(const struct dense *dense, size_t s, size_t t)
{
	double m[3], n[3];
	face_normal(m, dense, s);
	face_normal(n, dense, t);
	if (norm3(m) == 0 || norm3(n) == 0)
		return 0;
	return angle3(m, n) * DEGREES;
}

static idx_t parent_of(const struct dense *dense, idx_t label)
{
	return dense->patch && label >= 0 ? dense->patch[label].parent : label;
}

static bool same_surface(const struct dense *dense, idx_t left, idx_t right)
{
	return left == right || (left >= 0 && right >= 0 && parent_of(dense, left) == parent_of(dense, right));
}

/* twin[h]: the half-edge of the other triangle or NO_INDEX; mark[h]: the mesh edge is marked sharp. */
static bool pair_edges(idx_t *twin, bool *mark, const struct dense *dense, struct fault *fault)
{
	const size_t half_count = 3 * dense->triangle_count, count = half_count + dense->edge_count;
	struct edge_record *record = mem_array(count, sizeof *record), *other = mem_array(count, sizeof *other);
	for (size_t i = 0; i < count; i++) {
		idx_t a, b;
		if (i < half_count) {
			a = dense->triangle[i];
			b = dense->triangle[i - i % 3 + (i + 1) % 3];
			twin[i] = NO_INDEX;
		} else {
			a = dense->edge[i - half_count].vertex1;
			b = dense->edge[i - half_count].vertex2;
		}
		record[i] = (struct edge_record){a < b ? a : b, a < b ? b : a, (idx_t)i};
	}
	sort_records(other, record, count, dense->vertex_count, true);
	sort_records(record, other, count, dense->vertex_count, false);
	free(other);
	bool ok = true;
	for (size_t i = 0, j; i < count && ok; i = j) {
		size_t halves = 0;
		bool marked = false;
		for (j = i; j < count && record[j].low == record[i].low && record[j].high == record[i].high; j++) {
			const size_t item = (size_t)record[j].item;
			if (item < half_count)
				halves++; /* items ascend, so the half-edges come first */
			else if (dense->edge[item - half_count].kind == EDGE_SHARP)
				marked = true;
		}
		const idx_t h = record[i].item, g = halves > 1 ? record[i + 1].item : NO_INDEX;
		if (halves > 2)
			ok = fault_set(fault, EX_BAD_INPUT, "edge %" PRIidx " %" PRIidx " has %zu triangles", record[i].low,
				       record[i].high, halves);
		else if (halves == 2 && dense->triangle[h] == dense->triangle[g])
			ok = fault_set(fault, EX_BAD_INPUT,
				       "triangles %" PRIidx " and %" PRIidx " run along edge %" PRIidx " %" PRIidx
				       " in the same direction",
				       h / 3, g / 3, record[i].low, record[i].high);
		for (size_t k = 0; k < halves; k++)
			mark[record[i + k].item] = marked;
		if (halves == 2)
			twin[h] = g, twin[g] = h;
	}
	free(record);
	return ok;
}

/* How much the surface bends within the patch at the edges of triangle t and of its neighbours: what tessellation alone
 * does. The neighbours count because a strip of two triangles a quad bends only at the second one's far edge. */
static double own_bend(const struct dense *dense, const idx_t *twin, size_t t)
{
	double most = 0;
	for (size_t k = 0; k < 3; k++) {
		const idx_t g = twin[3 * t + k];
		if (g == NO_INDEX || dense->label[g / 3] != dense->label[t])
			continue;
		const size_t u = (size_t)g / 3;
		most = fmax(most, bend_deg(dense, t, u));
		for (size_t j = 0; j < 3; j++) {
			const idx_t f = twin[3 * u + j];
			if (f != NO_INDEX && dense->label[f / 3] == dense->label[t])
				most = fmax(most, bend_deg(dense, u, (size_t)f / 3));
		}
	}
	return most;
}

bool boundary_find(struct boundary *out, const struct dense *dense, const struct border_options *options, struct fault *fault)
{
	const size_t half_count = 3 * dense->triangle_count;
	idx_t *twin = mem_array(half_count, sizeof *twin);
	bool *mark = mem_array(half_count, sizeof *mark);
	if (!pair_edges(twin, mark, dense, fault)) {
		free(twin), free(mark);
		return false;
	}
	bool *in_use = mem_array(dense->vertex_count, sizeof *in_use);
	out->euler = (long)dense->triangle_count;
	for (size_t h = 0; h < half_count; h++) {
		out->euler -= twin[h] == NO_INDEX || (size_t)twin[h] > h;
		out->euler += !in_use[dense->triangle[h]];
		in_use[dense->triangle[h]] = true;
	}
	free(in_use);
	size_t count = 0, room = 64;
	struct boundary_edge *edge = mem_array(room, sizeof *edge);
	for (size_t h = 0; h < half_count; h++) {
		const idx_t g = twin[h], left = dense->label[h / 3], right = g == NO_INDEX ? -1 : dense->label[g / 3];
		bool dart = false;
		if (g != NO_INDEX && left == right) {
			if (!mark[h] || (size_t)g < h)
				continue;
			out->dart_edge_count++;
			if (!options->darts)
				continue;
			dart = true;
		}
		if (g != NO_INDEX && left > right)
			continue; /* the half-edge of the lower patch speaks for both */
		if (count == room)
			edge = mem_resize(edge, room *= 2, sizeof *edge);
		const idx_t a = dense->triangle[h], b = dense->triangle[h - h % 3 + (h + 1) % 3];
		bool sharp = true;
		if (dart || g == NO_INDEX)
			sharp = true;
		else if (same_surface(dense, left, right))
			sharp = false;
		else if (!mark[h]) {
			const size_t s = h / 3, t = (size_t)g / 3;
			sharp = options->smooth_deg == 0 ||
				bend_deg(dense, s, t) - fmax(own_bend(dense, twin, s), own_bend(dense, twin, t)) >
					options->smooth_deg;
		}
		edge[count++] = (struct boundary_edge){
			a, b, left, right, distance3(dense->xyz + 3 * (size_t)a, dense->xyz + 3 * (size_t)b), sharp};
	}
	free(twin), free(mark);

	size_t *start = mem_array(dense->vertex_count + 2, sizeof *start);
	idx_t *incident = mem_array(2 * count, sizeof *incident);
	for (size_t e = 0; e < count; e++)
		start[edge[e].a + 2]++, start[edge[e].b + 2]++;
	for (size_t v = 0; v < dense->vertex_count; v++)
		start[v + 2] += start[v + 1];
	for (size_t e = 0; e < count; e++) {
		incident[start[edge[e].a + 1]++] = (idx_t)e;
		incident[start[edge[e].b + 1]++] = (idx_t)e;
	}
	out->edge = edge, out->edge_count = count, out->start = start, out->incident = incident;
	return true;
}

void boundary_free(struct boundary *boundary)
{
	free(boundary->edge), free(boundary->start), free(boundary->incident);
}
