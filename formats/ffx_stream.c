/* FFX streams: header, frame, payload, checksum (see ffx.h and ffx(5)). */
#include "formats/ffx.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "formats/ffx_connect.h"
#include "formats/ffx_payload.h"

static const unsigned char magic[2] = {'F', 'X'};
#define HEADER_SIZE 4
#define STEP_SIZE 4
/* Streams up to this size end in a CRC-16, longer ones in a CRC-32. The 16 bits find every change of one or two bits and
 * every burst up to 16 bits in so short a stream, and let one in 65536 other damages pass; those decode to a valid mesh or
 * are refused for a contradiction. */
#define SHORT_STREAM 1024

/* --- grid and frame ------------------------------------------------------------------------------------------------ */

int32_t ffx_grid_steps(unsigned code)
{
	/* 65536 * 2^(i / 16) */
	static const uint32_t octave[16] = {65536, 68438, 71468,  74632,  77936,  81386,  84990,  88752,
					    92682, 96785, 101070, 105545, 110218, 115098, 120194, 125515};
	return (int32_t)(((uint64_t)octave[code % 16] << (3 + code / 16)) >> 16) - 1;
}

unsigned ffx_grid_code(int32_t steps)
{
	unsigned code = 0;
	while (code < FFX_GRID_CODES && ffx_grid_steps(code) < steps)
		code++;
	return code;
}

#define STEP_BIAS 128
#define STEP_BITS 21 /* of the mantissa, the highest being 1 */
double ffx_frame_step(double step)
{
	if (!(step >= ldexp(1, -120) && step <= ldexp(1, 120)))
		return 0;
	int exponent;
	const double mantissa = frexp(step, &exponent); /* [0.5, 1) */
	return ldexp(round(ldexp(mantissa, STEP_BITS)), exponent - STEP_BITS);
}

/* Of the longest side: how far the frame's origin may be off. The step adds 4.8e-7 at the far end. */
#define ORIGIN_ERROR 4e-7

bool ffx_frame_choose(struct ffx_frame *frame, const double low[3], double side, int32_t steps)
{
	*frame = (struct ffx_frame){.step = ffx_frame_step(side / steps)};
	if (frame->step == 0)
		return false;
	for (;; frame->origin_bits++) {
		bool is_near = true;
		for (int k = 0; k < 3; k++) {
			const double at = ldexp(low[k] / frame->step, (int)frame->origin_bits), whole = round(at);
			if (!(fabs(whole) <= (double)FFX_ORIGIN_LIMIT))
				return false;
			frame->origin[k] = (int64_t)whole;
			is_near = is_near && fabs(at - whole) <= ldexp(ORIGIN_ERROR * steps, (int)frame->origin_bits);
		}
		if (is_near || frame->origin_bits == 15)
			return true;
	}
}

static void put_frame_step(unsigned char byte[STEP_SIZE], const struct ffx_frame *frame)
{
	int exponent;
	const uint32_t mantissa = (uint32_t)ldexp(frexp(frame->step, &exponent), STEP_BITS) - (1u << (STEP_BITS - 1));
	byte[0] = (unsigned char)(exponent + STEP_BIAS);
	byte[1] = (unsigned char)(frame->origin_bits << 4 | mantissa >> 16);
	byte[2] = (unsigned char)(mantissa >> 8);
	byte[3] = (unsigned char)mantissa;
}

static void get_frame_step(struct ffx_frame *frame, const unsigned char byte[STEP_SIZE])
{
	const uint32_t mantissa = (byte[1] & 15u) << 16 | (uint32_t)byte[2] << 8 | byte[3];
	frame->origin_bits = byte[1] >> 4;
	frame->step = ldexp((1u << (STEP_BITS - 1)) + mantissa, byte[0] - STEP_BIAS - STEP_BITS);
}

/* Signed numbers as groups of 7 bits, lowest first; the sign in the lowest bit; the high bit says that more follows. */
static size_t put_signed(unsigned char *byte, int64_t value)
{
	uint64_t rest = value < 0 ? 2 * (uint64_t)-value - 1 : 2 * (uint64_t)value;
	size_t size = 0;
	do {
		byte[size++] = (unsigned char)((rest & 127) | (rest > 127 ? 128 : 0));
		rest >>= 7;
	} while (rest > 0);
	return size;
}

/* Returns the bytes taken, 0 when they run out or the number is too large or longer than need be. */
static size_t get_signed(int64_t *value, const unsigned char *byte, size_t size)
{
	uint64_t rest = 0;
	for (size_t i = 0; i < size && i < 8; i++) {
		rest |= (uint64_t)(byte[i] & 127) << 7 * i;
		if (byte[i] & 128)
			continue;
		if (byte[i] == 0 && i > 0)
			return 0;
		*value = rest & 1 ? -(int64_t)(rest / 2) - 1 : (int64_t)(rest / 2);
		return *value >= -FFX_ORIGIN_LIMIT && *value <= FFX_ORIGIN_LIMIT ? i + 1 : 0;
	}
	return 0;
}

/* CRC-16 of X.25: polynomial x^16 + x^12 + x^5 + 1, bits reversed, start and end inverted. */
static unsigned crc16(const unsigned char *byte, size_t size)
{
	unsigned crc = 0xffff;
	for (size_t i = 0; i < size; i++) {
		crc ^= byte[i];
		for (int k = 0; k < 8; k++)
			crc = crc >> 1 ^ (crc & 1 ? 0x8408 : 0);
	}
	return crc ^ 0xffff;
}

static size_t checksum_size(size_t size_without)
{
	return size_without + 2 <= SHORT_STREAM ? 2 : 4;
}

static uint32_t checksum(const unsigned char *byte, size_t size)
{
	if (checksum_size(size) == 2)
		return crc16(byte, size);
	return (uint32_t)crc32(crc32(0, NULL, 0), byte, (uInt)size);
}

/* --- encoding --------------------------------------------------------------------------------------------------------- */

struct attempt {
	unsigned char *bytes;
	size_t size;
	uint64_t cost;
	size_t root;
	struct payload_report report;
};

static bool encode_from(struct attempt *attempt, const struct payload *payload, idx_t root, struct ffx_model *model,
			struct fault *fault)
{
	struct ffx_coder coder = {.model = model};
	model_init(model);
	range_encode(&coder.range);
	if (!payload_encode(&coder, &attempt->report, payload, root, fault)) {
		free(coder.range.bytes);
		return false;
	}
	range_finish(&coder.range);
	attempt->bytes = coder.range.bytes;
	attempt->size = coder.range.size;
	attempt->cost = coder.cost;
	return true;
}

/* Encodings are tried as long as they take about as many edges together: half a second or so. */
#define ROOT_WORK 60000

/* The smallest encoding of all that are tried; the first of those of equal size and cost. */
static bool encode_best(struct attempt *best, const struct payload *payload, size_t root_limit, size_t first_root,
			struct fault *fault)
{
	const size_t halves = payload->surface.half_count;
	size_t tries = root_limit ? root_limit : 1 + ROOT_WORK / halves;
	if (tries > halves)
		tries = halves;
	struct ffx_model *model = mem_array(1, sizeof *model);
	bool is_good = true;
	*best = (struct attempt){0};
	for (size_t i = 0; i < tries && is_good; i++) {
		struct attempt attempt;
		attempt.root = (first_root + i * halves / tries) % halves;
		is_good = encode_from(&attempt, payload, (idx_t)attempt.root, model, fault);
		if (!is_good)
			break;
		if (!best->bytes || attempt.size < best->size || (attempt.size == best->size && attempt.cost < best->cost)) {
			free(best->bytes);
			*best = attempt;
		} else {
			free(attempt.bytes);
		}
	}
	free(model);
	if (!is_good)
		free(best->bytes);
	return is_good;
}

bool ffx_encode(unsigned char **bytes, size_t *size, struct ffx_report *report, const struct ffx *ffx,
		const struct ffx_options *options, struct fault *fault)
{
	if (ffx->grid_code >= FFX_GRID_CODES)
		return fault_set(fault, EX_BUG, "there is no grid %u", ffx->grid_code);
	if (ffx->has_frame &&
	    (ffx_frame_step(ffx->frame.step) != ffx->frame.step || ffx->frame.step == 0 || ffx->frame.origin_bits > 15))
		return fault_set(fault, EX_BUG, "the frame cannot be stored exactly");
	for (int k = 0; ffx->has_frame && k < 3; k++)
		if (ffx->frame.origin[k] < -FFX_ORIGIN_LIMIT || ffx->frame.origin[k] > FFX_ORIGIN_LIMIT)
			return fault_set(fault, EX_BAD_INPUT, "the cage is too far from the origin for its size");
	struct payload payload;
	if (!payload_prepare(&payload, ffx, fault))
		return false;
	struct attempt best;
	if (!encode_best(&best, &payload, options ? options->root_limit : 0, options ? options->first_root : 0, fault)) {
		payload_free(&payload);
		return false;
	}
	/* Zero bytes change nothing for the decoder; they keep its rule on labels for cages that compress all too well. */
	size_t payload_size = best.size;
	if (best.report.label_count > LABELS_FREE + LABELS_PER_BYTE * payload_size)
		payload_size = (best.report.label_count - LABELS_FREE + LABELS_PER_BYTE - 1) / LABELS_PER_BYTE;
	unsigned char *out = mem_array(HEADER_SIZE + STEP_SIZE + 3 * 8 + payload_size + 4, 1);
	size_t at = 0;
	out[at++] = magic[0];
	out[at++] = magic[1];
	out[at++] = (unsigned char)(FFX_VERSION | ffx->scheme << 3 | ffx->method << 5 | (ffx->has_frame ? 64 : 0) |
				    (ffx->face_patch ? 128 : 0));
	out[at++] = (unsigned char)ffx->grid_code;
	if (ffx->has_frame) {
		put_frame_step(out + at, &ffx->frame);
		at += STEP_SIZE;
		for (int k = 0; k < 3; k++)
			at += put_signed(out + at, ffx->frame.origin[k]);
	}
	const size_t header = at;
	memcpy(out + at, best.bytes, best.size);
	at += payload_size;
	const uint32_t sum = checksum(out, at);
	const size_t sum_size = checksum_size(at);
	for (size_t i = 0; i < sum_size; i++)
		out[at++] = (unsigned char)(sum >> 8 * i);
	*bytes = out;
	*size = at;
	if (report) {
		const double per_byte = 8 * 4096;
		const struct ffx_surface *s = &payload.surface;
		*report = (struct ffx_report){.vertex_count = s->vertex_count,
					      .edge_count = s->half_count / 2,
					      .face_count = s->face_count - s->hole_count,
					      .hole_count = s->hole_count,
					      .component_count = best.report.component_count,
					      .handle_count = best.report.handle_count,
					      .label_count = best.report.label_count,
					      .root = best.root,
					      .bytes_c = (double)best.report.cost_c / per_byte,
					      .bytes_g = (double)best.report.cost_g / per_byte,
					      .bytes_f = (double)best.report.cost_f / per_byte,
					      .bytes_header = header + sum_size,
					      .bytes_total = at};
	}
	free(best.bytes);
	payload_free(&payload);
	return true;
}

/* --- decoding ---------------------------------------------------------------------------------------------------------- */

void ffx_free(struct ffx *ffx)
{
	free(ffx->grid);
	free(ffx->face_corner);
	free(ffx->face_start);
	free(ffx->face_patch);
	free(ffx->sharp);
	free(ffx->corner);
	*ffx = (struct ffx){0};
}

/* Returns where the payload starts, 0 when the header is wrong. */
static size_t read_header(struct ffx *ffx, bool *has_patches, const unsigned char *bytes, size_t end, const char *shown,
			  struct fault *fault)
{
	ffx->scheme = (enum cage_scheme)(bytes[2] >> 3 & 3);
	ffx->method = (enum ffx_method)(bytes[2] >> 5 & 1);
	ffx->has_frame = bytes[2] & 64;
	*has_patches = bytes[2] & 128;
	ffx->grid_code = bytes[3];
	if (ffx->scheme > SCHEME_CATMULLCLARK) {
		fault_set(fault, EX_BAD_INPUT, "%s: byte 2: unknown subdivision scheme %d", shown, (int)ffx->scheme);
		return 0;
	}
	if (ffx->method != FFX_FACE_FIXER) {
		fault_set(fault, EX_BAD_INPUT, "%s: byte 2: unknown coding method %d", shown, (int)ffx->method);
		return 0;
	}
	if (ffx->grid_code >= FFX_GRID_CODES) {
		fault_set(fault, EX_BAD_INPUT, "%s: byte 3: there is no grid %u", shown, ffx->grid_code);
		return 0;
	}
	size_t at = HEADER_SIZE;
	if (!ffx->has_frame)
		return at;
	bool is_good = end >= at + STEP_SIZE;
	if (is_good) {
		get_frame_step(&ffx->frame, bytes + at);
		is_good = ffx_frame_step(ffx->frame.step) == ffx->frame.step;
		at += STEP_SIZE;
	}
	for (int k = 0; k < 3 && is_good; k++) {
		const size_t taken = get_signed(&ffx->frame.origin[k], bytes + at, end - at);
		is_good = taken > 0;
		at += taken;
	}
	if (!is_good)
		fault_set(fault, EX_BAD_INPUT, "%s: byte %zu: the frame is damaged", shown, at);
	return is_good ? at : 0;
}

bool ffx_decode(struct ffx *ffx, const unsigned char *bytes, size_t size, const char *shown, struct fault *fault)
{
	*ffx = (struct ffx){0};
	if (size < sizeof magic || memcmp(bytes, magic, sizeof magic) != 0)
		return fault_set(fault, EX_BAD_INPUT, "%s: not an FFX stream", shown);
	if (size < HEADER_SIZE + 2)
		return fault_set(fault, EX_BAD_INPUT, "%s: the stream ends in its header", shown);
	if ((bytes[2] & 7) != FFX_VERSION)
		return fault_set(fault, EX_BAD_INPUT, "%s: FFX version %d is not known here (only %d)", shown, bytes[2] & 7,
				 FFX_VERSION);
	const size_t sum_size = size <= SHORT_STREAM ? 2 : 4, end = size - sum_size;
	uint32_t sum = 0;
	for (size_t i = 0; i < sum_size; i++)
		sum |= (uint32_t)bytes[end + i] << 8 * i;
	if (checksum_size(end) != sum_size || sum != checksum(bytes, end))
		return fault_set(fault, EX_BAD_INPUT, "%s: damaged: the checksum differs", shown);
	bool has_patches;
	const size_t start = read_header(ffx, &has_patches, bytes, end, shown, fault);
	if (start == 0)
		return false;
	struct ffx_model *model = mem_array(1, sizeof *model);
	struct ffx_coder coder = {.model = model};
	model_init(model);
	range_decode(&coder.range, bytes + start, end - start);
	struct fault inner = {0};
	const size_t label_limit = LABELS_FREE + LABELS_PER_BYTE * (end - start);
	bool is_good =
		payload_decode(&coder, ffx, has_patches, label_limit < INDEX_LIMIT / 4 ? label_limit : INDEX_LIMIT / 4, &inner);
	if (is_good && coder.range.is_overrun)
		is_good = fault_set(&inner, EX_BAD_INPUT, "the stream ends too early");
	for (size_t i = start + coder.range.input_read; i < end && is_good; i++)
		if (bytes[i] != 0)
			is_good = fault_set(&inner, EX_BAD_INPUT, "something follows the cage");
	free(model);
	if (!is_good) {
		ffx_free(ffx);
		return fault_set(fault, inner.code, "%s: damaged: %s", shown, inner.text);
	}
	return true;
}

bool ffx_check(const unsigned char *bytes, size_t size, const char *shown, struct fault *fault)
{
	struct ffx ffx;
	if (!ffx_decode(&ffx, bytes, size, shown, fault))
		return false;
	ffx_free(&ffx);
	return true;
}

void ffx_to_cage(struct cage *cage, const struct ffx *ffx)
{
	*cage = (struct cage){.scheme = ffx->scheme,
			      .vertex_count = ffx->vertex_count,
			      .face_count = ffx->face_count,
			      .sharp_count = ffx->sharp_count};
	cage->xyz = mem_array(3 * ffx->vertex_count, sizeof(double));
	/* Sums in parts of a step are whole numbers below 2^53: each coordinate is rounded once. */
	const int64_t parts = (int64_t)1 << ffx->frame.origin_bits;
	const double part = ffx->has_frame ? ffx->frame.step / (double)parts : 1.0 / ffx_grid_steps(ffx->grid_code);
	for (size_t i = 0; i < 3 * ffx->vertex_count; i++)
		cage->xyz[i] = part * (double)(ffx->has_frame ? ffx->frame.origin[i % 3] + parts * ffx->grid[i] : ffx->grid[i]);
	cage->corner = mem_copy(ffx->corner, ffx->vertex_count, 1);
	cage->face_corner = mem_copy(ffx->face_corner, ffx->face_start[ffx->face_count], sizeof(idx_t));
	cage->face_start = mem_copy(ffx->face_start, ffx->face_count + 1, sizeof(size_t));
	if (ffx->face_patch)
		cage->face_patch = mem_copy(ffx->face_patch, ffx->face_count, sizeof(idx_t));
	else
		cage->face_patch = mem_array(ffx->face_count, sizeof(idx_t));
	cage->sharp = mem_copy(ffx->sharp, 2 * ffx->sharp_count, sizeof(idx_t));
}
