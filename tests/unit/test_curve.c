/* Subdivision curves: rules, ends, and how well they draw circles and arcs. */
#include "tests/unit/cage_samples.h"

#include "stages/geometry/curve.h"
#include "stages/geometry/lsq.h"
#include "stages/geometry/vector.h"

/* One subdivision step written out: midpoints, (1, 6, 1) / 8, ends kept. Returns the new count. */
static size_t refine_polygon(double *out, const double *in, size_t count, bool closed)
{
	size_t n = 0;
	for (size_t i = 0; i < count; i++) {
		const bool end = !closed && (i == 0 || i + 1 == count);
		const double *p = in + 3 * i, *before = in + 3 * ((i + count - 1) % count), *after = in + 3 * ((i + 1) % count);
		for (int c = 0; c < 3; c++)
			out[3 * n + (size_t)c] = end ? p[c] : (before[c] + 6 * p[c] + after[c]) / 8;
		n++;
		if (closed || i + 1 < count) {
			for (int c = 0; c < 3; c++)
				out[3 * n + (size_t)c] = (p[c] + after[c]) / 2;
			n++;
		}
	}
	return n;
}

/* The refined polygon has the same curve: limits of its points are the curve at half steps. */
static void refinement_keeps_the_curve(void **state)
{
	(void)state;
	double points[21], a[500], b[500];
	for (int i = 0; i < 21; i++)
		points[i] = sin(7.0 * i + 0.3 * i * i);
	for (size_t count = 2; count <= 7; count++)
		for (int closed = 0; closed < 2; closed++) {
			if (closed && count < 3)
				continue;
			const size_t twice = refine_polygon(a, points, count, closed), four = refine_polygon(b, a, twice, closed);
			assert_int_equal(twice, closed ? 2 * count : 2 * count - 1);
			for (size_t i = 0; i < four; i++) {
				double limit[3], direct[3];
				curve_limit(limit, b, four, closed, i);
				curve_point(direct, points, count, closed, (double)i / 4);
				assert_near(distance3(limit, direct), 0, 4e-15);
			}
		}
}

/* Inside: (1, 4, 1) / 6. Ends: interpolated, without second derivative. */
static void limits_and_ends(void **state)
{
	(void)state;
	const double points[] = {0, 0, 0, 1, 2, 0, 3, 1, 1, 4, -1, 2, 6, 0, 0};
	double p[3];
	for (size_t i = 0; i < 5; i++) {
		curve_limit(p, points, 5, false, i);
		for (size_t c = 0; c < 3; c++)
			assert_near(p[c], i == 0 || i == 4 ? points[3 * i + c] : (points[3 * i - 3 + c] + 4 * points[3 * i + c] + points[3 * i + 3 + c]) / 6, 1e-15);
	}
	double q[3], r[3];
	const double h = 1e-3;
	curve_point(p, points, 5, false, 0);
	curve_point(q, points, 5, false, h);
	curve_point(r, points, 5, false, 2 * h);
	for (int c = 0; c < 3; c++)
		assert_near((p[c] - 2 * q[c] + r[c]) / (h * h), 0, 0.02); /* grows as h: third derivative times h */
	curve_point(q, points, 5, false, -3);
	assert_memory_equal(p, q, sizeof p); /* beyond the ends: the ends */
	curve_point(q, points, 5, false, 9);
	assert_near(distance3(q, points + 12), 0, 0);
	/* closed: periodic, also below zero */
	curve_point(p, points, 5, true, 1.25);
	curve_point(q, points, 5, true, 1.25 - 10);
	assert_near(distance3(p, q), 0, 1e-15);
}

static void rows(void **state)
{
	(void)state;
	for (size_t count = 1; count <= 6; count++)
		for (int closed = 0; closed < 2; closed++)
			for (int k = 0; k <= 50; k++) {
				size_t index[4];
				double weight[4], sum = 0;
				const size_t used = curve_row(index, weight, count, closed, (double)count * k / 50);
				assert_in_range(used, 1, 4);
				for (size_t i = 0; i < used; i++) {
					assert_true(index[i] < count);
					sum += weight[i];
					for (size_t j = 0; j < i; j++)
						assert_int_not_equal(index[i], index[j]);
				}
				assert_near(sum, 1, 1e-15);
			}
	/* two points: the straight segment */
	double p[3];
	const double segment[] = {1, 1, 1, 3, 5, 7};
	curve_point(p, segment, 2, false, 0.5);
	assert_near(distance3(p, (const double[]){2, 3, 4}), 0, 1e-15);
}

/* Closed circles with k points on a regular polygon: largest radial error over the mean radius, and the polygon's radius for a mean
 * radius of 1. A uniform cubic B-spline converges with the fourth power of the step. */
static void circles(void **state)
{
	(void)state;
	const struct {
		size_t k;
		double error, radius;
	} table[] = {{3, 6.8e-2, 0}, {4, 1.5e-2, 1.522}, {5, 5.0e-3, 0}, {6, 2.2e-3, 1.203}, {8, 6.1e-4, 1.109}, {10, 2.4e-4, 0}, {12, 1.1e-4, 1.047}, {16, 3.4e-5, 0}};
	for (size_t t = 0; t < sizeof table / sizeof *table; t++) {
		double points[48], least = INFINITY, most = 0, mean = 0;
		for (size_t i = 0; i < table[t].k; i++) {
			points[3 * i] = cos(2 * PI * (double)i / (double)table[t].k);
			points[3 * i + 1] = sin(2 * PI * (double)i / (double)table[t].k);
			points[3 * i + 2] = 0;
		}
		for (int s = 0; s < 1000; s++) {
			double p[3];
			curve_point(p, points, table[t].k, true, (double)table[t].k * s / 1000);
			least = fmin(least, norm3(p));
			most = fmax(most, norm3(p));
			mean += norm3(p) / 1000;
		}
		assert_near(fmax(most - mean, mean - least) / mean, table[t].error, 0.05 * table[t].error);
		if (table[t].radius > 0)
			assert_near(1 / mean, table[t].radius, 1e-3);
	}
}

/* Arcs between two corners: least squares for m interior points by parameter correction. The fit's largest radial error is about
 * that of the best one, which the table gives. */
static void arcs(void **state)
{
	(void)state;
	const struct {
		double degrees;
		size_t m;
		double error;
	} table[] = {{90, 1, 2.3e-2}, {90, 2, 4.1e-3}, {90, 3, 1.2e-3}, {90, 4, 5.0e-4}, {90, 6, 1.3e-4}, {180, 2, 2.6e-2}, {180, 4, 2.7e-3}, {180, 6, 6.5e-4}, {360, 4, 2.4e-2}, {360, 8, 1.6e-3}};
	for (size_t t = 0; t < sizeof table / sizeof *table; t++) {
		const size_t count = table[t].m + 2;
		double points[30], next[30];
		unsigned char fixed[10] = {0};
		fixed[0] = fixed[count - 1] = 1;
		for (size_t i = 0; i < count; i++) {
			const double angle = table[t].degrees * PI / 180 * (double)i / (double)(count - 1);
			points[3 * i] = cos(angle);
			points[3 * i + 1] = sin(angle);
			points[3 * i + 2] = 0;
		}
		struct lsq *lsq = lsq_new(count, points, fixed);
		enum { SAMPLES = 200 };
		for (int step = 0; step < 60; step++) {
			lsq_clear(lsq);
			for (int s = 0; s <= SAMPLES; s++) {
				/* distance along the radius only: n n^T with a little of the rest to hold the parameters */
				size_t index[4];
				double weight[4], p[3], n[3];
				const double u = (double)(count - 1) * s / SAMPLES;
				const size_t used = curve_row(index, weight, count, false, u);
				curve_point(p, points, count, false, u);
				copy3(n, p);
				normalise3(n);
				idx_t column[4];
				for (size_t k = 0; k < used; k++)
					column[k] = (idx_t)index[k];
				const double metric[6] = {n[0] * n[0], n[0] * n[1], 0, n[1] * n[1], 0, 1};
				lsq_add(lsq, column, weight, used, n, metric, 1);
			}
			for (size_t i = 0; i < count; i++)
				lsq_add_point(lsq, (idx_t)i, points + 3 * i, 1e-3 * lsq_scale(lsq));
			assert_true(lsq_solve(lsq, next));
			memcpy(points, next, sizeof points);
		}
		double worst = 0;
		for (int s = 0; s <= 1000; s++) {
			double p[3];
			curve_point(p, points, count, false, (double)(count - 1) * s / 1000);
			worst = fmax(worst, fabs(norm3(p) - 1));
		}
		if (!(worst < 1.6 * table[t].error && worst > 0.5 * table[t].error))
			print_error("%g degrees, %zu points: %g instead of about %g\n", table[t].degrees, table[t].m, worst, table[t].error);
		assert_true(worst < 1.6 * table[t].error && worst > 0.5 * table[t].error);
		lsq_free(lsq);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(refinement_keeps_the_curve),
	        cmocka_unit_test(limits_and_ends),
	        cmocka_unit_test(rows),
	        cmocka_unit_test(circles),
	        cmocka_unit_test(arcs),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
