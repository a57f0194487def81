/* Vectors in three dimensions: small inline helpers on double[3]. */
#ifndef CAGEWRIGHT_VECTOR_H
#define CAGEWRIGHT_VECTOR_H

#include <math.h>

#define PI 3.14159265358979323846
#define DEGREES (180 / PI) /* radians * DEGREES = degrees */

static inline double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static inline void cross3(double out[3], const double a[3], const double b[3])
{
	const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
	out[0] = x, out[1] = y, out[2] = z;
}
static inline void sub3(double out[3], const double a[3], const double b[3])
{
	for (int i = 0; i < 3; i++)
		out[i] = a[i] - b[i];
}
static inline void copy3(double out[3], const double a[3])
{
	for (int i = 0; i < 3; i++)
		out[i] = a[i];
}
/* out += s * a */
static inline void add_scaled3(double out[3], double s, const double a[3])
{
	for (int i = 0; i < 3; i++)
		out[i] += s * a[i];
}
static inline void scale3(double a[3], double s)
{
	for (int i = 0; i < 3; i++)
		a[i] *= s;
}
static inline double norm3(const double a[3]) { return sqrt(dot3(a, a)); }
static inline double distance3(const double a[3], const double b[3])
{
	double d[3];
	sub3(d, a, b);
	return norm3(d);
}
/* Returns the old length; a zero vector stays zero. */
static inline double normalise3(double a[3])
{
	const double length = norm3(a);
	if (length > 0)
		scale3(a, 1 / length);
	return length;
}
/* Angle in [0, pi], exact also near 0 and pi. */
static inline double angle3(const double a[3], const double b[3])
{
	double c[3];
	cross3(c, a, b);
	return atan2(norm3(c), dot3(a, b));
}
/* Twice the area vector of a triangle: points to the side from which a, b, c run counter-clockwise. */
static inline void area_vector3(double out[3], const double a[3], const double b[3], const double c[3])
{
	double u[3], v[3];
	sub3(u, b, a);
	sub3(v, c, a);
	cross3(out, u, v);
}

#endif
