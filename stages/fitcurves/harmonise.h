/* Same numbers of control points on opposite curves, and aligned phases on opposite loops, so that the patch between them
 * becomes a clean band of quads (the patch method's section 4.6). */
#ifndef CAGEWRIGHT_HARMONISE_H
#define CAGEWRIGHT_HARMONISE_H

#include "stages/fitcurves/curvefit.h"
#include "stages/fitcurves/patchloops.h"

/* Offset o in [0, length of b) such that b at o + s (same_way) or o - s looks like a at s, centred and scaled alike;
 * *residual: root mean square distance after that over the mean radius (0 for similar loops). Both closed. */
double harmonise_offset(const struct polyline *a, const struct polyline *b, bool same_way, double *residual);

/* fit, line and options by chain; chains of length 0 are left alone. patch: what the patches are, or NULL;
 * planes
 * take polygons of any size, so that only narrow rings and strips are asked for bands. class_size
 * (by chain, may be NULL): how many curves share one number. Changes fits. Returns how many fits were
 * raised or moved. */
size_t harmonise(struct curvefit *fit, const struct polyline *line, const struct curvefit_options *options,
		 const struct border_network *border, const struct patchloops *loops, const struct dense_patch *patch,
		 size_t *class_size);

#endif
