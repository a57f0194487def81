/* Growing one analytic surface over the triangles that it explains.
 *
 * The vertices of a tessellated CAD face lie on its surface, the insides of its facets do not: distances are taken at
 * vertices; the normal of a facet may differ from the surface's by a part of the turn of the surface under the facet. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/primitive_grow.h"

#define FIT_POINTS_MOST 250 /* more points hardly change a fit of 7 parameters */
#define TURN_PER_BEND_MOST 2.2
#define FEW_TRIANGLES 16
#define DUAL_GAIN 0.8
#define FLAT_LOOKS 32
#define REFINE_MOST 6
#define TURN_MOST 0.95      /* chord of 57 degrees: coarser facets than hexagonal are not taken for round */

void grower_init(struct grower *g, const struct facets *f)
{
	*g = (struct grower){.facets = f};
	g->region = mem_array(f->triangle_count, sizeof *g->region);
	g->stamp = mem_array(f->triangle_count, sizeof *g->stamp);
	g->vertex_stamp = mem_array(f->vertex_count, sizeof *g->vertex_stamp);
	g->foot_tick = mem_array(f->vertex_count, sizeof *g->foot_tick);
	g->foot = mem_array(4 * f->vertex_count, sizeof *g->foot);
	g->surface_tick = 1;
	g->bad_stamp = mem_array(f->triangle_count, sizeof *g->bad_stamp);
	g->points = mem_array(3 * (FIT_POINTS_MOST + 4), sizeof *g->points);
	g->elements = mem_array(3 * (FIT_POINTS_MOST + 4), sizeof *g->elements);
	g->normals = mem_array(3 * (FIT_POINTS_MOST + 4), sizeof *g->normals);
	g->weights = mem_array(FIT_POINTS_MOST + 4, sizeof *g->weights);
}

void grower_free(struct grower *g)
{
	free(g->region);
	free(g->stamp);
	free(g->vertex_stamp);
	free(g->bad_stamp);
	free(g->foot_tick);
	free(g->foot);
	free(g->points);
	free(g->elements);
	free(g->normals);
	free(g->weights);
	*g = (struct grower){0};
}

/* Where the surface has no normal (cone apex, axis), a corner says nothing about the turn. */
static bool has_normal(const struct dense_patch *patch, const double x[3], double distance)
{
	if (patch->kind != PATCH_CONE && patch->kind != PATCH_TORUS)
		return true;
	double d[3], c[3];
	sub3(d, x, patch->point);
	cross3(c, d, patch->axis);
	return norm3(c) > 10 * distance;
}

void grow_begin(struct grower *g)
{
	g->surface_tick++;
	if (g->surface_tick == 0) {
		memset(g->foot_tick, 0, g->facets->vertex_count * sizeof *g->foot_tick);
		g->surface_tick = 1;
	}
}

/* Normal and distance at a vertex; its six or so triangles share them. */
static const double *vertex_foot(struct grower *g, const struct dense_patch *patch, idx_t v)
{
	double *foot = g->foot + 4 * v;
	if (g->foot_tick[v] != g->surface_tick) {
		g->foot_tick[v] = g->surface_tick;
		foot[3] = primitive_foot(patch, g->facets->xyz + 3 * v, NULL, foot);
	}
	return foot;
}

static double squared_distance(const double a[3], const double b[3])
{
	double d[3];
	sub3(d, a, b);
	return dot3(d, d);
}

bool grow_explains(struct grower *g, const struct dense_patch *patch, idx_t t, double turn_limit, double *turn)
{
	const struct facets *f = g->facets;
	const double *n[3];
	double centre[3], widest = 0;
	int normals = 0;
	for (int k = 0; k < 3; k++) {
		const idx_t v = f->triangle[3 * t + k];
		n[normals] = vertex_foot(g, patch, v);
		if (fabs(n[normals][3]) > g->distance)
			return false;
		normals += has_normal(patch, f->xyz + 3 * v, g->distance);
	}
	for (int i = 0; i < normals && patch->kind != PATCH_PLANE; i++)
		for (int j = 0; j < i; j++)
			widest = fmax(widest, squared_distance(n[i], n[j]));
	widest = sqrt(widest);
	if (turn)
		*turn = widest;
	if (widest > turn_limit)
		return false;
	/* a facet of little height says little about the normal: noise of its vertices turns it */
	const double *normal = f->normal + 3 * t;
	const double slack = f->height[t] > 0 ? g->angle + fmin(0.7, 1.5 * g->distance / f->height[t]) : 2;
	primitive_foot(patch, f->centroid + 3 * t, NULL, centre);
	return f->area[t] <= 0 || distance3(centre, normal) <= slack + 0.35 * widest;
}

static uint32_t next_tick(struct grower *g)
{
	if (++g->tick == UINT32_MAX / 2) {
		memset(g->stamp, 0, g->facets->triangle_count * sizeof *g->stamp);
		memset(g->vertex_stamp, 0, g->facets->vertex_count * sizeof *g->vertex_stamp);
		memset(g->bad_stamp, 0, g->facets->triangle_count * sizeof *g->bad_stamp);
		g->tick = 1;
	}
	return g->tick;
}

/* Remember the two largest turns among distinct flats. */
struct turn_record {
	double first, second;
	idx_t first_flat, second_flat;
};

static void record_turn(struct turn_record *r, idx_t flat, double turn)
{
	if (flat == r->first_flat) {
		r->first = fmax(r->first, turn);
	} else if (turn > r->first) {
		r->second = r->first, r->second_flat = r->first_flat;
		r->first = turn, r->first_flat = flat;
	} else if (turn > r->second || flat == r->second_flat) {
		r->second = fmax(r->second, turn), r->second_flat = flat;
	}
}

/* A facet of a curved face lies on it with all its corners. One that does not, beyond the tolerance of coplanarity, is
 * another face of which some corners happen to lie on the surface. Looks at FLAT_LOOKS triangles of a large flat. */
static bool sticks_out(struct grower *g, const struct dense_patch *patch, idx_t flat, double turn_limit, uint32_t tick)
{
	const size_t low = g->flats->start[flat], count = g->flats->start[flat + 1] - low;
	if (count < 2)
		return false;
	/* two marks of one tick: 2 * tick is good, 2 * tick + 1 is bad */
	if (g->bad_stamp[flat] / 2 == tick)
		return g->bad_stamp[flat] % 2;
	const size_t step = count / FLAT_LOOKS + 1;
	bool is_out = false;
	for (size_t i = 0; i < count && !is_out; i += step) {
		const idx_t t = g->flats->member[low + i];
		is_out = (!g->owner || g->owner[t] == NO_INDEX) && !grow_explains(g, patch, t, turn_limit, NULL);
	}
	g->bad_stamp[flat] = 2 * tick + is_out;
	return is_out;
}

double grow_region(struct grower *g, const struct dense_patch *patch, const idx_t *seed, size_t seed_count, double turn_limit)
{
	const struct facets *f = g->facets;
	const uint32_t tick = next_tick(g);
	grow_begin(g);
	struct turn_record record = {0, 0, NO_INDEX, NO_INDEX};
	idx_t some_flat[4];
	g->region_count = 0;
	g->region_area = 0;
	g->flat_count = 0;
	double squares = 0, bends = 0;
	size_t tail = 0;
	for (size_t i = 0; i < seed_count + tail; i++) {
		/* seeds first, then what was found */
		const bool is_seed = i < seed_count;
		const idx_t at = is_seed ? seed[i] : g->region[i - seed_count];
		for (int k = is_seed ? 2 : 0; k < 3; k++) {
			idx_t to = at;
			if (!is_seed) {
				if (f->is_sharp[3 * at + k])
					continue;
				to = f->neighbour[3 * at + k];
			}
			double turn;
			const idx_t flat = g->flats->of[to];
			if (g->stamp[to] == tick || (g->owner && g->owner[to] != NO_INDEX))
				continue;
			g->stamp[to] = tick;
			g->work++;
			if (!grow_explains(g, patch, to, turn_limit, &turn) || (patch->kind != PATCH_PLANE && sticks_out(g, patch, flat, turn_limit, tick)))
				continue;
			g->region[tail++] = to;
			g->region_area += f->area[to];
			double bend = 0;
			for (int j = 0; j < 3; j++)
				bend = fmax(bend, f->is_sharp[3 * to + j] ? 0 : fabs(f->bend[3 * to + j]));
			bends += bend * bend * f->area[to];
			squares += turn * turn * f->area[to];
			record_turn(&record, flat, turn);
			bool is_new = true;
			for (size_t j = 0; j < g->flat_count; j++)
				is_new = is_new && some_flat[j] != flat;
			if (is_new && g->flat_count < 4)
				some_flat[g->flat_count++] = flat;
		}
	}
	g->region_count = tail;
	g->turn = record.second;
	g->mean_turn = g->region_area > 0 ? sqrt(squares / g->region_area) : 0;
	g->mean_bend = g->region_area > 0 ? sqrt(bends / g->region_area) : 0;
	return g->region_area;
}

/* Distinct vertices of the triangles, at most about FIT_POINTS_MOST of them, evenly taken. */
static size_t gather_points(struct grower *g, const idx_t *part, size_t count)
{
	const struct facets *f = g->facets;
	const uint32_t tick = next_tick(g);
	const size_t stride = count / FIT_POINTS_MOST + 1;
	size_t points = 0;
	for (size_t i = 0; i < count && points < FIT_POINTS_MOST; i += stride)
		for (int k = 0; k < 3; k++) {
			const idx_t v = f->triangle[3 * part[i] + k];
			if (g->vertex_stamp[v] == tick)
				continue;
			g->vertex_stamp[v] = tick;
			copy3(g->points + 3 * points++, f->xyz + 3 * v);
		}
	g->work += points * 8;
	return points;
}

/* Surface elements for a guess. Of facets: exact for strips of flat facets, but the diagonals of twisted quadrangles turn the
 * normals of their halves. Of vertices, with the normals of their wedges: right inside a smooth surface, one-sided on sharp edges. */
static size_t gather_elements(struct grower *g, const idx_t *part, size_t count, bool of_vertices)
{
	const struct facets *f = g->facets;
	const size_t stride = count / FIT_POINTS_MOST + 1;
	const uint32_t tick = next_tick(g);
	size_t elements = 0;
	for (size_t i = 0; i < count && elements < FIT_POINTS_MOST; i += stride) {
		const idx_t t = part[i];
		if (!of_vertices && f->area[t] > 0) {
			copy3(g->elements + 3 * elements, f->centroid + 3 * t);
			copy3(g->normals + 3 * elements, f->normal + 3 * t);
			g->weights[elements++] = f->area[t];
		}
		for (int k = 0; of_vertices && k < 3; k++) {
			const idx_t v = f->triangle[3 * t + k];
			if (g->vertex_stamp[v] == tick)
				continue;
			g->vertex_stamp[v] = tick;
			copy3(g->elements + 3 * elements, f->xyz + 3 * v);
			copy3(g->normals + 3 * elements, f->wedge_normal + 3 * f->wedge[3 * t + k]);
			g->weights[elements++] = 1;
		}
	}
	return elements;
}

static bool guess_and_fit(struct grower *g, struct dense_patch *patch, enum patch_kind kind, const idx_t *part, size_t count, double most, bool of_vertices)
{
	double largest, before = INFINITY;
	const size_t elements = gather_elements(g, part, count, of_vertices);
	if (!primitive_guess(patch, kind, g->elements, g->normals, g->weights, elements))
		return false;
	const size_t points = gather_points(g, part, count);
	/* most guesses are bad: some steps tell whether it will converge */
	for (int pass = 0; pass < 5; pass++) {
		if (!primitive_fit(patch, g->points, NULL, points, 4))
			return false;
		primitive_residual(patch, g->points, points, &largest, NULL);
		if (largest <= most)
			return true;
		if (largest > (largest > 10 * most ? 0.5 : 0.8) * before)
			return false;
		before = largest;
	}
	return false;
}

bool grow_hypothesis(struct grower *g, struct dense_patch *patch, enum patch_kind kind, const idx_t *part, size_t count, double most)
{
	const bool is_torus = kind == PATCH_TORUS;
	if (guess_and_fit(g, patch, kind, part, count, most, is_torus))
		return true;
	return is_torus && count <= FEW_TRIANGLES && guess_and_fit(g, patch, kind, part, count, most, false);
}

bool grow_fit(struct grower *g, struct dense_patch *patch, const idx_t *part, size_t count)
{
	const size_t points = gather_points(g, part, count);
	return primitive_fit(patch, g->points, NULL, points, 6);
}

bool grow_dual_torus(struct grower *g, struct dense_patch *patch, const idx_t *part, size_t count)
{
	struct dense_patch dual = *patch;
	double middle[3] = {0, 0, 0}, before, after;
	const size_t points = gather_points(g, part, count);
	for (size_t i = 0; i < points; i++)
		add_scaled3(middle, 1 / (double)points, g->points + 3 * i);
	if (!primitive_dual_torus(&dual, patch, middle) || !primitive_fit(&dual, g->points, NULL, points, 12))
		return false;
	primitive_residual(patch, g->points, points, NULL, &before);
	primitive_residual(&dual, g->points, points, NULL, &after);
	if (!(after < DUAL_GAIN * before))
		return false;
	*patch = dual;
	return true;
}

double grow_residual(const struct facets *f, const struct dense_patch *patch, const idx_t *part, size_t count)
{
	double most = 0;
	for (size_t i = 0; i < count; i++)
		for (int k = 0; k < 3; k++)
			most = fmax(most, fabs(primitive_distance(patch, f->xyz + 3 * f->triangle[3 * part[i] + k])));
	return most;
}

double grow_refine(struct grower *g, struct dense_patch *patch, const idx_t *seed, size_t seed_count)
{
	double best = 0, turn_limit = TURN_MOST;
	for (int pass = 0; pass < REFINE_MOST; pass++) {
		struct dense_patch next = *patch;
		if (pass > 0 && !grow_fit(g, &next, g->region, g->region_count))
			break;
		const double area = grow_region(g, &next, seed, seed_count, turn_limit);
		if (area <= 0)
			return 0;
		*patch = next;
		if (patch->kind != PATCH_PLANE) {
			/* one facet much wider than all others is a plane that happens to end on the surface */
			const double limit = fmin(TURN_MOST, 1.5 * g->turn + 0.01);
			if (limit < turn_limit) {
				turn_limit = limit;
				if (grow_region(g, patch, seed, seed_count, turn_limit) <= 0)
					return 0;
			}
		}
		const bool settled = g->region_area <= 1.001 * best;
		best = g->region_area;
		if (settled)
			break;
	}
	if (patch->kind != PATCH_PLANE) {
		const size_t points = gather_points(g, g->region, g->region_count);
		if (g->mean_turn > TURN_PER_BEND_MOST * g->mean_bend + 0.02)
			return 0;
		if (g->flat_count < 3 || points < (size_t)primitive_parameter_count(patch->kind) + 2)
			return 0;
	}
	return g->region_area;
}
