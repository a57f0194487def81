/* Analytic surfaces: distance, foot point, curvature. Fitting is in primitive_fit.c. */
#include <math.h>

#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"

const char *const primitive_kind_name[PATCH_KIND_COUNT] = {"plane", "cylinder", "cone", "sphere", "torus", "free"};

int primitive_parameter_count(enum patch_kind kind)
{
	static const int count[PATCH_KIND_COUNT] = {3, 5, 6, 4, 7, 0};
	return count[kind];
}

/* Any unit vector perpendicular to the unit vector a. */
static void perpendicular(double out[3], const double a[3])
{
	const int k = fabs(a[0]) <= fabs(a[1]) ? (fabs(a[0]) <= fabs(a[2]) ? 0 : 2) : (fabs(a[1]) <= fabs(a[2]) ? 1 : 2);
	double e[3] = {0, 0, 0};
	e[k] = 1;
	cross3(out, a, e);
	normalise3(out);
}

/* Cylindrical coordinates about the patch's axis: height along it, distance from it, unit direction away from it. */
static void around_axis(const struct dense_patch *patch, const double x[3], double *height, double *rho, double away[3])
{
	double d[3];
	sub3(d, x, patch->point);
	*height = dot3(d, patch->axis);
	copy3(away, d);
	add_scaled3(away, -*height, patch->axis);
	*rho = norm3(away);
	if (*rho > 1e-300)
		scale3(away, 1 / *rho);
	else
		perpendicular(away, patch->axis);
}

double primitive_foot(const struct dense_patch *patch, const double x[3], double foot[3], double normal[3])
{
	double height, rho, away[3], n[3] = {0, 0, 0}, distance = 0, sign = patch->sign < 0 ? -1 : 1;
	switch (patch->kind) {
	case PATCH_PLANE: {
		double d[3];
		sub3(d, x, patch->point);
		copy3(n, patch->axis);
		distance = dot3(d, n);
		sign = 1;
		break;
	}
	case PATCH_SPHERE:
		sub3(n, x, patch->point);
		distance = norm3(n) - patch->radius;
		if (normalise3(n) <= 1e-300)
			n[2] = 1;
		break;
	case PATCH_CYLINDER:
		around_axis(patch, x, &height, &rho, n);
		distance = rho - patch->radius;
		break;
	case PATCH_CONE: {
		const double half = patch->radius2 / DEGREES, c = cos(half), s = sin(half);
		around_axis(patch, x, &height, &rho, away);
		distance = rho * c - height * s;
		for (int i = 0; i < 3; i++)
			n[i] = c * away[i] - s * patch->axis[i];
		break;
	}
	case PATCH_TORUS: {
		around_axis(patch, x, &height, &rho, away);
		const double q = rho - patch->radius, s = hypot(q, height);
		distance = s - patch->radius2;
		for (int i = 0; i < 3; i++)
			n[i] = s > 1e-300 ? (q * away[i] + height * patch->axis[i]) / s : away[i];
		break;
	}
	case PATCH_FREE:
		break;
	}
	if (foot) {
		copy3(foot, x);
		add_scaled3(foot, -distance, n);
	}
	if (normal) {
		copy3(normal, n);
		scale3(normal, sign);
	}
	return sign * distance;
}

double primitive_distance(const struct dense_patch *patch, const double x[3])
{
	return primitive_foot(patch, x, NULL, NULL);
}

void primitive_curvature(const struct dense_patch *patch, const double x[3], struct primitive_curvature *out)
{
	const double sign = patch->sign < 0 ? -1 : 1;
	double foot[3], n[3], along[3], around[3], k_along = 0, k_around = 0, height, rho, away[3];
	primitive_foot(patch, x, foot, n);
	out->isotropic = patch->kind == PATCH_PLANE || patch->kind == PATCH_SPHERE;
	if (out->isotropic) {
		perpendicular(along, n);
		if (patch->kind == PATCH_SPHERE)
			k_along = k_around = sign / patch->radius;
	} else {
		/* along: in the half-plane through the axis; around: along the circle of revolution */
		around_axis(patch, foot, &height, &rho, away);
		cross3(around, patch->axis, away);
		cross3(along, around, n);
		if (patch->kind == PATCH_CYLINDER)
			k_around = sign / patch->radius;
		else if (patch->kind == PATCH_CONE)
			k_around = rho > 0 ? sign * cos(patch->radius2 / DEGREES) / rho : 0;
		else {
			k_along = sign / patch->radius2;
			k_around = rho > 1e-300 ? dot3(n, away) / rho : 0;
		}
	}
	normalise3(along);
	cross3(around, n, along);
	if (fabs(k_along) <= fabs(k_around)) {
		out->kmin = k_along, out->kmax = k_around;
		copy3(out->dmin, along);
		copy3(out->dmax, around);
	} else {
		out->kmin = k_around, out->kmax = k_along;
		copy3(out->dmin, around);
		cross3(out->dmax, n, around);
	}
}

bool primitive_dual_torus(struct dense_patch *out, const struct dense_patch *torus, const double x[3])
{
	struct primitive_curvature k;
	double foot[3], normal[3], around[3];
	if (torus->kind != PATCH_TORUS)
		return false;
	primitive_foot(torus, x, foot, normal);
	primitive_curvature(torus, x, &k);
	/* which of the two is the tube's? */
	const double k_tube = (torus->sign < 0 ? -1 : 1) / torus->radius2;
	const bool is_max = fabs(k.kmax - k_tube) <= fabs(k.kmin - k_tube);
	const double k_around = is_max ? k.kmin : k.kmax;
		copy3(around, is_max ? k.dmin : k.dmax);
	if (fabs(k_around) < 1e-9 * fabs(k_tube) || fabs(k_tube - k_around) < 1e-6 * fabs(k_tube))
		return false;
	out->kind = PATCH_TORUS;
	copy3(out->point, foot);
	add_scaled3(out->point, -1 / k_tube, normal);
	copy3(out->axis, around);
	out->radius = fabs(1 / k_tube - 1 / k_around);
	out->radius2 = fabs(1 / k_around);
	out->sign = k_around < 0 ? -1 : 1;
	/* bent to one side both ways: x would lie on the inner sheet of a torus that meets itself, which is not ours */
	return out->radius2 < out->radius;
}

void primitive_residual(const struct dense_patch *patch, const double *xyz, size_t count, double *largest, double *rms)
{
	double most = 0, sum = 0;
	for (size_t i = 0; i < count; i++) {
		const double d = fabs(primitive_distance(patch, xyz + 3 * i));
		most = fmax(most, d);
		sum += d * d;
	}
	if (largest)
		*largest = most;
	if (rms)
		*rms = count ? sqrt(sum / (double)count) : 0;
}
