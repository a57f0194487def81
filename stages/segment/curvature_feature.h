/* Curvature of triangles as the published method classifies it. */
#ifndef CAGEWRIGHT_CURVATURE_FEATURE_H
#define CAGEWRIGHT_CURVATURE_FEATURE_H

#include "formats/dense.h"
#include "stages/segment/facets.h"

struct curvature_feature {
	double *value;            /* 2 a triangle: asinh(kmin), asinh(kmax) of the mean of its wedges, longest side 1 */
	double *direction;        /* 3 a triangle: mean direction of kmin, unit, either sense; 0 where there is none */
	double *wedge_value;      /* 2 a wedge */
	unsigned char *is_flat;   /* nothing bent about it */
};

void curvature_feature_build(struct curvature_feature *feature, const struct dense *dense, const struct facets *facets);
void curvature_feature_free(struct curvature_feature *feature);

#endif
