/* How much of a segment and of a triangle lies in a ball: see ballclip.h. */
#include "stages/curv/ballclip.h"

#include <math.h>

#include "stages/geometry/vector.h"

#define INSIDE (1 - 1e-9) /* squared */

double ball_segment(const double centre[3], double radius, const double a[3], const double b[3])
{
	double d[3], p[3];
	sub3(d, b, a);
	sub3(p, a, centre);
	const double dd = dot3(d, d), pd = dot3(p, d), pp = dot3(p, p);
	if (dd == 0)
		return 0;
	/* Both ends within, and not by rounding: all of it, without the roots. */
	if (pp < INSIDE * radius * radius && pp + 2 * pd + dd < INSIDE * radius * radius)
		return sqrt(dd);
	const double discriminant = pd * pd - dd * (pp - radius * radius);
	if (discriminant <= 0)
		return 0;
	const double root = sqrt(discriminant);
	const double from = fmax(0, (-pd - root) / dd), to = fmin(1, (-pd + root) / dd);
	return to > from ? (to - from) * sqrt(dd) : 0;
}

/* Signed area of the circular sector between the directions of p and q. */
static double sector(double radius, const double p[2], const double q[2])
{
	return 0.5 * radius * radius * atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
}

/* Signed area of disc (origin, radius) and triangle (origin, p, q). */
static double wedge_area(double radius, const double p[2], const double q[2])
{
	const double d[2] = {q[0] - p[0], q[1] - p[1]};
	const double dd = d[0] * d[0] + d[1] * d[1], pd = p[0] * d[0] + p[1] * d[1];
	const double pp = p[0] * p[0] + p[1] * p[1], qq = q[0] * q[0] + q[1] * q[1];
	/* Both ends within, and not by rounding: what the formulas below come to, without roots. */
	if (pp < INSIDE * radius * radius && qq < INSIDE * radius * radius && dd > 0)
		return 0.5 * (p[0] * (p[1] + d[1]) - p[1] * (p[0] + d[0]));
	const double discriminant = pd * pd - dd * (pp - radius * radius);
	if (dd == 0)
		return 0;
	if (discriminant <= 0)
		return sector(radius, p, q);
	const double root = sqrt(discriminant);
	const double in = (-pd - root) / dd, out = (-pd + root) / dd;
	if (out <= 0 || in >= 1)
		return sector(radius, p, q);
	const double u = fmax(in, 0), w = fmin(out, 1);
	const double enter[2] = {p[0] + u * d[0], p[1] + u * d[1]}, leave[2] = {p[0] + w * d[0], p[1] + w * d[1]};
	double area = 0.5 * (enter[0] * leave[1] - enter[1] * leave[0]);
	if (in > 0)
		area += sector(radius, p, enter);
	if (out < 1)
		area += sector(radius, leave, q);
	return area;
}

void ball_plane(struct ball_plane *plane, const double a[3], const double b[3], const double c[3])
{
	area_vector3(plane->normal, a, b, c);
	sub3(plane->e1, b, a);
	plane->has_area = normalise3(plane->normal) > 0 && normalise3(plane->e1) > 0;
	cross3(plane->e2, plane->normal, plane->e1);
}

double ball_triangle_in(const double centre[3], double radius, const struct ball_plane *plane, const double a[3], const double b[3],
                        const double c[3])
{
	const double *corner[3] = {a, b, c};
	double from[3];
	if (!plane->has_area)
		return 0;
	sub3(from, centre, a);
	const double height = dot3(from, plane->normal), disc2 = radius * radius - height * height;
	if (disc2 <= 0)
		return 0;
	double flat[3][2];
	for (int k = 0; k < 3; k++) {
		double p[3];
		sub3(p, corner[k], centre);
		flat[k][0] = dot3(p, plane->e1);
		flat[k][1] = dot3(p, plane->e2);
	}
	const double disc = sqrt(disc2);
	double area = 0;
	for (int k = 0; k < 3; k++)
		area += wedge_area(disc, flat[k], flat[(k + 1) % 3]);
	/* far triangles are a difference of equal sectors: what is left below rounding is nothing */
	return area > 1e-13 * disc2 ? area : 0;
}

double ball_triangle(const double centre[3], double radius, const double a[3], const double b[3], const double c[3])
{
	struct ball_plane plane;
	ball_plane(&plane, a, b, c);
	return ball_triangle_in(centre, radius, &plane, a, b, c);
}
