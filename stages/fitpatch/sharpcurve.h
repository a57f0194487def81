/* How far the curves of a draft are from the sharp edges of the mesh that they follow. */
#ifndef CAGEWRIGHT_SHARPCURVE_H
#define CAGEWRIGHT_SHARPCURVE_H

#include "stages/fitpatch/joint.h"

/* The distance (model units) that 99 per cent of the length of all sharp and border chains keep to their curves; 0 when there are none.
 * chain_of_curve: the chain that each curve of the draft follows. The distance of surfaces says little of it: where they meet at a wide angle, an
 * edge slides along both. About O(n) in the vertices of the chains. */
double sharpcurve_distance(const struct draft *draft, const struct target *target, const idx_t *chain_of_curve);

#endif
