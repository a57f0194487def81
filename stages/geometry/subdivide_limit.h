/* Limit stencils of single vertices. Private to subdivision. */
#ifndef CAGEWRIGHT_SUBDIVIDE_LIMIT_H
#define CAGEWRIGHT_SUBDIVIDE_LIMIT_H

#include "stages/geometry/subdivide_ring.h"

struct limit {
	const struct level *level;
	const struct topology *topology;
	idx_t *outgoing;           /* a vertex: one of its corners */
	idx_t *along;              /* 2 a vertex: neighbours along a crease */
	struct ring ring;
	struct ring_cache cache;
};

/* Is there a face that a step does not leave as it is (n-gons; triangles under Catmull-Clark)? Then one step must come first. */
bool limit_needs_step(const struct level *level, enum cage_scheme scheme);

void limit_begin(struct limit *limit, const struct level *level, const struct topology *topology);
void limit_end(struct limit *limit);

/* Called with each (vertex, weight) of the stencil; a vertex may come twice. */
typedef void (*limit_put)(void *user, idx_t vertex, double weight);
void limit_stencil(struct limit *limit, size_t vertex, limit_put put, void *user);

#endif
