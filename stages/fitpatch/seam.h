/* Seams: chords of plane patches that must be creases, or the faces beside them fold. */
#ifndef CAGEWRIGHT_SEAM_H
#define CAGEWRIGHT_SEAM_H

#include "stages/fitpatch/joint.h"

/* Find the seams of the draft as its faces are now, in place of those that it had. The smooth rule puts the middle of a chord half-way to
 * the middles of its two faces; where a plane runs around an inward corner, in a strip or frame, that is off the faces. A crease
 * between two corners stays where it is and costs no shape, as the faces lie in one plane. Patches with all[patch] != 0 get creases on
 * all chords, though that makes corners of the points on smooth borders. O(n log n). */
void seams_find(struct draft *draft, const struct dense *dense, const unsigned char *all);

#endif
