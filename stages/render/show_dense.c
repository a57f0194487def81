/* Dense meshes of curv, segment and rectify. */
#include <math.h>
#include <stdlib.h>

#include "formats/dense.h"
#include "formats/mesh.h"
#include "stages/geometry/vector.h"
#include "stages/render/show.h"

/* Curvature times the longest side that reaches the end of the colour scale: a fillet of 1 % of the part. */
#define CURVATURE_MOST 100

static const struct colour plain = {186, 198, 210};
static const struct colour thin = {70, 75, 80};

static void colour_patches(struct scene *scene, const struct dense *dense)
{
	for (size_t c = 0; c < 3 * dense->triangle_count; c++)
		scene->colour[c] = palette_patch((size_t)dense->label[c / 3]);
}

/* The sign and, on a scale of asinh so that large and small radii both show, the size of kmax. */
static void colour_curvature(struct scene *scene, const struct dense *dense)
{
	const double side = mesh_bounds(dense->xyz, dense->vertex_count, NULL, NULL);
	for (size_t c = 0; c < 3 * dense->triangle_count; c++) {
		const double k = dense->kmax[dense->triangle_wedge[c]] * side;
		scene->colour[c] = palette_scale(SCALE_DIVERGING, 0.5 + 0.5 * asinh(k) / asinh(CURVATURE_MOST));
	}
	scene->has_legend = true;
	scene->legend_scale = SCALE_DIVERGING;
	scene->legend_low = -CURVATURE_MOST;
	scene->legend_high = CURVATURE_MOST;
	scene->legend_unit = "";
}

static void use_wedge_normals(struct scene *scene, const struct dense *dense)
{
	for (size_t c = 0; c < 3 * dense->triangle_count; c++)
		for (int k = 0; k < 3; k++)
			scene->normal[3 * c + k] = (float)dense->wedge_normal[3 * (size_t)dense->triangle_wedge[c] + k];
}

static void add_feature_lines(struct scene *scene, const struct dense *dense)
{
	static const struct colour of_kind[4] = {{0, 0, 0}, {20, 20, 24}, {10, 130, 60}, {200, 0, 160}};
	for (size_t e = 0; e < dense->edge_count; e++) {
		const struct dense_edge *edge = &dense->edge[e];
		scene_add_line(scene, dense->xyz + 3 * (size_t)edge->vertex1, dense->xyz + 3 * (size_t)edge->vertex2, of_kind[edge->kind],
		               edge->kind == EDGE_SHARP ? 1.6f : 2.4f);
	}
}

bool show_dense(struct scene *scene, const struct ply *ply, const char *shown, const struct show_options *options, struct fault *fault)
{
	struct dense dense;
	const bool want_labels = options->colouring == COLOUR_PATCH;
	if (!dense_from_ply(&dense, ply, want_labels, shown, fault))
		return false;
	scene_set_surface(scene, dense.xyz, dense.vertex_count, dense.triangle, dense.triangle_count, plain);
	use_wedge_normals(scene, &dense);
	if (want_labels || (options->colouring == COLOUR_AUTO && dense.label != NULL))
		colour_patches(scene, &dense);
	else if (options->colouring == COLOUR_CURVATURE)
		colour_curvature(scene, &dense);
	if (options->edges) {
		size_t *face_start = mem_array(dense.triangle_count + 1, sizeof *face_start);
		for (size_t t = 0; t <= dense.triangle_count; t++)
			face_start[t] = 3 * t;
		scene_add_edges(scene, dense.xyz, dense.triangle, face_start, dense.triangle_count, thin, 0.7f);
		free(face_start);
	}
	if (dense.label != NULL)
		scene_add_label_borders(scene, dense.label, (struct colour){50, 50, 60}, 1.2f);
	add_feature_lines(scene, &dense);
	dense_free(&dense);
	return true;
}
