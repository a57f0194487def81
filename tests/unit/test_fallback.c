/* What becomes of patches that few smooth faces cannot follow: seams, facets, cages by edge collapse. */
#include "tests/unit/fitpatch_rig.h"

#include "stages/fitpatch/collapse.h"
#include "stages/fitpatch/facet.h"
#include "stages/fitpatch/seam.h"

static struct patch_error *fit(struct rig *rig)
{
	struct fault fault = {0};
	struct patch_error *error = mem_array(rig->dense.patch_count, sizeof *error);
	rig_layout(rig);
	if (!rounds_fit(&rig->draft, &rig->layouts, error, &rig->rounds, &fault))
		fail_msg("%s", fault.text);
	return error;
}

/* A plane frame, side 4, 0.1 wide. */
static struct dense narrow_frame(void)
{
	struct mesh mesh = {0};
	for (int ring = 0; ring < 2; ring++) {
		const double h = ring ? 1.9 : 2;
		shape_vertex(&mesh, -h, -h, 0), shape_vertex(&mesh, h, -h, 0), shape_vertex(&mesh, h, h, 0), shape_vertex(&mesh, -h, h, 0);
	}
	for (idx_t i = 0; i < 4; i++)
		shape_quad(&mesh, i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i);
	const enum patch_kind kind = PATCH_PLANE;
	idx_t *label = mem_array(mesh.face_count, sizeof *label);
	struct dense dense = rig_dense(&mesh, label, 1, &kind);
	free(label);
	shape_free(&mesh);
	return dense;
}

/* The smooth middle of a chord across a corner of the frame is the mean of its ends and of two middles of sides that are 2 away: it lies
 * a half inside of the frame. Creases there leave the plane as it is. */
static void test_seams(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, narrow_frame(), 0.02, 0.01);
	rig_layout(&rig);
	assert_int_equal(rig.draft.polygons.count, 4);
	assert_int_equal(rig.draft.seam_count, 4);
	for (size_t i = 0; i < 4; i++) {
		const double *a = &rig.draft.control.xyz[3 * (size_t)rig.draft.seam[3 * i]], *b = &rig.draft.control.xyz[3 * (size_t)rig.draft.seam[3 * i + 1]];
		assert_near(distance3(a, b), 0.1 * sqrt(2), 1e-9);
		assert_int_equal(rig.draft.seam[3 * i + 2], 0);
	}
	struct fault fault = {0};
	struct patch_error error;
	assert_true(joint_measure(&error, NULL, 1, &rig.draft, &rig.target, &fault));
	assert_near(error.max, 0, 1e-9);
	assert_near(error.folded, 0, 1e-12);
	rig.draft.seam_count = 0;
	assert_true(joint_measure(&error, NULL, 1, &rig.draft, &rig.target, &fault));
	assert_true(error.max > 0.2);
	assert_true(error.folded > 0.01);
	rig_free(&rig);
}

/* A wide frame needs none: its chords stay on their faces. */
static void test_no_seams(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_square_ring(), 0.04, 0.01);
	rig_layout(&rig);
	assert_int_equal(rig.draft.seam_count, 0);
	rig_free(&rig);
}

/* Three sides of a cube taken for one round patch, as a wrong segmentation would have it. */
static struct dense three_sides(void)
{
	struct mesh mesh = shape_box(1, 1, 1);
	idx_t label[12];
	enum patch_kind kinds[4] = {PATCH_CONE, PATCH_PLANE, PATCH_PLANE, PATCH_PLANE};
	idx_t next = 1;
	for (int t = 0; t < 12; t += 2) {
		const idx_t *v = &mesh.corner[3 * t];
		double normal[3];
		area_vector3(normal, &mesh.xyz[3 * (size_t)v[0]], &mesh.xyz[3 * (size_t)v[1]], &mesh.xyz[3 * (size_t)v[2]]);
		label[t] = label[t + 1] = normal[0] + normal[1] + normal[2] > 0 ? 0 : next++;
	}
	assert_int_equal(next, 4);
	struct dense dense = rig_dense(&mesh, label, 4, kinds);
	shape_free(&mesh);
	return dense;
}

/* Its facets are exact: six or fewer flat faces with creases between them. */
static void test_facets(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, three_sides(), 8e-3, 3e-3);
	rig.rounds.limit = 0;
	struct patch_error *error = fit(&rig);
	assert_true(error[0].max > 0.02);
	facet_rest(&rig.draft, &rig.layouts, error, &rig.rounds);
	assert_int_equal(rig.layouts.faceted[0], 1);
	assert_near(error[0].max, 0, 1e-6);
	assert_near(error[0].folded, 0, 1e-9);
	rig_check_draft(&rig.draft, NULL);
	free(error);
	rig_free(&rig);
}

/* A part within its bounds is left alone, to the bit. */
static void test_nothing_left(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_box(1, 1, 1), 4e-3, 1e-3);
	struct patch_error *error = fit(&rig);
	double *before = mem_copy(rig.draft.control.xyz, 3 * rig.draft.control.count, sizeof *before);
	const size_t points = rig.draft.control.count;
	facet_rest(&rig.draft, &rig.layouts, error, &rig.rounds);
	assert_int_equal(collapse_try(&rig.draft, &rig.layouts, error, &rig.rounds), COLLAPSE_NONE);
	assert_int_equal(rig.draft.control.count, points);
	assert_memory_equal(before, rig.draft.control.xyz, 3 * points * sizeof *before);
	free(before), free(error);
	rig_free(&rig);
}

/* Finer distances leave more triangles; a sphere stays one, its eight nodes and its twelve borders stay. */
static void test_collapse(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_ball(1, 16), 8e-3, 3e-3);
	size_t last = 0;
	for (double distance = 0.1; distance > 0.005; distance /= 2) {
		struct draft draft;
		struct fault fault = {0};
		size_t border;
		assert_true(collapse_draft(&draft, &rig.rounds, distance, &fault));
		assert_int_equal(rig_check_draft(&draft, &border), 2);
		assert_int_equal(border, 0);
		rig_check_curves(&draft);
		assert_int_equal(draft.network.curve_count, 12);
		size_t nodes = 0;
		for (size_t i = 0; i < draft.control.count; i++)
			nodes += draft.control.role[i] == POINT_JUNCTION;
		assert_int_equal(nodes, 8);
		for (size_t i = 0; i < draft.control.count; i++)
			assert_near(norm3(&draft.control.xyz[3 * i]), 1, 1e-9); /* vertices of the mesh */
		assert_true(draft.polygons.count > last);
		last = draft.polygons.count;
		draft_free(&draft);
	}
	rig_free(&rig);
}

static void waves(double p[3], double u, double v) { p[0] = u, p[1] = v, p[2] = 0.08 * sin(9 * u) * cos(7 * v); }

/* A free form that got no rounds is out of bounds; the collapsed cage is not, and its bound is a true one. */
static void test_collapse_try(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(40, PATCH_FREE, waves), 8e-3, 2e-3);
	rig.rounds.limit = 0;
	struct patch_error *error = fit(&rig);
	assert_true(error[0].max > 0.02);
	assert_int_equal(collapse_try(&rig.draft, &rig.layouts, error, &rig.rounds), COLLAPSE_SMOOTH);
	assert_near(error[0].max, 0, ROUNDS_SLACK * 8e-3);
	assert_near(rig_error(&rig, NULL), error[0].max, 0);
	rig_check_draft(&rig.draft, NULL);
	free(error);
	rig_free(&rig);
}

/* Points that a person moved are not given away. */
static void test_collapse_held(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(20, PATCH_FREE, waves), 8e-3, 2e-3);
	rig.rounds.limit = 0;
	rig.draft.control.held[0] = 1;
	struct patch_error *error = fit(&rig);
	assert_int_equal(collapse_try(&rig.draft, &rig.layouts, error, &rig.rounds), COLLAPSE_NONE);
	free(error);
	rig_free(&rig);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_seams),    cmocka_unit_test(test_no_seams),     cmocka_unit_test(test_facets),        cmocka_unit_test(test_nothing_left),
		cmocka_unit_test(test_collapse), cmocka_unit_test(test_collapse_try), cmocka_unit_test(test_collapse_held),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
