/* Deviations that can be worked out by hand: plates, cubes, and what sampling and triangulation must keep. */
#include <math.h>
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "stages/deviate/creases.h"
#include "stages/geometry/deviation.h"
#include "stages/geometry/sample.h"
#include "stages/geometry/triangulate.h"
#include "stages/geometry/trimesh.h"
#include "stages/geometry/vector.h"

static void assert_near(double got, double want, double tolerance)
{
	if (!(fabs(got - want) <= tolerance))
		fail_msg("%.17g is not within %g of %.17g", got, tolerance, want);
}

static const struct deviation_options quick = {.samples = 20000, .seed = 1, .tie_relative = 1e-6};

/* A unit square at height z as two triangles. */
static const idx_t plate_triangle[6] = {0, 1, 2, 0, 2, 3}, turned_triangle[6] = {0, 2, 1, 0, 3, 2};
static void make_plate(double xyz[12], double x, double z)
{
	const double corner[12] = {x, 0, z, x + 1, 0, z, x + 1, 1, z, x, 1, z};
	memcpy(xyz, corner, sizeof corner);
}

/* A cube [low, high]^3 of 12 triangles, outward. */
static const idx_t cube_triangle[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
static void make_cube(double xyz[24], double low, double high)
{
	for (int i = 0; i < 24; i++)
		xyz[i] = i / 3 >> i % 3 & 1 ? high : low;
}

static struct deviation measure(const double *a, size_t a_vertices, const idx_t *a_triangle, size_t a_count, const double *b,
                                size_t b_vertices, const idx_t *b_triangle, size_t b_count)
{
	const struct deviation_surface from = {a, a_vertices, a_triangle, a_count}, to = {b, b_vertices, b_triangle, b_count};
	struct deviation deviation;
	struct fault fault = {0};
	if (!deviation_measure(&deviation, &from, &to, &quick, &fault))
		fail_msg("%s", fault.text);
	return deviation;
}

static void parallel_plates(void **state)
{
	(void)state;
	/* Every point has the same distance and the same normal; seen the other way up, the opposite normal. */
	double a[12], b[12];
	make_plate(a, 0, 0);
	make_plate(b, 0, 0.25);
	struct deviation d = measure(a, 4, plate_triangle, 2, b, 4, plate_triangle, 2);
	assert_near(d.side, 1, 0);
	assert_near(d.diagonal, M_SQRT2, 1e-15);
	const struct deviation_side *const side[3] = {&d.ab, &d.ba, &d.both};
	for (int i = 0; i < 3; i++) {
		assert_near(side[i]->mean, 0.25, 1e-12);
		assert_near(side[i]->rms, 0.25, 1e-12);
		assert_near(side[i]->p50, 0.25, 1e-15);
		assert_near(side[i]->p99, 0.25, 1e-15);
		assert_near(side[i]->max, 0.25, 1e-15);
		assert_near(side[i]->normal_max_deg, 0, 1e-12);
		assert_near(side[i]->turned_share, 0, 0);
		assert_near(distance3(side[i]->worst, side[i]->worst_foot), 0.25, 1e-15);
	}
	d = measure(a, 4, plate_triangle, 2, b, 4, turned_triangle, 2);
	assert_near(d.both.normal_mean_deg, 180, 1e-9);
	assert_near(d.both.normal_p95_deg, 180, 1e-9);
	assert_near(d.both.turned_share, 1, 0);
	assert_near(d.both.folded_share, 1, 0); /* there is no other face */
}

static void turned_part_of_a_plate(void **state)
{
	(void)state;
	/* One of the two halves is turned over: half of the area, to the sample. Points near the common side may take the good normal, but
	 * only within the tie distance of 1.4e-6. */
	const idx_t half_turned[6] = {0, 1, 2, 0, 3, 2};
	double a[12];
	make_plate(a, 0, 0);
	const struct deviation d = measure(a, 4, plate_triangle, 2, a, 4, half_turned, 2);
	assert_near(d.ab.turned_share, 0.5, 1e-4);
	assert_near(d.ab.folded_share, 0.5, 1e-4); /* the error is 0, and the good half no nearer by it */
	assert_near(d.both.max, 0, 1e-15);
}

static void edge_beside_an_edge(void **state)
{
	(void)state;
	/* A ridge of 60 degrees between two faces of unit length, and the same one a hundredth to the right. Its left face lies
	 * e cos 30 inside the first one's, and crosses the right one s = e from the top (s along the face): the right face is nearer for s < 2 e.
	 * That strip is turned by 120 degrees, two hundredths of the half of the area that is left; the left face is hardly farther,
	 * so nothing is folded. */
	const double e = 0.01, x = 0.5, z = -sqrt(3) / 2;
	double a[18] = {0, 0, 0, 0, 1, 0, -x, 0, z, -x, 1, z, x, 0, z, x, 1, z}, b[18];
	const idx_t ridge[12] = {0, 1, 3, 0, 3, 2, 1, 0, 4, 1, 4, 5};
	for (int i = 0; i < 18; i++)
		b[i] = a[i] + (i % 3 == 0 ? e : 0);
	const struct deviation d = measure(a, 6, ridge, 4, b, 6, ridge, 4);
	assert_near(d.ba.turned_share, e, 0.2 * e);
	assert_near(d.ba.folded_share, 0, 0);
	assert_near(d.both.folded_share, 0, 0);
}

static void cube_in_cube(void **state)
{
	(void)state;
	/* The inner cube is everywhere 0.05 below the outer one. The other way it is 0.05 over the middle of a face, the hypotenuse of 0.05
	 * and the overhang in the strips along its edges, and 0.05 sqrt(3) at the corners, which are vertices. */
	double inner[24], outer[24];
	make_cube(inner, 0.05, 1.05);
	make_cube(outer, 0, 1.1);
	const struct deviation d = measure(outer, 8, cube_triangle, 12, inner, 8, cube_triangle, 12);
	assert_near(d.side, 1.1, 1e-15);
	assert_near(d.ba.mean, 0.05, 1e-12);
	assert_near(d.ba.max, 0.05, 1e-12);
	assert_near(d.ab.max, 0.05 * sqrt(3), 1e-12);
	double mean = 0;
	const int n = 440; /* midpoint rule over one face */
	for (int i = 0; i < n; i++)
		for (int j = 0; j < n; j++) {
			const double x = 1.1 * (i + 0.5) / n, y = 1.1 * (j + 0.5) / n;
			const double over_x = fmax(0, fmax(0.05 - x, x - 1.05)), over_y = fmax(0, fmax(0.05 - y, y - 1.05));
			mean += sqrt(over_x * over_x + over_y * over_y + 0.0025) / (n * n);
		}
	assert_near(d.ab.mean, mean, 1e-4 * mean);
	assert_near(d.both.mean, (d.ab.mean + d.ba.mean) / 2, 1e-15);
	assert_near(d.both.max, d.ab.max, 0);
	/* Samples over an edge of the inner cube are equally near to two of its faces: the parallel one counts. */
	assert_near(d.both.normal_max_deg, 0, 1e-9);
}

static void maximum_between_the_samples(void **state)
{
	(void)state;
	/* A plate 8 long over a roof valley whose two slopes meet along x = 3.7: the highest point over it is a line that 100 samples miss
	 * by a tenth, and no vertex of the plate lies there. The slopes fall by 1 in 1, so the nearest point of a sample at height h over
	 * the valley line is h / sqrt(2) away. */
	const double plate[] = {0, 0, 0, 8, 0, 0, 8, 4, 0, 0, 4, 0};
	const double valley[] = {-9, -9, 9.7, -9, 13, 9.7, 3.7, -9, -3, 3.7, 13, -3, 19.4, -9, 12.7, 19.4, 13, 12.7};
	const idx_t slopes[] = {0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5};
	const struct deviation_surface from = {plate, 4, plate_triangle, 2};
	struct nearest *to = nearest_new(valley, 6, slopes, 4);
	const struct deviation_options few = {.samples = 100, .seed = 1};
	struct deviation_side side;
	struct fault fault = {0};
	assert_true(deviation_one_way(&side, &from, to, 0, &few, &fault));
	assert_near(side.max, 3 / M_SQRT2, 0.02);
	assert_near(side.worst[0], 3.7, 0.04);
	nearest_free(to);
}

static void far_away_and_scaled(void **state)
{
	(void)state;
	double a[24], b[24], a2[24], b2[24];
	make_cube(a, 0, 1);
	make_cube(b, 0.01, 1.02);
	const struct deviation near = measure(a, 8, cube_triangle, 12, b, 8, cube_triangle, 12);
	for (int i = 0; i < 24; i++) {
		a2[i] = a[i] + 1e6;
		b2[i] = b[i] + 1e6;
	}
	const struct deviation far = measure(a2, 8, cube_triangle, 12, b2, 8, cube_triangle, 12);
	assert_near(far.both.mean, near.both.mean, 1e-9);
	assert_near(far.both.max, near.both.max, 1e-9);
	for (int i = 0; i < 24; i++) {
		a2[i] = a[i] * 1e-30;
		b2[i] = b[i] * 1e-30;
	}
	const struct deviation tiny = measure(a2, 8, cube_triangle, 12, b2, 8, cube_triangle, 12);
	assert_near(tiny.both.rms / tiny.side, near.both.rms / near.side, 1e-12);
	assert_near(tiny.both.normal_p95_deg, near.both.normal_p95_deg, 1e-9);
}

static void same_with_any_number_of_threads(void **state)
{
	(void)state;
	double a[24], b[24];
	make_cube(a, 0, 1);
	make_cube(b, 0.01, 1.02);
	const int before = omp_get_max_threads();
	omp_set_num_threads(1);
	const struct deviation one = measure(a, 8, cube_triangle, 12, b, 8, cube_triangle, 12);
	omp_set_num_threads(3);
	const struct deviation three = measure(a, 8, cube_triangle, 12, b, 8, cube_triangle, 12);
	omp_set_num_threads(before);
	assert_memory_equal(&one, &three, sizeof one);
}

static void no_area(void **state)
{
	(void)state;
	const double line[9] = {0, 0, 0, 1, 0, 0, 2, 0, 0};
	double cube[24];
	make_cube(cube, 0, 1);
	const struct deviation_surface flat = {line, 3, plate_triangle, 1}, good = {cube, 8, cube_triangle, 12}, none = {cube, 8, cube_triangle, 0};
	struct deviation deviation;
	struct fault fault = {0};
	assert_false(deviation_measure(&deviation, &flat, &good, &quick, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	fault = (struct fault){0};
	assert_false(deviation_measure(&deviation, &good, &flat, &quick, &fault));
	fault = (struct fault){0};
	assert_false(deviation_measure(&deviation, &good, &none, &quick, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
}

static void samples_follow_area(void **state)
{
	(void)state;
	/* Two triangles of areas 1 and 3, one without area between them: a quarter of 1000 samples on the first, none on the second; the
	 * mean of the samples of a triangle is its centroid, to the accuracy of a low-discrepancy sequence. */
	const double xyz[] = {0, 0, 0, 2, 0, 0, 0, 1, 0, 5, 5, 5, 10, 0, 0, 12, 0, 0, 10, 3, 0};
	const idx_t triangle[] = {0, 1, 2, 3, 3, 3, 4, 5, 6};
	enum { COUNT = 1000 };
	double point[3 * COUNT], mean[3][3] = {{0}};
	idx_t on[COUNT];
	assert_near(sample_surface(point, on, COUNT, xyz, triangle, 3, 5), 4, 1e-12);
	int count[3] = {0};
	for (int i = 0; i < COUNT; i++) {
		count[on[i]]++;
		add_scaled3(mean[on[i]], 1, point + 3 * i);
		assert_true(i == 0 || on[i] >= on[i - 1]);
	}
	assert_int_equal(count[1], 0);
	assert_near(count[0], 250, 1);
	assert_near(mean[0][0] / count[0], 2.0 / 3, 0.01);
	assert_near(mean[0][1] / count[0], 1.0 / 3, 0.01);
	assert_near(mean[2][0] / count[2], 10 + 2.0 / 3, 0.01);
	assert_near(mean[2][1] / count[2], 1, 0.01);
	/* Another seed, other points. */
	double other[3 * COUNT];
	sample_surface(other, on, COUNT, xyz, triangle, 3, 6);
	assert_true(memcmp(point, other, sizeof point) != 0);
	assert_near(sample_surface(point, on, COUNT, xyz, triangle + 3, 1, 5), 0, 0);
}

static void check_cut(const double *xyz, const idx_t *polygon, size_t count, double area)
{
	idx_t *triangle = mem_array(3 * count, sizeof *triangle);
	triangulate_polygon(triangle, xyz, polygon, count);
	double sum = 0;
	for (size_t t = 0; t + 2 < count; t++) {
		double n[3];
		area_vector3(n, xyz + 3 * triangle[3 * t], xyz + 3 * triangle[3 * t + 1], xyz + 3 * triangle[3 * t + 2]);
		if (!(n[2] >= 0)) /* 0: the corners between teeth lie on one line */
			fail_msg("triangle %zu of %zu: %g", t, count, n[2]);
		sum += n[2] / 2;
	}
	assert_near(sum, area, 1e-12 * area);
	free(triangle);
}

static void polygons_keep_their_area(void **state)
{
	(void)state;
	/* No triangle is turned over and the areas add up: nothing overlaps. */
	const double arrow[] = {0, 0, 0, 2, 1, 0, 0, 2, 0, 1, 1, 0}; /* a quad with a dent at its last corner */
	const idx_t order[] = {0, 1, 2, 3, 4, 5, 6, 7};
	check_cut(arrow, order, 4, 1);
	const double l_shape[] = {0, 0, 0, 2, 0, 0, 2, 1, 0, 1, 1, 0, 1, 2, 0, 0, 2, 0};
	check_cut(l_shape, order, 6, 3);
	/* Stars with deep teeth, and combs whose teeth block each other's ears: by the best ears and by the first ones. */
	for (int teeth = 20; teeth <= 2000; teeth *= 10) {
		double *star = mem_array(6 * (size_t)teeth, sizeof *star), *comb = mem_array(12 * (size_t)teeth, sizeof *comb);
		idx_t *corner = mem_array(4 * (size_t)teeth, sizeof *corner);
		for (int i = 0; i < 4 * teeth; i++)
			corner[i] = i;
		for (int i = 0; i < 2 * teeth; i++) {
			const double turn = PI * i / teeth, radius = i % 2 == 0 ? 3 : 1;
			star[3 * i] = radius * cos(turn), star[3 * i + 1] = radius * sin(turn), star[3 * i + 2] = 0;
		}
		check_cut(star, corner, 2 * (size_t)teeth, 2 * teeth * 3 * sin(PI / teeth) / 2);
		for (int i = 0; i < 2 * teeth; i++) { /* the spine from left to right, then the teeth back */
			comb[3 * i] = i, comb[3 * i + 1] = 0, comb[3 * i + 2] = 0;
			const int back = 2 * teeth + i;
			comb[3 * back] = 2 * teeth - 1 - i, comb[3 * back + 1] = i % 2 == 0 ? 20 : 0.5, comb[3 * back + 2] = 0;
		}
		for (int i = 0; i < 2 * teeth; i++) /* the spine bends a little */
			comb[3 * i + 1] = -1e-3 * i * (2 * teeth - 1 - i) / teeth / teeth;
		double area = (2 * teeth - 1) * (20 + 0.5) / 2;
		for (int i = 0; i + 1 < 2 * teeth; i++)
			area -= (comb[3 * i + 1] + comb[3 * i + 4]) / 2;
		check_cut(comb, corner, 4 * (size_t)teeth, area);
		free(star);
		free(comb);
		free(corner);
	}
}

static void polygons_that_cross_themselves_end(void **state)
{
	(void)state;
	/* Random corners: no answer is right, but there are count - 2 triangles of its corners, soon. */
	enum { COUNT = 5000 };
	double *xyz = mem_array(3 * COUNT, sizeof *xyz);
	idx_t *corner = mem_array(COUNT, sizeof *corner), *triangle = mem_array(3 * COUNT, sizeof *triangle);
	uint32_t seed = 7;
	for (int i = 0; i < 3 * COUNT; i++) {
		seed = seed * 1664525 + 1013904223;
		xyz[i] = seed / 4294967296.0;
		corner[i / 3] = i / 3;
	}
	for (int count = 100; count <= COUNT; count *= 50) {
		for (int i = 0; i < 3 * COUNT; i++)
			triangle[i] = NO_INDEX;
		triangulate_polygon(triangle, xyz, corner, (size_t)count);
		for (int i = 0; i < 3 * (count - 2); i++)
			assert_true(triangle[i] >= 0 && triangle[i] < count);
		assert_int_equal(triangle[3 * (count - 2)], NO_INDEX);
	}
	free(xyz);
	free(corner);
	free(triangle);
}

static void creases_of_cubes(void **state)
{
	(void)state;
	/* Twelve edges of a cube, not the diagonals of its faces. The edges of a cube 0.1 higher: the four at the bottom are the same, the
	 * upright ones agree but for the last tenth, the four at the top are 0.1 away. */
	double a[24], b[24];
	make_cube(a, 0, 1);
	make_cube(b, 0, 1);
	for (int v = 4; v < 8; v++)
		b[3 * v + 2] = 1.1;
	struct creases of_a, of_b;
	creases_find(&of_a, a, cube_triangle, 12, 40);
	creases_find(&of_b, b, cube_triangle, 12, 40);
	assert_int_equal(of_a.count, 12);
	assert_near(of_a.length, 12, 1e-14);
	assert_near(of_b.length, 12.4, 1e-14);
	struct crease_distance distance;
	creases_distance(&distance, a, &of_a, b, 8, &of_b, 12000);
	/* From the lower one: along its top edges, 0.1 up except where an upright edge of the other is nearer, within 0.1 of the corners,
	 * where it is the distance along the edge: 4 * (0.8 * 0.1 + 2 * 0.1^2 / 2) over 12. */
	assert_near(distance.mean, 4 * (0.08 + 0.01) / 12, 1e-5);
	assert_near(distance.max, 0.1, 1e-12);
	/* More than a hundredth of the length is 0.1 away, and the worst place is on the top edges. */
	assert_near(distance.p99, 0.1, 1e-12);
	assert_near(distance.worst[2], 1, 1e-12);
	creases_distance(&distance, b, &of_b, a, 8, &of_a, 12400);
	/* From the higher one: 0.1 along its top edges, and on average 0.05 along the last tenths of its upright ones. */
	assert_near(distance.mean, (4 * 0.1 + 4 * 0.1 * 0.05) / 12.4, 1e-5);
	assert_near(distance.max, 0.1, 1e-12);
	creases_free(&of_a);
	creases_free(&of_b);
	/* With a limit above 90 degrees a cube has none; a plate has its border. */
	creases_find(&of_a, a, cube_triangle, 12, 91);
	assert_int_equal(of_a.count, 0);
	creases_free(&of_a);
	double plate[12];
	make_plate(plate, 0, 0);
	creases_find(&of_a, plate, plate_triangle, 2, 40);
	assert_int_equal(of_a.count, 4);
	creases_free(&of_a);
}

static void trimesh_counts(void **state)
{
	(void)state;
	/* An open cube of five quads: 4 open edges, 10 triangles, area 5; a soup of triangles is welded. */
	static const idx_t quad[20] = {0, 2, 3, 1, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
	struct mesh mesh = {.vertex_count = 8, .face_count = 5};
	mesh.xyz = mem_array(24, sizeof *mesh.xyz);
	make_cube(mesh.xyz, 0, 1);
	mesh.corner = mem_copy(quad, 20, sizeof *quad);
	mesh.face_start = mem_array(6, sizeof *mesh.face_start);
	for (size_t f = 0; f <= 5; f++)
		mesh.face_start[f] = 4 * f;
	struct trimesh trimesh;
	struct fault fault = {0};
	assert_true(trimesh_from_mesh(&trimesh, &mesh, "open.off", &fault));
	assert_int_equal(trimesh.triangle_count, 10);
	assert_int_equal(trimesh.used_count, 8);
	assert_int_equal(trimesh.open_count, 4);
	assert_int_equal(trimesh.nonmanifold_count, 0);
	assert_near(trimesh.area, 5, 1e-15);
	trimesh_free(&trimesh);

	mesh = (struct mesh){.vertex_count = 36, .face_count = 12};
	double cube[24];
	make_cube(cube, 0, 2);
	mesh.xyz = mem_array(3 * 36, sizeof *mesh.xyz);
	mesh.corner = mem_array(36, sizeof *mesh.corner);
	mesh.face_start = mem_array(13, sizeof *mesh.face_start);
	for (size_t i = 0; i < 36; i++) {
		mesh.corner[i] = (idx_t)i;
		mesh.face_start[i / 3 + 1] = i + 1;
		copy3(mesh.xyz + 3 * i, cube + 3 * cube_triangle[i]);
	}
	assert_true(trimesh_from_mesh(&trimesh, &mesh, "cube.stl", &fault));
	assert_int_equal(trimesh.used_count, 8);
	assert_int_equal(trimesh.open_count, 0);
	assert_near(trimesh.volume, 8, 1e-14);
	trimesh_free(&trimesh);

	mesh = (struct mesh){.face_start = mem_array(1, sizeof(size_t))};
	assert_false(trimesh_from_mesh(&trimesh, &mesh, "empty.off", &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_string_equal(fault.text, "empty.off: no faces");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(parallel_plates),
		cmocka_unit_test(turned_part_of_a_plate),
		cmocka_unit_test(edge_beside_an_edge),
		cmocka_unit_test(cube_in_cube),
		cmocka_unit_test(maximum_between_the_samples),
		cmocka_unit_test(far_away_and_scaled),
		cmocka_unit_test(same_with_any_number_of_threads),
		cmocka_unit_test(no_area),
		cmocka_unit_test(samples_follow_area),
		cmocka_unit_test(polygons_keep_their_area),
		cmocka_unit_test(polygons_that_cross_themselves_end),
		cmocka_unit_test(creases_of_cubes),
		cmocka_unit_test(trimesh_counts),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
