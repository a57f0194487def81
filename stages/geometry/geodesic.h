/* Approximate geodesic paths: Dijkstra on mesh vertices and Steiner points of the edges, inside one patch. */
#ifndef CAGEWRIGHT_GEODESIC_H
#define CAGEWRIGHT_GEODESIC_H

#include "stages/geometry/half.h"

struct geodesic; /* graph and workspace, opaque */

/* A path: points with the mesh element that each lies on. */
struct geodesic_path {
	size_t count;
	double *xyz;        /* 3 a point, from source to target */
	idx_t *half;        /* half-edge that the point lies on (origin when at a vertex) */
	double *along;      /* [0, 1) from its origin; 0 = at the vertex */
	double length;
};
void geodesic_path_free(struct geodesic_path *path);

/* steiner points an edge (2 is enough for a few per cent of length), up to four times as many on the long sides of slivers. label/only: stay inside triangles with that label (label NULL: all). */
struct geodesic *geodesic_new(const double *xyz, const struct half *half, const idx_t *label, idx_t only, int steiner);
void geodesic_free(struct geodesic *geodesic);

/* Distances in the graph from a vertex to all (INFINITY where unreachable), then paths back from any vertex. O(m log m). Ties by
 * index. A path is straightened on its way through the same edges, so it may be a little shorter than the distance; count is 0 when the
 * target was not reached. */
void geodesic_from(struct geodesic *geodesic, idx_t source);
double geodesic_distance(const struct geodesic *geodesic, idx_t vertex);
void geodesic_path(struct geodesic_path *path, const struct geodesic *geodesic, idx_t target);

#endif
