/* Rounds of layout, fit and refinement. */
#include "stages/fitpatch/rounds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/fitpatch/enrich.h"
#include "stages/fitpatch/local.h"

/* A fold on less of a patch than this is left: it is smaller than what can be seen. */
static const double fold_share = 1e-3;
/* Rounds that try to get rid of a patch's folds by new border points. */
enum { FOLD_ROUNDS = 3, MOST_DETAIL = 8, CAREFUL_ATTEMPTS = 4 };

bool rounds_layout(struct draft *draft, const struct rounds *rounds, const struct layouts *layouts, const unsigned char *chosen, struct fault *fault)
{
	const struct target *target = rounds->target;
	const struct dense *dense = target->dense;
	struct polygons old = draft->polygons;
	polygons_init(&draft->polygons);
	struct edge_set *taken = edge_set_new();
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		const struct curve *curve = &draft->network.curve[k];
		const idx_t *point = &draft->network.point[curve->first];
		for (size_t i = 0; i + !curve->closed < curve->count; i++)
			edge_set_add(taken, point[i], point[(i + 1) % curve->count]);
	}
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
	                                 layouts->detail, taken, &draft->control, &draft->polygons};
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
		rounds->say("laid out %zu patches: %zu one face, %zu bands, %zu grids, %zu by chords; %zu faces in all", kinds[0] + kinds[1] + kinds[2] + kinds[3],
		            kinds[LAYOUT_FACE], kinds[LAYOUT_BAND], kinds[LAYOUT_GRID], kinds[LAYOUT_CHORDS], draft->polygons.count);
	polygons_by_patch(&draft->polygons, dense->patch_count);
	free(start), free(list);
	anchors_free(&anchors);
	edge_set_free(taken);
	return good;
}

/* First the points inside patches, with the borders where the curves were fitted; then all. A patch that folds or gets worse by its
 * moving borders (it has too few points inside, and pushes its borders out instead) gets them back, until no patch does. */
static bool fit_carefully(struct draft *draft, struct patch_error *error, struct face_error *face_error, const struct rounds *rounds, struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	const size_t points = draft->control.count, patches = dense->patch_count;
	unsigned char *still = mem_array(points, 1);
	bool inside = false;
	for (size_t i = 0; i < points; i++)
		still[i] = draft->control.role[i] != POINT_INSIDE, inside |= !still[i];
	if ((inside && !joint_fit(draft, rounds->target, &rounds->joint, still, fault)) || !joint_measure(error, face_error, patches, draft, rounds->target, fault)) {
		free(still);
		return false;
	}
	double *inner = mem_copy(draft->control.xyz, 3 * points, sizeof *inner);
	struct patch_error *first = mem_copy(error, patches, sizeof *first);
	unsigned char *bad = mem_array(patches, 1);
	memset(still, 0, points);
	bool good = true, settled = false;
	for (int attempt = 0; good && !settled && attempt < CAREFUL_ATTEMPTS; attempt++) {
		good = joint_fit(draft, rounds->target, &rounds->joint, still, fault) && joint_measure(error, face_error, patches, draft, rounds->target, fault);
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

bool rounds_fit(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds, struct fault *fault)
{
	const struct dense *dense = rounds->target->dense;
	const size_t patches = dense->patch_count;
	unsigned char *want = mem_array(patches, 1), *touched = mem_array(patches, 1), *again = mem_array(patches, 1), *fold_rounds = mem_array(patches, 1);
	bool good = false;
	for (int round = 0;; round++) {
		/* New points on borders are placed by a fit; only then can plane faces between them be found. */
		good = round == 0 || (joint_fit(draft, rounds->target, &rounds->joint, NULL, fault) && rounds_layout(draft, rounds, layouts, again, fault));
		if (!good)
			break;
		struct face_error *face_error = mem_array(draft->polygons.count, sizeof *face_error);
		good = fit_carefully(draft, error, face_error, rounds, fault);
		if (!good) {
			free(face_error);
			break;
		}
		double sum = 0, area = 0, worst = 0, folded = 0;
		for (size_t p = 0; p < patches; p++) {
			sum += error[p].mean * dense->patch[p].area, area += dense->patch[p].area, folded += error[p].folded;
			worst = fmax(worst, error[p].max);
		}
		const double mean = area > 0 ? sum / area : 0;
		rounds->say("round %d: %zu faces, mean %.4g, largest %.4g (bounds %.4g, %.4g), %.3g%% folded", round, draft->polygons.count, mean, worst,
		            rounds->bounds.mean, rounds->bounds.max, area > 0 ? 100 * folded / area : 0);
		size_t wanted = 0, anew = 0;
		for (size_t p = 0; p < patches; p++) {
			const bool folds = error[p].folded > fold_share * dense->patch[p].area && fold_rounds[p] < FOLD_ROUNDS;
			const bool far = error[p].max > rounds->bounds.max || (mean > rounds->bounds.mean && error[p].mean > rounds->bounds.mean);
			want[p] = WANT_NOTHING;
			again[p] = folds;
			touched[p] = 0;
			if (is_plane(dense, p)) {
				want[p] = folds || far ? WANT_BORDER : WANT_NOTHING;
			} else if (folds && fold_rounds[p] < 2) {
				want[p] = WANT_BORDER;
			} else if (folds || (far && layouts->kind[p] == LAYOUT_CHORDS && (round > 2 || error[p].max > 3 * rounds->bounds.max))) {
				/* A few points here and there do not help: start anew with more of them. */
				again[p] = layouts->detail[p] < MOST_DETAIL;
				layouts->detail[p] += again[p];
			} else if (far) {
				want[p] = WANT_INSIDE;
			}
			fold_rounds[p] += folds;
			wanted += want[p] != WANT_NOTHING || again[p];
			anew += again[p] && want[p] == WANT_NOTHING;
		}
		const size_t steps = wanted && round < rounds->limit ? enrich(draft, rounds->target, error, face_error, want, rounds->bounds.max, touched) : 0;
		free(face_error);
		if (round == rounds->limit || steps + anew == 0)
			break;
		/* Plane faces are cheap to find anew, and a fold means that the old ones were wrong. */
		for (size_t p = 0; p < patches; p++)
			again[p] |= touched[p] && is_plane(dense, p);
		rounds->say("%zu patches out of bounds or folded, %zu refinements, %zu laid out with more detail", wanted, steps, anew);
	}
	free(want), free(touched), free(again), free(fold_rounds);
	return good;
}

bool rounds_relax(struct draft *draft, struct patch_error *error, size_t *smooth, const unsigned char *candidate, const struct rounds *rounds,
                  struct fault *fault)
{
	const struct target *target = rounds->target;
	const size_t patches = target->dense->patch_count;
	const struct bounds *bounds = &rounds->bounds;
	struct network *network = &draft->network;
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
		good = joint_fit(draft, target, &rounds->joint, NULL, fault) && joint_measure(now, NULL, patches, draft, target, fault);
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
	if (good && *smooth > 0)
		memcpy(error, now, patches * sizeof *now);
	else if (good)
		memcpy(draft->control.xyz, kept, 3 * draft->control.count * sizeof *kept);
	free(kept), free(now);
	return good;
}
