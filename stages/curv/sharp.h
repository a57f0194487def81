/* Which edges of a triangle mesh are sharp (the patch method's section 1.1). */
#ifndef CAGEWRIGHT_SHARP_H
#define CAGEWRIGHT_SHARP_H

#include <stdbool.h>

#include "stages/geometry/half.h"

struct sharp_options {
	double angle_rad;  /* an edge that bends more is sharp; default 40 degrees */
	bool is_strict;    /* without the exception for regular bends */
};

struct sharp_counts {
	size_t over_angle;   /* edges that bend more than the angle */
	size_t regular;      /* of them: smooth after all, facets of a coarse round */
	size_t lonely;       /* single edges that lead nowhere, smooth after all */
	size_t extended;     /* edges below the angle that lengthen an open chain */
	size_t sharp;        /* in the end, without borders */
};

/* Set kind[h] (half_count, enum edge_kind, both twins) to EDGE_SHARP or 0 for edges with twin and to EDGE_BORDER for
 * those without; entries that hold EDGE_CUT already stay. bend as of wedge_bends. counts may be NULL. O(n). */
void sharp_edges(unsigned char *kind, struct sharp_counts *counts, const double *xyz, const double *bend, const struct half *half,
                 const struct sharp_options *options);

#endif
