/* The network of subdivision curves that bound the patches: struct, read, write, check of PART.fitcurves.ply
 * (see cagewright-network(5)). */
#ifndef CAGEWRIGHT_NETWORK_H
#define CAGEWRIGHT_NETWORK_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/ply.h"

enum point_kind { POINT_CORNER = 0, POINT_JUNCTION = 1, POINT_CREASE = 2 };
/* corner: interpolated, the curve may kink there; junction: end of curves (interpolated as well when three or more sharp
 * curves meet); crease: inside one curve. */

enum curve_kind { CURVE_SHARP = 0, CURVE_SMOOTH = 1, CURVE_BORDER = 2 };

struct curve {
	idx_t left, right;      /* patches, left when walking along the points; -1 outside */
	enum curve_kind kind;
	bool closed;            /* periodic: no end points, each point listed once */
	size_t first, count;    /* its points: point[first] .. point[first + count); open curves include both ends */
	double error;           /* largest distance to the mesh edges that it follows, model units */
	double length;          /* of the control polygon when fitted, model units: a curve whose points no longer give this
	                           length was moved by hand, and later stages leave it where it was put */
};

struct network {
	size_t vertex_count, curve_count, point_count;
	double *xyz;            /* 3 a vertex: control points, model units */
	unsigned char *kind;    /* enum point_kind */
	struct curve *curve;
	idx_t *point;           /* vertex indices of all curves, one after the other */
};

void network_free(struct network *network);

/* vertex_element: "vertex" in a fitcurves file; "netpoint" in a fitpatch file, where vertex are the patches' own.
 * Faults: indices out of range, an open curve with fewer than 2 points or a closed one with fewer than 3, non-finite numbers. */
bool network_from_ply(struct network *network, const struct ply *ply, const char *vertex_element, const char *shown, struct fault *fault);

/* Replaces vertex_element, "curve" and (only for "vertex") the derived "edge" element. */
void network_to_ply(struct ply *ply, const struct network *network, const char *vertex_element);

/* Length of a curve's control polygon (closed: with the closing side). */
double network_curve_length(const struct network *network, const struct curve *curve);

/* Was this curve moved by hand after it was fitted? Compares the length with the recorded one (relative 1e-9). */
bool network_curve_edited(const struct network *network, const struct curve *curve);

#endif
