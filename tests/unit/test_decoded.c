/* The refined mesh of a cage, measured and looked over. */
#include "tests/unit/polish_rig.h"

#include "stages/polish/decoded.h"

static const double middle[3] = {5, -2, 1};
#define SCALE 4.0

static void target_of(struct target *target, const struct sketch *s)
{
	struct rig_mesh mesh = rig_dense(s, 3);
	target_start(target, mesh.xyz, mesh.vertex_count, mesh.triangle, mesh.triangle_count, 500, 100, 30);
	rig_mesh_free(&mesh);
}

static bool measure(struct decoded_errors *errors, const struct sketch *s, const struct target *target, bool takes_unsound)
{
	struct cage cage;
	sketch_to_cage(&cage, s, middle, SCALE);
	const bool is_measured = decoded_measure(errors, target, &cage, 3, middle, SCALE, takes_unsound);
	cage_free(&cage);
	return is_measured;
}

/* A cube with sharp edges is its own limit: nothing is away from it. With one corner pulled out by a tenth of its side the largest distance is
 * that far, as three faces go there. */
static void test_cube(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(true);
	struct target target;
	struct decoded_errors e;
	target_of(&target, &cube);
	assert_true(measure(&e, &cube, &target, false));
	assert_near(e.mean, 0, 1e-9);
	assert_near(e.max, 0, 1e-9);
	assert_near(e.turned, 0, 0);
	assert_near(e.folded, 0, 0);
	for (int k = 0; k < 3; k++)
		cube.xyz[k] *= 1.2;
	assert_true(measure(&e, &cube, &target, false));
	assert_near(e.max, 0.1 * sqrt(3), 1e-3);
	assert_true(e.mean > 1e-3 && e.mean < 0.1);
	target_free(&target);
	sketch_free(&cube);
}

/* A sheet of squares with one inner point pulled past its neighbour lies twice over itself there, and looks down in between; the same sheet with the
 * point lifted is bent, not folded. */
static void test_fold(void **state)
{
	(void)state;
	struct sketch sheet = rig_quads(4, 4, false);
	struct target target;
	struct decoded_errors e;
	target_of(&target, &sheet);
	assert_true(measure(&e, &sheet, &target, false));
	assert_near(e.folded, 0, 0);
	const size_t inner = 2 + 5 * 2;
	sheet.xyz[3 * inner + 2] += 0.2;
	assert_true(measure(&e, &sheet, &target, false));
	assert_near(e.folded, 0, 0);
	sheet.xyz[3 * inner + 2] -= 0.2;
	sheet.xyz[3 * inner] += 1.0;
	assert_true(measure(&e, &sheet, &target, false));
	assert_true(e.folded > 1e-3 && e.folded < 0.5);
	target_free(&target);
	sketch_free(&sheet);
}

/* A box so thin that its lid and its bottom fall together in single precision, five units from the origin, is no box any more. */
static void test_unsound(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(true);
	struct target target;
	struct decoded_errors e;
	target_of(&target, &cube);
	for (size_t v = 0; v < cube.vertex_count; v++)
		cube.xyz[3 * v + 2] *= 1e-9;
	assert_false(measure(&e, &cube, &target, false));
	assert_true(measure(&e, &cube, &target, true));
	target_free(&target);
	sketch_free(&cube);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_cube), cmocka_unit_test(test_fold), cmocka_unit_test(test_unsound)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
