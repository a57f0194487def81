/* Partition by analytic surfaces: noise, search, borders, remains. */
#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/segment/primitive_search.h"
#include "stages/segment/region_tidy.h"
#include "stages/segment/segment_primitives.h"
#include "stages/segment/surface_noise.h"

#define EXACT_DISTANCE 5e-5   /* single precision of STL files and their modellers' own tolerances */
#define NOISY_DISTANCE 2e-4   /* from here on a mesh counts as remeshed or scanned */
#define DISTANCE_MOST 2e-3
#define NOISE_FACTOR 5.0      /* tolerance over typical distance */
#define ANGLE_TOLERANCE 0.05  /* radians: 3 degrees */

static double median_length(const struct facets *f)
{
	double sum = 0;
	for (size_t h = 0; h < 3 * f->triangle_count; h++)
		sum += f->length[h];
	return f->triangle_count ? sum / (3 * (double)f->triangle_count) : 0;
}

void segment_primitives(struct regions *r, const struct primitives_options *options, struct primitives_report *report)
{
	const struct facets *f = r->facets;
	struct flats flats;
	*report = (struct primitives_report){.distance = options->distance};
	report->noise = surface_noise(f);
	if (!(report->distance > 0))
		report->distance = fmin(DISTANCE_MOST, fmax(EXACT_DISTANCE, NOISE_FACTOR * report->noise));
	report->is_noisy = report->noise * NOISE_FACTOR >= NOISY_DISTANCE;
	flats_build(&flats, f, fmin(0.2 * report->distance, 2e-5), 0.01);
	const struct search_options search = {
		.distance = report->distance, .angle = ANGLE_TOLERANCE,
		.least_area = report->is_noisy ? options->least_area * f->total_area : 0,
		.work_most = 20000000 + 100 * f->triangle_count,
	};
	const struct tidy_options tidy = {
		.distance = report->distance, .angle = ANGLE_TOLERANCE,
		.smoothness = 0.5 * median_length(f),
		.least_area = options->least_area * f->total_area, .is_noisy = report->is_noisy,
	};
	primitive_search(r, &flats, &search);
	tidy_free_regions(r);
	tidy_borders(r, &tidy, 8);
	regions_split(r);
	tidy_absorb(r, &tidy);
	tidy_unite(r, &flats, &tidy);
	tidy_measure(r, &flats, true);
	tidy_borders(r, &tidy, 20);
	regions_split(r);
	tidy_absorb(r, &tidy);
	regions_renumber(r);
	tidy_measure(r, &flats, true);
	double free_area = 0;
	for (size_t i = 0; i < r->count; i++)
		free_area += r->patch[i].kind == PATCH_FREE ? r->patch[i].area : 0;
	report->free_share = f->total_area > 0 ? free_area / f->total_area : 0;
	flats_free(&flats);
}
