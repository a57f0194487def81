/* Hand-made local cages welded into known polyhedra (the patch method's section 6.4). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/assemble/tidy.h"
#include "stages/assemble/weld.h"

#define ROOM 400

/* Faces are given by network points; every face gets local vertices of its own, as if it were a patch's. */
struct made {
	struct cage cage;
	struct network network;
	double xyz[3 * ROOM], local_xyz[3 * ROOM];
	unsigned char kind[ROOM];
	struct curve curve[ROOM];
	idx_t point[ROOM], net[ROOM], corner[ROOM], patch[ROOM];
	size_t start[ROOM];
};

static struct made *make(void)
{
	struct made *m = mem_array(1, sizeof *m);
	m->network = (struct network){.xyz = m->xyz, .kind = m->kind, .curve = m->curve, .point = m->point};
	m->cage = (struct cage){
		.xyz = m->local_xyz, .net = m->net, .face_corner = m->corner, .face_start = m->start, .face_patch = m->patch};
	return m;
}

static idx_t add_point(struct made *m, double x, double y, double z, enum point_kind kind)
{
	const size_t i = m->network.vertex_count++;
	m->xyz[3 * i] = x, m->xyz[3 * i + 1] = y, m->xyz[3 * i + 2] = z;
	m->kind[i] = (unsigned char)kind;
	return (idx_t)i;
}

static void add_curve(struct made *m, enum curve_kind kind, bool closed, idx_t left, idx_t right, const idx_t *point,
		      size_t count)
{
	m->curve[m->network.curve_count++] = (struct curve){
		.left = left, .right = right, .kind = kind, .closed = closed, .first = m->network.point_count, .count = count};
	for (size_t i = 0; i < count; i++)
		m->point[m->network.point_count++] = point[i];
}

static void add_face(struct made *m, idx_t patch, const idx_t *point, size_t count)
{
	struct cage *c = &m->cage;
	for (size_t i = 0; i < count; i++) {
		const size_t v = c->vertex_count++;
		memcpy(m->local_xyz + 3 * v, m->xyz + 3 * (size_t)point[i], 3 * sizeof(double));
		m->net[v] = point[i];
		m->corner[c->face_start[c->face_count] + i] = (idx_t)v;
	}
	m->patch[c->face_count] = patch;
	c->face_start[c->face_count + 1] = c->face_start[c->face_count] + count;
	c->face_count++;
}

/* A straight sharp curve for every edge of the faces added since, between the patches on its sides. */
static void add_straight_curves(struct made *m, enum curve_kind between)
{
	for (size_t f = 0; f < m->cage.face_count; f++)
		for (size_t i = m->start[f]; i < m->start[f + 1]; i++) {
			const idx_t a = m->net[m->corner[i]],
				    b = m->net[m->corner[i + 1 < m->start[f + 1] ? i + 1 : m->start[f]]];
			idx_t right = -1;
			for (size_t g = 0; g < m->cage.face_count; g++)
				for (size_t j = m->start[g]; j < m->start[g + 1]; j++)
					if (m->net[m->corner[j]] == b &&
					    m->net[m->corner[j + 1 < m->start[g + 1] ? j + 1 : m->start[g]]] == a)
						right = m->patch[g];
			if (right == m->patch[f] || (right >= 0 && a > b))
				continue;
			add_curve(m, right < 0 ? CURVE_BORDER : between, false, m->patch[f], right, (const idx_t[]){a, b}, 2);
		}
}

static const idx_t cube_face[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

static void add_cube_points(struct made *m, double x, double y, double z)
{
	static const double p[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
	for (size_t i = 0; i < 8; i++)
		add_point(m, p[i][0] + x, p[i][1] + y, p[i][2] + z, POINT_JUNCTION);
}

static struct made *cube(void)
{
	struct made *m = make();
	add_cube_points(m, 0, 0, 0);
	for (idx_t f = 0; f < 6; f++)
		add_face(m, f, cube_face[f], 4);
	add_straight_curves(m, CURVE_SHARP);
	return m;
}

static long euler_of(const struct polymesh *mesh)
{
	long *euler, sum = 0;
	const size_t n = polymesh_euler(&euler, mesh);
	for (size_t i = 0; i < n; i++)
		sum += euler[i];
	free(euler);
	return sum;
}

static size_t edges_of(const struct cage *cage, long euler)
{
	return (size_t)((long)cage->vertex_count + (long)cage->face_count - euler);
}

/* Weld, tidy, and take the cage. */
static struct cage finish(struct made *m, struct tidy_report *tidied, long *euler)
{
	struct polymesh mesh;
	struct weld_report report;
	struct fault fault = {0};
	if (!weld(&mesh, &report, &m->cage, &m->network, &fault))
		fail_msg("%s", fault.text);
	tidy(tidied, &mesh, 1e-4);
	*euler = euler_of(&mesh);
	struct cage cage;
	polymesh_to_cage(&cage, &mesh);
	polymesh_free(&mesh);
	return cage;
}

static void test_cube(void **state)
{
	(void)state;
	struct made *m = cube();
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	assert_int_equal(cage.vertex_count, 8);
	assert_int_equal(cage.face_count, 6);
	assert_int_equal(euler, 2);
	assert_int_equal(edges_of(&cage, euler), 12);
	assert_int_equal(cage.sharp_count, 12);
	for (size_t v = 0; v < 8; v++)
		assert_int_equal(cage.corner[v], 0); /* three creases: corners by rule */
	assert_int_equal(tidied.merged + tidied.dissolved + tidied.straightened, 0);
	cage_free(&cage);
	free(m);
}

/* A capped cylinder: two closed curves of six points, six quads between them. Both circles are creases without corner. */
static void test_cylinder(void **state)
{
	(void)state;
	struct made *m = make();
	idx_t top[6], bottom[6], turned[6];
	for (idx_t i = 0; i < 6; i++)
		top[i] = add_point(m, cos(i * 1.0471975511965976), sin(i * 1.0471975511965976), 1, POINT_CREASE);
	for (idx_t i = 0; i < 6; i++)
		bottom[i] = add_point(m, cos(i * 1.0471975511965976), sin(i * 1.0471975511965976), 0, POINT_CREASE);
	for (size_t i = 0; i < 6; i++)
		turned[i] = bottom[5 - i];
	add_curve(m, CURVE_SHARP, true, 0, 2, top, 6);
	add_curve(m, CURVE_SHARP, true, 1, 2, turned, 6);
	add_face(m, 0, top, 6);
	add_face(m, 1, turned, 6);
	for (size_t i = 0; i < 6; i++)
		add_face(m, 2, (const idx_t[]){bottom[i], bottom[(i + 1) % 6], top[(i + 1) % 6], top[i]}, 4);
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	assert_int_equal(cage.vertex_count, 12);
	assert_int_equal(cage.face_count, 8);
	assert_int_equal(edges_of(&cage, euler), 18);
	assert_int_equal(cage.sharp_count, 12);
	for (size_t v = 0; v < 12; v++)
		assert_int_equal(cage.corner[v], 0);
	cage_free(&cage);
	free(m);
}

/* A block with a square hole through it: euler 0. Its top and bottom rings stay four quads, because no polygon has a hole. */
static void test_bored_block(void **state)
{
	(void)state;
	struct made *m = make();
	static const double square[4][2] = {{0, 0}, {3, 0}, {3, 3}, {0, 3}}, hole[4][2] = {{1, 1}, {2, 1}, {2, 2}, {1, 2}};
	for (int z = 0; z < 2; z++) {
		for (int i = 0; i < 4; i++)
			add_point(m, square[i][0], square[i][1], z, POINT_JUNCTION);
		for (int i = 0; i < 4; i++)
			add_point(m, hole[i][0], hole[i][1], z, POINT_JUNCTION);
	}
	for (idx_t i = 0; i < 4; i++) {
		const idx_t j = (i + 1) % 4;
		add_face(m, 0, (const idx_t[]){8 + i, 8 + j, 12 + j, 12 + i}, 4);
		add_face(m, 1, (const idx_t[]){i, 4 + i, 4 + j, j}, 4);
		add_face(m, 2 + i, (const idx_t[]){i, j, 8 + j, 8 + i}, 4);
		add_face(m, 6 + i, (const idx_t[]){4 + i, 12 + i, 12 + j, 4 + j}, 4);
	}
	add_straight_curves(m, CURVE_SHARP);
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	assert_int_equal(euler, 0);
	assert_int_equal(cage.vertex_count, 16);
	assert_int_equal(cage.sharp_count, 24);
	/* Two quads of a ring join into one, the next join would go around the hole or fold. */
	assert_true(cage.face_count >= 8 + 4 && cage.face_count <= 16);
	cage_free(&cage);
	free(m);
}

/* A cube whose top is four quads around a centre, with the midpoints of the top edges: everything that says nothing goes. */
static void test_planar(void **state)
{
	(void)state;
	struct made *m = make();
	add_cube_points(m, 0, 0, 0);
	const idx_t mid[4] = {add_point(m, 0.5, 0, 1, POINT_CREASE), add_point(m, 1, 0.5, 1, POINT_CREASE),
			      add_point(m, 0.5, 1, 1, POINT_CREASE), add_point(m, 0, 0.5, 1, POINT_CREASE)};
	const idx_t centre = add_point(m, 0.5, 0.5, 1, POINT_CREASE);
	for (idx_t i = 0; i < 4; i++) {
		const idx_t j = (i + 1) % 4;
		add_face(m, 1, (const idx_t[]){4 + i, mid[i], centre, mid[(i + 3) % 4]}, 4);
		add_face(m, 2 + i, (const idx_t[]){i, j, 4 + j, mid[i], 4 + i}, 5);
		add_curve(m, CURVE_SHARP, false, 2 + i, 0, (const idx_t[]){i, j}, 2);
		add_curve(m, CURVE_SHARP, false, 1, 2 + i, (const idx_t[]){4 + i, mid[i], 4 + j}, 3);
		add_curve(m, CURVE_SHARP, false, 2 + (i + 3) % 4, 2 + i, (const idx_t[]){i, 4 + i}, 2);
	}
	add_face(m, 0, cube_face[0], 4);
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	assert_int_equal(euler, 2);
	assert_int_equal(cage.vertex_count, 8);
	assert_int_equal(cage.face_count, 6);
	assert_int_equal(cage.sharp_count, 12);
	assert_int_equal(tidied.straightened, 4);
	cage_free(&cage);
	free(m);
}

/* A U of three rectangles is flat but not star-shaped: it does not become one face. */
static void test_star(void **state)
{
	(void)state;
	struct made *m = make();
	static const double p[10][2] = {{0, 0}, {1, 0}, {4, 0}, {5, 0}, {5, 4}, {4, 4}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
	for (size_t i = 0; i < 10; i++)
		add_point(m, p[i][0], p[i][1], 0, POINT_CORNER);
	add_face(m, 0, (const idx_t[]){0, 1, 7, 8, 9}, 5);
	add_face(m, 0, (const idx_t[]){1, 2, 6, 7}, 4);
	add_face(m, 0, (const idx_t[]){2, 3, 4, 5, 6}, 5);
	add_straight_curves(m, CURVE_SHARP);
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	assert_int_equal(euler, 1);
	assert_true(cage.face_count == 2 || cage.face_count == 3);
	assert_int_equal(cage.sharp_count, 0); /* borders are creases by themselves */
	cage_free(&cage);
	free(m);
}

/* An L with points on two of its straight sides: the one beside the inward kink keeps the fold there small and stays, the one
 * between outward kinks goes. */
static void test_kink(void **state)
{
	(void)state;
	struct made *m = make();
	static const double p[8][2] = {{0, 0}, {2, 0}, {4, 0}, {4, 3}, {3.5, 3}, {3, 3}, {3, 4}, {0, 4}};
	for (size_t i = 0; i < 8; i++)
		add_point(m, p[i][0], p[i][1], 0, i == 1 || i == 4 ? POINT_CREASE : POINT_CORNER);
	const idx_t face[8] = {0, 1, 2, 3, 4, 5, 6, 7};
	add_face(m, 0, face, 8);
	add_straight_curves(m, CURVE_SHARP);
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	assert_int_equal(tidied.straightened, 1);
	assert_int_equal(cage.vertex_count, 7);
	bool kept = false;
	for (size_t v = 0; v < 7; v++)
		kept |= cage.xyz[3 * v] == 3.5 && cage.xyz[3 * v + 1] == 3;
	assert_true(kept);
	cage_free(&cage);
	free(m);
}

/* The plate of one patch: kinks of its border with two creases are explicit corners. */
static void test_corners(void **state)
{
	(void)state;
	struct made *m = make();
	add_point(m, 0, 0, 0, POINT_CORNER);
	add_point(m, 2, 0, 0, POINT_CORNER);
	add_point(m, 2, 1, 0, POINT_CORNER);
	add_point(m, 0, 1, 0, POINT_CORNER);
	add_face(m, 0, (const idx_t[]){0, 1, 2, 3}, 4);
	add_straight_curves(m, CURVE_SHARP);
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	for (size_t v = 0; v < 4; v++)
		assert_int_equal(cage.corner[v], 1);
	cage_free(&cage);
	free(m);
}

/* Two cubes that share one point get a point each. */
static void test_fans(void **state)
{
	(void)state;
	struct made *m = make();
	add_cube_points(m, 0, 0, 0);
	add_cube_points(m, 1, 1, 1);
	for (idx_t f = 0; f < 6; f++)
		add_face(m, f, cube_face[f], 4);
	for (idx_t f = 0; f < 6; f++) {
		idx_t corner[4];
		for (size_t i = 0; i < 4; i++)
			corner[i] = cube_face[f][i] == 0 ? 6 : 8 + cube_face[f][i];
		add_face(m, 6 + f, corner, 4);
	}
	add_straight_curves(m, CURVE_SHARP);
	struct polymesh mesh;
	struct weld_report report;
	struct fault fault = {0};
	assert_true(weld(&mesh, &report, &m->cage, &m->network, &fault));
	assert_int_equal(report.split, 1);
	assert_int_equal(report.unused, 1); /* the second cube's own corner there */
	long *euler;
	assert_int_equal(polymesh_euler(&euler, &mesh), 2);
	assert_int_equal(euler[0], 2);
	assert_int_equal(euler[1], 2);
	free(euler);
	polymesh_free(&mesh);
	free(m);
}

/* A smooth vertex with two edges inside a folded quad is dissolved into its edge. */
static void test_dissolve(void **state)
{
	(void)state;
	struct made *m = make();
	add_cube_points(m, 0, 0, 0);
	const idx_t middle = add_point(m, 0.5, 0.5, 1.3, POINT_CREASE);
	add_face(m, 1, (const idx_t[]){4, 5, 6, middle}, 4);
	add_face(m, 1, (const idx_t[]){4, middle, 6, 7}, 4);
	for (idx_t f = 0; f < 6; f++)
		if (f != 1)
			add_face(m, f, cube_face[f], 4);
	add_straight_curves(m, CURVE_SHARP);
	struct tidy_report tidied;
	long euler;
	struct cage cage = finish(m, &tidied, &euler);
	assert_int_equal(tidied.dissolved, 1);
	assert_int_equal(euler, 2);
	assert_int_equal(cage.vertex_count, 8);
	cage_free(&cage);
	free(m);
}

static void expect_fault(struct made *m, const char *part)
{
	struct polymesh mesh;
	struct weld_report report;
	struct fault fault = {0};
	assert_false(weld(&mesh, &report, &m->cage, &m->network, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	if (!strstr(fault.text, part))
		fail_msg("'%s' does not say '%s'", fault.text, part);
	free(m);
}

/* Each kind of damage is named with patch and curve. */
static void test_damage(void **state)
{
	(void)state;
	struct made *m = cube();
	m->cage.face_count--; /* the last face is missing: its curves have a face on one side only */
	expect_fault(m, "crack");
	m = cube();
	m->corner[0] = m->corner[1], m->net[m->corner[0]] = m->net[m->corner[1]];
	expect_fault(m, "twice");
	m = cube();
	add_face(m, 9, cube_face[2], 4);
	expect_fault(m, "has 3 faces");
	m = cube();
	const idx_t a = m->corner[0];
	m->corner[0] = m->corner[3], m->corner[3] = a;
	const idx_t b = m->corner[1];
	m->corner[1] = m->corner[2], m->corner[2] = b;
	expect_fault(m, "the same way");
	m = cube();
	add_curve(m, CURVE_SHARP, false, 0, 1, (const idx_t[]){0, 6}, 2);
	expect_fault(m, "no face has its control edge 0 6");
	m = cube();
	add_curve(m, CURVE_SHARP, false, 0, 1, (const idx_t[]){0, 1}, 2);
	expect_fault(m, "both have the control edge 0 1");
	m = cube();
	m->net[0] = 99;
	expect_fault(m, "no network point 99");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_cube),   cmocka_unit_test(test_cylinder), cmocka_unit_test(test_bored_block),
		cmocka_unit_test(test_planar), cmocka_unit_test(test_star),     cmocka_unit_test(test_corners), cmocka_unit_test(test_kink),
		cmocka_unit_test(test_fans),   cmocka_unit_test(test_dissolve), cmocka_unit_test(test_damage),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
