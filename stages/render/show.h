/* From files to scenes: which kind of file it is, and what of it is drawn. */
#ifndef CAGEWRIGHT_SHOW_H
#define CAGEWRIGHT_SHOW_H

#include <stdbool.h>

#include "formats/cage.h"
#include "formats/input.h"
#include "formats/ply.h"
#include "stages/geometry/trimesh.h"
#include "stages/render/scene.h"

enum colouring {
	COLOUR_AUTO,        /* by patch when the file has patches, else shaded */
	COLOUR_SHADED,
	COLOUR_PATCH,
	COLOUR_CURVATURE,   /* of the wedges: kmax, blue concave, red convex */
	COLOUR_DEVIATION,   /* distance to another surface */
};

struct show_options {
	enum colouring colouring;
	bool edges;         /* all edges of the mesh, thin */
	int level;          /* cages: steps of refinement, drawn on the limit surface; 0: the control mesh */
};

/* Fill an empty scene from a file of any kind: dense, network, local cages, cage (PLY of ours), packed cage (.ffx), or a foreign
 * mesh. Colours by deviation are left to show_deviation. Faults: as the readers; a colouring that the file has no data for. */
bool show_file(struct scene *scene, const struct input *input, const struct show_options *options, struct fault *fault);

bool show_dense(struct scene *scene, const struct ply *ply, const char *shown, const struct show_options *options, struct fault *fault);
bool show_network(struct scene *scene, const struct ply *ply, const char *vertex_element, const char *shown, struct fault *fault);
bool show_cage(struct scene *scene, const struct cage *cage, const char *shown, const struct show_options *options, struct fault *fault);

/* A pale surface behind curves: what a network was made from. */
void show_ghost(struct scene *scene, const struct trimesh *surface);

/* Where two surfaces are farthest apart. */
struct show_worst {
	double at[3], normal[3]; /* the point, on the surface that it was found on, and which way that faces there */
	double distance;         /* model units */
	double mean;             /* of the shown surface, by the pieces' corners; model units */
	bool is_missing;         /* found on the other surface: the shown one lacks it */
};

/* Colour the scene's surface by distance to another one, heat scale from 0 to top (model units; 0: the largest distance found both ways),
 * with a ring at the worst point of both directions; the legend is in % of the other one's longest side. Long triangles are cut
 * first, so that the inside of large flat ones shows too. worst may be NULL. Faults: a scene without triangles, a surface without size. */
bool show_deviation(struct scene *scene, const struct trimesh *against, double top, struct show_worst *worst, struct fault *fault);

#endif
