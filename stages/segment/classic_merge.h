/* The published segmentation, second half: merging on the region adjacency graph
 * (Lavoue, Dupont, Baskurt, CAD 37, 2005, section 5), with the curvatures in asinh units. */
#ifndef CAGEWRIGHT_CLASSIC_MERGE_H
#define CAGEWRIGHT_CLASSIC_MERGE_H

#include "stages/segment/curvature_feature.h"
#include "stages/segment/regions.h"

struct merge_options {
	double stop;              /* largest distance D_ij at which two regions unite */
	double least_area;        /* regions below it unite with their nearest neighbour in any case */
};

/* Unite free regions. Regions of analytic surfaces stay as they are. Dense gives the wedges along the borders. Returns how many
 * unions there were. O(A log A) for A adjacencies. */
size_t classic_merge(struct regions *regions, const struct dense *dense, const struct curvature_feature *feature, const struct merge_options *options);

#endif
