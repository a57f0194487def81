/* Where control points of curves come to lie on the borders of the mesh. */
#include "tests/unit/fitpatch_rig.h"

#include "stages/fitpatch/anchor.h"

enum { FACETS = 60 };

/* A cylinder with a network by hand: on both circles a closed curve of k points (the limit of every one lies on the circle), the
 * first at phase. The network walks as left tells: the side is patch 0, the lower cap 1, the upper 2. */
static void circles(struct rig *rig, int k, double phase, bool turned)
{
	struct network network = {.vertex_count = 2 * (size_t)k, .curve_count = 2, .point_count = 2 * (size_t)k};
	network.xyz = mem_array(3 * network.vertex_count, sizeof *network.xyz);
	network.kind = mem_array(network.vertex_count, 1);
	network.curve = mem_array(2, sizeof *network.curve);
	network.point = mem_array(network.point_count, sizeof *network.point);
	/* limits are (1 4 1) / 6: the circle of control points is larger by 6 / (4 + 2 cos) */
	const double radius = 6 / (4 + 2 * cos(2 * PI / k));
	for (int c = 0; c < 2; c++) {
		for (int i = 0; i < k; i++) {
			/* counter-clockwise from above has the side on the left at the bottom, the cap at the top */
			const double angle = phase + (turned ? -1 : 1) * 2 * PI * i / k;
			double *p = &network.xyz[3 * (size_t)(c * k + i)];
			p[0] = radius * cos(angle), p[1] = radius * sin(angle), p[2] = c;
			network.point[c * k + i] = c * k + i;
			network.kind[c * k + i] = POINT_CREASE;
		}
		const bool side_left = (c == 0) != turned;
		network.curve[c] = (struct curve){.left = side_left ? 0 : 1 + c, .right = side_left ? 1 + c : 0, .kind = CURVE_SHARP, .closed = true,
		                                  .first = (size_t)(c * k), .count = (size_t)k};
	}
	for (int c = 0; c < 2; c++)
		network.curve[c].length = network_curve_length(&network, &network.curve[c]);
	rig_start(rig, rig_cylinder(1, 1, FACETS, 2), network, 0.01, 0.003);
}

static struct anchors place(const struct rig *rig)
{
	struct anchors anchors;
	anchors_place(&anchors, &rig->dense, &rig->half, &rig->border, &rig->network, rig->chain_of_curve);
	return anchors;
}

static void point_on_chain(double p[3], const struct rig *rig, size_t c, double along)
{
	const struct border_chain *chain = &rig->border.chain[c];
	const idx_t *vertex = &rig->border.vertex[chain->first];
	const size_t s = (size_t)along;
	const double *a = &rig->dense.xyz[3 * (size_t)vertex[s % chain->count]], *b = &rig->dense.xyz[3 * (size_t)vertex[(s + 1) % chain->count]];
	for (int k = 0; k < 3; k++)
		p[k] = a[k] + (along - (double)s) * (b[k] - a[k]);
}

/* Anchors of a chain rise, stay apart, and name every point of its curve once. */
static void check_order(const struct rig *rig, const struct anchors *anchors, size_t c)
{
	const struct border_chain *chain = &rig->border.chain[c];
	const double end = (double)(chain->closed ? chain->count : chain->count - 1);
	for (size_t i = anchors->first[c]; i < anchors->first[c + 1]; i++) {
		const struct anchor *a = &anchors->anchor[i];
		assert_true(a->along >= 0 && (chain->closed ? a->along < end : a->along <= end));
		if (i > anchors->first[c])
			assert_true(a->along > a[-1].along);
		for (size_t k = anchors->first[c]; k < i; k++)
			assert_int_not_equal(anchors->anchor[k].point, a->point);
	}
}

/* Points follow each other on the mesh as on the curve, once around. */
static void check_cycle(const struct anchors *anchors, size_t c, int k)
{
	const size_t n = anchors->first[c + 1] - anchors->first[c];
	assert_int_equal(n, k);
	const struct anchor *a = &anchors->anchor[anchors->first[c]];
	const int step = (a[1].point - a[0].point + k) % k;
	assert_true(step == 1 || step == k - 1);
	for (size_t i = 0; i < n; i++)
		assert_int_equal((a[(i + 1) % n].point - a[i].point + k) % k, step);
}

static void test_circle(void **state)
{
	(void)state;
	for (int turned = 0; turned < 2; turned++)
		for (int k = 3; k <= 12; k += 3) {
			struct rig rig;
			circles(&rig, k, 0.3, turned);
			struct anchors anchors = place(&rig);
			for (size_t c = 0; c < 2; c++) {
				check_order(&rig, &anchors, c);
				check_cycle(&anchors, c, k);
				for (size_t i = anchors.first[c]; i < anchors.first[c + 1]; i++) {
					double p[3];
					point_on_chain(p, &rig, c, anchors.anchor[i].along);
					const double *q = &rig.network.xyz[3 * (size_t)anchors.anchor[i].point];
					/* the mesh under the limit: at the same angle, but for a snap to a vertex a fortieth of a facet away */
					const double angle = atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
					assert_near(angle, 0, 2 * PI / FACETS / 30);
					assert_near(p[2], q[2], 0);
				}
			}
			/* Half-edges know their chain and segment. */
			size_t marked = 0;
			for (size_t h = 0; h < rig.half.half_count; h++) {
				const idx_t c = anchors.half_chain[h];
				if (c == NO_INDEX)
					continue;
				marked++;
				const idx_t s = anchors.half_segment[h], forward = s >= 0 ? s : -1 - s;
				const idx_t *vertex = &rig.border.vertex[rig.border.chain[c].first];
				const idx_t from = vertex[(size_t)(forward + (s < 0)) % rig.border.chain[c].count];
				assert_int_equal(rig.half.origin[h], from);
			}
			assert_int_equal(marked, 4 * FACETS); /* two circles, both sides */
			anchors_free(&anchors);
			rig_free(&rig);
		}
}

/* A point moved by hand, out or along the curve past its neighbours: the order on the mesh is that of the curve. */
static void test_moved(void **state)
{
	(void)state;
	for (int way = 0; way < 4; way++) {
		struct rig rig;
		circles(&rig, 8, 0, false);
		double *p = &rig.network.xyz[3 * 2];
		if (way == 0)
			p[0] *= 2.5, p[1] *= 2.5;
		else if (way == 1) /* to the place of the point after next */
			copy3(p, &rig.network.xyz[3 * 4]);
		else if (way == 2) /* across */
			p[0] = -p[0], p[1] = -p[1];
		else /* all in one place */
			for (int i = 0; i < 8; i++)
				copy3(&rig.network.xyz[3 * i], (double[3]){1, 0, 0});
		assert_true(network_curve_edited(&rig.network, &rig.network.curve[0]));
		struct anchors anchors = place(&rig);
		for (size_t c = 0; c < 2; c++) {
			check_order(&rig, &anchors, c);
			check_cycle(&anchors, c, 8);
		}
		anchors_free(&anchors);
		rig_free(&rig);
	}
}

/* The sheet of a patch after its anchors are applied. */
static size_t apply(struct sheet *sheet, const struct rig *rig, const struct anchors *anchors, idx_t patch)
{
	size_t *start;
	idx_t *list, *from;
	label_lists(&start, &list, rig->dense.label, rig->dense.triangle_count, rig->dense.patch_count);
	sheet_build(sheet, &from, &list[start[patch]], start[patch + 1] - start[patch], rig->dense.triangle, rig->half.twin, rig->dense.xyz);
	const size_t least = anchors_apply(sheet, anchors, &rig->dense);
	free(start), free(list), free(from);
	return least;
}

/* Both patches along a circle get the same points at the same places, new vertices where they lie inside a facet's edge. */
static void test_apply(void **state)
{
	(void)state;
	struct rig rig;
	circles(&rig, 7, 0.01, false);
	struct anchors anchors = place(&rig);
	double at[2][14][3];
	size_t count[2] = {0, 0};
	for (idx_t patch = 0; patch < 2; patch++) {
		struct sheet sheet;
		assert_int_equal(apply(&sheet, &rig, &anchors, patch), 7);
		for (size_t v = 0; v < sheet.vertex_count; v++) {
			if (sheet.point[v] == NO_INDEX)
				continue;
			assert_true(sheet_on_border(&sheet, (idx_t)v));
			copy3(at[patch][sheet.point[v]], &sheet.xyz[3 * v]);
			count[patch]++;
		}
		sheet_free(&sheet);
	}
	assert_int_equal(count[0], 14);
	assert_int_equal(count[1], 7);
	for (int i = 0; i < 7; i++)
		assert_near(distance3(at[0][i], at[1][i]), 0, 1e-15);
	anchors_free(&anchors);
	rig_free(&rig);
}

static void flat_place(double p[3], double u, double v) { p[0] = 4 * u, p[1] = v, p[2] = 0; }

/* The curves of a rectangle: from corner to corner, the nodes exactly at its corners, inner points in order between them. */
static void test_open(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(6, PATCH_PLANE, flat_place), 0.01, 0.003);
	assert_int_equal(rig.network.curve_count, 4);
	/* two inner points in the first curve, the second of them drawn back over the first */
	struct network *n = &rig.network;
	const idx_t a = n->point[n->curve[0].first], b = n->point[n->curve[0].first + 1];
	n->xyz = mem_resize(n->xyz, 3 * (n->vertex_count + 2), sizeof *n->xyz);
	n->kind = mem_resize(n->kind, n->vertex_count + 2, 1);
	for (size_t i = 0; i < 2; i++)
		for (size_t k = 0; k < 3; k++)
			n->xyz[3 * (n->vertex_count + i) + k] = n->xyz[3 * (size_t)a + k] + (i ? 0.3 : 0.6) * (n->xyz[3 * (size_t)b + k] - n->xyz[3 * (size_t)a + k]);
	const idx_t inner = (idx_t)n->vertex_count;
	n->kind[inner] = n->kind[inner + 1] = POINT_CREASE;
	n->vertex_count += 2;
	const size_t at = n->point_count;
	n->point_count += 4;
	n->point = mem_resize(n->point, n->point_count, sizeof *n->point);
	n->point[at] = a, n->point[at + 1] = inner, n->point[at + 2] = inner + 1, n->point[at + 3] = b;
	n->curve[0].first = at, n->curve[0].count = 4;
	struct anchors anchors = place(&rig);
	for (size_t c = 0; c < 4; c++) {
		check_order(&rig, &anchors, c);
		const struct anchor *first = &anchors.anchor[anchors.first[c]], *last = &anchors.anchor[anchors.first[c + 1] - 1];
		double p[3];
		point_on_chain(p, &rig, c, first->along);
		assert_near(distance3(p, &n->xyz[3 * (size_t)first->point]), 0, 0);
		assert_near(last->along, (double)(rig.border.chain[c].count - 1), 0);
	}
	const size_t c = (size_t)rig.chain_of_curve[0];
	const struct anchor *list = &anchors.anchor[anchors.first[c]];
	assert_int_equal(anchors.first[c + 1] - anchors.first[c], 4);
	const bool forward = list[0].point == a;
	assert_int_equal(list[1].point, forward ? inner : inner + 1);
	assert_int_equal(list[2].point, forward ? inner + 1 : inner);
	/* least change: both go to the middle of where they wanted to be, 0.45 of the way */
	const double end = list[3].along, middle = (list[1].along + list[2].along) / 2 / end;
	assert_near(forward ? middle : 1 - middle, 0.45, 0.1);
	struct sheet sheet;
	assert_int_equal(apply(&sheet, &rig, &anchors, 0), 6);
	sheet_free(&sheet);
	anchors_free(&anchors);
	rig_free(&rig);
}

/* A contracted curve: its chain has no curve, and the nodes at its ends are one point. The loop has one point less, not two in
 * a row. */
static void test_contracted(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(6, PATCH_PLANE, flat_place), 0.01, 0.003);
	struct network *n = &rig.network;
	const struct curve gone = n->curve[3];
	const idx_t a = n->point[gone.first], b = n->point[gone.first + 1];
	n->curve_count = 3;
	for (size_t k = 0; k < 3; k++)
		for (size_t i = 0; i < n->curve[k].count; i++)
			if (n->point[n->curve[k].first + i] == b)
				n->point[n->curve[k].first + i] = a;
	struct anchors anchors = place(&rig);
	const size_t chain = (size_t)rig.chain_of_curve[3];
	assert_int_equal(anchors.first[chain], anchors.first[chain + 1]);
	struct sheet sheet;
	assert_int_equal(apply(&sheet, &rig, &anchors, 0), 3);
	size_t points = 0;
	for (size_t v = 0; v < sheet.vertex_count; v++)
		points += sheet.point[v] != NO_INDEX;
	assert_int_equal(points, 3);
	sheet_free(&sheet);
	anchors_free(&anchors);
	rig_free(&rig);
}

/* A coarse border with more control points than edges: all find room. */
static void test_crowded(void **state)
{
	(void)state;
	struct rig rig;
	circles(&rig, 12, 0.1, false);
	rig_free(&rig);
	circles(&rig, 200, 0.1, false);
	struct anchors anchors = place(&rig);
	for (size_t c = 0; c < 2; c++) {
		check_order(&rig, &anchors, c);
		check_cycle(&anchors, c, 200);
	}
	struct sheet sheet;
	assert_int_equal(apply(&sheet, &rig, &anchors, 0), 200);
	for (size_t t = 0; t < sheet.triangle_count; t++) {
		double area[3];
		const idx_t *v = &sheet.origin[3 * t];
		area_vector3(area, &sheet.xyz[3 * (size_t)v[0]], &sheet.xyz[3 * (size_t)v[1]], &sheet.xyz[3 * (size_t)v[2]]);
		assert_true(norm3(area) > 0);
	}
	sheet_free(&sheet);
	anchors_free(&anchors);
	rig_free(&rig);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_circle), cmocka_unit_test(test_moved),      cmocka_unit_test(test_apply),
		cmocka_unit_test(test_open),   cmocka_unit_test(test_contracted), cmocka_unit_test(test_crowded),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
