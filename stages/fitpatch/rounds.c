/* Rounds of layout, fit and refinement. */
#include "stages/fitpatch/rounds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/fitpatch/enrich.h"
#include "stages/fitpatch/local.h"
#include "stages/fitpatch/seam.h"

/* A fold on less of a patch than this is left: it is smaller than what can be seen. */
static const double fold_share = 1e-3, bent_fold_share = 1e-2; /* of planes; of others, where a new layout loses more */
/* Of a part that is within its bounds. */
static const double most_folded = 5e-3;
/* Rounds that try to get rid of a patch's folds by new border points. */
enum { MOST_CAUTION = 2, FOLD_ROUNDS = 4, MOST_DETAIL = 8, CAREFUL_ATTEMPTS = 3 };
/* Rounds in a row that may pass without getting better. */
enum { STALE_ROUNDS = 3 };
enum { MOST_FACES_AT_LEAST = 400, FACES_DIVISOR = 8 };
/* Farther out of bounds than this, finer samples make no difference that would be worth their time. */
static const double hopeless = 3;
/* Faces of the finest surface that is fitted. */
enum { MOST_PIECES = 60000 };

struct layouts layouts_new(size_t patch_count, const struct layouts *copy_of)
{
	if (copy_of)
		return (struct layouts){mem_copy(copy_of->kind, patch_count, 1), mem_copy(copy_of->detail, patch_count, 1), mem_copy(copy_of->faceted, patch_count, 1)};
	return (struct layouts){mem_array(patch_count, 1), mem_array(patch_count, 1), mem_array(patch_count, 1)};
}

void layouts_free(struct layouts *layouts)
{
	free(layouts->kind), free(layouts->detail), free(layouts->faceted);
	*layouts = (struct layouts){0};
}

bool rounds_layout(struct draft *draft, const struct rounds *rounds, const struct layouts *layouts, const unsigned char *chosen, struct fault *fault)
{
	const struct target *target = rounds->target;
	const struct dense *dense = target->dense;
	struct polygons old = draft->polygons;
	polygons_init(&draft->polygons);
	struct edge_set *taken = edge_set_new();
	draft_curve_edges(taken, draft);
	for (size_t f = 0; f < old.count; f++) {
		if (!chosen || chosen[old.patch[f]])
			continue;
		const idx_t *corner = &old.corner[old.start[f]];
		const size_t count = old.start[f + 1] - old.start[f];
		polygons_add(&draft->polygons, corner, count, old.patch[f]);
		for (size_t i = 0; i < count; i++)
			edge_set_add(taken, corner[i], corner[(i + 1) % count]);
	}
	polygons_free(&old);
	struct network network = draft->network;
	network.xyz = draft->control.xyz;
	network.vertex_count = draft->control.count;
	struct anchors anchors;
	anchors_place(&anchors, dense, rounds->half, target->border, &network, rounds->chain_of_curve);
	struct layout_context context = {dense, rounds->half->twin, target->nearest, &anchors, rounds->bounds.max, fmin(rounds->bounds.max / 2, rounds->bounds.mean),
	                                 layouts->detail, layouts->faceted, rounds->name, taken, &draft->control, &draft->polygons};
	size_t *start, kinds[LAYOUT_KIND_COUNT] = {0};
	idx_t *list;
	label_lists(&start, &list, dense->label, dense->triangle_count, dense->patch_count);
	bool good = true;
	for (size_t p = 0; good && p < dense->patch_count; p++) {
		if (chosen && !chosen[p])
			continue;
		enum layout_kind kind = LAYOUT_FACE;
		good = layout_patch(&kind, &context, (idx_t)p, &list[start[p]], start[p + 1] - start[p], fault);
		layouts->kind[p] = kind;
		kinds[kind]++;
	}
	if (good)
		rounds->say("laid out %zu patches: %zu one face, %zu bands, %zu grids, %zu domes, %zu by chords; %zu faces in all",
		            kinds[LAYOUT_FACE] + kinds[LAYOUT_BAND] + kinds[LAYOUT_GRID] + kinds[LAYOUT_DOME] + kinds[LAYOUT_CHORDS], kinds[LAYOUT_FACE],
		            kinds[LAYOUT_BAND], kinds[LAYOUT_GRID], kinds[LAYOUT_DOME], kinds[LAYOUT_CHORDS], draft->polygons.count);
	polygons_by_patch(&draft->polygons, dense->patch_count);
	seams_find(draft, dense, layouts->faceted);
	free(start), free(list);
	anchors_free(&anchors);
	edge_set_free(taken);
	return good;
}

bool rounds_fit_points(struct draft *draft, const struct rounds *rounds, const unsigned char *still, struct fault *fault)
{
	*rounds->work += draft->polygons.count;
	return joint_fit(draft, rounds->target, &rounds->joint, still, fault);
}

bool rounds_fit_once(struct draft *draft, struct patch_error *error, struct face_error *face_error, const struct rounds *rounds, struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	const size_t points = draft->control.count, patches = dense->patch_count;
	unsigned char *still = mem_array(points, 1);
	bool inside = false;
	for (size_t i = 0; i < points; i++)
		still[i] = draft->control.role[i] != POINT_INSIDE, inside |= !still[i];
	if ((inside && !rounds_fit_points(draft, rounds, still, fault)) || !joint_measure(error, face_error, patches, draft, rounds->target, fault)) {
		free(still);
		return false;
	}
	double *inner = mem_copy(draft->control.xyz, 3 * points, sizeof *inner);
	struct patch_error *first = mem_copy(error, patches, sizeof *first);
	unsigned char *bad = mem_array(patches, 1);
	memset(still, 0, points);
	bool good = true, settled = false;
	for (int attempt = 0; good && !settled && attempt < (*rounds->work < rounds->most_work ? CAREFUL_ATTEMPTS : 1); attempt++) {
		good = rounds_fit_points(draft, rounds, still, fault) && joint_measure(error, face_error, patches, draft, rounds->target, fault);
		settled = true;
		for (size_t p = 0; good && p < patches; p++)
			if (!bad[p] && (error[p].folded > first[p].folded + fold_share / 2 * dense->patch[p].area
			                || (error[p].max > 1.2 * first[p].max && error[p].max > rounds->bounds.max / 2)))
				bad[p] = 1, settled = false;
		for (size_t f = 0; f < draft->polygons.count; f++)
			for (size_t i = draft->polygons.start[f]; bad[draft->polygons.patch[f]] && i < draft->polygons.start[f + 1]; i++)
				still[draft->polygons.corner[i]] = draft->control.role[draft->polygons.corner[i]] != POINT_INSIDE;
		if (!settled)
			memcpy(draft->control.xyz, inner, 3 * points * sizeof *inner);
	}
	if (good && !settled)
		good = joint_measure(error, face_error, patches, draft, rounds->target, fault);
	free(still), free(inner), free(first), free(bad);
	return good;
}

static bool is_plane(const struct dense *dense, size_t patch) { return dense->patch[patch].kind == PATCH_PLANE; }

struct part_state rounds_state(const struct patch_error *error, const struct dense *dense)
{
	struct part_state state = {0, 0, 0};
	double area = 0;
	for (size_t p = 0; p < dense->patch_count; p++) {
		state.mean += error[p].mean * dense->patch[p].area, area += dense->patch[p].area, state.folded += error[p].folded;
		state.worst = fmax(state.worst, error[p].max);
	}
	if (area > 0)
		state.mean /= area, state.folded /= area;
	return state;
}

double rounds_badness(const struct part_state *state, const struct bounds *bounds)
{
	return fmax(1, state->mean / bounds->mean) + fmax(1, state->worst / bounds->max) + 100 * state->folded;
}

double rounds_work_share(const struct dense *dense)
{
	const double full_triangles = 50000;
	return fmin(1, full_triangles / (double)dense->triangle_count);
}

bool rounds_within(const struct part_state *state, const struct bounds *bounds)
{
	return state->mean <= ROUNDS_SLACK * bounds->mean && state->worst <= ROUNDS_SLACK * bounds->max && state->folded <= most_folded;
}

/* What each patch gets in a round. */
struct plan {
	unsigned char *want;        /* enum want */
	unsigned char *again;       /* lay out anew */
	unsigned char *touched;
	unsigned char *fold_rounds; /* rounds in which it was folded */
	double *last_max;           /* the round before */
};

/* Returns the number of patches that want something; *anew of them are only laid out again, with more detail. */
static size_t plan_round(struct plan *plan, size_t *anew, struct layouts *layouts, const struct patch_error *error, const struct part_state *state,
                         const struct rounds *rounds)
{
	const struct dense *dense = rounds->target->dense;
	size_t wanted = 0;
	*anew = 0;
	for (size_t p = 0; p < dense->patch_count; p++) {
		const double share = is_plane(dense, p) ? fold_share : bent_fold_share;
		const bool folds = error[p].folded > share * dense->patch[p].area && plan->fold_rounds[p] < FOLD_ROUNDS;
		const bool far = error[p].max > rounds->bounds.max || (state->mean > rounds->bounds.mean && error[p].mean > rounds->bounds.mean);
		const bool stuck = error[p].max > 0.9 * plan->last_max[p] && layouts->kind[p] == LAYOUT_CHORDS;
		plan->want[p] = WANT_NOTHING, plan->again[p] = 0, plan->touched[p] = 0;
		if (is_plane(dense, p)) {
			/* Against folds alone more cautious faces cost less than points on the border; where the error is large, these come first. */
			const bool careful = folds && (!far || plan->fold_rounds[p] > 0) && layouts->detail[p] < MOST_CAUTION;
			if (careful)
				layouts->faceted[p] = ++layouts->detail[p] == MOST_CAUTION;
			*anew += careful;
			plan->want[p] = far || (folds && !careful) ? WANT_BORDER : WANT_NOTHING;
			plan->again[p] = folds || far;
		} else if (folds && plan->fold_rounds[p] == 0) {
			plan->want[p] = WANT_BORDER;
			plan->again[p] = 1;
		} else if (folds || (far && stuck)) {
			/* Single points do not help: start anew with more of them. */
			plan->again[p] = layouts->detail[p] < MOST_DETAIL;
			layouts->detail[p] += plan->again[p];
			*anew += plan->again[p];
		} else if (far) {
			plan->want[p] = WANT_INSIDE;
		}
		plan->fold_rounds[p] += folds;
		plan->last_max[p] = plan->again[p] ? INFINITY : error[p].max;
		wanted += plan->want[p] != WANT_NOTHING || plan->again[p];
	}
	return wanted;
}

/* Place the points from old_points on, find the faces of again anew, fit, measure (*face_error: caller frees). New points on borders
 * are placed by a fit, since plane faces between them can be found only then: of all points, or with the old border points still. */
static bool fit_round(struct draft *draft, struct patch_error *error, struct face_error **face_error, size_t old_points, bool borders_still,
                      const struct rounds *rounds, const struct layouts *layouts, const unsigned char *again, struct fault *fault)
{
	*face_error = NULL;
	if (old_points > 0) {
		unsigned char *still = mem_array(draft->control.count, 1);
		for (size_t i = 0; borders_still && i < old_points; i++)
			still[i] = draft->control.role[i] != POINT_INSIDE;
		const bool placed = rounds_fit_points(draft, rounds, still, fault);
		free(still);
		if (!placed || !rounds_layout(draft, rounds, layouts, again, fault))
			return false;
	}
	*face_error = mem_array(draft->polygons.count, sizeof **face_error);
	return rounds_fit_once(draft, error, *face_error, rounds, fault);
}

/* Both ways of placing new points: moving old border points makes room for them, but may push borders out; the second way is tried
 * where the first is no better than least. */
static bool fit_better(struct draft *draft, struct patch_error *error, struct face_error **face_error, size_t old_points, double least,
                       const struct rounds *rounds, const struct layouts *layouts, const unsigned char *again, struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	struct draft other = {0};
	if (old_points > 0)
		draft_copy(&other, draft);
	bool good = fit_round(draft, error, face_error, old_points, false, rounds, layouts, again, fault);
	struct part_state state = rounds_state(error, dense);
	const double first = rounds_badness(&state, &rounds->bounds);
	if (good && old_points > 0 && first >= least && *rounds->work < rounds->most_work / 2) {
		struct patch_error *other_error = mem_array(dense->patch_count, sizeof *other_error);
		struct face_error *other_face;
		struct fault other_fault = {0}; /* the first way worked: this one may fail */
		const bool other_good = fit_round(&other, other_error, &other_face, old_points, true, rounds, layouts, again, &other_fault);
		state = rounds_state(other_error, dense);
		if (other_good && rounds_badness(&state, &rounds->bounds) < first) {
			draft_free(draft);
			free(*face_error);
			*draft = other;
			*face_error = other_face;
			memcpy(error, other_error, dense->patch_count * sizeof *error);
			other = (struct draft){0}, other_face = NULL;
		}
		free(other_error), free(other_face);
	}
	draft_free(&other);
	return good;
}

bool rounds_settle(struct draft *draft, struct patch_error *error, const struct rounds *rounds, struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	struct joint_options finer = rounds->joint;
	size_t pieces = draft->polygons.start[draft->polygons.count]; /* an n-gon becomes n quads in the first step */
	for (int step = 1; step < finer.steps && pieces <= MOST_PIECES; step++)
		pieces *= 4;
	while (finer.steps < rounds->joint.steps + 2 && 4 * pieces <= MOST_PIECES)
		finer.steps++, pieces *= 4;
	const struct part_state coarse = rounds_state(error, dense);
	if (finer.steps == rounds->joint.steps || coarse.mean > hopeless * rounds->bounds.mean || coarse.worst > hopeless * rounds->bounds.max)
		return true;
	struct patch_error *settled = mem_array(dense->patch_count, sizeof *settled);
	double *before = mem_copy(draft->control.xyz, 3 * draft->control.count, sizeof *before);
	const bool good = joint_fit(draft, rounds->target, &finer, NULL, fault) && joint_measure(settled, NULL, dense->patch_count, draft, rounds->target, fault);
	const struct part_state was = rounds_state(error, dense), is = rounds_state(settled, dense);
	rounds->say("settled: mean %.4g, largest %.4g, %.3g%% folded", is.mean, is.worst, 100 * is.folded);
	/* Within the bounds a smaller mean counts too, against folds that no one sees. */
	const double gain = rounds_badness(&was, &rounds->bounds) - rounds_badness(&is, &rounds->bounds) + (was.mean - is.mean) / (4 * rounds->bounds.mean);
	if (good && gain > 0)
		memcpy(error, settled, dense->patch_count * sizeof *error);
	else
		memcpy(draft->control.xyz, before, 3 * draft->control.count * sizeof *before);
	free(settled), free(before);
	return good;
}

bool rounds_fit(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds, struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	const size_t patches = dense->patch_count;
	struct plan plan = {mem_array(patches, 1), mem_array(patches, 1), mem_array(patches, 1), mem_array(patches, 1), mem_array(patches, sizeof(double))};
	for (size_t p = 0; p < patches; p++)
		plan.last_max[p] = INFINITY;
	struct draft best = {0};
	struct layouts best_layouts = {0};
	double least = INFINITY;
	bool good = false;
	int stale = 0;
	size_t old_points = 0;
	for (int round = 0;; round++) {
		struct face_error *face_error;
		good = fit_better(draft, error, &face_error, old_points, least, rounds, layouts, plan.again, fault);
		if (!good) {
			free(face_error);
			break;
		}
		const struct part_state state = rounds_state(error, dense);
		rounds->say("round %d: %zu faces, mean %.4g, largest %.4g (bounds %.4g, %.4g), %.3g%% folded", round, draft->polygons.count, state.mean, state.worst,
		            rounds->bounds.mean, rounds->bounds.max, 100 * state.folded);
		const double now = rounds_badness(&state, &rounds->bounds);
		stale = now < 0.98 * least ? 0 : stale + 1;
		if (now < 0.999 * least) {
			draft_free(&best);
			draft_copy(&best, draft);
			layouts_free(&best_layouts);
			best_layouts = layouts_new(patches, layouts);
			least = now;
		}
		size_t anew, steps = 0;
		old_points = draft->control.count;
		const size_t wanted = plan_round(&plan, &anew, layouts, error, &state, rounds);
		/* A cage that nears the size of the mesh is none (the patch method's section 10, hazard 23). */
		const bool is_large = *rounds->work > rounds->most_work || (draft->polygons.count > MOST_FACES_AT_LEAST && draft->polygons.count > dense->triangle_count / FACES_DIVISOR);
		if (wanted && round < rounds->limit && !is_large) {
			steps = enrich(draft, rounds->target, error, face_error, plan.want, rounds->bounds.max, plan.touched);
			seams_find(draft, dense, layouts->faceted); /* a refinement may have put a point on one */
		}
		free(face_error);
		if (round == rounds->limit || is_large || steps + anew == 0 || stale >= STALE_ROUNDS)
			break;
		/* Plane faces are cheap to find anew. */
		for (size_t p = 0; p < patches; p++)
			plan.again[p] |= plan.touched[p] && is_plane(dense, p);
		rounds->say("%zu patches out of bounds or folded, %zu refinements, %zu laid out with more detail; %zu faces fitted so far", wanted, steps, anew, *rounds->work);
	}
	/* A refinement that ends in no manifold costs its round, not the part. */
	if (!good && isfinite(least)) {
		rounds->say("%s: the round before is kept", fault->text);
		*fault = (struct fault){0};
		good = true;
	}
	if (good) {
		draft_free(draft);
		*draft = best;
		layouts_free(layouts);
		*layouts = best_layouts;
		good = joint_measure(error, NULL, patches, draft, rounds->target, fault) && rounds_settle(draft, error, rounds, fault);
	} else {
		draft_free(&best);
		layouts_free(&best_layouts);
	}
	free(plan.want), free(plan.again), free(plan.touched), free(plan.fold_rounds), free(plan.last_max);
	return good;
}

bool rounds_relax(struct draft *draft, struct patch_error *error, size_t *smooth, const struct rounds *rounds,
                  struct fault *fault)
{
	const struct target *target = rounds->target;
	const size_t patches = target->dense->patch_count;
	const struct bounds *bounds = &rounds->bounds;
	struct network *network = &draft->network;
	const unsigned char *candidate = draft->tangential;
	double *kept = mem_copy(draft->control.xyz, 3 * draft->control.count, sizeof *kept);
	struct patch_error *now = mem_array(patches, sizeof *now);
	*smooth = 0;
	for (size_t k = 0; k < network->curve_count; k++)
		if (candidate[k])
			network->curve[k].kind = CURVE_SMOOTH, ++*smooth;
	enum { PASSES = 6 };
	bool good = true;
	for (int pass = 0; *smooth > 0 && pass < PASSES; pass++) {
		memcpy(draft->control.xyz, kept, 3 * draft->control.count * sizeof *kept);
		good = rounds_fit_points(draft, rounds, NULL, fault) && joint_measure(now, NULL, patches, draft, target, fault);
		if (!good)
			break;
		size_t back = 0;
		for (size_t k = 0; k < network->curve_count; k++) {
			if (network->curve[k].kind != CURVE_SMOOTH || !candidate[k])
				continue;
			bool worse = pass == PASSES - 1; /* patience ends with creases */
			const idx_t side[2] = {network->curve[k].left, network->curve[k].right};
			for (int i = 0; i < 2; i++)
				worse |= now[side[i]].max > fmax(bounds->max / 2, 1.1 * error[side[i]].max)
				         || now[side[i]].mean > fmax(bounds->mean / 2, 1.1 * error[side[i]].mean) || now[side[i]].folded > error[side[i]].folded;
			if (worse)
				network->curve[k].kind = CURVE_SHARP, back++;
		}
		*smooth -= back;
		if (back == 0)
			break;
	}
	/* All points moved: other patches may have lost more than these curves gained. */
	const struct part_state was = rounds_state(error, target->dense), is = rounds_state(now, target->dense);
	if (good && *smooth > 0 && rounds_badness(&is, bounds) > 1.01 * rounds_badness(&was, bounds)) {
		for (size_t k = 0; k < network->curve_count; k++)
			if (candidate[k])
				network->curve[k].kind = CURVE_SHARP;
		*smooth = 0;
	}
	if (good && *smooth > 0)
		memcpy(error, now, patches * sizeof *now);
	else if (good)
		memcpy(draft->control.xyz, kept, 3 * draft->control.count * sizeof *kept);
	free(kept), free(now);
	return good;
}
