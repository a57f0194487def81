/* Limit positions and normals. Corners stay, creases are B-splines (1, 4, 1) / 6, all others take the mask of their ring. */
#include "stages/geometry/subdivide_limit.h"

#include <stdlib.h>
#include <string.h>

#include "stages/geometry/vector.h"

bool limit_needs_step(const struct level *level, enum cage_scheme scheme)
{
	for (size_t f = 0; f < level->face_count; f++) {
		const size_t degree = level->face_start[f + 1] - level->face_start[f];
		if (degree > 4 || (degree == 3 && scheme == SCHEME_CATMULLCLARK))
			return true;
	}
	return false;
}

void limit_begin(struct limit *limit, const struct level *level, const struct topology *topology)
{
	memset(limit, 0, sizeof *limit);
	limit->level = level;
	limit->topology = topology;
	limit->outgoing = mem_array(level->vertex_count, sizeof *limit->outgoing);
	limit->along = mem_array(2 * level->vertex_count, sizeof *limit->along);
	for (size_t h = level->face_start[level->face_count]; h-- > 0;)
		limit->outgoing[level->face_corner[h]] = (idx_t)h;
	for (size_t i = 0; i < 2 * level->vertex_count; i++)
		limit->along[i] = NO_INDEX;
	for (size_t e = 0; e < topology->edge_count; e++) {
		if (!topology->crease[e])
			continue;
		const size_t h = (size_t)topology->half[2 * e];
		const idx_t end[2] = {level->face_corner[h], level->face_corner[corner_next(level, topology, h)]};
		for (int k = 0; k < 2; k++) {
			idx_t *along = limit->along + 2 * end[k];
			along[along[0] != NO_INDEX] = end[1 - k];
		}
	}
}

void limit_end(struct limit *limit)
{
	free(limit->outgoing);
	free(limit->along);
	ring_free(&limit->ring);
	ring_cache_free(&limit->cache);
}

/* weights on the ring that was collected last */
static void put_ring(const struct limit *limit, size_t vertex, const double *weight, limit_put put, void *user)
{
	const struct ring *ring = &limit->ring;
	put(user, (idx_t)vertex, weight[0]);
	for (size_t j = 0; j < ring->valence; j++) {
		put(user, ring->neighbour[j], weight[1 + j]);
		if (ring->opposite[j] != NO_INDEX)
			put(user, ring->opposite[j], weight[1 + ring->valence + j]);
	}
}

static const struct ring_mask *collect(struct limit *limit, size_t vertex, bool with_tangents)
{
	ring_collect(&limit->ring, limit->level, limit->topology, (size_t)limit->outgoing[vertex]);
	return ring_mask(&limit->cache, &limit->ring, with_tangents);
}

void limit_stencil(struct limit *limit, size_t vertex, limit_put put, void *user)
{
	const idx_t *along = limit->along + 2 * vertex;
	switch ((enum vertex_kind)limit->topology->kind[vertex]) {
	case KIND_CORNER:
		put(user, (idx_t)vertex, 1);
		break;
	case KIND_CREASE:
		put(user, (idx_t)vertex, 4.0 / 6);
		put(user, along[0], 1.0 / 6);
		put(user, along[1], 1.0 / 6);
		break;
	case KIND_SMOOTH:
	case KIND_DART:
		put_ring(limit, vertex, collect(limit, vertex, false)->limit, put, user);
		break;
	}
}

struct point_sum {
	const double *xyz;
	double sum[3];
};

static void put_point(void *user, idx_t vertex, double weight)
{
	struct point_sum *p = user;
	add_scaled3(p->sum, weight, p->xyz + 3 * vertex);
}

void level_to_limit(struct level *level, enum cage_scheme scheme)
{
	if (limit_needs_step(level, scheme)) {
		/* a vertex of the next level has the same limit: old vertices come first there */
		struct level next;
		level_refine(&next, level, scheme, 1);
		level_to_limit(&next, scheme);
		memcpy(level->xyz, next.xyz, 3 * level->vertex_count * sizeof *level->xyz);
		level_free(&next);
		return;
	}
	struct topology topology;
	topology_build(&topology, level, scheme);
	struct limit limit;
	limit_begin(&limit, level, &topology);
	double *out = mem_array(3 * level->vertex_count, sizeof *out);
	for (size_t v = 0; v < level->vertex_count; v++) {
		struct point_sum p = {level->xyz, {0, 0, 0}};
		limit_stencil(&limit, v, put_point, &p);
		copy3(out + 3 * v, p.sum);
	}
	free(level->xyz);
	level->xyz = out;
	limit_end(&limit);
	topology_free(&topology);
}

/* Unit normal of each face: of its area vector, which is that of its diagonals for a quad. */
static void face_normals(double *normal, const struct level *level)
{
	for (size_t f = 0; f < level->face_count; f++) {
		double *n = normal + 3 * f;
		n[0] = n[1] = n[2] = 0;
		const double *origin = level->xyz + 3 * level->face_corner[level->face_start[f]];
		for (size_t h = level->face_start[f] + 1; h + 1 < level->face_start[f + 1]; h++) {
			double area[3];
			area_vector3(area, origin, level->xyz + 3 * level->face_corner[h], level->xyz + 3 * level->face_corner[h + 1]);
			add_scaled3(n, 1, area);
		}
		normalise3(n);
	}
}

void level_normals(double *normal, const struct level *level, enum cage_scheme scheme)
{
	if (limit_needs_step(level, scheme)) {
		struct level next;
		level_refine(&next, level, scheme, 1);
		double *finer = mem_array(3 * next.vertex_count, sizeof *finer);
		level_normals(finer, &next, scheme);
		memcpy(normal, finer, 3 * level->vertex_count * sizeof *normal);
		free(finer);
		level_free(&next);
		return;
	}
	double *face = mem_array(3 * level->face_count, sizeof *face);
	face_normals(face, level);
	memset(normal, 0, 3 * level->vertex_count * sizeof *normal);
	for (size_t f = 0; f < level->face_count; f++)
		for (size_t h = level->face_start[f]; h < level->face_start[f + 1]; h++)
			add_scaled3(normal + 3 * level->face_corner[h], 1, face + 3 * f);
	free(face);

	struct topology topology;
	topology_build(&topology, level, scheme);
	struct limit limit;
	limit_begin(&limit, level, &topology);
	for (size_t v = 0; v < level->vertex_count; v++) {
		double *n = normal + 3 * v;
		normalise3(n);
		if (topology.kind[v] == KIND_CORNER || topology.kind[v] == KIND_CREASE)
			continue;
		const struct ring_mask *mask = collect(&limit, v, true);
		struct point_sum t1 = {level->xyz, {0, 0, 0}}, t2 = t1;
		put_ring(&limit, v, mask->tangent1, put_point, &t1);
		put_ring(&limit, v, mask->tangent2, put_point, &t2);
		double cross[3];
		cross3(cross, t1.sum, t2.sum);
		/* a cusp, or a surface shrunk to a point: the mean of the faces is all there is */
		if (norm3(cross) > 1e-12 * norm3(t1.sum) * norm3(t2.sum)) {
			normalise3(cross);
			copy3(n, cross);
		}
	}
	limit_end(&limit);
	topology_free(&topology);
}
