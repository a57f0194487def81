/* Step 3: faces that are nothing: a vertex twice, the same three vertices twice. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"
#include "stages/geometry/vector.h"

void soup_drop_collapsed(struct soup *soup)
{
	unsigned char *keep = mem_array(soup->triangle_count, 1);
	size_t dropped = 0;
	for (size_t t = 0; t < soup->triangle_count; t++) {
		const idx_t *c = soup->triangle + 3 * t;
		keep[t] = c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
		dropped += !keep[t];
	}
	soup_keep(soup, keep);
	soup->report->count[REPAIR_COLLAPSED_FACE] += dropped;
	free(keep);
}

/* A triangle by its vertices in rising order. */
struct triple {
	idx_t v[3], triangle;
	bool is_even; /* the order is reached by an even permutation: tells its orientation */
};

static int compare_triples(const void *left, const void *right)
{
	const struct triple *a = left, *b = right;
	for (int k = 0; k < 3; k++)
		if (a->v[k] != b->v[k])
			return a->v[k] < b->v[k] ? -1 : 1;
	return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

static struct triple triple_of(const idx_t *corner, size_t t)
{
	struct triple triple = {{corner[0], corner[1], corner[2]}, (idx_t)t, true};
	for (int i = 0; i < 3; i++) /* three exchanges of neighbours sort three values */
		for (int k = 0; k < 2; k++)
			if (triple.v[k] > triple.v[k + 1]) {
				const idx_t swap = triple.v[k];
				triple.v[k] = triple.v[k + 1];
				triple.v[k + 1] = swap;
				triple.is_even = !triple.is_even;
			}
	return triple;
}

/* Where a doubled sheet meets others at an edge: does material lie on both sides of it, and none between (two bodies touch
 * there), rather than between (a fin)? The neighbour at the next higher angle then has its inside towards the sheet, and so
 * has that at the next lower one. */
static bool is_contact(const struct soup *soup, const struct side *side, size_t count, const unsigned char *keep,
		       const idx_t *back)
{
	const double *low = soup->xyz + 3 * (size_t)side->low;
	double along[3], across[3] = {0}, third[3] = {0}, arm[3], least = INFINITY, most = -INFINITY;
	bool next_is_forward = false, last_is_forward = true;
	sub3(along, soup->xyz + 3 * (size_t)side->high, low);
	normalise3(along);
	for (int pass = 0; pass < 2; pass++) /* first the sheet, then what is around it */
		for (size_t k = 0; k < count; k++) {
			const size_t h = (size_t)side[k].half, t = h / 3;
			if (!keep[t] || (back[t] != NO_INDEX) != (pass == 0))
				continue;
			sub3(arm, soup->xyz + 3 * (size_t)soup->triangle[previous_half(h)], low);
			add_scaled3(arm, -dot3(arm, along), along);
			if (pass == 0) {
				copy3(across, arm);
				normalise3(across);
				cross3(third, along, across);
				continue;
			}
			const double turn = atan2(dot3(arm, third), dot3(arm, across)), angle = turn < 0 ? turn + 2 * PI : turn;
			const bool is_forward = soup->triangle[h] == side->low;
			if (angle < least) {
				least = angle;
				next_is_forward = is_forward;
			}
			if (angle > most) {
				most = angle;
				last_is_forward = is_forward;
			}
		}
	return next_is_forward && !last_is_forward;
}

/* Triangles that lie back to back: t and back[t]. Where bodies touch, both belong to them and both stay. A patch of them that
 * hangs on a surface which is whole without it (a fin of no thickness) goes altogether; one that closes a hole, or stands
 * alone, stays as one sheet. What most of the edges say where it meets others decides. */
static void sort_doubles(const struct soup *soup, unsigned char *keep, const idx_t *back)
{
	const size_t count = 3 * soup->triangle_count;
	struct side *side = soup_sides(soup);
	const bool oriented = soup_is_oriented(soup, side);
	idx_t *patch = new_roots(soup->triangle_count);
	struct votes {
		long fin, hole, contact, rim; /* rim: edges that nothing but the sheet has */
	} *votes = mem_array(soup->triangle_count, sizeof *votes);
	for (int pass = 0; pass < 2; pass++) /* first what belongs together, then what its edges say */
		for (size_t i = 0, end; i < count; i = end) {
			end = side_run(side, count, i);
			idx_t first = NO_INDEX;
			size_t others = 0, sheets = 0;
			for (size_t k = i; k < end; k++) {
				const idx_t t = side[k].half / 3;
				others += keep[t] && back[t] == NO_INDEX;
				if (!keep[t] || back[t] == NO_INDEX)
					continue;
				sheets++;
				if (first == NO_INDEX)
					first = t;
				else if (pass == 0)
					unite_roots(patch, first, t);
			}
			if (pass == 0 || first == NO_INDEX)
				continue;
			struct votes *const v = &votes[find_root(patch, first)];
			if (others == 0)
				v->rim += sheets == 1;
			else if (others % 2)
				v->hole++;
			else if (oriented && sheets == 1 && is_contact(soup, side + i, end - i, keep, back))
				v->contact++;
			else
				v->fin++;
		}
	for (size_t t = 0; t < soup->triangle_count; t++) {
		if (!keep[t] || back[t] == NO_INDEX)
			continue;
		const struct votes *v = &votes[find_root(patch, (idx_t)t)];
		if (v->contact > v->fin + v->hole + v->rim) {
			keep[back[t]] = 1;
			soup->report->count[REPAIR_DUPLICATE_FACE]--;
		} else if (v->fin > v->hole) {
			keep[t] = 0;
			soup->report->count[REPAIR_DUPLICATE_FACE]++;
		}
	}
	free(side), free(patch), free(votes);
}

void soup_drop_duplicates(struct soup *soup)
{
	const size_t count = soup->triangle_count;
	struct triple *triple = mem_array(count, sizeof *triple);
	unsigned char *keep = mem_array(count, 1);
	idx_t *back = mem_array(count, sizeof *back);
	memset(back, 0xff, count * sizeof *back);
	for (size_t t = 0; t < count; t++)
		triple[t] = triple_of(soup->triangle + 3 * t, t);
	qsort(triple, count, sizeof *triple, compare_triples);
	bool any = false, any_doubled = false;
	for (size_t i = 0, end; i < count; i = end) {
		size_t even = 0;
		for (end = i; end < count && memcmp(triple[end].v, triple[i].v, sizeof triple[i].v) == 0; end++)
			even += triple[end].is_even;
		/* The first one of the orientation that most have; of two that are equally many the first, and the first of the
		 * other. */
		const size_t odd = end - i - even;
		size_t kept = i, other = i;
		while (even != odd && triple[kept].is_even != (even > odd))
			kept++;
		keep[triple[kept].triangle] = 1;
		if (even == odd) {
			while (triple[other].is_even == triple[kept].is_even)
				other++;
			back[triple[kept].triangle] = triple[other].triangle;
			any_doubled = true;
		}
		soup->report->count[REPAIR_DUPLICATE_FACE] += end - i - 1;
		any = any || end - i > 1;
	}
	if (any_doubled)
		sort_doubles(soup, keep, back);
	if (any)
		soup_keep(soup, keep);
	free(triple), free(keep), free(back);
}
