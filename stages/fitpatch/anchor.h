/* Where the control points of the network sit on the borders of the dense mesh. */
#ifndef CAGEWRIGHT_ANCHOR_H
#define CAGEWRIGHT_ANCHOR_H

#include "formats/dense.h"
#include "formats/network.h"
#include "stages/fitpatch/sheet.h"
#include "stages/geometry/border.h"
#include "stages/geometry/half.h"

/* One control point on a chain: segment number + fraction. */
struct anchor {
	double along;
	idx_t point;  /* network vertex */
};

struct anchors {
	size_t *first;          /* a chain: its anchors are anchor[first[c]] .. anchor[first[c + 1]), along rising */
	struct anchor *anchor;
	idx_t *half_chain;      /* a dense half-edge: the chain it lies on, or NO_INDEX */
	idx_t *half_segment;    /* its segment there; negative -1 - segment when it runs against the chain */
};

/* chain_of_curve as of border_match. Open curves start and end at the chain's ends; inner points go where their limit
 * position is nearest, moved as little as it takes to come in order. */
void anchors_place(struct anchors *anchors, const struct dense *dense, const struct half *half, const struct border_network *border,
                   const struct network *network, const idx_t *chain_of_curve);
void anchors_free(struct anchors *anchors);

/* Give a sheet its control points: border half-edges are split where anchors lie inside them. Neighbours on a loop that
 * stand for the same control point (a contracted curve) become one. Returns the smallest number of points on a loop. */
size_t anchors_apply(struct sheet *sheet, const struct anchors *anchors, const struct dense *dense);

#endif
