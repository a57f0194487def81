/* Nearest points on a triangle mesh (Embree BVH, or a tree of our own by labels; the foot point is refined in double precision). */
#ifndef CAGEWRIGHT_NEAREST_H
#define CAGEWRIGHT_NEAREST_H

#include <stdbool.h>

#include "formats/memory.h"

struct nearest; /* opaque; queries of one tree may run in several threads */

struct foot {
	idx_t triangle;      /* NO_INDEX when nothing was found */
	double weight[3];    /* barycentric coordinates, >= 0, sum 1 */
	double point[3];
	double normal[3];    /* unit, of the triangle; 0 when it has no area */
	double distance;
};

/* Which triangles may answer. Zero-initialised: all. */
struct nearest_filter {
	const idx_t *label;      /* with only: triangles with label[t] == only */
	idx_t only;
	const double *normal;    /* unit; triangles whose normal n has dot(n, *normal) > least_dot are preferred: when one lies within */
	double least_dot;        /* reach * (the unrestricted distance) + slack it is taken, else the unrestricted answer */
	double reach, slack;
	idx_t hint;              /* 1 + a triangle that is probably near, such as the answer for a point close by; 0: none. The search is
	                          * faster with it, the answer the same */
};

/* Keeps pointers to the arrays: they must outlive it. Ends the program (exit 4) when Embree has no memory. */
struct nearest *nearest_new(const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count);
void nearest_free(struct nearest *nearest);

/* For meshes whose triangles bear labels, and whose vertices may move: a query with that very array as label searches the triangles
 * with its label alone. Keeps a pointer to label too. */
struct nearest *nearest_new_labelled(const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count, const idx_t *label);
/* The vertices of a labelled mesh have moved (the same array, new numbers): make the tree fit them, O(n). */
void nearest_move(struct nearest *nearest);

/* Nearest point to p; filter may be NULL. Ties go to the lowest triangle index. max_distance: INFINITY or a bound.
 * A p that is not finite has no nearest point. */
struct foot nearest_point(const struct nearest *nearest, const double p[3], double max_distance, const struct nearest_filter *filter);

/* Call visitor for every triangle within radius of p, with its nearest point; the order is not defined. */
typedef void nearest_visitor(void *user, idx_t triangle, const double point[3], double distance);
void nearest_within(const struct nearest *nearest, const double p[3], double radius, nearest_visitor *visitor, void *user);

/* Unit normal of a triangle; 0 when it has no area. */
const double *nearest_normal(const struct nearest *nearest, idx_t triangle);

/* Nearest point of one triangle and its weights (the regions of Ericson, Real-Time Collision Detection, 5.1.5); returns the
 * distance. Slivers and triangles without area give the nearest point of their sides. */
double nearest_on_triangle(double point[3], double weight[3], const double p[3], const double a[3], const double b[3], const double c[3]);

#endif
