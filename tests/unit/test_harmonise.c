/* Opposite curves get equal counts and aligned phases. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/fitcurves/harmonise.h"
#include "stages/geometry/vector.h"

static void assert_near(double value, double wanted, double tolerance)
{
	if (!(fabs(value - wanted) <= tolerance))
		fail_msg("%.17g is not %.17g +- %g", value, wanted, tolerance);
}

/* A circle around the z axis from angle phase on, clockwise when way is -1. */
static struct polyline circle(double radius, double z, double phase, int way, size_t count)
{
	double *xyz = mem_array(3 * count, sizeof *xyz);
	for (size_t i = 0; i < count; i++) {
		const double a = phase + way * 2 * PI * (double)i / (double)count;
		xyz[3 * i] = radius * cos(a), xyz[3 * i + 1] = radius * sin(a), xyz[3 * i + 2] = z;
	}
	struct polyline line;
	polyline_init(&line, xyz, count, true);
	free(xyz);
	return line;
}

/* Two circles of a tube: where one stands at angle 0 the other is 50 degrees on, whichever way it runs. */
static void test_offset(void **state)
{
	(void)state;
	struct polyline a = circle(1, 0, 0, 1, 90);
	for (int way = -1; way <= 1; way += 2) {
		struct polyline b = circle(2, 3, -50 / DEGREES * way, way, 90);
		double residual;
		const double offset = harmonise_offset(&a, &b, way > 0, &residual);
		assert_near(offset / b.length * 360, 50, 0.3);
		assert_near(residual, 0, 0.02); /* offsets are compared every 1.9 degrees */
		polyline_free(&b);
	}
	polyline_free(&a);
}

/* A tube between two circles with different phases and radii, patch 0 between them: same number, knots on the same rays. */
static void test_tube(void **state)
{
	(void)state;
	struct border_chain chain[2] = {{.left = 0, .right = 1, .closed = true}, {.left = 0, .right = 2, .closed = true}};
	struct border_network border = {.chain_count = 2, .chain = chain};
	const idx_t node[4] = {NO_INDEX, NO_INDEX, NO_INDEX, NO_INDEX};
	struct patchloops loops;
	patchloops_init(&loops, &border, node, NULL, 3);
	assert_int_equal(loops.loop_count, 4);
	assert_int_equal(loops.first_loop[1], 2);
	/* seen from the tube the two run against each other */
	struct polyline line[2] = {circle(1, 0, 0.3, 1, 200), circle(3, 2, 1, -1, 200)};
	const struct curvefit_options limit[2] = {{.max = 5e-3, .mean = 5e-3, .side = 6, .least_points = 3},
						  {.max = 5e-3, .mean = 5e-3, .side = 6, .least_points = 3}};
	struct curvefit fit[2];
	for (size_t i = 0; i < 2; i++)
		curvefit_best(fit + i, line + i, limit[i]);
	assert_true(fit[0].count < fit[1].count); /* the larger circle needs more points for the same distance */
	const size_t larger = fit[1].count;
	assert_int_equal(harmonise(fit, line, limit, &border, &loops, NULL, NULL), 1);
	assert_int_equal(fit[0].count, larger);
	assert_int_equal(fit[1].count, larger);
	for (size_t i = 0; i < larger; i++) {
		double nearest = 360;
		for (size_t j = 0; j < larger; j++) {
			const double *p = fit[0].xyz + 3 * i, *q = fit[1].xyz + 3 * j;
			nearest = fmin(nearest, fabs(atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1])) * DEGREES);
		}
		assert_near(nearest, 0, 1.5);
	}
	for (size_t i = 0; i < 2; i++) {
		assert_true(fit[i].error <= 5e-3);
		polyline_free(line + i), curvefit_free(fit + i);
	}
	patchloops_free(&loops);
}

/* A four-sided patch: its bent sides are arcs of 50 and 130 degrees; both get what the second needs. Its straight sides stay
 * without inner points. */
static void test_quad(void **state)
{
	(void)state;
	struct border_chain chain[4] = {
		{.left = 0, .right = 1}, {.left = 0, .right = 2}, {.left = 0, .right = 3}, {.left = 0, .right = 4}};
	struct border_network border = {.chain_count = 4, .chain = chain};
	const idx_t node[8] = {0, 1, 1, 2, 2, 3, 3, 0};
	struct patchloops loops;
	patchloops_init(&loops, &border, node, NULL, 5);
	struct polyline line[4];
	struct curvefit fit[4];
	struct curvefit_options limit[4];
	double xyz[3 * 41];
	for (size_t c = 0; c < 4; c++) {
		for (size_t i = 0; i < 41; i++) {
			const double t = (double)i / 40, s = c < 2 ? t : 1 - t;
			/* 0: a flat arc along x, 1: up at x = 1, 2: a deeper arc back, 3: down at x = 0 */
			xyz[3 * i] = c % 2 ? (c == 1) : s;
			xyz[3 * i + 1] = c % 2 ? s : (c == 2);
			const double half = (c == 0 ? 25 : 65) / DEGREES, radius = 0.5 / sin(half);
			xyz[3 * i + 2] = c % 2 ? 0 : sqrt(radius * radius - (s - 0.5) * (s - 0.5)) - radius * cos(half);
		}
		polyline_init(line + c, xyz, 41, false);
		limit[c] = (struct curvefit_options){.max = 4e-3, .mean = 1e-3, .side = 1, .least_points = 2};
		curvefit_best(fit + c, line + c, limit[c]);
	}
	const size_t low = fit[0].count, high = fit[2].count;
	assert_true(low < high && high - 2 <= 2 * (low - 2));
	assert_int_equal(fit[1].count, 2);
	assert_int_equal(harmonise(fit, line, limit, &border, &loops, NULL, NULL),
			 2); /* the flat arc; and a straight side, which keeps its two points */
	assert_int_equal(fit[0].count, high);
	assert_int_equal(fit[2].count, high);
	assert_int_equal(fit[1].count, 2);
	assert_int_equal(fit[3].count, 2);
	for (size_t c = 0; c < 4; c++) {
		assert_true(fit[c].ratio <= 1);
		polyline_free(line + c), curvefit_free(fit + c);
	}
	patchloops_free(&loops);
}

/* A ring between a circle and a square with rounded corners: no band, so nothing is changed. */
static void test_unlike(void **state)
{
	(void)state;
	struct border_chain chain[2] = {{.left = 0, .right = 1, .closed = true}, {.left = 0, .right = 2, .closed = true}};
	struct border_network border = {.chain_count = 2, .chain = chain};
	const idx_t node[4] = {NO_INDEX, NO_INDEX, NO_INDEX, NO_INDEX};
	struct patchloops loops;
	patchloops_init(&loops, &border, node, NULL, 3);
	double xyz[3 * 400];
	for (size_t i = 0; i < 400; i++) { /* a slot: two half circles of radius 1, four apart */
		const double a = -2 * PI * (double)i / 400;
		xyz[3 * i] = cos(a) + (cos(a) > 0 ? 4 : -4), xyz[3 * i + 1] = sin(a), xyz[3 * i + 2] = 0;
	}
	struct polyline line[2] = {circle(0.5, 0, 0, 1, 200), {0}};
	polyline_init(line + 1, xyz, 400, true);
	const struct curvefit_options limit = {.max = 1e-2, .mean = 1e-2, .side = 10, .least_points = 3},
				      limits[2] = {limit, limit};
	struct curvefit fit[2];
	for (size_t i = 0; i < 2; i++)
		curvefit_best(fit + i, line + i, limit);
	assert_int_equal(harmonise(fit, line, limits, &border, &loops, NULL, NULL), 0);
	for (size_t i = 0; i < 2; i++)
		polyline_free(line + i), curvefit_free(fit + i);
	patchloops_free(&loops);
}

/* In a plane a wide ring is left alone; in a narrow one the loops get the same number, or their control polygons would cross. */
static void test_plane(void **state)
{
	(void)state;
	struct border_chain chain[2] = {{.left = 0, .right = 1, .closed = true}, {.left = 0, .right = 2, .closed = true}};
	struct border_network border = {.chain_count = 2, .chain = chain};
	const idx_t node[4] = {NO_INDEX, NO_INDEX, NO_INDEX, NO_INDEX};
	const struct dense_patch patch[3] = {{.kind = PATCH_PLANE}, {.kind = PATCH_CYLINDER}, {.kind = PATCH_CYLINDER}};
	struct patchloops loops;
	patchloops_init(&loops, &border, node, NULL, 3);
	for (int narrow = 0; narrow < 2; narrow++) {
		struct polyline line[2] = {circle(1, 0, 0.3, 1, 200), circle(narrow ? 1.2 : 3, 0, 1, -1, 200)};
		struct curvefit_options limits[2];
		struct curvefit fit[2];
		for (size_t i = 0; i < 2; i++) {
			limits[i] = (struct curvefit_options){.max = i ? 1e-3 : 5e-3, .mean = 5e-3, .side = 6, .least_points = 3};
			curvefit_best(fit + i, line + i, limits[i]);
		}
		const size_t before = fit[0].count, larger = fit[1].count;
		assert_true(before < larger);
		assert_int_equal(harmonise(fit, line, limits, &border, &loops, patch, NULL), narrow);
		assert_int_equal(fit[0].count, narrow ? larger : before);
		for (size_t i = 0; i < 2; i++)
			polyline_free(line + i), curvefit_free(fit + i);
	}
	patchloops_free(&loops);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_offset), cmocka_unit_test(test_tube),   cmocka_unit_test(test_plane),
		cmocka_unit_test(test_quad),   cmocka_unit_test(test_unlike),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
