/* Facets: what is left for patches that no smooth surface of few points follows. */
#ifndef CAGEWRIGHT_FACET_H
#define CAGEWRIGHT_FACET_H

#include <stdbool.h>

#include "stages/fitpatch/rounds.h"

/* When the part is not within its bounds, or folded: patches that are out of bounds or folded become flat faces with creases between
 * them, from their triangles thinned to a share of the bound; points on their borders turn into corners, and more are added where the
 * borders are too coarse for that. Each pass is kept only when the part gets better. Returns whether any was. */
bool facet_rest(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds);

#endif
