/* Normal equations of samples on a refined cage. */
#include "stages/fitpatch/joint_normal.h"

#include <stdlib.h>
#include <string.h>

static inline void add_block(double *restrict out, double weight, const double *restrict block)
{
	for (int k = 0; k < 6; k++)
		out[k] += weight * block[k];
}

/* Number the edges of the refined triangles: those of every lower end lie together, in the order of the triangles. */
static void find_edges(struct normal_sums *sums)
{
	const struct terms *terms = sums->terms;
	const size_t n = terms->level.vertex_count, sides = 3 * terms->triangle_count;
	size_t *start = mem_array(n + 1, sizeof *start);
	idx_t *side = mem_array(sides, sizeof *side);
	sums->triangle_edge = mem_array(sides, sizeof *sums->triangle_edge);
	sums->edge_end = mem_array(2 * sides, sizeof *sums->edge_end);
	for (int pass = 0; pass < 2; pass++) {
		for (size_t h = 0; h < sides; h++) {
			const idx_t a = terms->triangle[h], b = terms->triangle[h % 3 == 2 ? h - 2 : h + 1];
			const size_t low = (size_t)(a < b ? a : b);
			if (pass == 0)
				start[low + 1]++;
			else
				side[start[low]++] = (idx_t)h;
		}
		for (size_t v = 0; pass == 0 && v < n; v++)
			start[v + 1] += start[v];
	}
	/* start[v] has become the end of v's sides */
	for (size_t v = 0, i = 0; v < n; v++) {
		const size_t first = sums->edge_count;
		for (; i < start[v]; i++) {
			const size_t h = (size_t)side[i];
			const idx_t a = terms->triangle[h], b = terms->triangle[h % 3 == 2 ? h - 2 : h + 1], high = a < b ? b : a;
			size_t e = first;
			while (e < sums->edge_count && sums->edge_end[2 * e + 1] != high)
				e++;
			if (e == sums->edge_count) {
				sums->edge_end[2 * e] = (idx_t)v, sums->edge_end[2 * e + 1] = high;
				sums->edge_count++;
			}
			sums->triangle_edge[h] = (idx_t)e;
		}
	}
	free(start), free(side);
	sums->around_start = mem_array(n + 1, sizeof *sums->around_start);
	sums->around = mem_array(2 * sums->edge_count, sizeof *sums->around);
	for (size_t i = 0; i < 2 * sums->edge_count; i++)
		sums->around_start[sums->edge_end[i] + 1]++;
	for (size_t v = 0; v < n; v++)
		sums->around_start[v + 1] += sums->around_start[v];
	size_t *next = mem_copy(sums->around_start, n + 1, sizeof *next);
	for (size_t i = 0; i < 2 * sums->edge_count; i++)
		sums->around[next[sums->edge_end[i]]++] = (idx_t)(i / 2);
	free(next);
}

static idx_t other_end(const struct normal_sums *sums, idx_t edge, size_t vertex)
{
	const idx_t *end = &sums->edge_end[2 * (size_t)edge];
	return end[0] == (idx_t)vertex ? end[1] : end[0];
}

static void transpose(struct normal_sums *sums)
{
	const struct sparse *rows = &sums->terms->rows;
	const size_t entries = rows->row_start[rows->row_count];
	sums->column_start = mem_array(rows->column_count + 1, sizeof *sums->column_start);
	sums->column_row = mem_array(entries, sizeof *sums->column_row);
	sums->column_weight = mem_array(entries, sizeof *sums->column_weight);
	for (size_t i = 0; i < entries; i++)
		sums->column_start[rows->column[i] + 1]++;
	for (size_t c = 0; c < rows->column_count; c++)
		sums->column_start[c + 1] += sums->column_start[c];
	size_t *next = mem_copy(sums->column_start, rows->column_count + 1, sizeof *next);
	for (size_t r = 0; r < rows->row_count; r++)
		for (size_t i = rows->row_start[r]; i < rows->row_start[r + 1]; i++) {
			const size_t at = next[rows->column[i]]++;
			sums->column_row[at] = (idx_t)r;
			sums->column_weight[at] = rows->weight[i];
		}
	free(next);
}

static int compare_columns(const void *a, const void *b)
{
	const idx_t x = *(const idx_t *)a, y = *(const idx_t *)b;
	return (x > y) - (x < y);
}

/* The pattern of N R. */
static void find_product(struct normal_sums *sums)
{
	const struct sparse *rows = &sums->terms->rows;
	const size_t n = rows->row_count;
	size_t room = 0, used = 0;
	idx_t *seen = mem_array(rows->column_count, sizeof *seen); /* row + 1 */
	sums->product_start = mem_array(n + 1, sizeof *sums->product_start);
	for (size_t r = 0; r < n; r++) {
		bool has_free = false;
		for (size_t i = rows->row_start[r]; i < rows->row_start[r + 1]; i++)
			has_free |= !sums->fixed[rows->column[i]];
		const size_t first = sums->around_start[r], last = has_free ? sums->around_start[r + 1] : first;
		/* the vertex itself, then its neighbours */
		for (size_t a = first; has_free && a <= last; a++) {
			const size_t from = a == last ? r : (size_t)other_end(sums, sums->around[a], r);
			const size_t count = rows->row_start[from + 1] - rows->row_start[from];
			if (used + count > room) {
				room = 2 * (used + count) + 1024;
				sums->product_column = mem_resize(sums->product_column, room, sizeof *sums->product_column);
			}
			for (size_t i = rows->row_start[from]; i < rows->row_start[from + 1]; i++)
				if (seen[rows->column[i]] != (idx_t)r + 1) {
					seen[rows->column[i]] = (idx_t)r + 1;
					sums->product_column[used++] = rows->column[i];
				}
		}
		if (used > sums->product_start[r])
			qsort(&sums->product_column[sums->product_start[r]], used - sums->product_start[r], sizeof *sums->product_column, compare_columns);
		sums->product_start[r + 1] = used;
	}
	sums->product = mem_array(6 * used, sizeof *sums->product);
	free(seen);
}

void normal_begin(struct normal_sums *sums, const struct terms *terms, const unsigned char *fixed)
{
	*sums = (struct normal_sums){.terms = terms, .fixed = fixed};
	find_edges(sums);
	transpose(sums);
	find_product(sums);
	sums->vertex = mem_array(6 * terms->level.vertex_count, sizeof *sums->vertex);
	sums->right = mem_array(3 * terms->level.vertex_count, sizeof *sums->right);
	sums->edge = mem_array(6 * sums->edge_count, sizeof *sums->edge);
}

void normal_end(struct normal_sums *sums)
{
	free(sums->vertex), free(sums->right), free(sums->edge), free(sums->edge_end), free(sums->triangle_edge);
	free(sums->around_start), free(sums->around), free(sums->product_start), free(sums->product_column), free(sums->product);
	free(sums->column_start), free(sums->column_row), free(sums->column_weight);
	*sums = (struct normal_sums){0};
}

void normal_clear(struct normal_sums *sums)
{
	memset(sums->vertex, 0, 6 * sums->terms->level.vertex_count * sizeof *sums->vertex);
	memset(sums->right, 0, 3 * sums->terms->level.vertex_count * sizeof *sums->right);
	memset(sums->edge, 0, 6 * sums->edge_count * sizeof *sums->edge);
}

/* out += weight * metric * target */
static void add_right(double out[3], double weight, const double metric[6], const double target[3])
{
	out[0] += weight * (metric[0] * target[0] + metric[1] * target[1] + metric[2] * target[2]);
	out[1] += weight * (metric[1] * target[0] + metric[3] * target[1] + metric[4] * target[2]);
	out[2] += weight * (metric[2] * target[0] + metric[4] * target[1] + metric[5] * target[2]);
}

void normal_add_vertex(struct normal_sums *sums, size_t vertex, const double target[3], const double metric[6], double weight)
{
	add_block(&sums->vertex[6 * vertex], weight, metric);
	add_right(&sums->right[3 * vertex], weight, metric, target);
}

void normal_add_point(struct normal_sums *sums, size_t triangle, const double at[3], const double target[3], const double metric[6], double weight)
{
	for (size_t k = 0; k < 3; k++) {
		if (at[k] == 0)
			continue;
		const size_t v = (size_t)sums->terms->triangle[3 * triangle + k], next = k == 2 ? 0 : k + 1;
		add_block(&sums->vertex[6 * v], weight * at[k] * at[k], metric);
		add_right(&sums->right[3 * v], weight * at[k], metric, target);
		if (at[next] != 0)
			add_block(&sums->edge[6 * (size_t)sums->triangle_edge[3 * triangle + k]], weight * at[k] * at[next], metric);
	}
}

/* N R, row by row. */
static void multiply(const struct normal_sums *sums)
{
	const struct sparse *rows = &sums->terms->rows;
	idx_t *place = mem_array(rows->column_count, sizeof *place);
	for (size_t r = 0; r < rows->row_count; r++) {
		const size_t low = sums->product_start[r], high = sums->product_start[r + 1];
		if (low == high)
			continue;
		double *product = &sums->product[6 * low];
		memset(product, 0, 6 * (high - low) * sizeof *product);
		for (size_t i = low; i < high; i++)
			place[sums->product_column[i]] = (idx_t)(i - low);
		const size_t first = sums->around_start[r], last = sums->around_start[r + 1];
		for (size_t a = first; a <= last; a++) {
			const size_t from = a == last ? r : (size_t)other_end(sums, sums->around[a], r);
			const double *block = a == last ? &sums->vertex[6 * r] : &sums->edge[6 * (size_t)sums->around[a]];
			if (block[0] == 0 && block[3] == 0 && block[5] == 0)
				continue; /* no sample: a semi-definite block without a diagonal is 0 (edges: of one sign, samples lie inside) */
			for (size_t i = rows->row_start[from]; i < rows->row_start[from + 1]; i++)
				add_block(&product[6 * (size_t)place[rows->column[i]]], rows->weight[i], block);
		}
	}
	free(place);
}

void normal_carry(const struct normal_sums *sums, struct lsq *lsq)
{
	multiply(sums);
	const size_t n = sums->terms->rows.column_count;
	double *sum = mem_array(6 * n, sizeof *sum);
	idx_t *seen = mem_array(n, sizeof *seen), *list = mem_array(n, sizeof *list);
	for (size_t c = 0; c < n; c++) {
		if (sums->fixed[c])
			continue;
		size_t count = 0;
		double right[3] = {0, 0, 0};
		for (size_t i = sums->column_start[c]; i < sums->column_start[c + 1]; i++) {
			const size_t r = (size_t)sums->column_row[i];
			const double weight = sums->column_weight[i];
			for (int k = 0; k < 3; k++)
				right[k] += weight * sums->right[3 * r + (size_t)k];
			for (size_t e = sums->product_start[r]; e < sums->product_start[r + 1]; e++) {
				const size_t d = (size_t)sums->product_column[e];
				if (d > c && !sums->fixed[d])
					continue; /* comes as (d, c) */
				if (seen[d] != (idx_t)c + 1) {
					seen[d] = (idx_t)c + 1;
					list[count++] = (idx_t)d;
					memset(&sum[6 * d], 0, 6 * sizeof *sum);
				}
				add_block(&sum[6 * d], weight, &sums->product[6 * e]);
			}
		}
		for (size_t i = 0; i < count; i++)
			lsq_add_block(lsq, (idx_t)c, list[i], &sum[6 * (size_t)list[i]]);
		lsq_add_right(lsq, (idx_t)c, right);
	}
	free(sum), free(seen), free(list);
}
