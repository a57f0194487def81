/* Reading numbers. */
#include "formats/number.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "formats/number_powers.h"

/* Powers of ten that a double holds exactly. */
static const double power10[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11,
                                 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static bool is_digit(char c)
{
	return (unsigned)(c - '0') < 10;
}

/* Exactly rounded by the C library, which wants a final 0. The syntax is known to be good. */
static double convert_slowly(const char *text, size_t length)
{
	char room[128];
	char *copy = length < sizeof room ? room : malloc(length + 1);
	if (!copy)
		return NAN;
	memcpy(copy, text, length);
	copy[length] = 0;
	const double value = strtod(copy, NULL);
	if (copy != room)
		free(copy);
	return value;
}

/* mantissa * 10^power, rounded to nearest, when 128 bits are enough to be sure of it: the product with the tabled power
 * of ten is at most two units too large in its lowest place, so that the answer is certain unless the bits behind the
 * mantissa are that close to one half. (As Lemire, Number Parsing at a Gigabyte per Second, 2021.) */
static bool convert_quickly(uint64_t mantissa, long power, double *value)
{
	if (mantissa == 0 || power < NUMBER_POWER_LOW || power > NUMBER_POWER_HIGH)
		return false;
	const struct number_power *ten = &number_power[power - NUMBER_POWER_LOW];
	const int shift = __builtin_clzll(mantissa);
	const uint64_t m = mantissa << shift;
	unsigned __int128 product = (unsigned __int128)m * ten->high + (uint64_t)((unsigned __int128)m * ten->low >> 64);
	/* exponent of the product's lowest bit */
	int exponent = 64 - shift - (127 - number_log2_of_power10((int)power));
	if (!(product >> 127)) {
		product <<= 1;
		exponent--;
	}
	const int cut = 128 - 53;
	const unsigned __int128 half = (unsigned __int128)1 << (cut - 1), rest = product & (2 * half - 1);
	if (rest >= half - 4 && rest <= half + 4)
		return false;
	const uint64_t top = (uint64_t)(product >> cut) + (rest > half);
	*value = ldexp((double)top, exponent + cut);
	return true;
}

bool num_parse(const char *text, size_t length, double *value)
{
	const char *at = text, *const end = text + length;
	bool negative = false;
	if (at < end && (*at == '-' || *at == '+'))
		negative = *at++ == '-';
	if (end - at == 3 && strncasecmp(at, "nan", 3) == 0) {
		*value = negative ? -NAN : NAN;
		return true;
	}
	if (end - at == 3 && strncasecmp(at, "inf", 3) == 0) {
		*value = negative ? -INFINITY : INFINITY;
		return true;
	}
	uint64_t mantissa = 0;
	int significant = 0; /* digits in mantissa, leading zeros not counted */
	bool any = false;
	long exponent = 0;
	for (; at < end && is_digit(*at); at++) {
		any = true;
		if (significant < 19) {
			mantissa = mantissa * 10 + (uint64_t)(*at - '0');
			significant += mantissa != 0;
		} else {
			significant = 20; /* more than we hold */
		}
	}
	if (at < end && *at == '.') {
		for (at++; at < end && is_digit(*at); at++) {
			any = true;
			if (significant < 19) {
				mantissa = mantissa * 10 + (uint64_t)(*at - '0');
				significant += mantissa != 0;
				exponent--;
			} else {
				significant = 20;
			}
		}
	}
	if (!any)
		return false;
	if (at < end && (*at == 'e' || *at == 'E')) {
		bool down = false;
		at++;
		if (at < end && (*at == '-' || *at == '+'))
			down = *at++ == '-';
		if (at == end)
			return false;
		long power = 0;
		for (; at < end && is_digit(*at); at++)
			if (power < 1000000)
				power = power * 10 + (*at - '0');
		exponent += down ? -power : power;
	}
	if (at != end)
		return false;
	/* Clinger's fast path: both factors are exact, so one rounding gives the nearest double. */
	if (significant <= 19 && mantissa <= (uint64_t)1 << 53 && exponent >= -22 && exponent <= 22) {
		const double m = (double)mantissa;
		const double magnitude = exponent < 0 ? m / power10[-exponent] : m * power10[exponent];
		*value = negative ? -magnitude : magnitude;
		return true;
	}
	if (significant <= 19 && convert_quickly(mantissa, exponent, value)) {
		if (negative)
			*value = -*value;
		return true;
	}
	*value = convert_slowly(text, length);
	return true;
}

bool num_parse_integer(const char *text, size_t length, long long low, long long high, long long *value)
{
	const char *at = text, *const end = text + length;
	bool negative = false;
	if (at < end && (*at == '-' || *at == '+'))
		negative = *at++ == '-';
	if (at == end)
		return false;
	unsigned long long magnitude = 0;
	for (; at < end; at++) {
		if (!is_digit(*at))
			return false;
		if (__builtin_mul_overflow(magnitude, 10ULL, &magnitude) ||
		    __builtin_add_overflow(magnitude, (unsigned long long)(*at - '0'), &magnitude))
			return false;
	}
	if (magnitude > (unsigned long long)INT64_MAX) /* the least long long is never asked for */
		return false;
	const long long whole = negative ? -(long long)magnitude : (long long)magnitude;
	if (whole < low || whole > high)
		return false;
	*value = whole;
	return true;
}
