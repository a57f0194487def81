/* Refinement: whatever strip is cut, the faces stay a manifold over the same curves. */
#include "tests/unit/fitpatch_rig.h"

#include "stages/fitpatch/enrich.h"

struct errors {
	struct patch_error *patch;
	struct face_error *face;
	unsigned char *want, *touched;
};

static struct errors no_errors(const struct rig *rig)
{
	struct errors e = {mem_array(rig->dense.patch_count, sizeof *e.patch), mem_array(rig->draft.polygons.count, sizeof *e.face),
	                   mem_array(rig->dense.patch_count, 1), mem_array(rig->dense.patch_count, 1)};
	for (size_t p = 0; p < rig->dense.patch_count; p++)
		e.patch[p].worst_face = NO_INDEX;
	return e;
}

static void free_errors(struct errors *e) { free(e->patch), free(e->face), free(e->want), free(e->touched); }

static size_t run(struct rig *rig, struct errors *e, double floor)
{
	return enrich(&rig->draft, &rig->target, e->patch, e->face, e->want, floor, e->touched);
}

/* One face is far off: refine inside. */
static size_t refine_face(struct rig *rig, size_t f)
{
	struct errors e = no_errors(rig);
	const idx_t p = rig->draft.polygons.patch[f];
	e.face[f].distance = e.patch[p].max = 1;
	e.patch[p].worst_face = (idx_t)f;
	e.want[p] = WANT_INSIDE;
	const size_t steps = run(rig, &e, 0.1);
	assert_int_equal(e.touched[p], steps > 0);
	free_errors(&e);
	return steps;
}

static size_t face_of(const struct rig *rig, idx_t patch)
{
	size_t f = 0;
	while (rig->draft.polygons.patch[f] != patch)
		f++;
	return f;
}

static void test_nothing(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 24, 1), 3e-3, 3e-3);
	rig_layout(&rig);
	struct draft before;
	draft_copy(&before, &rig.draft);
	struct errors e = no_errors(&rig);
	for (size_t f = 0; f < rig.draft.polygons.count; f++)
		e.face[f].distance = 1; /* far off, but nobody asks */
	assert_int_equal(run(&rig, &e, 0.1), 0);
	assert_int_equal(before.control.count, rig.draft.control.count);
	assert_int_equal(before.polygons.count, rig.draft.polygons.count);
	assert_memory_equal(before.polygons.corner, rig.draft.polygons.corner, before.polygons.start[before.polygons.count] * sizeof(idx_t));
	assert_memory_equal(before.polygons.start, rig.draft.polygons.start, (before.polygons.count + 1) * sizeof(size_t));
	for (size_t p = 0; p < 3; p++)
		assert_int_equal(e.touched[p], 0);
	free_errors(&e);
	draft_free(&before);
	rig_free(&rig);
}

/* The side of a cylinder bends around: its quads are cut along the axis, and each cap, a plane, takes the new point on its circle
 * as one more corner. */
static void test_polygon_ends(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 24, 1), 3e-3, 3e-3);
	rig_layout(&rig);
	const size_t n = rig.draft.network.curve[0].count;
	assert_int_equal(refine_face(&rig, face_of(&rig, 0)), 1);
	assert_int_equal(rig_check_draft(&rig.draft, NULL), 2);
	rig_check_curves(&rig.draft);
	size_t corners;
	assert_int_equal(rig_faces(&rig.draft, 0, &corners), n + 1);
	assert_int_equal(corners, 4);
	for (idx_t cap = 1; cap < 3; cap++) {
		assert_int_equal(rig_faces(&rig.draft, cap, &corners), 1);
		assert_int_equal(corners, n + 1);
	}
	assert_int_equal(rig.draft.network.curve[0].count, n + 1);
	assert_int_equal(rig.draft.network.curve[1].count, n + 1);
	assert_int_equal(rig.draft.network.point_count, 2 * n + 2);
	for (size_t i = 2 * n; i < rig.draft.control.count; i++)
		assert_int_equal(rig.draft.control.role[i], POINT_CREASE); /* of curves, none inside */
	rig_free(&rig);
}

/* Points between two held points of a curve are held as well: a hand's curve stays. */
static void test_held(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 24, 1), 3e-3, 3e-3);
	rig_layout(&rig);
	const struct curve *low = &rig.draft.network.curve[0];
	for (size_t i = 0; i < low->count; i++)
		rig.draft.control.held[rig.draft.network.point[low->first + i]] = 1;
	const size_t before = rig.draft.control.count;
	refine_face(&rig, face_of(&rig, 0));
	assert_int_equal(rig.draft.control.count, before + 2);
	assert_int_equal(rig.draft.control.held[before] + rig.draft.control.held[before + 1], 1);
	rig_free(&rig);
}

/* On a ring every strip closes: one more row all around, or one more slice through all rows. Quads stay quads. */
static void test_closed_strip(void **state)
{
	(void)state;
	struct mesh mesh = shape_torus(3, 1, 36, 18);
	idx_t *label = mem_array(mesh.face_count, sizeof *label);
	for (size_t t = 0; t < mesh.face_count; t++)
		label[t] = t / 2 % 18 >= 5 && t / 2 % 18 < 14;
	const enum patch_kind kinds[2] = {PATCH_TORUS, PATCH_TORUS};
	struct dense dense = rig_dense(&mesh, label, 2, kinds);
	dense.patch[1].parent = 0;
	struct rig rig;
	rig_make(&rig, dense, 0.06, 0.02);
	rig_layout(&rig);
	const size_t around = rig.network.curve[0].count;
	for (int again = 0; again < 4; again++) {
		const size_t before = rig.draft.polygons.count;
		assert_int_equal(refine_face(&rig, (size_t)again), 1);
		const size_t more = rig.draft.polygons.count - before;
		const size_t now = rig.draft.network.curve[0].count;
		/* a row has a quad a point of the circles, a slice a quad a row */
		assert_true(more == now || more == before / around || more == before / now || more * (now - 1) == before);
		size_t border, corners;
		assert_int_equal(rig_check_draft(&rig.draft, &border), 0);
		assert_int_equal(border, 0);
		rig_check_curves(&rig.draft);
		for (idx_t p = 0; p < 2; p++) {
			rig_faces(&rig.draft, p, &corners);
			assert_int_equal(corners, 4);
		}
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

/* A grid on an open sheet: the strip runs from border to border, and both border curves get the point at its end. */
static void test_open_strip(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(16, PATCH_SPHERE, ball_place), 2e-3, 5e-4);
	rig_layout(&rig);
	const size_t across = rig.network.curve[0].count - 1;
	size_t points = 0, border;
	assert_int_equal(refine_face(&rig, 0), 1);
	size_t corners;
	assert_int_equal(rig_faces(&rig.draft, 0, &corners), across * across + across);
	assert_int_equal(corners, 4);
	assert_int_equal(rig_check_draft(&rig.draft, &border), 1);
	assert_int_equal(border, 4 * across + 2);
	rig_check_curves(&rig.draft);
	for (size_t k = 0; k < 4; k++)
		points += rig.draft.network.curve[k].count - 1;
	assert_int_equal(points, 4 * across + 2);
	rig_free(&rig);
}

/* Triangles are cut through their longest side, and so is the one behind it; larger faces get a star. Many rounds of that on
 * a layout of both kinds, any face and any kind of wish. */
static void test_many(void **state)
{
	(void)state;
	for (int shape = 0; shape < 2; shape++) {
		struct rig rig;
		if (shape == 0) {
			rig_make(&rig, rig_sheet(16, PATCH_SPHERE, ball_place), 8e-3, 2e-3);
			rig.layouts.detail[0] = 3;
		} else {
			rig_make(&rig, rig_ball(1, 6), 8e-3, 3e-3);
			for (int p = 0; p < 6; p += 2)
				rig.layouts.detail[p] = 2;
		}
		rig_layout(&rig);
		size_t border;
		const long euler = rig_check_draft(&rig.draft, &border);
		uint32_t random = 7;
		size_t steps = 0;
		for (int round = 0; round < 12; round++) {
			struct errors e = no_errors(&rig);
			for (size_t p = 0; p < rig.dense.patch_count; p++) {
				random = random * 1664525u + 1013904223u;
				e.want[p] = random >> 30 == 0 ? WANT_BORDER : random >> 30 == 1 ? WANT_NOTHING : WANT_INSIDE;
				ball_place(e.patch[p].worst_point, (random >> 8 & 255) / 255.0, (random >> 16 & 255) / 255.0);
			}
			for (size_t f = 0; f < rig.draft.polygons.count; f++) {
				const idx_t p = rig.draft.polygons.patch[f];
				random = random * 1664525u + 1013904223u;
				e.face[f].distance = (random >> 8) / 16777216.0;
				if (e.face[f].distance > e.patch[p].max)
					e.patch[p].max = e.face[f].distance, e.patch[p].worst_face = (idx_t)f;
			}
			for (size_t f = 0; f < rig.draft.polygons.count; f++) /* few at a time */
				if (e.face[f].distance < 0.9 * e.patch[rig.draft.polygons.patch[f]].max)
					e.face[f].distance = 0;
			steps += run(&rig, &e, 0.1);
			free_errors(&e);
			size_t now;
			assert_int_equal(rig_check_draft(&rig.draft, &now), euler);
			assert_true(border == 0 ? now == 0 : now >= border);
			rig_check_curves(&rig.draft);
			for (size_t i = 0; i < 3 * rig.draft.control.count; i++)
				assert_true(isfinite(rig.draft.control.xyz[i]));
		}
		assert_true(steps > 12);
		rig_free(&rig);
	}
}

/* A plane that is off asks for a point on its border: the side nearest to where it is off. The neighbour learns of it. */
static void test_border(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 24, 1), 3e-3, 3e-3);
	rig_layout(&rig);
	const size_t n = rig.draft.network.curve[0].count, points = rig.draft.control.count;
	struct errors e = no_errors(&rig);
	const size_t f = face_of(&rig, 1);
	e.want[1] = WANT_BORDER;
	e.patch[1].max = e.face[f].distance = 1;
	e.patch[1].worst_face = (idx_t)f;
	const double *a = &rig.draft.control.xyz[3 * (size_t)rig.draft.polygons.corner[rig.draft.polygons.start[f]]];
	const double *b = &rig.draft.control.xyz[3 * (size_t)rig.draft.polygons.corner[rig.draft.polygons.start[f] + 1]];
	double middle[3];
	for (int k = 0; k < 3; k++)
		middle[k] = e.patch[1].worst_point[k] = (a[k] + b[k]) / 2;
	assert_int_equal(run(&rig, &e, 0.1), 1);
	free_errors(&e);
	assert_true(rig.draft.control.count > points);
	assert_near(distance3(&rig.draft.control.xyz[3 * points], middle), 0, 1e-12);
	assert_int_equal(rig_check_draft(&rig.draft, NULL), 2);
	rig_check_curves(&rig.draft);
	assert_true(rig.draft.network.curve[0].count + rig.draft.network.curve[1].count > 2 * n);
	rig_free(&rig);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_nothing),    cmocka_unit_test(test_polygon_ends), cmocka_unit_test(test_held), cmocka_unit_test(test_closed_strip),
		cmocka_unit_test(test_open_strip), cmocka_unit_test(test_many),         cmocka_unit_test(test_border),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
