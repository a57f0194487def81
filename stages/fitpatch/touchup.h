/* Touching up: the last patches that are out of bounds or folded, one at a time. */
#ifndef CAGEWRIGHT_TOUCHUP_H
#define CAGEWRIGHT_TOUCHUP_H

#include "stages/fitpatch/rounds.h"

/* A round of refinement moves all points, and may spoil elsewhere what it mends here. Here one patch, the worst, gets another layout or
 * more points, and only the points of the patches concerned move; of several ways the best is kept, when the part gets better by it.
 * On until nothing is out of bounds or folded, no way helps, or the work is used up; parts that are far out of bounds are left alone.
 * error is kept up to date. */
void touch_up(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds);

#endif
