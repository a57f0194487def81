/* Limit masks are left eigenvectors of the matrix that maps a ring to the same ring one level finer: eigenvalue 1 gives the
 * limit position, the next two the tangent plane. Pure patterns have them in closed form; mixed ones and darts go through power
 * iteration on the transpose, once a pattern. */
#include "stages/geometry/subdivide_ring.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/subdivide_mask.h"
#include "stages/geometry/vector.h"

/* The second eigenvalue is below 0.66 for all valences (it tends to (3 + sqrt 5) / 8 for quads, 5/8 for triangles; darts 1/2
 * and more): 90 steps leave 1e-16. Tangents converge with the ratio of third to fourth eigenvalue, which grows with valence. */
enum { LIMIT_STEPS = 120, TANGENT_STEPS = 400, ROTATED_VALENCE = 64 };

void ring_free(struct ring *ring)
{
	free(ring->neighbour);
	free(ring->opposite);
	memset(ring, 0, sizeof *ring);
}

/* Does the pattern read lower from place a than from place b? */
static bool reads_lower(const struct ring *ring, size_t a, size_t b)
{
	for (size_t k = 0; k < ring->valence; k++) {
		const bool x = ring->opposite[(a + k) % ring->valence] != NO_INDEX, y = ring->opposite[(b + k) % ring->valence] != NO_INDEX;
		if (x != y)
			return y;
	}
	return false;
}

static void reverse(idx_t *array, size_t begin, size_t end)
{
	for (; begin + 1 < end; begin++, end--) {
		const idx_t t = array[begin];
		array[begin] = array[end - 1];
		array[end - 1] = t;
	}
}

/* array[0] := array[first], cyclically */
static void rotate_left(idx_t *array, size_t count, size_t first)
{
	reverse(array, 0, first);
	reverse(array, first, count);
	reverse(array, 0, count);
}

void ring_collect(struct ring *ring, const struct level *level, const struct topology *topology, size_t h)
{
	const size_t valence = (size_t)topology->valence[level->face_corner[h]];
	if (valence > ring->room) {
		ring->room = 2 * valence;
		ring->neighbour = mem_resize(ring->neighbour, ring->room, sizeof *ring->neighbour);
		ring->opposite = mem_resize(ring->opposite, ring->room, sizeof *ring->opposite);
	}
	ring->valence = valence;
	ring->quads = 0;
	ring->sharp = NO_INDEX;
	for (size_t j = 0; j < valence; j++) {
		const size_t next = corner_next(level, topology, h), previous = corner_previous(level, topology, h);
		const size_t across = corner_next(level, topology, next);
		ring->neighbour[j] = level->face_corner[next];
		ring->opposite[j] = across == previous ? NO_INDEX : level->face_corner[across];
		ring->quads += across != previous;
		if (topology->crease[topology->edge[h]])
			ring->sharp = (idx_t)j;
		h = (size_t)corner_twin(topology, previous);
	}
	size_t first = 0;
	if (ring->sharp != NO_INDEX)
		first = (size_t)ring->sharp;
	else if (ring->quads > 0 && ring->quads < valence && valence <= ROTATED_VALENCE)
		for (size_t j = 1; j < valence; j++)
			if (reads_lower(ring, j, first))
				first = j;
	rotate_left(ring->neighbour, valence, first);
	rotate_left(ring->opposite, valence, first);
	if (ring->sharp != NO_INDEX)
		ring->sharp = 0;
}

/* --- masks by pattern --------------------------------------------------------------------------------------------- */

enum { QUAD = 1, SHARP = 2 };

/* Entries of the ring matrix, rows = new ring. */
struct entry {
	idx_t row, column;
	double weight;
};
struct matrix {
	struct entry *entry;
	size_t count, size;
};

static void put(struct matrix *m, size_t row, size_t column, double weight)
{
	m->entry[m->count++] = (struct entry){(idx_t)row, (idx_t)column, weight};
}

/* weight times what face j gives: its centre, for quads only. */
static void put_centre(struct matrix *m, size_t row, size_t n, size_t j, double weight)
{
	put(m, row, 0, weight / 4);
	put(m, row, 1 + j, weight / 4);
	put(m, row, 1 + n + j, weight / 4);
	put(m, row, 1 + (j + 1) % n, weight / 4);
}

/* The matrix of one step, from the same rules as the refiner (see triangle_sums and quad_sums there). */
static void ring_matrix(struct matrix *m, const unsigned char *pattern, size_t n)
{
	size_t quads = 0;
	for (size_t j = 0; j < n; j++)
		quads += pattern[j] & QUAD;
	m->size = 1 + 2 * n;
	m->count = 0;
	/* all quads: 5 entries a face in the first row, 12 in the row of an edge, 4 in that of a centre */
	m->entry = mem_array(1 + 21 * n, sizeof *m->entry);
	const struct step_mask mask = step_mask_smooth(n, quads);
	put(m, 0, 0, 1 - mask.beta * mask.count);
	for (size_t j = 0; j < n; j++) {
		put(m, 0, 1 + j, mask.beta);
		if (pattern[j] & QUAD)
			put_centre(m, 0, n, j, mask.beta);
	}
	for (size_t j = 0; j < n; j++) {
		const size_t row = 1 + j, before = (j + n - 1) % n;
		if (pattern[j] & SHARP) {
			put(m, row, 0, 1.0 / 2);
			put(m, row, row, 1.0 / 2);
		} else {
			for (int side = 0; side < 2; side++) {
				const size_t face = side ? before : j, third = 1 + (side ? before : (j + 1) % n);
				const bool is_quad = pattern[face] & QUAD;
				put(m, row, 0, is_quad ? 1.0 / 8 : 3.0 / 16);
				put(m, row, row, is_quad ? 1.0 / 8 : 3.0 / 16);
				if (is_quad)
					put_centre(m, row, n, face, 1.0 / 4);
				else
					put(m, row, third, 1.0 / 8);
			}
		}
		if (pattern[j] & QUAD)
			put_centre(m, 1 + n + j, n, j, 1);
	}
}

/* out = M^T in */
static void transposed(double *out, const struct matrix *m, const double *in)
{
	memset(out, 0, m->size * sizeof *out);
	for (size_t k = 0; k < m->count; k++)
		out[m->entry[k].column] += m->entry[k].weight * in[m->entry[k].row];
}

static double sum_of(const double *a, size_t count)
{
	double sum = 0;
	for (size_t i = 0; i < count; i++)
		sum += a[i];
	return sum;
}

static double product(const double *a, const double *b, size_t count)
{
	double sum = 0;
	for (size_t i = 0; i < count; i++)
		sum += a[i] * b[i];
	return sum;
}

static void limit_by_iteration(double *limit, const struct matrix *m)
{
	double *next = mem_array(m->size, sizeof *next);
	memset(limit, 0, m->size * sizeof *limit);
	limit[0] = 1;
	for (int step = 0; step < LIMIT_STEPS; step++) {
		transposed(next, m, limit);
		const double sum = sum_of(next, m->size); /* 1 but for rounding */
		double change = 0;
		for (size_t i = 0; i < m->size; i++) {
			change = fmax(change, fabs(next[i] / sum - limit[i]));
			limit[i] = next[i] / sum;
		}
		if (change < 1e-17)
			break;
	}
	free(next);
}

/* t := t without the parts along limit (its dual is the vector of ones) and along other (orthonormal), of length 1 */
static void orthonormal(double *t, const double *limit, const double *other, size_t size)
{
	const double sum = sum_of(t, size);
	for (size_t i = 0; i < size; i++)
		t[i] -= sum * limit[i];
	if (other) {
		const double p = product(t, other, size);
		for (size_t i = 0; i < size; i++)
			t[i] -= p * other[i];
	}
	const double length = sqrt(product(t, t, size));
	for (size_t i = 0; length > 0 && i < size; i++)
		t[i] /= length;
}

/* The plane of the two largest eigenvalues below 1, by iteration on two vectors at once. */
static void tangents_by_iteration(struct ring_mask *mask, const struct matrix *m)
{
	double *next = mem_array(m->size, sizeof *next);
	for (int step = 0; step < TANGENT_STEPS; step++) {
		transposed(next, m, mask->tangent1);
		memcpy(mask->tangent1, next, m->size * sizeof *next);
		orthonormal(mask->tangent1, mask->limit, NULL, m->size);
		transposed(next, m, mask->tangent2);
		memcpy(mask->tangent2, next, m->size * sizeof *next);
		orthonormal(mask->tangent2, mask->limit, mask->tangent1, m->size);
	}
	free(next);
}

/* The regular planar ring, to start the iteration and to tell on which side the tangents' cross product points. */
static void planar_ring(double *x, double *y, const unsigned char *pattern, size_t n)
{
	x[0] = y[0] = 0;
	for (size_t j = 0; j < n; j++) {
		const double here = 2 * PI * (double)j / (double)n, between = here + PI / (double)n;
		x[1 + j] = cos(here);
		y[1 + j] = sin(here);
		x[1 + n + j] = pattern[j] & QUAD ? cos(between) * 1.4 : 0;
		y[1 + n + j] = pattern[j] & QUAD ? sin(between) * 1.4 : 0;
	}
}

/* Closed forms for n quads: limit (n^2 : 4 : 1), tangents of Halstead, Kass, DeRose 1993. */
static void quad_masks(struct ring_mask *mask, size_t valence)
{
	const double n = (double)valence, c = cos(2 * PI / n);
	const double edge = 1 + c + cos(PI / n) * sqrt(2 * (9 + c));
	mask->limit[0] = n / (n + 5);
	for (size_t j = 0; j < valence; j++) {
		mask->limit[1 + j] = 4 / (n * (n + 5));
		mask->limit[1 + valence + j] = 1 / (n * (n + 5));
		const double here = 2 * PI * (double)j / n, next = 2 * PI * (double)(j + 1) / n;
		mask->tangent1[1 + j] = edge * cos(here);
		mask->tangent2[1 + j] = edge * sin(here);
		mask->tangent1[1 + valence + j] = cos(here) + cos(next);
		mask->tangent2[1 + valence + j] = sin(here) + sin(next);
	}
}

/* Closed forms for n triangles (Loop 1987). */
static void triangle_masks(struct ring_mask *mask, size_t valence)
{
	const double n = (double)valence, g = 3.0 / 8 + cos(2 * PI / n) / 4;
	const double chi = 1 / (3 * n / (8 * (5.0 / 8 - g * g)) + n);
	mask->limit[0] = 1 - n * chi;
	for (size_t j = 0; j < valence; j++) {
		mask->limit[1 + j] = chi;
		mask->tangent1[1 + j] = cos(2 * PI * (double)j / n);
		mask->tangent2[1 + j] = sin(2 * PI * (double)j / n);
	}
}

static void mixed_limit(struct ring_mask *mask)
{
	struct matrix m;
	ring_matrix(&m, mask->pattern, mask->valence);
	limit_by_iteration(mask->limit, &m);
	free(m.entry);
}

static void mixed_tangents(struct ring_mask *mask)
{
	const size_t n = mask->valence;
	struct matrix m;
	ring_matrix(&m, mask->pattern, n);
	double *x = mem_array(m.size, sizeof *x), *y = mem_array(m.size, sizeof *y);
	planar_ring(x, y, mask->pattern, n);
	memcpy(mask->tangent1, x, m.size * sizeof *x);
	memcpy(mask->tangent2, y, m.size * sizeof *y);
	tangents_by_iteration(mask, &m);
	const double turn = product(mask->tangent1, x, m.size) * product(mask->tangent2, y, m.size) -
	                    product(mask->tangent1, y, m.size) * product(mask->tangent2, x, m.size);
	for (size_t i = 0; turn < 0 && i < m.size; i++)
		mask->tangent2[i] = -mask->tangent2[i];
	free(x);
	free(y);
	free(m.entry);
	mask->has_tangents = true;
}

static struct ring_mask mask_new(const unsigned char *pattern, size_t valence)
{
	const size_t size = 1 + 2 * valence;
	struct ring_mask mask = {.valence = valence, .has_tangents = true};
	mask.pattern = mem_copy(pattern, valence, 1);
	mask.limit = mem_array(size, sizeof(double));
	mask.tangent1 = mem_array(size, sizeof(double));
	mask.tangent2 = mem_array(size, sizeof(double));
	size_t quads = 0, sharp = 0;
	for (size_t j = 0; j < valence; j++) {
		quads += pattern[j] & QUAD;
		sharp += (pattern[j] & SHARP) != 0;
	}
	if (sharp == 0 && quads == valence)
		quad_masks(&mask, valence);
	else if (sharp == 0 && quads == 0)
		triangle_masks(&mask, valence);
	else {
		mixed_limit(&mask);
		mask.has_tangents = false;
	}
	return mask;
}

void ring_cache_free(struct ring_cache *cache)
{
	for (size_t i = 0; i < cache->count; i++) {
		free(cache->mask[i].limit);
		free(cache->mask[i].tangent1);
		free(cache->mask[i].tangent2);
		free(cache->mask[i].pattern);
	}
	free(cache->mask);
	free(cache->slot);
	free(cache->pattern);
	memset(cache, 0, sizeof *cache);
}

/* FNV-1a */
static size_t pattern_hash(const unsigned char *pattern, size_t count)
{
	uint32_t hash = 2166136261u;
	for (size_t i = 0; i < count; i++)
		hash = (hash ^ pattern[i]) * 16777619u;
	return hash;
}

static size_t pattern_slot(const struct ring_cache *cache, const unsigned char *pattern, size_t valence)
{
	size_t s = pattern_hash(pattern, valence) & (cache->slot_count - 1);
	for (; cache->slot[s]; s = (s + 1) & (cache->slot_count - 1)) {
		const struct ring_mask *mask = cache->mask + cache->slot[s] - 1;
		if (mask->valence == valence && memcmp(mask->pattern, pattern, valence) == 0)
			break;
	}
	return s;
}

static struct ring_mask *find_mask(struct ring_cache *cache, const struct ring *ring)
{
	if (ring->valence > cache->pattern_room) {
		cache->pattern_room = 2 * ring->valence;
		cache->pattern = mem_resize(cache->pattern, cache->pattern_room, 1);
	}
	for (size_t j = 0; j < ring->valence; j++)
		cache->pattern[j] = (unsigned char)((ring->opposite[j] != NO_INDEX ? QUAD : 0) | (ring->sharp == (idx_t)j ? SHARP : 0));
	if (2 * (cache->count + 1) > cache->slot_count) {
		cache->slot_count = cache->slot_count ? 2 * cache->slot_count : 64;
		free(cache->slot);
		cache->slot = mem_array(cache->slot_count, sizeof *cache->slot);
		for (size_t i = 0; i < cache->count; i++)
			cache->slot[pattern_slot(cache, cache->mask[i].pattern, cache->mask[i].valence)] = (idx_t)i + 1;
	}
	const size_t s = pattern_slot(cache, cache->pattern, ring->valence);
	if (cache->slot[s])
		return cache->mask + cache->slot[s] - 1;
	if (cache->count == cache->room) {
		cache->room = cache->room ? 2 * cache->room : 16;
		cache->mask = mem_resize(cache->mask, cache->room, sizeof *cache->mask);
	}
	cache->mask[cache->count] = mask_new(cache->pattern, ring->valence);
	cache->slot[s] = (idx_t)++cache->count;
	return cache->mask + cache->count - 1;
}

const struct ring_mask *ring_mask(struct ring_cache *cache, const struct ring *ring, bool with_tangents)
{
	struct ring_mask *mask = find_mask(cache, ring);
	if (with_tangents && !mask->has_tangents)
		mixed_tangents(mask);
	return mask;
}
