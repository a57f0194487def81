/* Patch borders: wrong triangles come back, sharp borders stay, slivers and loose pieces go (the patch method's sections 3.5 and 10). */
#include "tests/unit/known_shapes.h"

#include <string.h>

#include "formats/dense.h"
#include "stages/curv/curvature.h"
#include "stages/geometry/wedge.h"
#include "stages/rectify/mincut.h"
#include "stages/rectify/rectification.h"

static const struct rectification_options plain = {0, 5e-4, false, false, false, 25 / DEGREES, 2};

static struct dense dense_of(const struct mesh *mesh)
{
	struct dense dense;
	struct fault fault = {0};
	const struct curvature_options options = {{40 / DEGREES, false}, 0};
	assert_true(curvature_compute(&dense, NULL, mesh, NULL, 0, &options, &fault));
	dense.label = mem_array(dense.triangle_count, sizeof *dense.label);
	return dense;
}

static void put_patches(struct dense *dense, const struct dense_patch *patch, size_t count)
{
	dense->patch = mem_copy(patch, count, sizeof *patch);
	dense->patch_count = count;
	for (size_t l = 0; l < count; l++)
		dense->patch[l].parent = (idx_t)l;
}

/* Three walls joined by a quarter round: an L-shaped profile with a fillet of radius r between its two outer faces, drawn
 * along z. Profile: (0,0) (1,0) up to (1,1-r), the arc to (1-r,1), then (0,1). Every face of the profile is cut in steps along z and
 * along itself. Patches: 0 wall x = 1, 1 fillet, 2 wall y = 1, 3 the others. */
#define FILLET 0.4
static struct mesh filleted(struct dense *dense, int steps, int arc_steps)
{
	struct mesh m = {0};
	const int wall = steps / 2;
	const int n = 2 * wall + arc_steps + 1; /* vertices along the profile from (1, 0) to (0, 1) */
	for (int z = 0; z <= steps; z++)
		for (int i = 0; i < n; i++) {
			double x = 1, y = 1;
			if (i <= wall)
				y = (1 - FILLET) * i / wall;
			else if (i >= wall + arc_steps)
				x = (1 - FILLET) * (n - 1 - i) / wall;
			else {
				const double a = PI / 2 * (i - wall) / arc_steps;
				x = 1 - FILLET + FILLET * cos(a), y = 1 - FILLET + FILLET * sin(a);
			}
			shape_vertex(&m, x, y, (double)z / steps);
		}
	const int corner = (int)m.vertex_count;
	for (int z = 0; z <= steps; z++)
		shape_vertex(&m, 0, 0, (double)z / steps);
	idx_t *label = NULL;
	size_t count = 0;
	for (int z = 0; z < steps; z++)
		for (int i = 0; i + 1 < n; i++) {
			shape_quad(&m, z * n + i, z * n + i + 1, (z + 1) * n + i + 1, (z + 1) * n + i);
			label = mem_resize(label, count + 2, sizeof *label);
			label[count] = label[count + 1] = i < wall ? 0 : i < wall + arc_steps ? 1 : 2;
			count += 2;
		}
	for (int z = 0; z < steps; z++) {
		shape_quad(&m, corner + z, z * n, (z + 1) * n, corner + z + 1);
		shape_quad(&m, z * n + n - 1, corner + z, corner + z + 1, (z + 1) * n + n - 1);
		label = mem_resize(label, count + 4, sizeof *label);
		for (int k = 0; k < 2; k++)
			label[count + k] = 3, label[count + 2 + k] = 4;
		count += 4;
	}
	for (int i = 0; i + 1 < n; i++) {
		shape_triangle(&m, corner, i + 1, i);
		shape_triangle(&m, corner + steps, steps * n + i, steps * n + i + 1);
		label = mem_resize(label, count + 2, sizeof *label);
		label[count] = 5, label[count + 1] = 6;
		count += 2;
	}
	*dense = dense_of(&m);
	memcpy(dense->label, label, count * sizeof *label);
	free(label);
	const double middle = 1 - FILLET;
	const struct dense_patch patch[7] = {
		{.kind = PATCH_PLANE, .point = {1, 0, 0}, .axis = {1, 0, 0}},
		{.kind = PATCH_CYLINDER, .point = {middle, middle, 0}, .axis = {0, 0, 1}, .radius = FILLET, .sign = 1},
		{.kind = PATCH_PLANE, .point = {0, 1, 0}, .axis = {0, 1, 0}},
		{.kind = PATCH_PLANE, .point = {0, 0, 0}, .axis = {0, -1, 0}},
		{.kind = PATCH_PLANE, .point = {0, 0, 0}, .axis = {-1, 0, 0}},
		{.kind = PATCH_PLANE, .point = {0, 0, 0}, .axis = {0, 0, -1}},
		{.kind = PATCH_PLANE, .point = {0, 0, 1}, .axis = {0, 0, 1}},
	};
	put_patches(dense, patch, 7);
	return m;
}

/* A number in [0, 1) from a fixed sequence (Knuth's MMIX generator). */
static double next_random(uint64_t *state)
{
	*state = *state * 6364136223846793005u + 1442695040888963407u;
	return (double)(*state >> 11) / 9007199254740992.0;
}

static double area_of(const struct dense *d, size_t t)
{
	double a[3];
	area_vector3(a, d->xyz + 3 * d->triangle[3 * t], d->xyz + 3 * d->triangle[3 * t + 1], d->xyz + 3 * d->triangle[3 * t + 2]);
	return norm3(a) / 2;
}

/* One in twenty of the triangles beside true borders is given to the patch behind the border. At least 95 % of their area
 * must come back; the number of patches stays, and a second run changes less than a thousandth. */
static void flipped_triangles_come_back(void **state)
{
	(void)state;
	for (int free_kind = 0; free_kind < 2; free_kind++) {
		struct dense dense;
		struct half half;
		struct fault fault = {0};
		struct mesh m = filleted(&dense, 48, 12);
		const size_t n = dense.triangle_count;
		idx_t *truth = mem_copy(dense.label, n, sizeof *truth);
		uint64_t seed = 7;
		double wrong = 0, left = 0;
		size_t flipped = 0;
		assert_true(half_build_triangles(&half, dense.triangle, n, dense.vertex_count, &fault));
		if (free_kind) /* the same without surfaces to go by: curvature decides */
			dense.patch[1].kind = PATCH_FREE;
		for (size_t t = 0; t < n; t++)
			for (int k = 0; k < 3; k++) {
				const idx_t other = half.face[half.twin[3 * t + k]];
				if (truth[other] != truth[t] && next_random(&seed) < 0.05) {
					dense.label[t] = truth[other];
					flipped++;
				}
			}
		for (size_t t = 0; t < n; t++)
			wrong += dense.label[t] != truth[t] ? area_of(&dense, t) : 0;
		assert_true(flipped > 5);
		struct rectification_counts counts;
		assert_true(rectification(&dense, &counts, &plain, "fillet", &fault));
		for (size_t t = 0; t < n; t++)
			left += dense.label[t] != truth[t] ? area_of(&dense, t) : 0;
		print_message("# %zu flipped, %.2f %% of the wrong area left\n", flipped, 100 * left / wrong);
		assert_true(left <= 0.05 * wrong);
		assert_int_equal(dense.patch_count, 7);

		idx_t *once = mem_copy(dense.label, n, sizeof *once);
		assert_true(rectification(&dense, &counts, &plain, "fillet", &fault));
		size_t moved = 0;
		for (size_t t = 0; t < n; t++)
			moved += dense.label[t] != once[t];
		assert_true((double)moved < 0.001 * (double)n);
		free(once);
		free(truth);
		half_free(&half);
		dense_free(&dense);
		shape_free(&m);
	}
}

/* Sound labels stay as they are to the last triangle: sharp borders, and smooth ones along the tangent lines. */
static void sound_borders_stay(void **state)
{
	(void)state;
	struct dense dense;
	struct mesh m = filleted(&dense, 12, 6);
	struct fault fault = {0};
	struct rectification_counts counts;
	struct rectification_options track = plain;
	track.track = true;
	idx_t *truth = mem_copy(dense.label, dense.triangle_count, sizeof *truth);
	assert_true(rectification(&dense, &counts, &plain, "fillet", &fault));
	assert_memory_equal(dense.label, truth, dense.triangle_count * sizeof *truth);
	assert_int_equal(counts.changed, 0);
	/* tangent lines are directions of least curvature: tracking finds every one of them correct */
	assert_true(rectification(&dense, &counts, &track, "fillet", &fault));
	assert_int_equal(counts.track.correct, counts.track.border_edges);
	assert_memory_equal(dense.label, truth, dense.triangle_count * sizeof *truth);
	/* area and residual are computed: the fillet's vertices lie on it */
	assert_near(dense.patch[0].area, 1 - FILLET, 1e-12);
	assert_near(dense.patch[1].residual, 0, 1e-12);
	assert_int_equal(dense.patch[1].parent, 1);
	free(truth);
	dense_free(&dense);
	shape_free(&m);
}

/* A border with saw teeth two edges wide is drawn straight again by either method. */
static void teeth_are_cut_off(void **state)
{
	(void)state;
	for (int tracking = 0; tracking < 2; tracking++) {
		struct dense dense;
		struct fault fault = {0};
		struct mesh m = filleted(&dense, 20, 8);
		idx_t *truth = mem_copy(dense.label, dense.triangle_count, sizeof *truth);
		/* the first strip of the fillet, in z from 0.3 to 0.4 and 0.6 to 0.7, is called wall */
		size_t wrong = 0, left = 0;
		for (size_t t = 0; t < dense.triangle_count; t++) {
			double z = 0, y = 0;
			for (int k = 0; k < 3; k++) {
				y += dense.xyz[3 * dense.triangle[3 * t + k] + 1] / 3;
				z += dense.xyz[3 * dense.triangle[3 * t + k] + 2] / 3;
			}
			if (truth[t] == 1 && y < 1 - FILLET + FILLET * sin(PI / 16) && ((z > 0.3 && z < 0.4) || (z > 0.6 && z < 0.7))) {
				dense.label[t] = 0;
				wrong++;
			}
		}
		assert_true(wrong >= 8);
		struct rectification_options options = plain;
		options.track = tracking;
		options.no_smooth = tracking;
		struct rectification_counts counts;
		assert_true(rectification(&dense, &counts, &options, "fillet", &fault));
		for (size_t t = 0; t < dense.triangle_count; t++)
			left += dense.label[t] != truth[t];
		print_message("# %s: %zu wrong, %zu left\n", tracking ? "tracking" : "smoothing", wrong, left);
		assert_int_equal(left, 0);
		free(truth);
		dense_free(&dense);
		shape_free(&m);
	}
}

/* A label in two places becomes two patches of one surface; a speck of it joins what is around. */
static void loose_pieces(void **state)
{
	(void)state;
	struct dense dense;
	struct fault fault = {0};
	struct mesh m = filleted(&dense, 20, 8);
	struct rectification_options options = plain;
	struct rectification_counts counts;
	options.no_smooth = true;
	/* wall 2 gets the name of wall 0: two places; one triangle of the fillet's inside is called wall */
	size_t speck = 0;
	for (size_t t = 0; t < dense.triangle_count; t++) {
		if (dense.label[t] == 2)
			dense.label[t] = 0;
		const double *p = dense.xyz + 3 * dense.triangle[3 * t];
		if (dense.label[t] == 1 && fabs(p[2] - 0.5) < 1e-9 && fabs(p[0] - p[1]) < 1e-9)
			speck = t;
	}
	assert_int_equal(dense.label[speck], 1);
	dense.label[speck] = 0;
	options.tiny_share = 2e-3;
	assert_true(rectification(&dense, &counts, &options, "fillet", &fault));
	assert_int_equal(counts.split, 1);
	assert_int_equal(counts.absorbed, 1);
	assert_int_equal(dense.patch_count, 7);
	/* patch 2 was empty and went: the new one is the last, and belongs to itself */
	assert_int_equal(dense.patch[6].parent, 6);
	assert_int_equal(dense.label[speck], 1);
	dense_free(&dense);
	shape_free(&m);
}

/* A chamfer 0.001 wide between two walls of a box is invisible: it joins a wall, and one of its two sharp edges goes. At
 * a smaller width it stays. */
static void slivers_are_merged(void **state)
{
	(void)state;
	struct mesh m = {0};
	const double c = 0.001;
	const double outline[5][2] = {{0, 0}, {1, 0}, {1, 1 - c}, {1 - c, 1}, {0, 1}};
	for (int z = 0; z < 2; z++)
		for (int i = 0; i < 5; i++)
			shape_vertex(&m, outline[i][0], outline[i][1], z);
	for (int i = 0; i < 5; i++)
		shape_quad(&m, i, (i + 1) % 5, 5 + (i + 1) % 5, 5 + i);
	for (int i = 1; i < 4; i++) {
		shape_triangle(&m, 0, i + 1, i);
		shape_triangle(&m, 5, 5 + i, 6 + i);
	}
	struct fault fault = {0};
	struct rectification_counts counts;
	struct rectification_options options = plain;
	struct dense dense = dense_of(&m);
	assert_int_equal(dense.edge_count, 15);
	struct dense_patch patch[7] = {{0}};
	for (int i = 0; i < 5; i++) {
		const double *a = outline[i], *b = outline[(i + 1) % 5];
		patch[i] = (struct dense_patch){.kind = PATCH_PLANE, .point = {a[0], a[1], 0}, .axis = {b[1] - a[1], a[0] - b[0], 0}};
		normalise3(patch[i].axis);
	}
	patch[5] = (struct dense_patch){.kind = PATCH_PLANE, .axis = {0, 0, -1}};
	patch[6] = (struct dense_patch){.kind = PATCH_PLANE, .point = {0, 0, 1}, .axis = {0, 0, 1}};
	put_patches(&dense, patch, 7);
	for (size_t t = 0; t < 16; t++)
		dense.label[t] = (idx_t)(t < 10 ? t / 2 : t % 2 ? 6 : 5);
	options.sliver = 0.5 * c;
	assert_true(rectification(&dense, &counts, &options, "box", &fault));
	assert_int_equal(counts.slivers, 0);
	assert_int_equal(dense.patch_count, 7);
	options.sliver = 2 * c;
	assert_true(rectification(&dense, &counts, &options, "box", &fault));
	assert_int_equal(counts.slivers, 1);
	assert_int_equal(counts.sliver_edges, 1);
	assert_int_equal(dense.patch_count, 6);
	assert_int_equal(dense.edge_count, 14);
	dense_free(&dense);
	shape_free(&m);
}

/* A chain of four nodes between two terminals is cut at its weakest edge; with equal weights and a tie, at the source's side. */
static void minimum_cut(void **state)
{
	(void)state;
	/* node 0 wants side 0 and node 3 side 1, each by 10 */
	const double cost[8] = {0, 10, 0, 0, 0, 0, 10, 0};
	struct mincut_edge edge[3] = {{0, 1, 3}, {1, 2, 1}, {2, 3, 2}};
	unsigned char side[4];
	assert_true(mincut_solve(side, 4, cost, edge, 3, 100));
	assert_memory_equal(side, "\0\0\1\1", 4);
	/* the cut may not cost more than giving in */
	for (int i = 0; i < 3; i++)
		edge[i].weight = 50;
	const double uneven[8] = {0, 10, 0, 0, 0, 0, 12, 0};
	assert_true(mincut_solve(side, 4, uneven, edge, 3, 100));
	assert_memory_equal(side, "\1\1\1\1", 4);
	/* a grid of 8 x 8 whose left column wants 0 and right column 1; the cheap edges lie on a staircase: 8 of weight 1 */
	double wish[128] = {0};
	struct mincut_edge net[112];
	size_t count = 0;
	for (int i = 0; i < 8; i++) {
		wish[2 * (8 * i) + 1] = 100;
		wish[2 * (8 * i + 7)] = 100;
		for (int j = 0; j < 8; j++) {
			if (j < 7)
				net[count++] = (struct mincut_edge){8 * i + j, 8 * i + j + 1, j == 2 + i / 4 ? 1 : 5};
			if (i < 7)
				net[count++] = (struct mincut_edge){8 * i + j, 8 * i + j + 8, i == 3 && j == 3 ? 0.5 : 5};
		}
	}
	unsigned char grid[64];
	assert_true(mincut_solve(grid, 64, wish, net, count, 100));
	for (int i = 0; i < 8; i++)
		for (int j = 0; j < 8; j++)
			assert_int_equal(grid[8 * i + j], j > 2 + i / 4);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(flipped_triangles_come_back),
		cmocka_unit_test(sound_borders_stay),
		cmocka_unit_test(teeth_are_cut_off),
		cmocka_unit_test(loose_pieces),
		cmocka_unit_test(slivers_are_merged),
		cmocka_unit_test(minimum_cut),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
