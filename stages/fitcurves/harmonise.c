/* Opposite curves: classes by union-find, the largest count of each class, knots copied along. */
#include "stages/fitcurves/harmonise.h"

#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"

/* Places compared when two loops are aligned, and offsets tried. */
#define PLACES 48
#define OFFSETS 192
/* Loops whose shapes differ by more than this share of their radius are not opposite. */
#define MOST_RESIDUAL 0.2
/* A curve is not raised to more than this many times its own inner points. */
#define MOST_RAISE 2
/* A copied fit may be this much worse than allowed before the knots are spread anew. */
#define COPY_RATIO 1.0
/* Planes take polygons of any size, so their borders may differ, unless these run so close that the control polygons of one
 * would cut the other's: rings whose loops differ by less than this in length, strips narrower than this share of theirs. A
 * circle of 4 points has them at 1.5 radii. */
#define RING_RATIO 0.8
#define STRIP_RATIO 0.25

static void centre_and_radius(double centre[3], double *radius, const double *place)
{
	centre[0] = centre[1] = centre[2] = 0;
	for (size_t i = 0; i < PLACES; i++)
		add_scaled3(centre, 1.0 / PLACES, place + 3 * i);
	*radius = 0;
	for (size_t i = 0; i < PLACES; i++)
		*radius += distance3(centre, place + 3 * i) / PLACES;
}

double harmonise_offset(const struct polyline *a, const struct polyline *b, bool same_way, double *residual)
{
	double pa[3 * PLACES], pb[3 * OFFSETS], coarse[3 * PLACES], ca[3], cb[3], ra, rb;
	for (size_t i = 0; i < PLACES; i++) {
		polyline_at(pa + 3 * i, a, a->length * (double)i / PLACES);
		polyline_at(coarse + 3 * i, b, b->length * (double)i / PLACES);
	}
	for (size_t i = 0; i < OFFSETS; i++)
		polyline_at(pb + 3 * i, b, b->length * (double)i / OFFSETS);
	centre_and_radius(ca, &ra, pa);
	centre_and_radius(cb, &rb, coarse);
	double cost[OFFSETS];
	size_t best = 0;
	for (size_t o = 0; o < OFFSETS; o++) {
		cost[o] = 0;
		for (size_t i = 0; i < PLACES; i++) {
			const size_t step = i * (OFFSETS / PLACES);
			const double *q = pb + 3 * ((same_way ? o + step : o + OFFSETS - step) % OFFSETS);
			for (size_t k = 0; k < 3; k++) {
				const double d = (pa[3 * i + k] - ca[k]) / ra - (q[k] - cb[k]) / rb;
				cost[o] += d * d / PLACES;
			}
		}
		if (cost[o] < cost[best])
			best = o;
	}
	*residual = sqrt(cost[best]);
	/* vertex of the parabola through the best offset and its neighbours */
	const double before = cost[(best + OFFSETS - 1) % OFFSETS], after = cost[(best + 1) % OFFSETS],
		     bend = before + after - 2 * cost[best];
	double offset = (double)best + (bend > 0 ? fmin(fmax((before - after) / (2 * bend), -0.5), 0.5) : 0);
	if (offset < 0)
		offset += OFFSETS;
	return offset * b->length / OFFSETS;
}

/* One relation: the second curve looks like the first, or like its reverse. */
struct opposite {
	size_t a, b;
	bool same_way;
};

struct relations {
	struct opposite *item;
	size_t count, room;
};

static void relate(struct relations *relations, const struct curvefit *fit, const struct polyline *line, size_t a, size_t b,
		   bool same_way)
{
	if (a == b || !(line[a].length > 0) || !(line[b].length > 0) || fit[a].closed != fit[b].closed)
		return;
	if (relations->count == relations->room)
		relations->item =
			mem_resize(relations->item, relations->room = 2 * relations->room + 16, sizeof *relations->item);
	relations->item[relations->count++] = (struct opposite){a, b, same_way};
}

/* Open curves are raised only where it costs little. */
static bool is_cheap(const struct curvefit *fit, size_t a, size_t b)
{
	const size_t p = fit[a].count - 2, q = fit[b].count - 2, low = p < q ? p : q, high = p < q ? q : p;
	return high <= MOST_RAISE * low;
}

static double loop_length(const struct polyline *line, const struct side *side, size_t count)
{
	double length = 0;
	for (size_t i = 0; i < count; i++)
		length += line[side[i].chain].length;
	return length;
}

/* Do two opposite curves run close to each other for their length? */
static bool is_strip(const struct polyline *a, const struct polyline *b)
{
	double p[3], q[3];
	polyline_at(p, a, a->length / 2);
	polyline_at(q, b, b->length / 2);
	return distance3(p, q) < STRIP_RATIO * fmax(a->length, b->length);
}

/* Opposite curves of one patch: two closed loops; two loops of equally many curves; four curves around. */
static void relate_patch(struct relations *relations, const struct curvefit *fit, const struct polyline *line,
			 const struct patchloops *loops, size_t patch, bool is_plane)
{
	const size_t first = loops->first_loop[patch], count = loops->first_loop[patch + 1] - first;
	for (size_t l = first; l < first + count; l++)
		if (loops->touches_itself[l])
			return;
	if (count == 0 || count > 2)
		return;
	const struct side *s = loops->side + loops->first_side[first];
	const size_t n = loops->first_side[first + 1] - loops->first_side[first];
	if (count == 1) {
		for (size_t i = 0; n == 4 && i < 2; i++)
			if (!line[s[i].chain].closed && is_cheap(fit, (size_t)s[i].chain, (size_t)s[i + 2].chain) &&
			    (!is_plane || is_strip(line + s[i].chain, line + s[i + 2].chain)))
				relate(relations, fit, line, (size_t)s[i].chain, (size_t)s[i + 2].chain,
				       s[i].reversed != s[i + 2].reversed);
		return;
	}
	const struct side *t = loops->side + loops->first_side[first + 1];
	const size_t m = loops->first_side[first + 2] - loops->first_side[first + 1];
	if (n != m)
		return;
	const double a_length = loop_length(line, s, n), b_length = loop_length(line, t, m);
	if (is_plane && fmin(a_length, b_length) < RING_RATIO * fmax(a_length, b_length))
		return;
	if (line[s[0].chain].closed && line[t[0].chain].closed) {
		if (!(line[s[0].chain].length > 0) || !(line[t[0].chain].length > 0))
			return;
		double residual;
		const bool same_way = s[0].reversed != t[0].reversed; /* around a band its two borders run against each other */
		harmonise_offset(line + s[0].chain, line + t[0].chain, same_way, &residual);
		if (residual <= MOST_RESIDUAL)
			relate(relations, fit, line, (size_t)s[0].chain, (size_t)t[0].chain, same_way);
		return;
	}
	if (line[s[0].chain].closed || line[t[0].chain].closed)
		return;
	/* Nodes matched by the turn around the band that brings them closest. */
	size_t best = 0;
	double least = INFINITY;
	for (size_t turn = 0; turn < n; turn++) {
		double cost = 0;
		for (size_t i = 0; i < n; i++) {
			const struct polyline *a = line + s[i].chain, *b = line + t[(turn + n - i) % n].chain;
			double p[3], q[3];
			polyline_at(p, a, a->length / 2);
			polyline_at(q, b, b->length / 2);
			cost += distance3(p, q);
		}
		if (cost < least)
			least = cost, best = turn;
	}
	for (size_t i = 0; i < n; i++) {
		const struct side u = s[i], v = t[(best + n - i) % n];
		if (is_cheap(fit, (size_t)u.chain, (size_t)v.chain))
			relate(relations, fit, line, (size_t)u.chain, (size_t)v.chain, u.reversed != v.reversed);
	}
}

static int compare_doubles(const void *a, const void *b)
{
	const double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* Fit b with the knots of a carried over. */
static void copy_knots(struct curvefit *b, const struct polyline *line_b, struct curvefit_options options,
		       const struct curvefit *a, const struct polyline *line_a, bool same_way)
{
	const size_t n = a->count;
	double *arc = mem_array(n, sizeof *arc);
	const double scale = line_b->length / line_a->length;
	if (line_b->closed) {
		double residual;
		const double offset = harmonise_offset(line_a, line_b, same_way, &residual);
		for (size_t i = 0; i < n; i++) {
			arc[i] = fmod(offset + (same_way ? 1 : -1) * scale * a->arc[i], line_b->length);
			if (arc[i] < 0)
				arc[i] += line_b->length;
		}
		qsort(arc, n, sizeof *arc, compare_doubles);
	} else {
		for (size_t i = 0; i < n; i++)
			arc[same_way ? i : n - 1 - i] = same_way ? scale * a->arc[i] : line_b->length - scale * a->arc[i];
		arc[0] = 0, arc[n - 1] = line_b->length;
	}
	bool ordered = true;
	for (size_t i = 1; i < n; i++)
		ordered &= arc[i] > arc[i - 1];
	struct curvefit copy = {0};
	if (ordered)
		curvefit_from(&copy, line_b, options, arc, n);
	if (!ordered || (copy.ratio > COPY_RATIO && copy.ratio > b->ratio)) {
		curvefit_free(&copy);
		if (b->count < n)
			curvefit_raise(b, line_b, options, n);
	} else {
		curvefit_free(b);
		*b = copy;
	}
	free(arc);
}

static size_t find_root(size_t *parent, size_t i)
{
	while (parent[i] != i)
		i = parent[i] = parent[parent[i]];
	return i;
}

size_t harmonise(struct curvefit *fit, const struct polyline *line, const struct curvefit_options *options,
		 const struct border_network *border, const struct patchloops *loops, const struct dense_patch *patch,
		 size_t *class_size)
{
	const size_t n = border->chain_count;
	struct relations relations = {0};
	for (size_t p = 0; p < loops->patch_count; p++)
		relate_patch(&relations, fit, line, loops, p, patch && patch[p].kind == PATCH_PLANE);
	size_t *parent = mem_array(n, sizeof *parent), *model = mem_array(n, sizeof *model);
	for (size_t c = 0; c < n; c++)
		parent[c] = c, model[c] = c;
	for (size_t r = 0; r < relations.count; r++) {
		const size_t a = find_root(parent, relations.item[r].a), b = find_root(parent, relations.item[r].b);
		if (a == b)
			continue;
		const size_t low = a < b ? a : b, high = a < b ? b : a;
		parent[high] = low;
		if (fit[model[high]].count > fit[model[low]].count)
			model[low] = model[high];
	}
	if (class_size) {
		size_t *size = mem_array(n, sizeof *size);
		for (size_t c = 0; c < n; c++)
			size[find_root(parent, c)]++;
		for (size_t c = 0; c < n; c++)
			class_size[c] = size[find_root(parent, c)];
		free(size);
	}
	/* Neighbours of each curve, to carry knots from the model outwards. */
	size_t *start = mem_array(n + 2, sizeof *start), *item = mem_array(2 * relations.count, sizeof *item);
	for (size_t r = 0; r < relations.count; r++)
		start[relations.item[r].a + 2]++, start[relations.item[r].b + 2]++;
	for (size_t c = 0; c < n; c++)
		start[c + 2] += start[c + 1];
	for (size_t r = 0; r < relations.count; r++) {
		item[start[relations.item[r].a + 1]++] = r;
		item[start[relations.item[r].b + 1]++] = r;
	}
	bool *done = mem_array(n, sizeof *done);
	size_t *queue = mem_array(n, sizeof *queue), changed = 0;
	for (size_t root = 0; root < n; root++) {
		if (find_root(parent, root) != root || start[root] == start[root + 1])
			continue;
		size_t head = 0, tail = 0;
		queue[tail++] = model[root];
		done[model[root]] = true;
		while (head < tail) {
			const size_t a = queue[head++];
			for (size_t k = start[a]; k < start[a + 1]; k++) {
				const struct opposite *o = relations.item + item[k];
				const size_t b = o->a == a ? o->b : o->a;
				if (done[b])
					continue;
				done[b] = true;
				queue[tail++] = b;
				if (!fit[b].closed && fit[a].count - 2 > MOST_RAISE * (fit[b].count - 2))
					continue; /* the class grew beyond what this curve should pay */
				copy_knots(fit + b, line + b, options[b], fit + a, line + a, o->same_way);
				changed++;
			}
		}
	}
	free(parent), free(model), free(start), free(item), free(done), free(queue), free(relations.item);
	return changed;
}
