/* Where knots begin: curvature profiles of polylines. */
#include "stages/fitcurves/knots.h"

#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"

/* Spans at the ends of an open curve over the others: an arc that must start without curvature needs its first knot early
 * (table 4.5 is reached so; even spans leave up to three times as much). */
#define END_SPAN 0.5
/* Resampled points behind curvature profiles. */
#define PROFILE_LEAST 32
#define PROFILE_MOST 2048
#define PROFILE_REACH 2

struct profile {
	size_t count; /* cells of equal arc length */
	double step;
	double *curvature; /* of each cell, smoothed over PROFILE_REACH cells both ways */
	double turning;    /* total, radians */
};

static void profile_init(struct profile *profile, const struct polyline *line, double side)
{
	const double edge = line->length / (double)line->segment_count;
	const double step = fmax(0.002 * side, edge / 2);
	size_t n = (size_t)fmin(ceil(line->length / step), PROFILE_MOST);
	if (n < PROFILE_LEAST)
		n = PROFILE_LEAST;
	profile->count = n;
	profile->step = line->length / (double)n;
	profile->curvature = mem_array(n, sizeof *profile->curvature);
	profile->turning = 0;
	/* Chords that are shorter than the mesh edges see spikes at the vertices and nothing between them. */
	const double reach = PROFILE_REACH * fmax(profile->step, edge / 2);
	for (size_t i = 0; i < n; i++) {
		const double arc = ((double)i + 0.5) * profile->step;
		double low = arc - reach, high = arc + reach, middle = arc;
		if (!line->closed) { /* one-sided at the ends */
			if (low < 0)
				low = 0, high = fmin(2 * reach, line->length), middle = high / 2;
			else if (high > line->length)
				high = line->length, low = fmax(0, high - 2 * reach), middle = (low + high) / 2;
		}
		double p[3], q[3], r[3], u[3], v[3];
		polyline_at(p, line, low);
		polyline_at(q, line, middle);
		polyline_at(r, line, high);
		sub3(u, q, p);
		sub3(v, r, q);
		profile->curvature[i] = norm3(u) > 0 && norm3(v) > 0 ? angle3(u, v) / ((high - low) / 2) : 0;
		profile->turning += profile->curvature[i] * profile->step;
	}
}

/* Cumulative measure of cells in which knots are spread evenly: the error of a cubic falls with the fourth power of the knot
 * distance, so bent parts need more, but only by a root; straight parts keep a share. */
static double *profile_measure(const struct profile *profile)
{
	double *measure = mem_array(profile->count + 1, sizeof *measure), mean = 0;
	for (size_t i = 0; i < profile->count; i++)
		mean += sqrt(profile->curvature[i]) / (double)profile->count;
	/* a tenth of a radian over the whole length: below that, curvature is rounding */
	const double floor_density = mean / 2 + sqrt(0.1 / (profile->step * (double)profile->count));
	for (size_t i = 0; i < profile->count; i++)
		measure[i + 1] = measure[i] + (sqrt(profile->curvature[i]) + floor_density) * profile->step;
	return measure;
}

static double measure_to_arc(const struct profile *profile, const double *measure, double value)
{
	size_t low = 0, high = profile->count;
	while (high - low > 1) {
		const size_t middle = (low + high) / 2;
		if (measure[middle] <= value)
			low = middle;
		else
			high = middle;
	}
	return ((double)low + (value - measure[low]) / (measure[low + 1] - measure[low])) * profile->step;
}

void knots_spread(double *arc, const struct polyline *line, double side, size_t count)
{
	struct profile profile;
	profile_init(&profile, line, side);
	double *measure = profile_measure(&profile);
	const double total = measure[profile.count];
	const double before = line->closed ? 0 : 1 - END_SPAN, spans = (double)count - (line->closed ? 0 : 1 + 2 * before);
	for (size_t i = 0; i < count; i++)
		arc[i] = measure_to_arc(&profile, measure, fmin(fmax(((double)i - before) * total / spans, 0), total));
	if (!line->closed)
		arc[0] = 0, arc[count - 1] = line->length;
	free(measure), free(profile.curvature);
}

static int compare_doubles(const void *a, const void *b)
{
	const double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

size_t knots_start(double *arc, size_t room, const struct polyline *line, double side, double max)
{
	struct profile profile;
	profile_init(&profile, line, side);
	double *measure = profile_measure(&profile), *knot = mem_array(room + 2, sizeof *knot);
	const size_t n = profile.count;
	const double total = measure[n];
	size_t count = 0, want;
	if (line->closed) {
		want = (size_t)fmin(ceil(pow(2.3 * line->length / (2 * PI) / max, 0.25)), 24);
		if (want < 4)
			want = 4;
	} else {
		knot[count++] = 0;
		knot[count++] = total;
		const double steps = ceil(profile.turning / (PI / 3));
		want = 2 + (profile.turning < 15 / DEGREES || steps < 2 ? 1 : (size_t)fmin(steps, 40) - 1);
	}
	double highest = 0;
	for (size_t i = 0; i < n; i++)
		highest = fmax(highest, profile.curvature[i]);
	for (size_t i = 0; i < n && count < room / 4; i++) {
		const double k = profile.curvature[i];
		if (k == 0 || (!line->closed && (i < PROFILE_REACH || i + PROFILE_REACH >= n)))
			continue;
		/* a maximum is prominent when the profile falls by a fifth of the highest on both sides before it rises above */
		bool is_top = true;
		for (int way = 0; way < 2 && is_top; way++) {
			bool falls = false;
			for (size_t step = 1; step < n && is_top && !falls; step++) {
				if (!line->closed && (way ? i + step >= n : step > i))
					break;
				const double other = profile.curvature[way ? (i + step) % n : (i + n - step) % n];
				falls = other < k - 0.2 * highest;
				is_top = way ? other <= k : other < k; /* of equals the first */
			}
			is_top = is_top && falls;
		}
		if (is_top)
			knot[count++] = (measure[i] + measure[i + 1]) / 2;
	}
	if (count == 0)
		knot[count++] = 0;
	qsort(knot, count, sizeof *knot, compare_doubles);
	while (count < want) {
		size_t at = 0;
		double widest = -1;
		for (size_t i = 0; i + 1 < count || (line->closed && i < count); i++) {
			const double gap = i + 1 < count ? knot[i + 1] - knot[i] : knot[0] + total - knot[i];
			if (gap > widest * (1 + 1e-9))
				widest = gap, at = i;
		}
		double value = knot[at] + widest / 2;
		if (value >= total && line->closed)
			value -= total;
		knot[count++] = value;
		qsort(knot, count, sizeof *knot, compare_doubles);
	}
	for (size_t i = 0; i < count; i++)
		arc[i] = measure_to_arc(&profile, measure, knot[i]);
	if (!line->closed)
		arc[0] = 0, arc[count - 1] = line->length;
	free(measure), free(profile.curvature), free(knot);
	return count;
}
