/* One patch of the dense mesh as a triangle mesh of its own that can be thinned out.
 *
 * Vertices can be removed (the hole is triangulated again at least cost) and edges swapped, which ends in a triangulation
 * of nothing but the control points of the patch's border. */
#ifndef CAGEWRIGHT_SHEET_H
#define CAGEWRIGHT_SHEET_H

#include <stdbool.h>

#include "formats/memory.h"

/* Half-edge h = 3 * triangle + k starts at origin[h]; a dead triangle has origin NO_INDEX. */
struct sheet {
	size_t vertex_count, triangle_count; /* rooms; dead ones included */
	double *xyz;            /* 3 a vertex */
	idx_t *origin, *twin;   /* 3 a triangle; twin NO_INDEX at the border */
	idx_t *outgoing;        /* a vertex: a half-edge that starts there, at the border the one without twin; NO_INDEX: dead */
	idx_t *point;           /* a vertex: the control point anchored here, or NO_INDEX */
	idx_t *segment;         /* a border half-edge: what the maker says of it (the dense half-edge it lies on) */
	size_t capacity;        /* triangles that there is room for */
	size_t vertex_capacity;
};

static inline idx_t sheet_next(idx_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
static inline idx_t sheet_previous(idx_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
static inline idx_t sheet_target(const struct sheet *sheet, idx_t h) { return sheet->origin[sheet_next(h)]; }

/* From triangles of a dense mesh (list of count triangle indices, all of one patch) and its twins: neighbours in the list stay
 * connected, a vertex where the patch touches itself becomes one vertex a fan. segment of a border half-edge is the dense half-edge.
 * dense_vertex (caller frees) tells where each vertex comes from. */
void sheet_build(struct sheet *sheet, idx_t **dense_vertex, const idx_t *list, size_t count, const idx_t *dense_triangle,
                 const idx_t *dense_twin, const double *dense_xyz);
void sheet_free(struct sheet *sheet);

/* Split the border half-edge h at xyz; both parts keep h's segment; returns the new vertex, and h ends there. */
idx_t sheet_split_border(struct sheet *sheet, idx_t h, const double xyz[3]);

/* Split the inner edge of h at xyz: its two triangles become four. Returns the new vertex. */
idx_t sheet_split_edge(struct sheet *sheet, idx_t h, const double xyz[3]);

/* Does an edge join the two vertices? */
idx_t sheet_edge(const struct sheet *sheet, idx_t a, idx_t b);

bool sheet_on_border(const struct sheet *sheet, idx_t vertex);

/* Corners around a vertex in counter-clockwise order, at most room; at the border from the next border vertex to the previous one. */
size_t sheet_ring(const struct sheet *sheet, idx_t vertex, idx_t *ring, size_t room);

/* What an edge between two vertices of the sheet costs (>= 0, INFINITY: not allowed), and what a triangle does. */
struct sheet_cost {
	double (*edge)(void *context, idx_t a, idx_t b);
	double (*triangle)(void *context, idx_t a, idx_t b, idx_t c);
	void *context;
};

/* Largest ring that is triangulated again; a vertex with more neighbours has to wait until they are fewer. */
#define SHEET_RING_LIMIT 48

/* Cheapest triangulation of the hole that a vertex would leave (Klincsek 1980, O(ring^3)); INFINITY when there is none.
 * *height (may be NULL) is how far the vertex is from it. With apply, do it. */
double sheet_remove(struct sheet *sheet, idx_t vertex, const struct sheet_cost *cost, double *height, bool apply);

/* Swap the inner edge of h when the other diagonal is cheaper, triangles counted; returns whether it was. */
bool sheet_swap(struct sheet *sheet, idx_t h, const struct sheet_cost *cost);

#endif
