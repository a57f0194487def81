/* Cleaning a raw mesh into an oriented manifold of triangles, with a count of every repair (the patch method's section 0.5). */
#ifndef CAGEWRIGHT_REPAIR_H
#define CAGEWRIGHT_REPAIR_H

#include <stdio.h>

#include "formats/mesh.h"

struct repair_options {
	double weld_relative;   /* of the diagonal, used only where exact welding leaves borders; 0: exact only. Default 1e-6 */
};

enum repair_kind {
	REPAIR_POLYGON_TRIANGULATED, REPAIR_WELDED_EXACT, REPAIR_WELDED_NEAR, REPAIR_COLLAPSED_FACE, REPAIR_DUPLICATE_FACE,
	REPAIR_ZERO_AREA_FACE, REPAIR_CAP_FLIPPED, REPAIR_T_JUNCTION_SPLIT, REPAIR_NONMANIFOLD_EDGE_CUT, REPAIR_NONMANIFOLD_VERTEX_SPLIT,
	REPAIR_FACE_FLIPPED, REPAIR_MOEBIUS_CUT, REPAIR_COMPONENT_TURNED, REPAIR_UNUSED_VERTEX, REPAIR_KIND_COUNT
};
extern const char *const repair_name[REPAIR_KIND_COUNT];   /* "polygon triangulated", ... */
extern const char *const repair_plural[REPAIR_KIND_COUNT]; /* "polygons triangulated", ... */

struct repair_component {
	size_t vertices, edges, faces, border_loops;
	long euler;
	long genus;             /* (2 - border_loops - euler) / 2 */
	double volume;          /* signed; only meaningful when border_loops is 0 */
};

struct repair_report {
	size_t count[REPAIR_KIND_COUNT];
	struct repair_component *component;
	size_t component_count;
	idx_t *cut;             /* 2 * cut_count vertex pairs of the clean mesh: edges opened by non-manifold or Moebius cuts */
	size_t cut_count;
};
void repair_report_free(struct repair_report *report);

/* mesh becomes triangles, manifold, consistently oriented, closed components with positive volume. A component inside an odd
 * number of others keeps its orientation (negative: a void; positive: a body in a body); when it had none of its own, it
 * becomes a void. When the result is what went in, all counts are 0. Vertices keep their order; copies made by cuts come last. Faults: nothing left. O(n log n). */
bool repair_mesh(struct mesh *mesh, const struct repair_options *options, struct repair_report *report, struct fault *fault);

#endif
