/* Rings of vertices and their limit and tangent masks (the patch method's section 9.2). Private to subdivision. */
#ifndef CAGEWRIGHT_SUBDIVIDE_RING_H
#define CAGEWRIGHT_SUBDIVIDE_RING_H

#include "stages/geometry/subdivide_topology.h"

/* The closed ring of a smooth or dart vertex among triangles and quads, counter-clockwise. Face j lies between neighbours j
 * and j + 1; opposite is its fourth vertex when it is a quad. */
struct ring {
	size_t valence, quads;
	idx_t *neighbour;          /* valence */
	idx_t *opposite;           /* valence; NO_INDEX at triangles */
	idx_t sharp;               /* place of the sharp edge of a dart among the neighbours, or NO_INDEX */
	size_t room;
};
void ring_free(struct ring *ring);

/* Walk around the vertex at corner h. The walk begins at the sharp edge of a dart, elsewhere where the pattern of triangles
 * and quads reads lowest, so that equal patterns have equal masks. */
void ring_collect(struct ring *ring, const struct level *level, const struct topology *topology, size_t h);

/* Masks on a ring: [0] the vertex itself, [1 + j] neighbour j, [1 + valence + j] opposite j (0 at triangles). */
struct ring_mask {
	double *limit;             /* sums to 1 */
	double *tangent1, *tangent2; /* sum to 0; tangent1 x tangent2 points outside */
	unsigned char *pattern;    /* valence flags: bit 0 quad, bit 1 sharp edge */
	size_t valence;
	bool has_tangents;         /* mixed rings: computed when first asked for */
};

/* Masks by pattern, kept as they come up. */
struct ring_cache {
	struct ring_mask *mask;
	size_t count, room;
	idx_t *slot;               /* hash of patterns: number + 1 */
	size_t slot_count;
	unsigned char *pattern;    /* workspace */
	size_t pattern_room;
};
void ring_cache_free(struct ring_cache *cache);

/* The pointer holds until the next call. */
const struct ring_mask *ring_mask(struct ring_cache *cache, const struct ring *ring, bool with_tangents);

#endif
