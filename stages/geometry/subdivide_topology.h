/* Edges, valences and creases of a level, and walks around its vertices. Private to subdivision. */
#ifndef CAGEWRIGHT_SUBDIVIDE_TOPOLOGY_H
#define CAGEWRIGHT_SUBDIVIDE_TOPOLOGY_H

#include "stages/geometry/subdivide.h"

enum vertex_kind { KIND_SMOOTH, KIND_DART, KIND_CREASE, KIND_CORNER };

/* A corner h of face_corner stands for the directed edge from its vertex to that of the next corner. */
struct topology {
	size_t edge_count;
	idx_t *edge;            /* a corner: its edge; edges are numbered in the order of their first corner */
	idx_t *half;            /* 2 an edge: its corners, lower first; the second is NO_INDEX at a border */
	idx_t *face;            /* a corner: its face */
	unsigned char *crease;  /* an edge: sharp or border */
	unsigned char *kind;    /* a vertex: enum vertex_kind */
	idx_t *valence;         /* a vertex: faces at it; of a smooth vertex also its edges */
	idx_t *quads;           /* a vertex: faces at it that a step splits into quads */
};

/* Everything about a valid level. O(n). */
void topology_build(struct topology *topology, const struct level *level, enum cage_scheme scheme);
void topology_free(struct topology *topology);

/* Is a face of this degree split into quads (true) or into four triangles? */
static inline bool splits_to_quads(size_t degree, enum cage_scheme scheme)
{
	return degree != 3 || scheme == SCHEME_CATMULLCLARK;
}

static inline size_t corner_next(const struct level *level, const struct topology *topology, size_t h)
{
	const idx_t f = topology->face[h];
	return h + 1 == level->face_start[f + 1] ? level->face_start[f] : h + 1;
}
static inline size_t corner_previous(const struct level *level, const struct topology *topology, size_t h)
{
	const idx_t f = topology->face[h];
	return h == level->face_start[f] ? level->face_start[f + 1] - 1 : h - 1;
}
/* The corner of the same edge in the other face, or NO_INDEX. */
static inline idx_t corner_twin(const struct topology *topology, size_t h)
{
	const idx_t *half = topology->half + 2 * (size_t)topology->edge[h];
	return half[0] == (idx_t)h ? half[1] : half[0];
}

#endif
