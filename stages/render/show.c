#include "stages/render/show.h"

#include <stdlib.h>
#include <string.h>

#include "formats/ffx.h"
#include "formats/mesh.h"
#include "formats/network.h"

/* Smooth shading across edges that bend less; more is drawn as an edge. Coarse tessellations of round things bend by up to
 * 30 degrees (twelve sides), the blunt edges of parts by 40 and more. */
#define CREASE_DEG 35

static const struct colour plain = {186, 198, 210};
static const struct colour thin = {70, 75, 80};

static bool show_foreign(struct scene *scene, const struct input *input, const struct show_options *options, struct fault *fault)
{
	if (options->colouring == COLOUR_PATCH || options->colouring == COLOUR_CURVATURE)
		return fault_set(fault, EX_BAD_INPUT, "%s: a plain mesh has no %s to colour by", input->shown,
		                 options->colouring == COLOUR_PATCH ? "patches" : "curvatures");
	struct mesh mesh;
	struct trimesh surface;
	if (!mesh_read(&mesh, input, fault) || !trimesh_from_mesh(&surface, &mesh, input->shown, fault))
		return false;
	scene_set_surface(scene, surface.mesh.xyz, surface.mesh.vertex_count, surface.triangle, surface.triangle_count, plain);
	scene_smooth(scene, CREASE_DEG, NULL, 0);
	scene_add_features(scene, CREASE_DEG, (struct colour){45, 48, 52}, (struct colour){10, 130, 60}, (struct colour){200, 0, 160});
	if (options->edges)
		scene_add_edges(scene, surface.mesh.xyz, surface.mesh.corner, surface.mesh.face_start, surface.mesh.face_count, thin, 0.7f);
	trimesh_free(&surface);
	return true;
}

void show_ghost(struct scene *scene, const struct trimesh *surface)
{
	static const struct colour pale = {226, 231, 236};
	scene_set_surface(scene, surface->mesh.xyz, surface->mesh.vertex_count, surface->triangle, surface->triangle_count, pale);
	scene_smooth(scene, CREASE_DEG, NULL, 0);
}

static bool is_cage(const struct ply *ply)
{
	for (size_t i = 0; i < ply->comment_count; i++)
		if (strncmp(ply->comment[i], "comment cagewright scheme ", 26) == 0)
			return true;
	return false;
}

/* Curves are interpolated at their ends: there the border of a local cage has a corner. */
static bool mark_curve_ends(struct cage *cage, const struct ply *ply, const char *shown, struct fault *fault)
{
	struct network network;
	if (!network_from_ply(&network, ply, "netpoint", shown, fault))
		return false;
	bool done = true;
	for (size_t v = 0; v < cage->vertex_count && done; v++)
		if (cage->net[v] >= 0 && (size_t)cage->net[v] >= network.vertex_count)
			done = fault_set(fault, EX_BAD_INPUT, "%s: vertex %zu is netpoint %d of %zu", shown, v, (int)cage->net[v], network.vertex_count);
		else if (cage->net[v] >= 0 && network.kind[cage->net[v]] != POINT_CREASE)
			cage->corner[v] = 1;
	network_free(&network);
	return done;
}

static bool show_cage_ply(struct scene *scene, const struct ply *ply, const char *shown, const struct show_options *options,
                          struct fault *fault)
{
	struct cage cage;
	if (!cage_from_ply(&cage, ply, shown, fault))
		return false;
	if (cage.net != NULL && ply_element(ply, "netpoint") != NULL && !mark_curve_ends(&cage, ply, shown, fault)) {
		cage_free(&cage);
		return false;
	}
	const bool done = show_cage(scene, &cage, shown, options, fault);
	cage_free(&cage);
	return done && (ply_element(ply, "netpoint") == NULL || show_network(scene, ply, "netpoint", shown, fault));
}

static bool show_packed(struct scene *scene, const struct input *input, const struct show_options *options, struct fault *fault)
{
	struct ffx ffx;
	struct cage cage;
	if (!ffx_decode(&ffx, input->data, input->size, input->shown, fault))
		return false;
	ffx_to_cage(&cage, &ffx);
	struct show_options shown = *options;
	const bool has_patches = ffx.face_patch != NULL;
	if (!has_patches && shown.colouring == COLOUR_AUTO)
		shown.colouring = COLOUR_SHADED;
	ffx_free(&ffx);
	if (!has_patches && shown.colouring == COLOUR_PATCH) {
		cage_free(&cage);
		return fault_set(fault, EX_BAD_INPUT, "%s: the packed cage has no patches to colour by", input->shown);
	}
	const bool done = show_cage(scene, &cage, input->shown, &shown, fault);
	cage_free(&cage);
	return done;
}

bool show_file(struct scene *scene, const struct input *input, const struct show_options *options, struct fault *fault)
{
	if (ffx_is_stream(input->data, input->size))
		return show_packed(scene, input, options, fault);
	if (input->size < 4 || memcmp(input->data, "ply", 3) != 0)
		return show_foreign(scene, input, options, fault);
	struct ply ply;
	if (!ply_read(&ply, input, fault))
		return false;
	bool done;
	if (ply_element(&ply, "wedge") != NULL)
		done = show_dense(scene, &ply, input->shown, options, fault);
	else if (is_cage(&ply) || ply_element(&ply, "netpoint") != NULL)
		done = show_cage_ply(scene, &ply, input->shown, options, fault);
	else if (ply_element(&ply, "curve") != NULL)
		done = show_network(scene, &ply, "vertex", input->shown, fault);
	else
		done = show_foreign(scene, input, options, fault);
	ply_free(&ply);
	return done;
}
