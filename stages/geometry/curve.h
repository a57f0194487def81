/* Subdivision curves: uniform cubic B-splines, natural at ends (the patch method's section 4.2). */
#ifndef CAGEWRIGHT_CURVE_H
#define CAGEWRIGHT_CURVE_H

#include <stdbool.h>
#include <stddef.h>

/* Limit position of control point i of count: (1, 4, 1) / 6 inside and on closed curves, the point itself at the ends. */
void curve_limit(double out[3], const double *points, size_t count, bool closed, size_t i);

/* Position at parameter u in [0, count - 1] (closed: [0, count)), knots at whole numbers = limits of the control points. */
void curve_point(double out[3], const double *points, size_t count, bool closed, double u);

/* The up to four weights behind curve_point: index[k], weight[k]; returns how many. */
size_t curve_row(size_t index[4], double weight[4], size_t count, bool closed, double u);

#endif
