/* Cutting free-form regions into compact pieces of moderate turn. */
#ifndef CAGEWRIGHT_FREE_CHARTS_H
#define CAGEWRIGHT_FREE_CHARTS_H

#include "stages/segment/regions.h"

struct chart_options {
	double least_mean;        /* pieces have a mean normal at least so long: (1 + cos a) / 2 for a cap of half angle a */
	double least_area;        /* pieces below twice this area are not cut */
	size_t pieces_most;       /* of all free regions together */
};

/* Bisect free regions, the worst first, by two-proxy variational shape approximation (Cohen-Steiner, Alliez, Desbrun 2004,
 * metric L2,1) with flooding, until each is flat enough or there are enough. Connected pieces stay connected. Returns the cuts. */
size_t free_charts(struct regions *regions, const struct chart_options *options);

#endif
