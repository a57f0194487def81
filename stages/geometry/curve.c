/* Subdivision curves: midpoints and (1, 6, 1) / 8, which is the uniform cubic B-spline; a phantom point 2 P0 - P1 before
 * an end makes the curve interpolate it, with second derivative zero there. */
#include "stages/geometry/curve.h"

#include <math.h>

/* Add weight to the entry of point i, appending it when it is new. */
static size_t put(size_t index[4], double weight[4], size_t used, size_t i, double w)
{
	if (w == 0)
		return used;
	for (size_t k = 0; k < used; k++)
		if (index[k] == i) {
			weight[k] += w;
			return used;
		}
	index[used] = i;
	weight[used] = w;
	return used + 1;
}

/* The same for point i of the extended polygon: -1 and count are phantoms of an open curve. */
static size_t put_extended(size_t index[4], double weight[4], size_t used, size_t count, bool closed, ptrdiff_t i, double w)
{
	const ptrdiff_t n = (ptrdiff_t)count;
	if (closed)
		return put(index, weight, used, (size_t)(((i % n) + n) % n), w);
	if (i >= 0 && i < n)
		return put(index, weight, used, (size_t)i, w);
	const size_t end = i < 0 ? 0 : count - 1, inner = i < 0 ? 1 : count - 2;
	used = put(index, weight, used, end, 2 * w);
	return put(index, weight, used, inner, -w);
}

size_t curve_row(size_t index[4], double weight[4], size_t count, bool closed, double u)
{
	if (count == 0)
		return 0;
	if (count == 1) {
		index[0] = 0;
		weight[0] = 1;
		return 1;
	}
	const double last = (double)(closed ? count : count - 1);
	if (closed) {
		u = fmod(u, last);
		if (u < 0)
			u += last;
	} else {
		u = fmin(fmax(u, 0), last);
	}
	double span = floor(u);
	if (span >= last)
		span = last - 1; /* the end of an open curve belongs to its last segment; closed: rounding of u + last */
	const double t = u - span, r = 1 - t;
	/* r^3, t^3 and what is left: exact sums of one at t = 0 and t = 1 */
	const double b0 = r * r * r / 6, b3 = t * t * t / 6, b1 = (4 - 3 * t * t * (2 - t)) / 6, b2 = (4 - 3 * r * r * (2 - r)) / 6;
	const ptrdiff_t i = (ptrdiff_t)span;
	/* the two points of the segment first: phantoms then only add to entries that exist */
	size_t used = 0;
	if (!closed && t == 0 && i == 0)
		return put(index, weight, 0, 0, 1);
	if (!closed && t == 1)
		return put(index, weight, 0, count - 1, 1);
	used = put_extended(index, weight, used, count, closed, i, b1);
	used = put_extended(index, weight, used, count, closed, i + 1, b2);
	used = put_extended(index, weight, used, count, closed, i - 1, b0);
	return put_extended(index, weight, used, count, closed, i + 2, b3);
}

void curve_point(double out[3], const double *points, size_t count, bool closed, double u)
{
	size_t index[4];
	double weight[4];
	const size_t used = curve_row(index, weight, count, closed, u);
	out[0] = out[1] = out[2] = 0;
	for (size_t k = 0; k < used; k++)
		for (int c = 0; c < 3; c++)
			out[c] += weight[k] * points[3 * index[k] + (size_t)c];
}

void curve_limit(double out[3], const double *points, size_t count, bool closed, size_t i)
{
	curve_point(out, points, count, closed, (double)i);
}
