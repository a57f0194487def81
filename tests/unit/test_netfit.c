/* Whole networks on meshes whose curves are known (the patch method's sections 4.6 and 4.8). */
#include <math.h>
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/fitcurves/netfit.h"
#include "stages/geometry/vector.h"

static void assert_near(double value, double wanted, double tolerance)
{
	if (!(fabs(value - wanted) <= tolerance))
		fail_msg("%.17g is not %.17g +- %g", value, wanted, tolerance);
}

static struct dense make(const double *xyz, size_t vertex_count, const idx_t *triangle, const idx_t *label, size_t triangle_count,
			 size_t patch_count)
{
	struct dense d = {.vertex_count = vertex_count, .triangle_count = triangle_count, .patch_count = patch_count};
	d.xyz = mem_copy(xyz, 3 * vertex_count, sizeof *xyz);
	d.triangle = mem_copy(triangle, 3 * triangle_count, sizeof *triangle);
	d.label = mem_copy(label, triangle_count, sizeof *label);
	return d;
}

static struct network fit(struct netfit_report *report, const struct dense *dense, double max)
{
	struct border_network border;
	struct fault fault = {0};
	struct network network;
	assert_true(border_extract(&border, dense, BORDER_DEFAULTS, &fault));
	netfit(&network, report, dense, &border, (struct netfit_options){.max = max, .mean = max / 2});
	border_free(&border);
	return network;
}

/* What every network keeps: points named by curves exist, nodes come first, no double edges, closed curves of three. */
static void check_rules(const struct network *n)
{
	for (size_t c = 0; c < n->curve_count; c++) {
		const struct curve *curve = n->curve + c;
		assert_true(curve->count >= (curve->closed ? 3 : 2));
		for (size_t i = 0; i < curve->count; i++) {
			assert_true((size_t)n->point[curve->first + i] < n->vertex_count);
			const bool is_end = !curve->closed && (i == 0 || i + 1 == curve->count);
			assert_int_equal(n->kind[n->point[curve->first + i]] == POINT_CREASE, !is_end);
		}
		if (!curve->closed && n->point[curve->first] == n->point[curve->first + curve->count - 1])
			assert_true(curve->count >= 4);
		assert_near(curve->length, network_curve_length(n, curve), 0);
		assert_false(network_curve_edited(n, curve));
		for (size_t o = 0; o < c; o++) {
			const struct curve *other = n->curve + o;
			if (curve->count != 2 || other->count != 2)
				continue;
			const idx_t a = n->point[curve->first], b = n->point[curve->first + 1], p = n->point[other->first],
				    q = n->point[other->first + 1];
			assert_false((a == p && b == q) || (a == q && b == p));
		}
	}
}

static const double cube_xyz[24] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
static const idx_t cube_triangle[36] = {0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
					1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
static const idx_t cube_label[12] = {0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5};

static void test_cube(void **state)
{
	(void)state;
	struct dense d = make(cube_xyz, 8, cube_triangle, cube_label, 12, 6);
	struct netfit_report report;
	struct network n = fit(&report, &d, 2e-3);
	assert_int_equal(n.vertex_count, 8);
	assert_int_equal(n.curve_count, 12);
	assert_int_equal(report.straight, 12);
	assert_near(report.error, 0, 1e-15);
	check_rules(&n);
	network_free(&n);
	dense_free(&d);
}

/* A capped cylinder of 64 facets, radius 0.5, height 1: patches side, top, bottom. */
static struct dense cylinder(size_t facets)
{
	double *xyz = mem_array(3 * (2 * facets + 2), sizeof *xyz);
	idx_t *triangle = mem_array(12 * facets, sizeof *triangle), *label = mem_array(4 * facets, sizeof *label);
	for (size_t i = 0; i < facets; i++)
		for (size_t z = 0; z < 2; z++) {
			double *p = xyz + 3 * (2 * i + z);
			p[0] = 0.5 * cos(2 * PI * (double)i / (double)facets),
			p[1] = 0.5 * sin(2 * PI * (double)i / (double)facets), p[2] = (double)z;
		}
	const idx_t low = (idx_t)(2 * facets), high = low + 1;
	xyz[3 * high + 2] = 1;
	for (size_t i = 0; i < facets; i++) {
		const idx_t a = (idx_t)(2 * i), b = (idx_t)(2 * ((i + 1) % facets));
		const idx_t corner[12] = {a, b, b + 1, a, b + 1, a + 1, a + 1, b + 1, high, b, a, low};
		memcpy(triangle + 12 * i, corner, sizeof corner);
		label[4 * i + 2] = 1, label[4 * i + 3] = 2;
	}
	struct dense d = make(xyz, 2 * facets + 2, triangle, label, 4 * facets, 3);
	free(xyz), free(triangle), free(label);
	return d;
}

/* Its two circles become closed curves with the same six points (table 4.5), one above the other, all crease points. */
static void test_cylinder(void **state)
{
	(void)state;
	struct dense d = cylinder(64);
	struct netfit_report report;
	struct network n = fit(&report, &d, 1.5e-3);
	assert_int_equal(n.curve_count, 2);
	assert_int_equal(report.closed, 2);
	assert_int_equal(report.nodes, 0);
	assert_int_equal(n.vertex_count, 12);
	assert_true(report.error <= 1.5e-3);
	check_rules(&n);
	for (size_t i = 0; i < 6; i++) {
		double nearest = INFINITY;
		for (size_t j = 0; j < 6; j++) {
			const double *p = n.xyz + 3 * (size_t)n.point[n.curve[0].first + i],
				     *q = n.xyz + 3 * (size_t)n.point[n.curve[1].first + j];
			nearest = fmin(nearest, hypot(p[0] - q[0], p[1] - q[1]));
		}
		assert_near(nearest, 0, 0.01);
	}
	network_free(&n);
	dense_free(&d);
}

/* A lens of two nearly straight borders between the same two nodes: one of them gets an inner point. */
static void test_double(void **state)
{
	(void)state;
	static const double xyz[18] = {0, 0, 0, 1, 0, 0, 0.5, 5e-4, 0, 0.5, -5e-4, 0, 0.5, 1, 0, 0.5, -1, 0};
	static const idx_t triangle[18] = {0, 2, 4, 2, 1, 4, 0, 5, 3, 3, 5, 1, 0, 3, 2, 2, 3, 1}, label[6] = {0, 0, 2, 2, 1, 1};
	struct dense d = make(xyz, 6, triangle, label, 6, 3);
	struct netfit_report report;
	struct network n = fit(&report, &d, 2e-3);
	assert_int_equal(report.split, 1);
	check_rules(&n);
	network_free(&n);
	dense_free(&d);
}

/* Four patches that nearly meet in one point: the tiny border between two of them becomes a node. */
static void test_contract(void **state)
{
	(void)state;
	static const idx_t triangle[18] = {0, 1, 5, 0, 5, 4, 1, 2, 5, 2, 3, 4, 2, 4, 5, 3, 0, 4}, label[6] = {0, 0, 1, 2, 2, 3};
	for (int far = 0; far < 2; far++) {
		const double e = far ? 0.1 : 1e-4;
		const double xyz[18] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, -e, 0, 0, e, 0, 0};
		struct dense d = make(xyz, 6, triangle, label, 6, 4);
		struct netfit_report report;
		struct network n = fit(&report, &d, 2e-3);
		assert_int_equal(report.contracted, !far);
		assert_int_equal(report.nodes, far ? 6 : 5);
		assert_int_equal(n.curve_count, far ? 9 : 8);
		check_rules(&n);
		network_free(&n);
		dense_free(&d);
	}
}

/* Three patches around two nodes that are close, one of which knows both: they stay apart, or it would be pinched. */
static void test_no_pinch(void **state)
{
	(void)state;
	/* patch 1 is a triangle beside the tiny border, with two other sides: contracting would leave it two */
	static const idx_t triangle[18] = {0, 1, 5, 0, 5, 4, 1, 2, 5, 2, 3, 4, 2, 4, 5, 3, 0, 4}, label[6] = {0, 0, 2, 3, 1, 3};
	const double e = 1e-4, xyz[18] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, -e, 0, 0, e, 0, 0};
	struct dense d = make(xyz, 6, triangle, label, 6, 4);
	struct netfit_report report;
	struct network n = fit(&report, &d, 2e-3);
	assert_int_equal(report.contracted, 0);
	check_rules(&n);
	network_free(&n);
	dense_free(&d);
}

static bool has_point(const struct network *n, double x, double y)
{
	for (size_t i = 0; i < n->vertex_count; i++)
		if (hypot(n->xyz[3 * i] - x, n->xyz[3 * i + 1] - y) < 1e-12)
			return true;
	return false;
}

/* A patch with four sides, two of them short: one may become a node, and that is the shorter one, wherever the numbering begins. */
static void test_contract_shortest(void **state)
{
	(void)state;
	static const double inner[8] = {-4e-4, 0, 4e-4, 0, 5e-5, 0.1, -5e-5, 0.1}, outer[8] = {-1, -1, 1, -1, 1, 1, -1, 1};
	for (size_t turn = 0; turn < 4; turn++) {
		double xyz[24] = {0};
		idx_t triangle[30], p[4];
		const idx_t label[10] = {1, 1, 2, 2, 3, 3, 4, 4, 0, 0};
		for (size_t k = 0; k < 4; k++) {
			p[k] = (idx_t)((k + turn) % 4);
			memcpy(xyz + 3 * (size_t)p[k], inner + 2 * k, 2 * sizeof *inner);
			memcpy(xyz + 3 * (4 + k), outer + 2 * k, 2 * sizeof *outer);
		}
		for (size_t k = 0; k < 4; k++) {
			const size_t l = (k + 1) % 4;
			const idx_t two[6] = {(idx_t)(4 + k), (idx_t)(4 + l), p[l], (idx_t)(4 + k), p[l], p[k]};
			memcpy(triangle + 6 * k, two, sizeof two);
		}
		const idx_t quad[6] = {p[0], p[1], p[2], p[0], p[2], p[3]};
		memcpy(triangle + 24, quad, sizeof quad);
		struct dense d = make(xyz, 8, triangle, label, 10, 5);
		struct netfit_report report;
		struct network n = fit(&report, &d, 2e-3);
		assert_int_equal(report.contracted, 1);
		assert_true(has_point(&n, 0, 0.1));
		assert_true(has_point(&n, -4e-4, 0) && has_point(&n, 4e-4, 0));
		check_rules(&n);
		network_free(&n);
		dense_free(&d);
	}
}

/* The border between two free-form halves of a dome runs in steps of whole triangles; the curve does not follow them. */
static void test_loose(void **state)
{
	(void)state;
	enum { N = 24 };
	double xyz[3 * (N + 1) * (N + 1)];
	idx_t triangle[6 * N * N], label[2 * N * N];
	for (size_t j = 0; j <= N; j++)
		for (size_t i = 0; i <= N; i++) {
			double *p = xyz + 3 * (j * (N + 1) + i);
			p[0] = (double)i / N, p[1] = (double)j / N, p[2] = 0.3 * (p[0] * (1 - p[0]) + p[1] * (1 - p[1]));
		}
	for (size_t j = 0; j < N; j++)
		for (size_t i = 0; i < N; i++) {
			const idx_t a = (idx_t)(j * (N + 1) + i), c = a + N + 2, corner[6] = {a, a + 1, c, a, c, a + N + 1};
			memcpy(triangle + 6 * (j * N + i), corner, sizeof corner);
			label[2 * (j * N + i)] = label[2 * (j * N + i) + 1] =
				2 * i + j % 2 * 2 < N; /* steps of one square to and fro */
		}
	struct dense d = make(xyz, (N + 1) * (N + 1), triangle, label, 2 * N * N, 2);
	d.patch = mem_array(2, sizeof *d.patch);
	d.patch[0] = (struct dense_patch){.kind = PATCH_FREE, .parent = 0};
	d.patch[1] = (struct dense_patch){.kind = PATCH_FREE, .parent = 1};
	struct netfit_report report;
	struct network n = fit(&report, &d, 2e-3);
	check_rules(&n);
	size_t found = 0;
	for (size_t c = 0; c < n.curve_count; c++) {
		if (n.curve[c].right < 0)
			continue;
		found++;
		assert_int_equal(n.curve[c].kind, CURVE_SMOOTH);
		assert_true(n.curve[c].count <= 6);
		assert_true(n.curve[c].error < 1.0 / N);
		assert_true(n.curve[c].error > 0.2 / N); /* it leaves the steps, and says by how much */
	}
	assert_int_equal(found, 1);
	assert_int_equal(report.relaxed, 1);
	network_free(&n);
	dense_free(&d);
}

/* The same bytes with one thread and with four. */
static void test_threads(void **state)
{
	(void)state;
	struct dense d = cylinder(40);
	struct netfit_report report;
	const int before = omp_get_max_threads();
	omp_set_num_threads(1);
	struct network a = fit(&report, &d, 1e-3);
	omp_set_num_threads(4);
	struct network b = fit(&report, &d, 1e-3);
	omp_set_num_threads(before);
	assert_int_equal(a.vertex_count, b.vertex_count);
	assert_memory_equal(a.xyz, b.xyz, 3 * a.vertex_count * sizeof *a.xyz);
	network_free(&a), network_free(&b);
	dense_free(&d);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_cube),     cmocka_unit_test(test_cylinder), cmocka_unit_test(test_double),
		cmocka_unit_test(test_contract), cmocka_unit_test(test_contract_shortest), cmocka_unit_test(test_no_pinch), cmocka_unit_test(test_loose),
		cmocka_unit_test(test_threads),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
