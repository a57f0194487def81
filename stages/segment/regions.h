/* A partition of the triangles with one surface a region, and what is done to it after the surfaces were found. */
#ifndef CAGEWRIGHT_REGIONS_H
#define CAGEWRIGHT_REGIONS_H

#include "stages/geometry/primitive.h"
#include "stages/segment/facets.h"

struct regions {
	const struct facets *facets;
	idx_t *label;              /* a triangle; NO_INDEX: none yet */
	struct dense_patch *patch; /* units of the facets */
	size_t count, capacity;
};

void regions_init(struct regions *regions, const struct facets *facets);
void regions_free(struct regions *regions);
idx_t regions_add(struct regions *regions, const struct dense_patch *patch);

/* Triangles by region: member[start[i]] .. member[start[i + 1]); caller frees both. Triangles without region are left out. */
void regions_members(const struct regions *regions, size_t **start, idx_t **member);

/* Make every region connected over edges that are not sharp: further parts become regions of their own with the same surface. */
void regions_split(struct regions *regions);

/* Drop unused regions, number the others by their lowest triangle. */
void regions_renumber(struct regions *regions);

/* One pair of regions that share a border, low < high. */
struct region_border {
	idx_t low, high;
	double length;             /* of the common border */
	double sharp_length;       /* of its sharp part */
};
/* Sorted by (low, high); caller frees. Triangles without region are left out. */
size_t regions_borders(const struct regions *regions, struct region_border **border);

#endif
