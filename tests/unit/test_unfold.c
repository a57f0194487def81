/* Plane faces that fold over, and what assemble makes of them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/assemble/change.h"
#include "stages/assemble/unfold.h"
#include "stages/geometry/subdivide.h"
#include "stages/geometry/vector.h"

enum { STEPS = 4 };

/* A prism of height 1 over a polygon in the plane: walls are patch 2 and on, top patch 0, bottom patch 1. The tops are given as lists of
 * corners that end with -1, two -1 end the list. is_corner: what stays where it is; edges at others are smooth where they are upright. */
static void make_prism(struct cage *cage, const double (*xy)[2], const unsigned char *is_corner, size_t n, const idx_t *tops)
{
	const size_t room = 200;
	*cage = (struct cage){.scheme = SCHEME_QUADTRI, .vertex_count = 2 * n};
	cage->xyz = mem_array(6 * n, sizeof(double)), cage->corner = mem_array(2 * n, 1);
	cage->face_corner = mem_array(room, sizeof(idx_t)), cage->face_start = mem_array(room, sizeof(size_t)), cage->face_patch = mem_array(room, sizeof(idx_t));
	cage->sharp = mem_array(2 * room, sizeof(idx_t));
	for (size_t i = 0; i < n; i++)
		for (size_t k = 0; k < 2; k++) {
			double *p = cage->xyz + 3 * (2 * i + k);
			p[0] = xy[i][0], p[1] = xy[i][1], p[2] = k ? 0 : 1;
		}
	size_t h = 0;
	for (const idx_t *top = tops; *top >= 0; top++) {
		size_t count = 0;
		for (; top[count] >= 0; count++)
			cage->face_corner[h + count] = 2 * top[count];
		cage->face_start[++cage->face_count] = h += count;
		for (size_t k = 0; k < count; k++)
			cage->face_corner[h + k] = 2 * top[count - 1 - k] + 1;
		cage->face_patch[cage->face_count] = 1;
		cage->face_start[++cage->face_count] = h += count;
		top += count;
	}
	for (size_t i = 0; i < n; i++) {
		const idx_t a = (idx_t)(2 * i), b = (idx_t)(2 * ((i + 1) % n)), face[4] = {b, a, a + 1, b + 1};
		memcpy(cage->face_corner + h, face, sizeof face);
		cage->face_patch[cage->face_count] = (idx_t)i + 2;
		cage->face_start[++cage->face_count] = h += 4;
	}
	/* sorted: edges of the two rims from even to even and odd to odd, uprights from even to odd */
	for (idx_t a = 0; a < (idx_t)(2 * n); a++)
		for (idx_t b = a + 1; b < (idx_t)(2 * n); b++) {
			const bool rim = (a & 1) == (b & 1) && (b - a == 2 || b - a == (idx_t)(2 * n - 2)), upright = (a & 1) == 0 && b == a + 1;
			if (rim || (upright && is_corner[a / 2]))
				cage->sharp[2 * cage->sharp_count] = a, cage->sharp[2 * cage->sharp_count++ + 1] = b;
		}
}

/* Area of the faces at height 1, and of what of them lies upside down, at the level of STEPS. */
static double top_area(double *turned, const struct cage *cage)
{
	struct level level, fine;
	struct fault fault = {0};
	double area = 0;
	*turned = 0;
	if (!level_from_cage(&level, cage, &fault))
		fail_msg("%s", fault.text);
	level_refine(&fine, &level, SCHEME_QUADTRI, STEPS);
	for (size_t f = 0; f < fine.face_count; f++) {
		if (cage->face_patch[fine.face_origin[f]] != 0)
			continue;
		const idx_t *corner = fine.face_corner + fine.face_start[f];
		const size_t n = fine.face_start[f + 1] - fine.face_start[f];
		double down[2] = {0, 0}, diagonal[2] = {0, 0}; /* of a quad: what is upside down by both, and how long they are */
		for (size_t from = 0; from < n - 2; from++)
			for (size_t k = 1; k + 1 < n; k++) {
				double doubled[3];
				const double *p = fine.xyz + 3 * (size_t)corner[from], *q = fine.xyz + 3 * (size_t)corner[(from + k) % n];
				area_vector3(doubled, p, q, fine.xyz + 3 * (size_t)corner[(from + k + 1) % n]);
				area += from == 0 ? doubled[2] / 2 : 0;
				down[from] += fmax(0, -doubled[2] / 2);
			}
		for (size_t from = 0; n == 4 && from < 2; from++)
			diagonal[from] = distance3(fine.xyz + 3 * (size_t)corner[from], fine.xyz + 3 * (size_t)corner[from + 2]);
		*turned += down[diagonal[1] < diagonal[0]];
	}
	level_free(&fine), level_free(&level);
	return area;
}

static void assert_near(double got, double want, double within)
{
	if (!(fabs(got - want) <= within))
		fail_msg("%.17g is not %.17g", got, want);
}

static const double el[6][2] = {{0, 0}, {6, 0}, {6, 1}, {1, 1}, {1, 6}, {0, 6}}; /* long arms pull harder */
static const unsigned char all_corners[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};

/* The corner at (1, 1) turns by three quarters: the smooth chord from there folds over the two edges. Both its ends are corners, so
 * that it can be a crease, which leaves two straight faces. */
static void test_inward_corner(void **state)
{
	(void)state;
	struct cage cage;
	struct unfold_report report;
	double turned;
	make_prism(&cage, el, all_corners, 6, (const idx_t[]){0, 1, 2, 3, -1, 0, 3, 4, 5, -1, -1});
	top_area(&turned, &cage);
	assert_true(turned > 1e-3);
	const size_t sharp = cage.sharp_count;
	unfold(&report, &cage, NULL, 1e-4, STEPS);
	assert_int_equal(report.left, 0);
	assert_true(report.folded >= 2);
	assert_int_equal(report.creased, 2);
	assert_int_equal(cage.sharp_count, sharp + 2);
	assert_int_equal(report.added, 0);
	assert_near(top_area(&turned, &cage), 11, 1e-12);
	assert_near(turned, 0, 0);
	struct unfold_report again;
	unfold(&again, &cage, NULL, 1e-4, STEPS);
	assert_int_equal(again.folded, 0);
	cage_free(&cage);
}

/* Here the outer corner is round: no crease may end there, so the chord gets a point on the way or goes elsewhere. */
static void test_no_corner_opposite(void **state)
{
	(void)state;
	const double round_el[7][2] = {{0.3, 0}, {6, 0}, {6, 1}, {1, 1}, {1, 6}, {0, 6}, {0, 0.3}};
	const unsigned char is_corner[7] = {0, 1, 1, 1, 1, 1, 0};
	struct cage cage;
	struct unfold_report report;
	double turned;
	make_prism(&cage, round_el, is_corner, 7, (const idx_t[]){0, 1, 2, 3, -1, 0, 3, 4, 5, 6, -1, -1});
	const double before = top_area(&turned, &cage);
	assert_true(turned > 1e-3);
	unfold(&report, &cage, NULL, 1e-4, STEPS);
	assert_int_equal(report.left, 0);
	/* the rim is where it was: at its smooth points there are the two creases of the rim yet */
	assert_near(top_area(&turned, &cage), before, 1e-9);
	assert_near(turned, 0, 0);
	for (size_t v = 0; v < 14; v += 12) {
		size_t creases = 0;
		for (size_t i = 0; i < 2 * cage.sharp_count; i++)
			creases += cage.sharp[i] == (idx_t)v;
		assert_int_equal(creases, 2);
	}
	cage_free(&cage);
}

/* All corners turn inward by a quarter: nothing folds, and nothing is done. */
static void test_convex(void **state)
{
	(void)state;
	const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
	struct cage cage;
	struct unfold_report report;
	make_prism(&cage, square, all_corners, 4, (const idx_t[]){0, 1, 2, -1, 0, 2, 3, -1, -1});
	const size_t sharp = cage.sharp_count, faces = cage.face_count;
	unfold(&report, &cage, NULL, 1e-4, STEPS);
	assert_int_equal(report.folded, 0);
	assert_int_equal(report.creased + report.redrawn + report.added, 0);
	assert_int_equal(cage.sharp_count, sharp);
	assert_int_equal(cage.face_count, faces);
	cage_free(&cage);
}

/* A patch of no known surface is none of ours, flat as its faces may be. */
static void test_free_form(void **state)
{
	(void)state;
	struct cage cage;
	struct unfold_report report;
	struct dense_patch patch[8] = {{0}};
	for (size_t p = 0; p < 8; p++)
		patch[p].kind = PATCH_FREE;
	make_prism(&cage, el, all_corners, 6, (const idx_t[]){0, 1, 2, 3, -1, 0, 3, 4, 5, -1, -1});
	unfold(&report, &cage, patch, 1e-4, STEPS);
	assert_int_equal(report.folded, 0);
	assert_int_equal(report.creased + report.redrawn + report.added, 0);
	cage_free(&cage);
}

/* The same on spheres so large that they are as good as planes: there the chord may become a crease, and nothing else is needed. */
static void test_bent(void **state)
{
	(void)state;
	const double radius = 1e6;
	struct cage cage;
	struct unfold_report report;
	double turned;
	struct dense_patch patch[8] = {{0}};
	for (size_t p = 0; p < 8; p++)
		patch[p].kind = p < 2 ? PATCH_SPHERE : PATCH_PLANE;
	patch[0].point[2] = 1 - radius, patch[1].point[2] = radius;
	patch[0].radius = patch[1].radius = radius, patch[0].sign = patch[1].sign = 1;
	make_prism(&cage, el, all_corners, 6, (const idx_t[]){0, 1, 2, 3, -1, 0, 3, 4, 5, -1, -1});
	unfold(&report, &cage, patch, 1e-4, STEPS);
	assert_int_equal(report.left, 0);
	assert_int_equal(report.creased, 2);
	assert_int_equal(report.redrawn + report.added, 0);
	assert_near(top_area(&turned, &cage), 11, 1e-12);
	assert_near(turned, 0, 0);
	cage_free(&cage);
}

/* The fold of a few polygons, measured with their neighbours alone, is that of the whole: a plot of both tops as against the level of the cage. */
static void test_fold_is_local(void **state)
{
	(void)state;
	struct cage cage;
	double turned;
	make_prism(&cage, el, all_corners, 6, (const idx_t[]){0, 1, 2, 3, -1, 0, 3, 4, 5, -1, -1});
	top_area(&turned, &cage);
	idx_t creases[12];
	unsigned char open[12] = {0};
	for (int v = 0; v < 12; v++)
		creases[v] = 3;
	struct points points = {cage.xyz, cage.corner, creases, open, 12, 12};
	size_t work = 0;
	struct plot plot = {.points = &points, .normal = {0, 0, 1}, .work = &work};
	plot_add(&plot, (const idx_t[]){0, 2, 4, 6}, (const unsigned char[]){1, 1, 1, 0}, 4, false);
	plot_add(&plot, (const idx_t[]){0, 6, 8, 10}, (const unsigned char[]){0, 1, 1, 1}, 4, false);
	double *folded;
	idx_t *touched;
	size_t count;
	assert_near(plot_fold(&folded, &touched, &count, &plot, (const idx_t[]){0}, 1, STEPS), turned, 1e-12);
	assert_int_equal(count, 2);
	/* the L is the same on both sides of its diagonal */
	assert_near(folded[0], folded[1], 1e-12);
	free(folded), free(touched);
	plot_free(&plot);
	cage_free(&cage);
}

/* Every kind of change, done and taken back, leaves the plot as it was; the corners that it makes are those of its parts. */
static void test_changes(void **state)
{
	(void)state;
	double xyz[3 * 10] = {0, 0, 0, 6, 0, 0, 6, 1, 0, 1, 1, 0, 1, 6, 0, 0, 6, 0};
	unsigned char corner[10] = {0}, open[10] = {0};
	idx_t creases[10] = {3, 3, 3, 3, 3, 3};
	struct points points = {xyz, corner, creases, open, 6, 10};
	size_t work = 0;
	struct plot plot = {.points = &points, .normal = {0, 0, 1}, .work = &work};
	const idx_t one[4] = {0, 1, 2, 3}, two[4] = {0, 3, 4, 5};
	plot_add(&plot, one, (const unsigned char[]){1, 1, 1, 0}, 4, false);
	plot_add(&plot, two, (const unsigned char[]){0, 1, 1, 1}, 4, false);
	const struct {
		struct change change;
		size_t polygons, corners, points, creases_at_3;
	} want[] = {
		{{WAY_CHORD, 0, 1, NO_INDEX, NO_INDEX, 0, 0, 0, 0, 0}, 1, 6, 6, 3},          /* joined */
		{{WAY_CHORD, 0, 1, 1, 5, 0, 0, 0, 0, 0}, 2, 8, 6, 3},                        /* swapped */
		{{WAY_CHORD, 0, 1, 0, 3, 0, 0, 1, 0, 0}, 2, 8, 6, 4},                        /* made a crease */
		{{WAY_CHORD, 0, NO_INDEX, 3, 1, 0, 0, 1, 0, 0}, 3, 10, 6, 4},                /* cut */
		{{WAY_SPLIT, 0, 1, 3, 0, 1, 5, 1, 0, 0}, 4, 14, 7, 4},                       /* a point on the edge, joined to both sides */
		{{WAY_SPLIT, 0, 1, 3, 0, NO_INDEX, 5, 0, 0, 0}, 3, 12, 7, 3},                /* to one */
		{{WAY_CENTRE, 0, NO_INDEX, 3, NO_INDEX, 0, 0, 1, 0, 0}, 5, 16, 7, 4},        /* a point in the middle */
	};
	for (size_t i = 0; i < sizeof want / sizeof *want; i++) {
		struct undo undo;
		struct change change = want[i].change;
		/* the edge of a split is given as it runs in polygon one, from 3 to 0 */
		assert_true(change_apply(&undo, &plot, &change));
		size_t polygons = 0, corners = 0;
		for (size_t p = 0; p < plot.count; p++)
			polygons += plot.polygon[p].count > 0, corners += plot.polygon[p].count;
		assert_int_equal(polygons, want[i].polygons);
		assert_int_equal(corners, want[i].corners);
		assert_int_equal(points.count, want[i].points);
		assert_int_equal(creases[3], want[i].creases_at_3);
		change_take_back(&undo, &plot, &change);
		assert_int_equal(plot.count, 2);
		assert_memory_equal(plot.polygon[0].corner, one, sizeof one);
		assert_memory_equal(plot.polygon[1].corner, two, sizeof two);
		assert_int_equal(points.count, 6);
		for (int v = 0; v < 6; v++)
			assert_int_equal(creases[v], 3);
	}
	plot_free(&plot);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_inward_corner),
		cmocka_unit_test(test_no_corner_opposite),
		cmocka_unit_test(test_convex),
		cmocka_unit_test(test_free_form),
		cmocka_unit_test(test_bent),
		cmocka_unit_test(test_fold_is_local),
		cmocka_unit_test(test_changes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
