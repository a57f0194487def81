/* The whole of polish on dense meshes whose cheapest cages are known. */
#include "tests/unit/polish_rig.h"

#include "stages/polish/plan.h"

/* The sketch after a step of subdivision: a cage of four times as many faces of nearly the same surface. */
static struct sketch refined(const struct sketch *s, int steps)
{
	struct level level = sketch_level(s), fine;
	level_refine(&fine, &level, s->scheme, steps);
	free(level.corner), free(level.face_origin);
	const size_t halves = fine.face_start[fine.face_count];
	struct sketch out = {.scheme = s->scheme, .vertex_count = fine.vertex_count, .face_count = fine.face_count,
	                     .next_id = (idx_t)fine.vertex_count, .next_face_id = (idx_t)fine.face_count};
	out.xyz = mem_copy(fine.xyz, 3 * fine.vertex_count, sizeof *out.xyz);
	out.id = mem_array(fine.vertex_count, sizeof *out.id);
	for (size_t v = 0; v < fine.vertex_count; v++)
		out.id[v] = (idx_t)v;
	out.corner = mem_copy(fine.corner, fine.vertex_count, 1);
	out.face_start = mem_copy(fine.face_start, fine.face_count + 1, sizeof *out.face_start);
	out.face_corner = mem_copy(fine.face_corner, halves, sizeof *out.face_corner);
	out.sharp = mem_copy(fine.sharp, halves, 1);
	out.face_patch = mem_array(fine.face_count, sizeof *out.face_patch);
	out.face_id = mem_array(fine.face_count, sizeof *out.face_id);
	for (size_t f = 0; f < fine.face_count; f++)
		out.face_id[f] = (idx_t)f;
	assert_true(sketch_connect(&out));
	level_free(&fine);
	return out;
}

static const double middle[3] = {30, 0, -4};
#define SCALE 20.0

static void __attribute__((format(printf, 1, 2))) say_nothing(const char *format, ...) { (void)format; }

/* Takes the sketch; truth: what the mesh is made of. */
static struct plan_result polish(struct sketch start, const struct sketch *truth, double mean, double max, int effort)
{
	struct rig_mesh mesh = rig_dense(truth, 3);
	struct target target;
	target_start(&target, mesh.xyz, mesh.vertex_count, mesh.triangle, mesh.triangle_count, 500, 150, SHARP_DEG);
	rig_mesh_free(&mesh);
	const struct plan_options options = {.mean = mean, .max = max, .level = 3, .effort = effort, .middle = middle, .scale = SCALE, .say = say_nothing};
	struct plan_result result;
	struct cage given;
	sketch_to_cage(&given, &start, middle, SCALE);
	assert_true(plan_run(&result, &given, &start, &target, &options));
	cage_free(&given);
	target_free(&target);
	return result;
}

/* What is promised of any result: a cage on its grid, coded in as many bytes as it says. */
static void check_result(const struct plan_result *r)
{
	struct ffx ffx;
	struct fault fault = {0};
	unsigned char *bytes;
	size_t size;
	struct ffx_report report;
	const struct ffx_options options = {0};
	assert_true(r->cage.grid_step > 0);
	if (!ffx_from_cage(&ffx, &r->cage, &fault))
		fail_msg("%s", fault.text);
	assert_true(ffx_encode(&bytes, &size, &report, &ffx, &options, &fault));
	assert_true(size <= r->bytes); /* more start edges may be tried than polish did */
	free(bytes);
	ffx_free(&ffx);
	struct level level;
	if (!level_from_cage(&level, &r->cage, &fault))
		fail_msg("%s", fault.text);
	level_free(&level);
}

static void assert_within(const struct plan_result *r, double mean, double max)
{
	assert_true(r->is_within);
	assert_true(r->errors.mean <= mean);
	assert_true(r->errors.max <= max);
}

/* A cube cut up into 24 faces: eight points are enough. */
static void test_cube(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(true);
	struct plan_result plain = polish(rig_cube(true), &cube, 1e-3, 1e-2, 0), r = polish(refined(&cube, 1), &cube, 1e-3, 1e-2, 3);
	check_result(&plain), check_result(&r);
	assert_within(&plain, 1e-3, 1e-2), assert_within(&r, 1e-3, 1e-2);
	assert_false(r.is_given);
	assert_int_equal(r.start_vertices, 26);
	assert_int_equal(r.start_faces, 24);
	assert_true(r.cage.vertex_count <= 8 && r.cage.face_count <= 6);
	assert_true(r.bytes <= plain.bytes);
	assert_true(r.search.done > 0 && r.rounded > 0 && r.measured > 0);
	/* The cube is where the part was, in its units. */
	for (size_t v = 0; v < r.cage.vertex_count; v++)
		for (int k = 0; k < 3; k++)
			assert_near(fabs(r.cage.xyz[3 * v + k] - middle[k]), SCALE / 2, 1.5e-2 * SCALE);
	cage_free(&plain.cage), cage_free(&r.cage);
	sketch_free(&cube);
}

static void assert_same(const struct plan_result *a, const struct plan_result *b)
{
	assert_int_equal(a->bytes, b->bytes);
	assert_int_equal(a->search.tried, b->search.tried);
	assert_memory_equal(&a->errors, &b->errors, sizeof a->errors);
	assert_int_equal(a->cage.vertex_count, b->cage.vertex_count);
	assert_memory_equal(a->cage.xyz, b->cage.xyz, 3 * a->cage.vertex_count * sizeof *a->cage.xyz);
	assert_int_equal(a->cage.face_count, b->cage.face_count);
	assert_memory_equal(a->cage.face_corner, b->cage.face_corner, a->cage.face_start[a->cage.face_count] * sizeof *a->cage.face_corner);
	assert_int_equal(a->cage.sharp_count, b->cage.sharp_count);
	assert_memory_equal(a->cage.sharp, b->cage.sharp, 2 * a->cage.sharp_count * sizeof *a->cage.sharp);
}

/* A part made of a prism of six sides, from a cage of four times as many faces: the search comes down to fewer bytes than the start
 * takes on the best grid, within the same bounds; and the same again, to the bit. */
static void test_cylinder(void **state)
{
	(void)state;
	struct sketch truth = rig_prism(6);
	struct plan_result plain = polish(refined(&truth, 1), &truth, 2e-3, 1.5e-2, 0), r = polish(refined(&truth, 1), &truth, 2e-3, 1.5e-2, 3),
	                   again = polish(refined(&truth, 1), &truth, 2e-3, 1.5e-2, 3);
	check_result(&plain), check_result(&r);
	assert_within(&plain, 2e-3, 1.5e-2), assert_within(&r, 2e-3, 1.5e-2);
	assert_true(10 * r.bytes < 9 * plain.bytes);
	assert_true(r.cage.vertex_count < r.start_vertices / 2);
	assert_true(r.cage.sharp_count >= 6); /* both rims are still sharp: their creases need three edges each */
	assert_same(&r, &again);
	cage_free(&plain.cage), cage_free(&r.cage), cage_free(&again.cage);
	sketch_free(&truth);
}

/* A round part without creases needs none. */
static void test_ball(void **state)
{
	(void)state;
	struct sketch truth = rig_cube(false);
	struct plan_result r = polish(refined(&truth, 1), &truth, 2e-3, 1.5e-2, 3);
	check_result(&r);
	assert_within(&r, 2e-3, 1.5e-2);
	assert_true(r.cage.vertex_count <= r.start_vertices && r.cage.face_count <= r.start_faces);
	assert_int_equal(r.cage.sharp_count, 0);
	cage_free(&r.cage);
	sketch_free(&truth);
}

/* A cage that cannot come near says so, and is the nearest there was: one on a grid, or the cage as it came. */
static void test_hopeless(void **state)
{
	(void)state;
	struct sketch truth = rig_prism(6);
	struct plan_result r = polish(rig_cube(true), &truth, 1e-4, 1e-3, 0);
	if (r.is_given)
		assert_near(r.cage.grid_step, 0, 0);
	else
		check_result(&r);
	assert_false(r.is_within);
	assert_true(r.errors.mean > 1e-4 || r.errors.max > 1e-3);
	cage_free(&r.cage);
	sketch_free(&truth);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_cube), cmocka_unit_test(test_cylinder), cmocka_unit_test(test_ball),
		cmocka_unit_test(test_hopeless),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
