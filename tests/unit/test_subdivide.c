/* Subdivision steps against the published rules, written again here without any of the code under test. */
#include "tests/unit/cage_samples.h"

#include <malloc.h>

#include "stages/geometry/curve.h"
#include "stages/geometry/subdivide_room.h"
#include "stages/geometry/vector.h"

/* Faces that hold the edge a-b (either direction). */
static size_t faces_of_edge(idx_t face[2], const struct level *m, idx_t a, idx_t b)
{
	size_t count = 0;
	for (size_t f = 0; f < m->face_count; f++)
		for (size_t h = m->face_start[f]; h < m->face_start[f + 1]; h++) {
			const size_t n = h + 1 == m->face_start[f + 1] ? m->face_start[f] : h + 1;
			const idx_t c = m->face_corner[h], d = m->face_corner[n];
			if ((c == a && d == b) || (c == b && d == a))
				face[count++ % 2] = (idx_t)f;
		}
	return count;
}

static void face_mean(double out[3], const struct level *m, idx_t f)
{
	const size_t degree = m->face_start[f + 1] - m->face_start[f];
	out[0] = out[1] = out[2] = 0;
	for (size_t h = m->face_start[f]; h < m->face_start[f + 1]; h++)
		add_scaled3(out, 1.0 / (double)degree, m->xyz + 3 * m->face_corner[h]);
}

/* Is there a vertex of m at p? */
static void assert_has_point(const struct level *m, const double p[3])
{
	double best = INFINITY;
	for (size_t v = 0; v < m->vertex_count; v++)
		best = fmin(best, distance3(m->xyz + 3 * v, p));
	assert_near(best, 0, 1e-14);
}

/* Catmull and Clark 1978: face points F, edge points (a + b + F1 + F2) / 4, vertices (Q + 2 R + (n - 3) S) / n, for closed
 * smooth meshes of any faces. Every point must be there, and no other. */
static void assert_catmull_clark(const struct level *in, const struct level *out)
{
	size_t edges = 0;
	for (size_t f = 0; f < in->face_count; f++) {
		double p[3];
		face_mean(p, in, (idx_t)f);
		assert_has_point(out, p);
		for (size_t h = in->face_start[f]; h < in->face_start[f + 1]; h++) {
			const size_t n = h + 1 == in->face_start[f + 1] ? in->face_start[f] : h + 1;
			const idx_t a = in->face_corner[h], b = in->face_corner[n];
			idx_t face[2];
			assert_int_equal(faces_of_edge(face, in, a, b), 2);
			edges += a < b;
			double q[3], e[3] = {0, 0, 0};
			for (int k = 0; k < 2; k++) {
				face_mean(q, in, face[k]);
				add_scaled3(e, 0.25, q);
			}
			add_scaled3(e, 0.25, in->xyz + 3 * a);
			add_scaled3(e, 0.25, in->xyz + 3 * b);
			assert_has_point(out, e);
		}
	}
	for (size_t v = 0; v < in->vertex_count; v++) {
		double q[3] = {0, 0, 0}, r[3] = {0, 0, 0}, p[3] = {0, 0, 0};
		int n = 0;
		for (size_t f = 0; f < in->face_count; f++)
			for (size_t h = in->face_start[f]; h < in->face_start[f + 1]; h++) {
				if (in->face_corner[h] != (idx_t)v)
					continue;
				const size_t next = h + 1 == in->face_start[f + 1] ? in->face_start[f] : h + 1;
				double c[3];
				face_mean(c, in, (idx_t)f);
				add_scaled3(q, 1, c);
				add_scaled3(r, 0.5, in->xyz + 3 * v);
				add_scaled3(r, 0.5, in->xyz + 3 * in->face_corner[next]);
				n++;
			}
		add_scaled3(p, 1.0 / (n * n), q);
		add_scaled3(p, 2.0 / (n * n), r);
		add_scaled3(p, (n - 3.0) / n, in->xyz + 3 * v);
		assert_near(distance3(p, out->xyz + 3 * v), 0, 1e-14);
	}
	assert_int_equal(out->vertex_count, in->vertex_count + edges + in->face_count);
	assert_int_equal(out->face_count, in->face_start[in->face_count]);
}

/* Loop 1987: edges 3/8 3/8 1/8 1/8, vertices (1 - n b) v + b sum, b = (5/8 - (3/8 + cos(2 pi / n) / 4)^2) / n. */
static void assert_loop(const struct level *in, const struct level *out)
{
	size_t edges = 0;
	for (size_t v = 0; v < in->vertex_count; v++) {
		double sum[3] = {0, 0, 0};
		int n = 0;
		for (size_t h = 0; h < 3 * in->face_count; h++) {
			if (in->face_corner[h] != (idx_t)v)
				continue;
			const idx_t w = in->face_corner[h - h % 3 + (h + 1) % 3];
			add_scaled3(sum, 1, in->xyz + 3 * w);
			n++;
			edges += (idx_t)v < w;
			idx_t face[2];
			assert_int_equal(faces_of_edge(face, in, (idx_t)v, w), 2);
			double p[3] = {0, 0, 0};
			add_scaled3(p, 3.0 / 8 - 1.0 / 4, in->xyz + 3 * v); /* the sums over both faces below add 2/8 each */
			add_scaled3(p, 3.0 / 8 - 1.0 / 4, in->xyz + 3 * w);
			for (int k = 0; k < 2; k++)
				for (int c = 0; c < 3; c++)
					add_scaled3(p, 1.0 / 8, in->xyz + 3 * in->face_corner[3 * face[k] + c]);
			assert_has_point(out, p);
		}
		const double g = 3.0 / 8 + cos(2 * PI / n) / 4, b = (5.0 / 8 - g * g) / n;
		double p[3] = {0, 0, 0};
		add_scaled3(p, 1 - n * b, in->xyz + 3 * v);
		add_scaled3(p, b, sum);
		assert_near(distance3(p, out->xyz + 3 * v), 0, 1e-14);
	}
	assert_int_equal(out->vertex_count, in->vertex_count + edges);
	assert_int_equal(out->face_count, 4 * in->face_count);
}

/* Two steps one after the other, each against the reference. */
static void two_steps(const double *xyz, size_t count, const int *faces, enum cage_scheme scheme, void (*check)(const struct level *, const struct level *))
{
	struct cage cage = cage_make(xyz, count, faces, scheme);
	struct level l0 = level_make(&cage), l1, l2;
	level_refine(&l1, &l0, scheme, 1);
	level_refine(&l2, &l1, scheme, 1);
	check(&l0, &l1);
	check(&l1, &l2);
	level_free(&l0);
	level_free(&l1);
	level_free(&l2);
	cage_drop(&cage);
}

static void quads_are_catmull_clark(void **state)
{
	(void)state;
	two_steps(cube_xyz, 8, cube_faces, SCHEME_QUADTRI, assert_catmull_clark);
	two_steps(cube_xyz, 8, cube_faces, SCHEME_CATMULLCLARK, assert_catmull_clark);
}

static void catmull_clark_takes_any_faces(void **state)
{
	(void)state;
	double xyz[36];
	prism_points(xyz, 1);
	two_steps(xyz, 12, prism_faces, SCHEME_CATMULLCLARK, assert_catmull_clark);
	two_steps(house_xyz, 9, house_faces, SCHEME_CATMULLCLARK, assert_catmull_clark);
	two_steps(octahedron_xyz, 6, octahedron_faces, SCHEME_CATMULLCLARK, assert_catmull_clark);
}

static void triangles_are_loop(void **state)
{
	(void)state;
	two_steps(octahedron_xyz, 6, octahedron_faces, SCHEME_QUADTRI, assert_loop);
	two_steps(octahedron_xyz, 6, octahedron_faces, SCHEME_LOOP, assert_loop);
	two_steps(tetrahedron_xyz, 4, tetrahedron_faces, SCHEME_QUADTRI, assert_loop);
	two_steps(tetrahedron_xyz, 4, tetrahedron_faces, SCHEME_LOOP, assert_loop);
}

static void assert_same_level(const struct level *a, const struct level *b)
{
	assert_int_equal(a->vertex_count, b->vertex_count);
	assert_int_equal(a->face_count, b->face_count);
	const size_t corners = a->face_start[a->face_count];
	assert_int_equal(corners, b->face_start[b->face_count]);
	assert_memory_equal(a->xyz, b->xyz, 3 * a->vertex_count * sizeof *a->xyz);
	assert_memory_equal(a->face_corner, b->face_corner, corners * sizeof *a->face_corner);
	assert_memory_equal(a->face_start, b->face_start, a->face_count * sizeof *a->face_start);
	assert_memory_equal(a->face_origin, b->face_origin, a->face_count * sizeof *a->face_origin);
	assert_memory_equal(a->corner, b->corner, a->vertex_count);
	assert_memory_equal(a->sharp, b->sharp, corners);
}

/* The cages that show every rule: mixed faces, n-gons, creases, corners, darts, borders. */
enum { SAMPLE_COUNT = 7 };
static struct cage sample(int which)
{
	struct cage cage;
	double xyz[36];
	prism_points(xyz, 1);
	switch (which) {
	case 0:
		return cage_make(house_xyz, 9, house_faces, SCHEME_QUADTRI);
	case 1: /* a crease around the roof, a dart down the roof, a corner on the crease */
		cage = cage_make(house_xyz, 9, house_faces, SCHEME_QUADTRI);
		cage_sharpen(&cage, (const int[]){4, 5, 5, 6, 6, 7, 7, 4, 4, 8, 0, 1, -1, -1});
		cage.corner[6] = 1;
		return cage;
	case 2:
		cage = cage_make(xyz, 12, prism_faces, SCHEME_QUADTRI);
		cage_sharpen(&cage, prism_rims);
		return cage;
	case 3: /* without its caps: two borders */
		return cage_make(xyz, 12, prism_faces + 14, SCHEME_QUADTRI);
	case 4:
		cage = cage_make(xyz, 12, prism_faces, SCHEME_CATMULLCLARK);
		cage_sharpen(&cage, (const int[]){0, 1, 1, 2, 7, 8, -1, -1});
		return cage;
	case 5:
		cage = cage_make(octahedron_xyz, 6, octahedron_faces, SCHEME_LOOP);
		cage_sharpen(&cage, (const int[]){0, 2, 2, 1, 1, 3, 0, 4, -1, -1});
		return cage;
	default: /* a pillow: two hexagons back to back, every vertex of valence 2 */
		return cage_make(xyz, 6, (const int[]){0, 1, 2, 3, 4, 5, -1, 5, 4, 3, 2, 1, 0, -1, -2}, SCHEME_QUADTRI);
	}
}

/* Three steps at once and one by one: the same bytes; and the sizes that are foretold. */
static void steps_compose(void **state)
{
	(void)state;
	for (int which = 0; which < SAMPLE_COUNT; which++) {
		struct cage cage = sample(which);
		struct level whole, now = level_make(&cage), next;
		level_refine(&whole, &now, cage.scheme, 3);
		size_t vertices, faces, corners;
		level_refined_size(&vertices, &faces, &corners, &now, cage.scheme, 3);
		assert_int_equal(vertices, whole.vertex_count);
		assert_int_equal(faces, whole.face_count);
		assert_int_equal(corners, whole.face_start[whole.face_count]);
		for (int s = 0; s < 3; s++) {
			level_refine(&next, &now, cage.scheme, 1);
			/* old vertices come first: their flags are where they were */
			assert_memory_equal(now.corner, next.corner, now.vertex_count);
			level_free(&now);
			now = next;
		}
		assert_same_level(&whole, &now);
		level_free(&whole);
		level_free(&now);
		cage_drop(&cage);
	}
}

/* Large levels take memory as it comes, what it held before must not show. Seven steps of the smallest sample are large. */
static void old_memory_does_not_show(void **state)
{
	(void)state;
	for (int which = 0; which < SAMPLE_COUNT; which++) {
		struct cage cage = sample(which);
		struct level base = level_make(&cage), level[2];
		for (int i = 0; i < 2; i++) {
			mallopt(M_PERTURB, i ? 0x5a : 0xc3); /* glibc then fills new memory with the complement */
			level_refine(&level[i], &base, cage.scheme, which == 0 ? 7 : 4);
			mallopt(M_PERTURB, 0);
		}
		if (which == 0)
			assert_true(3 * level[0].vertex_count * sizeof(double) > ROOM_LARGE);
		assert_same_level(&level[0], &level[1]);
		for (int i = 0; i < 2; i++)
			level_free(&level[i]);
		level_free(&base);
		cage_drop(&cage);
	}
}

/* Pieces of one room do not overlap, and each starts on a cache line of it. */
static void pieces_of_a_room(void **state)
{
	(void)state;
	const size_t count[] = {0, 1, 100, 50000}, size[] = {8, 1, 3, 24};
	size_t all = 0;
	for (int i = 0; i < 4; i++)
		all += room_piece(count[i], size[i]);
	unsigned char *room = room_zeroed(all, 1), *next = room, *before = room;
	assert_true(all > ROOM_LARGE);
	for (size_t i = 0; i < all; i++)
		assert_int_equal(room[i], 0);
	for (int i = 0; i < 4; i++) {
		unsigned char *piece = room_take(&next, count[i], size[i]);
		assert_true(piece >= before && (piece - room) % 64 == 0);
		before = piece + count[i] * size[i];
		assert_true(before <= next);
	}
	assert_ptr_equal(next, room + all);
	free(room);
}

/* Rows of the operator: the very surface, rising columns, sums of 1. */
static void operator_equals_refiner(void **state)
{
	(void)state;
	for (int which = 0; which < SAMPLE_COUNT; which++)
		for (int steps = 0; steps < 4; steps++)
			for (int limit = 0; limit < 2; limit++) {
				struct cage cage = sample(which);
				struct level in = level_make(&cage), want, refined;
				level_refine(&want, &in, cage.scheme, steps);
				if (limit)
					level_to_limit(&want, cage.scheme);
				struct sparse m;
				subdivide_operator(&m, &refined, &in, cage.scheme, steps, limit);
				assert_int_equal(m.row_count, want.vertex_count);
				assert_int_equal(m.column_count, cage.vertex_count);
				double *xyz = mem_array(3 * m.row_count, sizeof *xyz);
				sparse_apply(xyz, &m, cage.xyz);
				for (size_t i = 0; i < 3 * m.row_count; i++) {
					assert_near(xyz[i], want.xyz[i], 2e-14);
					assert_near(refined.xyz[i], want.xyz[i], 2e-14);
				}
				for (size_t r = 0; r < m.row_count; r++) {
					double sum = 0;
					for (size_t k = m.row_start[r]; k < m.row_start[r + 1]; k++) {
						sum += m.weight[k];
						assert_true(k == m.row_start[r] || m.column[k - 1] < m.column[k]);
					}
					assert_near(sum, 1, steps < 2 ? 1e-15 : 4e-15);
				}
				memcpy(refined.xyz, want.xyz, 3 * want.vertex_count * sizeof *want.xyz);
				assert_same_level(&refined, &want);
				free(xyz);
				sparse_free(&m);
				level_free(&in);
				level_free(&want);
				level_free(&refined);
				cage_drop(&cage);
			}
}

/* Other numbers for vertices and faces, faces that begin at another corner: the same surface. */
static void numbering_does_not_matter(void **state)
{
	(void)state;
	for (int which = 0; which < SAMPLE_COUNT; which++) {
		struct cage cage = sample(which), other = sample(which);
		const size_t n = cage.vertex_count;
		/* vertex v becomes (v * 5 + 3) mod n, or its mirror where 5 divides n; faces run backwards, each turned by one corner */
		idx_t *map = mem_array(n, sizeof *map);
		for (size_t v = 0; v < n; v++)
			map[v] = (idx_t)(n % 5 ? (5 * v + 3) % n : n - 1 - v);
		for (size_t v = 0; v < n; v++) {
			copy3(other.xyz + 3 * map[v], cage.xyz + 3 * v);
			other.corner[map[v]] = cage.corner[v];
		}
		size_t h = 0;
		for (size_t f = 0; f < cage.face_count; f++) {
			const size_t from = cage.face_count - 1 - f, first = cage.face_start[from], degree = cage.face_start[from + 1] - first;
			for (size_t k = 0; k < degree; k++)
				other.face_corner[h++] = map[cage.face_corner[first + (k + 1) % degree]];
			other.face_start[f + 1] = h;
		}
		int pairs[40] = {0};
		for (size_t s = 0; s < 2 * cage.sharp_count; s++)
			pairs[s] = map[cage.sharp[s]];
		pairs[2 * cage.sharp_count] = -1;
		cage_sharpen(&other, pairs);
		struct level a = level_make(&cage), b = level_make(&other), fine, same;
		level_refine(&fine, &a, cage.scheme, 2);
		level_refine(&same, &b, cage.scheme, 2);
		level_to_limit(&fine, cage.scheme);
		level_to_limit(&same, cage.scheme);
		assert_int_equal(fine.vertex_count, same.vertex_count);
		for (size_t v = 0; v < n; v++)
			assert_near(distance3(fine.xyz + 3 * v, same.xyz + 3 * map[v]), 0, 1e-14);
		for (size_t v = n; v < fine.vertex_count; v++)
			assert_has_point(&same, fine.xyz + 3 * v);
		free(map);
		level_free(&a);
		level_free(&b);
		level_free(&fine);
		level_free(&same);
		cage_drop(&cage);
		cage_drop(&other);
	}
}

/* Every edge of a closed mesh belongs to two faces, in opposite directions: count directed edges after sorting. */
static int compare_pairs(const void *a, const void *b)
{
	return memcmp(a, b, 2 * sizeof(uint32_t));
}

static void closed_stays_watertight(void **state)
{
	(void)state;
	const int closed[] = {0, 1, 2, 4, 5, 6};
	for (size_t i = 0; i < sizeof closed / sizeof *closed; i++) {
		struct cage cage = sample(closed[i]);
		struct level in = level_make(&cage), l;
		level_refine(&l, &in, cage.scheme, 4);
		const size_t n = l.face_start[l.face_count];
		uint32_t *forward = mem_array(2 * n, sizeof *forward), *backward = mem_array(2 * n, sizeof *backward);
		for (size_t f = 0; f < l.face_count; f++)
			for (size_t h = l.face_start[f]; h < l.face_start[f + 1]; h++) {
				const size_t next = h + 1 == l.face_start[f + 1] ? l.face_start[f] : h + 1;
				forward[2 * h] = backward[2 * h + 1] = (uint32_t)l.face_corner[h];
				forward[2 * h + 1] = backward[2 * h] = (uint32_t)l.face_corner[next];
			}
		qsort(forward, n, 2 * sizeof *forward, compare_pairs);
		qsort(backward, n, 2 * sizeof *backward, compare_pairs);
		assert_memory_equal(forward, backward, 2 * n * sizeof *forward);
		for (size_t h = 1; h < n; h++)
			assert_int_not_equal(compare_pairs(forward + 2 * h - 2, forward + 2 * h), 0);
		for (size_t k = 0; k < 3 * l.vertex_count; k++)
			assert_true(isfinite(l.xyz[k]));
		free(forward);
		free(backward);
		level_free(&in);
		level_free(&l);
		cage_drop(&cage);
	}
}

/* A flat cage of triangles, quads and a pentagon stays flat: heights are combinations of zeros. */
static void flat_stays_flat(void **state)
{
	(void)state;
	const double xyz[] = {0, 0, 0, 2, 0, 0, 3, 1, 0, 2, 2, 0, 0, 2, 0, 1, 1, 0, 4, 0, 0, 4, 2, 0};
	struct cage cage = cage_make(xyz, 8, (const int[]){0, 1, 5, -1, 0, 5, 4, -1, 5, 1, 2, 3, 4, -1, 1, 6, 2, -1, 6, 7, 3, 2, -1, -2}, SCHEME_QUADTRI);
	struct level in = level_make(&cage), l;
	level_refine(&l, &in, SCHEME_QUADTRI, 3);
	level_to_limit(&l, SCHEME_QUADTRI);
	for (size_t v = 0; v < l.vertex_count; v++)
		assert_true(l.xyz[3 * v + 2] == 0);
	level_free(&in);
	level_free(&l);
	cage_drop(&cage);
}

/* Corners keep their place at every level, and so do vertices with three sharp edges: a cube with all edges sharp stays one. */
static void corners_stay(void **state)
{
	(void)state;
	struct cage cage = cage_make(cube_xyz, 8, cube_faces, SCHEME_QUADTRI);
	cage_sharpen(&cage, (const int[]){0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7, -1, -1});
	struct level in = level_make(&cage), l;
	level_refine(&l, &in, SCHEME_QUADTRI, 4);
	assert_memory_equal(l.xyz, cube_xyz, sizeof cube_xyz);
	for (size_t v = 0; v < l.vertex_count; v++) {
		double far = 0;
		for (int i = 0; i < 3; i++)
			far = fmax(far, fabs(l.xyz[3 * v + (size_t)i]));
		assert_near(far, 1, 1e-15); /* on the cube's surface */
		assert_int_equal(l.corner[v], v < 8);
	}
	level_free(&in);
	level_free(&l);
	cage_drop(&cage);
}

/* (1, 6, 1) / 8 and midpoints on a crease of a smooth solid. */
static void crease_step(void **state)
{
	(void)state;
	struct cage cage = cage_make(cube_xyz, 8, cube_faces, SCHEME_QUADTRI);
	cage_sharpen(&cage, (const int[]){4, 5, 5, 6, 6, 7, 7, 4, -1, -1});
	struct level in = level_make(&cage), l;
	level_refine(&l, &in, SCHEME_QUADTRI, 1);
	/* vertex 4 = (-1, -1, 1) between 5 = (1, -1, 1) and 7 = (-1, 1, 1) */
	const double want[3] = {(-6 + 1 - 1) / 8.0, (-6 - 1 + 1) / 8.0, 1}, middle[3] = {0, -1, 1};
	assert_near(distance3(l.xyz + 12, want), 0, 1e-15);
	assert_has_point(&l, middle);
	level_free(&in);
	level_free(&l);
	cage_drop(&cage);
}

/* Mixed vertex of the house's roof edge, valence 4 with triangles (2) and quads (2), against the published mask: smoothing of the
 * split mesh with alpha = 1 / (1 + 4/2 + 2/4), then p + eta (q - p) beyond, eta(4, 2) = 0.21380. */
static void mixed_vertex(void **state)
{
	(void)state;
	struct cage cage = cage_make(house_xyz, 9, house_faces, SCHEME_QUADTRI);
	struct level in = level_make(&cage), l;
	level_refine(&l, &in, SCHEME_QUADTRI, 1);
	/* vertex 5: quads 0 1 5 4 and 1 2 6 5, triangles 4 5 8 and 5 6 8; neighbours 4 1 6 8 */
	const double *p = house_xyz + 15;
	const int neighbour[4] = {4, 1, 6, 8}, quad[2][4] = {{0, 1, 5, 4}, {1, 2, 6, 5}};
	const double alpha = 1 / (1 + 4 / 2.0 + 2 / 4.0);
	for (int i = 0; i < 3; i++) {
		double q = alpha * p[i];
		for (int k = 0; k < 4; k++)
			q += alpha / 2 * (p[i] + house_xyz[3 * neighbour[k] + i]) / 2;
		for (int k = 0; k < 2; k++)
			for (int c = 0; c < 4; c++)
				q += alpha / 4 * house_xyz[3 * quad[k][c] + i] / 4;
		assert_near(l.xyz[15 + i], q + 0.21380 * (q - p[i]), 1e-15);
	}
	/* edge 5-6 between a quad and a triangle: centre 1/4, neighbours 1/8, opposite corners of the split quad 1/16 */
	const double *a = house_xyz + 15, *b = house_xyz + 18, *top = house_xyz + 24, *c = house_xyz + 3, *d = house_xyz + 6;
	double edge[3];
	for (int i = 0; i < 3; i++) {
		const double face = (a[i] + b[i] + c[i] + d[i]) / 4;
		edge[i] = (a[i] + b[i]) / 2 / 4 + (a[i] + b[i] + (a[i] + top[i]) / 2 + (b[i] + top[i]) / 2 + face) / 8 +
		          ((a[i] + c[i]) / 2 + (b[i] + d[i]) / 2) / 16;
	}
	assert_has_point(&l, edge);
	level_free(&in);
	level_free(&l);
	cage_drop(&cage);
}

/* What is no cage is refused, and the message names the place. */
static void refuse(const double *xyz, size_t count, const int *faces, enum cage_scheme scheme, const int *sharp, const char *message)
{
	struct cage cage = cage_make(xyz, count, faces, scheme);
	if (sharp)
		cage_sharpen(&cage, sharp);
	struct level level;
	struct fault fault = {0};
	assert_false(level_from_cage(&level, &cage, &fault));
	assert_string_equal(fault.text, message);
	assert_int_equal(fault.code, EX_BAD_INPUT);
	cage_drop(&cage);
}

static void bad_cages(void **state)
{
	(void)state;
	const double *xyz = cube_xyz;
	refuse(xyz, 4, (const int[]){0, 1, 2, -1, 1, 0, 3, -1, 0, 1, 3, -1, -2}, SCHEME_QUADTRI, NULL, "edge 0-1 has 3 faces (0, 1, 2)");
	refuse(xyz, 4, (const int[]){0, 1, 2, -1, 0, 1, 3, -1, -2}, SCHEME_QUADTRI, NULL,
	       "faces 0 and 1 run along edge 0-1 in the same direction: orientations differ");
	refuse(xyz, 5, (const int[]){0, 1, 2, -1, 0, 3, 4, -1, -2}, SCHEME_QUADTRI, NULL,
	       "vertex 0 has more than one fan of faces (one with face 1)");
	/* two tetrahedra that touch at vertex 0: closed fans */
	refuse(xyz, 7, (const int[]){0, 1, 2, -1, 0, 2, 3, -1, 0, 3, 1, -1, 1, 3, 2, -1, 0, 4, 5, -1, 0, 5, 6, -1, 0, 6, 4, -1, 4, 6, 5, -1, -2},
	       SCHEME_QUADTRI, NULL, "vertex 0 has more than one fan of faces (one with face 4)");
	refuse(xyz, 4, (const int[]){0, 1, 2, 1, -1, -2}, SCHEME_QUADTRI, NULL, "face 0 has vertex 1 twice");
	refuse(xyz, 4, (const int[]){0, 1, -1, -2}, SCHEME_QUADTRI, NULL, "face 0 has 2 vertices, less than 3");
	refuse(xyz, 3, (const int[]){0, 1, 3, -1, -2}, SCHEME_QUADTRI, NULL, "face 0: there is no vertex 3");
	refuse(xyz, 4, (const int[]){0, 1, 2, -1, -2}, SCHEME_QUADTRI, NULL, "vertex 3 has no face");
	refuse(xyz, 4, (const int[]){0, 1, 2, 3, -1, -2}, SCHEME_LOOP, NULL, "face 0 has 4 vertices: Loop subdivision needs triangles");
	refuse(xyz, 4, (const int[]){0, 1, 2, 3, -1, -2}, SCHEME_QUADTRI, (const int[]){0, 1, 0, 2, -1, -1}, "sharp edge 0-2 is no edge of a face");
	refuse(xyz, 4, (const int[]){0, 1, 2, 3, -1, -2}, SCHEME_QUADTRI, (const int[]){3, 9, -1, -1}, "sharp edge 3-9 is no edge of a face");
}

/* Sizes beyond what indices can number are foretold, not run into. */
static void too_many_steps(void **state)
{
	(void)state;
	struct cage cage = cage_make(cube_xyz, 8, cube_faces, SCHEME_QUADTRI);
	struct level in = level_make(&cage);
	size_t vertices, faces, corners;
	level_refined_size(&vertices, &faces, &corners, &in, SCHEME_QUADTRI, 13);
	assert_int_equal(corners, (size_t)24 << 26);
	assert_int_equal(faces, (size_t)6 << 26);
	assert_int_equal(vertices, ((size_t)6 << 26) + 2); /* Euler: V = E - F + 2, E = 2 F */
	level_refined_size(&vertices, NULL, NULL, &in, SCHEME_QUADTRI, 14);
	assert_true(vertices == SIZE_MAX);
	level_free(&in);
	cage_drop(&cage);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(quads_are_catmull_clark),
	        cmocka_unit_test(catmull_clark_takes_any_faces),
	        cmocka_unit_test(triangles_are_loop),
	        cmocka_unit_test(steps_compose),
	        cmocka_unit_test(old_memory_does_not_show),
	        cmocka_unit_test(pieces_of_a_room),
	        cmocka_unit_test(operator_equals_refiner),
	        cmocka_unit_test(numbering_does_not_matter),
	        cmocka_unit_test(closed_stays_watertight),
	        cmocka_unit_test(flat_stays_flat),
	        cmocka_unit_test(corners_stay),
	        cmocka_unit_test(crease_step),
	        cmocka_unit_test(mixed_vertex),
	        cmocka_unit_test(bad_cages),
	        cmocka_unit_test(too_many_steps),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
