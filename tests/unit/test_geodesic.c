/* Paths on known surfaces: planes and cylinders unroll, so that the true lengths are straight lines. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "stages/geometry/geodesic.h"
#include "stages/geometry/vector.h"

static void assert_near(double got, double want, double tolerance)
{
	if (!(fabs(got - want) <= tolerance))
		fail_msg("%.17g is not within %g of %.17g", got, tolerance, want);
}

static void build(struct half *half, const idx_t *triangle, size_t triangle_count, size_t vertex_count)
{
	struct fault fault = {0};
	if (!half_build_triangles(half, triangle, triangle_count, vertex_count, &fault))
		fail_msg("%s", fault.text);
}

/* A path must be a chain of points on the half-edges that it names, as long as it says, and inside the label. */
static void check_path(const struct geodesic_path *path, const double *xyz, const struct half *half, const idx_t *label, idx_t only)
{
	double length = 0;
	for (size_t i = 0; i < path->count; i++) {
		const idx_t h = path->half[i];
		const double *a = xyz + 3 * half->origin[h], *b = xyz + 3 * half->origin[half->next[h]];
		assert_true(path->along[i] >= 0 && path->along[i] < 1);
		for (int k = 0; k < 3; k++)
			assert_near(path->xyz[3 * i + k], a[k] + path->along[i] * (b[k] - a[k]), 1e-14);
		if (label != NULL)
			assert_int_equal(label[half->face[h]], only);
		if (i > 0)
			length += distance3(path->xyz + 3 * i, path->xyz + 3 * (i - 1));
	}
	assert_near(path->length, length, 1e-13);
}

enum { N = 8, GRID = (N + 1) * (N + 1) };

/* N by N squares in the plane, each cut by the diagonal from lower left to upper right. */
static void make_grid(double xyz[3 * GRID], idx_t triangle[6 * N * N])
{
	for (int i = 0; i < GRID; i++)
		xyz[3 * i] = i % (N + 1), xyz[3 * i + 1] = i / (N + 1), xyz[3 * i + 2] = 0;
	for (int q = 0; q < N * N; q++) {
		const idx_t a = q % N + q / N * (N + 1), corner[6] = {a, a + 1, a + N + 2, a, a + N + 2, a + N + 1};
		for (int k = 0; k < 6; k++)
			triangle[6 * q + k] = corner[k];
	}
}

static void plane_grid(void **state)
{
	(void)state;
	double xyz[3 * GRID];
	idx_t triangle[6 * N * N];
	make_grid(xyz, triangle);
	struct half half;
	build(&half, triangle, 2 * N * N, GRID);
	struct geodesic *g = geodesic_new(xyz, &half, NULL, 0, 2);
	for (idx_t source = 0; source < GRID; source += 13) {
		geodesic_from(g, source);
		for (idx_t v = 0; v < GRID; v++) {
			/* Never shorter than the straight line; with two Steiner points an edge up to 6 per cent longer, straightened 3 */
			const double true_length = distance3(xyz + 3 * source, xyz + 3 * v), found = geodesic_distance(g, v);
			assert_true(found >= true_length - 1e-12);
			assert_true(found <= true_length * 1.06 + 1e-12);
			struct geodesic_path path;
			geodesic_path(&path, g, v);
			assert_true(path.length <= found + 1e-12);
			assert_true(path.length >= true_length - 1e-12);
			assert_true(path.length <= true_length * 1.03 + 1e-12);
			assert_true(path.count >= 1);
			assert_near(distance3(path.xyz, xyz + 3 * source), 0, 0);
			assert_near(distance3(path.xyz + 3 * (path.count - 1), xyz + 3 * v), 0, 0);
			check_path(&path, xyz, &half, NULL, 0);
			geodesic_path_free(&path);
		}
	}
	/* Along a row, a column and a diagonal the graph has the straight line itself. */
	geodesic_from(g, 0);
	assert_near(geodesic_distance(g, N), N, 1e-12);
	assert_near(geodesic_distance(g, GRID - 1), N * M_SQRT2, 1e-12);
	geodesic_free(g);
	half_free(&half);
}

static void cylinder_without_inner_vertices(void **state)
{
	(void)state;
	/* 24 long thin facets: edges alone force a path to run around the rim and straight up; unrolled it is a slanted line. */
	enum { SIDES = 24 };
	double xyz[6 * SIDES];
	idx_t triangle[6 * SIDES];
	for (int i = 0; i < SIDES; i++) {
		const double turn = 2 * PI * i / SIDES;
		for (int top = 0; top < 2; top++) {
			double *p = xyz + 3 * (2 * i + top);
			p[0] = cos(turn), p[1] = sin(turn), p[2] = 3.0 * top;
		}
		const idx_t a = 2 * i, b = 2 * ((i + 1) % SIDES), corner[6] = {a, b, b + 1, a, b + 1, a + 1};
		for (int k = 0; k < 6; k++)
			triangle[6 * i + k] = corner[k];
	}
	struct half half;
	build(&half, triangle, 2 * SIDES, 2 * SIDES);
	const double facet = 2 * sin(PI / SIDES), straight = hypot(SIDES / 3 * facet, 3), around = SIDES / 3 * facet + 3;
	for (int steiner = 0; steiner <= 8; steiner += 2) {
		struct geodesic *g = geodesic_new(xyz, &half, NULL, 0, steiner);
		geodesic_from(g, 0);
		/* Against the diagonals: a third of the way around and up. */
		const double found = geodesic_distance(g, 2 * (SIDES - SIDES / 3) + 1);
		assert_true(found >= straight - 1e-12);
		if (steiner == 0)
			assert_near(found, around, 1e-12);
		if (steiner == 2)
			assert_true(found < 1.07 * straight);
		if (steiner > 0) {
			struct geodesic_path path;
			geodesic_path(&path, g, 2 * (SIDES - SIDES / 3) + 1);
			check_path(&path, xyz, &half, NULL, 0);
			assert_near(path.length, straight, 1e-4 * straight);
			geodesic_path_free(&path);
		}
		geodesic_free(g);
	}
	half_free(&half);
}

static void stays_inside_its_label(void **state)
{
	(void)state;
	double xyz[3 * GRID];
	idx_t triangle[6 * N * N], label[2 * N * N];
	make_grid(xyz, triangle);
	/* A wall from below up to y = 6 in the fourth column: the way around its top is two straight lines. */
	for (int t = 0; t < 2 * N * N; t++)
		label[t] = t / 2 % N == 3 && t / 2 / N < 6;
	struct half half;
	build(&half, triangle, 2 * N * N, GRID);
	struct geodesic *g = geodesic_new(xyz, &half, label, 0, 3);
	geodesic_from(g, 0);
	const double true_length = hypot(3, 6) + 1 + hypot(4, 6);
	assert_true(geodesic_distance(g, N) >= true_length - 1e-12);
	assert_true(geodesic_distance(g, N) < 1.03 * true_length);
	struct geodesic_path path;
	geodesic_path(&path, g, N);
	check_path(&path, xyz, &half, label, 0);
	geodesic_path_free(&path);
	geodesic_free(g);

	/* Inside the wall, and from a vertex that the wall does not have. */
	g = geodesic_new(xyz, &half, label, 1, 2);
	geodesic_from(g, 3);
	assert_near(geodesic_distance(g, 3 + 6 * (N + 1)), 6, 1e-12);
	assert_true(isinf(geodesic_distance(g, 0)));
	geodesic_path(&path, g, 0);
	assert_int_equal(path.count, 0);
	geodesic_path_free(&path);
	geodesic_from(g, 0);
	assert_true(isinf(geodesic_distance(g, 3)));
	geodesic_free(g);
	g = geodesic_new(xyz, &half, label, 7, 2); /* nobody has this label */
	geodesic_from(g, 0);
	assert_true(isinf(geodesic_distance(g, 0)));
	geodesic_free(g);
	geodesic_free(NULL);
	half_free(&half);
}

static void equals_relaxation_to_the_end(void **state)
{
	(void)state;
	/* The same graph without Steiner points by the simplest method there is: relax all edges until nothing changes. */
	double xyz[3 * GRID], plain[GRID];
	idx_t triangle[6 * N * N];
	make_grid(xyz, triangle);
	uint32_t seed = 1;
	for (int i = 0; i < GRID; i++) {
		seed = seed * 1664525 + 1013904223;
		xyz[3 * i + 2] = seed / 4294967296.0 * 3;
	}
	struct half half;
	build(&half, triangle, 2 * N * N, GRID);
	for (int i = 0; i < GRID; i++)
		plain[i] = i == 40 ? 0 : INFINITY;
	for (int round = 0; round < GRID; round++)
		for (size_t h = 0; h < half.half_count; h++) {
			const idx_t a = half.origin[h], b = half.origin[half.next[h]];
			const double length = distance3(xyz + 3 * a, xyz + 3 * b);
			plain[b] = fmin(plain[b], plain[a] + length);
			plain[a] = fmin(plain[a], plain[b] + length);
		}
	struct geodesic *g = geodesic_new(xyz, &half, NULL, 0, 0);
	geodesic_from(g, 40);
	for (idx_t v = 0; v < GRID; v++)
		assert_near(geodesic_distance(g, v), plain[v], 1e-12);
	geodesic_free(g);
	half_free(&half);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(plane_grid),
		cmocka_unit_test(cylinder_without_inner_vertices),
		cmocka_unit_test(stays_inside_its_label),
		cmocka_unit_test(equals_relaxation_to_the_end),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
