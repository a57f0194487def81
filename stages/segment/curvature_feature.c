/* Curvature of triangles: the mean of their wedges, so that a vertex on a sharp edge counts with the right side only. */
#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/geometry/eigen3.h"
#include "stages/geometry/vector.h"
#include "stages/segment/curvature_feature.h"

#define FLAT_FEATURE 0.05  /* asinh of curvature * longest side: a radius of 20 sides */

void curvature_feature_build(struct curvature_feature *c, const struct dense *dense, const struct facets *f)
{
	const size_t n = dense->triangle_count;
	*c = (struct curvature_feature){
		.value = mem_array(2 * n, sizeof *c->value), .direction = mem_array(3 * n, sizeof *c->direction),
		.wedge_value = mem_array(2 * dense->wedge_count, sizeof *c->wedge_value), .is_flat = mem_array(n, 1)};
	for (size_t w = 0; w < dense->wedge_count; w++) {
		c->wedge_value[2 * w] = asinh(dense->kmin[w] * f->side);
		c->wedge_value[2 * w + 1] = asinh(dense->kmax[w] * f->side);
	}
	for (size_t t = 0; t < n; t++) {
		double kmin = 0, kmax = 0, m[6] = {0}, value[3], vector[3][3];
		bool has_direction = false;
		for (int k = 0; k < 3; k++) {
			const idx_t w = dense->triangle_wedge[3 * t + k];
			kmin += dense->kmin[w] / 3;
			kmax += dense->kmax[w] / 3;
			if (dense->quality[w] != WEDGE_GOOD)
				continue;
			const double *d = dense->dmin + 3 * w;
			has_direction = true;
			m[0] += d[0] * d[0], m[1] += d[0] * d[1], m[2] += d[0] * d[2];
			m[3] += d[1] * d[1], m[4] += d[1] * d[2], m[5] += d[2] * d[2];
		}
		c->value[2 * t] = asinh(kmin * f->side);
		c->value[2 * t + 1] = asinh(kmax * f->side);
		c->is_flat[t] = fabs(c->value[2 * t]) < FLAT_FEATURE && fabs(c->value[2 * t + 1]) < FLAT_FEATURE;
		if (has_direction) {
			eigen3_symmetric(value, vector, m);
			copy3(c->direction + 3 * t, vector[2]);
		}
	}
}

void curvature_feature_free(struct curvature_feature *c)
{
	free(c->value);
	free(c->direction);
	free(c->wedge_value);
	free(c->is_flat);
	*c = (struct curvature_feature){0};
}
