/* Cages on grids: as coarse as the tolerance allows, nothing collapsed, and the unpacked surface where it was. */
#include "tests/unit/ffx_helpers.h"

#include "formats/mesh.h"
#include "stages/facefix/cheaper.h"
#include "stages/facefix/gridfit.h"
#include "stages/facefix/gridmend.h"
#include "stages/geometry/subdivide.h"
#include "stages/geometry/trimesh.h"
#include "stages/geometry/vector.h"

/* A hexagonal prism around the z axis with a ring half-way: its smooth side is nearly a cylinder. */
static struct cage prism(double radius, double height)
{
	const double profile[3][2] = {{radius, 0}, {radius, height / 2}, {radius, height}};
	struct cage cage = sample_turned(profile, 3, 6, false);
	sample_tag(&cage, 70, 0);
	return cage;
}

/* Each coordinate moves by half a step at most, faces and flags stay. */
static void test_rounding(void **state)
{
	(void)state;
	struct cage cage = prism(30, 100), back;
	for (size_t v = 0; v < cage.vertex_count; v++)
		cage.xyz[3 * v] -= 1234.5;
	for (unsigned code = 10; code < FFX_GRID_CODES; code += 9) {
		struct ffx ffx;
		struct fault fault = {0};
		assert_true(gridfit_round(&ffx, &cage, code, false, &fault));
		ffx_to_cage(&back, &ffx);
		for (size_t i = 0; i < 3 * cage.vertex_count; i++)
			assert_near(back.xyz[i], cage.xyz[i], 0.69 * ffx.frame.step + 1e-4);
		/* The ends of the longest side are where they were up to the frame. */
		assert_near(back.xyz[2], 0, ffx.frame.step / 15.9);
		assert_near(back.xyz[3 * 12 + 2], 100, 3 * ffx.frame.step / 15.9);
		cage_free(&back);
		ffx_free(&ffx);
	}
	cage_free(&cage);
}

/* The chosen grid keeps the tolerance, measured here vertex by vertex with plain distances, and a tenfold tolerance gives a
 * coarser one. */
static void test_choice(void **state)
{
	(void)state;
	struct cage cage = prism(31.7, 100);
	sample_seed(3);
	sample_move(&cage, 0.8, true);
	unsigned last = FFX_GRID_CODES;
	for (double tolerance = 0.001; tolerance < 2; tolerance *= 10) {
		struct gridfit_choice choice;
		struct fault fault = {0};
		assert_true(gridfit_choose(&choice, &cage, tolerance, &fault));
		assert_true(choice.mean <= tolerance && choice.max <= 8 * tolerance);
		assert_true(choice.grid_code < last);
		last = choice.grid_code;
		struct ffx ffx;
		struct cage rounded;
		struct level a, b, fine_a, fine_b;
		assert_true(gridfit_round(&ffx, &cage, choice.grid_code, false, &fault));
		ffx_to_cage(&rounded, &ffx);
		assert_true(level_from_cage(&a, &cage, &fault) && level_from_cage(&b, &rounded, &fault));
		level_refine(&fine_a, &a, cage.scheme, 3);
		level_refine(&fine_b, &b, cage.scheme, 3);
		double mean = 0;
		for (size_t v = 0; v < fine_a.vertex_count; v++)
			mean += distance3(fine_a.xyz + 3 * v, fine_b.xyz + 3 * v) / (double)fine_a.vertex_count;
		/* The distance of corresponding points is at most about sqrt(3) times that along the normal here, where errors go
		 * all ways, and the frame is off by less than a fifth of a step. */
		assert_true(mean <= 2.5 * tolerance + 0.2 * ffx.frame.step);
		level_free(&fine_a);
		level_free(&fine_b);
		level_free(&a);
		level_free(&b);
		cage_free(&rounded);
		ffx_free(&ffx);
	}
	cage_free(&cage);
}

/* A plate whose coordinates are off their planes by about half a step: cheaper rounding finds planes again, within the tolerance
 * measured anew, 1.3 steps of each exact value, and without new collapses. */
static void test_cheaper(void **state)
{
	(void)state;
	sample_seed(11);
	struct cage cage = sample_plate(3, 2, 0.3, 0.5);
	sample_tag(&cage, 30, 0);
	for (size_t i = 0; i < 3 * cage.vertex_count; i++)
		cage.xyz[i] = 100 * cage.xyz[i] + sample_real(-0.7, 0.7);
	const double tolerance = 0.3;
	struct gridfit_choice choice;
	struct fault fault = {0};
	struct ffx ffx;
	struct cheaper_report report;
	assert_true(gridfit_choose(&choice, &cage, tolerance, &fault));
	assert_true(gridfit_round(&ffx, &cage, choice.grid_code, false, &fault));
	assert_true(cheaper_round(&ffx, &report, &cage, tolerance, 0, &fault));
	assert_true(report.moved > 3 && report.tried >= report.moved);
	assert_true(report.bytes_after < 0.97 * report.bytes_before);
	struct gridfit_ruler ruler;
	double mean, max;
	assert_true(gridfit_ruler_start(&ruler, &cage, &fault));
	gridfit_deviation(&mean, &max, &ruler, &ffx);
	gridfit_ruler_free(&ruler);
	assert_near(mean, report.mean, 1e-12);
	assert_true(mean <= tolerance && max <= 8 * tolerance);
	struct cage rounded;
	ffx_to_cage(&rounded, &ffx);
	for (size_t i = 0; i < 3 * cage.vertex_count; i++)
		assert_near(rounded.xyz[i], cage.xyz[i], 1.3 * ffx.frame.step * (1 + 1e-6) + 1e-4);
	const struct gridfit_damage damage = gridfit_check(&cage, &ffx, 4 * tolerance);
	assert_int_equal(damage.collapsed + damage.turned, 0);
	size_t size;
	struct ffx_report packed;
	unsigned char *bytes;
	assert_true(ffx_encode(&bytes, &size, &packed, &ffx, &(struct ffx_options){.root_limit = 1}, &fault));
	assert_near(packed.bytes_c + packed.bytes_g + packed.bytes_f, report.bytes_after, 1e-9);
	free(bytes);
	cage_free(&rounded);
	ffx_free(&ffx);
	cage_free(&cage);
}

/* Two vertices of a face that a coarse grid puts at one place; the tolerance alone would not mind. */
static void test_collapse(void **state)
{
	(void)state;
	struct cage cage = {0};
	const double at[10][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},     {0, 0, 1},
				  {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {1, 0.999, 0}, {1, 0.999, 1}};
	for (int i = 0; i < 10; i++)
		sample_vertex(&cage, at[i][0], at[i][1], at[i][2]);
	sample_face(&cage, (idx_t[]){3, 2, 8, 1, 0}, 5);
	sample_face(&cage, (idx_t[]){4, 5, 9, 6, 7}, 5);
	sample_quad(&cage, 0, 1, 5, 4);
	sample_quad(&cage, 1, 8, 9, 5);
	sample_quad(&cage, 8, 2, 6, 9);
	sample_quad(&cage, 2, 3, 7, 6);
	sample_quad(&cage, 3, 0, 4, 7);
	struct ffx ffx;
	struct fault fault = {0};
	assert_true(gridfit_round(&ffx, &cage, ffx_grid_code(127), false, &fault));
	const struct gridfit_damage coarse = gridfit_check(&cage, &ffx, 1e-4);
	assert_int_equal(coarse.collapsed, 3); /* both ends and the thin side */
	ffx_free(&ffx);
	assert_true(gridfit_round(&ffx, &cage, ffx_grid_code(2047), false, &fault));
	const struct gridfit_damage fine = gridfit_check(&cage, &ffx, 1e-4);
	assert_int_equal(fine.collapsed, 0);
	assert_int_equal(fine.turned, 0);
	ffx_free(&ffx);
	/* Moved apart by a step they need no grid that is finer than the gap of 0.001. */
	struct gridfit_choice choice;
	assert_true(gridfit_choose(&choice, &cage, 0.01, &fault));
	assert_true(choice.mean <= 0.01 && choice.max <= 0.08);
	assert_true(ffx_grid_steps(choice.grid_code) < 400);
	assert_true(gridfit_round(&ffx, &cage, choice.grid_code, false, &fault));
	struct gridmend_report report;
	gridmend(&ffx, &report, &cage, 0.04);
	assert_true(report.found > 0 && report.moved > 0);
	assert_int_equal(report.left, 0);
	const struct gridfit_damage mended = gridfit_check(&cage, &ffx, 0.04);
	assert_int_equal(mended.collapsed + mended.turned + mended.overlaid, 0);
	ffx_free(&ffx);
	cage_free(&cage);
}

#define GRID_14 15 /* a grid of 14 steps */

static int compare_pairs(const void *left, const void *right)
{
	const idx_t *a = left, *b = right;
	const int k = a[0] == b[0];
	return (a[k] > b[k]) - (a[k] < b[k]);
}

/* A block of 14 steps a side on a grid of 14, all its edges sharp, so that it is refined in straight lines. Its top is a triangle
 * on the front edge, with its tip at (x, y), and three more around that. */
static struct cage block_with_tip(double x, double y)
{
	struct cage cage = {0};
	for (int v = 0; v < 8; v++)
		sample_vertex(&cage, v & 1 ? 14 : 0, v & 2 ? 14 : 0, v & 4 ? 14 : 0);
	sample_vertex(&cage, x, y, 14);
	sample_quad(&cage, 0, 2, 3, 1);
	sample_quad(&cage, 0, 1, 5, 4);
	sample_quad(&cage, 1, 3, 7, 5);
	sample_quad(&cage, 3, 2, 6, 7);
	sample_quad(&cage, 2, 0, 4, 6);
	const idx_t rim[] = {4, 5, 7, 6, 4};
	for (int i = 0; i < 4; i++)
		sample_face(&cage, (idx_t[]){rim[i], rim[i + 1], 8}, 3);
	cage.sharp = mem_array(2 * 16, sizeof *cage.sharp);
	for (size_t f = 0; f < cage.face_count; f++) {
		const idx_t *corner = sample_corners(&cage, f);
		const size_t n = sample_degree(&cage, f);
		for (size_t i = 0; i < n; i++)
			if (corner[i] < corner[(i + 1) % n]) { /* each edge once */
				cage.sharp[2 * cage.sharp_count] = corner[i];
				cage.sharp[2 * cage.sharp_count++ + 1] = corner[(i + 1) % n];
			}
	}
	assert_int_equal(cage.sharp_count, 16);
	qsort(cage.sharp, cage.sharp_count, 2 * sizeof *cage.sharp, compare_pairs);
	return cage;
}

/* Edges of more than two faces when the refined cage is written vertex by vertex and welded again, as STL is. */
static size_t nonmanifold_edges(const struct ffx *ffx, int steps)
{
	struct cage cage;
	struct level base, fine;
	struct fault fault = {0};
	ffx_to_cage(&cage, ffx);
	assert_true(level_from_cage(&base, &cage, &fault));
	level_refine(&fine, &base, cage.scheme, steps);
	const size_t corners = fine.face_start[fine.face_count];
	struct mesh mesh = {.vertex_count = fine.vertex_count, .face_count = fine.face_count};
	mesh.xyz = mem_copy(fine.xyz, 3 * fine.vertex_count, sizeof(double));
	mesh.corner = mem_copy(fine.face_corner, corners, sizeof(idx_t));
	mesh.face_start = mem_copy(fine.face_start, fine.face_count + 1, sizeof(size_t));
	mesh_weld(&mesh, 0, NULL);
	struct trimesh trimesh;
	assert_true(trimesh_from_mesh(&trimesh, &mesh, "welded", &fault));
	const size_t count = trimesh.nonmanifold_count;
	assert_int_equal(trimesh.open_count, 0);
	trimesh_free(&trimesh);
	level_free(&fine);
	level_free(&base);
	cage_free(&cage);
	return count;
}

static void assert_mended(double x, double y)
{
	struct cage cage = block_with_tip(x, y);
	struct ffx ffx;
	struct fault fault = {0};
	assert_int_equal(ffx_grid_steps(GRID_14), 14);
	assert_true(gridfit_round(&ffx, &cage, GRID_14, false, &fault));
	assert_true(nonmanifold_edges(&ffx, 4) > 0);
	assert_true(gridfit_check(&cage, &ffx, 4).overlaid > 0);
	struct gridmend_report report;
	gridmend(&ffx, &report, &cage, 4);
	assert_true(report.found > 0);
	assert_int_equal(report.moved, 1);
	assert_int_equal(report.left, 0);
	assert_int_equal(gridmend_count(&ffx, &cage), 0);
	/* One step away, and nothing else has moved. */
	size_t moved = 0;
	for (size_t i = 0; i < 3 * cage.vertex_count; i++) {
		const double off = ffx.grid[i] - gridfit_exact(&cage, &ffx, i);
		assert_true(fabs(off) < 2);
		moved += fabs(off) > 0.5 + 1e-5;
	}
	assert_true(moved <= 3);
	for (int steps = 0; steps <= 4; steps++)
		assert_int_equal(nonmanifold_edges(&ffx, steps), 0);
	ffx_free(&ffx);
	cage_free(&cage);
}

/* The triangle on the front edge, 0.3 steps high, becomes a line: its tip falls onto the middle of that edge. */
static void test_line(void **state)
{
	(void)state;
	assert_mended(7, 0.3);
}

/* The tip falls onto a corner of the block. */
static void test_one_point(void **state)
{
	(void)state;
	assert_mended(0.3, 0.4);
}

/* The corner (0, 0) of the top moved to (2, 0), and the tip beyond the left edge: the triangle there is turned over and lies on its
 * neighbours at the two edges of the tip. That it was so before rounding makes it no better. */
static void test_folded(void **state)
{
	(void)state;
	struct cage cage = block_with_tip(0, 4);
	cage.xyz[3 * 4] = 2;
	struct ffx ffx;
	struct fault fault = {0};
	assert_true(gridfit_round(&ffx, &cage, GRID_14, false, &fault));
	assert_int_equal(gridmend_count(&ffx, &cage), 4); /* each edge is seen from both its ends */
	struct gridmend_report report;
	gridmend(&ffx, &report, &cage, 4);
	assert_int_equal(report.found, 4);
	assert_int_equal(report.left, 0);
	ffx_free(&ffx);
	cage_free(&cage);
}

static void test_refusals(void **state)
{
	(void)state;
	struct cage cage = prism(1, 1);
	struct ffx ffx;
	struct fault fault = {0};
	for (size_t i = 0; i < 3 * cage.vertex_count; i++)
		cage.xyz[i] = 5;
	assert_false(gridfit_round(&ffx, &cage, 100, false, &fault));
	assert_contains(fault.text, "no extent");
	fault = (struct fault){0};
	for (size_t i = 0; i < 3 * cage.vertex_count; i++)
		cage.xyz[i] = 1e20 * (1 + (double)(i % 7) * 1e-15);
	assert_false(gridfit_round(&ffx, &cage, 100, false, &fault));
	assert_contains(fault.text, "beyond what a stream can hold");
	cage_free(&cage);
}

/* Level 0 of what is unpacked is the cage that was packed, and higher levels are closed when it is: every edge has two faces. */
static void test_unpacked_levels(void **state)
{
	(void)state;
	struct cage cage = sample_plate(2, 1, 0.2, 1), back;
	sample_tag(&cage, 30, 0);
	struct ffx ffx = ffx_rounded(&cage, 120), out;
	ffx.has_frame = true;
	assert_true(ffx_frame_choose(&ffx.frame, (double[]){0, 0, 0}, 1.3, ffx_grid_steps(120)));
	size_t size;
	struct ffx_report report;
	struct fault fault = {0};
	unsigned char *bytes = round_trip(&ffx, &size, &report, 1);
	assert_true(ffx_decode(&out, bytes, size, "t.ffx", &fault));
	ffx_to_cage(&back, &out);
	struct level base, fine;
	assert_true(level_from_cage(&base, &back, &fault));
	assert_int_equal(base.vertex_count, cage.vertex_count);
	assert_memory_equal(base.xyz, back.xyz, 3 * base.vertex_count * sizeof(double));
	level_refine(&fine, &base, back.scheme, 2);
	struct ffx closed = {.grid_code = 0,
			     .vertex_count = fine.vertex_count,
			     .grid = mem_array(3 * fine.vertex_count, sizeof(int32_t)),
			     .face_corner = fine.face_corner,
			     .face_start = fine.face_start,
			     .face_count = fine.face_count};
	unsigned char *again;
	assert_true(ffx_encode(&again, &size, &report, &closed, &(struct ffx_options){.root_limit = 1}, &fault));
	assert_int_equal(report.hole_count, 0);
	assert_int_equal(report.handle_count, 2);
	free(again);
	free(closed.grid);
	level_free(&fine);
	level_free(&base);
	cage_free(&back);
	ffx_free(&out);
	free(bytes);
	free(ffx.grid);
	cage_free(&cage);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_rounding), cmocka_unit_test(test_choice),   cmocka_unit_test(test_cheaper),
		cmocka_unit_test(test_collapse), cmocka_unit_test(test_refusals), cmocka_unit_test(test_unpacked_levels),
		cmocka_unit_test(test_line),     cmocka_unit_test(test_one_point), cmocka_unit_test(test_folded),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
