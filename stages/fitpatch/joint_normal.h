/* Normal equations of samples on a refined cage: summed over the refined mesh, then carried to the control points. */
#ifndef CAGEWRIGHT_JOINT_NORMAL_H
#define CAGEWRIGHT_JOINT_NORMAL_H

#include "stages/fitpatch/joint_terms.h"
#include "stages/geometry/lsq.h"

/* A point of the surface is a mean of one or three refined vertices, and these are means of about a dozen control points: its square
 * couples a few hundred pairs of them. Summed first for the vertices and edges of the refined mesh (N), a sample costs a few
 * blocks, and the sums R^T N R are carried over once, R being the subdivision operator. */
struct normal_sums {
	const struct terms *terms;
	const unsigned char *fixed; /* a cage vertex */
	double *vertex;             /* 6 a refined vertex: its block on the diagonal (xx xy xz yy yz zz) */
	double *right;              /* 3 a refined vertex */
	double *edge;               /* 6 an edge of the refined mesh */
	idx_t *edge_end;            /* 2 an edge: its vertices, the lower first */
	idx_t *triangle_edge;       /* 3 a triangle: edges 01 12 20 */
	size_t edge_count;
	/* Edges around every refined vertex. */
	size_t *around_start;
	idx_t *around;
	/* Columns (cage vertices, rising) of the row of N R of every refined vertex that has a free control point. */
	size_t *product_start;
	idx_t *product_column;
	double *product;            /* 6 an entry */
	/* R by columns. */
	size_t *column_start;
	idx_t *column_row;
	double *column_weight;
};

/* Keeps pointers to terms and fixed. O(n) time and memory in the refined mesh. */
void normal_begin(struct normal_sums *sums, const struct terms *terms, const unsigned char *fixed);
void normal_end(struct normal_sums *sums);
void normal_clear(struct normal_sums *sums);

/* Add weight * (p - target)^T metric (p - target) for refined vertex p. */
void normal_add_vertex(struct normal_sums *sums, size_t vertex, const double target[3], const double metric[6], double weight);
/* The same for a point of a refined triangle, given by its weights there. */
void normal_add_point(struct normal_sums *sums, size_t triangle, const double at[3], const double target[3], const double metric[6], double weight);

/* Add all sums to a system over the cage's vertices with the same fixed ones. */
void normal_carry(const struct normal_sums *sums, struct lsq *lsq);

#endif
