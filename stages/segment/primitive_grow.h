/* Growing one analytic surface over the triangles that it explains. All lengths in units of the facets (longest side 1). */
#ifndef CAGEWRIGHT_PRIMITIVE_GROW_H
#define CAGEWRIGHT_PRIMITIVE_GROW_H

#include "stages/geometry/primitive.h"
#include "stages/segment/flats.h"

/* Workspace and rules of growing; one a thread. */
struct grower {
	const struct facets *facets;
	const struct flats *flats; /* coplanar clusters: a curved surface takes them whole or not at all */
	const idx_t *owner;      /* region that a triangle already belongs to; growing takes only NO_INDEX */
	double distance;         /* most distance of a vertex to the surface */
	double angle;            /* radians: most angle of a facet to the surface, beyond what noise and the facet's own turn explain */
	/* result of the last grow_region, in order of growth */
	idx_t *region;
	size_t region_count;
	double region_area;
	double turn;             /* typical large turn of one facet: the second largest of its flats */
	double mean_turn;        /* root mean square turn of the facets by area */
	double mean_bend;        /* the same of the largest bend that each triangle has to a neighbour */
	size_t flat_count;       /* distinct flats in it, counted up to a few */
	size_t work;             /* triangles visited and points fitted so far: bounds the whole search */
	/* private */
	uint32_t *foot_tick;     /* a vertex: when its distance and normal below were found */
	double *foot;            /* 4 a vertex: normal of the surface at its foot point, distance */
	uint32_t *stamp, *vertex_stamp, *bad_stamp, tick, surface_tick; /* bad: flats that stick out of the surface */
	double *points, *elements, *normals, *weights;
};

void grower_init(struct grower *grower, const struct facets *facets);
void grower_free(struct grower *grower);

/* To be called before grow_explains is asked about another surface: what it remembers of vertices is void. */
void grow_begin(struct grower *grower);

/* Does the surface explain the triangle? turn_limit: most angle between surface normals at its corners (chord length, < 2);
 * turn (may be NULL) gets that angle. */
bool grow_explains(struct grower *grower, const struct dense_patch *patch, idx_t t, double turn_limit, double *turn);

/* Collect the connected triangles around seed (count of them, which must be free) that the surface explains.
 * Returns the area, 0 when no seed triangle fits. */
double grow_region(struct grower *grower, const struct dense_patch *patch, const idx_t *seed, size_t seed_count, double turn_limit);

/* Guess a surface of the kind from triangles and fit it to their vertices. False when there is none or
 * the vertices lie off it by more than most. */
bool grow_hypothesis(struct grower *grower, struct dense_patch *patch, enum patch_kind kind, const idx_t *part, size_t count, double most);

/* Alternate growing from the seed and refitting until nothing is gained. Returns the area of the last region, 0 when it
 * is not worth a patch of that kind: too few facets to confirm the surface, all facets in one plane, or a surface that turns
 * under the facets much more than the mesh bends between them (a torus through two circles of a cylinder). */
double grow_refine(struct grower *grower, struct dense_patch *patch, const idx_t *seed, size_t seed_count);

/* Fit patch (a good guess) to the vertices of count triangles; false leaves it. */
bool grow_fit(struct grower *grower, struct dense_patch *patch, const idx_t *part, size_t count);

/* Replace a torus by its dual, fitted to the triangles, when that fits and lies nearer to them; false leaves it. */
bool grow_dual_torus(struct grower *grower, struct dense_patch *patch, const idx_t *part, size_t count);

/* Largest distance of the vertices of count triangles. */
double grow_residual(const struct facets *facets, const struct dense_patch *patch, const idx_t *part, size_t count);
#endif
