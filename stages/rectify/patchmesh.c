/* One patch cut out as a mesh of its own: see patchmesh.h. */
#include "stages/rectify/patchmesh.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/vector.h"
#include "stages/rectify/minheap.h"

void patchmesh_cut_out(struct patchmesh *part, const struct half *half, const double *xyz, const idx_t *list, size_t triangle_count, idx_t *local)
{
	struct half *own = &part->half;
	const size_t n = 3 * triangle_count;
	*own = (struct half){.face_count = triangle_count, .half_count = n};
	own->origin = mem_array(n, sizeof *own->origin);
	own->next = mem_array(n, sizeof *own->next);
	own->previous = mem_array(n, sizeof *own->previous);
	own->twin = mem_array(n, sizeof *own->twin);
	own->face = mem_array(n, sizeof *own->face);
	part->vertex = mem_array(n, sizeof *part->vertex);
	for (size_t i = 0; i < triangle_count; i++)
		local[list[i]] = (idx_t)i;
	for (size_t h = 0; h < n; h++) {
		const idx_t twin = half->twin[3 * list[h / 3] + (idx_t)(h % 3)];
		const idx_t other = twin == NO_INDEX ? NO_INDEX : local[half->face[twin]];
		own->twin[h] = other == NO_INDEX ? NO_INDEX : 3 * other + twin % 3;
		own->face[h] = (idx_t)(h / 3);
		own->next[h] = (idx_t)(h % 3 == 2 ? h - 2 : h + 1);
		own->previous[h] = (idx_t)(h % 3 == 0 ? h + 2 : h - 1);
		own->origin[h] = NO_INDEX;
	}
	for (size_t i = 0; i < triangle_count; i++)
		local[list[i]] = NO_INDEX;
	/* one vertex a fan */
	for (size_t seed = 0; seed < n; seed++) {
		if (own->origin[seed] != NO_INDEX)
			continue;
		idx_t start = (idx_t)seed;
		while (own->twin[start] != NO_INDEX && own->next[own->twin[start]] != (idx_t)seed)
			start = own->next[own->twin[start]];
		const idx_t v = (idx_t)own->vertex_count++;
		part->vertex[v] = half->origin[3 * list[seed / 3] + (idx_t)(seed % 3)];
		idx_t h = start;
		do {
			own->origin[h] = v;
			h = own->twin[own->previous[h]];
		} while (h != NO_INDEX && h != start);
	}
	own->outgoing = mem_array(own->vertex_count, sizeof *own->outgoing);
	for (size_t v = 0; v < own->vertex_count; v++)
		own->outgoing[v] = NO_INDEX;
	for (size_t h = 0; h < n; h++)
		if (own->outgoing[own->origin[h]] == NO_INDEX || own->twin[own->previous[h]] == NO_INDEX)
			own->outgoing[own->origin[h]] = (idx_t)h;
	part->xyz = mem_array(own->vertex_count, 3 * sizeof *part->xyz);
	for (size_t v = 0; v < own->vertex_count; v++)
		copy3(part->xyz + 3 * v, xyz + 3 * part->vertex[v]);
}

void patchmesh_free(struct patchmesh *part)
{
	half_free(&part->half);
	free(part->vertex);
	free(part->xyz);
	*part = (struct patchmesh){0};
}

void patchmesh_distances(double *distance, const struct patchmesh *part, const idx_t *source, size_t source_count)
{
	const struct half *half = &part->half;
	struct minheap heap = {0};
	for (size_t v = 0; v < half->vertex_count; v++)
		distance[v] = INFINITY;
	for (size_t i = 0; i < source_count; i++) {
		distance[source[i]] = 0;
		minheap_push(&heap, 0, source[i]);
	}
	while (heap.count > 0) {
		const struct minheap_entry e = minheap_pop(&heap);
		if (e.key > distance[e.vertex])
			continue;
		idx_t h = half->outgoing[e.vertex];
		const idx_t start = h;
		/* all spokes: the half-edges that leave, and the last one that arrives */
		do {
			const idx_t end[2] = {half->origin[half->next[h]], half->origin[half->previous[h]]};
			for (int k = 0; k < 2; k++) {
				const double d = e.key + distance3(part->xyz + 3 * e.vertex, part->xyz + 3 * end[k]);
				if (d < distance[end[k]]) {
					distance[end[k]] = d;
					minheap_push(&heap, d, end[k]);
				}
			}
			h = half->twin[h] == NO_INDEX ? NO_INDEX : half->next[half->twin[h]];
		} while (h != NO_INDEX && h != start);
	}
	free(heap.entry);
}
