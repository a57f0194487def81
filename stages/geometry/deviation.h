/* How far two surfaces are apart, both ways (the patch method's section 13.3; after Metro: Cignoni, Rocchini and Scopigno 1998). */
#ifndef CAGEWRIGHT_DEVIATION_H
#define CAGEWRIGHT_DEVIATION_H

#include <stdbool.h>

#include "formats/fault.h"
#include "formats/memory.h"
#include "stages/geometry/nearest.h"

/* A triangle mesh; vertices that no triangle uses are not part of the surface. */
struct deviation_surface {
	const double *xyz;      /* 3 a vertex, model units */
	size_t vertex_count;
	const idx_t *triangle;  /* 3 a triangle */
	size_t triangle_count;
};

struct deviation_options {
	size_t samples;         /* a side, > 0 */
	uint64_t seed;
	double tie_relative;    /* of A's diagonal: faces this much farther than the nearest count as equally near when normals are compared */
};
#define DEVIATION_DEFAULTS ((struct deviation_options){.samples = 100000, .seed = 1, .tie_relative = 1e-6})

/* One direction. Means and percentiles over samples uniform by area; the maximum over samples, vertices, and the tops that a search
 * from the worst samples finds. */
struct deviation_side {
	double mean, rms, p50, p95, p99, max;   /* model units */
	double normal_mean_deg, normal_rms_deg, normal_p95_deg, normal_max_deg; /* [0, 180] */
	double turned_share;    /* share of the area whose normal is turned by more than 90 degrees, [0, 1] */
	/* Of that, what is turned from every face at most p95 farther than the nearest one. Beside edges that bend by 90 degrees and more the nearest
	 * face is the one beyond the edge, where the edges of the two surfaces are a little apart: a strip as wide as the error is turned there,
	 * though nothing is folded. */
	double folded_share;
	double worst[3];        /* the point of the maximum, on the sampled surface */
	double worst_foot[3];   /* and its nearest point on the other one */
};

struct deviation {
	double side, diagonal;  /* longest side and diagonal of the bounding box of A */
	/* ab: samples of A against B. both: mean of the means, root of the mean of the mean squares, larger of the percentiles, maxima
	 * and shares (worst points of the direction with the larger maximum). */
	struct deviation_side ab, ba, both;
};

/* Measure one direction; to is the tree of the other surface, tie in model units. Faults: a surface without area. */
bool deviation_one_way(struct deviation_side *out, const struct deviation_surface *from, const struct nearest *to, double tie,
                       const struct deviation_options *options, struct fault *fault);

/* Measure both. Same result with any number of threads. O((samples + vertices) log triangles). */
bool deviation_measure(struct deviation *out, const struct deviation_surface *a, const struct deviation_surface *b,
                       const struct deviation_options *options, struct fault *fault);

#endif
