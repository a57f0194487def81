/* Fit of one subdivision curve to one polyline by squared-distance minimisation.
 *
 * Wang, Pottmann and Liu, Fitting B-spline curves to point clouds by curvature-based squared distance minimization (2006),
 * with clamped weights, and uniform knots because subdivision knows no others. */
#include "stages/fitcurves/curvefit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/fitcurves/curvestep.h"
#include "stages/fitcurves/knots.h"
#include "stages/geometry/curve.h"
#include "stages/geometry/vector.h"

/* Samples of a span between two knots: level 4 of subdivision. */
#define SPAN_SAMPLES 16
#define ITERATIONS 5
#define REMOVAL_ITERATIONS 3
/* Proximal weight over the mean diagonal of the normal equations, its growth when a step fails, and how often. */
#define PROXIMAL 1e-3
#define PROXIMAL_GROWTH 10
#define PROXIMAL_TRIALS 4
/* Spread knots with up to this many points are tried before the curvature maxima are. */
#define MOST_SPREAD 14
/* Insertion gives up when this many new points brought less than a twentieth. */
#define PATIENCE 6

/* --- state of a fit ---------------------------------------------------------------------------------------------- */

static void fit_alloc(struct curvefit *fit, size_t count, bool closed)
{
	*fit = (struct curvefit){.count = count, .closed = closed};
	fit->xyz = mem_array(3 * count, sizeof *fit->xyz);
	fit->arc = mem_array(count, sizeof *fit->arc);
}

void curvefit_free(struct curvefit *fit)
{
	free(fit->xyz), free(fit->arc);
	*fit = (struct curvefit){0};
}

static void fit_copy(struct curvefit *to, const struct curvefit *from)
{
	double *xyz = mem_copy(from->xyz, 3 * from->count, sizeof *xyz), *arc = mem_copy(from->arc, from->count, sizeof *arc);
	curvefit_free(to);
	*to = *from;
	to->xyz = xyz, to->arc = arc;
}

static void fit_move(struct curvefit *to, struct curvefit *from)
{
	curvefit_free(to);
	*to = *from;
	*from = (struct curvefit){0};
}

/* Control points whose limits are the polyline's points at the knots' arcs. Gauss and Seidel's iteration gains a bit a
 * round: each row has 4 on the diagonal and 2 beside it. */
static void interpolate(struct curvefit *fit, const struct polyline *line)
{
	const size_t n = fit->count;
	double *limit = mem_array(3 * n, sizeof *limit);
	for (size_t i = 0; i < n; i++)
		polyline_at(limit + 3 * i, line, fit->arc[i]);
	memcpy(fit->xyz, limit, 3 * n * sizeof *limit);
	for (int round = 0; round < 50; round++)
		for (size_t i = fit->closed ? 0 : 1; i < (fit->closed ? n : n - 1); i++)
			for (size_t k = 0; k < 3; k++)
				fit->xyz[3 * i + k] = (6 * limit[3 * i + k] - fit->xyz[3 * ((i + n - 1) % n) + k] -
						       fit->xyz[3 * ((i + 1) % n) + k]) /
						      4;
	free(limit);
}

/* Arc length at the end of span i. */
static double span_end(const struct curvefit *fit, const struct polyline *line, size_t i)
{
	return i + 1 < fit->count ? fit->arc[i + 1] : fit->arc[0] + line->length;
}

struct samples {
	struct curvesample *sample;
	size_t count, forward_count;
	double energy;
};

static double allowed_max(const struct polyline *line, const struct curvefit_options *options, size_t segment)
{
	return fmax(options->max, line->slack[segment]);
}

/* Nearest point of the sampled curve to target vertex v, among the spans around its arc length. */
static double reverse_distance(double *u, double point[3], const struct curvefit *fit, const struct polyline *line,
			       const struct curvesample *forward, size_t spans, size_t v)
{
	double arc = line->arc[v];
	if (fit->closed && arc < fit->arc[0])
		arc += line->length;
	size_t low = 0, high = spans;
	while (high - low > 1) {
		const size_t middle = (low + high) / 2;
		if (fit->arc[middle] <= arc)
			low = middle;
		else
			high = middle;
	}
	const size_t all = spans * SPAN_SAMPLES, steps = spans < 3 ? all : 3 * SPAN_SAMPLES;
	size_t at = low * SPAN_SAMPLES;
	if (fit->closed)
		at = spans < 3 ? 0 : (at + all - SPAN_SAMPLES) % all;
	else
		at = low > 0 ? at - SPAN_SAMPLES : 0;
	double best = INFINITY, along[3] = {0};
	const double *p = line->xyz + 3 * v;
	for (size_t k = 0; k < steps; k++, at++) {
		if (at == all) {
			if (!fit->closed)
				break;
			at = 0;
		}
		const struct curvesample *a = forward + at, *b = forward + (fit->closed ? (at + 1) % all : at + 1);
		double d[3], w[3];
		sub3(d, b->point, a->point);
		sub3(w, p, a->point);
		const double length2 = dot3(d, d);
		const double t = length2 > 0 ? fmin(fmax(dot3(d, w) / length2, 0), 1) : 0;
		add_scaled3(w, -t, d);
		if (dot3(w, w) < best) {
			best = dot3(w, w);
			*u = a->u + t / SPAN_SAMPLES;
			copy3(along, d);
		}
	}
	/* To the curve itself, which a chord is not; speed varies along it, so what is left along the chord does not count. */
	double w[3];
	curve_point(point, fit->xyz, fit->count, fit->closed, *u);
	sub3(w, point, p);
	normalise3(along);
	add_scaled3(w, -dot3(w, along), along);
	return norm3(w);
}

/* Samples of the curve with foot points, target vertices with theirs; fills the fit's errors. */
static void take_samples(struct samples *s, struct curvefit *fit, const struct polyline *line,
			 const struct curvefit_options *options)
{
	const size_t n = fit->count, spans = fit->closed ? n : n - 1;
	s->forward_count = spans * SPAN_SAMPLES + !fit->closed;
	s->count = s->forward_count;
	s->energy = 0;
	for (size_t k = 0; k < s->forward_count; k++) {
		struct curvesample *sample = s->sample + k;
		size_t span = k / SPAN_SAMPLES;
		if (span == spans)
			span--;
		sample->u = (double)k / SPAN_SAMPLES;
		sample->reverse = false;
		curve_point(sample->point, fit->xyz, n, fit->closed, sample->u);
		const double from = fit->arc[span], to = span_end(fit, line, span);
		double margin = (to - from) / 2 + 0.01 * line->length;
		if (fit->closed)
			margin = fmin(margin, fmax(0, 0.95 * line->length - (to - from)) / 2);
		sample->foot = polyline_nearest(line, sample->point, from - margin, to + margin);
	}
	double sum = 0, allowed = 0, total = 0;
	fit->error = 0;
	double worst = 0;
	for (size_t k = 0; k < s->forward_count; k++) {
		struct curvesample *sample = s->sample + k;
		const size_t before = k > 0 ? k - 1 : fit->closed ? s->forward_count - 1 : 0;
		const size_t after = k + 1 < s->forward_count ? k + 1 : fit->closed ? 0 : k;
		sample->weight =
			(distance3(sample->point, s->sample[before].point) + distance3(sample->point, s->sample[after].point)) /
			2;
		const double d = sample->foot.distance, most = allowed_max(line, options, sample->foot.segment);
		sum += sample->weight * d;
		allowed += sample->weight * fmax(options->mean, line->slack[sample->foot.segment] / 2);
		total += sample->weight;
		s->energy += sample->weight * d * d;
		fit->error = fmax(fit->error, d);
		if (d / most > worst)
			worst = d / most, fit->worst_arc = sample->foot.arc;
	}
	for (size_t v = 0; v < line->count; v++) {
		if (!fit->closed && (v == 0 || v + 1 == line->count))
			continue;
		double u = 0, point[3] = {0};
		const double d = reverse_distance(&u, point, fit, line, s->sample, spans, v);
		const size_t segment = v < line->segment_count ? v : v - 1, other = v > 0 ? v - 1 : line->segment_count - 1;
		const double most = fmax(allowed_max(line, options, segment), allowed_max(line, options, other));
		const double weight = (line->arc[segment + 1] - line->arc[segment] + line->arc[other + 1] - line->arc[other]) / 2;
		fit->error = fmax(fit->error, d);
		s->energy += weight * d * d;
		if (d / most > worst)
			worst = d / most, fit->worst_arc = line->arc[v];
		if (d > 0.7 * most) { /* cut corners pull; where the curve runs well, its own samples say all */
			struct curvesample *sample = s->sample + s->count++;
			*sample = (struct curvesample){.u = u, .weight = weight, .reverse = true};
			copy3(sample->point, point);
			copy3(sample->foot.point, line->xyz + 3 * v);
			copy3(sample->foot.tangent, line->tangent + 3 * v);
		}
	}
	fit->mean = total > 0 ? sum / total : 0;
	fit->ratio = fmax(worst, allowed > 0 ? sum / allowed : 0);
}

static struct samples samples_new(const struct curvefit *fit, const struct polyline *line)
{
	return (struct samples){.sample = mem_array(fit->count * SPAN_SAMPLES + 1 + line->count, sizeof(struct curvesample))};
}

/* Let the knots' arcs follow their foot points, as long as they stay in order. */
static void follow_knots(struct curvefit *fit, const struct polyline *line, const struct samples *s)
{
	const size_t n = fit->count;
	double *arc = mem_array(n, sizeof *arc);
	bool ordered = true;
	for (size_t i = 0; i < n; i++) {
		arc[i] = s->sample[i * SPAN_SAMPLES].foot.arc;
		if (fit->closed)
			arc[i] += line->length * round((fit->arc[i] - arc[i]) / line->length);
		if (i > 0 && arc[i] <= arc[i - 1])
			ordered = false;
	}
	if (!fit->closed)
		arc[0] = 0, arc[n - 1] = line->length;
	else if (arc[n - 1] >= arc[0] + line->length)
		ordered = false;
	if (ordered && (n < 2 || (arc[1] > arc[0] && arc[n - 1] > arc[n - 2])))
		memcpy(fit->arc, arc, n * sizeof *arc);
	free(arc);
}

/* Iterate from the fit's points; leaves the best state by ratio. */
static void optimise(struct curvefit *fit, const struct polyline *line, const struct curvefit_options *options, int iterations)
{
	struct samples now = samples_new(fit, line), next = samples_new(fit, line);
	take_samples(&now, fit, line, options);
	if (!fit->closed && fit->count < 3)
		iterations = 0;
	struct curvefit best = {0}, trial = {0};
	fit_copy(&best, fit);
	double proximal = PROXIMAL;
	for (int i = 0; i < iterations; i++) {
		bool better = false;
		const double energy = now.energy;
		for (int k = 0; k < PROXIMAL_TRIALS && !better; k++, proximal *= PROXIMAL_GROWTH) {
			fit_copy(&trial, fit);
			if (!curvestep(trial.xyz, fit, now.sample, now.count, proximal))
				continue;
			take_samples(&next, &trial, line, options);
			better = next.energy < energy;
		}
		if (!better)
			break;
		proximal = fmax(PROXIMAL, proximal / (PROXIMAL_GROWTH * PROXIMAL_GROWTH));
		const struct samples old = now;
		now = next, next = old;
		fit_move(fit, &trial);
		follow_knots(fit, line, &now);
		if (fit->ratio < best.ratio)
			fit_copy(&best, fit);
		if (energy - now.energy < 1e-4 * energy)
			break;
	}
	fit_move(fit, &best);
	curvefit_free(&trial);
	free(now.sample), free(next.sample);
}

void curvefit_measure(struct curvefit *fit, const struct polyline *line, struct curvefit_options options)
{
	struct samples s = samples_new(fit, line);
	take_samples(&s, fit, line, &options);
	free(s.sample);
}

/* --- strategies -------------------------------------------------------------------------------------------------- */

void curvefit_from(struct curvefit *fit, const struct polyline *line, struct curvefit_options options, const double *arc,
		   size_t count)
{
	fit_alloc(fit, count, line->closed);
	memcpy(fit->arc, arc, count * sizeof *arc);
	interpolate(fit, line);
	optimise(fit, line, &options, ITERATIONS);
}

void curvefit_exact(struct curvefit *fit, const struct polyline *line, struct curvefit_options options, size_t count)
{
	double *arc = mem_array(count, sizeof *arc);
	knots_spread(arc, line, options.side, count);
	curvefit_from(fit, line, options, arc, count);
	free(arc);
}

/* A new knot in the span that holds arc, its control point on the segment between its neighbours. */
static void insert_knot(struct curvefit *fit, const struct polyline *line, double arc)
{
	const size_t n = fit->count, spans = fit->closed ? n : n - 1;
	if (fit->closed && arc < fit->arc[0])
		arc += line->length;
	size_t span = 0;
	while (span + 1 < spans && fit->arc[span + 1] <= arc)
		span++;
	const double from = fit->arc[span], to = span_end(fit, line, span);
	const double t = to > from ? fmin(fmax((arc - from) / (to - from), 0.25), 0.75) : 0.5;
	struct curvefit more;
	fit_alloc(&more, n + 1, fit->closed);
	const size_t at = span + 1;
	memcpy(more.xyz, fit->xyz, 3 * at * sizeof *more.xyz);
	memcpy(more.xyz + 3 * (at + 1), fit->xyz + 3 * at, 3 * (n - at) * sizeof *more.xyz);
	memcpy(more.arc, fit->arc, at * sizeof *more.arc);
	memcpy(more.arc + at + 1, fit->arc + at, (n - at) * sizeof *more.arc);
	for (size_t k = 0; k < 3; k++)
		more.xyz[3 * at + k] = (1 - t) * fit->xyz[3 * span + k] + t * fit->xyz[3 * (at % n) + k];
	more.arc[at] = (1 - t) * from + t * to;
	fit_move(fit, &more);
}

static void remove_knot(struct curvefit *out, const struct curvefit *fit, const struct polyline *line, size_t i)
{
	fit_alloc(out, fit->count - 1, fit->closed);
	for (size_t k = 0, to = 0; k < fit->count; k++)
		if (k != i)
			out->arc[to++] = fit->arc[k];
	interpolate(out, line);
}

struct candidate {
	double cost;
	size_t knot;
};

static int compare_candidates(const void *a, const void *b)
{
	const struct candidate *x = a, *y = b;
	if (x->cost != y->cost)
		return x->cost < y->cost ? -1 : 1;
	return (x->knot > y->knot) - (x->knot < y->knot);
}

/* Take out inner knots as long as the rest fits; those first whose control point bends the polygon's own trend least. */
static void prune(struct curvefit *fit, const struct polyline *line, const struct curvefit_options *options)
{
	size_t trials = 3 * fit->count;
	for (bool again = true; again && trials > 0;) {
		const size_t n = fit->count, first = fit->closed ? 0 : 1, last = fit->closed ? n : n - 1;
		if (n <= options->least_points)
			return;
		struct candidate *candidate = mem_array(n, sizeof *candidate);
		size_t count = 0;
		for (size_t i = first; i < last; i++) {
			double p[3], limit[3];
			const size_t before = (i + n - 1) % n, after = (i + 1) % n;
			const double from = fit->arc[before] - (i == 0 ? line->length : 0),
				     to = fit->arc[after] + (i + 1 == n ? line->length : 0);
			const double t = to > from ? (fit->arc[i] - from) / (to - from) : 0.5;
			curve_limit(limit, fit->xyz, n, fit->closed, i);
			for (size_t k = 0; k < 3; k++)
				p[k] = (1 - t) * fit->xyz[3 * before + k] + t * fit->xyz[3 * after + k];
			candidate[count++] = (struct candidate){distance3(p, fit->xyz + 3 * i), i};
		}
		qsort(candidate, count, sizeof *candidate, compare_candidates);
		again = false;
		for (size_t c = 0; c < count && !again && trials > 0; c++, trials--) {
			struct curvefit less;
			remove_knot(&less, fit, line, candidate[c].knot);
			optimise(&less, line, options, REMOVAL_ITERATIONS);
			if (less.ratio <= 1) {
				fit_move(fit, &less);
				again = true;
			} else {
				curvefit_free(&less);
			}
		}
		free(candidate);
	}
}

/* From the curvature maxima, with insertion at the worst place. At most most points; false when that is not enough. */
static bool fit_by_insertion(struct curvefit *fit, const struct polyline *line, const struct curvefit_options *options,
			     size_t most)
{
	double arc[CURVEFIT_MOST_POINTS];
	const size_t count = knots_start(arc, CURVEFIT_MOST_POINTS, line, options->side, options->max);
	fit_alloc(fit, count, line->closed);
	memcpy(fit->arc, arc, count * sizeof *arc);
	interpolate(fit, line);
	optimise(fit, line, options, ITERATIONS);
	while (fit->count < options->least_points) {
		insert_knot(fit, line, fit->worst_arc);
		optimise(fit, line, options, ITERATIONS);
	}
	struct curvefit best = {0};
	fit_copy(&best, fit);
	for (size_t idle = 0; fit->ratio > 1 && fit->count < most && idle < PATIENCE;) {
		insert_knot(fit, line, fit->worst_arc);
		optimise(fit, line, options, ITERATIONS);
		idle++;
		if (fit->ratio < 0.95 * best.ratio) {
			fit_copy(&best, fit);
			idle = 0;
		}
	}
	if (fit->ratio > 1)
		fit_move(fit, &best);
	curvefit_free(&best);
	return fit->ratio <= 1;
}

void curvefit_best(struct curvefit *fit, const struct polyline *line, struct curvefit_options options)
{
	if (options.least_points < (line->closed ? 3 : 2))
		options.least_points = line->closed ? 3 : 2;
	struct curvefit best = {.ratio = INFINITY};
	for (size_t n = options.least_points; n <= MOST_SPREAD; n++) {
		struct curvefit trial;
		curvefit_exact(&trial, line, options, n);
		if (trial.ratio < best.ratio || best.count == 0)
			fit_copy(&best, &trial);
		curvefit_free(&trial);
		if (best.ratio <= 1)
			break;
	}
	if (best.ratio > 1 || best.count > options.least_points + 2) {
		struct curvefit other;
		const bool fits =
			fit_by_insertion(&other, line, &options, best.ratio > 1 ? CURVEFIT_MOST_POINTS : best.count + 4);
		if (fits)
			prune(&other, line, &options);
		if (best.ratio > 1 ? other.ratio < best.ratio : fits && other.count < best.count)
			fit_copy(&best, &other);
		curvefit_free(&other);
	}
	*fit = best;
}

void curvefit_point(struct curvefit *fit, const double p[3], size_t count, bool closed)
{
	fit_alloc(fit, count, closed);
	for (size_t i = 0; i < count; i++)
		copy3(fit->xyz + 3 * i, p);
}

void curvefit_raise(struct curvefit *fit, const struct polyline *line, struct curvefit_options options, size_t count)
{
	struct curvefit even;
	curvefit_exact(&even, line, options, count);
	if (even.ratio > 1) {
		struct curvefit cut = {0};
		fit_copy(&cut, fit);
		while (cut.count < count) {
			size_t widest = 0;
			for (size_t i = 1; i < (cut.closed ? cut.count : cut.count - 1); i++)
				if (span_end(&cut, line, i) - cut.arc[i] >
				    (span_end(&cut, line, widest) - cut.arc[widest]) * (1 + 1e-9))
					widest = i;
			insert_knot(&cut, line, (cut.arc[widest] + span_end(&cut, line, widest)) / 2);
		}
		optimise(&cut, line, &options, ITERATIONS);
		if (cut.ratio < even.ratio)
			fit_copy(&even, &cut);
		curvefit_free(&cut);
	}
	fit_move(fit, &even);
}
