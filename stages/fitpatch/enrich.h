/* More control points where the error is too large. */
#ifndef CAGEWRIGHT_ENRICH_H
#define CAGEWRIGHT_ENRICH_H

#include "stages/fitpatch/joint.h"

/* Refine the draft in the patches that want it (want[patch] != 0), at the faces whose face_error is above floor, the worst
 * first, at most one step a face and round. A quad is cut across the direction in which the target bends more, and with it the whole strip of
 * quads that it lies in, up to faces that can take one more corner; a triangle at its longest edge; a polygon gets a point in its
 * middle, or, on a plane, one on the border side nearest to the error. Returns the number of steps taken. */
size_t enrich(struct draft *draft, const struct target *target, const struct patch_error *error, const double *face_error,
              const unsigned char *want, double floor);

#endif
