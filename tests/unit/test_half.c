/* Half-edges, and the shim's simplification. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "formats/shim/openmesh.h"
#include "stages/geometry/half.h"

static void check_links(const struct half *half)
{
	for (size_t h = 0; h < half->half_count; h++) {
		assert_int_equal(half->previous[half->next[h]], h);
		assert_int_equal(half->face[half->next[h]], half->face[h]);
		if (half->twin[h] == NO_INDEX)
			continue;
		assert_int_equal(half->twin[half->twin[h]], h);
		assert_int_equal(half->origin[half->twin[h]], half->origin[half->next[h]]);
		assert_int_equal(half->origin[half->next[half->twin[h]]], half->origin[h]);
	}
	for (size_t v = 0; v < half->vertex_count; v++) {
		if (half->outgoing[v] == NO_INDEX)
			continue;
		assert_int_equal(half->origin[half->outgoing[v]], v);
		for (size_t h = 0; h < half->half_count; h++) /* at a border vertex the chosen one is the one at the border */
			if (half->origin[h] == (idx_t)v && half->twin[h] == NO_INDEX)
				assert_int_equal(half->outgoing[v], h);
	}
}

/* A tetrahedron: 4 - 6 + 4 = 2, no border. */
static void tetrahedron(void **state)
{
	(void)state;
	const idx_t triangle[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
	struct half half;
	struct fault fault = {0};
	assert_true(half_build_triangles(&half, triangle, 4, 4, &fault));
	check_links(&half);
	assert_int_equal(half_edge_count(&half), 6);
	for (size_t h = 0; h < 12; h++)
		assert_true(half.twin[h] != NO_INDEX);
	half_free(&half);
}

/* A 3 x 3 grid of vertices with one quad cut in two: 9 vertices, 5 faces, 13 edges (12 of the grid and the diagonal),
 * 8 of them at the border; and a vertex without faces. */
static void grid_with_border(void **state)
{
	(void)state;
	const idx_t corner[] = {0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 4, 8, 7};
	const size_t start[] = {0, 4, 8, 12, 15, 18};
	struct half half;
	struct fault fault = {0};
	assert_true(half_build(&half, corner, start, 5, 10, &fault));
	check_links(&half);
	assert_int_equal(half_edge_count(&half), 13);
	size_t border = 0;
	for (size_t h = 0; h < half.half_count; h++)
		border += half.twin[h] == NO_INDEX;
	assert_int_equal(border, 8);
	assert_int_equal(half.outgoing[9], NO_INDEX);
	half_free(&half);
}

/* Faces in any order, with fans that meet late: a wheel of 8 whose spokes come even first, then odd. */
static void wheel_in_any_order(void **state)
{
	(void)state;
	idx_t triangle[24];
	for (idx_t i = 0; i < 8; i++) {
		const idx_t t = i < 4 ? 2 * i : 2 * (i - 4) + 1;
		triangle[3 * i] = 8, triangle[3 * i + 1] = t, triangle[3 * i + 2] = (t + 1) % 8;
	}
	struct half half;
	struct fault fault = {0};
	assert_true(half_build_triangles(&half, triangle, 8, 9, &fault));
	check_links(&half);
	assert_int_equal(half_edge_count(&half), 16);
	half_free(&half);
}

static void refused(const idx_t *triangle, size_t count, size_t vertices, const char *why)
{
	struct half half;
	struct fault fault = {0};
	assert_false(half_build_triangles(&half, triangle, count, vertices, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	if (!strstr(fault.text, why))
		fail_msg("'%s' does not say '%s'", fault.text, why);
}

static void says_what_is_wrong(void **state)
{
	(void)state;
	refused((const idx_t[]){0, 1, 2, 1, 0, 3, 0, 1, 4}, 3, 5, "edge 0-1 has 3 faces");
	refused((const idx_t[]){0, 1, 2, 0, 1, 3}, 2, 4, "same direction");
	refused((const idx_t[]){0, 1, 2, 0, 3, 4}, 2, 5, "vertex 0 make more than one fan");
	refused((const idx_t[]){0, 1, 1}, 1, 2, "face 0 has vertex 1 twice");
	refused((const idx_t[]){0, 1, 5}, 1, 3, "vertex 5 is not in [0, 3)");
	/* Two tetrahedra that touch at a vertex: each fan is closed. */
	refused((const idx_t[]){0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 5, 4, 0, 4, 6, 4, 5, 6, 5, 0, 6}, 8, 7,
		"vertex 0 make more than one fan");
}

/* A flat square grid: n x n squares in [0, 1]^2, two triangles each. */
static idx_t *flat_grid(size_t n, double **xyz)
{
	*xyz = mem_array(3 * (n + 1) * (n + 1), sizeof **xyz);
	idx_t *triangle = mem_array(6 * n * n, sizeof *triangle);
	for (size_t j = 0; j <= n; j++)
		for (size_t i = 0; i <= n; i++) {
			(*xyz)[3 * (j * (n + 1) + i)] = (double)i / (double)n;
			(*xyz)[3 * (j * (n + 1) + i) + 1] = (double)j / (double)n;
		}
	idx_t *t = triangle;
	for (size_t j = 0; j < n; j++)
		for (size_t i = 0; i < n; i++) {
			const idx_t a = (idx_t)(j * (n + 1) + i), b = a + 1, c = b + (idx_t)n + 1, d = c - 1;
			memcpy(t, (idx_t[6]){a, b, c, a, c, d}, 6 * sizeof *t);
			t += 6;
		}
	return triangle;
}

static double flat_area(const idx_t *triangle, long count, const double *xyz)
{
	double sum = 0;
	for (long t = 0; t < count; t++) {
		const double *a = xyz + 3 * (size_t)triangle[3 * t], *b = xyz + 3 * (size_t)triangle[3 * t + 1],
			     *c = xyz + 3 * (size_t)triangle[3 * t + 2];
		const double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
		assert_true(area > 0); /* none turned over */
		sum += area;
	}
	return sum;
}

/* A square needs two triangles. Its border costs area wherever a corner goes, so the corners stay. */
static void simplify_square(void **state)
{
	(void)state;
	double *xyz;
	char message[200];
	idx_t *triangle = flat_grid(10, &xyz);
	const long left = shim_simplify(triangle, NULL, 200, xyz, 121, NULL, NULL, 0, 1e-12, 0, message, sizeof message);
	assert_int_equal(left, 2);
	assert_true(fabs(flat_area(triangle, left, xyz) - 1) < 1e-12);
	free(triangle), free(xyz);
}

/* A feature line across the middle stays an edge path from border to border, although the surface is flat; a locked vertex stays.
 */
static void simplify_keeps_features(void **state)
{
	(void)state;
	double *xyz;
	char message[200];
	idx_t *triangle = flat_grid(10, &xyz), feature[20];
	unsigned char locked[121] = {0};
	locked[3 * 11 + 7] = 1;
	for (idx_t i = 0; i < 10; i++)
		feature[2 * i] = 5 * 11 + i, feature[2 * i + 1] = 5 * 11 + i + 1;
	const long left = shim_simplify(triangle, NULL, 200, xyz, 121, locked, feature, 10, 1e-12, 0, message, sizeof message);
	/* 4 corners, 2 ends of the line, 1 locked: 7 vertices, 6 at the border: 2 * 7 - 6 - 2 triangles */
	assert_int_equal(left, 6);
	assert_true(fabs(flat_area(triangle, left, xyz) - 1) < 1e-12);
	bool has_line = false, has_locked = false;
	for (long h = 0; h < 3 * left; h++) {
		const idx_t a = triangle[h], b = triangle[h % 3 == 2 ? h - 2 : h + 1];
		has_line |= (a == 55 && b == 65) || (a == 65 && b == 55);
		has_locked |= a == 3 * 11 + 7;
	}
	assert_true(has_line && has_locked);
	free(triangle), free(xyz);
}

static void simplify_stops_at_target(void **state)
{
	(void)state;
	double *xyz;
	char message[200];
	idx_t *triangle = flat_grid(10, &xyz);
	const long left = shim_simplify(triangle, NULL, 200, xyz, 121, NULL, NULL, 0, 1e-12, 50, message, sizeof message);
	assert_true(left <= 50 && left >= 48);
	free(triangle), free(xyz);
}

/* Height of the surface over (x, y), by the triangle that lies there. */
static double height_at(const idx_t *triangle, long count, const double *xyz, double x, double y)
{
	for (long t = 0; t < count; t++) {
		const double *p[3], least = -1e-9;
		double w[3], sum = 0, z = 0;
		for (int k = 0; k < 3; k++)
			p[k] = xyz + 3 * (size_t)triangle[3 * t + k];
		for (int k = 0; k < 3; k++) {
			const double *b = p[(k + 1) % 3], *c = p[(k + 2) % 3];
			w[k] = (b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x);
			sum += w[k];
		}
		for (int k = 0; k < 3; k++)
			z += w[k] / sum * p[k][2];
		if (w[0] / sum >= least && w[1] / sum >= least && w[2] / sum >= least)
			return z;
	}
	return NAN;
}

/* On a curved sheet the error is a squared distance: with a bound of e^2 no vertex that went away is much further than e
 * from what is left, and far fewer triangles do. */
static void simplify_keeps_its_error(void **state)
{
	(void)state;
	for (double e = 1e-4; e < 2e-2; e *= 10) {
		double *xyz, worst = 0;
		char message[200];
		idx_t *triangle = flat_grid(24, &xyz);
		for (size_t v = 0; v < 625; v++)
			xyz[3 * v + 2] = 0.4 * xyz[3 * v] * xyz[3 * v] - 0.3 * xyz[3 * v + 1] * xyz[3 * v + 1];
		const long left = shim_simplify(triangle, NULL, 1152, xyz, 625, NULL, NULL, 0, e * e, 0, message, sizeof message);
		for (size_t v = 0; v < 625; v++) {
			const double z = height_at(triangle, left, xyz, xyz[3 * v], xyz[3 * v + 1]);
			assert_false(isnan(z)); /* the square is still covered */
			worst = fmax(worst, fabs(z - xyz[3 * v + 2]));
		}
		assert_true(worst < 4 * e);
		if (e > 5e-4)
			assert_true(left < 1152 / 4);
		free(triangle), free(xyz);
	}
}

static void simplify_refuses(void **state)
{
	(void)state;
	char message[200];
	const double xyz[15] = {0};
	idx_t bad[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
	assert_int_equal(shim_simplify(bad, NULL, 3, xyz, 5, NULL, NULL, 0, 1, 0, message, sizeof message), -1);
	assert_string_equal(message, "the triangles do not make a manifold");
	idx_t good[] = {0, 1, 2};
	const idx_t feature[] = {0, 4};
	assert_int_equal(shim_simplify(good, NULL, 1, xyz, 5, NULL, feature, 1, 1, 0, message, sizeof message), -1);
	assert_string_equal(message, "a feature edge is not in the mesh");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(tetrahedron),
		cmocka_unit_test(grid_with_border),
		cmocka_unit_test(wheel_in_any_order),
		cmocka_unit_test(says_what_is_wrong),
		cmocka_unit_test(simplify_square),
		cmocka_unit_test(simplify_keeps_features),
		cmocka_unit_test(simplify_stops_at_target),
		cmocka_unit_test(simplify_keeps_its_error),
		cmocka_unit_test(simplify_refuses),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
