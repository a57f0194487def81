/* Uniting neighbours that one surface explains: what was found from two seeds, or as pieces of a torus. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/segment/primitive_grow.h"
#include "stages/segment/region_tidy.h"

#define SOME_LOOKS 128
#define UNEXPLAINED_MOST 0.005
#define TURN_GROWTH_MOST 2.0 /* of the squared turn */
#define UNITE_PASSES 50

/* Does the surface explain all triangles but a small share of their area? */
static bool explains_all(struct grower *g, const struct dense_patch *patch, const idx_t *part, size_t count, double area, double turn_limit)
{
	double out = 0;
	grow_begin(g);
	for (size_t i = 0; i < count; i++)
		if (!grow_explains(g, patch, part[i], turn_limit, NULL) && (out += g->facets->area[part[i]]) > UNEXPLAINED_MOST * area)
			return false;
	return true;
}

/* Does it explain some of them? Looks at SOME_LOOKS evenly taken. */
static bool explains_some(struct grower *g, const struct dense_patch *patch, const idx_t *part, size_t count)
{
	const size_t step = count / SOME_LOOKS + 1;
	grow_begin(g);
	for (size_t i = 0; i < count; i += step)
		if (grow_explains(g, patch, part[i], 2, NULL))
			return true;
	return false;
}

static int compare_border_length(const void *left, const void *right)
{
	const struct region_border *a = left, *b = right;
	if (a->length != b->length)
		return a->length > b->length ? -1 : 1;
	if (a->low != b->low)
		return a->low < b->low ? -1 : 1;
	return (a->high > b->high) - (a->high < b->high);
}

/* One surface for both: the larger one's refitted, else a fresh guess, simplest first. */
static bool fit_union(struct grower *g, struct dense_patch *out, const struct dense_patch *a, const struct dense_patch *b, const idx_t *part,
                      size_t count, double area, double turn_limit)
{
	/* two bent surfaces may be pieces of a torus; a plane and another one are not */
	const bool has_plane = a->kind == PATCH_PLANE || b->kind == PATCH_PLANE;
	const int pa = primitive_parameter_count(a->kind), pb = primitive_parameter_count(b->kind), most = has_plane ? (pa > pb ? pa : pb) : 7;
	static const enum patch_kind kind[] = {PATCH_PLANE, PATCH_SPHERE, PATCH_CYLINDER, PATCH_CONE, PATCH_TORUS};
	for (int k = 0; k < 5; k++) {
		if (primitive_parameter_count(kind[k]) > most)
			break;
		struct dense_patch p;
		if (kind[k] == a->kind) {
			p = *a;
			if (grow_fit(g, &p, part, count) && explains_all(g, &p, part, count, area, turn_limit)) {
				*out = p;
				return true;
			}
		}
		p = *a;
		if (kind[k] == PATCH_TORUS && a->kind == PATCH_TORUS && grow_dual_torus(g, &p, part, count) && explains_all(g, &p, part, count, area, turn_limit)) {
			*out = p;
			return true;
		}
		p = *a;
		if (grow_hypothesis(g, &p, kind[k], part, count, 2 * g->distance) && explains_all(g, &p, part, count, area, turn_limit)) {
			*out = p;
			return true;
		}
	}
	return false;
}

/* Sum of squared turns under the triangles, times their areas; widest and area are raised by what there is. */
static double square_turn(struct grower *g, const struct dense_patch *patch, const idx_t *part, size_t count, double *widest, double *area)
{
	double sum = 0, turn = 0;
	grow_begin(g);
	for (size_t i = 0; i < count; i++) {
		if (area)
			*area += g->facets->area[part[i]];
		if (patch->kind == PATCH_PLANE || !grow_explains(g, patch, part[i], 2, &turn))
			continue;
		sum += g->facets->area[part[i]] * turn * turn;
		if (widest)
			*widest = fmax(*widest, turn);
	}
	return sum;
}

size_t tidy_unite(struct regions *r, const struct flats *flats, const struct tidy_options *o)
{
	const struct facets *f = r->facets;
	struct grower g;
	size_t united = 0;
	grower_init(&g, f);
	g.flats = flats;
	/* what was found from two ends of a noisy surface differs by more than the noise */
	g.distance = o->is_noisy ? 2 * o->distance : o->distance;
	g.angle = o->angle;
	idx_t *part = mem_array(f->triangle_count, sizeof *part);
	/* pairs of which neither changed since the last pass fail again */
	unsigned char *is_fresh = mem_array(r->count, 1);
	memset(is_fresh, 1, r->count);
	for (int pass = 0; pass < UNITE_PASSES; pass++) {
		size_t *start, now = 0;
		idx_t *member;
		struct region_border *border;
		regions_members(r, &start, &member);
		const size_t borders = regions_borders(r, &border);
		unsigned char *is_touched = mem_array(r->count, 1);
		qsort(border, borders, sizeof *border, compare_border_length);
		for (size_t i = 0; i < borders; i++) {
			idx_t a = border[i].low, b = border[i].high;
			if (is_touched[a] || is_touched[b] || (!is_fresh[a] && !is_fresh[b]) || border[i].sharp_length >= border[i].length)
				continue;
			if (r->patch[a].kind == PATCH_FREE || r->patch[b].kind == PATCH_FREE)
				continue;
			size_t na = start[a + 1] - start[a], nb = start[b + 1] - start[b];
			if (na < nb) {
				const idx_t swap = a;
				a = b, b = swap;
				na = start[a + 1] - start[a], nb = start[b + 1] - start[b];
			}
			/* one surface for both is near each of them where they meet: most pairs end here */
			g.distance = 8 * o->distance;
			g.angle = 3 * o->angle;
			const bool is_near = explains_some(&g, &r->patch[a], member + start[b], nb) || explains_some(&g, &r->patch[b], member + start[a], na);
			g.distance = o->is_noisy ? 2 * o->distance : o->distance;
			g.angle = o->angle;
			if (!is_near)
				continue;
			memcpy(part, member + start[a], na * sizeof *part);
			memcpy(part + na, member + start[b], nb * sizeof *part);
			double widest = 0, area = 0;
			const double before = square_turn(&g, &r->patch[a], part, na, &widest, &area) + square_turn(&g, &r->patch[b], part + na, nb, &widest, &area);
			struct dense_patch joint = r->patch[a];
			if (!fit_union(&g, &joint, &r->patch[a], &r->patch[b], part, na + nb, area, widest > 0 ? 1.5 * widest + 0.01 : 0.3))
				continue;
			/* a surface that turns much more under the same facets is not theirs */
			if (square_turn(&g, &joint, part, na + nb, NULL, NULL) > TURN_GROWTH_MOST * before + 1e-3 * area)
				continue;
			r->patch[a] = joint;
			for (size_t j = start[b]; j < start[b + 1]; j++)
				r->label[member[j]] = a;
			is_touched[a] = is_touched[b] = 1;
			now++;
		}
		free(start);
		free(member);
		free(border);
		free(is_fresh);
		is_fresh = is_touched;
		united += now;
		if (!now)
			break;
	}
	free(is_fresh);
	free(part);
	grower_free(&g);
	return united;
}
