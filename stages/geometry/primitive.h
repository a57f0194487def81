/* Analytic surfaces: plane, cylinder, cone, sphere, torus, all given by the parameters of struct dense_patch.
 *
 * The signed distance is positive on the side of the outward normal (out of the material). For curved surfaces that
 * normal points away from the axis, centre or tube when sign is +1, and towards it when sign is -1. A patch of kind
 * PATCH_FREE has no surface: the functions below must not be called with it. Any unit of length. */
#ifndef CAGEWRIGHT_PRIMITIVE_H
#define CAGEWRIGHT_PRIMITIVE_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/dense.h"

extern const char *const primitive_kind_name[PATCH_KIND_COUNT]; /* "plane", "cylinder", ... "free" */

/* Free parameters of a kind: plane 3, sphere 4, cylinder 5, cone 6, torus 7; 0 for free. */
int primitive_parameter_count(enum patch_kind kind);

/* Signed distance of x. Exact for every kind; behind a cone's apex the distance is that of the double cone's
 * near line, so that it stays smooth there. */
double primitive_distance(const struct dense_patch *patch, const double x[3]);

/* Foot point of x and unit outward normal there; either may be NULL. On the axis, where every direction is as good, one
 * of them is chosen. Returns the signed distance. */
double primitive_foot(const struct dense_patch *patch, const double x[3], double foot[3], double normal[3]);

struct primitive_curvature {
	double kmin, kmax;       /* |kmin| <= |kmax|, convex > 0, 1 / unit of length */
	double dmin[3], dmax[3]; /* unit, tangent; (normal, dmin, dmax) right-handed */
	bool isotropic;          /* plane, sphere: the directions are arbitrary */
};
/* Principal curvatures and directions at the foot point of x. At a cone's apex kmax is 0. */
void primitive_curvature(const struct dense_patch *patch, const double x[3], struct primitive_curvature *out);

/* A first guess of the given kind (not PATCH_FREE) from count surface elements (points and unit outward normals, 3 each,
 * positive weights or NULL). Closed forms: plane, sphere, cylinder and cone by linear least squares on normals, torus by the linear
 * complex of its normal lines (Pottmann, Randrup, Rotational and helical surface approximation, Computing 60, 1998).
 * Sets kind, point, axis, radius, radius2, sign; leaves the rest. False when the elements do not determine the kind. */
bool primitive_guess(struct dense_patch *patch, enum patch_kind kind, const double *xyz, const double *normal, const double *weight, size_t count);

/* The other torus that has the same normal and principal curvatures at the foot point of x: what is tube and what goes around
 * the axis changes places. Near x the two are hardly told apart, so a fit to a small part may end in the wrong one. False
 * where there is none that does not meet itself: only saddles have one. Touches kind, point, axis, radius, radius2, sign of out. */
bool primitive_dual_torus(struct dense_patch *out, const struct dense_patch *torus, const double x[3]);

/* Improve a guess to the least sum of squared distances of count points (weights positive or NULL) by Gauss-Newton
 * with Levenberg's damping, at most step_limit steps (0: a default of 30). Planes in closed form. sign and the sense of
 * the axis are kept. Returns false, and leaves the patch, when the fit runs away (radius over 1e4 times the extent of
 * the points, cone narrower than 0.02 or wider than 89.98 degrees) or count is less than the number of parameters. */
bool primitive_fit(struct dense_patch *patch, const double *xyz, const double *weight, size_t count, int step_limit);

/* Largest and root mean square distance of count points; either may be NULL. */
void primitive_residual(const struct dense_patch *patch, const double *xyz, size_t count, double *largest, double *rms);

#endif
