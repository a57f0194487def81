/* Positions and flags of an FFX stream. Private to formats/ffx*. */
#ifndef CAGEWRIGHT_FFX_GEOMETRY_H
#define CAGEWRIGHT_FFX_GEOMETRY_H

#include <stdbool.h>

#include "formats/fault.h"
#include "formats/ffx_model.h"
#include "formats/ffx_surface.h"

/* How often each value has been seen: a binary tree of counts, its root at 1. */
struct seen_values {
	uint32_t *count;
	int bits;
};

/* The state of position coding: zero at first; geometry_start sets it up and may be called again for the next stream. */
struct geometry {
	struct ffx_coder *coder;
	int32_t steps;
	int bits;
	unsigned scale;             /* SCALE_CLASSES */
	struct seen_values seen[4]; /* by axis, and all */
};
struct guesses;
void geometry_start(struct geometry *geometry, struct ffx_coder *coder, int32_t steps);
void geometry_free(struct geometry *geometry);
/* Code one vertex; encoding reads point, decoding fills it. */
void geometry_vertex(struct geometry *geometry, const struct guesses *guesses, int32_t point[3]);

/* Code the positions of all vertices in the given order (predict_order): grid, 3 a vertex, in [0, steps]. Encoding reads
 * grid, decoding fills it. Faults: the stream ends too early. */
bool geometry_code(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const idx_t *rank,
		   int32_t *grid, int32_t steps, struct fault *fault);

/* Code a flag for each edge with two real faces: sharp[h] for half-edge h, the same on both sides. */
bool sharp_code(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const int32_t *grid,
		unsigned char *sharp, struct fault *fault);

/* Code a corner flag for each vertex with fewer than three sharp or border edges; others are set to 0. */
bool corner_code(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const int32_t *grid,
		 const unsigned char *sharp, unsigned char *corner, struct fault *fault);

/* Code the patch of each face that is no hole: patch, one a face of the surface, numbered by first appearance in the order of
 * faces; encoding takes any numbers >= 0 and renumbers them. */
bool patch_code(struct ffx_coder *coder, const struct ffx_surface *surface, const int32_t *grid, const unsigned char *sharp,
		idx_t *patch, struct fault *fault);

#endif
