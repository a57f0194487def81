/* Masks of one subdivision step and of the limit (the patch method's sections 9.1 and 9.2). Private to subdivision. */
#ifndef CAGEWRIGHT_SUBDIVIDE_MASK_H
#define CAGEWRIGHT_SUBDIVIDE_MASK_H

#include <stddef.h>

/* The rule of an old vertex in one step, written as  v' = v + beta * (sum - count * v).
 *
 * In every scheme here the old vertices around v and the centroids of the faces at v that become quads have one and the
 * same weight beta, so that a single sum over both is enough: smooth: over edge neighbours and such centroids; crease: over
 * its two neighbours along the crease; corner: beta = 0. */
struct step_mask {
	double beta, count;
};

struct step_mask step_mask_corner(void);
struct step_mask step_mask_crease(void);
/* Smooth or dart: edges at the vertex (>= 2) and, among its faces, those that are split into quads. Triangles only: Loop 1987;
 * quads only: Catmull and Clark 1978; mixed: Stam and Loop 2003 with the correction of bounded curvature at low valence. */
struct step_mask step_mask_smooth(size_t edges, size_t quads);

#endif
