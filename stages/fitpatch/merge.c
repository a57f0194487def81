/* Merging triangles into quads and plane polygons (Hertel and Mehlhorn 1983, with the centroid star test in place of
 * convexity: the patch method's section 5.2, steps 6 and 7). */
#include "stages/fitpatch/merge.h"

#include <math.h>
#include <stdlib.h>

#include "stages/fitpatch/frame.h"
#include "stages/geometry/polygon.h"
#include "stages/geometry/vector.h"

/* Margins of the star test: plane polygons only have to stay unfolded, quads on bent surfaces should look like quads. */
static const double plane_margin = 0.02, bent_margin = 0.15;
enum { MOST_CORNERS = 32 };

/* Polygons as rings of half-edges of the sheet: next and previous over the remaining edges. */
struct rings {
	idx_t *next, *previous; /* a half-edge */
	idx_t *root;            /* a triangle: union-find over merged triangles */
};

static idx_t root_of(const struct rings *rings, idx_t t)
{
	while (rings->root[t] != t)
		t = rings->root[t] = rings->root[rings->root[t]];
	return t;
}

struct candidate {
	double cost;
	idx_t half;
};

static int worst_first(const void *a, const void *b)
{
	const struct candidate *x = a, *y = b;
	return x->cost != y->cost ? (x->cost > y->cost ? -1 : 1) : (x->half > y->half) - (x->half < y->half);
}

/* The corners of the union over the edge of h; 0 when too large, or when the two polygons share more than this edge. */
static size_t union_corners(idx_t *corner, const struct rings *rings, const struct sheet *sheet, idx_t h)
{
	const idx_t g = sheet->twin[h];
	size_t count = 0;
	for (int side = 0; side < 2; side++) {
		const idx_t from = side ? g : h, other = side ? h : g;
		for (idx_t k = rings->next[from]; k != from; k = rings->next[k]) {
			if (count == MOST_CORNERS)
				return 0;
			if (sheet->twin[k] != NO_INDEX && root_of(rings, sheet->twin[k] / 3) == root_of(rings, other / 3))
				return 0;
			corner[count++] = sheet->point[sheet->origin[k]];
		}
	}
	return count;
}

/* Points on curves are harmless: the curve is smooth there. */
static bool has_reflex_node(const struct layout_context *context, const struct merge_options *options, const idx_t *corner, size_t count, const double normal[3])
{
	for (size_t i = 0; i < count; i++) {
		const unsigned char role = context->control->role[corner[i]];
		if ((options->is_careful || (role != POINT_CREASE && role != POINT_INSIDE)) && polygon_turn_deg(context->control->xyz, corner, count, i, normal) < -POLYGON_REFLEX_DEG)
			return true;
	}
	return false;
}

static bool is_good(const struct layout_context *context, const struct merge_options *options, const idx_t *corner, size_t count, const double hint[3])
{
	for (size_t i = 0; i < count; i++)
		for (size_t j = i + 1; j < count; j++)
			if (corner[i] == corner[j])
				return false;
	double centre[3], normal[3];
	const double *xyz = context->control->xyz;
	polygon_plane(centre, normal, xyz, corner, count);
	if (dot3(normal, hint) < 0.3)
		return false;
	const bool flat = polygon_flatness(xyz, corner, count) <= options->flat;
	if (!flat && (count > 4 || options->is_careful))
		return false;
	return !has_reflex_node(context, options, corner, count, normal) && polygon_star(xyz, corner, count, normal) > (options->is_plane ? plane_margin : bent_margin);
}

/* The largest height of the target over the polygon's middle: a plane polygon under a dome must stay cut. */
static bool covers_target(const struct layout_context *context, const struct merge_options *options, idx_t patch, const idx_t *corner, size_t count)
{
	if (options->is_plane || count <= 4)
		return true;
	double centre[3], normal[3];
	polygon_plane(centre, normal, context->control->xyz, corner, count);
	for (size_t i = 0; i <= count; i++) {
		double p[3];
		for (int k = 0; k < 3; k++)
			p[k] = i == count ? centre[k] : (centre[k] + context->control->xyz[3 * (size_t)corner[i] + (size_t)k]) / 2;
		const struct foot foot = frame_foot(context->nearest, context->dense, patch, p);
		if (foot.distance > options->flat || dot3(foot.normal, normal) < 0.98)
			return false;
	}
	return true;
}

static void surface_normal(double normal[3], const struct sheet *sheet, idx_t triangle)
{
	area_vector3(normal, &sheet->xyz[3 * (size_t)sheet->origin[3 * triangle]], &sheet->xyz[3 * (size_t)sheet->origin[3 * triangle + 1]],
	             &sheet->xyz[3 * (size_t)sheet->origin[3 * triangle + 2]]);
}

void merge_triangles(struct layout_context *context, struct chord_context *chords, const struct merge_options *options, idx_t patch)
{
	const struct sheet *sheet = chords->sheet;
	const size_t halves = 3 * sheet->triangle_count;
	struct rings rings = {mem_array(halves, sizeof(idx_t)), mem_array(halves, sizeof(idx_t)), mem_array(sheet->triangle_count, sizeof(idx_t))};
	struct candidate *candidate = mem_array(halves, sizeof *candidate);
	size_t candidates = 0;
	for (size_t t = 0; t < sheet->triangle_count; t++)
		rings.root[t] = (idx_t)t;
	for (size_t h = 0; h < halves; h++) {
		rings.next[h] = sheet_next((idx_t)h), rings.previous[h] = sheet_previous((idx_t)h);
		const idx_t g = sheet->twin[h];
		if (sheet->origin[h] == NO_INDEX || g == NO_INDEX || g < (idx_t)h)
			continue;
		double cost = chord_cost(chords, sheet->origin[h], sheet->origin[g]);
		if (isinf(cost))
			cost = 1e6; /* doubles an edge of another patch: the first to go */
		candidate[candidates++] = (struct candidate){cost, (idx_t)h};
	}
	qsort(candidate, candidates, sizeof *candidate, worst_first);
	idx_t *valence = mem_array(sheet->vertex_count, sizeof *valence);
	for (size_t i = 0; i < halves; i++)
		if (sheet->origin[i] != NO_INDEX)
			valence[sheet->origin[i]]++; /* edges of inner vertices */
	idx_t corner[MOST_CORNERS];
	for (size_t i = 0; i < candidates; i++) {
		const idx_t h = candidate[i].half, g = sheet->twin[h];
		const idx_t one = root_of(&rings, h / 3), two = root_of(&rings, g / 3);
		const idx_t from = sheet->origin[h], to = sheet->origin[g];
		/* A point inside with two edges would be none. */
		if (one == two || (valence[from] <= 3 && !sheet_on_border(sheet, from)) || (valence[to] <= 3 && !sheet_on_border(sheet, to)))
			continue;
		const size_t count = union_corners(corner, &rings, sheet, h);
		double hint[3], other[3];
		surface_normal(hint, sheet, h / 3);
		surface_normal(other, sheet, g / 3);
		normalise3(hint), normalise3(other);
		if (!options->is_plane && dot3(hint, other) < 0.5)
			continue; /* a quad over a fold of more than 60 degrees bends too much for one face */
		add_scaled3(hint, 1, other);
		normalise3(hint);
		if (count == 0 || !is_good(context, options, corner, count, hint) || !covers_target(context, options, patch, corner, count))
			continue;
		valence[from]--, valence[to]--;
		/* Take h and g out of their rings. */
		rings.next[rings.previous[h]] = rings.next[g], rings.previous[rings.next[g]] = rings.previous[h];
		rings.next[rings.previous[g]] = rings.next[h], rings.previous[rings.next[h]] = rings.previous[g];
		rings.next[h] = rings.next[g] = NO_INDEX;
		rings.root[one > two ? one : two] = one > two ? two : one;
	}
	unsigned char *done = mem_array(halves, 1);
	for (size_t h = 0; h < halves; h++) {
		if (sheet->origin[h] == NO_INDEX || rings.next[h] == NO_INDEX || done[h])
			continue;
		size_t count = 0;
		for (idx_t k = (idx_t)h; !done[k]; k = rings.next[k]) {
			done[k] = 1;
			corner[count++] = sheet->point[sheet->origin[k]];
			edge_set_add(context->taken, sheet->point[sheet->origin[k]], sheet->point[sheet_target(sheet, k)]);
		}
		polygons_add(context->polygons, corner, count, patch);
	}
	free(rings.next), free(rings.previous), free(rings.root), free(candidate), free(done), free(valence);
}
