/* The triangles of a dense mesh as a graph: neighbours, bends, sizes, in units of the part's longest side. */
#ifndef CAGEWRIGHT_FACETS_H
#define CAGEWRIGHT_FACETS_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/dense.h"

/* Half-edge h = 3 * triangle + k runs from corner k to corner k + 1. */
struct facets {
	size_t vertex_count, triangle_count;
	const idx_t *triangle;   /* 3 a triangle; belongs to the dense mesh */
	double *xyz;             /* 3 a vertex; box centre at 0, longest side 1 */
	double centre[3], side;  /* model = centre + side * xyz */
	idx_t *neighbour;        /* triangle across half-edge h, NO_INDEX at borders and where the mesh is no manifold */
	idx_t *twin;             /* the half-edge on the other side, NO_INDEX likewise */
	unsigned char *is_sharp; /* half-edge is sharp, border or cut: regions do not grow across */
	double *bend;            /* bending angle at half-edge h, radians, > 0 convex; 0 at borders */
	double *length;          /* of half-edge h */
	double *normal;          /* 3 a triangle, unit; 0 for triangles without area */
	double *centroid;        /* 3 a triangle */
	const idx_t *wedge;      /* 3 a triangle: the wedge at each corner; belongs to the dense mesh */
	double *wedge_normal;    /* 3 a wedge, unit: mean of its triangles by angle */
	double *area, *height;   /* a triangle; height over its longest edge */
	double total_area;
	idx_t *smooth_part;      /* connected set of triangles over edges that are not sharp */
	size_t smooth_part_count;
};

/* dense must outlive the facets. O(n log n). */
void facets_build(struct facets *facets, const struct dense *dense);
void facets_free(struct facets *facets);

/* Parameters between the unit of the facets and model units. */
void facets_to_model(const struct facets *facets, struct dense_patch *patch);
void facets_from_model(const struct facets *facets, struct dense_patch *patch);

#endif
