/* Touching up patch by patch. */
#include "stages/fitpatch/touchup.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/fitpatch/enrich.h"
#include "stages/fitpatch/seam.h"
#include "stages/fitpatch/local.h"

/* Work (struct rounds) that a part gets for it. */
enum { TOUCH_WORK = 8000 };
/* Folds of less than this share of the part are not looked for. */
static const double seen_folds = 3e-4;
/* A patch folds when this share of its area does. */
static const double patch_folds = 2e-3;
/* Farther out of bounds than this there is more to do than touching up. */
static const double hopeless_mean = 1.5, hopeless_worst = 3;
/* Gains below this (of rounds_badness) are not worth the points. */
static const double least_gain = 0.01;
/* Details (struct layout_context) of planes and of others are at most this. */
enum { MOST_PLANE_DETAIL = 2, MOST_BENT_DETAIL = 8 };

/* What may help a patch: points inside, on its border, or a layout of another detail: each of a plane's, one or two steps more of others. */
enum way { WAY_INSIDE, WAY_BORDER, WAY_DETAIL, WAY_COUNT = WAY_DETAIL + MOST_PLANE_DETAIL + 1 };

struct touch {
	struct draft draft;
	struct layouts layouts;
	struct patch_error *error;
	double badness;
};

static void touch_free(struct touch *touch)
{
	draft_free(&touch->draft);
	layouts_free(&touch->layouts);
	free(touch->error);
	*touch = (struct touch){0};
}

/* What a patch adds to the badness; 0 for those that are good enough. */
static double need_of(const struct patch_error *error, const struct dense_patch *patch, const struct bounds *bounds, double area)
{
	const double far = fmax(0, error->max / bounds->max - 1), folds = error->folded > patch_folds * patch->area ? 100 * error->folded / area : 0;
	return far + folds;
}

static double part_area(const struct dense *dense)
{
	double area = 0;
	for (size_t p = 0; p < dense->patch_count; p++)
		area += dense->patch[p].area;
	return area;
}

/* As rounds_badness, but every patch that is out of bounds counts, not the worst alone: patches are mended one by one. */
static double badness_of(const struct patch_error *error, const struct rounds *rounds)
{
	const struct dense *dense = rounds->target->dense;
	const struct part_state state = rounds_state(error, dense);
	double sum = 100 * state.folded + fmax(1, state.mean / rounds->bounds.mean);
	for (size_t p = 0; p < dense->patch_count; p++)
		sum += fmax(0, error[p].max / rounds->bounds.max - 1);
	return sum;
}

/* Fit with all points still but those of the patches that changed; the old ones on borders may stay, too. */
static bool fit_changed(struct draft *draft, const unsigned char *changed, const struct rounds *rounds, struct fault *fault)
{
	unsigned char *still = mem_array(draft->control.count, 1);
	memset(still, 1, draft->control.count);
	for (size_t f = 0; f < draft->polygons.count; f++)
		for (size_t i = draft->polygons.start[f]; changed[draft->polygons.patch[f]] && i < draft->polygons.start[f + 1]; i++)
			still[draft->polygons.corner[i]] = 0;
	const bool good = rounds_fit_points(draft, rounds, still, fault);
	free(still);
	return good;
}

/* Try one way on a copy. False when it changes nothing or ends in no cage. */
static bool try_way(struct touch *touch, enum way way, size_t patch, const struct draft *draft, const struct layouts *layouts,
                    const struct patch_error *error, const struct face_error *face_error, const struct rounds *rounds)
{
	const struct dense *dense = rounds->target->dense;
	const size_t patches = dense->patch_count;
	const bool is_plane = dense->patch[patch].kind == PATCH_PLANE;
	const unsigned char step = way >= WAY_DETAIL ? (unsigned char)(way - WAY_DETAIL) : 0;
	const unsigned char detail = is_plane ? step : (unsigned char)(layouts->detail[patch] + step);
	if ((way == WAY_INSIDE && is_plane) || (way >= WAY_DETAIL && (detail == layouts->detail[patch] || detail > MOST_BENT_DETAIL)))
		return false;
	struct fault fault = {0};
	unsigned char *want = mem_array(patches, 1), *changed = mem_array(patches, 1);
	draft_copy(&touch->draft, draft);
	touch->layouts = layouts_new(patches, layouts);
	touch->error = mem_array(patches, sizeof *touch->error);
	bool good = true;
	if (way >= WAY_DETAIL) {
		touch->layouts.detail[patch] = detail;
		if (is_plane)
			touch->layouts.faceted[patch] = detail == MOST_PLANE_DETAIL;
		changed[patch] = 1;
	} else {
		want[patch] = way == WAY_INSIDE ? WANT_INSIDE : WANT_BORDER;
		good = enrich(&touch->draft, rounds->target, error, face_error, want, fmin(rounds->bounds.max, 0.9 * error[patch].max), changed) > 0;
		changed[patch] = 1;
		seams_find(&touch->draft, dense, touch->layouts.faceted); /* a refinement may have put a point on one */
		good = good && fit_changed(&touch->draft, changed, rounds, &fault);
	}
	/* Plane faces are found anew where they got points, others where the way asks for it. */
	unsigned char *again = mem_array(patches, 1);
	bool any = false;
	for (size_t p = 0; p < patches; p++) {
		again[p] = changed[p] && (dense->patch[p].kind == PATCH_PLANE || (p == patch && way != WAY_INSIDE));
		any |= again[p];
	}
	good = good && (!any || (rounds_layout(&touch->draft, rounds, &touch->layouts, again, &fault) && fit_changed(&touch->draft, changed, rounds, &fault)))
	       && joint_measure(touch->error, NULL, patches, &touch->draft, rounds->target, &fault);
	free(want), free(changed), free(again);
	if (!good)
		return false;
	touch->badness = badness_of(touch->error, rounds);
	return true;
}

void touch_up(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds)
{
	const struct dense *dense = rounds->target->dense;
	const size_t patches = dense->patch_count, work_before = *rounds->work;
	const size_t most_work = (size_t)(rounds_work_share(dense) * TOUCH_WORK);
	const struct part_state first = rounds_state(error, dense);
	if (first.mean > hopeless_mean * rounds->bounds.mean || first.worst > hopeless_worst * rounds->bounds.max)
		return;
	const double area = part_area(dense);
	unsigned char *hopeless = mem_array(patches, 1);
	struct fault fault = {0};
	while (*rounds->work - work_before + draft->polygons.count < most_work) {
		const struct part_state state = rounds_state(error, dense);
		size_t worst = 0;
		double most = 0;
		for (size_t p = 0; p < patches; p++) {
			const double need = hopeless[p] ? 0 : need_of(&error[p], &dense->patch[p], &rounds->bounds, area);
			if (need > most)
				most = need, worst = p;
		}
		if (!(most > least_gain) || (state.worst <= rounds->bounds.max && state.folded <= seen_folds))
			break;
		struct face_error *face_error = mem_array(draft->polygons.count, sizeof *face_error);
		if (!joint_measure(error, face_error, patches, draft, rounds->target, &fault)) {
			free(face_error);
			break;
		}
		struct touch best = {.badness = badness_of(error, rounds) - fmin(least_gain, most / 4)};
		bool found = false;
		for (enum way way = 0; way < WAY_COUNT; way++) {
			struct touch touch = {0};
			if (try_way(&touch, way, worst, draft, layouts, error, face_error, rounds) && touch.badness < best.badness) {
				touch_free(&best);
				best = touch, touch = (struct touch){0};
				found = true;
			}
			touch_free(&touch);
		}
		free(face_error);
		hopeless[worst] = !found;
		if (!found)
			continue;
		draft_free(draft);
		layouts_free(layouts);
		*draft = best.draft, *layouts = best.layouts;
		memcpy(error, best.error, patches * sizeof *error);
		free(best.error);
		const struct part_state is = rounds_state(error, dense);
		rounds->say("touched up patch %zu: %zu faces, mean %.4g, largest %.4g, %.3g%% folded", (size_t)rounds->name[worst], draft->polygons.count, is.mean, is.worst,
		            100 * is.folded);
	}
	free(hopeless);
}
