/* Nearest points on the chains between two patches, against a look at every segment. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "stages/fitpatch/joint_terms.h"
#include "stages/geometry/vector.h"

static void assert_near(double got, double want, double tolerance)
{
	if (!(fabs(got - want) <= tolerance))
		fail_msg("%.17g is not within %g of %.17g", got, tolerance, want);
}

static unsigned seed = 7;
static double random_unit(void) /* [0, 1) */
{
	seed = seed * 1664525u + 1013904223u;
	return (double)(seed >> 8) / (1 << 24);
}

static double segment_distance(const double *p, const double *a, const double *b)
{
	double ab[3], ap[3];
	sub3(ab, b, a), sub3(ap, p, a);
	const double t = fmin(fmax(dot3(ap, ab) / dot3(ab, ab), 0), 1);
	add_scaled3(ap, -t, ab);
	return norm3(ap);
}

enum { CHAINS = 5 };

static void equals_look_at_all(void **state)
{
	(void)state;
	/* Curls of 2 to 301 vertices: one segment, less than a run, a full run, many; the last one is closed. Chains 1 and 3 part the
	 * same patches, named the other way round. */
	static const size_t count[CHAINS] = {2, 7, 9, 301, 100};
	static const idx_t left[CHAINS] = {0, 2, 3, 1, 4}, right[CHAINS] = {1, 1, -1, 2, 3};
	struct border_chain chain[CHAINS] = {0};
	double xyz[3 * 419];
	idx_t vertex[419];
	size_t used = 0;
	for (size_t c = 0; c < CHAINS; c++) {
		chain[c].left = left[c], chain[c].right = right[c], chain[c].first = used, chain[c].count = count[c], chain[c].closed = c == 4;
		for (size_t i = 0; i < count[c]; i++, used++) {
			const double t = (double)i / (double)count[c] * 2 * PI;
			xyz[3 * used] = (double)c + cos(t), xyz[3 * used + 1] = sin(t) + 0.05 * random_unit(), xyz[3 * used + 2] = c == 4 ? 0 : 0.3 * t;
			vertex[used] = (idx_t)used;
		}
	}
	const struct border_network border = {.chain = chain, .chain_count = CHAINS, .vertex = vertex};
	struct chain_index *index = chain_index_new(&border, xyz);
	for (int i = 0; i < 500; i++) {
		const double p[3] = {6 * random_unit() - 1, 4 * random_unit() - 2, 3 * random_unit() - 1};
		const size_t c = (size_t)i % CHAINS;
		double want = INFINITY, point[3], tangent[3], offset[3];
		for (size_t k = 0; k < CHAINS; k++) {
			if (fmin(left[k], right[k]) != fmin(left[c], right[c]) || fmax(left[k], right[k]) != fmax(left[c], right[c]))
				continue;
			for (size_t s = 0; s + !chain[k].closed < count[k]; s++)
				want = fmin(want, segment_distance(p, &xyz[3 * (chain[k].first + s)], &xyz[3 * (chain[k].first + (s + 1) % count[k])]));
		}
		assert_true(chain_nearest(point, tangent, index, right[c], left[c], p));
		sub3(offset, p, point);
		assert_near(norm3(offset), want, 1e-14);
		assert_near(norm3(tangent), 1, 1e-14);
	}
	double point[3], tangent[3];
	assert_false(chain_nearest(point, tangent, index, 0, 4, xyz)); /* no border between these */
	chain_index_free(index);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(equals_look_at_all)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
