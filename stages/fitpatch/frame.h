/* What the dense mesh knows at a point of a triangle: normal and curvature. */
#ifndef CAGEWRIGHT_FRAME_H
#define CAGEWRIGHT_FRAME_H

#include "formats/dense.h"
#include "stages/geometry/nearest.h"

struct frame {
	double normal[3];    /* unit, wedge normals interpolated */
	double e1[3];        /* unit tangent: direction of k1; any tangent where the surface is isotropic */
	double k1, k2;       /* |k1| <= |k2|, convex > 0, 1 / unit of the mesh */
	double anisotropy;   /* [0, 1]: how much e1 can be trusted */
};

/* Nearest point of one patch. */
struct foot frame_foot(const struct nearest *nearest, const struct dense *dense, idx_t patch, const double p[3]);

/* Curvature tensors of the three wedges are interpolated, then decomposed: interpolated directions would cancel where they
 * differ in sign only (the patch method's section 5.4). */
void frame_at(struct frame *frame, const struct dense *dense, const struct foot *foot);

#endif
