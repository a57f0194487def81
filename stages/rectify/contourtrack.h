/* Redraw patch borders that do not follow the curvature (the patch method's sections 3.1, 3.2). */
#ifndef CAGEWRIGHT_CONTOURTRACK_H
#define CAGEWRIGHT_CONTOURTRACK_H

#include "stages/rectify/partition.h"

struct contourtrack_options {
	double score_rad;    /* a border edge whose score is at most this is correct */
	int passes;
	double tiny_area;    /* components below it are absorbed, longest side 1 */
};

struct contourtrack_counts {
	size_t border_edges;  /* smooth ones, in the first pass */
	size_t correct;       /* of them */
	size_t tracked;       /* paths that replace wrong borders, all passes */
	size_t kept;          /* open ends from which no better border was found */
	int passes;
};

/* Score of the edge of half-edge h as a border, radians: the angle between the edge and the direction of least curvature, mean
 * over the wedges at its ends by anisotropy, the better of its two sides; 0 on sharp edges and mesh borders. Where the wedges are isotropic the
 * contrast of the two labels decides: 90 degrees * exp(-|C_left - C_right|). */
double contourtrack_score(const struct partition *p, idx_t h);

void contourtrack(struct partition *p, const struct contourtrack_options *options, struct contourtrack_counts *counts);

#endif
