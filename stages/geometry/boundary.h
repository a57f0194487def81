/* The boundary edges of a labelled mesh, which border.h makes chains of. */
#ifndef CAGEWRIGHT_BOUNDARY_H
#define CAGEWRIGHT_BOUNDARY_H

#include "stages/geometry/border.h"

struct boundary_edge {
	idx_t a, b; /* left patch on the left from a to b */
	idx_t left, right;
	double length;
	bool sharp;
};

struct boundary {
	struct boundary_edge *edge;
	size_t edge_count;
	size_t dart_edge_count;
	long euler;
	size_t *start;   /* vertex_count + 1 offsets into incident */
	idx_t *incident; /* edges at each vertex, ascending */
};

/* Edges between patches, borders, and with options->darts sharp edges inside a patch, in order of their half-edges. Faults as
 * border_extract. */
bool boundary_find(struct boundary *boundary, const struct dense *dense, const struct border_options *options,
		   struct fault *fault);
void boundary_free(struct boundary *boundary);

#endif
