/* The limit samples of a draft, what each of them belongs to, and its nearest point of the target. */
#ifndef CAGEWRIGHT_JOINT_TERMS_H
#define CAGEWRIGHT_JOINT_TERMS_H

#include "stages/fitpatch/joint.h"
#include "stages/geometry/subdivide.h"

enum sample_kind { SAMPLE_SURFACE, SAMPLE_CURVE, SAMPLE_NODE };

/* Samples are the limit positions of the vertices of the refined cage. */
struct terms {
	struct cage cage;
	idx_t *vertex_of;         /* control point -> cage vertex */
	idx_t *control_of;        /* cage vertex -> control point */
	struct level level;       /* refined connectivity; xyz are limit positions */
	struct sparse rows;       /* sample = row over cage vertices */
	unsigned char *kind;      /* a sample: enum sample_kind */
	idx_t *patch;             /* a sample: patch, or left patch of a curve sample */
	idx_t *patch2;            /* right patch (-1 outside) of curve samples and of samples on smooth curves; NO_PATCH else */
	double *area;             /* a sample: its dual cell, of the first positions */
	idx_t *triangle;          /* the refined mesh as triangles */
	idx_t *triangle_patch, *triangle_face;
	idx_t *triangle_surface;  /* parent of the patch */
	size_t triangle_count;
};
#define NO_PATCH ((idx_t)-2)

bool terms_make(struct terms *terms, const struct draft *draft, const struct dense *dense, int steps, bool with_rows, struct fault *fault);
void terms_free(struct terms *terms);

/* Chains of the dense mesh by the pair of patches that they part. */
struct chain_index;
struct chain_index *chain_index_new(const struct border_network *border, const double *xyz);
void chain_index_free(struct chain_index *index);
/* Nearest point on the chains between two patches; false when there is none. tangent is unit. */
bool chain_nearest(double point[3], double tangent[3], const struct chain_index *index, idx_t patch, idx_t patch2, const double p[3]);

/* Foot of a surface sample on the surface of its patch, or on the nearer one of the two that it lies between. hint: on each surface 1 + a triangle
 * that is probably near, 0 for none; gets the triangles found. */
struct foot terms_foot(const struct terms *terms, const struct target *target, size_t sample, idx_t hint[2]);

/* Feet of all target samples on the samples' triangles of their own surface; nearest is over those (labelled by triangle_surface). Feet
 * found before (triangle NO_INDEX: none) are where the searches start. */
void terms_feet_of_target(struct foot *feet, const struct terms *terms, const struct target *target, const struct nearest *nearest);

#endif
