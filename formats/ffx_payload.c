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

/* Everything after connectivity, the same for both directions. */
static bool code_attributes(struct ffx_coder *coder, struct payload_report *report, const struct ffx_surface *surface,
			    const idx_t *order, const idx_t *rank, int32_t *grid, int32_t steps, unsigned char *sharp,
			    unsigned char *corner, idx_t *patch, struct fault *fault)
{
	const uint64_t start = coder->cost;
	if (!geometry_code(coder, surface, order, rank, grid, steps, fault))
		return false;
	const uint64_t middle = coder->cost;
	const bool is_good = sharp_code(coder, surface, order, grid, sharp, fault) &&
			     corner_code(coder, surface, order, grid, sharp, corner, fault) &&
			     (!patch || patch_code(coder, surface, grid, sharp, patch, fault));
	if (report) {
		report->cost_g = middle - start;
		report->cost_f = coder->cost - middle;
	}
	return is_good;
}

bool payload_encode(struct ffx_coder *coder, struct payload_report *report, const struct payload *payload, idx_t root,
		    struct fault *fault)
{
	const struct ffx *ffx = payload->ffx;
	struct labels labels;
	labels_make(&labels, &payload->surface, root);
	struct ffx_surface s;
	idx_t *original = NULL;
	*report = (struct payload_report){
		.label_count = labels.count, .component_count = labels.component_count, .handle_count = labels.handle_count};
	bool is_good = connect_code(coder, &s, &labels, &original, INDEX_LIMIT / 4, fault);
	report->cost_c = coder->cost;
	labels_free(&labels);
	if (!is_good)
		return false;
	/* Carry the attributes over to the surface as the decoder will see it. */
	int32_t *grid = mem_array(3 * s.vertex_count, sizeof *grid);
	unsigned char *corner = mem_array(s.vertex_count, 1), *sharp = mem_array(s.half_count, 1);
	idx_t *patch = ffx->face_patch ? mem_array(s.face_count, sizeof *patch) : NULL;
	for (size_t h = 0; h < s.half_count; h++) {
		const idx_t from = payload->surface.origin[original[h]];
		memcpy(grid + 3 * (size_t)s.origin[h], ffx->grid + 3 * (size_t)from, 3 * sizeof *grid);
		corner[s.origin[h]] = ffx->corner && ffx->corner[from];
		sharp[h] = payload->sharp[original[h]];
		if (patch && !s.hole[s.face[h]])
			patch[s.face[h]] = ffx->face_patch[payload->surface.face[original[h]]];
	}
	idx_t *order = mem_array(s.vertex_count, sizeof *order), *rank = mem_array(s.vertex_count, sizeof *rank);
	predict_order(order, rank, &s);
	is_good = code_attributes(coder, report, &s, order, rank, grid, ffx_grid_steps(ffx->grid_code), sharp, corner, patch,
				  fault);
	free(order);
	free(rank);
	free(grid);
	free(corner);
	free(sharp);
	free(patch);
	free(original);
	surface_free(&s);
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

bool payload_decode(struct ffx_coder *coder, struct ffx *ffx, bool has_patches, size_t label_limit, struct fault *fault)
{
	struct ffx_surface s;
	if (!connect_code(coder, &s, NULL, NULL, label_limit, fault))
		return false;
	int32_t *grid = mem_array(3 * s.vertex_count, sizeof *grid);
	unsigned char *corner = mem_array(s.vertex_count, 1), *sharp = mem_array(s.half_count, 1);
	idx_t *patch = has_patches ? mem_array(s.face_count, sizeof *patch) : NULL;
	idx_t *order = mem_array(s.vertex_count, sizeof *order), *rank = mem_array(s.vertex_count, sizeof *rank);
	predict_order(order, rank, &s);
	const bool is_good =
		code_attributes(coder, NULL, &s, order, rank, grid, ffx_grid_steps(ffx->grid_code), sharp, corner, patch, fault);
	if (is_good)
		take_lists(ffx, &s, rank, grid, sharp, corner, patch);
	free(order);
	free(rank);
	free(grid);
	free(corner);
	free(sharp);
	free(patch);
	surface_free(&s);
	return is_good;
}
