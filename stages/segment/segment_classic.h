/* Partition by curvature: the published method for whole meshes, and what default segmentation does where no analytic
 * surface explains the mesh. */
#ifndef CAGEWRIGHT_SEGMENT_CLASSIC_H
#define CAGEWRIGHT_SEGMENT_CLASSIC_H

#include "formats/dense.h"
#include "stages/segment/regions.h"

struct classic_options {
	int clusters;             /* 0: automatic */
	double stop;              /* D_stop of merging, asinh units */
	double least_area;        /* share of the whole */
	size_t charts_most;       /* most free regions after cutting strongly turned ones */
	double distance;          /* tolerance in which a finished region counts as an analytic surface, longest side 1 */
};

struct classic_report {
	int clusters;
	size_t grown, united;     /* regions after growing; unions */
};

/* Label every triangle. regions comes initialised and empty. */
void segment_classic(struct regions *regions, const struct dense *dense, const struct classic_options *options, struct classic_report *report);

/* Divide free regions: smooth parts of the mesh that are mostly free become compact charts (a scan, a free-form body), other large free
 * regions are classified by curvature; then the strongly turned ones are cut. */
void segment_free(struct regions *regions, const struct dense *dense, const struct classic_options *options);

#endif
