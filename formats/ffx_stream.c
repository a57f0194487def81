/* FFX streams: header, frame, payload, checksum (see ffx.h and ffx(5)). */
#include "formats/ffx.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "formats/ffx_connect.h"
#include "formats/ffx_payload.h"

#define MAGIC 0xfa /* in no text: UTF-8 has no such byte */
#define HEADER_SIZE 3
/* Streams up to this size end in a CRC-16, longer ones in a CRC-32. The 16 bits find every change of one or two bits and
 * every burst up to 16 bits in so short a stream, and let one in 65536 other damages pass; those decode to a valid mesh or
 * are refused for a contradiction. */
#define SHORT_STREAM 1024

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

struct ffx_work {
	struct ffx_model start, model;
	struct forward forward;
	struct range range;
};

struct ffx_work *ffx_work_new(void)
{
	struct ffx_work *work = mem_array(1, sizeof *work);
	model_init(&work->start);
	model_reset(&work->model, &work->start, false);
	return work;
}

void ffx_work_free(struct ffx_work *work)
{
	forward_free(&work->forward);
	free(work->range.bytes);
	free(work);
}

struct attempt {
	unsigned char *bytes;
	size_t size;
	uint64_t cost;
	size_t root;
	enum ffx_method method;
	uint64_t frame_cost;
	struct payload_report report;
};

/* All that the range coder carries. */
static bool code_all(struct ffx_coder *coder, struct attempt *attempt, const struct payload *payload, struct forward *forward,
		     struct fault *fault)
{
	if (payload->ffx->has_frame) {
		struct ffx_frame frame = payload->ffx->frame;
		if (!frame_code(coder, &frame, ffx_grid_steps(payload->ffx->grid_code), fault))
			return false;
	}
	attempt->frame_cost = coder->cost;
	if (!payload_encode(coder, &attempt->report, payload, attempt->method, (idx_t)attempt->root, forward, fault))
		return false;
	attempt->cost = coder->cost;
	return true;
}

static bool encode_from(struct attempt *attempt, const struct payload *payload, struct ffx_work *work, struct fault *fault)
{
	struct ffx_coder coder = {.model = &work->model};
	model_reset(&work->model, &work->start, attempt->method == FFX_FORWARD);
	range_encode(&coder.range);
	if (!code_all(&coder, attempt, payload, &work->forward, fault)) {
		free(coder.range.bytes);
		return false;
	}
	range_finish(&coder.range);
	attempt->bytes = coder.range.bytes;
	attempt->size = coder.range.size;
	return true;
}

/* Encodings are tried as long as they take about as many edges together: half a second or so. */
#define ROOT_WORK 60000

/* The smallest encoding of all that are tried; the first of those of equal size and cost. FFX_BEST: every start edge by both
 * methods. */
static bool encode_best(struct attempt *best, const struct payload *payload, const struct ffx_options *options,
			enum ffx_method method, struct fault *fault)
{
	const size_t halves = payload->surface.half_count;
	size_t tries = options->root_limit ? options->root_limit : 1 + ROOT_WORK / halves;
	if (tries > halves)
		tries = halves;
	struct ffx_work *work = ffx_work_new();
	*best = (struct attempt){0};
	for (int pass = 0; pass < 2; pass++) {
		const enum ffx_method now = pass ? FFX_FACE_FIXER : FFX_FORWARD;
		if (method != FFX_BEST && method != now)
			continue;
		for (size_t i = 0; i < tries; i++) {
			struct attempt attempt = {.method = now, .root = (options->first_root + i * halves / tries) % halves};
			if (!encode_from(&attempt, payload, work, fault))
				break;
			if (!best->bytes || attempt.size < best->size ||
			    (attempt.size == best->size && attempt.cost < best->cost)) {
				free(best->bytes);
				*best = attempt;
			} else {
				free(attempt.bytes);
			}
		}
	}
	ffx_work_free(work);
	return best->bytes != NULL;
}

static bool check_grid_and_frame(const struct ffx *ffx, struct fault *fault)
{
	if (ffx->grid_code >= FFX_GRID_CODES)
		return fault_set(fault, EX_BUG, "there is no grid %u", ffx->grid_code);
	const struct ffx_frame *frame = &ffx->frame;
	if (ffx->has_frame && (frame->origin_bits > 15 || frame->step == 0 ||
			       ffx_frame_step(frame->step, ffx_grid_steps(ffx->grid_code), frame->origin_bits) != frame->step))
		return fault_set(fault, EX_BUG, "the frame cannot be stored exactly");
	for (int k = 0; ffx->has_frame && k < 3; k++)
		if (frame->origin[k] < -FFX_ORIGIN_LIMIT || frame->origin[k] > FFX_ORIGIN_LIMIT)
			return fault_set(fault, EX_BAD_INPUT, "the cage is too far from the origin for its size");
	return true;
}

static void fill_report(struct ffx_report *report, const struct payload *payload, const struct attempt *attempt)
{
	const double per_byte = 8 * 4096;
	const struct ffx_surface *s = &payload->surface;
	*report = (struct ffx_report){.vertex_count = s->vertex_count,
				      .edge_count = s->half_count / 2,
				      .face_count = s->face_count - s->hole_count,
				      .hole_count = s->hole_count,
				      .component_count = attempt->report.component_count,
				      .handle_count = attempt->report.handle_count,
				      .label_count = attempt->report.label_count,
				      .root = attempt->root,
				      .method = attempt->method,
				      .bytes_frame = (double)attempt->frame_cost / per_byte,
				      .bytes_c = (double)attempt->report.cost_c / per_byte,
				      .bytes_g = (double)attempt->report.cost_g / per_byte,
				      .bytes_f = (double)attempt->report.cost_f / per_byte};
}

double ffx_cost(struct ffx_work *work, const struct ffx *ffx, size_t root, struct ffx_report *report, struct fault *fault)
{
	struct payload payload;
	if (!check_grid_and_frame(ffx, fault) || !payload_prepare(&payload, ffx, fault))
		return HUGE_VAL;
	struct attempt attempt = {.method = ffx->method == FFX_FACE_FIXER ? FFX_FACE_FIXER : FFX_FORWARD,
				  .root = root % payload.surface.half_count};
	struct ffx_coder coder = {.model = &work->model};
	model_reset(&work->model, &work->start, attempt.method == FFX_FORWARD);
	unsigned char *bytes = work->range.bytes;
	const size_t capacity = work->range.capacity;
	range_encode(&coder.range);
	coder.range.bytes = bytes;
	coder.range.capacity = capacity;
	const bool is_good = code_all(&coder, &attempt, &payload, &work->forward, fault);
	work->range = coder.range;
	const double total = HEADER_SIZE + 2 + (double)attempt.cost / (8 * 4096);
	if (report && is_good) {
		fill_report(report, &payload, &attempt);
		report->bytes_header = HEADER_SIZE + 2;
		report->bytes_total = (size_t)ceil(total);
	}
	payload_free(&payload);
	return is_good ? total : HUGE_VAL;
}

bool ffx_encode(unsigned char **bytes, size_t *size, struct ffx_report *report, const struct ffx *ffx,
		const struct ffx_options *options, struct fault *fault)
{
	if (!check_grid_and_frame(ffx, fault))
		return false;
	struct payload payload;
	if (!payload_prepare(&payload, ffx, fault))
		return false;
	struct attempt best;
	if (!encode_best(&best, &payload, options ? options : &(struct ffx_options){0}, ffx->method, fault)) {
		payload_free(&payload);
		return false;
	}
	/* Zero bytes change nothing for the decoder; they keep its rule on labels for cages that compress all too well. */
	size_t payload_size = best.size;
	if (best.report.label_count > LABELS_FREE + LABELS_PER_BYTE * payload_size)
		payload_size = (best.report.label_count - LABELS_FREE + LABELS_PER_BYTE - 1) / LABELS_PER_BYTE;
	unsigned char *out = mem_array(HEADER_SIZE + payload_size + 4, 1);
	size_t at = 0;
	out[at++] = MAGIC;
	out[at++] = (unsigned char)(FFX_VERSION | ffx->scheme << 2 | (best.method == FFX_FORWARD) << 4 |
				    (ffx->has_frame ? 32 : 0) | (ffx->face_patch ? 64 : 0));
	out[at++] = (unsigned char)ffx->grid_code;
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
		fill_report(report, &payload, &best);
		report->bytes_header = header + sum_size;
		report->bytes_total = at;
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

static bool read_header(struct ffx *ffx, const unsigned char *bytes, const char *shown, struct fault *fault)
{
	ffx->scheme = (enum cage_scheme)(bytes[1] >> 2 & 3);
	ffx->method = bytes[1] & 16 ? FFX_FORWARD : FFX_FACE_FIXER;
	ffx->has_frame = bytes[1] & 32;
	ffx->grid_code = bytes[2];
	if (ffx->scheme > SCHEME_CATMULLCLARK)
		return fault_set(fault, EX_BAD_INPUT, "%s: byte 1: unknown subdivision scheme %d", shown, (int)ffx->scheme);
	if (bytes[1] & 128)
		return fault_set(fault, EX_BAD_INPUT, "%s: byte 1: an unknown flag is set", shown);
	if (ffx->grid_code >= FFX_GRID_CODES)
		return fault_set(fault, EX_BAD_INPUT, "%s: byte 2: there is no grid %u", shown, ffx->grid_code);
	return true;
}

bool ffx_is_stream(const unsigned char *bytes, size_t size)
{
	return size >= HEADER_SIZE && bytes[0] == MAGIC && (bytes[1] & 3) == FFX_VERSION;
}

bool ffx_decode(struct ffx *ffx, const unsigned char *bytes, size_t size, const char *shown, struct fault *fault)
{
	*ffx = (struct ffx){0};
	if (size < 1 || bytes[0] != MAGIC)
		return fault_set(fault, EX_BAD_INPUT, "%s: not an FFX stream", shown);
	if (size < HEADER_SIZE + 2)
		return fault_set(fault, EX_BAD_INPUT, "%s: the stream ends in its header", shown);
	if ((bytes[1] & 3) != FFX_VERSION)
		return fault_set(fault, EX_BAD_INPUT, "%s: FFX version %d is not known here (only %d)", shown, bytes[1] & 3,
				 FFX_VERSION);
	const size_t sum_size = size <= SHORT_STREAM ? 2 : 4, end = size - sum_size;
	uint32_t sum = 0;
	for (size_t i = 0; i < sum_size; i++)
		sum |= (uint32_t)bytes[end + i] << 8 * i;
	if (checksum_size(end) != sum_size || sum != checksum(bytes, end))
		return fault_set(fault, EX_BAD_INPUT, "%s: damaged: the checksum differs", shown);
	if (!read_header(ffx, bytes, shown, fault))
		return false;
	const size_t start = HEADER_SIZE;
	struct ffx_model *model = mem_array(1, sizeof *model);
	struct ffx_coder coder = {.model = model};
	model_init(model);
	range_decode(&coder.range, bytes + start, end - start);
	struct fault inner = {0};
	const size_t label_limit = LABELS_FREE + LABELS_PER_BYTE * (end - start);
	bool is_good = !ffx->has_frame || frame_code(&coder, &ffx->frame, ffx_grid_steps(ffx->grid_code), &inner);
	is_good = is_good && payload_decode(&coder, ffx, bytes[1] & 64,
					    label_limit < INDEX_LIMIT / 4 ? label_limit : INDEX_LIMIT / 4, &inner);
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
