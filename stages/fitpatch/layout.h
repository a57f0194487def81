/* The initial control polygons of every patch, over the control points of the network and as few others as possible. */
#ifndef CAGEWRIGHT_LAYOUT_H
#define CAGEWRIGHT_LAYOUT_H

#include <stdbool.h>

#include "formats/dense.h"
#include "formats/fault.h"
#include "stages/fitpatch/anchor.h"
#include "stages/fitpatch/chord.h"
#include "stages/geometry/nearest.h"

/* Control points of the whole cage: those of the network first, then the ones inside patches. */
struct control {
	double *xyz;
	unsigned char *role; /* enum point_kind for points of the network, POINT_INSIDE within patches */
	unsigned char *held; /* 1 for points of a curve that a person moved: they stay */
	size_t count, capacity;
};
#define POINT_INSIDE 255
idx_t control_add(struct control *control, const double xyz[3], unsigned char role);
void control_free(struct control *control);

/* Control faces of the whole cage over control points. */
struct polygons {
	idx_t *corner;
	size_t *start; /* count + 1 */
	idx_t *patch;
	size_t count, capacity, corner_capacity;
};
void polygons_init(struct polygons *polygons);
void polygons_add(struct polygons *polygons, const idx_t *corner, size_t count, idx_t patch);
/* Sort by patch, stable: the faces of a patch lie together. */
void polygons_by_patch(struct polygons *polygons, size_t patch_count);
void polygons_free(struct polygons *polygons);

/* How a patch was laid out, for the report. */
enum layout_kind { LAYOUT_FACE, LAYOUT_BAND, LAYOUT_GRID, LAYOUT_DOME, LAYOUT_CHORDS, LAYOUT_KIND_COUNT };

struct layout_context {
	const struct dense *dense;
	const idx_t *dense_twin;
	const struct nearest *nearest;
	const struct anchors *anchors;
	double tolerance;              /* largest distance, model units */
	double flat;                   /* a polygon this flat is plane, model units */
	const unsigned char *detail;   /* a patch: 0: no points inside but those that topology asks for; n: the triangles before the merge
	                                  follow the patch within 16 * tolerance / 2^n; planes: 0 large faces, 1 convex ones, 2 and creases between all */
	const unsigned char *faceted;  /* a patch: 1: its faces will be flat, with creases between them */
	const idx_t *name;             /* what people call each patch */
	struct edge_set *taken;        /* edges of the curves and of the patches done so far */
	struct control *control;
	struct polygons *polygons;
};

/* Lay out one patch given by its triangles. Faults (EX_BAD_INPUT) name the patch: a border loop with fewer than three
 * control points, or border vertices that cannot be taken out. */
bool layout_patch(enum layout_kind *kind, struct layout_context *context, idx_t patch, const idx_t *list, size_t count, struct fault *fault);

#endif
