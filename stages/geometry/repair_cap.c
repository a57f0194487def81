/* Step 3: triangles without area. Needles (two corners in one place) collapse; caps (a corner on the opposite edge) give
 * that edge away: it is flipped, because dropping the cap would leave its corner as a T-junction on the neighbour's edge. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"
#include "stages/geometry/vector.h"

/* Needles collapse, caps flip, which may make new ones of either kind, rarely more than once. */
#define ROUND_LIMIT 8
#define PASS_LIMIT 64

/* Of edge {low, high}: how many triangles have it, and the exclusive or of their numbers, which of two gives the other. */
struct edge_slot {
	idx_t low, high;
	int32_t count;
	uint32_t sum;
};

struct edge_map {
	struct edge_slot *slot;
	size_t mask, filled;
};

static size_t hash_ends(idx_t low, idx_t high)
{
	uint64_t hash = ((uint64_t)(uint32_t)low << 32 | (uint32_t)high) * 0x9E3779B97F4A7C15u; /* 2^64 / golden ratio */
	return (size_t)(hash ^ hash >> 29);
}

static struct edge_slot *map_probe(const struct edge_map *map, idx_t low, idx_t high)
{
	size_t i = hash_ends(low, high) & map->mask;
	while (map->slot[i].low != NO_INDEX && (map->slot[i].low != low || map->slot[i].high != high))
		i = (i + 1) & map->mask;
	return &map->slot[i];
}

static struct edge_map map_new(size_t edges)
{
	size_t size = 64;
	while (size < 2 * edges)
		size *= 2;
	struct edge_map map = {mem_array(size, sizeof *map.slot), size - 1, 0};
	for (size_t i = 0; i < size; i++)
		map.slot[i].low = NO_INDEX;
	return map;
}

static struct edge_slot *map_edge(struct edge_map *map, idx_t a, idx_t b)
{
	const idx_t low = a < b ? a : b, high = a < b ? b : a;
	struct edge_slot *slot = map_probe(map, low, high);
	if (slot->low != NO_INDEX)
		return slot;
	if (2 * map->filled > map->mask) {
		struct edge_map larger = map_new(2 * (map->mask + 1));
		for (size_t i = 0; i <= map->mask; i++)
			if (map->slot[i].low != NO_INDEX)
				*map_probe(&larger, map->slot[i].low, map->slot[i].high) = map->slot[i];
		larger.filled = map->filled;
		free(map->slot);
		*map = larger;
		slot = map_probe(map, low, high);
	}
	map->filled++;
	*slot = (struct edge_slot){low, high, 0, 0};
	return slot;
}

static void count_triangle(struct edge_map *map, const struct soup *soup, size_t t, int sign)
{
	for (size_t h = 3 * t; h < 3 * t + 3; h++) {
		struct edge_slot *const slot = map_edge(map, soup->triangle[h], soup->triangle[next_half(h)]);
		slot->count += sign;
		slot->sum ^= (uint32_t)t;
	}
}

/* Height over the longest edge; *longest is its half-edge, *length its length. */
static double height(const struct soup *soup, size_t t, size_t *longest, double *length)
{
	const double *corner[3];
	double area[3];
	for (size_t k = 0; k < 3; k++)
		corner[k] = soup->xyz + 3 * (size_t)soup->triangle[3 * t + k];
	*length = -1;
	for (size_t k = 0; k < 3; k++) {
		const double edge = distance3(corner[k], corner[(k + 1) % 3]);
		if (edge > *length) {
			*length = edge;
			*longest = 3 * t + k;
		}
	}
	area_vector3(area, corner[0], corner[1], corner[2]);
	return *length > 0 ? norm3(area) / *length : 0;
}

static double height_of(const double *a, const double *b, const double *c)
{
	double area[3];
	area_vector3(area, a, b, c);
	const double length = fmax(distance3(a, b), fmax(distance3(b, c), distance3(c, a)));
	return length > 0 ? norm3(area) / length : 0;
}

static bool is_flat(const struct soup *soup, size_t t)
{
	size_t longest;
	double length;
	return height(soup, t, &longest, &length) < REPAIR_FLAT_HEIGHT * soup->side;
}

struct cap {
	double length; /* of its longest edge */
	idx_t triangle;
};

/* Longest first: the last of a row of caps has the longest edge, and beyond it a triangle with an area. */
static int compare_caps(const void *left, const void *right)
{
	const struct cap *a = left, *b = right;
	if (a->length != b->length)
		return a->length > b->length ? -1 : 1;
	return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

struct flattening {
	struct soup *soup;
	struct edge_map map;
	unsigned char *keep;
	struct cap *next;        /* for the next pass; each triangle once, or the list would double from pass to pass */
	size_t next_count;
	unsigned char *is_noted; /* a triangle: in this list */
	bool changed;
};

static void note_if_flat(struct flattening *flat, size_t t)
{
	if (flat->is_noted[t] || !is_flat(flat->soup, t))
		return;
	flat->is_noted[t] = 1;
	flat->next[flat->next_count++].triangle = (idx_t)t;
}

/* The caps noted so far, in order, with the lengths that their edges have now. */
static struct cap *take_noted(struct flattening *flat, size_t *count)
{
	struct cap *caps = mem_copy(flat->next, flat->next_count, sizeof *caps);
	*count = flat->next_count;
	flat->next_count = 0;
	for (size_t i = 0; i < *count; i++) {
		size_t longest;
		height(flat->soup, (size_t)caps[i].triangle, &longest, &caps[i].length);
		flat->is_noted[caps[i].triangle] = 0;
	}
	qsort(caps, *count, sizeof *caps, compare_caps);
	return caps;
}

/* Give the longest edge of cap t away: its corner o now divides the neighbour n. */
static void flip(struct flattening *flat, size_t t, size_t h, size_t n)
{
	idx_t *const triangle = flat->soup->triangle;
	const idx_t p = triangle[h], q = triangle[next_half(h)], o = triangle[previous_half(h)];
	size_t g = 3 * n;
	while (triangle[g] == o || (triangle[g] != p && triangle[g] != q) ||
	       (triangle[next_half(g)] != p && triangle[next_half(g)] != q))
		g++;
	const idx_t from = triangle[g], to = triangle[next_half(g)], d = triangle[previous_half(g)];
	count_triangle(&flat->map, flat->soup, t, -1);
	count_triangle(&flat->map, flat->soup, n, -1);
	/* As the neighbour is oriented: the cap has no side of its own. */
	memcpy(triangle + 3 * t, (idx_t[3]){from, o, d}, 3 * sizeof *triangle);
	memcpy(triangle + 3 * n, (idx_t[3]){o, to, d}, 3 * sizeof *triangle);
	count_triangle(&flat->map, flat->soup, t, 1);
	count_triangle(&flat->map, flat->soup, n, 1);
	flat->soup->report->count[REPAIR_CAP_FLIPPED]++;
	flat->changed = true;
	note_if_flat(flat, t);
	note_if_flat(flat, n);
}

static void treat_cap(struct flattening *flat, size_t t)
{
	struct soup *const soup = flat->soup;
	size_t h, other;
	double length, other_length;
	const double limit = REPAIR_FLAT_HEIGHT * soup->side;
	if (!flat->keep[t] || !(height(soup, t, &h, &length) < limit))
		return;
	const idx_t p = soup->triangle[h], q = soup->triangle[next_half(h)], o = soup->triangle[previous_half(h)];
	const double *po = soup->xyz + 3 * (size_t)o;
	if (distance3(po, soup->xyz + 3 * (size_t)p) < limit || distance3(po, soup->xyz + 3 * (size_t)q) < limit)
		return; /* a needle */
	const struct edge_slot *edge = map_edge(&flat->map, p, q);
	if (edge->count == 1) { /* at a border nobody misses it */
		flat->keep[t] = 0;
		count_triangle(&flat->map, soup, t, -1);
		soup->report->count[REPAIR_ZERO_AREA_FACE]++;
		flat->changed = true;
		return;
	}
	if (edge->count != 2)
		return;
	const size_t n = edge->sum ^ (uint32_t)t;
	idx_t d = NO_INDEX;
	for (size_t k = 3 * n; k < 3 * n + 3; k++)
		if (soup->triangle[k] != p && soup->triangle[k] != q)
			d = soup->triangle[k];
	if (d == o || d == NO_INDEX || map_edge(&flat->map, o, d)->count > 0)
		return;
	const double low = height(soup, t, &other, &other_length), neighbour = height(soup, n, &other, &other_length);
	const idx_t a = soup->triangle[other], b = soup->triangle[next_half(other)];
	const bool shares_longest = (a == p && b == q) || (a == q && b == p);
	if (neighbour < limit && !shares_longest) {
		note_if_flat(flat, t); /* a row of caps: after its neighbour, whose longest edge is longer */
		return;
	}
	/* Two caps over one longest edge get shorter edges, so that this ends. Otherwise the flip must help, or the next pass
	 * would take it back: with a corner near an end of the edge it only turns a thin triangle into another. */
	const double *pp = soup->xyz + 3 * (size_t)p, *pq = soup->xyz + 3 * (size_t)q, *pd = soup->xyz + 3 * (size_t)d;
	const double after = fmin(height_of(pp, po, pd), height_of(po, pq, pd));
	if (neighbour >= limit && !(after >= limit) && !(after > 2 * low))
		return;
	flip(flat, t, h, n);
}

static bool treat_caps(struct soup *soup)
{
	struct flattening flat = {
		.soup = soup,
		.map = map_new(3 * soup->triangle_count),
		.keep = mem_array(soup->triangle_count, 1),
		.next = mem_array(soup->triangle_count, sizeof *flat.next),
		.is_noted = mem_array(soup->triangle_count, 1),
	};
	memset(flat.keep, 1, soup->triangle_count);
	for (size_t t = 0; t < soup->triangle_count; t++) {
		count_triangle(&flat.map, soup, t, 1);
		note_if_flat(&flat, t);
	}
	for (int pass = 0; pass < PASS_LIMIT && flat.next_count > 0; pass++) {
		const bool changed_before = flat.changed;
		size_t count;
		struct cap *caps = take_noted(&flat, &count);
		flat.changed = false;
		for (size_t i = 0; i < count; i++)
			treat_cap(&flat, (size_t)caps[i].triangle);
		free(caps);
		const bool changed_now = flat.changed;
		flat.changed = changed_before || changed_now;
		if (!changed_now)
			break;
	}
	if (flat.changed)
		soup_keep(soup, flat.keep);
	free(flat.keep), free(flat.next), free(flat.is_noted), free(flat.map.slot);
	return flat.changed;
}

/* Two corners of a triangle without area in one place: they become one vertex. */
static bool collapse_needles(struct soup *soup)
{
	idx_t *becomes = new_roots(soup->vertex_count);
	const double limit = REPAIR_FLAT_HEIGHT * soup->side;
	bool changed = false;
	for (size_t t = 0; t < soup->triangle_count; t++) {
		if (!is_flat(soup, t))
			continue;
		for (size_t h = 3 * t; h < 3 * t + 3; h++) {
			const idx_t a = soup->triangle[h], b = soup->triangle[next_half(h)];
			if (distance3(soup->xyz + 3 * (size_t)a, soup->xyz + 3 * (size_t)b) < limit) {
				unite_roots(becomes, a, b);
				changed = true;
			}
		}
	}
	size_t collapsed = 0;
	unsigned char *keep = mem_array(soup->triangle_count, 1);
	for (size_t t = 0; t < soup->triangle_count && changed; t++) {
		idx_t *const c = soup->triangle + 3 * t;
		for (int k = 0; k < 3; k++)
			c[k] = find_root(becomes, c[k]);
		keep[t] = c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
		collapsed += !keep[t];
	}
	if (changed) {
		soup_keep(soup, keep);
		soup->report->count[REPAIR_ZERO_AREA_FACE] += collapsed;
		soup_drop_duplicates(soup);
	}
	free(keep);
	free(becomes);
	return changed;
}

/* Pieces that have no area anywhere. */
static void drop_flat_pieces(struct soup *soup)
{
	const size_t count = 3 * soup->triangle_count;
	struct side *side = soup_sides(soup);
	idx_t *piece = new_roots(soup->triangle_count);
	for (size_t i = 1; i < count; i++)
		if (side[i].low == side[i - 1].low && side[i].high == side[i - 1].high)
			unite_roots(piece, side[i].half / 3, side[i - 1].half / 3);
	unsigned char *has_area = mem_array(soup->triangle_count, 1), *keep = mem_array(soup->triangle_count, 1);
	for (size_t t = 0; t < soup->triangle_count; t++)
		if (!is_flat(soup, t))
			has_area[find_root(piece, (idx_t)t)] = 1;
	for (size_t t = 0; t < soup->triangle_count; t++) {
		keep[t] = has_area[find_root(piece, (idx_t)t)];
		soup->report->count[REPAIR_ZERO_AREA_FACE] += !keep[t];
	}
	soup_keep(soup, keep);
	free(side), free(piece), free(has_area), free(keep);
}

void soup_flatten(struct soup *soup)
{
	bool any = false;
	for (size_t t = 0; t < soup->triangle_count && !any; t++)
		any = is_flat(soup, t);
	if (!any)
		return;
	for (int round = 0; round < ROUND_LIMIT; round++) {
		const bool collapsed = collapse_needles(soup);
		if (!treat_caps(soup) && !collapsed)
			break;
	}
	drop_flat_pieces(soup);
}
