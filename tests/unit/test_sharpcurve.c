/* Distances of polylines of known shape to curves of known shape. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "stages/fitpatch/sharpcurve.h"
#include "stages/geometry/vector.h"

static void assert_near(double got, double want, double within)
{
	if (!(fabs(got - want) <= within))
		fail_msg("%.17g is not %.17g", got, want);
}

enum { ROOM = 128 };

/* One chain and the curve that follows it. */
struct scene {
	double chain_xyz[3 * ROOM], control_xyz[3 * ROOM];
	idx_t chain_vertex[ROOM], curve_point[ROOM];
	unsigned char role[ROOM];
	struct border_chain chain;
	struct curve curve;
};

static double measure(struct scene *s)
{
	for (idx_t i = 0; i < ROOM; i++)
		s->chain_vertex[i] = s->curve_point[i] = i;
	struct dense dense = {.xyz = s->chain_xyz};
	struct border_network border = {.chain_count = 1, .chain = &s->chain, .vertex = s->chain_vertex};
	const struct target target = {.dense = &dense, .border = &border};
	struct draft draft = {.control = {.xyz = s->control_xyz, .role = s->role, .count = s->curve.count},
	                      .network = {.curve = &s->curve, .curve_count = 1, .point = s->curve_point}};
	const idx_t chain_of_curve = 0;
	return sharpcurve_distance(&draft, &target, &chain_of_curve);
}

static void put(double *xyz, size_t *count, double x, double y)
{
	xyz[3 * *count] = x, xyz[3 * *count + 1] = y, xyz[3 * (*count)++ + 2] = 0;
}

/* A straight line a tenth beside another. */
static void test_straight(void **state)
{
	(void)state;
	struct scene s = {0};
	for (int i = 0; i <= 10; i++)
		put(s.chain_xyz, &s.chain.count, i, 0);
	put(s.control_xyz, &s.curve.count, 0, 0.1);
	put(s.control_xyz, &s.curve.count, 10, 0.1);
	assert_near(measure(&s), 0.1, 1e-12);
	/* one side of ten is more than one in a hundred */
	s.chain_xyz[3 * 10 + 1] = 1;
	assert_near(measure(&s), 0.4, 1e-12);
	s.chain.kind = CURVE_SMOOTH; /* none of the sharp ones */
	assert_near(measure(&s), 0, 0);
}

/* The limit of a regular polygon's control point is (4 + 2 cos(2 pi / n)) / 6 of it from the centre; between them the curve is as good as round for
 * n = 16. The middles of the chain's sides are cos(pi / 64) from the centre. */
static void test_round(void **state)
{
	(void)state;
	struct scene s = {0};
	const double r = 6 / (4 + 2 * cos(2 * PI / 16));
	for (int i = 0; i < 64; i++)
		put(s.chain_xyz, &s.chain.count, cos(2 * PI * i / 64), sin(2 * PI * i / 64));
	for (int i = 0; i < 16; i++) {
		s.role[i] = POINT_CREASE;
		put(s.control_xyz, &s.curve.count, r * cos(2 * PI * i / 16), r * sin(2 * PI * i / 16));
	}
	s.chain.closed = s.curve.closed = true;
	assert_near(measure(&s), 1 - cos(PI / 64), 4e-4);
}

/* Around a right angle: a corner is kept; a point of the curve is not, its limit is a third of the way to the middle of its neighbours. The last
 * one in a hundred of the length, beside the corner itself, does not count. */
static void test_corner(void **state)
{
	(void)state;
	struct scene s = {0};
	for (int i = 0; i < 50; i++)
		put(s.chain_xyz, &s.chain.count, i / 50.0, 0);
	for (int i = 0; i <= 50; i++)
		put(s.chain_xyz, &s.chain.count, 1, i / 50.0);
	put(s.control_xyz, &s.curve.count, 0, 0), put(s.control_xyz, &s.curve.count, 1, 0), put(s.control_xyz, &s.curve.count, 1, 1);
	s.role[1] = POINT_CORNER;
	assert_near(measure(&s), 0, 1e-9);
	s.role[1] = POINT_CREASE;
	const double middle = sqrt(0.5) / 3; /* 1/3 of the way to (1/2, 1/2) */
	assert_near(measure(&s), middle - 0.01, 0.008);
	/* the same around a closed square, which begins between its corners: all four corners are kept */
	struct scene square = {0};
	const double at[8][2] = {{0.5, 0}, {1, 0}, {1, 0.5}, {1, 1}, {0.5, 1}, {0, 1}, {0, 0.5}, {0, 0}};
	for (int i = 0; i < 8; i++) {
		put(square.chain_xyz, &square.chain.count, at[i][0], at[i][1]);
		square.role[i] = i % 2 ? POINT_CORNER : POINT_CREASE;
		put(square.control_xyz, &square.curve.count, at[i][0], at[i][1]);
	}
	square.chain.closed = square.curve.closed = true;
	assert_near(measure(&square), 0, 1e-9);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_straight),
		cmocka_unit_test(test_round),
		cmocka_unit_test(test_corner),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
