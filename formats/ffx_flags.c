/* Coding of sharp edges, corners and patches, after the positions, which predict them. All angles in integers. */
#include <stdlib.h>
#include <string.h>

#include "formats/ffx_geometry.h"

#define FAN_LIMIT 64 /* half-edges around a vertex that are looked at for one flag */

enum { UNSEEN = 0, SMOOTH = 1, SHARP = 2 };

/* Is the angle between two vectors (each part below 2^18) at most that whose squared cosine is numerator / denominator? */
static bool is_within(const int64_t a[3], const int64_t b[3], int numerator, int denominator)
{
	const int64_t dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
	const int64_t aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2], bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
	return dot > 0 && (__int128)dot * dot * denominator >= (__int128)aa * bb * numerator;
}

/* Newell's normal of each face, brought below 2^15; 0 for degenerate faces. */
static int64_t *face_normals(const struct ffx_surface *surface, const int32_t *grid)
{
	int64_t *normal = mem_array(3 * surface->face_count, sizeof *normal);
	for (size_t f = 0; f < surface->face_count; f++) {
		int64_t sum[3] = {0};
		idx_t h = surface->first[f];
		const int32_t *foot = grid + 3 * (size_t)surface->origin[h];
		do {
			const int32_t *p = grid + 3 * (size_t)surface->origin[h], *q = grid + 3 * (size_t)surface_end(surface, h);
			for (int k = 0; k < 3; k++) {
				const int i = (k + 1) % 3, j = (k + 2) % 3;
				sum[k] += (int64_t)(p[i] - foot[i]) * (q[j] - foot[j]) -
					  (int64_t)(p[j] - foot[j]) * (q[i] - foot[i]);
			}
			h = surface->next[h];
		} while (h != surface->first[f]);
		while (llabs(sum[0]) > 32767 || llabs(sum[1]) > 32767 || llabs(sum[2]) > 32767)
			for (int k = 0; k < 3; k++)
				sum[k] /= 2;
		memcpy(normal + 3 * f, sum, sizeof sum);
	}
	return normal;
}

/* Below 2, 15, 40, 70 degrees, above, and degenerate. */
static unsigned dihedral_class(const int64_t *normal, const struct ffx_surface *surface, idx_t half)
{
	static const struct {
		int numerator, denominator; /* squared cosine */
	} limit[] = {{9988, 10000}, {9330, 10000}, {5868, 10000}, {1170, 10000}};
	const int64_t *a = normal + 3 * (size_t)surface->face[half], *b = normal + 3 * (size_t)surface->face[surface->twin[half]];
	if ((a[0] == 0 && a[1] == 0 && a[2] == 0) || (b[0] == 0 && b[1] == 0 && b[2] == 0))
		return 5;
	for (unsigned i = 0; i < 4; i++)
		if (is_within(a, b, limit[i].numerator, limit[i].denominator))
			return i;
	return 4;
}

static void direction(int64_t out[3], const struct ffx_surface *surface, const int32_t *grid, idx_t half)
{
	const int32_t *a = grid + 3 * (size_t)surface->origin[half], *b = grid + 3 * (size_t)surface_end(surface, half);
	for (int k = 0; k < 3; k++)
		out[k] = (int64_t)b[k] - a[k];
}

static unsigned least(size_t a, unsigned b)
{
	return a < b ? (unsigned)a : b;
}

struct flags {
	struct ffx_coder *coder;
	const struct ffx_surface *surface;
	const int32_t *grid;
	const int64_t *normal;
	unsigned char *state;           /* a half-edge */
	uint32_t *sharp_at, *unseen_at; /* a vertex */
	unsigned char *sharp_in;        /* a face: sharp edges so far, up to 2 */
	size_t edges, sharps;           /* coded so far */
};

/* What the end where half starts says: is there a sharp edge that half goes straight on from, and what is the topologically
 * opposite edge of a vertex with four? */
static void look_around(const struct flags *f, idx_t half, unsigned *straight, unsigned *opposite)
{
	const struct ffx_surface *s = f->surface;
	int64_t along[3], other[3];
	direction(along, s, f->grid, half);
	*straight = 0;
	*opposite = 3;
	int count = 1;
	for (idx_t h = surface_turn(s, half); h != half && count < FAN_LIMIT; h = surface_turn(s, h), count++) {
		if (f->state[h] == SHARP) {
			direction(other, s, f->grid, h);
			for (int k = 0; k < 3; k++)
				other[k] = -other[k];
			const bool is_straight = is_within(along, other, 3, 4); /* 30 degrees */
			*straight = is_straight ? 2 : *straight > 1 ? 2 : 1;
		}
		if (count == 2)
			*opposite = f->state[h];
	}
	if (count != 4)
		*opposite = 3;
}

static unsigned code_sharp(struct flags *f, idx_t half, unsigned is_sharp)
{
	const struct ffx_surface *s = f->surface;
	const idx_t twin = s->twin[half], a = s->origin[half], b = s->origin[twin];
	const unsigned d = dihedral_class(f->normal, s, half);
	unsigned straight_a, straight_b, opposite_a, opposite_b;
	look_around(f, half, &straight_a, &opposite_a);
	look_around(f, twin, &straight_b, &opposite_b);
	const unsigned sharp_a = least(f->sharp_at[a], 2), sharp_b = least(f->sharp_at[b], 2);
	const unsigned left_a = least(f->unseen_at[a] - 1, 2), left_b = least(f->unseen_at[b] - 1, 2);
	const idx_t left = s->face[half], right = s->face[twin];
	const unsigned in_left = f->sharp_in[left], in_right = f->sharp_in[right];
	const unsigned much = f->edges < 4 ? 0 : 4 * f->sharps < f->edges ? 1 : 2 * f->sharps < f->edges ? 2 : 3;
	const unsigned degrees = least((size_t)s->degree[left] - 3, 2) * 3 + least((size_t)s->degree[right] - 3, 2);
	/* On which side of the left face's plane the right face's next vertex lies: convex or concave. */
	const int64_t *n = f->normal + 3 * (size_t)left;
	const int32_t *p = f->grid + 3 * (size_t)a, *q = f->grid + 3 * (size_t)s->origin[s->previous[twin]];
	const unsigned is_concave = n[0] * (q[0] - p[0]) + n[1] * (q[1] - p[1]) + n[2] * (q[2] - p[2]) > 0;
	const unsigned input[SHARP_INPUTS] = {
		(((d * 3 + sharp_a) * 3 + left_a) * 3 + sharp_b) * 3 + left_b,
		(d * 4 + opposite_a) * 4 + opposite_b,
		((d * 3 + sharp_a) * 3 + left_a) * 3 + straight_a,
		d * 4 + much,
		(d * 3 + in_left) * 3 + in_right,
		(d * 2 + is_concave) * 9 + degrees,
		((d * 3 + straight_a) * 3 + straight_b) * 4 + much,
	};
	for (size_t i = 0; i < SHARP_INPUTS; i++)
		mix_context(f->coder, CONTEXT_SHARP + i * SHARP_SIZE + input[i], WEIGHT_SHARP + i * CONFIDENCE_CLASSES);
	is_sharp = mix_code(f->coder, is_sharp);
	f->state[half] = f->state[twin] = is_sharp ? SHARP : SMOOTH;
	f->unseen_at[a]--;
	f->unseen_at[b]--;
	f->edges++;
	if (is_sharp) {
		f->sharps++;
		f->sharp_at[a]++;
		f->sharp_at[b]++;
		f->sharp_in[left] = (unsigned char)least(f->sharp_in[left] + (size_t)1, 2);
		f->sharp_in[right] = (unsigned char)least(f->sharp_in[right] + (size_t)1, 2);
	}
	return is_sharp;
}

static bool is_border(const struct ffx_surface *surface, idx_t half)
{
	return surface->hole[surface->face[half]] || surface->hole[surface->face[surface->twin[half]]];
}

bool sharp_code(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const int32_t *grid,
		unsigned char *sharp, struct fault *fault)
{
	struct flags f = {.coder = coder, .surface = surface, .grid = grid};
	int64_t *normal = face_normals(surface, grid);
	f.normal = normal;
	f.state = mem_array(surface->half_count, 1);
	f.sharp_at = mem_array(surface->vertex_count, sizeof(uint32_t));
	f.unseen_at = mem_array(surface->vertex_count, sizeof(uint32_t));
	f.sharp_in = mem_array(surface->face_count, 1);
	for (size_t h = 0; h < surface->half_count; h++) {
		if (is_border(surface, (idx_t)h)) {
			f.state[h] = SHARP;
			f.sharp_at[surface->origin[h]]++;
		} else {
			f.unseen_at[surface->origin[h]]++;
		}
	}
	bool is_good = true;
	for (size_t i = 0; i < surface->vertex_count && is_good; i++) {
		const idx_t start = surface->outgoing[order[i]];
		idx_t h = start;
		do {
			if (f.state[h] == UNSEEN)
				sharp[h] = sharp[surface->twin[h]] = (unsigned char)code_sharp(&f, h, sharp[h]);
			else if (is_border(surface, h))
				sharp[h] = 0;
			h = surface_turn(surface, h);
		} while (h != start);
		if (coder->range.is_overrun)
			is_good = fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
	}
	free(normal);
	free(f.state);
	free(f.sharp_at);
	free(f.unseen_at);
	free(f.sharp_in);
	return is_good;
}

bool corner_code(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const int32_t *grid,
		 const unsigned char *sharp, unsigned char *corner, struct fault *fault)
{
	size_t seen = 0, corners = 0;
	for (size_t i = 0; i < surface->vertex_count; i++) {
		const idx_t v = order[i], start = surface->outgoing[v];
		idx_t crease[2] = {NO_INDEX, NO_INDEX};
		size_t count = 0, valence = 0;
		idx_t h = start;
		do {
			if (sharp[h] || is_border(surface, h)) {
				if (count < 2)
					crease[count] = h;
				count++;
			}
			valence++;
			h = surface_turn(surface, h);
		} while (h != start);
		if (count > 2) {
			corner[v] = 0;
			continue;
		}
		unsigned angle = 5; /* how much the crease turns: below 20, 40, 60, 80 degrees, more, no crease */
		if (count == 2) {
			static const int cosine2[4] = {8830, 5868, 2500, 302}; /* squared, in 1/10000 */
			int64_t in[3], out[3];
			direction(in, surface, grid, surface->twin[crease[0]]);
			direction(out, surface, grid, crease[1]);
			for (angle = 0; angle < 4 && !is_within(in, out, cosine2[angle], 10000); angle++)
				;
		}
		const unsigned much = seen < 8 ? 0 : corners == 0 ? 1 : 8 * corners < seen ? 2 : 3;
		const unsigned input[CORNER_INPUTS] = {
			angle * 4 + much,
			angle * 4 + least(valence - 2, 3),
			(unsigned)count * 4 + much,
		};
		for (size_t j = 0; j < CORNER_INPUTS; j++)
			mix_context(coder, CONTEXT_CORNER + j * CORNER_SIZE + input[j], WEIGHT_CORNER + j * CONFIDENCE_CLASSES);
		corner[v] = (unsigned char)mix_code(coder, corner[v]);
		seen++;
		corners += corner[v];
		if (coder->range.is_overrun)
			return fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
	}
	return true;
}

static int compare_indices(const void *left, const void *right)
{
	const idx_t a = *(const idx_t *)left, b = *(const idx_t *)right;
	return a < b ? -1 : a > b;
}

/* Number arbitrary patch ids by first appearance. */
static void number_patches(idx_t *patch, const struct ffx_surface *surface)
{
	idx_t *id = mem_array(surface->face_count, sizeof *id), *number = mem_array(surface->face_count, sizeof *number);
	size_t count = 0, unique = 0;
	for (size_t f = 0; f < surface->face_count; f++)
		if (!surface->hole[f])
			id[count++] = patch[f];
	qsort(id, count, sizeof *id, compare_indices);
	for (size_t i = 0; i < count; i++)
		if (i == 0 || id[i] != id[unique - 1])
			id[unique++] = id[i];
	for (size_t i = 0; i < unique; i++)
		number[i] = NO_INDEX;
	idx_t fresh = 0;
	for (size_t f = 0; f < surface->face_count; f++) {
		if (surface->hole[f])
			continue;
		const idx_t *found = bsearch(&patch[f], id, unique, sizeof *id, compare_indices);
		idx_t *to = number + (found - id);
		if (*to == NO_INDEX)
			*to = fresh++;
		patch[f] = *to;
	}
	free(id);
	free(number);
}

bool patch_code(struct ffx_coder *coder, const struct ffx_surface *surface, const int32_t *grid, const unsigned char *sharp,
		idx_t *patch, struct fault *fault)
{
	if (!coder->range.is_decoding)
		number_patches(patch, surface);
	int64_t *normal = face_normals(surface, grid);
	idx_t patches = 0;
	bool is_good = true;
	for (size_t f = 0; f < surface->face_count && is_good; f++) {
		if (surface->hole[f])
			continue;
		/* Is it that of a neighbour? Asked once for each, in the order around the face; smooth edges are likely inside a
		 * patch. */
		idx_t asked[8];
		int asked_count = 0;
		bool is_known = false;
		idx_t h = surface->first[f];
		do {
			const size_t g = (size_t)surface->face[surface->twin[h]];
			bool is_new = g < f && !surface->hole[g] && asked_count < 8;
			for (int i = 0; i < asked_count && is_new; i++)
				is_new = asked[i] != patch[g];
			if (is_new) {
				const unsigned context = (sharp[h]          ? 0
							  : asked_count > 0 ? 2
									    : 1) *
								 DIHEDRAL_CLASSES +
							 dihedral_class(normal, surface, h);
				is_known = model_bit(coder, CONTEXT_PATCH + context, patch[f] == patch[g]);
				if (is_known)
					patch[f] = patch[g];
				asked[asked_count++] = patch[g];
			}
			h = surface->next[h];
		} while (h != surface->first[f] && !is_known);
		if (!is_known)
			patch[f] = (idx_t)model_uniform(coder, (uint32_t)patches + 1, (uint32_t)patch[f]);
		if (patch[f] == patches)
			patches++;
		if (coder->range.is_overrun)
			is_good = fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
	}
	free(normal);
	return is_good;
}
