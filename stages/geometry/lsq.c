/* Weighted least squares for points in space: normal equations in symmetric 3x3 blocks, Cholesky factorisation (dense for
 * small or well-filled systems, CHOLMOD's simplicial one otherwise: Davis and Hager 2009). */
#include "stages/geometry/lsq.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <suitesparse/cholmod.h>

/* Up to here the number of a block is looked up in a triangle (2 MB at most), beyond in a hash. */
enum { TABLE_POINTS = 1024 };
/* The dense factor does about ten times the operations in the time of the simplicial one, which has no blocks to work in. So it
 * is taken for few free points, and for more of them when so many of all pairs are coupled that fill would be nearly complete. */
enum { DENSE_ALWAYS = 64, DENSE_AT_MOST = 400 };
enum { DISSECTED = 1000 };
static const double dense_share = 0.08;
/* Ratio of the smallest to the largest squared pivot below which a matrix counts as singular. */
static const double least_rcond = 1e-15;

struct lsq {
	size_t point_count;
	const double *xyz;
	const unsigned char *fixed;
	idx_t *free_number;      /* a point: its place among the free ones, or NO_INDEX */
	size_t free_count;
	double *right;           /* 3 a point: sum of w c M target */
	/* lower triangle of blocks in order of arrival, each symmetric by itself: xx xy xz yy yz zz */
	double *block;
	size_t block_count, block_room;
	idx_t *row, *column;     /* of each block */
	bool has_table;          /* slot[i (i + 1) / 2 + j] is block (i, j); else a hash with open addressing */
	idx_t *slot;             /* block number + 1, 0 = none yet */
	size_t slot_count;       /* of the hash: a power of two */
	/* what CHOLMOD knows */
	cholmod_common common;
	cholmod_sparse *matrix;
	cholmod_factor *factor;
	size_t *place;           /* 9 a block: entry of the matrix for each coordinate pair, SIZE_MAX where there is none */
	size_t analysed;         /* block_count when the pattern was analysed */
};

/* Entry of a symmetric block for coordinates (r, c). */
static const unsigned char packed[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};

struct lsq *lsq_new(size_t point_count, const double *xyz, const unsigned char *fixed)
{
	struct lsq *lsq = mem_array(1, sizeof *lsq);
	lsq->point_count = point_count;
	lsq->xyz = xyz;
	lsq->fixed = fixed;
	lsq->free_number = mem_array(point_count, sizeof *lsq->free_number);
	for (size_t i = 0; i < point_count; i++)
		lsq->free_number[i] = fixed && fixed[i] ? NO_INDEX : (idx_t)lsq->free_count++;
	lsq->right = mem_array(3 * point_count, sizeof *lsq->right);
	lsq->has_table = point_count <= TABLE_POINTS;
	lsq->slot_count = lsq->has_table ? point_count * (point_count + 1) / 2 : 1 << 14;
	lsq->slot = mem_array(lsq->slot_count, sizeof *lsq->slot);
	cholmod_start(&lsq->common);
	lsq->common.supernodal = CHOLMOD_SIMPLICIAL;
	lsq->common.final_ll = 1; /* LL' tells an indefinite matrix, LDL' goes on */
	lsq->common.nmethods = 1;
	/* Nested dissection halves the operations for thousands of points on a surface; minimum degree is found faster for few. */
	lsq->common.method[0].ordering = point_count > DISSECTED ? CHOLMOD_METIS : CHOLMOD_AMD;
	lsq->common.print = 0;
	return lsq;
}

static void forget_pattern(struct lsq *lsq)
{
	if (lsq->matrix)
		cholmod_free_sparse(&lsq->matrix, &lsq->common);
	if (lsq->factor)
		cholmod_free_factor(&lsq->factor, &lsq->common);
	free(lsq->place);
	lsq->place = NULL;
	lsq->analysed = 0;
}

void lsq_free(struct lsq *lsq)
{
	if (lsq == NULL)
		return;
	forget_pattern(lsq);
	cholmod_finish(&lsq->common);
	free(lsq->free_number);
	free(lsq->right);
	free(lsq->block);
	free(lsq->row);
	free(lsq->column);
	free(lsq->slot);
	free(lsq);
}

void lsq_clear(struct lsq *lsq)
{
	/* blocks of the old pattern stay, as zeros: the next terms are likely to need the same */
	memset(lsq->right, 0, 3 * lsq->point_count * sizeof *lsq->right);
	if (lsq->block)
		memset(lsq->block, 0, 6 * lsq->block_count * sizeof *lsq->block);
}

static size_t first_slot(const struct lsq *lsq, idx_t i, idx_t j)
{
	const uint64_t key = (uint64_t)(uint32_t)i << 32 | (uint32_t)j;
	return (size_t)(key * 0x9E3779B97F4A7C15u >> 32) & (lsq->slot_count - 1);
}

static void grow_slots(struct lsq *lsq)
{
	free(lsq->slot);
	lsq->slot_count *= 2;
	lsq->slot = mem_array(lsq->slot_count, sizeof *lsq->slot);
	for (size_t b = 0; b < lsq->block_count; b++) {
		size_t s = first_slot(lsq, lsq->row[b], lsq->column[b]);
		while (lsq->slot[s])
			s = (s + 1) & (lsq->slot_count - 1);
		lsq->slot[s] = (idx_t)b + 1;
	}
}

/* Append the block of points i and j, i >= j; its number + 1. */
static idx_t new_block(struct lsq *lsq, idx_t i, idx_t j)
{
	const size_t b = lsq->block_count++;
	if (b == lsq->block_room) {
		lsq->block_room = lsq->block_room ? 2 * lsq->block_room : 512;
		lsq->block = mem_resize(lsq->block, lsq->block_room, 6 * sizeof *lsq->block);
		lsq->row = mem_resize(lsq->row, lsq->block_room, sizeof *lsq->row);
		lsq->column = mem_resize(lsq->column, lsq->block_room, sizeof *lsq->column);
	}
	memset(lsq->block + 6 * b, 0, 6 * sizeof *lsq->block);
	lsq->row[b] = i;
	lsq->column[b] = j;
	return (idx_t)b + 1;
}

static double *hashed_block(struct lsq *lsq, idx_t i, idx_t j)
{
	size_t s = first_slot(lsq, i, j);
	for (; lsq->slot[s]; s = (s + 1) & (lsq->slot_count - 1)) {
		const size_t b = (size_t)lsq->slot[s] - 1;
		if (lsq->row[b] == i && lsq->column[b] == j)
			return lsq->block + 6 * b;
	}
	const idx_t number = lsq->slot[s] = new_block(lsq, i, j);
	if (2 * lsq->block_count > lsq->slot_count)
		grow_slots(lsq);
	return lsq->block + 6 * ((size_t)number - 1);
}

/* The block of points i and j. The pointer holds until the next call. */
static inline double *block_at(struct lsq *lsq, idx_t i, idx_t j)
{
	if (i < j) {
		const idx_t t = i;
		i = j;
		j = t;
	}
	if (!lsq->has_table)
		return hashed_block(lsq, i, j);
	idx_t *slot = lsq->slot + (size_t)i * ((size_t)i + 1) / 2 + (size_t)j;
	if (*slot == 0)
		*slot = new_block(lsq, i, j);
	return lsq->block + 6 * ((size_t)*slot - 1);
}

void lsq_add(struct lsq *lsq, const idx_t *index, const double *coefficient, size_t count, const double target[3], const double metric[6], double weight)
{
	double m[6], t[3];
	for (int k = 0; k < 6; k++)
		m[k] = weight * metric[k];
	for (int k = 0; k < 3; k++)
		t[k] = m[packed[3 * k]] * target[0] + m[packed[3 * k + 1]] * target[1] + m[packed[3 * k + 2]] * target[2];
	for (size_t p = 0; p < count; p++) {
		const idx_t i = index[p];
		const bool i_is_free = lsq->free_number[i] != NO_INDEX;
		double mp[6];
		for (int k = 0; k < 6; k++)
			mp[k] = coefficient[p] * m[k];
		if (i_is_free)
			for (int k = 0; k < 3; k++)
				lsq->right[3 * i + k] += coefficient[p] * t[k];
		for (size_t q = 0; q <= p; q++) {
			const idx_t j = index[q];
			if (!i_is_free && lsq->free_number[j] == NO_INDEX)
				continue;
			double *restrict b = block_at(lsq, i, j);
			/* the same point at two places of the row: (p, q) and (q, p) meet in one block */
			const double c = i == j && p != q ? 2 * coefficient[q] : coefficient[q];
			b[0] += c * mp[0];
			b[1] += c * mp[1];
			b[2] += c * mp[2];
			b[3] += c * mp[3];
			b[4] += c * mp[4];
			b[5] += c * mp[5];
		}
	}
}

void lsq_add_point(struct lsq *lsq, idx_t i, const double target[3], double weight)
{
	if (lsq->free_number[i] == NO_INDEX)
		return;
	double *b = block_at(lsq, i, i);
	b[0] += weight;
	b[3] += weight;
	b[5] += weight;
	for (int k = 0; k < 3; k++)
		lsq->right[3 * i + k] += weight * target[k];
}

void lsq_add_block(struct lsq *lsq, idx_t i, idx_t j, const double block[6])
{
	if (lsq->free_number[i] == NO_INDEX && lsq->free_number[j] == NO_INDEX)
		return;
	double *b = block_at(lsq, i, j);
	for (int k = 0; k < 6; k++)
		b[k] += block[k];
}

void lsq_add_right(struct lsq *lsq, idx_t i, const double right[3])
{
	for (int k = 0; k < 3; k++)
		lsq->right[3 * i + k] += right[k];
}

double lsq_scale(const struct lsq *lsq)
{
	double sum = 0;
	for (size_t k = 0; k < lsq->block_count; k++) {
		const double *b = lsq->block + 6 * k;
		if (lsq->row[k] == lsq->column[k] && lsq->free_number[lsq->row[k]] != NO_INDEX)
			sum += b[0] + b[3] + b[5];
	}
	return lsq->free_count ? sum / (3 * (double)lsq->free_count) : 0;
}

/* right -= block * position, for the fixed partner of a free point */
static void subtract_block(double right[3], const double b[6], const double x[3])
{
	right[0] -= b[0] * x[0] + b[1] * x[1] + b[2] * x[2];
	right[1] -= b[1] * x[0] + b[3] * x[1] + b[4] * x[2];
	right[2] -= b[2] * x[0] + b[4] * x[1] + b[5] * x[2];
}

/* right: 3 a free point. Block (i, j) moves to the right-hand side when just one of its points is fixed. */
static void subtract_fixed(double *right, const struct lsq *lsq, idx_t i, idx_t j, const double b[6])
{
	const idx_t fi = lsq->free_number[i], fj = lsq->free_number[j];
	if (fi != NO_INDEX && fj == NO_INDEX)
		subtract_block(right + 3 * fi, b, lsq->xyz + 3 * j);
	else if (fi == NO_INDEX && fj != NO_INDEX)
		subtract_block(right + 3 * fj, b, lsq->xyz + 3 * i);
}

/* Four sums side by side: one chain of additions would wait for each. The order is fixed, whatever the compiler. */
static double dot(const double *a, const double *b, size_t count)
{
	double s[4] = {0, 0, 0, 0};
	size_t k = 0;
	for (; k + 4 <= count; k += 4)
		for (size_t l = 0; l < 4; l++)
			s[l] += a[k + l] * b[k + l];
	for (; k < count; k++)
		s[0] += a[k] * b[k];
	return (s[0] + s[1]) + (s[2] + s[3]);
}

/* sum[r] = a . row r, of four rows stride apart: each number of a is read once for all, and no addition waits for another. */
static void four_dots(double sum[4], const double *a, const double *row, size_t stride, size_t count)
{
	const double *one = row + stride, *two = one + stride, *three = two + stride;
	double s[4][2] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
	size_t k = 0;
	for (; k + 2 <= count; k += 2)
		for (size_t l = 0; l < 2; l++) {
			const double x = a[k + l];
			s[0][l] += x * row[k + l];
			s[1][l] += x * one[k + l];
			s[2][l] += x * two[k + l];
			s[3][l] += x * three[k + l];
		}
	if (k < count) {
		s[0][0] += a[k] * row[k];
		s[1][0] += a[k] * one[k];
		s[2][0] += a[k] * two[k];
		s[3][0] += a[k] * three[k];
	}
	for (int r = 0; r < 4; r++)
		sum[r] = s[r][0] + s[r][1];
}

/* Rows that are worked on together, a multiple of 4: rows above are then read once for all of them. */
enum { ROW_BLOCK = 24 };

/* Entries j to j + 3 of row i, all rows above i being done. */
static void finish_four(double *row, const double *above, size_t n, size_t j)
{
	double sum[4];
	four_dots(sum, row, above + j * n, n, j);
	for (size_t r = 0; r < 4; r++) {
		const double *other = above + (j + r) * n;
		double x = row[j + r] - sum[r];
		for (size_t k = j; k < j + r; k++)
			x -= row[k] * other[k];
		row[j + r] = x / other[j + r];
	}
}

/* Cholesky in place, rows of the lower triangle; then x := A^-1 x. */
static bool dense_solve(double *a, double *x, size_t n)
{
	double largest = 0, smallest = INFINITY;
	for (size_t first = 0; first < n; first += ROW_BLOCK) {
		const size_t end = first + ROW_BLOCK < n ? first + ROW_BLOCK : n;
		for (size_t j = 0; j < first; j += 4)
			for (size_t i = first; i < end; i++)
				finish_four(a + i * n, a, n, j);
		for (size_t j = first; j < end; j++) {
			double *aj = a + j * n;
			const double pivot = aj[j] - dot(aj, aj, j);
			if (!(pivot > 0))
				return false;
			aj[j] = sqrt(pivot);
			largest = fmax(largest, pivot);
			smallest = fmin(smallest, pivot);
			for (size_t i = j + 1; i < end; i++)
				a[i * n + j] = (a[i * n + j] - dot(a + i * n, aj, j)) / aj[j];
		}
	}
	if (!(smallest > least_rcond * largest))
		return false;
	for (size_t i = 0; i < n; i++)
		x[i] = (x[i] - dot(a + i * n, x, i)) / a[i * n + i];
	for (size_t i = n; i-- > 0;) {
		x[i] /= a[i * n + i];
		for (size_t j = 0; j < i; j++)
			x[j] -= a[i * n + j] * x[i];
	}
	return true;
}

/* x: right-hand side in, solution out. */
static bool solve_dense(const struct lsq *lsq, double *x)
{
	const size_t n = 3 * lsq->free_count;
	double *a = mem_array(n * n, sizeof *a);
	for (size_t k = 0; k < lsq->block_count; k++) {
		const double *b = lsq->block + 6 * k;
		const idx_t i = lsq->free_number[lsq->row[k]], j = lsq->free_number[lsq->column[k]];
		subtract_fixed(x, lsq, lsq->row[k], lsq->column[k], b);
		if (i == NO_INDEX || j == NO_INDEX)
			continue;
		for (size_t e = 0; e < 9; e++) /* free numbers rise with points: i >= j */
			a[(3 * (size_t)i + e / 3) * n + 3 * (size_t)j + e % 3] = b[packed[e]];
	}
	const bool good = dense_solve(a, x, n);
	free(a);
	return good;
}

static bool is_well_filled(const struct lsq *lsq)
{
	const size_t n = lsq->free_count;
	if (n <= DENSE_ALWAYS || n > DENSE_AT_MOST)
		return n <= DENSE_ALWAYS;
	size_t coupled = 0;
	for (size_t k = 0; k < lsq->block_count; k++)
		coupled += lsq->free_number[lsq->row[k]] != NO_INDEX && lsq->free_number[lsq->column[k]] != NO_INDEX;
	return (double)coupled > dense_share * (double)n * (double)(n + 1) / 2;
}

/* The pattern of the free part as compressed columns (lower triangle, rows rising), and its ordering. */
static bool analyse(struct lsq *lsq)
{
	forget_pattern(lsq);
	const size_t n = lsq->free_count;
	/* free blocks by column, then by row: two counting sorts */
	idx_t *order = mem_array(lsq->block_count, sizeof *order), *by_row = mem_array(lsq->block_count, sizeof *by_row);
	size_t *start = mem_array(n + 1, sizeof *start), used = 0;
	for (int pass = 0; pass < 2; pass++) {
		const idx_t *point = pass ? lsq->column : lsq->row;
		memset(start, 0, (n + 1) * sizeof *start);
		for (size_t i = 0; i < (pass ? used : lsq->block_count); i++) {
			const size_t b = pass ? (size_t)by_row[i] : i;
			if (lsq->free_number[lsq->row[b]] != NO_INDEX && lsq->free_number[lsq->column[b]] != NO_INDEX)
				start[lsq->free_number[point[b]] + 1]++;
		}
		for (size_t v = 0; v < n; v++)
			start[v + 1] += start[v];
		const size_t total = pass ? used : lsq->block_count;
		used = start[n];
		for (size_t i = 0; i < total; i++) {
			const size_t b = pass ? (size_t)by_row[i] : i;
			if (lsq->free_number[lsq->row[b]] != NO_INDEX && lsq->free_number[lsq->column[b]] != NO_INDEX)
				(pass ? order : by_row)[start[lsq->free_number[point[b]]]++] = (idx_t)b;
		}
	}
	/* after the fill start[v] is the end of column v */
	size_t entries = 9 * used;
	for (size_t i = 0; i < used; i++)
		entries -= lsq->row[order[i]] == lsq->column[order[i]] ? 3 : 0;
	lsq->matrix = cholmod_allocate_sparse(3 * n, 3 * n, entries, 1, 1, -1, CHOLMOD_REAL, &lsq->common);
	lsq->place = mem_array(9 * lsq->block_count, sizeof *lsq->place);
	for (size_t i = 0; i < 9 * lsq->block_count; i++)
		lsq->place[i] = SIZE_MAX;
	if (lsq->matrix) {
		int *column_start = lsq->matrix->p, *row = lsq->matrix->i;
		size_t entry = 0;
		for (size_t v = 0; v < n; v++)
			for (size_t c = 0; c < 3; c++) {
				column_start[3 * v + c] = (int)entry;
				for (size_t i = v ? start[v - 1] : 0; i < start[v]; i++) {
					const size_t b = (size_t)order[i], fi = (size_t)lsq->free_number[lsq->row[b]];
					for (size_t r = fi == v ? c : 0; r < 3; r++) {
						row[entry] = (int)(3 * fi + r);
						lsq->place[9 * b + 3 * r + c] = entry++;
					}
				}
			}
		column_start[3 * n] = (int)entry;
		lsq->factor = cholmod_analyze(lsq->matrix, &lsq->common);
	}
	free(order);
	free(by_row);
	free(start);
	lsq->analysed = lsq->block_count;
	return lsq->factor != NULL;
}

static bool solve_sparse(struct lsq *lsq, double *x)
{
	if ((lsq->factor == NULL || lsq->analysed != lsq->block_count) && !analyse(lsq))
		return false;
	double *value = lsq->matrix->x;
	for (size_t b = 0; b < lsq->block_count; b++) {
		subtract_fixed(x, lsq, lsq->row[b], lsq->column[b], lsq->block + 6 * b);
		for (size_t k = 0; k < 9; k++)
			if (lsq->place[9 * b + k] != SIZE_MAX)
				value[lsq->place[9 * b + k]] = lsq->block[6 * b + packed[k]];
	}
	lsq->common.status = CHOLMOD_OK;
	cholmod_factorize(lsq->matrix, lsq->factor, &lsq->common);
	if (lsq->common.status != CHOLMOD_OK || lsq->factor->minor < lsq->factor->n || !(cholmod_rcond(lsq->factor, &lsq->common) > least_rcond))
		return false;
	cholmod_dense right = {.nrow = 3 * lsq->free_count,
	                       .ncol = 1,
	                       .nzmax = 3 * lsq->free_count,
	                       .d = 3 * lsq->free_count,
	                       .x = x,
	                       .xtype = CHOLMOD_REAL,
	                       .dtype = CHOLMOD_DOUBLE};
	cholmod_dense *solution = cholmod_solve(CHOLMOD_A, lsq->factor, &right, &lsq->common);
	if (solution == NULL)
		return false;
	memcpy(x, solution->x, 3 * lsq->free_count * sizeof *x);
	cholmod_free_dense(&solution, &lsq->common);
	return true;
}

bool lsq_solve(struct lsq *lsq, double *xyz_out)
{
	double *x = mem_array(3 * lsq->free_count, sizeof *x);
	for (size_t i = 0; i < lsq->point_count; i++)
		if (lsq->free_number[i] != NO_INDEX)
			memcpy(x + 3 * lsq->free_number[i], lsq->right + 3 * i, 3 * sizeof *x);
	bool good = lsq->free_count == 0 || (is_well_filled(lsq) ? solve_dense(lsq, x) : solve_sparse(lsq, x));
	for (size_t i = 0; good && i < 3 * lsq->free_count; i++)
		good = isfinite(x[i]);
	for (size_t i = 0; good && i < lsq->point_count; i++) {
		const idx_t f = lsq->free_number[i];
		memmove(xyz_out + 3 * i, f == NO_INDEX ? lsq->xyz + 3 * i : x + 3 * f, 3 * sizeof *x);
	}
	free(x);
	return good;
}
