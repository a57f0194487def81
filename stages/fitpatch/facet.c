/* Facets for the patches that are left over. */
#include "stages/fitpatch/facet.h"

#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/fitpatch/enrich.h"
#include "stages/fitpatch/local.h"

enum { PASSES = 4, STALE_PASSES = 2 /* in a row without getting better */ };
/* Detail (struct layout_context) of bent patches in the first pass: triangles within the bound itself; a step finer every pass. */
enum { FIRST_DETAIL = 4, LAST_DETAIL = 6 };
/* Folded by more than this share of its area a patch is left over, too. */
static const double most_folded = 0.01;
/* And then this share of the part is worth it. */
static const double seen_folds = 1e-3;

/* Free forms of more of the area than this are no exceptions, and facets no answer. */
static const double most_left = 0.25;

static bool is_left_over(const struct patch_error *error, const struct dense_patch *patch, const struct bounds *bounds)
{
	return error->max > ROUNDS_SLACK * bounds->max || error->folded > most_folded * patch->area;
}

/* One pass on a draft of its own; face_error (caller frees) is by its faces. */
static bool one_pass(struct draft *draft, struct layouts *layouts, struct patch_error *error, struct face_error **face_error, const unsigned char *chosen,
                     const struct rounds *rounds, struct fault *fault)
{
	*face_error = NULL;
	if (!rounds_layout(draft, rounds, layouts, chosen, fault))
		return false;
	*face_error = mem_array(draft->polygons.count, sizeof **face_error);
	return rounds_fit_once(draft, error, *face_error, rounds, fault);
}

bool facet_rest(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds)
{
	const struct dense *dense = rounds->target->dense;
	const size_t patches = dense->patch_count;
	struct part_state state = rounds_state(error, dense);
	if (rounds_within(&state, &rounds->bounds) && state.folded <= seen_folds)
		return false;
	unsigned char *chosen = mem_array(patches, 1), *want = mem_array(patches, 1), *touched = mem_array(patches, 1);
	struct patch_error *now = mem_array(patches, sizeof *now);
	struct draft next = {0};
	draft_copy(&next, draft);
	struct layouts own = layouts_new(patches, layouts);
	double least = rounds_badness(&state, &rounds->bounds);
	memcpy(now, error, patches * sizeof *now);
	double area = 0;
	for (size_t p = 0; p < patches; p++)
		area += dense->patch[p].area;
	const size_t work_before = *rounds->work;
	int stale = 0;
	bool better = false;
	for (int pass = 0; pass < PASSES && stale < STALE_PASSES && *rounds->work - work_before <= rounds->most_work / 2; pass++) {
		size_t left = 0;
		double left_area = 0;
		for (size_t p = 0; p < patches; p++) {
			const bool rest = is_left_over(&now[p], &dense->patch[p], &rounds->bounds);
			chosen[p] = rest;
			left += rest;
			left_area += rest && dense->patch[p].kind == PATCH_FREE ? dense->patch[p].area : 0;
			want[p] = rest && own.faceted[p] ? WANT_BORDER : WANT_NOTHING;
			if (!rest)
				continue;
			own.faceted[p] = 1;
			const int detail = FIRST_DETAIL + pass < LAST_DETAIL ? FIRST_DETAIL + pass : LAST_DETAIL;
			own.detail[p] = (unsigned char)(dense->patch[p].kind == PATCH_PLANE ? 1 : detail);
		}
		if (left == 0 || left_area > most_left * area)
			break;
		struct fault fault = {0};
		struct face_error *face_error;
		const bool good = one_pass(&next, &own, now, &face_error, chosen, rounds, &fault);
		if (!good) {
			rounds->say("facets: %s", fault.text);
			free(face_error);
			break;
		}
		state = rounds_state(now, dense);
		const double is = rounds_badness(&state, &rounds->bounds);
		rounds->say("facets for %zu patches: %zu faces, mean %.4g, largest %.4g, %.3g%% folded: %s", left, next.polygons.count, state.mean, state.worst,
		            100 * state.folded, is < least ? "taken" : "left");
		stale = is < least ? 0 : stale + 1;
		if (is < least) {
			better = true;
			least = is;
			draft_free(draft);
			draft_copy(draft, &next);
			memcpy(error, now, patches * sizeof *error);
			layouts_free(layouts);
			*layouts = layouts_new(patches, &own);
		}
		/* Points for the borders that are still too coarse; the faces beside them are found anew in the next pass. */
		memset(touched, 0, patches);
		enrich(&next, rounds->target, now, face_error, want, rounds->bounds.max, touched);
		free(face_error);
	}
	draft_free(&next);
	layouts_free(&own);
	free(chosen), free(want), free(touched), free(now);
	return better;
}
