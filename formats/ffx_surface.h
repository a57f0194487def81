/* Half-edges of a polygon mesh whose borders are closed with hole faces: what the coder walks on. Private to formats/ffx*.
 *
 * Half-edge h starts at origin[h]; twin[h] runs the other way; next and previous go around the face to its left. Every half-edge
 * has a twin and a face, which is a hole outside the border. */
#ifndef CAGEWRIGHT_FFX_SURFACE_H
#define CAGEWRIGHT_FFX_SURFACE_H

#include "formats/fault.h"
#include "formats/memory.h"

struct ffx_surface {
	size_t half_count, face_count, vertex_count, hole_count;
	idx_t *next, *previous, *twin, *origin, *face; /* half_count each */
	idx_t *first;                                  /* a face: one of its half-edges */
	idx_t *degree;                                 /* a face */
	unsigned char *hole;                           /* a face: 1 outside a border */
	idx_t *outgoing;                               /* a vertex: one half-edge that starts there */
	idx_t *root;                                   /* decoded surfaces: the start half-edge of each component */
	size_t component_count;
};

void surface_free(struct ffx_surface *surface);

/* From face lists (as in struct mesh); half-edge h < face_start[face_count] is corner h of the lists. Faults (EX_BAD_INPUT):
 * fewer than 3 corners or a repeated vertex in a face, an edge with more than two faces or two that run along it in the same
 * direction, a vertex with no face or more than one fan of faces. O(n log n). */
bool surface_build(struct ffx_surface *surface, const idx_t *corner, const size_t *face_start, size_t face_count,
		   size_t vertex_count, struct fault *fault);

/* A decoded surface may be what no cage is: a face that meets itself, two edges between the same vertices, touching holes. */
bool surface_check(const struct ffx_surface *surface, struct fault *fault);

static inline idx_t surface_end(const struct ffx_surface *surface, idx_t half)
{
	return surface->origin[surface->twin[half]];
}

/* The next half-edge that starts at the same vertex, clockwise. */
static inline idx_t surface_turn(const struct ffx_surface *surface, idx_t half)
{
	return surface->next[surface->twin[half]];
}

#endif
