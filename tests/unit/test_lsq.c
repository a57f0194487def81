/* The block system against a dense solve by Gaussian elimination of the same terms written out. */
#include "tests/unit/cage_samples.h"

#include "stages/geometry/lsq.h"

static unsigned seed;
static double random_unit(void) /* [-1, 1) */
{
	seed = seed * 1664525u + 1013904223u;
	return (double)(seed >> 8) / (1 << 23) - 1;
}

/* A x = b by elimination with row pivots; a is n x n. */
static void eliminate(double *a, double *b, size_t n)
{
	for (size_t k = 0; k < n; k++) {
		size_t p = k;
		for (size_t i = k + 1; i < n; i++)
			if (fabs(a[i * n + k]) > fabs(a[p * n + k]))
				p = i;
		for (size_t j = 0; j < n; j++) {
			const double t = a[k * n + j];
			a[k * n + j] = a[p * n + j];
			a[p * n + j] = t;
		}
		const double t = b[k];
		b[k] = b[p];
		b[p] = t;
		for (size_t i = k + 1; i < n; i++) {
			const double f = a[i * n + k] / a[k * n + k];
			for (size_t j = k; f != 0 && j < n; j++)
				a[i * n + j] -= f * a[k * n + j];
			b[i] -= f * b[k];
		}
	}
	for (size_t i = n; i-- > 0;) {
		for (size_t j = i + 1; j < n; j++)
			b[i] -= a[i * n + j] * b[j];
		b[i] /= a[i * n + i];
	}
}

enum { ROW = 5 };

/* Random banded terms for n points, every fourth one fixed: solve both ways and compare. */
static void compare(size_t n, size_t terms, int repeat)
{
	seed = (unsigned)n;
	double *xyz = mem_array(3 * n, sizeof *xyz), *out = mem_array(3 * n, sizeof *out);
	unsigned char *fixed = mem_array(n, 1);
	for (size_t i = 0; i < n; i++) {
		fixed[i] = i % 4 == 3;
		for (size_t c = 0; c < 3; c++)
			xyz[3 * i + c] = random_unit();
	}
	struct lsq *lsq = lsq_new(n, xyz, fixed);
	double *a = NULL, *b = NULL;
	const size_t m = 3 * n;
	for (int round = 0; round < repeat; round++) { /* the second round uses the kept pattern */
		lsq_clear(lsq);
		free(a);
		free(b);
		a = mem_array(m * m, sizeof *a);
		b = mem_array(m, sizeof *b);
		for (size_t t = 0; t < terms; t++) {
			idx_t index[ROW];
			double c[ROW], target[3], g[3], h[3], metric[6];
			const size_t first = (size_t)((random_unit() + 1) / 2 * (double)(n - 8));
			for (size_t k = 0; k < ROW; k++) {
				index[k] = (idx_t)(first + (size_t)((random_unit() + 1) * 4)); /* may come twice */
				c[k] = random_unit();
			}
			for (int k = 0; k < 3; k++) {
				target[k] = random_unit();
				g[k] = random_unit();
				h[k] = random_unit();
			}
			int e = 0;
			for (int r = 0; r < 3; r++)
				for (int s = r; s < 3; s++)
					metric[e++] = g[r] * g[s] + 0.1 * h[r] * h[s] + (r == s ? 0.01 : 0);
			const double weight = 0.1 + fabs(random_unit());
			lsq_add(lsq, index, c, ROW, target, metric, weight);
			const double full[3][3] = {{metric[0], metric[1], metric[2]}, {metric[1], metric[3], metric[4]}, {metric[2], metric[4], metric[5]}};
			for (int k = 0; k < ROW; k++)
				for (int r = 0; r < 3; r++)
					for (int s = 0; s < 3; s++) {
						b[3 * index[k] + r] += weight * c[k] * full[r][s] * target[s];
						for (int l = 0; l < ROW; l++)
							a[(size_t)(3 * index[k] + r) * m + (size_t)(3 * index[l] + s)] += weight * c[k] * c[l] * full[r][s];
					}
		}
		for (size_t i = 0; i < n; i++) {
			const double target[3] = {1, 2, 3};
			lsq_add_point(lsq, (idx_t)i, target, 0.05);
			for (size_t k = 0; k < 3; k++) {
				a[(3 * i + k) * m + 3 * i + k] += 0.05;
				b[3 * i + k] += 0.05 * target[k];
			}
		}
		double trace = 0;
		size_t free_points = 0;
		for (size_t i = 0; i < n; i++)
			for (size_t k = 0; !fixed[i] && k < 3; k++) {
				trace += a[(3 * i + k) * m + 3 * i + k];
				free_points += k == 0;
			}
		assert_near(lsq_scale(lsq), trace / (3 * (double)free_points), 1e-12 * trace);
		for (size_t i = 0; i < n; i++)
			for (size_t k = 0; fixed[i] && k < 3; k++) { /* equation of a fixed coordinate: x = xyz */
				for (size_t j = 0; j < m; j++)
					a[(3 * i + k) * m + j] = j == 3 * i + k;
				b[3 * i + k] = xyz[3 * i + k];
			}
		eliminate(a, b, m);
		assert_true(lsq_solve(lsq, out));
		for (size_t i = 0; i < m; i++)
			assert_near(out[i], b[i], 1e-10);
		for (size_t i = 0; i < n; i++)
			if (fixed[i])
				assert_memory_equal(out + 3 * i, xyz + 3 * i, 3 * sizeof *out);
	}
	free(a);
	free(b);
	lsq_free(lsq);
	free(xyz);
	free(out);
	free(fixed);
}

/* Few free points, many free points densely coupled: both by the dense factor. */
static void small_system_equals_elimination(void **state)
{
	(void)state;
	compare(12, 60, 2);
	compare(96, 500, 2);
}

/* Sparsely coupled: CHOLMOD; the second round uses the kept ordering. */
static void sparse_system_equals_elimination(void **state)
{
	(void)state;
	compare(250, 900, 2);
}

/* Beyond the table of pairs. At the minimum the gradient of the sum vanishes in every free coordinate: checked term by term. */
static void large_system_is_a_minimum(void **state)
{
	(void)state;
	enum { POINTS = 1500, TERMS = 6000 };
	double *xyz = mem_array(3 * POINTS, sizeof *xyz), *gradient = mem_array(3 * POINTS, sizeof *gradient);
	unsigned char *fixed = mem_array(POINTS, 1);
	for (size_t i = 0; i < 3 * POINTS; i++)
		xyz[i] = random_unit();
	for (size_t i = 0; i < POINTS; i += 5)
		fixed[i] = 1;
	struct lsq *lsq = lsq_new(POINTS, xyz, fixed);
	for (int pass = 0; pass < 2; pass++) {
		seed = 5; /* the same terms in both passes */
		for (int t = 0; t < TERMS; t++) {
			idx_t index[ROW];
			double c[ROW], target[3], weight = 0.5 + fabs(random_unit());
			const idx_t first = (idx_t)((random_unit() + 1) / 2 * (POINTS - 40));
			for (int k = 0; k < ROW; k++) {
				index[k] = first + (idx_t)((random_unit() + 1) * 20);
				c[k] = random_unit();
			}
			for (int k = 0; k < 3; k++)
				target[k] = random_unit();
			const double metric[6] = {1, 0.2, 0.1, 0.5, -0.1, 0.3};
			if (pass == 0) {
				lsq_add(lsq, index, c, ROW, target, metric, weight);
				continue;
			}
			double r[3] = {-target[0], -target[1], -target[2]};
			for (int k = 0; k < ROW; k++)
				for (int i = 0; i < 3; i++)
					r[i] += c[k] * xyz[3 * index[k] + i];
			const double mr[3] = {metric[0] * r[0] + metric[1] * r[1] + metric[2] * r[2], metric[1] * r[0] + metric[3] * r[1] + metric[4] * r[2],
			                      metric[2] * r[0] + metric[4] * r[1] + metric[5] * r[2]};
			for (int k = 0; k < ROW; k++)
				for (int i = 0; i < 3; i++)
					gradient[3 * index[k] + i] += weight * c[k] * mr[i];
		}
		const double origin[3] = {0, 0, 0};
		for (size_t i = 0; i < POINTS; i++) {
			if (pass == 0)
				lsq_add_point(lsq, (idx_t)i, origin, 0.01);
			for (size_t k = 0; k < 3; k++)
				gradient[3 * i + k] += 0.01 * xyz[3 * i + k];
		}
		if (pass == 0) {
			assert_true(lsq_solve(lsq, xyz)); /* in place */
			memset(gradient, 0, 3 * POINTS * sizeof *gradient);
		}
	}
	for (size_t i = 0; i < 3 * POINTS; i++)
		if (!fixed[i / 3])
			assert_near(gradient[i], 0, 1e-12);
	lsq_free(lsq);
	free(xyz);
	free(gradient);
	free(fixed);
}

/* A point that no term holds makes the matrix singular: said so, and the output untouched. Both factorisations. */
static void singular_is_told(void **state)
{
	(void)state;
	const size_t sizes[] = {2, 200};
	for (int s = 0; s < 2; s++) {
		const size_t n = sizes[s];
		double *xyz = mem_array(3 * n, sizeof *xyz), *out = mem_array(3 * n, sizeof *out);
		struct lsq *lsq = lsq_new(n, xyz, NULL);
		const double target[3] = {1, 1, 1}, flat[6] = {0, 0, 0, 0, 0, 1};
		for (size_t i = 0; i + 1 < n; i++)
			lsq_add_point(lsq, (idx_t)i, target, 1);
		out[0] = 7;
		assert_false(lsq_solve(lsq, out));
		assert_true(out[0] == 7);
		/* held across z alone: still singular */
		lsq_add(lsq, &(idx_t){(idx_t)n - 1}, &(double){1}, 1, target, flat, 1);
		assert_false(lsq_solve(lsq, out));
		lsq_add_point(lsq, (idx_t)n - 1, target, 1e-3);
		assert_true(lsq_solve(lsq, out));
		assert_near(out[3 * n - 1], 1, 1e-12);
		/* after clearing there is nothing at all */
		lsq_clear(lsq);
		assert_false(lsq_solve(lsq, out));
		lsq_free(lsq);
		free(xyz);
		free(out);
	}
}

/* Everything fixed: nothing to solve, and positions come out as they are at that time. */
static void all_fixed(void **state)
{
	(void)state;
	double xyz[6] = {1, 2, 3, 4, 5, 6}, out[6] = {0};
	const unsigned char fixed[2] = {1, 1};
	struct lsq *lsq = lsq_new(2, xyz, fixed);
	xyz[4] = 9;
	assert_true(lsq_solve(lsq, out));
	assert_memory_equal(out, xyz, sizeof xyz);
	lsq_free(lsq);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(small_system_equals_elimination),
	        cmocka_unit_test(sparse_system_equals_elimination),
	        cmocka_unit_test(large_system_is_a_minimum),
	        cmocka_unit_test(singular_is_told),
	        cmocka_unit_test(all_fixed),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
