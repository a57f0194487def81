/* The sheet that a patch is thinned out on: whatever is removed or swapped, it stays a manifold of the same topology. */
#include "tests/unit/known_shapes.h"

#include <string.h>

#include "stages/fitpatch/sheet.h"
#include "stages/geometry/half.h"

/* A flat grid of wide x high squares of side 1, two triangles each; squares with hole[j * wide + i] are left out. */
static struct mesh flat_grid(int wide, int high, const unsigned char *hole)
{
	struct mesh m = {0};
	for (int j = 0; j <= high; j++)
		for (int i = 0; i <= wide; i++)
			shape_vertex(&m, i, j, 0);
	for (int j = 0; j < high; j++)
		for (int i = 0; i < wide; i++)
			if (!hole || !hole[j * wide + i]) {
				const idx_t a = j * (wide + 1) + i, b = a + wide + 1;
				shape_quad(&m, a, a + 1, b + 1, b);
			}
	return m;
}

/* The sheet of some triangles of a mesh; NULL: of all. */
static struct sheet sheet_of(const struct mesh *m, const idx_t *list, size_t count)
{
	struct half half;
	struct fault fault = {0};
	assert_true(half_build_triangles(&half, m->corner, m->face_count, m->vertex_count, &fault));
	idx_t *all = mem_array(m->face_count, sizeof *all), *from;
	for (size_t t = 0; t < m->face_count; t++)
		all[t] = (idx_t)t;
	struct sheet sheet;
	sheet_build(&sheet, &from, list ? list : all, list ? count : m->face_count, m->corner, half.twin, m->xyz);
	for (size_t v = 0; v < sheet.vertex_count; v++)
		assert_near(distance3(&sheet.xyz[3 * v], &m->xyz[3 * (size_t)from[v]]), 0, 0);
	free(all), free(from);
	half_free(&half);
	return sheet;
}

static double area_of(const struct sheet *sheet, size_t t)
{
	double area[3];
	const idx_t *v = &sheet->origin[3 * t];
	area_vector3(area, &sheet->xyz[3 * (size_t)v[0]], &sheet->xyz[3 * (size_t)v[1]], &sheet->xyz[3 * (size_t)v[2]]);
	return area[2] / 2;
}

struct counted {
	long euler;
	size_t vertices, triangles, border;
	double area;
};

/* All that must hold of a flat sheet; euler and area are returned to be compared. */
static struct counted check_sheet(const struct sheet *sheet)
{
	struct counted c = {0};
	unsigned char *used = mem_array(sheet->vertex_count, 1), *borders = mem_array(sheet->vertex_count, 1);
	size_t edges = 0;
	for (size_t t = 0; t < sheet->triangle_count; t++) {
		const bool dead = sheet->origin[3 * t] == NO_INDEX;
		assert_true(dead == (sheet->origin[3 * t + 1] == NO_INDEX) && dead == (sheet->origin[3 * t + 2] == NO_INDEX));
		if (dead)
			continue;
		c.triangles++;
		c.area += area_of(sheet, t);
		assert_true(area_of(sheet, t) > 0);
		for (idx_t h = 3 * (idx_t)t; h < 3 * (idx_t)t + 3; h++) {
			const idx_t g = sheet->twin[h];
			used[sheet->origin[h]] = 1;
			if (g == NO_INDEX) {
				c.border++, edges++;
				borders[sheet->origin[h]]++;
				continue;
			}
			assert_int_equal(sheet->twin[g], h);
			assert_true(sheet->origin[g] == sheet_target(sheet, h) && sheet->origin[h] == sheet_target(sheet, g));
			edges += g > h;
		}
	}
	for (size_t v = 0; v < sheet->vertex_count; v++) {
		const idx_t h = sheet->outgoing[v];
		assert_int_equal(h != NO_INDEX, used[v]);
		if (h == NO_INDEX)
			continue;
		c.vertices++;
		assert_int_equal(sheet->origin[h], v);
		assert_true(borders[v] <= 1); /* one fan */
		assert_int_equal(sheet_on_border(sheet, (idx_t)v), borders[v]);
		/* The ring meets every neighbour once, and an edge leads there. */
		idx_t ring[64];
		const size_t n = sheet_ring(sheet, (idx_t)v, ring, 64);
		assert_true(n >= 2 && n <= 64);
		for (size_t i = 0; i < n; i++) {
			const idx_t e = sheet_edge(sheet, (idx_t)v, ring[i]);
			assert_true(e != NO_INDEX);
			assert_true((sheet->origin[e] == (idx_t)v && sheet_target(sheet, e) == ring[i]) || (sheet->origin[e] == ring[i] && sheet_target(sheet, e) == (idx_t)v));
			for (size_t k = 0; k < i; k++)
				assert_int_not_equal(ring[i], ring[k]);
		}
	}
	c.euler = (long)c.vertices - (long)edges + (long)c.triangles;
	free(used), free(borders);
	return c;
}

/* Short edges; triangles that are not turned over. */
static double edge_length(void *context, idx_t a, idx_t b)
{
	const struct sheet *sheet = context;
	return distance3(&sheet->xyz[3 * (size_t)a], &sheet->xyz[3 * (size_t)b]);
}
static double upward(void *context, idx_t a, idx_t b, idx_t c)
{
	const struct sheet *sheet = context;
	double area[3];
	area_vector3(area, &sheet->xyz[3 * (size_t)a], &sheet->xyz[3 * (size_t)b], &sheet->xyz[3 * (size_t)c]);
	return area[2] > 1e-9 ? 0 : INFINITY;
}

/* Any order of edges will do for swaps. */
static double hashed(void *context, idx_t a, idx_t b)
{
	(void)context;
	return (double)(((uint32_t)(a < b ? a : b) * 2654435761u ^ (uint32_t)(a < b ? b : a) * 40503u) >> 12);
}

/* A fixed sequence of numbers. */
static uint32_t draw(uint32_t *state)
{
	*state = *state * 1664525u + 1013904223u;
	return *state >> 8;
}

static void test_build(void **state)
{
	(void)state;
	struct mesh m = flat_grid(5, 4, NULL);
	struct sheet sheet = sheet_of(&m, NULL, 0);
	struct counted c = check_sheet(&sheet);
	assert_int_equal(c.vertices, 30);
	assert_int_equal(c.triangles, 40);
	assert_int_equal(c.border, 18);
	assert_int_equal(c.euler, 1); /* a disc */
	assert_near(c.area, 20, 1e-12);
	for (size_t h = 0; h < 3 * sheet.triangle_count; h++)
		assert_int_equal(sheet.segment[h], h); /* all triangles, in order */
	for (size_t v = 0; v < sheet.vertex_count; v++)
		assert_int_equal(sheet.point[v], NO_INDEX);
	sheet_free(&sheet);

	/* Part of it: an edge to a triangle outside is border, and knows its dense half-edge. */
	const idx_t some[3] = {7, 0, 1};
	sheet = sheet_of(&m, some, 3);
	c = check_sheet(&sheet);
	assert_int_equal(c.triangles, 3);
	for (size_t h = 0; h < 9; h++)
		assert_int_equal(sheet.segment[h], 3 * some[h / 3] + (idx_t)(h % 3));
	sheet_free(&sheet);
	shape_free(&m);
}

/* Two triangles that meet in a vertex only: each gets a copy of it. */
static void test_pinched(void **state)
{
	(void)state;
	struct mesh m = {0};
	const double p[5][2] = {{0, 0}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}};
	for (int i = 0; i < 5; i++)
		shape_vertex(&m, p[i][0], p[i][1], 0);
	for (int i = 0; i < 4; i++)
		shape_triangle(&m, 0, 1 + i, 1 + (i + 1) % 4);
	const idx_t opposite[2] = {0, 2}, three[3] = {0, 1, 2};
	struct sheet sheet = sheet_of(&m, opposite, 2);
	struct counted c = check_sheet(&sheet);
	assert_int_equal(c.vertices, 6);
	assert_int_equal(c.border, 6);
	assert_int_equal(c.euler, 2); /* two discs */
	sheet_free(&sheet);
	/* three in a row are one fan */
	sheet = sheet_of(&m, three, 3);
	c = check_sheet(&sheet);
	assert_int_equal(c.vertices, 5);
	assert_int_equal(c.euler, 1);
	sheet_free(&sheet);
	shape_free(&m);
}

/* Every border half-edge of a sheet with a hole, split at its middle and again. */
static void test_split_border(void **state)
{
	(void)state;
	const unsigned char hole[9] = {0, 0, 0, 0, 1, 0, 0, 0, 0};
	struct mesh m = flat_grid(3, 3, hole);
	struct sheet sheet = sheet_of(&m, NULL, 0);
	const struct counted before = check_sheet(&sheet);
	assert_int_equal(before.euler, 0); /* a ring */
	assert_int_equal(before.border, 16);
	unsigned char *done = mem_array(3 * sheet.triangle_count, 1); /* a dense half-edge */
	size_t splits = 0;
	for (size_t h = 0; h < 3 * sheet.triangle_count; h++) { /* the other border side of an ear moves to a new triangle */
		if (sheet.twin[h] != NO_INDEX || done[sheet.segment[h]])
			continue;
		const idx_t a = sheet.origin[h], segment = sheet.segment[h];
		done[segment] = 1;
		double middle[3];
		for (int part = 0; part < 2; part++) {
			const idx_t b = sheet_target(&sheet, (idx_t)h);
			for (int k = 0; k < 3; k++)
				middle[k] = (sheet.xyz[3 * (size_t)a + (size_t)k] + sheet.xyz[3 * (size_t)b + (size_t)k]) / 2;
			const idx_t q = sheet_split_border(&sheet, (idx_t)h, middle);
			splits++;
			assert_int_equal(q, sheet.vertex_count - 1);
			assert_near(distance3(&sheet.xyz[3 * (size_t)q], middle), 0, 0);
			assert_int_equal(sheet.point[q], NO_INDEX);
			assert_int_equal(sheet.origin[h], a);
			assert_int_equal(sheet_target(&sheet, (idx_t)h), q);
			assert_int_equal(sheet_target(&sheet, sheet.outgoing[q]), b);
			assert_int_equal(sheet.segment[h], segment);
			assert_int_equal(sheet.segment[sheet.outgoing[q]], segment);
			assert_true(sheet_on_border(&sheet, q));
		}
	}
	free(done);
	const struct counted after = check_sheet(&sheet);
	assert_int_equal(splits, 32);
	assert_int_equal(after.border, before.border + splits);
	assert_int_equal(after.vertices, before.vertices + splits);
	assert_int_equal(after.euler, before.euler);
	assert_near(after.area, before.area, 1e-12);
	sheet_free(&sheet);
	shape_free(&m);
}

static idx_t vertex_at(const struct sheet *sheet, double x, double y)
{
	for (size_t v = 0; v < sheet->vertex_count; v++)
		if (sheet->xyz[3 * v] == x && sheet->xyz[3 * v + 1] == y)
			return (idx_t)v;
	fail_msg("no vertex at %g %g", x, y);
	return NO_INDEX;
}

static void test_remove_interior(void **state)
{
	(void)state;
	struct mesh m = flat_grid(2, 2, NULL);
	struct sheet sheet = sheet_of(&m, NULL, 0);
	const struct sheet_cost cost = {edge_length, upward, &sheet};
	double height = -1;
	/* The middle vertex: its hole is a hexagon (the triangulation's diagonals run one way); a price without doing it changes nothing. */
	const double price = sheet_remove(&sheet, vertex_at(&sheet, 1, 1), &cost, &height, false);
	assert_true(isfinite(price));
	assert_near(height, 0, 1e-12); /* flat */
	assert_int_equal(check_sheet(&sheet).vertices, 9);
	assert_near(sheet_remove(&sheet, vertex_at(&sheet, 1, 1), &cost, NULL, true), price, 0);
	const struct counted c = check_sheet(&sheet);
	assert_int_equal(c.vertices, 8);
	assert_int_equal(c.triangles, 6);
	assert_int_equal(c.euler, 1);
	assert_near(c.area, 4, 1e-12);
	sheet_free(&sheet);
	shape_free(&m);
}

/* The apex of a pyramid is as far from its base as it is high; the plan takes the shorter diagonal of the base. */
static void test_height(void **state)
{
	(void)state;
	struct mesh m = {0};
	const double p[5][3] = {{-2, 0, 0}, {0, -1, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 0.7}};
	for (int i = 0; i < 5; i++)
		shape_vertex(&m, p[i][0], p[i][1], p[i][2]);
	for (int i = 0; i < 4; i++)
		shape_triangle(&m, i, (i + 1) % 4, 4);
	struct sheet sheet = sheet_of(&m, NULL, 0);
	idx_t apex = NO_INDEX;
	for (size_t v = 0; v < 5; v++)
		if (sheet.xyz[3 * v + 2] > 0)
			apex = (idx_t)v;
	const struct sheet_cost cost = {edge_length, upward, &sheet};
	double height;
	assert_near(sheet_remove(&sheet, apex, &cost, &height, true), 2, 1e-12);
	assert_near(height, 0.7, 1e-12);
	const struct counted c = check_sheet(&sheet);
	assert_int_equal(c.triangles, 2);
	assert_near(c.area, 4, 1e-12);
	sheet_free(&sheet);
	shape_free(&m);
}

static void test_remove_border(void **state)
{
	(void)state;
	struct mesh m = flat_grid(2, 2, NULL);
	struct sheet sheet = sheet_of(&m, NULL, 0);
	const struct sheet_cost cost = {edge_length, upward, &sheet};
	/* In the middle of a straight side nothing is lost. */
	assert_true(isfinite(sheet_remove(&sheet, vertex_at(&sheet, 1, 0), &cost, NULL, true)));
	struct counted c = check_sheet(&sheet);
	assert_int_equal(c.vertices, 8);
	assert_int_equal(c.border, 7);
	assert_int_equal(c.euler, 1);
	assert_near(c.area, 4, 1e-12);
	sheet_free(&sheet);
	/* A corner of one triangle (diagonals run up to the right) goes with it; one of two loses what its new side cuts off. */
	sheet = sheet_of(&m, NULL, 0);
	assert_near(sheet_remove(&sheet, vertex_at(&sheet, 2, 0), &cost, NULL, true), 0, 0);
	c = check_sheet(&sheet);
	assert_int_equal(c.vertices, 8);
	assert_int_equal(c.border, 8 - 2 + 1);
	assert_int_equal(c.euler, 1);
	assert_near(c.area, 3.5, 1e-12);
	/* (1 0) (1 1) (0 1) are its neighbours: one triangle fills the hole, upside up. */
	assert_true(isfinite(sheet_remove(&sheet, vertex_at(&sheet, 0, 0), &cost, NULL, true)));
	c = check_sheet(&sheet);
	assert_int_equal(c.vertices, 7);
	assert_near(c.area, 3, 1e-12);
	sheet_free(&sheet);
	shape_free(&m);
}

/* The last triangle cannot go, and neither can a vertex whose removal would double an edge. */
static void test_refusals(void **state)
{
	(void)state;
	struct mesh m = {0};
	const double p[4][2] = {{0, 0}, {4, 0}, {2, 4}, {2, 1}};
	for (int i = 0; i < 4; i++)
		shape_vertex(&m, p[i][0], p[i][1], 0);
	const idx_t one[1] = {0};
	shape_triangle(&m, 0, 1, 3), shape_triangle(&m, 1, 2, 3), shape_triangle(&m, 2, 0, 3);
	struct sheet sheet = sheet_of(&m, one, 1);
	struct sheet_cost cost = {edge_length, upward, &sheet};
	for (idx_t v = 0; v < 3; v++)
		assert_true(isinf(sheet_remove(&sheet, v, &cost, NULL, true)));
	assert_int_equal(check_sheet(&sheet).triangles, 1);
	sheet_free(&sheet);
	/* Three around one: a corner's hole would close along the edge between the other two, which is there. */
	sheet = sheet_of(&m, NULL, 0);
	cost.context = &sheet;
	for (size_t v = 0; v < 4; v++)
		if (sheet_on_border(&sheet, (idx_t)v))
			assert_true(isinf(sheet_remove(&sheet, (idx_t)v, &cost, NULL, true)));
	assert_int_equal(check_sheet(&sheet).triangles, 3);
	/* No swap: the other diagonal of any inner edge is an edge already. */
	for (idx_t h = 0; h < 9; h++)
		assert_false(sheet_swap(&sheet, h, &cost));
	sheet_free(&sheet);
	shape_free(&m);
}

/* A vertex with more neighbours than SHEET_RING_LIMIT waits. */
static void test_ring_limit(void **state)
{
	(void)state;
	enum { AROUND = SHEET_RING_LIMIT + 10 };
	struct mesh m = {0};
	shape_vertex(&m, 0, 0, 0);
	for (int i = 0; i < AROUND; i++)
		shape_vertex(&m, cos(2 * PI * i / AROUND), sin(2 * PI * i / AROUND), 0);
	for (int i = 0; i < AROUND; i++)
		shape_triangle(&m, 0, 1 + i, 1 + (i + 1) % AROUND);
	struct sheet sheet = sheet_of(&m, NULL, 0);
	const struct sheet_cost cost = {edge_length, upward, &sheet};
	idx_t centre = NO_INDEX, ring[4];
	for (size_t v = 0; v < sheet.vertex_count; v++)
		if (!sheet_on_border(&sheet, (idx_t)v))
			centre = (idx_t)v;
	assert_int_equal(sheet_ring(&sheet, centre, ring, 4), AROUND); /* says how many, writes no more than there is room for */
	assert_true(isinf(sheet_remove(&sheet, centre, &cost, NULL, true)));
	/* Vertices of the rim go until the ring is small enough. */
	for (size_t v = 0; v < sheet.vertex_count; v += 2)
		if ((idx_t)v != centre)
			assert_true(isfinite(sheet_remove(&sheet, (idx_t)v, &cost, NULL, true)));
	assert_true(isfinite(sheet_remove(&sheet, centre, &cost, NULL, true)));
	assert_int_equal(check_sheet(&sheet).euler, 1);
	sheet_free(&sheet);
	shape_free(&m);
}

static void test_swap(void **state)
{
	(void)state;
	struct mesh m = {0};
	const double p[4][2] = {{0, 0}, {4, 0}, {4, 1}, {0, 1}};
	for (int i = 0; i < 4; i++)
		shape_vertex(&m, p[i][0], p[i][1] + (i == 2 ? 2 : 0), 0);
	shape_quad(&m, 0, 1, 2, 3); /* the diagonal 0 2 is the longer one */
	struct sheet sheet = sheet_of(&m, NULL, 0);
	const struct sheet_cost cost = {edge_length, upward, &sheet};
	size_t swaps = 0;
	for (idx_t h = 0; h < 6; h++)
		swaps += sheet_swap(&sheet, h, &cost);
	assert_int_equal(swaps, 1); /* and not back again */
	const struct counted c = check_sheet(&sheet);
	assert_int_equal(c.border, 4);
	assert_near(c.area, 8, 1e-12);
	/* Border half-edges took what is said of them along. */
	for (idx_t h = 0; h < 6; h++)
		if (sheet.twin[h] == NO_INDEX) {
			const idx_t dense = sheet.segment[h];
			assert_near(distance3(&sheet.xyz[3 * (size_t)sheet.origin[h]], &m.xyz[3 * (size_t)m.corner[dense]]), 0, 0);
		}
	sheet_free(&sheet);
	shape_free(&m);
}

/* Random removals and swaps on a grid with two holes: the topology, the area within the border and all invariants stay. */
static void test_random(void **state)
{
	(void)state;
	unsigned char hole[80] = {0};
	hole[22] = hole[23] = hole[56] = 1;
	for (uint32_t seed = 1; seed <= 12; seed++) {
		struct mesh m = flat_grid(10, 8, hole);
		uint32_t random = seed;
		/* no two edges alike, the border where it was */
		for (size_t v = 0; v < m.vertex_count; v++)
			for (int k = 0; k < 2; k++)
				m.xyz[3 * v + (size_t)k] += 0.2 * (draw(&random) / 16777216.0 - 0.5);
		struct sheet sheet = sheet_of(&m, NULL, 0);
		const struct sheet_cost cost = {edge_length, upward, &sheet};
		const struct sheet_cost any_order = {hashed, upward, &sheet};
		struct counted before = check_sheet(&sheet);
		assert_int_equal(before.euler, -1); /* a disc less two holes */
		size_t removed = 0, swapped = 0;
		for (int step = 0; step < 2000; step++) {
			if (draw(&random) % 8 != 0) {
				const idx_t h = (idx_t)(draw(&random) % (3 * sheet.triangle_count));
				if (sheet.origin[h] != NO_INDEX)
					swapped += sheet_swap(&sheet, h, &any_order);
			} else {
				const idx_t v = (idx_t)(draw(&random) % sheet.vertex_count);
				if (sheet.outgoing[v] == NO_INDEX)
					continue;
				const bool inside = !sheet_on_border(&sheet, v);
				const bool gone = isfinite(sheet_remove(&sheet, v, &cost, NULL, true));
				removed += gone;
				assert_int_equal(sheet.outgoing[v] == NO_INDEX, gone);
				if (step % 50 == 0 || !inside) {
					const struct counted after = check_sheet(&sheet);
					assert_int_equal(after.euler, before.euler);
					if (inside)
						assert_near(after.area, before.area, 1e-9);
					before = after;
				}
			}
		}
		assert_true(removed > 60 && swapped > 40);
		assert_int_equal(check_sheet(&sheet).euler, -1);
		sheet_free(&sheet);
		shape_free(&m);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_build),    cmocka_unit_test(test_pinched),       cmocka_unit_test(test_split_border), cmocka_unit_test(test_remove_interior),
		cmocka_unit_test(test_height),   cmocka_unit_test(test_remove_border), cmocka_unit_test(test_refusals),     cmocka_unit_test(test_ring_limit),
		cmocka_unit_test(test_swap),     cmocka_unit_test(test_random),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
