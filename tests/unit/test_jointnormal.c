/* Sums over a refined mesh, carried to the control points, against every sample added to the system by itself. */
#include "tests/unit/cage_samples.h"

#include "stages/fitpatch/joint_normal.h"

static unsigned seed;
static double random_unit(void) /* [0, 1) */
{
	seed = seed * 1664525u + 1013904223u;
	return (double)(seed >> 8) / (1 << 24);
}

static void random_term(double target[3], double metric[6], double *weight)
{
	double a[3], b[3];
	for (int k = 0; k < 3; k++)
		target[k] = 2 * random_unit() - 1, a[k] = random_unit(), b[k] = random_unit();
	for (int r = 0, e = 0; r < 3; r++)
		for (int c = r; c < 3; c++, e++)
			metric[e] = a[r] * a[c] + b[r] * b[c] + (r == c ? 0.01 : 0);
	*weight = 0.5 + random_unit();
}

/* Both ways for one cage; every fixed_each-th of its vertices is fixed. */
static void compare(const struct cage *cage, size_t fixed_each, int repeat)
{
	seed = (unsigned)(cage->vertex_count + fixed_each);
	struct terms terms = {0};
	struct level base = level_make(cage);
	subdivide_operator(&terms.rows, &terms.level, &base, cage->scheme, 2, true);
	level_free(&base);
	const struct level *level = &terms.level;
	terms.triangle = mem_array(6 * level->face_count, sizeof *terms.triangle);
	for (size_t f = 0; f < level->face_count; f++)
		for (size_t i = level->face_start[f] + 1; i + 1 < level->face_start[f + 1]; i++) {
			idx_t *t = &terms.triangle[3 * terms.triangle_count++];
			t[0] = level->face_corner[level->face_start[f]], t[1] = level->face_corner[i], t[2] = level->face_corner[i + 1];
		}
	const size_t n = cage->vertex_count;
	unsigned char *fixed = mem_array(n, 1);
	for (size_t v = 0; v < n; v++)
		fixed[v] = v % fixed_each == 0;
	struct normal_sums sums;
	normal_begin(&sums, &terms, fixed);
	/* Euler: a closed surface of genus 0 has 3 (vertices - 2) edges in triangles. */
	assert_int_equal(sums.edge_count, 3 * (level->vertex_count - 2));
	for (int round = 0; round < repeat; round++) { /* a second round must not remember the first */
		struct lsq *direct = lsq_new(n, cage->xyz, fixed), *carried = lsq_new(n, cage->xyz, fixed);
		normal_clear(&sums);
		double target[3], metric[6], weight;
		for (size_t s = 0; s < level->vertex_count; s += 3) {
			random_term(target, metric, &weight);
			normal_add_vertex(&sums, s, target, metric, weight);
			const size_t low = terms.rows.row_start[s];
			lsq_add(direct, &terms.rows.column[low], &terms.rows.weight[low], terms.rows.row_start[s + 1] - low, target, metric, weight);
		}
		for (int i = 0; i < 300; i++) {
			random_term(target, metric, &weight);
			const size_t t = (size_t)(random_unit() * (double)terms.triangle_count);
			double at[3] = {random_unit(), random_unit(), 0}; /* some lie on sides and corners */
			if (i % 5 == 0)
				at[i % 2] = 0;
			if (at[0] + at[1] > 1)
				at[0] = 1 - at[0], at[1] = 1 - at[1];
			at[2] = i % 7 == 0 ? 0 : 1 - at[0] - at[1];
			normal_add_point(&sums, t, at, target, metric, weight);
			idx_t column[200]; /* lsq_add takes the same column more than once */
			double value[200];
			size_t count = 0;
			for (size_t k = 0; k < 3; k++) {
				const size_t row = (size_t)terms.triangle[3 * t + k];
				for (size_t e = terms.rows.row_start[row]; e < terms.rows.row_start[row + 1]; e++)
					column[count] = terms.rows.column[e], value[count++] = at[k] * terms.rows.weight[e];
			}
			lsq_add(direct, column, value, count, target, metric, weight);
		}
		normal_carry(&sums, carried);
		assert_near(lsq_scale(carried), lsq_scale(direct), 1e-12 * lsq_scale(direct));
		double *one = mem_array(3 * n, sizeof *one), *two = mem_array(3 * n, sizeof *two);
		assert_true(lsq_solve(direct, one));
		assert_true(lsq_solve(carried, two));
		for (size_t i = 0; i < 3 * n; i++)
			assert_near(two[i], one[i], 1e-9);
		free(one), free(two);
		lsq_free(direct), lsq_free(carried);
	}
	normal_end(&sums);
	free(fixed), free(terms.triangle);
	sparse_free(&terms.rows);
	level_free(&terms.level);
}

static void quads_and_triangles(void **state)
{
	(void)state;
	struct cage cage = cage_make(house_xyz, 9, house_faces, SCHEME_QUADTRI);
	compare(&cage, 100, 2);
	compare(&cage, 2, 2);
	cage_drop(&cage);
	cage = cage_make(octahedron_xyz, 6, octahedron_faces, SCHEME_LOOP);
	compare(&cage, 3, 1);
	cage_drop(&cage);
}

static void creases(void **state)
{
	(void)state;
	double xyz[36];
	prism_points(xyz, 1);
	struct cage cage = cage_make(xyz, 12, prism_faces, SCHEME_QUADTRI);
	cage_sharpen(&cage, prism_rims);
	compare(&cage, 5, 2);
	cage_drop(&cage);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(quads_and_triangles),
		cmocka_unit_test(creases),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
