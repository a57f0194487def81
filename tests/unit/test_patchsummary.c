/* What is said of a labelled mesh, on one whose loops, curves and worst place are known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/geometry/patchsummary.h"

enum { N = 16, MIDDLE = N / 2 };

/* A square of N by N squares in the plane, its middle quarter a patch of its own with its middle vertex 0.01 too high. */
static struct dense window(void)
{
	struct dense d = {.vertex_count = (N + 1) * (N + 1), .triangle_count = 2 * N * N, .patch_count = 2};
	d.xyz = mem_array(3 * d.vertex_count, sizeof *d.xyz);
	d.triangle = mem_array(3 * d.triangle_count, sizeof *d.triangle);
	d.label = mem_array(d.triangle_count, sizeof *d.label);
	d.patch = mem_array(2, sizeof *d.patch);
	for (int p = 0; p < 2; p++)
		d.patch[p] = (struct dense_patch){.kind = PATCH_PLANE, .axis = {0, 0, 1}, .parent = p};
	for (int v = 0; v < (N + 1) * (N + 1); v++) {
		d.xyz[3 * v] = v % (N + 1);
		d.xyz[3 * v + 1] = v / (N + 1);
	}
	d.xyz[3 * (MIDDLE * (N + 1) + MIDDLE) + 2] = 0.01;
	for (int s = 0; s < N * N; s++) {
		const int i = s % N, j = s / N, a = j * (N + 1) + i;
		const idx_t corner[6] = {a, a + 1, a + N + 2, a, a + N + 2, a + N + 1};
		for (int k = 0; k < 6; k++)
			d.triangle[6 * s + k] = corner[k];
		d.label[2 * s] = d.label[2 * s + 1] = i >= N / 4 && i < 3 * N / 4 && j >= N / 4 && j < 3 * N / 4;
	}
	return d;
}

static void summary_of_window(void **state)
{
	(void)state;
	struct dense d = window();
	struct patch_summary s;
	struct fault fault = {0};
	assert_true(patch_summarise(&s, &d, &fault));
	/* four sides outside, four around the window, a node at each of their corners */
	assert_int_equal(s.curves[CURVE_BORDER], 4);
	assert_int_equal(s.curves[CURVE_SMOOTH], 4);
	assert_int_equal(s.curves[CURVE_SHARP], 0);
	assert_int_equal(s.nodes, 8);
	/* the frame has an outer and an inner loop, the window one */
	assert_int_equal(s.loops, 3);
	assert_int_equal(s.most_loops, 0);
	assert_int_equal(s.most_loops_count, 2);
	assert_int_equal(s.closed, 0);
	assert_int_equal(s.handled, 0);
	assert_int_equal(s.genus, 0);
	assert_int_equal(s.worst, 1);
	assert_true(fabs(s.worst_distance - 0.01) < 1e-15);
	assert_true(fabs(s.worst_at[0] - MIDDLE) < 1e-15 && fabs(s.worst_at[1] - MIDDLE) < 1e-15 && fabs(s.worst_at[2] - 0.01) < 1e-15);
	/* free patches have no surface to be off */
	d.patch[0].kind = d.patch[1].kind = PATCH_FREE;
	assert_true(patch_summarise(&s, &d, &fault));
	assert_int_equal(s.worst, NO_INDEX);
	dense_free(&d);
}

static void summary_of_closed(void **state)
{
	(void)state;
	/* a tetrahedron of one patch: closed, no loops, no handles, no curves */
	const double xyz[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
	const idx_t triangle[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
	struct dense d = {.vertex_count = 4, .triangle_count = 4, .patch_count = 1};
	d.xyz = mem_copy(xyz, 12, sizeof *xyz);
	d.triangle = mem_copy(triangle, 12, sizeof *triangle);
	d.label = mem_array(4, sizeof *d.label);
	d.patch = mem_array(1, sizeof *d.patch);
	d.patch[0].kind = PATCH_FREE;
	struct patch_summary s;
	struct fault fault = {0};
	assert_true(patch_summarise(&s, &d, &fault));
	assert_int_equal(s.closed, 1);
	assert_int_equal(s.loops, 0);
	assert_int_equal(s.genus, 0);
	assert_int_equal(s.curves[CURVE_SHARP] + s.curves[CURVE_SMOOTH] + s.curves[CURVE_BORDER], 0);
	dense_free(&d);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(summary_of_window), cmocka_unit_test(summary_of_closed)};
	return cmocka_run_group_tests_name("patchsummary", tests, NULL, NULL);
}
