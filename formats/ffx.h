/* FFX: a cage packed into a few hundred bytes. Struct, encoder, decoder, checker (see ffx(5)).
 *
 * A stream holds connectivity (Face Fixer labels; Isenburg and Snoeyink 2000), integer positions, sharp edges, corner
 * flags and, if wanted, the faces' patches, all through one adaptive binary range coder. Every coded decision is made in
 * integers: the same cage gives the same bytes on every machine. The decoder needs libc only. */
#ifndef CAGEWRIGHT_FFX_H
#define CAGEWRIGHT_FFX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "formats/cage.h"
#include "formats/fault.h"
#include "formats/memory.h"

#define FFX_VERSION 1

/* The grid code of the header: the longest side has at most ffx_grid_steps(code) steps. Geometric, 16 codes an octave,
 * from 7 (code 0) to 65535 (code FFX_GRID_CODES - 1 = 208). */
#define FFX_GRID_CODES 209
int32_t ffx_grid_steps(unsigned code);
/* The smallest code that has at least steps steps; FFX_GRID_CODES when there is none. */
unsigned ffx_grid_code(int32_t steps);

/* How connectivity and positions are coded. */
enum ffx_method {
	FFX_BEST = 0,   /* for the encoder only: whichever is smaller */
	FFX_FORWARD,    /* faces grow around a finished region, positions are coded in between */
	FFX_FACE_FIXER, /* Face Fixer's labels first, then positions */
};

/* Positions in space: x = step * (origin / 2^origin_bits + grid). */
#define FFX_ORIGIN_LIMIT ((int64_t)1 << 48)
struct ffx_frame {
	double step;          /* > 0, model units; a value that ffx_frame_step() gives for the grid and origin_bits */
	unsigned origin_bits; /* 0 to 15 */
	int64_t origin[3];    /* |origin| <= FFX_ORIGIN_LIMIT */
};

struct ffx {
	enum cage_scheme scheme;
	enum ffx_method method;
	unsigned grid_code; /* coordinates are in [0, ffx_grid_steps(grid_code)] */
	bool has_frame;
	struct ffx_frame frame;
	size_t vertex_count;
	int32_t *grid;      /* 3 a vertex */
	idx_t *face_corner; /* as in struct cage: at least 3 a face, no vertex twice in a face */
	size_t *face_start;
	size_t face_count;
	idx_t *face_patch; /* NULL unless groups are stored; decoded patches are numbered by first appearance from 0 */
	idx_t *sharp;      /* as in struct cage */
	size_t sharp_count;
	unsigned char *corner; /* a vertex; vertices where three or more sharp or border edges meet are corners by
				  themselves: their flags are not stored and come back as 0 */
};

void ffx_free(struct ffx *ffx);

/* The step nearest to step that a frame of a grid with that many steps and those origin bits can hold: the far end of the grid is
 * within 2^-origin_bits steps of where step itself would put it. 0 when step is outside [2^-120, 2^120]. */
double ffx_frame_step(double step, int32_t steps, unsigned origin_bits);

/* The frame of a grid whose lowest corner is low and whose longest side has steps steps: the grid's ends are within 1/16 step
 * (the far one 3/16) of their places, FFX_FRAME_BITS being 3. A caller who fits positions to the grid loses nothing by that, and
 * one who needs another place takes more origin bits himself. False when low is too far away or side cannot be stored. */
#define FFX_FRAME_BITS 3
bool ffx_frame_choose(struct ffx_frame *frame, const double low[3], double side, int32_t steps);

struct ffx_options {
	size_t root_limit; /* encodings that are tried, each from another start edge; the smallest is kept. 0: as many as
			      is cheap (all for cages up to some hundred edges) */
	size_t first_root; /* half-edge that the first attempt starts from; as in the report */
};

/* Where the bytes went. Parts are -log2 p / 8 of their decisions; total is the stream's size. */
struct ffx_report {
	size_t vertex_count, edge_count, face_count, hole_count, component_count, handle_count, label_count;
	double bytes_c, bytes_g, bytes_f;
	size_t root;         /* half-edge that this encoding starts from */
	enum ffx_method method;
	double bytes_frame;
	size_t bytes_header; /* magic, flags, grid and checksum */
	size_t bytes_total;
};

/* Pack. bytes belongs to the caller (free). The decoded cage is the same up to the order of its vertices, of its faces and
 * of the first corner in a face. Faults (EX_BAD_INPUT): not an oriented manifold, a vertex without faces, coordinates outside the
 * grid. */
bool ffx_encode(unsigned char **bytes, size_t *size, struct ffx_report *report, const struct ffx *ffx,
		const struct ffx_options *options, struct fault *fault);

/* What one encoding costs, for searches that change a cage little by little: bytes of the whole stream before its end is rounded,
 * from start half-edge root (modulo their number; half-edge h below face_start[face_count] is corner h of the lists), by
 * ffx->method, FFX_BEST meaning FFX_FORWARD. No stream is made. HUGE_VAL on the faults of ffx_encode. work keeps memory from call
 * to call; one for each thread. report may be NULL. */
struct ffx_work;
struct ffx_work *ffx_work_new(void);
void ffx_work_free(struct ffx_work *work);
double ffx_cost(struct ffx_work *work, const struct ffx *ffx, size_t root, struct ffx_report *report, struct fault *fault);

/* Unpack. Everything decoded is checked: the result is always an oriented manifold with vertices on the grid. Faults
 * (EX_BAD_INPUT) name shown: wrong magic, a newer version, checksum, truncation, contradictions. */
bool ffx_decode(struct ffx *ffx, const unsigned char *bytes, size_t size, const char *shown, struct fault *fault);

/* Does it begin like a stream? */
bool ffx_is_stream(const unsigned char *bytes, size_t size);

/* Is this a stream that ffx_decode accepts? */
bool ffx_check(const unsigned char *bytes, size_t size, const char *shown, struct fault *fault);

/* A cage whose vertices lie on its grid (cage->grid_step > 0), ready to be packed: each coordinate within a 1000th of a step of a whole number of
 * steps from the origin. Faults (EX_BAD_INPUT): a vertex beside the grid, more steps than a stream can hold, a place that no frame can hold. */
bool ffx_from_cage(struct ffx *ffx, const struct cage *cage, struct fault *fault);

/* The cage in model units (without a frame: the longest side of the grid is 1, its lowest corner at 0). */
void ffx_to_cage(struct cage *cage, const struct ffx *ffx);

#endif
