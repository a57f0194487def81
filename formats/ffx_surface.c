/* Half-edges with hole faces (see ffx_surface.h). */
#include "formats/ffx_surface.h"

#include <stdlib.h>

void surface_free(struct ffx_surface *surface)
{
	free(surface->next);
	free(surface->previous);
	free(surface->twin);
	free(surface->origin);
	free(surface->face);
	free(surface->first);
	free(surface->degree);
	free(surface->hole);
	free(surface->outgoing);
	free(surface->root);
	*surface = (struct ffx_surface){0};
}

struct side {
	idx_t low, high, half; /* the edge's vertices and the half-edge along it */
};

static int compare_sides(const void *left, const void *right)
{
	const struct side *a = left, *b = right;
	if (a->low != b->low)
		return a->low < b->low ? -1 : 1;
	if (a->high != b->high)
		return a->high < b->high ? -1 : 1;
	return a->half < b->half ? -1 : a->half > b->half;
}

static bool check_faces(const idx_t *corner, const size_t *face_start, size_t face_count, size_t vertex_count,
			struct fault *fault)
{
	idx_t *seen = mem_array(vertex_count, sizeof *seen);
	bool is_good = true;
	for (size_t f = 0; f < face_count && is_good; f++) {
		if (face_start[f + 1] < face_start[f] + 3)
			is_good = fault_set(fault, EX_BAD_INPUT, "face %zu: fewer than 3 vertices", f);
		for (size_t h = face_start[f]; h < face_start[f + 1] && is_good; h++) {
			const idx_t v = corner[h];
			if (v < 0 || (size_t)v >= vertex_count)
				is_good = fault_set(fault, EX_BAD_INPUT, "face %zu: vertex %" PRIidx " does not exist", f, v);
			else if (seen[v] == (idx_t)f + 1)
				is_good = fault_set(fault, EX_BAD_INPUT, "face %zu: vertex %" PRIidx " twice", f, v);
			else
				seen[v] = (idx_t)f + 1;
		}
	}
	free(seen);
	return is_good;
}

/* Pair the half-edges; those of the border get twins behind the corners of the lists. */
static bool pair_sides(struct ffx_surface *surface, size_t corner_count, struct fault *fault)
{
	struct side *side = mem_array(corner_count, sizeof *side);
	for (size_t h = 0; h < corner_count; h++) {
		const idx_t a = surface->origin[h], b = surface->origin[surface->next[h]];
		side[h] = (struct side){a < b ? a : b, a < b ? b : a, (idx_t)h};
	}
	qsort(side, corner_count, sizeof *side, compare_sides);
	bool is_good = true;
	size_t border = corner_count;
	for (size_t i = 0, n; i < corner_count && is_good; i += n) {
		for (n = 1; i + n < corner_count && side[i + n].low == side[i].low && side[i + n].high == side[i].high; n++)
			;
		const idx_t h = side[i].half;
		if (n > 2) {
			is_good = fault_set(fault, EX_BAD_INPUT, "edge %" PRIidx " %" PRIidx " has %zu faces", side[i].low,
					    side[i].high, n);
		} else if (n == 2) {
			const idx_t t = side[i + 1].half;
			if (surface->origin[h] == surface->origin[t])
				is_good = fault_set(fault, EX_BAD_INPUT,
						    "edge %" PRIidx " %" PRIidx ": its two faces are oriented against each other",
						    side[i].low, side[i].high);
			surface->twin[h] = t;
			surface->twin[t] = h;
		} else {
			surface->twin[h] = (idx_t)border;
			surface->twin[border] = h;
			surface->origin[border] = surface->origin[surface->next[h]];
			border++;
		}
	}
	surface->half_count = border;
	free(side);
	return is_good;
}

/* Link the border half-edges to loops: the next one starts where this ends, across the faces of that vertex. */
static void close_borders(struct ffx_surface *surface, size_t corner_count)
{
	for (size_t t = corner_count; t < surface->half_count; t++) {
		idx_t e = surface->twin[t];
		do
			e = surface->twin[surface->previous[e]];
		while ((size_t)e < corner_count);
		surface->next[t] = e;
		surface->previous[e] = (idx_t)t;
		surface->face[t] = NO_INDEX;
	}
	for (size_t t = corner_count; t < surface->half_count; t++) {
		if (surface->face[t] != NO_INDEX)
			continue;
		const size_t f = surface->face_count++;
		surface->hole[f] = 1;
		surface->hole_count++;
		surface->first[f] = (idx_t)t;
		idx_t h = (idx_t)t;
		do {
			surface->face[h] = (idx_t)f;
			surface->degree[f]++;
			h = surface->next[h];
		} while (h != (idx_t)t);
	}
}

static bool check_fans(struct ffx_surface *surface, struct fault *fault)
{
	idx_t *leaving = mem_array(surface->vertex_count, sizeof *leaving);
	for (size_t v = 0; v < surface->vertex_count; v++)
		surface->outgoing[v] = NO_INDEX;
	for (size_t h = 0; h < surface->half_count; h++) {
		leaving[surface->origin[h]]++;
		if (surface->outgoing[surface->origin[h]] == NO_INDEX)
			surface->outgoing[surface->origin[h]] = (idx_t)h;
	}
	bool is_good = true;
	for (size_t v = 0; v < surface->vertex_count && is_good; v++) {
		if (leaving[v] == 0) {
			is_good = fault_set(fault, EX_BAD_INPUT, "vertex %zu has no face", v);
			break;
		}
		idx_t h = surface->outgoing[v];
		do {
			leaving[v]--;
			h = surface_turn(surface, h);
		} while (h != surface->outgoing[v]);
		if (leaving[v] > 0)
			is_good = fault_set(fault, EX_BAD_INPUT, "vertex %zu has more than one fan of faces", v);
	}
	free(leaving);
	return is_good;
}

bool surface_build(struct ffx_surface *surface, const idx_t *corner, const size_t *face_start, size_t face_count,
		   size_t vertex_count, struct fault *fault)
{
	*surface = (struct ffx_surface){0};
	const size_t corner_count = face_start[face_count];
	if (corner_count > INDEX_LIMIT / 4 || vertex_count > INDEX_LIMIT / 4)
		return fault_set(fault, EX_BAD_INPUT, "too many faces for one cage");
	if (!check_faces(corner, face_start, face_count, vertex_count, fault))
		return false;
	const size_t room = 2 * corner_count;
	surface->vertex_count = vertex_count;
	surface->next = mem_array(room, sizeof(idx_t));
	surface->previous = mem_array(room, sizeof(idx_t));
	surface->twin = mem_array(room, sizeof(idx_t));
	surface->origin = mem_array(room, sizeof(idx_t));
	surface->face = mem_array(room, sizeof(idx_t));
	surface->first = mem_array(face_count + corner_count, sizeof(idx_t));
	surface->degree = mem_array(face_count + corner_count, sizeof(idx_t));
	surface->hole = mem_array(face_count + corner_count, 1);
	surface->outgoing = mem_array(vertex_count, sizeof(idx_t));
	surface->face_count = face_count;
	for (size_t f = 0; f < face_count; f++) {
		surface->first[f] = (idx_t)face_start[f];
		surface->degree[f] = (idx_t)(face_start[f + 1] - face_start[f]);
		for (size_t h = face_start[f]; h < face_start[f + 1]; h++) {
			surface->origin[h] = corner[h];
			surface->face[h] = (idx_t)f;
			surface->next[h] = (idx_t)(h + 1 < face_start[f + 1] ? h + 1 : face_start[f]);
			surface->previous[surface->next[h]] = (idx_t)h;
		}
	}
	if (!pair_sides(surface, corner_count, fault)) {
		surface_free(surface);
		return false;
	}
	close_borders(surface, corner_count);
	if (!check_fans(surface, fault)) {
		surface_free(surface);
		return false;
	}
	return true;
}

bool surface_check(const struct ffx_surface *surface, struct fault *fault)
{
	idx_t *corner = mem_array(surface->half_count, sizeof *corner);
	size_t *start = mem_array(surface->face_count + 1, sizeof *start);
	size_t count = 0, faces = 0;
	for (size_t f = 0; f < surface->face_count; f++) {
		if (surface->hole[f])
			continue;
		idx_t h = surface->first[f];
		do {
			corner[count++] = surface->origin[h];
			h = surface->next[h];
		} while (h != surface->first[f]);
		start[++faces] = count;
	}
	bool is_good = true;
	for (size_t h = 0; h < surface->half_count && is_good; h++)
		if (surface->hole[surface->face[h]] && surface->hole[surface->face[surface->twin[h]]])
			is_good = fault_set(fault, EX_BAD_INPUT, "an edge without a face");
	struct ffx_surface again = {0};
	is_good = is_good && surface_build(&again, corner, start, faces, surface->vertex_count, fault);
	surface_free(&again);
	free(corner);
	free(start);
	return is_good;
}
