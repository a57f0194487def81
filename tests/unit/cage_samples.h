/* Small cages written out for the tests of subdivision. */
#ifndef CAGEWRIGHT_CAGE_SAMPLES_H
#define CAGEWRIGHT_CAGE_SAMPLES_H

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "stages/geometry/subdivide.h"

#define assert_near(a, b, tolerance) assert_near_at(a, b, tolerance, __FILE__, __LINE__)
static inline void assert_near_at(double a, double b, double tolerance, const char *file, int line)
{
	if (!(fabs(a - b) <= tolerance)) {
		print_error("%.17g and %.17g differ by %g, more than %g\n", a, b, fabs(a - b), tolerance);
		_fail(file, line);
	}
}

/* faces: vertex numbers, each face ended by -1, the list by -2. Release with cage_drop. */
static inline struct cage cage_make(const double *xyz, size_t vertex_count, const int *faces, enum cage_scheme scheme)
{
	struct cage cage = {.scheme = scheme, .vertex_count = vertex_count};
	cage.xyz = mem_copy(xyz, 3 * vertex_count, sizeof *xyz);
	cage.corner = mem_array(vertex_count, 1);
	size_t corners = 0;
	for (size_t i = 0; faces[i] != -2; i++)
		if (faces[i] == -1)
			cage.face_count++;
		else
			corners++;
	cage.face_corner = mem_array(corners, sizeof *cage.face_corner);
	cage.face_start = mem_array(cage.face_count + 1, sizeof *cage.face_start);
	cage.face_patch = mem_array(cage.face_count, sizeof *cage.face_patch);
	size_t f = 0, h = 0;
	for (size_t i = 0; faces[i] != -2; i++)
		if (faces[i] == -1)
			cage.face_start[++f] = h;
		else
			cage.face_corner[h++] = faces[i];
	return cage;
}

static inline void cage_drop(struct cage *cage)
{
	free(cage->xyz);
	free(cage->corner);
	free(cage->face_corner);
	free(cage->face_start);
	free(cage->face_patch);
	free(cage->sharp);
	memset(cage, 0, sizeof *cage);
}

/* Mark edges a-b, pairs ended by -1, as sharp (sorted, lower vertex first). */
static inline void cage_sharpen(struct cage *cage, const int *pairs)
{
	size_t count = 0;
	while (pairs[2 * count] >= 0)
		count++;
	cage->sharp = mem_resize(cage->sharp, 2 * count, sizeof *cage->sharp);
	cage->sharp_count = count;
	for (size_t s = 0; s < count; s++) {
		const int a = pairs[2 * s], b = pairs[2 * s + 1];
		size_t i = s;
		const idx_t low = a < b ? a : b, high = a < b ? b : a;
		for (; i > 0 && (cage->sharp[2 * i - 2] > low || (cage->sharp[2 * i - 2] == low && cage->sharp[2 * i - 1] > high)); i--) {
			cage->sharp[2 * i] = cage->sharp[2 * i - 2];
			cage->sharp[2 * i + 1] = cage->sharp[2 * i - 1];
		}
		cage->sharp[2 * i] = low;
		cage->sharp[2 * i + 1] = high;
	}
}

static inline struct level level_make(const struct cage *cage)
{
	struct level level;
	struct fault fault = {0};
	if (!level_from_cage(&level, cage, &fault)) {
		print_error("%s\n", fault.text);
		fail();
	}
	return level;
}

static const double cube_xyz[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
static const int cube_faces[] = {0, 3, 2, 1, -1, 4, 5, 6, 7, -1, 0, 1, 5, 4, -1, 1, 2, 6, 5, -1, 2, 3, 7, 6, -1, 3, 0, 4, 7, -1, -2};
static const double octahedron_xyz[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
static const int octahedron_faces[] = {0, 2, 4, -1, 2, 1, 4, -1, 1, 3, 4, -1, 3, 0, 4, -1, 2, 0, 5, -1, 1, 2, 5, -1, 3, 1, 5, -1, 0, 3, 5, -1, -2};
static const double tetrahedron_xyz[] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
static const int tetrahedron_faces[] = {0, 1, 2, -1, 0, 2, 3, -1, 0, 3, 1, -1, 1, 3, 2, -1, -2};
/* A house: cube with a pyramid as roof and one wall split into triangles: vertices of every mixture of triangles and quads. */
static const double house_xyz[] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 0, 0, 2, 2, 0, 2, 2, 2, 2, 0, 2, 2, 1, 1, 3.5};
static const int house_faces[] = {0, 3, 2, 1, -1, 0, 1, 5, 4, -1, 1, 2, 6, 5, -1, 2, 3, 7, -1, 2, 7, 6, -1, 3, 0, 4, 7, -1,
                                  4, 5, 8, -1, 5, 6, 8, -1, 6, 7, 8, -1, 7, 4, 8, -1, -2};
/* Prism over a hexagon of radius 1, height 2, bottom z = -1: vertices 0-5 below, 6-11 above; caps are faces 0 and 1. */
static const int prism_faces[] = {5, 4, 3, 2, 1, 0, -1, 6, 7, 8, 9, 10, 11, -1, 0, 1, 7, 6, -1, 1, 2, 8, 7, -1, 2, 3, 9, 8, -1,
                                  3, 4, 10, 9, -1, 4, 5, 11, 10, -1, 5, 0, 6, 11, -1, -2};
static const int prism_rims[] = {0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 0, 6, 7, 7, 8, 8, 9, 9, 10, 10, 11, 11, 6, -1, -1};
static inline void prism_points(double xyz[36], double radius)
{
	for (int k = 0; k < 12; k++) {
		const double angle = (k % 6) * 3.14159265358979323846 / 3;
		xyz[3 * k] = radius * cos(angle);
		xyz[3 * k + 1] = radius * sin(angle);
		xyz[3 * k + 2] = k < 6 ? -1 : 1;
	}
}

#endif
