#include "tests/unit/helpers.h"

#include "formats/network.h"

/* Two open curves between the corners 0 and 3 (one straight, one by way of 1 and 2) and a closed triangle 4 5 6.
 * Their points stand in another order than the curves. */
static struct network three_curves(void)
{
	static const double xyz[21] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 5, 3, 0, 5, 0, 4, 5};
	static const unsigned char kind[7] = {POINT_CORNER, POINT_CREASE, POINT_CREASE, POINT_JUNCTION, POINT_CREASE, POINT_CREASE, POINT_CREASE};
	static const struct curve curve[3] = {
		{.left = 0, .right = -1, .kind = CURVE_BORDER, .first = 3, .count = 4, .error = 0.25, .length = 3},
		{.left = 0, .right = 1, .kind = CURVE_SHARP, .first = 7, .count = 2, .error = 0, .length = 1},
		{.left = 1, .right = 2, .kind = CURVE_SMOOTH, .closed = true, .first = 0, .count = 3, .error = 1e-3, .length = 12},
	};
	static const idx_t point[9] = {4, 5, 6, 0, 1, 2, 3, 3, 0};
	struct network n = {.vertex_count = 7, .curve_count = 3, .point_count = 9};
	n.xyz = mem_copy(xyz, 21, sizeof *xyz);
	n.kind = mem_copy(kind, 7, 1);
	n.curve = mem_copy(curve, 3, sizeof *curve);
	n.point = mem_copy(point, 9, sizeof *point);
	return n;
}

static void comes_back(void **state)
{
	(void)state;
	static const char *const element[] = {"vertex", "netpoint"};
	for (int k = 0; k < 2; k++) {
		struct network n = three_curves(), back;
		struct fault fault = {0};
		struct ply ply;
		ply_init(&ply);
		network_to_ply(&ply, &n, element[k]);
		assert_true((ply_element(&ply, "edge") != NULL) == (k == 0));
		assert_true(network_from_ply(&back, &ply, element[k], "t.ply", &fault));
		assert_int_equal(back.vertex_count, 7);
		assert_memory_equal(back.xyz, n.xyz, 21 * sizeof *n.xyz);
		assert_memory_equal(back.kind, n.kind, 7);
		assert_int_equal(back.curve_count, 3);
		for (int c = 0; c < 3; c++) {
			const struct curve *a = &n.curve[c], *b = &back.curve[c];
			assert_true(a->left == b->left && a->right == b->right && a->kind == b->kind && a->closed == b->closed &&
			            a->count == b->count && a->error == b->error && a->length == b->length);
			for (size_t i = 0; i < a->count; i++)
				assert_int_equal(n.point[a->first + i], back.point[b->first + i]);
		}
		network_free(&back);
		network_free(&n);
		ply_free(&ply);
	}
}

static void draws_every_side_once(void **state)
{
	(void)state;
	struct network n = three_curves();
	struct ply ply;
	ply_init(&ply);
	network_to_ply(&ply, &n, "vertex");
	const struct ply_element *edge = ply_element(&ply, "edge");
	/* 3 sides, 1 side, and 3 of the closed curve with the closing one */
	assert_int_equal(edge->count, 7);
	assert_true(ply_column(edge, "vertex1")->value[6] == 6 && ply_column(edge, "vertex2")->value[6] == 4);
	network_free(&n);
	ply_free(&ply);
}

static void lengths_tell_edits(void **state)
{
	(void)state;
	struct network n = three_curves();
	/* three sides of a unit square; its fourth; the triangle 3 4 5 */
	assert_near(network_curve_length(&n, &n.curve[0]), 3, 1e-15);
	assert_near(network_curve_length(&n, &n.curve[1]), 1, 1e-15);
	assert_near(network_curve_length(&n, &n.curve[2]), 12, 1e-14);
	for (int c = 0; c < 3; c++)
		assert_false(network_curve_edited(&n, &n.curve[c]));
	/* rounding is no edit */
	n.curve[2].length = 12 * (1 + 1e-14);
	assert_false(network_curve_edited(&n, &n.curve[2]));
	/* moving point 1 by hand changes the first curve, no other */
	n.xyz[3] = 1.001;
	assert_true(network_curve_edited(&n, &n.curve[0]));
	assert_false(network_curve_edited(&n, &n.curve[1]));
	/* a point of the closed curve, through its closing side too */
	n.xyz[3 * 6] = -0.01;
	assert_true(network_curve_edited(&n, &n.curve[2]));
	network_free(&n);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(comes_back),
		cmocka_unit_test(draws_every_side_once),
		cmocka_unit_test(lengths_tell_edits),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
