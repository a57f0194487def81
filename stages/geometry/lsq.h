/* Weighted least squares for control points: normal equations, sparse Cholesky (CHOLMOD). */
#ifndef CAGEWRIGHT_LSQ_H
#define CAGEWRIGHT_LSQ_H

#include <stdbool.h>

#include "formats/memory.h"

/* Unknowns are points in space; terms couple their coordinates through a 3x3 metric. */
struct lsq; /* opaque */

/* point_count points; fixed[i] != 0 keeps point i at xyz[3 i ..] (moved to the right-hand side). Both arrays are read by
 * lsq_solve and must outlive the system; fixed may be NULL and may not change, xyz may. One system belongs to one thread;
 * several systems may be used at once. Sums run in the order of the calls: same calls, same bytes. */
struct lsq *lsq_new(size_t point_count, const double *xyz, const unsigned char *fixed);
void lsq_free(struct lsq *lsq);

/* Forget all terms, keep the pattern analysis where the next pattern is the same. */
void lsq_clear(struct lsq *lsq);

/* Add weight * (sum_j coefficient[j] P[index[j]] - target)^T metric (...), metric: xx xy xz yy yz zz, positive semi-definite.
 * An index may come twice (its coefficients add up). O(count^2). */
void lsq_add(struct lsq *lsq, const idx_t *index, const double *coefficient, size_t count, const double target[3], const double metric[6], double weight);

/* Add weight * |P[i] - target|^2 (proximal terms, pulls). */
void lsq_add_point(struct lsq *lsq, idx_t i, const double target[3], double weight);

/* Parts of normal equations that were summed elsewhere: block (i, j), symmetric by itself (xx xy xz yy yz zz), and the right-hand
 * side of point i (sum of weight * coefficient * metric * target). Block (j, i) is the same one: it is added once. */
void lsq_add_block(struct lsq *lsq, idx_t i, idx_t j, const double block[6]);
void lsq_add_right(struct lsq *lsq, idx_t i, const double right[3]);

/* Mean diagonal entry of the free part so far: the scale for proximal weights. */
double lsq_scale(const struct lsq *lsq);

/* Solve; fixed points come out as they went in. False when the matrix is not positive definite to working precision: some
 * point has too few terms (nothing is written then). xyz_out may be the array given to lsq_new. */
bool lsq_solve(struct lsq *lsq, double *xyz_out);

#endif
