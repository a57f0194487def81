/* Angles, lengths and planes in integers: what the forward coder's contexts are made of. Private to formats/ffx*.
 *
 * Vectors have parts below 2^18. Angles are in 1/4096 of a turn. */
#ifndef CAGEWRIGHT_FFX_ANGLE_H
#define CAGEWRIGHT_FFX_ANGLE_H

#include <stdbool.h>
#include <stdint.h>

#define ANGLE_TURN 4096

/* b - a */
static inline void vector_between(int64_t out[3], const int32_t *a, const int32_t *b)
{
	for (int k = 0; k < 3; k++)
		out[k] = (int64_t)b[k] - a[k];
}
static inline bool vector_is_zero(const int64_t v[3])
{
	return v[0] == 0 && v[1] == 0 && v[2] == 0;
}
/* Halve until every part is below 2^15, rounding to 0. */
void vector_shrink(int64_t v[3]);
/* a x b; parts of a and b below 2^30. */
static inline void vector_cross(int64_t out[3], const int64_t a[3], const int64_t b[3])
{
	for (int k = 0; k < 3; k++)
		out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}
static inline int64_t vector_dot(const int64_t a[3], const int64_t b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
/* Largest whole number whose square is at most x. */
uint32_t root_of(uint64_t x);
/* Length, rounded down; parts below 2^31. */
uint32_t vector_length(const int64_t v[3]);

/* Angle between two vectors, 0 to 2048; 0 when one of them is 0. */
int angle_between(const int64_t a[3], const int64_t b[3]);

/* How far the surface bends at an edge along which left and right have these normals (below 2^15): -2048 to 2048, > 0 where it
 * is convex, edge running with the left face; 0 when a normal is 0. */
int angle_bend(const int64_t left[3], const int64_t right[3], const int64_t edge[3]);

#endif
