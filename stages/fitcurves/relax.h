/* Borders that run in steps along triangles, drawn taut on the surface. */
#ifndef CAGEWRIGHT_RELAX_H
#define CAGEWRIGHT_RELAX_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/dense.h"
#include "stages/geometry/nearest.h"

/* A border between free-form or virtual patches has no place of its own, only the mesh edges that it had to take. Each edge is
 * halved, then all but the end points are averaged with their neighbours again and again, kept within half an edge of where
 * they were and on the triangles of patches left and right (right -1: left alone). xyz: count points; returns the number of
 * points in *out (3 doubles each, caller frees): 2 count - 1, closed 2 count. */
size_t relax_border(double **out, const double *xyz, size_t count, bool closed, const struct dense *dense,
		    const struct nearest *nearest, idx_t left, idx_t right);

/* Move the inner points of an open border (count >= 2) to the straight line between its ends, laid on the triangles of patches left
 * and right. False, and nothing moved, when that strays too far from the border. */
bool relax_straight(double *xyz, size_t count, const struct dense *dense, const struct nearest *nearest, idx_t left, idx_t right);

#endif
