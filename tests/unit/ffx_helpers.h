/* What the tests of the packed stream share: cages put on grids, and comparing two of them. */
#ifndef CAGEWRIGHT_TESTS_FFX_HELPERS_H
#define CAGEWRIGHT_TESTS_FFX_HELPERS_H

#include "tests/unit/helpers.h"

#include <time.h>

#include "formats/ffx.h"
#include "tests/fixtures/samplecages.h"

/* Borrowed arrays of the cage, and a grid of its own: put vertex v at a place that no other vertex has. */
static inline struct ffx ffx_of(const struct cage *cage, unsigned code)
{
	return (struct ffx){.scheme = cage->scheme,
			    .grid_code = code,
			    .vertex_count = cage->vertex_count,
			    .grid = mem_array(3 * cage->vertex_count, sizeof(int32_t)),
			    .face_corner = cage->face_corner,
			    .face_start = cage->face_start,
			    .face_count = cage->face_count,
			    .sharp = cage->sharp,
			    .sharp_count = cage->sharp_count,
			    .corner = cage->corner};
}

/* Distinct random places for up to 6400 vertices; v's own number is in the first two coordinates. */
static inline struct ffx ffx_scattered(const struct cage *cage)
{
	struct ffx ffx = ffx_of(cage, ffx_grid_code(4095));
	for (size_t v = 0; v < cage->vertex_count; v++) {
		ffx.grid[3 * v] = (int32_t)(v % 64 * 64 + sample_random(64));
		ffx.grid[3 * v + 1] = (int32_t)(v / 64 * 40 + sample_random(40));
		ffx.grid[3 * v + 2] = (int32_t)sample_random(4096);
	}
	return ffx;
}

/* The cage's own places, rounded; lowest corner at 0. */
static inline struct ffx ffx_rounded(const struct cage *cage, unsigned code)
{
	struct ffx ffx = ffx_of(cage, code);
	double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, side = 0;
	for (size_t i = 0; i < 3 * cage->vertex_count; i++)
		low[i % 3] = fmin(low[i % 3], cage->xyz[i]);
	for (size_t i = 0; i < 3 * cage->vertex_count; i++)
		side = fmax(side, cage->xyz[i] - low[i % 3]);
	for (size_t i = 0; i < 3 * cage->vertex_count; i++)
		ffx.grid[i] = (int32_t)lround((cage->xyz[i] - low[i % 3]) / side * ffx_grid_steps(code));
	return ffx;
}

/* --- comparing: everything by places, in sorted order --- */

static inline int compare_triples(const void *left, const void *right)
{
	return memcmp(left, right, 3 * sizeof(int32_t));
}

static inline int compare_bytes_12(const void *left, const void *right)
{
	return memcmp(left, right, 12);
}

/* The rank of each vertex among the sorted places. */
static inline idx_t *place_ranks(const struct ffx *ffx)
{
	int32_t *sorted = mem_copy(ffx->grid, ffx->vertex_count, 3 * sizeof(int32_t));
	qsort(sorted, ffx->vertex_count, 3 * sizeof(int32_t), compare_triples);
	idx_t *rank = mem_array(ffx->vertex_count, sizeof *rank);
	for (size_t v = 0; v < ffx->vertex_count; v++) {
		const int32_t *found =
			bsearch(ffx->grid + 3 * v, sorted, ffx->vertex_count, 3 * sizeof(int32_t), compare_triples);
		rank[v] = (idx_t)((found - sorted) / 3);
	}
	free(sorted);
	return rank;
}

/* Three numbers for each half-edge: the two ranks along it and the lowest rank of its face: equal multisets of these mean equal
 * faces, as long as no two vertices share a place. Then, sorted, the sharp edges; then corner flags by rank. */
static inline int32_t *signature(const struct ffx *ffx, size_t *count, const unsigned char *corner)
{
	idx_t *rank = place_ranks(ffx);
	const size_t corners = ffx->face_start[ffx->face_count];
	int32_t *out = mem_array(3 * (corners + ffx->sharp_count + ffx->vertex_count), sizeof *out), *at = out;
	for (size_t f = 0; f < ffx->face_count; f++) {
		const size_t n = ffx->face_start[f + 1] - ffx->face_start[f];
		const idx_t *c = ffx->face_corner + ffx->face_start[f];
		int32_t low = INT32_MAX;
		for (size_t i = 0; i < n; i++)
			low = rank[c[i]] < low ? rank[c[i]] : low;
		for (size_t i = 0; i < n; i++, at += 3)
			at[0] = rank[c[i]], at[1] = rank[c[(i + 1) % n]], at[2] = low;
	}
	qsort(out, corners, 12, compare_bytes_12);
	int32_t *sharp = at;
	for (size_t i = 0; i < ffx->sharp_count; i++, at += 3) {
		const idx_t a = rank[ffx->sharp[2 * i]], b = rank[ffx->sharp[2 * i + 1]];
		at[0] = a < b ? a : b, at[1] = a < b ? b : a, at[2] = 0;
	}
	qsort(sharp, ffx->sharp_count, 12, compare_bytes_12);
	for (size_t v = 0; v < ffx->vertex_count; v++)
		at[3 * rank[v]] = corner[v];
	*count = (size_t)(at - out) + 3 * ffx->vertex_count;
	free(rank);
	return out;
}

/* Corner flags that mean something: vertices with fewer than three sharp or border edges. O(corners log corners). */
static inline unsigned char *meaningful_corners(const struct ffx *ffx)
{
	const size_t corners = ffx->face_start[ffx->face_count];
	idx_t *edge = mem_array(3 * corners, sizeof *edge);
	size_t *crease = mem_array(ffx->vertex_count, sizeof *crease);
	for (size_t f = 0, h = 0; f < ffx->face_count; f++)
		for (; h < ffx->face_start[f + 1]; h++) {
			const idx_t a = ffx->face_corner[h],
				    b = ffx->face_corner[h + 1 < ffx->face_start[f + 1] ? h + 1 : ffx->face_start[f]];
			edge[3 * h] = a < b ? a : b, edge[3 * h + 1] = a < b ? b : a;
		}
	qsort(edge, corners, 12, compare_bytes_12);
	for (size_t h = 0; h < corners; h++) {
		const bool has_next = h + 1 < corners && memcmp(edge + 3 * h, edge + 3 * h + 3, 12) == 0;
		if (!has_next) { /* only one face */
			crease[edge[3 * h]]++;
			crease[edge[3 * h + 1]]++;
		}
		h += has_next;
	}
	for (size_t i = 0; i < 2 * ffx->sharp_count; i++)
		crease[ffx->sharp[i]]++;
	unsigned char *corner = mem_array(ffx->vertex_count, 1);
	for (size_t v = 0; v < ffx->vertex_count; v++)
		corner[v] = ffx->corner[v] && crease[v] < 3;
	free(edge);
	free(crease);
	return corner;
}

static inline void assert_same_cage(const struct ffx *in, const struct ffx *out)
{
	assert_int_equal(in->vertex_count, out->vertex_count);
	assert_int_equal(in->face_count, out->face_count);
	assert_int_equal(in->sharp_count, out->sharp_count);
	assert_int_equal(in->scheme, out->scheme);
	assert_int_equal(in->grid_code, out->grid_code);
	assert_int_equal(in->has_frame, out->has_frame);
	if (in->has_frame)
		assert_memory_equal(&in->frame, &out->frame, sizeof in->frame);
	size_t in_count, out_count;
	unsigned char *corner = meaningful_corners(in);
	int32_t *a = signature(in, &in_count, corner), *b = signature(out, &out_count, out->corner);
	assert_int_equal(in_count, out_count);
	assert_memory_equal(a, b, in_count * sizeof *a);
	free(corner);
	free(a);
	free(b);
}

/* Encode, decode, compare. Returns the stream (caller frees). */
static inline unsigned char *round_trip(const struct ffx *ffx, size_t *size, struct ffx_report *report, size_t roots)
{
	unsigned char *bytes;
	struct fault fault = {0};
	const struct ffx_options options = {.root_limit = roots};
	if (!ffx_encode(&bytes, size, report, ffx, &options, &fault))
		fail_msg("not encoded: %s", fault.text);
	struct ffx out;
	if (!ffx_decode(&out, bytes, *size, "t.ffx", &fault))
		fail_msg("not decoded: %s", fault.text);
	assert_same_cage(ffx, &out);
	ffx_free(&out);
	return bytes;
}

/* Bring the checksum at the end in line with the rest, so that damage reaches the decoder: the same sums as ffx(5) describes,
 * written again here. */
static inline void seal(unsigned char *bytes, size_t size)
{
	const size_t sum_size = size <= 1024 ? 2 : 4;
	if (size < sum_size)
		return;
	const uint32_t polynomial = sum_size == 2 ? 0x8408u : 0xedb88320u, all = sum_size == 2 ? 0xffffu : 0xffffffffu;
	uint32_t crc = all;
	for (size_t i = 0; i < size - sum_size; i++) {
		crc ^= bytes[i];
		for (int k = 0; k < 8; k++)
			crc = crc >> 1 ^ (crc & 1 ? polynomial : 0);
	}
	crc ^= all;
	for (size_t i = 0; i < sum_size; i++)
		bytes[size - sum_size + i] = (unsigned char)(crc >> 8 * i);
}

/* One of all kinds of meshes; false for an empty one. Some touch themselves along an edge or at a vertex: the encoder refuses
 * those. */
static inline bool any_random_mesh(struct cage *cage, uint64_t seed)
{
	sample_seed(seed);
	switch (sample_random(6)) {
	case 0:
		*cage = sample_torus(3 + (int)sample_random(5), 3 + (int)sample_random(5));
		break;
	case 1:
		*cage = sample_plate(1 + (int)sample_random(3), 1 + (int)sample_random(2), 0.3, 0.5);
		break;
	case 2:
		*cage = sample_blocks(1 + (int)sample_random(3), 1 + (int)sample_random(3), 1 + (int)sample_random(2), 0.7);
		break;
	case 3:
		*cage = sample_random_turned();
		break;
	case 4:
		*cage = sample_extruded();
		break;
	default:
		*cage = sample_blocks(2 + (int)sample_random(2), 2 + (int)sample_random(2), 2, 0.85);
		break;
	}
	if (cage->face_count == 0) {
		cage_free(cage);
		return false;
	}
	const uint32_t faces = (uint32_t)cage->face_count;
	sample_remesh(cage, sample_random(faces + 1), sample_random(faces + 1));
	if (sample_chance(0.3)) { /* holes */
		bool *drop = mem_array(cage->face_count + 1, sizeof *drop);
		for (uint32_t i = 1 + sample_random(3); i > 0 && cage->face_count > 4; i--)
			drop[sample_random((uint32_t)cage->face_count)] = true;
		sample_drop_faces(cage, drop);
		free(drop);
	}
	return cage->face_count > 0;
}

#endif
