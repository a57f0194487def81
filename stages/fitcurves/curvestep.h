/* One step of squared-distance minimisation of a curve (the patch method's section 4.4, 3 to 6). */
#ifndef CAGEWRIGHT_CURVESTEP_H
#define CAGEWRIGHT_CURVESTEP_H

#include "stages/fitcurves/curvefit.h"

/* A point of the curve and where it should be. */
struct curvesample {
	double u, point[3], weight;
	struct polyline_foot foot;
	bool reverse; /* from a vertex of the target to the curve: foot.point is the vertex */
};

/* Minimise the samples' quadratic forms plus proximal * (mean diagonal) * |P - P now|^2 over the points of fit that are not ends;
 * xyz_out gets all points. False, with nothing written, when the matrix is not positive definite. */
bool curvestep(double *xyz_out, const struct curvefit *fit, const struct curvesample *samples, size_t sample_count,
	       double proximal);

#endif
