/* From a triangulation to few polygons: the chords that fit the surface least are taken out again. */
#ifndef CAGEWRIGHT_MERGE_H
#define CAGEWRIGHT_MERGE_H

#include "stages/fitpatch/layout.h"

struct merge_options {
	bool is_plane;
	bool is_careful;     /* flat and convex faces only */       /* the whole patch: polygons of any size */
	double flat;         /* largest distance to the common plane, model units, for polygons above four corners */
};

/* The living triangles of a sheet become polygons over control points (point[v]; all living vertices have one). An edge goes, the worst
 * first, when the union is star-shaped as seen from its centroid (which keeps the first subdivision step unfolded), has no
 * vertex twice, and is a quad or plane. */
void merge_triangles(struct layout_context *context, struct chord_context *chords, const struct merge_options *options, idx_t patch);

#endif
