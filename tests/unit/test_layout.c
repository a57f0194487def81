/* Chords, bands, grids and merged polygons on surfaces where the right layout is known (the patch method's 5.1, 5.2 and 5.7). */
#include "tests/unit/fitpatch_rig.h"

#include "stages/fitpatch/chord.h"
#include "stages/fitpatch/loops.h"
#include "stages/geometry/polygon.h"

static void test_edge_set(void **state)
{
	(void)state;
	struct edge_set *set = edge_set_new();
	assert_false(edge_set_has(set, 3, 4));
	for (idx_t i = 0; i < 5000; i++)
		edge_set_add(set, i % 2 ? i : i + 7, i % 2 ? i + 7 : i);
	for (idx_t i = 0; i < 5000; i++) {
		assert_true(edge_set_has(set, i, i + 7) && edge_set_has(set, i + 7, i)); /* no direction */
		assert_false(edge_set_has(set, i, i + 6));
	}
	edge_set_free(set);
	edge_set_free(NULL);
}

/* The sheet of one patch, and what chords on it cost. */
struct chords {
	struct sheet sheet;
	struct edge_set *taken;
	struct chord_context context;
};

static void chords_start(struct chords *chords, const struct rig *rig, idx_t patch, bool is_plane, double diameter)
{
	size_t *start;
	idx_t *list, *from;
	label_lists(&start, &list, rig->dense.label, rig->dense.triangle_count, rig->dense.patch_count);
	sheet_build(&chords->sheet, &from, &list[start[patch]], start[patch + 1] - start[patch], rig->dense.triangle, rig->half.twin, rig->dense.xyz);
	free(start), free(list), free(from);
	chords->taken = edge_set_new();
	chords->context = (struct chord_context){.dense = &rig->dense, .nearest = rig->nearest, .sheet = &chords->sheet, .control = rig->draft.control.xyz,
	                                         .taken = chords->taken, .patch = patch, .is_plane = is_plane, .diameter = diameter};
	chord_open(&chords->context);
}

static void chords_end(struct chords *chords)
{
	chord_close(&chords->context);
	edge_set_free(chords->taken);
	sheet_free(&chords->sheet);
}

static idx_t vertex_near(const struct sheet *sheet, double x, double y, double z)
{
	const double p[3] = {x, y, z};
	idx_t best = 0;
	for (size_t v = 1; v < sheet->vertex_count; v++)
		if (distance3(&sheet->xyz[3 * v], p) < distance3(&sheet->xyz[3 * (size_t)best], p))
			best = (idx_t)v;
	return best;
}

/* On a cylinder side dmin runs along the axis. A chord along it costs its length alone, and so does one across it as far as
 * directions go; one at 45 degrees to both has a mean angle of 45 degrees to either. */
static void test_chord_cylinder(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(1, 2, 48, 8), 0.01, 0.003);
	struct chords c;
	chords_start(&c, &rig, 0, false, 3);
	const idx_t low = vertex_near(&c.sheet, 1, 0, 0.25), high = vertex_near(&c.sheet, 1, 0, 1.25);
	const double along = chord_cost(&c.context, low, high);
	assert_near(along, 10 * 1.0 / 3, 0.5);
	assert_near(chord_cost(&c.context, high, low), along, 0);
	/* A turn of 30 degrees at half the height of that arc: the helix of 45 degrees. */
	const double turn = 30 / DEGREES;
	const idx_t aside = vertex_near(&c.sheet, cos(turn), sin(turn), 0.25 + 0.5);
	const double slant = chord_cost(&c.context, low, aside);
	assert_true(slant > 35);
	assert_true(slant < 45 + 10 + 45);
	/* Through the bar: as deep as a chord can leave the surface. */
	const double through = chord_cost(&c.context, low, vertex_near(&c.sheet, -1, 0, 0.25));
	assert_true(through > 45 && through > along + 30);
	/* Between control points that an edge joins already there is none. */
	c.sheet.point[low] = 3, c.sheet.point[high] = 4;
	assert_near(chord_cost(&c.context, low, high), along, 0);
	edge_set_add(c.taken, 4, 3);
	assert_true(isinf(chord_cost(&c.context, low, high)));
	c.sheet.point[high] = 3; /* nor from a point to itself */
	assert_true(isinf(chord_cost(&c.context, low, high)));
	chords_end(&c);
	rig_free(&rig);
}

/* A plane has no directions: 22.5 degrees for every chord (section 5.1), and its length. */
static void test_chord_plane(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_box(4, 3, 1), 0.01, 0.003);
	struct chords c;
	chords_start(&c, &rig, 1, true, 5);
	for (idx_t a = 0; a < 4; a++)
		for (idx_t b = 0; b < a; b++) {
			const double length = distance3(&c.sheet.xyz[3 * (size_t)a], &c.sheet.xyz[3 * (size_t)b]);
			assert_near(chord_cost(&c.context, a, b), 22.5 + 10 * length / 5, 1e-9);
		}
	/* A triangle over it is free; turned over it costs more than any chord. */
	const idx_t p = vertex_near(&c.sheet, 0, 0, 1), q = vertex_near(&c.sheet, 4, 0, 1), r = vertex_near(&c.sheet, 0, 3, 1);
	assert_near(chord_triangle_cost(&c.context, p, q, r), 0, 1e-9);
	assert_true(chord_triangle_cost(&c.context, p, r, q) > 1000);
	chords_end(&c);
	rig_free(&rig);
}

/* 5.7: a face of a cube is one quad. */
static void test_cube(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_box(1, 1, 1), 4e-3, 1e-3);
	rig_layout(&rig);
	assert_int_equal(rig.draft.polygons.count, 6);
	assert_int_equal(rig.draft.control.count, 8);
	size_t border;
	assert_int_equal(rig_check_draft(&rig.draft, &border), 2);
	assert_int_equal(border, 0);
	for (idx_t p = 0; p < 6; p++) {
		size_t corners;
		assert_int_equal(rig_faces(&rig.draft, p, &corners), 1);
		assert_int_equal(corners, 4);
		assert_int_equal(rig.layouts.kind[p], LAYOUT_FACE);
	}
	assert_near(rig_error(&rig, NULL), 0, 1e-14);
	rig_free(&rig);
}

/* 5.7: six points on either circle of a cylinder give a band of six quads without inner points; each cap is one hexagon. */
static void test_cylinder(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 64, 1), 3e-3, 3e-3);
	assert_int_equal(rig.network.vertex_count, 12);
	rig_layout(&rig);
	size_t corners;
	assert_int_equal(rig_faces(&rig.draft, 0, &corners), 6);
	assert_int_equal(corners, 4);
	assert_int_equal(rig.layouts.kind[0], LAYOUT_BAND);
	assert_int_equal(rig_faces(&rig.draft, 1, &corners), 1);
	assert_int_equal(corners, 6);
	assert_int_equal(rig.draft.control.count, 12);
	assert_int_equal(rig_check_draft(&rig.draft, NULL), 2);
	/* Every rung joins points one above the other, straight along the axis. */
	for (size_t f = 0; f < rig.draft.polygons.count; f++)
		for (size_t i = 0; rig.draft.polygons.patch[f] == 0 && i < 4; i++) {
			const idx_t *q = &rig.draft.polygons.corner[rig.draft.polygons.start[f]];
			const double *a = &rig.draft.control.xyz[3 * (size_t)q[i]], *b = &rig.draft.control.xyz[3 * (size_t)q[(i + 1) % 4]];
			if (fabs(a[2] - b[2]) > 0.5)
				assert_near(hypot(a[0] - b[0], a[1] - b[1]), 0, 0.02);
		}
	rig_free(&rig);
}

/* The outer and the inner half of a ring: each bends by 180 degrees between its two circles, which no single row of quads can
 * follow. */
static void test_torus_strip(void **state)
{
	(void)state;
	struct mesh mesh = shape_torus(3, 1, 48, 24);
	idx_t *label = mem_array(mesh.face_count, sizeof *label);
	for (size_t t = 0; t < mesh.face_count; t++) {
		const size_t j = t / 2 % 24; /* quads along the tube, 0 outside */
		label[t] = j >= 6 && j < 18;
	}
	const enum patch_kind kinds[2] = {PATCH_TORUS, PATCH_TORUS};
	struct dense dense = rig_dense(&mesh, label, 2, kinds);
	dense.patch[1].parent = 0; /* of one surface: smooth between them */
	struct rig rig;
	rig_make(&rig, dense, 0.03, 0.008);
	rig_layout(&rig);
	assert_int_equal(rig_check_draft(&rig.draft, NULL), 0);
	const size_t around = rig.network.curve[0].count;
	for (idx_t p = 0; p < 2; p++) {
		size_t corners;
		const size_t faces = rig_faces(&rig.draft, p, &corners);
		assert_int_equal(corners, 4);
		assert_int_equal(rig.layouts.kind[p], LAYOUT_BAND);
		assert_int_equal(faces % around, 0);
		assert_true(faces / around >= 2);
	}
	/* Inner points lie on the mesh, so within a facet's sagitta of the tube. */
	for (size_t i = rig.network.vertex_count; i < rig.draft.control.count; i++) {
		const double *p = &rig.draft.control.xyz[3 * i];
		assert_int_equal(rig.draft.control.role[i], POINT_INSIDE);
		assert_near(hypot(hypot(p[0], p[1]) - 3, p[2]), 1, 0.015);
	}
	rig_free(&rig);
	free(label);
	shape_free(&mesh);
}

static void ball_place(double p[3], double u, double v)
{
	p[0] = 2 * u - 1, p[1] = 2 * v - 1;
	p[2] = sqrt(4 - p[0] * p[0] - p[1] * p[1]);
}

/* Four arcs with corners of about 90 degrees between them: a grid of quads whose inner points lie on the surface. */
static void test_grid(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(16, PATCH_SPHERE, ball_place), 2e-3, 5e-4);
	assert_int_equal(rig.network.curve_count, 4);
	const size_t across = rig.network.curve[0].count - 1;
	assert_true(across > 1);
	for (size_t k = 0; k < 4; k++)
		assert_int_equal(rig.network.curve[k].count - 1, across);
	rig_layout(&rig);
	assert_int_equal(rig.layouts.kind[0], LAYOUT_GRID);
	size_t corners, border;
	assert_int_equal(rig_faces(&rig.draft, 0, &corners), across * across);
	assert_int_equal(corners, 4);
	assert_int_equal(rig_check_draft(&rig.draft, &border), 1);
	assert_int_equal(border, 4 * across);
	assert_int_equal(rig.draft.control.count, (across + 1) * (across + 1));
	for (size_t i = rig.network.vertex_count; i < rig.draft.control.count; i++)
		assert_near(norm3(&rig.draft.control.xyz[3 * i]), 2, 2 * 0.003);
	rig_free(&rig);
}

/* A plane patch has no business with inner points, and its faces do not fold in the first subdivision step. */
static void check_plane_faces(const struct rig *rig, idx_t patch)
{
	const struct polygons *polygons = &rig->draft.polygons;
	for (size_t f = 0; f < polygons->count; f++) {
		if (polygons->patch[f] != patch)
			continue;
		const idx_t *corner = &polygons->corner[polygons->start[f]];
		const size_t count = polygons->start[f + 1] - polygons->start[f];
		for (size_t i = 0; i < count; i++) {
			assert_int_not_equal(rig->draft.control.role[corner[i]], POINT_INSIDE);
			for (size_t k = 0; k < i; k++)
				assert_int_not_equal(corner[i], corner[k]);
		}
		assert_true(polygon_star(rig->draft.control.xyz, corner, count, rig->dense.patch[patch].axis) > 0);
	}
}

/* A ring between two squares: four corners outside, four inside. No face can be star-shaped around a corner of the hole, so at
 * least two are needed, and at least four when none is to have an angle above 180 degrees at two such corners. */
static void test_square_ring(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_square_ring(), 0.01, 0.003);
	assert_int_equal(rig.network.vertex_count, 8);
	rig_layout(&rig);
	const size_t faces = rig_faces(&rig.draft, 0, NULL);
	assert_true(faces >= 3 && faces <= 6);
	size_t border;
	assert_int_equal(rig_check_draft(&rig.draft, &border), 0);
	assert_int_equal(border, 8);
	check_plane_faces(&rig, 0);
	rig_free(&rig);
}

/* A patch that a loop of two points bounds cannot be a face: the fault names it. */
static void test_too_few(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 24, 1), 3e-3, 3e-3);
	struct network *network = &rig.draft.network;
	network->curve[0].count = 2;
	struct fault fault = {0};
	assert_false(rounds_layout(&rig.draft, &rig.rounds, &rig.layouts, NULL, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_non_null(strstr(fault.text, "2 control points"));
	rig_free(&rig);
}

/* With more detail a patch gets points inside: a half sphere's, else a face over its border circle. All stay on the surface. */
static void test_detail(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(16, PATCH_SPHERE, ball_place), 8e-3, 2e-3);
	size_t before = 0;
	for (unsigned char detail = 1; detail <= 5; detail += 2) {
		rig.layouts.detail[0] = detail;
		rig_layout(&rig);
		assert_int_equal(rig_check_draft(&rig.draft, NULL), 1);
		const size_t faces = rig.draft.polygons.count;
		assert_true(faces >= before);
		before = faces;
		assert_int_equal(rig.layouts.kind[0], LAYOUT_CHORDS);
	}
	assert_true(before > 8);
	rig_free(&rig);
}

/* Faces come out patch by patch, in the order they had. */
static void test_by_patch(void **state)
{
	(void)state;
	struct polygons p;
	polygons_init(&p);
	for (idx_t i = 0; i < 300; i++) {
		const idx_t corner[5] = {i, i + 1, i + 2, i + 3, i + 4};
		polygons_add(&p, corner, 3 + (size_t)i % 3, i * 7 % 10);
	}
	polygons_by_patch(&p, 10);
	assert_int_equal(p.count, 300);
	for (size_t f = 0; f < 300; f++) {
		const idx_t i = p.corner[p.start[f]];
		assert_int_equal(p.patch[f], i * 7 % 10);
		assert_int_equal(p.start[f + 1] - p.start[f], 3 + i % 3);
		if (f > 0)
			assert_true(p.patch[f] > p.patch[f - 1] || (p.patch[f] == p.patch[f - 1] && i > p.corner[p.start[f - 1]]));
	}
	polygons_free(&p);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_edge_set), cmocka_unit_test(test_chord_cylinder), cmocka_unit_test(test_chord_plane),  cmocka_unit_test(test_cube),
		cmocka_unit_test(test_cylinder), cmocka_unit_test(test_torus_strip),    cmocka_unit_test(test_grid),         cmocka_unit_test(test_square_ring),
		cmocka_unit_test(test_too_few),  cmocka_unit_test(test_detail),         cmocka_unit_test(test_by_patch),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
