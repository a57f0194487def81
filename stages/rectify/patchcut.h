/* Cut patches that no network of disc and annulus faces can take (the patch method's section 5.0). */
#ifndef CAGEWRIGHT_PATCHCUT_H
#define CAGEWRIGHT_PATCHCUT_H

#include "stages/rectify/partition.h"

struct patchcut_counts {
	size_t closed;       /* patches without border that were cut */
	size_t handles;      /* patches of genus >= 1 that were cut (a closed one counts here) */
	size_t balls;        /* patches that were most of a sphere and were cut */
	size_t parts;        /* patches that were added */
	size_t unsolved;     /* patches that are still closed or have handles: 0 but for a mesh that defies the bound of rounds */
	int rounds;
};

/* Cut closed patches and patches of genus >= 1 along mesh edges until every one has genus 0 and a border; also spheres of which
 * a border leaves most, because no polygon in that border spans them. Spheres and what is
 * star-shaped: by the six sides of a box along the principal axes; tori: by sectors around the axis, enough of them for
 * 0.1 % of the longest side; others: by the best of some level sets of the distance from a far point, again and again.
 * The cuts are shortened by labelsmooth. Parts share their group. counts is set. */
void patchcut(struct partition *p, struct patchcut_counts *counts);

#endif
