/* Control polygons of a patch.
 *
 * The method that this pipeline rebuilds cuts the patch's border polygon by its most coherent chord, and again, until all
 * parts are done; several loops need keyholes first, and every cut needs a path that stays inside the part. We go the other way:
 * the dense triangles are thinned out until only the control points of the border are left, which is a full set of chords that cannot
 * cross, whatever the number of loops (chords between loops are the keyhole's bridges) or the genus; edges are swapped to the most coherent
 * ones; then the least coherent ones are taken out while the union stays fit to be a face. Same score, same faces, no path surgery. */
#include "stages/fitpatch/layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/fitpatch/loops.h"
#include "stages/fitpatch/merge.h"
#include "stages/geometry/vector.h"

idx_t control_add(struct control *control, const double xyz[3], unsigned char role)
{
	if (control->count == control->capacity) {
		control->capacity += control->capacity / 2 + 64;
		control->xyz = mem_resize(control->xyz, 3 * control->capacity, sizeof *control->xyz);
		control->role = mem_resize(control->role, control->capacity, 1);
		control->held = mem_resize(control->held, control->capacity, 1);
	}
	control->role[control->count] = role;
	control->held[control->count] = 0;
	copy3(&control->xyz[3 * control->count], xyz);
	return (idx_t)control->count++;
}

void control_free(struct control *control)
{
	free(control->xyz), free(control->role), free(control->held);
	*control = (struct control){0};
}

void polygons_init(struct polygons *polygons)
{
	*polygons = (struct polygons){.start = mem_array(1, sizeof *polygons->start)};
}

void polygons_add(struct polygons *polygons, const idx_t *corner, size_t count, idx_t patch)
{
	const size_t used = polygons->start[polygons->count];
	if (polygons->count == polygons->capacity) {
		polygons->capacity += polygons->capacity / 2 + 64;
		polygons->start = mem_resize(polygons->start, polygons->capacity + 1, sizeof *polygons->start);
		polygons->patch = mem_resize(polygons->patch, polygons->capacity, sizeof *polygons->patch);
	}
	if (used + count > polygons->corner_capacity) {
		polygons->corner_capacity = (used + count) * 3 / 2 + 64;
		polygons->corner = mem_resize(polygons->corner, polygons->corner_capacity, sizeof *polygons->corner);
	}
	memcpy(&polygons->corner[used], corner, count * sizeof *corner);
	polygons->patch[polygons->count] = patch;
	polygons->start[++polygons->count] = used + count;
}

void polygons_by_patch(struct polygons *polygons, size_t patch_count)
{
	size_t *start = mem_array(patch_count + 1, sizeof *start);
	idx_t *order = mem_array(polygons->count, sizeof *order);
	for (size_t f = 0; f < polygons->count; f++)
		start[polygons->patch[f] + 1]++;
	for (size_t p = 0; p < patch_count; p++)
		start[p + 1] += start[p];
	for (size_t f = 0; f < polygons->count; f++)
		order[start[polygons->patch[f]]++] = (idx_t)f;
	struct polygons sorted;
	polygons_init(&sorted);
	for (size_t i = 0; i < polygons->count; i++) {
		const size_t f = (size_t)order[i];
		polygons_add(&sorted, &polygons->corner[polygons->start[f]], polygons->start[f + 1] - polygons->start[f], polygons->patch[f]);
	}
	polygons_free(polygons);
	*polygons = sorted;
	free(start), free(order);
}

void polygons_free(struct polygons *polygons)
{
	free(polygons->corner), free(polygons->start), free(polygons->patch);
	*polygons = (struct polygons){0};
}

/* Points inside a patch stay this far from its border, as a share of the border's side. */
static const double border_clearance = 0.35;

/* Costs while thinning: short edges, no triangle that turns away from the surface as it was. */
struct thinning {
	const struct sheet *sheet;
	const struct edge_set *taken;
	const double *normal; /* 3 a vertex of the sheet, unit */
	double size;
};

static double thin_edge(void *opaque, idx_t a, idx_t b)
{
	const struct thinning *thinning = opaque;
	const idx_t p = thinning->sheet->point[a], q = thinning->sheet->point[b];
	if (p != NO_INDEX && q != NO_INDEX && (p == q || edge_set_has(thinning->taken, p, q)))
		return INFINITY;
	return distance3(&thinning->sheet->xyz[3 * (size_t)a], &thinning->sheet->xyz[3 * (size_t)b]) / thinning->size;
}

static double thin_triangle(void *opaque, idx_t a, idx_t b, idx_t c)
{
	const struct thinning *thinning = opaque;
	const double *xyz = thinning->sheet->xyz;
	double normal[3], mean[3] = {0, 0, 0};
	area_vector3(normal, &xyz[3 * (size_t)a], &xyz[3 * (size_t)b], &xyz[3 * (size_t)c]);
	normalise3(normal);
	add_scaled3(mean, 1, &thinning->normal[3 * (size_t)a]);
	add_scaled3(mean, 1, &thinning->normal[3 * (size_t)b]);
	add_scaled3(mean, 1, &thinning->normal[3 * (size_t)c]);
	normalise3(mean);
	const double turn = dot3(normal, mean);
	return turn < 0.3 ? 100 * (0.3 - turn) : 0;
}

static double *vertex_normals(const struct sheet *sheet)
{
	double *normal = mem_array(3 * sheet->vertex_count, sizeof *normal);
	for (size_t t = 0; t < sheet->triangle_count; t++) {
		double area[3];
		const idx_t *v = &sheet->origin[3 * t];
		area_vector3(area, &sheet->xyz[3 * (size_t)v[0]], &sheet->xyz[3 * (size_t)v[1]], &sheet->xyz[3 * (size_t)v[2]]);
		for (int k = 0; k < 3; k++)
			add_scaled3(&normal[3 * (size_t)v[k]], 1, area);
	}
	for (size_t v = 0; v < sheet->vertex_count; v++)
		normalise3(&normal[3 * v]);
	return normal;
}

/* Take out every vertex that is no control point, few neighbours first and never two neighbours in one pass, so that rings
 * stay small and round (Schroeder, Zarge and Lorensen 1992). Vertices that cannot go stay, and so do those inside the patch that
 * would leave the surface by more than limit, unless they are crowded: drift (a vertex) holds how far the triangles around may be off already. Returns how many stay. */
static size_t thin_out(struct sheet *sheet, const struct sheet_cost *cost, const unsigned char *crowded, double *drift, double limit)
{
	unsigned char *rested = mem_array(sheet->vertex_count, 1);
	idx_t *waiting = mem_array(sheet->vertex_count, sizeof *waiting);
	size_t count = 0;
	for (size_t v = 0; v < sheet->vertex_count; v++)
		if (sheet->outgoing[v] != NO_INDEX && sheet->point[v] == NO_INDEX)
			waiting[count++] = (idx_t)v;
	static const size_t ring_limit[] = {7, 9, 12, 18, 30, SHEET_RING_LIMIT};
	enum { LIMITS = sizeof ring_limit / sizeof *ring_limit };
	size_t step = 0;
	for (int pass = 0; count > 0 && pass < 200; pass++) {
		memset(rested, 0, sheet->vertex_count);
		size_t left = 0;
		const size_t before = count;
		for (size_t i = 0; i < count; i++) {
			const idx_t v = waiting[i];
			idx_t ring[SHEET_RING_LIMIT];
			const size_t degree = sheet_ring(sheet, v, ring, SHEET_RING_LIMIT);
			bool gone = false;
			if (degree <= ring_limit[step] && !rested[v]) {
				/* A fold is accepted only when nothing else is left to do. */
				double height;
				const double price = sheet_remove(sheet, v, cost, &height, false);
				const bool near = crowded[v] || height + drift[v] <= limit || sheet_on_border(sheet, v);
				if (near && price < (step + 1 < LIMITS ? 30 : INFINITY)) {
					sheet_remove(sheet, v, cost, NULL, true);
					gone = true;
					for (size_t k = 0; k < degree; k++) {
						rested[ring[k]] = 1;
						if (!crowded[v])
							drift[ring[k]] = fmax(drift[ring[k]], height + drift[v]);
					}
				}
			}
			if (!gone)
				waiting[left++] = v;
		}
		count = left;
		if (before - left <= before / 50) {
			if (step + 1 < LIMITS)
				step++;
			else if (before == left)
				break;
		}
	}
	free(rested), free(waiting);
	return count;
}

/* Vertices that are too close to the border for its control points: sides are chords of curves, and a point between
 * a chord and its curve makes faces that fold. */
static unsigned char *find_crowded(const struct sheet *sheet, const struct loops *loops)
{
	unsigned char *crowded = mem_array(sheet->vertex_count, 1);
	for (size_t v = 0; v < sheet->vertex_count; v++)
		for (size_t l = 0; l < loops->count && !crowded[v]; l++)
			for (size_t i = loops->start[l]; i < loops->start[l + 1]; i++) {
				const double *p = &sheet->xyz[3 * v], *a = &sheet->xyz[3 * (size_t)loops->vertex[i]];
				const double *b = &sheet->xyz[3 * (size_t)loops->vertex[i + 1 < loops->start[l + 1] ? i + 1 : loops->start[l]]];
				double along[3], offset[3];
				sub3(along, b, a);
				sub3(offset, p, a);
				const double squared = dot3(along, along), t = squared > 0 ? fmin(fmax(dot3(offset, along) / squared, 0), 1) : 0;
				add_scaled3(offset, -t, along);
				if (dot3(offset, offset) < border_clearance * border_clearance * squared) {
					crowded[v] = 1;
					break;
				}
			}
	return crowded;
}

static void swap_edges(struct sheet *sheet, const struct sheet_cost *cost)
{
	for (int pass = 0; pass < 12; pass++) {
		size_t swaps = 0;
		for (size_t h = 0; h < 3 * sheet->triangle_count; h++)
			if (sheet->origin[h] != NO_INDEX && sheet->twin[h] != NO_INDEX && sheet->twin[h] > (idx_t)h)
				swaps += sheet_swap(sheet, (idx_t)h, cost);
		if (swaps == 0)
			break;
	}
}

/* No edge may stand twice between two control points, in this patch or any other: those that do (the costs could not avoid them)
 * get a point in their middle, and edges from a point to itself, where a patch touches itself, two. */
static void part_double_edges(struct sheet *sheet, const struct edge_set *taken)
{
	struct edge_set *mine = edge_set_new();
	for (size_t h = 0; h < 3 * sheet->triangle_count; h++) {
		if (sheet->origin[h] == NO_INDEX || sheet->twin[h] == NO_INDEX || sheet->twin[h] < (idx_t)h)
			continue;
		const idx_t a = sheet->origin[h], b = sheet_target(sheet, (idx_t)h), p = sheet->point[a], q = sheet->point[b];
		if (p == NO_INDEX || q == NO_INDEX)
			continue;
		if (p != q && !edge_set_has(taken, p, q) && !edge_set_has(mine, p, q)) {
			edge_set_add(mine, p, q);
			continue;
		}
		double middle[3];
		for (int k = 0; k < 3; k++)
			middle[k] = (sheet->xyz[3 * (size_t)a + (size_t)k] + sheet->xyz[3 * (size_t)b + (size_t)k]) / 2;
		sheet_split_edge(sheet, (idx_t)h, middle);
		if (p != q)
			continue;
		for (int k = 0; k < 3; k++)
			middle[k] = (sheet->xyz[3 * (size_t)a + (size_t)k] + middle[k]) / 2;
		sheet_split_edge(sheet, (idx_t)h, middle);
	}
	edge_set_free(mine);
}

static double sheet_diameter(const struct sheet *sheet)
{
	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
	for (size_t v = 0; v < sheet->vertex_count; v++)
		for (int k = 0; k < 3; k++) {
			low[k] = fmin(low[k], sheet->xyz[3 * v + (size_t)k]);
			high[k] = fmax(high[k], sheet->xyz[3 * v + (size_t)k]);
		}
	const double diameter = distance3(low, high);
	return diameter > 0 ? diameter : 1;
}

bool layout_patch(enum layout_kind *kind, struct layout_context *context, idx_t patch, const idx_t *list, size_t count, struct fault *fault)
{
	struct sheet sheet;
	idx_t *dense_vertex;
	sheet_build(&sheet, &dense_vertex, list, count, context->dense->triangle, context->dense_twin, context->dense->xyz);
	free(dense_vertex);
	const size_t least = anchors_apply(&sheet, context->anchors, context->dense);
	if (least == SIZE_MAX && count > 0) {
		sheet_free(&sheet);
		return fault_set(fault, EX_BAD_INPUT, "patch %" PRIidx " has no border: rectify cuts such patches", context->name[patch]);
	}
	if (least < 3) {
		sheet_free(&sheet);
		return fault_set(fault, EX_BAD_INPUT, "patch %" PRIidx ": a border loop has %zu control points, needs 3", context->name[patch], least);
	}
	/* Between flat faces points are where the surface is, not where a smooth one would need them. */
	for (size_t v = 0; context->faceted[patch] && v < sheet.vertex_count; v++)
		if (sheet.point[v] != NO_INDEX && !context->control->held[sheet.point[v]])
			copy3(&context->control->xyz[3 * (size_t)sheet.point[v]], &sheet.xyz[3 * v]);
	const bool is_plane = context->dense->patch && context->dense->patch[patch].kind == PATCH_PLANE;
	struct loops loops;
	loops_find(&loops, &sheet);
	bool done = false;
	if (!is_plane && context->detail[patch] == 0) {
		if (loops_band(context, &sheet, &loops, patch))
			*kind = LAYOUT_BAND, done = true;
		else if (loops_grid(context, &sheet, &loops, patch))
			*kind = LAYOUT_GRID, done = true;
		else if (loops_dome(context, &sheet, &loops, patch))
			*kind = LAYOUT_DOME, done = true;
	}
	const size_t loop_count = loops.count;
	const double limit = context->detail[patch] && !is_plane ? ldexp(16 * context->tolerance, -context->detail[patch]) : INFINITY;
	unsigned char *crowded = done || isinf(limit) ? mem_array(sheet.vertex_count, 1) : find_crowded(&sheet, &loops);
	loops_free(&loops);
	if (done) {
		sheet_free(&sheet);
		free(crowded);
		return true;
	}
	double *normal = vertex_normals(&sheet);
	struct thinning thinning = {&sheet, context->taken, normal, sheet_diameter(&sheet)};
	const struct sheet_cost short_edges = {thin_edge, thin_triangle, &thinning};
	struct chord_context chords = {.dense = context->dense, .nearest = context->nearest, .sheet = &sheet, .control = context->control->xyz, .taken = context->taken,
	                               .patch = patch, .is_plane = is_plane, .diameter = thinning.size};
	chord_open(&chords);
	const struct sheet_cost coherent = {chord_cost, chord_triangle_cost, &chords};
	double *drift = mem_array(sheet.vertex_count, sizeof *drift);
	thin_out(&sheet, &short_edges, crowded, drift, limit);
	swap_edges(&sheet, &coherent);
	/* What had to wait may be free to go after the swaps. */
	bool border_left = false;
	if (thin_out(&sheet, &coherent, crowded, drift, limit) > 0)
		for (size_t v = 0; v < sheet.vertex_count; v++)
			border_left |= sheet.outgoing[v] != NO_INDEX && sheet.point[v] == NO_INDEX && sheet_on_border(&sheet, (idx_t)v);
	free(normal), free(drift), free(crowded);
	bool good = true;
	if (border_left) {
		good = fault_set(fault, EX_BAD_INPUT, "patch %" PRIidx ": its border cannot be thinned out to the control points", context->name[patch]);
	} else {
		size_t faces_before = context->polygons->count;
		part_double_edges(&sheet, context->taken);
		for (size_t v = 0; v < sheet.vertex_count; v++)
			if (sheet.outgoing[v] != NO_INDEX && sheet.point[v] == NO_INDEX)
				sheet.point[v] = control_add(context->control, &sheet.xyz[3 * v], POINT_INSIDE);
		chords.control = context->control->xyz;
		const struct merge_options options = {is_plane, context->faceted[patch] || (is_plane && context->detail[patch] > 0), context->flat};
		merge_triangles(context, &chords, &options, patch);
		*kind = context->polygons->count - faces_before == 1 && loop_count == 1 ? LAYOUT_FACE : LAYOUT_CHORDS;
	}
	chord_close(&chords);
	sheet_free(&sheet);
	return good;
}
