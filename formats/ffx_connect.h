/* Connectivity of an FFX stream by Face Fixer (Isenburg and Snoeyink, "Face Fixer: compressing polygon meshes with
 * properties", SIGGRAPH 2000), with a reverse decoder. Private to formats/ffx*. */
#ifndef CAGEWRIGHT_FFX_CONNECT_H
#define CAGEWRIGHT_FFX_CONNECT_H

#include "formats/fault.h"
#include "formats/ffx_model.h"
#include "formats/ffx_surface.h"

/* One label fixes one edge. */
struct label {
	unsigned char kind;         /* enum ffx_label; LABEL_F3 .. LABEL_F7 and LABEL_H with their degree */
	idx_t degree;               /* F and H: edges of the face */
	idx_t depth, index, length; /* M: places below the top of the stack, place of the twin in that boundary, its length */
	idx_t gate, twin;           /* the edge's two half-edges in the encoded surface */
};

struct labels {
	struct label *label;
	size_t count;
	size_t *component_end; /* labels of component c end at component_end[c] */
	size_t component_count;
	size_t handle_count;
};
void labels_free(struct labels *labels);

/* Walk the surface from half-edge root (its component first, then the others, each from its lowest half-edge) and write
 * the labels in their order. O(n log n). */
void labels_make(struct labels *labels, const struct ffx_surface *surface, idx_t root);

/* More labels than this are refused, so that a short damaged stream cannot ask for much memory or time; the encoder pads
 * streams of cages that compress better. */
#define LABELS_FREE 4096
#define LABELS_PER_BYTE 64

/* Work that all M labels of a stream may cause together, in steps along boundaries and down the stack. */
#define MERGE_WORK_LIMIT ((size_t)1 << 26)

/* Code the labels of all components from the last to the first and build the surface that they mean.
 * Encoding: labels given; original[h] becomes the half-edge of the encoded surface that half-edge h of *surface is (caller
 * frees). Decoding: labels NULL, original NULL. The result is an oriented manifold that surface_build would accept, or a fault.
 */
bool connect_code(struct ffx_coder *coder, struct ffx_surface *surface, const struct labels *labels, idx_t **original,
		  size_t label_limit, struct fault *fault);

#endif
