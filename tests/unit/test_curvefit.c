/* Curves fitted to polylines whose best curve is known (the patch method's sections 4.5 and 4.8). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/fitcurves/curvefit.h"
#include "stages/geometry/curve.h"
#include "stages/geometry/vector.h"

static void assert_near(double value, double wanted, double tolerance)
{
	if (!(fabs(value - wanted) <= tolerance))
		fail_msg("%.17g is not %.17g +- %g", value, wanted, tolerance);
}

/* An arc of radius 1 in the plane z = x / 2: count points from angle 0. Closed for a whole turn. */
static struct polyline arc_line(double angle, size_t count, bool closed)
{
	double *xyz = mem_array(3 * count, sizeof *xyz);
	for (size_t i = 0; i < count; i++) {
		const double a = angle * (double)i / (double)(closed ? count : count - 1);
		xyz[3 * i] = cos(a) * sqrt(0.8), xyz[3 * i + 1] = sin(a), xyz[3 * i + 2] = cos(a) * sqrt(0.2);
	}
	struct polyline line;
	polyline_init(&line, xyz, count, closed);
	free(xyz);
	return line;
}

static struct curvefit_options within(double max)
{
	return (struct curvefit_options){.max = max, .mean = max, .side = 2, .least_points = 2};
}

/* A circle of 64 points at 3e-3 of its radius: table 4.5 says 6 points for a circle (5 leave 5e-3); the 64-gon stands off
 * by 1.2e-3 itself. The control points of 6 stand at 1.203 radii. */
static void test_circle(void **state)
{
	(void)state;
	struct polyline line = arc_line(2 * PI, 64, true);
	struct curvefit fit;
	curvefit_best(&fit, &line, within(3e-3));
	assert_true(fit.closed);
	assert_true(fit.count <= 6);
	assert_true(fit.error <= 3e-3);
	curvefit_free(&fit);
	curvefit_exact(&fit, &line, within(3e-3), 6);
	for (size_t i = 0; i < 6; i++)
		assert_near(norm3(fit.xyz + 3 * i), 1.203, 0.01);
	curvefit_free(&fit);
	polyline_free(&line);
}

/* Errors of table 4.5 for closed circles and arcs between corners, from dense targets, with a margin of 1.5. */
static void test_table(void **state)
{
	(void)state;
	static const struct {
		double angle, error;
		size_t points;
	} table[] = {
		{0, 1.5e-2, 4},   {0, 5.0e-3, 5},   {0, 2.2e-3, 6},   {0, 6.1e-4, 8},  {0, 1.1e-4, 12},
		{90, 2.3e-2, 3},  {90, 4.1e-3, 4},  {90, 1.2e-3, 5},  {90, 5.0e-4, 6}, {180, 2.6e-2, 4},
		{180, 7.1e-3, 5}, {180, 2.7e-3, 6}, {180, 1.2e-3, 7},
	};
	for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
		const bool closed = table[i].angle == 0;
		struct polyline line = arc_line(closed ? 2 * PI : table[i].angle / DEGREES, 1000, closed);
		struct curvefit fit;
		curvefit_exact(&fit, &line, within(1e-6), table[i].points);
		if (fit.error > 1.5 * table[i].error + 2e-5)
			fail_msg("%zu points on %g degrees: %g, table %g", table[i].points, table[i].angle, fit.error,
				 table[i].error);
		assert_true(fit.error > table[i].error / 3); /* uniform cubics can do no better */
		curvefit_free(&fit);
		polyline_free(&line);
	}
}

/* A quarter circle at 1.5e-3: three inner points leave 1.2e-3. */
static void test_quarter(void **state)
{
	(void)state;
	struct polyline line = arc_line(PI / 2, 200, false);
	struct curvefit fit;
	curvefit_best(&fit, &line, within(1.5e-3));
	assert_true(fit.count <= 5);
	assert_true(fit.error <= 1.5e-3);
	for (size_t k = 0; k < 3; k++) {
		assert_near(fit.xyz[k], line.xyz[k], 0);
		assert_near(fit.xyz[3 * (fit.count - 1) + k], line.xyz[3 * 199 + k], 0);
	}
	curvefit_free(&fit);
	polyline_free(&line);
}

static void test_straight(void **state)
{
	(void)state;
	double xyz[33];
	for (size_t i = 0; i < 11; i++)
		xyz[3 * i] = (double)i, xyz[3 * i + 1] = 2 * (double)i, xyz[3 * i + 2] = 1;
	struct polyline line;
	polyline_init(&line, xyz, 11, false);
	struct curvefit fit;
	curvefit_best(&fit, &line, (struct curvefit_options){.max = 1e-3, .mean = 1e-3, .side = 20, .least_points = 2});
	assert_int_equal(fit.count, 2);
	assert_near(fit.error, 0, 1e-12);
	curvefit_free(&fit);
	/* A straight curve that needs inner points for the network's sake has them on the line. */
	curvefit_best(&fit, &line, (struct curvefit_options){.max = 1e-3, .mean = 1e-3, .side = 20, .least_points = 4});
	assert_int_equal(fit.count, 4);
	assert_near(fit.error, 0, 1e-9);
	curvefit_free(&fit);
	polyline_free(&line);
}

/* Samples of a B-spline with eight known control points are found again with at most ten. */
static void test_spline(void **state)
{
	(void)state;
	static const double control[24] = {0, 0, 0, 1, 2, 0, 2.5, 2, 1, 3, 0, 1, 4.5, -1, 0, 6, 0, -1, 6.5, 2, 0, 8, 2, 1};
	double xyz[3 * 400];
	for (size_t i = 0; i < 400; i++)
		curve_point(xyz + 3 * i, control, 8, false, 7.0 * (double)i / 399);
	struct polyline line;
	polyline_init(&line, xyz, 400, false);
	struct curvefit fit;
	curvefit_best(&fit, &line, (struct curvefit_options){.max = 8e-3, .mean = 2e-3, .side = 8, .least_points = 2});
	assert_true(fit.error <= 8e-3);
	assert_true(fit.count <= 10);
	curvefit_free(&fit);
	polyline_free(&line);
}

/* A coarse circle of 12 points and one of 400: the first stands off by 3.4e-2 of its radius, which no smooth curve mends;
 * it must not be chased with control points. */
static void test_coarse(void **state)
{
	(void)state;
	struct polyline line = arc_line(2 * PI, 12, true);
	struct curvefit fit;
	curvefit_best(&fit, &line, within(1e-3));
	assert_true(fit.count <= 6);
	assert_true(fit.error < 0.035);
	assert_true(fit.ratio <= 1);
	curvefit_free(&fit);
	polyline_free(&line);
}

/* The border of a half plane along triangles goes up and down by 0.4 edges: it is fitted by a straight line. */
static void test_jagged(void **state)
{
	(void)state;
	double xyz[303];
	for (size_t i = 0; i < 101; i++)
		xyz[3 * i] = (double)i / 100, xyz[3 * i + 1] = i % 2 && i < 100 ? 0.004 : 0, xyz[3 * i + 2] = 0;
	struct polyline line;
	polyline_init(&line, xyz, 101, false);
	assert_true(polyline_is_jagged(&line));
	polyline_smooth(&line);
	struct curvefit fit;
	curvefit_best(&fit, &line, (struct curvefit_options){.max = 2e-3, .mean = 5e-4, .side = 1, .least_points = 2});
	assert_true(fit.count <= 3);
	curvefit_free(&fit);
	polyline_free(&line);
	line = arc_line(2 * PI, 12, true);
	assert_false(polyline_is_jagged(&line));
	polyline_free(&line);
}

/* Same result when the target is moved and scaled: nothing depends on a unit. */
static void test_scaling(void **state)
{
	(void)state;
	struct polyline line = arc_line(PI, 90, false);
	double xyz[270];
	for (size_t i = 0; i < 270; i++)
		xyz[i] = 1000 * line.xyz[i] + 500;
	struct polyline big;
	polyline_init(&big, xyz, 90, false);
	struct curvefit a, b;
	curvefit_best(&a, &line, within(2e-3));
	curvefit_best(&b, &big, (struct curvefit_options){.max = 2, .mean = 2, .side = 2000, .least_points = 2});
	assert_int_equal(a.count, b.count);
	for (size_t i = 0; i < 3 * a.count; i++)
		assert_near(b.xyz[i], 1000 * a.xyz[i] + 500, 1e-6);
	curvefit_free(&a), curvefit_free(&b);
	polyline_free(&line), polyline_free(&big);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_circle),   cmocka_unit_test(test_table),   cmocka_unit_test(test_quarter),
		cmocka_unit_test(test_straight), cmocka_unit_test(test_spline),  cmocka_unit_test(test_coarse),
		cmocka_unit_test(test_jagged),   cmocka_unit_test(test_scaling),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
