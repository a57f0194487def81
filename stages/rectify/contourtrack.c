/* Redraw patch borders that do not follow the curvature: see contourtrack.h.
 *
 * Natural borders of a part run along the direction of least curvature. Border edges that do so are kept; from the ends of
 * the kept chains the missing borders are looked for as cheapest paths, and what they enclose is labelled anew. */
#include "stages/rectify/contourtrack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/vector.h"
#include "stages/rectify/minheap.h"

#define INFORMED 0.2        /* sum of anisotropies below which directions tell nothing */
#define UNDEFINED_SCORE (PI / 4)
#define CHAIN_EDGES 3       /* correct chains below this and below .. */
#define CHAIN_LENGTH 6      /* .. so many typical widths are chance */
#define SCORE_COST 3
#define TURN_COST 1
#define BORDER_GAIN 0.5
#define REACH 6             /* times the old border's length */
#define REGIONS_MOST 8      /* labels around one vertex */
#define LOSS_MOST 0.3       /* share of a patch that may get lost in another one's component */

enum edge_state { NOT_BORDER, CORRECT, WRONG, TRACKED };

struct tracker {
	struct partition *p;
	const struct contourtrack_options *options;
	unsigned char *state;  /* a half-edge, both twins */
	idx_t *chain;          /* a vertex: union-find over correct chains */
	idx_t *gap;            /* a vertex: union-find over wrong chains */
	double *gap_length;    /* by root */
	unsigned char *on_correct, *on_wrong; /* a vertex */
	/* Dijkstra, valid where stamp is now */
	double *cost;
	idx_t *arrived;        /* half-edge towards or from the vertex that the path came by, NO_INDEX at the start */
	unsigned *stamp, now;
	unsigned char *done;
};

static idx_t end_of(const struct half *half, idx_t h)
{
	return half->origin[half->next[h]];
}

/* Sum of anisotropy times angle and of anisotropy at the ends of h, with the wedges on the side of its face. */
static void side_score(double *weighted, double *weight, const struct partition *p, idx_t h)
{
	const struct half *half = &p->half;
	const struct dense *dense = p->dense;
	const idx_t corner[2] = {h, half->next[h]};
	double e[3];
	*weighted = *weight = 0;
	sub3(e, p->xyz + 3 * end_of(half, h), p->xyz + 3 * half->origin[h]);
	for (int k = 0; k < 2; k++) {
		const idx_t w = dense->triangle_wedge[corner[k]];
		if (dense->quality[w] != WEDGE_GOOD)
			continue;
		const double angle = angle3(e, dense->dmin + 3 * w);
		*weighted += dense->anisotropy[w] * fmin(angle, PI - angle);
		*weight += dense->anisotropy[w];
	}
}

double contourtrack_score(const struct partition *p, idx_t h)
{
	const idx_t twin = p->half.twin[h];
	if (p->kind[h] || twin == NO_INDEX)
		return 0;
	double best = INFINITY;
	for (int k = 0; k < 2; k++) {
		double weighted, weight;
		side_score(&weighted, &weight, p, k ? twin : h);
		if (weight >= INFORMED)
			best = fmin(best, weighted / weight);
	}
	if (best < INFINITY)
		return best;
	const idx_t l = p->label[p->half.face[h]], r = p->label[p->half.face[twin]];
	if (l == r)
		return UNDEFINED_SCORE;
	return PI / 2 * exp(-hypot(p->mean_curvature[2 * l] - p->mean_curvature[2 * r], p->mean_curvature[2 * l + 1] - p->mean_curvature[2 * r + 1]));
}

static idx_t root_of(idx_t *parent, idx_t i)
{
	while (parent[i] != i)
		i = parent[i] = parent[parent[i]];
	return i;
}

static void unite(idx_t *parent, idx_t a, idx_t b)
{
	a = root_of(parent, a);
	b = root_of(parent, b);
	parent[a > b ? a : b] = a < b ? a : b;
}

/* Visits each edge once: twinless half-edges and the lower of two twins. */
static bool is_first_side(const struct half *half, size_t h)
{
	return half->twin[h] == NO_INDEX || (idx_t)h < half->twin[h];
}

static void set_state(struct tracker *t, idx_t h, enum edge_state state)
{
	t->state[h] = (unsigned char)state;
	if (t->p->half.twin[h] != NO_INDEX)
		t->state[t->p->half.twin[h]] = (unsigned char)state;
}

/* Judge the border edges, demote correct chains that are too short to be more than chance, join what is left to chains. */
static void judge(struct tracker *t, bool is_first_pass, struct contourtrack_counts *counts)
{
	const struct partition *p = t->p;
	const struct half *half = &p->half;
	const size_t v_count = half->vertex_count;
	size_t *edges = mem_array(v_count, sizeof *edges);
	double *length = mem_array(v_count, sizeof *length);
	unsigned char *is_held = mem_array(v_count, 1); /* chain root: touches a sharp edge or a border */
	for (size_t v = 0; v < v_count; v++) {
		t->chain[v] = t->gap[v] = (idx_t)v;
		t->gap_length[v] = 0;
		t->on_correct[v] = t->on_wrong[v] = 0;
	}
	for (size_t h = 0; h < half->half_count; h++) {
		if (!is_first_side(half, h))
			continue;
		const idx_t twin = half->twin[h];
		const bool is_border = twin == NO_INDEX || p->label[half->face[h]] != p->label[half->face[twin]];
		enum edge_state state = NOT_BORDER;
		if (is_border)
			state = contourtrack_score(p, (idx_t)h) <= t->options->score_rad ? CORRECT : WRONG;
		if (is_border && !p->kind[h] && is_first_pass) {
			counts->border_edges++;
			counts->correct += state == CORRECT;
		}
		set_state(t, (idx_t)h, state);
		if (state == CORRECT)
			unite(t->chain, half->origin[h], end_of(half, (idx_t)h));
	}
	for (size_t h = 0; h < half->half_count; h++) {
		if (!is_first_side(half, h) || t->state[h] != CORRECT)
			continue;
		const idx_t root = root_of(t->chain, half->origin[h]);
		edges[root]++;
		length[root] += p->length[h];
		is_held[root] |= p->kind[h] != 0;
	}
	for (size_t h = 0; h < half->half_count; h++) {
		if (!is_first_side(half, h) || t->state[h] != CORRECT)
			continue;
		const idx_t root = root_of(t->chain, half->origin[h]);
		if (!is_held[root] && edges[root] < CHAIN_EDGES && length[root] < CHAIN_LENGTH * p->scale)
			set_state(t, (idx_t)h, WRONG);
	}
	for (size_t h = 0; h < half->half_count; h++) {
		if (!is_first_side(half, h) || t->state[h] == NOT_BORDER)
			continue;
		const idx_t a = half->origin[h], b = end_of(half, (idx_t)h);
		if (t->state[h] == CORRECT) {
			t->on_correct[a] = t->on_correct[b] = 1;
		} else {
			t->on_wrong[a] = t->on_wrong[b] = 1;
			unite(t->gap, a, b);
		}
	}
	for (size_t h = 0; h < half->half_count; h++)
		if (is_first_side(half, h) && t->state[h] == WRONG)
			t->gap_length[root_of(t->gap, half->origin[h])] += p->length[h];
	free(edges);
	free(length);
	free(is_held);
}

/* Labels of the triangles around a vertex. */
static int labels_around(idx_t label[REGIONS_MOST], const struct partition *p, idx_t v)
{
	const struct half *half = &p->half;
	const idx_t start = half->outgoing[v];
	int count = 0;
	for (int direction = 0; direction < 2; direction++) {
		idx_t h = start;
		do {
			const idx_t l = p->label[half->face[h]];
			int i = 0;
			while (i < count && label[i] != l)
				i++;
			if (i == count && count < REGIONS_MOST)
				label[count++] = l;
			h = direction ? half->twin[half->previous[h]] : half->twin[h] == NO_INDEX ? NO_INDEX : half->next[half->twin[h]];
		} while (h != NO_INDEX && h != start);
	}
	return count;
}

static bool is_allowed(const struct partition *p, idx_t h, const idx_t *label, int count)
{
	for (int side = 0; side < 2; side++) {
		const idx_t g = side ? p->half.twin[h] : h;
		if (g == NO_INDEX)
			continue;
		for (int i = 0; i < count; i++)
			if (p->label[p->half.face[g]] == label[i])
				return true;
	}
	return false;
}

/* Cost of walking the edge of h from vertex `from`, after having come by `arrived`. */
static double step_cost(const struct tracker *t, idx_t h, idx_t from)
{
	const struct partition *p = t->p;
	const struct half *half = &p->half;
	const idx_t came = t->arrived[from];
	double turn = 0;
	if (came != NO_INDEX) {
		double e[3], f[3];
		const idx_t other = half->origin[came] == from ? end_of(half, came) : half->origin[came];
		sub3(e, p->xyz + 3 * from, p->xyz + 3 * other);
		sub3(f, p->xyz + 3 * (half->origin[h] == from ? end_of(half, h) : half->origin[h]), p->xyz + 3 * from);
		turn = angle3(e, f) / (PI / 2);
	}
	const double score = contourtrack_score(p, h) / (PI / 2);
	const bool was_border = t->state[h] == WRONG;
	return p->length[h] * (1 + SCORE_COST * score * score + TURN_COST * turn * turn - (was_border ? BORDER_GAIN : 0));
}

static void relax(struct tracker *t, struct minheap *heap, idx_t h, idx_t from, const idx_t *label, int label_count)
{
	const struct half *half = &t->p->half;
	if (!is_allowed(t->p, h, label, label_count))
		return;
	const idx_t to = half->origin[h] == from ? end_of(half, h) : half->origin[h];
	if (t->stamp[to] == t->now && t->done[to])
		return;
	const double cost = t->cost[from] + step_cost(t, h, from);
	if (t->stamp[to] == t->now && cost >= t->cost[to])
		return;
	t->stamp[to] = t->now;
	t->done[to] = 0;
	t->cost[to] = cost;
	t->arrived[to] = h;
	minheap_push(heap, cost, to);
}

/* Cheapest path from an open end to another chain of correct edges or another open end. Marks it TRACKED; false when there is
 * none within reach. */
static bool track_from(struct tracker *t, idx_t start)
{
	const struct partition *p = t->p;
	const struct half *half = &p->half;
	struct minheap heap = {0};
	idx_t label[REGIONS_MOST] = {0}, found = NO_INDEX;
	const int label_count = labels_around(label, p, start);
	const double reach = REACH * t->gap_length[root_of(t->gap, start)];
	const idx_t own = root_of(t->chain, start);
	t->now++;
	t->stamp[start] = t->now;
	t->done[start] = 0;
	t->cost[start] = 0;
	t->arrived[start] = NO_INDEX;
	minheap_push(&heap, 0, start);
	while (heap.count > 0) {
		const struct minheap_entry e = minheap_pop(&heap);
		const idx_t v = e.vertex;
		if (t->done[v] || e.key > t->cost[v])
			continue;
		if (e.key > reach)
			break;
		t->done[v] = 1;
		if (v != start && t->on_correct[v]) {
			/* along its own chain lies nothing new, but another open end of it closes the gap */
			if (root_of(t->chain, v) != own || t->on_wrong[v]) {
				found = v;
				break;
			}
			continue;
		}
		const idx_t first = half->outgoing[v];
		for (int direction = 0; direction < 2; direction++) {
			idx_t h = first;
			do {
				relax(t, &heap, h, v, label, label_count);
				if (half->twin[half->previous[h]] == NO_INDEX)
					relax(t, &heap, half->previous[h], v, label, label_count);
				h = direction ? half->twin[half->previous[h]] : half->twin[h] == NO_INDEX ? NO_INDEX : half->next[half->twin[h]];
			} while (h != NO_INDEX && h != first);
			if (h == first)
				break; /* a whole turn: nothing is left for the other direction */
		}
	}
	free(heap.entry);
	if (found == NO_INDEX)
		return false;
	for (idx_t v = found; t->arrived[v] != NO_INDEX;) {
		const idx_t h = t->arrived[v];
		v = half->origin[h] == v ? end_of(half, h) : half->origin[h];
		if (t->state[h] != CORRECT)
			set_state(t, h, TRACKED);
	}
	return true;
}

struct share {
	idx_t component, label;
	double area;
};

static int compare_shares(const void *a, const void *b)
{
	const struct share *p = a, *q = b;
	if (p->component != q->component)
		return p->component < q->component ? -1 : 1;
	if (p->label != q->label)
		return p->label < q->label ? -1 : 1;
	return (p->area > q->area) - (p->area < q->area);
}

/* Flood between the borders; every component takes the label that has most of it, unless that would swallow a patch. */
static size_t relabel(struct tracker *t, const unsigned char *is_replaced)
{
	struct partition *p = t->p;
	const struct half *half = &p->half;
	const size_t n = half->face_count;
	idx_t *component = mem_array(n, sizeof *component), *stack = mem_array(n, sizeof *stack), *wanted;
	size_t count = 0, changed = 0;
	for (size_t i = 0; i < n; i++)
		component[i] = NO_INDEX;
	for (size_t seed = 0; seed < n; seed++) {
		if (component[seed] != NO_INDEX)
			continue;
		size_t top = 0;
		stack[top++] = (idx_t)seed;
		component[seed] = (idx_t)count;
		while (top > 0) {
			const idx_t f = stack[--top];
			for (idx_t h = 3 * f; h < 3 * f + 3; h++) {
				const idx_t twin = half->twin[h];
				if (twin == NO_INDEX || component[half->face[twin]] != NO_INDEX)
					continue;
				const bool is_open = t->state[h] == NOT_BORDER || (t->state[h] == WRONG && is_replaced[root_of(t->gap, half->origin[h])]);
				if (!is_open)
					continue;
				component[half->face[twin]] = (idx_t)count;
				stack[top++] = half->face[twin];
			}
		}
		count++;
	}
	struct share *share = mem_array(n, sizeof *share);
	for (size_t i = 0; i < n; i++)
		share[i] = (struct share){component[i], p->label[i], p->area[i]};
	qsort(share, n, sizeof *share, compare_shares);
	wanted = mem_array(count, sizeof *wanted);
	for (size_t i = 0, end; i < n; i = end) {
		const idx_t c = share[i].component;
		double most = -1, lost = 0;
		for (size_t k = end = i; end < n && share[end].component == c; k = end) {
			double area = 0;
			for (; end < n && share[end].component == c && share[end].label == share[k].label; end++)
				area += share[end].area;
			share[k].area = area;
			if (area > most)
				most = area, wanted[c] = share[k].label;
			for (size_t j = k + 1; j < end; j++)
				share[j].area = 0;
		}
		for (size_t k = i; k < end; k++)
			if (share[k].label != wanted[c] && share[k].area > 0 && p->patch_area[share[k].label] > 0)
				lost = fmax(lost, share[k].area / p->patch_area[share[k].label]);
		if (lost > LOSS_MOST)
			wanted[c] = NO_INDEX;
	}
	for (size_t i = 0; i < n; i++) {
		if (wanted[component[i]] == NO_INDEX || wanted[component[i]] == p->label[i])
			continue;
		p->label[i] = wanted[component[i]];
		changed++;
	}
	free(component);
	free(stack);
	free(wanted);
	free(share);
	return changed;
}

void contourtrack(struct partition *p, const struct contourtrack_options *options, struct contourtrack_counts *counts)
{
	const struct half *half = &p->half;
	const size_t v_count = half->vertex_count;
	struct tracker t = {.p = p, .options = options};
	*counts = (struct contourtrack_counts){0};
	t.state = mem_array(half->half_count, 1);
	t.chain = mem_array(v_count, sizeof *t.chain);
	t.gap = mem_array(v_count, sizeof *t.gap);
	t.gap_length = mem_array(v_count, sizeof *t.gap_length);
	t.on_correct = mem_array(v_count, 1);
	t.on_wrong = mem_array(v_count, 1);
	t.cost = mem_array(v_count, sizeof *t.cost);
	t.arrived = mem_array(v_count, sizeof *t.arrived);
	t.stamp = mem_array(v_count, sizeof *t.stamp);
	t.done = mem_array(v_count, 1);
	unsigned char *is_replaced = mem_array(v_count, 1);
	for (int pass = 0; pass < options->passes; pass++) {
		partition_refresh(p);
		judge(&t, pass == 0, counts);
		counts->passes++;
		/* a gap is replaced when every open end of it found a way */
		memset(is_replaced, 0, v_count);
		for (size_t v = 0; v < v_count; v++)
			if (t.on_correct[v] && t.on_wrong[v])
				is_replaced[root_of(t.gap, (idx_t)v)] = 1;
		for (size_t v = 0; v < v_count; v++) {
			if (!t.on_correct[v] || !t.on_wrong[v])
				continue;
			if (track_from(&t, (idx_t)v)) {
				counts->tracked++;
			} else {
				is_replaced[root_of(t.gap, (idx_t)v)] = 0;
				counts->kept++;
			}
		}
		const size_t changed = relabel(&t, is_replaced);
		partition_split(p, options->tiny_area, 0, false, NULL, NULL);
		if (changed == 0)
			break;
	}
	partition_refresh(p);
	free(t.state);
	free(t.chain);
	free(t.gap);
	free(t.gap_length);
	free(t.on_correct);
	free(t.on_wrong);
	free(t.cost);
	free(t.arrived);
	free(t.stamp);
	free(t.done);
	free(is_replaced);
}
