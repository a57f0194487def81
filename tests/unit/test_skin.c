/* The refined surface of a cage: nearest points against looking at every triangle, parts against the whole, columns against moved vertices. */
#include "tests/unit/polish_rig.h"

#include "stages/geometry/nearest.h"
#include "stages/geometry/vector.h"
#include "stages/polish/skin.h"

static uint32_t lot(uint32_t *seed) { return (*seed = *seed * 1664525u + 1013904223u) >> 8; }
static double lot_between(uint32_t *seed, double low, double high) { return low + (high - low) * lot(seed) / 16777216.0; }

static void build_all(struct skin *skin, const struct sketch *s, int steps)
{
	idx_t *all = mem_array(s->face_count, sizeof *all);
	for (size_t f = 0; f < s->face_count; f++)
		all[f] = (idx_t)f;
	skin_build(skin, s, all, s->face_count, steps);
	free(all);
}

/* Shapes with quads, triangles and larger faces, smooth and creased, closed and open, few faces and many. */
enum { SHAPES = 5 };
static struct sketch shape(int which)
{
	double house[27];
	for (int i = 0; i < 27; i++)
		house[i] = house_xyz[i] / 3.5 - 0.4;
	switch (which) {
	case 0: return rig_quads(10, 8, true);
	case 1: return rig_prism(7);
	case 2: return rig_make(house, 9, house_faces, (const int[]){4, 5, 5, 6, 6, 7, 4, 7, -1, -1});
	case 3: return rig_quads(3, 2, false);
	default: return rig_cube(true);
	}
}

static size_t fine_count(const struct skin *skin) { return skin->first[skin->root_count] << (2 * (skin->steps - 1)); }

/* Least measure over all triangles of all faces that may answer. */
static double brute(const struct skin *skin, const double p[3], const double normal[3])
{
	const struct level *fine = &skin->fine;
	double best = INFINITY;
	for (size_t f = 0; f < fine_count(skin); f++) {
		const idx_t *c = &fine->face_corner[fine->face_start[f]];
		const size_t degree = fine->face_start[f + 1] - fine->face_start[f];
		const double *v[4], penalty = dot3((const double[]){skin->normal[f][0], skin->normal[f][1], skin->normal[f][2]}, normal) < -0.2 ? SKIN_PENALTY : 0;
		for (size_t i = 0; i < degree; i++)
			v[i] = &fine->xyz[3 * (size_t)c[i]];
		for (size_t i = 1; i + 1 < degree; i++) {
			double point[3], weight[3];
			best = fmin(best, penalty + nearest_on_triangle(point, weight, p, v[0], v[i], v[i + 1]));
		}
	}
	return best;
}

static void check_foot(const struct skin_foot *foot, const struct skin *skin, const double p[3])
{
	assert_in_range(foot->fine, 0, fine_count(skin) - 1);
	assert_int_equal(skin->fine.face_origin[foot->fine], foot->root);
	assert_in_range(foot->root, 0, skin->root_count - 1);
	double sum = 0;
	for (int i = 0; i < 3; i++) {
		assert_true(foot->weight[i] >= 0);
		sum += foot->weight[i];
	}
	assert_near(sum, 1, 1e-12);
	for (int k = 0; k < 3; k++) {
		double x = 0;
		for (int i = 0; i < 3; i++)
			x += foot->weight[i] * skin->fine.xyz[3 * (size_t)foot->corner[i] + k];
		assert_near(foot->point[k], x, 1e-9);
	}
	assert_near(foot->distance, distance3(p, foot->point), 1e-9);
	assert_near(foot->measure, foot->distance + (foot->is_turned ? SKIN_PENALTY : 0), 1e-15);
}

/* Far points, near ones and such on the surface; the order of the roots may be that of a box around many points, and the first guess any
 * face. */
static void test_nearest(void **state)
{
	(void)state;
	uint32_t seed = 5;
	for (int which = 0; which < SHAPES; which++)
		for (int steps = 2; steps <= 3; steps++) {
			struct sketch s = shape(which);
			struct skin skin;
			build_all(&skin, &s, steps);
			assert_int_equal(skin.fine.face_count, fine_count(&skin));
			struct skin_order tight = {0}, wide = {0};
			const float everywhere[6] = {-1, -1, -1, 1, 1, 1};
			skin_order(&wide, &skin, everywhere);
			for (int i = 0; i < 60; i++) {
				double p[3], normal[3];
				const size_t v = lot(&seed) % skin.fine.vertex_count;
				const double off = i % 3 == 0 ? 0 : i % 3 == 1 ? 0.02 : 0.5;
				for (int k = 0; k < 3; k++) {
					p[k] = skin.fine.xyz[3 * v + k] + lot_between(&seed, -off, off);
					normal[k] = lot_between(&seed, -1, 1);
				}
				normalise3(normal);
				const float box[6] = {(float)p[0], (float)p[1], (float)p[2], (float)p[0], (float)p[1], (float)p[2]};
				skin_order(&tight, &skin, box);
				const struct skin_foot foot = skin_nearest(&skin, &tight, p, normal, NO_INDEX);
				check_foot(&foot, &skin, p);
				assert_near(foot.measure, brute(&skin, p, normal), 1e-7);
				const idx_t hint = (idx_t)(lot(&seed) % fine_count(&skin));
				const struct skin_foot hinted = skin_nearest(&skin, &tight, p, normal, hint), far = skin_nearest(&skin, &wide, p, normal, hint),
				                       again = skin_nearest(&skin, &wide, p, normal, NO_INDEX);
				check_foot(&hinted, &skin, p), check_foot(&far, &skin, p);
				assert_near(hinted.measure, foot.measure, 1e-7);
				assert_near(far.measure, foot.measure, 1e-7);
				assert_near(again.measure, foot.measure, 1e-7);
			}
			skin_order_free(&tight), skin_order_free(&wide);
			skin_free(&skin);
			sketch_free(&s);
		}
}

/* A slab: a point on its top that looks down belongs to the bottom when that is nearer than the penalty, else it stays, turned. */
static void test_turned(void **state)
{
	(void)state;
	for (int is_thick = 0; is_thick < 2; is_thick++) {
		const double thickness = is_thick ? 4 * SKIN_PENALTY : SKIN_PENALTY / 4;
		struct sketch s = rig_cube(true);
		for (size_t v = 0; v < 8; v++)
			s.xyz[3 * v + 2] *= thickness;
		struct skin skin;
		build_all(&skin, &s, 3);
		struct skin_order order = {0};
		const double p[3] = {0.1, -0.07, thickness / 2}, up[3] = {0, 0, 1}, down[3] = {0, 0, -1};
		skin_order(&order, &skin, (const float[6]){-1, -1, -1, 1, 1, 1});
		struct skin_foot foot = skin_nearest(&skin, &order, p, up, NO_INDEX);
		assert_near(foot.measure, 0, 1e-9);
		assert_false(foot.is_turned);
		foot = skin_nearest(&skin, &order, p, down, NO_INDEX);
		assert_int_equal(foot.is_turned, is_thick);
		assert_near(foot.distance, is_thick ? 0 : thickness, 1e-9);
		assert_near(foot.measure, is_thick ? SKIN_PENALTY : thickness, 1e-9);
		skin_order_free(&order);
		skin_free(&skin);
		sketch_free(&s);
	}
}

/* Some faces alone look as they do in the whole, also when the rings around them touch each other in single vertices. */
static void test_part(void **state)
{
	(void)state;
	uint32_t seed = 12;
	for (int i = 0; i < 4 * SHAPES; i++) {
		struct sketch s = shape(i % SHAPES);
		struct skin whole, part;
		const int steps = 2 + i / SHAPES % 2;
		build_all(&whole, &s, steps);
		idx_t face[12];
		size_t count = 0;
		for (size_t f = 0; f < s.face_count && count < 12; f++)
			if (lot(&seed) % (1 + s.face_count / 4) == 0)
				face[count++] = (idx_t)f;
		if (count == 0)
			face[count++] = 1;
		skin_build(&part, &s, face, count, steps);
		assert_int_equal(part.root_count, count);
		for (size_t r = 0; r < count; r++) {
			assert_int_equal(part.face[r], face[r]);
			const size_t a = part.first[r] << (2 * (steps - 1)), b = whole.first[face[r]] << (2 * (steps - 1));
			const size_t faces = (part.first[r + 1] - part.first[r]) << (2 * (steps - 1));
			for (size_t f = 0; f < faces; f++)
				for (size_t c = 0; c < part.fine.face_start[a + f + 1] - part.fine.face_start[a + f]; c++) {
					const idx_t v = part.fine.face_corner[part.fine.face_start[a + f] + c], w = whole.fine.face_corner[whole.fine.face_start[b + f] + c];
					for (int k = 0; k < 3; k++)
						assert_near(part.fine.xyz[3 * (size_t)v + k], whole.fine.xyz[3 * (size_t)w + k], 1e-13);
				}
		}
		skin_free(&whole), skin_free(&part);
		sketch_free(&s);
	}
}

/* Subdivision is linear: a column is what the surface does when a vertex moves by 1, and all columns together are 1 everywhere. */
static void test_columns(void **state)
{
	(void)state;
	for (int which = 0; which < SHAPES; which++) {
		struct sketch s = shape(which);
		struct skin skin;
		build_all(&skin, &s, which % 2 ? 2 : 3);
		const size_t n = skin.fine.vertex_count;
		const idx_t some[4] = {5, 0, 3, 2};
		double *column = mem_array(4 * n, sizeof *column);
		skin_columns(column, &skin, some, 4);
		for (size_t i = 0; i < 4; i++) {
			double *before = mem_copy(skin.fine.xyz, 3 * n, sizeof *before);
			const size_t axis = i % 3;
			s.xyz[3 * (size_t)some[i] + axis] += 1;
			skin_move(&skin, &s);
			assert_int_equal(skin.fine.vertex_count, n);
			for (size_t v = 0; v < 3 * n; v++)
				assert_near(skin.fine.xyz[v] - before[v], v % 3 == axis ? column[4 * (v / 3) + i] : 0, 1e-12);
			s.xyz[3 * (size_t)some[i] + axis] -= 1;
			skin_move(&skin, &s);
			free(before);
		}
		free(column);
		idx_t *all = mem_array(s.vertex_count, sizeof *all);
		for (size_t v = 0; v < s.vertex_count; v++)
			all[v] = (idx_t)v;
		column = mem_array(s.vertex_count * n, sizeof *column);
		skin_columns(column, &skin, all, s.vertex_count);
		for (size_t v = 0; v < n; v++) {
			double sum = 0;
			for (size_t i = 0; i < s.vertex_count; i++)
				sum += column[v * s.vertex_count + i];
			assert_near(sum, 1, 1e-12);
		}
		free(column), free(all);
		skin_free(&skin);
		sketch_free(&s);
	}
}

/* Moved vertices: boxes and normals follow. */
static void test_move(void **state)
{
	(void)state;
	struct sketch s = shape(0);
	struct skin moved, fresh;
	build_all(&moved, &s, 3);
	for (size_t v = 0; v < s.vertex_count; v++)
		s.xyz[3 * v] *= 1.5, s.xyz[3 * v + 2] += 0.3 * s.xyz[3 * v + 1];
	skin_move(&moved, &s);
	build_all(&fresh, &s, 3);
	assert_memory_equal(moved.fine.xyz, fresh.fine.xyz, 3 * fresh.fine.vertex_count * sizeof(double));
	assert_memory_equal(moved.normal, fresh.normal, fresh.fine.face_count * sizeof *fresh.normal);
	assert_memory_equal(moved.root_box, fresh.root_box, 6 * fresh.root_count * sizeof *fresh.root_box);
	skin_free(&moved), skin_free(&fresh);
	sketch_free(&s);
}

/* Each edge as its two faces see it: the same three vertices, in reverse. With two steps the middle alone is known. */
static void test_side(void **state)
{
	(void)state;
	for (int which = 0; which < SHAPES; which++)
		for (int steps = 2; steps <= 3; steps++) {
			struct sketch s = shape(which);
			struct skin skin;
			build_all(&skin, &s, steps);
			for (size_t h = 0; h < s.face_start[s.face_count]; h++) {
				const idx_t f = s.face[h], t = s.twin[h];
				idx_t side[3], other[3];
				skin_side(side, &skin, (size_t)f, h - s.face_start[f], sketch_degree(&s, f));
				assert_int_equal(side[0] == side[1], steps == 2);
				assert_int_equal(side[2] == side[1], steps == 2);
				if (t != NO_INDEX) {
					skin_side(other, &skin, (size_t)s.face[t], (size_t)t - s.face_start[s.face[t]], sketch_degree(&s, s.face[t]));
					for (int i = 0; i < 3; i++)
						assert_int_equal(side[i], other[2 - i]);
				}
				/* The edges of a cube are creases between corners: straight, and its vertices stay evenly spaced. */
				const double *a = &s.xyz[3 * (size_t)s.face_corner[h]], *b = &s.xyz[3 * (size_t)sketch_head(&s, (idx_t)h)];
				for (int i = 0; which == 4 && i < 3; i++)
					for (int k = 0; k < 3; k++) {
						const double share = steps == 3 ? 0.25 * (i + 1) : 0.5;
						assert_near(skin.fine.xyz[3 * (size_t)side[i] + k], a[k] + share * (b[k] - a[k]), 1e-13);
					}
			}
			skin_free(&skin);
			sketch_free(&s);
		}
}

/* Spots share out the area of the surface, look outwards, and tell what is folded. */
static void test_spots(void **state)
{
	(void)state;
	for (int which = 0; which < SHAPES; which++) {
		struct sketch s = shape(which);
		struct skin skin;
		build_all(&skin, &s, 3);
		double area = 0, fine_area = 0;
		for (size_t r = 0; r < skin.root_count; r++)
			for (size_t i = 0; i < skin_spot_count(&skin, r); i++) {
				struct skin_spot spot;
				skin_spot(&spot, &skin, r, i);
				area += spot.area;
				assert_near(norm3(spot.normal), 1, 1e-12);
				assert_near(spot.folded, 0, 0);
				for (int k = 0; k < 3; k++) {
					double x = 0;
					for (int c = 0; c < 3; c++)
						x += spot.weight[c] * skin.fine.xyz[3 * (size_t)spot.corner[c] + k];
					assert_near(spot.point[k], x, 1e-13);
				}
				if (which == 4) { /* on a face of the cube, looking out of it */
					double along = 0;
					for (int k = 0; k < 3; k++)
						along += spot.normal[k] * spot.point[k];
					assert_near(along, 0.5, 1e-12);
				}
			}
		for (size_t f = 0; f < fine_count(&skin); f++) {
			const idx_t *c = &skin.fine.face_corner[skin.fine.face_start[f]];
			for (size_t i = 1; i + 1 < skin.fine.face_start[f + 1] - skin.fine.face_start[f]; i++) {
				double n[3];
				area_vector3(n, &skin.fine.xyz[3 * (size_t)c[0]], &skin.fine.xyz[3 * (size_t)c[i]], &skin.fine.xyz[3 * (size_t)c[i + 1]]);
				fine_area += norm3(n) / 2;
			}
		}
		assert_near(area, fine_area, 1e-12);
		if (which == 4)
			assert_near(area, 6, 1e-12);
		skin_free(&skin);
		sketch_free(&s);
	}
	/* The middle of a square sheet pulled over its rim folds it. */
	struct sketch s = rig_quads(2, 2, false);
	s.xyz[3 * 4] = 3;
	struct skin skin;
	build_all(&skin, &s, 3);
	double folded = 0;
	for (size_t r = 0; r < skin.root_count; r++)
		for (size_t i = 0; i < skin_spot_count(&skin, r); i++) {
			struct skin_spot spot;
			skin_spot(&spot, &skin, r, i);
			folded += spot.folded;
			assert_true(spot.folded <= spot.area);
		}
	assert_true(folded > 0);
	skin_free(&skin);
	sketch_free(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_nearest), cmocka_unit_test(test_turned), cmocka_unit_test(test_part),  cmocka_unit_test(test_columns),
		cmocka_unit_test(test_move),    cmocka_unit_test(test_side),   cmocka_unit_test(test_spots),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
