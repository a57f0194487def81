/* Joint squared-distance fit of a cage.
 *
 * Limit samples of the cage are pulled to their feet on the target (forward), target samples pull the surface under them
 * (reverse: without it nothing covers a target area that the cage does not reach); both through quadratic forms that let samples
 * slide where the target does not bend (Pottmann and Hofer 2003). Every iteration solves one sparse system for all points. */
#include "stages/fitpatch/joint.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/fitpatch/frame.h"
#include "stages/fitpatch/joint_normal.h"
#include "stages/fitpatch/joint_terms.h"
#include "stages/geometry/lsq.h"
#include "stages/geometry/vector.h"

static const double curve_weight = 3;        /* of a crease sample against a surface sample of the same area */
static const double node_weight = 10;
static const double reverse_weight = 0.5;
static const double slide = 0.003;          /* isotropic share of every metric: little, or samples could not slide */
/* Pull of points inside patches to the middle of their neighbours. The data leave them free to slide along the surface: where there
 * are many, in free forms, faces would fold over each other (of a smooth scan 2.4 % of the area with 1e-4, 0.08 % with 1e-2). */
static const double fairness = 1e-3, free_fairness = 1e-2;
/* Pull of every point to where it is, as a share of the mean diagonal entry; where a step overshoots, so many times more. */
static const double proximal = 1e-3, caution = 100;
/* A fit that gains less than this share of its error in a step has settled. Between rounds of refinement more would be lost again; of
 * the error in the end 0.1 % is left. */
static const double settled_gain = 0.002;

/* Where a sample on a crease goes. */
struct curve_foot {
	double point[3], tangent[3];
	bool found;
};

struct system {
	const struct draft *draft;
	const struct target *target;
	const struct joint_options *options;
	struct terms *terms;
	struct chain_index *chains;
	struct nearest *nearest; /* on the samples' triangles */
	struct normal_sums sums;
	struct lsq *lsq;
	double *xyz;         /* 3 a cage vertex, current */
	const double *node;  /* where the network's control points were: targets of nodes, 3 a control point */
	unsigned char *fixed;
	double area;         /* of all samples */
	double scale;        /* mean diagonal entry of the samples' terms */
	/* Feet at the current positions, and where to look for them next time. */
	struct foot *forward, *reverse; /* a sample; a sample of the target */
	struct curve_foot *curve;       /* a sample */
	idx_t *hint;                    /* 2 a sample */
};

static void add_isotropic(double metric[6])
{
	metric[0] += slide, metric[3] += slide, metric[5] += slide;
}

/* Find all feet. Returns the area-weighted mean distance of the samples plus the mean distance of the target's. */
static double find_feet(struct system *system)
{
	struct terms *terms = system->terms;
	const struct target *target = system->target;
	const size_t n = terms->level.vertex_count;
	sparse_apply(terms->level.xyz, &terms->rows, system->xyz);
	nearest_move(system->nearest);
#pragma omp parallel for schedule(dynamic, 64)
	for (size_t s = 0; s < n; s++) {
		struct curve_foot *curve = &system->curve[s];
		if (terms->kind[s] == SAMPLE_SURFACE)
			system->forward[s] = terms_foot(terms, target, s, &system->hint[2 * s]);
		else if (terms->kind[s] == SAMPLE_CURVE)
			curve->found = chain_nearest(curve->point, curve->tangent, system->chains, terms->patch[s], terms->patch2[s], &terms->level.xyz[3 * s]);
	}
	terms_feet_of_target(system->reverse, terms, target, system->nearest);
	double forward = 0, reverse = 0;
	for (size_t s = 0; s < n; s++)
		if (terms->kind[s] == SAMPLE_SURFACE && system->forward[s].triangle != NO_INDEX)
			forward += terms->area[s] * system->forward[s].distance;
		else if (terms->kind[s] == SAMPLE_CURVE && system->curve[s].found)
			forward += terms->area[s] * distance3(&terms->level.xyz[3 * s], system->curve[s].point);
	for (size_t s = 0; s < target->sample_count; s++)
		if (system->reverse[s].triangle != NO_INDEX)
			reverse += system->reverse[s].distance;
	return forward / system->area + (target->sample_count ? reverse / (double)target->sample_count : 0);
}

static void add_forward(struct system *system)
{
	const struct terms *terms = system->terms;
	for (size_t s = 0; s < terms->level.vertex_count; s++) {
		const double *p = &terms->level.xyz[3 * s];
		const double weight = terms->area[s] / system->area;
		double metric[6], offset[3];
		if (terms->kind[s] == SAMPLE_SURFACE && system->forward[s].triangle != NO_INDEX) {
			const struct foot *foot = &system->forward[s];
			struct frame frame;
			frame_at(&frame, system->target->dense, foot);
			sub3(offset, p, foot->point);
			sqdist_surface(metric, frame.normal, frame.e1, frame.k1, frame.k2, dot3(offset, frame.normal), system->options->variant);
			add_isotropic(metric);
			normal_add_vertex(&system->sums, s, foot->point, metric, weight);
		} else if (terms->kind[s] == SAMPLE_CURVE && system->curve[s].found) {
			const struct curve_foot *curve = &system->curve[s];
			const double straight[3] = {0, 0, 0};
			sub3(offset, p, curve->point);
			/* The polyline's own curvature is all in its corners: tangent distance, with the proximal term against overshoot. */
			sqdist_curve(metric, curve->tangent, straight, offset, SQDIST_TANGENT);
			add_isotropic(metric);
			normal_add_vertex(&system->sums, s, curve->point, metric, curve_weight * weight);
		}
	}
}

static void add_reverse(struct system *system)
{
	const struct target *target = system->target;
	for (size_t s = 0; s < target->sample_count; s++) {
		const struct foot *foot = &system->reverse[s];
		if (foot->triangle == NO_INDEX)
			continue;
		const double *normal = nearest_normal(target->nearest, target->sample_triangle[s]);
		double metric[6] = {normal[0] * normal[0], normal[0] * normal[1], normal[0] * normal[2],
		                    normal[1] * normal[1], normal[1] * normal[2], normal[2] * normal[2]};
		add_isotropic(metric);
		normal_add_point(&system->sums, (size_t)foot->triangle, foot->weight, &target->sample[3 * s], metric,
		                 reverse_weight / (double)target->sample_count);
	}
}

/* Points inside patches are drawn to the middle of their neighbours; nodes to where the network had them. */
static void add_regularity(struct system *system)
{
	const struct terms *terms = system->terms;
	const struct cage *cage = &terms->cage;
	const double scale = system->scale = lsq_scale(system->lsq);
	const size_t n = cage->vertex_count;
	idx_t *degree = mem_array(n, sizeof *degree), *patch = mem_array(n, sizeof *patch);
	double *middle = mem_array(3 * n, sizeof *middle);
	for (size_t f = 0; f < cage->face_count; f++)
		for (size_t i = cage->face_start[f]; i < cage->face_start[f + 1]; i++) {
			const idx_t a = cage->face_corner[i], b = cage->face_corner[i + 1 < cage->face_start[f + 1] ? i + 1 : cage->face_start[f]];
			patch[a] = cage->face_patch[f];
			degree[a]++; /* inside a closed fan every neighbour comes once */
			add_scaled3(&middle[3 * (size_t)a], 1, &system->xyz[3 * (size_t)b]);
		}
	for (size_t v = 0; v < n; v++) {
		const idx_t point = terms->control_of[v];
		const unsigned char role = system->draft->control.role[point];
		if (role == POINT_INSIDE) {
			scale3(&middle[3 * v], 1.0 / degree[v]);
			const bool is_free = system->target->dense->patch[patch[v]].kind == PATCH_FREE;
			lsq_add_point(system->lsq, (idx_t)v, &middle[3 * v], (is_free ? free_fairness : fairness) * scale);
		} else if (role != POINT_CREASE && terms->kind[v] == SAMPLE_NODE) {
			lsq_add_point(system->lsq, (idx_t)v, &system->node[3 * (size_t)point], node_weight * terms->area[v] / system->area);
		}
	}
	free(degree), free(patch), free(middle);
}

static void add_proximal(struct system *system, double share)
{
	for (size_t v = 0; v < system->terms->cage.vertex_count; v++)
		lsq_add_point(system->lsq, (idx_t)v, &system->xyz[3 * v], share * system->scale);
}

/* Go to next, but no point farther than its nearest neighbour is: the quadratic forms mean little beyond. */
static void move_points(struct system *system, const double *next)
{
	const struct cage *cage = &system->terms->cage;
	double *reach = mem_array(cage->vertex_count, sizeof *reach);
	for (size_t v = 0; v < cage->vertex_count; v++)
		reach[v] = INFINITY;
	for (size_t f = 0; f < cage->face_count; f++)
		for (size_t i = cage->face_start[f]; i < cage->face_start[f + 1]; i++) {
			const idx_t a = cage->face_corner[i], b = cage->face_corner[i + 1 < cage->face_start[f + 1] ? i + 1 : cage->face_start[f]];
			const double length = distance3(&system->xyz[3 * (size_t)a], &system->xyz[3 * (size_t)b]);
			reach[a] = fmin(reach[a], length), reach[b] = fmin(reach[b], length);
		}
	for (size_t v = 0; v < cage->vertex_count; v++) {
		double step[3];
		sub3(step, &next[3 * v], &system->xyz[3 * v]);
		const double length = norm3(step);
		add_scaled3(&system->xyz[3 * v], length > reach[v] ? reach[v] / length : 1, step);
	}
	free(reach);
}

bool joint_fit(struct draft *draft, const struct target *target, const struct joint_options *options, const unsigned char *still, struct fault *fault)
{
	struct terms terms;
	if (!terms_make(&terms, draft, target->dense, options->steps, true, fault))
		return false;
	const size_t n = terms.cage.vertex_count;
	struct system system = {.draft = draft, .target = target, .options = options, .terms = &terms};
	system.chains = chain_index_new(target->border, target->dense->xyz);
	system.xyz = mem_copy(terms.cage.xyz, 3 * n, sizeof(double));
	double *start = mem_copy(draft->control.xyz, 3 * draft->control.count, sizeof(double));
	system.node = start;
	system.fixed = mem_array(n, 1);
	for (size_t v = 0; v < n; v++)
		system.fixed[v] = draft->control.held[terms.control_of[v]] || (still && still[terms.control_of[v]]);
	for (size_t s = 0; s < terms.level.vertex_count; s++)
		system.area += terms.area[s];
	const size_t samples = terms.level.vertex_count;
	system.forward = mem_array(samples, sizeof *system.forward);
	system.curve = mem_array(samples, sizeof *system.curve);
	system.hint = mem_array(2 * samples, sizeof *system.hint);
	system.reverse = mem_array(target->sample_count, sizeof *system.reverse);
	for (size_t s = 0; s < target->sample_count; s++)
		system.reverse[s].triangle = NO_INDEX;
	system.nearest = nearest_new_labelled(terms.level.xyz, samples, terms.triangle, terms.triangle_count, terms.triangle_surface);
	normal_begin(&system.sums, &terms, system.fixed);
	system.lsq = lsq_new(n, system.xyz, system.fixed);
	double *next = mem_array(3 * n, sizeof *next), *best = mem_copy(system.xyz, 3 * n, sizeof(double));
	double least = INFINITY, step = proximal;
	bool overshot = false;
	for (int iteration = 0; iteration <= options->iterations; iteration++) {
		const double error = find_feet(&system);
		if (error < least) {
			const bool settled = least - error < settled_gain * least;
			least = error, overshot = false;
			memcpy(best, system.xyz, 3 * n * sizeof *best);
			if (settled || iteration == options->iterations)
				break;
			normal_clear(&system.sums);
			lsq_clear(system.lsq);
			add_forward(&system);
			add_reverse(&system);
			normal_carry(&system.sums, system.lsq);
			add_regularity(&system);
			add_proximal(&system, step);
		} else {
			if (iteration == 0 || overshot)
				break;
			/* Go back and take a shorter step from there: the system is still the one of the best positions. */
			overshot = true;
			memcpy(system.xyz, best, 3 * n * sizeof *best);
			add_proximal(&system, (caution - 1) * step);
			step *= caution;
		}
		if (!lsq_solve(system.lsq, next))
			break;
		move_points(&system, next);
	}
	for (size_t v = 0; v < n; v++)
		copy3(&draft->control.xyz[3 * (size_t)terms.control_of[v]], &best[3 * v]);
	free(next), free(best), free(start), free(system.xyz), free(system.fixed);
	free(system.forward), free(system.reverse), free(system.curve), free(system.hint);
	lsq_free(system.lsq);
	normal_end(&system.sums);
	nearest_free(system.nearest);
	chain_index_free(system.chains);
	terms_free(&terms);
	return true;
}

/* One distance goes into a patch's sums. */
struct tally {
	double sum[2], weight[2], normal_sum;
};

static void note_worst(struct patch_error *error, struct face_error *face_error, double distance, idx_t face, const double point[3])
{
	if (face_error && distance > face_error[face].distance)
		face_error[face].distance = distance;
	if (distance > error->max) {
		error->max = distance;
		error->worst_face = face;
		copy3(error->worst_point, point);
	}
}

/* Triangles of the refined surface against the normals of the target under their corners. */
static void measure_folds(struct patch_error *error, size_t patch_count, struct face_error *face_error, const struct terms *terms, const struct foot *feet)
{
	double *largest = mem_array(patch_count, sizeof *largest); /* folded triangle of each patch */
	for (size_t t = 0; t < terms->triangle_count; t++) {
		const idx_t *v = &terms->triangle[3 * t];
		const double *a = &terms->level.xyz[3 * (size_t)v[0]], *b = &terms->level.xyz[3 * (size_t)v[1]], *c = &terms->level.xyz[3 * (size_t)v[2]];
		double normal[3], under[3] = {0, 0, 0};
		area_vector3(normal, a, b, c);
		for (int k = 0; k < 3; k++)
			add_scaled3(under, 1, feet[v[k]].normal);
		if (dot3(normal, under) >= 0)
			continue;
		struct patch_error *patch = &error[terms->triangle_patch[t]];
		const double area = norm3(normal) / 2;
		patch->folded += area;
		if (face_error)
			face_error[terms->triangle_face[t]].folded += area;
		if (area > largest[terms->triangle_patch[t]]) {
			largest[terms->triangle_patch[t]] = area;
			for (int k = 0; k < 3; k++)
				patch->fold_point[k] = (a[k] + b[k] + c[k]) / 3;
		}
	}
	free(largest);
}

bool joint_measure(struct patch_error *error, struct face_error *face_error, size_t patch_count, const struct draft *draft, const struct target *target, struct fault *fault)
{
	struct terms terms;
	if (!terms_make(&terms, draft, target->dense, 3, false, fault))
		return false;
	for (size_t p = 0; p < patch_count; p++)
		error[p] = (struct patch_error){.worst_face = NO_INDEX};
	if (face_error)
		memset(face_error, 0, draft->polygons.count * sizeof *face_error);
	struct tally *tally = mem_array(patch_count, sizeof *tally);
	const size_t n = terms.level.vertex_count;
	struct foot *feet = mem_array(n > target->sample_count ? n : target->sample_count, sizeof *feet);
#pragma omp parallel for schedule(dynamic, 64)
	for (size_t s = 0; s < n; s++) {
		idx_t hint[2] = {0, 0};
		feet[s] = terms_foot(&terms, target, s, hint);
	}
	idx_t *face_of = mem_array(n, sizeof *face_of);
	for (size_t t = terms.triangle_count; t-- > 0;)
		for (int k = 0; k < 3; k++)
			face_of[terms.triangle[3 * t + (size_t)k]] = terms.triangle_face[t];
	for (size_t s = 0; s < n; s++) {
		if (feet[s].triangle == NO_INDEX)
			continue;
		const size_t p = (size_t)terms.patch[s];
		tally[p].sum[0] += terms.area[s] * feet[s].distance;
		tally[p].weight[0] += terms.area[s];
		note_worst(&error[p], face_error, feet[s].distance, face_of[s], &terms.level.xyz[3 * s]);
	}
	measure_folds(error, patch_count, face_error, &terms, feet);
	struct nearest *nearest = nearest_new_labelled(terms.level.xyz, n, terms.triangle, terms.triangle_count, terms.triangle_surface);
	for (size_t s = 0; s < target->sample_count; s++)
		feet[s].triangle = NO_INDEX;
	terms_feet_of_target(feet, &terms, target, nearest);
	const double *dense = target->dense->xyz;
	for (size_t s = 0; s < target->sample_count; s++) {
		if (feet[s].triangle == NO_INDEX)
			continue;
		const size_t p = (size_t)target->dense->label[target->sample_triangle[s]];
		const idx_t *t = &target->dense->triangle[3 * (size_t)target->sample_triangle[s]];
		double normal[3];
		area_vector3(normal, &dense[3 * (size_t)t[0]], &dense[3 * (size_t)t[1]], &dense[3 * (size_t)t[2]]);
		tally[p].sum[1] += feet[s].distance;
		tally[p].weight[1] += 1;
		tally[p].normal_sum += angle3(normal, feet[s].normal) * DEGREES;
		note_worst(&error[p], face_error, feet[s].distance, terms.triangle_face[feet[s].triangle], &target->sample[3 * s]);
	}
	nearest_free(nearest);
	for (size_t p = 0; p < patch_count; p++) {
		const double forward = tally[p].weight[0] > 0 ? tally[p].sum[0] / tally[p].weight[0] : 0;
		const double reverse = tally[p].weight[1] > 0 ? tally[p].sum[1] / tally[p].weight[1] : forward;
		error[p].mean = (forward + reverse) / 2;
		error[p].normal_deg = tally[p].weight[1] > 0 ? tally[p].normal_sum / tally[p].weight[1] : 0;
	}
	free(tally), free(feet), free(face_of);
	terms_free(&terms);
	return true;
}
