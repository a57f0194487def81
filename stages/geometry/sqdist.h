/* Quadratic forms that approximate squared distance to a curve or surface near a foot point
 * (Pottmann and Hofer 2003; the patch method's sections 4.4 and 5.4, corrected signs). */
#ifndef CAGEWRIGHT_SQDIST_H
#define CAGEWRIGHT_SQDIST_H

enum sqdist_variant { SQDIST_SIDED = 0, SQDIST_ABS = 1, SQDIST_POINT = 2, SQDIST_TANGENT = 3 };

/* Weight of a coordinate across which the target bends: s = k * delta (curve: curvature vector . offset;
 * surface: - kappa * d). Sided: s / (s - 1) for s < 0, else 0; abs: |s| / (|s| + 1); point: 1; tangent: 0.
 * In [0, 1] for every s; 1 is reached by the point variant and by infinite s only. NaN counts as 0. */
double sqdist_weight(double s, enum sqdist_variant variant);

/* Metric I - (1 - a) t t^T of a curve at a foot point with unit tangent t, curvature vector k, offset = sample - foot. */
void sqdist_curve(double metric[6], const double tangent[3], const double curvature[3], const double offset[3], enum sqdist_variant variant);

/* Metric n n^T + a1 e1 e1^T + a2 e2 e2^T of a surface: normal n, e1 the unit direction of k1, e2 = n x e1; curvatures convex > 0;
 * d = signed height of the sample above the foot point. */
void sqdist_surface(double metric[6], const double normal[3], const double e1[3], double k1, double k2, double d, enum sqdist_variant variant);

#endif
