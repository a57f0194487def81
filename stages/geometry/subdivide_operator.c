/* Subdivision as sparse matrices: the same rules as the refiner's, row by row. */
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/sparse.h"
#include "stages/geometry/subdivide_limit.h"
#include "stages/geometry/subdivide_mask.h"

/* weight times the centre of a face */
static void put_centre(struct sparse_maker *maker, const struct level *level, size_t f, double weight)
{
	const double share = weight / (double)(level->face_start[f + 1] - level->face_start[f]);
	for (size_t h = level->face_start[f]; h < level->face_start[f + 1]; h++)
		sparse_put(maker, (size_t)level->face_corner[h], share);
}

/* What the face of corner h gives to the point of its smooth edge. */
static void put_edge_side(struct sparse_maker *maker, const struct level *level, const struct topology *topology, size_t h,
                          enum cage_scheme scheme)
{
	const size_t f = (size_t)topology->face[h], degree = level->face_start[f + 1] - level->face_start[f];
	const size_t next = corner_next(level, topology, h), previous = corner_previous(level, topology, h);
	const size_t a = (size_t)level->face_corner[h], b = (size_t)level->face_corner[next];
	const size_t p = (size_t)level->face_corner[previous], q = (size_t)level->face_corner[corner_next(level, topology, next)];
	if (!splits_to_quads(degree, scheme)) {
		sparse_put(maker, a, 3.0 / 16);
		sparse_put(maker, b, 3.0 / 16);
		sparse_put(maker, p, 1.0 / 8);
		return;
	}
	const bool is_plain = degree == 4 || scheme == SCHEME_CATMULLCLARK;
	sparse_put(maker, a, is_plain ? 1.0 / 8 : 5.0 / 32);
	sparse_put(maker, b, is_plain ? 1.0 / 8 : 5.0 / 32);
	if (!is_plain) {
		sparse_put(maker, p, 1.0 / 32);
		sparse_put(maker, q, 1.0 / 32);
	}
	put_centre(maker, level, f, is_plain ? 1.0 / 4 : 1.0 / 8);
}

static void put_vertex(struct sparse_maker *maker, const struct level *level, const struct topology *topology, size_t v,
                       const idx_t *corner, const idx_t along[2], enum cage_scheme scheme)
{
	if (topology->kind[v] == KIND_CORNER) {
		sparse_put(maker, v, 1);
		return;
	}
	if (topology->kind[v] == KIND_CREASE) {
		const double beta = step_mask_crease().beta;
		sparse_put(maker, v, 1 - 2 * beta);
		sparse_put(maker, (size_t)along[0], beta);
		sparse_put(maker, (size_t)along[1], beta);
		return;
	}
	const size_t valence = (size_t)topology->valence[v];
	const struct step_mask mask = step_mask_smooth(valence, (size_t)topology->quads[v]);
	sparse_put(maker, v, 1 - mask.beta * mask.count);
	for (size_t j = 0; j < valence; j++) {
		const size_t h = (size_t)corner[j], f = (size_t)topology->face[h];
		sparse_put(maker, (size_t)level->face_corner[corner_next(level, topology, h)], mask.beta);
		if (splits_to_quads(level->face_start[f + 1] - level->face_start[f], scheme))
			put_centre(maker, level, f, mask.beta);
	}
}

/* One step: rows in the order of the refiner: old vertices, edges, centres. */
static void step_operator(struct sparse *out, const struct level *level, const struct topology *topology, enum cage_scheme scheme)
{
	const size_t corner_count = level->face_start[level->face_count];
	size_t centres = 0;
	for (size_t f = 0; f < level->face_count; f++)
		centres += splits_to_quads(level->face_start[f + 1] - level->face_start[f], scheme);
	/* corners by vertex */
	size_t *start = mem_array(level->vertex_count + 1, sizeof *start);
	idx_t *corner = mem_array(corner_count, sizeof *corner);
	for (size_t v = 0; v < level->vertex_count; v++)
		start[v + 1] = start[v] + (size_t)topology->valence[v];
	for (size_t h = 0; h < corner_count; h++)
		corner[start[level->face_corner[h]]++] = (idx_t)h;
	struct limit limit; /* knows the neighbours along creases */
	limit_begin(&limit, level, topology);

	struct sparse_maker maker;
	sparse_begin(&maker, out, level->vertex_count + topology->edge_count + centres, level->vertex_count);
	for (size_t v = 0; v < level->vertex_count; v++) {
		put_vertex(&maker, level, topology, v, corner + start[v] - topology->valence[v], limit.along + 2 * v, scheme);
		sparse_end_row(&maker);
	}
	for (size_t e = 0; e < topology->edge_count; e++) {
		const size_t h = (size_t)topology->half[2 * e];
		if (topology->crease[e]) {
			sparse_put(&maker, (size_t)level->face_corner[h], 1.0 / 2);
			sparse_put(&maker, (size_t)level->face_corner[corner_next(level, topology, h)], 1.0 / 2);
		} else {
			put_edge_side(&maker, level, topology, h, scheme);
			put_edge_side(&maker, level, topology, (size_t)topology->half[2 * e + 1], scheme);
		}
		sparse_end_row(&maker);
	}
	for (size_t f = 0; f < level->face_count; f++)
		if (splits_to_quads(level->face_start[f + 1] - level->face_start[f], scheme)) {
			put_centre(&maker, level, f, 1);
			sparse_end_row(&maker);
		}
	sparse_end(&maker);
	limit_end(&limit);
	free(start);
	free(corner);
}

static void put_entry(void *user, idx_t vertex, double weight)
{
	sparse_put(user, (size_t)vertex, weight);
}

/* Limits of the first row_count vertices. */
static void limit_operator(struct sparse *out, const struct level *level, const struct topology *topology, size_t row_count)
{
	struct limit limit;
	limit_begin(&limit, level, topology);
	struct sparse_maker maker;
	sparse_begin(&maker, out, row_count, level->vertex_count);
	for (size_t v = 0; v < row_count; v++) {
		limit_stencil(&limit, v, put_entry, &maker);
		sparse_end_row(&maker);
	}
	sparse_end(&maker);
	limit_end(&limit);
}

static void identity(struct sparse *out, size_t count)
{
	struct sparse_maker maker;
	sparse_begin(&maker, out, count, count);
	for (size_t v = 0; v < count; v++) {
		sparse_put(&maker, v, 1);
		sparse_end_row(&maker);
	}
	sparse_end(&maker);
}

/* total := next * total; next is used up */
static void prepend(struct sparse *total, struct sparse *next)
{
	if (total->row_start == NULL) {
		*total = *next;
		return;
	}
	struct sparse product;
	sparse_multiply(&product, next, total);
	sparse_free(total);
	sparse_free(next);
	*total = product;
}

void subdivide_operator(struct sparse *operator, struct level *refined, const struct level *in, enum cage_scheme scheme, int steps, bool to_limit)
{
	memset(operator, 0, sizeof *operator);
	struct level level, next;
	level_refine(&level, in, scheme, 0);
	/* with n-gons on the last level, limits are taken one step further on */
	const bool extra = to_limit && limit_needs_step(in, scheme) && steps == 0;
	for (int s = 0; s < steps + extra; s++) {
		struct topology topology;
		struct sparse step;
		topology_build(&topology, &level, scheme);
		step_operator(&step, &level, &topology, scheme);
		topology_free(&topology);
		prepend(operator, &step);
		level_refine(&next, &level, scheme, 1);
		level_free(&level);
		level = next;
	}
	if (to_limit) {
		struct topology topology;
		struct sparse last;
		topology_build(&topology, &level, scheme);
		limit_operator(&last, &level, &topology, extra ? in->vertex_count : level.vertex_count);
		topology_free(&topology);
		prepend(operator, &last);
	}
	if (operator->row_start == NULL)
		identity(operator, in->vertex_count);
	if (extra) {
		level_free(&level);
		level_refine(&level, in, scheme, 0);
	}
	if (to_limit)
		sparse_apply(level.xyz, operator, in->xyz);
	*refined = level;
}
