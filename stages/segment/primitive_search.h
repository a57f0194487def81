/* Find analytic surfaces that explain large connected parts of a mesh. */
#ifndef CAGEWRIGHT_PRIMITIVE_SEARCH_H
#define CAGEWRIGHT_PRIMITIVE_SEARCH_H

#include "stages/segment/flats.h"
#include "stages/segment/regions.h"

struct search_options {
	double distance;         /* tolerance, longest side 1 */
	double angle;            /* radians, tolerance of normals beyond noise of the vertices */
	double least_area;       /* smallest patch of a dense, noisy mesh; 0 for exact tessellations */
	size_t work_most;        /* bound of the search, in triangle visits */
};

/* Give every triangle that is explained by some surface to a region, the largest surfaces first, the simplest where two
 * explain about the same. The others keep NO_INDEX. Deterministic. */
void primitive_search(struct regions *regions, const struct flats *flats, const struct search_options *options);

#endif
