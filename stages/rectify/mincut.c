/* Minimum cut by Dinitz's algorithm: see mincut.h.
 *
 * The source stands for side 0, the sink for side 1: the arc from the source carries the cost of side 1 (it is cut when
 * the node goes there), the arc to the sink the cost of side 0. The terminals are not nodes but a residual a node. */
#include "stages/rectify/mincut.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct flow {
	size_t node_count;
	size_t *start;       /* arcs of node i: start[i] .. start[i + 1] */
	idx_t *head;
	size_t *mirror;      /* the arc back */
	double *residual;
	double *from_source, *to_sink;
	idx_t *level;
	size_t *current;     /* arc to go on with in this phase */
	idx_t *queue;
	double nothing;      /* residuals up to this are used up */
};

static void build_arcs(struct flow *f, const struct mincut_edge *edge, size_t edge_count)
{
	f->start = mem_array(f->node_count + 2, sizeof *f->start);
	f->head = mem_array(2 * edge_count, sizeof *f->head);
	f->mirror = mem_array(2 * edge_count, sizeof *f->mirror);
	f->residual = mem_array(2 * edge_count, sizeof *f->residual);
	for (size_t e = 0; e < edge_count; e++) {
		f->start[edge[e].a + 2]++;
		f->start[edge[e].b + 2]++;
	}
	for (size_t i = 0; i < f->node_count; i++)
		f->start[i + 2] += f->start[i + 1];
	for (size_t e = 0; e < edge_count; e++) {
		const size_t there = f->start[edge[e].a + 1]++, back = f->start[edge[e].b + 1]++;
		f->head[there] = edge[e].b;
		f->head[back] = edge[e].a;
		f->mirror[there] = back;
		f->mirror[back] = there;
		f->residual[there] = f->residual[back] = edge[e].weight;
	}
}

/* Levels from the source. Returns whether the sink can be reached. */
static bool find_levels(struct flow *f)
{
	size_t tail = 0;
	bool is_reached = false;
	for (size_t i = 0; i < f->node_count; i++) {
		f->level[i] = NO_INDEX;
		if (f->from_source[i] > f->nothing) {
			f->level[i] = 0;
			f->queue[tail++] = (idx_t)i;
		}
	}
	for (size_t k = 0; k < tail; k++) {
		const idx_t i = f->queue[k];
		is_reached = is_reached || f->to_sink[i] > f->nothing;
		for (size_t a = f->start[i]; a < f->start[i + 1]; a++) {
			if (f->residual[a] > f->nothing && f->level[f->head[a]] == NO_INDEX) {
				f->level[f->head[a]] = f->level[i] + 1;
				f->queue[tail++] = f->head[a];
			}
		}
	}
	return is_reached;
}

/* Push what one node of level 0 can send, along shortest paths, until its arcs are used up. path: node_count arcs. */
static void push_from(struct flow *f, idx_t source, size_t *path)
{
	size_t depth = 0;
	idx_t at = source;
	while (f->from_source[source] > f->nothing) {
		if (f->to_sink[at] > f->nothing) {
			double amount = fmin(f->from_source[source], f->to_sink[at]);
			for (size_t i = 0; i < depth; i++)
				amount = fmin(amount, f->residual[path[i]]);
			f->from_source[source] -= amount;
			f->to_sink[at] -= amount;
			size_t keep = depth;
			for (size_t i = depth; i-- > 0;) {
				f->residual[path[i]] -= amount;
				f->residual[f->mirror[path[i]]] += amount;
				if (f->residual[path[i]] <= f->nothing)
					keep = i;
			}
			/* go on from the start of the first arc that is full */
			if (keep < depth)
				at = f->head[f->mirror[path[keep]]];
			depth = keep;
			continue;
		}
		size_t a = f->current[at];
		while (a < f->start[at + 1] && !(f->residual[a] > f->nothing && f->level[f->head[a]] == f->level[at] + 1))
			a++;
		f->current[at] = a;
		if (a < f->start[at + 1]) {
			path[depth++] = a;
			at = f->head[a];
		} else if (depth > 0) {
			depth--;
			at = f->head[f->mirror[path[depth]]];
			f->current[at]++;
		} else {
			return;
		}
	}
}

bool mincut_solve(unsigned char *side, size_t node_count, const double *side_cost, const struct mincut_edge *edge, size_t edge_count,
                  size_t phase_limit)
{
	struct flow f = {.node_count = node_count};
	double largest = 0;
	build_arcs(&f, edge, edge_count);
	f.from_source = mem_array(node_count, sizeof *f.from_source);
	f.to_sink = mem_array(node_count, sizeof *f.to_sink);
	f.level = mem_array(node_count, sizeof *f.level);
	f.current = mem_array(node_count, sizeof *f.current);
	f.queue = mem_array(node_count, sizeof *f.queue);
	size_t *path = mem_array(node_count + 1, sizeof *path);
	for (size_t i = 0; i < node_count; i++) {
		const double least = fmin(side_cost[2 * i], side_cost[2 * i + 1]);
		f.from_source[i] = side_cost[2 * i + 1] - least;
		f.to_sink[i] = side_cost[2 * i] - least;
		largest = fmax(largest, fmax(f.from_source[i], f.to_sink[i]));
	}
	for (size_t e = 0; e < edge_count; e++)
		largest = fmax(largest, edge[e].weight);
	f.nothing = 1e-12 * largest;
	bool is_done = false;
	for (size_t phase = 0; phase < phase_limit && !is_done; phase++) {
		is_done = !find_levels(&f);
		if (is_done)
			break;
		memcpy(f.current, f.start, node_count * sizeof *f.current);
		for (size_t i = 0; i < node_count; i++)
			if (f.level[i] == 0)
				push_from(&f, (idx_t)i, path);
	}
	for (size_t i = 0; i < node_count; i++)
		side[i] = f.level[i] == NO_INDEX;
	free(f.start);
	free(f.head);
	free(f.mirror);
	free(f.residual);
	free(f.from_source);
	free(f.to_sink);
	free(f.level);
	free(f.current);
	free(f.queue);
	free(path);
	return is_done;
}
