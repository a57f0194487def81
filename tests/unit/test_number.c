#include "tests/unit/helpers.h"

#include "formats/number.h"

/* splitmix64: the same numbers on every machine */
static uint64_t bits_of(uint64_t *state)
{
	uint64_t z = *state += 0x9e3779b97f4a7c15u;
	z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
	z = (z ^ z >> 27) * 0x94d049bb133111ebu;
	return z ^ z >> 31;
}

static bool parse(const char *text, double *value)
{
	return num_parse(text, strlen(text), value);
}

static void parses_c_syntax(void **state)
{
	(void)state;
	static const struct {
		const char *text;
		double value;
	} good[] = {
		{"0", 0}, {"1", 1}, {"-1", -1}, {"+3", 3}, {".5", 0.5}, {"5.", 5}, {"1.5e3", 1500}, {"1E-2", 0.01},
		{"000012", 12}, {"1e+05", 100000}, {"0.1", 0.1}, {"123456789012345678", 123456789012345678.0},
		{"1e22", 1e22}, {"1e23", 1e23}, {"4.9e-324", 4.9406564584124654e-324}, {"1.7976931348623157e308", 1.7976931348623157e308},
		{"0.000000000000000000000000000000000000000000000000001e51", 1}, {"9007199254740993", 9007199254740992.0},
		{"1e400", HUGE_VAL}, {"-1e400", -HUGE_VAL}, {"1e-400", 0}, {"0e999999999999", 0},
		{"1.00000000000000011102230246251565404", 1}, /* just below the middle between 1 and the next double */
		{"1.00000000000000011102230246251565405", 1.0000000000000002}, /* just above it */
	};
	for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
		double value = 7;
		if (!parse(good[i].text, &value) || value != good[i].value)
			fail_msg("'%s' gives %.17g", good[i].text, value);
	}
	double value;
	assert_true(parse("-0", &value) && value == 0 && signbit(value));
	assert_true(parse("nan", &value) && isnan(value));
	assert_true(parse("NaN", &value) && isnan(value));
	assert_true(parse("-inf", &value) && value == -HUGE_VAL);
	assert_true(parse("INF", &value) && value == HUGE_VAL);
}

static void refuses_anything_else(void **state)
{
	(void)state;
	static const char *const bad[] = {"", "-", "+", ".", "e5", "1e", "1e+", "1,5", "1 ", " 1", "0x10", "1f", "abc", "1.2.3",
	                                  "--1", "1e5.0", "infinity!", "nano", "1_000", "\xd9\xa1"};
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
		double value;
		if (parse(bad[i], &value))
			fail_msg("'%s' was taken for %.17g", bad[i], value);
	}
	/* the field ends where it is said to end */
	double value;
	assert_true(num_parse("12345", 2, &value) && value == 12);
	assert_true(num_parse("1e5", 1, &value) && value == 1);
}

static void parses_long_digits(void **state)
{
	(void)state;
	/* 400 digits behind the point: longer than any fixed buffer; the C library gives the reference */
	char text[500] = "0.";
	for (int i = 2; i < 402; i++)
		text[i] = (char)('0' + i * 7 % 10);
	double value;
	assert_true(parse(text, &value));
	assert_true(value == strtod(text, NULL));
}

static void parses_integers_in_range(void **state)
{
	(void)state;
	long long value;
	assert_true(num_parse_integer("255", 3, 0, 255, &value) && value == 255);
	assert_true(num_parse_integer("-128", 4, -128, 127, &value) && value == -128);
	assert_true(num_parse_integer("+7", 2, 0, 9, &value) && value == 7);
	assert_false(num_parse_integer("256", 3, 0, 255, &value));
	assert_false(num_parse_integer("-129", 4, -128, 127, &value));
	assert_false(num_parse_integer("3.0", 3, 0, 255, &value));
	assert_false(num_parse_integer("", 0, 0, 255, &value));
	assert_false(num_parse_integer("-", 1, 0, 255, &value));
	/* wraps round to 1 in 64 bits when nobody looks */
	assert_false(num_parse_integer("18446744073709551617", 20, 0, 255, &value));
	assert_false(num_parse_integer("99999999999999999999999999999", 29, 0, INT64_MAX, &value));
}

static void prints_plainly(void **state)
{
	(void)state;
	static const struct {
		double value;
		const char *text;
	} known[] = {
		{0, "0"}, {-0.0, "-0"}, {3, "3"}, {-12, "-12"}, {0.1, "0.1"}, {0.5, "0.5"}, {1.0 / 3, "0.3333333333333333"},
		{2.0 / 3, "0.6666666666666666"}, {999999999999999, "999999999999999"}, {1e15, "1e+15"}, {1e23, "1e+23"},
		{0.0001, "0.0001"}, {0.00001, "1e-05"}, {1.5e-7, "1.5e-07"}, {123456.789, "123456.789"},
		{5e-324, "5e-324"}, {1.7976931348623157e308, "1.7976931348623157e+308"}, {0.1 + 0.2, "0.30000000000000004"},
		{9007199254740993.0, "9007199254740992"}, {2251799813685249.5, "2251799813685249.5"},
		{INFINITY, "inf"}, {-INFINITY, "-inf"}, {NAN, "nan"},
	};
	for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
		char text[NUM_TEXT_SIZE];
		const size_t length = num_print(text, known[i].value);
		assert_string_equal(text, known[i].text);
		assert_int_equal(length, strlen(text));
	}
	char text[NUM_TEXT_SIZE];
	num_print_float(text, 0.1f);
	assert_string_equal(text, "0.1"); /* not 0.100000001490116 */
	num_print_float(text, 16777216.0f);
	assert_string_equal(text, "16777216");
	num_print_float(text, 3.4028235e38f);
	assert_string_equal(text, "3.4028235e+38");
	num_print_float(text, 1e-45f);
	assert_string_equal(text, "1e-45");
}

/* Every double must come back; the C library is asked as well, so that a mistake in our reader cannot hide one in our printer. */
static void reads_back_what_it_prints(void **state)
{
	(void)state;
	uint64_t seed = 1;
	for (int i = 0; i < 200000; i++) {
		const uint64_t bits = bits_of(&seed);
		double value;
		if (i % 4 == 0)
			memcpy(&value, &bits, sizeof value); /* any exponent */
		else if (i % 4 == 1)
			value = (double)(bits >> 11) * 0x1p-53 * 100; /* like coordinates */
		else if (i % 4 == 2)
			value = ldexp((double)(bits >> 11), (int)(bits % 200) - 150);
		else
			value = ldexp(1, (int)(bits % 300) - 150); /* the gap below a power of two is half as wide */
		if (!isfinite(value))
			continue;
		char text[NUM_TEXT_SIZE];
		const size_t length = num_print(text, value);
		double back;
		if (!num_parse(text, length, &back) || back != value || strtod(text, NULL) != value)
			fail_msg("%a was printed as %s", value, text);
		/* no longer than the first precision of printf that reads back */
		char ours[40];
		for (int digits = 15; digits <= 17; digits++) {
			snprintf(ours, sizeof ours, "%.*g", digits, value);
			if (strtod(ours, NULL) == value)
				break;
		}
		if (length > strlen(ours))
			fail_msg("%s is longer than %s", text, ours);
	}
}

static void floats_read_back(void **state)
{
	(void)state;
	uint64_t seed = 2;
	for (int i = 0; i < 100000; i++) {
		const uint32_t bits = (uint32_t)bits_of(&seed);
		float value;
		memcpy(&value, &bits, sizeof value);
		if (!isfinite(value))
			continue;
		char text[NUM_TEXT_SIZE];
		const size_t length = num_print_float(text, value);
		double back;
		if (!num_parse(text, length, &back) || (float)back != value || strtof(text, NULL) != value)
			fail_msg("%a was printed as %s", (double)value, text);
	}
}

static void reads_as_the_c_library_does(void **state)
{
	(void)state;
	uint64_t seed = 3;
	for (int i = 0; i < 100000; i++) {
		char text[64];
		snprintf(text, sizeof text, "%llu.%llue%d", (unsigned long long)(bits_of(&seed) % 100000),
		         (unsigned long long)(bits_of(&seed) % (i % 2 ? 1000000000000 : 10000000)), (int)(bits_of(&seed) % 100) - 50);
		double value;
		if (!parse(text, &value) || value != strtod(text, NULL))
			fail_msg("%s gives %a, not %a", text, value, strtod(text, NULL));
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(parses_c_syntax),       cmocka_unit_test(refuses_anything_else), cmocka_unit_test(parses_long_digits),
		cmocka_unit_test(parses_integers_in_range), cmocka_unit_test(prints_plainly),     cmocka_unit_test(reads_back_what_it_prints),
		cmocka_unit_test(floats_read_back),      cmocka_unit_test(reads_as_the_c_library_does),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
