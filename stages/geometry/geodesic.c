/* Shortest paths on a graph of mesh vertices and Steiner points (Lanthier, Maheshwari and Sack 2001): any two nodes on the sides of one
 * triangle are joined by the straight line between them. The arcs are not stored: a node that is settled relaxes the
 * nodes of its triangles. */
#include "stages/geometry/geodesic.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/vector.h"

#define STEINER_MOST 16
/* The long sides of slivers get up to this many times the points asked for: with few, a path across a row of slivers would have to
 * choose between going straight over and far along. */
#define SLIVER_FACTOR 4
/* Straightening a path: rounds at most, and the change, relative to its length, that ends it. */
#define STRAIGHTEN_ROUNDS 200
#define STRAIGHTEN_CHANGE 1e-6
/* A straightened point stays this far, as a share of its edge, from the ends. */
#define STRAIGHTEN_RIM 1e-3

struct geodesic {
	size_t vertex_count, edge_count, triangle_count, node_count; /* of the part inside the label */
	size_t *first_point;    /* edge -> its first Steiner point's node, edge_count + 1 */
	idx_t *point_edge;      /* node - vertex_count -> edge */
	idx_t *local;           /* mesh vertex -> node, NO_INDEX outside */
	size_t mesh_vertex_count;
	idx_t *vertex_half;     /* node of a vertex -> one half-edge inside that starts there */
	idx_t *edge_half;       /* edge -> its half-edge of lower index inside */
	double *xyz;            /* 3 a node: vertices, then the Steiner points of each edge, evenly from its half-edge's origin */
	idx_t *triangle_vertex; /* 3 a triangle */
	idx_t *triangle_edge;   /* 3 a triangle */
	size_t *fan_start;      /* vertex -> its triangles in fan */
	idx_t *fan;
	idx_t *edge_vertex;     /* 2 an edge: the nodes of its ends, from edge_half's origin */
	idx_t *edge_triangle;   /* 2 an edge, NO_INDEX at the rim */
	/* Workspace of the last search. */
	double *distance;
	idx_t *before;          /* the node that each was reached from */
	idx_t *heap, *place;    /* nodes by (distance, index); where each node is in the heap, NO_INDEX outside */
	size_t heap_count;
};

void geodesic_path_free(struct geodesic_path *path)
{
	free(path->xyz);
	free(path->half);
	free(path->along);
	*path = (struct geodesic_path){0};
}

void geodesic_free(struct geodesic *g)
{
	if (g == NULL)
		return;
	free(g->first_point);
	free(g->point_edge);
	free(g->local);
	free(g->vertex_half);
	free(g->edge_half);
	free(g->xyz);
	free(g->triangle_vertex);
	free(g->triangle_edge);
	free(g->fan_start);
	free(g->fan);
	free(g->edge_triangle);
	free(g->edge_vertex);
	free(g->distance);
	free(g->before);
	free(g->heap);
	free(g->place);
	free(g);
}

/* Number the vertices and edges of the triangles inside, in the order in which those come. */
static void number_elements(struct geodesic *g, const struct half *half, const idx_t *label, idx_t only)
{
	idx_t *half_edge = mem_array(half->half_count, sizeof *half_edge); /* half-edge -> edge + 1, 0 for not yet */
	g->mesh_vertex_count = half->vertex_count;
	g->local = mem_array(half->vertex_count, sizeof *g->local);
	for (size_t v = 0; v < half->vertex_count; v++)
		g->local[v] = NO_INDEX;
	for (size_t f = 0; f < half->face_count; f++)
		g->triangle_count += label == NULL || label[f] == only;
	g->vertex_half = mem_array(3 * g->triangle_count, sizeof *g->vertex_half);
	g->edge_half = mem_array(3 * g->triangle_count, sizeof *g->edge_half);
	g->triangle_vertex = mem_array(3 * g->triangle_count, sizeof *g->triangle_vertex);
	g->triangle_edge = mem_array(3 * g->triangle_count, sizeof *g->triangle_edge);
	g->edge_triangle = mem_array(6 * g->triangle_count, sizeof *g->edge_triangle);
	size_t t = 0;
	for (size_t f = 0; f < half->face_count; f++) {
		if (label != NULL && label[f] != only)
			continue;
		for (size_t k = 0; k < 3; k++) {
			const size_t h = 3 * f + k;
			idx_t *node = &g->local[half->origin[h]];
			if (*node == NO_INDEX) {
				*node = (idx_t)g->vertex_count;
				g->vertex_half[g->vertex_count++] = (idx_t)h;
			}
			g->triangle_vertex[3 * t + k] = *node;
			const idx_t twin = half->twin[h];
			idx_t edge = twin != NO_INDEX ? half_edge[twin] - 1 : NO_INDEX; /* set only when the twin is inside and came first */
			if (edge == NO_INDEX) {
				edge = (idx_t)g->edge_count++;
				g->edge_half[edge] = (idx_t)h;
				g->edge_triangle[2 * edge] = (idx_t)t;
				g->edge_triangle[2 * edge + 1] = NO_INDEX;
			} else {
				g->edge_triangle[2 * edge + 1] = (idx_t)t;
			}
			half_edge[h] = edge + 1;
			g->triangle_edge[3 * t + k] = edge;
		}
		t++;
	}
	free(half_edge);
}

static void collect_fans(struct geodesic *g)
{
	g->fan_start = mem_array(g->vertex_count + 2, sizeof *g->fan_start);
	g->fan = mem_array(3 * g->triangle_count, sizeof *g->fan);
	for (size_t c = 0; c < 3 * g->triangle_count; c++)
		g->fan_start[g->triangle_vertex[c] + 2]++;
	for (size_t v = 0; v < g->vertex_count; v++)
		g->fan_start[v + 2] += g->fan_start[v + 1];
	for (size_t c = 0; c < 3 * g->triangle_count; c++) /* afterwards fan_start[v] is where v begins */
		g->fan[g->fan_start[g->triangle_vertex[c] + 1]++] = (idx_t)(c / 3);
}

/* Steiner points of an edge: spaced like the width of the narrower triangle beside it, within [steiner, SLIVER_FACTOR * steiner]. */
static size_t points_of_edge(const struct geodesic *g, size_t edge, const double *a, const double *b, int steiner)
{
	const double length = distance3(a, b);
	double width = length;
	for (int i = 0; i < 2; i++) {
		const idx_t t = g->edge_triangle[2 * edge + i];
		if (t == NO_INDEX)
			continue;
		const idx_t *corner = g->triangle_vertex + 3 * (size_t)t;
		double n[3];
		area_vector3(n, g->xyz + 3 * (size_t)corner[0], g->xyz + 3 * (size_t)corner[1], g->xyz + 3 * (size_t)corner[2]);
		width = fmin(width, length > 0 ? norm3(n) / length : 0);
	}
	const double wanted = width > 0 ? ceil(length / width) - 1 : SLIVER_FACTOR * steiner;
	return (size_t)fmax(steiner, fmin(SLIVER_FACTOR * steiner, wanted));
}

struct geodesic *geodesic_new(const double *xyz, const struct half *half, const idx_t *label, idx_t only, int steiner)
{
	struct geodesic *g = mem_array(1, sizeof *g);
	steiner = steiner < 0 ? 0 : steiner > STEINER_MOST ? STEINER_MOST : steiner;
	number_elements(g, half, label, only);
	collect_fans(g);
	g->xyz = mem_array(3 * g->vertex_count, sizeof *g->xyz);
	for (size_t v = 0; v < g->vertex_count; v++)
		copy3(g->xyz + 3 * v, xyz + 3 * (size_t)half->origin[g->vertex_half[v]]);
	g->first_point = mem_array(g->edge_count + 1, sizeof *g->first_point);
	g->edge_vertex = mem_array(2 * g->edge_count, sizeof *g->edge_vertex);
	g->node_count = g->vertex_count;
	for (size_t e = 0; e < g->edge_count; e++) {
		const idx_t h = g->edge_half[e];
		g->first_point[e] = g->node_count;
		g->edge_vertex[2 * e] = g->local[half->origin[h]];
		g->edge_vertex[2 * e + 1] = g->local[half->origin[half->next[h]]];
		g->node_count += points_of_edge(g, e, xyz + 3 * (size_t)half->origin[h], xyz + 3 * (size_t)half->origin[half->next[h]], steiner);
	}
	g->first_point[g->edge_count] = g->node_count;
	g->xyz = mem_resize(g->xyz, 3 * g->node_count, sizeof *g->xyz);
	g->point_edge = mem_array(g->node_count - g->vertex_count, sizeof *g->point_edge);
	for (size_t e = 0; e < g->edge_count; e++) {
		const idx_t h = g->edge_half[e];
		const double *a = xyz + 3 * (size_t)half->origin[h], *b = xyz + 3 * (size_t)half->origin[half->next[h]];
		const size_t first = g->first_point[e], count = g->first_point[e + 1] - first;
		for (size_t i = 0; i < count; i++) {
			const double u = (double)(i + 1) / (double)(count + 1);
			for (int k = 0; k < 3; k++)
				g->xyz[3 * (first + i) + k] = (1 - u) * a[k] + u * b[k];
			g->point_edge[first + i - g->vertex_count] = (idx_t)e;
		}
	}
	g->distance = mem_array(g->node_count, sizeof *g->distance);
	g->before = mem_array(g->node_count, sizeof *g->before);
	g->heap = mem_array(g->node_count, sizeof *g->heap);
	g->place = mem_array(g->node_count, sizeof *g->place);
	for (size_t n = 0; n < g->node_count; n++) {
		g->distance[n] = INFINITY;
		g->before[n] = g->place[n] = NO_INDEX;
	}
	return g;
}

static bool is_nearer(const struct geodesic *g, idx_t a, idx_t b)
{
	return g->distance[a] != g->distance[b] ? g->distance[a] < g->distance[b] : a < b;
}

static void set_at(struct geodesic *g, size_t i, idx_t node)
{
	g->heap[i] = node;
	g->place[node] = (idx_t)i;
}

static void sift_up(struct geodesic *g, size_t i)
{
	const idx_t node = g->heap[i];
	while (i > 0 && is_nearer(g, node, g->heap[(i - 1) / 2])) {
		set_at(g, i, g->heap[(i - 1) / 2]);
		i = (i - 1) / 2;
	}
	set_at(g, i, node);
}

static idx_t take_nearest(struct geodesic *g)
{
	const idx_t nearest = g->heap[0], node = g->heap[--g->heap_count];
	size_t i = 0;
	for (size_t child; (child = 2 * i + 1) < g->heap_count; i = child) {
		if (child + 1 < g->heap_count && is_nearer(g, g->heap[child + 1], g->heap[child]))
			child++;
		if (is_nearer(g, node, g->heap[child]))
			break;
		set_at(g, i, g->heap[child]);
	}
	if (g->heap_count > 0)
		set_at(g, i, node);
	g->place[nearest] = NO_INDEX;
	return nearest;
}

static void reach(struct geodesic *g, idx_t node, idx_t from, double distance)
{
	if (!(distance < g->distance[node]))
		return;
	const bool is_new = g->place[node] == NO_INDEX;
	g->distance[node] = distance;
	g->before[node] = from;
	if (is_new)
		set_at(g, g->heap_count++, node);
	sift_up(g, (size_t)g->place[node]);
}

static void relax_triangle(struct geodesic *g, idx_t t, idx_t from)
{
	const double *p = g->xyz + 3 * (size_t)from, d = g->distance[from];
	for (int k = 0; k < 3; k++) {
		const idx_t v = g->triangle_vertex[3 * (size_t)t + k];
		reach(g, v, from, d + distance3(p, g->xyz + 3 * (size_t)v));
		const idx_t e = g->triangle_edge[3 * (size_t)t + k];
		for (size_t n = g->first_point[e]; n < g->first_point[e + 1]; n++)
			reach(g, (idx_t)n, from, d + distance3(p, g->xyz + 3 * n));
	}
}

void geodesic_from(struct geodesic *g, idx_t source)
{
	for (size_t n = 0; n < g->node_count; n++) {
		g->distance[n] = INFINITY;
		g->before[n] = g->place[n] = NO_INDEX;
	}
	g->heap_count = 0;
	if (source < 0 || (size_t)source >= g->mesh_vertex_count || g->local[source] == NO_INDEX)
		return;
	reach(g, g->local[source], NO_INDEX, 0);
	while (g->heap_count > 0) {
		const idx_t node = take_nearest(g);
		if ((size_t)node < g->vertex_count) {
			for (size_t i = g->fan_start[node]; i < g->fan_start[node + 1]; i++)
				relax_triangle(g, g->fan[i], node);
		} else {
			const size_t edge = (size_t)g->point_edge[(size_t)node - g->vertex_count];
			for (size_t i = 0; i < 2; i++)
				if (g->edge_triangle[2 * edge + i] != NO_INDEX)
					relax_triangle(g, g->edge_triangle[2 * edge + i], node);
		}
	}
}

static idx_t node_of(const struct geodesic *g, idx_t vertex)
{
	return vertex < 0 || (size_t)vertex >= g->mesh_vertex_count ? NO_INDEX : g->local[vertex];
}

double geodesic_distance(const struct geodesic *g, idx_t vertex)
{
	const idx_t node = node_of(g, vertex);
	return node == NO_INDEX ? INFINITY : g->distance[node];
}

/* Slide each point that lies inside an edge to where the way between its neighbours is shortest: unfolded flat, the point where
 * the straight line crosses the edge. The length is convex in these positions, so rounds of this end at the shortest path
 * through the same edges. */
static void straighten(struct geodesic_path *path, const idx_t *edge, const struct geodesic *g)
{
	for (int round = 0; round < STRAIGHTEN_ROUNDS; round++) {
		double change = 0;
		for (size_t i = 1; i + 1 < path->count; i++) {
			if (edge[i] == NO_INDEX)
				continue;
			const double *a = g->xyz + 3 * (size_t)g->edge_vertex[2 * (size_t)edge[i]];
			const double *b = g->xyz + 3 * (size_t)g->edge_vertex[2 * (size_t)edge[i] + 1];
			double u[3], along[2], off[2];
			sub3(u, b, a);
			const double length = normalise3(u);
			for (int k = 0; k < 2; k++) { /* the neighbours along the edge and off it */
				double d[3];
				sub3(d, path->xyz + 3 * (k == 0 ? i - 1 : i + 1), a);
				along[k] = dot3(d, u);
				add_scaled3(d, -along[k], u);
				off[k] = norm3(d);
			}
			if (!(off[0] + off[1] > 0))
				continue;
			const double at = (along[0] * off[1] + along[1] * off[0]) / (off[0] + off[1]) / length;
			const double slid = fmin(1 - STRAIGHTEN_RIM, fmax(STRAIGHTEN_RIM, at));
			change = fmax(change, fabs(slid - path->along[i]) * length);
			path->along[i] = slid;
			copy3(path->xyz + 3 * i, a);
			add_scaled3(path->xyz + 3 * i, slid * length, u);
		}
		if (!(change > STRAIGHTEN_CHANGE * path->length))
			break;
	}
	path->length = 0;
	for (size_t i = 1; i < path->count; i++)
		path->length += distance3(path->xyz + 3 * (i - 1), path->xyz + 3 * i);
}

void geodesic_path(struct geodesic_path *path, const struct geodesic *g, idx_t target)
{
	*path = (struct geodesic_path){0};
	const idx_t last = node_of(g, target);
	if (last == NO_INDEX || !(g->distance[last] < INFINITY))
		return;
	for (idx_t node = last; node != NO_INDEX; node = g->before[node])
		path->count++;
	path->xyz = mem_array(3 * path->count, sizeof *path->xyz);
	path->half = mem_array(path->count, sizeof *path->half);
	path->along = mem_array(path->count, sizeof *path->along);
	path->length = g->distance[last];
	idx_t *edge = mem_array(path->count, sizeof *edge);
	size_t i = path->count;
	for (idx_t node = last; node != NO_INDEX; node = g->before[node]) {
		copy3(path->xyz + 3 * --i, g->xyz + 3 * (size_t)node);
		if ((size_t)node < g->vertex_count) {
			path->half[i] = g->vertex_half[node];
			edge[i] = NO_INDEX;
		} else {
			const idx_t e = g->point_edge[(size_t)node - g->vertex_count];
			path->half[i] = g->edge_half[e];
			edge[i] = e;
			path->along[i] = (double)((size_t)node - g->first_point[e] + 1) / (double)(g->first_point[e + 1] - g->first_point[e] + 1);
		}
	}
	straighten(path, edge, g);
	free(edge);
}
