/* Cages by edge collapse. */
#include "stages/fitpatch/collapse.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "formats/shim/openmesh.h"
#include "stages/fitpatch/facet.h"
#include "stages/fitpatch/local.h"
#include "stages/fitpatch/seam.h"
#include "stages/fitpatch/sharpcurve.h"
#include "stages/fitpatch/touchup.h"
#include "stages/geometry/vector.h"

/* Distances that are tried, in mean bounds: from the first down by the step, as smooth surfaces are better than the facets that the
 * collapse measures. */
static const double first_distance = 12, distance_step = 0.6, least_step = 0.3, most_step = 0.75;
enum { DISTANCES = 9 };
/* The first one of facets that stay facets. */
static const double first_facets = 2;
/* A larger mesh takes ten seconds and more for a try: facets alone are tried. */
enum { MOST_TRIANGLES = 150000 };
/* From this many on, a cage whose mean is good and whose largest error is so many bounds is the last one: finer ones would hardly be within. */
enum { PATIENT_TRIANGLES = 50000, FAR_BOUNDS = 3 };
/* Work of all tries together (struct rounds): while nothing is within the bounds, and when something is; and faces of a cage that is worth it. */
enum { MOST_WORK = 12000, WORK_WITHIN = 2500, MOST_FACES = 6000 };
/* A collapsed cage takes the place of one within the bounds below this share of its bytes: points without a pattern cost more. */
static const double smaller = 0.85;
/* With folds on more than this share of the area, one without them (less than half) may be larger. */
static const double seen_folds = 1e-3, larger_unfolded = 1.3;
/* Or of about the same size, with this share of the mean error. */
static const double much_closer = 0.7, same_size = 1;
/* Sharp edges keep within this share of the bound of the largest error, as those of fitted curves do. */
static const double sharp_share = 0.5;
/* Bytes of a packed point and face, about. */
static const double point_bytes = 2.3, face_bytes = 0.4;

/* Both ends of every side of every chain. */
static idx_t *chain_edges(size_t *count, const struct border_network *border)
{
	idx_t *edge = mem_array(2 * (border->vertex_count + border->chain_count), sizeof *edge);
	*count = 0;
	for (size_t c = 0; c < border->chain_count; c++) {
		const struct border_chain *chain = &border->chain[c];
		const idx_t *vertex = &border->vertex[chain->first];
		for (size_t i = 0; i + !chain->closed < chain->count; i++, ++*count)
			edge[2 * *count] = vertex[i], edge[2 * *count + 1] = vertex[(i + 1) % chain->count];
	}
	return edge;
}

/* Curves and their control points from the vertices of the chains that are left; number: control point of a mesh vertex. */
static void put_curves(struct draft *draft, idx_t *number, const struct dense *dense, const struct border_network *border, const unsigned char *used)
{
	for (size_t i = 0; i < border->node_count; i++)
		if (used[border->node[i]])
			number[border->node[i]] = control_add(&draft->control, &dense->xyz[3 * (size_t)border->node[i]], border->node_kind[i]);
	struct network *network = &draft->network;
	*network = (struct network){.curve = mem_array(border->chain_count, sizeof *network->curve),
	                            .point = mem_array(border->vertex_count + border->chain_count, sizeof *network->point)};
	for (size_t c = 0; c < border->chain_count; c++) {
		const struct border_chain *chain = &border->chain[c];
		struct curve *curve = &network->curve[network->curve_count++];
		*curve = (struct curve){.left = chain->left, .right = chain->right, .kind = chain->kind, .closed = chain->closed, .first = network->point_count};
		for (size_t i = 0; i < chain->count; i++) {
			const idx_t v = border->vertex[chain->first + i];
			if (!used[v])
				continue;
			if (number[v] == NO_INDEX)
				number[v] = control_add(&draft->control, &dense->xyz[3 * (size_t)v], POINT_CREASE);
			network->point[network->point_count++] = number[v];
		}
		curve->count = network->point_count - curve->first;
	}
	network->vertex_count = draft->control.count;
}

bool collapse_draft(struct draft *draft, const struct rounds *rounds, double distance, struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	const struct border_network *border = rounds->target->border;
	unsigned char *locked = mem_array(dense->vertex_count, 1), *used = mem_array(dense->vertex_count, 1);
	for (size_t i = 0; i < border->node_count; i++)
		locked[border->node[i]] = 1;
	idx_t *triangle = mem_copy(dense->triangle, 3 * dense->triangle_count, sizeof *triangle);
	idx_t *origin = mem_array(dense->triangle_count, sizeof *origin);
	size_t edges;
	idx_t *edge = chain_edges(&edges, border);
	char message[200];
	const long left = shim_simplify(triangle, origin, dense->triangle_count, dense->xyz, dense->vertex_count, locked, edge, edges, distance * distance, 0,
	                                message, sizeof message);
	*draft = (struct draft){0};
	polygons_init(&draft->polygons);
	if (left >= 0) {
		idx_t *number = mem_array(dense->vertex_count, sizeof *number);
		for (size_t v = 0; v < dense->vertex_count; v++)
			number[v] = NO_INDEX;
		for (size_t i = 0; i < 3 * (size_t)left; i++)
			used[triangle[i]] = 1;
		put_curves(draft, number, dense, border, used);
		for (size_t t = 0; t < (size_t)left; t++) {
			idx_t corner[3];
			for (size_t k = 0; k < 3; k++) {
				const idx_t v = triangle[3 * t + k];
				if (number[v] == NO_INDEX)
					number[v] = control_add(&draft->control, &dense->xyz[3 * (size_t)v], POINT_INSIDE);
				corner[k] = number[v];
			}
			polygons_add(&draft->polygons, corner, 3, dense->label[origin[t]]);
		}
		polygons_by_patch(&draft->polygons, dense->patch_count);
		draft_sharpen(draft, dense);
		free(number);
	}
	free(locked), free(used), free(triangle), free(origin), free(edge);
	return left >= 0 || fault_set(fault, EX_BAD_INPUT, "%s", message);
}

static double bytes_of(const struct draft *draft) { return point_bytes * (double)draft->control.count + face_bytes * (double)draft->polygons.count; }

/* The most bytes of the other cage, in those of the draft, for which it is worth to take the draft's place; both are within the bounds. */
static double worth(const struct part_state *draft, const struct part_state *other)
{
	if (draft->folded > seen_folds && other->folded < draft->folded / 2)
		return larger_unfolded;
	return other->mean < much_closer * draft->mean && other->folded <= fmax(draft->folded, seen_folds) ? same_size : smaller;
}

/* A cage by collapse, fitted; its plane patches get polygons once the points on their borders have found their places. */
static bool fit_collapsed(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds, double distance,
                          struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	if (!collapse_draft(draft, rounds, distance, fault))
		return false;
	if (draft->polygons.count > MOST_FACES)
		return fault_set(fault, EX_BAD_INPUT, "%zu faces", draft->polygons.count);
	if (!rounds_fit_points(draft, rounds, NULL, fault))
		return false;
	unsigned char *plane = mem_array(dense->patch_count, 1);
	bool any = false;
	for (size_t p = 0; p < dense->patch_count; p++) {
		plane[p] = dense->patch[p].kind == PATCH_PLANE;
		layouts->kind[p] = LAYOUT_CHORDS, layouts->detail[p] = 0;
		any |= plane[p];
	}
	const bool good = !any || rounds_layout(draft, rounds, layouts, plane, fault);
	free(plane);
	return good && rounds_fit_once(draft, error, NULL, rounds, fault) && rounds_settle(draft, error, rounds, fault);
}

/* The collapsed mesh itself: nothing smooth is left, so that its error is that of its triangles, which the distance bounds. */
static bool facets_only(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds, double distance,
                        struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	if (!collapse_draft(draft, rounds, distance, fault))
		return false;
	for (size_t i = 0; i < draft->control.count; i++)
		if (draft->control.role[i] != POINT_INSIDE)
			draft->control.role[i] = POINT_CORNER;
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		draft->tangential[k] = 0;
		if (draft->network.curve[k].kind == CURVE_SMOOTH)
			draft->network.curve[k].kind = CURVE_SHARP;
	}
	unsigned char *plane = mem_array(dense->patch_count, 1);
	for (size_t p = 0; p < dense->patch_count; p++) {
		plane[p] = dense->patch[p].kind == PATCH_PLANE;
		layouts->kind[p] = LAYOUT_CHORDS, layouts->detail[p] = 1;
	}
	const bool good = rounds_layout(draft, rounds, layouts, plane, fault);
	free(plane);
	memset(layouts->faceted, 1, dense->patch_count);
	seams_find(draft, dense, layouts->faceted);
	return good && joint_measure(error, NULL, dense->patch_count, draft, rounds->target, fault);
}

/* From coarse to fine until one is within the bounds. */
static bool try_facets(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds)
{
	const size_t patches = rounds->target->dense->patch_count;
	double distance = first_facets * rounds->bounds.mean;
	for (int try = 0; try < DISTANCES; try++, distance *= distance_step) {
		struct draft other = {0};
		struct patch_error *other_error = mem_array(patches, sizeof *other_error);
		struct layouts other_layouts = layouts_new(patches, NULL);
		struct fault fault = {0};
		bool good = facets_only(&other, &other_layouts, other_error, rounds, distance, &fault);
		if (good) {
			const struct part_state state = rounds_state(other_error, rounds->target->dense);
			good = rounds_within(&state, &rounds->bounds);
			rounds->say("as facets: %zu points, %zu faces, mean %.4g, largest %.4g, %.3g%% folded: %s", other.control.count, other.polygons.count, state.mean,
			            state.worst, 100 * state.folded, good ? "taken" : "left");
		} else {
			rounds->say("as facets: %s", fault.text);
		}
		if (good) {
			const struct draft swap = *draft;
			*draft = other, other = swap;
			const struct layouts theirs = *layouts;
			*layouts = other_layouts, other_layouts = theirs;
			memcpy(error, other_error, patches * sizeof *error);
		}
		draft_free(&other);
		layouts_free(&other_layouts);
		free(other_error);
		if (good)
			return true;
	}
	return false;
}

enum collapse collapse_try(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds)
{
	const struct dense *dense = rounds->target->dense;
	const size_t patches = dense->patch_count, chains = rounds->target->border->chain_count;
	struct part_state state = rounds_state(error, dense), own_state = state;
	double least = rounds_badness(&state, &rounds->bounds);
	bool within = rounds_within(&state, &rounds->bounds), kept = within; /* kept: the sharp edges too */
	/* what the draft does not keep is not asked of others */
	double most_sharp = fmax(sharp_share * rounds->bounds.max, sharpcurve_distance(draft, rounds->target, rounds->chain_of_curve));
	for (size_t i = 0; i < draft->control.count; i++)
		if (draft->control.held[i])
			return COLLAPSE_NONE; /* what a person moved stays */
	enum collapse result = COLLAPSE_NONE;
	idx_t *own_chain = mem_array(chains, sizeof *own_chain);
	for (size_t c = 0; c < chains; c++)
		own_chain[c] = (idx_t)c;
	size_t work = 0;
	const size_t most_work = (size_t)(rounds_work_share(dense) * MOST_WORK), within_work = (size_t)(rounds_work_share(dense) * WORK_WITHIN);
	struct rounds own = *rounds;
	own.chain_of_curve = own_chain, own.work = &work, own.most_work = most_work;
	double distance = first_distance * rounds->bounds.mean;
	for (int try = 0; try < DISTANCES && dense->triangle_count <= MOST_TRIANGLES && work < (kept ? within_work : most_work); try++) {
		double step = distance_step;
		struct draft other;
		struct patch_error *other_error = mem_array(patches, sizeof *other_error);
		struct layouts other_layouts = layouts_new(patches, NULL);
		struct fault other_fault = {0};
		bool take = false, done = false, futile = false;
		if (fit_collapsed(&other, &other_layouts, other_error, &own, distance, &other_fault)) {
			state = rounds_state(other_error, dense);
			if (!rounds_within(&state, &rounds->bounds) && state.mean <= rounds->bounds.mean) {
				touch_up(&other, &other_layouts, other_error, &own); /* a few patches spoil it */
				facet_rest(&other, &other_layouts, other_error, &own);
				state = rounds_state(other_error, dense);
			}
			const double now = rounds_badness(&state, &rounds->bounds), sharp = sharpcurve_distance(&other, rounds->target, own_chain);
			done = rounds_within(&state, &rounds->bounds) && sharp <= most_sharp;
			futile = dense->triangle_count > PATIENT_TRIANGLES && state.mean <= rounds->bounds.mean && state.worst > FAR_BOUNDS * rounds->bounds.max;
			take = done && kept ? bytes_of(&other) < worth(&own_state, &state) * bytes_of(draft) : done || (!kept && now < least);
			rounds->say("by collapse: %zu points, %zu faces, mean %.4g, largest %.4g, sharp edges %.4g (bound %.4g), %.3g%% folded: %s", other.control.count,
			            other.polygons.count, state.mean, state.worst, sharp, most_sharp, 100 * state.folded, take ? "taken" : "left");
			/* Errors fall about with the distance, the largest more slowly. */
			step = fmin(fmax(0.9 * fmin(rounds->bounds.mean / state.mean, sqrt(fmin(rounds->bounds.max / state.worst, most_sharp / sharp))), least_step), most_step);
			if (take) {
				least = now, within = rounds_within(&state, &rounds->bounds), kept = done, own_state = state;
				most_sharp = fmin(most_sharp, fmax(sharp_share * rounds->bounds.max, sharp));
			}
		} else {
			rounds->say("by collapse: %s", other_fault.text);
			done = true;
		}
		if (take) {
			result = COLLAPSE_SMOOTH;
			const struct draft swap = *draft;
			*draft = other, other = swap;
			memcpy(error, other_error, patches * sizeof *error);
			const struct layouts theirs = *layouts;
			*layouts = other_layouts, other_layouts = theirs;
		}
		const bool larger = bytes_of(&other) > worth(&own_state, &state) * bytes_of(draft);
		draft_free(&other);
		layouts_free(&other_layouts);
		free(other_error);
		distance *= step;
		/* Finer ones would only be larger. */
		if (done || futile || (kept && larger))
			break;
	}
	if (!within && try_facets(draft, layouts, error, &own))
		result = COLLAPSE_FACETS;
	free(own_chain);
	return result;
}
