/* Whole fits with refinement on surfaces that are known (the patch method's section 5.7). */
#include "tests/unit/fitpatch_rig.h"

#include <omp.h>

#include "stages/geometry/subdivide.h"

static struct patch_error *fit(struct rig *rig)
{
	struct fault fault = {0};
	struct patch_error *error = mem_array(rig->dense.patch_count, sizeof *error);
	rig_layout(rig);
	if (!rounds_fit(&rig->draft, &rig->layouts, error, &rig->rounds, &fault))
		fail_msg("%s", fault.text);
	/* what is said of the result is true of it */
	double largest = 0;
	for (size_t p = 0; p < rig->dense.patch_count; p++)
		largest = fmax(largest, error[p].max);
	assert_near(largest, rig_error(rig, NULL), 0);
	rig_check_draft(&rig->draft, NULL);
	rig_check_curves(&rig->draft);
	return error;
}

static void test_cube(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_box(1, 1, 1), 4e-3, 1e-3);
	struct patch_error *error = fit(&rig);
	assert_int_equal(rig.draft.polygons.count, 6);
	assert_int_equal(rig.draft.control.count, 8);
	for (int p = 0; p < 6; p++)
		assert_near(error[p].max, 0, 1e-14);
	free(error);
	rig_free(&rig);
}

/* The limit surface of the draft after some steps: what its patches look like. */
static struct level limit_of(const struct draft *draft, struct cage *cage, int steps)
{
	idx_t *vertex_of;
	struct fault fault = {0};
	struct level base, fine;
	draft_cage(cage, &vertex_of, draft);
	assert_true(level_from_cage(&base, cage, &fault));
	level_refine(&fine, &base, SCHEME_QUADTRI, steps);
	level_to_limit(&fine, SCHEME_QUADTRI);
	level_free(&base);
	free(vertex_of);
	return fine;
}

/* Six points a circle: six quads, within 2.5e-3 of the radius (the best would be 2.2e-3), and a band between two equal crease polygons is ruled: its rungs are
 * straight along the axis. Facets are so fine that their sagitta is no matter. */
static void test_cylinder(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(1, 2, 180, 1), 6e-3, 6e-3);
	assert_int_equal(rig.network.vertex_count, 12);
	struct patch_error *error = fit(&rig);
	size_t corners;
	assert_int_equal(rig_faces(&rig.draft, 0, &corners), 6);
	assert_int_equal(corners, 4);
	assert_int_equal(rig.draft.control.count, 12);
	free(error);
	struct cage cage;
	struct level fine = limit_of(&rig.draft, &cage, 3);
	size_t rungs = 0;
	for (size_t v = 0; v < fine.vertex_count; v++)
		if (fine.xyz[3 * v + 2] > 0.1 && fine.xyz[3 * v + 2] < 1.9)
			assert_near(hypot(fine.xyz[3 * v], fine.xyz[3 * v + 1]), 1, 2.5e-3);
	for (size_t f = 0; f < fine.face_count; f++)
		for (size_t h = fine.face_start[f]; cage.face_patch[fine.face_origin[f]] == 0 && h < fine.face_start[f + 1]; h++) {
			const double *a = &fine.xyz[3 * (size_t)fine.face_corner[h]];
			const double *b = &fine.xyz[3 * (size_t)fine.face_corner[h + 1 < fine.face_start[f + 1] ? h + 1 : fine.face_start[f]]];
			if (fabs(b[2] - a[2]) < 0.1)
				continue;
			/* an eighth of a rung: parallel to the straight line between its ends */
			assert_near(fabs(b[2] - a[2]), 2.0 / 8, 2e-3);
			assert_near(hypot(b[0] - a[0], b[1] - a[1]), 0, 2e-3);
			rungs++;
		}
	assert_int_equal(rungs, 2 * 8 * 48); /* 8 pieces of 48 rungs, seen from both sides */
	level_free(&fine);
	cage_free(&cage);
	rig_free(&rig);
}

/* When the two circles are the same but for their height, every rung is. */
static void test_ruled(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(1, 2, 180, 1), 6e-3, 6e-3);
	rig_layout(&rig);
	for (size_t f = 0; f < rig.draft.polygons.count; f++) {
		const idx_t *q = &rig.draft.polygons.corner[rig.draft.polygons.start[f]];
		for (size_t i = 0; rig.draft.polygons.patch[f] == 0 && i < 4; i++) {
			double *a = &rig.draft.control.xyz[3 * (size_t)q[i]], *b = &rig.draft.control.xyz[3 * (size_t)q[(i + 1) % 4]];
			if (a[2] > 1 && b[2] < 1)
				a[0] = b[0], a[1] = b[1];
		}
	}
	struct cage cage;
	struct level fine = limit_of(&rig.draft, &cage, 3);
	for (size_t f = 0; f < fine.face_count; f++)
		for (size_t h = fine.face_start[f]; cage.face_patch[fine.face_origin[f]] == 0 && h < fine.face_start[f + 1]; h++) {
			const double *a = &fine.xyz[3 * (size_t)fine.face_corner[h]];
			const double *b = &fine.xyz[3 * (size_t)fine.face_corner[h + 1 < fine.face_start[f + 1] ? h + 1 : fine.face_start[f]]];
			if (fabs(b[2] - a[2]) > 0.1)
				assert_near(hypot(b[0] - a[0], b[1] - a[1]), 0, 1e-14);
		}
	level_free(&fine);
	cage_free(&cage);
	rig_free(&rig);
}

/* Discs of triangles: rings of 6, 12, 18 ... vertices. place turns a point of the unit disc into one of the surface. */
static struct dense disc(int rings, enum patch_kind kind, void (*place)(double xyz[3], double x, double y))
{
	struct mesh mesh = {0};
	for (int r = 0; r <= rings; r++)
		for (int i = 0; i < (r ? 6 * r : 1); i++) {
			const double angle = r ? 2 * PI * i / (6 * r) : 0, radius = (double)r / rings;
			double p[3];
			place(p, radius * cos(angle), radius * sin(angle));
			shape_vertex(&mesh, p[0], p[1], p[2]);
		}
	for (int r = 1; r <= rings; r++) {
		const idx_t outer = 1 + 3 * r * (r - 1), inner = r > 1 ? 1 + 3 * (r - 1) * (r - 2) : 0;
		const int n = 6 * r, m = r > 1 ? 6 * (r - 1) : 1;
		for (int side = 0; side < 6; side++)
			for (int k = 0; k < r; k++) {
				const idx_t a = outer + (side * r + k) % n, b = outer + (side * r + k + 1) % n, c = inner + (side * (r - 1) + k) % m;
				shape_triangle(&mesh, a, b, c);
				if (k + 1 < r)
					shape_triangle(&mesh, b, inner + (side * (r - 1) + k + 1) % m, c);
			}
	}
	idx_t *label = mem_array(mesh.face_count, sizeof *label);
	struct dense dense = rig_dense(&mesh, label, 1, &kind);
	free(label);
	shape_free(&mesh);
	return dense;
}

static void half_ball_place(double p[3], double x, double y)
{
	const double radius = hypot(x, y), polar = radius * PI / 2;
	p[0] = radius > 0 ? sin(polar) * x / radius : 0, p[1] = radius > 0 ? sin(polar) * y / radius : 0, p[2] = cos(polar);
}

static void saddle_place(double p[3], double x, double y) { p[0] = x, p[1] = y, p[2] = x * x - y * y; }

/* A plane circle bounds a half sphere: no flat disc may come of it. */
static void test_half_sphere(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, disc(12, PATCH_SPHERE, half_ball_place), 8e-3, 3e-3);
	struct patch_error *error = fit(&rig);
	assert_near(error[0].max, 0, 8e-3);
	assert_near(error[0].mean, 0, 3e-3);
	double top = 0;
	for (size_t i = 0; i < rig.draft.control.count; i++)
		top = fmax(top, rig.draft.control.xyz[3 * i + 2]);
	assert_true(top > 0.95);
	free(error);
	rig_free(&rig);
}

static void test_saddle(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, disc(12, PATCH_FREE, saddle_place), 8e-3, 3e-3);
	struct patch_error *error = fit(&rig);
	assert_near(error[0].max, 0, 8e-3);
	assert_near(error[0].mean, 0, 3e-3);
	free(error);
	rig_free(&rig);
}

/* Six parts that meet smoothly: 5e-3 of the radius with at most 26 points. */
static void test_ball(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_ball(1, 16), 8e-3, 3e-3);
	struct patch_error *error = fit(&rig);
	for (int p = 0; p < 6; p++)
		assert_near(error[p].max, 0, 5e-3);
	assert_true(rig.draft.control.count <= 26);
	free(error);
	rig_free(&rig);
}

/* With no rounds there is one layout and one fit, whatever the error. */
static void test_limit(void **state)
{
	(void)state;
	size_t faces[2];
	for (int limit = 0; limit < 2; limit++) {
		struct rig rig;
		rig_make(&rig, disc(8, PATCH_SPHERE, half_ball_place), 8e-3, 3e-3);
		rig.rounds.limit = limit;
		rig_layout(&rig);
		const size_t first = rig.draft.polygons.count;
		free(fit(&rig));
		faces[limit] = rig.draft.polygons.count;
		if (limit == 0)
			assert_int_equal(first, faces[0]);
		rig_free(&rig);
	}
	assert_true(faces[1] > faces[0]);
}

/* A loose end of the bounds: nothing to do, nothing done. */
static void test_within(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(1, 2, 48, 1), 6e-3, 6e-3);
	rig.rounds.bounds = (struct bounds){1, 1};
	free(fit(&rig));
	assert_int_equal(rig_faces(&rig.draft, 0, NULL), rig.network.curve[0].count);
	assert_int_equal(rig.draft.control.count, rig.network.vertex_count);
	rig_free(&rig);
}

/* The edges between the parts of a sphere are no creases, given the choice; those of a cube are, and stay what they were. */
static void test_relax(void **state)
{
	(void)state;
	for (int shape = 0; shape < 2; shape++) {
		struct rig rig;
		struct fault fault = {0};
		struct dense dense = shape ? rig_box(1, 1, 1) : rig_ball(1, 12);
		for (int p = 0; p < 6; p++)
			dense.patch[p].parent = p;
		rig_make(&rig, dense, 0.02, 0.01);
		for (size_t k = 0; k < 12; k++)
			rig.draft.network.curve[k].kind = CURVE_SHARP;
		rig.draft.tangential = mem_array(12, 1);
		memset(rig.draft.tangential, 1, 12);
		struct patch_error *error = fit(&rig);
		double *before = mem_copy(rig.draft.control.xyz, 3 * rig.draft.control.count, sizeof *before);
		size_t smooth;
		assert_int_equal(rig.draft.network.curve_count, 12);
		assert_true(rounds_relax(&rig.draft, error, &smooth, &rig.rounds, &fault));
		assert_int_equal(smooth, shape ? 0 : 12);
		for (size_t k = 0; k < 12; k++)
			assert_int_equal(rig.draft.network.curve[k].kind, shape ? CURVE_SHARP : CURVE_SMOOTH);
		if (shape)
			assert_memory_equal(before, rig.draft.control.xyz, 3 * rig.draft.control.count * sizeof *before);
		double largest = 0;
		for (int p = 0; p < 6; p++)
			largest = fmax(largest, error[p].max);
		assert_near(largest, rig_error(&rig, NULL), 0);
		free(before), free(error);
		rig_free(&rig);
	}
}

/* Held points stay through all rounds. */
static void test_held(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, disc(8, PATCH_SPHERE, half_ball_place), 8e-3, 3e-3);
	const size_t n = rig.draft.control.count;
	for (size_t i = 0; i < n; i++)
		rig.draft.control.held[i] = 1;
	rig.draft.control.xyz[0] += 0.02;
	double *start = mem_copy(rig.draft.control.xyz, 3 * n, sizeof *start);
	rig.rounds.limit = 2;
	free(fit(&rig));
	assert_memory_equal(start, rig.draft.control.xyz, 3 * n * sizeof *start);
	free(start);
	rig_free(&rig);
}

/* The same bits with one thread and two, all rounds through. */
static void test_threads(void **state)
{
	(void)state;
	struct draft result[2];
	for (int threads = 1; threads <= 2; threads++) {
		struct rig rig;
		omp_set_num_threads(threads);
		rig_make(&rig, disc(6, PATCH_SPHERE, half_ball_place), 8e-3, 3e-3);
		rig.rounds.limit = 1;
		free(fit(&rig));
		draft_copy(&result[threads - 1], &rig.draft);
		rig_free(&rig);
	}
	assert_int_equal(result[0].control.count, result[1].control.count);
	assert_int_equal(result[0].polygons.count, result[1].polygons.count);
	assert_memory_equal(result[0].control.xyz, result[1].control.xyz, 3 * result[0].control.count * sizeof(double));
	assert_memory_equal(result[0].polygons.corner, result[1].polygons.corner, result[0].polygons.start[result[0].polygons.count] * sizeof(idx_t));
	draft_free(&result[0]);
	draft_free(&result[1]);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_cube),  cmocka_unit_test(test_cylinder), cmocka_unit_test(test_ruled),  cmocka_unit_test(test_half_sphere),
		cmocka_unit_test(test_saddle), cmocka_unit_test(test_ball),    cmocka_unit_test(test_limit),  cmocka_unit_test(test_within),
		cmocka_unit_test(test_relax), cmocka_unit_test(test_held),     cmocka_unit_test(test_threads),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
