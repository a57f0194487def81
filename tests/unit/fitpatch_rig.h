/* All that a fit of patches needs, made of a labelled mesh of known shape. */
#ifndef CAGEWRIGHT_FITPATCH_RIG_H
#define CAGEWRIGHT_FITPATCH_RIG_H

#include "tests/unit/known_shapes.h"

#include <string.h>

#include "stages/curv/curvature.h"
#include "stages/fitcurves/netfit.h"
#include "stages/fitpatch/local.h"
#include "stages/fitpatch/rounds.h"
#include "stages/geometry/sample.h"

enum { RIG_SAMPLES = 1500 };

struct rig {
	struct dense dense;
	struct half half;
	struct border_network border;
	struct network network;
	struct nearest *nearest, *on_surface;
	idx_t *surface;
	idx_t *chain_of_curve;
	idx_t *name;
	size_t work;
	double *sample;
	idx_t *sample_triangle;
	struct target target;
	struct draft draft;
	struct rounds rounds;
	struct layouts layouts;
};

static inline void rig_quiet(const char *format, ...) { (void)format; }

/* The mesh with curvatures, the patch of every triangle, and patches that know their kind (PATCH_FREE where kinds is NULL), plane
 * and area. */
static inline struct dense rig_dense(const struct mesh *mesh, const idx_t *label, size_t patch_count, const enum patch_kind *kinds)
{
	struct dense dense;
	struct fault fault = {0};
	const struct curvature_options options = {{40 / DEGREES, false}, 0};
	if (!curvature_compute(&dense, NULL, mesh, NULL, 0, &options, &fault))
		fail_msg("%s", fault.text);
	dense.label = mem_copy(label, mesh->face_count, sizeof *label);
	dense.patch = mem_array(patch_count, sizeof *dense.patch);
	dense.patch_count = patch_count;
	for (size_t t = 0; t < dense.triangle_count; t++) {
		const idx_t *v = &dense.triangle[3 * t];
		double area[3];
		area_vector3(area, &dense.xyz[3 * (size_t)v[0]], &dense.xyz[3 * (size_t)v[1]], &dense.xyz[3 * (size_t)v[2]]);
		struct dense_patch *patch = &dense.patch[label[t]];
		patch->area += norm3(area) / 2;
		add_scaled3(patch->axis, 0.5, area);
		copy3(patch->point, &dense.xyz[3 * (size_t)v[0]]);
	}
	for (size_t p = 0; p < patch_count; p++) {
		dense.patch[p].kind = kinds ? kinds[p] : PATCH_FREE;
		dense.patch[p].parent = (idx_t)p;
		normalise3(dense.patch[p].axis);
	}
	return dense;
}

/* Around dense and a network of its own; both belong to the rig from now on. max, mean: bounds, model units. */
static inline void rig_start(struct rig *rig, struct dense dense, struct network network, double max, double mean)
{
	struct fault fault = {0};
	*rig = (struct rig){.dense = dense, .network = network};
	assert_true(half_build_triangles(&rig->half, dense.triangle, dense.triangle_count, dense.vertex_count, &fault));
	assert_true(border_extract(&rig->border, &rig->dense, BORDER_DEFAULTS, &fault));
	rig->nearest = nearest_new_labelled(dense.xyz, dense.vertex_count, dense.triangle, dense.triangle_count, dense.label);
	rig->chain_of_curve = mem_array(network.curve_count, sizeof *rig->chain_of_curve);
	border_match(rig->chain_of_curve, &rig->border, &rig->dense, &rig->network);
	rig->sample = mem_array(3 * RIG_SAMPLES, sizeof *rig->sample);
	rig->sample_triangle = mem_array(RIG_SAMPLES, sizeof *rig->sample_triangle);
	sample_surface(rig->sample, rig->sample_triangle, RIG_SAMPLES, dense.xyz, dense.triangle, dense.triangle_count, 1);
	rig->surface = mem_array(dense.triangle_count, sizeof *rig->surface);
	for (size_t t = 0; t < dense.triangle_count; t++)
		rig->surface[t] = dense.patch[dense.label[t]].parent;
	rig->on_surface = nearest_new_labelled(dense.xyz, dense.vertex_count, dense.triangle, dense.triangle_count, rig->surface);
	rig->target = (struct target){&rig->dense, rig->nearest, rig->surface, rig->on_surface, &rig->border, rig->sample, rig->sample_triangle, RIG_SAMPLES};
	rig->name = mem_array(dense.patch_count, sizeof *rig->name);
	for (size_t p = 0; p < dense.patch_count; p++)
		rig->name[p] = (idx_t)p;
	rig->rounds = (struct rounds){&rig->target, &rig->half, rig->chain_of_curve, {5, 2, SQDIST_SIDED}, {max, mean}, 6, &rig->work, 20000, rig->name, rig_quiet};
	rig->layouts = layouts_new(dense.patch_count, NULL);
	draft_start(&rig->draft, &rig->network);
}

/* The same with curves fitted to the borders within max / 2 and mean / 2, as fitcurves does. */
static inline void rig_make(struct rig *rig, struct dense dense, double max, double mean)
{
	struct border_network border;
	struct fault fault = {0};
	struct network network;
	struct netfit_report report;
	assert_true(border_extract(&border, &dense, BORDER_DEFAULTS, &fault));
	netfit(&network, &report, &dense, &border, (struct netfit_options){.max = max / 2, .mean = mean / 2});
	border_free(&border);
	rig_start(rig, dense, network, max, mean);
}

static inline void rig_free(struct rig *rig)
{
	draft_free(&rig->draft);
	layouts_free(&rig->layouts);
	free(rig->sample), free(rig->sample_triangle), free(rig->chain_of_curve), free(rig->name);
	nearest_free(rig->nearest);
	nearest_free(rig->on_surface);
	free(rig->surface);
	border_free(&rig->border);
	half_free(&rig->half);
	network_free(&rig->network);
	dense_free(&rig->dense);
}

/* Lay out all patches. */
static inline void rig_layout(struct rig *rig)
{
	struct fault fault = {0};
	if (!rounds_layout(&rig->draft, &rig->rounds, &rig->layouts, NULL, &fault))
		fail_msg("%s", fault.text);
}

/* The largest error of any patch, and (may be NULL) the area-weighted mean. */
static inline double rig_error(const struct rig *rig, double *mean)
{
	struct fault fault = {0};
	struct patch_error *error = mem_array(rig->dense.patch_count, sizeof *error);
	if (!joint_measure(error, NULL, rig->dense.patch_count, &rig->draft, &rig->target, &fault))
		fail_msg("%s", fault.text);
	double largest = 0, sum = 0, area = 0;
	for (size_t p = 0; p < rig->dense.patch_count; p++) {
		largest = fmax(largest, error[p].max);
		sum += error[p].mean * rig->dense.patch[p].area, area += rig->dense.patch[p].area;
	}
	free(error);
	if (mean)
		*mean = sum / area;
	return largest;
}

/* The faces of a draft are an oriented manifold without repeated corners; returns V - E + F, and in *border (may be NULL) the
 * number of edges with one face. */
static inline long rig_check_draft(const struct draft *draft, size_t *border)
{
	struct cage cage;
	idx_t *vertex_of;
	struct half half;
	struct fault fault = {0};
	draft_cage(&cage, &vertex_of, draft);
	if (!half_build(&half, cage.face_corner, cage.face_start, cage.face_count, cage.vertex_count, &fault))
		fail_msg("%s", fault.text);
	const long euler = (long)cage.vertex_count - (long)half_edge_count(&half) + (long)cage.face_count;
	if (border) {
		*border = 0;
		for (size_t h = 0; h < half.half_count; h++)
			*border += half.twin[h] == NO_INDEX;
	}
	half_free(&half);
	cage_free(&cage);
	free(vertex_of);
	return euler;
}

/* Every side of every curve is an edge of some face, so that it can be a crease. */
static inline void rig_check_curves(const struct draft *draft)
{
	const struct polygons *p = &draft->polygons;
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		const struct curve *curve = &draft->network.curve[k];
		const idx_t *point = &draft->network.point[curve->first];
		for (size_t i = 0; i + !curve->closed < curve->count; i++) {
			const idx_t a = point[i], b = point[(i + 1) % curve->count];
			bool found = false;
			for (size_t f = 0; f < p->count && !found; f++)
				for (size_t h = p->start[f]; h < p->start[f + 1]; h++) {
					const idx_t c = p->corner[h], d = p->corner[h + 1 < p->start[f + 1] ? h + 1 : p->start[f]];
					found |= (c == a && d == b) || (c == b && d == a);
				}
			if (!found)
				fail_msg("curve %zu: no face has the side %d %d", k, (int)a, (int)b);
		}
	}
}

/* Faces of a patch; corners (may be NULL) becomes the corner count that all share, 0 when they differ. */
static inline size_t rig_faces(const struct draft *draft, idx_t patch, size_t *corners)
{
	size_t count = 0, shared = 0;
	for (size_t f = 0; f < draft->polygons.count; f++) {
		if (draft->polygons.patch[f] != patch)
			continue;
		const size_t n = draft->polygons.start[f + 1] - draft->polygons.start[f];
		shared = count == 0 || shared == n ? n : 0;
		count++;
	}
	if (corners)
		*corners = shared;
	return count;
}

/* Shapes with labels. A closed cylinder: side 0, lower cap 1, upper cap 2. */
static inline struct dense rig_cylinder(double radius, double height, int facets, int rings)
{
	struct mesh mesh = shape_cylinder(radius, height, facets, rings);
	idx_t *label = mem_array(mesh.face_count, sizeof *label);
	for (size_t t = 0; t < mesh.face_count; t++)
		label[t] = t < 2 * (size_t)(facets * rings) ? 0 : t < (size_t)(2 * facets * rings + facets) ? 1 : 2;
	const enum patch_kind kinds[3] = {PATCH_CYLINDER, PATCH_PLANE, PATCH_PLANE};
	struct dense dense = rig_dense(&mesh, label, 3, kinds);
	free(label);
	shape_free(&mesh);
	return dense;
}

static inline struct dense rig_box(double x, double y, double z)
{
	struct mesh mesh = shape_box(x, y, z);
	idx_t label[12];
	enum patch_kind kinds[6];
	for (int t = 0; t < 12; t++)
		label[t] = t / 2, kinds[t / 2] = PATCH_PLANE;
	struct dense dense = rig_dense(&mesh, label, 6, kinds);
	shape_free(&mesh);
	return dense;
}

/* The same part turned, moved and scaled (shape_turn). */
static inline struct dense rig_turned(const struct dense *dense, double scale)
{
	struct mesh mesh = {0};
	for (size_t v = 0; v < dense->vertex_count; v++)
		shape_vertex(&mesh, dense->xyz[3 * v], dense->xyz[3 * v + 1], dense->xyz[3 * v + 2]);
	for (size_t t = 0; t < dense->triangle_count; t++)
		shape_triangle(&mesh, dense->triangle[3 * t], dense->triangle[3 * t + 1], dense->triangle[3 * t + 2]);
	shape_turn(&mesh, scale);
	enum patch_kind *kinds = mem_array(dense->patch_count, sizeof *kinds);
	for (size_t p = 0; p < dense->patch_count; p++)
		kinds[p] = dense->patch[p].kind;
	struct dense turned = rig_dense(&mesh, dense->label, dense->patch_count, kinds);
	for (size_t p = 0; p < dense->patch_count; p++)
		turned.patch[p].parent = dense->patch[p].parent;
	free(kinds);
	shape_free(&mesh);
	return turned;
}

/* An open sheet over [0, 1]^2 of n x n squares of two triangles, one patch; place turns u, v into a point. */
static inline struct dense rig_sheet(int n, enum patch_kind kind, void (*place)(double xyz[3], double u, double v))
{
	struct mesh mesh = {0};
	for (int j = 0; j <= n; j++)
		for (int i = 0; i <= n; i++) {
			double p[3];
			place(p, (double)i / n, (double)j / n);
			shape_vertex(&mesh, p[0], p[1], p[2]);
		}
	for (int j = 0; j < n; j++)
		for (int i = 0; i < n; i++) {
			const idx_t a = j * (n + 1) + i, b = a + n + 1;
			shape_quad(&mesh, a, a + 1, b + 1, b);
		}
	idx_t *label = mem_array(mesh.face_count, sizeof *label);
	struct dense dense = rig_dense(&mesh, label, 1, &kind);
	free(label);
	shape_free(&mesh);
	return dense;
}

/* A sphere of n x n squares on each side of a cube, two triangles each; the sides are patches of one surface. */
static inline struct dense rig_ball(double radius, int n)
{
	struct mesh mesh = {0};
	for (int side = 0; side < 6; side++) {
		const idx_t first = (idx_t)mesh.vertex_count;
		const int axis = side / 2, sign = side % 2 ? 1 : -1;
		for (int j = 0; j <= n; j++)
			for (int i = 0; i <= n; i++) {
				double p[3];
				p[axis] = sign;
				p[(axis + 1) % 3] = tan(PI / 4 * (2.0 * i / n - 1));
				p[(axis + 2) % 3] = tan(PI / 4 * (2.0 * j / n - 1)) * sign;
				normalise3(p);
				shape_vertex(&mesh, radius * p[0], radius * p[1], radius * p[2]);
			}
		for (int j = 0; j < n; j++)
			for (int i = 0; i < n; i++) {
				const idx_t a = first + j * (n + 1) + i, b = a + n + 1;
				shape_quad(&mesh, a, a + 1, b + 1, b);
			}
	}
	mesh_weld(&mesh, 1e-9 * radius, NULL);
	idx_t *label = mem_array(mesh.face_count, sizeof *label);
	for (size_t t = 0; t < mesh.face_count; t++)
		label[t] = (idx_t)(t / (2 * (size_t)(n * n)));
	const enum patch_kind kinds[6] = {PATCH_SPHERE, PATCH_SPHERE, PATCH_SPHERE, PATCH_SPHERE, PATCH_SPHERE, PATCH_SPHERE};
	struct dense dense = rig_dense(&mesh, label, 6, kinds);
	for (int p = 0; p < 6; p++)
		dense.patch[p].parent = 0;
	free(label);
	shape_free(&mesh);
	return dense;
}

/* A square plate without thickness, side 4, with a square hole of side 2 in its middle; one plane patch. */
static inline struct dense rig_square_ring(void)
{
	struct mesh mesh = {0};
	for (int j = 0; j <= 4; j++)
		for (int i = 0; i <= 4; i++)
			shape_vertex(&mesh, i, j, 0);
	for (int j = 0; j < 4; j++)
		for (int i = 0; i < 4; i++)
			if (i == 0 || j == 0 || i == 3 || j == 3) {
				const idx_t a = j * 5 + i;
				shape_quad(&mesh, a, a + 1, a + 6, a + 5);
			}
	/* the middle vertex has no triangle: the last takes its place */
	struct mesh tight = {0};
	for (idx_t v = 0; v < 25; v++)
		if (v != 12)
			shape_vertex(&tight, mesh.xyz[3 * v], mesh.xyz[3 * v + 1], 0);
	for (size_t t = 0; t < mesh.face_count; t++) {
		idx_t c[3];
		for (int k = 0; k < 3; k++)
			c[k] = mesh.corner[3 * t + (size_t)k] - (mesh.corner[3 * t + (size_t)k] > 12);
		shape_triangle(&tight, c[0], c[1], c[2]);
	}
	const enum patch_kind kind = PATCH_PLANE;
	idx_t *label = mem_array(tight.face_count, sizeof *label);
	struct dense dense = rig_dense(&tight, label, 1, &kind);
	free(label);
	shape_free(&mesh);
	shape_free(&tight);
	return dense;
}

#endif
