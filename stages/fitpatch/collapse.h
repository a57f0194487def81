/* Cages by edge collapse: the other way to a layout, for what no patch of few points follows. */
#ifndef CAGEWRIGHT_COLLAPSE_H
#define CAGEWRIGHT_COLLAPSE_H

#include "stages/fitpatch/rounds.h"

/* The dense mesh by edge collapses along and between its borders, which stay curves, within a root-mean-square distance to the planes of
 * its triangles (Garland and Heckbert 1997; model units). Control points are vertices of the mesh, nodes among them, faces its
 * triangles. False with a fault when the mesh is refused. O(n log n). */
bool collapse_draft(struct draft *draft, const struct rounds *rounds, double distance, struct fault *fault);

/* Cages by collapse, from coarse to fine, until one is within the bounds or none can be smaller than the draft that is. It takes the place of the draft (and error, layouts) when that was not, or has more points. What
 * is never within them becomes the collapsed mesh itself, all of it facets. Returns which of these the draft is now. */
enum collapse { COLLAPSE_NONE, COLLAPSE_SMOOTH, COLLAPSE_FACETS };
enum collapse collapse_try(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds);

#endif
