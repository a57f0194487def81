#include "stages/geometry/sample.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/vector.h"

/* Next number in [0, 1): splitmix64 (Steele, Lea and Flood 2014). */
static double random_unit(uint64_t *state)
{
	uint64_t z = *state += 0x9e3779b97f4a7c15u;
	z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
	z = (z ^ z >> 27) * 0x94d049bb133111ebu;
	z ^= z >> 31;
	return (double)(z >> 11) / 9007199254740992.0;
}

static double triangle_area(const double *xyz, const idx_t *corner)
{
	double n[3];
	area_vector3(n, xyz + 3 * (size_t)corner[0], xyz + 3 * (size_t)corner[1], xyz + 3 * (size_t)corner[2]);
	return norm3(n) / 2;
}

double sample_surface(double *restrict point, idx_t *restrict triangle, size_t count, const double *restrict xyz,
                      const idx_t *restrict mesh_triangle, size_t triangle_count, uint64_t seed)
{
	double total = 0;
	for (size_t t = 0; t < triangle_count; t++)
		total += triangle_area(xyz, mesh_triangle + 3 * t);
	if (!(total > 0) || !isfinite(total))
		return total;

	/* The plastic number p solves p^3 = p + 1; steps of 1/p and 1/p^2 spread best in the plane. */
	const double step1 = 0.7548776662466927, step2 = 0.5698402909980532;
	const double shift1 = random_unit(&seed), shift2 = random_unit(&seed);
	size_t t = 0, last = 0; /* last: the last triangle with an area, for the rounding at the end */
	double below = 0, area = triangle_area(xyz, mesh_triangle);
	for (size_t i = 0; i < count; i++) {
		const double wanted = ((double)i + random_unit(&seed)) / (double)count * total;
		if (area > 0)
			last = t;
		while (below + area <= wanted && t + 1 < triangle_count) {
			below += area;
			area = triangle_area(xyz, mesh_triangle + 3 * ++t);
			if (area > 0)
				last = t;
		}
		double whole;
		const double r = sqrt(modf(shift1 + (double)i * step1, &whole)), s = modf(shift2 + (double)i * step2, &whole);
		const idx_t *corner = mesh_triangle + 3 * last;
		const double *a = xyz + 3 * (size_t)corner[0], *b = xyz + 3 * (size_t)corner[1], *c = xyz + 3 * (size_t)corner[2];
		for (int k = 0; k < 3; k++)
			point[3 * i + k] = a[k] * (1 - r) + b[k] * (r * (1 - s)) + c[k] * (r * s);
		triangle[i] = (idx_t)last;
	}
	return total;
}
