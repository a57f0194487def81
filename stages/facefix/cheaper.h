/* Rounding a cage so that it costs fewer bytes: coordinates go to the next grid value where that is cheaper. */
#ifndef CAGEWRIGHT_CHEAPER_H
#define CAGEWRIGHT_CHEAPER_H

#include <stdbool.h>

#include "formats/cage.h"
#include "formats/fault.h"
#include "formats/ffx.h"

struct cheaper_report {
	size_t tried, moved;
	double bytes_before, bytes_after; /* of the payload */
	double mean, max;                 /* deviation in the end, model units */
};

/* Move coordinates of *ffx, a rounding of *cage (gridfit_round), one step up or down, to 1.3 steps from their exact value at
 * most, when the stream gets shorter, the deviation stays within tolerance in the mean and 8 tolerance at most, and nothing
 * collapses or turns that did not before. Candidates in the order of how little the move costs in distance; work is bounded, so
 * that large cages get fewer trials. root: the start edge to encode from (ffx_report.root). Faults as ffx_encode. */
bool cheaper_round(struct ffx *ffx, struct cheaper_report *report, const struct cage *cage, double tolerance, size_t root,
		   struct fault *fault);

#endif
