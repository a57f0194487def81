/* Thinning out one patch: a small editable triangle mesh. */
#include "stages/fitpatch/sheet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/nearest.h"
#include "stages/geometry/vector.h"

/* Union-find over corners: a local vertex is a fan of corners. */
static idx_t find_root(idx_t *parent, idx_t i)
{
	while (parent[i] != i)
		i = parent[i] = parent[parent[i]];
	return i;
}

static void unite(idx_t *parent, idx_t a, idx_t b)
{
	a = find_root(parent, a), b = find_root(parent, b);
	if (a != b)
		parent[a > b ? a : b] = a > b ? b : a;
}

void sheet_build(struct sheet *sheet, idx_t **dense_vertex, const idx_t *list, size_t count, const idx_t *dense_triangle,
                 const idx_t *dense_twin, const double *dense_xyz)
{
	idx_t highest = -1;
	for (size_t i = 0; i < count; i++)
		highest = list[i] > highest ? list[i] : highest;
	idx_t *local = mem_array((size_t)(highest + 1), sizeof *local); /* dense triangle -> local + 1 */
	for (size_t i = 0; i < count; i++)
		local[list[i]] = (idx_t)i + 1;
	*sheet = (struct sheet){.triangle_count = count, .capacity = count};
	sheet->origin = mem_array(3 * count, sizeof *sheet->origin);
	sheet->twin = mem_array(3 * count, sizeof *sheet->twin);
	sheet->segment = mem_array(3 * count, sizeof *sheet->segment);
	idx_t *parent = mem_array(3 * count, sizeof *parent);
	for (size_t h = 0; h < 3 * count; h++)
		parent[h] = (idx_t)h;
	for (size_t i = 0; i < count; i++)
		for (idx_t k = 0; k < 3; k++) {
			const idx_t h = 3 * (idx_t)i + k, dense = 3 * list[i] + k, across = dense_twin[dense];
			const idx_t other = across != NO_INDEX && across / 3 <= highest ? local[across / 3] - 1 : NO_INDEX;
			sheet->segment[h] = dense;
			sheet->twin[h] = other == NO_INDEX ? NO_INDEX : 3 * other + across % 3;
			if (sheet->twin[h] != NO_INDEX) {
				unite(parent, h, sheet_next(sheet->twin[h]));
				unite(parent, sheet_next(h), sheet->twin[h]);
			}
		}
	idx_t *number = mem_array(3 * count, sizeof *number);
	size_t vertices = 0;
	for (size_t h = 0; h < 3 * count; h++)
		if (find_root(parent, (idx_t)h) == (idx_t)h)
			number[h] = (idx_t)vertices++;
	sheet->vertex_count = sheet->vertex_capacity = vertices;
	sheet->xyz = mem_array(3 * vertices, sizeof *sheet->xyz);
	sheet->outgoing = mem_array(vertices, sizeof *sheet->outgoing);
	sheet->point = mem_array(vertices, sizeof *sheet->point);
	*dense_vertex = mem_array(vertices, sizeof **dense_vertex);
	memset(sheet->point, 0xff, vertices * sizeof *sheet->point);
	for (size_t h = 3 * count; h-- > 0;) {
		const idx_t v = number[find_root(parent, (idx_t)h)];
		const idx_t from = dense_triangle[3 * (size_t)list[h / 3] + h % 3];
		sheet->origin[h] = v;
		(*dense_vertex)[v] = from;
		copy3(&sheet->xyz[3 * (size_t)v], &dense_xyz[3 * (size_t)from]);
		sheet->outgoing[v] = (idx_t)h;
	}
	for (size_t h = 0; h < 3 * count; h++)
		if (sheet->twin[h] == NO_INDEX)
			sheet->outgoing[sheet->origin[h]] = (idx_t)h;
	free(local), free(parent), free(number);
}

void sheet_free(struct sheet *sheet)
{
	free(sheet->xyz), free(sheet->origin), free(sheet->twin), free(sheet->outgoing), free(sheet->point), free(sheet->segment);
	*sheet = (struct sheet){0};
}

static idx_t new_triangle(struct sheet *sheet)
{
	if (sheet->triangle_count == sheet->capacity) {
		sheet->capacity += sheet->capacity / 2 + 8;
		sheet->origin = mem_resize(sheet->origin, 3 * sheet->capacity, sizeof *sheet->origin);
		sheet->twin = mem_resize(sheet->twin, 3 * sheet->capacity, sizeof *sheet->twin);
		sheet->segment = mem_resize(sheet->segment, 3 * sheet->capacity, sizeof *sheet->segment);
	}
	return (idx_t)sheet->triangle_count++;
}

static idx_t new_vertex(struct sheet *sheet, const double xyz[3])
{
	if (sheet->vertex_count == sheet->vertex_capacity) {
		sheet->vertex_capacity += sheet->vertex_capacity / 2 + 8;
		sheet->xyz = mem_resize(sheet->xyz, 3 * sheet->vertex_capacity, sizeof *sheet->xyz);
		sheet->outgoing = mem_resize(sheet->outgoing, sheet->vertex_capacity, sizeof *sheet->outgoing);
		sheet->point = mem_resize(sheet->point, sheet->vertex_capacity, sizeof *sheet->point);
	}
	copy3(&sheet->xyz[3 * sheet->vertex_count], xyz);
	sheet->point[sheet->vertex_count] = NO_INDEX;
	return (idx_t)sheet->vertex_count++;
}

static void link_twins(struct sheet *sheet, idx_t a, idx_t b)
{
	if (a != NO_INDEX)
		sheet->twin[a] = b;
	if (b != NO_INDEX)
		sheet->twin[b] = a;
}

/* Split triangle (a b c) of h = a -> b into (a q c) and (q b c); returns q -> b. Twins of the two halves are the caller's. */
static idx_t split_half(struct sheet *sheet, idx_t h, idx_t q)
{
	const idx_t bc = sheet_next(h), b = sheet->origin[bc], c = sheet_target(sheet, bc), across = sheet->twin[bc];
	const idx_t t = 3 * new_triangle(sheet);
	sheet->origin[t] = q, sheet->origin[t + 1] = b, sheet->origin[t + 2] = c;
	sheet->segment[t] = sheet->segment[h];
	sheet->segment[t + 1] = sheet->segment[bc];
	sheet->segment[t + 2] = NO_INDEX;
	link_twins(sheet, t + 1, across);
	sheet->origin[bc] = q;
	sheet->segment[bc] = NO_INDEX;
	link_twins(sheet, bc, t + 2);
	if (sheet->outgoing[b] == bc)
		sheet->outgoing[b] = t + 1;
	return t;
}

idx_t sheet_split_border(struct sheet *sheet, idx_t h, const double xyz[3])
{
	const idx_t q = new_vertex(sheet, xyz), t = split_half(sheet, h, q);
	sheet->twin[t] = NO_INDEX;
	sheet->outgoing[q] = t;
	return q;
}

idx_t sheet_split_edge(struct sheet *sheet, idx_t h, const double xyz[3])
{
	const idx_t g = sheet->twin[h], q = new_vertex(sheet, xyz);
	const idx_t from_h = split_half(sheet, h, q), from_g = split_half(sheet, g, q);
	link_twins(sheet, h, from_g); /* a -> q and q -> a */
	link_twins(sheet, g, from_h);
	sheet->outgoing[q] = from_h;
	return q;
}

bool sheet_on_border(const struct sheet *sheet, idx_t vertex) { return sheet->twin[sheet->outgoing[vertex]] == NO_INDEX; }

size_t sheet_ring(const struct sheet *sheet, idx_t vertex, idx_t *ring, size_t room)
{
	size_t count = 0;
	const idx_t start = sheet->outgoing[vertex];
	idx_t h = start;
	do {
		if (count < room)
			ring[count] = sheet_target(sheet, h);
		count++;
		const idx_t back = sheet_previous(h);
		if (sheet->twin[back] == NO_INDEX) { /* the fan ends at the border */
			if (count < room)
				ring[count] = sheet->origin[back];
			count++;
			break;
		}
		h = sheet->twin[back];
	} while (h != start);
	return count;
}

idx_t sheet_edge(const struct sheet *sheet, idx_t a, idx_t b)
{
	const idx_t start = sheet->outgoing[a];
	idx_t h = start;
	do {
		if (sheet_target(sheet, h) == b)
			return h;
		const idx_t back = sheet_previous(h);
		if (sheet->origin[back] == b)
			return back;
		h = sheet->twin[back];
	} while (h != NO_INDEX && h != start);
	return NO_INDEX;
}

/* The ring of a vertex with the half-edges outside it: outer[i] is the twin of ring edge i -> i + 1. */
struct hole {
	size_t count;
	bool is_open; /* the vertex lies on the border: the side from the last corner to the first is new border */
	idx_t corner[SHEET_RING_LIMIT], outer[SHEET_RING_LIMIT], inner[SHEET_RING_LIMIT];
};

static bool hole_around(struct hole *hole, const struct sheet *sheet, idx_t vertex)
{
	const idx_t start = sheet->outgoing[vertex];
	idx_t h = start;
	hole->count = 0;
	hole->is_open = sheet->twin[start] == NO_INDEX;
	do {
		if (hole->count + 2 > SHEET_RING_LIMIT)
			return false;
		hole->corner[hole->count] = sheet_target(sheet, h);
		hole->inner[hole->count] = sheet_next(h);
		hole->outer[hole->count++] = sheet->twin[sheet_next(h)];
		const idx_t back = sheet_previous(h);
		h = sheet->twin[back];
		if (h == NO_INDEX) {
			hole->corner[hole->count] = sheet->origin[back];
			hole->inner[hole->count] = NO_INDEX;
			hole->outer[hole->count++] = NO_INDEX;
		}
	} while (h != NO_INDEX && h != start);
	return true;
}

/* Split points of the best triangulation of corner i .. j; -1 for sides. */
struct plan {
	double cost[SHEET_RING_LIMIT][SHEET_RING_LIMIT];
	signed char split[SHEET_RING_LIMIT][SHEET_RING_LIMIT];
};

/* A diagonal may not double an edge that exists; the edges to the vertex itself go away. */
static double diagonal_cost(const struct sheet *sheet, const struct sheet_cost *cost, idx_t a, idx_t b)
{
	if (a == b || sheet_edge(sheet, a, b) != NO_INDEX)
		return INFINITY;
	return cost->edge(cost->context, a, b);
}

static double plan_hole(struct plan *plan, const struct hole *hole, const struct sheet *sheet, const struct sheet_cost *cost)
{
	const size_t n = hole->count;
	for (size_t i = 0; i + 1 < n; i++)
		plan->cost[i][i + 1] = 0, plan->split[i][i + 1] = -1;
	for (size_t span = 2; span < n; span++)
		for (size_t i = 0; i + span < n; i++) {
			const size_t j = i + span;
			plan->cost[i][j] = INFINITY;
			plan->split[i][j] = -1;
			/* The whole polygon's closing side is a side; when it becomes new border it must be no edge yet, but costs nothing:
			 * it runs along a curve. */
			double side = 0;
			if (span < n - 1)
				side = diagonal_cost(sheet, cost, hole->corner[i], hole->corner[j]);
			else if (hole->is_open && sheet_edge(sheet, hole->corner[i], hole->corner[j]) != NO_INDEX)
				side = INFINITY;
			if (isinf(side))
				continue;
			for (size_t k = i + 1; k < j; k++) {
				const double parts = plan->cost[i][k] + plan->cost[k][j] + side;
				if (parts >= plan->cost[i][j])
					continue;
				const double sum = parts + cost->triangle(cost->context, hole->corner[i], hole->corner[k], hole->corner[j]);
				if (sum < plan->cost[i][j])
					plan->cost[i][j] = sum, plan->split[i][j] = (signed char)k;
			}
		}
	return plan->cost[0][n - 1];
}

/* Put the triangles of corner i .. j into free slots; returns the half-edge that runs from corner i to corner j ... as seen
 * from inside the piece, i.e. j -> i. */
static idx_t fill_hole(struct sheet *sheet, const struct plan *plan, const struct hole *hole, size_t i, size_t j, idx_t *free_triangle, size_t *used)
{
	const size_t k = (size_t)plan->split[i][j];
	const idx_t t = 3 * free_triangle[(*used)++];
	const size_t at[3] = {i, k, j};
	for (int s = 0; s < 3; s++) {
		sheet->origin[t + s] = hole->corner[at[s]];
		sheet->segment[t + s] = NO_INDEX;
	}
	for (int s = 0; s < 2; s++) {
		const size_t from = at[s], to = at[s + 1];
		if (to == from + 1) {
			link_twins(sheet, t + s, hole->outer[from]);
			sheet->outgoing[hole->corner[from]] = t + s;
		} else {
			link_twins(sheet, t + s, fill_hole(sheet, plan, hole, from, to, free_triangle, used));
		}
	}
	return t + 2;
}

/* Distance of p to the planned triangles of corner i .. j. */
static double plan_distance(const struct plan *plan, const struct hole *hole, const struct sheet *sheet, const double p[3], size_t i, size_t j)
{
	if (plan->split[i][j] < 0)
		return INFINITY;
	const size_t k = (size_t)plan->split[i][j];
	double point[3], weight[3];
	const double here = nearest_on_triangle(point, weight, p, &sheet->xyz[3 * (size_t)hole->corner[i]], &sheet->xyz[3 * (size_t)hole->corner[k]],
	                                        &sheet->xyz[3 * (size_t)hole->corner[j]]);
	return fmin(here, fmin(plan_distance(plan, hole, sheet, p, i, k), plan_distance(plan, hole, sheet, p, k, j)));
}

double sheet_remove(struct sheet *sheet, idx_t vertex, const struct sheet_cost *cost, double *height, bool apply)
{
	struct hole hole;
	if (!hole_around(&hole, sheet, vertex))
		return INFINITY;
	const size_t fan = hole.is_open ? hole.count - 1 : hole.count;
	if (hole.count < 3) {
		/* An ear: the triangle goes, its inner side becomes border. */
		if (!hole.is_open || hole.outer[0] == NO_INDEX)
			return INFINITY;
	}
	struct plan plan;
	double price = 0;
	if (hole.count >= 3) {
		price = plan_hole(&plan, &hole, sheet, cost);
		if (isinf(price))
			return INFINITY;
	}
	if (height)
		*height = hole.count >= 3 ? plan_distance(&plan, &hole, sheet, &sheet->xyz[3 * (size_t)vertex], 0, hole.count - 1) : 0;
	if (!apply)
		return price;

	idx_t slot[SHEET_RING_LIMIT];
	for (size_t i = 0; i < fan; i++)
		slot[i] = hole.inner[i] / 3;
	for (size_t i = 0; i < fan; i++)
		for (int s = 0; s < 3; s++)
			sheet->origin[3 * slot[i] + s] = NO_INDEX;
	sheet->outgoing[vertex] = NO_INDEX;
	if (hole.count < 3) {
		sheet->twin[hole.outer[0]] = NO_INDEX;
		sheet->outgoing[hole.corner[1]] = hole.outer[0];
		/* corner[0] keeps its border half-edge when it had another one than this triangle's. */
		for (idx_t h = sheet_next(hole.outer[0]);;) {
			if (sheet->twin[h] == NO_INDEX) {
				sheet->outgoing[hole.corner[0]] = h;
				break;
			}
			h = sheet_next(sheet->twin[h]);
		}
		return price;
	}
	size_t used = 0;
	const idx_t closing = fill_hole(sheet, &plan, &hole, 0, hole.count - 1, slot, &used);
	if (hole.is_open)
		sheet->twin[closing] = NO_INDEX;
	else
		link_twins(sheet, closing, hole.outer[hole.count - 1]);
	sheet->outgoing[hole.corner[hole.count - 1]] = closing;
	/* Border corners must start at their border half-edge. */
	for (size_t i = 0; i < hole.count; i++) {
		idx_t h = sheet->outgoing[hole.corner[i]];
		const idx_t start = h;
		while (sheet->twin[h] != NO_INDEX) { /* clockwise */
			h = sheet_next(sheet->twin[h]);
			if (h == start)
				break;
		}
		sheet->outgoing[hole.corner[i]] = h;
	}
	return price;
}

bool sheet_swap(struct sheet *sheet, idx_t h, const struct sheet_cost *cost)
{
	const idx_t g = sheet->twin[h];
	if (g == NO_INDEX)
		return false;
	const idx_t a = sheet->origin[h], b = sheet->origin[g];
	const idx_t c = sheet->origin[sheet_previous(h)], d = sheet->origin[sheet_previous(g)];
	const double after_edge = diagonal_cost(sheet, cost, c, d);
	if (isinf(after_edge))
		return false;
	const double before = cost->edge(cost->context, a, b) + cost->triangle(cost->context, a, b, c) + cost->triangle(cost->context, b, a, d);
	const double after = after_edge + cost->triangle(cost->context, c, d, b) + cost->triangle(cost->context, d, c, a);
	if (!(after < before - 1e-9 * (1 + fabs(before))))
		return false;
	/* (a b c)(b a d) -> (c d b)(d c a), in the same slots. */
	const idx_t bc = sheet_next(h), ca = sheet_previous(h), ad = sheet_next(g), db = sheet_previous(g);
	const idx_t twin_bc = sheet->twin[bc], twin_ca = sheet->twin[ca], twin_ad = sheet->twin[ad], twin_db = sheet->twin[db];
	const idx_t segment_bc = sheet->segment[bc], segment_ca = sheet->segment[ca], segment_ad = sheet->segment[ad], segment_db = sheet->segment[db];
	sheet->origin[h] = c, sheet->origin[bc] = d, sheet->origin[ca] = b;  /* c->d d->b b->c */
	sheet->origin[g] = d, sheet->origin[ad] = c, sheet->origin[db] = a;  /* d->c c->a a->d */
	sheet->segment[h] = sheet->segment[g] = NO_INDEX;
	link_twins(sheet, bc, twin_db), sheet->segment[bc] = segment_db;
	link_twins(sheet, ca, twin_bc), sheet->segment[ca] = segment_bc;
	link_twins(sheet, ad, twin_ca), sheet->segment[ad] = segment_ca;
	link_twins(sheet, db, twin_ad), sheet->segment[db] = segment_ad;
	const idx_t start[4][2] = {{c, h}, {d, bc}, {b, ca}, {a, db}};
	for (int i = 0; i < 4; i++) {
		idx_t k = start[i][1];
		const idx_t first = k;
		while (sheet->twin[k] != NO_INDEX) {
			k = sheet_next(sheet->twin[k]);
			if (k == first)
				break;
		}
		sheet->outgoing[start[i][0]] = k;
	}
	return true;
}
