/* Making sparse matrices row by row. The matrix itself is struct sparse of stages/geometry/subdivide.h. */
#ifndef CAGEWRIGHT_SPARSE_H
#define CAGEWRIGHT_SPARSE_H

#include "stages/geometry/subdivide.h"

/* A row is gathered in a full vector with one bit a column in use: reading the bits gives the columns in order, without sorting. */
struct sparse_maker {
	struct sparse *out;
	size_t row, used, room; /* rows finished; entries in them and space for entries */
	double *value;
	uint64_t *bits;
	idx_t *word;            /* words of bits in use, in order of arrival */
	size_t word_count, used_words;
};

void sparse_begin(struct sparse_maker *maker, struct sparse *out, size_t row_count, size_t column_count);
void sparse_end(struct sparse_maker *maker);
/* The row is complete; entries that came to exactly 0 are left out. */
void sparse_end_row(struct sparse_maker *maker);

/* Add to an entry of the present row. */
static inline void sparse_put(struct sparse_maker *maker, size_t column, double weight)
{
	const size_t w = column / 64;
	if (maker->bits[w] == 0)
		maker->word[maker->used_words++] = (idx_t)w;
	maker->bits[w] |= (uint64_t)1 << (column % 64);
	maker->value[column] += weight;
}

#endif
