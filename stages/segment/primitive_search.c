/* Find analytic surfaces that explain large connected parts of a mesh.
 *
 * Hypotheses come from small connected groups of flats (coplanar clusters) around seeds, are grown over everything that
 * they explain, and refitted; then the largest is taken, the others are regrown in what is left, and so on (the greedy
 * order of Schnabel, Wahl, Klein, Efficient RANSAC for point-cloud shape detection, 2007, with seeds by area instead of
 * random ones, so that the same part gives the same patches). Rounds repeat in what is left. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/primitive_grow.h"
#include "stages/segment/primitive_search.h"

#define ROUNDS_MOST 6
#define LEAST_PROGRESS 2e-3  /* share of the free area that a round must explain for another one */
#define SIMPLER_SHARE 1.15   /* a surface with more parameters must explain so much more area */
#define RING_FLATS_MOST 64
#define NEIGHBOURS_MOST 5
#define COARSE_FLATS 1500    /* a smooth part with fewer flats is searched facet by facet */
#define MISSES_MOST 120      /* so many seeds of one smooth part without a surface worth it: it is free-form */
#define STRIP_MISSES_MOST 15 /* after so many, the part is no strip of facets */
#define MISSES_AT_FIRST 30   /* the same, when no seed has found anything yet */
#define MISS_SHARE 5e-4
#define TRIES_MOST 150       /* seeds a round, in a noisy smooth part */

struct proposal {
	struct dense_patch patch;
	double area, turn_limit, mean_turn;
	idx_t flat;              /* seed */
};

struct search {
	const struct facets *facets;
	const struct flats *flats;
	const struct search_options *options;
	struct regions *regions;
	struct grower grower;
	unsigned char *is_covered; /* a triangle: some proposal of this round explains it, or its surroundings were tried in vain */
	idx_t *group;            /* triangles of a group of flats */
	size_t group_count;
	uint32_t *flat_stamp, tick;
	size_t *part_flats;      /* a smooth part: its flats */
	double *part_area;       /* a smooth part: area that is free in this round */
	int *part_tries, *part_regions; /* seeds in this round; regions of all rounds */
	int *part_hits;          /* seeds that were worth it, of all rounds */
	int *part_misses;        /* seeds in vain since the last success in this round */
};

static const enum patch_kind simplest_first[] = {PATCH_PLANE, PATCH_SPHERE, PATCH_CYLINDER, PATCH_CONE, PATCH_TORUS};
#define KINDS (sizeof simplest_first / sizeof *simplest_first)

static double surface_turn_limit(const struct grower *g, const struct dense_patch *patch)
{
	return patch->kind == PATCH_PLANE ? 0.95 : fmin(0.95, 1.5 * g->turn + 0.01);
}

static bool is_free_flat(const struct search *s, idx_t flat)
{
	return s->regions->label[s->flats->member[s->flats->start[flat]]] == NO_INDEX;
}

static const idx_t *flat_members(const struct search *s, idx_t flat, size_t *count)
{
	*count = s->flats->start[flat + 1] - s->flats->start[flat];
	return s->flats->member + s->flats->start[flat];
}

static void group_add(struct search *s, idx_t flat)
{
	size_t count;
	const idx_t *member = flat_members(s, flat, &count);
	for (size_t i = 0; i < count; i++)
		if (s->regions->label[member[i]] == NO_INDEX)
			s->group[s->group_count++] = member[i];
	s->flat_stamp[flat] = s->tick;
}

/* Flats around the seed in breadth-first order until there are want of them; flats much larger than the seed are other
 * surfaces, most likely. Returns how many were taken. */
static size_t collect_ring(struct search *s, idx_t flat, size_t want)
{
	const struct facets *f = s->facets;
	size_t flats = 1;
	s->tick++;
	s->group_count = 0;
	group_add(s, flat);
	for (size_t head = 0; head < s->group_count && flats < want; head++)
		for (int k = 0; k < 3 && flats < want; k++) {
			const idx_t h = 3 * s->group[head] + k, to = f->neighbour[h];
			if (f->is_sharp[h] || s->regions->label[to] != NO_INDEX)
				continue;
			const idx_t other = s->flats->of[to];
			if (s->flat_stamp[other] == s->tick || s->flats->area[other] > 5 * s->flats->area[flat])
				continue;
			group_add(s, other);
			flats++;
		}
	return flats;
}

struct flat_neighbour {
	idx_t flat;
	double length;
};

/* The free flats across the longest smooth borders of a flat, longest first. */
static int neighbours_of(const struct search *s, idx_t flat, struct flat_neighbour best[NEIGHBOURS_MOST])
{
	const struct facets *f = s->facets;
	struct flat_neighbour all[RING_FLATS_MOST];
	int count = 0, taken = 0;
	size_t members;
	const idx_t *member = flat_members(s, flat, &members);
	for (size_t i = 0; i < members; i++)
		for (int k = 0; k < 3; k++) {
			const idx_t h = 3 * member[i] + k, to = f->neighbour[h];
			if (f->is_sharp[h] || s->flats->of[to] == flat || s->regions->label[to] != NO_INDEX)
				continue;
			int j = 0;
			while (j < count && all[j].flat != s->flats->of[to])
				j++;
			if (j == RING_FLATS_MOST)
				continue;
			if (j == count)
				all[count++] = (struct flat_neighbour){s->flats->of[to], 0};
			all[j].length += f->length[h];
		}
	for (; taken < NEIGHBOURS_MOST && count; taken++) {
		int most = 0;
		for (int j = 1; j < count; j++)
			if (all[j].length > all[most].length || (all[j].length == all[most].length && all[j].flat < all[most].flat))
				most = j;
		best[taken] = all[most];
		all[most] = all[--count];
	}
	return taken;
}

/* More area wins; of about equals the one whose facets turn much less (the vertices of two circles lie on a sphere as well
 * as on a cylinder or cone, but the mesh bends only as the latter does), else the one with fewer parameters. */
static bool is_better(const struct proposal *a, const struct proposal *b)
{
	const int pa = primitive_parameter_count(a->patch.kind), pb = primitive_parameter_count(b->patch.kind);
	if (!(b->area > 0) || !(a->area > 0))
		return a->area > b->area;
	if (a->patch.kind != PATCH_PLANE && b->patch.kind != PATCH_PLANE && a->area < 2 * b->area && b->area < 2 * a->area) {
		if (a->mean_turn < 0.7 * b->mean_turn - 0.01)
			return true;
		if (b->mean_turn < 0.7 * a->mean_turn - 0.01)
			return false;
	}
	if (pa > pb)
		return a->area > SIMPLER_SHARE * b->area;
	if (pa < pb)
		return a->area * SIMPLER_SHARE > b->area;
	return a->area > b->area * (1 + 1e-9);
}

/* Try the kinds on the present group, seeded by flat; keep the best. */
static void try_group(struct search *s, idx_t flat, size_t first_kind, struct proposal *best)
{
	size_t seeds;
	const idx_t *seed = flat_members(s, flat, &seeds);
	for (size_t k = first_kind; k < KINDS; k++) {
		struct proposal p = {.flat = flat};
		if (!grow_hypothesis(&s->grower, &p.patch, simplest_first[k], s->group, s->group_count, 2 * s->options->distance))
			continue;
		p.area = grow_refine(&s->grower, &p.patch, seed, seeds);
		p.turn_limit = surface_turn_limit(&s->grower, &p.patch);
		p.mean_turn = s->grower.mean_turn;
		if (is_better(&p, best))
			*best = p;
		/* nothing explains more than everything; but a sphere through two circles is not yet the simplest that does */
		if (k >= 3 && best->area > 0.98 * s->part_area[s->facets->smooth_part[seed[0]]])
			break;
	}
}

/* A plane among facets of its own size is most likely a facet of something curved. */
static bool is_significant_plane(struct search *s, const struct proposal *p, const struct flat_neighbour *neighbour, int count)
{
	int large = 0;
	for (int i = 0; i < count; i++)
		large += s->flats->area[neighbour[i].flat] * 3 > p->area;
	return count == 0 || large == 0 || p->area > 0.01 * s->facets->total_area;
}

/* A slightly bent cylinder, or a slightly opened one, shows only over a length that small groups do not have: try tori and cones on the
 * whole region of a cylinder or sphere, and of the two tori that bend alike in the middle take the one that fits all. */
static void extend_by_bend(struct search *s, idx_t flat, struct proposal *best)
{
	size_t seeds;
	const idx_t *seed = flat_members(s, flat, &seeds);
	if (!(best->area > 0) || (best->patch.kind != PATCH_CYLINDER && best->patch.kind != PATCH_SPHERE && best->patch.kind != PATCH_TORUS))
		return;
	if (best->area > 0.98 * s->part_area[s->facets->smooth_part[seed[0]]])
		return;
	grow_region(&s->grower, &best->patch, seed, seeds, best->turn_limit);
	memcpy(s->group, s->grower.region, s->grower.region_count * sizeof *s->group);
	s->group_count = s->grower.region_count;
	if (best->patch.kind == PATCH_TORUS) {
		struct proposal p = *best;
		if (!grow_dual_torus(&s->grower, &p.patch, s->group, s->group_count))
			return;
		p.area = grow_refine(&s->grower, &p.patch, seed, seeds);
		p.turn_limit = surface_turn_limit(&s->grower, &p.patch);
		p.mean_turn = s->grower.mean_turn;
		if (p.area >= best->area)
			*best = p;
		return;
	}
	try_group(s, flat, best->patch.kind == PATCH_CYLINDER ? 3 : 4, best);
}

static struct proposal propose(struct search *s, idx_t flat)
{
	struct proposal best = {.flat = flat};
	struct flat_neighbour neighbour[NEIGHBOURS_MOST];
	const int neighbours = neighbours_of(s, flat, neighbour);

	s->group_count = 0;
	s->tick++;
	group_add(s, flat);
	const double flat_area = s->flats->area[flat];
	size_t seeds;
	const idx_t *seed = flat_members(s, flat, &seeds);
	if (grow_hypothesis(&s->grower, &best.patch, PATCH_PLANE, seed, seeds, s->options->distance)) {
		best.area = grow_refine(&s->grower, &best.patch, seed, seeds);
		best.turn_limit = 0.95;
	}
	if (neighbours > 0) {
		const idx_t part = s->facets->smooth_part[seed[0]];
		const bool is_coarse = s->part_flats[part] < COARSE_FLATS && s->part_misses[part] < STRIP_MISSES_MOST;
		for (size_t want = 40; want >= 8; want /= 5)
			if (collect_ring(s, flat, want) >= 3) {
				double group_area = 0;
				for (size_t i = 0; i < s->group_count; i++)
					group_area += s->facets->area[s->group[i]];
				try_group(s, flat, want > 8 ? 0 : 1, &best);
				/* what grows so far beyond its origin is no accident */
				if (best.area > 4 * group_area)
					break;
			}
		/* a strip of facets: the seed with two neighbours; only when the rings found nothing better than the seed itself.
		 * Among many small facets rings of them are better */
		for (int i = 0; i < neighbours && is_coarse && best.area < 2.5 * flat_area; i++)
			for (int j = 0; j < i && best.area < 2.5 * flat_area; j++) {
				s->tick++;
				s->group_count = 0;
				group_add(s, flat);
				group_add(s, neighbour[i].flat);
				group_add(s, neighbour[j].flat);
				try_group(s, flat, 1, &best);
			}
	}
	extend_by_bend(s, flat, &best);
	if (best.area > 0 && best.patch.kind == PATCH_PLANE && !is_significant_plane(s, &best, neighbour, neighbours))
		best.area = 0;
	if (best.area < s->options->least_area)
		best.area = 0;
	return best;
}

static void cover(struct search *s, const idx_t *part, size_t count)
{
	for (size_t i = 0; i < count; i++)
		s->is_covered[part[i]] = 1;
}

/* Take proposals by area; one whose triangles went to others is regrown in the rest and waits its turn. Returns the area taken. */
static double accept(struct search *s, struct proposal *proposal, size_t count)
{
	double accepted = 0;
	while (count) {
		size_t most = 0;
		for (size_t i = 1; i < count; i++)
			if (is_better(&proposal[i], &proposal[most]))
				most = i;
		struct proposal p = proposal[most];
		size_t seeds;
		const idx_t *seed = flat_members(s, p.flat, &seeds);
		const double area = grow_region(&s->grower, &p.patch, seed, seeds, p.turn_limit);
		const bool is_sound = area > 0 && area >= s->options->least_area && (p.patch.kind == PATCH_PLANE || s->grower.flat_count >= 3);
		if (!is_sound || area < 0.3 * p.area) {
			proposal[most] = proposal[--count];
		} else if (area < 0.95 * p.area) {
			proposal[most].area = area;
		} else {
			const idx_t label = regions_add(s->regions, &p.patch);
			for (size_t i = 0; i < s->grower.region_count; i++)
				s->regions->label[s->grower.region[i]] = label;
			accepted += area;
			s->part_regions[s->facets->smooth_part[seed[0]]]++;
			proposal[most] = proposal[--count];
		}
	}
	return accepted;
}

struct seed_order {
	double key;
	idx_t flat;
};

static int compare_seeds(const void *left, const void *right)
{
	const struct seed_order *a = left, *b = right;
	if (a->key != b->key)
		return a->key > b->key ? -1 : 1;
	return (a->flat > b->flat) - (a->flat < b->flat);
}

/* Steps from the nearest sharp edge or taken triangle: seeds deep inside see one surface only. */
static void measure_depth(const struct search *s, int *depth, idx_t *queue)
{
	const struct facets *f = s->facets;
	size_t head = 0, tail = 0;
	for (size_t t = 0; t < f->triangle_count; t++) {
		depth[t] = -1;
		bool is_rim = false;
		for (int k = 0; k < 3; k++)
			is_rim = is_rim || f->is_sharp[3 * t + k] || s->regions->label[f->neighbour[3 * t + k]] != NO_INDEX;
		if (is_rim) {
			depth[t] = 0;
			queue[tail++] = (idx_t)t;
		}
	}
	while (head < tail) {
		const idx_t t = queue[head++];
		for (int k = 0; k < 3; k++) {
			const idx_t to = f->neighbour[3 * t + k];
			if (f->is_sharp[3 * t + k] || depth[to] >= 0)
				continue;
			depth[to] = depth[t] + 1;
			queue[tail++] = to;
		}
	}
	for (size_t t = 0; t < f->triangle_count; t++)
		depth[t] = depth[t] < 0 ? 8 : depth[t]; /* closed smooth part: no rim at all */
}

/* One round over what is left; returns the share of it that was taken. */
static double search_round(struct search *s)
{
	const struct facets *f = s->facets;
	const size_t n = s->flats->count;
	struct seed_order *order = mem_array(n, sizeof *order);
	int *depth = mem_array(f->triangle_count, sizeof *depth);
	idx_t *queue = mem_array(f->triangle_count, sizeof *queue);
	struct proposal *proposal = NULL;
	size_t proposals = 0, capacity = 0;
	measure_depth(s, depth, queue);
	for (size_t i = 0; i < n; i++) {
		const int d = depth[s->flats->member[s->flats->start[i]]];
		order[i] = (struct seed_order){s->flats->area[i] * (1 + d) * (1 + d), (idx_t)i};
	}
	qsort(order, n, sizeof *order, compare_seeds);
	memset(s->is_covered, 0, f->triangle_count);
	memset(s->part_area, 0, f->smooth_part_count * sizeof *s->part_area);
	for (size_t t = 0; t < f->triangle_count; t++)
		if (s->regions->label[t] == NO_INDEX)
			s->part_area[f->smooth_part[t]] += f->area[t];
	/* a noisy part that took so many surfaces is none of surfaces */
	for (size_t p = 0; p < f->smooth_part_count; p++)
		s->part_tries[p] = s->options->least_area > 0 && s->part_regions[p] > TRIES_MOST ? TRIES_MOST : 0;
	memset(s->part_misses, 0, f->smooth_part_count * sizeof *s->part_misses);
	for (size_t i = 0; i < n && s->grower.work < s->options->work_most; i++) {
		const idx_t flat = order[i].flat, first = s->flats->member[s->flats->start[flat]];
		int *misses = &s->part_misses[f->smooth_part[first]];
		if (s->is_covered[first] || !is_free_flat(s, flat) || *misses >= (s->part_hits[f->smooth_part[first]] ? MISSES_MOST : MISSES_AT_FIRST))
			continue;
		if (s->options->least_area > 0 && s->part_tries[f->smooth_part[first]]++ >= TRIES_MOST)
			continue;
		struct proposal p = propose(s, flat);
		const bool is_hit = p.area > MISS_SHARE * f->total_area;
		*misses = is_hit ? 0 : *misses + 1;
		s->part_hits[f->smooth_part[first]] += is_hit;
		if (!(p.area > 0)) {
			collect_ring(s, flat, 6);
			cover(s, s->group, s->group_count);
			continue;
		}
		size_t seeds;
		const idx_t *seed = flat_members(s, flat, &seeds);
		grow_region(&s->grower, &p.patch, seed, seeds, p.turn_limit);
		cover(s, s->grower.region, s->grower.region_count);
		s->is_covered[first] = 1;
		if (proposals == capacity) {
			capacity = capacity ? 2 * capacity : 64;
			proposal = mem_resize(proposal, capacity, sizeof *proposal);
		}
		proposal[proposals++] = p;
	}
	free(order);
	free(depth);
	free(queue);
	double left = 0;
	for (size_t p = 0; p < f->smooth_part_count; p++)
		left += s->part_area[p];
	const double accepted = accept(s, proposal, proposals);
	free(proposal);
	return left > 0 ? accepted / left : 0;
}

/* Whole smooth parts that are one surface: most faces of most parts. */
static void take_whole_parts(struct search *s)
{
	const struct facets *f = s->facets;
	size_t *start = mem_array(f->smooth_part_count + 2, sizeof *start);
	idx_t *member = mem_array(f->triangle_count, sizeof *member);
	for (size_t t = 0; t < f->triangle_count; t++)
		start[f->smooth_part[t] + 2]++;
	for (size_t i = 2; i < f->smooth_part_count + 2; i++)
		start[i] += start[i - 1];
	for (size_t t = 0; t < f->triangle_count; t++)
		member[start[f->smooth_part[t] + 1]++] = (idx_t)t;
	for (size_t i = 0; i < f->smooth_part_count; i++) {
		const idx_t *part = member + start[i];
		const size_t count = start[i + 1] - start[i];
		size_t largest = 0;
		if (s->regions->label[part[0]] != NO_INDEX)
			continue;
		for (size_t j = 0; j < count; j++) {
			if (f->area[part[j]] > f->area[part[largest]])
				largest = j;
		}
		struct proposal best = {.area = 0};
		bool is_whole = false;
		for (size_t k = 0; k < KINDS; k++) {
			struct proposal p = {.flat = s->flats->of[part[largest]]};
			if (!grow_hypothesis(&s->grower, &p.patch, simplest_first[k], part, count, s->options->distance))
				continue;
			size_t seeds;
			const idx_t *seed = flat_members(s, p.flat, &seeds);
			p.area = grow_refine(&s->grower, &p.patch, seed, seeds);
			p.mean_turn = s->grower.mean_turn;
			if (!is_better(&p, &best))
				continue;
			best = p;
			is_whole = s->grower.region_count == count;
			if (is_whole && best.patch.kind == PATCH_PLANE)
				break;
		}
		/* a better surface for nearly all goes before one for all: its rest will be absorbed */
		if (!is_whole)
			continue;
		const idx_t label = regions_add(s->regions, &best.patch);
		for (size_t j = 0; j < count; j++)
			s->regions->label[part[j]] = label;
	}
	free(start);
	free(member);
}

void primitive_search(struct regions *regions, const struct flats *flats, const struct search_options *options)
{
	const struct facets *f = regions->facets;
	struct search s = {.facets = f, .flats = flats, .options = options, .regions = regions};
	grower_init(&s.grower, f);
	s.grower.flats = flats;
	s.grower.owner = regions->label;
	s.grower.distance = options->distance;
	s.grower.angle = options->angle;
	s.is_covered = mem_array(f->triangle_count, 1);
	s.group = mem_array(f->triangle_count, sizeof *s.group);
	s.flat_stamp = mem_array(flats->count, sizeof *s.flat_stamp);
	s.part_flats = mem_array(f->smooth_part_count, sizeof *s.part_flats);
	s.part_area = mem_array(f->smooth_part_count, sizeof *s.part_area);
	s.part_tries = mem_array(f->smooth_part_count, sizeof *s.part_tries);
	s.part_regions = mem_array(f->smooth_part_count, sizeof *s.part_regions);
	s.part_hits = mem_array(f->smooth_part_count, sizeof *s.part_hits);
	s.part_misses = mem_array(f->smooth_part_count, sizeof *s.part_misses);
	for (size_t i = 0; i < flats->count; i++)
		s.part_flats[f->smooth_part[flats->member[flats->start[i]]]]++;
	take_whole_parts(&s);
	for (int round = 0; round < ROUNDS_MOST && s.grower.work < options->work_most; round++)
		if (search_round(&s) < LEAST_PROGRESS)
			break;
	grower_free(&s.grower);
	free(s.is_covered);
	free(s.group);
	free(s.flat_stamp);
	free(s.part_flats);
	free(s.part_area);
	free(s.part_tries);
	free(s.part_regions);
	free(s.part_hits);
	free(s.part_misses);
}
