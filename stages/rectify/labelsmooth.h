/* Smooth patch borders by a label energy (the patch method's section 3.3). */
#ifndef CAGEWRIGHT_LABELSMOOTH_H
#define CAGEWRIGHT_LABELSMOOTH_H

#include "stages/rectify/partition.h"

/* How badly a triangle suits a label, >= 0; 1 weighs about as much as one border edge of a triangle of typical width. */
typedef double label_cost(const void *context, idx_t triangle, idx_t label);

/* By the patch's surface: angle between normals over 6 degrees, distance of the corners over 0.0005 of the longest side, or
 * over twice the patch's spread (partition_measure_spread) where that is more; free patches by the difference of
 * curvatures, as far as theirs is one. At most 16, and 16 more beyond the patch's residual. context: struct partition. */
label_cost label_surface_cost;

struct labelsmooth_options {
	label_cost *cost;
	const void *context;
	const idx_t *family;  /* a label: only borders between labels of one family >= 0 move; NULL: only those between groups */
	const double *scale;  /* a label: typical width of its triangles; NULL: that of the whole mesh */
	const unsigned char *fixed; /* a triangle: != 0 does not move between two free patches; NULL: none */
	int rings;            /* how many triangles a border may move */
	double loss_most;     /* share of its area that a patch may lose in one move; twice that in all */
	int rounds;
};

struct labelsmooth_counts {
	size_t relabelled;    /* triangles, in all rounds */
	int rounds;
	size_t unfinished;    /* cuts that met the limit of their iterations */
};

/* fixed[t] = 0 for triangles whose middle is within reach (longest side 1, along the surface) of a smooth border between
 * groups, 1 for others: with it several calls together cannot carry a border of free patches, which no surface holds in
 * its place, farther than that. O(n). */
void labelsmooth_fix(unsigned char *fixed, const struct partition *p, double reach);

/* Minimise sum over triangles of area * cost + sum over edges between labels of lambda * length * omega, where omega is 0 on
 * sharp edges and else max(0.1, 1 - bend / 40 degrees), lambda half a typical edge. For two neighbouring patches at a time the
 * best border within the rings is a minimum cut (swap moves: Boykov, Veksler, Zabih 2001); pairs by number, rounds until
 * nothing changes. A move that would take more than its share of a patch is not made. counts is added to. */
void labelsmooth(struct partition *p, const struct labelsmooth_options *options, struct labelsmooth_counts *counts);

#endif
