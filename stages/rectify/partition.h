/* A dense mesh with its labels, prepared for moving them: what the methods of rectify work on.
 *
 * Lengths are relative to the longest side of the bounding box, patches too. */
#ifndef CAGEWRIGHT_PARTITION_H
#define CAGEWRIGHT_PARTITION_H

#include <stdbool.h>

#include "formats/dense.h"
#include "stages/geometry/half.h"

struct partition {
	const struct dense *dense;
	struct half half;
	double side;             /* longest side of the bounding box in model units */
	double low[3];           /* its lower corner, model units */
	double *xyz;             /* 3 a vertex: (model - low) / side */
	unsigned char *kind;     /* a half-edge: enum edge_kind, 0 smooth */
	double *bend, *length;   /* a half-edge: radians, length */
	double *area;            /* a triangle */
	double *normal;          /* 3 a triangle, unit; of very low triangles the neighbour's */
	double *centroid;        /* 3 a triangle */
	double *curvature;       /* 2 a triangle: asinh of the mean kmin, kmax of its wedges (longest side 1) */
	double scale;            /* typical width of a triangle: median of 2 area / longest edge */
	double total_area;
	idx_t *label;            /* a triangle */
	struct dense_patch *patch; /* patch_count, relative lengths; area and parent are not kept up to date, residual is as read */
	idx_t *group;            /* a patch: number that patches cut from one surface share */
	double *mean_curvature;  /* 2 a patch: area-weighted mean of curvature, see partition_refresh */
	double *curvature_variance; /* a patch: area-weighted mean squared distance of curvature from it */
	double *normal_spread, *distance_spread; /* a patch: see partition_measure_spread; 0 before */
	double *patch_area;      /* a patch: 0 when it has no triangle left */
	size_t patch_count, patch_room, group_count;
};

/* Faults: EX_BAD_INPUT when the mesh is no manifold or the edges are not its edges. */
bool partition_new(struct partition *p, const struct dense *dense, const char *shown, struct fault *fault);
void partition_free(struct partition *p);

/* Add a copy of a patch, of the same group or of one of its own; returns its label. */
idx_t partition_add(struct partition *p, idx_t like, bool own_group);

/* Recompute patch_area, mean_curvature and curvature_variance. O(n). */
void partition_refresh(struct partition *p);

/* How well the patches fit their surfaces: median angle (radians) between the normals of a patch's triangles and its
 * surface, median of the triangles' largest distance from it. Medians, so that some wrong triangles do not count; 0 for
 * free patches. O(n log n). */
void partition_measure_spread(struct partition *p);

/* Angle and largest corner distance of one triangle to the surface of a patch, which must not be free. */
void partition_deviation(double *angle_rad, double *distance, const struct partition *p, idx_t triangle, idx_t label);

/* Give every edge-connected component but the largest of a patch a label of its own, or, where it is smaller than
 * tiny_area or tiny_share of its patch and some smooth edge leads out of it, the label of the neighbour with the longest
 * common smooth border. siblings_only: it may only join patches of its group, and the new patches stay in it. Counts are
 * added to and may be NULL. */
void partition_split(struct partition *p, double tiny_area, double tiny_share, bool siblings_only, size_t *split, size_t *absorbed);

/* Write labels and patches back: empty patches go, the others keep their order; area, residual and parent are computed.
 * dense->label and dense->patch are replaced; edges that are smooth by now (kind 0) leave dense->edge. */
void partition_finish(const struct partition *p, struct dense *dense);

/* Triangles of each patch: list[start[l]] .. list[start[l + 1]), rising; caller frees both. */
void partition_lists(const struct partition *p, size_t **start, idx_t **list);

#endif
