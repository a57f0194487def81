/* Curvature tensors by normal cycles, one a wedge: see normalcycle.h.
 *
 * Every edge is a bit of cylinder: it adds its bending angle times its length, along its direction. Wedges do not
 * depend on each other; each thread keeps a stamp a triangle to know what its ball has met. */
#include "stages/curv/normalcycle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/dense.h"
#include "stages/curv/ballclip.h"
#include "stages/geometry/vector.h"

#define BENT_RAD (0.05 / DEGREES)        /* edges that bend less hold no curvature worth a larger ball */
#define FACETS_A_RADIUS 3                /* fewer give up to 36 % error, more blur (measured on cylinders) */
#define FACETS_LEAST 2
#define WIDTH_RINGS 5                    /* steps over edges in which the facets' width is looked for */
#define WIDTH_LIMIT 256                  /* triangles looked at for it */
#define BENT_LEAST 3                     /* bent edges that a ball must hold, or it grows */
#define GROWTH 1.5
#define GROWTH_STEPS 3
#define BALL_LIMIT 20000                 /* triangles: a ball beyond is halved, so that one place cannot take all the time */
#define HALVING_STEPS 12
#define AREA_LEAST 1e-14                 /* of a ball, longest side 1: below, there is nothing to divide by */
#define SEARCH_LIMIT 1000                /* triangles to look at for a neighbour to copy from */
#define ANISOTROPY_KAPPA 0.2             /* curvature that counts as none, longest side 1 */
#define ISOTROPIC_BELOW 0.2              /* of the anisotropy */
#define FLAT_BELOW 0.02                  /* of curvature times radius */
#define SINGULAR_RAD (30 / DEGREES)      /* defect of the angle sum */

/* What one thread needs to walk. */
struct scratch {
	unsigned *stamp; /* face_count */
	unsigned now;
	idx_t *queue;    /* face_count */
};

struct cycle {
	const struct normalcycle_mesh *mesh;
	const struct normalcycle_options *options;
	size_t *corner_start;   /* wedge_count + 1 */
	idx_t *corner;          /* half-edges that leave the vertex in the wedge */
	unsigned char *is_bent; /* a wedge: its smooth component has bent edges */
	double *height;         /* a triangle: over its longest edge */
	unsigned char *bends;   /* a triangle: an edge of it is bent */
	struct ball_plane *plane; /* a triangle */
	idx_t *edge;            /* a half-edge: index of its edge below; NO_INDEX for stops */
	double *along;          /* 6 an edge: its unit direction; the unit mean of the normals beside it, or 0 */
};

struct sum {
	double tensor[6]; /* xx xy xz yy yz zz */
	double area;
	size_t bent;
	bool is_over;     /* BALL_LIMIT was met */
};

static const double *at(const struct normalcycle_mesh *mesh, idx_t h)
{
	return mesh->xyz + 3 * mesh->half->origin[h];
}

static void collect_corners(struct cycle *cycle)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	const size_t n = m->half->half_count;
	cycle->corner_start = mem_array(m->wedge_count + 1, sizeof *cycle->corner_start);
	cycle->corner = mem_array(n, sizeof *cycle->corner);
	for (size_t h = 0; h < n; h++)
		cycle->corner_start[m->triangle_wedge[h] + 1]++;
	for (size_t w = 0; w < m->wedge_count; w++)
		cycle->corner_start[w + 1] += cycle->corner_start[w];
	size_t *fill = mem_copy(cycle->corner_start, m->wedge_count + 1, sizeof *fill);
	for (size_t h = 0; h < n; h++)
		cycle->corner[fill[m->triangle_wedge[h]]++] = (idx_t)h;
	free(fill);
}

/* Mark the wedges of smooth components that bend somewhere. */
static void find_bent_components(struct cycle *cycle)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	const struct half *half = m->half;
	idx_t *queue = mem_array(half->face_count, sizeof *queue);
	unsigned char *seen = mem_array(half->face_count, 1);
	cycle->is_bent = mem_array(m->wedge_count, 1);
	for (size_t seed = 0; seed < half->face_count; seed++) {
		if (seen[seed])
			continue;
		size_t tail = 0;
		bool is_bent = false;
		seen[seed] = 1;
		queue[tail++] = (idx_t)seed;
		for (size_t i = 0; i < tail; i++) {
			for (idx_t h = 3 * queue[i]; h < 3 * queue[i] + 3; h++) {
				if (m->stop[h])
					continue;
				is_bent = is_bent || fabs(m->bend[h]) > BENT_RAD;
				const idx_t other = half->face[half->twin[h]];
				if (!seen[other]) {
					seen[other] = 1;
					queue[tail++] = other;
				}
			}
		}
		for (size_t i = 0; is_bent && i < tail; i++)
			for (int k = 0; k < 3; k++)
				cycle->is_bent[m->triangle_wedge[3 * queue[i] + k]] = 1;
	}
	free(queue);
	free(seen);
}

/* Mean of the wedge's triangle normals by their angle at the vertex: unlike the mean by area it does not depend on how
 * a facet is cut into triangles. */
static void wedge_normal(double out[3], const struct cycle *cycle, size_t wedge)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	memset(out, 0, 3 * sizeof *out);
	for (size_t i = cycle->corner_start[wedge]; i < cycle->corner_start[wedge + 1]; i++) {
		const idx_t h = cycle->corner[i];
		double u[3], v[3];
		sub3(u, at(m, m->half->next[h]), at(m, h));
		sub3(v, at(m, m->half->previous[h]), at(m, h));
		add_scaled3(out, angle3(u, v), m->normal + 3 * m->half->face[h]);
	}
	if (normalise3(out) > 0)
		return;
	for (size_t i = cycle->corner_start[wedge]; i < cycle->corner_start[wedge + 1]; i++) {
		copy3(out, m->normal + 3 * m->half->face[cycle->corner[i]]);
		if (norm3(out) > 0)
			return;
	}
	out[2] = 1;
}

/* What would be at place k if the values were sorted (Hoare's selection; they are moved about). */
static double in_order(double *value, size_t count, size_t k)
{
	ptrdiff_t low = 0, high = (ptrdiff_t)count - 1, want = (ptrdiff_t)k;
	while (low < high) {
		const double pivot = value[low + (high - low) / 2];
		ptrdiff_t i = low, j = high;
		while (i <= j) {
			while (value[i] < pivot)
				i++;
			while (pivot < value[j])
				j--;
			if (i <= j) {
				const double swap = value[i];
				value[i++] = value[j];
				value[j--] = swap;
			}
		}
		if (want <= j)
			high = j;
		else if (want >= i)
			low = i;
		else
			break;
	}
	return value[k];
}

/* What every ball that meets a triangle or an edge asks of it. */
static void measure_mesh(struct cycle *cycle)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	const struct half *half = m->half;
	const ptrdiff_t faces = (ptrdiff_t)half->face_count;
	size_t edges = 0;
	cycle->height = mem_array(half->face_count, sizeof *cycle->height);
	cycle->bends = mem_array(half->face_count, 1);
	cycle->plane = mem_array(half->face_count, sizeof *cycle->plane);
	cycle->edge = mem_array(half->half_count, sizeof *cycle->edge);
	for (size_t h = 0; h < half->half_count; h++)
		if (m->stop[h])
			cycle->edge[h] = NO_INDEX;
		else
			cycle->edge[h] = (idx_t)h < half->twin[h] ? (idx_t)edges++ : cycle->edge[half->twin[h]];
	cycle->along = mem_array(6 * edges, sizeof *cycle->along);
#pragma omp parallel for schedule(static)
	for (ptrdiff_t t = 0; t < faces; t++) {
		double longest = 0, normal[3];
		for (idx_t h = 3 * (idx_t)t; h < 3 * (idx_t)t + 3; h++) {
			longest = fmax(longest, distance3(at(m, h), at(m, half->next[h])));
			if (m->stop[h])
				continue;
			cycle->bends[t] |= fabs(m->bend[h]) > BENT_RAD;
			if (h > half->twin[h])
				continue;
			double *e = cycle->along + 6 * (size_t)cycle->edge[h], *between = e + 3;
			sub3(e, at(m, half->next[h]), at(m, h));
			normalise3(e);
			for (int i = 0; i < 3; i++)
				between[i] = m->normal[3 * t + i] + m->normal[3 * half->face[half->twin[h]] + i];
			if (!(normalise3(between) > 1e-3) || cycle->options->no_rotation)
				memset(between, 0, 3 * sizeof *between);
		}
		area_vector3(normal, at(m, 3 * (idx_t)t), at(m, 3 * (idx_t)t + 1), at(m, 3 * (idx_t)t + 2));
		ball_plane(&cycle->plane[t], at(m, 3 * (idx_t)t), at(m, 3 * (idx_t)t + 1), at(m, 3 * (idx_t)t + 2));
		cycle->height[t] = longest > 0 ? norm3(normal) / longest : 0;
	}
}

/* Width of the facets near a wedge: the median height of the bent triangles (of all, where none is bent) over their longest
 * edges. On long thin triangles this is the distance of consecutive bends, where edge lengths say nothing. */
static double facet_width(const struct cycle *cycle, struct scratch *scratch, size_t wedge)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	const struct half *half = m->half;
	double width[2][WIDTH_LIMIT];
	size_t count[2] = {0, 0}, tail = 0, ring_end;
	scratch->now++;
	for (size_t i = cycle->corner_start[wedge]; i < cycle->corner_start[wedge + 1] && tail < WIDTH_LIMIT; i++) {
		const idx_t t = half->face[cycle->corner[i]];
		scratch->stamp[t] = scratch->now;
		scratch->queue[tail++] = t;
	}
	ring_end = tail;
	int ring = 0;
	for (size_t i = 0; i < tail; i++) {
		if (i == ring_end) {
			ring++;
			ring_end = tail;
		}
		const idx_t t = scratch->queue[i];
		for (idx_t h = 3 * t; h < 3 * t + 3 && ring < WIDTH_RINGS && tail < WIDTH_LIMIT; h++) {
			if (m->stop[h])
				continue;
			const idx_t other = half->face[half->twin[h]];
			if (scratch->stamp[other] != scratch->now) {
				scratch->stamp[other] = scratch->now;
				scratch->queue[tail++] = other;
			}
		}
		width[0][count[0]++] = cycle->height[t];
		if (cycle->bends[t])
			width[1][count[1]++] = cycle->height[t];
	}
	const int which = count[1] > 0;
	return in_order(width[which], count[which], count[which] / 2);
}

/* Turn unit e by the smallest rotation that takes unit from to unit to. */
static void rotate(double e[3], const double from[3], const double to[3])
{
	double v[3], once[3], twice[3];
	const double cosine = dot3(from, to);
	if (cosine < -0.999) /* no smallest rotation there */
		return;
	cross3(v, from, to);
	cross3(once, v, e);
	cross3(twice, v, once);
	for (int i = 0; i < 3; i++)
		e[i] += once[i] + twice[i] / (1 + cosine);
}

static void add_edge(struct sum *sum, const struct cycle *cycle, idx_t h, double length, const double normal[3])
{
	const struct normalcycle_mesh *m = cycle->mesh;
	const double bend = m->bend[h];
	const double *along = cycle->along + 6 * (size_t)cycle->edge[h];
	double e[3];
	if (fabs(bend) > BENT_RAD)
		sum->bent++;
	copy3(e, along);
	if (along[3] != 0 || along[4] != 0 || along[5] != 0)
		rotate(e, along + 3, normal);
	const double weight = bend * length;
	sum->tensor[0] += weight * e[0] * e[0];
	sum->tensor[1] += weight * e[0] * e[1];
	sum->tensor[2] += weight * e[0] * e[2];
	sum->tensor[3] += weight * e[1] * e[1];
	sum->tensor[4] += weight * e[1] * e[2];
	sum->tensor[5] += weight * e[2] * e[2];
}

/* Over the part of the ball that hangs together with the wedge, without crossing stops: on a thin wall the plain ball
 * would catch the other side. */
static struct sum ball_sum(const struct cycle *cycle, struct scratch *scratch, size_t wedge, double radius, const double normal[3])
{
	const struct normalcycle_mesh *m = cycle->mesh;
	const struct half *half = m->half;
	const double *centre = m->xyz + 3 * m->wedge_vertex[wedge];
	struct sum sum = {{0}, 0, 0, false};
	size_t tail = 0;
	scratch->now++;
	for (size_t i = cycle->corner_start[wedge]; i < cycle->corner_start[wedge + 1]; i++) {
		const idx_t t = half->face[cycle->corner[i]];
		if (scratch->stamp[t] == scratch->now)
			continue;
		scratch->stamp[t] = scratch->now;
		scratch->queue[tail++] = t;
	}
	const size_t own = tail;
	for (size_t i = 0; i < tail; i++) {
		const idx_t t = scratch->queue[i];
		sum.area += ball_triangle_in(centre, radius, &cycle->plane[t], at(m, 3 * t), at(m, 3 * t + 1), at(m, 3 * t + 2));
		for (idx_t h = 3 * t; h < 3 * t + 3; h++) {
			if (m->stop[h])
				continue;
			const double length = ball_segment(centre, radius, at(m, h), at(m, half->next[h]));
			if (length <= 0)
				continue;
			const idx_t twin = half->twin[h];
			if (h < twin) /* both triangles are met: once is enough */
				add_edge(&sum, cycle, h, length, normal);
			const idx_t other = half->face[twin];
			if (scratch->stamp[other] == scratch->now)
				continue;
			if (tail - own >= BALL_LIMIT) {
				sum.is_over = true;
				return sum;
			}
			scratch->stamp[other] = scratch->now;
			scratch->queue[tail++] = other;
		}
	}
	return sum;
}

/* The wedge's own triangles: spokes whole, link edges half (their other half belongs to the triangles outside). */
static struct sum one_ring_sum(const struct cycle *cycle, size_t wedge, const double normal[3])
{
	const struct normalcycle_mesh *m = cycle->mesh;
	const struct half *half = m->half;
	struct sum sum = {{0}, 0, 0, false};
	for (size_t i = cycle->corner_start[wedge]; i < cycle->corner_start[wedge + 1]; i++) {
		const idx_t h = cycle->corner[i], link = half->next[h];
		double area[3];
		area_vector3(area, at(m, h), at(m, link), at(m, half->previous[h]));
		sum.area += 0.5 * norm3(area);
		if (!m->stop[h])
			add_edge(&sum, cycle, h, distance3(at(m, h), at(m, link)), normal);
		if (!m->stop[link])
			add_edge(&sum, cycle, link, 0.5 * distance3(at(m, link), at(m, half->next[link])), normal);
	}
	return sum;
}

/* True for a vertex without stops around it whose angles do not add up to a full turn. */
static bool is_singular(const struct cycle *cycle, size_t wedge)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	double total = 0;
	for (size_t i = cycle->corner_start[wedge]; i < cycle->corner_start[wedge + 1]; i++) {
		const idx_t h = cycle->corner[i];
		double u[3], v[3];
		if (m->stop[h] || m->stop[m->half->previous[h]])
			return false;
		sub3(u, at(m, m->half->next[h]), at(m, h));
		sub3(v, at(m, m->half->previous[h]), at(m, h));
		total += angle3(u, v);
	}
	return fabs(total - 2 * PI) > SINGULAR_RAD;
}

/* Unit vector across n: the coordinate axis least along it, made tangent. */
static void any_tangent(double out[3], const double n[3])
{
	int axis = 0;
	for (int i = 1; i < 3; i++)
		if (fabs(n[i]) < fabs(n[axis]))
			axis = i;
	memset(out, 0, 3 * sizeof *out);
	out[axis] = 1;
	add_scaled3(out, -n[axis], n);
	normalise3(out);
}

static void set_flat(struct normalcycle_result *r, size_t wedge, double radius)
{
	r->kmin[wedge] = r->kmax[wedge] = r->anisotropy[wedge] = 0;
	r->radius[wedge] = radius;
	r->quality[wedge] = WEDGE_FLAT;
	any_tangent(r->dmin + 3 * wedge, r->normal + 3 * wedge);
}

/* Eigenvalues in the tangent plane. The eigenvector of kmax is dmin: a bent edge runs along the direction in which the
 * surface does not bend. The tensor has no part along the normal once its edges are turned into the tangent plane, so
 * nothing is lost by projecting it, and no eigenvector needs to be told from the normal. */
static void set_principal(struct normalcycle_result *r, size_t wedge, const struct sum *sum, double radius)
{
	const double *n = r->normal + 3 * wedge, *t = sum->tensor;
	double u[3], v[3];
	any_tangent(u, n);
	cross3(v, n, u);
	const double tu[3] = {t[0] * u[0] + t[1] * u[1] + t[2] * u[2], t[1] * u[0] + t[3] * u[1] + t[4] * u[2],
	                      t[2] * u[0] + t[4] * u[1] + t[5] * u[2]};
	const double tv[3] = {t[0] * v[0] + t[1] * v[1] + t[2] * v[2], t[1] * v[0] + t[3] * v[1] + t[4] * v[2],
	                      t[2] * v[0] + t[4] * v[1] + t[5] * v[2]};
	const double uu = dot3(tu, u) / sum->area, uv = dot3(tu, v) / sum->area, vv = dot3(tv, v) / sum->area;
	const double mean = 0.5 * (uu + vv), half_difference = hypot(0.5 * (uu - vv), uv);
	const double sign = mean < 0 ? -1 : 1;
	r->kmax[wedge] = mean + sign * half_difference;
	r->kmin[wedge] = mean - sign * half_difference;
	const double angle = 0.5 * atan2(2 * uv, uu - vv) + (sign < 0 ? PI / 2 : 0);
	for (int i = 0; i < 3; i++)
		r->dmin[3 * wedge + i] = cos(angle) * u[i] + sin(angle) * v[i];
	const double big = fabs(r->kmax[wedge]), small = fabs(r->kmin[wedge]);
	r->anisotropy[wedge] = (big - small) / (big + small + ANISOTROPY_KAPPA);
	r->radius[wedge] = radius;
	const bool is_isotropic = r->anisotropy[wedge] < ISOTROPIC_BELOW || big * radius < FLAT_BELOW;
	r->quality[wedge] = is_isotropic ? WEDGE_ISOTROPIC : WEDGE_GOOD;
}

/* False when the area is nothing to divide by. */
static bool compute_wedge(struct normalcycle_result *r, const struct cycle *cycle, struct scratch *scratch, size_t wedge, double radius)
{
	const double *normal = r->normal + 3 * wedge;
	struct sum sum = {{0}, 0, 0, true};
	if (!cycle->is_bent[wedge]) {
		set_flat(r, wedge, radius);
		return true;
	}
	if (!cycle->options->one_ring) {
		for (int i = 0; i < HALVING_STEPS; i++) {
			sum = ball_sum(cycle, scratch, wedge, radius, normal);
			if (!sum.is_over)
				break;
			radius /= 2;
		}
		const bool is_fixed = cycle->options->radius > 0;
		for (int i = 0; !is_fixed && !sum.is_over && sum.bent < BENT_LEAST && i < GROWTH_STEPS; i++) {
			const struct sum larger = ball_sum(cycle, scratch, wedge, radius * GROWTH, normal);
			if (larger.is_over)
				break;
			sum = larger;
			radius *= GROWTH;
		}
	}
	if (sum.is_over || sum.area < AREA_LEAST) {
		sum = one_ring_sum(cycle, wedge, normal);
		radius = sqrt(sum.area / PI);
	}
	if (sum.area < AREA_LEAST)
		return false;
	if (sum.bent == 0)
		set_flat(r, wedge, radius);
	else
		set_principal(r, wedge, &sum, radius);
	if (sum.bent > 0 && is_singular(cycle, wedge))
		r->quality[wedge] = WEDGE_SINGULAR;
	return true;
}

/* Take the curvature of the nearest wedge (in steps over triangles) that has one. */
static void copy_nearest(struct normalcycle_result *r, const struct cycle *cycle, struct scratch *scratch, size_t wedge, const unsigned char *is_set)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	size_t tail = 0;
	scratch->now++;
	set_flat(r, wedge, 0);
	const idx_t first = m->half->face[cycle->corner[cycle->corner_start[wedge]]];
	scratch->stamp[first] = scratch->now;
	scratch->queue[tail++] = first;
	for (size_t i = 0; i < tail && i < SEARCH_LIMIT; i++) {
		for (idx_t h = 3 * scratch->queue[i]; h < 3 * scratch->queue[i] + 3; h++) {
			const size_t from = (size_t)m->triangle_wedge[h];
			if (is_set[from]) {
				r->kmin[wedge] = r->kmin[from];
				r->kmax[wedge] = r->kmax[from];
				copy3(r->dmin + 3 * wedge, r->dmin + 3 * from);
				/* tangent to this wedge */
				add_scaled3(r->dmin + 3 * wedge, -dot3(r->dmin + 3 * wedge, r->normal + 3 * wedge), r->normal + 3 * wedge);
				if (!(normalise3(r->dmin + 3 * wedge) > 0.1))
					any_tangent(r->dmin + 3 * wedge, r->normal + 3 * wedge);
				r->anisotropy[wedge] = r->anisotropy[from];
				r->radius[wedge] = r->radius[from];
				r->quality[wedge] = r->quality[from];
				return;
			}
			if (m->stop[h])
				continue;
			const idx_t other = m->half->face[m->half->twin[h]];
			if (scratch->stamp[other] != scratch->now) {
				scratch->stamp[other] = scratch->now;
				scratch->queue[tail++] = other;
			}
		}
	}
}

/* Mean of a wedge's radius and of its neighbours' over smooth edges. */
static double smoothed_radius(const struct cycle *cycle, const double *radius, size_t wedge)
{
	const struct normalcycle_mesh *m = cycle->mesh;
	double total = 0;
	size_t count = 0;
	for (size_t i = cycle->corner_start[wedge]; i < cycle->corner_start[wedge + 1]; i++) {
		const idx_t h = cycle->corner[i];
		total += radius[m->triangle_wedge[m->half->next[h]]] + radius[m->triangle_wedge[m->half->previous[h]]];
		count += 2;
	}
	return 0.5 * (radius[wedge] + total / (double)count);
}

/* Where facets are wider than the upper bound, a ball that keeps to it would only see its own edge. */
static double automatic_radius(double width, const struct normalcycle_options *options)
{
	const double high = fmax(options->radius_high, FACETS_LEAST * width);
	return fmin(fmax(FACETS_A_RADIUS * width, options->radius_low), high);
}

static void scratch_new(struct scratch *scratch, size_t face_count)
{
	scratch->stamp = mem_array(face_count, sizeof *scratch->stamp);
	scratch->queue = mem_array(face_count, sizeof *scratch->queue);
	scratch->now = 0;
}

static void scratch_free(struct scratch *scratch)
{
	free(scratch->stamp);
	free(scratch->queue);
}

void normalcycle_tensors(struct normalcycle_result *result, const struct normalcycle_mesh *mesh, const struct normalcycle_options *options)
{
	struct cycle cycle = {.mesh = mesh, .options = options};
	const ptrdiff_t count = (ptrdiff_t)mesh->wedge_count;
	const size_t face_count = mesh->half->face_count;
	double *radius = mem_array(mesh->wedge_count, sizeof *radius);
	unsigned char *is_set = mem_array(mesh->wedge_count, 1);
	collect_corners(&cycle);
	find_bent_components(&cycle);
	measure_mesh(&cycle);
#pragma omp parallel
	{
		struct scratch scratch;
		scratch_new(&scratch, face_count);
#pragma omp for schedule(dynamic, 64)
		for (ptrdiff_t w = 0; w < count; w++) {
			wedge_normal(result->normal + 3 * w, &cycle, (size_t)w);
			radius[w] = options->radius;
			if (!(options->radius > 0) && cycle.is_bent[w])
				radius[w] = automatic_radius(facet_width(&cycle, &scratch, (size_t)w), options);
		}
#pragma omp for schedule(dynamic, 64)
		for (ptrdiff_t w = 0; w < count; w++) {
			const double r = options->radius > 0 ? options->radius : smoothed_radius(&cycle, radius, (size_t)w);
			is_set[w] = compute_wedge(result, &cycle, &scratch, (size_t)w, r);
		}
		scratch_free(&scratch);
	}
	struct scratch scratch;
	scratch_new(&scratch, face_count);
	for (ptrdiff_t w = 0; w < count; w++)
		if (!is_set[w])
			copy_nearest(result, &cycle, &scratch, (size_t)w, is_set);
	scratch_free(&scratch);
	free(cycle.corner_start);
	free(cycle.corner);
	free(cycle.is_bent);
	free(cycle.height);
	free(cycle.bends);
	free(cycle.plane);
	free(cycle.edge);
	free(cycle.along);
	free(radius);
	free(is_set);
}
