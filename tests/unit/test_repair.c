/* Repairs on small meshes whose right answer is known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#include "stages/geometry/half.h"
#include "stages/geometry/repair.h"
#include "stages/geometry/repair_internal.h"

static const struct repair_options usual = {1e-6};

/* --- building ---------------------------------------------------------------------------------------------------- */

static struct mesh new_mesh(void)
{
	return (struct mesh){mem_array(1, sizeof(double)), 0, mem_array(1, sizeof(idx_t)), mem_array(1, sizeof(size_t)), 0};
}

static idx_t add_vertex(struct mesh *mesh, double x, double y, double z)
{
	mesh->xyz = mem_resize(mesh->xyz, 3 * (mesh->vertex_count + 1), sizeof *mesh->xyz);
	double *p = mesh->xyz + 3 * mesh->vertex_count;
	p[0] = x, p[1] = y, p[2] = z;
	return (idx_t)mesh->vertex_count++;
}

static void add_face(struct mesh *mesh, const idx_t *corner, size_t count)
{
	const size_t used = mesh->face_start[mesh->face_count];
	mesh->corner = mem_resize(mesh->corner, used + count, sizeof *mesh->corner);
	memcpy(mesh->corner + used, corner, count * sizeof *corner);
	mesh->face_start = mem_resize(mesh->face_start, mesh->face_count + 2, sizeof *mesh->face_start);
	mesh->face_start[++mesh->face_count] = used + count;
}

static void add_triangle(struct mesh *mesh, idx_t a, idx_t b, idx_t c)
{
	add_face(mesh, (const idx_t[]){a, b, c}, 3);
}

/* The box between two corners as 12 triangles, outward (or inward). */
static void add_box(struct mesh *mesh, const double low[3], const double high[3], bool inward)
{
	static const idx_t quad[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
	const idx_t base = (idx_t)mesh->vertex_count;
	for (int i = 0; i < 8; i++)
		add_vertex(mesh, (i & 1 ? high : low)[0], (i & 2 ? high : low)[1], (i & 4 ? high : low)[2]);
	for (int q = 0; q < 6; q++)
		for (int t = 0; t < 2; t++) {
			const idx_t a = base + quad[q][0], b = base + quad[q][t + 1], c = base + quad[q][t + 2];
			add_triangle(mesh, a, inward ? c : b, inward ? b : c);
		}
}

static void add_cube(struct mesh *mesh, double x, double y, double z, double side)
{
	add_box(mesh, (const double[]){x, y, z}, (const double[]){x + side, y + side, z + side}, false);
}

/* As an STL file would have it: every triangle with vertices of its own. */
static void unweld(struct mesh *mesh)
{
	const size_t count = mesh->face_start[mesh->face_count];
	double *xyz = mem_array(3 * count, sizeof *xyz);
	for (size_t h = 0; h < count; h++) {
		memcpy(xyz + 3 * h, mesh->xyz + 3 * (size_t)mesh->corner[h], 3 * sizeof *xyz);
		mesh->corner[h] = (idx_t)h;
	}
	free(mesh->xyz);
	mesh->xyz = xyz;
	mesh->vertex_count = count;
}

/* --- checking ---------------------------------------------------------------------------------------------------- */

/* Repair, and see that the result is what was promised whatever went in. */
static struct repair_report repaired(struct mesh *mesh)
{
	struct repair_report report;
	struct fault fault = {0};
	if (!repair_mesh(mesh, &usual, &report, &fault))
		fail_msg("%s", fault.text);
	struct half half;
	if (!half_build_triangles(&half, mesh->corner, mesh->face_count, mesh->vertex_count, &fault))
		fail_msg("%s", fault.text);
	for (size_t v = 0; v < mesh->vertex_count; v++)
		assert_true(half.outgoing[v] != NO_INDEX);
	for (size_t i = 0; i < report.cut_count; i++) { /* every opened edge is a border */
		bool found = false;
		for (size_t h = 0; h < half.half_count; h++)
			found |= half.twin[h] == NO_INDEX && half.origin[h] == report.cut[2 * i] &&
				 half.origin[half.next[h]] == report.cut[2 * i + 1];
		assert_true(found);
	}
	half_free(&half);
	return report;
}

static void expect_component(const struct repair_component *c, size_t vertices, size_t edges, size_t faces, size_t borders,
			     long genus)
{
	assert_int_equal(c->vertices, vertices);
	assert_int_equal(c->edges, edges);
	assert_int_equal(c->faces, faces);
	assert_int_equal(c->border_loops, borders);
	assert_int_equal(c->euler, (long)vertices - (long)edges + (long)faces);
	assert_int_equal(c->genus, genus);
}

/* Nothing but the kinds given (ended by REPAIR_KIND_COUNT) was counted. */
static void expect_only(const struct repair_report *report, const enum repair_kind *kind)
{
	for (int k = 0; k < REPAIR_KIND_COUNT; k++) {
		bool listed = false;
		for (const enum repair_kind *l = kind; *l != REPAIR_KIND_COUNT; l++)
			listed |= (int)*l == k;
		if (!listed && report->count[k])
			fail_msg("%zu %s", report->count[k], repair_plural[k]);
		if (listed && !report->count[k])
			fail_msg("no %s", repair_name[k]);
	}
}
#define EXPECT_ONLY(report, ...) expect_only(&(report), (const enum repair_kind[]){__VA_ARGS__, REPAIR_KIND_COUNT})

static void done(struct mesh *mesh, struct repair_report *report)
{
	mesh_free(mesh);
	repair_report_free(report);
}

static void assert_near(double got, double want, double tolerance)
{
	if (!(fabs(got - want) <= tolerance))
		fail_msg("%.17g is not %.17g", got, want);
}

/* --- the method's acceptance --------------------------------------------------------------------------------------- */

/* A cube as STL: V=8, E=18, F=12, chi=2, no border. */
static void stl_cube(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	unweld(&mesh);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_WELDED_EXACT);
	assert_int_equal(report.count[REPAIR_WELDED_EXACT], 36 - 8);
	assert_int_equal(report.component_count, 1);
	expect_component(report.component, 8, 18, 12, 0, 0);
	assert_near(report.component[0].volume, 1, 1e-15);
	done(&mesh, &report);
}

/* Four triangles meet at the edge that two cubes share; each cube keeps its own two, since the gaps are equal and those
 * inside of the material go first. */
static void two_cubes_share_an_edge(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	add_cube(&mesh, 1, 1, 0, 1);
	unweld(&mesh);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_WELDED_EXACT, REPAIR_NONMANIFOLD_EDGE_CUT);
	assert_int_equal(report.count[REPAIR_NONMANIFOLD_EDGE_CUT], 1);
	assert_int_equal(report.component_count, 2);
	for (int i = 0; i < 2; i++) {
		expect_component(&report.component[i], 8, 18, 12, 0, 0);
		assert_near(report.component[i].volume, 1, 1e-14);
	}
	assert_int_equal(report.cut_count, 0); /* nothing is open */
	done(&mesh, &report);
}

/* One copy of one corner is off by 1e-8: still 8 vertices. */
static void stl_cube_with_a_crack(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	unweld(&mesh);
	mesh.xyz[3 * 7 + 2] += 1e-8;
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_WELDED_EXACT, REPAIR_WELDED_NEAR);
	assert_int_equal(report.count[REPAIR_WELDED_NEAR], 1);
	expect_component(report.component, 8, 18, 12, 0, 0);
	done(&mesh, &report);
}

static uint32_t next_random(uint32_t *seed)
{
	return *seed = *seed * 1664525u + 1013904223u;
}

static void swap(idx_t *a, idx_t *b)
{
	const idx_t c = *a;
	*a = *b;
	*b = c;
}

static void random_flips(void **state)
{
	(void)state;
	uint32_t seed = 1;
	for (int trial = 0; trial < 20; trial++) {
		struct mesh mesh = new_mesh();
		add_cube(&mesh, -3, 5, 7, 2);
		for (size_t f = 0; f < mesh.face_count; f++)
			if (next_random(&seed) >> 31)
				swap(&mesh.corner[3 * f], &mesh.corner[3 * f + 1]);
		struct repair_report report = repaired(&mesh);
		assert_int_equal(report.component_count, 1);
		assert_near(report.component[0].volume, 8, 1e-12);
		done(&mesh, &report);
	}
}

/* --- each kind of repair --------------------------------------------------------------------------------------------- */

static void clean_mesh_stays(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	idx_t before[36];
	memcpy(before, mesh.corner, sizeof before);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_KIND_COUNT);
	assert_memory_equal(mesh.corner, before, sizeof before);
	done(&mesh, &report);
}

/* An L of six corners: a fan from its first corner would cover what lies outside of it. */
static void polygons(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	static const double l[6][2] = {{1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}, {1, 1}};
	for (int i = 0; i < 6; i++)
		add_vertex(&mesh, l[i][0], l[i][1], 0);
	add_face(&mesh, (const idx_t[]){0, 1, 2, 3, 4, 5}, 6);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_POLYGON_TRIANGULATED);
	expect_component(report.component, 6, 9, 4, 1, 0);
	double area = 0;
	for (size_t f = 0; f < mesh.face_count; f++) {
		const double *a = mesh.xyz + 3 * (size_t)mesh.corner[3 * f], *b = mesh.xyz + 3 * (size_t)mesh.corner[3 * f + 1],
			     *c = mesh.xyz + 3 * (size_t)mesh.corner[3 * f + 2];
		const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
		assert_true(twice > 0);
		area += twice / 2;
	}
	assert_near(area, 3, 1e-15);
	done(&mesh, &report);
}

static void collapsed_and_duplicate(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	add_triangle(&mesh, 0, 1, 1);
	add_triangle(&mesh, mesh.corner[1], mesh.corner[2], mesh.corner[0]);
	add_vertex(&mesh, 9, 9, 9);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_COLLAPSED_FACE, REPAIR_DUPLICATE_FACE, REPAIR_UNUSED_VERTEX);
	expect_component(report.component, 8, 18, 12, 0, 0);
	done(&mesh, &report);
}

/* Two triangles back to back, hanging on an edge of a cube, bound nothing: the cube is whole without them. */
static void fin(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	const idx_t tip = add_vertex(&mesh, -1, -1, 0.5);
	add_triangle(&mesh, 0, 4, tip);
	add_triangle(&mesh, 4, 0, tip);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_DUPLICATE_FACE);
	assert_int_equal(report.count[REPAIR_DUPLICATE_FACE], 2);
	expect_component(report.component, 8, 18, 12, 0, 0);
	done(&mesh, &report);
}

/* Bodies that touch along whole faces stay bodies: a row of three cubes, and a block of eight. */
static void bodies_that_touch(void **state)
{
	(void)state;
	for (int block = 0; block < 2; block++) {
		struct mesh mesh = new_mesh();
		const int count = block ? 8 : 3;
		for (int i = 0; i < count; i++)
			add_cube(&mesh, block ? i & 1 : i, block ? i >> 1 & 1 : 0, block ? i >> 2 : 0, 1);
		unweld(&mesh);
		struct repair_report report = repaired(&mesh);
		EXPECT_ONLY(report, REPAIR_WELDED_EXACT, REPAIR_NONMANIFOLD_EDGE_CUT);
		assert_int_equal(report.component_count, count);
		for (int i = 0; i < count; i++) {
			expect_component(&report.component[i], 8, 18, 12, 0, 0);
			assert_near(report.component[i].volume, 1, 1e-14);
		}
		done(&mesh, &report);
	}
}

/* Alone, a sheet of two sides stays as one sheet. */
static void sheet_of_two_sides(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	for (int i = 0; i < 4; i++)
		add_vertex(&mesh, i & 1, i >> 1, 0);
	add_triangle(&mesh, 0, 1, 3), add_triangle(&mesh, 0, 3, 2);
	add_triangle(&mesh, 0, 3, 1), add_triangle(&mesh, 0, 2, 3);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_DUPLICATE_FACE);
	expect_component(report.component, 4, 5, 2, 1, 0);
	done(&mesh, &report);
}

/* A vertex on the middle of a cube's edge, with a triangle of no area between it and the edge: flipping the edge gives
 * the neighbour two triangles in place of one, and nothing is torn: V=9, F=14. */
static void cap(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	const idx_t middle = add_vertex(&mesh, 0.5, 0, 0); /* on edge 0-1 */
	for (size_t f = 0; f < 12; f++) /* the first triangle that runs 1 -> 0 or 0 -> 1 is split at it, the other is not */
		for (size_t k = 0; k < 3; k++) {
			const idx_t a = mesh.corner[3 * f + k], b = mesh.corner[3 * f + (k + 1) % 3],
				    c = mesh.corner[3 * f + (k + 2) % 3];
			if (a == 1 && b == 0) {
				mesh.corner[3 * f + (k + 1) % 3] = middle;
				add_triangle(&mesh, middle, 0, c);
				add_triangle(&mesh, 1, 0, middle);
			}
		}
	assert_int_equal(mesh.face_count, 14);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_CAP_FLIPPED);
	assert_int_equal(report.count[REPAIR_CAP_FLIPPED], 1);
	expect_component(report.component, 9, 21, 14, 0, 0);
	assert_near(report.component[0].volume, 1, 1e-15);
	for (size_t f = 0; f < mesh.face_count; f++) {
		double n[3], length = 0;
		const double *a = mesh.xyz + 3 * (size_t)mesh.corner[3 * f], *b = mesh.xyz + 3 * (size_t)mesh.corner[3 * f + 1],
			     *c = mesh.xyz + 3 * (size_t)mesh.corner[3 * f + 2];
		for (int i = 0; i < 3; i++) {
			const int j = (i + 1) % 3, k = (i + 2) % 3;
			n[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
			length += n[i] * n[i];
		}
		assert_true(sqrt(length) > 0.1);
	}
	done(&mesh, &report);
}

/* A row of n vertices along one edge, joined to it by a staircase of caps: all are flipped away. */
static void row_of_caps(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	enum { COUNT = 40 };
	idx_t row[COUNT + 2];
	row[0] = add_vertex(&mesh, 0, 0, 0);
	for (int i = 1; i <= COUNT; i++)
		row[i] = add_vertex(&mesh, i, 0, 0);
	row[COUNT + 1] = add_vertex(&mesh, COUNT + 1, 0, 0);
	const idx_t up = add_vertex(&mesh, 20, 10, 0), down = add_vertex(&mesh, 20, -10, 0);
	for (int i = 0; i <= COUNT; i++)
		add_triangle(&mesh, row[i], row[i + 1], up);
	for (int i = 1; i <= COUNT; i++) /* a fan of caps from the first vertex */
		add_triangle(&mesh, row[0], row[i + 1], row[i]);
	add_triangle(&mesh, row[COUNT + 1], row[0], down);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_CAP_FLIPPED);
	expect_component(report.component, COUNT + 4, 0 + (3 * (2 * COUNT + 2) + 4) / 2, 2 * COUNT + 2, 1, 0);
	for (size_t f = 0; f < mesh.face_count; f++) {
		bool apex = false;
		for (size_t k = 0; k < 3; k++)
			apex |= mesh.corner[3 * f + k] == up || mesh.corner[3 * f + k] == down;
		assert_true(apex);
	}
	done(&mesh, &report);
}

/* A torus beside a triangle so large that most of the torus has no area by that measure, though its edges have a length: caps beside
 * caps. The list of those to look at again must not double from pass to pass. */
static void torus_of_caps(void **state)
{
	(void)state;
	enum { AROUND = 60, ACROSS = 10 };
	for (double far = 7e5; far < 2e6; far *= 1.1) {
		struct mesh mesh = new_mesh();
		for (int i = 0; i < AROUND; i++)
			for (int j = 0; j < ACROSS; j++) {
				const double shift = 0.4 * ((i * 37 + j * 101) % 64) / 64;
				const double a = 2 * M_PI * (i + shift) / AROUND, b = 2 * M_PI * (j + 0.4 - shift) / ACROSS;
				add_vertex(&mesh, (1 + 0.3 * cos(b)) * cos(a), (1 + 0.3 * cos(b)) * sin(a), 0.3 * sin(b));
			}
		for (int i = 0; i < AROUND; i++)
			for (int j = 0; j < ACROSS; j++) {
				const int k = (i + 1) % AROUND, l = (j + 1) % ACROSS;
				add_triangle(&mesh, ACROSS * i + j, ACROSS * k + j, ACROSS * k + l);
				add_triangle(&mesh, ACROSS * i + j, ACROSS * k + l, ACROSS * i + l);
			}
		const idx_t a = add_vertex(&mesh, far, 0, 0), b = add_vertex(&mesh, far, far, 0), c = add_vertex(&mesh, far, 0, far);
		add_triangle(&mesh, a, b, c);
		const clock_t start = clock();
		struct repair_report report = repaired(&mesh);
		assert_true((double)(clock() - start) / CLOCKS_PER_SEC < 2);
		repair_report_free(&report);
		mesh_free(&mesh);
	}
}

/* Two corners 1e-9 apart, inside: the two needles between them go. */
static void needle(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	const idx_t a = add_vertex(&mesh, 0, 0, 0), b = add_vertex(&mesh, 2, 0, 0), c = add_vertex(&mesh, 2, 2, 0),
		    d = add_vertex(&mesh, 0, 2, 0);
	const idx_t p = add_vertex(&mesh, 1, 1, 0), q = add_vertex(&mesh, 1 + 1e-9, 1, 0);
	add_triangle(&mesh, a, p, d), add_triangle(&mesh, b, c, q);
	add_triangle(&mesh, a, b, p), add_triangle(&mesh, b, q, p);
	add_triangle(&mesh, c, d, q), add_triangle(&mesh, d, p, q);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_ZERO_AREA_FACE);
	assert_int_equal(report.count[REPAIR_ZERO_AREA_FACE], 2);
	expect_component(report.component, 5, 8, 4, 1, 0);
	done(&mesh, &report);
}

/* Two squares side by side, the right one with a vertex in the middle of the common edge. */
static void t_junction(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	for (int i = 0; i < 6; i++)
		add_vertex(&mesh, i % 3, i / 3, 0); /* 0 1 2 below, 3 4 5 above */
	const idx_t middle = add_vertex(&mesh, 1, 0.5, 0);
	add_triangle(&mesh, 0, 1, 4), add_triangle(&mesh, 0, 4, 3);
	add_triangle(&mesh, 1, 2, middle), add_triangle(&mesh, 2, 5, middle), add_triangle(&mesh, 5, 4, middle);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_T_JUNCTION_SPLIT);
	assert_int_equal(report.count[REPAIR_T_JUNCTION_SPLIT], 1);
	/* One sheet with the six outer vertices on its border and one inside: F = 2 * 7 - 6 - 2. */
	assert_int_equal(report.component_count, 1);
	expect_component(report.component, 7, 12, 6, 1, 0);
	done(&mesh, &report);
}

/* One large triangle, with vertices of others on all of its three sides, two on each: no piece without area, no crack left. */
static void t_junctions_on_every_side(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	static const double corner[3][2] = {{0, 0}, {3, 0}, {0, 3}}, away[3][2] = {{0, -3}, {3, 3}, {-3, 0}};
	for (int i = 0; i < 3; i++)
		add_vertex(&mesh, corner[i][0], corner[i][1], 0);
	add_triangle(&mesh, 0, 1, 2);
	for (int side = 0; side < 3; side++) {
		const double *from = corner[side], *to = corner[(side + 1) % 3];
		const idx_t far = add_vertex(&mesh, away[side][0], away[side][1], 0);
		idx_t last = (idx_t)side;
		for (int i = 1; i <= 3; i++) {
			const idx_t v = i == 3 ? (idx_t)((side + 1) % 3)
					       : add_vertex(&mesh, from[0] + (to[0] - from[0]) * i / 3,
							    from[1] + (to[1] - from[1]) * i / 3, 0);
			add_triangle(&mesh, v, last, far);
			last = v;
		}
	}
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_T_JUNCTION_SPLIT);
	assert_int_equal(report.count[REPAIR_T_JUNCTION_SPLIT], 6);
	/* 3 corners, 3 far vertices, 6 on the sides; 9 triangles outside and 7 inside; 6 border edges. */
	assert_int_equal(report.component_count, 1);
	expect_component(report.component, 12, (3 * 16 + 6) / 2, 16, 1, 0);
	done(&mesh, &report);
}

/* Three half-planes at one edge: the two that are 60 degrees apart go on into each other, the third is cut off. */
static void three_sheets(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_vertex(&mesh, 0, 0, 0), add_vertex(&mesh, 0, 0, 1);
	static const double degrees[3] = {0, 60, 180};
	for (int i = 0; i < 3; i++) {
		const idx_t v = add_vertex(&mesh, cos(degrees[i] * acos(-1) / 180), sin(degrees[i] * acos(-1) / 180), 0.5);
		add_triangle(&mesh, 0, 1, v);
	}
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_NONMANIFOLD_EDGE_CUT, REPAIR_FACE_FLIPPED);
	assert_int_equal(report.component_count, 2);
	expect_component(&report.component[0], 4, 5, 2, 1, 0);
	expect_component(&report.component[1], 3, 3, 1, 1, 0);
	assert_int_equal(report.cut_count, 1);
	done(&mesh, &report);
}

/* Two tetrahedra that touch at a vertex. */
static void bow_tie(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	add_cube(&mesh, 1, 1, 1, 1);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_WELDED_EXACT, REPAIR_NONMANIFOLD_VERTEX_SPLIT);
	assert_int_equal(report.count[REPAIR_NONMANIFOLD_VERTEX_SPLIT], 1);
	assert_int_equal(report.component_count, 2);
	done(&mesh, &report);
}

/* Seven cubes in a row that bends round until the last touches the first along an edge. */
static void edge_that_meets_itself(void **state)
{
	(void)state;
	/* Cubes of one layer: a path from (0, 0) around to (1, 1), which touches the first one along an edge. */
	static const int cube[7][2] = {{0, 0}, {-1, 0}, {-1, 1}, {-1, 2}, {0, 2}, {1, 2}, {1, 1}};
	struct mesh mesh = new_mesh();
	for (int i = 0; i < 7; i++)
		for (int side = 0; side < 6; side++) {
			const int axis = side / 2, up = side % 2, u = (axis + 1) % 3, w = (axis + 2) % 3;
			bool inner = false;
			for (int j = 0; j < 7 && axis < 2; j++)
				inner |= cube[j][axis] == cube[i][axis] + (up ? 1 : -1) && cube[j][1 - axis] == cube[i][1 - axis];
			if (inner)
				continue;
			idx_t corner[4];
			for (int k = 0; k < 4; k++) {
				double p[3] = {cube[i][0], cube[i][1], 0};
				p[axis] += up;
				p[u] += k == 1 || k == 2;
				p[w] += k >= 2;
				corner[k] = add_vertex(&mesh, p[0], p[1], p[2]);
			}
			add_face(&mesh, up ? corner : (const idx_t[]){corner[3], corner[2], corner[1], corner[0]}, 4);
		}
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_POLYGON_TRIANGULATED, REPAIR_WELDED_EXACT, REPAIR_NONMANIFOLD_EDGE_CUT);
	assert_int_equal(report.count[REPAIR_NONMANIFOLD_EDGE_CUT], 1);
	assert_int_equal(report.component_count, 1);
	assert_int_equal(report.component[0].border_loops, 0);
	assert_near(report.component[0].volume, 7, 1e-12);
	done(&mesh, &report);
}

/* A band of n quads with half a turn cannot be oriented: one rung is cut, which leaves a band with one border. */
static void moebius(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	enum { COUNT = 24 };
	for (int i = 0; i < COUNT; i++) {
		const double along = 2 * acos(-1) * i / COUNT, turn = along / 2;
		for (int side = -1; side <= 1; side += 2)
			add_vertex(&mesh, (3 + side * cos(turn)) * cos(along), (3 + side * cos(turn)) * sin(along),
				   side * sin(turn));
	}
	for (int i = 0; i < COUNT; i++) {
		const idx_t a = 2 * i, b = a + 1, c = i + 1 < COUNT ? b + 2 : 0, d = i + 1 < COUNT ? a + 2 : 1;
		add_triangle(&mesh, a, b, c), add_triangle(&mesh, a, c, d);
	}
	struct repair_report report = repaired(&mesh);
	assert_true(report.count[REPAIR_MOEBIUS_CUT] >= 1);
	assert_int_equal(report.component_count, 1);
	assert_int_equal(report.component[0].faces, 2 * COUNT);
	assert_int_equal(report.component[0].border_loops, 1);
	assert_int_equal(report.component[0].genus, 0);
	assert_int_equal(report.component[0].euler, 1);
	assert_int_equal(report.cut_count, 2 * report.count[REPAIR_MOEBIUS_CUT]);
	done(&mesh, &report);
}

/* A box in a box in a box. Outward, inward, outward is how a hollow body with a loose core is written; turned over, it is
 * turned back; and with every face at random it comes out the same. */
static void nested_boxes(void **state)
{
	(void)state;
	uint32_t seed = 7;
	for (int how = 0; how < 3; how++) {
		struct mesh mesh = new_mesh();
		for (int i = 0; i < 3; i++) {
			const double low[] = {i, i, i}, high[] = {9 - i, 9 - i, 9 - i};
			add_box(&mesh, low, high, i == 1);
		}
		for (size_t f = 0; f < mesh.face_count && how > 0; f++)
			if (how == 1 ? f < 12 || f >= 24 : next_random(&seed) >> 31)
				swap(&mesh.corner[3 * f], &mesh.corner[3 * f + 1]);
		struct repair_report report = repaired(&mesh);
		assert_int_equal(report.component_count, 3);
		assert_near(report.component[0].volume, 729, 1e-9);
		assert_near(report.component[1].volume, -343, 1e-9);
		assert_near(report.component[2].volume, 125, 1e-9);
		done(&mesh, &report);
	}
}

/* A body that was written into another one, outward, stays so. */
static void body_in_a_body(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 3);
	add_cube(&mesh, 1, 1, 1, 1);
	struct repair_report report = repaired(&mesh);
	EXPECT_ONLY(report, REPAIR_KIND_COUNT);
	assert_near(report.component[1].volume, 1, 1e-12);
	done(&mesh, &report);
}

static void nothing_left(void **state)
{
	(void)state;
	static const double xyz[3][9] = {
		{0, 0, 0, 1, 0, 0, 2, 0, 0}, {1, 1, 1, 1, 1, 1, 1, 1, 1}, {0, 0, 0, 1, 0, 0, 1, 1e-12, 0}};
	for (int i = 0; i < 3; i++) {
		struct mesh mesh = new_mesh();
		for (int v = 0; v < 3; v++)
			add_vertex(&mesh, xyz[i][3 * v], xyz[i][3 * v + 1], xyz[i][3 * v + 2]);
		add_triangle(&mesh, 0, 1, 2);
		struct repair_report report;
		struct fault fault = {0};
		assert_false(repair_mesh(&mesh, &usual, &report, &fault));
		assert_int_equal(fault.code, EX_BAD_INPUT);
		done(&mesh, &report);
	}
}

/* Triangles at random on few vertices: every step meets every other. Whatever comes out is a manifold. */
static void random_soups(void **state)
{
	(void)state;
	uint32_t seed = 99;
	for (int trial = 0; trial < 400; trial++) {
		struct mesh mesh = new_mesh();
		const int side = 2 + trial % 3; /* a lattice, so that much is collinear and coplanar */
		for (int i = 0; i < side * side * side; i++)
			add_vertex(&mesh, i % side, i / side % side, i / side / side);
		const int faces = 5 + (int)(next_random(&seed) >> 16) % 120;
		for (int f = 0; f < faces; f++) {
			idx_t c[5];
			const size_t corners = 3 + (next_random(&seed) >> 24) % 3;
			for (size_t k = 0; k < corners; k++)
				c[k] = (idx_t)((next_random(&seed) >> 8) % mesh.vertex_count);
			add_face(&mesh, c, corners);
		}
		struct repair_report report;
		struct fault fault = {0};
		if (repair_mesh(&mesh, &usual, &report, &fault)) {
			struct half half;
			if (!half_build_triangles(&half, mesh.corner, mesh.face_count, mesh.vertex_count, &fault))
				fail_msg("trial %d: %s", trial, fault.text);
			half_free(&half);
		} else if (fault.code != EX_BAD_INPUT) {
			fail_msg("trial %d: %s", trial, fault.text);
		}
		done(&mesh, &report);
	}
}

/* Repairing what was repaired changes nothing more, also where vertices in one place were taken apart. */
static void repair_is_idempotent(void **state)
{
	(void)state;
	struct mesh mesh = new_mesh();
	add_cube(&mesh, 0, 0, 0, 1);
	add_cube(&mesh, 1, 0.25, 0.25, 0.5); /* touches the first cube's side */
	add_cube(&mesh, 0, 0, 5, 1);
	add_cube(&mesh, 1, 1, 5, 1); /* shares an edge with the one before */
	add_cube(&mesh, 2, 2, 6, 1); /* shares a vertex with that */
	unweld(&mesh);
	for (size_t f = 0; f < mesh.face_count; f += 3)
		swap(&mesh.corner[3 * f], &mesh.corner[3 * f + 1]);
	struct repair_report report = repaired(&mesh), again;
	assert_int_equal(report.count[REPAIR_NONMANIFOLD_EDGE_CUT], 1);
	assert_int_equal(report.count[REPAIR_NONMANIFOLD_VERTEX_SPLIT], 1);
	struct mesh copy = {mem_copy(mesh.xyz, 3 * mesh.vertex_count, sizeof *mesh.xyz), mesh.vertex_count,
			    mem_copy(mesh.corner, 3 * mesh.face_count, sizeof *mesh.corner),
			    mem_copy(mesh.face_start, mesh.face_count + 1, sizeof *mesh.face_start), mesh.face_count};
	again = repaired(&copy);
	EXPECT_ONLY(again, REPAIR_KIND_COUNT);
	assert_int_equal(copy.face_count, mesh.face_count);
	assert_int_equal(copy.vertex_count, mesh.vertex_count);
	assert_memory_equal(copy.corner, mesh.corner, 3 * mesh.face_count * sizeof *mesh.corner);
	assert_memory_equal(copy.xyz, mesh.xyz, 3 * mesh.vertex_count * sizeof *mesh.xyz);
	done(&mesh, &report);
	done(&copy, &again);
}

/* What is wrong with a mesh does not depend on its size, its place, or the order of its faces. */
static void size_and_order_do_not_matter(void **state)
{
	(void)state;
	struct repair_report reference = {0};
	for (int trial = 0; trial < 8; trial++) {
		struct mesh mesh = new_mesh();
		uint32_t seed = (uint32_t)trial;
		add_cube(&mesh, 0, 0, 0, 4);
		add_cube(&mesh, 4, 4, 0, 1); /* shares a corner's edge with the first */
		add_cube(&mesh, 1, 1, 1, 1); /* inside of it */
		add_cube(&mesh, 8, 8, 8, 1);
		mesh.corner[3 * 40] = mesh.corner[3 * 40 + 1]; /* a hole in the last one */
		swap(&mesh.corner[3 * 5], &mesh.corner[3 * 5 + 1]);
		const idx_t middle = add_vertex(&mesh, 2, 0, 0);
		add_triangle(&mesh, 0, middle, add_vertex(&mesh, 1, -3, -3));
		for (size_t f = mesh.face_count; f-- > 1 && trial > 0;) { /* shuffle */
			const size_t g = (next_random(&seed) >> 8) % (f + 1);
			for (size_t k = 0; k < 3; k++)
				swap(&mesh.corner[3 * f + k], &mesh.corner[3 * g + k]);
		}
		const double scale = trial % 4 == 1 ? 0x1p-60 : trial % 4 == 2 ? 0x1p60 : 1, shift = trial % 4 == 3 ? 1024 : 0;
		for (size_t i = 0; i < 3 * mesh.vertex_count; i++)
			mesh.xyz[i] = mesh.xyz[i] * scale + shift;
		struct repair_report report = repaired(&mesh);
		double volume = 0, wanted = 0;
		long genus = 0, euler = 0, wanted_euler = 0;
		for (size_t i = 0; i < report.component_count; i++) {
			volume += report.component[i].border_loops ? 0 : report.component[i].volume;
			genus += report.component[i].genus;
			euler += report.component[i].euler;
		}
		if (trial == 0)
			reference = report;
		for (size_t i = 0; i < reference.component_count; i++) {
			wanted += reference.component[i].border_loops ? 0 : reference.component[i].volume;
			wanted_euler += reference.component[i].euler;
		}
		assert_memory_equal(report.count, reference.count, sizeof report.count);
		assert_int_equal(report.component_count, 5);
		assert_int_equal(report.component_count, reference.component_count);
		assert_int_equal(genus, 0);
		assert_int_equal(euler, wanted_euler);
		assert_near(volume, wanted * scale * scale * scale, 1e-9 * scale * scale * scale);
		mesh_free(&mesh);
		if (trial > 0)
			repair_report_free(&report);
	}
	repair_report_free(&reference);
}

/* 100 000 triangles in about a second, and no square of anything: a bumpy grid as STL, every face at random. */
static void large_mesh_is_fast(void **state)
{
	(void)state;
	enum { SIDE = 224 };
	struct mesh mesh = new_mesh();
	free(mesh.xyz), free(mesh.corner), free(mesh.face_start);
	mesh.vertex_count = 6 * SIDE * SIDE;
	mesh.face_count = 2 * SIDE * SIDE;
	mesh.xyz = mem_array(3 * mesh.vertex_count, sizeof *mesh.xyz);
	mesh.corner = mem_array(mesh.vertex_count, sizeof *mesh.corner);
	mesh.face_start = mem_array(mesh.face_count + 1, sizeof *mesh.face_start);
	uint32_t seed = 3;
	double *p = mesh.xyz;
	for (int j = 0; j < SIDE; j++)
		for (int i = 0; i < SIDE; i++) {
			static const int corner[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
			for (int k = 0; k < 6; k++) {
				const int x = i + corner[k][0], y = j + corner[k][1];
				*p++ = x, *p++ = y, *p++ = sin(x * 0.1) * cos(y * 0.13);
			}
		}
	for (size_t h = 0; h < mesh.vertex_count; h++)
		mesh.corner[h] = (idx_t)h;
	for (size_t f = 0; f <= mesh.face_count; f++)
		mesh.face_start[f] = 3 * f;
	for (size_t f = 0; f < mesh.face_count; f++)
		if (next_random(&seed) >> 31)
			swap(&mesh.corner[3 * f], &mesh.corner[3 * f + 1]);
	const clock_t begin = clock();
	struct repair_report report;
	struct fault fault = {0};
	assert_true(repair_mesh(&mesh, &usual, &report, &fault));
	assert_true((double)(clock() - begin) / CLOCKS_PER_SEC <
		    10); /* 0.3 s alone on a slow machine; sanitizers take their time */
	expect_component(report.component, (SIDE + 1) * (SIDE + 1), 3 * SIDE * SIDE + 2 * SIDE, 2 * SIDE * SIDE, 1, 0);
	done(&mesh, &report);
}

/* Against all boxes, on random segments. */
struct seen {
	unsigned char item[500];
};

static void see(void *user, size_t item)
{
	((struct seen *)user)->item[item] = 1;
}

static void box_tree_misses_nothing(void **state)
{
	(void)state;
	enum { COUNT = 500 };
	static double box[6 * COUNT];
	uint32_t seed = 5;
	for (size_t k = 0; k < COUNT; k++)
		for (size_t i = 0; i < 3; i++) {
			box[6 * k + i] = (double)(next_random(&seed) >> 8) / (1 << 24);
			box[6 * k + 3 + i] = box[6 * k + i] + 0.05 * (double)(next_random(&seed) >> 8) / (1 << 24);
		}
	struct box_tree tree = box_tree_new(box, COUNT);
	size_t visited = 0;
	for (int trial = 0; trial < 200; trial++) {
		double from[3], to[3];
		for (int i = 0; i < 3; i++) {
			from[i] = (double)(next_random(&seed) >> 8) / (1 << 24);
			to[i] = trial % 2 ? from[i] : (double)(next_random(&seed) >> 8) / (1 << 24);
		}
		struct seen seen = {{0}};
		box_tree_segment(&tree, from, to, 0.01, see, &seen);
		for (size_t k = 0; k < COUNT; k++) {
			visited += seen.item[k];
			for (int s = 0; s <= 100 && !seen.item[k];
			     s++) { /* points along the segment are outside of what was left out */
				bool inside = true;
				for (size_t i = 0; i < 3; i++) {
					const double x = from[i] + (to[i] - from[i]) * s / 100;
					inside = inside && x >= box[6 * k + i] - 0.01 && x <= box[6 * k + 3 + i] + 0.01;
				}
				assert_false(inside);
			}
		}
	}
	assert_true(visited < 200 * COUNT / 4); /* and it does leave most out */
	box_tree_free(&tree);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(stl_cube),
		cmocka_unit_test(two_cubes_share_an_edge),
		cmocka_unit_test(stl_cube_with_a_crack),
		cmocka_unit_test(random_flips),
		cmocka_unit_test(clean_mesh_stays),
		cmocka_unit_test(polygons),
		cmocka_unit_test(collapsed_and_duplicate),
		cmocka_unit_test(fin),
		cmocka_unit_test(bodies_that_touch),
		cmocka_unit_test(sheet_of_two_sides),
		cmocka_unit_test(cap),
		cmocka_unit_test(row_of_caps),
		cmocka_unit_test(torus_of_caps),
		cmocka_unit_test(needle),
		cmocka_unit_test(t_junction),
		cmocka_unit_test(t_junctions_on_every_side),
		cmocka_unit_test(three_sheets),
		cmocka_unit_test(bow_tie),
		cmocka_unit_test(edge_that_meets_itself),
		cmocka_unit_test(moebius),
		cmocka_unit_test(nested_boxes),
		cmocka_unit_test(body_in_a_body),
		cmocka_unit_test(nothing_left),
		cmocka_unit_test(random_soups),
		cmocka_unit_test(repair_is_idempotent),
		cmocka_unit_test(size_and_order_do_not_matter),
		cmocka_unit_test(large_mesh_is_fast),
		cmocka_unit_test(box_tree_misses_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
