/* Judging a cage against a dense mesh: cubes, whose distances can be told by hand, and parts of a judgement against the whole. */
#include "tests/unit/polish_rig.h"

#include "stages/geometry/vector.h"
#include "stages/polish/refit.h"

static struct target target_of(const struct sketch *s, int steps, size_t samples)
{
	struct rig_mesh mesh = rig_dense(s, steps);
	struct target target;
	target_start(&target, mesh.xyz, mesh.vertex_count, mesh.triangle, mesh.triangle_count, samples, samples / 4, 30);
	rig_mesh_free(&mesh);
	return target;
}
static size_t looked_at; /* counts on; nobody asks */
static struct judge judge_of(const struct target *target) { return (struct judge){.target = target, .max = 0.0075, .limit = 0.0095, .steps = 3, .work = &looked_at}; }

/* Samples of a cube lie on its faces with their normals; behind them come points of its edges, which are where two coordinates are half
 * a side. */
static void test_target(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(true);
	struct target t = target_of(&cube, 2, 600), again = target_of(&cube, 2, 600), more;
	assert_near(t.area, 6, 1e-12);
	assert_int_equal(t.area_count, 600);
	assert_true(t.count > 600 && t.count <= 600 + 150 + 4);
	size_t on_side[6] = {0};
	for (size_t i = 0; i < t.count; i++) {
		const double *p = &t.point[3 * i], *n = &t.normal[3 * i];
		size_t halves = 0;
		for (int k = 0; k < 3; k++) {
			assert_true(fabs(p[k]) <= 0.5 + 1e-12);
			halves += fabs(p[k]) > 0.5 - 1e-9;
			if (fabs(n[k]) > 0.5 && i < t.area_count)
				on_side[2 * k + (n[k] > 0)]++;
		}
		assert_near(dot3(p, n), 0.5, 1e-9);
		assert_true(halves >= (i < t.area_count ? 1u : 2u));
	}
	for (int k = 0; k < 6; k++)
		assert_in_range(on_side[k], 80, 120); /* uniform: a sixth each */
	assert_int_equal(again.count, t.count);
	assert_memory_equal(again.point, t.point, 3 * t.count * sizeof *t.point);
	/* Other samples of the same mesh; the first ones stay as they are, and so does the mesh when these are gone. */
	target_resample(&more, &t, 900, 100, 30);
	assert_int_equal(more.area_count, 900);
	assert_ptr_equal(more.xyz, t.xyz);
	target_free(&more);
	assert_memory_equal(again.point, t.point, 3 * t.count * sizeof *t.point);
	assert_memory_equal(again.xyz, t.xyz, 3 * t.vertex_count * sizeof *t.xyz);
	target_free(&t), target_free(&again);
	sketch_free(&cube);
}

/* The cost rises with the distance, ever more steeply, and its slope is its slope. */
static void test_cost(void **state)
{
	(void)state;
	const struct judge judge = {.max = 0.0075, .limit = 0.0095};
	assert_near(judge_cost(&judge, 0, false), 0, 0);
	assert_true(judge_cost(&judge, 0, true) > 0);
	double last_slope = 0;
	for (int i = 1; i < 400; i++) {
		const double d = i * 5e-5 + 1e-6, h = 1e-8, slope = (judge_cost(&judge, d + h, false) - judge_cost(&judge, d - h, false)) / (2 * h);
		assert_near(judge_slope(&judge, d), slope, 1e-4 * slope);
		assert_true(slope >= last_slope - 1e-4);
		assert_near(judge_cost(&judge, d, true) - judge_cost(&judge, d, false), judge_cost(&judge, 0, true), 1e-12);
		last_slope = slope;
	}
}

/* Two cubes, one moved by d along x. From either, two faces are d away, and of the other four a strip of width d is, half as far in the
 * mean: (2 d + 4 d^2 / 2) / 6. The largest is d. */
static void test_shifted_cube(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(true);
	struct target t = target_of(&cube, 2, 6000);
	const struct judge judge = judge_of(&t);
	struct errors e;
	judge_all(&e, &judge, &cube);
	assert_near(e.mean, 0, 1e-9);
	assert_near(e.max, 0, 1e-9);
	assert_near(e.cost, 0, 1e-8);
	assert_near(e.turned, 0, 0);
	errors_free(&e);
	double last = 0;
	for (int i = 1; i <= 3; i++) {
		const double d = 2e-3 * i;
		for (size_t v = 0; v < 8; v++)
			cube.xyz[3 * v] += 2e-3;
		judge_all(&e, &judge, &cube);
		assert_near(e.mean, (2 * d + 2 * d * d) / 6, 0.05 * d / 3);
		assert_near(e.max, d, 1e-6);
		assert_true(e.cost > last && e.cost > e.mean);
		assert_near(e.turned, 0, 1e-3);
		last = e.cost;
		errors_free(&e);
	}
	sketch_free(&cube), target_free(&t);
}

/* Seen from inside, all of it is turned. */
static void test_inside_out(void **state)
{
	(void)state;
	int reversed[32];
	for (int f = 0; f < 6; f++)
		for (int i = 0; i < 5; i++)
			reversed[5 * f + i] = i < 4 ? cube_faces[5 * f + 3 - i] : -1;
	reversed[30] = -2;
	double xyz[24];
	for (int i = 0; i < 24; i++)
		xyz[i] = cube_xyz[i] / 2;
	struct sketch cube = rig_cube(true), inside = rig_make(xyz, 8, reversed, cube_edges);
	struct target t = target_of(&cube, 2, 1000);
	const struct judge judge = judge_of(&t);
	struct errors e;
	judge_all(&e, &judge, &inside);
	assert_near(e.turned, 1, 1e-9);
	assert_true(e.cost >= judge_cost(&judge, 0, true));
	errors_free(&e);
	sketch_free(&cube), sketch_free(&inside), target_free(&t);
}

/* Every sample is on the list of its face and on no other; faces' and samples' costs add up to the whole; and the view of some faces with
 * their samples, nothing else, sees what the whole saw there, when they are as near as other faces. */
static void test_parts(void **state)
{
	(void)state;
	struct sketch torus = rig_quads(8, 6, true);
	struct target t = target_of(&torus, 2, 3000);
	const struct judge judge = judge_of(&t);
	uint32_t seed = 3;
	for (size_t i = 0; i < 3 * torus.vertex_count; i++) {
		seed = seed * 1664525u + 1013904223u;
		torus.xyz[i] += 4e-3 * ((seed >> 8) / 16777216.0 - 0.5);
	}
	struct errors e;
	judge_all(&e, &judge, &torus);
	assert_true(e.mean > 1e-4 && e.mean < 4e-3 && e.max > e.mean && e.max < 1e-2);
	size_t listed = 0;
	double samples = 0, spots = 0, area = 0, tips = 0, worst = 0;
	for (size_t f = 0; f < torus.face_count; f++) {
		for (size_t k = e.face_first[f]; k < e.face_first[f + 1]; k++, listed++)
			assert_int_equal(e.sample[e.face_sample[k]].face, f);
		spots += e.face[f].cost, area += e.face[f].area, worst = fmax(worst, e.face[f].worst);
	}
	assert_int_equal(listed, t.count);
	for (size_t i = 0; i < t.count; i++)
		samples += (double)e.sample[i].cost, worst = fmax(worst, (double)e.sample[i].distance);
	for (size_t v = 0; v < torus.vertex_count; v++)
		tips += (double)e.tip[v];
	assert_near(e.cost, ((samples + tips) / (double)t.area_count + spots / area) / 2, 1e-6 * e.cost);
	assert_true(worst <= e.max + 1e-9);
	const idx_t seed_vertex = 11;
	size_t count, sample_count = 0;
	idx_t *face = sketch_faces_near(&count, &torus, &seed_vertex, 1, 2), *sample = mem_array(t.count, sizeof *sample);
	double near_spots = 0, near_samples = 0;
	for (size_t i = 0; i < count; i++) {
		near_spots += e.face[face[i]].cost;
		for (size_t k = e.face_first[face[i]]; k < e.face_first[face[i] + 1]; k++)
			near_samples += (double)e.sample[sample[sample_count++] = e.face_sample[k]].cost;
	}
	struct view view;
	view_open(&view, &judge, &torus, face, count, sample, sample_count);
	assert_near(view.spot_sum, near_spots, 1e-9);
	assert_near(view.sample_sum, near_samples, 1e-5 * near_samples); /* kept as floats */
	/* There and back is as before, to the bit. */
	const double before = view_cost(&view, &judge, area);
	torus.xyz[3 * 11 + 2] += 0.25;
	view_move(&view, &judge, &torus);
	assert_true(view_cost(&view, &judge, area) > before);
	torus.xyz[3 * 11 + 2] -= 0.25;
	view_move(&view, &judge, &torus);
	assert_near(view_cost(&view, &judge, area), before, 1e-12);
	view_free(&view);
	free(face), free(sample);
	errors_free(&e);
	sketch_free(&torus), target_free(&t);
}

/* Fits lower the cost, and find the cage that the mesh was made of when they start near it. */
static void test_refit(void **state)
{
	(void)state;
	struct sketch torus = rig_quads(8, 6, true), moved;
	struct target t = target_of(&torus, 3, 3000);
	const struct judge judge = judge_of(&t);
	sketch_copy(&moved, &torus);
	uint32_t seed = 9;
	for (size_t i = 0; i < 3 * moved.vertex_count; i++) {
		seed = seed * 1664525u + 1013904223u;
		moved.xyz[i] += 4e-3 * ((seed >> 8) / 16777216.0 - 0.5);
	}
	struct errors before, after;
	judge_all(&before, &judge, &moved);
	struct sketch one;
	sketch_copy(&one, &moved);
	refit_all(&moved, &after, &judge, 8);
	assert_true(after.cost < before.cost / 4);
	assert_true(after.mean < before.mean / 4);
	errors_free(&after);
	/* A single vertex can do less; the cost is the one that was promised. */
	const idx_t vertex[2] = {17, 3};
	size_t count, sample_count = 0;
	idx_t *face = sketch_faces_near(&count, &one, vertex, 2, 2), *sample = mem_array(t.count, sizeof *sample);
	for (size_t i = 0; i < count; i++)
		for (size_t k = before.face_first[face[i]]; k < before.face_first[face[i] + 1]; k++)
			sample[sample_count++] = before.face_sample[k];
	struct view view;
	view_open(&view, &judge, &one, face, count, sample, sample_count);
	const double area = 2, start = view_cost(&view, &judge, area), reached = refit_few(&one, &view, &judge, vertex, 2, area, INFINITY, 4);
	assert_true(reached < start);
	assert_near(view_cost(&view, &judge, area), reached, 1e-15);
	for (size_t v = 0; v < one.vertex_count; v++)
		if (v != 17 && v != 3) {
			seed = 9;
			for (size_t i = 0; i <= 3 * v; i++)
				seed = seed * 1664525u + 1013904223u;
			assert_near(one.xyz[3 * v], torus.xyz[3 * v] + 4e-3 * ((seed >> 8) / 16777216.0 - 0.5), 1e-15); /* the others stay */
		}
	view_free(&view);
	free(face), free(sample);
	errors_free(&before);
	sketch_free(&one), sketch_free(&moved), sketch_free(&torus), target_free(&t);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_target),     cmocka_unit_test(test_cost),  cmocka_unit_test(test_shifted_cube),
		cmocka_unit_test(test_inside_out), cmocka_unit_test(test_parts), cmocka_unit_test(test_refit),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
