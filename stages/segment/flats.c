/* Coplanar clusters of triangles. */
#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/flats.h"

struct by_area {
	double area;
	idx_t triangle;
};

static int compare_area(const void *left, const void *right)
{
	const struct by_area *a = left, *b = right;
	if (a->area != b->area)
		return a->area > b->area ? -1 : 1;
	return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

void flats_build(struct flats *flats, const struct facets *f, double distance, double angle)
{
	const size_t n = f->triangle_count;
	struct by_area *order = mem_array(n, sizeof *order);
	*flats = (struct flats){.of = mem_array(n, sizeof *flats->of), .start = mem_array(n + 1, sizeof *flats->start),
	                        .member = mem_array(n, sizeof *flats->member), .area = mem_array(n, sizeof *flats->area)};
	for (size_t t = 0; t < n; t++) {
		order[t] = (struct by_area){f->area[t], (idx_t)t};
		flats->of[t] = NO_INDEX;
	}
	qsort(order, n, sizeof *order, compare_area);
	const double least_dot = cos(angle);
	size_t tail = 0;
	for (size_t i = 0; i < n; i++) {
		const idx_t seed = order[i].triangle;
		if (flats->of[seed] != NO_INDEX)
			continue;
		const double *normal = f->normal + 3 * seed, *at = f->centroid + 3 * seed;
		size_t head = tail;
		flats->of[seed] = (idx_t)flats->count;
		flats->member[tail++] = seed;
		while (head < tail) {
			const idx_t t = flats->member[head++];
			flats->area[flats->count] += f->area[t];
			for (int k = 0; k < 3; k++) {
				const idx_t to = f->neighbour[3 * t + k];
				if (f->is_sharp[3 * t + k] || flats->of[to] != NO_INDEX)
					continue;
				/* slivers have no reliable normal: their vertices decide */
				bool is_in = f->height[to] < 20 * distance || dot3(normal, f->normal + 3 * to) >= least_dot;
				for (int c = 0; c < 3 && is_in; c++) {
					double d[3];
					sub3(d, f->xyz + 3 * f->triangle[3 * to + c], at);
					is_in = fabs(dot3(d, normal)) <= distance;
				}
				if (!is_in)
					continue;
				flats->of[to] = (idx_t)flats->count;
				flats->member[tail++] = to;
			}
		}
		flats->start[++flats->count] = tail;
	}
	free(order);
}

void flats_free(struct flats *flats)
{
	free(flats->of);
	free(flats->start);
	free(flats->member);
	free(flats->area);
	*flats = (struct flats){0};
}
