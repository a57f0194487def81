/* After the search: borders straightened, remains absorbed, equal surfaces united. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/primitive_grow.h"
#include "stages/segment/region_tidy.h"

#define COST_MOST 25.0  /* a triangle that does not fit at all */
#define COST_FREE 6.0   /* a triangle of a free region: between "fits badly" and "does not fit" */
#define COST_FITTING 9.0 /* vertices within the tolerance, normals about */
#define ABSORB_PASSES 12
#define IDENTIFY_ANGLE 0.05 /* radians */
#define STRIP_AREA_MOST 10.0 /* least areas */
#define SPECK_TRIANGLES_MOST 24

void tidy_free_regions(struct regions *r)
{
	const struct facets *f = r->facets;
	idx_t *queue = mem_array(f->triangle_count, sizeof *queue);
	for (size_t t = 0; t < f->triangle_count; t++) {
		if (r->label[t] != NO_INDEX)
			continue;
		const struct dense_patch patch = {.kind = PATCH_FREE};
		const idx_t label = regions_add(r, &patch);
		size_t head = 0, tail = 0;
		queue[tail++] = (idx_t)t;
		r->label[t] = label;
		while (head < tail) {
			const idx_t at = queue[head++];
			for (int k = 0; k < 3; k++) {
				const idx_t to = f->neighbour[3 * at + k];
				if (f->is_sharp[3 * at + k] || r->label[to] != NO_INDEX)
					continue;
				r->label[to] = label;
				queue[tail++] = to;
			}
		}
	}
	free(queue);
}

/* Misfit of a triangle in squared tolerances: distance of its vertices and deviation of its normal. */
static double misfit(const struct facets *f, const struct tidy_options *o, const struct dense_patch *patch, idx_t t)
{
	if (patch->kind == PATCH_FREE)
		return COST_FREE;
	double sum = 0, n[3];
	for (int k = 0; k < 3; k++) {
		const double d = 3 * primitive_distance(patch, f->xyz + 3 * f->triangle[3 * t + k]) / o->distance;
		sum += fmin(COST_MOST, d * d) / 3;
	}
	if (f->height[t] > 0) {
		const double slack = o->angle + fmin(0.7, 1.5 * o->distance / f->height[t]);
		primitive_foot(patch, f->centroid + 3 * t, NULL, n);
		const double d = 2 * distance3(n, f->normal + 3 * t) / slack;
		sum += fmin(COST_MOST, d * d);
	}
	return sum;
}

size_t tidy_borders(struct regions *r, const struct tidy_options *o, int sweeps)
{
	const struct facets *f = r->facets;
	unsigned char *is_active = mem_array(f->triangle_count, 1);
	size_t changed = 0;
	memset(is_active, 1, f->triangle_count);
	for (int sweep = 0; sweep < sweeps; sweep++) {
		size_t now = 0;
		for (size_t t = 0; t < f->triangle_count; t++) {
			if (!is_active[t])
				continue;
			is_active[t] = 0;
			idx_t candidate[4] = {r->label[t]};
			int candidates = 1;
			for (int k = 0; k < 3; k++) {
				const size_t h = 3 * t + k;
				if (f->is_sharp[h])
					continue;
				const idx_t other = r->label[f->neighbour[h]];
				bool is_new = true;
				for (int j = 0; j < candidates; j++)
					is_new = is_new && candidate[j] != other;
				if (is_new)
					candidate[candidates++] = other;
			}
			if (candidates == 1)
				continue;
			double least = INFINITY;
			idx_t best = candidate[0];
			for (int j = 0; j < candidates; j++) {
				double cost = f->area[t] * misfit(f, o, &r->patch[candidate[j]], (idx_t)t);
				for (int k = 0; k < 3; k++) {
					const size_t h = 3 * t + k;
					if (!f->is_sharp[h] && r->label[f->neighbour[h]] != candidate[j])
						cost += o->smoothness * f->length[h] * fmax(0.1, 1 - fabs(f->bend[h]) / 0.7);
				}
				/* the present label keeps ties */
				if (cost < least * (1 - 1e-9)) {
					least = cost;
					best = candidate[j];
				}
			}
			if (best == r->label[t])
				continue;
			r->label[t] = best;
			now++;
			is_active[t] = 1;
			for (int k = 0; k < 3; k++)
				if (f->neighbour[3 * t + k] != NO_INDEX)
					is_active[f->neighbour[3 * t + k]] = 1;
		}
		changed += now;
		if (!now)
			break;
	}
	free(is_active);
	return changed;
}

struct small_region {
	double area;
	idx_t region;
};

static int compare_small(const void *left, const void *right)
{
	const struct small_region *a = left, *b = right;
	if (a->area != b->area)
		return a->area < b->area ? -1 : 1;
	return (a->region > b->region) - (a->region < b->region);
}

/* Mean misfit of a region's triangles to another region's surface. */
static double mean_misfit(const struct regions *r, const struct tidy_options *o, const struct dense_patch *patch, const idx_t *part, size_t count)
{
	double sum = 0, area = 0;
	for (size_t i = 0; i < count; i++) {
		sum += r->facets->area[part[i]] * misfit(r->facets, o, patch, part[i]);
		area += r->facets->area[part[i]];
	}
	return area > 0 ? sum / area : 0;
}

enum smallness { NOT_SMALL, SMALL_IF_FITTING, SMALL };

/* Small regions are absorbed whatever fits; small patches of a surface only where the neighbour explains them as well. */
static enum smallness smallness(const struct regions *r, const struct tidy_options *o, idx_t region, const idx_t *part, size_t count)
{
	const struct facets *f = r->facets;
	double area = 0, perimeter = 0, height = 0;
	for (size_t i = 0; i < count; i++) {
		area += f->area[part[i]];
		height += f->area[part[i]] * f->height[part[i]];
		for (int k = 0; k < 3; k++) {
			const idx_t h = 3 * part[i] + k, to = f->neighbour[h];
			if (to == NO_INDEX || r->label[to] != region)
				perimeter += f->length[h];
		}
	}
	const bool is_free = r->patch[region].kind == PATCH_FREE;
	/* one triangle wide: the width of a strip is twice its area over its perimeter */
	const bool is_strip = area < STRIP_AREA_MOST * o->least_area && 2 * area * area < 1.3 * perimeter * height;
	if (is_free)
		return area < o->least_area || is_strip || (count <= 3 && area < STRIP_AREA_MOST * o->least_area) ? SMALL : NOT_SMALL;
	if (o->is_noisy && o->is_dense && (is_strip || area < o->least_area))
		return SMALL;
	return area < o->least_area || is_strip ? SMALL_IF_FITTING : NOT_SMALL;
}

size_t tidy_absorb(struct regions *r, const struct tidy_options *o)
{
	size_t absorbed = 0;
	for (int pass = 0; pass < ABSORB_PASSES; pass++) {
		size_t *start, smalls = 0, now = 0;
		idx_t *member;
		struct region_border *border;
		regions_members(r, &start, &member);
		const size_t borders = regions_borders(r, &border);
		struct small_region *small = mem_array(r->count, sizeof *small);
		idx_t *into = mem_array(r->count, sizeof *into);
		double *best = mem_array(r->count, sizeof *best), *most = mem_array(r->count, sizeof *most);
		unsigned char *is_candidate = mem_array(r->count, 1), *is_touched = mem_array(r->count, 1);
		for (size_t i = 0; i < r->count; i++) {
			into[i] = NO_INDEX;
			best[i] = INFINITY;
			const size_t count = start[i + 1] - start[i];
			const enum smallness how = count ? smallness(r, o, (idx_t)i, member + start[i], count) : NOT_SMALL;
			if (how == NOT_SMALL)
				continue;
			most[i] = how == SMALL ? INFINITY : COST_FITTING;
			double area = 0;
			for (size_t j = start[i]; j < start[i + 1]; j++)
				area += r->facets->area[member[j]];
			small[smalls++] = (struct small_region){area, (idx_t)i};
			is_candidate[i] = 1;
		}
		for (size_t i = 0; i < borders; i++)
			for (int side = 0; side < 2; side++) {
				const idx_t a = side ? border[i].high : border[i].low, b = side ? border[i].low : border[i].high;
				const double smooth = border[i].length - border[i].sharp_length;
				if (!is_candidate[a] || smooth <= 0)
					continue;
				/* a surface that was found stays one: only remains go to free regions */
				if (r->patch[b].kind == PATCH_FREE && r->patch[a].kind != PATCH_FREE)
					continue;
				/* where nothing fits, the longer common border decides */
				const double cost = mean_misfit(r, o, &r->patch[b], member + start[a], start[a + 1] - start[a]) + 1e-3 / smooth;
				if (cost < best[a] && cost < most[a]) {
					best[a] = cost;
					into[a] = b;
				}
			}
		qsort(small, smalls, sizeof *small, compare_small);
		for (size_t i = 0; i < smalls; i++) {
			const idx_t a = small[i].region, b = into[a];
			if (b == NO_INDEX || is_touched[a] || is_touched[b])
				continue;
			for (size_t j = start[a]; j < start[a + 1]; j++)
				r->label[member[j]] = b;
			/* b has grown: what it is now is seen in the next pass; but many small ones may join one large one */
			is_touched[a] = 1;
			if (is_candidate[b])
				is_touched[b] = 1;
			now++;
		}
		free(start);
		free(member);
		free(border);
		free(small);
		free(into);
		free(best);
		free(most);
		free(is_candidate);
		free(is_touched);
		absorbed += now;
		if (!now)
			break;
	}
	return absorbed;
}

size_t tidy_specks(struct regions *r, const double *speck_area, const double *reach)
{
	const struct facets *f = r->facets;
	size_t *start, absorbed = 0;
	idx_t *member;
	struct region_border *border;
	regions_members(r, &start, &member);
	const size_t borders = regions_borders(r, &border);
	idx_t *into = mem_array(r->count, sizeof *into);
	double *length = mem_array(r->count, sizeof *length);
	unsigned char *is_speck = mem_array(r->count, 1);
	for (size_t i = 0; i < r->count; i++) {
		double area = 0;
		for (size_t j = start[i]; j < start[i + 1]; j++)
			area += f->area[member[j]];
		is_speck[i] = area < speck_area[i] && start[i + 1] - start[i] <= SPECK_TRIANGLES_MOST;
		into[i] = NO_INDEX;
	}
	for (size_t i = 0; i < borders; i++)
		for (int side = 0; side < 2; side++) {
			const idx_t a = side ? border[i].high : border[i].low, b = side ? border[i].low : border[i].high;
			if (!is_speck[a] || is_speck[b] || border[i].length <= length[a])
				continue;
			/* a facet or two alone between sharp edges of a rough mesh is a burr, even if it sticks out */
			const double far = start[a + 1] - start[a] <= 2 ? fmax(reach[a], 3 * reach[b]) : fmax(reach[a], reach[b]);
			if (r->patch[b].kind == PATCH_FREE || grow_residual(f, &r->patch[b], member + start[a], start[a + 1] - start[a]) <= far) {
				into[a] = b;
				length[a] = border[i].length;
			}
		}
	for (size_t i = 0; i < r->count; i++)
		if (into[i] != NO_INDEX) {
			for (size_t j = start[i]; j < start[i + 1]; j++)
				r->label[member[j]] = into[i];
			absorbed++;
		}
	free(start);
	free(member);
	free(border);
	free(into);
	free(length);
	free(is_speck);
	return absorbed;
}

static void identify(struct regions *r, double distance, int kinds)
{
	static const enum patch_kind kind[] = {PATCH_PLANE, PATCH_SPHERE, PATCH_CYLINDER, PATCH_CONE, PATCH_TORUS};
	struct grower g;
	size_t *start;
	idx_t *member;
	grower_init(&g, r->facets);
	g.distance = distance;
	g.angle = IDENTIFY_ANGLE;
	regions_members(r, &start, &member);
	for (size_t i = 0; i < r->count; i++) {
		const idx_t *part = member + start[i];
		const size_t count = start[i + 1] - start[i];
		for (int k = 0; k < kinds && r->patch[i].kind == PATCH_FREE && count; k++) {
			struct dense_patch surface = r->patch[i];
			bool is_on = grow_hypothesis(&g, &surface, kind[k], part, count, distance);
			grow_begin(&g);
			for (size_t j = 0; j < count && is_on; j++)
				is_on = grow_explains(&g, &surface, part[j], 1, NULL);
			if (is_on)
				r->patch[i] = surface;
		}
	}
	free(start);
	free(member);
	grower_free(&g);
}

void tidy_flat_regions(struct regions *r, double distance)
{
	identify(r, distance, 1);
}

void tidy_identify(struct regions *r, double distance)
{
	identify(r, distance, 5);
}

/* Refit to the triangles that lie on the surface, so that what was absorbed beside it does not pull it away. */
static void refit(struct grower *g, struct dense_patch *p, const idx_t *part, size_t count, double distance, idx_t *on)
{
	size_t on_count = 0;
	for (size_t j = 0; j < count; j++)
		if (grow_residual(g->facets, p, part + j, 1) <= 1.5 * distance)
			on[on_count++] = part[j];
	struct dense_patch next = *p;
	if (2 * on_count < count || !grow_fit(g, &next, on, on_count))
		return;
	if (grow_residual(g->facets, &next, on, on_count) <= 2 * distance)
		*p = next;
}

void tidy_measure(struct regions *r, double refit_distance)
{
	const struct facets *f = r->facets;
	struct grower g;
	size_t *start;
	idx_t *member, *on = mem_array(f->triangle_count, sizeof *on);
	grower_init(&g, f);
	regions_members(r, &start, &member);
	for (size_t i = 0; i < r->count; i++) {
		struct dense_patch *p = &r->patch[i];
		const idx_t *part = member + start[i];
		const size_t count = start[i + 1] - start[i];
		if (refit_distance > 0 && p->kind != PATCH_FREE && count)
			refit(&g, p, part, count, refit_distance, on);
		p->area = 0;
		for (size_t j = 0; j < count; j++)
			p->area += f->area[part[j]];
		p->residual = p->kind == PATCH_FREE ? 0 : grow_residual(f, p, part, count);
	}
	free(start);
	free(member);
	free(on);
	grower_free(&g);
}
