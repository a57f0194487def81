/* What the range coder of an FFX stream carries: connectivity, positions, sharp edges, corners, patches, in this order. Private
 * to formats/ffx* and to the program that trains the tables. */
#ifndef CAGEWRIGHT_FFX_PAYLOAD_H
#define CAGEWRIGHT_FFX_PAYLOAD_H

#include <stdbool.h>

#include "formats/fault.h"
#include "formats/ffx.h"
#include "formats/ffx_forward.h"
#include "formats/ffx_model.h"
#include "formats/ffx_surface.h"

/* A cage ready to be coded: its half-edges, and flags on them. */
struct payload {
	struct ffx_surface surface;
	unsigned char *sharp; /* a half-edge */
	const struct ffx *ffx;
};
void payload_free(struct payload *payload);

/* Code a frame (ffx_frame.c): encoding reads *frame, decoding fills it. Faults: out of range. */
bool frame_code(struct ffx_coder *coder, struct ffx_frame *frame, int32_t steps, struct fault *fault);

/* Faults (EX_BAD_INPUT) as ffx_encode; listed border edges are left out. */
bool payload_prepare(struct payload *payload, const struct ffx *ffx, struct fault *fault);

/* Costs in 1/4096 bit, and what was coded. */
struct payload_report {
	uint64_t cost_c, cost_g, cost_f;
	size_t label_count, component_count, handle_count;
};

/* Encode by method (not FFX_BEST) from start half-edge root; forward: room for the forward coder, zero or used before; the coder
 * has been set up with a model and range_encode. Does not finish the range coder. */
bool payload_encode(struct ffx_coder *coder, struct payload_report *report, const struct payload *payload, enum ffx_method method,
		    idx_t root, struct forward *forward, struct fault *fault);

/* Fill counts, grid, faces, patches (when has_patches), sharp and corner of *ffx; grid_code and method are set by the caller. */
bool payload_decode(struct ffx_coder *coder, struct ffx *ffx, bool has_patches, size_t edge_limit, struct fault *fault);

#endif
