/* A partition of the triangles: bookkeeping. */
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/segment/regions.h"

void regions_init(struct regions *r, const struct facets *facets)
{
	*r = (struct regions){.facets = facets, .label = mem_array(facets->triangle_count, sizeof *r->label)};
	for (size_t t = 0; t < facets->triangle_count; t++)
		r->label[t] = NO_INDEX;
}

void regions_free(struct regions *r)
{
	free(r->label);
	free(r->patch);
	*r = (struct regions){0};
}

idx_t regions_add(struct regions *r, const struct dense_patch *patch)
{
	if (r->count == r->capacity) {
		r->capacity = r->capacity ? 2 * r->capacity : 64;
		r->patch = mem_resize(r->patch, r->capacity, sizeof *r->patch);
	}
	r->patch[r->count] = *patch;
	return (idx_t)r->count++;
}

void regions_members(const struct regions *r, size_t **start, idx_t **member)
{
	const size_t n = r->facets->triangle_count;
	*start = mem_array(r->count + 2, sizeof **start);
	*member = mem_array(n, sizeof **member);
	for (size_t t = 0; t < n; t++)
		if (r->label[t] != NO_INDEX)
			(*start)[r->label[t] + 2]++;
	for (size_t i = 2; i < r->count + 2; i++)
		(*start)[i] += (*start)[i - 1];
	for (size_t t = 0; t < n; t++)
		if (r->label[t] != NO_INDEX)
			(*member)[(*start)[r->label[t] + 1]++] = (idx_t)t;
}

void regions_split(struct regions *r)
{
	const struct facets *f = r->facets;
	const size_t old_count = r->count;
	unsigned char *is_seen = mem_array(f->triangle_count, 1), *is_used = mem_array(old_count, 1);
	idx_t *queue = mem_array(f->triangle_count, sizeof *queue);
	for (size_t t = 0; t < f->triangle_count; t++) {
		const idx_t label = r->label[t];
		if (is_seen[t] || label == NO_INDEX)
			continue;
		size_t head = 0, tail = 0;
		queue[tail++] = (idx_t)t;
		is_seen[t] = 1;
		while (head < tail) {
			const idx_t at = queue[head++];
			for (int k = 0; k < 3; k++) {
				const idx_t to = f->neighbour[3 * at + k];
				if (f->is_sharp[3 * at + k] || is_seen[to] || r->label[to] != label)
					continue;
				is_seen[to] = 1;
				queue[tail++] = to;
			}
		}
		if (is_used[label]) {
			const struct dense_patch copy = r->patch[label];
			const idx_t fresh = regions_add(r, &copy);
			for (size_t i = 0; i < tail; i++)
				r->label[queue[i]] = fresh;
		}
		is_used[label] = 1;
	}
	free(queue);
	free(is_seen);
	free(is_used);
}

void regions_renumber(struct regions *r)
{
	const size_t n = r->facets->triangle_count;
	idx_t *fresh = mem_array(r->count, sizeof *fresh), used = 0;
	struct dense_patch *patch = mem_array(r->count, sizeof *patch);
	for (size_t i = 0; i < r->count; i++)
		fresh[i] = NO_INDEX;
	for (size_t t = 0; t < n; t++) {
		const idx_t old = r->label[t];
		if (old == NO_INDEX)
			continue;
		if (fresh[old] == NO_INDEX) {
			patch[used] = r->patch[old];
			fresh[old] = used++;
		}
		r->label[t] = fresh[old];
	}
	free(r->patch);
	r->patch = patch;
	r->capacity = r->count;
	r->count = (size_t)used;
	free(fresh);
}

static int compare_borders(const void *left, const void *right)
{
	const struct region_border *a = left, *b = right;
	if (a->low != b->low)
		return a->low < b->low ? -1 : 1;
	if (a->high != b->high)
		return a->high < b->high ? -1 : 1;
	/* sums must not depend on the order that qsort gives equals: longest first, then by sharpness */
	if (a->length != b->length)
		return a->length > b->length ? -1 : 1;
	return (a->sharp_length < b->sharp_length) - (a->sharp_length > b->sharp_length);
}

size_t regions_borders(const struct regions *r, struct region_border **border)
{
	const struct facets *f = r->facets;
	size_t count = 0, used = 0;
	for (int pass = 0; pass < 2; pass++) {
		if (pass)
			*border = mem_array(count, sizeof **border);
		for (size_t h = 0; h < 3 * f->triangle_count; h++) {
			const idx_t to = f->neighbour[h];
			if (to == NO_INDEX || f->twin[h] < (idx_t)h)
				continue;
			const idx_t a = r->label[h / 3], b = r->label[to];
			if (a == b || a == NO_INDEX || b == NO_INDEX)
				continue;
			if (!pass) {
				count++;
				continue;
			}
			(*border)[used++] = (struct region_border){a < b ? a : b, a < b ? b : a, f->length[h], f->is_sharp[h] ? f->length[h] : 0};
		}
	}
	qsort(*border, used, sizeof **border, compare_borders);
	count = 0;
	for (size_t i = 0; i < used; i++) {
		if (count && (*border)[count - 1].low == (*border)[i].low && (*border)[count - 1].high == (*border)[i].high) {
			(*border)[count - 1].length += (*border)[i].length;
			(*border)[count - 1].sharp_length += (*border)[i].sharp_length;
		} else {
			(*border)[count++] = (*border)[i];
		}
	}
	return count;
}
