/* Printing numbers: the shortest text that reads back. */
#include "formats/number.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "formats/number_powers.h"

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

/* A decimal digits * 10^power. */
struct decimal {
	uint64_t digits;
	int power;
};

/* High part of g * factor, with its lowest bit set when anything nonzero is behind it. */
static uint64_t round_to_odd(const struct number_power *g, uint64_t factor)
{
	const uint64_t low = (uint64_t)((unsigned __int128)g->low * factor >> 64);
	const unsigned __int128 product = (unsigned __int128)g->high * factor + low;
	return (uint64_t)(product >> 64) | ((uint64_t)product > 1);
}

/* The shortest decimal that rounds to mantissa * 2^exponent, and the closest of these: Giulietti, The Schubfach way to
 * render doubles, 2020. The interval that rounds to the number is scaled by a power of ten such that it holds at least
 * one and at most a few whole numbers; lower_closer: the number below is only half as far away. False when the power of
 * ten is not in the table. */
static bool shortest(struct decimal *decimal, uint64_t mantissa, int exponent, bool lower_closer)
{
	const int power = lower_closer ? number_log10_of_three_quarters(exponent) : number_log10_of_power2(exponent);
	if (-power < NUMBER_POWER_LOW || -power > NUMBER_POWER_HIGH)
		return false;
	const struct number_power *g = &number_power[-power - NUMBER_POWER_LOW];
	const int shift = exponent + number_log2_of_power10(-power) + 1;
	/* in quarters; the ends belong to the interval when the mantissa is even */
	const uint64_t odd = mantissa & 1;
	const uint64_t middle = round_to_odd(g, 4 * mantissa << shift);
	const uint64_t low = round_to_odd(g, (4 * mantissa - (lower_closer ? 1 : 2)) << shift) + odd;
	const uint64_t high = round_to_odd(g, (4 * mantissa + 2) << shift) - odd;
	const uint64_t whole = middle / 4;
	if (whole >= 10) {
		const uint64_t tens = whole / 10;
		const bool below = low <= 40 * tens, above = 40 * tens + 40 <= high;
		if (below != above) {
			*decimal = (struct decimal){tens + above, power + 1};
			return true;
		}
	}
	const bool below = low <= 4 * whole, above = 4 * whole + 4 <= high;
	bool up = above;
	if (below == above)
		up = middle > 4 * whole + 2 || (middle == 4 * whole + 2 && (whole & 1));
	*decimal = (struct decimal){whole + up, power};
	return true;
}

/* As printf's %g with as many digits as there are, but at least 15: an exponent below 1e-4 and from 1e15. */
static size_t print_decimal(char text[NUM_TEXT_SIZE], bool negative, struct decimal decimal)
{
	char digit[NUM_TEXT_SIZE];
	while (decimal.digits % 10 == 0) {
		decimal.digits /= 10;
		decimal.power++;
	}
	const int count = (int)print_integer(digit, (int64_t)decimal.digits);
	const int first = count - 1 + decimal.power; /* power of ten of the first digit */
	char *at = text;
	if (negative)
		*at++ = '-';
	if (first < -4 || first >= (count > 15 ? count : 15)) {
		*at++ = digit[0];
		if (count > 1) {
			*at++ = '.';
			memcpy(at, digit + 1, (size_t)count - 1);
			at += count - 1;
		}
		const int size = first < 0 ? -first : first;
		*at++ = 'e';
		*at++ = first < 0 ? '-' : '+';
		if (size >= 100)
			*at++ = (char)('0' + size / 100);
		*at++ = (char)('0' + size / 10 % 10);
		*at++ = (char)('0' + size % 10);
	} else if (first < 0) {
		memcpy(at, "0.0000", 6);
		at += 1 - first;
		memcpy(at, digit, (size_t)count);
		at += count;
	} else {
		for (int i = 0; i <= first || i < count; i++) {
			if (i == first + 1)
				*at++ = '.';
			*at++ = i < count ? digit[i] : '0';
		}
	}
	*at = 0;
	return (size_t)(at - text);
}

/* Outside the table: the first precision of printf that reads back. Rare, so its slowness does not matter. */
static size_t print_by_trial(char text[NUM_TEXT_SIZE], double value, bool is_float)
{
	const int last = is_float ? 9 : 17;
	for (int digits = 1;; digits++) {
		const size_t length = (size_t)snprintf(text, NUM_TEXT_SIZE, "%.*g", digits, value);
		double back;
		if (digits == last)
			return length;
		if (num_parse(text, length, &back) && (is_float ? (float)back == (float)value : back == value))
			return length;
	}
}

size_t num_print(char text[NUM_TEXT_SIZE], double value)
{
	const size_t length = print_special(text, value);
	if (length)
		return length;
	uint64_t bits;
	memcpy(&bits, &value, sizeof bits);
	const uint64_t fraction = bits & 0xfffffffffffffu;
	const int biased = (int)(bits >> 52 & 0x7ff);
	struct decimal decimal;
	if (biased == 0 || !shortest(&decimal, fraction | (uint64_t)1 << 52, biased - 1075, fraction == 0 && biased > 1))
		return print_by_trial(text, value, false);
	return print_decimal(text, signbit(value), decimal);
}

size_t num_print_float(char text[NUM_TEXT_SIZE], float value)
{
	const size_t length = print_special(text, (double)value);
	if (length)
		return length;
	uint32_t bits;
	memcpy(&bits, &value, sizeof bits);
	const uint32_t fraction = bits & 0x7fffffu;
	const int biased = (int)(bits >> 23 & 0xff);
	struct decimal decimal;
	if (biased == 0 || !shortest(&decimal, fraction | (uint32_t)1 << 23, biased - 150, fraction == 0 && biased > 1))
		return print_by_trial(text, (double)value, true);
	return print_decimal(text, signbit(value), decimal);
}
