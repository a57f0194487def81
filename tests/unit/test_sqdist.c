/* Squared-distance weights against second differences of true squared distances. */
#include "tests/unit/cage_samples.h"

#include "stages/geometry/sqdist.h"
#include "stages/geometry/vector.h"

static double form(const double m[6], const double x[3])
{
	return m[0] * x[0] * x[0] + m[3] * x[1] * x[1] + m[5] * x[2] * x[2] + 2 * (m[1] * x[0] * x[1] + m[2] * x[0] * x[2] + m[4] * x[1] * x[2]);
}

static double circle_distance2(const double p[3], double r)
{
	const double radial = hypot(p[0], p[1]) - r;
	return radial * radial + p[2] * p[2];
}

/* Half the second derivative of the squared distance along direction u at p. */
static double half_second(double (*f)(const double *, double), double r, const double p[3], const double u[3])
{
	const double h = 1e-3;
	double a[3], b[3];
	copy3(a, p);
	copy3(b, p);
	add_scaled3(a, h, u);
	add_scaled3(b, -h, u);
	return (f(a, r) - 2 * f(p, r) + f(b, r)) / (2 * h * h);
}

/* Circle of radius r, sample outside in its plane and above: s = k . delta, k = -(1 / r) radial. Half the Hessian is the metric. */
static void circle(void **state)
{
	(void)state;
	const double r = 2, samples[][3] = {{2.5, 0, 0}, {2.3, 0, 0.4}, {3, 0, -1}};
	for (size_t k = 0; k < sizeof samples / sizeof *samples; k++) {
		const double tangent[3] = {0, 1, 0}, curvature[3] = {-1 / r, 0, 0}, offset[3] = {samples[k][0] - r, 0, samples[k][2]};
		double m[6];
		sqdist_curve(m, tangent, curvature, offset, SQDIST_SIDED);
		const double directions[][3] = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0.6, 0.8, 0}};
		for (size_t d = 0; d < 4; d++)
			assert_near(form(m, directions[d]), half_second(circle_distance2, r, samples[k], directions[d]), 1e-5);
	}
	/* inside the true weight is negative: clamped to 0 */
	const double tangent[3] = {0, 1, 0}, curvature[3] = {-1 / r, 0, 0}, inward[3] = {-0.5, 0, 0};
	double m[6];
	sqdist_curve(m, tangent, curvature, inward, SQDIST_SIDED);
	assert_true(half_second(circle_distance2, r, (const double[]){1.5, 0, 0}, tangent) < 0);
	assert_near(form(m, tangent), 0, 1e-16);
	assert_near(form(m, (const double[]){1, 0, 0}), 1, 1e-16);
	/* the magnitude variant: |s| / (|s| + 1) with s = 1/4 */
	sqdist_curve(m, tangent, curvature, inward, SQDIST_ABS);
	assert_near(form(m, tangent), 0.2, 1e-15);
}

static double sphere_distance2(const double p[3], double r)
{
	const double d = norm3(p) - r;
	return d * d;
}

/* Sphere of radius r from outside: both principal curvatures are 1 / r, convex. And a hollow sphere from its inside. */
static void sphere(void **state)
{
	(void)state;
	const double r = 2, normal[3] = {0, 0, 1}, e1[3] = {1, 0, 0};
	const double p[3] = {0, 0, 2.7}, q[3] = {0, 0, 1.2};
	double m[6];
	sqdist_surface(m, normal, e1, 1 / r, 1 / r, 0.7, SQDIST_SIDED);
	const double directions[][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, 0, 0.8}};
	for (size_t d = 0; d < 4; d++)
		assert_near(form(m, directions[d]), half_second(sphere_distance2, r, p, directions[d]), 1e-5);
	/* from inside, with the normal turned outward still: weight below zero in truth, clamped */
	sqdist_surface(m, normal, e1, 1 / r, 1 / r, -0.8, SQDIST_SIDED);
	assert_true(half_second(sphere_distance2, r, q, e1) < 0);
	assert_near(form(m, e1), 0, 1e-16);
	/* a cylinder of radius r along y from outside: bent across x only */
	sqdist_surface(m, normal, e1, 1 / r, 0, 0.7, SQDIST_SIDED);
	assert_near(form(m, e1), 0.7 / 2.7, 1e-15);
	assert_near(form(m, (const double[]){0, 1, 0}), 0, 1e-16);
}

static void weights_stay_in_range(void **state)
{
	(void)state;
	const double s[] = {-INFINITY, -1e300, -3, -1, -1e-9, 0, 1e-9, 0.5, 1, 2, 1e300, INFINITY, NAN};
	for (size_t k = 0; k < sizeof s / sizeof *s; k++)
		for (int variant = SQDIST_SIDED; variant <= SQDIST_TANGENT; variant++) {
			const double w = sqdist_weight(s[k], (enum sqdist_variant)variant);
			assert_true(w >= 0 && w <= 1);
			if (fabs(s[k]) <= 3 && variant != SQDIST_POINT)
				assert_true(w < 1);
		}
	assert_near(sqdist_weight(-1, SQDIST_SIDED), 0.5, 1e-16);
	assert_near(sqdist_weight(-3, SQDIST_SIDED), 0.75, 1e-16);
	assert_near(sqdist_weight(3, SQDIST_ABS), 0.75, 1e-16);
	assert_near(sqdist_weight(3, SQDIST_POINT), 1, 0);
	assert_near(sqdist_weight(-3, SQDIST_TANGENT), 0, 0);
}

/* Point and tangent distance are the two ends: the unit metric and n n^T. */
static void ends(void **state)
{
	(void)state;
	const double normal[3] = {2.0 / 3, 1.0 / 3, 2.0 / 3}, e1[3] = {1 / sqrt(5), -2 / sqrt(5), 0};
	double m[6];
	sqdist_surface(m, normal, e1, 5, -3, 0.1, SQDIST_POINT);
	for (int i = 0; i < 6; i++)
		assert_near(m[i], i == 0 || i == 3 || i == 5, 1e-15);
	sqdist_surface(m, normal, e1, 5, -3, 0.1, SQDIST_TANGENT);
	assert_near(m[0], normal[0] * normal[0], 1e-16);
	assert_near(m[4], normal[1] * normal[2], 1e-16);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(circle),
	        cmocka_unit_test(sphere),
	        cmocka_unit_test(weights_stay_in_range),
	        cmocka_unit_test(ends),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
