/* More control points where the error is too large. */
#ifndef CAGEWRIGHT_ENRICH_H
#define CAGEWRIGHT_ENRICH_H

#include "stages/fitpatch/joint.h"

/* What a patch asks for. */
enum want {
	WANT_NOTHING,
	WANT_INSIDE, /* points where the error is */
	WANT_BORDER, /* a point on the border nearest to the error, or to the fold when there is one: the borders decide (planes),
	                or hold each other's control polygons crossed (folds) */
};

/* Refine the draft in the patches that want it (want[patch]), at the faces whose distance is above floor, the worst
 * first, at most one step a face and round. A quad is cut across the direction in which the target bends more, and with it the whole strip of
 * quads that it lies in, up to faces that can take one more corner; a triangle at its longest edge; a polygon gets a point in its
 * middle. Sets touched[patch] where faces changed. Returns the number of steps taken. */
size_t enrich(struct draft *draft, const struct target *target, const struct patch_error *error, const struct face_error *face_error,
              const unsigned char *want, double floor, unsigned char *touched);

#endif
