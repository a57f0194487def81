/* A binary range coder with carry propagation: 32-bit range, 16-bit probabilities, shortest flush.
 *
 * One struct serves both directions: range_bit() and range_uniform() take the value to be coded when encoding and ignore
 * it when decoding, and return the value in both cases. A model written once on top of them is symmetric by construction.
 * Source: G. N. N. Martin, "Range encoding" (1979); carry by stepping back through the bytes already written. */
#ifndef CAGEWRIGHT_RANGE_H
#define CAGEWRIGHT_RANGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RANGE_ONE 65536u /* probability 1 */

/* Bytes that a decoder may read behind the end (they are zeros) before the stream counts as truncated: the four that
 * fill its register and as many that the shortest flush leaves out. */
#define RANGE_PADDING 8

struct range {
	bool is_decoding;
	bool is_overrun;      /* decoding: more than RANGE_PADDING bytes were missing; what was decoded since is noise */
	unsigned char *bytes; /* encoding: what has been written; caller frees */
	size_t size, capacity;
	const unsigned char *input; /* decoding */
	size_t input_size, input_read;
	uint64_t low;   /* encoding: lower end, below 2^32 between calls */
	uint32_t range; /* at least 2^24 between calls */
	uint32_t code;  /* decoding: value relative to the lower end */
};

void range_encode(struct range *range);
void range_decode(struct range *range, const unsigned char *input, size_t input_size);

/* One bit whose probability of being 1 is probability / RANGE_ONE, in [1, RANGE_ONE - 1]. */
unsigned range_bit(struct range *range, uint32_t probability, unsigned bit);

/* One of count equally likely values, value < count, 1 <= count <= 2^31. */
uint32_t range_uniform(struct range *range, uint32_t count, uint32_t value);

/* Encoding: choose the value with the most trailing zero bits in the last interval, append its leading bytes, drop zero
 * bytes from the end as far as the decoder's padding makes up for them. */
void range_finish(struct range *range);

#endif
