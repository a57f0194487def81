/* Polygons of control points: plane, flatness, and whether the first subdivision step keeps them unfolded. */
#ifndef CAGEWRIGHT_POLYGON_H
#define CAGEWRIGHT_POLYGON_H

#include <stddef.h>

#include "formats/memory.h"

/* Centre (mean of the corners) and unit area normal of a polygon given by count vertex indices. Returns its area (0: normal is 0). */
double polygon_plane(double centre[3], double normal[3], const double *xyz, const idx_t *corner, size_t count);

/* Largest distance of the corners to that plane. */
double polygon_flatness(const double *xyz, const idx_t *corner, size_t count);

/* How much the polygon turns at corner i, seen along unit normal: in degrees, > 0 to the left (convex), (-180, 180]. */
double polygon_turn_deg(const double *xyz, const idx_t *corner, size_t count, size_t i, const double normal[3]);

/* A polygon must not fill the outside of a kink alone: next to a vertex that is kept (a corner), its subdivision surface folds over
 * the two creases. At kept vertices polygons turn outward by at most this. */
#define POLYGON_REFLEX_DEG 5

/* The smallest signed area of the quads (corner, next midpoint, centre, previous midpoint) that the first subdivision step
 * makes, seen along unit normal, relative to the mean of their absolute values: > 0 when the polygon is star-shaped as seen from
 * its vertex centroid; 1 for a regular polygon; <= 0 when a sub-quad folds over. */
double polygon_star(const double *xyz, const idx_t *corner, size_t count, const double normal[3]);

#endif
