/* Clean, smooth and cut the patches of a labelled mesh: what rectify does, free of I/O. */
#ifndef CAGEWRIGHT_RECTIFICATION_H
#define CAGEWRIGHT_RECTIFICATION_H

#include "stages/rectify/contourtrack.h"
#include "stages/rectify/labelsmooth.h"
#include "stages/rectify/patchcut.h"
#include "stages/rectify/sliver.h"

struct rectification_options {
	double sliver;        /* patches narrower than this (model units) are merged; 0: none */
	double tiny_share;    /* loose pieces of a patch below this share of the total area join a neighbour; default 5e-4 */
	bool no_smooth;       /* without label smoothing */
	bool no_cut;          /* without cutting closed patches and handles */
	bool track;           /* contour tracking before the smoothing */
	double score_rad;     /* of contour tracking: borders that lie nearer to dmin are correct; default 25 degrees */
	int passes;           /* of contour tracking; default 2 */
};

struct rectification_counts {
	size_t slivers, sliver_edges;   /* merged patches, sharp edges that went with them */
	size_t split, absorbed;         /* loose pieces that became patches, that joined a neighbour */
	struct contourtrack_counts track;
	struct labelsmooth_counts smooth;
	struct patchcut_counts cut;
	size_t changed;                 /* triangles of another patch than before, cuts aside */
};

/* dense must have labels. Its labels and patches are replaced, sharp edges inside merged slivers go. Faults as of
 * partition_new. */
bool rectification(struct dense *dense, struct rectification_counts *counts, const struct rectification_options *options, const char *shown,
                   struct fault *fault);

#endif
