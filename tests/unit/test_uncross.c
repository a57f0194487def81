/* Control polygons on one plane end apart. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/fitcurves/uncross.h"
#include "stages/geometry/vector.h"

/* A bore of radius 1 around (x, 0) in the plane y = 2 z, seen from above. */
static struct polyline bore(double x)
{
	double xyz[600];
	for (size_t i = 0; i < 200; i++) {
		const double a = -2 * PI * (double)i / 200, v = sin(a);
		xyz[3 * i] = x + cos(a), xyz[3 * i + 1] = v * 2 / sqrt(5), xyz[3 * i + 2] = v / sqrt(5);
	}
	struct polyline line;
	polyline_init(&line, xyz, 200, true);
	return line;
}

/* Crossing number of the control polygon around a point, in the coordinates x and y, in which the plane is seen in full. */
static bool is_inside(const struct curvefit *fit, const double p[3])
{
	bool inside = false;
	for (size_t i = 0; i < fit->count; i++) {
		const double *a = fit->xyz + 3 * i, *b = fit->xyz + 3 * ((i + 1) % fit->count);
		if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]))
			inside = !inside;
	}
	return inside;
}

static size_t invaders(const struct curvefit *a, const struct curvefit *b)
{
	size_t count = 0;
	for (size_t i = 0; i < a->count; i++)
		count += is_inside(b, a->xyz + 3 * i);
	for (size_t i = 0; i < b->count; i++)
		count += is_inside(a, b->xyz + 3 * i);
	return count;
}

/* Two bores three tenths of their radius apart, four points each: squares of 1.52 radii with their corners in each other. On
 * a plane they get more points until they are apart; the one whose class is larger gets fewer. On a cylinder's side
 * nothing is done. */
static void test_bores(void **state)
{
	(void)state;
	struct border_chain chain[2] = {{.left = 0, .right = 1, .closed = true}, {.left = 0, .right = 2, .closed = true}};
	const struct border_network border = {.chain_count = 2, .chain = chain};
	struct dense_patch patch[3] = {{.kind = PATCH_PLANE, .axis = {0, -1 / sqrt(5), 2 / sqrt(5)}},
				       {.kind = PATCH_CYLINDER},
				       {.kind = PATCH_CYLINDER}};
	struct polyline line[2] = {bore(0), bore(2.3)};
	const struct curvefit_options limit = {.max = 0.1, .mean = 0.1, .side = 5, .least_points = 3}, limits[2] = {limit, limit};
	const size_t class_size[2] = {5, 1};
	struct curvefit fit[2];
	for (size_t i = 0; i < 2; i++)
		curvefit_exact(fit + i, line + i, limit, 4);
	assert_true(invaders(fit, fit + 1) > 0);
	patch[0].kind = PATCH_TORUS;
	assert_int_equal(uncross(fit, line, limits, &border, NULL, patch, 3, class_size), 0);
	patch[0].kind = PATCH_PLANE;
	int rounds = 0;
	while (uncross(fit, line, limits, &border, NULL, patch, 3, class_size) > 0)
		assert_true(++rounds < 20);
	assert_true(rounds > 0);
	assert_int_equal(invaders(fit, fit + 1), 0);
	assert_true(fit[0].count < fit[1].count);
	for (size_t i = 0; i < 2; i++)
		polyline_free(line + i), curvefit_free(fit + i);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_bores),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
