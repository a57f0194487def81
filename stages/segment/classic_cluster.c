/* The published segmentation, first half: k-means of principal curvatures and region growing. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/classic_cluster.h"

#define ITERATIONS_MOST 30
#define CLUSTERS_TRIED 8
#define ENOUGH_DISTORTION 0.05
#define ENOUGH_GAIN 0.15
#define FLAT_BEND 0.0174533     /* 1 degree */
#define DIRECTION_DOT 0.8660254 /* 30 degrees */

struct sample {
	double x[2], weight;
	idx_t triangle;
};

static double distance2(const double a[2], const double b[2])
{
	return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

/* Uniform in [0, 1) from a fixed sequence (Numerical Recipes' linear congruence). */
static double next_random(uint32_t *state)
{
	*state = *state * 1664525u + 1013904223u;
	return (double)(*state >> 8) / (1 << 24);
}

/* k-means++ seeds, then Lloyd; returns the distortion. of: cluster of each sample, from 0. */
static double k_means(unsigned char *of, const struct sample *sample, size_t count, int k)
{
	double centre[CLASSIC_CLUSTERS_MOST][2], *nearest = mem_array(count, sizeof *nearest), distortion = 0;
	uint32_t state = 1;
	double total = 0;
	for (size_t i = 0; i < count; i++)
		total += sample[i].weight;
	for (int c = 0; c < k; c++) {
		double sum = 0;
		for (size_t i = 0; i < count; i++)
			sum += c ? sample[i].weight * nearest[i] : sample[i].weight;
		double goal = next_random(&state) * sum;
		size_t pick = 0;
		while (pick + 1 < count && (goal -= c ? sample[pick].weight * nearest[pick] : sample[pick].weight) > 0)
			pick++;
		memcpy(centre[c], sample[pick].x, sizeof centre[c]);
		for (size_t i = 0; i < count; i++) {
			const double d = distance2(sample[i].x, centre[c]);
			nearest[i] = c ? fmin(nearest[i], d) : d;
		}
	}
	for (int iteration = 0; iteration < ITERATIONS_MOST; iteration++) {
		double sum[CLASSIC_CLUSTERS_MOST][3] = {{0}}, farthest = -1;
		size_t farthest_sample = 0;
		bool is_changed = iteration == 0;
		distortion = 0;
		for (size_t i = 0; i < count; i++) {
			int best = 0;
			double least = INFINITY;
			for (int c = 0; c < k; c++) {
				const double d = distance2(sample[i].x, centre[c]);
				if (d < least)
					least = d, best = c;
			}
			is_changed = is_changed || of[i] != best;
			of[i] = (unsigned char)best;
			distortion += sample[i].weight * least;
			if (least > farthest)
				farthest = least, farthest_sample = i;
			sum[best][0] += sample[i].weight * sample[i].x[0];
			sum[best][1] += sample[i].weight * sample[i].x[1];
			sum[best][2] += sample[i].weight;
		}
		if (!is_changed)
			break;
		for (int c = 0; c < k; c++) {
			if (sum[c][2] > 0) {
				centre[c][0] = sum[c][0] / sum[c][2];
				centre[c][1] = sum[c][1] / sum[c][2];
			} else {
				memcpy(centre[c], sample[farthest_sample].x, sizeof centre[c]);
			}
		}
	}
	free(nearest);
	return total > 0 ? distortion / total : 0;
}

int classic_cluster(unsigned char *cluster, const struct regions *r, const struct curvature_feature *feature, int clusters)
{
	const struct facets *f = r->facets;
	struct sample *sample = mem_array(f->triangle_count, sizeof *sample);
	unsigned char *of = mem_array(f->triangle_count, 1), *best_of = mem_array(f->triangle_count, 1);
	size_t count = 0;
	memset(cluster, 0, f->triangle_count);
	for (size_t t = 0; t < f->triangle_count; t++)
		if (r->label[t] == NO_INDEX && !feature->is_flat[t])
			sample[count++] = (struct sample){{feature->value[2 * t], feature->value[2 * t + 1]}, f->area[t], (idx_t)t};
	int k = 0;
	if (count) {
		const int low = clusters ? clusters : 1, high = clusters ? clusters : CLUSTERS_TRIED;
		double first = 0, before = 0;
		for (int tried = low; tried <= high; tried++) {
			const double distortion = k_means(of, sample, count, tried);
			if (tried == low)
				first = distortion;
			else if (before - distortion < ENOUGH_GAIN * before)
				break;
			memcpy(best_of, of, count);
			k = tried;
			before = distortion;
			if (distortion < ENOUGH_DISTORTION * first || distortion <= 0)
				break;
		}
		for (size_t i = 0; i < count; i++)
			cluster[sample[i].triangle] = (unsigned char)(best_of[i] + 1);
	}
	free(sample);
	free(of);
	free(best_of);
	return k;
}

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

void classic_grow(struct regions *r, const struct curvature_feature *feature, const unsigned char *cluster)
{
	const struct facets *f = r->facets;
	struct by_area *order = mem_array(f->triangle_count, sizeof *order);
	idx_t *queue = mem_array(f->triangle_count, sizeof *queue);
	const struct dense_patch free_patch = {.kind = PATCH_FREE};
	for (size_t t = 0; t < f->triangle_count; t++)
		order[t] = (struct by_area){f->area[t], (idx_t)t};
	qsort(order, f->triangle_count, sizeof *order, compare_area);
	for (size_t i = 0; i < f->triangle_count; i++) {
		const idx_t seed = order[i].triangle;
		if (r->label[seed] != NO_INDEX)
			continue;
		const idx_t label = regions_add(r, &free_patch);
		size_t head = 0, tail = 0;
		queue[tail++] = seed;
		r->label[seed] = label;
		while (head < tail) {
			const idx_t at = queue[head++];
			for (int k = 0; k < 3; k++) {
				const idx_t h = 3 * at + k, to = f->neighbour[h];
				if (f->is_sharp[h] || r->label[to] != NO_INDEX || cluster[to] != cluster[seed])
					continue;
				if (cluster[seed] == 0 && fabs(f->bend[h]) >= FLAT_BEND)
					continue;
				const double *d = feature->direction + 3 * at, *e = feature->direction + 3 * to;
				if (cluster[seed] && dot3(d, d) > 0 && dot3(e, e) > 0 && fabs(dot3(d, e)) < DIRECTION_DOT)
					continue;
				r->label[to] = label;
				queue[tail++] = to;
			}
		}
	}
	free(order);
	free(queue);
}
