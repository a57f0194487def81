/* What somebody who unpacks a cage gets: the refined mesh, measured and looked over. */
#ifndef CAGEWRIGHT_DECODED_H
#define CAGEWRIGHT_DECODED_H

#include "formats/cage.h"
#include "stages/polish/judge.h"

/* Distances in longest sides as deviate(1) measures them; shares of the area: what looks away from the target (folded_share of deviate), and what
 * looks away from the part of the surface that it belongs to. */
struct decoded_errors {
	double mean, max, turned, folded;
};

/* Refine a cage of model = middle + scale * x steps times, 1 to 6, and measure it against the target. False when it cannot be refined, or is another
 * surface when it is written as single triangles in single precision: points of different faces that fall together open or join edges.
 * takes_unsound: that does not matter. O(n log n) in the refined faces and the target's triangles. */
bool decoded_measure(struct decoded_errors *errors, const struct target *target, const struct cage *cage, int steps, const double middle[3], double scale,
                     bool takes_unsound);

#endif
