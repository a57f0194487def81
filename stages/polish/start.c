#include "stages/polish/start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/shim/openmesh.h"
#include "stages/geometry/half.h"
#include "stages/geometry/vector.h"
#include "stages/polish/refit.h"

#define FINEST_FACES 6000   /* the dense mesh goes there once; coarser ones are made from that */
#define COARSEST_FACES 24
#define FACES_RATIO 1.5
#define REFITS 4
#define CREASE_SHARE 0.6    /* of the angle from which an edge of the target is sharp: collapsed edges bend less where a side is curved */

/* A triangle mesh whose vertices are some of the target's. */
struct base {
	idx_t *triangle;
	size_t triangle_count;
	const double *xyz;
	size_t vertex_count;
	unsigned char *is_sharp; /* a vertex: an end of a sharp edge of the target */
};

static double bend(const double *xyz, const struct half *half, size_t h)
{
	double n[2][3];
	for (int i = 0; i < 2; i++) {
		const size_t f = i ? (size_t)half->twin[h] / 3 : h / 3;
		area_vector3(n[i], &xyz[3 * (size_t)half->origin[3 * f]], &xyz[3 * (size_t)half->origin[3 * f + 1]], &xyz[3 * (size_t)half->origin[3 * f + 2]]);
	}
	return norm3(n[0]) > 0 && norm3(n[1]) > 0 ? angle3(n[0], n[1]) * DEGREES : 0;
}

/* The edges that bend by the angle or more: 2 vertices each. Only those between sharp vertices, when these are known. */
static idx_t *sharp_edges(size_t *count, const struct half *half, const double *xyz, double deg, const unsigned char *is_sharp)
{
	idx_t *edge = mem_array(half->half_count, sizeof *edge);
	*count = 0;
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t a = half->origin[h], b = half->origin[half->next[h]];
		if (half->twin[h] > (idx_t)h && (!is_sharp || (is_sharp[a] && is_sharp[b])) && bend(xyz, half, h) > deg)
			edge[2 * *count] = a, edge[2 * (*count)++ + 1] = b;
	}
	return edge;
}

static int compare_edges(const void *a, const void *b)
{
	const idx_t *p = a, *q = b;
	return p[0] != q[0] ? (p[0] > q[0]) - (p[0] < q[0]) : (p[1] > q[1]) - (p[1] < q[1]);
}

static bool collapse(struct base *base, size_t faces, double deg)
{
	struct half half;
	struct fault fault = {0};
	char message[200];
	if (!half_build_triangles(&half, base->triangle, base->triangle_count, base->vertex_count, &fault))
		return false;
	size_t count;
	if (!base->is_sharp) {
		base->is_sharp = mem_array(base->vertex_count, 1);
		idx_t *edge = sharp_edges(&count, &half, base->xyz, deg, NULL);
		for (size_t i = 0; i < 2 * count; i++)
			base->is_sharp[edge[i]] = 1;
		free(edge);
	}
	half_free(&half);
	const long left = shim_simplify(base->triangle, NULL, base->triangle_count, base->xyz, base->vertex_count, NULL, NULL, 0, 1, faces, message, sizeof message);
	base->triangle_count = left < 0 ? 0 : (size_t)left;
	return left > 0;
}

static bool to_sketch(struct sketch *sketch, const struct base *base, enum cage_scheme scheme, double deg)
{
	static const double zero[3] = {0};
	const size_t n = base->triangle_count;
	struct fault fault = {0};
	struct half half;
	idx_t *number = mem_array(base->vertex_count, sizeof *number);
	struct cage cage = {.scheme = scheme, .face_count = n};
	cage.xyz = mem_array(9 * n, sizeof *cage.xyz);
	cage.face_corner = mem_array(3 * n, sizeof *cage.face_corner);
	cage.face_start = mem_array(n + 1, sizeof *cage.face_start);
	cage.face_patch = mem_array(n, sizeof *cage.face_patch);
	for (size_t i = 0; i < 3 * n; i++) {
		const idx_t v = base->triangle[i];
		if (number[v] == 0) {
			copy3(&cage.xyz[3 * cage.vertex_count], &base->xyz[3 * (size_t)v]);
			number[v] = (idx_t)++cage.vertex_count;
		}
		cage.face_corner[i] = number[v] - 1;
	}
	cage.corner = mem_array(cage.vertex_count, 1);
	for (size_t f = 0; f <= n; f++)
		cage.face_start[f] = 3 * f;
	bool is_good = half_build_triangles(&half, cage.face_corner, n, cage.vertex_count, &fault);
	if (is_good) {
		unsigned char *is_sharp = mem_array(cage.vertex_count, 1);
		for (size_t v = 0; v < base->vertex_count; v++)
			if (number[v] > 0)
				is_sharp[number[v] - 1] = base->is_sharp[v];
		cage.sharp = sharp_edges(&cage.sharp_count, &half, cage.xyz, CREASE_SHARE * deg, is_sharp);
		for (size_t e = 0; e < cage.sharp_count; e++) {
			idx_t *ends = &cage.sharp[2 * e];
			if (ends[0] > ends[1]) {
				const idx_t first = ends[0];
				ends[0] = ends[1], ends[1] = first;
			}
		}
		qsort(cage.sharp, cage.sharp_count, 2 * sizeof *cage.sharp, compare_edges);
		half_free(&half);
		is_good = sketch_from_cage(sketch, &cage, zero, 1, &fault);
		free(is_sharp);
	}
	cage_free(&cage);
	free(number);
	return is_good;
}

/* The candidate of about so many faces; false when it cannot be made, or is that of *reached faces again: handles and what must not fold set
 * a limit. */
static bool fitted(struct candidate *c, size_t *reached, const struct base *fine, size_t faces, enum cage_scheme scheme, const struct judge *judge, double deg)
{
	struct base base = *fine;
	*c = (struct candidate){0};
	base.triangle = mem_copy(fine->triangle, 3 * fine->triangle_count, sizeof *fine->triangle);
	bool is_good = collapse(&base, faces, deg) && base.triangle_count != *reached;
	*reached = base.triangle_count;
	is_good = is_good && to_sketch(&c->sketch, &base, scheme, deg);
	free(base.triangle);
	if (is_good)
		refit_all(&c->sketch, &c->errors, judge, REFITS);
	return is_good;
}

bool start_collapsed(struct candidate *out, enum cage_scheme scheme, const struct judge *judge, double most_mean, double most_mean_large,
                     size_t most_vertices, double sharp_deg)
{
	const struct target *t = judge->target;
	struct base fine = {mem_copy(t->triangle, 3 * t->triangle_count, sizeof *t->triangle), t->triangle_count, t->xyz, t->vertex_count, NULL};
	const size_t most_faces = 2 * most_vertices;
	bool is_found = false;
	size_t reached = 0;
	if (collapse(&fine, FINEST_FACES, sharp_deg))
		for (double faces = COARSEST_FACES; faces < (double)most_faces * FACES_RATIO && !is_found; faces *= FACES_RATIO) {
			if (!fitted(out, &reached, &fine, (size_t)fmin(faces, (double)most_faces), scheme, judge, sharp_deg))
				continue;
			if (out->sketch.vertex_count > most_vertices) { /* feature edges hold more than that */
				candidate_free(out);
				break;
			}
			is_found = out->errors.mean <= (3 * out->sketch.vertex_count > most_vertices ? most_mean_large : most_mean);
			if (!is_found)
				candidate_free(out);
		}
	free(fine.triangle), free(fine.is_sharp);
	return is_found;
}
