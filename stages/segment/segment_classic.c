/* Partition by curvature. */
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/segment/classic_cluster.h"
#include "stages/segment/classic_merge.h"
#include "stages/segment/free_charts.h"
#include "stages/segment/region_tidy.h"
#include "stages/segment/segment_classic.h"

#define MOSTLY_FREE 0.6       /* of a smooth part: no CAD face */
#define CHART_MEAN 0.7        /* length of a chart's mean normal: a cap of 66 degrees */
#define WORTH_CLASSIFYING 8.0 /* least areas: smaller free regions stay whole */
#define REMAINS_STOP 1.0      /* D_stop among what no surface explains: few patches count more than even curvature */

void segment_classic(struct regions *r, const struct dense *dense, const struct classic_options *o, struct classic_report *report)
{
	const struct facets *f = r->facets;
	const double least_area = o->least_area * f->total_area;
	struct curvature_feature feature;
	unsigned char *cluster = mem_array(f->triangle_count, 1);
	curvature_feature_build(&feature, dense, f);
	report->clusters = classic_cluster(cluster, r, &feature, o->clusters);
	classic_grow(r, &feature, cluster);
	report->grown = r->count;
	report->united = classic_merge(r, dense, &feature, &(struct merge_options){o->stop, least_area});
	tidy_identify(r, o->distance);
	regions_renumber(r);
	tidy_measure(r, 0);
	curvature_feature_free(&feature);
	free(cluster);
}

void segment_free(struct regions *r, const struct dense *dense, const struct classic_options *o)
{
	const struct facets *f = r->facets;
	const double least_area = o->least_area * f->total_area;
	double *part_area = mem_array(f->smooth_part_count, sizeof *part_area), *free_area = mem_array(f->smooth_part_count, sizeof *free_area);
	double *area = mem_array(r->count, sizeof *area);
	bool is_any = false, is_classic = false;
	for (size_t t = 0; t < f->triangle_count; t++) {
		part_area[f->smooth_part[t]] += f->area[t];
		free_area[f->smooth_part[t]] += r->patch[r->label[t]].kind == PATCH_FREE ? f->area[t] : 0;
		area[r->label[t]] += f->area[t];
	}
	/* whole smooth parts anew, as one region each */
	for (size_t t = 0; t < f->triangle_count; t++) {
		const idx_t p = f->smooth_part[t];
		is_any = is_any || r->patch[r->label[t]].kind == PATCH_FREE;
		if (free_area[p] > MOSTLY_FREE * part_area[p] && part_area[p] > WORTH_CLASSIFYING * least_area)
			r->label[t] = NO_INDEX;
	}
	if (is_any) {
		tidy_free_regions(r);
		for (size_t t = 0; t < f->triangle_count; t++) {
			const idx_t p = f->smooth_part[t], label = r->label[t];
			if (r->patch[label].kind == PATCH_FREE && free_area[p] <= MOSTLY_FREE * part_area[p] && area[label] > WORTH_CLASSIFYING * least_area) {
				r->label[t] = NO_INDEX;
				is_classic = true;
			}
		}
		if (is_classic) {
			struct curvature_feature feature;
			unsigned char *cluster = mem_array(f->triangle_count, 1);
			curvature_feature_build(&feature, dense, f);
			classic_cluster(cluster, r, &feature, o->clusters);
			classic_grow(r, &feature, cluster);
			classic_merge(r, dense, &feature, &(struct merge_options){REMAINS_STOP, WORTH_CLASSIFYING * least_area});
			curvature_feature_free(&feature);
			free(cluster);
		}
		free_charts(r, &(struct chart_options){CHART_MEAN, least_area, o->charts_most});
	}
	free(part_area);
	free(free_area);
	free(area);
}
