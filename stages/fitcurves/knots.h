/* Arc lengths at which the knots of a curve begin (the patch method's section 4.3). */
#ifndef CAGEWRIGHT_KNOTS_H
#define CAGEWRIGHT_KNOTS_H

#include <stddef.h>

#include "stages/fitcurves/polyline.h"

/* count knots (open: the ends included) spread evenly by the root of curvature plus a share of length; spans at open ends are
 * half as long. side: longest side of the part, the scale of resampling. */
void knots_spread(double *arc, const struct polyline *line, double side, size_t count);

/* Knots at the prominent maxima of curvature, then in the largest gaps until there are enough: an inner knot for every 60 degrees
 * of turning, closed curves (2.3 radius / max)^(1/4) but at least 4. Returns their number, at most room (>= 64); open: ends
 * included. */
size_t knots_start(double *arc, size_t room, const struct polyline *line, double side, double max);

#endif
