/* Polygons of control points (the patch method's section 5.2, steps 3, 6 and 7). */
#include "stages/geometry/polygon.h"

#include <math.h>

#include "stages/geometry/vector.h"

double polygon_plane(double centre[3], double normal[3], const double *xyz, const idx_t *corner, size_t count)
{
	centre[0] = centre[1] = centre[2] = 0;
	for (size_t i = 0; i < count; i++)
		add_scaled3(centre, 1 / (double)count, &xyz[3 * (size_t)corner[i]]);
	normal[0] = normal[1] = normal[2] = 0;
	for (size_t i = 0; i < count; i++) { /* Newell: the sum over a fan around any point, here the centre */
		double doubled[3];
		area_vector3(doubled, centre, &xyz[3 * (size_t)corner[i]], &xyz[3 * (size_t)corner[(i + 1) % count]]);
		add_scaled3(normal, 0.5, doubled);
	}
	return normalise3(normal);
}

double polygon_flatness(const double *xyz, const idx_t *corner, size_t count)
{
	double centre[3], normal[3], worst = 0;
	polygon_plane(centre, normal, xyz, corner, count);
	for (size_t i = 0; i < count; i++) {
		double offset[3];
		sub3(offset, &xyz[3 * (size_t)corner[i]], centre);
		worst = fmax(worst, fabs(dot3(offset, normal)));
	}
	return worst;
}

double polygon_turn_deg(const double *xyz, const idx_t *corner, size_t count, size_t i, const double normal[3])
{
	const double *here = &xyz[3 * (size_t)corner[i]];
	double in[3], out[3], across[3];
	sub3(in, here, &xyz[3 * (size_t)corner[(i + count - 1) % count]]);
	sub3(out, &xyz[3 * (size_t)corner[(i + 1) % count]], here);
	cross3(across, in, out);
	return atan2(dot3(across, normal), dot3(in, out)) * DEGREES;
}

double polygon_star(const double *xyz, const idx_t *corner, size_t count, const double normal[3])
{
	double centre[3] = {0, 0, 0};
	for (size_t i = 0; i < count; i++)
		add_scaled3(centre, 1 / (double)count, &xyz[3 * (size_t)corner[i]]);
	double least = INFINITY, sum = 0;
	for (size_t i = 0; i < count; i++) {
		const double *here = &xyz[3 * (size_t)corner[i]];
		const double *after = &xyz[3 * (size_t)corner[(i + 1) % count]], *before = &xyz[3 * (size_t)corner[(i + count - 1) % count]];
		double next[3], previous[3], first[3], second[3];
		for (int k = 0; k < 3; k++) {
			next[k] = (here[k] + after[k]) / 2;
			previous[k] = (here[k] + before[k]) / 2;
		}
		area_vector3(first, centre, here, next);
		area_vector3(second, centre, previous, here);
		/* Both halves must be positive: a quad may hide a folded half behind a large one. */
		const double a = dot3(first, normal) / 2, b = dot3(second, normal) / 2;
		least = fmin(least, 2 * fmin(a, b));
		sum += fabs(a) + fabs(b);
	}
	return sum > 0 ? least / (sum / (double)count) : 0;
}
