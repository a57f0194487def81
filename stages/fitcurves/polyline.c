/* Target polylines of the curve fit. */
#include "stages/fitcurves/polyline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"

/* A vertex that turns by more is a kink of the target, not a sample of something round. */
#define KINK_RAD (50 / DEGREES)
/* Half widths of the local cubics that find and remove steps. */
#define NOISE_HALF 2
#define SMOOTH_HALF 4
/* A line is jagged when the noise is more than this share of its median edge. */
#define JAGGED_SHARE 0.06

static int compare_doubles(const void *a, const void *b)
{
	const double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double median(double *value, size_t count)
{
	if (count == 0)
		return 0;
	qsort(value, count, sizeof *value, compare_doubles);
	return value[count / 2];
}

static size_t neighbour(const struct polyline *line, size_t i, ptrdiff_t step)
{
	const ptrdiff_t n = (ptrdiff_t)line->count;
	return (size_t)((((ptrdiff_t)i + step) % n + n) % n);
}

/* Value at the middle of a least-squares cubic in arc length through 2 half + 1 vertices around vertex i. Chebyshev-free
 * normal equations: arcs are scaled to [-1, 1] and the systems are 4 by 4. False when too few vertices are there. */
static bool local_cubic(double out[3], const struct polyline *line, size_t i, size_t half)
{
	if (line->closed ? line->count < 2 * half + 1 : i < half || i + half >= line->count)
		return false;
	double s[2 * SMOOTH_HALF + 1], reach = 0;
	const double *p[2 * SMOOTH_HALF + 1];
	for (size_t k = 0; k <= 2 * half; k++) {
		const size_t v = neighbour(line, i, (ptrdiff_t)k - (ptrdiff_t)half);
		double d = line->arc[v] - line->arc[i];
		if (line->closed && k < half && d > 0)
			d -= line->length;
		if (line->closed && k > half && d < 0)
			d += line->length;
		s[k] = d;
		p[k] = line->xyz + 3 * v;
		reach = fmax(reach, fabs(d));
	}
	double a[4][7] = {{0}};
	for (size_t k = 0; k <= 2 * half; k++) {
		const double t = s[k] / reach;
		const double power[4] = {1, t, t * t, t * t * t};
		for (int r = 0; r < 4; r++) {
			for (int c = 0; c < 4; c++)
				a[r][c] += power[r] * power[c];
			for (int c = 0; c < 3; c++)
				a[r][4 + c] += power[r] * p[k][c];
		}
	}
	for (int c = 0; c < 4; c++) {
		int pivot = c;
		for (int r = c + 1; r < 4; r++)
			if (fabs(a[r][c]) > fabs(a[pivot][c]))
				pivot = r;
		if (fabs(a[pivot][c]) < 1e-12)
			return false;
		for (int k = 0; k < 7; k++) {
			const double x = a[c][k];
			a[c][k] = a[pivot][k], a[pivot][k] = x;
		}
		for (int r = 0; r < 4; r++) {
			if (r == c)
				continue;
			const double f = a[r][c] / a[c][c];
			for (int k = c; k < 7; k++)
				a[r][k] -= f * a[c][k];
		}
	}
	for (int c = 0; c < 3; c++)
		out[c] = a[0][4 + c] / a[0][0];
	return true;
}

static void measure_noise(struct polyline *line)
{
	double *residual = mem_array(line->count, sizeof *residual);
	size_t count = 0;
	for (size_t i = 0; i < line->count; i++) {
		double p[3];
		if (local_cubic(p, line, i, NOISE_HALF))
			residual[count++] = distance3(p, line->xyz + 3 * i);
	}
	line->noise = median(residual, count);
	free(residual);
}

static double median_edge(const struct polyline *line)
{
	double *length = mem_array(line->segment_count, sizeof *length);
	for (size_t i = 0; i < line->segment_count; i++)
		length[i] = line->arc[i + 1] - line->arc[i];
	const double result = median(length, line->segment_count);
	free(length);
	return result;
}

/* Everything that follows from the points. */
static void derive(struct polyline *line)
{
	const size_t n = line->count;
	line->arc[0] = 0;
	for (size_t i = 0; i < line->segment_count; i++)
		line->arc[i + 1] = line->arc[i] + distance3(line->xyz + 3 * i, line->xyz + 3 * ((i + 1) % n));
	line->length = line->arc[line->segment_count];
	for (size_t i = 0; i < n; i++) {
		const bool has_before = line->closed || i > 0, has_after = line->closed || i + 1 < n;
		double before[3] = {0}, after[3] = {0}, before_length = 0, after_length = 0;
		double *tangent = line->tangent + 3 * i, *curvature = line->curvature + 3 * i;
		if (has_before) {
			sub3(before, line->xyz + 3 * i, line->xyz + 3 * neighbour(line, i, -1));
			before_length = normalise3(before);
		}
		if (has_after) {
			sub3(after, line->xyz + 3 * neighbour(line, i, 1), line->xyz + 3 * i);
			after_length = normalise3(after);
		}
		for (int k = 0; k < 3; k++)
			tangent[k] = before[k] + after[k], curvature[k] = 0;
		if (normalise3(tangent) == 0)
			copy3(tangent, has_after ? after : before);
		line->turn[i] = has_before && has_after ? angle3(before, after) : 0;
		if (line->turn[i] > 0 && line->turn[i] < KINK_RAD) {
			sub3(curvature, after, before);
			normalise3(curvature);
			scale3(curvature, line->turn[i] / ((before_length + after_length) / 2));
		}
	}
	for (size_t i = 0; i < line->segment_count; i++) {
		/* sagitta = edge * tan(angle / 4) / 2 of the arc over this chord. The smaller turn of both ends, because one kink
		 * between straight stretches is not round; an end of the line asks the vertex after next. */
		const size_t j = (i + 1) % n;
		const bool at_start = !line->closed && i == 0, at_end = !line->closed && i + 2 == n;
		const size_t u = at_start ? (n > 3 ? 2 : 1) : i, v = at_end ? (n > 3 ? n - 3 : 1) : j;
		const double angle =
			fmin(line->turn[u] < KINK_RAD ? line->turn[u] : 0, line->turn[v] < KINK_RAD ? line->turn[v] : 0);
		const bool same_side = dot3(line->curvature + 3 * u, line->curvature + 3 * v) > 0;
		line->slack[i] = same_side ? (line->arc[i + 1] - line->arc[i]) * tan(angle / 4) / 2 : 0;
	}
}

void polyline_init(struct polyline *line, const double *xyz, size_t count, bool closed)
{
	*line = (struct polyline){.closed = closed};
	line->xyz = mem_array(3 * count, sizeof *line->xyz);
	for (size_t i = 0; i < count; i++)
		if (line->count == 0 || distance3(line->xyz + 3 * (line->count - 1), xyz + 3 * i) > 0)
			copy3(line->xyz + 3 * line->count++, xyz + 3 * i);
	while (closed && line->count > 1 && distance3(line->xyz, line->xyz + 3 * (line->count - 1)) == 0)
		line->count--;
	line->segment_count = line->closed ? line->count : line->count - 1;
	line->arc = mem_array(line->count + 1, sizeof *line->arc);
	line->tangent = mem_array(3 * line->count, sizeof *line->tangent);
	line->curvature = mem_array(3 * line->count, sizeof *line->curvature);
	line->turn = mem_array(line->count, sizeof *line->turn);
	line->slack = mem_array(line->count, sizeof *line->slack);
	derive(line);
	measure_noise(line);
}

void polyline_free(struct polyline *line)
{
	free(line->xyz), free(line->arc), free(line->tangent), free(line->curvature), free(line->turn), free(line->slack);
	*line = (struct polyline){0};
}

bool polyline_is_jagged(const struct polyline *line)
{
	return line->noise > JAGGED_SHARE * median_edge(line);
}

void polyline_smooth(struct polyline *line)
{
	const double noise = line->noise;
	double *smooth = mem_copy(line->xyz, 3 * line->count, sizeof *smooth);
	for (size_t i = 0; i < line->count; i++)
		for (size_t half = SMOOTH_HALF; half >= NOISE_HALF; half--)
			if (local_cubic(smooth + 3 * i, line, i, half))
				break;
	memcpy(line->xyz, smooth, 3 * line->count * sizeof *smooth);
	free(smooth);
	derive(line);
	for (size_t i = 0; i < line->segment_count; i++)
		line->slack[i] = fmax(line->slack[i], 2 * noise); /* the border was nowhere nearer to its true course */
}

size_t polyline_segment(const struct polyline *line, double arc)
{
	size_t low = 0, high = line->segment_count;
	while (high - low > 1) {
		const size_t middle = (low + high) / 2;
		if (line->arc[middle] <= arc)
			low = middle;
		else
			high = middle;
	}
	return low;
}

void polyline_at(double out[3], const struct polyline *line, double arc)
{
	if (line->closed) {
		arc = fmod(arc, line->length);
		if (arc < 0)
			arc += line->length;
	}
	const size_t i = polyline_segment(line, arc), j = (i + 1) % line->count;
	const double length = line->arc[i + 1] - line->arc[i];
	const double t = length > 0 ? fmin(fmax((arc - line->arc[i]) / length, 0), 1) : 0;
	for (int k = 0; k < 3; k++)
		out[k] = (1 - t) * line->xyz[3 * i + k] + t * line->xyz[3 * j + k];
}

double polyline_carry(const struct polyline *to, const struct polyline *from, double arc)
{
	const double turns = from->closed ? floor(arc / from->length) : 0;
	const double rest = arc - turns * from->length;
	const size_t i = polyline_segment(from, rest);
	const double length = from->arc[i + 1] - from->arc[i],
		     t = length > 0 ? fmin(fmax((rest - from->arc[i]) / length, 0), 1) : 0;
	/* segments of to for each of from: 1 or 1/2. Vertices that fell together shift the rest by a segment, which is near
	 * enough. */
	const double share = (double)to->segment_count / (double)from->segment_count, place = ((double)i + t) * share;
	const size_t j = place >= (double)to->segment_count ? to->segment_count - 1 : (size_t)place;
	return turns * to->length + to->arc[j] + (place - (double)j) * (to->arc[j + 1] - to->arc[j]);
}

struct polyline_foot polyline_nearest(const struct polyline *line, const double p[3], double from, double to)
{
	const size_t n = line->segment_count;
	size_t first, steps;
	if (line->closed) {
		from = fmod(from, line->length) < 0 ? fmod(from, line->length) + line->length : fmod(from, line->length);
		to = fmod(to, line->length) < 0 ? fmod(to, line->length) + line->length : fmod(to, line->length);
		first = polyline_segment(line, from);
		const size_t last = polyline_segment(line, to);
		steps = (last + n - first) % n;
		if (to < from && last == first)
			steps = n - 1; /* nearly a whole turn */
	} else {
		first = polyline_segment(line, fmin(fmax(from, 0), line->length));
		steps = polyline_segment(line, fmin(fmax(to, 0), line->length));
		steps = steps > first ? steps - first : 0;
	}
	double best = INFINITY, best_t = 0;
	size_t at = first;
	for (size_t k = 0; k <= steps; k++) {
		const size_t i = (first + k) % n;
		const double *a = line->xyz + 3 * i, *b = line->xyz + 3 * ((i + 1) % line->count);
		double u[3], w[3];
		sub3(u, b, a);
		sub3(w, p, a);
		const double length2 = dot3(u, u);
		const double t = length2 > 0 ? fmin(fmax(dot3(u, w) / length2, 0), 1) : 0;
		add_scaled3(w, -t, u);
		const double d = dot3(w, w);
		if (d < best)
			best = d, best_t = t, at = i;
	}
	struct polyline_foot foot = {.segment = at, .distance = sqrt(best)};
	const size_t next = (at + 1) % line->count;
	foot.arc = line->arc[at] + best_t * (line->arc[at + 1] - line->arc[at]);
	for (int k = 0; k < 3; k++) {
		foot.point[k] = (1 - best_t) * line->xyz[3 * at + k] + best_t * line->xyz[3 * next + k];
		foot.curvature[k] = (1 - best_t) * line->curvature[3 * at + k] + best_t * line->curvature[3 * next + k];
		foot.tangent[k] = (1 - best_t) * line->tangent[3 * at + k] + best_t * line->tangent[3 * next + k];
	}
	if (line->turn[at] > KINK_RAD || line->turn[next] > KINK_RAD)
		sub3(foot.tangent, line->xyz + 3 * next, line->xyz + 3 * at);
	normalise3(foot.tangent);
	return foot;
}
