/* A binary range coder with carry propagation (see range.h). */
#include "formats/range.h"

#include <assert.h>

#include "formats/memory.h"

#define RANGE_TOP (1u << 24)

static unsigned char next_byte(struct range *range)
{
	const size_t at = range->input_read++;
	if (at < range->input_size)
		return range->input[at];
	if (at >= range->input_size + RANGE_PADDING)
		range->is_overrun = true;
	return 0;
}

static void put_byte(struct range *range, unsigned char byte)
{
	if (range->size == range->capacity) {
		range->capacity = range->capacity ? 2 * range->capacity : 256;
		range->bytes = mem_resize(range->bytes, range->capacity, 1);
	}
	range->bytes[range->size++] = byte;
}

void range_encode(struct range *range)
{
	*range = (struct range){.range = UINT32_MAX};
}

void range_decode(struct range *range, const unsigned char *input, size_t input_size)
{
	*range = (struct range){.is_decoding = true, .range = UINT32_MAX, .input = input, .input_size = input_size};
	for (int i = 0; i < 4; i++)
		range->code = range->code << 8 | next_byte(range);
}

/* The interval's lower end passed 2^32: add one to the number that the written bytes are. It cannot run off the front,
 * because all that is ever added stays below 1. */
static void carry(struct range *range)
{
	if (range->low >> 32) {
		range->low &= UINT32_MAX;
		for (size_t i = range->size; i > 0 && ++range->bytes[i - 1] == 0; i--)
			;
	}
}

static void normalise(struct range *range)
{
	if (!range->is_decoding)
		carry(range);
	while (range->range < RANGE_TOP) {
		if (range->is_decoding) {
			range->code = range->code << 8 | next_byte(range);
		} else {
			put_byte(range, (unsigned char)(range->low >> 24));
			range->low = range->low << 8 & UINT32_MAX;
		}
		range->range <<= 8;
	}
}

unsigned range_bit(struct range *range, uint32_t probability, unsigned bit)
{
	assert(probability > 0 && probability < RANGE_ONE);
	const uint32_t split = (uint32_t)((uint64_t)range->range * probability >> 16);
	if (range->is_decoding)
		bit = range->code < split;
	if (bit) {
		range->range = split;
	} else {
		range->range -= split;
		if (range->is_decoding)
			range->code -= split;
		else
			range->low += split;
	}
	normalise(range);
	return bit;
}

static uint32_t code_uniform(struct range *range, uint32_t count, uint32_t value)
{
	const uint32_t part = range->range / count;
	if (range->is_decoding) {
		value = range->code / part;
		if (value >= count)
			value = count - 1; /* the remainder of the division belongs to the last value */
		range->code -= value * part;
	} else {
		range->low += (uint64_t)value * part;
	}
	range->range = value == count - 1 ? range->range - value * part : part;
	normalise(range);
	return value;
}

uint32_t range_uniform(struct range *range, uint32_t count, uint32_t value)
{
	assert(count > 0 && count <= 1u << 31 && (range->is_decoding || value < count));
	if (count <= 1u << 16)
		return code_uniform(range, count, value);
	/* High and low half apart, so that no part is smaller than 2^8; a value that only noise can give is brought into range.
	 */
	const uint32_t high = code_uniform(range, ((count - 1) >> 16) + 1, value >> 16);
	const uint32_t both = high << 16 | code_uniform(range, 1u << 16, value & 0xffff);
	return both < count ? both : count - 1;
}

void range_finish(struct range *range)
{
	assert(!range->is_decoding);
	uint64_t value = range->low;
	for (int bits = 32; bits > 0; bits--) {
		const uint64_t mask = ((uint64_t)1 << bits) - 1;
		value = (range->low + mask) & ~mask;
		if (value < range->low + range->range)
			break;
		value = range->low;
	}
	range->low = value;
	carry(range);
	for (int shift = 24; shift >= 0; shift -= 8)
		put_byte(range, (unsigned char)(range->low >> shift));
	const size_t least = range->size > RANGE_PADDING ? range->size - RANGE_PADDING : 0;
	while (range->size > least && range->bytes[range->size - 1] == 0)
		range->size--;
}
