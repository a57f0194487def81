/* One subdivision curve fitted to one polyline (the patch method's sections 4.3 and 4.4): initial points from curvature,
 * squared-distance minimisation, knot insertion, backward removal. Free of shared state: curves may be fitted in parallel. */
#ifndef CAGEWRIGHT_CURVEFIT_H
#define CAGEWRIGHT_CURVEFIT_H

#include <stdbool.h>
#include <stddef.h>

#include "stages/fitcurves/polyline.h"

#define CURVEFIT_MOST_POINTS 128 /* control points of one curve; a target that needs more stays above its tolerance */

struct curvefit_options {
	double max, mean;    /* distances allowed, in the polyline's units; where the polyline is coarse its slack is allowed */
	double side;         /* longest side of the part: scale of the resampling step */
	size_t least_points; /* of the result, ends included: closed at least 3, a loop from a node to itself 4, else 2 */
};

struct curvefit {
	size_t count; /* open: both ends included */
	bool closed;
	double *xyz; /* 3 a control point; open: the first and last are the polyline's ends */
	double *arc; /* arc length of the polyline at each knot, ascending (closed: arc[0] may be anything in [0, length)) */
	double error, mean; /* largest distance both ways, mean of the samples' */
	double ratio;       /* of error to what is allowed: <= 1 within tolerance */
	double worst_arc;   /* where */
};

void curvefit_free(struct curvefit *fit);

/* As few points as the tolerances allow. */
void curvefit_best(struct curvefit *fit, const struct polyline *line, struct curvefit_options options);

/* Start from given arc lengths of the knots (count of them, ascending; open: 0 and the length first and last; closed: within
 * one turn, may begin anywhere). Exactly count points. */
void curvefit_from(struct curvefit *fit, const struct polyline *line, struct curvefit_options options, const double *arc,
		   size_t count);

/* Exactly count points (at least 2 open, 3 closed), spread by arc length and curvature. */
void curvefit_exact(struct curvefit *fit, const struct polyline *line, struct curvefit_options options, size_t count);

/* Exactly count >= fit->count points: spread anew, or the fit's own with the widest spans cut, whichever is better. */
void curvefit_raise(struct curvefit *fit, const struct polyline *line, struct curvefit_options options, size_t count);

/* A curve without length: count points at p. */
void curvefit_point(struct curvefit *fit, const double p[3], size_t count, bool closed);

/* Distances both ways between control points (count, closed as in fit) and another polyline; fit->arc is kept. */
void curvefit_measure(struct curvefit *fit, const struct polyline *line, struct curvefit_options options);

#endif
