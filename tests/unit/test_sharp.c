/* Sharp edges, and the wedges and patches that they bound (the patch method's sections 0.5, 1.1, 5.0). */
#include "tests/unit/known_shapes.h"

#include <string.h>

#include "formats/dense.h"
#include "stages/curv/sharp.h"
#include "stages/geometry/wedge.h"

struct found {
	struct mesh mesh;
	struct half half;
	double *normal, *bend;
	unsigned char *kind;
	struct sharp_counts counts;
};

static struct found find(struct mesh mesh, bool is_strict)
{
	struct found f = {.mesh = mesh};
	struct fault fault = {0};
	assert_true(half_build_triangles(&f.half, mesh.corner, mesh.face_count, mesh.vertex_count, &fault));
	f.normal = mem_array(mesh.face_count, 3 * sizeof(double));
	f.bend = mem_array(f.half.half_count, sizeof(double));
	f.kind = mem_array(f.half.half_count, 1);
	wedge_triangle_normals(f.normal, mesh.xyz, &f.half, 1e-5);
	wedge_bends(f.bend, mesh.xyz, f.normal, &f.half);
	const struct sharp_options options = {40 / DEGREES, is_strict};
	sharp_edges(f.kind, &f.counts, mesh.xyz, f.bend, &f.half, &options);
	return f;
}

static void drop(struct found *f)
{
	shape_free(&f->mesh);
	half_free(&f->half);
	free(f->normal);
	free(f->bend);
	free(f->kind);
}

/* A prism around z with the given outline (counter-clockwise from above), capped by fans of the outline's mean. */
static struct mesh prism(const double (*outline)[2], int n, double height)
{
	struct mesh m = {0};
	double middle[2] = {0, 0};
	for (int level = 0; level < 2; level++)
		for (int i = 0; i < n; i++)
			shape_vertex(&m, outline[i][0], outline[i][1], level * height);
	for (int i = 0; i < n; i++)
		for (int k = 0; k < 2; k++)
			middle[k] += outline[i][k] / n;
	for (int i = 0; i < n; i++)
		shape_quad(&m, i, (i + 1) % n, n + (i + 1) % n, n + i);
	const idx_t low = shape_vertex(&m, middle[0], middle[1], 0), high = shape_vertex(&m, middle[0], middle[1], height);
	for (int i = 0; i < n; i++) {
		shape_triangle(&m, low, (i + 1) % n, i);
		shape_triangle(&m, high, n + i, n + (i + 1) % n);
	}
	return m;
}

static void cube_has_twelve(void **state)
{
	(void)state;
	struct found f = find(shape_box(1, 1, 1), false);
	assert_int_equal(f.counts.sharp, 12);
	drop(&f);
}

/* Eight sides bend 45 degrees each: regular, so that only the two rims of eight edges are sharp; six sides bend 60
 * and are a nut. */
static void coarse_cylinder_is_round_and_nut_is_not(void **state)
{
	(void)state;
	struct found f = find(shape_cylinder(0.5, 1, 8, 1), false);
	assert_int_equal(f.counts.sharp, 16);
	assert_int_equal(f.counts.regular, 8);
	drop(&f);
	f = find(shape_cylinder(0.5, 1, 8, 3), false); /* with rings of vertices between */
	assert_int_equal(f.counts.sharp, 16);
	assert_int_equal(f.counts.regular, 24);
	drop(&f);
	f = find(shape_cylinder(0.5, 1, 8, 1), true);
	assert_int_equal(f.counts.sharp, 24);
	drop(&f);
	f = find(shape_cylinder(0.5, 1, 6, 1), false);
	assert_int_equal(f.counts.sharp, 18);
	drop(&f);
}

/* A chamfer bends 45 degrees twice; the next bends are 90 degrees and far: sharp. 2 x 5 rim edges and 5 upright ones. */
static void chamfer_is_sharp(void **state)
{
	(void)state;
	static const double outline[5][2] = {{0, 0}, {1, 0}, {1, 0.9}, {0.9, 1}, {0, 1}};
	struct found f = find(prism(outline, 5, 0.5), false);
	assert_int_equal(f.counts.sharp, 15);
	assert_int_equal(f.counts.regular, 0);
	drop(&f);
	/* all four corners chamfered: eight equal bends, but unequal spacing */
	static const double four[8][2] = {{0.1, 0}, {0.9, 0}, {1, 0.1}, {1, 0.9}, {0.9, 1}, {0.1, 1}, {0, 0.9}, {0, 0.1}};
	f = find(prism(four, 8, 0.5), false);
	assert_int_equal(f.counts.sharp, 24);
	drop(&f);
}

/* A roof whose ridge fades: 60, 45, then 30 degrees. The last edge is below the angle, but the open chain goes on along it. */
static void open_chain_is_extended(void **state)
{
	(void)state;
	struct mesh m = {0};
	static const double lift[5] = {0.577, 0.45, 0.268, 0, 0};
	for (int i = 0; i < 5; i++) {
		shape_vertex(&m, i, -1, 0);
		shape_vertex(&m, i, 0, lift[i]);
		shape_vertex(&m, i, 1, 0);
	}
	for (int i = 0; i < 4; i++)
		for (int k = 0; k < 2; k++)
			shape_quad(&m, 3 * i + k, 3 * i + 3 + k, 3 * i + 4 + k, 3 * i + 1 + k);
	struct found f = find(m, false);
	assert_true(f.counts.extended >= 1);
	assert_true(f.counts.sharp >= 2 && f.counts.sharp <= 3);
	drop(&f);
}

/* A single edge of a pyramid-like bump, over the angle with nothing to go on to, is no feature. */
static void lonely_edge_goes(void **state)
{
	(void)state;
	/* a roof: the ridge is one edge that bends 60 degrees */
	struct mesh m = {0};
	const double z = tan(30 / DEGREES);
	shape_vertex(&m, -1, 0, z);
	shape_vertex(&m, 1, 0, z);
	shape_vertex(&m, -1, -1, 0);
	shape_vertex(&m, 1, -1, 0);
	shape_vertex(&m, 1, 1, 0);
	shape_vertex(&m, -1, 1, 0);
	shape_quad(&m, 2, 3, 1, 0);
	shape_quad(&m, 4, 5, 0, 1);
	struct found f = find(m, false);
	assert_int_equal(f.counts.lonely + f.counts.sharp, 1);
	/* its ends lie on the border here, so it leads somewhere: it stays */
	assert_int_equal(f.counts.sharp, 1);
	drop(&f);

	/* a hipped roof: the ridge bends 42 degrees, the hips half as much */
	m = (struct mesh){0};
	static const double ring[6][2] = {{-5, 0}, {-2.5, -3}, {2.5, -3}, {5, 0}, {2.5, 3}, {-2.5, 3}};
	shape_vertex(&m, -1, 0, 1.15);
	shape_vertex(&m, 1, 0, 1.15);
	for (int i = 0; i < 6; i++)
		shape_vertex(&m, ring[i][0], ring[i][1], 0);
	shape_triangle(&m, 0, 2, 3);
	shape_quad(&m, 3, 4, 1, 0);
	shape_triangle(&m, 1, 4, 5);
	shape_triangle(&m, 1, 5, 6);
	shape_quad(&m, 6, 7, 0, 1);
	shape_triangle(&m, 0, 7, 2);
	f = find(m, false);
	assert_int_equal(f.counts.over_angle, 1);
	assert_int_equal(f.counts.lonely, 1);
	assert_int_equal(f.counts.sharp, 0);
	drop(&f);
}

/* A needle between two faces whose height is below the digits of a file has no normal of its own: it may not make edges sharp. */
static void needle_takes_its_neighbours_normal(void **state)
{
	(void)state;
	struct mesh m = {0};
	shape_vertex(&m, 0, 0, 0);
	shape_vertex(&m, 1, 0, 0);
	shape_vertex(&m, 0.5, 1, 0);
	shape_vertex(&m, 0.5, -1, 0);
	shape_vertex(&m, 0.5, 1e-7, 1e-6); /* on the line of 0 and 1 but for rounding */
	shape_triangle(&m, 0, 4, 2);
	shape_triangle(&m, 4, 1, 2);
	shape_triangle(&m, 0, 1, 4);
	shape_triangle(&m, 0, 3, 1);
	struct found f = find(m, false);
	assert_int_equal(f.counts.sharp, 0);
	assert_near(f.normal[3 * 2 + 2], 1, 1e-9);
	drop(&f);
}

/* Three wedges at a cube's corner, one at a dart's end, two on a ridge. */
static void wedges_are_fans(void **state)
{
	(void)state;
	struct mesh m = {0};
	idx_t *vertex;
	/* a flat grid of 3 x 3 vertices with one marked edge from the rim to the middle, then on to the other rim */
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++)
			shape_vertex(&m, j, i, 0);
	for (int i = 0; i < 2; i++)
		for (int j = 0; j < 2; j++)
			shape_quad(&m, 3 * i + j, 3 * i + j + 1, 3 * i + j + 4, 3 * i + j + 3);
	struct found f = find(m, false);
	idx_t wedge[24];
	assert_int_equal(wedge_number(wedge, &vertex, &f.half, f.kind), 9);
	free(vertex);
	for (size_t h = 0; h < f.half.half_count; h++) {
		const idx_t a = f.half.origin[h], b = f.half.origin[f.half.next[h]];
		if ((a == 1 && b == 4) || (a == 4 && b == 1))
			f.kind[h] = EDGE_SHARP;
	}
	/* vertex 1 on the rim is cut in two, vertex 4 is a dart's end */
	assert_int_equal(wedge_number(wedge, &vertex, &f.half, f.kind), 10);
	free(vertex);
	for (size_t h = 0; h < f.half.half_count; h++) {
		const idx_t a = f.half.origin[h], b = f.half.origin[f.half.next[h]];
		if ((a == 7 && b == 4) || (a == 4 && b == 7))
			f.kind[h] = EDGE_SHARP;
	}
	assert_int_equal(wedge_number(wedge, &vertex, &f.half, f.kind), 12);
	for (size_t h = 0; h < f.half.half_count; h++) {
		assert_int_equal(vertex[wedge[h]], f.half.origin[h]);
		/* the two sides of an unmarked edge share the wedge */
		if (!f.kind[h])
			assert_int_equal(wedge[h], wedge[f.half.next[f.half.twin[h]]]);
	}
	free(vertex);
	drop(&f);
	f = find(shape_box(1, 2, 3), false);
	idx_t box[36];
	assert_int_equal(wedge_number(box, NULL, &f.half, f.kind), 24);
	drop(&f);
}

/* Euler characteristics: a disc 1, an annulus 0 with two loops, a torus 0 of genus 1, a sphere 2; two triangles that touch at
 * a vertex are apart after splitting. */
static void topologies(void **state)
{
	(void)state;
	struct patch_topology t[4];
	const int n = 12;
	struct found f = find(shape_cylinder(0.5, 1, n, 2), false);
	idx_t *label = mem_array(f.mesh.face_count, sizeof *label);
	for (int i = 0; i < 6 * n; i++)
		label[i] = i < 4 * n ? 0 : i < 5 * n ? 1 : 2;
	patch_topologies(t, 3, label, &f.half);
	assert_int_equal(t[0].euler, 0);
	assert_int_equal(t[0].border_loops, 2);
	assert_int_equal(t[0].genus, 0);
	assert_int_equal(t[1].euler, 1);
	assert_int_equal(t[1].border_loops, 1);
	assert_int_equal(t[1].genus, 0);
	assert_int_equal(t[0].components, 1);
	struct patch_adjacency *list;
	assert_int_equal(patch_adjacencies(&list, label, f.mesh.xyz, f.kind, &f.half), 2);
	assert_int_equal(list[1].first, 0);
	assert_int_equal(list[1].second, 2);
	assert_near(list[1].length, n * 2 * 0.5 * sin(PI / n), 1e-12);
	assert_near(list[1].sharp_length, list[1].length, 1e-12);
	free(list);
	memset(label, 0, f.mesh.face_count * sizeof *label);
	patch_topologies(t, 1, label, &f.half);
	assert_int_equal(t[0].euler, 2);
	assert_int_equal(t[0].border_loops, 0);
	/* two opposite triangles of the upper cap: they meet in its centre only */
	label[5 * n] = label[5 * n + 6] = 1;
	patch_topologies(t, 2, label, &f.half);
	assert_int_equal(t[1].components, 2);
	assert_int_equal(t[1].vertices, 6);
	assert_int_equal(t[1].border_loops, 2);
	free(label);
	drop(&f);

	f = find(shape_torus(3, 1, 12, 8), false);
	label = mem_array(f.mesh.face_count, sizeof *label);
	patch_topologies(t, 1, label, &f.half);
	assert_int_equal(t[0].euler, 0);
	assert_int_equal(t[0].genus, 1);
	free(label);
	drop(&f);
}

/* Edges named by a file are found on both sides; a pair of vertices that is no edge is refused. */
static void listed_edges(void **state)
{
	(void)state;
	struct found f = find(shape_box(1, 1, 1), false);
	struct dense_edge edge[2] = {{1, 0, 90, EDGE_SHARP}, {4, 6, 90, EDGE_SHARP}};
	struct dense dense = {.edge_count = 2, .edge = edge};
	struct fault fault = {0};
	unsigned char kind[36];
	assert_true(wedge_mark_edges(kind, &dense, &f.half, "box.ply", &fault));
	size_t marked = 0;
	for (size_t h = 0; h < 36; h++) {
		marked += kind[h] == EDGE_SHARP;
		assert_int_equal(kind[h], kind[f.half.twin[h]]);
	}
	assert_int_equal(marked, 4);
	edge[1].vertex2 = 3;
	assert_false(wedge_mark_edges(kind, &dense, &f.half, "box.ply", &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_non_null(strstr(fault.text, "box.ply"));
	drop(&f);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(cube_has_twelve),
		cmocka_unit_test(coarse_cylinder_is_round_and_nut_is_not),
		cmocka_unit_test(chamfer_is_sharp),
		cmocka_unit_test(open_chain_is_extended),
		cmocka_unit_test(lonely_edge_goes),
		cmocka_unit_test(needle_takes_its_neighbours_normal),
		cmocka_unit_test(wedges_are_fans),
		cmocka_unit_test(topologies),
		cmocka_unit_test(listed_edges),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
