/* Limit positions and normals: known values, invariance under subdivision, curves, rulings. */
#include "tests/unit/cage_samples.h"

#include "stages/geometry/curve.h"
#include "stages/geometry/vector.h"

static struct level refined(const struct cage *cage, int steps, bool limit)
{
	struct level in = level_make(cage), out;
	level_refine(&out, &in, cage->scheme, steps);
	if (limit)
		level_to_limit(&out, cage->scheme);
	level_free(&in);
	return out;
}

/* Corner (1, 1, 1) of a cube: 3/8 + 4/24 (1 + 1 - 1) + 1/24 (1 - 1 - 1) = 1/2 (weights n^2 : 4 : 1 over n (n + 5), n = 3). */
static void cube_limit(void **state)
{
	(void)state;
	struct cage cage = cage_make(cube_xyz, 8, cube_faces, SCHEME_QUADTRI);
	struct level l = refined(&cage, 0, true);
	for (size_t i = 0; i < 24; i++)
		assert_near(l.xyz[i], cube_xyz[i] / 2, 1e-15);
	level_free(&l);
	cage_drop(&cage);
}

/* Octahedron: neighbours of (1, 0, 0) cancel, what is left is 1 - 4 chi, chi = 1 / (3 / (8 b) + 4), b = (5/8 - (3/8)^2) / 4. */
static void octahedron_limit(void **state)
{
	(void)state;
	const double b = (5.0 / 8 - 9.0 / 64) / 4, centre = 1 - 4 / (3 / (8 * b) + 4);
	for (int scheme = SCHEME_QUADTRI; scheme <= SCHEME_LOOP; scheme++) {
		struct cage cage = cage_make(octahedron_xyz, 6, octahedron_faces, (enum cage_scheme)scheme);
		struct level l = refined(&cage, 0, true);
		for (size_t i = 0; i < 18; i++)
			assert_near(l.xyz[i], octahedron_xyz[i] * centre, 1e-15);
		level_free(&l);
		cage_drop(&cage);
	}
}

static struct cage sample(int which)
{
	struct cage cage;
	double xyz[36];
	prism_points(xyz, 1);
	switch (which) {
	case 0:
		return cage_make(house_xyz, 9, house_faces, SCHEME_QUADTRI);
	case 1: /* darts among triangles, among quads and among both */
		cage = cage_make(house_xyz, 9, house_faces, SCHEME_QUADTRI);
		cage_sharpen(&cage, (const int[]){4, 8, 0, 1, 2, 6, -1, -1});
		return cage;
	case 2: /* n-gons; a dart from the rim down */
		cage = cage_make(xyz, 12, prism_faces, SCHEME_QUADTRI);
		cage_sharpen(&cage, (const int[]){6, 7, 7, 8, 8, 9, 9, 10, 10, 11, 11, 6, 0, 1, -1, -1});
		return cage;
	case 3:
		return cage_make(octahedron_xyz, 6, octahedron_faces, SCHEME_CATMULLCLARK);
	case 4:
		cage = cage_make(tetrahedron_xyz, 4, tetrahedron_faces, SCHEME_LOOP);
		cage_sharpen(&cage, (const int[]){0, 1, -1, -1});
		return cage;
	default: /* valence 2 */
		return cage_make(xyz, 6, (const int[]){0, 1, 2, 3, 4, 5, -1, 5, 4, 3, 2, 1, 0, -1, -2}, SCHEME_QUADTRI);
	}
}
enum { SAMPLE_COUNT = 6 };

/* The defining property of a left eigenvector for eigenvalue 1: the mask gives the same point on every level. And that point is
 * where subdivision goes: after six steps it is near. */
static void limits_do_not_depend_on_the_level(void **state)
{
	(void)state;
	for (int which = 0; which < SAMPLE_COUNT; which++) {
		struct cage cage = sample(which);
		struct level coarse = refined(&cage, 0, true), fine = refined(&cage, 1, true), finer = refined(&cage, 4, true), deep = refined(&cage, 6, false);
		for (size_t i = 0; i < 3 * coarse.vertex_count; i++) {
			assert_near(coarse.xyz[i], finer.xyz[i], 1e-14);
			assert_near(coarse.xyz[i], deep.xyz[i], 5e-3);
		}
		for (size_t i = 0; i < 3 * fine.vertex_count; i++)
			assert_near(fine.xyz[i], finer.xyz[i], 1e-14);
		level_free(&coarse);
		level_free(&fine);
		level_free(&finer);
		level_free(&deep);
		cage_drop(&cage);
	}
}

/* Tangent masks span an invariant plane: away from creases the normal is the same on every level; it is a unit vector. */
static void normals_do_not_depend_on_the_level(void **state)
{
	(void)state;
	for (int which = 0; which < SAMPLE_COUNT - 1; which++) {
		struct cage cage = sample(which);
		struct level coarse = refined(&cage, 1, false), fine = refined(&cage, 3, false), deep = refined(&cage, 5, true);
		double *a = mem_array(3 * coarse.vertex_count, sizeof *a), *b = mem_array(3 * fine.vertex_count, sizeof *b);
		level_normals(a, &coarse, cage.scheme);
		level_normals(b, &fine, cage.scheme);
		unsigned char *sharp_edges = mem_array(coarse.vertex_count, 1);
		for (size_t f = 0; f < coarse.face_count; f++)
			for (size_t h = coarse.face_start[f]; h < coarse.face_start[f + 1]; h++)
				sharp_edges[coarse.face_corner[h]] += coarse.sharp[h]; /* out of a closed mesh's vertex: once an edge */
		for (size_t v = 0; v < coarse.vertex_count; v++) {
			assert_near(norm3(a + 3 * v), 1, 1e-14);
			if (sharp_edges[v] > 1)
				continue;
			assert_near(distance3(a + 3 * v, b + 3 * v), 0, 1e-10);
			/* and it is the normal of the faces that meet there far down, up to their size */
			double mean[3] = {0, 0, 0};
			for (size_t f = 0; f < deep.face_count; f++)
				for (size_t h = deep.face_start[f]; h < deep.face_start[f + 1]; h++)
					if (deep.face_corner[h] == (idx_t)v) {
						double area[3];
						const idx_t *c = deep.face_corner + deep.face_start[f];
						area_vector3(area, deep.xyz + 3 * c[0], deep.xyz + 3 * c[1], deep.xyz + 3 * c[2]);
						add_scaled3(mean, 1 / norm3(area), area);
					}
			normalise3(mean);
			assert_near(distance3(a + 3 * v, mean), 0, 0.1);
		}
		free(a);
		free(b);
		free(sharp_edges);
		level_free(&coarse);
		level_free(&fine);
		level_free(&deep);
		cage_drop(&cage);
	}
}

/* Distance of p from the nearest of the curve's points at steps of 1 / per_segment. */
static double off_curve(const double p[3], const double *points, size_t count, bool closed, int per_segment)
{
	double best = INFINITY, q[3];
	for (size_t k = 0; k <= (count - !closed) * (size_t)per_segment; k++) {
		curve_point(q, points, count, closed, (double)k / per_segment);
		best = fmin(best, distance3(p, q));
	}
	return best;
}

/* Rim of a prism: sharp, or border when the caps are missing: the limits of level 3 lie on the closed B-spline of the rim's control
 * points at whole eighths. */
static void crease_ring_is_the_curve(void **state)
{
	(void)state;
	double xyz[36];
	prism_points(xyz, 1);
	xyz[1] = -0.4; /* no symmetry needed */
	xyz[23] = 1.6;
	for (int open = 0; open < 2; open++) {
		struct cage cage = cage_make(xyz, 12, prism_faces + (open ? 14 : 0), SCHEME_QUADTRI);
		if (!open)
			cage_sharpen(&cage, prism_rims);
		struct level l = refined(&cage, 3, true);
		size_t on_rims = 0;
		for (size_t h = 0; h < l.face_start[l.face_count]; h++) {
			if (!l.sharp[h])
				continue;
			const double *p = l.xyz + 3 * l.face_corner[h];
			assert_near(fmin(off_curve(p, xyz, 6, true, 8), off_curve(p, xyz + 18, 6, true, 8)), 0, 1e-15);
			on_rims++;
		}
		assert_int_equal(on_rims, (open ? 1 : 2) * 2 * 6 * 8);
		level_free(&l);
		cage_drop(&cage);
	}
}

/* A border between two corners is the natural B-spline that ends there. */
static void crease_between_corners_is_the_open_curve(void **state)
{
	(void)state;
	/* strip of four quads; the corners are those of the strip */
	double xyz[30];
	for (int k = 0; k < 5; k++) {
		const double low[3] = {k, 0.3 * (k % 2), sin(k)}, high[3] = {k, 2, cos(k)};
		copy3(xyz + 3 * k, low);
		copy3(xyz + 15 + 3 * k, high);
	}
	struct cage cage = cage_make(xyz, 10, (const int[]){0, 1, 6, 5, -1, 1, 2, 7, 6, -1, 2, 3, 8, 7, -1, 3, 4, 9, 8, -1, -2}, SCHEME_QUADTRI);
	cage.corner[0] = cage.corner[4] = cage.corner[5] = cage.corner[9] = 1;
	struct level l = refined(&cage, 3, true);
	size_t count = 0;
	for (size_t h = 0; h < l.face_start[l.face_count]; h++)
		if (l.sharp[h]) {
			const double *p = l.xyz + 3 * l.face_corner[h];
			const double ends[2][6] = {{xyz[0], xyz[1], xyz[2], xyz[15], xyz[16], xyz[17]}, {xyz[12], xyz[13], xyz[14], xyz[27], xyz[28], xyz[29]}};
			const double off = fmin(fmin(off_curve(p, xyz, 5, false, 8), off_curve(p, xyz + 15, 5, false, 8)),
			                        fmin(off_curve(p, ends[0], 2, false, 8), off_curve(p, ends[1], 2, false, 8)));
			assert_near(off, 0, 2e-15);
			count++;
		}
	assert_int_equal(count, 2 * (4 + 1) * 8);
	level_free(&l);
	cage_drop(&cage);
}

/* Between two equal crease polygons a band of quads is exactly ruled: below and above each other everywhere. And with six points
 * a circle, the limit is within 2.2e-3 of the cylinder of its mean radius; the caps are flat. */
static void prism_is_a_cylinder(void **state)
{
	(void)state;
	double xyz[36];
	prism_points(xyz, 1.203);
	struct cage cage = cage_make(xyz, 12, prism_faces, SCHEME_QUADTRI);
	cage_sharpen(&cage, prism_rims);
	struct level l = refined(&cage, 4, true);
	double least = INFINITY, most = 0;
	size_t side_points = 0;
	for (size_t f = 0; f < l.face_count; f++)
		for (size_t h = l.face_start[f]; h < l.face_start[f + 1]; h++) {
			const double *p = l.xyz + 3 * l.face_corner[h];
			if (l.face_origin[f] < 2) {
				assert_near(p[2], l.face_origin[f] == 0 ? -1 : 1, 1e-15);
				continue;
			}
			const double r = hypot(p[0], p[1]);
			least = fmin(least, r);
			most = fmax(most, r);
			const double foot[3] = {p[0], p[1], -1};
			assert_near(off_curve(foot, xyz, 6, true, 16), 0, 2e-15);
			side_points++;
		}
	assert_int_equal(side_points, 6 * 256 * 4);
	const double mean = (least + most) / 2;
	assert_near(mean, 1, 1e-3);
	assert_true((most - least) / 2 / mean <= 2.2e-3);
	level_free(&l);
	cage_drop(&cage);
}

/* x -> A x + t before or after: the same surface. */
static void affine_maps_commute(void **state)
{
	(void)state;
	const double a[3][3] = {{2, 0.3, -0.1}, {0.5, -1, 0.7}, {0.2, 0.4, 1.5}}, t[3] = {3, -2, 1};
	for (int which = 0; which < SAMPLE_COUNT; which++)
		for (int limit = 0; limit < 2; limit++) {
			struct cage cage = sample(which);
			struct level before = refined(&cage, 3, limit);
			for (size_t v = 0; v < cage.vertex_count; v++) {
				double p[3];
				for (int i = 0; i < 3; i++)
					p[i] = dot3(a[i], cage.xyz + 3 * v) + t[i];
				copy3(cage.xyz + 3 * v, p);
			}
			struct level after = refined(&cage, 3, limit);
			for (size_t v = 0; v < before.vertex_count; v++)
				for (size_t i = 0; i < 3; i++)
					assert_near(after.xyz[3 * v + i], dot3(a[i], before.xyz + 3 * v) + t[i], 2e-14);
			level_free(&before);
			level_free(&after);
			cage_drop(&cage);
		}
}

/* --- all patterns of triangles and quads around a vertex ------------------------------------------------------------ */

enum { MOST = 7, RING = 1 + 2 * MOST };

/* Vertex 0, neighbours 1 .. n, then the fourth vertices of quads; bit j of pattern: is face j a quad? */
static struct cage ring_cage(size_t n, unsigned pattern, bool dart)
{
	double xyz[3 * RING] = {0};
	int faces[5 * MOST + 1], f = 0;
	size_t count = 1 + n;
	for (size_t j = 0; j < n; j++) {
		const double here = 2 * PI * (double)j / (double)n, between = here + PI / (double)n;
		xyz[3 + 3 * j] = cos(here);
		xyz[4 + 3 * j] = sin(here);
		faces[f++] = 0;
		faces[f++] = 1 + (int)j;
		if (pattern >> j & 1) {
			xyz[3 * count] = 1.5 * cos(between);
			xyz[3 * count + 1] = 1.5 * sin(between);
			faces[f++] = (int)count++;
		}
		faces[f++] = 1 + (int)((j + 1) % n);
		faces[f++] = -1;
	}
	faces[f] = -2;
	struct cage cage = cage_make(xyz, count, faces, SCHEME_QUADTRI);
	if (dart)
		cage_sharpen(&cage, (const int[]){0, 1, -1, -1});
	return cage;
}

/* The matrix of one step on the ring, from the rows of the operator: m[i][j], new ring point i from old ring point j. */
static size_t ring_step(double m[RING][RING], const struct cage *cage, size_t n)
{
	struct level in = level_make(cage), out;
	struct sparse step;
	subdivide_operator(&step, &out, &in, SCHEME_QUADTRI, 1, false);
	size_t row[RING] = {0}, count = 1 + n;
	/* the first child of face j is (0, middle of edge j, centre for quads, ...) */
	for (size_t j = 0; j < n; j++) {
		const idx_t *child = out.face_corner + 4 * in.face_start[j];
		assert_int_equal(child[0], 0);
		row[1 + j] = (size_t)child[1];
		if (in.face_start[j + 1] - in.face_start[j] == 4)
			row[count++] = (size_t)child[2];
	}
	assert_int_equal(count, cage->vertex_count);
	for (size_t i = 0; i < count; i++) {
		for (size_t j = 0; j < count; j++)
			m[i][j] = 0;
		for (size_t k = step.row_start[row[i]]; k < step.row_start[row[i] + 1]; k++)
			m[i][step.column[k]] = step.weight[k];
	}
	sparse_free(&step);
	level_free(&in);
	level_free(&out);
	return count;
}

/* limit . step = limit, for every pattern up to valence 7, smooth and dart. */
static void masks_are_left_eigenvectors(void **state)
{
	(void)state;
	size_t tried = 0;
	for (size_t n = 3; n <= MOST; n++)
		for (unsigned pattern = 0; pattern < 1u << n; pattern++)
			for (int dart = 0; dart < 2; dart++) {
				struct cage cage = ring_cage(n, pattern, dart);
				double m[RING][RING];
				const size_t count = ring_step(m, &cage, n);
				struct level in = level_make(&cage), out;
				struct sparse limit;
				subdivide_operator(&limit, &out, &in, SCHEME_QUADTRI, 0, true);
				double mask[RING] = {0}, sum = 0;
				for (size_t k = limit.row_start[0]; k < limit.row_start[1]; k++) {
					mask[limit.column[k]] = limit.weight[k];
					sum += limit.weight[k];
				}
				assert_near(sum, 1, 1e-15);
				for (size_t j = 0; j < count; j++) {
					double image = 0;
					for (size_t i = 0; i < count; i++)
						image += mask[i] * m[i][j];
					assert_near(image, mask[j], 3e-16);
				}
				sparse_free(&limit);
				level_free(&in);
				level_free(&out);
				cage_drop(&cage);
				tried++;
			}
	assert_int_equal(tried, 2 * (8 + 16 + 32 + 64 + 128));
}

/* Eigenvalues by orthogonal iteration, largest magnitude first (they are real and distinct where this is asked). */
static void eigenvalues(double value[RING], double m[RING][RING], size_t count)
{
	double q[RING][RING] = {{0}}, r[RING][RING]; /* rows are vectors */
	for (size_t i = 0; i < count; i++)
		for (size_t j = 0; j < count; j++)
			q[i][j] = (i == j) + 0.1 * sin((double)(3 * i + 7 * j * j));
	for (int step = 0; step < 3000; step++) {
		for (size_t i = 0; i < count; i++)
			for (size_t k = 0; k < count; k++) {
				r[i][k] = 0;
				for (size_t j = 0; j < count; j++)
					r[i][k] += m[k][j] * q[i][j];
			}
		for (size_t i = 0; i < count; i++) {
			double length = 0, rayleigh = 0;
			for (size_t k = 0; k < count; k++)
				rayleigh += r[i][k] * q[i][k];
			value[i] = rayleigh;
			for (size_t l = 0; l < i; l++) {
				double p = 0;
				for (size_t k = 0; k < count; k++)
					p += r[i][k] * q[l][k];
				for (size_t k = 0; k < count; k++)
					r[i][k] -= p * q[l][k];
			}
			for (size_t k = 0; k < count; k++)
				length += r[i][k] * r[i][k];
			for (size_t k = 0; k < count; k++)
				q[i][k] = r[i][k] / sqrt(length);
		}
	}
}

/* Two triangles, two quads: the published spectrum 1, 0.4523, 0.4451, 0.2045, the last being the square of the second: bounded
 * curvature. The same for one and three quads among four faces. */
static void corrected_vertices_have_bounded_curvature(void **state)
{
	(void)state;
	const struct {
		size_t n;
		unsigned pattern;
	} known[] = {{4, 3}, {4, 1}, {4, 7}};
	for (int k = 0; k < 3; k++) {
		struct cage cage = ring_cage(known[k].n, known[k].pattern, false);
		double m[RING][RING], value[RING];
		const size_t count = ring_step(m, &cage, known[k].n);
		eigenvalues(value, m, count);
		assert_near(value[0], 1, 1e-12);
		assert_near(value[3], value[1] * value[1], 2e-4);
		if (k == 0) {
			assert_near(value[1], 0.4523, 5e-5);
			assert_near(value[2], 0.4451, 5e-5);
			assert_near(value[3], 0.2045, 5e-5);
		}
		cage_drop(&cage);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(cube_limit),
	        cmocka_unit_test(octahedron_limit),
	        cmocka_unit_test(limits_do_not_depend_on_the_level),
	        cmocka_unit_test(normals_do_not_depend_on_the_level),
	        cmocka_unit_test(crease_ring_is_the_curve),
	        cmocka_unit_test(crease_between_corners_is_the_open_curve),
	        cmocka_unit_test(prism_is_a_cylinder),
	        cmocka_unit_test(affine_maps_commute),
	        cmocka_unit_test(masks_are_left_eigenvectors),
	        cmocka_unit_test(corrected_vertices_have_bounded_curvature),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
