/* Steps 2 and 4: closing what floating point numbers and careless tessellation left open. Borders only. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"
#include "stages/geometry/vector.h"

/* 1 for vertices and (when not NULL) half-edges at a border. Returns how many vertices. */
static size_t mark_border(const struct soup *soup, unsigned char *vertex, unsigned char *half)
{
	const size_t count = 3 * soup->triangle_count;
	struct side *side = soup_sides(soup);
	size_t found = 0;
	for (size_t i = 0, end; i < count; i = end) {
		end = side_run(side, count, i);
		if (end - i != 1)
			continue;
		found += !vertex[side[i].low];
		vertex[side[i].low] = 1;
		found += !vertex[side[i].high];
		vertex[side[i].high] = 1;
		if (half)
			half[side[i].half] = 1;
	}
	free(side);
	return found;
}

void soup_weld_border(struct soup *soup, double distance)
{
	unsigned char *at_border = mem_array(soup->vertex_count, 1);
	const size_t count = mark_border(soup, at_border, NULL);
	size_t *no_faces = mem_array(1, sizeof *no_faces);
	struct mesh border = {.xyz = mem_array(3 * count, sizeof *border.xyz), .vertex_count = count, .face_start = no_faces};
	idx_t *vertex = mem_array(count, sizeof *vertex), *group = mem_array(count, sizeof *group),
	      *leader = mem_array(count, sizeof *leader);
	for (size_t v = 0, n = 0; v < soup->vertex_count; v++)
		if (at_border[v]) {
			copy3(border.xyz + 3 * n, soup->xyz + 3 * v);
			vertex[n++] = (idx_t)v;
		}
	soup->report->count[REPAIR_WELDED_NEAR] += mesh_weld(&border, distance, group);
	idx_t *becomes = mem_array(soup->vertex_count, sizeof *becomes);
	for (size_t v = 0; v < soup->vertex_count; v++)
		becomes[v] = (idx_t)v;
	for (size_t n = count; n-- > 0;) /* downward, so that the first of a group leads */
		leader[group[n]] = vertex[n];
	for (size_t n = 0; n < count; n++)
		becomes[vertex[n]] = leader[group[n]];
	for (size_t h = 0; h < 3 * soup->triangle_count; h++)
		soup->triangle[h] = becomes[soup->triangle[h]];
	mesh_free(&border);
	free(at_border), free(vertex), free(group), free(leader), free(becomes);
}

/* A vertex on a border edge. */
struct junction {
	double along; /* [0, 1] from the start of the half-edge */
	idx_t vertex;
};

static int compare_junctions(const void *left, const void *right)
{
	const struct junction *a = left, *b = right;
	if (a->along != b->along)
		return a->along < b->along ? -1 : 1;
	return (a->vertex > b->vertex) - (a->vertex < b->vertex);
}

struct junction_query {
	const struct soup *soup;
	const idx_t *vertex; /* of each item of the tree */
	size_t half;
	double distance;
	struct junction *junction;
	size_t count, room;
};

static void visit_vertex(void *user, size_t item)
{
	struct junction_query *const query = user;
	const struct soup *const soup = query->soup;
	const idx_t v = query->vertex[item], a = soup->triangle[query->half], b = soup->triangle[next_half(query->half)];
	if (v == a || v == b || v == soup->triangle[previous_half(query->half)])
		return;
	const double *pa = soup->xyz + 3 * (size_t)a, *pb = soup->xyz + 3 * (size_t)b, *pv = soup->xyz + 3 * (size_t)v;
	double ab[3], av[3], off[3];
	sub3(ab, pb, pa);
	sub3(av, pv, pa);
	const double length = norm3(ab), along = dot3(av, ab) / length;
	/* What is as near to an end was a matter for welding. */
	if (!(along > query->distance) || !(along < length - query->distance))
		return;
	copy3(off, av);
	add_scaled3(off, -along / length, ab);
	if (norm3(off) > query->distance)
		return;
	if (query->count == query->room)
		query->junction = mem_resize(query->junction, query->room = 2 * query->room + 16, sizeof *query->junction);
	query->junction[query->count++] = (struct junction){along / length, v};
}

/* Cut the triangle of half-edge at[k] at the junctions into a fan around the opposite corner. at[0], at[1], at[2] are where
 * the half-edges of one original triangle are now. */
static void split_side(struct soup *soup, size_t *at, size_t k, const struct junction *junction, size_t count)
{
	const size_t h = at[k];
	const bool next_moves = at[(k + 1) % 3] == next_half(h); /* else an earlier cut has taken that side elsewhere */
	const idx_t apex = soup->triangle[previous_half(h)], end = soup->triangle[next_half(h)];
	for (size_t j = 0; j < count; j++) {
		const idx_t v = junction[j].vertex, to = j + 1 < count ? junction[j + 1].vertex : end;
		const size_t t = soup_add_triangle(soup, v, to, apex);
		if (j == 0)
			soup->triangle[next_half(h)] = v;
		if (j + 1 == count && next_moves)
			at[(k + 1) % 3] = 3 * t + 1; /* from the end to the apex */
	}
}

void soup_split_junctions(struct soup *soup, double distance)
{
	const size_t old_triangles = soup->triangle_count, old_count = 3 * old_triangles;
	unsigned char *at_border = mem_array(soup->vertex_count, 1), *border = mem_array(old_count, 1);
	const size_t count = mark_border(soup, at_border, border);
	idx_t *vertex = mem_array(count, sizeof *vertex);
	double *box = mem_array(6 * count, sizeof *box);
	for (size_t v = 0, n = 0; v < soup->vertex_count; v++)
		if (at_border[v]) {
			copy3(box + 6 * n, soup->xyz + 3 * v);
			copy3(box + 6 * n + 3, soup->xyz + 3 * v);
			vertex[n++] = (idx_t)v;
		}
	struct box_tree tree = box_tree_new(box, count);
	struct junction_query query = {.soup = soup, .vertex = vertex, .distance = distance};
	/* Heaps of edges over heaps of vertices along one line could make a square of them: more than this is no tessellation. */
	const size_t most = 4 * old_triangles + 1000;
	size_t splits = 0;
	for (size_t t = 0; t < old_triangles && splits < most; t++) {
		size_t at[3] = {3 * t, 3 * t + 1, 3 * t + 2};
		for (size_t k = 0; k < 3 && splits < most; k++) {
			if (!border[3 * t + k])
				continue;
			query.half = at[k];
			query.count = 0;
			const double *from = soup->xyz + 3 * (size_t)soup->triangle[at[k]],
				     *to = soup->xyz + 3 * (size_t)soup->triangle[next_half(at[k])];
			box_tree_segment(&tree, from, to, distance, visit_vertex, &query);
			if (query.count == 0)
				continue;
			qsort(query.junction, query.count, sizeof *query.junction, compare_junctions);
			split_side(soup, at, k, query.junction, query.count);
			splits += query.count;
		}
	}
	soup->report->count[REPAIR_T_JUNCTION_SPLIT] += splits;
	box_tree_free(&tree);
	free(at_border), free(border), free(vertex), free(box), free(query.junction);
}
