/* How far the vertices of a mesh lie off smooth surfaces. */
#ifndef CAGEWRIGHT_SURFACE_NOISE_H
#define CAGEWRIGHT_SURFACE_NOISE_H

#include "stages/segment/facets.h"

/* Typical distance (longest side 1) of vertices to the best analytic surface through their neighbourhood: a low quantile
 * over places spread over the area, so that borders between surfaces do not count. About 1e-8 .. 1e-6 for CAD tessellations. */
double surface_noise(const struct facets *facets);

#endif
