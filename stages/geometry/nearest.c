/* Nearest points on a triangle mesh: Embree 3 finds the candidates, double precision decides.
 *
 * Embree works in single precision. The mesh is centred and scaled to the cube [-1, 1]^3 for it, and every radius
 * that it gets is a little larger than the true one, by more than all its roundings together; each triangle that it
 * reports is then measured in the caller's own coordinates. So the answer is the one that a search of all triangles
 * in double precision would give, whatever the shape of the tree. */
#include "stages/geometry/nearest.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "formats/fault.h"
#include "stages/geometry/labeltree.h"
#include "stages/geometry/vector.h"

/* Bounds for Embree's roundings. Vertices lie in [-1, 1], so storing one as float moves it by at most 2^-24 * sqrt(3);
 * a query point q likewise by 2^-24 * |q|; a box distance takes five more operations. 8 * 2^-24 covers their sum. */
#define SINGLE_SLACK (8.0 / 16777216.0)
/* Queries farther out than this (in half sides of the box) would overflow squares in single precision. */
#define SINGLE_FAR 1e15
/* Far more than the rounding errors of a dozen operations in doubles, as a share of the numbers that went in. */
#define ROUNDING 1e-13

/* A triangle lies within its height of the line through its longest side. */
struct ridge {
	double direction[3]; /* unit; 0 for a point */
	double height;       /* and all rounding errors */
	double from[3];      /* a point on the line */
};

struct nearest {
	const double *xyz;
	const idx_t *triangle;
	size_t triangle_count;
	double *normal;             /* 3 a triangle, unit; 0 for one without area */
	struct ridge *ridge;        /* a triangle */
	/* Either the labels' tree */
	struct label_tree *tree;
	const idx_t *label;
	/* or Embree's. */
	double centre[3], half_side;
	RTCDevice device;
	RTCScene scene;
};

struct query {
	const struct nearest *nearest;
	const struct nearest_filter *filter;
	const double *p;
	double slack;               /* absolute, in Embree's units */
	bool only_preferred;        /* skip triangles that the filter's normal does not like */
	struct foot foot;
};

/* Squared distance. */
static double segment_foot(double point[3], double *along, const double p[3], const double a[3], const double b[3])
{
	double ab[3], ap[3];
	sub3(ab, b, a);
	sub3(ap, p, a);
	const double whole = dot3(ab, ab), part = dot3(ap, ab);
	if (!(part > 0) || !(whole > 0)) {
		*along = 0;
		copy3(point, a);
	} else if (part >= whole) {
		*along = 1;
		copy3(point, b);
	} else {
		*along = part / whole;
		copy3(point, a);
		add_scaled3(point, *along, ab);
	}
	double offset[3];
	sub3(offset, p, point);
	return dot3(offset, offset);
}

static bool comes_before(const double a[3], const double b[3])
{
	for (int i = 0; i < 3; i++)
		if (a[i] != b[i])
			return a[i] < b[i];
	return false;
}

/* Rounding errors of the weights are far below least_weight while their condition (squared) is below most_condition. */
static const double least_weight = 1e-6, most_condition = 1e16;

/* The weights of the foot in the plane say which sides see p: the nearest point lies on one of them, or inside when there is none.
 * Slivers, whose weights are quotients of rounding errors, try all sides and the inside. A side is always run through from its
 * lexicographically lower end, so that the two triangles of an edge give the same bits and the tie rule holds. */
double nearest_on_triangle(double point[3], double weight[3], const double p[3], const double a[3], const double b[3], const double c[3])
{
	double ab[3], ac[3], ap[3], n[3], m[3], inner[3];
	sub3(ab, b, a);
	sub3(ac, c, a);
	sub3(ap, p, a);
	cross3(n, ab, ac);
	const double nn = dot3(n, n);
	cross3(m, ap, ac);
	inner[1] = dot3(m, n) / nn;
	cross3(m, ab, ap);
	inner[2] = dot3(m, n) / nn;
	inner[0] = 1 - inner[1] - inner[2];
	const bool is_sliver = !(dot3(ap, ap) * fmax(dot3(ab, ab), dot3(ac, ac)) < most_condition * nn);
	const double *const corner[3] = {a, b, c};
	double best = INFINITY;
	copy3(point, a);
	weight[0] = 1, weight[1] = weight[2] = 0;
	for (int k = 0; k < 3; k++) {
		if (!is_sliver && inner[k == 0 ? 2 : k - 1] > least_weight)
			continue;
		int from = k, to = k == 2 ? 0 : k + 1;
		if (comes_before(corner[to], corner[from])) {
			const int swap = from;
			from = to, to = swap;
		}
		double foot[3], along;
		const double squared = segment_foot(foot, &along, p, corner[from], corner[to]);
		if (squared < best) {
			best = squared;
			copy3(point, foot);
			weight[0] = weight[1] = weight[2] = 0;
			weight[from] = 1 - along;
			weight[to] += along;
		}
	}
	if (inner[0] > 0 && inner[1] > 0 && inner[2] > 0) { /* false for the NaN of a triangle without area */
		double foot[3], offset[3];
		copy3(foot, a);
		add_scaled3(foot, inner[1], ab);
		add_scaled3(foot, inner[2], ac);
		sub3(offset, p, foot);
		const double squared = dot3(offset, offset);
		if (squared < best) {
			best = squared;
			copy3(point, foot);
			copy3(weight, inner);
		}
	}
	return sqrt(best);
}

static _Noreturn void embree_failed(RTCDevice device)
{
	/* The ways to fail here: memory, nearly always, or an installation without a usable back end. Exit 4 as mem_array does. */
	char text[100];
	snprintf(text, sizeof text, "out of memory: the nearest-point tree could not be built: Embree error %d", (int)rtcGetDeviceError(device));
	mem_fail(text);
}

static struct nearest *start(const double *xyz, const idx_t *triangle, size_t triangle_count)
{
	struct nearest *nearest = mem_array(1, sizeof *nearest);
	nearest->xyz = xyz;
	nearest->triangle = triangle;
	nearest->triangle_count = triangle_count;
	nearest->normal = mem_array(3 * triangle_count, sizeof *nearest->normal);
	nearest->half_side = 1;
	nearest->ridge = mem_array(triangle_count, sizeof *nearest->ridge);
	return nearest;
}

static void measure_ridge(struct ridge *ridge, const double *xyz, const idx_t corner[3], double doubled_area)
{
	double longest = 0;
	*ridge = (struct ridge){.height = 0};
	copy3(ridge->from, xyz + 3 * (size_t)corner[0]);
	for (int k = 0; k < 3; k++) {
		double side[3];
		sub3(side, xyz + 3 * (size_t)corner[(k + 1) % 3], xyz + 3 * (size_t)corner[k]);
		const double length = norm3(side);
		if (length > longest) {
			longest = length;
			copy3(ridge->from, xyz + 3 * (size_t)corner[k]);
			copy3(ridge->direction, side);
		}
	}
	normalise3(ridge->direction);
	ridge->height = (longest > 0 ? doubled_area / longest : 0) + ROUNDING * (longest + norm3(ridge->from));
}

static void measure_triangles(struct nearest *nearest)
{
	for (size_t t = 0; t < nearest->triangle_count; t++) {
		const idx_t *corner = nearest->triangle + 3 * t;
		double *normal = nearest->normal + 3 * t;
		area_vector3(normal, nearest->xyz + 3 * (size_t)corner[0], nearest->xyz + 3 * (size_t)corner[1], nearest->xyz + 3 * (size_t)corner[2]);
		measure_ridge(&nearest->ridge[t], nearest->xyz, corner, norm3(normal));
		normalise3(normal);
	}
}

/* Slivers as long as the part are candidates everywhere along it: most of them are told to be out of reach by the line that they
 * lie around, which is a tenth of the work of measuring them. */
static bool is_beyond(const struct nearest *nearest, const double p[3], size_t t, double reach)
{
	const struct ridge *ridge = &nearest->ridge[t];
	double offset[3];
	sub3(offset, p, ridge->from);
	const double along = dot3(offset, ridge->direction), squared = dot3(offset, offset), wide = reach + ridge->height;
	return squared - along * along > (1 + ROUNDING) * wide * wide + ROUNDING * (squared + dot3(p, p));
}

struct nearest *nearest_new_labelled(const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count, const idx_t *label)
{
	(void)vertex_count; /* as nearest_new has it */
	struct nearest *nearest = start(xyz, triangle, triangle_count);
	nearest->label = label;
	if (triangle_count > 0)
		nearest->tree = label_tree_new(xyz, triangle, triangle_count, label);
	measure_triangles(nearest);
	return nearest;
}

void nearest_move(struct nearest *nearest)
{
	if (nearest->tree)
		label_tree_refit(nearest->tree);
	measure_triangles(nearest);
}

struct nearest *nearest_new(const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count)
{
	struct nearest *nearest = start(xyz, triangle, triangle_count);
	if (triangle_count == 0)
		return nearest;

	/* The box of the triangles, not of the vertices: one stray vertex far away would cost all precision. */
	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
	for (size_t i = 0; i < 3 * triangle_count; i++)
		for (int k = 0; k < 3; k++) {
			const double x = xyz[3 * (size_t)triangle[i] + k];
			low[k] = fmin(low[k], x);
			high[k] = fmax(high[k], x);
		}
	double half_side = 0;
	for (int k = 0; k < 3; k++) {
		nearest->centre[k] = low[k] / 2 + high[k] / 2;
		half_side = fmax(half_side, high[k] / 2 - low[k] / 2);
	}
	if (half_side > 0)
		nearest->half_side = half_side;

	nearest->device = rtcNewDevice(NULL);
	if (nearest->device == NULL)
		embree_failed(NULL);
	nearest->scene = rtcNewScene(nearest->device);
	rtcSetSceneFlags(nearest->scene, RTC_SCENE_FLAG_ROBUST);
	const RTCGeometry geometry = rtcNewGeometry(nearest->device, RTC_GEOMETRY_TYPE_TRIANGLE);
	float *position = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
	                                          vertex_count);
	unsigned *corner = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
	                                           triangle_count);
	if (position == NULL || corner == NULL)
		embree_failed(nearest->device);
	for (size_t i = 0; i < 3 * vertex_count; i++) {
		const double x = (xyz[i] - nearest->centre[i % 3]) / nearest->half_side;
		position[i] = (float)fmax(-2, fmin(2, x)); /* beyond 1: a vertex without triangle */
	}
	for (size_t i = 0; i < 3 * triangle_count; i++)
		corner[i] = (unsigned)triangle[i];
	measure_triangles(nearest);
	rtcCommitGeometry(geometry);
	rtcAttachGeometry(nearest->scene, geometry);
	rtcReleaseGeometry(geometry);
	rtcCommitScene(nearest->scene);
	if (rtcGetDeviceError(nearest->device) != RTC_ERROR_NONE)
		embree_failed(nearest->device);
	return nearest;
}

void nearest_free(struct nearest *nearest)
{
	if (nearest == NULL)
		return;
	if (nearest->device != NULL) {
		rtcReleaseScene(nearest->scene);
		rtcReleaseDevice(nearest->device);
	}
	label_tree_free(nearest->tree);
	free(nearest->normal);
	free(nearest->ridge);
	free(nearest);
}

/* A radius in model units as Embree needs it: in its units, and larger than all its errors. */
static float single_radius(const struct nearest *nearest, double radius, double slack)
{
	const double r = radius / nearest->half_side * (1 + SINGLE_SLACK) + slack;
	return r < 1e18 ? (float)r : INFINITY;
}

static double triangle_foot(double point[3], double weight[3], const struct nearest *nearest, const double p[3], size_t t)
{
	const idx_t *corner = nearest->triangle + 3 * t;
	return nearest_on_triangle(point, weight, p, nearest->xyz + 3 * (size_t)corner[0], nearest->xyz + 3 * (size_t)corner[1],
	                           nearest->xyz + 3 * (size_t)corner[2]);
}

/* Measure one candidate; true when it is the best so far. */
static bool consider(struct query *query, size_t t)
{
	const struct nearest *nearest = query->nearest;
	const struct nearest_filter *filter = query->filter;
	if ((idx_t)t == query->foot.triangle)
		return false;
	if (filter != NULL && filter->label != NULL && filter->label[t] != filter->only)
		return false;
	if (query->only_preferred && !(dot3(nearest->normal + 3 * t, filter->normal) > filter->least_dot))
		return false;
	if (is_beyond(nearest, query->p, t, query->foot.distance))
		return false;
	struct foot foot;
	foot.triangle = (idx_t)t;
	foot.distance = triangle_foot(foot.point, foot.weight, nearest, query->p, t);
	struct foot *best = &query->foot;
	if (!(foot.distance < best->distance || (foot.distance == best->distance && (best->triangle == NO_INDEX || foot.triangle < best->triangle))))
		return false;
	*best = foot;
	return true;
}

static bool on_candidate(struct RTCPointQueryFunctionArguments *arguments)
{
	struct query *query = arguments->userPtr;
	if (!consider(query, arguments->primID))
		return false;
	const float radius = single_radius(query->nearest, query->foot.distance, query->slack);
	if (!(radius < arguments->query->radius))
		return false;
	arguments->query->radius = radius;
	return true;
}

/* Fill an Embree query around p; false when single precision cannot hold it. */
static bool single_query(struct RTCPointQuery *single, double *slack, const struct nearest *nearest, const double p[3])
{
	double q[3], far = 1;
	for (int k = 0; k < 3; k++) {
		q[k] = (p[k] - nearest->centre[k]) / nearest->half_side;
		far = fmax(far, fabs(q[k]));
	}
	single->x = (float)q[0];
	single->y = (float)q[1];
	single->z = (float)q[2];
	single->time = 0;
	*slack = SINGLE_SLACK * far;
	return far < SINGLE_FAR;
}

static double on_near_triangle(void *user, idx_t triangle)
{
	struct query *query = user;
	consider(query, (size_t)triangle);
	return query->foot.distance;
}

static void search(struct query *query, double max_distance)
{
	const struct nearest *nearest = query->nearest;
	const struct nearest_filter *filter = query->filter;
	query->foot.triangle = NO_INDEX;
	query->foot.distance = max_distance;
	if (filter != NULL && filter->hint > 0 && (size_t)filter->hint <= nearest->triangle_count)
		consider(query, (size_t)filter->hint - 1);
	if (nearest->tree) {
		const bool only_label = filter != NULL && filter->label == nearest->label;
		label_tree_search(nearest->tree, query->p, query->foot.distance, only_label, only_label ? filter->only : 0, on_near_triangle, query);
		return;
	}
	struct RTCPointQuery single;
	if (!single_query(&single, &query->slack, nearest, query->p)) {
		for (size_t t = 0; t < nearest->triangle_count; t++)
			consider(query, t);
		return;
	}
	single.radius = single_radius(nearest, query->foot.distance, query->slack);
	struct RTCPointQueryContext context;
	rtcInitPointQueryContext(&context);
	rtcPointQuery(nearest->scene, &single, &context, on_candidate, query);
}

struct foot nearest_point(const struct nearest *nearest, const double p[3], double max_distance, const struct nearest_filter *filter)
{
	struct query query = {.nearest = nearest, .filter = filter, .p = p};
	query.foot.triangle = NO_INDEX;
	query.foot.distance = INFINITY;
	if (nearest->triangle_count == 0 || !isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]) || !(max_distance >= 0))
		return query.foot;
	search(&query, max_distance);
	if (query.foot.triangle == NO_INDEX) {
		query.foot.distance = INFINITY;
		return query.foot;
	}
	if (filter != NULL && filter->normal != NULL &&
	    !(dot3(nearest->normal + 3 * (size_t)query.foot.triangle, filter->normal) > filter->least_dot)) {
		struct query preferred = query;
		preferred.only_preferred = true;
		search(&preferred, fmin(max_distance, filter->reach * query.foot.distance + filter->slack));
		if (preferred.foot.triangle != NO_INDEX)
			query.foot = preferred.foot;
	}
	copy3(query.foot.normal, nearest->normal + 3 * (size_t)query.foot.triangle);
	return query.foot;
}

struct visit {
	struct query query;
	double radius;
	nearest_visitor *visitor;
	void *user;
};

static void visit_one(struct visit *visit, size_t t)
{
	if (is_beyond(visit->query.nearest, visit->query.p, t, visit->radius))
		return;
	double point[3], weight[3];
	const double distance = triangle_foot(point, weight, visit->query.nearest, visit->query.p, t);
	if (distance <= visit->radius)
		visit->visitor(visit->user, (idx_t)t, point, distance);
}

static bool on_visit(struct RTCPointQueryFunctionArguments *arguments)
{
	visit_one(arguments->userPtr, arguments->primID);
	return false;
}

static double on_visit_near(void *user, idx_t triangle)
{
	struct visit *visit = user;
	visit_one(visit, (size_t)triangle);
	return visit->radius;
}

void nearest_within(const struct nearest *nearest, const double p[3], double radius, nearest_visitor *visitor, void *user)
{
	if (nearest->triangle_count == 0 || !isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]) || !(radius >= 0))
		return;
	struct visit visit = {.query = {.nearest = nearest, .p = p}, .radius = radius, .visitor = visitor, .user = user};
	if (nearest->tree) {
		label_tree_search(nearest->tree, p, radius, false, 0, on_visit_near, &visit);
		return;
	}
	struct RTCPointQuery single;
	if (!single_query(&single, &visit.query.slack, nearest, p)) {
		for (size_t t = 0; t < nearest->triangle_count; t++)
			visit_one(&visit, t);
		return;
	}
	single.radius = single_radius(nearest, radius, visit.query.slack);
	struct RTCPointQueryContext context;
	rtcInitPointQueryContext(&context);
	rtcPointQuery(nearest->scene, &single, &context, on_visit, &visit);
}

const double *nearest_normal(const struct nearest *nearest, idx_t triangle)
{
	return nearest->normal + 3 * (size_t)triangle;
}
