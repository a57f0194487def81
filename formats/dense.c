#include "formats/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const wedge_normal_name[3] = {"nx", "ny", "nz"};
static const char *const dmin_name[3] = {"dminx", "dminy", "dminz"};
static const char *const point_name[3] = {"px", "py", "pz"};
static const char *const axis_name[3] = {"ax", "ay", "az"};

void dense_free(struct dense *dense)
{
	free(dense->xyz);
	free(dense->triangle);
	free(dense->triangle_wedge);
	free(dense->label);
	free(dense->wedge_vertex);
	free(dense->wedge_normal);
	free(dense->kmin);
	free(dense->kmax);
	free(dense->dmin);
	free(dense->anisotropy);
	free(dense->quality);
	free(dense->edge);
	free(dense->patch);
	*dense = (struct dense){0};
}

/* Three indices a face. */
static idx_t *index_triples(const struct ply_element *face, const char *name, size_t high, const char *shown, struct fault *fault)
{
	const struct ply_column *column = ply_want_list(face, name, shown, fault);
	if (!column)
		return NULL;
	for (size_t f = 0; f < face->count; f++) {
		if (column->start[f + 1] - column->start[f] != 3) {
			fault_set(fault, EX_BAD_INPUT, "%s: face %zu: %zu %s, a triangle has 3", shown, f,
			          column->start[f + 1] - column->start[f], column->name);
			return NULL;
		}
	}
	return ply_indices(face, column, 0, (long long)high, shown, fault);
}

static bool read_triangles(struct dense *dense, const struct ply *ply, const char *shown, struct fault *fault)
{
	const struct ply_element *vertex = ply_want_element(ply, "vertex", shown, fault);
	const struct ply_element *face = vertex ? ply_want_element(ply, "face", shown, fault) : NULL;
	if (!face)
		return false;
	dense->vertex_count = vertex->count;
	dense->triangle_count = face->count;
	dense->xyz = ply_points(vertex, shown, fault);
	if (!dense->xyz)
		return false;
	dense->triangle = index_triples(face, "vertex_indices", vertex->count, shown, fault);
	if (!dense->triangle)
		return false;
	for (size_t f = 0; f < face->count; f++) {
		const idx_t *t = dense->triangle + 3 * f;
		if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
			return fault_set(fault, EX_BAD_INPUT, "%s: face %zu: a vertex stands twice in the triangle", shown, f);
	}
	return true;
}

static bool read_wedges(struct dense *dense, const struct ply *ply, const char *shown, struct fault *fault)
{
	const struct ply_element *wedge = ply_want_element(ply, "wedge", shown, fault);
	if (!wedge)
		return false;
	dense->wedge_count = wedge->count;
	if (!(dense->wedge_vertex = ply_index_scalar(wedge, "vertex", 0, (long long)dense->vertex_count, shown, fault)) ||
	    !(dense->wedge_normal = ply_triples(wedge, wedge_normal_name, shown, fault)) ||
	    !(dense->kmin = ply_numbers(wedge, "kmin", shown, fault)) ||
	    !(dense->kmax = ply_numbers(wedge, "kmax", shown, fault)) ||
	    !(dense->dmin = ply_triples(wedge, dmin_name, shown, fault)) ||
	    !(dense->anisotropy = ply_numbers(wedge, "anisotropy", shown, fault)))
		return false;
	idx_t *quality = ply_index_scalar(wedge, "quality", 0, WEDGE_SINGULAR + 1, shown, fault);
	if (!quality)
		return false;
	dense->quality = mem_array(wedge->count, 1);
	for (size_t w = 0; w < wedge->count; w++)
		dense->quality[w] = (unsigned char)quality[w];
	free(quality);

	const struct ply_element *face = ply_element(ply, "face");
	dense->triangle_wedge = index_triples(face, "wedge_indices", wedge->count, shown, fault);
	if (!dense->triangle_wedge)
		return false;
	for (size_t c = 0; c < 3 * dense->triangle_count; c++)
		if (dense->wedge_vertex[dense->triangle_wedge[c]] != dense->triangle[c])
			return fault_set(fault, EX_BAD_INPUT, "%s: face %zu: wedge %" PRIidx " belongs to vertex %" PRIidx ", not to %" PRIidx,
			                 shown, c / 3, dense->triangle_wedge[c], dense->wedge_vertex[dense->triangle_wedge[c]],
			                 dense->triangle[c]);
	return true;
}

static bool read_edges(struct dense *dense, const struct ply *ply, const char *shown, struct fault *fault)
{
	const struct ply_element *edge = ply_want_element(ply, "edge", shown, fault);
	if (!edge)
		return false;
	dense->edge_count = edge->count;
	dense->edge = mem_array(edge->count, sizeof *dense->edge);
	idx_t *vertex1 = NULL, *vertex2 = NULL, *sharp = NULL;
	double *angle = NULL;
	bool good = false;
	if ((vertex1 = ply_index_scalar(edge, "vertex1", 0, (long long)dense->vertex_count, shown, fault)) &&
	    (vertex2 = ply_index_scalar(edge, "vertex2", 0, (long long)dense->vertex_count, shown, fault)) &&
	    (sharp = ply_index_scalar(edge, "sharp", EDGE_SHARP, EDGE_CUT + 1, shown, fault)) &&
	    (angle = ply_numbers(edge, "angle", shown, fault))) {
		good = true;
		for (size_t e = 0; good && e < edge->count; e++) {
			if (vertex1[e] == vertex2[e])
				good = fault_set(fault, EX_BAD_INPUT, "%s: edge %zu: both ends are vertex %" PRIidx, shown, e, vertex1[e]);
			dense->edge[e] = (struct dense_edge){vertex1[e], vertex2[e], angle[e], (enum edge_kind)sharp[e]};
		}
	}
	free(vertex1);
	free(vertex2);
	free(sharp);
	free(angle);
	return good;
}

static bool read_patches(struct dense *dense, const struct ply *ply, const char *shown, struct fault *fault)
{
	const struct ply_element *patch = ply_want_element(ply, "patch", shown, fault);
	if (!patch)
		return false;
	const size_t count = patch->count;
	dense->patch_count = count;
	idx_t *id = NULL, *kind = NULL, *parent = NULL;
	double *point = NULL, *axis = NULL, *radius = NULL, *radius2 = NULL, *sign = NULL, *area = NULL, *residual = NULL;
	bool good = false;
	if ((id = ply_index_scalar(patch, "id", 0, (long long)count, shown, fault)) &&
	    (kind = ply_index_scalar(patch, "kind", 0, PATCH_KIND_COUNT, shown, fault)) &&
	    (point = ply_triples(patch, point_name, shown, fault)) &&
	    (axis = ply_triples(patch, axis_name, shown, fault)) &&
	    (radius = ply_numbers(patch, "radius", shown, fault)) &&
	    (radius2 = ply_numbers(patch, "radius2", shown, fault)) &&
	    (sign = ply_numbers(patch, "sign", shown, fault)) &&
	    (area = ply_numbers(patch, "area", shown, fault)) &&
	    (residual = ply_numbers(patch, "residual", shown, fault)) &&
	    (parent = ply_index_scalar(patch, "parent", 0, (long long)INDEX_LIMIT, shown, fault))) {
		good = true;
		dense->patch = mem_array(count, sizeof *dense->patch);
		for (size_t p = 0; good && p < count; p++) {
			if ((size_t)id[p] != p)
				good = fault_set(fault, EX_BAD_INPUT, "%s: patch %zu: id %" PRIidx " is out of order", shown, p, id[p]);
			dense->patch[p] = (struct dense_patch){
				.kind = (enum patch_kind)kind[p],
				.point = {point[3 * p], point[3 * p + 1], point[3 * p + 2]},
				.axis = {axis[3 * p], axis[3 * p + 1], axis[3 * p + 2]},
				.radius = radius[p],
				.radius2 = radius2[p],
				.sign = sign[p],
				.area = area[p],
				.residual = residual[p],
				.parent = parent[p],
			};
		}
	}
	free(id);
	free(kind);
	free(parent);
	free(point);
	free(axis);
	free(radius);
	free(radius2);
	free(sign);
	free(area);
	free(residual);
	if (!good)
		return false;
	dense->label = ply_index_scalar(ply_element(ply, "face"), "patch", 0, (long long)count, shown, fault);
	return dense->label != NULL;
}

bool dense_from_ply(struct dense *dense, const struct ply *ply, bool want_labels, const char *shown, struct fault *fault)
{
	*dense = (struct dense){0};
	bool good = read_triangles(dense, ply, shown, fault) && read_wedges(dense, ply, shown, fault) &&
	            read_edges(dense, ply, shown, fault);
	if (good) {
		const bool has_labels = ply_element(ply, "patch") || ply_column(ply_element(ply, "face"), "patch");
		if (want_labels || has_labels)
			good = read_patches(dense, ply, shown, fault);
	}
	if (!good)
		dense_free(dense);
	return good;
}

static void put_numbers(struct ply_element *element, const char *name, const double *value)
{
	memcpy(ply_put_scalar(element, name, PLY_FLOAT64), value, element->count * sizeof *value);
}

static void put_triples(struct ply_element *face, const char *name, const idx_t *index)
{
	size_t *start = mem_array(face->count + 1, sizeof *start);
	for (size_t f = 0; f <= face->count; f++)
		start[f] = 3 * f;
	ply_put_index_lists(face, name, start, index);
	free(start);
}

static void put_edges(struct ply *ply, const struct dense *dense)
{
	struct ply_element *edge = ply_put_element(ply, "edge", dense->edge_count);
	double *vertex1 = ply_put_scalar(edge, "vertex1", PLY_INT32);
	double *vertex2 = ply_put_scalar(edge, "vertex2", PLY_INT32);
	double *angle = ply_put_scalar(edge, "angle", PLY_FLOAT64);
	double *sharp = ply_put_scalar(edge, "sharp", PLY_UINT8);
	for (size_t e = 0; e < dense->edge_count; e++) {
		vertex1[e] = dense->edge[e].vertex1;
		vertex2[e] = dense->edge[e].vertex2;
		angle[e] = dense->edge[e].angle_deg;
		sharp[e] = dense->edge[e].kind;
	}
}

static void put_patches(struct ply *ply, const struct dense *dense)
{
	struct ply_element *patch = ply_put_element(ply, "patch", dense->patch_count);
	double *id = ply_put_scalar(patch, "id", PLY_INT32);
	double *kind = ply_put_scalar(patch, "kind", PLY_UINT8);
	double *point[3], *axis[3];
	for (int k = 0; k < 3; k++)
		point[k] = ply_put_scalar(patch, point_name[k], PLY_FLOAT64);
	for (int k = 0; k < 3; k++)
		axis[k] = ply_put_scalar(patch, axis_name[k], PLY_FLOAT64);
	double *radius = ply_put_scalar(patch, "radius", PLY_FLOAT64);
	double *radius2 = ply_put_scalar(patch, "radius2", PLY_FLOAT64);
	double *sign = ply_put_scalar(patch, "sign", PLY_FLOAT64);
	double *area = ply_put_scalar(patch, "area", PLY_FLOAT64);
	double *residual = ply_put_scalar(patch, "residual", PLY_FLOAT64);
	double *parent = ply_put_scalar(patch, "parent", PLY_INT32);
	for (size_t p = 0; p < dense->patch_count; p++) {
		const struct dense_patch *from = &dense->patch[p];
		id[p] = (double)p;
		kind[p] = from->kind;
		for (int k = 0; k < 3; k++) {
			point[k][p] = from->point[k];
			axis[k][p] = from->axis[k];
		}
		radius[p] = from->radius;
		radius2[p] = from->radius2;
		sign[p] = from->sign;
		area[p] = from->area;
		residual[p] = from->residual;
		parent[p] = from->parent;
	}
}

void dense_to_ply(struct ply *ply, const struct dense *dense)
{
	ply_put_points(ply_put_element(ply, "vertex", dense->vertex_count), dense->xyz);
	struct ply_element *face = ply_put_element(ply, "face", dense->triangle_count);
	put_triples(face, "vertex_indices", dense->triangle);
	put_triples(face, "wedge_indices", dense->triangle_wedge);
	struct ply_element *wedge = ply_put_element(ply, "wedge", dense->wedge_count);
	ply_put_indices(wedge, "vertex", PLY_INT32, dense->wedge_vertex);
	ply_put_triples(wedge, wedge_normal_name, dense->wedge_normal);
	put_numbers(wedge, "kmin", dense->kmin);
	put_numbers(wedge, "kmax", dense->kmax);
	ply_put_triples(wedge, dmin_name, dense->dmin);
	put_numbers(wedge, "anisotropy", dense->anisotropy);
	double *quality = ply_put_scalar(wedge, "quality", PLY_UINT8);
	for (size_t w = 0; w < dense->wedge_count; w++)
		quality[w] = dense->quality[w];
	put_edges(ply, dense);
	if (dense->label && dense->patch)
		dense_labels_to_ply(ply, dense);
}

void dense_labels_to_ply(struct ply *ply, const struct dense *dense)
{
	struct ply_element *face = ply_element(ply, "face");
	if (!face)
		face = ply_put_element(ply, "face", dense->triangle_count);
	ply_put_indices(face, "patch", PLY_INT32, dense->label);
	put_patches(ply, dense);
}
