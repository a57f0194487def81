/* The published segmentation, second half: merging on the region adjacency graph.
 *
 * Edges live in one array and in a list for each region; a union moves the edges of the region with the shorter list and
 * joins doubles through a hash of region pairs. The heap keeps old entries: a version number tells them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/segment/classic_merge.h"

#define SMALL_FACTOR 1e-3   /* S_ij: small regions go first */
#define SHARP_SHARE 0.2     /* of the common border that may be sharp */
#define SIGN_MOST 0.5       /* asinh units: convex and concave parts beyond it never unite */

struct node {
	double area, perimeter;
	double curvature[2];      /* area-weighted sum */
	double convex[2], concave[2]; /* sum of kmax features by sign, and its area */
	idx_t parent;             /* itself as long as it lives */
	idx_t *edge;              /* indices of its edges, dead ones included */
	size_t edge_count, edge_capacity;
	bool is_free;
};

struct link {
	idx_t a, b;
	double length, sharp;
	double curvature[2];      /* length-weighted sum of the wedges along the border */
	double weight;            /* of that sum */
	uint32_t version;
	bool is_dead;
};

struct heap_entry {
	double distance;
	idx_t link;
	uint32_t version;
};

struct graph {
	struct node *node;
	struct link *link;
	size_t link_count;
	struct heap_entry *heap;
	size_t heap_count, heap_capacity;
	idx_t *slot;              /* hash of pairs to links, open addressing */
	size_t slot_mask, slots_used;
};

static bool comes_before(const struct heap_entry *a, const struct heap_entry *b)
{
	if (a->distance != b->distance)
		return a->distance < b->distance;
	return a->link < b->link;
}

static void heap_push(struct graph *g, struct heap_entry entry)
{
	if (g->heap_count == g->heap_capacity) {
		g->heap_capacity = g->heap_capacity ? 2 * g->heap_capacity : 256;
		g->heap = mem_resize(g->heap, g->heap_capacity, sizeof *g->heap);
	}
	size_t i = g->heap_count++;
	while (i && comes_before(&entry, &g->heap[(i - 1) / 2])) {
		g->heap[i] = g->heap[(i - 1) / 2];
		i = (i - 1) / 2;
	}
	g->heap[i] = entry;
}

static struct heap_entry heap_pop(struct graph *g)
{
	const struct heap_entry top = g->heap[0], last = g->heap[--g->heap_count];
	size_t i = 0;
	for (;;) {
		size_t child = 2 * i + 1;
		if (child >= g->heap_count)
			break;
		if (child + 1 < g->heap_count && comes_before(&g->heap[child + 1], &g->heap[child]))
			child++;
		if (!comes_before(&g->heap[child], &last))
			break;
		g->heap[i] = g->heap[child];
		i = child;
	}
	if (g->heap_count)
		g->heap[i] = last;
	return top;
}

static size_t pair_hash(idx_t a, idx_t b)
{
	const uint64_t low = (uint64_t)(a < b ? a : b), high = (uint64_t)(a < b ? b : a);
	uint64_t x = low * 0x9e3779b97f4a7c15u ^ (high + 0x632be59bd9b4e019u) * 0xd6e8feb86659fd93u;
	return (size_t)(x ^ x >> 32);
}

/* The slot of the living link between a and b, or the free slot for it. Dead links stay in their slots. */
static size_t find_slot(const struct graph *g, idx_t a, idx_t b)
{
	size_t i = pair_hash(a, b) & g->slot_mask;
	for (; g->slot[i] != NO_INDEX; i = (i + 1) & g->slot_mask) {
		const struct link *l = &g->link[g->slot[i]];
		if (!l->is_dead && ((l->a == a && l->b == b) || (l->a == b && l->b == a)))
			break;
	}
	return i;
}

/* Slots of moved and dead links are never freed one by one: when half are used, all living links are entered anew. */
static void reserve_slot(struct graph *g)
{
	if (2 * ++g->slots_used <= g->slot_mask)
		return;
	size_t living = 0;
	for (size_t i = 0; i < g->link_count; i++)
		living += !g->link[i].is_dead;
	size_t slots = 64;
	while (slots < 8 * (living + 1))
		slots *= 2;
	free(g->slot);
	g->slot = mem_array(slots, sizeof *g->slot);
	memset(g->slot, 0xff, slots * sizeof *g->slot);
	g->slot_mask = slots - 1;
	for (size_t i = 0; i < g->link_count; i++)
		if (!g->link[i].is_dead)
			g->slot[find_slot(g, g->link[i].a, g->link[i].b)] = (idx_t)i;
	g->slots_used = living + 1;
}

static void node_add_edge(struct node *n, idx_t edge)
{
	if (n->edge_count == n->edge_capacity) {
		n->edge_capacity = n->edge_capacity ? 2 * n->edge_capacity : 4;
		n->edge = mem_resize(n->edge, n->edge_capacity, sizeof *n->edge);
	}
	n->edge[n->edge_count++] = edge;
}

static double mean_difference(const struct node *n, const struct link *l)
{
	const double area = n->area > 0 ? n->area : 1, weight = l->weight > 0 ? l->weight : 1;
	return hypot(n->curvature[0] / area - l->curvature[0] / weight, n->curvature[1] / area - l->curvature[1] / weight);
}

static double link_distance(const struct graph *g, const struct link *l, double least_area)
{
	const struct node *a = &g->node[l->a], *b = &g->node[l->b];
	const double curvature = mean_difference(a, l) + mean_difference(b, l);
	const double nesting = fmin(a->perimeter, b->perimeter) / l->length;
	const double small = fmin(a->area, b->area) < least_area ? SMALL_FACTOR : 1;
	return curvature * nesting * small;
}

static bool is_vetoed(const struct graph *g, const struct link *l, double least_area)
{
	const struct node *a = &g->node[l->a], *b = &g->node[l->b];
	if (!a->is_free || !b->is_free || l->sharp >= l->length)
		return true;
	if (fmin(a->area, b->area) < least_area / 10)
		return false;
	if (l->sharp > SHARP_SHARE * l->length)
		return true;
	const double convex = a->convex[1] + b->convex[1], concave = a->concave[1] + b->concave[1], area = a->area + b->area;
	return fmin(a->area, b->area) >= least_area && convex > 0.1 * area && concave > 0.1 * area &&
	       (a->convex[0] + b->convex[0]) / convex > SIGN_MOST && (a->concave[0] + b->concave[0]) / concave < -SIGN_MOST;
}

static void push_link(struct graph *g, idx_t index, double least_area)
{
	struct link *l = &g->link[index];
	l->version++;
	if (!is_vetoed(g, l, least_area))
		heap_push(g, (struct heap_entry){link_distance(g, l, least_area), index, l->version});
}

/* b becomes part of a. */
static void unite(struct graph *g, idx_t a, idx_t b, idx_t through, double least_area)
{
	if (g->node[a].edge_count < g->node[b].edge_count) {
		const idx_t swap = a;
		a = b, b = swap;
	}
	struct node *keep = &g->node[a], *gone = &g->node[b];
	keep->perimeter += gone->perimeter - 2 * g->link[through].length;
	keep->area += gone->area;
	for (int i = 0; i < 2; i++) {
		keep->curvature[i] += gone->curvature[i];
		keep->convex[i] += gone->convex[i];
		keep->concave[i] += gone->concave[i];
	}
	gone->parent = a;
	g->link[through].is_dead = true;
	for (size_t i = 0; i < gone->edge_count; i++) {
		const idx_t e = gone->edge[i];
		struct link *l = &g->link[e];
		if (l->is_dead)
			continue;
		const idx_t other = l->a == b ? l->b : l->a;
		size_t slot = find_slot(g, a, other);
		if (g->slot[slot] != NO_INDEX) {
			struct link *into = &g->link[g->slot[slot]];
			into->length += l->length;
			into->sharp += l->sharp;
			into->weight += l->weight;
			into->curvature[0] += l->curvature[0];
			into->curvature[1] += l->curvature[1];
			l->is_dead = true;
		} else {
			l->a = a, l->b = other;
			g->slot[slot] = e;
			reserve_slot(g);
			node_add_edge(keep, e);
		}
	}
	free(gone->edge);
	gone->edge = NULL;
	gone->edge_count = gone->edge_capacity = 0;
	size_t living = 0;
	for (size_t i = 0; i < keep->edge_count; i++)
		if (!g->link[keep->edge[i]].is_dead) {
			keep->edge[living++] = keep->edge[i];
			push_link(g, keep->edge[i], least_area);
		}
	keep->edge_count = living;
}

static void build_graph(struct graph *g, const struct regions *r, const struct dense *dense, const struct curvature_feature *feature)
{
	const struct facets *f = r->facets;
	size_t borders = 0;
	g->node = mem_array(r->count, sizeof *g->node);
	for (size_t i = 0; i < r->count; i++) {
		g->node[i].parent = (idx_t)i;
		g->node[i].is_free = r->patch[i].kind == PATCH_FREE;
	}
	for (size_t t = 0; t < f->triangle_count; t++) {
		struct node *n = &g->node[r->label[t]];
		n->area += f->area[t];
		for (int i = 0; i < 2; i++)
			n->curvature[i] += f->area[t] * feature->value[2 * t + i];
		double *side = feature->value[2 * t + 1] > 0 ? n->convex : n->concave;
		side[0] += f->area[t] * feature->value[2 * t + 1];
		side[1] += f->area[t];
		for (int k = 0; k < 3; k++) {
			const idx_t to = f->neighbour[3 * t + k];
			const bool is_border = to == NO_INDEX || r->label[to] != r->label[t];
			n->perimeter += is_border ? f->length[3 * t + k] : 0;
			borders += is_border;
		}
	}
	g->slot = mem_array(64, sizeof *g->slot);
	memset(g->slot, 0xff, 64 * sizeof *g->slot);
	g->slot_mask = 63;
	g->link = mem_array(borders, sizeof *g->link);
	for (size_t h = 0; h < 3 * f->triangle_count; h++) {
		const idx_t to = f->neighbour[h];
		if (to == NO_INDEX || f->twin[h] < (idx_t)h)
			continue;
		const idx_t a = r->label[h / 3], b = r->label[to];
		if (a == b)
			continue;
		const size_t slot = find_slot(g, a, b);
		size_t at;
		if (g->slot[slot] == NO_INDEX) {
			g->slot[slot] = (idx_t)g->link_count;
			g->link[g->link_count] = (struct link){.a = a, .b = b};
			at = g->link_count;
			node_add_edge(&g->node[a], (idx_t)g->link_count);
			node_add_edge(&g->node[b], (idx_t)g->link_count);
			g->link_count++;
			reserve_slot(g);
		} else {
			at = (size_t)g->slot[slot];
		}
		struct link *l = &g->link[at];
		l->length += f->length[h];
		l->sharp += f->is_sharp[h] ? f->length[h] : 0;
		/* the four wedges at the two ends, as both sides see them */
		const size_t other = (size_t)f->twin[h];
		const size_t corner[4] = {h, h / 3 * 3 + (h + 1) % 3, other, other / 3 * 3 + (other + 1) % 3};
		for (int i = 0; i < 4; i++)
			for (int j = 0; j < 2; j++)
				l->curvature[j] += f->length[h] / 4 * feature->wedge_value[2 * dense->triangle_wedge[corner[i]] + j];
		l->weight += f->length[h];
	}
}

size_t classic_merge(struct regions *r, const struct dense *dense, const struct curvature_feature *feature, const struct merge_options *o)
{
	struct graph g = {0};
	size_t unions = 0;
	build_graph(&g, r, dense, feature);
	for (size_t i = 0; i < g.link_count; i++)
		push_link(&g, (idx_t)i, o->least_area);
	while (g.heap_count) {
		const struct heap_entry top = heap_pop(&g);
		struct link *l = &g.link[top.link];
		if (l->is_dead || l->version != top.version)
			continue;
		/* the smallest distance may be large: then only small regions go on */
		if (top.distance > o->stop && fmin(g.node[l->a].area, g.node[l->b].area) >= o->least_area)
			continue;
		unite(&g, l->a, l->b, top.link, o->least_area);
		unions++;
	}
	for (size_t t = 0; t < r->facets->triangle_count; t++) {
		idx_t at = r->label[t];
		while (g.node[at].parent != at) {
			g.node[at].parent = g.node[g.node[at].parent].parent;
			at = g.node[at].parent;
		}
		r->label[t] = at;
	}
	for (size_t i = 0; i < r->count; i++)
		free(g.node[i].edge);
	free(g.node);
	free(g.link);
	free(g.heap);
	free(g.slot);
	return unions;
}
