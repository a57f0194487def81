/* Half-edges of polygon meshes as flat arrays.
 *
 * Half-edge h is the corner h of the face lists: it starts at origin[h] and runs to origin[next[h]]. For triangles
 * h = 3 * face + k. twin[h] is NO_INDEX at a border. */
#ifndef CAGEWRIGHT_HALF_H
#define CAGEWRIGHT_HALF_H

#include <stdbool.h>

#include "formats/fault.h"
#include "formats/memory.h"

struct half {
	size_t vertex_count, face_count, half_count;
	idx_t *origin, *next, *previous, *twin, *face; /* half_count each */
	idx_t *outgoing;  /* a vertex: one half-edge that starts there; at a border the one without twin (nothing on its right
	                     side), from which a walk over twin[previous[h]] meets all; NO_INDEX for a vertex without faces */
};

/* Build from face lists (as in struct mesh). Connectivity comes from OpenMesh (through the shim) for manifold input.
 * Faults (EX_BAD_INPUT): an edge with more than two faces, two faces that run along an edge in the same direction, a vertex
 * with more than one fan, a face with a repeated vertex. O(n). */
bool half_build(struct half *half, const idx_t *corner, const size_t *face_start, size_t face_count, size_t vertex_count, struct fault *fault);
/* Triangles: 3 * triangle_count indices. */
bool half_build_triangles(struct half *half, const idx_t *triangle, size_t triangle_count, size_t vertex_count, struct fault *fault);
void half_free(struct half *half);

/* Number of edges (twins counted once). */
size_t half_edge_count(const struct half *half);

#endif
