/* Another place for the search to begin: the dense mesh itself, collapsed to few triangles. */
#ifndef CAGEWRIGHT_START_H
#define CAGEWRIGHT_START_H

#include "stages/polish/search.h"

/* Collapse the target's edges (quadrics; sharp edges collapse along themselves) to the coarsest of a row of triangle counts whose fitted
 * surface has a mean distance of at most most_mean (most_mean_large from a third of most_vertices on), and at most most_vertices vertices. Edges that bend by about sharp_deg and run along sharp
 * edges of the target are creases. False, and nothing to free, when the target is no oriented manifold or no count will do.
 * O(n log n) in the target's triangles, once; the rest depends on most_vertices. */
bool start_collapsed(struct candidate *candidate, enum cage_scheme scheme, const struct judge *judge, double most_mean, double most_mean_large,
                     size_t most_vertices, double sharp_deg);

#endif
