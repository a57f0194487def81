/* The joint fit and its measure (the patch method's sections 5.4 and 6.3) on cylinders, spheres and planes. */
#include "tests/unit/fitpatch_rig.h"

#include <omp.h>

/* A number in [-1, 1] of a fixed sequence. */
static double draw(uint32_t *state)
{
	*state = *state * 1664525u + 1013904223u;
	return (double)(*state >> 8) / 8388608.0 - 1;
}

static void disturb(struct draft *draft, double by)
{
	uint32_t random = 5;
	for (size_t i = 0; i < 3 * draft->control.count; i++)
		draft->control.xyz[i] += by * draw(&random);
}

static void fit(struct rig *rig, const unsigned char *still)
{
	struct fault fault = {0};
	if (!joint_fit(&rig->draft, &rig->target, &rig->rounds.joint, still, &fault))
		fail_msg("%s", fault.text);
}

static void flat_place(double p[3], double u, double v) { p[0] = u, p[1] = v, p[2] = 0; }

/* One quad over the unit square whose corners are corners of the cage: its limit surface is the square itself. */
static void one_quad(struct rig *rig, double height, bool turned)
{
	const idx_t corner[4] = {0, 1, 2, 3};
	idx_t order[4];
	for (size_t i = 0; i < rig->draft.control.count; i++) {
		assert_true(i < 4);
		const double *p = &rig->draft.control.xyz[3 * i];
		order[p[1] == 0 ? (p[0] == 0 ? 0 : 1) : (p[0] == 0 ? 3 : 2)] = corner[i];
		rig->draft.control.xyz[3 * i + 2] = height;
	}
	if (turned) {
		const idx_t swap = order[1];
		order[1] = order[3], order[3] = swap;
	}
	polygons_add(&rig->draft.polygons, order, 4, 0);
}

static void test_measure(void **state)
{
	(void)state;
	struct rig rig;
	struct fault fault = {0};
	rig_make(&rig, rig_sheet(6, PATCH_PLANE, flat_place), 0.01, 0.003);
	one_quad(&rig, 0.25, false);
	struct patch_error error;
	struct face_error face;
	assert_true(joint_measure(&error, &face, 1, &rig.draft, &rig.target, &fault));
	/* every point of either is 0.25 from the other */
	assert_near(error.mean, 0.25, 1e-9);
	assert_near(error.max, 0.25, 1e-9);
	assert_near(face.distance, 0.25, 1e-9);
	assert_near(error.normal_deg, 0, 1e-5);
	assert_near(error.folded, 0, 0);
	assert_int_equal(error.worst_face, 0);
	rig_free(&rig);
	/* Turned over, all of it is folded. */
	rig_make(&rig, rig_sheet(6, PATCH_PLANE, flat_place), 0.01, 0.003);
	one_quad(&rig, 0, true);
	assert_true(joint_measure(&error, &face, 1, &rig.draft, &rig.target, &fault));
	assert_near(error.folded, 1, 1e-9);
	assert_near(face.folded, 1, 1e-9);
	assert_near(error.max, 0, 1e-9);
	assert_near(error.normal_deg, 180, 1e-5);
	rig_free(&rig);
}

/* The cage of a draft: creases along sharp curves, none listed along borders; the nodes of a square's border are corners. */
static void test_cage(void **state)
{
	(void)state;
	struct rig rig;
	struct cage cage;
	idx_t *vertex_of;
	rig_make(&rig, rig_sheet(6, PATCH_PLANE, flat_place), 0.01, 0.003);
	one_quad(&rig, 0, false);
	const idx_t unused = control_add(&rig.draft.control, (double[3]){9, 9, 9}, POINT_INSIDE);
	draft_cage(&cage, &vertex_of, &rig.draft);
	assert_int_equal(cage.vertex_count, 4); /* points that no face uses are left out */
	assert_int_equal(vertex_of[unused], NO_INDEX);
	assert_int_equal(cage.sharp_count, 0);
	for (int v = 0; v < 4; v++)
		assert_int_equal(cage.corner[v], 1);
	free(vertex_of);
	cage_free(&cage);
	rig_free(&rig);

	rig_make(&rig, rig_box(2, 1, 1), 0.01, 0.003);
	rig_layout(&rig);
	draft_cage(&cage, &vertex_of, &rig.draft);
	assert_int_equal(cage.vertex_count, 8);
	assert_int_equal(cage.sharp_count, 12);
	for (size_t e = 0; e < 12; e++)
		assert_true(cage.sharp[2 * e] < cage.sharp[2 * e + 1] && (e == 0 || cage.sharp[2 * e] >= cage.sharp[2 * e - 2]));
	/* smooth curves are no creases */
	for (size_t k = 0; k < rig.draft.network.curve_count; k++)
		rig.draft.network.curve[k].kind = CURVE_SMOOTH;
	free(vertex_of);
	cage_free(&cage);
	draft_cage(&cage, &vertex_of, &rig.draft);
	assert_int_equal(cage.sharp_count, 0);
	free(vertex_of);
	cage_free(&cage);
	rig_free(&rig);
}

/* From disturbed points the fit finds the surface again. */
static void check_recovers(struct rig *rig, double by, double bound)
{
	rig_layout(rig);
	double mean;
	disturb(&rig->draft, by);
	const double before = rig_error(rig, &mean), mean_before = mean;
	for (int again = 0; again < 2; again++)
		fit(rig, NULL);
	const double after = rig_error(rig, &mean);
	assert_true(after < before / 2 && mean < mean_before / 3);
	assert_near(after, 0, bound);
}

static void test_cylinder(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 96, 4), 3e-3, 1e-3);
	check_recovers(&rig, 0.03, 4e-3);
	/* the points of either circle are where it is: 0 and 1 high */
	for (size_t i = 0; i < rig.draft.control.count; i++)
		assert_near(fabs(rig.draft.control.xyz[3 * i + 2] - 0.5), 0.5, 2e-3);
	rig_free(&rig);
}

/* 5.7: a sphere of at most 26 points within 5e-3 of its radius. Its six parts meet smoothly: the control points at
 * their corners have to leave the sphere for that, as only interpolated nodes are drawn to where the curves ended. */
static void test_ball(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_ball(1, 12), 8e-3, 3e-3);
	rig_layout(&rig);
	assert_true(rig_error(&rig, NULL) > 0.1); /* points on the sphere, surface within it */
	fit(&rig, NULL);
	assert_near(rig_error(&rig, NULL), 0, 5e-3);
	assert_true(rig.draft.control.count <= 26);
	size_t away = 0;
	for (size_t i = 0; i < rig.draft.control.count; i++)
		away += norm3(&rig.draft.control.xyz[3 * i]) > 1.02;
	assert_int_equal(away, rig.draft.control.count);
	rig_free(&rig);
}

/* A plane stays a plane, whatever its place in space: 1e-12 of the side (5.7). */
static void test_plane(void **state)
{
	(void)state;
	struct dense flat = rig_square_ring();
	struct dense dense = rig_turned(&flat, 1);
	dense_free(&flat);
	struct rig rig;
	rig_make(&rig, dense, 0.04, 0.01);
	rig_layout(&rig);
	const double *normal = rig.dense.patch[0].axis, height = dot3(normal, rig.dense.xyz);
	for (size_t i = 0; i < rig.draft.control.count; i++) /* within the plane they may be anywhere */
		add_scaled3(&rig.draft.control.xyz[3 * i], 0.002 * (double)i, (double[3]){normal[1], -normal[0], 0});
	fit(&rig, NULL);
	for (size_t i = 0; i < rig.draft.control.count; i++)
		assert_near(dot3(normal, &rig.draft.control.xyz[3 * i]), height, 4e-12);
	rig_free(&rig);
}

/* Points of curves that a person moved, and those told to be still, keep their bits. */
static void test_held(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 48, 2), 3e-3, 1e-3);
	rig_layout(&rig);
	disturb(&rig.draft, 0.02);
	const size_t n = rig.draft.control.count;
	unsigned char *still = mem_array(n, 1);
	for (size_t i = 0; i < n; i++)
		rig.draft.control.held[i] = i % 3 == 0, still[i] = i % 3 == 1;
	double *start = mem_copy(rig.draft.control.xyz, 3 * n, sizeof *start);
	fit(&rig, still);
	size_t moved = 0;
	for (size_t i = 0; i < n; i++) {
		const bool same = memcmp(&start[3 * i], &rig.draft.control.xyz[3 * i], 3 * sizeof *start) == 0;
		assert_true(i % 3 == 2 || same);
		moved += !same;
	}
	assert_true(moved >= n / 3 - 1);
	free(start), free(still);
	rig_free(&rig);
}

/* Virtual borders have no place of their own: with those of the mesh in steps of a facet to either side, the same cage has the same
 * error, as its feet may lie on any part of the sphere. */
static void test_virtual_border(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_ball(1, 12), 8e-3, 3e-3);
	rig_layout(&rig);
	fit(&rig, NULL);
	double mean, moved_mean;
	const double largest = rig_error(&rig, &mean);
	/* every third triangle beside a border goes over to the patch on its other side */
	size_t moved = 0;
	idx_t *label = mem_copy(rig.dense.label, rig.dense.triangle_count, sizeof *label);
	for (size_t h = 0; h < rig.half.half_count; h++) {
		const size_t t = h / 3, other = (size_t)rig.half.twin[h] / 3;
		if (rig.dense.label[other] > rig.dense.label[t] && t % 3 == 0)
			label[t] = rig.dense.label[other], moved++;
	}
	assert_true(moved > 10);
	memcpy(rig.dense.label, label, rig.dense.triangle_count * sizeof *label);
	free(label);
	assert_near(rig_error(&rig, &moved_mean), largest, 1e-4);
	assert_near(moved_mean, mean, 1e-4);
	rig_free(&rig);
}

static void turn_points(double *xyz, size_t count, double scale)
{
	struct mesh mesh = {.xyz = xyz, .vertex_count = count};
	shape_turn(&mesh, scale);
}

/* Turned, moved and a hundred times larger, the same fit. */
static void test_motion(void **state)
{
	(void)state;
	const double scale = 100;
	struct rig one, two;
	rig_make(&one, rig_cylinder(0.5, 1, 48, 4), 3e-3, 1e-3);
	rig_layout(&one);
	disturb(&one.draft, 0.02);
	struct dense dense = rig_turned(&one.dense, scale);
	struct network network = one.network;
	network.xyz = mem_copy(network.xyz, 3 * network.vertex_count, sizeof(double));
	network.kind = mem_copy(network.kind, network.vertex_count, 1);
	network.curve = mem_copy(network.curve, network.curve_count, sizeof *network.curve);
	network.point = mem_copy(network.point, network.point_count, sizeof *network.point);
	turn_points(network.xyz, network.vertex_count, scale);
	rig_start(&two, dense, network, scale * 3e-3, scale * 1e-3);
	draft_free(&two.draft);
	draft_copy(&two.draft, &one.draft);
	turn_points(two.draft.control.xyz, two.draft.control.count, scale);
	memcpy(two.sample, one.sample, 3 * RIG_SAMPLES * sizeof *one.sample);
	memcpy(two.sample_triangle, one.sample_triangle, RIG_SAMPLES * sizeof *one.sample_triangle);
	turn_points(two.sample, RIG_SAMPLES, scale);
	fit(&one, NULL);
	fit(&two, NULL);
	turn_points(one.draft.control.xyz, one.draft.control.count, scale);
	for (size_t i = 0; i < one.draft.control.count; i++)
		assert_near(distance3(&one.draft.control.xyz[3 * i], &two.draft.control.xyz[3 * i]), 0, 1e-6 * scale);
	rig_free(&one);
	rig_free(&two);
}

/* The number of threads does not show in a single bit. */
static void test_threads(void **state)
{
	(void)state;
	double *result[2];
	size_t n = 0;
	for (int threads = 1; threads <= 2; threads++) {
		struct rig rig;
		rig_make(&rig, rig_ball(1, 6), 8e-3, 3e-3);
		rig_layout(&rig);
		disturb(&rig.draft, 0.03);
		omp_set_num_threads(threads);
		fit(&rig, NULL);
		n = 3 * rig.draft.control.count;
		result[threads - 1] = mem_array(n + 2, sizeof(double));
		memcpy(result[threads - 1], rig.draft.control.xyz, n * sizeof(double));
		result[threads - 1][n] = rig_error(&rig, &result[threads - 1][n + 1]);
		rig_free(&rig);
	}
	assert_memory_equal(result[0], result[1], (n + 2) * sizeof(double));
	free(result[0]), free(result[1]);
}

/* Every form of squared distance fits; point distance cannot slide, so it is the slowest, not wrong. */
static void test_variants(void **state)
{
	(void)state;
	for (enum sqdist_variant variant = SQDIST_SIDED; variant <= SQDIST_TANGENT; variant++) {
		struct rig rig;
		rig_make(&rig, rig_cylinder(0.5, 1, 64, 4), 3e-3, 1e-3);
		rig_layout(&rig);
		disturb(&rig.draft, 0.02);
		double before, after;
		rig_error(&rig, &before);
		rig.rounds.joint.variant = variant;
		fit(&rig, NULL);
		rig_error(&rig, &after);
		assert_true(after < before / 2);
		rig_free(&rig);
	}
}

/* Faces that are no manifold are a fault, not a crash. */
static void test_fault(void **state)
{
	(void)state;
	struct rig rig;
	struct fault fault = {0};
	struct patch_error error[6];
	rig_make(&rig, rig_box(1, 1, 1), 0.01, 0.003);
	rig_layout(&rig);
	const idx_t again[3] = {rig.draft.polygons.corner[0], rig.draft.polygons.corner[1], rig.draft.polygons.corner[2]};
	polygons_add(&rig.draft.polygons, again, 3, 0);
	assert_false(joint_fit(&rig.draft, &rig.target, &rig.rounds.joint, NULL, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_true(fault.text[0] != 0);
	fault = (struct fault){0};
	assert_false(joint_measure(error, NULL, 6, &rig.draft, &rig.target, &fault));
	rig_free(&rig);
}

/* No iterations: nothing moves. */
static void test_none(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 24, 1), 3e-3, 1e-3);
	rig_layout(&rig);
	double *start = mem_copy(rig.draft.control.xyz, 3 * rig.draft.control.count, sizeof *start);
	rig.rounds.joint.iterations = 0;
	fit(&rig, NULL);
	assert_memory_equal(start, rig.draft.control.xyz, 3 * rig.draft.control.count * sizeof *start);
	free(start);
	rig_free(&rig);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_measure), cmocka_unit_test(test_cage),   cmocka_unit_test(test_cylinder), cmocka_unit_test(test_ball),
		cmocka_unit_test(test_plane),   cmocka_unit_test(test_held),   cmocka_unit_test(test_motion),   cmocka_unit_test(test_threads),
		cmocka_unit_test(test_variants), cmocka_unit_test(test_fault), cmocka_unit_test(test_none),
		cmocka_unit_test(test_virtual_border),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
