/* Powers of ten to 128 bits, for reading and printing numbers exactly without big integers. */
#ifndef CAGEWRIGHT_NUMBER_POWERS_H
#define CAGEWRIGHT_NUMBER_POWERS_H

#include <stdint.h>

#define NUMBER_POWER_LOW (-40)
#define NUMBER_POWER_HIGH 60

/* number_power[k - NUMBER_POWER_LOW] is 10^k times a power of two, rounded up, with its highest bit set. */
struct number_power {
	uint64_t high, low;
};
extern const struct number_power number_power[NUMBER_POWER_HIGH - NUMBER_POWER_LOW + 1];

/* floor(log2(10^k)) and floor(log10(2^q)) for all exponents of doubles; the factors are the logarithms in fixed point. */
static inline int number_log2_of_power10(int k)
{
	return (int)(((int64_t)k * 1741647) >> 19);
}

static inline int number_log10_of_power2(int q)
{
	return (int)(((int64_t)q * 1262611) >> 22);
}

/* floor(log10(3/4 2^q)) */
static inline int number_log10_of_three_quarters(int q)
{
	return (int)(((int64_t)q * 1262611 - 524031) >> 22);
}

#endif
