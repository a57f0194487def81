#include "stages/deviate/creases.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/nearest.h"
#include "stages/geometry/vector.h"

struct side {
	uint64_t key;           /* lower vertex << 32 | higher */
	idx_t triangle;
};

static int compare_sides(const void *a, const void *b)
{
	const struct side *x = a, *y = b;
	if (x->key != y->key)
		return x->key < y->key ? -1 : 1;
	return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static void triangle_normal(double normal[3], const double *xyz, const idx_t *corner)
{
	area_vector3(normal, xyz + 3 * (size_t)corner[0], xyz + 3 * (size_t)corner[1], xyz + 3 * (size_t)corner[2]);
	normalise3(normal);
}

void creases_find(struct creases *creases, const double *xyz, const idx_t *triangle, size_t triangle_count, double sharp_deg)
{
	*creases = (struct creases){0};
	const size_t side_count = 3 * triangle_count;
	struct side *side = mem_array(side_count, sizeof *side);
	for (size_t c = 0; c < side_count; c++) {
		const uint64_t a = (uint64_t)triangle[c], b = (uint64_t)triangle[c % 3 == 2 ? c - 2 : c + 1];
		side[c] = (struct side){a < b ? a << 32 | b : b << 32 | a, (idx_t)(c / 3)};
	}
	qsort(side, side_count, sizeof *side, compare_sides);
	creases->vertex = mem_array(2 * side_count, sizeof *creases->vertex);
	for (size_t i = 0, j; i < side_count; i = j) {
		for (j = i + 1; j < side_count && side[j].key == side[i].key; j++)
			;
		if (j - i == 2) {
			double n1[3], n2[3];
			triangle_normal(n1, xyz, triangle + 3 * (size_t)side[i].triangle);
			triangle_normal(n2, xyz, triangle + 3 * (size_t)side[i + 1].triangle);
			if (angle3(n1, n2) * DEGREES <= sharp_deg)
				continue;
		}
		idx_t *end = creases->vertex + 2 * creases->count;
		end[0] = (idx_t)(side[i].key >> 32);
		end[1] = (idx_t)(side[i].key & 0xffffffffu);
		const double length = distance3(xyz + 3 * (size_t)end[0], xyz + 3 * (size_t)end[1]);
		if (length > 0) {
			creases->length += length;
			creases->count++;
		}
	}
	free(side);
}

void creases_free(struct creases *creases)
{
	free(creases->vertex);
	*creases = (struct creases){0};
}

static int compare_numbers(const void *a, const void *b)
{
	const double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

void creases_distance(struct crease_distance *out, const double *xyz, const struct creases *from, const double *to_xyz,
                      size_t to_vertex_count, const struct creases *to, size_t samples)
{
	/* A segment is a triangle whose third corner is its second. */
	idx_t *segment = mem_array(3 * to->count, sizeof *segment);
	for (size_t e = 0; e < to->count; e++) {
		segment[3 * e] = to->vertex[2 * e];
		segment[3 * e + 1] = segment[3 * e + 2] = to->vertex[2 * e + 1];
	}
	struct nearest *tree = nearest_new(to_xyz, to_vertex_count, segment, to->count);
	const size_t all = samples + 2 * from->count;
	double *point = mem_array(3 * all, sizeof *point), *distance = mem_array(all, sizeof *distance);
	size_t edge = 0;
	double below = 0, length = 0;
	for (size_t i = 0; i < samples; i++) { /* the middles of equal shares of the length */
		const double wanted = ((double)i + 0.5) / (double)samples * from->length;
		const double *a, *b;
		for (;; edge++) {
			a = xyz + 3 * (size_t)from->vertex[2 * edge];
			b = xyz + 3 * (size_t)from->vertex[2 * edge + 1];
			length = distance3(a, b);
			if (below + length > wanted || edge + 1 == from->count)
				break;
			below += length;
		}
		const double u = fmin(1, (wanted - below) / length);
		for (int k = 0; k < 3; k++)
			point[3 * i + k] = (1 - u) * a[k] + u * b[k];
	}
	for (size_t i = 0; i < 2 * from->count; i++)
		copy3(point + 3 * (samples + i), xyz + 3 * (size_t)from->vertex[i]);
#pragma omp parallel for schedule(dynamic, 256)
	for (size_t i = 0; i < all; i++)
		distance[i] = nearest_point(tree, point + 3 * i, INFINITY, NULL).distance;
	*out = (struct crease_distance){0};
	size_t worst = 0;
	for (size_t i = 1; i < all; i++)
		if (distance[i] > distance[worst])
			worst = i;
	out->max = distance[worst];
	copy3(out->worst, point + 3 * worst);
	const double scale = out->max > 0 ? out->max : 1;
	for (size_t i = 0; i < samples; i++) {
		out->mean += distance[i] / scale;
		out->rms += distance[i] / scale * (distance[i] / scale);
	}
	out->mean *= scale / (double)samples;
	out->rms = sqrt(out->rms / (double)samples) * scale;
	qsort(distance, samples, sizeof *distance, compare_numbers);
	out->p99 = distance[(99 * samples + 99) / 100 - 1];
	nearest_free(tree);
	free(segment);
	free(point);
	free(distance);
}
