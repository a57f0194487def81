/* Clean, smooth and cut the patches of a labelled mesh: see rectification.h. */
#include "stages/rectify/rectification.h"

#include <stdlib.h>
#include <string.h>

#define RINGS 4
#define FREE_REACH 2.5     /* typical widths that a border of free patches may move */
#define LOSS_MOST 0.3      /* a border that would take more of a patch is no border */
#define SMOOTH_ROUNDS 12
#define SMOOTH_REPEATS 3
#define PIECE_SHARE 0.02   /* pieces that smoothing cuts off a patch */

bool rectification(struct dense *dense, struct rectification_counts *counts, const struct rectification_options *options, const char *shown,
                   struct fault *fault)
{
	struct partition p;
	*counts = (struct rectification_counts){0};
	if (!partition_new(&p, dense, shown, fault))
		return false;
	const double tiny = options->tiny_share * p.total_area;
	if (options->sliver > 0)
		counts->slivers = sliver_merge(&p, options->sliver / p.side, &counts->sliver_edges);
	if (options->track) {
		const struct contourtrack_options track = {options->score_rad, options->passes, tiny};
		contourtrack(&p, &track, &counts->track);
		partition_split(&p, tiny, PIECE_SHARE, false, &counts->split, &counts->absorbed);
	}
	/* not before the smoothing: a few wrong triangles may cut a narrow patch in many pieces */
	if (options->no_smooth) {
		partition_split(&p, tiny, 0, false, &counts->split, &counts->absorbed);
	} else {
		unsigned char *fixed = mem_array(dense->triangle_count, 1);
		const struct labelsmooth_options smooth = {label_surface_cost, &p, NULL, NULL, fixed, RINGS, LOSS_MOST, SMOOTH_ROUNDS};
		partition_measure_spread(&p);
		labelsmooth_fix(fixed, &p, FREE_REACH * p.scale);
		/* pieces that change hands may set borders free to move */
		for (int i = 0; i < SMOOTH_REPEATS; i++) {
			const size_t moved = counts->smooth.relabelled, given = counts->split + counts->absorbed;
			labelsmooth(&p, &smooth, &counts->smooth);
			partition_split(&p, tiny, PIECE_SHARE, false, &counts->split, &counts->absorbed);
			if (counts->smooth.relabelled == moved || counts->split + counts->absorbed == given)
				break;
		}
		free(fixed);
	}
	for (size_t t = 0; t < dense->triangle_count; t++)
		counts->changed += p.label[t] != dense->label[t];
	if (!options->no_cut)
		patchcut(&p, &counts->cut);
	partition_finish(&p, dense);
	partition_free(&p);
	return true;
}
