/* Normal and curvature at a foot point. */
#include "stages/fitpatch/frame.h"

#include <math.h>

#include "stages/geometry/eigen3.h"
#include "stages/geometry/vector.h"

struct foot frame_foot(const struct nearest *nearest, const struct dense *dense, idx_t patch, const double p[3])
{
	const struct nearest_filter filter = {.label = dense->label, .only = patch};
	return nearest_point(nearest, p, INFINITY, &filter);
}

void frame_at(struct frame *frame, const struct dense *dense, const struct foot *foot)
{
	double tensor[6] = {0}, anisotropy = 0;
	*frame = (struct frame){0};
	for (int k = 0; k < 3; k++) {
		const size_t w = (size_t)dense->triangle_wedge[3 * (size_t)foot->triangle + (size_t)k];
		const double *n = &dense->wedge_normal[3 * w], *d = &dense->dmin[3 * w];
		const double weight = foot->weight[k];
		double across[3];
		cross3(across, n, d);
		add_scaled3(frame->normal, weight, n);
		anisotropy += weight * (dense->quality[w] == WEDGE_GOOD ? dense->anisotropy[w] : 0);
		const double a = weight * dense->kmin[w], b = weight * dense->kmax[w];
		tensor[0] += a * d[0] * d[0] + b * across[0] * across[0];
		tensor[1] += a * d[0] * d[1] + b * across[0] * across[1];
		tensor[2] += a * d[0] * d[2] + b * across[0] * across[2];
		tensor[3] += a * d[1] * d[1] + b * across[1] * across[1];
		tensor[4] += a * d[1] * d[2] + b * across[1] * across[2];
		tensor[5] += a * d[2] * d[2] + b * across[2] * across[2];
	}
	if (normalise3(frame->normal) < 0.5) /* wedges disagree: a pole or a sliver */
		copy3(frame->normal, foot->normal);
	double value[3], vector[3][3];
	eigen3_symmetric(value, vector, tensor);
	int out = 0;
	for (int i = 1; i < 3; i++)
		if (fabs(dot3(vector[i], frame->normal)) > fabs(dot3(vector[out], frame->normal)))
			out = i;
	int first = (out + 1) % 3, second = (out + 2) % 3;
	if (fabs(value[first]) > fabs(value[second])) {
		const int swap = first;
		first = second, second = swap;
	}
	frame->k1 = value[first], frame->k2 = value[second];
	frame->anisotropy = anisotropy;
	copy3(frame->e1, vector[first]);
	add_scaled3(frame->e1, -dot3(frame->e1, frame->normal), frame->normal);
	if (normalise3(frame->e1) < 1e-6) {
		const double x[3] = {fabs(frame->normal[0]) < 0.6, fabs(frame->normal[0]) >= 0.6, 0};
		cross3(frame->e1, frame->normal, x);
		normalise3(frame->e1);
	}
}
