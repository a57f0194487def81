/* Rounding by what it costs (patch method, sections 11.4 and 12.5: one step up or down with the coder in the loop). */
#include "stages/facefix/cheaper.h"

#include <math.h>
#include <stdlib.h>

#include "stages/facefix/gridfit.h"

#define WORK_LIMIT 120000    /* edges coded in all trials together: about a second */
#define FAR_LIMIT 1.3        /* steps: candidates further from their exact value are not tried */
#define GAIN_LEAST (0.1 / 8) /* bytes */

struct candidate {
	size_t coordinate; /* index into ffx->grid */
	double far;        /* distance of the other value from the exact one, steps */
	int32_t other;
};

static int compare_candidates(const void *left, const void *right)
{
	const struct candidate *a = left, *b = right;
	if (a->far != b->far)
		return a->far < b->far ? -1 : 1;
	if (a->coordinate != b->coordinate)
		return a->coordinate < b->coordinate ? -1 : 1;
	return a->other < b->other ? -1 : a->other > b->other;
}

static size_t find_candidates(struct candidate *candidate, const struct ffx *ffx, const struct cage *cage)
{
	const int32_t steps = ffx_grid_steps(ffx->grid_code);
	size_t count = 0;
	for (size_t i = 0; i < 3 * ffx->vertex_count; i++) {
		const double exact =
			cage->xyz[i] / ffx->frame.step - ldexp((double)ffx->frame.origin[i % 3], -(int)ffx->frame.origin_bits);
		for (int move = -1; move <= 1; move += 2) {
			const int32_t other = ffx->grid[i] + move;
			const double far = fabs(exact - other);
			if (far <= FAR_LIMIT && other >= 0 && other <= steps)
				candidate[count++] = (struct candidate){i, far, other};
		}
	}
	qsort(candidate, count, sizeof *candidate, compare_candidates);
	return count;
}

static bool cost_of(double *bytes, size_t *edges, const struct ffx *ffx, size_t root, struct fault *fault)
{
	unsigned char *stream;
	size_t size;
	struct ffx_report report;
	if (!ffx_encode(&stream, &size, &report, ffx, &(struct ffx_options){.root_limit = 1, .first_root = root}, fault))
		return false;
	free(stream);
	*bytes = report.bytes_c + report.bytes_g + report.bytes_f;
	*edges = report.edge_count;
	return true;
}

bool cheaper_round(struct ffx *ffx, struct cheaper_report *report, const struct cage *cage, double tolerance, size_t root,
		   struct fault *fault)
{
	*report = (struct cheaper_report){0};
	size_t edges;
	if (!cost_of(&report->bytes_before, &edges, ffx, root, fault))
		return false;
	report->bytes_after = report->bytes_before;
	struct gridfit_ruler ruler;
	if (!gridfit_ruler_start(&ruler, cage, fault))
		return false;
	gridfit_deviation(&report->mean, &report->max, &ruler, ffx);
	const double small = GRIDFIT_SMALL_TOLERANCES * tolerance;
	const struct gridfit_damage before = gridfit_check(cage, ffx, small);
	struct candidate *candidate = mem_array(6 * ffx->vertex_count, sizeof *candidate);
	const size_t count = find_candidates(candidate, ffx, cage), limit = WORK_LIMIT / edges;
	bool is_good = true;
	for (size_t i = 0; i < count && i < limit && is_good; i++) {
		int32_t *at = &ffx->grid[candidate[i].coordinate];
		const int32_t old = *at;
		double bytes, mean, max;
		*at = candidate[i].other;
		is_good = cost_of(&bytes, &edges, ffx, root, fault);
		report->tried++;
		bool is_kept = is_good && bytes < report->bytes_after - GAIN_LEAST;
		if (is_kept) {
			gridfit_deviation(&mean, &max, &ruler, ffx);
			is_kept = mean <= tolerance && max <= GRIDFIT_MAX_OVER_MEAN * tolerance;
		}
		if (is_kept) {
			const struct gridfit_damage damage = gridfit_check(cage, ffx, small);
			is_kept = damage.collapsed <= before.collapsed && damage.turned <= before.turned &&
				  damage.overlaid <= before.overlaid;
		}
		if (is_kept) {
			report->bytes_after = bytes;
			report->mean = mean;
			report->max = max;
			report->moved++;
		} else {
			*at = old;
		}
	}
	free(candidate);
	gridfit_ruler_free(&ruler);
	return is_good;
}
