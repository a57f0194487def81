/* How much of a segment and of a triangle lies in a ball: exact. */
#ifndef CAGEWRIGHT_BALLCLIP_H
#define CAGEWRIGHT_BALLCLIP_H

#include <stdbool.h>

/* Length of the part of segment ab inside the ball (centre, radius > 0). */
double ball_segment(const double centre[3], double radius, const double a[3], const double b[3]);

/* Area of the part of triangle abc inside the ball: the ball cuts the triangle's plane in a disc, and triangle and disc
 * intersect in a signed sum of circular sectors and straight parts over the three edges. 0 for a triangle without area. */
double ball_triangle(const double centre[3], double radius, const double a[3], const double b[3], const double c[3]);

/* The same for a triangle that many balls meet: what does not depend on the ball, once. */
struct ball_plane {
	double normal[3], e1[3], e2[3]; /* orthonormal; e1 along ab */
	bool has_area;
};
void ball_plane(struct ball_plane *plane, const double a[3], const double b[3], const double c[3]);
double ball_triangle_in(const double centre[3], double radius, const struct ball_plane *plane, const double a[3], const double b[3],
                        const double c[3]);

#endif
