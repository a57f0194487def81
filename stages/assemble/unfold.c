/* Plane faces laid out anew: the flat pieces of a cage, and what is done in each. */
#include "stages/assemble/unfold.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/assemble/plot.h"
#include "stages/assemble/redraw.h"
#include "stages/geometry/polygon.h"
#include "stages/geometry/vector.h"

/* A side of a face. */
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

static int compare_pairs(const void *a, const void *b)
{
	const idx_t *x = a, *y = b;
	if (x[0] != y[0])
		return x[0] < y[0] ? -1 : 1;
	return (x[1] > y[1]) - (x[1] < y[1]);
}

static int compare_indices(const void *a, const void *b)
{
	const idx_t x = *(const idx_t *)a, y = *(const idx_t *)b;
	return (x > y) - (x < y);
}

/* What there is to know of a cage: half h = entry h of face_corner, the edge from it to the next. */
struct map {
	idx_t *face, *next, *twin;    /* a half; twin NO_INDEX at a border */
	unsigned char *crease;        /* a half */
	idx_t *creases;               /* a vertex */
	size_t *around_start;         /* a vertex: its faces are around[around_start[v]] .. */
	idx_t *around;
};

static void map_make(struct map *map, const struct cage *cage)
{
	const size_t n = cage->face_start[cage->face_count];
	*map = (struct map){mem_array(n, sizeof(idx_t)), mem_array(n, sizeof(idx_t)), mem_array(n, sizeof(idx_t)), mem_array(n, 1),
			    mem_array(cage->vertex_count, sizeof(idx_t)), mem_array(cage->vertex_count + 2, sizeof(size_t)), mem_array(n, sizeof(idx_t))};
	struct side *side = mem_array(n, sizeof *side);
	for (size_t f = 0; f < cage->face_count; f++)
		for (size_t h = cage->face_start[f]; h < cage->face_start[f + 1]; h++) {
			map->face[h] = (idx_t)f, map->twin[h] = NO_INDEX;
			map->next[h] = (idx_t)(h + 1 < cage->face_start[f + 1] ? h + 1 : cage->face_start[f]);
			const idx_t a = cage->face_corner[h], b = cage->face_corner[map->next[h]];
			side[h] = (struct side){a < b ? a : b, a < b ? b : a, (idx_t)h};
			map->around_start[a + 2]++;
		}
	for (size_t v = 0; v < cage->vertex_count; v++)
		map->around_start[v + 2] += map->around_start[v + 1];
	for (size_t h = 0; h < n; h++)
		map->around[map->around_start[cage->face_corner[h] + 1]++] = map->face[h];
	qsort(side, n, sizeof *side, compare_sides);
	for (size_t i = 0; i < n; i++) {
		const bool paired = i + 1 < n && side[i].low == side[i + 1].low && side[i].high == side[i + 1].high;
		const idx_t pair[2] = {side[i].low, side[i].high};
		const bool crease = !paired || bsearch(pair, cage->sharp, cage->sharp_count, sizeof pair, compare_pairs) != NULL;
		map->crease[side[i].item] = crease;
		map->creases[pair[0]] += crease, map->creases[pair[1]] += crease;
		if (!paired)
			continue;
		map->crease[side[i + 1].item] = crease;
		map->twin[side[i].item] = side[i + 1].item, map->twin[side[i + 1].item] = side[i].item;
		i++;
	}
	free(side);
}

static void map_free(struct map *map)
{
	free(map->face), free(map->next), free(map->twin), free(map->crease), free(map->creases), free(map->around_start), free(map->around);
}

/* Faces of a patch that is known to be a plane may be this many times as far from it: they were fitted to what is nearly one. */
#define KNOWN_PLANE_SLACK 25

/* Smooth faces beside a plane, and bent surfaces themselves, may move by so many times planar. */
#define MOST_SHIFT 5
/* What becomes of the cage, in a grid or a fit, may move its points against each other by such a share of planar. */
#define ROUNDING 0.5
/* New points, against those of the cage. */
enum { MOST_NEW_DIVISOR = 8, MOST_NEW_AT_LEAST = 32 };

struct sized_face {
	double area;
	idx_t face;
};

static int largest_first(const void *a, const void *b)
{
	const struct sized_face *x = a, *y = b;
	return x->area != y->area ? (x->area > y->area ? -1 : 1) : (x->face > y->face) - (x->face < y->face);
}

static bool is_bent(const struct dense_patch *patch, idx_t number)
{
	return patch && patch[number].kind != PATCH_PLANE;
}

static bool is_in_plane(const struct cage *cage, size_t face, const double centre[3], const double normal[3], double planar)
{
	for (size_t k = cage->face_start[face]; k < cage->face_start[face + 1]; k++) {
		double d[3];
		sub3(d, cage->xyz + 3 * (size_t)cage->face_corner[k], centre);
		if (fabs(dot3(d, normal)) > planar)
			return false;
	}
	return true;
}

/* Piece of each face, NO_INDEX for none: the parts of patches that are known surfaces but planes, and flat ones, which may be of several patches.
 * They grow from the largest faces, which tell their plane best. Returns how many there are. */
static size_t find_pieces(idx_t *piece, const struct cage *cage, const struct map *map, const struct dense_patch *patch, double planar)
{
	struct sized_face *order = mem_array(cage->face_count, sizeof *order);
	idx_t *stack = mem_array(cage->face_count, sizeof *stack);
	size_t pieces = 0;
	if (patch)
		planar *= KNOWN_PLANE_SLACK;
	for (size_t f = 0; f < cage->face_count; f++) {
		double centre[3], normal[3];
		const size_t first = cage->face_start[f];
		order[f] = (struct sized_face){polygon_plane(centre, normal, cage->xyz, cage->face_corner + first, cage->face_start[f + 1] - first), (idx_t)f};
		piece[f] = NO_INDEX;
	}
	qsort(order, cage->face_count, sizeof *order, largest_first);
	for (size_t i = 0; i < cage->face_count && order[i].area > 0; i++) {
		const size_t seed = (size_t)order[i].face, first = cage->face_start[seed], count = cage->face_start[seed + 1] - first;
		const idx_t of = cage->face_patch[seed];
		const bool bent = is_bent(patch, of);
		if (piece[seed] != NO_INDEX || (bent && patch[of].kind == PATCH_FREE) || (!bent && polygon_flatness(cage->xyz, cage->face_corner + first, count) > planar))
			continue;
		double centre[3], normal[3];
		polygon_plane(centre, normal, cage->xyz, cage->face_corner + first, count);
		size_t waiting = 0;
		piece[seed] = (idx_t)pieces;
		stack[waiting++] = (idx_t)seed;
		while (waiting > 0) {
			const size_t f = (size_t)stack[--waiting];
			for (size_t h = cage->face_start[f]; h < cage->face_start[f + 1]; h++) {
				if (map->twin[h] == NO_INDEX)
					continue;
				const size_t g = (size_t)map->face[map->twin[h]];
				const idx_t other = cage->face_patch[g];
				if (piece[g] != NO_INDEX || ((map->crease[h] || bent || is_bent(patch, other)) && cage->face_patch[f] != other))
					continue;
				if (bent || is_in_plane(cage, g, centre, normal, planar))
					piece[g] = (idx_t)pieces, stack[waiting++] = (idx_t)g;
			}
		}
		pieces++;
	}
	free(order), free(stack);
	return pieces;
}

/* The plot of some faces (rising). Where it is joined to others without a crease, all that touch it are there too: with half a fan around a
 * vertex its rule would be another. */
static void make_plot(struct plot *plot, const struct cage *cage, const struct map *map, const idx_t *piece, const idx_t *face, size_t count)
{
	const idx_t number = piece[face[0]];
	bool is_joined = false;
	size_t around = 0;
	plot->normal[0] = plot->normal[1] = plot->normal[2] = 0;
	for (size_t i = 0; i < count; i++) {
		const size_t first = cage->face_start[face[i]], n = cage->face_start[face[i] + 1] - first;
		plot_add(plot, cage->face_corner + first, map->crease + first, n, false);
		double centre[3], normal[3];
		const double area = polygon_plane(centre, normal, cage->xyz, cage->face_corner + first, n);
		add_scaled3(plot->normal, area, normal);
		for (size_t h = first; h < first + n; h++) {
			around += map->around_start[cage->face_corner[h] + 1] - map->around_start[cage->face_corner[h]];
			if (map->crease[h] || piece[map->face[map->twin[h]]] == number)
				continue;
			is_joined = true;
			plot->points->open[cage->face_corner[h]] = plot->points->open[cage->face_corner[map->next[h]]] = 1;
		}
	}
	normalise3(plot->normal);
	if (!is_joined)
		return;
	idx_t *fixed = mem_array(around, sizeof *fixed);
	size_t fixed_count = 0;
	for (size_t i = 0; i < count; i++)
		for (size_t h = cage->face_start[face[i]]; h < cage->face_start[face[i] + 1]; h++) {
			const size_t v = (size_t)cage->face_corner[h];
			for (size_t a = map->around_start[v]; a < map->around_start[v + 1]; a++)
				if (piece[map->around[a]] != number)
					fixed[fixed_count++] = map->around[a];
		}
	qsort(fixed, fixed_count, sizeof *fixed, compare_indices);
	for (size_t i = 0; i < fixed_count; i++) {
		const size_t first = cage->face_start[fixed[i]];
		if (i == 0 || fixed[i] != fixed[i - 1])
			plot_add(plot, cage->face_corner + first, map->crease + first, cage->face_start[fixed[i] + 1] - first, true);
	}
	free(fixed);
}

/* A face of the new cage. */
struct drawn {
	struct polygon polygon;
	idx_t patch;
};

/* The cage of the faces in their order; edges with two sides that are creases are listed. */
static void draw_cage(struct cage *cage, const struct drawn *drawn, size_t count)
{
	size_t corners = 0, faces = 0, sides = 0;
	for (size_t i = 0; i < count; i++)
		corners += drawn[i].polygon.count;
	free(cage->face_corner), free(cage->face_start), free(cage->face_patch), free(cage->sharp);
	cage->face_corner = mem_array(corners, sizeof *cage->face_corner);
	cage->face_start = mem_array(count + 1, sizeof *cage->face_start);
	cage->face_patch = mem_array(count, sizeof *cage->face_patch);
	idx_t *side = mem_array(2 * corners, sizeof *side);
	corners = 0;
	for (size_t i = 0; i < count; i++) {
		const struct polygon *p = &drawn[i].polygon;
		if (p->count == 0)
			continue;
		for (size_t k = 0; k < p->count; k++) {
			const idx_t a = p->corner[k], b = p->corner[k + 1 < p->count ? k + 1 : 0];
			cage->face_corner[corners++] = a;
			if (p->crease[k])
				side[2 * sides] = a < b ? a : b, side[2 * sides++ + 1] = a < b ? b : a;
		}
		cage->face_patch[faces] = drawn[i].patch;
		cage->face_start[++faces] = corners;
	}
	cage->face_count = faces;
	qsort(side, sides, 2 * sizeof *side, compare_pairs);
	cage->sharp_count = 0;
	for (size_t i = 1; i < sides; i++)
		if (side[2 * i] == side[2 * i - 2] && side[2 * i + 1] == side[2 * i - 1])
			memcpy(side + 2 * cage->sharp_count++, side + 2 * i, 2 * sizeof *side);
	cage->sharp = side;
}

void unfold(struct unfold_report *report, struct cage *cage, const struct dense_patch *patch, double planar, int steps)
{
	*report = (struct unfold_report){0};
	if (cage->face_count == 0)
		return;
	struct map map;
	map_make(&map, cage);
	idx_t *piece = mem_array(cage->face_count, sizeof *piece), *list = mem_array(cage->face_count, sizeof *list);
	const size_t pieces = find_pieces(piece, cage, &map, patch, planar);
	size_t *start = mem_array(pieces + 2, sizeof *start), work = 0;
	for (size_t f = 0; f < cage->face_count; f++)
		if (piece[f] != NO_INDEX)
			start[piece[f] + 2]++;
	for (size_t p = 0; p < pieces; p++)
		start[p + 2] += start[p + 1];
	for (size_t f = 0; f < cage->face_count; f++)
		if (piece[f] != NO_INDEX)
			list[start[piece[f] + 1]++] = (idx_t)f;
	struct drawn *drawn = mem_array(cage->face_count, sizeof *drawn);
	size_t drawn_count = cage->face_count, drawn_room = cage->face_count;
	for (size_t f = 0; f < cage->face_count; f++)
		drawn[f].patch = cage->face_patch[f];
	const size_t room = cage->vertex_count + cage->vertex_count / MOST_NEW_DIVISOR + MOST_NEW_AT_LEAST;
	struct points points = {mem_array(3 * room, sizeof(double)), mem_array(room, 1), mem_array(room, sizeof(idx_t)), mem_array(room, 1), cage->vertex_count, room};
	memcpy(points.xyz, cage->xyz, 3 * cage->vertex_count * sizeof(double));
	memcpy(points.corner, cage->corner, cage->vertex_count);
	memcpy(points.creases, map.creases, cage->vertex_count * sizeof(idx_t));
	struct edge_list edges;
	edge_list_make(&edges, cage);
	for (size_t p = 0; p < pieces; p++) {
		const size_t own = start[p + 1] - start[p];
		struct plot plot = {.points = &points, .margin = ROUNDING * planar, .work = &work};
		const idx_t of = cage->face_patch[list[start[p]]];
		plot.bent = is_bent(patch, of) ? &patch[of] : NULL;
		make_plot(&plot, cage, &map, piece, list + start[p], own);
		if (redraw(report, &plot, &edges, MOST_SHIFT * planar, steps)) {
			for (size_t i = 0; i < own; i++) {
				drawn[list[start[p] + i]].polygon = plot.polygon[i];
				if (plot.polygon[i].count == 0)
					drawn[list[start[p] + i]].patch = NO_INDEX; /* gone, not untouched */
				plot.polygon[i] = (struct polygon){0};
			}
			for (size_t i = own; i < plot.count; i++) {
				if (plot.polygon[i].fixed || plot.polygon[i].count == 0)
					continue;
				if (drawn_count == drawn_room)
					drawn = mem_resize(drawn, drawn_room += drawn_room / 2 + 16, sizeof *drawn);
				drawn[drawn_count++] = (struct drawn){plot.polygon[i], cage->face_patch[list[start[p]]]};
				plot.polygon[i] = (struct polygon){0};
			}
		}
		plot_free(&plot);
		memset(points.open, 0, room);
	}
	for (size_t f = 0; f < cage->face_count; f++) {
		const size_t first = cage->face_start[f], n = cage->face_start[f + 1] - first;
		if (drawn[f].polygon.count == 0 && drawn[f].patch != NO_INDEX)
			drawn[f].polygon = (struct polygon){mem_copy(cage->face_corner + first, n, sizeof(idx_t)), mem_copy(map.crease + first, n, 1), n, false, 0};
	}
	draw_cage(cage, drawn, drawn_count);
	free(cage->xyz), free(cage->corner);
	cage->xyz = points.xyz, cage->corner = points.corner;
	report->added = points.count - cage->vertex_count;
	cage->vertex_count = points.count;
	for (size_t i = 0; i < drawn_count; i++)
		free(drawn[i].polygon.corner), free(drawn[i].polygon.crease);
	free(points.creases), free(points.open);
	free(drawn), free(piece), free(list), free(start);
	edge_list_free(&edges);
	map_free(&map);
}
