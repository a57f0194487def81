/* Anchoring control points to mesh borders. */
#include "stages/fitpatch/anchor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/curve.h"
#include "stages/geometry/vector.h"

/* Two anchors on a segment stay this far apart, as a share of it: triangles between them must not vanish. */
static const double least_gap = 0.05;

/* The half-edge a -> b, or NO_INDEX. */
static idx_t find_half(const struct half *half, idx_t a, idx_t b)
{
	const idx_t start = half->outgoing[a];
	if (start == NO_INDEX)
		return NO_INDEX;
	idx_t h = start;
	do {
		if (half->origin[half->next[h]] == b)
			return h;
		const idx_t back = half->previous[h];
		h = half->twin[back];
	} while (h != NO_INDEX && h != start);
	return NO_INDEX;
}

static void mark_halves(struct anchors *anchors, const struct half *half, const struct border_network *border)
{
	anchors->half_chain = mem_array(half->half_count, sizeof *anchors->half_chain);
	anchors->half_segment = mem_array(half->half_count, sizeof *anchors->half_segment);
	memset(anchors->half_chain, 0xff, half->half_count * sizeof *anchors->half_chain);
	for (size_t c = 0; c < border->chain_count; c++) {
		const struct border_chain *chain = &border->chain[c];
		const idx_t *vertex = &border->vertex[chain->first];
		const size_t segments = chain->closed ? chain->count : chain->count - 1;
		for (size_t s = 0; s < segments; s++) {
			const idx_t a = vertex[s], b = vertex[(s + 1) % chain->count];
			const idx_t forward = find_half(half, a, b), backward = find_half(half, b, a);
			if (forward != NO_INDEX)
				anchors->half_chain[forward] = (idx_t)c, anchors->half_segment[forward] = (idx_t)s;
			if (backward != NO_INDEX)
				anchors->half_chain[backward] = (idx_t)c, anchors->half_segment[backward] = -1 - (idx_t)s;
		}
	}
}

/* The polyline of a chain. */
struct line {
	const double *xyz;
	const idx_t *vertex;
	size_t vertices, segments;
};

static double nearest_along(const struct line *line, const double p[3], double low, double high)
{
	double best = low, best_distance = INFINITY;
	for (size_t s = (size_t)low; s < line->segments && (double)s < high; s++) {
		const double *a = &line->xyz[3 * (size_t)line->vertex[s]], *b = &line->xyz[3 * (size_t)line->vertex[(s + 1) % line->vertices]];
		double ab[3], ap[3];
		sub3(ab, b, a);
		sub3(ap, p, a);
		const double squared = dot3(ab, ab);
		double t = squared > 0 ? dot3(ap, ab) / squared : 0;
		t = fmin(fmax(t, 0), 1);
		t = fmin(fmax((double)s + t, low), high) - (double)s;
		double foot[3];
		copy3(foot, a);
		add_scaled3(foot, t, ab);
		const double distance = distance3(foot, p);
		if (distance < best_distance)
			best_distance = distance, best = (double)s + t;
	}
	return best;
}

/* Least change of value[count] that makes every value at least gap larger than the one before: pool adjacent violators on
 * value - i gap (isotonic regression; Barlow and Brunk 1972). weight is scratch of count + count. */
static void put_in_order(double *value, size_t count, double gap, double *scratch)
{
	double *mean = scratch, *size = scratch + count;
	size_t blocks = 0;
	for (size_t i = 0; i < count; i++) {
		mean[blocks] = value[i] - (double)i * gap, size[blocks++] = 1;
		while (blocks > 1 && mean[blocks - 1] < mean[blocks - 2]) {
			const double both = size[blocks - 1] + size[blocks - 2];
			mean[blocks - 2] = (mean[blocks - 1] * size[blocks - 1] + mean[blocks - 2] * size[blocks - 2]) / both;
			size[blocks-- - 2] = both;
		}
	}
	size_t i = 0;
	for (size_t b = 0; b < blocks; b++)
		for (double k = 0; k < size[b]; k++, i++)
			value[i] = mean[b] + (double)i * gap;
}

/* Places of the inner points along the line, in [0, segments), rising (closed: from some point on, once around). */
static void place_points(double *along, size_t count, const struct line *line, const double *points, size_t point_count, bool closed, bool forward)
{
	const double length = (double)line->segments, gap = fmin(least_gap, 0.5 * length / (double)(count + 1));
	for (size_t i = 0; i < count; i++) {
		const size_t at = closed ? i : i + 1;
		double limit[3];
		curve_limit(limit, points, point_count, closed, forward ? at : point_count - 1 - at);
		along[i] = nearest_along(line, limit, 0, length);
		/* Around a closed line the shorter way from the point before. */
		if (closed && i > 0)
			along[i] += length * round((along[i - 1] - along[i]) / length);
	}
	double *scratch = mem_array(2 * count, sizeof *scratch);
	put_in_order(along, count, gap, scratch);
	free(scratch);
	const double low = closed ? along[0] : gap, high = closed ? along[0] + length - gap : length - gap;
	for (size_t i = 0; i < count; i++) { /* room for those before and after */
		along[i] = fmax(along[i], low + (double)i * gap);
		along[i] = fmin(along[i], high - (double)(count - 1 - i) * gap);
	}
	for (size_t i = 0; closed && i < count; i++)
		along[i] -= length * floor(along[i] / length);
}

static int compare_anchors(const void *a, const void *b)
{
	const struct anchor *x = a, *y = b;
	return x->along != y->along ? (x->along < y->along ? -1 : 1) : (x->point > y->point) - (x->point < y->point);
}

void anchors_place(struct anchors *anchors, const struct dense *dense, const struct half *half, const struct border_network *border,
                   const struct network *network, const idx_t *chain_of_curve)
{
	*anchors = (struct anchors){0};
	mark_halves(anchors, half, border);
	anchors->first = mem_array(border->chain_count + 1, sizeof *anchors->first);
	anchors->anchor = mem_array(network->point_count, sizeof *anchors->anchor);
	idx_t *curve_of_chain = mem_array(border->chain_count, sizeof *curve_of_chain);
	memset(curve_of_chain, 0xff, border->chain_count * sizeof *curve_of_chain);
	for (size_t k = network->curve_count; k-- > 0;)
		if (chain_of_curve[k] != NO_INDEX)
			curve_of_chain[chain_of_curve[k]] = (idx_t)k;
	size_t used = 0;
	for (size_t c = 0; c < border->chain_count; c++) {
		anchors->first[c] = used;
		if (curve_of_chain[c] == NO_INDEX)
			continue;
		const struct curve *curve = &network->curve[curve_of_chain[c]];
		const struct border_chain *chain = &border->chain[c];
		const struct line line = {dense->xyz, &border->vertex[chain->first], chain->count, chain->closed ? chain->count : chain->count - 1};
		const idx_t *point = &network->point[curve->first];
		double *points = mem_array(3 * curve->count, sizeof *points);
		for (size_t i = 0; i < curve->count; i++)
			copy3(&points[3 * i], &network->xyz[3 * (size_t)point[i]]);
		const bool forward = curve->left == chain->left;
		const size_t inner = curve->closed ? curve->count : curve->count - 2;
		double *along = mem_array(inner, sizeof *along);
		if (inner > 0)
			place_points(along, inner, &line, points, curve->count, curve->closed, forward);
		if (!curve->closed) {
			anchors->anchor[used++] = (struct anchor){0, point[forward ? 0 : curve->count - 1]};
			anchors->anchor[used++] = (struct anchor){(double)line.segments, point[forward ? curve->count - 1 : 0]};
		}
		for (size_t i = 0; i < inner; i++) {
			const size_t at = curve->closed ? i : i + 1;
			double snapped = along[i];
			/* A vertex that is close is taken as it is: no needless split. */
			if (fabs(snapped - round(snapped)) < least_gap / 2 && (curve->closed || (round(snapped) > 0 && round(snapped) < (double)line.segments)))
				snapped = round(snapped);
			if (curve->closed && snapped >= (double)line.segments)
				snapped = 0;
			anchors->anchor[used++] = (struct anchor){snapped, point[forward ? at : curve->count - 1 - at]};
		}
		qsort(&anchors->anchor[anchors->first[c]], used - anchors->first[c], sizeof *anchors->anchor, compare_anchors);
		/* Snapping may have put two on one vertex: part them again. */
		for (size_t i = anchors->first[c] + 1; i < used; i++)
			if (anchors->anchor[i].along <= anchors->anchor[i - 1].along)
				anchors->anchor[i].along = anchors->anchor[i - 1].along + least_gap / 4;
		free(points), free(along);
	}
	anchors->first[border->chain_count] = used;
	free(curve_of_chain);
}

void anchors_free(struct anchors *anchors)
{
	free(anchors->first), free(anchors->anchor), free(anchors->half_chain), free(anchors->half_segment);
	*anchors = (struct anchors){0};
}

size_t anchors_apply(struct sheet *sheet, const struct anchors *anchors, const struct dense *dense)
{
	for (size_t g = 0; g < 3 * sheet->triangle_count; g++) { /* the count grows: a split moves the other border side of an ear */
		idx_t h = (idx_t)g;
		if (sheet->twin[h] != NO_INDEX || sheet->segment[h] == NO_INDEX)
			continue;
		const idx_t dense_half = sheet->segment[h], c = anchors->half_chain[dense_half];
		if (c == NO_INDEX)
			continue;
		const bool forward = anchors->half_segment[dense_half] >= 0;
		const double low = (double)(forward ? anchors->half_segment[dense_half] : -1 - anchors->half_segment[dense_half]), high = low + 1;
		const double *from = &dense->xyz[3 * (size_t)dense->triangle[dense_half]];
		const double *to = &dense->xyz[3 * (size_t)dense->triangle[sheet_next(dense_half)]];
		const size_t count = anchors->first[c + 1] - anchors->first[c];
		const struct anchor *list = &anchors->anchor[anchors->first[c]];
		/* Vertices first, by the ends of the whole half-edge; then the points inside it, in its direction. */
		for (size_t i = 0; i < count; i++) {
			if (list[i].along == low)
				sheet->point[forward ? sheet->origin[h] : sheet_target(sheet, h)] = list[i].point;
			if (list[i].along == high)
				sheet->point[forward ? sheet_target(sheet, h) : sheet->origin[h]] = list[i].point;
		}
		sheet->segment[h] = NO_INDEX; /* done: its parts must not be looked at again */
		for (size_t n = 0; n < count; n++) {
			const struct anchor *a = &list[forward ? n : count - 1 - n];
			if (!(a->along > low && a->along < high))
				continue;
			const double t = forward ? a->along - low : high - a->along;
			double xyz[3];
			for (int k = 0; k < 3; k++)
				xyz[k] = from[k] + t * (to[k] - from[k]);
			const idx_t q = sheet_split_border(sheet, h, xyz);
			sheet->point[q] = a->point;
			h = sheet->outgoing[q];
		}
	}
	/* Closed chains: an anchor at 0 sits at the seam vertex, which is also the end of the last segment: found above by low.
	 * Now the loops. */
	size_t least = SIZE_MAX;
	unsigned char *seen = mem_array(3 * sheet->triangle_count, 1);
	for (size_t g = 0; g < 3 * sheet->triangle_count; g++) {
		if (sheet->twin[g] != NO_INDEX || seen[g])
			continue;
		size_t points = 0;
		idx_t previous = NO_INDEX, first = NO_INDEX, first_vertex = NO_INDEX;
		idx_t h = (idx_t)g;
		do {
			seen[h] = 1;
			const idx_t v = sheet->origin[h];
			if (sheet->point[v] != NO_INDEX) {
				if (sheet->point[v] == previous) {
					sheet->point[v] = NO_INDEX;
				} else {
					previous = sheet->point[v];
					points++;
					if (first == NO_INDEX)
						first = previous, first_vertex = v;
				}
			}
			h = sheet_next(h);
			while (sheet->twin[h] != NO_INDEX)
				h = sheet_next(sheet->twin[h]);
		} while (h != (idx_t)g);
		if (points > 1 && previous == first) { /* the loop closes on the same point */
			sheet->point[first_vertex] = NO_INDEX;
			points--;
		}
		least = points < least ? points : least;
	}
	free(seen);
	return least;
}
