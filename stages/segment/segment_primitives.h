/* Partition by analytic surfaces, with free-form regions where none explains the mesh. */
#ifndef CAGEWRIGHT_SEGMENT_PRIMITIVES_H
#define CAGEWRIGHT_SEGMENT_PRIMITIVES_H

#include "stages/segment/regions.h"

struct primitives_options {
	double distance;         /* tolerance, longest side 1; 0: from the noise of the mesh */
	double least_area;       /* share of the whole: free regions (noisy meshes: all regions) below it are absorbed */
};

struct primitives_report {
	double noise;            /* typical distance of a vertex to the surface that explains it, longest side 1 */
	double distance;         /* tolerance that was used */
	bool is_noisy;
	double free_share;       /* of the area: not explained */
};

/* Label all triangles. regions comes initialised and empty. */
void segment_primitives(struct regions *regions, const struct primitives_options *options, struct primitives_report *report);

#endif
