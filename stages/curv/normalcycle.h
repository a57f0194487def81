/* Curvature tensors of a triangle mesh by normal cycles, one a wedge.
 *
 * D. Cohen-Steiner, J.-M. Morvan: Restricted Delaunay triangulations and normal cycle (2003), with the corrections of
 * the patch method's sections 1.2-1.5: connected ball, exact area, rotation of the edges into the wedge's tangent plane. */
#ifndef CAGEWRIGHT_NORMALCYCLE_H
#define CAGEWRIGHT_NORMALCYCLE_H

#include <stdbool.h>

#include "stages/geometry/half.h"

struct normalcycle_options {
	double radius;       /* of every ball, in units of xyz; 0: from the width of the facets */
	double radius_low;   /* bounds of the automatic radius; default 0.003 and 0.06 */
	double radius_high;
	bool no_rotation;    /* without the rotation correction (to compare) */
	bool one_ring;       /* the wedge's own triangles instead of a ball */
};

/* The mesh: xyz with the longest side of its bounding box 1; normal and bend as of wedge_triangle_normals and
 * wedge_bends; stop[h] != 0 where a ball may not cross (sharp edges and borders). */
struct normalcycle_mesh {
	const double *xyz, *normal, *bend;
	const unsigned char *stop;
	const struct half *half;
	const idx_t *triangle_wedge;
	const idx_t *wedge_vertex;
	size_t wedge_count;
};

/* Arrays of wedge_count (times 3 for vectors), filled. Curvatures in 1 / unit of xyz, convex > 0, |kmin| <= |kmax|;
 * dmin unit, tangent, the direction in which the surface bends by kmin; radius what was used (0 for one ring). */
struct normalcycle_result {
	double *normal, *kmin, *kmax, *dmin, *anisotropy, *radius;
	unsigned char *quality; /* enum wedge_quality */
};

/* O(wedges * triangles a ball); a ball of more than 20000 triangles is halved. The same bits for any number of threads. */
void normalcycle_tensors(struct normalcycle_result *result, const struct normalcycle_mesh *mesh, const struct normalcycle_options *options);

#endif
