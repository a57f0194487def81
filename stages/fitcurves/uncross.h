/* Control polygons that cut each other in the plane of their patch. */
#ifndef CAGEWRIGHT_UNCROSS_H
#define CAGEWRIGHT_UNCROSS_H

#include "stages/fitcurves/curvefit.h"
#include "stages/geometry/border.h"

/* The control polygon of a bent curve stands off from it: four points around a bore make a square of one and a half times its
 * radius. Where that cuts the polygon of a neighbour on the same plane, the plane's faces would fold. Gives one more point to the
 * curve of each cutting pair that comes nearer by it for the cost: all curves of its class (class_size, by chain) will be raised
 * with it; call it until it returns 0, the number of curves raised. fit, line and options by chain, is_gone may be NULL, patch by
 * number. */
size_t uncross(struct curvefit *fit, const struct polyline *line, const struct curvefit_options *options,
	       const struct border_network *border, const bool *is_gone, const struct dense_patch *patch, size_t patch_count,
	       const size_t *class_size);

#endif
