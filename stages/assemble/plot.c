/* Plots: the surface near some polygons, refined on its own. */
#include "stages/assemble/plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/cage.h"
#include "stages/geometry/primitive.h"
#include "stages/geometry/subdivide.h"
#include "stages/geometry/vector.h"

void plot_add(struct plot *plot, const idx_t *corner, const unsigned char *crease, size_t count, bool fixed)
{
	if (plot->count == plot->room) {
		plot->room += plot->room / 2 + 8;
		plot->polygon = mem_resize(plot->polygon, plot->room, sizeof *plot->polygon);
	}
	plot->polygon[plot->count++] =
		(struct polygon){mem_copy(corner, count, sizeof *corner), mem_copy(crease, count, 1), count, fixed, 0};
}

void plot_free(struct plot *plot)
{
	for (size_t i = 0; i < plot->count; i++)
		free(plot->polygon[i].corner), free(plot->polygon[i].crease);
	free(plot->polygon);
	plot->polygon = NULL, plot->count = plot->room = 0;
}

idx_t plot_new_point(struct plot *plot, const double xyz[3])
{
	struct points *points = plot->points;
	if (points->count == points->room)
		return NO_INDEX;
	copy3(points->xyz + 3 * points->count, xyz);
	points->corner[points->count] = points->open[points->count] = 0;
	points->creases[points->count] = 0;
	return (idx_t)points->count++;
}

static int compare_indices(const void *a, const void *b)
{
	const idx_t x = *(const idx_t *)a, y = *(const idx_t *)b;
	return (x > y) - (x < y);
}

static bool has_vertex(const idx_t *sorted, size_t count, idx_t vertex)
{
	return bsearch(&vertex, sorted, count, sizeof vertex, compare_indices) != NULL;
}

/* The polygons that have a vertex with any of the chosen ones, these among them, in order. */
static idx_t *touching(size_t *found, const struct plot *plot, const idx_t *chosen, size_t chosen_count)
{
	size_t corners = 0, n = 0;
	for (size_t i = 0; i < chosen_count; i++)
		corners += plot->polygon[chosen[i]].count;
	idx_t *vertex = mem_array(corners, sizeof *vertex), *result = mem_array(plot->count, sizeof *result);
	for (size_t i = 0; i < chosen_count; i++) {
		const struct polygon *p = &plot->polygon[chosen[i]];
		if (p->count == 0)
			continue;
		memcpy(vertex + n, p->corner, p->count * sizeof *vertex);
		n += p->count;
	}
	qsort(vertex, n, sizeof *vertex, compare_indices);
	*found = 0;
	for (size_t i = 0; i < plot->count; i++) {
		bool touches = false;
		for (size_t k = 0; k < plot->polygon[i].count && !touches; k++)
			touches = has_vertex(vertex, n, plot->polygon[i].corner[k]);
		if (touches)
			result[(*found)++] = (idx_t)i;
	}
	free(vertex);
	return result;
}

/* A side of a polygon. */
struct side {
	idx_t low, high, item;
};

static int compare_sides(const void *a, const void *b)
{
	const struct side *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	if (x->high != y->high)
		return x->high < y->high ? -1 : 1;
	return (x->item > y->item) - (x->item < y->item);
}

/* The chosen polygons as a cage of their own. Each fan of them around a vertex gets a vertex, which keeps the rule that it has in the whole. */
static void cut_out(struct cage *cage, const struct plot *plot, const idx_t *chosen, size_t count)
{
	size_t n = 0;
	*cage = (struct cage){.scheme = SCHEME_QUADTRI, .face_count = count, .face_start = mem_array(count + 1, sizeof *cage->face_start)};
	for (size_t i = 0; i < count; i++)
		cage->face_start[i + 1] = n += plot->polygon[chosen[i]].count;
	idx_t *origin = mem_array(n, sizeof *origin), *twin = mem_array(n, sizeof *twin), *next = mem_array(n, sizeof *next),
	      *previous = mem_array(n, sizeof *previous);
	unsigned char *crease = mem_array(n, 1);
	struct side *side = mem_array(n, sizeof *side);
	cage->face_corner = mem_array(n, sizeof *cage->face_corner);
	cage->face_patch = mem_array(count, sizeof *cage->face_patch);
	cage->xyz = mem_array(3 * n, sizeof *cage->xyz);
	cage->corner = mem_array(n, 1);
	cage->sharp = mem_array(2 * n, sizeof *cage->sharp);
	for (size_t i = 0; i < count; i++) {
		const struct polygon *p = &plot->polygon[chosen[i]];
		const size_t first = cage->face_start[i];
		for (size_t k = 0; k < p->count; k++) {
			const size_t h = first + k, to = k + 1 < p->count ? k + 1 : 0;
			const idx_t a = p->corner[k], b = p->corner[to];
			origin[h] = a, crease[h] = p->crease[k], twin[h] = NO_INDEX;
			next[h] = (idx_t)(first + to), previous[first + to] = (idx_t)h;
			side[h] = (struct side){a < b ? a : b, a < b ? b : a, (idx_t)h};
		}
	}
	qsort(side, n, sizeof *side, compare_sides);
	for (size_t i = 0; i + 1 < n; i++)
		if (side[i].low == side[i + 1].low && side[i].high == side[i + 1].high)
			twin[side[i].item] = side[i + 1].item, twin[side[i + 1].item] = side[i].item;
	for (size_t h = 0; h < n; h++)
		cage->face_corner[h] = NO_INDEX;
	for (size_t start = 0; start < n; start++) {
		if (cage->face_corner[start] != NO_INDEX)
			continue;
		const idx_t name = (idx_t)cage->vertex_count++, v = origin[start];
		copy3(cage->xyz + 3 * (size_t)name, plot->points->xyz + 3 * (size_t)v);
		cage->corner[name] = plot_is_kept(plot, v);
		for (idx_t h = (idx_t)start; h != NO_INDEX && cage->face_corner[h] == NO_INDEX; h = twin[previous[h]])
			cage->face_corner[h] = name;
		for (idx_t t = twin[start]; t != NO_INDEX && cage->face_corner[next[t]] == NO_INDEX; t = twin[next[t]])
			cage->face_corner[next[t]] = name;
	}
	for (size_t h = 0; h < n; h++)
		if (crease[h] && twin[h] > (idx_t)h) {
			cage->sharp[2 * cage->sharp_count] = cage->face_corner[h];
			cage->sharp[2 * cage->sharp_count++ + 1] = cage->face_corner[next[h]];
		}
	free(origin), free(twin), free(next), free(previous), free(crease), free(side);
}

/* How far triangle a b c is from being the right way up, whatever happens to its height within margin. */
static double turned_area(const double *xyz, const idx_t *corner, const double normal[3], double margin, int a, int b, int c)
{
	const double *p = xyz + 3 * (size_t)corner[a], *q = xyz + 3 * (size_t)corner[b], *r = xyz + 3 * (size_t)corner[c];
	double doubled[3];
	area_vector3(doubled, p, q, r);
	const double base = fmax(distance3(p, q), fmax(distance3(q, r), distance3(r, p)));
	return fmax(0, base * margin - dot3(doubled, normal)) / 2;
}

/* The same of a triangle or quad; a quad by its shorter diagonal, as triangle files cut it. */
static double face_fold(const double *xyz, const idx_t *corner, size_t count, const double normal[3], double margin)
{
	if (count == 3)
		return turned_area(xyz, corner, normal, margin, 0, 1, 2);
	const double even = distance3(xyz + 3 * (size_t)corner[0], xyz + 3 * (size_t)corner[2]), odd = distance3(xyz + 3 * (size_t)corner[1], xyz + 3 * (size_t)corner[3]);
	if (even < odd)
		return turned_area(xyz, corner, normal, margin, 0, 1, 2) + turned_area(xyz, corner, normal, margin, 0, 2, 3);
	return turned_area(xyz, corner, normal, margin, 0, 1, 3) + turned_area(xyz, corner, normal, margin, 1, 2, 3);
}

double plot_fold(double **folded, idx_t **touched, size_t *touched_count, const struct plot *plot, const idx_t *core, size_t core_count, int steps)
{
	size_t near_count, context_count;
	idx_t *near = touching(&near_count, plot, core, core_count);
	idx_t *context = touching(&context_count, plot, near, near_count);
	double *area = mem_array(near_count, sizeof *area), sum = 0;
	struct cage cage = {0};
	struct level level = {0}, fine = {0};
	struct fault fault = {0};
	cut_out(&cage, plot, context, context_count);
	const bool good = level_from_cage(&level, &cage, &fault);
	if (good) {
		level_refine(&fine, &level, SCHEME_QUADTRI, steps);
		*plot->work += fine.face_count;
		size_t *rank = mem_array(context_count, sizeof *rank); /* 1 + place in near of a face of the context, 0: not there */
		for (size_t i = 0, j = 0; i < near_count; i++) {
			while (context[j] != near[i])
				j++;
			rank[j] = i + 1;
		}
		for (size_t f = 0; f < fine.face_count; f++) {
			const size_t at = rank[fine.face_origin[f]], first = fine.face_start[f];
			if (at == 0 || plot->polygon[near[at - 1]].fixed)
				continue;
			double normal[3];
			copy3(normal, plot->normal);
			if (plot->bent)
				primitive_foot(plot->bent, fine.xyz + 3 * (size_t)fine.face_corner[first], NULL, normal);
			const double turned = face_fold(fine.xyz, fine.face_corner + first, fine.face_start[f + 1] - first, normal, ldexp(plot->margin, -steps));
			area[at - 1] += turned;
			sum += turned;
		}
		free(rank);
	}
	level_free(&fine), level_free(&level);
	cage_free(&cage);
	free(context);
	if (folded && good)
		*folded = area, *touched = near, *touched_count = near_count;
	else {
		free(area), free(near);
		if (folded)
			*folded = NULL, *touched = NULL, *touched_count = 0;
	}
	return good ? sum : INFINITY;
}

double *plot_surface(size_t *count, const struct plot *plot, const idx_t *core, size_t core_count, bool fixed, int steps)
{
	size_t near_count, context_count;
	idx_t *near = touching(&near_count, plot, core, core_count);
	bool any = false;
	*count = 0;
	for (size_t i = 0; i < near_count && !any; i++)
		any = plot->polygon[near[i]].fixed == fixed;
	if (!any) {
		free(near);
		return NULL;
	}
	idx_t *context = touching(&context_count, plot, near, near_count);
	struct cage cage;
	struct level level = {0}, fine = {0};
	struct fault fault = {0};
	double *at = NULL;
	cut_out(&cage, plot, context, context_count);
	if (level_from_cage(&level, &cage, &fault)) {
		level_refine(&fine, &level, SCHEME_QUADTRI, steps);
		*plot->work += fine.face_count;
		unsigned char *wanted = mem_array(context_count, 1);
		for (size_t i = 0, j = 0; i < near_count; i++) {
			while (context[j] != near[i])
				j++;
			wanted[j] = plot->polygon[near[i]].fixed == fixed;
		}
		at = mem_array(9 * fine.face_start[fine.face_count], sizeof *at);
		for (size_t f = 0; f < fine.face_count; f++)
			for (size_t h = fine.face_start[f] + 1; wanted[fine.face_origin[f]] && h + 1 < fine.face_start[f + 1]; h++, ++*count) {
				copy3(at + 9 * *count, fine.xyz + 3 * (size_t)fine.face_corner[fine.face_start[f]]);
				copy3(at + 9 * *count + 3, fine.xyz + 3 * (size_t)fine.face_corner[h]);
				copy3(at + 9 * *count + 6, fine.xyz + 3 * (size_t)fine.face_corner[h + 1]);
			}
		free(wanted);
	}
	level_free(&fine), level_free(&level);
	cage_free(&cage);
	free(near), free(context);
	return at;
}
