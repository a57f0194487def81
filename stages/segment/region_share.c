/* Facets of curved surfaces that search took for planes.
 *
 * A coarse pipe that goes straight over into a bend has facets that are flat across the seam: coplanar with their like of the
 * other surface, so that neither surface takes the flat whole. What explains every triangle of such a plane is its
 * neighbours, none of whose surfaces turns more under them than under its own facets. */
#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/segment/primitive_grow.h"
#include "stages/segment/region_tidy.h"

#define SHARERS_MOST 8
#define TURN_SLACK 1.1

static bool is_curved(const struct dense_patch *patch)
{
	return patch->kind != PATCH_PLANE && patch->kind != PATCH_FREE;
}

/* The largest turn of the surface under its own triangles. */
static double largest_turn(struct grower *g, const struct dense_patch *patch, const idx_t *part, size_t count)
{
	double most = 0, turn;
	grow_begin(g);
	for (size_t i = 0; i < count; i++)
		if (grow_explains(g, patch, part[i], 2, &turn))
			most = fmax(most, turn);
	return most;
}

/* Which of the sharers takes each triangle; false when one is left over. */
static bool share_out(struct grower *g, idx_t *taker, const struct regions *r, const idx_t *part, size_t count, const idx_t *sharer,
                      const double *turn, int sharers)
{
	const struct facets *f = g->facets;
	double *least = mem_array(count, sizeof *least);
	size_t taken = 0;
	for (size_t i = 0; i < count; i++)
		taker[i] = NO_INDEX;
	for (int s = 0; s < sharers; s++) {
		const struct dense_patch *patch = &r->patch[sharer[s]];
		grow_begin(g);
		for (size_t i = 0; i < count; i++) {
			if (!grow_explains(g, patch, part[i], TURN_SLACK * turn[s], NULL))
				continue;
			double off = 0;
			for (int k = 0; k < 3; k++)
				off = fmax(off, fabs(primitive_distance(patch, f->xyz + 3 * f->triangle[3 * part[i] + k])));
			taken += taker[i] == NO_INDEX;
			if (taker[i] == NO_INDEX || off < least[i]) {
				taker[i] = sharer[s];
				least[i] = off;
			}
		}
	}
	free(least);
	return taken == count;
}

size_t tidy_share_flats(struct regions *r, const struct flats *flats, const struct tidy_options *o)
{
	const struct facets *f = r->facets;
	struct grower g;
	size_t *start, shared = 0;
	idx_t *member;
	grower_init(&g, f);
	g.flats = flats;
	g.distance = o->distance;
	g.angle = o->angle;
	regions_members(r, &start, &member);
	idx_t *taker = mem_array(f->triangle_count, sizeof *taker);
	double *largest = mem_array(r->count, sizeof *largest);
	for (size_t i = 0; i < r->count; i++)
		largest[i] = -1;
	for (size_t i = 0; i < r->count; i++) {
		const idx_t *part = member + start[i];
		const size_t count = start[i + 1] - start[i];
		idx_t sharer[SHARERS_MOST];
		double turn[SHARERS_MOST];
		int sharers = 0;
		bool is_facet = count > 0 && r->patch[i].kind == PATCH_PLANE;
		for (size_t j = 0; j < count && is_facet; j++) {
			is_facet = flats->of[part[j]] == flats->of[part[0]];
			for (int k = 0; k < 3 && is_facet; k++) {
				const size_t h = 3 * (size_t)part[j] + k;
				if (f->is_sharp[h])
					continue;
				const idx_t to = r->label[f->neighbour[h]];
				int s = 0;
				while (s < sharers && sharer[s] != to)
					s++;
				if (s == sharers && sharers < SHARERS_MOST && is_curved(&r->patch[to]))
					sharer[sharers++] = to;
			}
		}
		if (!is_facet || sharers == 0)
			continue;
		for (int s = 0; s < sharers; s++) {
			const idx_t a = sharer[s];
			if (largest[a] < 0)
				largest[a] = largest_turn(&g, &r->patch[a], member + start[a], start[a + 1] - start[a]);
			turn[s] = largest[a];
		}
		if (!share_out(&g, taker, r, part, count, sharer, turn, sharers))
			continue;
		for (size_t j = 0; j < count; j++)
			r->label[part[j]] = taker[j];
		shared++;
	}
	free(start);
	free(member);
	free(taker);
	free(largest);
	grower_free(&g);
	return shared;
}
