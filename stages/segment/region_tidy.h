/* After the search: borders straightened, remains absorbed, equal surfaces united. */
#ifndef CAGEWRIGHT_REGION_TIDY_H
#define CAGEWRIGHT_REGION_TIDY_H

#include "stages/segment/flats.h"
#include "stages/segment/regions.h"

struct tidy_options {
	double distance;         /* tolerance, longest side 1 */
	double angle;            /* radians, tolerance of normals */
	double smoothness;       /* length: how much longer a border may be for a better fit; 0 for none */
	double least_area;       /* smaller free regions are absorbed, in a noisy mesh smaller patches of any kind */
	bool is_noisy;           /* surfaces are met only roughly: small patches are more likely artefacts than details */
	bool is_dense;           /* remeshed or scanned: strips of one triangle's width along smoothed edges mean nothing */
};

/* Connected triangles without region become free regions. */
void tidy_free_regions(struct regions *regions);

/* Reassign triangles along borders that are not sharp to the neighbour that explains them better (iterated conditional
 * modes of fit cost * area + smoothness * border length; at most sweeps sweeps). Returns how many changed. */
size_t tidy_borders(struct regions *regions, const struct tidy_options *options, int sweeps);

/* Unite small or thin regions with the neighbour across a border that is not sharp that explains them best. */
size_t tidy_absorb(struct regions *regions, const struct tidy_options *options);

/* Give specks, regions of a few triangles and next to no area that sharp edges may enclose (slivers between wrongly sharp
 * edges), to the neighbour with the longest common border among those whose surface their vertices meet within reach[neighbour].
 * speck_area and reach: one a region. */
size_t tidy_specks(struct regions *regions, const double *speck_area, const double *reach);

/* Free regions that lie on a plane within distance become planes. */
void tidy_flat_regions(struct regions *regions, double distance);

/* The same for every kind of surface, simplest first. */
void tidy_identify(struct regions *regions, double distance);

/* Give planes of one flat to the curved neighbours that explain all of its triangles (facets that are flat across a seam).
 * Returns how many went. */
size_t tidy_share_flats(struct regions *regions, const struct flats *flats, const struct tidy_options *options);

/* Unite neighbours that one surface explains, no more complex than the more complex of both. */
size_t tidy_unite(struct regions *regions, const struct flats *flats, const struct tidy_options *options);

/* Fill area and residual; with refit_distance > 0 first fit every surface again to its vertices within about that distance. */
void tidy_measure(struct regions *regions, double refit_distance);

#endif
