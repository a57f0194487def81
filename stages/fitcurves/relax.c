/* Laplacian smoothing in a tube around the border, projected to the surface. */
#include "stages/fitcurves/relax.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"

/* Rounds of averaging between projections, and how often. A staircase of period p vertices needs about p * p rounds. */
#define ROUNDS 8
#define PROJECTIONS 6
/* Radius of the tube over the local edge length. */
#define TUBE 0.5
/* A straight way is one border's when it stays this near, in lengths, and does not jump by this many steps from one part of the
 * surface to another. */
#define ASTRAY 0.15
#define JUMP 4

static void project(double p[3], const struct dense *dense, const struct nearest *nearest, idx_t left, idx_t right)
{
	struct foot best = {.triangle = NO_INDEX, .distance = INFINITY};
	const idx_t patch[2] = {left, right};
	for (int k = 0; k < 2; k++) {
		if (patch[k] < 0)
			continue;
		const struct nearest_filter filter = {.label = dense->label, .only = patch[k]};
		const struct foot foot = nearest_point(nearest, p, INFINITY, &filter);
		if (foot.triangle != NO_INDEX && foot.distance < best.distance)
			best = foot;
	}
	if (best.triangle != NO_INDEX)
		copy3(p, best.point);
}

size_t relax_border(double **out, const double *xyz, size_t count, bool closed, const struct dense *dense,
		    const struct nearest *nearest, idx_t left, idx_t right)
{
	const size_t segments = closed ? count : count - 1, n = segments + count;
	double *home = mem_array(3 * n, sizeof *home), *reach = mem_array(n, sizeof *reach);
	for (size_t i = 0; i < count; i++)
		copy3(home + 6 * i, xyz + 3 * i);
	for (size_t i = 0; i < segments; i++)
		for (size_t k = 0; k < 3; k++)
			home[6 * i + 3 + k] = (xyz[3 * i + k] + xyz[3 * ((i + 1) % count) + k]) / 2;
	for (size_t i = 0; i < n; i++) {
		/* mean of the halved edges on both sides, twice */
		const double *before = home + 3 * (i > 0    ? i - 1
						   : closed ? n - 1
							    : i),
			     *after = home + 3 * (i + 1 < n ? i + 1
						  : closed  ? 0
							    : i);
		reach[i] = TUBE * (distance3(home + 3 * i, before) + distance3(home + 3 * i, after));
	}
	double *now = mem_copy(home, 3 * n, sizeof *now), *next = mem_copy(home, 3 * n, sizeof *next);
	const size_t first = closed ? 0 : 1, last = closed ? n : n - 1;
	for (int projection = 0; projection < PROJECTIONS; projection++) {
		for (int round = 0; round < ROUNDS; round++) {
			for (size_t i = first; i < last; i++) {
				const double *a = now + 3 * (i > 0 ? i - 1 : n - 1), *b = now + 3 * (i + 1 < n ? i + 1 : 0);
				double d[3];
				for (size_t k = 0; k < 3; k++)
					d[k] = (a[k] + 2 * now[3 * i + k] + b[k]) / 4 - home[3 * i + k];
				const double length = norm3(d);
				if (length > reach[i])
					scale3(d, reach[i] / length);
				for (size_t k = 0; k < 3; k++)
					next[3 * i + k] = home[3 * i + k] + d[k];
			}
			double *swap = now;
			now = next, next = swap;
		}
		for (size_t i = first; i < last; i++)
			project(now + 3 * i, dense, nearest, left, right);
	}
	free(home), free(reach), free(next);
	*out = now;
	return n;
}

bool relax_straight(double *xyz, size_t count, const struct dense *dense, const struct nearest *nearest, idx_t left, idx_t right)
{
	double length = 0;
	for (size_t i = 1; i < count; i++)
		length += distance3(xyz + 3 * (i - 1), xyz + 3 * i);
	double *straight = mem_copy(xyz, 3 * count, sizeof *straight), along = 0, before = 0;
	const double *from = xyz, *to = xyz + 3 * (count - 1);
	bool near = true;
	for (size_t i = 1; near && i < count; i++) {
		along += distance3(xyz + 3 * (i - 1), xyz + 3 * i);
		double *p = straight + 3 * i;
		if (i + 1 < count) {
			for (size_t k = 0; k < 3; k++)
				p[k] = from[k] + along / length * (to[k] - from[k]);
			project(p, dense, nearest, left, right);
		}
		const double step = distance3(p - 3, p);
		near = distance3(p, xyz + 3 * i) <= ASTRAY * length && step <= JUMP * (along - before);
		before = along;
	}
	if (near)
		memcpy(xyz, straight, 3 * count * sizeof *xyz);
	free(straight);
	return near;
}
