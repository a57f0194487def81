/* Integer angles, lengths and planes under the forward coder. */
#include "tests/unit/helpers.h"

#include "formats/ffx_angle.h"
#include "tests/fixtures/samplecages.h"

/* Against atan2 in doubles: within a unit and a half (1/4096 turn), whatever the lengths. */
static void test_angles(void **state)
{
	(void)state;
	sample_seed(1);
	for (int i = 0; i < 20000; i++) {
		const uint32_t size = 2u << sample_random(16);
		int64_t a[3], b[3];
		double cross = 0, dot = 0;
		for (int k = 0; k < 3; k++) {
			a[k] = (int64_t)sample_random(2 * size) - size;
			b[k] = (int64_t)sample_random(2 * size) - size;
		}
		for (int k = 0; k < 3; k++) {
			const double c = (double)(a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
			cross += c * c;
			dot += (double)(a[k] * b[k]);
		}
		if (vector_is_zero(a) || vector_is_zero(b))
			continue;
		/* Shrinking to 15 bits turns a vector by 1e-4 at most, a third of a unit. */
		assert_near(angle_between(a, b), atan2(sqrt(cross), dot) / 6.283185307179586 * ANGLE_TURN, 1.5);
	}
	assert_int_equal(angle_between((int64_t[]){5, 0, 0}, (int64_t[]){0, 0, 3}), 1024);
	assert_int_equal(angle_between((int64_t[]){5, 5, 0}, (int64_t[]){-1, -1, 0}), 2048);
	assert_int_equal(angle_between((int64_t[]){0, 0, 0}, (int64_t[]){1, 0, 0}), 0);
}

/* Two faces of a box meet at a right angle: convex from outside, concave when both normals point in. */
static void test_bends(void **state)
{
	(void)state;
	/* The top's edge at y = 0 runs along x with the top to its left; beyond it comes the side that looks along -y. */
	const int64_t top[3] = {0, 0, 100}, side[3] = {0, -100, 0}, edge[3] = {7, 0, 0};
	assert_int_equal(angle_bend(top, side, edge), 1024);
	assert_int_equal(angle_bend(top, (int64_t[]){0, 100, 0}, edge), -1024);
	assert_int_equal(angle_bend(top, top, edge), 0);
	assert_int_equal(angle_bend(top, (int64_t[]){0, 0, 0}, edge), 0);
}

/* The largest whole number whose square fits, at squares and beside them, up to the largest. */
static void test_roots(void **state)
{
	(void)state;
	for (uint64_t r = 0; r < 70000; r++) {
		assert_int_equal(root_of(r * r), r);
		assert_int_equal(root_of(r * r + 2 * r), r);
	}
	for (int bits = 17; bits < 32; bits++) {
		const uint64_t r = ((uint64_t)1 << bits) + 12345;
		assert_int_equal(root_of(r * r), r);
		assert_int_equal(root_of(r * r - 1), r - 1);
	}
	assert_int_equal(root_of(UINT64_MAX), UINT32_MAX);
	assert_int_equal(vector_length((int64_t[]){3, -4, 12}), 13);
}

/* Directions keep, parts end below 2^15. */
static void test_shrinking(void **state)
{
	(void)state;
	int64_t v[3] = {-((int64_t)1 << 40), (int64_t)1 << 39, 5};
	vector_shrink(v);
	assert_int_equal(v[0], -16384);
	assert_int_equal(v[1], 8192);
	assert_int_equal(v[2], 0);
	int64_t w[3] = {32767, -32767, 1};
	vector_shrink(w);
	assert_int_equal(w[0], 32767);
	assert_int_equal(w[1], -32767);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_angles),
		cmocka_unit_test(test_bends),
		cmocka_unit_test(test_roots),
		cmocka_unit_test(test_shrinking),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
