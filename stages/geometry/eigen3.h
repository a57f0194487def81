/* Symmetric 3x3 eigenproblem by cyclic Jacobi rotations. */
#ifndef CAGEWRIGHT_EIGEN3_H
#define CAGEWRIGHT_EIGEN3_H

/* matrix: xx xy xz yy yz zz. value: ascending; vector[i] is the unit eigenvector of value[i], a right-handed frame.
 * Accurate to rounding of the largest entry; at most 32 sweeps (6 is usual). */
void eigen3_symmetric(double value[3], double vector[3][3], const double matrix[6]);

#endif
