/* How much of a segment and of a triangle lies in a ball: exact. */
#ifndef CAGEWRIGHT_BALLCLIP_H
#define CAGEWRIGHT_BALLCLIP_H

/* Length of the part of segment ab inside the ball (centre, radius > 0). */
double ball_segment(const double centre[3], double radius, const double a[3], const double b[3]);

/* Area of the part of triangle abc inside the ball: the ball cuts the triangle's plane in a disc, and triangle and disc
 * intersect in a signed sum of circular sectors and straight parts over the three edges. 0 for a triangle without area. */
double ball_triangle(const double centre[3], double radius, const double a[3], const double b[3], const double c[3]);

#endif
