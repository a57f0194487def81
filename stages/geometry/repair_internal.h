/* The steps of repair_mesh, on one soup of triangles. Private to repair*.c. */
#ifndef CAGEWRIGHT_REPAIR_INTERNAL_H
#define CAGEWRIGHT_REPAIR_INTERNAL_H

#include "stages/geometry/repair.h"

/* A triangle lower than this over its longest edge has no area. Relative to the longest side of the box (section 0.5). */
#define REPAIR_FLAT_HEIGHT 1e-7

struct soup {
	double *xyz; /* 3 a vertex, room for vertex_room */
	size_t vertex_count, vertex_room;
	idx_t *triangle; /* 3 a triangle; half-edge h starts at triangle[h] */
	size_t triangle_count, triangle_room;
	idx_t *pair;           /* from soup_pair on: the half-edge that continues the surface over this edge, or NO_INDEX */
	unsigned char *opened; /* from soup_pair on: 1 for half-edges left without pair by a cut */
	double side, diagonal; /* of the box */
	struct repair_report *report;
};

static inline size_t next_half(size_t h)
{
	return h % 3 == 2 ? h - 2 : h + 1;
}
static inline size_t previous_half(size_t h)
{
	return h % 3 == 0 ? h + 2 : h - 1;
}

/* A half-edge by its ends, low < high. */
struct side {
	idx_t low, high, half;
};

/* All half-edges sorted by low, high, half (caller frees). O(n log n). */
struct side *soup_sides(const struct soup *soup);
/* Where the run of equal ends that begins at first is over. */
size_t side_run(const struct side *side, size_t side_count, size_t first);

/* Are nearly all edges with two triangles run through both ways? Then directions can be trusted at the others too. */
bool soup_is_oriented(const struct soup *soup, const struct side *side);

idx_t soup_add_vertex(struct soup *soup, const double xyz[3]);
size_t soup_add_triangle(struct soup *soup, idx_t a, idx_t b, idx_t c); /* pair and opened, where there are some: none */
/* Keep the triangles with keep[t] != 0, in their order. Before soup_pair only. */
void soup_keep(struct soup *soup, const unsigned char *keep);
bool soup_has_border(const struct soup *soup);

/* Step 3: faces with a vertex twice, and faces with the same three vertices. */
void soup_drop_collapsed(struct soup *soup);
void soup_drop_duplicates(struct soup *soup);
/* Step 2 and 4: unite border vertices within distance; split border edges at border vertices within distance. */
void soup_weld_border(struct soup *soup, double distance);
void soup_split_junctions(struct soup *soup, double distance);
/* Step 3: triangles without area. */
void soup_flatten(struct soup *soup);
/* Step 5: which two half-edges go on into each other; then a copy of a vertex for each fan. */
void soup_pair(struct soup *soup);
void soup_split_fans(struct soup *soup);
/* Step 6. turned[t]: 1 for triangles of components in which some had to be turned (triangle_count, caller frees). */
unsigned char *soup_orient(struct soup *soup);
void soup_turn_outward(struct soup *soup, const unsigned char *turned, size_t turned_count);
/* component[t] of each triangle over pairs, numbered by lowest triangle (caller frees). */
idx_t *soup_components(const struct soup *soup, size_t *component_count);

/* Union-find whose roots are the lowest members. */
idx_t find_root(idx_t *parent, idx_t v);
void unite_roots(idx_t *parent, idx_t a, idx_t b);
idx_t *new_roots(size_t count);

/* A tree of axis-parallel boxes (low xyz, high xyz each) to be asked which of them a segment meets. */
struct box_tree {
	size_t node_count, item_count;
	double *box;    /* 6 a node */
	size_t *behind; /* a node: the node behind its part */
	size_t *item;   /* a permutation of the items; node ranges are halves of it */
};
struct box_tree box_tree_new(const double *box, size_t item_count);
void box_tree_free(struct box_tree *tree);
/* Calls visit for each item whose leaf the segment comes within reach of (a superset of the items that it does). */
void box_tree_segment(const struct box_tree *tree, const double from[3], const double to[3], double reach,
		      void (*visit)(void *user, size_t item), void *user);

#endif
