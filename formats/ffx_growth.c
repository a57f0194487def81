/* The half-built surface of the forward coder: its room, its boundary, and what becomes of it (see ffx_forward.h). */
#include <stdlib.h>
#include <string.h>

#include "formats/ffx_forward.h"

void forward_free(struct forward *f)
{
	free(f->next);
	free(f->previous);
	free(f->origin);
	free(f->face);
	free(f->after);
	free(f->before);
	free(f->place);
	free(f->is_dead);
	free(f->source);
	free(f->grid);
	free(f->used);
	free(f->valence);
	free(f->mark);
	free(f->first);
	free(f->degree);
	free(f->normal);
	free(f->bound);
	free(f->path);
	free(f->corner);
	free(f->behind);
	free(f->is_known);
	free(f->far);
	free(f->root);
	free(f->built);
	free(f->number);
	geometry_free(&f->geometry);
	*f = (struct forward){0};
}

static size_t grown(size_t room)
{
	return room < 128 ? 256 : 2 * room;
}

static void *grow(void *old, size_t count, size_t size)
{
	return mem_resize(old, count, size);
}

void forward_reserve(struct forward *f)
{
	if (f->half_count + 2 > f->half_room) {
		const size_t n = f->half_room = grown(f->half_room);
		f->next = grow(f->next, n, sizeof(idx_t));
		f->previous = grow(f->previous, n, sizeof(idx_t));
		f->origin = grow(f->origin, n, sizeof(idx_t));
		f->face = grow(f->face, n, sizeof(idx_t));
		f->after = grow(f->after, n, sizeof(idx_t));
		f->before = grow(f->before, n, sizeof(idx_t));
		f->place = grow(f->place, n, sizeof(idx_t));
		f->is_dead = grow(f->is_dead, n, 1);
		f->source = grow(f->source, n, sizeof(idx_t));
		f->bound = grow(f->bound, n, sizeof(idx_t));
	}
	if (f->vertex_count + 2 > f->vertex_room) {
		const size_t n = f->vertex_room = grown(f->vertex_room);
		f->grid = grow(f->grid, 3 * n, sizeof(int32_t));
		f->used = grow(f->used, n, sizeof(int32_t));
		f->valence = grow(f->valence, n, 1);
		f->mark = grow(f->mark, n, sizeof(idx_t));
	}
	if (f->face_count + 1 > f->face_room) {
		const size_t n = f->face_room = grown(f->face_room);
		f->first = grow(f->first, n, sizeof(idx_t));
		f->degree = grow(f->degree, n, sizeof(idx_t));
		f->normal = grow(f->normal, 3 * n, sizeof(int64_t));
	}
	if (f->path_count + f->behind_count + 2 > f->path_room) {
		f->path_room = grown(f->path_room);
		f->path = grow(f->path, f->path_room, sizeof(idx_t));
		f->corner = grow(f->corner, f->path_room, sizeof(idx_t));
		f->behind = grow(f->behind, f->path_room, sizeof(idx_t));
		f->is_known = grow(f->is_known, f->path_room, 1);
	}
	if (f->component_count + 1 > f->root_room) {
		f->root_room = grown(f->root_room);
		f->root = grow(f->root, f->root_room, sizeof(idx_t));
	}
}

void forward_join(struct forward *f, idx_t a, idx_t b)
{
	f->after[a] = b;
	f->before[b] = a;
}

void forward_bound_add(struct forward *f, idx_t half)
{
	f->place[half] = (idx_t)f->bound_count;
	f->bound[f->bound_count++] = half;
	f->alive_count++;
}

void forward_bound_remove(struct forward *f, idx_t half)
{
	const idx_t last = f->bound[--f->bound_count];
	f->bound[f->place[half]] = last;
	f->place[last] = f->place[half];
	f->alive_count--;
}

idx_t forward_pair(struct forward *f, idx_t a, idx_t b, idx_t source)
{
	const idx_t h = (idx_t)f->half_count;
	f->half_count += 2;
	for (int i = 0; i < 2; i++) {
		f->origin[h + i] = i ? b : a;
		f->face[h + i] = NO_INDEX;
		f->is_dead[h + i] = 0;
		if (f->surface) {
			const idx_t s = i ? f->surface->twin[source] : source;
			f->source[h + i] = s;
			f->built[s] = h + i;
		}
	}
	return h;
}

idx_t forward_vertex(struct forward *f, idx_t source)
{
	const idx_t v = (idx_t)f->vertex_count++;
	f->used[v] = 0;
	f->valence[v] = 0;
	f->mark[v] = 0;
	int32_t *at = f->grid + 3 * (size_t)v;
	memset(at, 0, 3 * sizeof *at);
	if (f->surface) {
		f->number[source] = v;
		memcpy(at, f->surface_grid + 3 * (size_t)source, 3 * sizeof *at);
	}
	return v;
}

void forward_surface(struct ffx_surface *surface, const struct forward *f)
{
	const size_t halves = f->half_count;
	*surface = (struct ffx_surface){.half_count = halves,
					.vertex_count = f->vertex_count,
					.face_count = f->face_count,
					.component_count = f->component_count};
	surface->next = mem_copy(f->next, halves, sizeof(idx_t));
	surface->previous = mem_copy(f->previous, halves, sizeof(idx_t));
	surface->origin = mem_copy(f->origin, halves, sizeof(idx_t));
	surface->face = mem_copy(f->face, halves, sizeof(idx_t));
	surface->twin = mem_array(halves, sizeof(idx_t));
	surface->outgoing = mem_array(f->vertex_count, sizeof(idx_t));
	surface->root = mem_copy(f->root, f->component_count, sizeof(idx_t));
	size_t faces = f->face_count;
	for (size_t h = 0; h < halves; h++) {
		surface->twin[h] = (idx_t)(h ^ 1);
		surface->outgoing[f->origin[h]] = (idx_t)h;
		faces += f->face[h] == NO_INDEX;
	}
	surface->first = mem_array(faces, sizeof(idx_t));
	surface->degree = mem_array(faces, sizeof(idx_t));
	surface->hole = mem_array(faces, 1);
	memcpy(surface->first, f->first, f->face_count * sizeof(idx_t));
	memcpy(surface->degree, f->degree, f->face_count * sizeof(idx_t));
	for (size_t h = 0; h < halves; h++) {
		if (surface->face[h] != NO_INDEX)
			continue;
		const size_t hole = surface->face_count++;
		surface->hole_count++;
		surface->hole[hole] = 1;
		surface->first[hole] = (idx_t)h;
		idx_t e = (idx_t)h;
		do {
			surface->face[e] = (idx_t)hole;
			surface->degree[hole]++;
			surface->next[e] = f->after[e];
			surface->previous[f->after[e]] = e;
			e = f->after[e];
		} while (e != (idx_t)h);
	}
}
