/* Merge patches that are too narrow to be seen: see sliver.h. */
#include "stages/rectify/sliver.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"
#include "stages/rectify/patchmesh.h"

struct by_area {
	double area;
	idx_t label;
};

static int compare_areas(const void *a, const void *b)
{
	const struct by_area *p = a, *q = b;
	if (p->area != q->area)
		return p->area < q->area ? -1 : 1;
	return (p->label > q->label) - (p->label < q->label);
}

/* A border half-edge of a patch, by the label behind it. */
struct neighbour {
	idx_t label;
	double length;
};

static int compare_neighbours(const void *a, const void *b)
{
	const struct neighbour *p = a, *q = b;
	if (p->label != q->label)
		return p->label < q->label ? -1 : 1;
	return (p->length > q->length) - (p->length < q->length);
}

static bool is_narrow(const struct partition *p, const idx_t *list, size_t count, double width, idx_t *local)
{
	const struct half *half = &p->half;
	double area = 0, perimeter = 0;
	for (size_t i = 0; i < count; i++) {
		area += p->area[list[i]];
		for (idx_t h = 3 * list[i]; h < 3 * list[i] + 3; h++)
			if (half->twin[h] == NO_INDEX || p->label[half->face[half->twin[h]]] != p->label[list[i]])
				perimeter += p->length[h];
	}
	if (!(perimeter > 0) || 2 * area > width * perimeter)
		return false;
	struct patchmesh m;
	patchmesh_cut_out(&m, half, p->xyz, list, count, local);
	idx_t *source = mem_array(m.half.vertex_count, sizeof *source);
	double *distance = mem_array(m.half.vertex_count, sizeof *distance);
	size_t source_count = 0;
	for (size_t v = 0; v < m.half.vertex_count; v++)
		/* a border vertex' first half-edge has no face on its left */
		if (m.half.twin[m.half.previous[m.half.outgoing[v]]] == NO_INDEX)
			source[source_count++] = (idx_t)v;
	patchmesh_distances(distance, &m, source, source_count);
	bool is_near = true;
	for (size_t v = 0; v < m.half.vertex_count; v++)
		is_near = is_near && 2 * distance[v] <= width;
	free(source);
	free(distance);
	patchmesh_free(&m);
	return is_near;
}

/* The neighbour with the longest common border, NO_INDEX for none. */
static idx_t find_host(const struct partition *p, const idx_t *list, size_t count)
{
	const struct half *half = &p->half;
	struct neighbour *n = mem_array(3 * count, sizeof *n);
	size_t found = 0;
	for (size_t i = 0; i < count; i++)
		for (idx_t h = 3 * list[i]; h < 3 * list[i] + 3; h++)
			if (half->twin[h] != NO_INDEX && p->label[half->face[half->twin[h]]] != p->label[list[i]])
				n[found++] = (struct neighbour){p->label[half->face[half->twin[h]]], p->length[h]};
	qsort(n, found, sizeof *n, compare_neighbours);
	idx_t host = NO_INDEX;
	double longest = 0;
	for (size_t i = 0, end; i < found; i = end) {
		double length = 0;
		for (end = i; end < found && n[end].label == n[i].label; end++)
			length += n[end].length;
		if (length > longest)
			longest = length, host = n[i].label;
	}
	free(n);
	return host;
}

static bool is_near_surface(const struct partition *p, const idx_t *list, size_t count, idx_t host, double width)
{
	if (p->patch[host].kind == PATCH_FREE)
		return true;
	for (size_t i = 0; i < count; i++)
		for (int k = 0; k < 3; k++)
			if (fabs(primitive_distance(&p->patch[host], p->xyz + 3 * p->half.origin[3 * list[i] + k])) > width)
				return false;
	return true;
}

/* A patch's own triangles and those of the slivers that it has taken in: the labels chained behind it. */
static size_t gather(idx_t *out, idx_t label, const idx_t *chain, const size_t *start, const idx_t *list)
{
	size_t count = 0;
	for (idx_t l = label; l != NO_INDEX; l = chain[l])
		for (size_t i = start[l]; i < start[l + 1]; i++)
			out[count++] = list[i];
	return count;
}

size_t sliver_merge(struct partition *p, double width, size_t *edges)
{
	const struct half *half = &p->half;
	const size_t patch_count = p->patch_count;
	struct by_area *order = mem_array(patch_count, sizeof *order);
	idx_t *local = mem_array(half->face_count, sizeof *local), *own = mem_array(half->face_count, sizeof *own), *list;
	idx_t *chain = mem_array(patch_count, sizeof *chain), *tail = mem_array(patch_count, sizeof *tail);
	size_t *start, merged = 0, smoothed = 0, order_count = 0;
	partition_refresh(p);
	partition_lists(p, &start, &list);
	for (size_t t = 0; t < half->face_count; t++)
		local[t] = NO_INDEX;
	for (size_t l = 0; l < patch_count; l++) {
		chain[l] = NO_INDEX;
		tail[l] = (idx_t)l;
		if (start[l + 1] > start[l])
			order[order_count++] = (struct by_area){p->patch_area[l], (idx_t)l};
	}
	qsort(order, order_count, sizeof *order, compare_areas);
	for (size_t i = 0; i < order_count; i++) {
		const idx_t l = order[i].label;
		const size_t count = gather(own, l, chain, start, list);
		if (!is_narrow(p, own, count, width, local))
			continue;
		const idx_t host = find_host(p, own, count);
		if (host == NO_INDEX || !is_near_surface(p, own, count, host, width))
			continue;
		for (size_t k = 0; k < count; k++)
			for (idx_t h = 3 * own[k]; h < 3 * own[k] + 3; h++) {
				const idx_t twin = half->twin[h];
				if (twin == NO_INDEX || p->label[half->face[twin]] != host || p->kind[h] != EDGE_SHARP)
					continue;
				p->kind[h] = p->kind[twin] = 0;
				smoothed++;
			}
		for (size_t k = 0; k < count; k++)
			p->label[own[k]] = host;
		chain[tail[host]] = l;
		tail[host] = tail[l];
		merged++;
	}
	partition_refresh(p);
	if (edges)
		*edges = smoothed;
	free(order);
	free(local);
	free(own);
	free(chain);
	free(tail);
	free(start);
	free(list);
	return merged;
}
