/* Curvature tensors on shapes whose curvatures are known (the patch method's section 1.6). */
#include "tests/unit/known_shapes.h"

#include <string.h>

#include "formats/dense.h"
#include "stages/curv/ballclip.h"
#include "stages/curv/curvature.h"
#include "stages/geometry/repair.h"
#include "stages/geometry/wedge.h"

/* Everything around normalcycle_tensors for one mesh, with the mesh's own lengths. */
struct setup {
	struct mesh mesh;
	struct half half;
	double *normal, *bend;
	unsigned char *kind;
	idx_t *triangle_wedge, *wedge_vertex;
	size_t count;
	struct normalcycle_result result;
};

static struct setup run(struct mesh mesh, double radius, bool no_rotation, bool one_ring)
{
	struct setup s = {.mesh = mesh};
	struct fault fault = {0};
	assert_true(half_build_triangles(&s.half, mesh.corner, mesh.face_count, mesh.vertex_count, &fault));
	s.normal = mem_array(mesh.face_count, 3 * sizeof(double));
	s.bend = mem_array(s.half.half_count, sizeof(double));
	s.kind = mem_array(s.half.half_count, 1);
	wedge_triangle_normals(s.normal, mesh.xyz, &s.half, 1e-5);
	wedge_bends(s.bend, mesh.xyz, s.normal, &s.half);
	const struct sharp_options sharp = {40 / DEGREES, false};
	sharp_edges(s.kind, NULL, mesh.xyz, s.bend, &s.half, &sharp);
	s.triangle_wedge = mem_array(s.half.half_count, sizeof(idx_t));
	s.count = wedge_number(s.triangle_wedge, &s.wedge_vertex, &s.half, s.kind);
	double **const array[] = {&s.result.kmin, &s.result.kmax, &s.result.anisotropy, &s.result.radius};
	for (size_t i = 0; i < 4; i++)
		*array[i] = mem_array(s.count, sizeof(double));
	s.result.normal = mem_array(s.count, 3 * sizeof(double));
	s.result.dmin = mem_array(s.count, 3 * sizeof(double));
	s.result.quality = mem_array(s.count, 1);
	const struct normalcycle_mesh input = {mesh.xyz, s.normal, s.bend, s.kind, &s.half, s.triangle_wedge, s.wedge_vertex, s.count};
	const struct normalcycle_options options = {radius, 0.003, 0.06, no_rotation, one_ring};
	normalcycle_tensors(&s.result, &input, &options);
	return s;
}

static void drop(struct setup *s)
{
	shape_free(&s->mesh);
	half_free(&s->half);
	free(s->normal);
	free(s->bend);
	free(s->kind);
	free(s->triangle_wedge);
	free(s->wedge_vertex);
	free(s->result.normal);
	free(s->result.kmin);
	free(s->result.kmax);
	free(s->result.dmin);
	free(s->result.anisotropy);
	free(s->result.radius);
	free(s->result.quality);
}

static double mean_edge(const struct mesh *mesh)
{
	double total = 0;
	for (size_t h = 0; h < 3 * mesh->face_count; h++)
		total += distance3(mesh->xyz + 3 * mesh->corner[h], mesh->xyz + 3 * mesh->corner[h % 3 == 2 ? h - 2 : h + 1]);
	return total / (double)(3 * mesh->face_count);
}

/* Largest and mean |k * r - 1| over both curvatures of all wedges. */
static void sphere_errors(double *worst, double *mean, const struct setup *s, double r)
{
	*worst = *mean = 0;
	for (size_t w = 0; w < s->count; w++) {
		const double a = fabs(s->result.kmin[w] * r - 1), b = fabs(s->result.kmax[w] * r - 1);
		*worst = fmax(*worst, fmax(a, b));
		*mean += (a + b) / (2 * (double)s->count);
	}
}

/* A sphere of radius r bends by 1/r in every direction, and convex is positive. */
static void sphere_bends_by_its_radius(void **state)
{
	(void)state;
	const double r = 0.5;
	double worst, mean;
	struct mesh ball = shape_icosphere(r, 3);
	assert_int_equal(ball.vertex_count, 642);
	const double edge = mean_edge(&ball);
	struct setup s = run(ball, 3 * edge, false, false);
	sphere_errors(&worst, &mean, &s, r);
	print_message("# icosphere, 3 edges, rotation: worst %.4f, mean %.4f\n", worst, mean);
	assert_int_equal(s.count, 642);
	assert_true(worst <= 0.03 * 1.5);
	assert_true(mean <= 0.017 * 1.5);
	drop(&s);

	s = run(shape_icosphere(r, 3), 2 * edge, true, false);
	sphere_errors(&worst, &mean, &s, r);
	print_message("# icosphere, 2 edges, no rotation: worst %.4f, mean %.4f\n", worst, mean);
	assert_true(worst <= 0.035 * 1.5);
	drop(&s);

	s = run(shape_icosphere(r, 3), 0, false, true);
	sphere_errors(&worst, &mean, &s, r);
	print_message("# icosphere, one ring: worst %.4f, mean %.4f\n", worst, mean);
	assert_true(worst <= 0.04 * 1.5);
	assert_true(mean <= 0.01 * 1.5);
	drop(&s);
}

/* Without the correction a ball of three edges on a coarse sphere loses a sixth of the curvature; with it hardly any. */
static void rotation_correction_saves_large_balls(void **state)
{
	(void)state;
	double worst, with, without;
	struct mesh ball = shape_icosphere(0.5, 2);
	const double radius = 4 * mean_edge(&ball);
	struct setup s = run(ball, radius, false, false);
	sphere_errors(&worst, &with, &s, 0.5);
	drop(&s);
	s = run(shape_icosphere(0.5, 2), radius, true, false);
	sphere_errors(&worst, &without, &s, 0.5);
	drop(&s);
	print_message("# four edges: mean %.4f with, %.4f without\n", with, without);
	assert_true(with <= 0.011 * 1.5);
	assert_true(without > 0.2);
}

/* A sphere turned inside out is a hollow: both curvatures change their sign. */
static void hollow_is_negative(void **state)
{
	(void)state;
	struct mesh ball = shape_icosphere(0.5, 2);
	const double edge = mean_edge(&ball);
	for (size_t f = 0; f < ball.face_count; f++) {
		const idx_t swap = ball.corner[3 * f];
		ball.corner[3 * f] = ball.corner[3 * f + 1];
		ball.corner[3 * f + 1] = swap;
	}
	struct setup s = run(ball, 3 * edge, false, false);
	for (size_t w = 0; w < s.count; w++) {
		assert_near(s.result.kmax[w], -2, 0.08);
		assert_near(s.result.kmin[w], -2, 0.08);
	}
	drop(&s);
}

/* 24 facets and nothing inside: around the axis 1/r, along it exactly nothing, and dmin is the axis. Caps are flat. */
static void bare_cylinder(void **state)
{
	(void)state;
	const double r = 0.3;
	const int n = 24;
	for (int automatic = 0; automatic < 2; automatic++) {
		const double width = 2 * r * sin(PI / n);
		struct setup s = run(shape_cylinder(r, 1, n, 1), automatic ? 0 : 3 * width, false, false);
		size_t sides = 0, caps = 0;
		double worst = 0;
		assert_int_equal(s.count, 4 * n + 2);
		for (size_t w = 0; w < s.count; w++) {
			const double *p = s.mesh.xyz + 3 * s.wedge_vertex[w], *d = s.result.dmin + 3 * w;
			if (fabs(s.result.normal[3 * w + 2]) > 0.9) {
				caps++;
				assert_true(s.result.kmin[w] == 0 && s.result.kmax[w] == 0);
				assert_int_equal(s.result.quality[w], WEDGE_FLAT);
				continue;
			}
			sides++;
			worst = fmax(worst, fabs(s.result.kmax[w] * r - 1));
			assert_near(s.result.kmin[w], 0, 1e-9);
			assert_true(atan2(hypot(d[0], d[1]), fabs(d[2])) * DEGREES < 0.1);
			assert_int_equal(s.result.quality[w], WEDGE_GOOD);
			/* the normal points away from the axis */
			assert_near(s.result.normal[3 * w] * p[0] + s.result.normal[3 * w + 1] * p[1], r, 1e-9);
		}
		print_message("# bare cylinder, %s radius: worst %.4f\n", automatic ? "automatic" : "fixed", worst);
		assert_int_equal(sides, 2 * n);
		assert_int_equal(caps, 2 * n + 2);
		assert_true(worst <= (automatic ? 0.1 : 0.01));
		drop(&s);
	}
}

/* A torus of radii 3 and 1: around the tube 1, along the big circle cos v / (3 + cos v), dmin along the big circle. */
static void torus_has_both_signs(void **state)
{
	(void)state;
	struct mesh torus = shape_torus(3, 1, 72, 32);
	double *length = mem_array(3 * torus.face_count, sizeof *length);
	for (size_t h = 0; h < 3 * torus.face_count; h++)
		length[h] = distance3(torus.xyz + 3 * torus.corner[h], torus.xyz + 3 * torus.corner[h % 3 == 2 ? h - 2 : h + 1]);
	for (size_t i = 1; i < 3 * torus.face_count; i++) /* insertion is enough for lengths in runs */
		for (size_t k = i; k > 0 && length[k] < length[k - 1]; k--) {
			const double swap = length[k];
			length[k] = length[k - 1], length[k - 1] = swap;
		}
	const double median = length[3 * torus.face_count / 2];
	free(length);
	struct setup s = run(torus, 3 * median, false, false);
	double worst_max = 0, worst_min = 0, mean_min = 0, worst_turn = 0;
	for (size_t w = 0; w < s.count; w++) {
		const double *p = s.mesh.xyz + 3 * s.wedge_vertex[w], *d = s.result.dmin + 3 * w;
		const double out = hypot(p[0], p[1]), wanted = (out - 3) / out;
		worst_max = fmax(worst_max, fabs(s.result.kmax[w] - 1));
		worst_min = fmax(worst_min, fabs(s.result.kmin[w] - wanted));
		mean_min += fabs(s.result.kmin[w] - wanted) / (double)s.count;
		worst_turn = fmax(worst_turn, acos(fmin(1, fabs(d[0] * -p[1] + d[1] * p[0]) / out)) * DEGREES);
	}
	print_message("# torus: kmax %.4f, kmin %.4f (mean %.4f), dmin %.3f degrees\n", worst_max, worst_min, mean_min, worst_turn);
	assert_true(worst_max <= 0.011 * 1.5);
	assert_true(worst_min <= 0.055 * 1.5);
	assert_true(mean_min <= 0.02 * 1.5);
	assert_true(worst_turn <= 1 * 1.5);
	drop(&s);
}

/* Nothing bends on a cube but its twelve edges, whichever way they are looked at. */
static void cube_is_flat(void **state)
{
	(void)state;
	struct mesh cube = shape_box(1, 1, 1);
	struct dense dense;
	struct fault fault = {0};
	const struct curvature_options options = {{40 / DEGREES, false}, 0};
	assert_true(curvature_compute(&dense, NULL, &cube, NULL, 0, &options, &fault));
	assert_int_equal(dense.edge_count, 12);
	assert_int_equal(dense.wedge_count, 24);
	for (size_t e = 0; e < dense.edge_count; e++) {
		assert_near(dense.edge[e].angle_deg, 90, 1e-12);
		assert_int_equal(dense.edge[e].kind, EDGE_SHARP);
	}
	for (size_t w = 0; w < dense.wedge_count; w++)
		assert_int_equal(dense.quality[w], WEDGE_FLAT);
	dense_free(&dense);
	shape_free(&cube);
}

/* A part seven times as large and turned has curvatures a seventh as large, and nothing else changes. */
static void motion_and_scale(void **state)
{
	(void)state;
	struct mesh torus = shape_torus(3, 1, 24, 12), turned = shape_torus(3, 1, 24, 12);
	struct fault fault = {0};
	/* a fixed share of the longest side, which the rotation changes: the radius must be given */
	const struct curvature_options one = {{40 / DEGREES, false}, 0.8}, seven = {{40 / DEGREES, false}, 5.6};
	struct dense a, b;
	shape_turn(&turned, 7);
	assert_true(curvature_compute(&a, NULL, &torus, NULL, 0, &one, &fault));
	assert_true(curvature_compute(&b, NULL, &turned, NULL, 0, &seven, &fault));
	assert_int_equal(a.wedge_count, b.wedge_count);
	for (size_t w = 0; w < a.wedge_count; w++) {
		assert_near(b.kmin[w] * 7, a.kmin[w], 1e-9);
		assert_near(b.kmax[w] * 7, a.kmax[w], 1e-9);
	}
	dense_free(&a);
	dense_free(&b);
	shape_free(&torus);
	shape_free(&turned);
}

/* Two parallel walls nearer than the ball: the ball stays on its own wall, so a plate's rounded rim does not see the other side. */
static void thin_wall_is_not_crossed(void **state)
{
	(void)state;
	/* a tube with walls 0.02 apart, sharp rims: outside 1/r, inside -1/r, though every ball of 0.2 holds both walls */
	struct mesh m = {0};
	const int n = 48;
	const double outer = 0.5, inner = 0.48;
	for (int ring = 0; ring < 4; ring++) {
		const double r = ring < 2 ? outer : inner;
		for (int i = 0; i < n; i++)
			shape_vertex(&m, r * cos(2 * PI * i / n), r * sin(2 * PI * i / n), ring == 1 || ring == 2 ? 1 : 0);
	}
	for (int ring = 0; ring < 4; ring++)
		for (int i = 0; i < n; i++) {
			const int j = (i + 1) % n, up = (ring + 1) % 4;
			shape_quad(&m, ring * n + i, ring * n + j, up * n + j, up * n + i);
		}
	struct setup s = run(m, 0.2, false, false);
	size_t inside = 0, outside = 0;
	for (size_t w = 0; w < s.count; w++) {
		const double *normal = s.result.normal + 3 * w, *p = s.mesh.xyz + 3 * s.wedge_vertex[w];
		const double out = normal[0] * p[0] + normal[1] * p[1];
		if (fabs(normal[2]) > 0.9)
			continue;
		const double r = out > 0 ? outer : -inner;
		assert_near(s.result.kmax[w] * r, 1, 0.04);
		out > 0 ? outside++ : inside++;
	}
	assert_int_equal(inside, 2 * n);
	assert_int_equal(outside, 2 * n);
	drop(&s);
}

/* Triangle and disc: whole triangle, whole disc, half a disc, a quarter, nothing, and the ball's height over the plane. */
static void clipping_is_exact(void **state)
{
	(void)state;
	const double o[3] = {0, 0, 0}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
	const double a[3] = {-10, -10, 0}, b[3] = {10, -10, 0}, c[3] = {0, 20, 0};
	const double left[3] = {-10, 0, 0}, right[3] = {10, 0, 0};
	assert_near(ball_triangle(o, 5, o, x, y), 0.5, 1e-14);
	assert_near(ball_triangle(o, 0.5, a, b, c), PI / 4, 1e-14);
	assert_near(ball_triangle(o, 0.5, left, right, c), PI / 8, 1e-14);
	assert_near(ball_triangle(o, 0.5, o, x, y), PI / 16, 1e-14);
	const double far[3] = {0, 0, 3}, near[3] = {0, 0, 0.3};
	assert_true(ball_triangle(far, 2, a, b, c) == 0);
	assert_near(ball_triangle(near, 0.5, a, b, c), PI * 0.16, 1e-14);
	/* no area, no answer */
	assert_true(ball_triangle(o, 1, o, x, x) == 0);
	assert_near(ball_segment(o, 0.5, left, right), 1, 1e-14);
	assert_near(ball_segment(o, 0.5, o, right), 0.5, 1e-14);
	assert_near(ball_segment(near, 0.5, left, right), 0.8, 1e-14);
	assert_true(ball_segment(far, 2, left, right) == 0);
	assert_true(ball_segment(o, 1, x, x) == 0);
}

/* A sheet of eight triangles: its rim is listed as border, and as cut where a repair opened it. */
static void open_sheet_has_borders(void **state)
{
	(void)state;
	struct mesh m = {0};
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			shape_vertex(&m, j, i, 0);
	for (int i = 0; i < 2; i++)
		for (int j = 0; j < 2; j++)
			shape_quad(&m, 3 * i + j, 3 * i + j + 1, 3 * i + j + 4, 3 * i + j + 3);
	struct dense dense;
	struct fault fault = {0};
	const idx_t cut[] = {1, 0};
	const struct curvature_options options = {{40 / DEGREES, false}, 0};
	assert_true(curvature_compute(&dense, NULL, &m, cut, 1, &options, &fault));
	assert_int_equal(dense.edge_count, 8);
	assert_int_equal(dense.wedge_count, 9);
	size_t cuts = 0;
	for (size_t e = 0; e < dense.edge_count; e++)
		cuts += dense.edge[e].kind == EDGE_CUT;
	assert_int_equal(cuts, 1);
	dense_free(&dense);
	shape_free(&m);
}

/* Every triangle of a cube with corners of its own, one of them off by 1e-8, every third turned over: after the repair
 * eight vertices, all normals outward, twelve sharp convex edges. Two cubes that share an edge come apart. */
static void soup_of_a_cube(void **state)
{
	(void)state;
	for (int cubes = 1; cubes <= 2; cubes++) {
		struct mesh soup = {0};
		for (int c = 0; c < cubes; c++) {
			struct mesh cube = shape_box(1, 1, 1);
			for (size_t f = 0; f < cube.face_count; f++) {
				idx_t corner[3];
				for (int k = 0; k < 3; k++) {
					const double *p = cube.xyz + 3 * cube.corner[3 * f + k];
					corner[k] = shape_vertex(&soup, p[0] + c, p[1] + c, p[2] + (f == 5 && k == 0 ? 1e-8 : 0));
				}
				/* two cubes at an edge are only told apart by which side is out */
				cubes == 2 || f % 3 ? shape_triangle(&soup, corner[0], corner[1], corner[2]) : shape_triangle(&soup, corner[0], corner[2], corner[1]);
			}
			shape_free(&cube);
		}
		struct repair_report report;
		struct fault fault = {0};
		const struct repair_options repair = {1e-6};
		assert_true(repair_mesh(&soup, &repair, &report, &fault));
		assert_int_equal(soup.vertex_count, 8 * cubes);
		assert_int_equal(report.component_count, cubes);
		for (int c = 0; c < cubes; c++) {
			assert_int_equal(report.component[c].edges, 18);
			assert_int_equal(report.component[c].euler, 2);
			assert_int_equal(report.component[c].genus, 0);
			assert_near(report.component[c].volume, 1, 1e-7);
		}
		struct dense dense;
		const struct curvature_options options = {{40 / DEGREES, false}, 0};
		assert_true(curvature_compute(&dense, NULL, &soup, report.cut, report.cut_count, &options, &fault));
		assert_int_equal(dense.edge_count, 12 * cubes);
		assert_int_equal(dense.wedge_count, 24 * cubes);
		for (size_t e = 0; e < dense.edge_count; e++)
			assert_near(dense.edge[e].angle_deg, 90, 1e-5);
		dense_free(&dense);
		repair_report_free(&report);
		shape_free(&soup);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sphere_bends_by_its_radius),
		cmocka_unit_test(rotation_correction_saves_large_balls),
		cmocka_unit_test(hollow_is_negative),
		cmocka_unit_test(bare_cylinder),
		cmocka_unit_test(torus_has_both_signs),
		cmocka_unit_test(cube_is_flat),
		cmocka_unit_test(motion_and_scale),
		cmocka_unit_test(thin_wall_is_not_crossed),
		cmocka_unit_test(clipping_is_exact),
		cmocka_unit_test(open_sheet_has_borders),
		cmocka_unit_test(soup_of_a_cube),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
