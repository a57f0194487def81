/* From a clean mesh to the dense mesh with curvatures: see curvature.h. */
#include "stages/curv/curvature.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/vector.h"
#include "stages/geometry/wedge.h"

/* Lower triangles (longest side 1) have a normal that the six digits of common files decide. */
#define THIN 1e-5
#define RADIUS_LOW 0.003
#define RADIUS_HIGH 0.06

static int compare_pairs(const void *a, const void *b)
{
	const idx_t *p = a, *q = b;
	if (p[0] != q[0])
		return p[0] < q[0] ? -1 : 1;
	return (p[1] > q[1]) - (p[1] < q[1]);
}

/* Mark border half-edges that a repair opened. */
static void mark_cuts(unsigned char *kind, const struct half *half, const idx_t *cut, size_t cut_count)
{
	idx_t *pair = mem_array(cut_count, 2 * sizeof *pair);
	for (size_t i = 0; i < cut_count; i++) {
		pair[2 * i] = cut[2 * i] < cut[2 * i + 1] ? cut[2 * i] : cut[2 * i + 1];
		pair[2 * i + 1] = cut[2 * i] < cut[2 * i + 1] ? cut[2 * i + 1] : cut[2 * i];
	}
	qsort(pair, cut_count, 2 * sizeof *pair, compare_pairs);
	for (size_t h = 0; h < half->half_count; h++) {
		if (half->twin[h] != NO_INDEX)
			continue;
		const idx_t a = half->origin[h], b = half->origin[half->next[h]];
		const idx_t want[2] = {a < b ? a : b, a < b ? b : a};
		if (bsearch(want, pair, cut_count, 2 * sizeof *pair, compare_pairs))
			kind[h] = EDGE_CUT;
	}
	free(pair);
}

static void list_edges(struct dense *dense, const unsigned char *kind, const double *bend, const struct half *half)
{
	for (int pass = 0; pass < 2; pass++) {
		dense->edge_count = 0;
		for (size_t h = 0; h < half->half_count; h++) {
			const idx_t twin = half->twin[h];
			if (!kind[h] || (twin != NO_INDEX && twin < (idx_t)h))
				continue;
			if (pass == 1) {
				dense->edge[dense->edge_count] = (struct dense_edge){half->origin[h], half->origin[half->next[h]], bend[h] * DEGREES,
				                                                     (enum edge_kind)kind[h]};
			}
			dense->edge_count++;
		}
		if (pass == 0)
			dense->edge = mem_array(dense->edge_count, sizeof *dense->edge);
	}
}

bool curvature_compute(struct dense *dense, struct sharp_counts *counts, const struct mesh *mesh, const idx_t *cut, size_t cut_count,
                       const struct curvature_options *options, struct fault *fault)
{
	struct half half;
	double low[3], high[3];
	memset(dense, 0, sizeof *dense);
	for (size_t f = 0; f < mesh->face_count; f++)
		if (mesh->face_start[f + 1] - mesh->face_start[f] != 3)
			return fault_set(fault, EX_BUG, "face %zu of the clean mesh is no triangle", f);
	if (!half_build_triangles(&half, mesh->corner, mesh->face_count, mesh->vertex_count, fault))
		return false;
	const double side = mesh_bounds(mesh->xyz, mesh->vertex_count, low, high);
	if (!(side > 0) || !isfinite(side)) {
		half_free(&half);
		return fault_set(fault, EX_BAD_INPUT, "the mesh has no extent");
	}

	const size_t vertex_count = mesh->vertex_count, triangle_count = mesh->face_count;
	double *xyz = mem_array(vertex_count, 3 * sizeof *xyz);
	for (size_t i = 0; i < 3 * vertex_count; i++)
		xyz[i] = (mesh->xyz[i] - low[i % 3]) / side;
	double *normal = mem_array(triangle_count, 3 * sizeof *normal);
	double *bend = mem_array(half.half_count, sizeof *bend);
	unsigned char *kind = mem_array(half.half_count, 1);
	wedge_triangle_normals(normal, xyz, &half, THIN);
	wedge_bends(bend, xyz, normal, &half);
	mark_cuts(kind, &half, cut, cut_count);
	sharp_edges(kind, counts, xyz, bend, &half, &options->sharp);

	dense->vertex_count = vertex_count;
	dense->triangle_count = triangle_count;
	dense->xyz = mem_copy(mesh->xyz, 3 * vertex_count, sizeof *mesh->xyz);
	dense->triangle = mem_copy(mesh->corner, 3 * triangle_count, sizeof *mesh->corner);
	dense->triangle_wedge = mem_array(3 * triangle_count, sizeof *dense->triangle_wedge);
	dense->wedge_count = wedge_number(dense->triangle_wedge, &dense->wedge_vertex, &half, kind);
	list_edges(dense, kind, bend, &half);

	const size_t n = dense->wedge_count;
	dense->wedge_normal = mem_array(3 * n, sizeof *dense->wedge_normal);
	dense->kmin = mem_array(n, sizeof *dense->kmin);
	dense->kmax = mem_array(n, sizeof *dense->kmax);
	dense->dmin = mem_array(3 * n, sizeof *dense->dmin);
	dense->anisotropy = mem_array(n, sizeof *dense->anisotropy);
	dense->quality = mem_array(n, sizeof *dense->quality);
	double *radius = mem_array(n, sizeof *radius);
	const struct normalcycle_mesh input = {xyz, normal, bend, kind, &half, dense->triangle_wedge, dense->wedge_vertex, n};
	const struct normalcycle_options how = {options->radius / side, RADIUS_LOW, RADIUS_HIGH, false, false};
	struct normalcycle_result result = {dense->wedge_normal, dense->kmin, dense->kmax, dense->dmin, dense->anisotropy, radius, dense->quality};
	normalcycle_tensors(&result, &input, &how);
	for (size_t w = 0; w < n; w++) {
		dense->kmin[w] /= side;
		dense->kmax[w] /= side;
	}
	free(radius);
	free(xyz);
	free(normal);
	free(bend);
	free(kind);
	half_free(&half);
	return true;
}
