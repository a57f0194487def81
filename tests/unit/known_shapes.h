/* Triangle meshes whose curvatures, sharp edges and patches are known, for the unit tests of curv and rectify. */
#ifndef CAGEWRIGHT_KNOWN_SHAPES_H
#define CAGEWRIGHT_KNOWN_SHAPES_H

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <cmocka.h>

#include "formats/mesh.h"
#include "stages/geometry/vector.h"

/* cmocka 1.1.5 compares floats as float. */
#define assert_near(actual, wanted, tolerance)                                                                               \
	do {                                                                                                                 \
		const double actual_ = (actual), wanted_ = (wanted), tolerance_ = (tolerance);                               \
		if (!(fabs(actual_ - wanted_) <= tolerance_))                                                                \
			fail_msg("%s = %.17g, wanted %.17g within %g", #actual, actual_, wanted_, tolerance_);               \
	} while (0)

/* A growing mesh of triangles. */
static inline idx_t shape_vertex(struct mesh *m, double x, double y, double z)
{
	m->xyz = mem_resize(m->xyz, 3 * (m->vertex_count + 1), sizeof *m->xyz);
	double *p = m->xyz + 3 * m->vertex_count;
	p[0] = x, p[1] = y, p[2] = z;
	return (idx_t)m->vertex_count++;
}
static inline void shape_triangle(struct mesh *m, idx_t a, idx_t b, idx_t c)
{
	m->corner = mem_resize(m->corner, 3 * (m->face_count + 1), sizeof *m->corner);
	m->face_start = mem_resize(m->face_start, m->face_count + 2, sizeof *m->face_start);
	m->face_start[0] = 0;
	m->corner[3 * m->face_count] = a, m->corner[3 * m->face_count + 1] = b, m->corner[3 * m->face_count + 2] = c;
	m->face_count++;
	m->face_start[m->face_count] = 3 * m->face_count;
}
static inline void shape_quad(struct mesh *m, idx_t a, idx_t b, idx_t c, idx_t d)
{
	shape_triangle(m, a, b, c);
	shape_triangle(m, a, c, d);
}
static inline void shape_free(struct mesh *m)
{
	free(m->xyz);
	free(m->corner);
	free(m->face_start);
	*m = (struct mesh){0};
}

/* Box [0, x] x [0, y] x [0, z]: 8 vertices, 12 triangles, faces in the order -z +z -y +x +y -x. */
static inline struct mesh shape_box(double x, double y, double z)
{
	struct mesh m = {0};
	for (int i = 0; i < 8; i++)
		shape_vertex(&m, i & 1 ? x : 0, i & 2 ? y : 0, i & 4 ? z : 0);
	shape_quad(&m, 0, 2, 3, 1);
	shape_quad(&m, 4, 5, 7, 6);
	shape_quad(&m, 0, 1, 5, 4);
	shape_quad(&m, 1, 3, 7, 5);
	shape_quad(&m, 3, 2, 6, 7);
	shape_quad(&m, 2, 0, 4, 6);
	return m;
}

/* Prism of n sides on a circle of the radius, axis z from 0 to height, rings + 1 circles of vertices, capped by fans of
 * a centre. Side triangles come first (2 n rings), then the lower cap's n, then the upper cap's n. */
static inline struct mesh shape_cylinder(double radius, double height, int n, int rings)
{
	struct mesh m = {0};
	for (int r = 0; r <= rings; r++)
		for (int i = 0; i < n; i++)
			shape_vertex(&m, radius * cos(2 * PI * i / n), radius * sin(2 * PI * i / n), height * r / rings);
	for (int r = 0; r < rings; r++)
		for (int i = 0; i < n; i++) {
			const int j = (i + 1) % n;
			shape_quad(&m, r * n + i, r * n + j, (r + 1) * n + j, (r + 1) * n + i);
		}
	const idx_t low = shape_vertex(&m, 0, 0, 0), high = shape_vertex(&m, 0, 0, height);
	for (int i = 0; i < n; i++)
		shape_triangle(&m, low, (i + 1) % n, i);
	for (int i = 0; i < n; i++)
		shape_triangle(&m, high, rings * n + i, rings * n + (i + 1) % n);
	return m;
}

/* Torus around z: centre circle of radius big, tube of radius small; around x along quads. Vertex i * along + j has the
 * angles 2 pi i / around of the big circle and 2 pi j / along of the tube (0 outside). */
static inline struct mesh shape_torus(double big, double small, int around, int along)
{
	struct mesh m = {0};
	for (int i = 0; i < around; i++)
		for (int j = 0; j < along; j++) {
			const double u = 2 * PI * i / around, v = 2 * PI * j / along;
			shape_vertex(&m, (big + small * cos(v)) * cos(u), (big + small * cos(v)) * sin(u), small * sin(v));
		}
	for (int i = 0; i < around; i++)
		for (int j = 0; j < along; j++) {
			const int k = (i + 1) % around, l = (j + 1) % along;
			shape_quad(&m, i * along + j, k * along + j, k * along + l, i * along + l);
		}
	return m;
}

/* Sphere by quartering an icosahedron: 10 * 4^level + 2 vertices. */
static inline struct mesh shape_icosphere(double radius, int level)
{
	struct mesh m = {0};
	const double t = (1 + sqrt(5)) / 2;
	static const int face[20][3] = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
	                                {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
	const double p[12][3] = {{-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0}, {0, -1, t}, {0, 1, t}, {0, -1, -t}, {0, 1, -t}, {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1}};
	for (int i = 0; i < 12; i++)
		shape_vertex(&m, p[i][0], p[i][1], p[i][2]);
	for (int i = 0; i < 20; i++)
		shape_triangle(&m, face[i][0], face[i][1], face[i][2]);
	for (int l = 0; l < level; l++) {
		struct mesh fine = {0};
		for (size_t i = 0; i < m.vertex_count; i++)
			shape_vertex(&fine, m.xyz[3 * i], m.xyz[3 * i + 1], m.xyz[3 * i + 2]);
		idx_t *middle = mem_array(3 * m.face_count, sizeof *middle);
		for (size_t h = 0; h < 3 * m.face_count; h++) {
			const idx_t a = m.corner[h], b = m.corner[h % 3 == 2 ? h - 2 : h + 1];
			middle[h] = NO_INDEX;
			for (size_t g = 0; g < h && middle[h] == NO_INDEX; g++)
				if (m.corner[g] == b && m.corner[g % 3 == 2 ? g - 2 : g + 1] == a)
					middle[h] = middle[g];
			if (middle[h] == NO_INDEX)
				middle[h] = shape_vertex(&fine, m.xyz[3 * a] + m.xyz[3 * b], m.xyz[3 * a + 1] + m.xyz[3 * b + 1],
				                         m.xyz[3 * a + 2] + m.xyz[3 * b + 2]);
		}
		for (size_t f = 0; f < m.face_count; f++) {
			const idx_t *c = m.corner + 3 * f, *e = middle + 3 * f;
			shape_triangle(&fine, c[0], e[0], e[2]);
			shape_triangle(&fine, c[1], e[1], e[0]);
			shape_triangle(&fine, c[2], e[2], e[1]);
			shape_triangle(&fine, e[0], e[1], e[2]);
		}
		free(middle);
		shape_free(&m);
		m = fine;
		for (size_t i = 0; i < m.vertex_count; i++)
			normalise3(m.xyz + 3 * i);
	}
	for (size_t i = 0; i < m.vertex_count; i++) {
		normalise3(m.xyz + 3 * i);
		scale3(m.xyz + 3 * i, radius);
	}
	return m;
}

/* Rotate by a fixed general rotation (unit quaternion of 1, 2, 3, 4), scale and move: what may not change a result. */
static inline void shape_turn(struct mesh *m, double scale)
{
	const double s = sqrt(30), w = 1 / s, x = 2 / s, y = 3 / s, z = 4 / s;
	const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
	                        {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
	                        {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
	for (size_t i = 0; i < m->vertex_count; i++) {
		double p[3];
		for (int k = 0; k < 3; k++)
			p[k] = scale * dot3(r[k], m->xyz + 3 * i) + k + 1;
		copy3(m->xyz + 3 * i, p);
	}
}

#endif
