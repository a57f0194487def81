/* A cage from a collapsed dense mesh. */
#include "tests/unit/polish_rig.h"

#include "stages/polish/judge.h"
#include "stages/polish/start.h"

#define SHARP 30

struct start_rig {
	struct target target;
	struct judge judge;
	size_t work;
};

static void rig_start(struct start_rig *rig, const struct sketch *truth)
{
	struct rig_mesh mesh = rig_dense(truth, 4);
	target_start(&rig->target, mesh.xyz, mesh.vertex_count, mesh.triangle, mesh.triangle_count, 2000, 400, SHARP);
	rig_mesh_free(&mesh);
	rig->work = 0;
	rig->judge = (struct judge){&rig->target, 0.0075, 0.009, 3, &rig->work, PEAKS_SOME};
}

/* A prism over 12 sides refined is a cylinder with 12 flat sides rounded off: two rims of creases, a smooth side, flat caps. A few dozen
 * triangles follow it, the rims stay sharp, and the surface stays closed and in one piece. */
static void test_cylinder(void **state)
{
	(void)state;
	struct sketch truth = rig_prism(12);
	struct start_rig rig;
	struct candidate c;
	rig_start(&rig, &truth);
	assert_true(start_collapsed(&c, SCHEME_QUADTRI, &rig.judge, 1e-3, 2e-3, 300, SHARP));
	rig_check(&c.sketch);
	assert_true(c.errors.mean <= 1e-3);
	assert_true(c.sketch.vertex_count <= 100);
	assert_true(3 * c.sketch.face_count == c.sketch.face_start[c.sketch.face_count]);
	assert_int_equal(rig_euler(&c.sketch), 2);
	size_t sharp = 0;
	for (size_t h = 0; h < c.sketch.face_start[c.sketch.face_count]; h++)
		sharp += c.sketch.sharp[h];
	assert_true(sharp / 2 >= 2 * 4); /* a closed crease of fewer than four edges is no circle */
	assert_true(rig.work > 0);
	candidate_free(&c);
	/* fewer vertices than any fit needs */
	assert_false(start_collapsed(&c, SCHEME_QUADTRI, &rig.judge, 1e-3, 1e-3, 10, SHARP));
	target_free(&rig.target);
	sketch_free(&truth);
}

/* What has no sharp edge gets no crease; what has a border keeps it; a handle stays. */
static void test_torus_and_sheet(void **state)
{
	(void)state;
	for (int is_closed = 0; is_closed < 2; is_closed++) {
		struct sketch truth = rig_quads(8, 8, is_closed);
		struct start_rig rig;
		struct candidate c;
		rig_start(&rig, &truth);
		assert_true(start_collapsed(&c, SCHEME_LOOP, &rig.judge, 2e-3, 4e-3, 400, SHARP));
		rig_check(&c.sketch);
		assert_int_equal(c.sketch.scheme, SCHEME_LOOP);
		assert_int_equal(rig_euler(&c.sketch), is_closed ? 0 : 1);
		size_t pieces, loops;
		rig_topology(&pieces, &loops, &c.sketch);
		assert_int_equal(pieces, 1);
		assert_int_equal(loops, is_closed ? 0 : 1);
		for (size_t h = 0; h < c.sketch.face_start[c.sketch.face_count]; h++)
			assert_true(!c.sketch.sharp[h] || c.sketch.twin[h] == NO_INDEX);
		candidate_free(&c);
		target_free(&rig.target);
		sketch_free(&truth);
	}
}

/* Three triangles at one edge are no manifold: there is nothing to begin with. */
static void test_fan(void **state)
{
	(void)state;
	static const double xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1};
	static const idx_t triangle[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
	struct target target;
	size_t work = 0;
	target_start(&target, xyz, 5, triangle, 3, 100, 10, SHARP);
	const struct judge judge = {&target, 0.0075, 0.009, 3, &work, PEAKS_SOME};
	struct candidate c;
	assert_false(start_collapsed(&c, SCHEME_QUADTRI, &judge, 1, 1, 100, SHARP));
	target_free(&target);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_cylinder), cmocka_unit_test(test_torus_and_sheet), cmocka_unit_test(test_fan)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
