/* A polygon mesh that can be edited: half-edges with faces and vertices that may go. */
#ifndef CAGEWRIGHT_POLYMESH_H
#define CAGEWRIGHT_POLYMESH_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/cage.h"
#include "formats/memory.h"

/* Half-edge h runs from origin[h] to origin[next[h]], its face on the left. */
struct polymesh {
	size_t vertex_count, face_count, half_count;
	double *xyz;           /* 3 a vertex */
	unsigned char *corner; /* a vertex: explicit corner */
	idx_t *origin, *next, *previous, *face;
	idx_t *twin; /* NO_INDEX at a border */
	bool *sharp; /* a half-edge: crease, set on both twins; border edges count as creases everywhere */
	idx_t *face_patch;
	idx_t *face_half; /* one half-edge of each face, NO_INDEX when the face is gone */
	bool *half_gone;
};

/* Room for everything; origin, next, previous, face, face_half are laid out from the lists (as in struct cage), twin is
 * NO_INDEX, nothing is sharp. */
void polymesh_init(struct polymesh *mesh, const double *xyz, size_t vertex_count, const idx_t *corner, const size_t *face_start,
		   const idx_t *face_patch, size_t face_count);
void polymesh_copy(struct polymesh *to, const struct polymesh *from);
void polymesh_free(struct polymesh *mesh);

static inline bool polymesh_is_crease(const struct polymesh *mesh, idx_t half)
{
	return mesh->twin[half] == NO_INDEX || mesh->sharp[half];
}

/* One half-edge that leaves each vertex (vertex_count), at a border the one whose previous edge is a border; NO_INDEX where
 * none does. With several fans the last one found. */
void polymesh_outgoing(idx_t *outgoing, const struct polymesh *mesh);

/* Give every fan but the first of each vertex a vertex of its own; returns how many were added. */
size_t polymesh_split_fans(struct polymesh *mesh);

/* Euler characteristic (vertices in use - edges + faces) of each component, components in order of their first face.
 * Returns their number; *euler is the caller's. */
size_t polymesh_euler(long **euler, const struct polymesh *mesh);

/* Vertices in use keep their order, so do faces. */
void polymesh_to_cage(struct cage *cage, const struct polymesh *mesh);

#endif
