/* Polygons to triangles. */
#ifndef CAGEWRIGHT_TRIANGULATE_H
#define CAGEWRIGHT_TRIANGULATE_H

#include "formats/mesh.h"

/* Polygons with up to this many corners are cut by their best ears, a quadratic search; larger ones by the first ears found. */
#define TRIANGULATE_BEST_MOST 200

/* Cut one polygon of count >= 3 corners (vertex indices) into count - 2 triangles of the same orientation.
 * Quads by the diagonal that leaves no triangle turned over, else the shorter one (ties: the first); larger ones by ears (Meisters 1975)
 * in the plane of the Newell normal. Keeps the area of planar simple polygons; the others get triangles too, and time is bounded:
 * about O(n log n) for usual ones, never more than some 10^8 steps. */
void triangulate_polygon(idx_t *restrict triangle, const double *restrict xyz, const idx_t *restrict corner, size_t count);

/* All faces of a mesh: returns 3 * *triangle_count indices (caller frees); *face, when not NULL, gets the face that each
 * triangle comes from (caller frees). Faces with less than 3 corners give nothing. */
idx_t *triangulate_mesh(size_t *triangle_count, idx_t **face, const double *xyz, const idx_t *corner, const size_t *face_start,
                        size_t face_count);

#endif
