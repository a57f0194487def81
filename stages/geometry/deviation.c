#include "stages/geometry/deviation.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/sample.h"
#include "stages/geometry/vector.h"

/* Normals closer than this are taken as equal at once, without looking for a better one among equally near faces. */
#define SAME_NORMAL_RAD 1e-7

/* Climbing to the maximum: from this many triangles, by this many steps at most, until the step is this share of a side. */
#define CLIMB_PEAKS 400
#define CLIMB_LEAST_PEAK 0.4 /* and only from samples at least this high, in shares of the maximum so far */
#define CLIMB_TRIES 24
#define CLIMB_LEAST_STEP 0.004

struct agreement {
	const struct nearest *to;
	const double *normal;
	double best;            /* cosine, -2 for none yet */
	idx_t triangle;
};

static void compare_normal(void *user, idx_t triangle, const double point[3], double distance)
{
	(void)point;
	(void)distance;
	struct agreement *agreement = user;
	const double *n = nearest_normal(agreement->to, triangle);
	if (!(dot3(n, n) > 0.5)) /* no area, no normal */
		return;
	const double cosine = dot3(n, agreement->normal);
	if (cosine > agreement->best || (cosine == agreement->best && triangle < agreement->triangle)) {
		agreement->best = cosine;
		agreement->triangle = triangle;
	}
}

/* Angle between a unit normal and the best-agreeing face among the nearest ones, in degrees. */
static double normal_turn_deg(const struct nearest *to, const double p[3], const struct foot *foot, const double normal[3], double tie)
{
	if (dot3(foot->normal, foot->normal) > 0.5) {
		const double turn = angle3(normal, foot->normal);
		if (turn < SAME_NORMAL_RAD)
			return turn * DEGREES;
	}
	struct agreement agreement = {.to = to, .normal = normal, .best = -2, .triangle = NO_INDEX};
	nearest_within(to, p, foot->distance + tie, compare_normal, &agreement);
	return agreement.triangle == NO_INDEX ? 0 : angle3(normal, nearest_normal(to, agreement.triangle)) * DEGREES;
}

static void triangle_normal(double normal[3], const struct deviation_surface *surface, idx_t triangle)
{
	const idx_t *corner = surface->triangle + 3 * (size_t)triangle;
	area_vector3(normal, surface->xyz + 3 * (size_t)corner[0], surface->xyz + 3 * (size_t)corner[1], surface->xyz + 3 * (size_t)corner[2]);
	normalise3(normal);
}

/* Share of the samples that are turned (by turn_deg) even from the faces that are up to slack farther than the nearest one. */
static double folded_share(const double *point, const idx_t *triangle, const double *turn_deg, size_t count, const struct deviation_surface *from,
                           const struct nearest *to, double slack)
{
	size_t folded = 0;
#pragma omp parallel for schedule(dynamic, 512) reduction(+ : folded)
	for (size_t i = 0; i < count; i++) {
		if (!(turn_deg[i] > 90))
			continue;
		double normal[3];
		triangle_normal(normal, from, triangle[i]);
		const struct nearest_filter filter = {.normal = normal, .least_dot = 0, .reach = 1, .slack = slack};
		folded += !(dot3(nearest_point(to, point + 3 * i, INFINITY, &filter).normal, normal) > 0);
	}
	return (double)folded / (double)count;
}

static int compare_doubles(const void *a, const void *b)
{
	const double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double percentile(const double *sorted, size_t count, double share)
{
	const size_t i = (size_t)(share * (double)count);
	return sorted[i < count ? i : count - 1];
}

/* The vertices in use, packed; returns their number. */
static size_t used_vertices(idx_t *vertex, const struct deviation_surface *surface)
{
	unsigned char *used = mem_array(surface->vertex_count, 1);
	for (size_t i = 0; i < 3 * surface->triangle_count; i++)
		used[surface->triangle[i]] = 1;
	size_t count = 0;
	for (size_t v = 0; v < surface->vertex_count; v++)
		if (used[v])
			vertex[count++] = (idx_t)v;
	free(used);
	return count;
}

/* A triangle with the highest of its samples. */
struct peak {
	double distance;
	size_t sample;
};

static int compare_peaks(const void *a, const void *b)
{
	const struct peak *x = a, *y = b;
	if (x->distance != y->distance)
		return x->distance > y->distance ? -1 : 1;
	return (x->sample > y->sample) - (x->sample < y->sample);
}

/* Move p inside triangle a b c to where the distance is larger: steps along three directions, halved when none helps. Returns the
 * distance there. */
static double climb(double p[3], double distance, const double a[3], const double b[3], const double c[3], const struct nearest *to)
{
	double direction[3][3];
	sub3(direction[0], b, a);
	sub3(direction[1], c, b);
	sub3(direction[2], a, c);
	double step = 0.25;
	for (int tries = 0; tries < CLIMB_TRIES && step > CLIMB_LEAST_STEP; tries++) {
		double best[3], most = distance;
		copy3(best, p);
		for (int k = 0; k < 6; k++) {
			double moved[3], inside[3], weight[3];
			copy3(moved, p);
			add_scaled3(moved, k % 2 == 0 ? step : -step, direction[k / 2]);
			nearest_on_triangle(inside, weight, moved, a, b, c);
			const double there = nearest_point(to, inside, INFINITY, NULL).distance;
			if (there > most) {
				most = there;
				copy3(best, inside);
			}
		}
		if (most > distance) {
			distance = most;
			copy3(p, best);
		} else {
			step /= 2;
		}
	}
	return distance;
}

/* Samples miss the tops of the distance by their spacing: climb from the best sample of each of the worst triangles. Writes the
 * highest point to worst and returns its distance; at least the given one. */
static double climb_peaks(double worst[3], double distance_so_far, const double *point, const idx_t *triangle, const double *distance,
                          size_t count, const struct deviation_surface *from, const struct nearest *to)
{
	struct peak *peak = mem_array(count, sizeof *peak);
	size_t peak_count = 0;
	for (size_t i = 0, j; i < count; i = j) { /* samples come triangle by triangle */
		size_t best = i;
		for (j = i + 1; j < count && triangle[j] == triangle[i]; j++)
			if (distance[j] > distance[best])
				best = j;
		peak[peak_count++] = (struct peak){distance[best], best};
	}
	qsort(peak, peak_count, sizeof *peak, compare_peaks);
	while (peak_count > 0 && (peak_count > CLIMB_PEAKS || !(peak[peak_count - 1].distance > CLIMB_LEAST_PEAK * distance_so_far)))
		peak_count--;
	double *top = mem_array(4 * peak_count, sizeof *top); /* point and distance */
#pragma omp parallel for schedule(dynamic, 4)
	for (size_t i = 0; i < peak_count; i++) {
		const idx_t *corner = from->triangle + 3 * (size_t)triangle[peak[i].sample];
		copy3(top + 4 * i, point + 3 * peak[i].sample);
		top[4 * i + 3] = climb(top + 4 * i, peak[i].distance, from->xyz + 3 * (size_t)corner[0], from->xyz + 3 * (size_t)corner[1],
		                       from->xyz + 3 * (size_t)corner[2], to);
	}
	for (size_t i = 0; i < peak_count; i++)
		if (top[4 * i + 3] > distance_so_far) {
			distance_so_far = top[4 * i + 3];
			copy3(worst, top + 4 * i);
		}
	free(peak);
	free(top);
	return distance_so_far;
}

bool deviation_one_way(struct deviation_side *out, const struct deviation_surface *from, const struct nearest *to, double tie,
                       const struct deviation_options *options, struct fault *fault)
{
	const size_t n = options->samples;
	double *point = mem_array(3 * n, sizeof *point);
	idx_t *triangle = mem_array(n, sizeof *triangle);
	const double area = sample_surface(point, triangle, n, from->xyz, from->triangle, from->triangle_count, options->seed);
	if (!(area > 0) || !isfinite(area)) {
		free(point);
		free(triangle);
		return fault_set(fault, EX_BAD_INPUT, area > 0 ? "a surface with an area beyond all numbers" : "a surface without area");
	}
	idx_t *vertex = mem_array(from->vertex_count, sizeof *vertex);
	const size_t vertex_count = used_vertices(vertex, from), all = n + vertex_count;
	double *distance = mem_array(all, sizeof *distance), *turn = mem_array(n, sizeof *turn);
#pragma omp parallel for schedule(dynamic, 512)
	for (size_t i = 0; i < all; i++) {
		const double *p = i < n ? point + 3 * i : from->xyz + 3 * (size_t)vertex[i - n];
		const struct foot foot = nearest_point(to, p, INFINITY, NULL);
		distance[i] = foot.distance;
		if (i < n) {
			double normal[3];
			triangle_normal(normal, from, triangle[i]);
			turn[i] = normal_turn_deg(to, p, &foot, normal, tie);
		}
	}

	/* Sums in the order of the samples, scaled by the largest so that squares neither overflow nor vanish. */
	*out = (struct deviation_side){0};
	size_t worst = 0, turned = 0;
	for (size_t i = 1; i < all; i++)
		if (distance[i] > distance[worst])
			worst = i;
	out->max = distance[worst];
	copy3(out->worst, worst < n ? point + 3 * worst : from->xyz + 3 * (size_t)vertex[worst - n]);
	if (out->max > 1e-3 * tie) /* else only rounding errors */
		out->max = climb_peaks(out->worst, out->max, point, triangle, distance, n, from, to);
	const struct foot foot = nearest_point(to, out->worst, INFINITY, NULL);
	copy3(out->worst_foot, foot.point);
	const double scale = out->max > 0 ? out->max : 1;
	for (size_t i = 0; i < n; i++) {
		const double d = distance[i] / scale;
		out->mean += d;
		out->rms += d * d;
		out->normal_mean_deg += turn[i];
		out->normal_rms_deg += turn[i] * turn[i];
		turned += turn[i] > 90;
	}
	out->mean *= scale / (double)n;
	out->rms = sqrt(out->rms / (double)n) * scale;
	out->normal_mean_deg /= (double)n;
	out->normal_rms_deg = sqrt(out->normal_rms_deg / (double)n);
	out->turned_share = (double)turned / (double)n;
	qsort(distance, n, sizeof *distance, compare_doubles);
	out->p50 = percentile(distance, n, 0.5);
	out->p95 = percentile(distance, n, 0.95);
	out->p99 = percentile(distance, n, 0.99);
	out->folded_share = folded_share(point, triangle, turn, n, from, to, out->p95 + tie);
	qsort(turn, n, sizeof *turn, compare_doubles);
	out->normal_p95_deg = percentile(turn, n, 0.95);
	out->normal_max_deg = turn[n - 1];
	free(point);
	free(triangle);
	free(vertex);
	free(distance);
	free(turn);
	return true;
}

static void surface_box(double *side, double *diagonal, const struct deviation_surface *surface)
{
	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, extent[3];
	for (size_t i = 0; i < 3 * surface->triangle_count; i++)
		for (int k = 0; k < 3; k++) {
			const double x = surface->xyz[3 * (size_t)surface->triangle[i] + k];
			low[k] = fmin(low[k], x);
			high[k] = fmax(high[k], x);
		}
	*side = 0;
	for (int k = 0; k < 3; k++) {
		extent[k] = surface->triangle_count > 0 ? high[k] - low[k] : 0;
		*side = fmax(*side, extent[k]);
	}
	*diagonal = norm3(extent);
}

static void combine(struct deviation_side *both, const struct deviation_side *ab, const struct deviation_side *ba)
{
	*both = ab->max >= ba->max ? *ab : *ba; /* worst points and max */
	both->mean = (ab->mean + ba->mean) / 2;
	both->rms = hypot(ab->rms, ba->rms) / M_SQRT2;
	both->p50 = fmax(ab->p50, ba->p50);
	both->p95 = fmax(ab->p95, ba->p95);
	both->p99 = fmax(ab->p99, ba->p99);
	both->normal_mean_deg = (ab->normal_mean_deg + ba->normal_mean_deg) / 2;
	both->normal_rms_deg = hypot(ab->normal_rms_deg, ba->normal_rms_deg) / M_SQRT2;
	both->normal_p95_deg = fmax(ab->normal_p95_deg, ba->normal_p95_deg);
	both->normal_max_deg = fmax(ab->normal_max_deg, ba->normal_max_deg);
	both->turned_share = fmax(ab->turned_share, ba->turned_share);
	both->folded_share = fmax(ab->folded_share, ba->folded_share);
}

bool deviation_measure(struct deviation *out, const struct deviation_surface *a, const struct deviation_surface *b,
                       const struct deviation_options *options, struct fault *fault)
{
	*out = (struct deviation){0};
	surface_box(&out->side, &out->diagonal, a);
	const double tie = options->tie_relative * out->diagonal;
	struct nearest *tree_a = nearest_new(a->xyz, a->vertex_count, a->triangle, a->triangle_count);
	struct nearest *tree_b = nearest_new(b->xyz, b->vertex_count, b->triangle, b->triangle_count);
	struct deviation_options back = *options;
	back.seed++;
	const bool done = deviation_one_way(&out->ab, a, tree_b, tie, options, fault) &&
	                  deviation_one_way(&out->ba, b, tree_a, tie, &back, fault);
	nearest_free(tree_a);
	nearest_free(tree_b);
	if (done)
		combine(&out->both, &out->ab, &out->ba);
	return done;
}
