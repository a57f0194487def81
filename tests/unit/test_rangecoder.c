/* The range coder: what goes in comes out, in as few bytes as the probabilities say. */
#include "tests/unit/helpers.h"

#include "formats/range.h"
#include "tests/fixtures/samplecages.h"

static uint32_t random_probability(void)
{
	/* often extreme: carries and renormalisation at their limits */
	switch (sample_random(4)) {
	case 0:
		return 1 + sample_random(3);
	case 1:
		return RANGE_ONE - 1 - sample_random(3);
	default:
		return 1 + sample_random(RANGE_ONE - 1);
	}
}

static void test_bits_round_trip(void **state)
{
	(void)state;
	for (uint64_t seed = 1; seed <= 300; seed++) {
		sample_seed(seed);
		const size_t count = sample_random(2000);
		struct range encoder, decoder;
		range_encode(&encoder);
		double bits = 0;
		for (size_t i = 0; i < count; i++) {
			if (sample_chance(0.2)) {
				const uint32_t n = sample_chance(0.5) ? 1 + sample_random(300) : 1 + sample_random(1u << 31);
				range_uniform(&encoder, n, sample_random(n));
				bits += log2(n);
			} else {
				const uint32_t p = random_probability();
				const unsigned bit = sample_random(RANGE_ONE) < p;
				assert_int_equal(range_bit(&encoder, p, bit), bit);
				bits -= log2((double)(bit ? p : RANGE_ONE - p) / RANGE_ONE);
			}
		}
		range_finish(&encoder);
		/* 1 per mille for the division in range_uniform, and one byte for the end */
		if ((double)encoder.size > bits / 8 * 1.001 + 1)
			fail_msg("seed %d: %zu bytes for %.1f bits", (int)seed, encoder.size, bits);
		range_decode(&decoder, encoder.bytes, encoder.size);
		sample_seed(seed);
		assert_int_equal(sample_random(2000), count);
		for (size_t i = 0; i < count; i++) {
			if (sample_chance(0.2)) {
				const uint32_t n = sample_chance(0.5) ? 1 + sample_random(300) : 1 + sample_random(1u << 31);
				const uint32_t wanted = sample_random(n);
				assert_int_equal(range_uniform(&decoder, n, 0), wanted);
			} else {
				const uint32_t p = random_probability();
				const unsigned wanted = sample_random(RANGE_ONE) < p;
				assert_int_equal(range_bit(&decoder, p, 0), wanted);
			}
		}
		assert_false(decoder.is_overrun);
		free(encoder.bytes);
	}
}

/* Nothing costs nothing: the shortest flush leaves no byte of an interval that holds 0. */
static void test_empty_and_likely(void **state)
{
	(void)state;
	struct range encoder;
	range_encode(&encoder);
	range_finish(&encoder);
	assert_int_equal(encoder.size, 0);
	free(encoder.bytes);
	range_encode(&encoder);
	for (int i = 0; i < 20; i++)
		range_bit(&encoder, RANGE_ONE - 1, 1);
	range_finish(&encoder);
	assert_int_equal(encoder.size, 0);
	free(encoder.bytes);
	/* One fair coin fits one byte. */
	range_encode(&encoder);
	range_bit(&encoder, RANGE_ONE / 2, 0);
	range_finish(&encoder);
	assert_int_equal(encoder.size, 1);
	free(encoder.bytes);
}

/* A long row of the unlikeliest 0 after 1s pushes the lower end up against 2^32: the carry must run back over 0xff bytes. */
static void test_carry(void **state)
{
	(void)state;
	struct range encoder, decoder;
	range_encode(&encoder);
	for (int i = 0; i < 4000; i++)
		range_bit(&encoder, RANGE_ONE - 1 - (uint32_t)(i % 7), i % 251 == 250);
	range_finish(&encoder);
	range_decode(&decoder, encoder.bytes, encoder.size);
	for (int i = 0; i < 4000; i++)
		assert_int_equal(range_bit(&decoder, RANGE_ONE - 1 - (uint32_t)(i % 7), 0), i % 251 == 250);
	free(encoder.bytes);
}

/* Reading on behind the end is noticed, not endless zeros. */
static void test_overrun(void **state)
{
	(void)state;
	struct range decoder;
	const unsigned char some[3] = {0x12, 0x34, 0x56};
	range_decode(&decoder, some, sizeof some);
	for (int i = 0; i < 3 * 8 - 1; i++)
		range_bit(&decoder, RANGE_ONE / 2, 0);
	assert_false(decoder.is_overrun);
	for (int i = 0; i < 8 * RANGE_PADDING; i++)
		range_bit(&decoder, RANGE_ONE / 2, 0);
	assert_true(decoder.is_overrun);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_bits_round_trip),
		cmocka_unit_test(test_empty_and_likely),
		cmocka_unit_test(test_carry),
		cmocka_unit_test(test_overrun),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
