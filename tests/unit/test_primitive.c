/* Analytic surfaces: distances, feet, curvatures and fits of points made from known parameters. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"

/* cmocka's float assertion compares as float */
#define assert_near(got, want, tolerance) \
	do { \
		const double got_ = (got), want_ = (want), tolerance_ = (tolerance); \
		if (!(fabs(got_ - want_) <= tolerance_)) { \
			print_error("%s = %.17g, not %.17g +- %g\n", #got, got_, want_, tolerance_); \
			fail(); \
		} \
	} while (0)

#define POINTS 120

/* A frame that is aligned with nothing: columns are an orthonormal basis. */
static const double frame_u[3] = {2. / 3, 2. / 3, 1. / 3}, frame_v[3] = {-2. / 3, 1. / 3, 2. / 3}, frame_w[3] = {1. / 3, -2. / 3, 2. / 3};

static void place(double out[3], const double at[3], double u, double v, double w)
{
	copy3(out, at);
	add_scaled3(out, u, frame_u);
	add_scaled3(out, v, frame_v);
	add_scaled3(out, w, frame_w);
}

/* Elements of a surface about the axis frame_w through at: count points on a part (less than half a turn) of it, and outward
 * normals. The torus has radii 3 and 1, the cone a half angle of 20 degrees, everything else radius 2. */
static void make_elements(double *xyz, double *normal, enum patch_kind kind, const double at[3], double sign, double turn)
{
	for (int i = 0; i < POINTS; i++) {
		const double a = turn * (i % 12) / 12, t = (i / 12) / 10.0, c = cos(a), s = sin(a), b = -0.4 + 1.1 * t;
		const double origin[3] = {0, 0, 0};
		switch (kind) {
		case PATCH_PLANE:
			place(xyz + 3 * i, at, c * (1 + t), s * (1 + t), 0);
			place(normal + 3 * i, origin, 0, 0, 1);
			break;
		case PATCH_CYLINDER:
			place(xyz + 3 * i, at, 2 * c, 2 * s, 3 * t);
			place(normal + 3 * i, origin, c, s, 0);
			break;
		case PATCH_CONE: {
			const double half = 20 / DEGREES, h = 2 + 3 * t;
			place(xyz + 3 * i, at, h * tan(half) * c, h * tan(half) * s, h);
			place(normal + 3 * i, origin, cos(half) * c, cos(half) * s, -sin(half));
			break;
		}
		case PATCH_SPHERE:
			place(normal + 3 * i, origin, cos(b) * c, cos(b) * s, sin(b));
			copy3(xyz + 3 * i, at);
			add_scaled3(xyz + 3 * i, 2, normal + 3 * i);
			break;
		case PATCH_TORUS:
			place(normal + 3 * i, origin, cos(b) * c, cos(b) * s, sin(b));
			place(xyz + 3 * i, at, 3 * c + cos(b) * c, 3 * s + cos(b) * s, sin(b));
			break;
		case PATCH_FREE:
			break;
		}
		if (kind != PATCH_PLANE)
			scale3(normal + 3 * i, sign);
	}
}

static const double at[3] = {10, -4, 7};

/* Guess and fit must find the surface that the elements were taken from, from an eighth of a turn on, and from both sides. */
static void test_fit_exact(void **state)
{
	(void)state;
	double xyz[3 * POINTS], normal[3 * POINTS], largest;
	for (int kind = 0; kind < PATCH_FREE; kind++)
		for (int turn = 1; turn <= 8; turn *= 2)
			for (int side = 0; side < 2; side++) {
				const double sign = side ? -1 : 1;
				struct dense_patch patch = {.area = 5};
				make_elements(xyz, normal, (enum patch_kind)kind, at, sign, turn * PI / 4);
				assert_true(primitive_guess(&patch, (enum patch_kind)kind, xyz, normal, NULL, POINTS));
				assert_true(primitive_fit(&patch, xyz, NULL, POINTS, 0));
				primitive_residual(&patch, xyz, POINTS, &largest, NULL);
				assert_near(largest, 0, 1e-7);
				assert_int_equal(patch.kind, kind);
				assert_near(patch.area, 5, 0); /* not its business */
				if (kind == PATCH_PLANE) {
					assert_near(dot3(patch.axis, frame_w), 1, 1e-12);
					continue;
				}
				assert_near(patch.sign, sign, 0);
				if (kind != PATCH_SPHERE)
					assert_near(fabs(dot3(patch.axis, frame_w)), 1, 1e-9);
				if (kind == PATCH_CYLINDER || kind == PATCH_SPHERE)
					assert_near(patch.radius, 2, 1e-6);
				if (kind == PATCH_CONE) {
					assert_near(distance3(patch.point, at), 0, 1e-5);
					assert_near(patch.radius2, 20, 1e-5);
					assert_near(dot3(patch.axis, frame_w), 1, 1e-9);
				}
				if (kind == PATCH_SPHERE || kind == PATCH_TORUS)
					assert_near(distance3(patch.point, at), 0, 1e-5);
				if (kind == PATCH_TORUS) {
					assert_near(patch.radius, 3, 1e-5);
					assert_near(patch.radius2, 1, 1e-5);
				}
				for (int i = 0; i < POINTS; i++) {
					double n[3], foot[3];
					assert_near(primitive_foot(&patch, xyz + 3 * i, foot, n), 0, 1e-7);
					assert_near(dot3(n, normal + 3 * i), 1, 1e-9);
				}
			}
}

/* From a guess with facet normals that are wrong by some degrees and points off by 1 %, the fit still comes within that error. */
static void test_fit_noise(void **state)
{
	(void)state;
	double xyz[3 * POINTS], normal[3 * POINTS];
	uint32_t seed = 1;
	for (int kind = 1; kind < PATCH_FREE; kind++) {
		struct dense_patch patch = {0};
		double rms;
		make_elements(xyz, normal, (enum patch_kind)kind, at, 1, 2 * PI / 3);
		for (int i = 0; i < 3 * POINTS; i++) {
			seed = seed * 1664525u + 1013904223u;
			xyz[i] += 0.01 * ((double)(seed >> 8) / (1 << 24) - 0.5);
			seed = seed * 1664525u + 1013904223u;
			normal[i] += 0.1 * ((double)(seed >> 8) / (1 << 24) - 0.5);
		}
		assert_true(primitive_guess(&patch, (enum patch_kind)kind, xyz, normal, NULL, POINTS));
		assert_true(primitive_fit(&patch, xyz, NULL, POINTS, 0));
		primitive_residual(&patch, xyz, POINTS, NULL, &rms);
		assert_true(rms < 1.2 * 0.01 / sqrt(12)); /* the deviation of the uniform noise, and a margin for chance */
	}
}

/* A point off the surface: |distance| is the way to the foot, along the normal there, positive outside. */
static void test_distance(void **state)
{
	(void)state;
	static const struct dense_patch patch[] = {
		{.kind = PATCH_PLANE, .point = {0, 0, 1}, .axis = {0, 0, 1}},
		{.kind = PATCH_CYLINDER, .axis = {0, 0, 1}, .radius = 2, .sign = 1},
		{.kind = PATCH_CONE, .axis = {0, 0, 1}, .radius2 = 45, .sign = -1},
		{.kind = PATCH_SPHERE, .radius = 2, .sign = -1},
		{.kind = PATCH_TORUS, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1, .sign = 1},
	};
	/* by hand for x = (3, 0, 2): plane 2 - 1; cylinder 3 - 2; cone (3 - 2) / sqrt 2, seen from inside; sphere sqrt 13 - 2, from inside; torus 2 - 1 */
	static const double want[] = {1, 1, -0.70710678118654752, -1.6055512754639893, 1};
	for (size_t i = 0; i < sizeof patch / sizeof *patch; i++) {
		const double x[3] = {3, 0, 2};
		double foot[3], normal[3], again[3];
		const double d = primitive_foot(&patch[i], x, foot, normal);
		assert_near(d, want[i], 1e-12);
		assert_near(primitive_distance(&patch[i], x), d, 0);
		assert_near(primitive_distance(&patch[i], foot), 0, 1e-12);
		assert_near(norm3(normal), 1, 1e-12);
		copy3(again, foot);
		add_scaled3(again, d, normal);
		assert_near(distance3(again, x), 0, 1e-12);
	}
}

static void test_axis_point(void **state)
{
	(void)state;
	/* on the axis every direction is as good: any unit normal across it will do, but it must be one */
	const struct dense_patch patch = {.kind = PATCH_CYLINDER, .axis = {0, 0, 1}, .radius = 2, .sign = 1};
	const double x[3] = {0, 0, 5};
	double foot[3], normal[3];
	assert_near(primitive_foot(&patch, x, foot, normal), -2, 1e-12);
	assert_near(norm3(normal), 1, 1e-12);
	assert_near(normal[2], 0, 1e-12);
	assert_near(hypot(foot[0], foot[1]), 2, 1e-12);
}

static void test_curvature(void **state)
{
	(void)state;
	struct primitive_curvature k;
	const struct dense_patch shaft = {.kind = PATCH_CYLINDER, .axis = {0, 0, 1}, .radius = 2, .sign = 1};
	primitive_curvature(&shaft, (const double[]){3, 0, 1}, &k);
	assert_near(k.kmin, 0, 0);
	assert_near(k.kmax, 0.5, 1e-12);
	assert_near(fabs(k.dmin[2]), 1, 1e-12);
	assert_near(fabs(k.dmax[1]), 1, 1e-12);
	assert_false(k.isotropic);

	const struct dense_patch bore = {.kind = PATCH_CYLINDER, .axis = {0, 0, 1}, .radius = 2, .sign = -1};
	primitive_curvature(&bore, (const double[]){3, 0, 1}, &k);
	assert_near(k.kmax, -0.5, 1e-12);

	const struct dense_patch ball = {.kind = PATCH_SPHERE, .radius = 4, .sign = 1};
	primitive_curvature(&ball, (const double[]){3, 0, 1}, &k);
	assert_near(k.kmin, 0.25, 1e-12);
	assert_near(k.kmax, 0.25, 1e-12);
	assert_true(k.isotropic);

	/* torus, outer equator: 1 / tube and 1 / (R + r); inner equator: a saddle */
	const struct dense_patch ring = {.kind = PATCH_TORUS, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1, .sign = 1};
	primitive_curvature(&ring, (const double[]){5, 0, 0}, &k);
	assert_near(k.kmax, 1, 1e-12);
	assert_near(k.kmin, 0.25, 1e-12);
	assert_near(fabs(k.dmin[1]), 1, 1e-12);
	primitive_curvature(&ring, (const double[]){1.5, 0, 0}, &k);
	assert_near(k.kmax, 1, 1e-12);
	assert_near(k.kmin, -0.5, 1e-12);
	/* a torus fillet in a corner, seen from outside of the material: the tube's curvature is negative */
	const struct dense_patch groove = {.kind = PATCH_TORUS, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1, .sign = -1};
	primitive_curvature(&groove, (const double[]){2.5, 0, 0}, &k);
	assert_near(k.kmax, -1, 1e-12);
	assert_near(k.kmin, 0.5, 1e-12);

	/* cone of 45 degrees at distance 1 from its axis: cos 45 / 1, straight along the ruling */
	const struct dense_patch cone = {.kind = PATCH_CONE, .axis = {0, 0, 1}, .radius2 = 45, .sign = 1};
	primitive_curvature(&cone, (const double[]){1, 0, 1}, &k);
	assert_near(k.kmin, 0, 0);
	assert_near(k.kmax, sqrt(0.5), 1e-12);
	assert_near(fabs(k.dmin[0]), sqrt(0.5), 1e-12);
	assert_near(fabs(k.dmin[2]), sqrt(0.5), 1e-12);
	double normal[3], side[3];
	primitive_foot(&cone, (const double[]){1, 0, 1}, NULL, normal);
	cross3(side, normal, k.dmin);
	assert_near(distance3(side, k.dmax), 0, 1e-12);
}

/* The dual torus touches with the same curvatures, and its dual is the torus itself. */
static void test_dual(void **state)
{
	(void)state;
	const struct dense_patch torus = {.kind = PATCH_TORUS, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1, .sign = -1};
	const double inner[3] = {2, 0, 0}, outer[3] = {4, 0, 0};
	struct dense_patch dual = {0}, again = {0};
	struct primitive_curvature k, l;
	double n[3], m[3];
	assert_true(primitive_dual_torus(&dual, &torus, inner));
	assert_near(primitive_foot(&dual, inner, NULL, m), 0, 1e-12);
	primitive_foot(&torus, inner, NULL, n);
	assert_near(distance3(m, n), 0, 1e-12);
	primitive_curvature(&torus, inner, &k);
	primitive_curvature(&dual, inner, &l);
	assert_near(k.kmin, l.kmin, 1e-12);
	assert_near(k.kmax, l.kmax, 1e-12);
	assert_near(dual.radius2, 2, 1e-12); /* the circle of radius 2 around the axis becomes the tube */
	assert_true(primitive_dual_torus(&again, &dual, inner));
	assert_near(again.radius, 3, 1e-12);
	assert_near(again.radius2, 1, 1e-12);
	assert_near(again.sign, -1, 0);
	/* outside, a tube of radius 4 around a circle of radius 3 would meet itself */
	assert_false(primitive_dual_torus(&dual, &torus, outer));
	assert_false(primitive_dual_torus(&dual, &(struct dense_patch){.kind = PATCH_SPHERE, .radius = 1}, inner));
}

/* What does not determine a surface is refused, and the patch stays. */
static void test_refuse(void **state)
{
	(void)state;
	double line[15], same[15];
	for (int i = 0; i < 5; i++)
		for (int k = 0; k < 3; k++)
			line[3 * i + k] = i, same[3 * i + k] = k == 2;
	struct dense_patch patch = {0};
	assert_false(primitive_guess(&patch, PATCH_CYLINDER, line, same, NULL, 5)); /* one normal only */
	assert_false(primitive_guess(&patch, PATCH_SPHERE, line, same, NULL, 5));
	patch = (struct dense_patch){.kind = PATCH_PLANE, .axis = {0, 0, 1}};
	assert_false(primitive_fit(&patch, line, NULL, 5, 0)); /* a line lies in many planes */
	patch = (struct dense_patch){.kind = PATCH_TORUS, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1};
	assert_false(primitive_fit(&patch, line, NULL, 5, 0)); /* seven parameters from five points */
	assert_near(patch.radius, 3, 0);
	assert_false(primitive_guess(&patch, PATCH_FREE, line, same, NULL, 5));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_fit_exact), cmocka_unit_test(test_fit_noise), cmocka_unit_test(test_distance),
		cmocka_unit_test(test_axis_point), cmocka_unit_test(test_curvature), cmocka_unit_test(test_dual), cmocka_unit_test(test_refuse),
	};
	return cmocka_run_group_tests_name("primitive", tests, NULL, NULL);
}
