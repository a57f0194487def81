/* Half-edges as flat arrays: twins come from OpenMesh, next and previous from the face lists. */
#include "stages/geometry/half.h"

#include <stdlib.h>
#include <string.h>

#include "formats/shim/openmesh.h"

void half_free(struct half *half)
{
	free(half->origin);
	free(half->next);
	free(half->previous);
	free(half->twin);
	free(half->face);
	free(half->outgoing);
	*half = (struct half){0};
}

/* A half-edge by its ends, for sorting; forward tells the direction. */
struct side {
	idx_t low, high, half;
};

static int compare_sides(const void *left, const void *right)
{
	const struct side *a = left, *b = right;
	if (a->low != b->low)
		return a->low < b->low ? -1 : 1;
	if (a->high != b->high)
		return a->high < b->high ? -1 : 1;
	return (a->half > b->half) - (a->half < b->half);
}

/* Twins by sorting, and what is wrong with the edges if anything is: OpenMesh only says that something is. */
static bool sort_twins(struct half *half, struct fault *fault)
{
	struct side *side = mem_array(half->half_count, sizeof *side);
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t a = half->origin[h], b = half->origin[half->next[h]];
		side[h] = (struct side){a < b ? a : b, a < b ? b : a, (idx_t)h};
		half->twin[h] = NO_INDEX;
	}
	qsort(side, half->half_count, sizeof *side, compare_sides);
	bool good = true;
	for (size_t i = 0, end; i < half->half_count && good; i = end) {
		for (end = i + 1; end < half->half_count && side[end].low == side[i].low && side[end].high == side[i].high;)
			end++;
		if (end - i > 2)
			good = fault_set(fault, EX_BAD_INPUT, "edge %" PRIidx "-%" PRIidx " has %zu faces", side[i].low,
					 side[i].high, end - i);
		if (end - i != 2)
			continue;
		const idx_t g = side[i].half, h = side[i + 1].half;
		if (half->origin[g] == half->origin[h])
			good = fault_set(fault, EX_BAD_INPUT,
					 "faces %" PRIidx " and %" PRIidx " run along edge %" PRIidx "-%" PRIidx
					 " in the same direction",
					 half->face[g], half->face[h], side[i].low, side[i].high);
		half->twin[g] = h;
		half->twin[h] = g;
	}
	free(side);
	return good;
}

/* Every half-edge must be met when walking around the vertex that it starts from. */
static bool check_fans(const struct half *half, struct fault *fault)
{
	unsigned char *met = mem_array(half->half_count, 1);
	for (size_t v = 0; v < half->vertex_count; v++) {
		const idx_t first = half->outgoing[v];
		if (first == NO_INDEX)
			continue;
		idx_t h = first;
		do {
			met[h] = 1;
			h = half->twin[half->previous[h]]; /* the next one counter-clockwise */
		} while (h != NO_INDEX && h != first);
	}
	bool good = true;
	for (size_t h = 0; h < half->half_count && good; h++)
		if (!met[h])
			good = fault_set(fault, EX_BAD_INPUT, "the faces at vertex %" PRIidx " make more than one fan",
					 half->origin[h]);
	free(met);
	return good;
}

/* Corners in range, at least three a face, no vertex twice in one. */
static bool check_faces(const idx_t *corner, const size_t *face_start, size_t face_count, size_t vertex_count,
			struct fault *fault)
{
	idx_t *last_face = mem_array(vertex_count, sizeof *last_face); /* the face after which v was seen, + 1 */
	bool good = true;
	for (size_t f = 0; f < face_count && good; f++) {
		if (face_start[f + 1] - face_start[f] < 3)
			good = fault_set(fault, EX_BAD_INPUT, "face %zu has fewer than 3 corners", f);
		for (size_t h = face_start[f]; h < face_start[f + 1] && good; h++) {
			if (corner[h] < 0 || (size_t)corner[h] >= vertex_count)
				good = fault_set(fault, EX_BAD_INPUT, "face %zu: vertex %" PRIidx " is not in [0, %zu)", f,
						 corner[h], vertex_count);
			else if (last_face[corner[h]] == (idx_t)f + 1)
				good = fault_set(fault, EX_BAD_INPUT, "face %zu has vertex %" PRIidx " twice", f, corner[h]);
			else
				last_face[corner[h]] = (idx_t)f + 1;
		}
	}
	free(last_face);
	return good;
}

bool half_build(struct half *half, const idx_t *corner, const size_t *face_start, size_t face_count, size_t vertex_count,
		struct fault *fault)
{
	*half = (struct half){0};
	const size_t half_count = face_start[face_count];
	if (half_count > INDEX_LIMIT || vertex_count > INDEX_LIMIT)
		return fault_set(fault, EX_BAD_INPUT, "%zu face corners are too many", half_count);
	if (!check_faces(corner, face_start, face_count, vertex_count, fault))
		return false;
	half->vertex_count = vertex_count;
	half->face_count = face_count;
	half->half_count = half_count;
	half->origin = mem_copy(corner, half_count, sizeof *corner);
	half->next = mem_array(half_count, sizeof *half->next);
	half->previous = mem_array(half_count, sizeof *half->previous);
	half->face = mem_array(half_count, sizeof *half->face);
	half->twin = mem_array(half_count, sizeof *half->twin);
	half->outgoing = mem_array(vertex_count, sizeof *half->outgoing);
	for (size_t f = 0; f < face_count; f++)
		for (size_t h = face_start[f]; h < face_start[f + 1]; h++) {
			const size_t next = h + 1 < face_start[f + 1] ? h + 1 : face_start[f];
			half->next[h] = (idx_t)next;
			half->previous[next] = (idx_t)h;
			half->face[h] = (idx_t)f;
		}
	char message[200];
	if (shim_twins(half->twin, corner, face_start, face_count, vertex_count, message, sizeof message) != 0 &&
	    !sort_twins(half, fault)) {
		half_free(half);
		return false;
	}
	for (size_t v = 0; v < vertex_count; v++)
		half->outgoing[v] = NO_INDEX;
	/* The lowest half-edge, so that the answer does not depend on the library; at a border the one where a walk that
	 * turns counter-clockwise, over twin[previous[h]], meets all others. */
	for (size_t h = 0; h < half_count; h++) {
		idx_t *const first = &half->outgoing[corner[h]];
		if (*first == NO_INDEX || (half->twin[h] == NO_INDEX && half->twin[*first] != NO_INDEX))
			*first = (idx_t)h;
	}
	if (!check_fans(half, fault)) {
		half_free(half);
		return false;
	}
	return true;
}

bool half_build_triangles(struct half *half, const idx_t *triangle, size_t triangle_count, size_t vertex_count,
			  struct fault *fault)
{
	size_t *face_start = mem_array(triangle_count + 1, sizeof *face_start);
	for (size_t t = 0; t <= triangle_count; t++)
		face_start[t] = 3 * t;
	const bool good = half_build(half, triangle, face_start, triangle_count, vertex_count, fault);
	free(face_start);
	return good;
}

size_t half_edge_count(const struct half *half)
{
	size_t count = 0;
	for (size_t h = 0; h < half->half_count; h++)
		count += half->twin[h] == NO_INDEX || (size_t)half->twin[h] > h;
	return count;
}
