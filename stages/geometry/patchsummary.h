/* What a person wants to know of a labelled mesh: curves between patches, loops and handles, the patch that fits worst. */
#ifndef CAGEWRIGHT_PATCHSUMMARY_H
#define CAGEWRIGHT_PATCHSUMMARY_H

#include "formats/dense.h"
#include "formats/fault.h"
#include "formats/network.h"

struct patch_summary {
	size_t curves[CURVE_BORDER + 1]; /* chains between patches by enum curve_kind */
	size_t nodes;                    /* where chains meet or turn sharply */
	size_t loops;                    /* border loops of all patches */
	size_t closed;                   /* patches without border */
	size_t handled;                  /* patches with handles ... */
	long genus;                      /* ... and the handles of all */
	idx_t most_loops;                /* patch with the most loops, the first of them; NO_INDEX without patches */
	size_t most_loops_count;
	idx_t worst;                     /* patch of a surface with the vertex farthest off it; NO_INDEX when all are free */
	double worst_distance;           /* model units */
	double worst_at[3];              /* that vertex */
};

/* dense needs label and patch. Faults as border_extract (EX_BAD_INPUT). O(n). */
bool patch_summarise(struct patch_summary *summary, const struct dense *dense, struct fault *fault);

#endif
