/* Sparse matrices by rows: the few operations that subdivision needs. */
#include "stages/geometry/sparse.h"

#include <stdlib.h>
#include <string.h>

/* Up to so many words of bits (64 columns each) are scanned for every row; wider matrices sort the words in use. */
enum { SCANNED_WORDS = 16 };

void sparse_free(struct sparse *sparse)
{
	if (sparse == NULL)
		return;
	free(sparse->row_start);
	free(sparse->column);
	free(sparse->weight);
	memset(sparse, 0, sizeof *sparse);
}

void sparse_apply(double *restrict out, const struct sparse *sparse, const double *restrict in)
{
	for (size_t r = 0; r < sparse->row_count; r++) {
		double sum[3] = {0, 0, 0};
		for (size_t k = sparse->row_start[r]; k < sparse->row_start[r + 1]; k++)
			for (size_t i = 0; i < 3; i++)
				sum[i] += sparse->weight[k] * in[3 * (size_t)sparse->column[k] + i];
		memcpy(out + 3 * r, sum, sizeof sum);
	}
}

void sparse_begin(struct sparse_maker *maker, struct sparse *out, size_t row_count, size_t column_count)
{
	*out = (struct sparse){.row_count = row_count, .column_count = column_count};
	out->row_start = mem_array(row_count + 1, sizeof *out->row_start);
	*maker = (struct sparse_maker){.out = out, .word_count = column_count / 64 + 1};
	maker->value = mem_array(64 * maker->word_count, sizeof *maker->value);
	maker->bits = mem_array(maker->word_count, sizeof *maker->bits);
	maker->word = mem_array(maker->word_count, sizeof *maker->word);
}

static int compare_words(const void *a, const void *b)
{
	const idx_t x = *(const idx_t *)a, y = *(const idx_t *)b;
	return (x > y) - (x < y);
}

void sparse_end_row(struct sparse_maker *maker)
{
	struct sparse *out = maker->out;
	const bool scan = maker->word_count <= SCANNED_WORDS;
	if (!scan && maker->used_words > 1)
		qsort(maker->word, maker->used_words, sizeof *maker->word, compare_words);
	for (size_t i = 0; i < (scan ? maker->word_count : maker->used_words); i++) {
		const size_t w = scan ? i : (size_t)maker->word[i];
		if (maker->used + 64 > maker->room) {
			maker->room = 2 * maker->room + 1024;
			out->column = mem_resize(out->column, maker->room, sizeof *out->column);
			out->weight = mem_resize(out->weight, maker->room, sizeof *out->weight);
		}
		for (uint64_t bits = maker->bits[w]; bits; bits &= bits - 1) {
			const size_t c = 64 * w + (size_t)__builtin_ctzll(bits);
			if (maker->value[c] != 0) {
				out->column[maker->used] = (idx_t)c;
				out->weight[maker->used++] = maker->value[c];
			}
			maker->value[c] = 0;
		}
		maker->bits[w] = 0;
	}
	maker->used_words = 0;
	out->row_start[++maker->row] = maker->used;
}

void sparse_end(struct sparse_maker *maker)
{
	struct sparse *out = maker->out;
	/* an empty matrix still owns arrays */
	out->column = mem_resize(out->column, maker->used ? maker->used : 1, sizeof *out->column);
	out->weight = mem_resize(out->weight, maker->used ? maker->used : 1, sizeof *out->weight);
	free(maker->value);
	free(maker->bits);
	free(maker->word);
}

void sparse_multiply(struct sparse *out, const struct sparse *left, const struct sparse *right)
{
	struct sparse_maker maker;
	sparse_begin(&maker, out, left->row_count, right->column_count);
	for (size_t r = 0; r < left->row_count; r++) {
		for (size_t k = left->row_start[r]; k < left->row_start[r + 1]; k++) {
			const size_t m = (size_t)left->column[k];
			for (size_t l = right->row_start[m]; l < right->row_start[m + 1]; l++)
				sparse_put(&maker, (size_t)right->column[l], left->weight[k] * right->weight[l]);
		}
		sparse_end_row(&maker);
	}
	sparse_end(&maker);
}
