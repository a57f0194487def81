/* Mending what rounding laid together: vertices at one grid point, and edges that leave a vertex in one direction, as those of a
 * face without area do, and faces folded onto their neighbours. Refined, edges of such faces would lie on each other, and the
 * surface would not be watertight. */
#ifndef CAGEWRIGHT_GRIDMEND_H
#define CAGEWRIGHT_GRIDMEND_H

#include <stddef.h>

#include "formats/cage.h"
#include "formats/ffx.h"

/* Pairs of edges at a vertex that leave it in the same direction on the grid, plus vertices at a grid point where another one is,
 * plus edges whose two faces lie on each other in one plane (seen at either end). Not counted: vertices that were at one place in
 * *cage, and pairs of edges to them. O(n log n) where no vertex has a large share of all edges. */
size_t gridmend_count(const struct ffx *ffx, const struct cage *cage);

struct gridmend_report {
	size_t found; /* pairs before */
	size_t moved; /* moves of a vertex to a neighbour of its grid point */
	size_t left;  /* pairs that no move mended */
};

/* Move vertices of *ffx, a rounding of *cage, one grid point on (26 neighbours, to less than 2 steps from the exact value in each
 * coordinate) so that no such pairs are left: each time the move that leaves fewest pairs around it, and of those the one
 * nearest to the exact place. A move that turns over a sub-quad with sides of small (model units; see gridfit_check) or more is
 * not made. Eight passes at most. */
void gridmend(struct ffx *ffx, struct gridmend_report *report, const struct cage *cage, double small);

#endif
