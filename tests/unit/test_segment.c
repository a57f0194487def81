/* Segmentation by analytic surfaces: sample parts whose faces are known. */
#include "tests/unit/segmented.h"

#define ALL (1 - 1e-9) /* of the pairs: but for rounding */

/* Faces of the part and facets round a circle; all patches must be faces. */
static void assert_faces(const char *name, const struct part_options *options, double least_rand)
{
	struct segmented s;
	segmented_part(&s, name, options);
	segmented_run(&s);
	segmented_assert_sound(&s);
	const double rand = segmented_rand(&s, s.regions.label, s.truth);
	if (rand < least_rand || (least_rand >= ALL && s.regions.count != s.face_count))
		fail_msg("%s: %zu patches for %zu faces, Rand index %g", name, s.regions.count, s.face_count, rand);
	segmented_free(&s);
}

/* The method's acceptance list: cube 6, capped cylinder 3 whatever its facets and with or without rings, cylinder with a half
 * sphere 3, box with one filleted edge 7, sphere 1, torus 1. */
static void test_acceptance(void **state)
{
	(void)state;
	assert_faces("cube", &(struct part_options){.nasty = true}, ALL);
	assert_faces("cube", &(struct part_options){.target = 1000}, ALL);
	static const int facets[] = {8, 9, 12, 24, 60, 200};
	for (size_t i = 0; i < sizeof facets / sizeof *facets; i++)
		assert_faces("cylinder", &(struct part_options){.nasty = true, .facets = facets[i]}, ALL);
	assert_faces("cylinder", &(struct part_options){.facets = 8, .edge = 5}, ALL);
	assert_faces("cylinder", &(struct part_options){.facets = 36, .edge = 5}, ALL);
	assert_faces("dome", &(struct part_options){.facets = 36}, ALL);
	assert_faces("filleted", &(struct part_options){.nasty = true}, ALL);
	assert_faces("filleted", &(struct part_options){.target = 2000}, ALL);
	assert_faces("uvsphere", &(struct part_options){.facets = 24}, ALL);
	assert_faces("icosphere", &(struct part_options){.target = 1000}, ALL);
	assert_faces("ring", &(struct part_options){.facets = 24}, ALL);
}

/* Coaxial steps of different radius, fillets, chamfers, cones, bores, tangent faces on every side. */
static void test_parts(void **state)
{
	(void)state;
	static const char *const name[] = {"frustum", "cone", "pin", "shaft", "spool", "flange", "plate3", "bracket", "chamfered", "nut", "crosshole", "rounded", "elbow"};
	for (size_t i = 0; i < sizeof name / sizeof *name; i++)
		assert_faces(name[i], &(struct part_options){.facets = 36, .edge = 20}, ALL);
	static const char *const coarse[] = {"frustum", "cone", "shaft", "spool", "flange", "plate12", "bracket", "chamfered", "nut", "crosshole"};
	for (size_t i = 0; i < sizeof coarse / sizeof *coarse; i++)
		assert_faces(coarse[i], &(struct part_options){.nasty = true, .facets = 24}, ALL);
	/* where the pipe goes over into its bend, facets at its sides are flat across the seam */
	assert_faces("elbow", &(struct part_options){.nasty = true}, ALL);
	/* involutes are no analytic surface: they may come in pieces */
	assert_faces("gear", &(struct part_options){.nasty = true}, 0.98);
}

/* Vertices moved by up to 2e-4 of the longest side: the patches stay, by more than 98 % of the pairs. */
static void test_noise(void **state)
{
	(void)state;
	static const char *const name[] = {"cylinder", "filleted", "bracket", "pin"};
	for (size_t i = 0; i < sizeof name / sizeof *name; i++)
		assert_faces(name[i], &(struct part_options){.target = 1500, .jitter = 2e-4}, 0.98);
}

/* Kind, radius, side and residual of each patch are those of the face that it is. */
static void test_parameters(void **state)
{
	(void)state;
	struct segmented s;
	segmented_part(&s, "flange", &(struct part_options){.facets = 36, .edge = 20});
	segmented_run(&s);
	assert_int_equal(s.regions.count, s.face_count);
	for (size_t t = 0; t < s.facets.triangle_count; t++) {
		const struct dense_patch *p = &s.regions.patch[s.regions.label[t]];
		const struct solid_face *face = &s.face[s.truth[t]];
		assert_int_equal(p->kind, face->kind);
		if (p->kind == PATCH_CYLINDER)
			assert_near(p->radius * s.facets.side, face->radius, 1e-5 * face->radius);
		assert_true(p->residual < 1e-6);
		/* the outward normal of the surface is that of the mesh */
		double normal[3];
		primitive_foot(p, s.facets.centroid + 3 * t, NULL, normal);
		assert_true(dot3(normal, s.facets.normal + 3 * t) > 0.98);
	}
	segmented_free(&s);
}

/* The same part turned, shifted, scaled, with other numbers of vertices and triangles has the same faces. */
static void test_invariance(void **state)
{
	(void)state;
	static const char *const name[] = {"shaft", "bracket", "rounded"};
	for (size_t i = 0; i < sizeof name / sizeof *name; i++) {
		assert_faces(name[i], &(struct part_options){.facets = 24, .edge = 20, .rotate = true}, ALL);
		assert_faces(name[i], &(struct part_options){.facets = 24, .edge = 20, .shuffle = true, .seed = 5}, ALL);
		assert_faces(name[i], &(struct part_options){.facets = 24, .edge = 20, .scale = 1e-3}, ALL);
		assert_faces(name[i], &(struct part_options){.facets = 24, .edge = 20, .scale = 1e4}, ALL);
	}
}

/* On a noisy part, where the patches are a matter of judgement, renumbering leaves them as they are on 99 % of the area. */
static void test_renumbering(void **state)
{
	(void)state;
	struct segmented a, b;
	segmented_part(&a, "bracket", &(struct part_options){.target = 1500, .jitter = 2e-4});
	segmented_run(&a);
	const size_t n = a.dense.triangle_count, nv = a.dense.vertex_count;
	double *xyz = mem_array(3 * nv, sizeof *xyz);
	idx_t *triangle = mem_array(3 * n, sizeof *triangle), *back = mem_array(n, sizeof *back);
	for (size_t v = 0; v < 3 * nv; v++)
		xyz[3 * (nv - 1 - v / 3) + v % 3] = a.dense.xyz[v];
	for (size_t t = 0; t < n; t++)
		for (int k = 0; k < 3; k++)
			triangle[3 * (n - 1 - t) + k] = (idx_t)nv - 1 - a.dense.triangle[3 * t + (k + 1) % 3];
	segmented_dense(&b, xyz, nv, triangle, n);
	segmented_run(&b);
	for (size_t t = 0; t < n; t++)
		back[t] = b.regions.label[n - 1 - t];
	assert_true(segmented_rand(&a, a.regions.label, back) > 0.98);
	free(xyz);
	free(triangle);
	free(back);
	segmented_free(&a);
	segmented_free(&b);
}

/* An ellipsoid is no analytic surface of ours: it ends in connected charts that do not turn far, within the bound. */
static void test_free_form(void **state)
{
	(void)state;
	struct segmented sphere, s;
	segmented_part(&sphere, "icosphere", &(struct part_options){.target = 5000});
	for (size_t v = 0; v < sphere.dense.vertex_count; v++) {
		sphere.dense.xyz[3 * v + 1] *= 0.7;
		sphere.dense.xyz[3 * v + 2] *= 0.45;
	}
	segmented_dense(&s, sphere.dense.xyz, sphere.dense.vertex_count, sphere.dense.triangle, sphere.dense.triangle_count);
	segmented_run(&s);
	segmented_assert_sound(&s);
	assert_in_range(s.regions.count, 2, 60);
	segmented_free(&s);
	segmented_free(&sphere);
}

/* A gently bent open sheet is one free patch: surfaces that only approximate it are not its faces. */
static void test_saddle(void **state)
{
	(void)state;
	struct segmented s;
	segmented_part(&s, "saddle", &(struct part_options){0});
	segmented_run(&s);
	segmented_assert_sound(&s);
	assert_int_equal(s.regions.count, 1);
	assert_int_equal(s.regions.patch[0].kind, PATCH_FREE);
	segmented_free(&s);
}

/* A ring of a twisted band of few triangles is some bent patches, not as many planes; a box with bevels, whose faces are as few
 * triangles each and bend less, is its planes. */
static void test_few_triangles(void **state)
{
	(void)state;
	enum { STEPS = 17, STEP_DEG = 20 };
	double xyz[6 * (STEPS + 1)];
	idx_t triangle[6 * STEPS];
	struct segmented s;
	for (int i = 0; i <= STEPS; i++)
		for (int side = 0; side < 2; side++) {
			const double a = i * STEP_DEG / DEGREES, half = side ? 10 : -10, r = 30 + half * cos(a / 2);
			memcpy(xyz + 6 * i + 3 * side, (double[3]){r * cos(a), r * sin(a), half * sin(a / 2)}, 3 * sizeof *xyz);
		}
	for (int i = 0; i < STEPS; i++)
		memcpy(triangle + 6 * i, (idx_t[6]){2 * i, 2 * i + 2, 2 * i + 3, 2 * i, 2 * i + 3, 2 * i + 1}, 6 * sizeof *triangle);
	segmented_dense(&s, xyz, 2 * (STEPS + 1), triangle, 2 * STEPS);
	segmented_run(&s);
	segmented_assert_sound(&s);
	/* cut by how far a patch may turn, no more */
	assert_in_range(s.regions.count, 1, 8);
	for (size_t i = 0; i < s.regions.count; i++)
		assert_true(s.regions.patch[i].kind != PATCH_PLANE);
	segmented_free(&s);

	/* a square tower whose upper end slopes all round, by 30 degrees and then by 65: 4 walls, 8 slopes, 1 top */
	double tower[48];
	idx_t face[6 * 12 + 6];
	static const double radius[4] = {10, 10, 9, 6}, height[4] = {0, 20, 21.732, 23.131};
	for (int level = 0; level < 4; level++)
		for (int k = 0; k < 4; k++)
			memcpy(tower + 12 * level + 3 * k, (double[3]){(k == 0 || k == 3 ? -1 : 1) * radius[level], (k < 2 ? -1 : 1) * radius[level], height[level]}, 3 * sizeof *tower);
	for (int level = 0; level < 3; level++)
		for (int k = 0; k < 4; k++) {
			const idx_t a = 4 * level + k, b = 4 * level + (k + 1) % 4;
			memcpy(face + 6 * (4 * level + k), (idx_t[6]){a, b, b + 4, a, b + 4, a + 4}, 6 * sizeof *face);
		}
	memcpy(face + 72, (idx_t[6]){12, 13, 14, 12, 14, 15}, 6 * sizeof *face);
	segmented_dense(&s, tower, 16, face, 26);
	segmented_run(&s);
	segmented_assert_sound(&s);
	assert_int_equal(s.regions.count, 13);
	for (size_t i = 0; i < s.regions.count; i++)
		assert_int_equal(s.regions.patch[i].kind, PATCH_PLANE);
	segmented_free(&s);
}

/* Two runs give the same labels. */
static void test_repeatable(void **state)
{
	(void)state;
	struct segmented a, b;
	const struct part_options options = {.target = 1500, .jitter = 1e-4};
	segmented_part(&a, "shaft", &options);
	segmented_part(&b, "shaft", &options);
	segmented_run(&a);
	segmented_run(&b);
	assert_int_equal(a.regions.count, b.regions.count);
	assert_memory_equal(a.regions.label, b.regions.label, a.facets.triangle_count * sizeof *a.regions.label);
	assert_memory_equal(a.regions.patch, b.regions.patch, a.regions.count * sizeof *a.regions.patch);
	segmented_free(&a);
	segmented_free(&b);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_acceptance), cmocka_unit_test(test_parts), cmocka_unit_test(test_noise),
		cmocka_unit_test(test_parameters), cmocka_unit_test(test_invariance), cmocka_unit_test(test_renumbering),
		cmocka_unit_test(test_free_form), cmocka_unit_test(test_saddle), cmocka_unit_test(test_few_triangles), cmocka_unit_test(test_repeatable),
	};
	return cmocka_run_group_tests_name("segment", tests, NULL, NULL);
}
