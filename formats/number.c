#include "formats/number.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

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

static size_t print_integer(char text[NUM_TEXT_SIZE], int64_t value)
{
	char digit[20];
	size_t count = 0, length = 0;
	uint64_t rest = value < 0 ? (uint64_t)-value : (uint64_t)value;
	do
		digit[count++] = (char)('0' + rest % 10);
	while ((rest /= 10) != 0);
	if (value < 0)
		text[length++] = '-';
	while (count)
		text[length++] = digit[--count];
	text[length] = 0;
	return length;
}

/* nan, inf and whole numbers below 1e15: 0 when it is none of them. */
static size_t print_special(char text[NUM_TEXT_SIZE], double value)
{
	if (isnan(value) || isinf(value)) {
		const char *name = isnan(value) ? "nan" : "inf";
		return (size_t)snprintf(text, NUM_TEXT_SIZE, "%s%s", signbit(value) ? "-" : "", name);
	}
	if (fabs(value) >= 1e15 || value != (double)(int64_t)value)
		return 0;
	if (value == 0 && signbit(value)) {
		memcpy(text, "-0", 3);
		return 2;
	}
	return print_integer(text, (int64_t)value);
}

size_t num_print(char text[NUM_TEXT_SIZE], double value)
{
	size_t length = print_special(text, value);
	for (int digits = 15; length == 0 && digits <= 17; digits++) {
		const size_t made = (size_t)snprintf(text, NUM_TEXT_SIZE, "%.*g", digits, value);
		double back;
		if (digits == 17 || (num_parse(text, made, &back) && back == value))
			length = made;
	}
	return length;
}

size_t num_print_float(char text[NUM_TEXT_SIZE], float value)
{
	size_t length = print_special(text, (double)value);
	for (int digits = 6; length == 0 && digits <= 9; digits++) {
		const size_t made = (size_t)snprintf(text, NUM_TEXT_SIZE, "%.*g", digits, (double)value);
		double back;
		if (digits == 9 || (num_parse(text, made, &back) && (float)back == value))
			length = made;
	}
	return length;
}
