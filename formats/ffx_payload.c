/* The parts of an FFX payload in their order (see ffx_payload.h). */
#include "formats/ffx_payload.h"

#include <stdlib.h>
#include <string.h>

#include "formats/ffx_connect.h"
#include "formats/ffx_geometry.h"
#include "formats/ffx_predict.h"

void payload_free(struct payload *payload)
{
	surface_free(&payload->surface);
	free(payload->sharp);
	*payload = (struct payload){0};
}

/* Mark the half-edges of the listed edges. */
static bool mark_sharp(struct payload *payload, struct fault *fault)
{
	const struct ffx *ffx = payload->ffx;
	const struct ffx_surface *s = &payload->surface;
	for (size_t i = 0; i < ffx->sharp_count; i++) {
		const idx_t a = ffx->sharp[2 * i], b = ffx->sharp[2 * i + 1];
		if (a < 0 || b < 0 || (size_t)a >= s->vertex_count || (size_t)b >= s->vertex_count)
			return fault_set(fault, EX_BAD_INPUT, "sharp edge %zu: vertex does not exist", i);
		idx_t h = s->outgoing[a];
		while (surface_end(s, h) != b) {
			h = surface_turn(s, h);
			if (h == s->outgoing[a])
				return fault_set(fault, EX_BAD_INPUT,
						 "sharp edge %zu: no face has an edge from %" PRIidx " to %" PRIidx, i, a, b);
		}
		if (!s->hole[s->face[h]] && !s->hole[s->face[s->twin[h]]])
			payload->sharp[h] = payload->sharp[s->twin[h]] = 1;
	}
	return true;
}

bool payload_prepare(struct payload *payload, const struct ffx *ffx, struct fault *fault)
{
	*payload = (struct payload){.ffx = ffx};
	if (ffx->face_count == 0)
		return fault_set(fault, EX_BAD_INPUT, "the cage has no faces");
	const int32_t steps = ffx_grid_steps(ffx->grid_code);
	for (size_t i = 0; i < 3 * ffx->vertex_count; i++)
		if (ffx->grid[i] < 0 || ffx->grid[i] > steps)
			return fault_set(fault, EX_BAD_INPUT, "vertex %zu is outside the grid", i / 3);
	for (size_t f = 0; ffx->face_patch && f < ffx->face_count; f++)
		if (ffx->face_patch[f] < 0)
			return fault_set(fault, EX_BAD_INPUT, "face %zu has no patch", f);
	if (!surface_build(&payload->surface, ffx->face_corner, ffx->face_start, ffx->face_count, ffx->vertex_count, fault))
		return false;
	payload->sharp = mem_array(payload->surface.half_count, 1);
	if (!mark_sharp(payload, fault)) {
		payload_free(payload);
		return false;
	}
	return true;
}

/* Everything after positions, the same for both directions. */
static bool code_flags(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const int32_t *grid,
		       unsigned char *sharp, unsigned char *corner, idx_t *patch, struct fault *fault)
{
	return sharp_code(coder, surface, order, grid, sharp, fault) &&
	       corner_code(coder, surface, order, grid, sharp, corner, fault) &&
	       (!patch || patch_code(coder, surface, grid, sharp, patch, fault));
}

static idx_t *counted(size_t count)
{
	idx_t *number = mem_array(count, sizeof *number);
	for (size_t i = 0; i < count; i++)
		number[i] = (idx_t)i;
	return number;
}

/* Connectivity and positions, coded: the surface as the decoder will see it, where its half-edges come from, its vertices'
 * order and positions. */
struct coded {
	struct ffx_surface surface;
	const idx_t *original;
	idx_t *owned; /* original, when it is to be freed */
	idx_t *order, *rank;
	int32_t *grid;
};

static void coded_free(struct coded *c)
{
	surface_free(&c->surface);
	free(c->owned);
	free(c->order);
	free(c->rank);
	free(c->grid);
}

static bool encode_labels(struct coded *c, struct ffx_coder *coder, struct payload_report *report, const struct payload *payload,
			  idx_t root, struct fault *fault)
{
	const uint64_t start = coder->cost;
	struct labels labels;
	labels_make(&labels, &payload->surface, root);
	report->label_count = labels.count;
	report->component_count = labels.component_count;
	report->handle_count = labels.handle_count;
	const bool is_good = connect_code(coder, &c->surface, &labels, &c->owned, INDEX_LIMIT / 4, fault);
	labels_free(&labels);
	report->cost_c = coder->cost - start;
	if (!is_good)
		return false;
	c->original = c->owned;
	const struct ffx_surface *s = &c->surface;
	c->grid = mem_array(3 * s->vertex_count, sizeof *c->grid);
	for (size_t h = 0; h < s->half_count; h++)
		memcpy(c->grid + 3 * (size_t)s->origin[h],
		       payload->ffx->grid + 3 * (size_t)payload->surface.origin[c->original[h]], 3 * sizeof *c->grid);
	c->order = mem_array(s->vertex_count, sizeof(idx_t));
	c->rank = mem_array(s->vertex_count, sizeof(idx_t));
	predict_order(c->order, c->rank, s);
	if (!geometry_code(coder, s, c->order, c->rank, c->grid, ffx_grid_steps(payload->ffx->grid_code), fault))
		return false;
	report->cost_g = coder->cost - start - report->cost_c;
	return true;
}

static bool encode_forward(struct coded *c, struct ffx_coder *coder, struct payload_report *report, const struct payload *payload,
			   idx_t root, struct forward *forward, struct fault *fault)
{
	const uint64_t start = coder->cost;
	if (!forward_code(forward, coder, &payload->surface, payload->ffx->grid, root, ffx_grid_steps(payload->ffx->grid_code),
			  INDEX_LIMIT / 4, fault))
		return false;
	forward_surface(&c->surface, forward);
	c->original = forward->source;
	c->order = counted(forward->vertex_count);
	c->grid = mem_copy(forward->grid, forward->vertex_count, 3 * sizeof *c->grid);
	report->label_count = forward->half_count / 2;
	report->component_count = forward->component_count;
	report->cost_g = forward->cost_g;
	report->cost_c = coder->cost - start - forward->cost_g;
	/* V - E + F of the surface with its holes closed is 2 (components - handles). */
	report->handle_count = (size_t)((2 * (int64_t)c->surface.component_count - (int64_t)c->surface.vertex_count +
					 (int64_t)c->surface.half_count / 2 - (int64_t)c->surface.face_count) /
					2);
	return true;
}

bool payload_encode(struct ffx_coder *coder, struct payload_report *report, const struct payload *payload, enum ffx_method method,
		    idx_t root, struct forward *forward, struct fault *fault)
{
	const struct ffx *ffx = payload->ffx;
	*report = (struct payload_report){0};
	struct coded c = {0};
	bool is_good = method == FFX_FORWARD ? encode_forward(&c, coder, report, payload, root, forward, fault)
					     : encode_labels(&c, coder, report, payload, root, fault);
	if (is_good) {
		/* Carry the flags over to the surface as the decoder will see it. */
		const struct ffx_surface *s = &c.surface;
		unsigned char *corner = mem_array(s->vertex_count, 1), *sharp = mem_array(s->half_count, 1);
		idx_t *patch = ffx->face_patch ? mem_array(s->face_count, sizeof *patch) : NULL;
		for (size_t h = 0; h < s->half_count; h++) {
			const idx_t from = c.original[h];
			corner[s->origin[h]] = ffx->corner && ffx->corner[payload->surface.origin[from]];
			sharp[h] = payload->sharp[from];
			if (patch && !s->hole[s->face[h]])
				patch[s->face[h]] = ffx->face_patch[payload->surface.face[from]];
		}
		const uint64_t before = coder->cost;
		is_good = code_flags(coder, s, c.order, c.grid, sharp, corner, patch, fault);
		report->cost_f = coder->cost - before;
		free(corner);
		free(sharp);
		free(patch);
	}
	coded_free(&c);
	return is_good;
}

static int compare_edges(const void *left, const void *right)
{
	const idx_t *a = left, *b = right;
	if (a[0] != b[0])
		return a[0] < b[0] ? -1 : 1;
	return a[1] < b[1] ? -1 : a[1] > b[1];
}

/* The surface as lists; vertices numbered by rank. */
static void take_lists(struct ffx *ffx, const struct ffx_surface *s, const idx_t *rank, const int32_t *grid,
		       const unsigned char *sharp, const unsigned char *corner, const idx_t *patch)
{
	ffx->vertex_count = s->vertex_count;
	ffx->grid = mem_array(3 * s->vertex_count, sizeof(int32_t));
	ffx->corner = mem_array(s->vertex_count, 1);
	for (size_t v = 0; v < s->vertex_count; v++) {
		memcpy(ffx->grid + 3 * (size_t)rank[v], grid + 3 * v, 3 * sizeof *grid);
		ffx->corner[rank[v]] = corner[v];
	}
	ffx->face_corner = mem_array(s->half_count, sizeof(idx_t));
	ffx->face_start = mem_array(s->face_count + 1, sizeof(size_t));
	ffx->face_patch = patch ? mem_array(s->face_count, sizeof(idx_t)) : NULL;
	size_t count = 0;
	for (size_t f = 0; f < s->face_count; f++) {
		if (s->hole[f])
			continue;
		idx_t h = s->first[f];
		do {
			ffx->face_corner[count++] = rank[s->origin[h]];
			h = s->next[h];
		} while (h != s->first[f]);
		if (patch)
			ffx->face_patch[ffx->face_count] = patch[f];
		ffx->face_start[++ffx->face_count] = count;
	}
	ffx->sharp = mem_array(s->half_count, sizeof(idx_t));
	for (size_t h = 0; h < s->half_count; h++) {
		const idx_t a = rank[s->origin[h]], b = rank[surface_end(s, (idx_t)h)];
		if (!sharp[h] || a > b)
			continue;
		ffx->sharp[2 * ffx->sharp_count] = a;
		ffx->sharp[2 * ffx->sharp_count + 1] = b;
		ffx->sharp_count++;
	}
	qsort(ffx->sharp, ffx->sharp_count, 2 * sizeof(idx_t), compare_edges);
}

static bool decode_labels(struct coded *c, struct ffx_coder *coder, int32_t steps, size_t edge_limit, struct fault *fault)
{
	if (!connect_code(coder, &c->surface, NULL, NULL, edge_limit, fault))
		return false;
	const struct ffx_surface *s = &c->surface;
	c->grid = mem_array(3 * s->vertex_count, sizeof *c->grid);
	c->order = mem_array(s->vertex_count, sizeof(idx_t));
	c->rank = mem_array(s->vertex_count, sizeof(idx_t));
	predict_order(c->order, c->rank, s);
	return geometry_code(coder, s, c->order, c->rank, c->grid, steps, fault);
}

static bool decode_forward(struct coded *c, struct ffx_coder *coder, int32_t steps, size_t edge_limit, struct fault *fault)
{
	struct forward forward = {0};
	bool is_good = forward_code(&forward, coder, NULL, NULL, 0, steps, edge_limit, fault);
	if (is_good) {
		forward_surface(&c->surface, &forward);
		c->grid = mem_copy(forward.grid, forward.vertex_count, 3 * sizeof *c->grid);
		c->order = counted(forward.vertex_count);
		c->rank = counted(forward.vertex_count);
		is_good = surface_check(&c->surface, fault);
	}
	forward_free(&forward);
	return is_good;
}

bool payload_decode(struct ffx_coder *coder, struct ffx *ffx, bool has_patches, size_t edge_limit, struct fault *fault)
{
	struct coded c = {0};
	const int32_t steps = ffx_grid_steps(ffx->grid_code);
	bool is_good = ffx->method == FFX_FORWARD ? decode_forward(&c, coder, steps, edge_limit, fault)
						  : decode_labels(&c, coder, steps, edge_limit, fault);
	if (is_good) {
		const struct ffx_surface *s = &c.surface;
		unsigned char *corner = mem_array(s->vertex_count, 1), *sharp = mem_array(s->half_count, 1);
		idx_t *patch = has_patches ? mem_array(s->face_count, sizeof *patch) : NULL;
		is_good = code_flags(coder, s, c.order, c.grid, sharp, corner, patch, fault);
		if (is_good)
			take_lists(ffx, s, c.rank, c.grid, sharp, corner, patch);
		free(corner);
		free(sharp);
		free(patch);
	}
	coded_free(&c);
	return is_good;
}
