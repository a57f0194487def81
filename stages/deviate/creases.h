/* How far the sharp edges of two surfaces are apart (the patch method's section 13.3, item 3). */
#ifndef CAGEWRIGHT_CREASES_H
#define CAGEWRIGHT_CREASES_H

#include "formats/memory.h"

/* Edges of a triangle mesh that bend by more than some angle, or that have one triangle only. */
struct creases {
	idx_t *vertex;          /* 2 an edge, lower first, sorted */
	size_t count;
	double length;          /* of all of them, model units */
};

/* O(n log n). Edges of more than two triangles count as creases. */
void creases_find(struct creases *creases, const double *xyz, const idx_t *triangle, size_t triangle_count, double sharp_deg);
void creases_free(struct creases *creases);

struct crease_distance {
	double mean, rms, p99, max; /* model units; all but max uniform by length, max with the ends of the edges */
	double worst[3];        /* where max was found */
};

/* From samples on the creases of one surface to the nearest crease of another one; both must have some, and there
 * must be samples. O((samples + count) log count). */
void creases_distance(struct crease_distance *out, const double *xyz, const struct creases *from, const double *to_xyz,
                      size_t to_vertex_count, const struct creases *to, size_t samples);

#endif
