/* Virtual borders: closed patches and patches with handles are cut until each part has genus 0 and a border (section 5.0). */
#include "tests/unit/known_shapes.h"

#include <string.h>

#include "formats/dense.h"
#include "stages/curv/curvature.h"
#include "stages/geometry/wedge.h"
#include "stages/rectify/rectification.h"

static const struct rectification_options plain = {0, 5e-4, false, false, false, 25 / DEGREES, 2};

/* The whole mesh as one patch. */
static struct dense one_patch(const struct mesh *mesh, struct dense_patch patch)
{
	struct dense dense;
	struct fault fault = {0};
	/* nothing is sharp: what is under test is a smooth surface */
	const struct curvature_options options = {{179 / DEGREES, true}, 0};
	assert_true(curvature_compute(&dense, NULL, mesh, NULL, 0, &options, &fault));
	dense.label = mem_array(dense.triangle_count, sizeof *dense.label);
	dense.patch = mem_copy(&patch, 1, sizeof patch);
	dense.patch_count = 1;
	return dense;
}

/* Run, and check what must hold of every result. Returns the number of parts. */
static size_t cut(struct dense *dense, struct rectification_counts *counts)
{
	struct fault fault = {0};
	struct half half;
	assert_true(rectification(dense, counts, &plain, "shape", &fault));
	assert_int_equal(counts->cut.unsolved, 0);
	assert_true(half_build_triangles(&half, dense->triangle, dense->triangle_count, dense->vertex_count, &fault));
	struct patch_topology *t = mem_array(dense->patch_count, sizeof *t);
	patch_topologies(t, dense->patch_count, dense->label, &half);
	for (size_t l = 0; l < dense->patch_count; l++) {
		assert_int_equal(t[l].components, 1);
		assert_int_equal(t[l].genus, 0);
		assert_true(t[l].border_loops >= 1);
		assert_int_equal(dense->patch[l].parent, 0);
		assert_int_equal(dense->patch[l].kind, dense->patch[0].kind);
		assert_true(dense->patch[l].area > 0);
	}
	free(t);
	half_free(&half);
	return dense->patch_count;
}

static double total_area(const struct dense *dense)
{
	double area = 0;
	for (size_t l = 0; l < dense->patch_count; l++)
		area += dense->patch[l].area;
	return area;
}

/* Six equal sides; the cuts of a ball lie along the coordinate planes' diagonals. A second run finds nothing to do. */
static void ball_becomes_a_cube(void **state)
{
	(void)state;
	struct mesh ball = shape_icosphere(2, 4);
	struct dense dense = one_patch(&ball, (struct dense_patch){.kind = PATCH_SPHERE, .radius = 2, .sign = 1});
	struct rectification_counts counts;
	assert_int_equal(cut(&dense, &counts), 6);
	assert_int_equal(counts.cut.closed, 1);
	for (size_t l = 0; l < 6; l++) {
		assert_near(dense.patch[l].area, total_area(&dense) / 6, 0.05 * total_area(&dense) / 6);
		assert_near(dense.patch[l].radius, 2, 1e-12);
		assert_near(dense.patch[l].residual, 0, 1e-12);
	}
	idx_t *once = mem_copy(dense.label, dense.triangle_count, sizeof *once);
	assert_int_equal(cut(&dense, &counts), 6);
	assert_int_equal(counts.cut.parts, 0);
	assert_memory_equal(once, dense.label, dense.triangle_count * sizeof *once);
	free(once);
	dense_free(&dense);
	shape_free(&ball);
}

/* A ball with a small hole has a border, but no polygon in it spans the ball: cut like a closed one, the hole in one side. */
static void ball_with_a_hole(void **state)
{
	(void)state;
	struct mesh ball = shape_icosphere(2, 4);
	ball.face_count--;
	struct dense dense = one_patch(&ball, (struct dense_patch){.kind = PATCH_SPHERE, .radius = 2, .sign = 1});
	struct rectification_counts counts;
	assert_int_equal(cut(&dense, &counts), 6);
	assert_int_equal(counts.cut.balls, 1);
	assert_int_equal(counts.cut.closed, 0);
	assert_int_equal(cut(&dense, &counts), 6);
	assert_int_equal(counts.cut.balls, 0);
	/* half a ball is left alone: the triangles whose middle is above the plane z = 0 */
	dense_free(&dense);
	size_t kept = 0;
	for (size_t f = 0; f < ball.face_count; f++) {
		double z = 0;
		for (int k = 0; k < 3; k++)
			z += ball.xyz[3 * ball.corner[3 * f + k] + 2];
		if (z > 0) {
			for (int k = 0; k < 3; k++)
				ball.corner[3 * kept + k] = ball.corner[3 * f + k];
			kept++;
		}
	}
	ball.face_count = kept;
	dense = one_patch(&ball, (struct dense_patch){.kind = PATCH_SPHERE, .radius = 2, .sign = 1});
	assert_int_equal(cut(&dense, &counts), 1);
	dense_free(&dense);
	shape_free(&ball);
}

/* 20 and even 4 triangles can be cut too: every part of a few triangles. */
static void few_triangles(void **state)
{
	(void)state;
	struct mesh ball = shape_icosphere(1, 0);
	struct dense dense = one_patch(&ball, (struct dense_patch){.kind = PATCH_SPHERE, .radius = 1, .sign = 1});
	struct rectification_counts counts;
	const size_t parts = cut(&dense, &counts);
	assert_true(parts >= 2 && parts <= 6);
	dense_free(&dense);
	shape_free(&ball);
	struct mesh m = {0};
	shape_vertex(&m, 1, 1, 1);
	shape_vertex(&m, 1, -1, -1);
	shape_vertex(&m, -1, 1, -1);
	shape_vertex(&m, -1, -1, 1);
	shape_triangle(&m, 0, 1, 2);
	shape_triangle(&m, 0, 3, 1);
	shape_triangle(&m, 0, 2, 3);
	shape_triangle(&m, 1, 3, 2);
	dense = one_patch(&m, (struct dense_patch){.kind = PATCH_FREE});
	assert_true(cut(&dense, &counts) >= 2);
	dense_free(&dense);
	shape_free(&m);
}

/* A ring of radii 3 and 1: k sectors with 2.3 * 4 / 8 / k^4 <= 0.001 give 6, each a band with two borders that are circles of
 * the tube, because the mesh has such circles wherever a sixth ends. */
static void torus_becomes_sectors(void **state)
{
	(void)state;
	struct mesh torus = shape_torus(3, 1, 48, 24);
	struct dense dense = one_patch(&torus, (struct dense_patch){.kind = PATCH_TORUS, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1, .sign = 1});
	struct rectification_counts counts;
	assert_int_equal(cut(&dense, &counts), 6);
	assert_int_equal(counts.cut.handles, 1);
	for (size_t l = 0; l < 6; l++)
		assert_near(dense.patch[l].area, total_area(&dense) / 6, 1e-9);
	dense_free(&dense);
	shape_free(&torus);

	/* a dozen by six: fewer sectors, still bands */
	torus = shape_torus(3, 1, 12, 6);
	dense = one_patch(&torus, (struct dense_patch){.kind = PATCH_TORUS, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1, .sign = 1});
	const size_t parts = cut(&dense, &counts);
	assert_true(parts >= 2 && parts <= 6);
	dense_free(&dense);
	shape_free(&torus);
}

/* A torus that lacks a triangle has one border and still a handle. */
static void torus_with_a_hole(void **state)
{
	(void)state;
	for (int kind = PATCH_TORUS; kind <= PATCH_FREE; kind++) {
		struct mesh torus = shape_torus(3, 1, 36, 18);
		torus.face_count--;
		struct dense dense =
			one_patch(&torus, (struct dense_patch){.kind = (enum patch_kind)kind, .axis = {0, 0, 1}, .radius = 3, .radius2 = 1, .sign = 1});
		struct rectification_counts counts;
		const size_t parts = cut(&dense, &counts);
		print_message("# torus with a hole, kind %d: %zu parts\n", kind, parts);
		assert_int_equal(counts.cut.handles, 1);
		assert_true(parts >= 2 && parts <= 8);
		dense_free(&dense);
		shape_free(&torus);
	}
}

/* A plate of w x h x d unit cubes less those at odd (x, y): (w - 1) / 2 * (h - 1) / 2 holes through it. */
static struct mesh perforated(int w, int h, int d)
{
	struct mesh m = {0};
	for (int z = 0; z <= d; z++)
		for (int y = 0; y <= h; y++)
			for (int x = 0; x <= w; x++)
				shape_vertex(&m, x, y, z);
#define FULL(x, y, z) ((x) >= 0 && (x) < w && (y) >= 0 && (y) < h && (z) >= 0 && (z) < d && !((x) % 2 && (y) % 2))
#define AT(x, y, z) (((z) * (h + 1) + (y)) * (w + 1) + (x))
	for (int z = 0; z < d; z++)
		for (int y = 0; y < h; y++)
			for (int x = 0; x < w; x++) {
				if (!FULL(x, y, z))
					continue;
				if (!FULL(x - 1, y, z))
					shape_quad(&m, AT(x, y, z), AT(x, y, z + 1), AT(x, y + 1, z + 1), AT(x, y + 1, z));
				if (!FULL(x + 1, y, z))
					shape_quad(&m, AT(x + 1, y, z), AT(x + 1, y + 1, z), AT(x + 1, y + 1, z + 1), AT(x + 1, y, z + 1));
				if (!FULL(x, y - 1, z))
					shape_quad(&m, AT(x, y, z), AT(x + 1, y, z), AT(x + 1, y, z + 1), AT(x, y, z + 1));
				if (!FULL(x, y + 1, z))
					shape_quad(&m, AT(x, y + 1, z), AT(x, y + 1, z + 1), AT(x + 1, y + 1, z + 1), AT(x + 1, y + 1, z));
				if (!FULL(x, y, z - 1))
					shape_quad(&m, AT(x, y, z), AT(x, y + 1, z), AT(x + 1, y + 1, z), AT(x + 1, y, z));
				if (!FULL(x, y, z + 1))
					shape_quad(&m, AT(x, y, z + 1), AT(x + 1, y, z + 1), AT(x + 1, y + 1, z + 1), AT(x, y + 1, z + 1));
			}
#undef FULL
#undef AT
	/* drop the vertices that no face uses */
	idx_t *name = mem_array(m.vertex_count, sizeof *name);
	size_t kept = 0;
	for (size_t v = 0; v < m.vertex_count; v++)
		name[v] = NO_INDEX;
	for (size_t h2 = 0; h2 < 3 * m.face_count; h2++)
		name[m.corner[h2]] = 0;
	for (size_t v = 0; v < m.vertex_count; v++)
		if (name[v] == 0) {
			copy3(m.xyz + 3 * kept, m.xyz + 3 * v);
			name[v] = (idx_t)kept++;
		}
	for (size_t h2 = 0; h2 < 3 * m.face_count; h2++)
		m.corner[h2] = name[m.corner[h2]];
	m.vertex_count = kept;
	free(name);
	return m;
}

/* Free surfaces with one, two and nine handles. */
static void handles(void **state)
{
	(void)state;
	static const int size[3][2] = {{3, 3}, {5, 3}, {7, 7}};
	static const size_t most[3] = {4, 8, 40};
	for (int i = 0; i < 3; i++) {
		struct mesh m = perforated(size[i][0], size[i][1], 1);
		struct dense dense = one_patch(&m, (struct dense_patch){.kind = PATCH_FREE});
		struct rectification_counts counts;
		const size_t parts = cut(&dense, &counts);
		print_message("# plate %d x %d: %zu parts in %d rounds\n", size[i][0], size[i][1], parts, counts.cut.rounds);
		assert_true(parts >= 2 && parts <= most[i]);
		dense_free(&dense);
		shape_free(&m);
	}
}

/* A dumbbell does not look away from its middle: level sets, and two discs or a few bands are enough. */
static void closed_and_not_star_shaped(void **state)
{
	(void)state;
	struct mesh m = shape_icosphere(1, 3);
	/* bend the ball to a horseshoe: x becomes an angle of up to 150 degrees */
	for (size_t v = 0; v < m.vertex_count; v++) {
		double *p = m.xyz + 3 * v;
		const double angle = p[0] * 150 / DEGREES, r = 2 + 0.6 * p[1];
		p[0] = r * sin(angle), p[1] = r * cos(angle), p[2] *= 0.6;
	}
	for (size_t f = 0; f < m.face_count; f++) { /* (x, y) to (angle, radius) turns the orientation */
		const idx_t swap = m.corner[3 * f];
		m.corner[3 * f] = m.corner[3 * f + 1], m.corner[3 * f + 1] = swap;
	}
	struct dense dense = one_patch(&m, (struct dense_patch){.kind = PATCH_FREE});
	struct rectification_counts counts;
	assert_true(cut(&dense, &counts) <= 4);
	dense_free(&dense);
	shape_free(&m);
}

/* A tube needs no cut: two borders, no handle; and without cuts nothing is cut. */
static void nothing_to_cut(void **state)
{
	(void)state;
	struct mesh m = shape_cylinder(1, 2, 16, 2);
	m.face_count -= 32; /* the caps */
	m.vertex_count -= 2;
	struct dense dense = one_patch(&m, (struct dense_patch){.kind = PATCH_CYLINDER, .axis = {0, 0, 1}, .radius = 1, .sign = 1});
	struct rectification_counts counts;
	assert_int_equal(cut(&dense, &counts), 1);
	dense_free(&dense);
	shape_free(&m);

	struct mesh ball = shape_icosphere(1, 2);
	struct rectification_options options = plain;
	struct fault fault = {0};
	options.no_cut = true;
	dense = one_patch(&ball, (struct dense_patch){.kind = PATCH_SPHERE, .radius = 1, .sign = 1});
	assert_true(rectification(&dense, &counts, &options, "ball", &fault));
	assert_int_equal(dense.patch_count, 1);
	dense_free(&dense);
	shape_free(&ball);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(ball_becomes_a_cube),
		cmocka_unit_test(ball_with_a_hole),
		cmocka_unit_test(few_triangles),
		cmocka_unit_test(torus_becomes_sectors),
		cmocka_unit_test(torus_with_a_hole),
		cmocka_unit_test(handles),
		cmocka_unit_test(closed_and_not_star_shaped),
		cmocka_unit_test(nothing_to_cut),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
