/* Partition by analytic surfaces, with free-form regions where none explains the mesh. */
#ifndef CAGEWRIGHT_SEGMENT_PRIMITIVES_H
#define CAGEWRIGHT_SEGMENT_PRIMITIVES_H

#include "stages/segment/regions.h"

struct primitives_options {
	double distance;         /* tolerance, longest side 1; 0: chosen for each smooth part of the mesh */
	double least_area;       /* share of the whole: free regions (noisy meshes: all regions) below it are absorbed */
};

#define PRIMITIVES_LEVELS 4
struct primitives_report {
	double distance[PRIMITIVES_LEVELS]; /* tolerances that were tried */
	double area_share[PRIMITIVES_LEVELS]; /* of the mesh that took each */
	double noise;            /* root mean square distance of vertices to the surfaces that explain them, longest side 1 */
	double free_share;       /* of the area: not explained */
};

/* Label all triangles. regions comes initialised and empty; what no surface explains ends in free regions, one for each
 * connected set. */
void segment_primitives(struct regions *regions, const struct primitives_options *options, struct primitives_report *report);

#endif
