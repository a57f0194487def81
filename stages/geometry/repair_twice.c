/* Step 3: faces that are nothing: a vertex twice, the same three vertices twice. */
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"

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

/* Triangles that lie back to back in equal numbers bound nothing. A patch of them that hangs on a surface which is
 * whole without it (a fin of no thickness) goes altogether; one that closes a hole, or stands alone, stays as one sheet. What
 * most of the edges say where it meets others decides.
 * doubled: 1 for the triangle that is kept of such a group. */
static void drop_fins(const struct soup *soup, unsigned char *keep, const unsigned char *doubled, struct repair_report *report)
{
	const size_t count = 3 * soup->triangle_count;
	struct side *side = soup_sides(soup);
	idx_t *patch = new_roots(soup->triangle_count);
	long *hangs = mem_array(soup->triangle_count, sizeof *hangs); /* a patch: edges with whole surface less those without */
	for (int pass = 0; pass < 2; pass++) /* first what belongs together, then how each patch is used */
		for (size_t i = 0, end; i < count; i = end) {
			end = side_run(side, count, i);
			idx_t first = NO_INDEX;
			size_t others = 0;
			for (size_t k = i; k < end; k++) {
				const idx_t t = side[k].half / 3;
				others += keep[t] && !doubled[t];
				if (!keep[t] || !doubled[t])
					continue;
				if (first == NO_INDEX)
					first = t;
				else if (pass == 0)
					unite_roots(patch, first, t);
			}
			if (pass == 1 && first != NO_INDEX && others > 0)
				hangs[find_root(patch, first)] += others % 2 ? -1 : 1;
		}
	for (size_t t = 0; t < soup->triangle_count; t++)
		if (keep[t] && doubled[t] && hangs[find_root(patch, (idx_t)t)] > 0) {
			keep[t] = 0;
			report->count[REPAIR_DUPLICATE_FACE]++;
		}
	free(side), free(patch), free(hangs);
}

void soup_drop_duplicates(struct soup *soup)
{
	const size_t count = soup->triangle_count;
	struct triple *triple = mem_array(count, sizeof *triple);
	unsigned char *keep = mem_array(count, 1), *doubled = mem_array(count, 1);
	for (size_t t = 0; t < count; t++)
		triple[t] = triple_of(soup->triangle + 3 * t, t);
	qsort(triple, count, sizeof *triple, compare_triples);
	bool any = false, any_doubled = false;
	for (size_t i = 0, end; i < count; i = end) {
		size_t even = 0;
		for (end = i; end < count && memcmp(triple[end].v, triple[i].v, sizeof triple[i].v) == 0; end++)
			even += triple[end].is_even;
		/* The first one of the orientation that most have. */
		const size_t odd = end - i - even;
		size_t kept = i;
		while (even != odd && triple[kept].is_even != (even > odd))
			kept++;
		keep[triple[kept].triangle] = 1;
		doubled[triple[kept].triangle] = even == odd;
		soup->report->count[REPAIR_DUPLICATE_FACE] += end - i - 1;
		any = any || end - i > 1;
		any_doubled = any_doubled || even == odd;
	}
	if (any_doubled)
		drop_fins(soup, keep, doubled, soup->report);
	if (any)
		soup_keep(soup, keep);
	free(triple), free(keep), free(doubled);
}
