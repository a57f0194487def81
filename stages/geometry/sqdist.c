/* Quadratic approximants of squared distance (Pottmann and Hofer, Geometry of the squared distance function to curves and
 * surfaces, 2003), with weights that are never negative so that every sum of them is positive semi-definite. */
#include "stages/geometry/sqdist.h"

#include <math.h>

#include "stages/geometry/vector.h"

double sqdist_weight(double s, enum sqdist_variant variant)
{
	switch (variant) {
	case SQDIST_POINT:
		return 1;
	case SQDIST_TANGENT:
		return 0;
	case SQDIST_ABS:
		/* 1 / (1 + 1 / |s|) instead of |s| / (|s| + 1): right for infinite s too */
		return s > 0 || s < 0 ? 1 / (1 + 1 / fabs(s)) : 0;
	case SQDIST_SIDED:
		break;
	}
	/* s / (s - 1): beyond the centre of curvature (0 < s) the true weight is negative, and iterations with it diverge */
	return s < 0 ? 1 / (1 - 1 / s) : 0;
}

/* metric += weight * v v^T */
static void add_square(double metric[6], double weight, const double v[3])
{
	metric[0] += weight * v[0] * v[0];
	metric[1] += weight * v[0] * v[1];
	metric[2] += weight * v[0] * v[2];
	metric[3] += weight * v[1] * v[1];
	metric[4] += weight * v[1] * v[2];
	metric[5] += weight * v[2] * v[2];
}

void sqdist_curve(double metric[6], const double tangent[3], const double curvature[3], const double offset[3], enum sqdist_variant variant)
{
	metric[0] = metric[3] = metric[5] = 1;
	metric[1] = metric[2] = metric[4] = 0;
	add_square(metric, sqdist_weight(dot3(curvature, offset), variant) - 1, tangent);
}

void sqdist_surface(double metric[6], const double normal[3], const double e1[3], double k1, double k2, double d, enum sqdist_variant variant)
{
	double e2[3];
	cross3(e2, normal, e1);
	for (int i = 0; i < 6; i++)
		metric[i] = 0;
	add_square(metric, 1, normal);
	add_square(metric, sqdist_weight(-k1 * d, variant), e1);
	add_square(metric, sqdist_weight(-k2 * d, variant), e2);
}
