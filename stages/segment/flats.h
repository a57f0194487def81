/* Coplanar clusters of triangles: the facets of the tessellation as the modeller made them. */
#ifndef CAGEWRIGHT_FLATS_H
#define CAGEWRIGHT_FLATS_H

#include "stages/segment/facets.h"

struct flats {
	size_t count;
	idx_t *of;               /* a triangle: its flat */
	size_t *start;           /* count + 1 */
	idx_t *member;           /* triangles of flat i: member[start[i]] .. member[start[i + 1]), lowest first seed */
	double *area;
};

/* Grow from the largest triangles over edges that are not sharp: vertices within distance of the seed's plane, normals
 * within angle (radians) of the seed's. O(n log n). */
void flats_build(struct flats *flats, const struct facets *facets, double distance, double angle);
void flats_free(struct flats *flats);

#endif
