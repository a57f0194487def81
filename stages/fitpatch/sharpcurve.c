/* Distance of sharp edges to their curves. */
#include "stages/fitpatch/sharpcurve.h"

#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/geometry/curve.h"
#include "stages/geometry/vector.h"

/* Straight pieces of a curve between two control points, and points of a chain that are looked at. */
enum { PIECES = 8, MOST_PLACES = 200 };
static const double share = 0.99;

struct place {
	double distance, length;
};

static int compare_places(const void *a, const void *b)
{
	const struct place *x = a, *y = b;
	if (x->distance != y->distance)
		return x->distance < y->distance ? -1 : 1;
	return (x->length > y->length) - (x->length < y->length);
}

/* The curve as a polyline: between points that are corners each stretch is a curve of its own. Returns its points. */
static size_t draw_curve(double *line, const struct draft *draft, const struct curve *curve)
{
	const idx_t *point = &draft->network.point[curve->first];
	double *control = mem_array(3 * (curve->count + 1), sizeof *control);
	size_t corner = 0, drawn = 0;
	if (curve->closed) /* from a corner on, if there is one */
		while (corner < curve->count && draft->control.role[point[corner]] != POINT_CORNER)
			corner++;
	const bool around = curve->closed && corner == curve->count;
	const size_t total = curve->closed && !around ? curve->count + 1 : curve->count;
	for (size_t i = 0, count = 0; i < total; i++) {
		const idx_t p = point[(i + (curve->closed && !around ? corner : 0)) % curve->count];
		copy3(&control[3 * count++], &draft->control.xyz[3 * (size_t)p]);
		const bool ends = i + 1 == total || (!around && i > 0 && draft->control.role[p] == POINT_CORNER);
		if (!ends)
			continue;
		const size_t spans = around ? count : count - 1;
		for (size_t k = 0; k <= spans * PIECES; k++, drawn++)
			curve_point(&line[3 * drawn], control, count, around, fmin((double)k / PIECES, (double)spans * (1 - 1e-12)));
		if (!around)
			copy3(&line[3 * (drawn - 1)], &control[3 * (count - 1)]), copy3(control, &control[3 * (count - 1)]);
		count = 1;
	}
	free(control);
	return drawn;
}

static double distance_to_line(const double *line, size_t count, const double p[3])
{
	double least = INFINITY;
	for (size_t i = 0; i + 1 < count; i++) {
		double along[3], offset[3];
		sub3(along, &line[3 * (i + 1)], &line[3 * i]);
		sub3(offset, p, &line[3 * i]);
		const double squared = dot3(along, along), t = squared > 0 ? fmin(fmax(dot3(offset, along) / squared, 0), 1) : 0;
		add_scaled3(offset, -t, along);
		least = fmin(least, dot3(offset, offset));
	}
	return sqrt(least);
}

double sharpcurve_distance(const struct draft *draft, const struct target *target, const idx_t *chain_of_curve)
{
	const struct border_network *border = target->border;
	const double *xyz = target->dense->xyz;
	size_t most = 2, places = 0;
	for (size_t k = 0; k < draft->network.curve_count; k++)
		most = draft->network.curve[k].count > most ? draft->network.curve[k].count : most;
	/* every control point may begin a stretch */
	double *line = mem_array(3 * (most + 2) * (PIECES + 2), sizeof *line);
	struct place *place = mem_array(draft->network.curve_count * (MOST_PLACES + 1), sizeof *place);
	double sum = 0;
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		const struct border_chain *chain = &border->chain[chain_of_curve[k]];
		const struct curve *curve = &draft->network.curve[k];
		if (chain->kind == CURVE_SMOOTH || curve->count < 2)
			continue;
		const size_t count = draw_curve(line, draft, curve), sides = chain->count - !chain->closed;
		const size_t stride = sides / MOST_PLACES + 1;
		for (size_t i = 0; i < sides; i += stride) { /* the middles of sides stand for the ones around */
			const double *a = &xyz[3 * (size_t)border->vertex[chain->first + i]], *b = &xyz[3 * (size_t)border->vertex[chain->first + (i + 1) % chain->count]];
			const double middle[3] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
			place[places] = (struct place){distance_to_line(line, count, middle), distance3(a, b) * (double)stride};
			sum += place[places++].length;
		}
	}
	qsort(place, places, sizeof *place, compare_places);
	double length = 0, distance = 0;
	for (size_t i = 0; i < places && length < share * sum; i++)
		length += place[i].length, distance = place[i].distance;
	free(line), free(place);
	return distance;
}
