/* Editable polygon mesh. */
#include "stages/assemble/polymesh.h"

#include <stdlib.h>
#include <string.h>

void polymesh_init(struct polymesh *mesh, const double *xyz, size_t vertex_count, const idx_t *corner, const size_t *face_start,
		   const idx_t *face_patch, size_t face_count)
{
	const size_t n = face_start[face_count];
	*mesh = (struct polymesh){.vertex_count = vertex_count, .face_count = face_count, .half_count = n};
	mesh->xyz = mem_copy(xyz, 3 * vertex_count, sizeof *xyz);
	mesh->corner = mem_array(vertex_count, 1);
	mesh->origin = mem_copy(corner, n, sizeof *corner);
	mesh->next = mem_array(n, sizeof *mesh->next);
	mesh->previous = mem_array(n, sizeof *mesh->previous);
	mesh->face = mem_array(n, sizeof *mesh->face);
	mesh->twin = mem_array(n, sizeof *mesh->twin);
	mesh->sharp = mem_array(n, sizeof *mesh->sharp);
	mesh->half_gone = mem_array(n, sizeof *mesh->half_gone);
	mesh->face_patch = mem_copy(face_patch, face_count, sizeof *face_patch);
	mesh->face_half = mem_array(face_count, sizeof *mesh->face_half);
	for (size_t f = 0; f < face_count; f++) {
		mesh->face_half[f] = (idx_t)face_start[f];
		for (size_t h = face_start[f]; h < face_start[f + 1]; h++) {
			mesh->next[h] = (idx_t)(h + 1 < face_start[f + 1] ? h + 1 : face_start[f]);
			mesh->previous[mesh->next[h]] = (idx_t)h;
			mesh->face[h] = (idx_t)f;
			mesh->twin[h] = NO_INDEX;
		}
	}
}

void polymesh_copy(struct polymesh *to, const struct polymesh *from)
{
	const size_t v = from->vertex_count, f = from->face_count, h = from->half_count;
	*to = *from;
	to->xyz = mem_copy(from->xyz, 3 * v, sizeof *to->xyz);
	to->corner = mem_copy(from->corner, v, 1);
	to->origin = mem_copy(from->origin, h, sizeof *to->origin);
	to->next = mem_copy(from->next, h, sizeof *to->next);
	to->previous = mem_copy(from->previous, h, sizeof *to->previous);
	to->face = mem_copy(from->face, h, sizeof *to->face);
	to->twin = mem_copy(from->twin, h, sizeof *to->twin);
	to->sharp = mem_copy(from->sharp, h, sizeof *to->sharp);
	to->face_patch = mem_copy(from->face_patch, f, sizeof *to->face_patch);
	to->face_half = mem_copy(from->face_half, f, sizeof *to->face_half);
	to->half_gone = mem_copy(from->half_gone, h, sizeof *to->half_gone);
}

void polymesh_free(struct polymesh *mesh)
{
	free(mesh->xyz), free(mesh->corner), free(mesh->origin), free(mesh->next), free(mesh->previous), free(mesh->face),
		free(mesh->twin);
	free(mesh->sharp), free(mesh->half_gone), free(mesh->face_patch), free(mesh->face_half);
	*mesh = (struct polymesh){0};
}

void polymesh_outgoing(idx_t *outgoing, const struct polymesh *mesh)
{
	for (size_t v = 0; v < mesh->vertex_count; v++)
		outgoing[v] = NO_INDEX;
	for (size_t h = 0; h < mesh->half_count; h++)
		if (!mesh->half_gone[h] && outgoing[mesh->origin[h]] == NO_INDEX)
			outgoing[mesh->origin[h]] = (idx_t)h;
	for (size_t h = 0; h < mesh->half_count; h++)
		if (!mesh->half_gone[h] && mesh->twin[mesh->previous[h]] == NO_INDEX)
			outgoing[mesh->origin[h]] = (idx_t)h;
}

size_t polymesh_split_fans(struct polymesh *mesh)
{
	bool *done = mem_array(mesh->half_count, sizeof *done), *taken = mem_array(mesh->vertex_count, sizeof *taken);
	const size_t before = mesh->vertex_count;
	size_t room = before;
	for (size_t start = 0; start < mesh->half_count; start++) {
		if (done[start] || mesh->half_gone[start])
			continue;
		const idx_t vertex = mesh->origin[start];
		idx_t name = vertex;
		if (taken[vertex]) {
			if (mesh->vertex_count == room) {
				room += room / 2 + 8;
				mesh->xyz = mem_resize(mesh->xyz, 3 * room, sizeof *mesh->xyz);
				mesh->corner = mem_resize(mesh->corner, room, 1);
			}
			name = (idx_t)mesh->vertex_count++;
			memcpy(mesh->xyz + 3 * (size_t)name, mesh->xyz + 3 * (size_t)vertex, 3 * sizeof *mesh->xyz);
			mesh->corner[name] = mesh->corner[vertex];
		}
		taken[vertex] = true;
		/* around the vertex both ways: counter-clockwise over previous' twin, clockwise over the twin's next */
		for (idx_t h = (idx_t)start; h != NO_INDEX && !done[h]; h = mesh->twin[mesh->previous[h]]) {
			done[h] = true;
			mesh->origin[h] = name;
		}
		for (idx_t t = mesh->twin[start]; t != NO_INDEX && !done[mesh->next[t]]; t = mesh->twin[mesh->next[t]]) {
			done[mesh->next[t]] = true;
			mesh->origin[mesh->next[t]] = name;
		}
	}
	free(done), free(taken);
	return mesh->vertex_count - before;
}

static size_t find_root(size_t *parent, size_t i)
{
	while (parent[i] != i)
		i = parent[i] = parent[parent[i]];
	return i;
}

size_t polymesh_euler(long **euler, const struct polymesh *mesh)
{
	size_t *parent = mem_array(mesh->face_count, sizeof *parent), *number = mem_array(mesh->face_count, sizeof *number),
	       count = 0;
	for (size_t f = 0; f < mesh->face_count; f++)
		parent[f] = f;
	for (size_t h = 0; h < mesh->half_count; h++) {
		if (mesh->half_gone[h] || mesh->twin[h] == NO_INDEX)
			continue;
		const size_t a = find_root(parent, (size_t)mesh->face[h]),
			     b = find_root(parent, (size_t)mesh->face[mesh->twin[h]]);
		parent[a > b ? a : b] = a > b ? b : a;
	}
	for (size_t f = 0; f < mesh->face_count; f++)
		if (mesh->face_half[f] != NO_INDEX && find_root(parent, f) == f)
			number[f] = count++;
	*euler = mem_array(count, sizeof **euler);
	bool *seen = mem_array(mesh->vertex_count, sizeof *seen);
	for (size_t f = 0; f < mesh->face_count; f++)
		if (mesh->face_half[f] != NO_INDEX)
			(*euler)[number[find_root(parent, f)]]++;
	for (size_t h = 0; h < mesh->half_count; h++) {
		if (mesh->half_gone[h])
			continue;
		long *sum = *euler + number[find_root(parent, (size_t)mesh->face[h])];
		if (mesh->twin[h] == NO_INDEX || (size_t)mesh->twin[h] > h)
			--*sum;
		if (!seen[mesh->origin[h]]) {
			seen[mesh->origin[h]] = true;
			++*sum;
		}
	}
	free(parent), free(number), free(seen);
	return count;
}

static int compare_pairs(const void *a, const void *b)
{
	const idx_t *x = a, *y = b;
	if (x[0] != y[0])
		return x[0] < y[0] ? -1 : 1;
	return (x[1] > y[1]) - (x[1] < y[1]);
}

void polymesh_to_cage(struct cage *cage, const struct polymesh *mesh)
{
	*cage = (struct cage){.scheme = SCHEME_QUADTRI};
	idx_t *name = mem_array(mesh->vertex_count, sizeof *name);
	for (size_t h = 0; h < mesh->half_count; h++)
		if (!mesh->half_gone[h])
			name[mesh->origin[h]] = 1;
	for (size_t v = 0; v < mesh->vertex_count; v++)
		name[v] = name[v] ? (idx_t)cage->vertex_count++ : NO_INDEX;
	cage->xyz = mem_array(3 * cage->vertex_count, sizeof *cage->xyz);
	cage->corner = mem_array(cage->vertex_count, 1);
	for (size_t v = 0; v < mesh->vertex_count; v++)
		if (name[v] != NO_INDEX) {
			memcpy(cage->xyz + 3 * (size_t)name[v], mesh->xyz + 3 * v, 3 * sizeof *cage->xyz);
			cage->corner[name[v]] = mesh->corner[v];
		}
	cage->face_corner = mem_array(mesh->half_count, sizeof *cage->face_corner);
	cage->face_start = mem_array(mesh->face_count + 1, sizeof *cage->face_start);
	cage->face_patch = mem_array(mesh->face_count, sizeof *cage->face_patch);
	cage->sharp = mem_array(2 * mesh->half_count, sizeof *cage->sharp);
	size_t corners = 0;
	for (size_t f = 0; f < mesh->face_count; f++) {
		if (mesh->face_half[f] == NO_INDEX)
			continue;
		idx_t h = mesh->face_half[f];
		do {
			cage->face_corner[corners++] = name[mesh->origin[h]];
			if (mesh->sharp[h] && mesh->twin[h] > h) {
				const idx_t a = name[mesh->origin[h]], b = name[mesh->origin[mesh->next[h]]];
				cage->sharp[2 * cage->sharp_count] = a < b ? a : b;
				cage->sharp[2 * cage->sharp_count++ + 1] = a < b ? b : a;
			}
			h = mesh->next[h];
		} while (h != mesh->face_half[f]);
		cage->face_patch[cage->face_count] = mesh->face_patch[f];
		cage->face_start[++cage->face_count] = corners;
	}
	qsort(cage->sharp, cage->sharp_count, 2 * sizeof *cage->sharp, compare_pairs);
	free(name);
}
