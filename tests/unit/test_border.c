/* Chains and nodes of borders on meshes whose network is known. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/geometry/border.h"
#include "stages/geometry/vector.h"

/* A flat grid of n by n squares over [0, 1]^2, two triangles each, labelled by a function of the square. */
static struct dense grid(size_t n, idx_t (*label)(size_t i, size_t j, size_t n), size_t patches)
{
	struct dense d = {.vertex_count = (n + 1) * (n + 1), .triangle_count = 2 * n * n, .patch_count = patches};
	d.xyz = mem_array(3 * d.vertex_count, sizeof *d.xyz);
	d.triangle = mem_array(3 * d.triangle_count, sizeof *d.triangle);
	d.label = mem_array(d.triangle_count, sizeof *d.label);
	for (size_t j = 0; j <= n; j++)
		for (size_t i = 0; i <= n; i++) {
			double *p = d.xyz + 3 * (j * (n + 1) + i);
			p[0] = (double)i / (double)n, p[1] = (double)j / (double)n;
		}
	for (size_t j = 0; j < n; j++)
		for (size_t i = 0; i < n; i++) {
			const idx_t a = (idx_t)(j * (n + 1) + i), b = a + 1, c = b + (idx_t)n + 1, e = a + (idx_t)n + 1;
			const size_t t = 2 * (j * n + i);
			const idx_t tri[6] = {a, b, c, a, c, e};
			for (size_t k = 0; k < 6; k++)
				d.triangle[3 * t + k] = tri[k];
			d.label[t] = d.label[t + 1] = label(i, j, n);
		}
	return d;
}

static idx_t one(size_t i, size_t j, size_t n)
{
	(void)i, (void)j, (void)n;
	return 0;
}
static idx_t halves(size_t i, size_t j, size_t n)
{
	(void)j;
	return i < n / 2;
}
static idx_t chequered(size_t i, size_t j, size_t n)
{
	return (i < n / 2) == (j < n / 2);
}
static idx_t island(size_t i, size_t j, size_t n)
{
	const double x = (double)i + 0.5 - (double)n / 2, y = (double)j + 0.5 - (double)n / 2;
	return x * x + y * y < (double)(n * n) / 9;
}

/* Left patch on the left: every chain edge is an edge of a triangle with the left label, in its direction. */
static void check_left(const struct border_network *b, const struct dense *d)
{
	for (size_t c = 0; c < b->chain_count; c++) {
		const struct border_chain *chain = b->chain + c;
		for (size_t i = 1; i < chain->count + chain->closed; i++) {
			const idx_t from = b->vertex[chain->first + i - 1], to = b->vertex[chain->first + i % chain->count];
			bool found = false;
			for (size_t h = 0; h < 3 * d->triangle_count; h++)
				found |= d->triangle[h] == from && d->triangle[h - h % 3 + (h + 1) % 3] == to &&
					 d->label[h / 3] == chain->left;
			assert_true(found);
		}
	}
}

/* The border of a square plate turns by 90 degrees four times: 4 corners, 4 straight chains; all else is straight. */
static void test_square(void **state)
{
	(void)state;
	for (size_t n = 1; n < 9; n += 3) {
		struct dense d = grid(n, one, 1);
		struct border_network b;
		struct fault fault = {0};
		assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
		assert_int_equal(b.node_count, 4);
		assert_int_equal(b.chain_count, 4);
		assert_int_equal(b.euler, 1);
		for (size_t i = 0; i < 4; i++) {
			assert_int_equal(b.node_kind[i], POINT_CORNER);
			assert_int_equal(b.chain[i].kind, CURVE_BORDER);
			assert_int_equal(b.chain[i].right, -1);
			assert_int_equal(b.chain[i].count, n + 1);
			assert_false(b.chain[i].closed);
		}
		check_left(&b, &d);
		border_free(&b);
		dense_free(&d);
	}
}

/* Two halves of a plate: the middle line ends in two nodes, in which two border chains go straight on (no corners). The
 * plate is flat, so the line is smooth. */
static void test_halves(void **state)
{
	(void)state;
	struct dense d = grid(6, halves, 2);
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	assert_int_equal(b.node_count, 6);
	assert_int_equal(b.chain_count, 7);
	size_t smooth = 0, corners = 0;
	for (size_t i = 0; i < b.chain_count; i++)
		if (b.chain[i].kind == CURVE_SMOOTH) {
			smooth++;
			assert_int_equal(b.chain[i].left, 0);
			assert_int_equal(b.chain[i].right, 1);
			assert_int_equal(b.chain[i].count, 7);
		}
	for (size_t i = 0; i < b.node_count; i++)
		corners += b.node_kind[i] == POINT_CORNER;
	assert_int_equal(smooth, 1);
	assert_int_equal(corners, 4);
	check_left(&b, &d);
	border_free(&b);
	dense_free(&d);
}

/* Where two squares of one patch touch in the middle of the plate there is a node with four chains. */
static void test_touching(void **state)
{
	(void)state;
	struct dense d = grid(4, chequered, 2);
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	const idx_t middle = b.node_of_vertex[12];
	assert_true(middle != NO_INDEX);
	size_t there = 0;
	for (size_t i = 0; i < b.chain_count; i++)
		there += b.vertex[b.chain[i].first] == 12 || b.vertex[b.chain[i].first + b.chain[i].count - 1] == 12;
	assert_int_equal(there, 4);
	check_left(&b, &d);
	border_free(&b);
	dense_free(&d);
}

/* A round island in a square grid has a border of unit steps; they are smaller than the reach of a corner, so it is one
 * closed smooth chain, which begins at its leftmost, then lowest vertex. */
static void test_island(void **state)
{
	(void)state;
	struct dense d = grid(120, island, 2);
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	size_t closed = 0;
	for (size_t i = 0; i < b.chain_count; i++)
		if (b.chain[i].closed) {
			closed++;
			const double *seam = d.xyz + 3 * (size_t)b.vertex[b.chain[i].first];
			for (size_t k = 0; k < b.chain[i].count; k++) {
				const double *p = d.xyz + 3 * (size_t)b.vertex[b.chain[i].first + k];
				assert_true(seam[0] < p[0] || (seam[0] == p[0] && seam[1] <= p[1]));
			}
		}
	assert_int_equal(closed, 1);
	assert_int_equal(b.chain_count, 5);
	check_left(&b, &d);
	border_free(&b);
	dense_free(&d);
}

static const double cube_xyz[24] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
static const idx_t cube_triangle[36] = {0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
					1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};

static struct dense cube(void)
{
	struct dense d = {.vertex_count = 8, .triangle_count = 12, .patch_count = 6};
	d.xyz = mem_copy(cube_xyz, 24, sizeof *d.xyz);
	d.triangle = mem_copy(cube_triangle, 36, sizeof *d.triangle);
	d.label = mem_array(12, sizeof *d.label);
	for (size_t t = 0; t < 12; t++)
		d.label[t] = (idx_t)(t / 2);
	return d;
}

/* A cube: 8 nodes where three sharp chains meet (junctions: corners by rule), 12 chains of one edge. */
static void test_cube(void **state)
{
	(void)state;
	struct dense d = cube();
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	assert_int_equal(b.node_count, 8);
	assert_int_equal(b.chain_count, 12);
	assert_int_equal(b.euler, 2);
	for (size_t i = 0; i < 12; i++) {
		assert_int_equal(b.chain[i].kind, CURVE_SHARP);
		assert_int_equal(b.chain[i].count, 2);
		assert_true(b.chain[i].left < b.chain[i].right);
	}
	for (size_t i = 0; i < 8; i++)
		assert_int_equal(b.node_kind[i], POINT_JUNCTION);
	check_left(&b, &d);
	border_free(&b);
	dense_free(&d);
}

/* Patches cut from one surface by a virtual border meet in a smooth chain whatever the mesh does there. */
static void test_parent(void **state)
{
	(void)state;
	struct dense d = cube();
	d.patch = mem_array(6, sizeof *d.patch);
	for (idx_t i = 0; i < 6; i++)
		d.patch[i].parent = i == 3 ? 2 : i;
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	size_t smooth = 0;
	for (size_t i = 0; i < b.chain_count; i++)
		if (b.chain[i].kind == CURVE_SMOOTH) {
			smooth++;
			assert_int_equal(b.chain[i].left, 2);
			assert_int_equal(b.chain[i].right, 3);
		}
	assert_int_equal(smooth, 1);
	/* Its two ends are where the other two edges, at right angles, make a corner with only two sharp chains. */
	size_t corners = 0;
	for (size_t i = 0; i < b.node_count; i++)
		corners += b.node_kind[i] == POINT_CORNER;
	assert_int_equal(corners, 2);
	border_free(&b);
	dense_free(&d);
}

/* A plate bent along its middle line by an angle that changes from 60 degrees to nothing: the crease ends in the middle,
 * so the border between the halves gets a node there and two chains of different kind. */
static void test_fading_crease(void **state)
{
	(void)state;
	const size_t n = 20;
	struct dense d = grid(n, halves, 2);
	for (size_t j = 0; j <= n; j++)
		for (size_t i = 0; i <= n; i++) {
			double *p = d.xyz + 3 * (j * (n + 1) + i);
			const double bend = fmax(0, 0.5 - p[1]) * 2;
			p[2] = -bend * fabs(p[0] - 0.5);
		}
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	size_t sharp = 0, smooth = 0;
	for (size_t i = 0; i < b.chain_count; i++) {
		sharp += b.chain[i].kind == CURVE_SHARP;
		smooth += b.chain[i].kind == CURVE_SMOOTH;
		if (b.chain[i].kind == CURVE_SMOOTH)
			assert_true(b.chain[i].count >= n / 2);
	}
	assert_int_equal(sharp, 1);
	assert_int_equal(smooth, 1);
	border_free(&b);
	dense_free(&d);
}

/* An inner sharp edge with one patch on both sides is counted; it becomes a chain only when asked for. */
static void test_dart(void **state)
{
	(void)state;
	struct dense d = grid(4, one, 1);
	struct dense_edge edge[2] = {{11, 12, 50, EDGE_SHARP}, {12, 13, 50, EDGE_SHARP}};
	d.edge = edge, d.edge_count = 2;
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	assert_int_equal(b.dart_edge_count, 2);
	assert_int_equal(b.chain_count, 4);
	border_free(&b);
	assert_true(border_extract(&b, &d, (struct border_options){45, 8, true}, &fault));
	assert_int_equal(b.chain_count, 5);
	border_free(&b);
	d.edge = NULL, d.edge_count = 0;
	dense_free(&d);
}

static void test_faults(void **state)
{
	(void)state;
	struct dense d = cube();
	struct border_network b;
	struct fault fault = {0};
	d.triangle[0] = 3, d.triangle[1] = 0; /* turned around: two triangles run the same way */
	assert_false(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	dense_free(&d);
	d = cube();
	for (size_t k = 0; k < 3; k++)
		d.triangle[33 + k] = d.triangle[k]; /* a triangle twice: three at its edges */
	fault = (struct fault){0};
	assert_false(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	dense_free(&d);
}

/* A network made of the chains' own vertices, with its curves in another order and direction, finds its chains again. */
static void test_match(void **state)
{
	(void)state;
	struct dense d = cube();
	struct border_network b;
	struct fault fault = {0};
	assert_true(border_extract(&b, &d, BORDER_DEFAULTS, &fault));
	struct curve curve[12];
	idx_t point[24], found[12];
	for (size_t i = 0; i < 12; i++) {
		const struct border_chain *chain = b.chain + 11 - i;
		curve[i] = (struct curve){.left = chain->right, .right = chain->left, .first = 2 * i, .count = 2};
		point[2 * i] = b.vertex[chain->first + 1];
		point[2 * i + 1] = b.vertex[chain->first];
	}
	struct network network = {
		.vertex_count = 8, .curve_count = 12, .point_count = 24, .xyz = d.xyz, .curve = curve, .point = point};
	border_match(found, &b, &d, &network);
	for (idx_t i = 0; i < 12; i++)
		assert_int_equal(found[i], 11 - i);
	border_free(&b);
	dense_free(&d);
}

/* The options come back from the comment; nonsense in it gives the defaults. */
static void test_options(void **state)
{
	(void)state;
	struct ply ply;
	ply_init(&ply);
	struct border_options options = border_options_from_ply(&ply);
	assert_true(options.corner_deg == 45 && options.smooth_deg == 8);
	border_options_to_ply(&ply, (struct border_options){30.5, 0, false});
	border_options_to_ply(&ply, (struct border_options){62.25, 1, false});
	assert_int_equal(ply.comment_count, 1);
	options = border_options_from_ply(&ply);
	assert_true(options.corner_deg == 62.25 && options.smooth_deg == 1);
	ply_free(&ply);
	ply_init(&ply);
	ply_comment(&ply, "cagewright-border corner=x smooth=-4");
	options = border_options_from_ply(&ply);
	assert_true(options.corner_deg == 45 && options.smooth_deg == 8);
	ply_free(&ply);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_square),        cmocka_unit_test(test_halves),  cmocka_unit_test(test_touching),
		cmocka_unit_test(test_island),        cmocka_unit_test(test_cube),    cmocka_unit_test(test_parent),
		cmocka_unit_test(test_fading_crease), cmocka_unit_test(test_dart),    cmocka_unit_test(test_faults),
		cmocka_unit_test(test_match),         cmocka_unit_test(test_options),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
