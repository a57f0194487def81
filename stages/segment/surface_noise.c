/* How far the vertices of a mesh lie off smooth surfaces: local fits at places spread evenly over the area. */
#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/segment/primitive_grow.h"
#include "stages/segment/surface_noise.h"

#define PLACES 240
#define NEIGHBOURHOOD 60  /* triangles: about 40 vertices against at most 7 parameters */
#define QUANTILE 0.4

static int compare_doubles(const void *left, const void *right)
{
	const double a = *(const double *)left, b = *(const double *)right;
	return (a > b) - (a < b);
}

/* Triangles around t, not across sharp edges, breadth first. */
static size_t neighbourhood(const struct facets *f, idx_t t, idx_t *part)
{
	size_t head = 0, tail = 0;
	part[tail++] = t;
	while (head < tail && tail < NEIGHBOURHOOD) {
		const idx_t at = part[head++];
		for (int k = 0; k < 3 && tail < NEIGHBOURHOOD; k++) {
			const idx_t to = f->neighbour[3 * at + k];
			if (f->is_sharp[3 * at + k])
				continue;
			size_t i = 0;
			while (i < tail && part[i] != to)
				i++;
			if (i == tail)
				part[tail++] = to;
		}
	}
	return tail;
}

double surface_noise(const struct facets *f)
{
	static const enum patch_kind kind[] = {PATCH_PLANE, PATCH_SPHERE, PATCH_CYLINDER, PATCH_CONE, PATCH_TORUS};
	struct grower g;
	double *noise = mem_array(PLACES + 1, sizeof *noise);
	size_t places = 0;
	idx_t part[NEIGHBOURHOOD];
	grower_init(&g, f);
	double passed = 0;
	const double step = f->total_area / PLACES;
	for (size_t t = 0; t < f->triangle_count && places < PLACES; t++) {
		passed += f->area[t];
		if (passed < ((double)places + 0.5) * step)
			continue;
		const size_t count = neighbourhood(f, (idx_t)t, part);
		double best = INFINITY;
		for (int k = 0; k < 5; k++) {
			struct dense_patch patch = {0};
			double rms;
			if (!grow_hypothesis(&g, &patch, kind[k], part, count, INFINITY))
				continue;
			rms = grow_rms(f, &patch, part, count);
			best = fmin(best, rms);
		}
		/* a large triangle stands for many places */
		while (places < PLACES && passed >= ((double)places + 0.5) * step)
			noise[places++] = best;
	}
	grower_free(&g);
	qsort(noise, places, sizeof *noise, compare_doubles);
	const double result = places ? noise[(size_t)(QUANTILE * (double)places)] : 0;
	free(noise);
	return isfinite(result) ? result : 0;
}
