/* Border chains of a labelled mesh: boundary edges, nodes, kinds (the patch method's section 4.1). */
#include "stages/geometry/border.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/boundary.h"
#include "stages/geometry/vector.h"

/* Tangents at a possible corner are chords over at least this share of the longest side, ... */
#define CORNER_REACH 0.01
/* ... over more on smooth borders, which run in steps of whole triangles. */
#define SMOOTH_REACH 0.03
#define SMOOTH_EDGES 4
/* Beyond this turn a vertex is a corner whatever its neighbours do: the mesh is closer to a hexagon than to its circle. */
#define SURE_CORNER_DEG 59
/* A corner turns more than this many times as much as its neighbours: vertices of a coarse circle do not. */
#define CORNER_PROMINENCE 3
/* A sharp or smooth stretch shorter than this share of the longest side does not split a border. */
#define LEAST_STRETCH 0.03

/* Nodes by connectivity: not two boundary edges, other patches, or edges that do not follow each other. */
static void mark_nodes(bool *is_node, const struct boundary *boundary, size_t vertex_count)
{
	for (size_t v = 0; v < vertex_count; v++) {
		const size_t degree = boundary->start[v + 1] - boundary->start[v];
		if (degree == 0)
			continue;
		if (degree != 2) {
			is_node[v] = true;
			continue;
		}
		const struct boundary_edge *e = boundary->edge + boundary->incident[boundary->start[v]];
		const struct boundary_edge *f = boundary->edge + boundary->incident[boundary->start[v] + 1];
		if (e->left != f->left || e->right != f->right)
			is_node[v] = true;
		else if (e->left != e->right && (e->a == (idx_t)v) == (f->a == (idx_t)v))
			is_node[v] = true;
	}
}

/* A walk along boundary edges: vertices in order (closed: each once) and the edges between them. */
struct walk {
	idx_t *vertex, *edge;
	size_t vertex_count, edge_count, room;
	bool closed;
};

static void walk_push(struct walk *walk, idx_t edge, idx_t vertex)
{
	if (walk->vertex_count == walk->room) {
		walk->room = 2 * walk->room + 16;
		walk->vertex = mem_resize(walk->vertex, walk->room, sizeof *walk->vertex);
		walk->edge = mem_resize(walk->edge, walk->room, sizeof *walk->edge);
	}
	walk->vertex[walk->vertex_count++] = vertex;
	if (edge != NO_INDEX)
		walk->edge[walk->edge_count++] = edge;
}

/* Walk from vertex along edge until a node or back to the start. used is set for every edge passed. */
static void walk_from(struct walk *walk, bool *used, const struct boundary *boundary, const bool *is_node, idx_t vertex,
		      idx_t edge)
{
	walk->vertex_count = walk->edge_count = 0;
	walk->closed = false;
	walk_push(walk, NO_INDEX, vertex);
	idx_t at = vertex;
	for (;;) {
		used[edge] = true;
		const struct boundary_edge *e = boundary->edge + edge;
		at = e->a == at ? e->b : e->a;
		if (at == vertex && !is_node[vertex]) {
			walk->edge[walk->edge_count++] = edge; /* room: edges never outnumber vertices */
			walk->closed = true;
			return;
		}
		walk_push(walk, edge, at);
		if (is_node[at])
			return;
		const idx_t *pair = boundary->incident + boundary->start[at];
		edge = pair[0] == edge ? pair[1] : pair[0];
	}
}

static void walk_free(struct walk *walk)
{
	free(walk->vertex), free(walk->edge);
}

/* The next chain that starts with an unused edge: from the chain's beginning, left patch on the left. */
static bool walk_next(struct walk *walk, bool *used, const struct boundary *boundary, const struct dense *dense,
		      const bool *is_node, size_t *next_edge)
{
	while (*next_edge < boundary->edge_count && used[*next_edge])
		++*next_edge;
	if (*next_edge == boundary->edge_count)
		return false;
	idx_t edge = (idx_t)*next_edge, at = boundary->edge[edge].a;
	const idx_t first = edge;
	idx_t seam = at, seam_edge = edge;
	while (!is_node[at]) { /* backwards to the node, or once around for the seam */
		const idx_t *pair = boundary->incident + boundary->start[at];
		const idx_t before = pair[0] == edge ? pair[1] : pair[0];
		const struct boundary_edge *e = boundary->edge + before;
		edge = before;
		at = e->a == at ? e->b : e->a;
		if (edge == first)
			break;
		const double *p = dense->xyz + 3 * (size_t)at, *q = dense->xyz + 3 * (size_t)seam;
		int order = 0;
		for (int k = 0; k < 3 && order == 0; k++)
			order = (p[k] > q[k]) - (p[k] < q[k]);
		if (order < 0 || (order == 0 && at < seam))
			seam = at, seam_edge = edge;
	}
	if (is_node[at])
		walk_from(walk, used, boundary, is_node, at, edge);
	else
		walk_from(walk, used, boundary, is_node, seam, seam_edge);
	return true;
}

/* Make sharp and smooth stretches along one walk long enough: those that are too short and shorter than their neighbours
 * change over, until none is left. Every pass at least halves the number of short stretches that touch each other. */
static void clean_stretches(struct boundary_edge *edge, const struct walk *walk, double least)
{
	const size_t n = walk->edge_count;
	size_t *begin = mem_array(n + 1, sizeof *begin);
	double *length = mem_array(n + 2, sizeof *length);
	for (int pass = 0; pass < 64; pass++) {
		size_t origin = 0; /* closed walks start behind a change */
		if (walk->closed) {
			while (origin < n && edge[walk->edge[origin]].sharp == edge[walk->edge[(origin + n - 1) % n]].sharp)
				origin++;
			if (origin == n)
				break;
		}
		size_t count = 0;
		for (size_t i = 0; i < n; i++) {
			const struct boundary_edge *e = edge + walk->edge[(origin + i) % n];
			if (i == 0 || e->sharp != edge[walk->edge[(origin + i - 1) % n]].sharp) {
				begin[count] = i;
				length[count++] = 0;
			}
			length[count - 1] += e->length;
		}
		begin[count] = n;
		if (count < 2)
			break;
		size_t changed = 0;
		bool before_changed = false, first_changed = false; /* of two equal neighbours only one changes */
		for (size_t i = 0; i < count; i++) {
			const double before = i > 0 ? length[i - 1] : walk->closed ? length[count - 1] : INFINITY;
			const double after = i + 1 < count ? length[i + 1] : walk->closed ? length[0] : INFINITY;
			const bool change = length[i] < least && length[i] <= before && length[i] <= after && !before_changed &&
					    !(walk->closed && i + 1 == count && first_changed);
			before_changed = change;
			first_changed |= change && i == 0;
			if (!change)
				continue;
			for (size_t k = begin[i]; k < begin[i + 1]; k++)
				edge[walk->edge[(origin + k) % n]].sharp ^= true;
			changed++;
		}
		if (changed == 0)
			break;
	}
	free(begin), free(length);
}

/* Chord of the walk that leaves vertex i forwards or backwards: over at least `edges` edges and `reach` length, stopping at
 * the end or (careful) before a vertex that turns by more than stop_deg itself. */
static bool chord(double out[3], const struct walk *walk, const double *xyz, const double *turn_deg, size_t i, int step,
		  size_t edges, double reach, double stop_deg)
{
	const size_t n = walk->vertex_count;
	size_t at = i, taken = 0;
	double gone = 0;
	while ((taken < edges || gone < reach) && taken < n / 2) {
		size_t to;
		if (walk->closed)
			to = step > 0 ? (at + 1) % n : (at + n - 1) % n;
		else if (step > 0 ? at + 1 == n : at == 0)
			break;
		else
			to = step > 0 ? at + 1 : at - 1;
		gone += distance3(xyz + 3 * (size_t)walk->vertex[at], xyz + 3 * (size_t)walk->vertex[to]);
		at = to;
		taken++;
		if (turn_deg[at] > stop_deg)
			break;
	}
	if (taken == 0)
		return false;
	sub3(out, xyz + 3 * (size_t)walk->vertex[at], xyz + 3 * (size_t)walk->vertex[i]);
	return normalise3(out) > 0;
}

/* Turn of the walk at its vertex i between the plain mesh edges, degrees; 0 at the ends. */
static double plain_turn(const struct walk *walk, const double *xyz, size_t i)
{
	const size_t n = walk->vertex_count;
	if (!walk->closed && (i == 0 || i + 1 == n))
		return 0;
	double u[3], v[3];
	const double *p = xyz + 3 * (size_t)walk->vertex[i];
	sub3(u, p, xyz + 3 * (size_t)walk->vertex[(i + n - 1) % n]);
	sub3(v, xyz + 3 * (size_t)walk->vertex[(i + 1) % n], p);
	return norm3(u) > 0 && norm3(v) > 0 ? angle3(u, v) * DEGREES : 0;
}

static void mark_corners(bool *is_node, const struct boundary_edge *edge, const struct walk *walk, const double *xyz, double side,
			 double corner_deg)
{
	const size_t n = walk->vertex_count;
	double *plain = mem_array(n, sizeof *plain), *wide = mem_array(n, sizeof *wide);
	for (size_t i = 0; i < n; i++)
		plain[i] = plain_turn(walk, xyz, i);
	const size_t begin = walk->closed ? 0 : 1, end = walk->closed ? n : n - 1;
	for (size_t i = begin; i < end; i++) {
		const bool smooth =
			!edge[walk->edge[(i + walk->edge_count - 1) % walk->edge_count]].sharp && !edge[walk->edge[i]].sharp;
		double u[3], v[3];
		if (chord(u, walk, xyz, plain, i, -1, smooth ? SMOOTH_EDGES : 2, (smooth ? SMOOTH_REACH : CORNER_REACH) * side,
			  smooth ? 361 : 30) &&
		    chord(v, walk, xyz, plain, i, 1, smooth ? SMOOTH_EDGES : 2, (smooth ? SMOOTH_REACH : CORNER_REACH) * side,
			  smooth ? 361 : 30)) {
			scale3(u, -1);
			wide[i] = angle3(u, v) * DEGREES;
		}
		if (wide[i] <= corner_deg)
			wide[i] = 0;
		else if (!smooth) {
			const double around = fmax(plain[(i + n - 1) % n], plain[(i + 1) % n]);
			if (plain[i] <= corner_deg || (plain[i] <= SURE_CORNER_DEG && plain[i] <= CORNER_PROMINENCE * around))
				wide[i] = 0;
			else
				is_node[walk->vertex[i]] = true, wide[i] = 0;
		}
	}
	/* Smooth borders: what is left in wide spreads over the reach; its peaks are the corners, unless they bend all along. */
	for (size_t i = begin; i < end; i++) {
		if (wide[i] == 0)
			continue;
		bool peak = true;
		double total = 0;
		size_t counted = 0;
		for (size_t k = 1; k <= SMOOTH_EDGES && peak; k++) {
			const size_t before = walk->closed || i >= k ? (i + n - k % n) % n : i,
				     after = walk->closed || i + k < n ? (i + k) % n : i;
			if ((before != i && wide[before] >= wide[i]) || (after != i && wide[after] > wide[i]))
				peak = false;
			if (k == SMOOTH_EDGES)
				total += wide[before] + wide[after], counted += 2;
		}
		if (peak && counted > 0 && total / (double)counted * 2 < wide[i])
			is_node[walk->vertex[i]] = true;
	}
	free(plain), free(wide);
}

static double longest_side(const struct dense *dense)
{
	double side = 0;
	for (size_t k = 0; k < 3; k++) {
		double low = INFINITY, high = -INFINITY;
		for (size_t v = 0; v < dense->vertex_count; v++)
			low = fmin(low, dense->xyz[3 * v + k]), high = fmax(high, dense->xyz[3 * v + k]);
		side = fmax(side, high - low);
	}
	return side;
}

static void find_nodes(bool *is_node, struct boundary *boundary, const struct dense *dense, const struct border_options *options)
{
	const double side = longest_side(dense);
	bool *used = mem_array(boundary->edge_count, sizeof *used), *extra = mem_array(dense->vertex_count, sizeof *extra);
	struct walk walk = {0};
	mark_nodes(is_node, boundary, dense->vertex_count);
	for (size_t next = 0; walk_next(&walk, used, boundary, dense, is_node, &next);) {
		clean_stretches(boundary->edge, &walk, LEAST_STRETCH * side);
		const size_t n = walk.edge_count;
		for (size_t i = walk.closed ? 0 : 1; i < n; i++) {
			const bool before = boundary->edge[walk.edge[(i + n - 1) % n]].sharp;
			if (before != boundary->edge[walk.edge[i]].sharp)
				extra[walk.vertex[i]] = true;
		}
		mark_corners(extra, boundary->edge, &walk, dense->xyz, side, options->corner_deg);
	}
	for (size_t v = 0; v < dense->vertex_count; v++)
		is_node[v] |= extra[v];
	walk_free(&walk);
	free(used), free(extra);
}

static void trace_chains(struct border_network *network, const struct boundary *boundary, const struct dense *dense,
			 const bool *is_node)
{
	size_t chain_room = 16, vertex_room = 64;
	network->chain = mem_array(chain_room, sizeof *network->chain);
	network->vertex = mem_array(vertex_room, sizeof *network->vertex);
	bool *used = mem_array(boundary->edge_count, sizeof *used);
	struct walk walk = {0};
	for (size_t next = 0; walk_next(&walk, used, boundary, dense, is_node, &next);) {
		const struct boundary_edge *e = boundary->edge + walk.edge[0];
		if (e->a != walk.vertex[0]) { /* only darts, which have no left */
			for (size_t i = 0, j = walk.vertex_count - 1; i < j; i++, j--) {
				const idx_t v = walk.vertex[i];
				walk.vertex[i] = walk.vertex[j], walk.vertex[j] = v;
			}
		}
		if (network->chain_count == chain_room)
			network->chain = mem_resize(network->chain, chain_room *= 2, sizeof *network->chain);
		while (network->vertex_count + walk.vertex_count > vertex_room)
			network->vertex = mem_resize(network->vertex, vertex_room *= 2, sizeof *network->vertex);
		network->chain[network->chain_count++] = (struct border_chain){
			.left = e->left,
			.right = e->right,
			.kind = e->right < 0 ? CURVE_BORDER
				: e->sharp   ? CURVE_SHARP
					     : CURVE_SMOOTH,
			.closed = walk.closed,
			.first = network->vertex_count,
			.count = walk.vertex_count,
		};
		memcpy(network->vertex + network->vertex_count, walk.vertex, walk.vertex_count * sizeof *walk.vertex);
		network->vertex_count += walk.vertex_count;
	}
	walk_free(&walk);
	free(used);
}

/* Direction in which a chain leaves one of its ends, over the corner's reach. */
static void end_tangent(double out[3], const struct border_network *network, const struct border_chain *chain, const double *xyz,
			bool at_start, double reach)
{
	const idx_t *v = network->vertex + chain->first;
	const double *p = xyz + 3 * (size_t)(at_start ? v[0] : v[chain->count - 1]);
	const double *last = p;
	double gone = 0;
	for (size_t i = 1; i < chain->count && (i <= 2 || gone < reach); i++) {
		const double *q = xyz + 3 * (size_t)(at_start ? v[i] : v[chain->count - 1 - i]);
		double u[3], w[3];
		sub3(u, last, p);
		sub3(w, q, last);
		if (i > 1 && angle3(u, w) * DEGREES > 30)
			break; /* a corner beside the node is not its tangent */
		gone += norm3(w);
		last = q;
	}
	sub3(out, last, p);
	normalise3(out);
}

static void name_nodes(struct border_network *network, const struct dense *dense, const bool *is_node, double corner_deg)
{
	network->node_of_vertex = mem_array(dense->vertex_count, sizeof *network->node_of_vertex);
	for (size_t v = 0; v < dense->vertex_count; v++)
		network->node_of_vertex[v] = is_node[v] ? (idx_t)network->node_count++ : NO_INDEX;
	network->node = mem_array(network->node_count, sizeof *network->node);
	network->node_kind = mem_array(network->node_count, 1);
	unsigned char *creases = mem_array(network->node_count, 1);
	double *tangent = mem_array(6 * network->node_count, sizeof *tangent);
	for (size_t v = 0; v < dense->vertex_count; v++)
		if (is_node[v])
			network->node[network->node_of_vertex[v]] = (idx_t)v;
	const double reach = CORNER_REACH * longest_side(dense);
	for (size_t c = 0; c < network->chain_count; c++) {
		const struct border_chain *chain = network->chain + c;
		if (chain->closed || chain->kind == CURVE_SMOOTH)
			continue;
		for (int end = 0; end < 2; end++) {
			const size_t node =
				(size_t)network
					->node_of_vertex[network->vertex[end ? chain->first + chain->count - 1 : chain->first]];
			if (creases[node] < 2)
				end_tangent(tangent + 6 * node + 3 * creases[node], network, chain, dense->xyz, end == 0, reach);
			if (creases[node] < 3)
				creases[node]++;
		}
	}
	for (size_t i = 0; i < network->node_count; i++) {
		double back[3];
		copy3(back, tangent + 6 * i);
		scale3(back, -1);
		network->node_kind[i] = creases[i] == 2 && angle3(back, tangent + 6 * i + 3) * DEGREES > corner_deg
						? POINT_CORNER
						: POINT_JUNCTION;
	}
	free(creases), free(tangent);
}

bool border_extract(struct border_network *network, const struct dense *dense, struct border_options options, struct fault *fault)
{
	*network = (struct border_network){0};
	struct boundary boundary = {0};
	if (!boundary_find(&boundary, dense, &options, fault))
		return false;
	bool *is_node = mem_array(dense->vertex_count, sizeof *is_node);
	find_nodes(is_node, &boundary, dense, &options);
	trace_chains(network, &boundary, dense, is_node);
	name_nodes(network, dense, is_node, options.corner_deg);
	network->dart_edge_count = boundary.dart_edge_count;
	network->euler = boundary.euler;
	boundary_free(&boundary);
	free(is_node);
	return true;
}

void border_free(struct border_network *network)
{
	free(network->node), free(network->node_kind), free(network->node_of_vertex), free(network->chain), free(network->vertex);
	*network = (struct border_network){0};
}
