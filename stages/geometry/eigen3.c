/* Symmetric 3x3 eigenproblem by cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5). */
#include "stages/geometry/eigen3.h"

#include <math.h>

#include "stages/geometry/vector.h"

enum { SWEEP_LIMIT = 32 };

/* Zero a[p][q] by a rotation in the plane (p, q); the columns of v follow. */
static void rotate(double a[3][3], double v[3][3], int p, int q)
{
	if (a[p][q] == 0)
		return;
	/* the smaller root of t^2 + 2 theta t - 1: a rotation by at most 45 degrees, which is what makes Jacobi converge */
	const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
	const double t = copysign(1, theta) / (fabs(theta) + sqrt(theta * theta + 1));
	const double c = 1 / sqrt(t * t + 1), s = t * c;
	const int r = 3 - p - q;
	const double shift = t * a[p][q], arp = a[r][p], arq = a[r][q];
	a[p][p] -= shift;
	a[q][q] += shift;
	a[p][q] = a[q][p] = 0;
	a[r][p] = a[p][r] = c * arp - s * arq;
	a[r][q] = a[q][r] = s * arp + c * arq;
	for (int k = 0; k < 3; k++) {
		const double vkp = v[k][p], vkq = v[k][q];
		v[k][p] = c * vkp - s * vkq;
		v[k][q] = s * vkp + c * vkq;
	}
}

void eigen3_symmetric(double value[3], double vector[3][3], const double matrix[6])
{
	double largest = 0;
	for (int i = 0; i < 6; i++)
		largest = fmax(largest, fabs(matrix[i]));
	/* A power of two near the largest entry: exact, and squares neither overflow nor vanish. */
	int exponent = 0;
	if (largest > 0 && isfinite(largest))
		(void)frexp(largest, &exponent);
	double m[6];
	for (int i = 0; i < 6; i++)
		m[i] = ldexp(matrix[i], -exponent);
	double a[3][3] = {{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}};
	double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	for (int sweep = 0; sweep < SWEEP_LIMIT && (a[0][1] != 0 || a[0][2] != 0 || a[1][2] != 0); sweep++) {
		rotate(a, v, 0, 1);
		rotate(a, v, 0, 2);
		rotate(a, v, 1, 2);
	}
	int order[3] = {0, 1, 2};
	for (int i = 1; i < 3; i++)
		for (int j = i; j > 0 && a[order[j]][order[j]] < a[order[j - 1]][order[j - 1]]; j--) {
			const int swap = order[j];
			order[j] = order[j - 1];
			order[j - 1] = swap;
		}
	for (int i = 0; i < 3; i++) {
		value[i] = ldexp(a[order[i]][order[i]], exponent);
		for (int k = 0; k < 3; k++)
			vector[i][k] = v[k][order[i]];
		normalise3(vector[i]);
	}
	double third[3];
	cross3(third, vector[0], vector[1]);
	if (dot3(third, vector[2]) < 0)
		scale3(vector[2], -1);
}
