/* Drafts from networks and into documents; polygons of control points. */
#include "tests/unit/fitpatch_rig.h"

#include <stdio.h>

#include "formats/cage.h"
#include "stages/geometry/polygon.h"

static void test_start(void **state)
{
	(void)state;
	struct dense dense = rig_cylinder(0.5, 1, 24, 1);
	struct rig rig;
	rig_make(&rig, dense, 3e-3, 3e-3);
	const size_t n = rig.network.curve[0].count;
	for (size_t i = 0; i < rig.draft.control.count; i++) {
		assert_int_equal(rig.draft.control.held[i], 0);
		assert_int_equal(rig.draft.control.role[i], rig.network.kind[i]);
	}
	draft_free(&rig.draft);
	/* A point moved by hand: the curve's length says so, and all of its points are held, no other's. */
	rig.network.xyz[3 * (size_t)rig.network.point[rig.network.curve[1].first] + 1] += 0.1;
	draft_start(&rig.draft, &rig.network);
	size_t held = 0;
	for (size_t i = 0; i < rig.draft.control.count; i++)
		held += rig.draft.control.held[i];
	assert_int_equal(held, n);
	for (size_t i = 0; i < n; i++)
		assert_int_equal(rig.draft.control.held[rig.network.point[rig.network.curve[1].first + i]], 1);
	/* A copy shares nothing. */
	rig_layout(&rig);
	struct draft copy;
	draft_copy(&copy, &rig.draft);
	assert_int_equal(copy.polygons.count, rig.draft.polygons.count);
	assert_memory_equal(copy.control.xyz, rig.draft.control.xyz, 3 * copy.control.count * sizeof(double));
	const double kept = rig.draft.control.xyz[0];
	copy.control.xyz[0] = 99;
	copy.network.curve[0].kind = CURVE_SMOOTH;
	control_add(&copy.control, (double[3]){1, 2, 3}, POINT_INSIDE);
	polygons_add(&copy.polygons, (const idx_t[3]){0, 1, 2}, 3, 0);
	assert_near(rig.draft.control.xyz[0], kept, 0);
	assert_int_equal(rig.draft.network.curve[0].kind, CURVE_SHARP);
	draft_free(&copy);
	rig_free(&rig);
}

static void test_label_lists(void **state)
{
	(void)state;
	const idx_t label[7] = {2, 0, 2, 2, 0, 3, 2};
	size_t *start;
	idx_t *list;
	label_lists(&start, &list, label, 7, 5);
	const size_t wanted[6] = {0, 2, 2, 6, 7, 7}; /* patches 1 and 4 have no triangle */
	const idx_t order[7] = {1, 4, 0, 2, 3, 6, 5};
	for (int p = 0; p < 6; p++)
		assert_int_equal(start[p], wanted[p]);
	assert_memory_equal(list, order, sizeof order);
	free(start), free(list);
}

/* Through a document and its text back into a cage and a network: each patch in vertices of its own, which name the network
 * points that they are, in the same places. */
static void test_round_trip(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_ball(1, 6), 8e-3, 3e-3);
	for (int p = 0; p < 6; p += 2)
		rig.layouts.detail[p] = 2; /* points inside */
	rig_layout(&rig);
	struct ply ply, again;
	struct fault fault = {0};
	ply_init(&ply);
	network_to_ply(&ply, &rig.network, "vertex");
	ply_put_element(&ply, "remark", 2);
	local_to_ply(&ply, &rig.draft);
	char *text = NULL;
	size_t size = 0;
	FILE *file = open_memstream(&text, &size);
	ply_write(file, &ply);
	fclose(file);
	const struct input input = {.shown = "t.ply", .data = (void *)text, .size = size};
	assert_true(ply_read(&again, &input, &fault));
	assert_non_null(ply_element(&again, "remark"));
	struct cage cage;
	struct network network;
	if (!cage_from_ply(&cage, &again, "t.ply", &fault) || !network_from_ply(&network, &again, "netpoint", "t.ply", &fault))
		fail_msg("%s", fault.text);

	assert_int_equal(network.vertex_count, rig.network.vertex_count);
	assert_int_equal(network.curve_count, rig.network.curve_count);
	for (size_t i = 0; i < network.vertex_count; i++)
		assert_near(distance3(&network.xyz[3 * i], &rig.draft.control.xyz[3 * i]), 0, 0);
	for (size_t k = 0; k < network.curve_count; k++) {
		assert_int_equal(network.curve[k].kind, CURVE_SMOOTH);
		assert_false(network_curve_edited(&network, &network.curve[k])); /* the fit is no hand edit */
	}
	assert_int_equal(cage.face_count, rig.draft.polygons.count);
	assert_non_null(cage.net);
	idx_t *patch_of = mem_array(cage.vertex_count, sizeof *patch_of);
	memset(patch_of, 0xff, cage.vertex_count * sizeof *patch_of);
	size_t inside = 0;
	for (size_t f = 0; f < cage.face_count; f++) {
		assert_int_equal(cage.face_patch[f], rig.draft.polygons.patch[f]);
		assert_int_equal(cage.face_start[f + 1] - cage.face_start[f], rig.draft.polygons.start[f + 1] - rig.draft.polygons.start[f]);
		for (size_t h = cage.face_start[f]; h < cage.face_start[f + 1]; h++) {
			const idx_t v = cage.face_corner[h], point = rig.draft.polygons.corner[h];
			assert_near(distance3(&cage.xyz[3 * (size_t)v], &rig.draft.control.xyz[3 * (size_t)point]), 0, 0);
			assert_int_equal(cage.net[v], rig.draft.control.role[point] == POINT_INSIDE ? NO_INDEX : point);
			assert_true(patch_of[v] == NO_INDEX || patch_of[v] == cage.face_patch[f]);
			inside += patch_of[v] == NO_INDEX && cage.net[v] == NO_INDEX;
			patch_of[v] = cage.face_patch[f];
		}
	}
	for (size_t v = 0; v < cage.vertex_count; v++)
		assert_true(patch_of[v] != NO_INDEX);
	assert_true(inside > 0);
	assert_int_equal(inside, rig.draft.control.count - rig.network.vertex_count);
	free(patch_of), free(text);
	cage_free(&cage);
	network_free(&network);
	ply_free(&again);
	ply_free(&ply);
	rig_free(&rig);
}

/* What refinement adds to curves comes after the network's own points; those that no curve has any more are left out. */
static void test_numbers(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_cylinder(0.5, 1, 24, 1), 3e-3, 3e-3);
	rig_layout(&rig);
	const size_t n = rig.network.vertex_count;
	struct network *network = &rig.draft.network;
	/* a point of the last curve is put out of use, a new one takes its place */
	const size_t at = network->curve[network->curve_count - 1].first;
	const idx_t old = network->point[at], new = control_add(&rig.draft.control, (double[3]){7, 8, 9}, POINT_CREASE);
	network->point[at] = new;
	for (size_t h = 0; h < rig.draft.polygons.start[rig.draft.polygons.count]; h++)
		if (rig.draft.polygons.corner[h] == old)
			rig.draft.polygons.corner[h] = new;
	struct ply ply;
	struct network result;
	struct fault fault = {0};
	ply_init(&ply);
	local_to_ply(&ply, &rig.draft);
	assert_true(network_from_ply(&result, &ply, "netpoint", "t.ply", &fault));
	assert_int_equal(result.vertex_count, n);
	assert_near(result.xyz[3 * (n - 1)], 7, 0);
	assert_int_equal(result.point[result.curve[result.curve_count - 1].first], n - 1);
	for (size_t i = 0, k = 0; i < n; i++)
		if ((idx_t)i != old) {
			assert_near(distance3(&result.xyz[3 * k], &rig.draft.control.xyz[3 * i]), 0, 0);
			k++;
		}
	network_free(&result);
	ply_free(&ply);
	rig_free(&rig);
}

static void test_polygon(void **state)
{
	(void)state;
	const double xyz[] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, /* a square */ 2, 2, 1, /* its third corner lifted */ 0.2, 0.2, 0 /* drawn in */, 1, 0, 0};
	const idx_t square[4] = {0, 1, 2, 3}, lifted[4] = {0, 1, 4, 3}, dart[4] = {0, 1, 5, 3}, flat[3] = {0, 6, 1};
	const double up[3] = {0, 0, 1}, down[3] = {0, 0, -1};
	double centre[3], normal[3];
	assert_near(polygon_plane(centre, normal, xyz, square, 4), 4, 1e-12);
	assert_near(distance3(centre, (double[3]){1, 1, 0}), 0, 1e-12);
	assert_near(distance3(normal, up), 0, 1e-12);
	assert_near(polygon_flatness(xyz, square, 4), 0, 1e-15);
	assert_near(polygon_star(xyz, square, 4, up), 1, 1e-12);    /* all sub-quads alike */
	assert_near(polygon_star(xyz, square, 4, down), -1, 1e-12); /* seen from below they run the wrong way */
	/* One corner of four lifted by 1: the best plane through the centre passes all corners at a fourth of its height, less the tilt. */
	const double flatness = polygon_flatness(xyz, lifted, 4);
	polygon_plane(centre, normal, xyz, lifted, 4);
	assert_true(flatness > 0.1 && flatness <= 0.25);
	assert_near(flatness, 0.25 * normal[2], 1e-12);
	/* The centroid (0.55, 0.55) lies beyond the corner that was drawn in: the sub-quad there folds over. */
	assert_true(polygon_star(xyz, dart, 4, up) < 0);
	assert_near(polygon_plane(centre, normal, xyz, flat, 3), 0, 0);
	assert_near(norm3(normal), 0, 0);
	/* a regular polygon of any size */
	for (int n = 3; n < 30; n++) {
		double p[90];
		idx_t corner[30];
		for (int i = 0; i < n; i++)
			p[3 * i] = cos(2 * PI * i / n), p[3 * i + 1] = sin(2 * PI * i / n), p[3 * i + 2] = 5, corner[i] = i;
		assert_near(polygon_star(p, corner, (size_t)n, up), 1, 1e-9);
		assert_near(polygon_plane(centre, normal, p, corner, (size_t)n), n / 2.0 * sin(2 * PI / n), 1e-12);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_start),   cmocka_unit_test(test_label_lists), cmocka_unit_test(test_round_trip),
		cmocka_unit_test(test_numbers), cmocka_unit_test(test_polygon),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
