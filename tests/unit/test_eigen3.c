/* Eigenvalues and vectors of symmetric 3x3 matrices: by definition, A v = lambda v, on matrices with known ones. */
#include "tests/unit/cage_samples.h"

#include "stages/geometry/eigen3.h"
#include "stages/geometry/vector.h"

static unsigned seed = 1;
static double random_unit(void) /* [-1, 1) */
{
	seed = seed * 1664525u + 1013904223u;
	return (double)(seed >> 8) / (1 << 23) - 1;
}

static void check(const double m[6], double scale)
{
	double value[3], vector[3][3];
	eigen3_symmetric(value, vector, m);
	assert_true(value[0] <= value[1] && value[1] <= value[2]);
	for (int i = 0; i < 3; i++) {
		const double *v = vector[i];
		const double av[3] = {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[1] * v[0] + m[3] * v[1] + m[4] * v[2], m[2] * v[0] + m[4] * v[1] + m[5] * v[2]};
		for (int k = 0; k < 3; k++)
			assert_near(av[k], value[i] * v[k], 2e-15 * scale);
		for (int j = 0; j < 3; j++)
			assert_near(dot3(v, vector[j]), i == j, 2e-15);
	}
	double third[3];
	cross3(third, vector[0], vector[1]);
	assert_near(dot3(third, vector[2]), 1, 2e-15); /* right-handed */
	assert_near(value[0] + value[1] + value[2], m[0] + m[3] + m[5], 4e-15 * scale);
}

static void random_matrices(void **state)
{
	(void)state;
	for (int k = 0; k < 2000; k++) {
		double m[6];
		for (int i = 0; i < 6; i++)
			m[i] = random_unit();
		check(m, 1);
	}
}

/* Turned diagonal matrices: the eigenvalues are known, also when two or three are equal or zero. */
static void known_eigenvalues(void **state)
{
	(void)state;
	const double sets[][3] = {{-2, 1, 5}, {0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {-1, -1, 3}, {1e-9, 1, 1e3}, {-1, 0, 1}, {1, 1 + 1e-12, 2}};
	for (size_t s = 0; s < sizeof sets / sizeof *sets; s++)
		for (int k = 0; k < 50; k++) {
			double q[3][3]; /* a random orthonormal frame */
			for (int i = 0; i < 2; i++)
				for (int c = 0; c < 3; c++)
					q[i][c] = random_unit();
			normalise3(q[0]);
			add_scaled3(q[1], -dot3(q[0], q[1]), q[0]);
			normalise3(q[1]);
			add_scaled3(q[1], -dot3(q[0], q[1]), q[0]);
			normalise3(q[1]);
			cross3(q[2], q[0], q[1]);
			double m[6];
			for (int r = 0, e = 0; r < 3; r++)
				for (int c = r; c < 3; c++, e++)
					m[e] = sets[s][0] * q[0][r] * q[0][c] + sets[s][1] * q[1][r] * q[1][c] + sets[s][2] * q[2][r] * q[2][c];
			double value[3], vector[3][3], scale = 0;
			for (int i = 0; i < 3; i++)
				scale = fmax(scale, fabs(sets[s][i]));
			check(m, scale);
			eigen3_symmetric(value, vector, m);
			for (int i = 0; i < 3; i++)
				assert_near(value[i], sets[s][i], 4e-15 * scale);
		}
}

static void degenerate_matrices(void **state)
{
	(void)state;
	check((const double[]){0, 0, 0, 0, 0, 0}, 1);
	check((const double[]){0, 1, 0, 0, 0, 0}, 1);
	check((const double[]){1, 1, 1, 1, 1, 1}, 1);
	check((const double[]){1, 1e-300, 0, 1, 1e-200, 1}, 1);
	check((const double[]){4e-310, 1e-310, 0, 2e-310, 0, 1e-310}, 1e-300); /* subnormal */
	check((const double[]){1e307, 2e307, -1e307, 3e307, 4e307, -5e307}, 1e308);
	/* diagonal: nothing to turn */
	double value[3], vector[3][3];
	eigen3_symmetric(value, vector, (const double[]){3, 0, 0, 1, 0, 2});
	assert_true(value[0] == 1 && value[1] == 2 && value[2] == 3);
	/* no numbers: comes back */
	eigen3_symmetric(value, vector, (const double[]){NAN, 0, 1, 0, INFINITY, 2});
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(random_matrices),
	        cmocka_unit_test(known_eigenvalues),
	        cmocka_unit_test(degenerate_matrices),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
