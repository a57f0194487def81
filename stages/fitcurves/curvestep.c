/* Normal equations of a curve, banded but for the corner of closed ones, by Cholesky in its envelope. */
#include "stages/fitcurves/curvestep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/curve.h"
#include "stages/geometry/sqdist.h"
#include "stages/geometry/vector.h"

/* Lower triangle, rows start at their first entry that may differ from 0 (envelope); Cholesky keeps the envelope. */
struct system {
	size_t size;   /* 3 a free point */
	double *a, *b; /* size * size, size */
	size_t *first;
};

static bool cholesky_solve(struct system *sys)
{
	const size_t m = sys->size;
	for (size_t r = 0; r < m; r++) {
		double *row = sys->a + r * m;
		for (size_t c = sys->first[r]; c <= r; c++) {
			const double *other = sys->a + c * m;
			double sum = row[c];
			for (size_t k = sys->first[r] > sys->first[c] ? sys->first[r] : sys->first[c]; k < c; k++)
				sum -= row[k] * other[k];
			if (c < r)
				row[c] = sum / other[c];
			else if (sum > 0)
				row[c] = sqrt(sum);
			else
				return false;
		}
	}
	for (size_t r = 0; r < m; r++) {
		for (size_t k = sys->first[r]; k < r; k++)
			sys->b[r] -= sys->a[r * m + k] * sys->b[k];
		sys->b[r] /= sys->a[r * m + r];
	}
	for (size_t r = m; r-- > 0;) {
		sys->b[r] /= sys->a[r * m + r];
		for (size_t k = sys->first[r]; k < r; k++)
			sys->b[k] -= sys->a[r * m + k] * sys->b[r];
	}
	return true;
}

bool curvestep(double *xyz_out, const struct curvefit *fit, const struct curvesample *samples, size_t sample_count,
	       double proximal)
{
	const size_t n = fit->count, offset = fit->closed ? 0 : 1, free_count = fit->closed ? n : n - 2, m = 3 * free_count;
	static const size_t packed[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
	struct system sys = {.size = m,
			     .a = mem_array(m * m, sizeof(double)),
			     .b = mem_array(m, sizeof(double)),
			     .first = mem_array(m, sizeof(size_t))};
	for (size_t r = 0; r < m; r++) {
		const size_t block = r / 3;
		sys.first[r] = block < 3 || (fit->closed && block + 3 >= n) ? 0 : 3 * (block - 3);
	}
	for (size_t k = 0; k < sample_count; k++) {
		const struct curvesample *sample = samples + k;
		size_t index[4];
		double coefficient[4], metric[6], delta[3], target[3];
		const size_t used = curve_row(index, coefficient, n, fit->closed, sample->u);
		sub3(delta, sample->point, sample->foot.point);
		sqdist_curve(metric, sample->foot.tangent, sample->foot.curvature, delta, SQDIST_SIDED);
		copy3(target, sample->foot.point);
		for (size_t i = 0; i < used; i++)
			if (index[i] < offset || index[i] >= offset + free_count)
				add_scaled3(target, -coefficient[i], fit->xyz + 3 * index[i]);
		for (size_t i = 0; i < used; i++) {
			if (index[i] < offset || index[i] >= offset + free_count)
				continue;
			const size_t row = 3 * (index[i] - offset);
			for (size_t c = 0; c < 3; c++) {
				double *b = sys.b + row + c;
				for (size_t d = 0; d < 3; d++)
					*b += sample->weight * coefficient[i] * metric[packed[c][d]] * target[d];
				for (size_t j = 0; j < used; j++) {
					if (index[j] < offset || index[j] >= offset + free_count || index[j] > index[i])
						continue;
					const size_t column = 3 * (index[j] - offset);
					for (size_t d = 0; d < (j == i ? c + 1 : 3); d++)
						sys.a[(row + c) * m + column + d] +=
							sample->weight * coefficient[i] * coefficient[j] * metric[packed[c][d]];
				}
			}
		}
	}
	double trace = 0;
	for (size_t r = 0; r < m; r++)
		trace += sys.a[r * m + r];
	const double weight = proximal * trace / (double)m;
	for (size_t r = 0; r < m; r++) {
		sys.a[r * m + r] += weight;
		sys.b[r] += weight * fit->xyz[3 * offset + r];
	}
	const bool ok = cholesky_solve(&sys);
	if (ok) {
		memcpy(xyz_out, fit->xyz, 3 * n * sizeof *xyz_out);
		memcpy(xyz_out + 3 * offset, sys.b, m * sizeof *xyz_out);
	}
	free(sys.a), free(sys.b), free(sys.first);
	return ok;
}
