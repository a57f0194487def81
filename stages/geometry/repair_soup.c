/* What the steps of repair_mesh share: half-edges by their ends, growth, union-find. */
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"

static int compare_ends(const void *left, const void *right)
{
	const struct side *a = left, *b = right;
	if (a->high != b->high)
		return a->high < b->high ? -1 : 1;
	return (a->half > b->half) - (a->half < b->half);
}

struct side *soup_sides(const struct soup *soup)
{
	const size_t count = 3 * soup->triangle_count;
	struct side *side = mem_array(count, sizeof *side);
	size_t *start = mem_array(soup->vertex_count + 2, sizeof *start);
	for (size_t h = 0; h < count; h++) {
		const idx_t a = soup->triangle[h], b = soup->triangle[next_half(h)];
		start[(a < b ? a : b) + 2]++;
	}
	for (size_t v = 0; v < soup->vertex_count; v++)
		start[v + 2] += start[v + 1];
	for (size_t h = 0; h < count; h++) { /* counting sort by the lower end; then start[v + 1] is where v's end */
		const idx_t a = soup->triangle[h], b = soup->triangle[next_half(h)];
		const idx_t low = a < b ? a : b;
		side[start[low + 1]++] = (struct side){low, a < b ? b : a, (idx_t)h};
	}
	for (size_t v = 0; v < soup->vertex_count; v++)
		qsort(side + start[v], start[v + 1] - start[v], sizeof *side, compare_ends);
	free(start);
	return side;
}

size_t side_run(const struct side *side, size_t side_count, size_t first)
{
	size_t end = first + 1;
	while (end < side_count && side[end].low == side[first].low && side[end].high == side[first].high)
		end++;
	return end;
}

bool soup_is_oriented(const struct soup *soup, const struct side *side)
{
	const size_t count = 3 * soup->triangle_count;
	size_t good = 0, twisted = 0;
	for (size_t i = 0, end; i < count; i = end) {
		end = side_run(side, count, i);
		if (end - i == 2)
			*(soup->triangle[side[i].half] == soup->triangle[side[i + 1].half] ? &twisted : &good) += 1;
	}
	return 10 * twisted <= good;
}

idx_t soup_add_vertex(struct soup *soup, const double xyz[3])
{
	if (soup->vertex_count == soup->vertex_room)
		soup->xyz = mem_resize(soup->xyz, 3 * (soup->vertex_room = 2 * soup->vertex_room + 16), sizeof *soup->xyz);
	memcpy(soup->xyz + 3 * soup->vertex_count, (double[3]){xyz[0], xyz[1], xyz[2]}, 3 * sizeof *xyz);
	return (idx_t)soup->vertex_count++;
}

size_t soup_add_triangle(struct soup *soup, idx_t a, idx_t b, idx_t c)
{
	if (soup->triangle_count == soup->triangle_room) {
		soup->triangle_room = 2 * soup->triangle_room + 16;
		soup->triangle = mem_resize(soup->triangle, 3 * soup->triangle_room, sizeof *soup->triangle);
		if (soup->pair) {
			soup->pair = mem_resize(soup->pair, 3 * soup->triangle_room, sizeof *soup->pair);
			soup->opened = mem_resize(soup->opened, 3 * soup->triangle_room, 1);
		}
	}
	const size_t t = soup->triangle_count++;
	const idx_t corner[3] = {a, b, c};
	for (size_t k = 0; k < 3; k++) {
		soup->triangle[3 * t + k] = corner[k];
		if (soup->pair) {
			soup->pair[3 * t + k] = NO_INDEX;
			soup->opened[3 * t + k] = 0;
		}
	}
	return t;
}

void soup_keep(struct soup *soup, const unsigned char *keep)
{
	size_t kept = 0;
	for (size_t t = 0; t < soup->triangle_count; t++)
		if (keep[t]) {
			memmove(soup->triangle + 3 * kept, soup->triangle + 3 * t, 3 * sizeof *soup->triangle);
			kept++;
		}
	soup->triangle_count = kept;
}

bool soup_has_border(const struct soup *soup)
{
	const size_t count = 3 * soup->triangle_count;
	struct side *side = soup_sides(soup);
	bool found = false;
	for (size_t i = 0, end; i < count && !found; i = end) {
		end = side_run(side, count, i);
		found = end - i == 1;
	}
	free(side);
	return found;
}

idx_t find_root(idx_t *parent, idx_t v)
{
	while (parent[v] != v)
		v = parent[v] = parent[parent[v]];
	return v;
}

void unite_roots(idx_t *parent, idx_t a, idx_t b)
{
	a = find_root(parent, a);
	b = find_root(parent, b);
	if (a != b)
		parent[a > b ? a : b] = a < b ? a : b;
}

idx_t *new_roots(size_t count)
{
	idx_t *parent = mem_array(count, sizeof *parent);
	for (size_t i = 0; i < count; i++)
		parent[i] = (idx_t)i;
	return parent;
}

idx_t *soup_components(const struct soup *soup, size_t *component_count)
{
	idx_t *parent = new_roots(soup->triangle_count);
	for (size_t h = 0; h < 3 * soup->triangle_count; h++)
		if (soup->pair[h] != NO_INDEX)
			unite_roots(parent, (idx_t)(h / 3), soup->pair[h] / 3);
	idx_t *component = mem_array(soup->triangle_count, sizeof *component);
	*component_count = 0;
	for (size_t t = 0; t < soup->triangle_count; t++) {
		const idx_t root = find_root(parent, (idx_t)t);
		component[t] = root == (idx_t)t ? (idx_t)(*component_count)++ : component[root];
	}
	free(parent);
	return component;
}
