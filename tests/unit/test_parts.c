/* The sample parts are what they say: without this, tests that rest on them would prove nothing. */
#include "tests/unit/helpers.h"

#include "tests/fixtures/parts.h"
#include "tests/fixtures/planar.h"

struct side {
	int low, high, forward; /* forward: +1 when walked from low to high */
};

static int compare_sides(const void *a, const void *b)
{
	const struct side *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	if (x->high != y->high)
		return x->high < y->high ? -1 : 1;
	return (x->forward > y->forward) - (x->forward < y->forward);
}

struct measure {
	size_t edges, border, crowded, clashing; /* sides of one triangle, of more than two, of two that run the same way */
	long euler;
	double volume, area, smallest;
};

static void triangle_cross(double cross[3], const struct solid *solid, size_t t)
{
	const double *a = solid->xyz + 3 * solid->triangle[3 * t], *b = solid->xyz + 3 * solid->triangle[3 * t + 1];
	const double *c = solid->xyz + 3 * solid->triangle[3 * t + 2];
	for (int k = 0; k < 3; k++) {
		const int i = (k + 1) % 3, j = (k + 2) % 3;
		cross[k] = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
	}
}

static struct measure measure(const struct solid *solid)
{
	struct measure m = {.smallest = INFINITY};
	const size_t count = 3 * solid->triangle_count;
	struct side *side = mem_array(count, sizeof *side);
	for (size_t i = 0; i < count; i++) {
		const int a = solid->triangle[i], b = solid->triangle[i % 3 == 2 ? i - 2 : i + 1];
		side[i] = (struct side){a < b ? a : b, a < b ? b : a, a < b ? 1 : -1};
	}
	qsort(side, count, sizeof *side, compare_sides);
	for (size_t i = 0, end; i < count; i = end) {
		int forward = 0;
		for (end = i; end < count && side[end].low == side[i].low && side[end].high == side[i].high; end++)
			forward += side[end].forward;
		m.edges++;
		m.border += end - i == 1;
		m.crowded += end - i > 2;
		m.clashing += end - i == 2 && forward != 0;
	}
	free(side);
	m.euler = (long)solid->vertex_count - (long)m.edges + (long)solid->triangle_count;
	for (size_t t = 0; t < solid->triangle_count; t++) {
		double cross[3];
		triangle_cross(cross, solid, t);
		const double *a = solid->xyz + 3 * solid->triangle[3 * t];
		const double area = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]) / 2;
		m.area += area;
		m.smallest = fmin(m.smallest, area);
		m.volume += (cross[0] * a[0] + cross[1] * a[1] + cross[2] * a[2]) / 6;
	}
	return m;
}

static void check_topology(const char *name, const struct solid *solid)
{
	const struct measure m = measure(solid);
	if (solid->failed)
		fail_msg("%s: a plane face has no triangles", name);
	if (!(m.smallest > 0))
		fail_msg("%s: a triangle without area", name);
	if (strcmp(name, "touching") == 0) {
		/* the shared edge and only it has four triangles */
		assert_true(m.crowded > 0 && m.border == 0 && m.clashing == 0);
		return;
	}
	if (m.crowded)
		fail_msg("%s: %zu edges with more than two triangles", name, m.crowded);
	if (solid->closed && (m.border || m.clashing))
		fail_msg("%s: %zu open and %zu clashing edges", name, m.border, m.clashing);
	if (!solid->closed && m.border == 0)
		fail_msg("%s: is closed", name);
	if (solid->orientable == (m.clashing > 0))
		fail_msg("%s: %zu clashing edges", name, m.clashing);
	if (solid->closed && m.euler != 2 * solid->components - 2 * solid->genus)
		fail_msg("%s: Euler characteristic %ld, genus %d", name, m.euler, solid->genus);
	for (size_t t = 0; t < solid->triangle_count; t++)
		assert_true(solid->triangle_face[t] >= 0 && (size_t)solid->triangle_face[t] < solid->face_count);
}

static void every_part_is_whole(void **state)
{
	(void)state;
	static const struct part_options options[] = {{0}, {.nasty = true}, {.facets = 12}, {.facets = 7, .edge = 9}, {.target = 1500}};
	const struct part_entry *entry;
	size_t i = 0;
	for (; (entry = part_at(i)) != NULL; i++) {
		for (size_t o = 0; o < sizeof options / sizeof *options; o++) {
			struct solid solid;
			assert_true(part_make(&solid, entry->name, &options[o]));
			check_topology(entry->name, &solid);
			solid_free(&solid);
		}
	}
	assert_true(i >= 30);
	struct solid none;
	assert_false(part_make(&none, "no such part", &options[0]));
}

/* Vertices on the surface make the error of volume and area fall with the square of the edge length: with edges half as
 * long it is a quarter. The formulas are exact, so the figures must meet them; polyhedra meet them at once. */
static void figures_converge(void **state)
{
	(void)state;
	const struct part_entry *entry;
	for (size_t i = 0; (entry = part_at(i)) != NULL; i++) {
		double volume_error[2], area_error[2];
		for (int fine = 0; fine < 2; fine++) {
			struct solid solid;
			/* arcs by angle alone: the segment counts double exactly */
			part_make(&solid, entry->name, &(struct part_options){.facets = fine ? 96 : 48, .edge = entry->size / (fine ? 16 : 8)});
			const struct measure m = measure(&solid);
			volume_error[fine] = solid.volume > 0 ? fabs(m.volume / solid.volume - 1) : 0;
			area_error[fine] = fabs(m.area / solid.area - 1);
			solid_free(&solid);
		}
		/* 2000 sides of an involute are exact to 1e-7 */
		if (volume_error[1] > 2e-3 || (volume_error[0] > 1e-6 && volume_error[1] > 0.4 * volume_error[0]))
			fail_msg("%s: volume is off by %g, then %g", entry->name, volume_error[0], volume_error[1]);
		if (area_error[1] > 2e-3 || (area_error[0] > 1e-6 && area_error[1] > 0.4 * area_error[0]))
			fail_msg("%s: area is off by %g, then %g", entry->name, area_error[0], area_error[1]);
	}
}

/* Triangles of a plane face share a normal; vertices of the round ones have the distance they should. */
static void faces_are_what_they_say(void **state)
{
	(void)state;
	const struct part_entry *entry;
	for (size_t i = 0; (entry = part_at(i)) != NULL; i++) {
		struct solid solid;
		part_make(&solid, entry->name, &(struct part_options){0});
		double (*normal)[3] = mem_array(solid.face_count, sizeof *normal);
		unsigned char *seen = mem_array(solid.face_count, 1);
		for (size_t t = 0; t < solid.triangle_count; t++) {
			const int face = solid.triangle_face[t];
			double cross[3];
			triangle_cross(cross, &solid, t);
			const double size = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
			double dot = 0;
			for (int k = 0; k < 3; k++) {
				cross[k] /= size;
				dot += cross[k] * normal[face][k];
			}
			if (!seen[face])
				memcpy(normal[face], cross, sizeof cross);
			else if (solid.face[face].kind == PATCH_PLANE && dot < 1 - 1e-9)
				fail_msg("%s: face %d is no plane", entry->name, face);
			seen[face] = 1;
		}
		for (size_t f = 0; f < solid.face_count; f++)
			if (!seen[f])
				fail_msg("%s: face %zu has no triangles", entry->name, f);
		free(normal);
		free(seen);
		solid_free(&solid);
	}
	struct solid ring;
	part_make(&ring, "ring", &(struct part_options){0});
	for (size_t v = 0; v < ring.vertex_count; v++) {
		const double *p = ring.xyz + 3 * v;
		assert_near(hypot(hypot(p[0], p[1]) - 30, p[2]), 8, 1e-12);
	}
	solid_free(&ring);
}

static void density_is_as_asked(void **state)
{
	(void)state;
	struct solid solid;
	/* 12 facets around and no inner vertices: 12 + 12 vertices, 2 * 12 wall triangles, 10 on each cap */
	part_make(&solid, "cylinder", &(struct part_options){.facets = 12});
	assert_int_equal(solid.vertex_count, 24);
	assert_int_equal(solid.triangle_count, 44);
	solid_free(&solid);
	part_make(&solid, "cube", &(struct part_options){.nasty = true});
	assert_int_equal(solid.vertex_count, 8);
	assert_int_equal(solid.triangle_count, 12);
	solid_free(&solid);
	static const char *const name[] = {"flange", "gear", "icosphere", "elbow"};
	for (int i = 0; i < 4; i++) {
		for (int nasty = 0; nasty < 2; nasty++) {
			part_make(&solid, name[i], &(struct part_options){.nasty = nasty, .target = 20000});
			assert_true(solid.triangle_count > 16000 && solid.triangle_count < 25000);
			solid_free(&solid);
		}
	}
}

static void changes_keep_what_they_should(void **state)
{
	(void)state;
	struct solid plain, changed;
	part_make(&plain, "bracket", &(struct part_options){0});
	const struct measure before = measure(&plain);
	part_make(&changed, "bracket", &(struct part_options){.seed = 5, .shuffle = true, .rotate = true, .scale = 3});
	check_topology("bracket", &changed);
	const struct measure after = measure(&changed);
	assert_near(after.volume / before.volume, 27, 1e-9);
	assert_near(after.area / before.area, 9, 1e-9);
	assert_near(changed.volume / plain.volume, 27, 1e-9);
	/* faces move with their triangles: as many of each as before */
	assert_int_equal(changed.face_count, plain.face_count);
	for (int f = 0; f < (int)plain.face_count; f++) {
		long balance = 0;
		for (size_t t = 0; t < plain.triangle_count; t++)
			balance += (plain.triangle_face[t] == f) - (changed.triangle_face[t] == f);
		assert_int_equal(balance, 0);
	}
	/* the same seed gives the same part, another one does not */
	struct solid again, other;
	part_make(&again, "bracket", &(struct part_options){.seed = 5, .shuffle = true, .rotate = true, .scale = 3});
	part_make(&other, "bracket", &(struct part_options){.seed = 6, .shuffle = true, .rotate = true, .scale = 3});
	assert_memory_equal(again.xyz, changed.xyz, 3 * changed.vertex_count * sizeof *changed.xyz);
	assert_memory_not_equal(other.xyz, changed.xyz, 3 * changed.vertex_count * sizeof *changed.xyz);
	solid_free(&again);
	solid_free(&other);
	solid_free(&changed);
	/* a third of the facets turned: edges clash, the area stays */
	part_make(&changed, "bracket", &(struct part_options){.flip = true});
	const struct measure flipped = measure(&changed);
	assert_true(flipped.clashing > plain.triangle_count / 3);
	assert_near(flipped.area, before.area, 1e-9);
	solid_free(&changed);
	part_make(&changed, "bracket", &(struct part_options){.jitter = 1e-3});
	double largest = 0;
	for (size_t k = 0; k < 3 * plain.vertex_count; k++)
		largest = fmax(largest, fabs(changed.xyz[k] - plain.xyz[k]));
	assert_true(largest > 0.07 && largest <= 0.08 * 1.0001); /* 1e-3 of the longest side, 80 */
	solid_free(&changed);
	solid_free(&plain);
}

/* A square ring with the inner square turned by 45 degrees, and a comb whose teeth no single ear order gets through. */
static void plane_regions(void **state)
{
	(void)state;
	static const double ring[] = {0, 0, 4, 0, 4, 4, 0, 4, 2, 1, 3, 2, 2, 3, 1, 2};
	static const size_t ring_start[] = {0, 4, 8};
	for (int raw = 0; raw < 2; raw++) {
		struct planar planar;
		assert_true(planar_make(&planar, ring, ring_start, 2, raw, 0));
		assert_int_equal(planar.point_count, 8);
		assert_int_equal(planar.triangle_count, 8); /* points + 2 holes - 2 */
		planar_free(&planar);
	}
	struct planar planar;
	assert_true(planar_make(&planar, ring, ring_start, 2, false, 0.3));
	double area = 0;
	for (size_t t = 0; t < planar.triangle_count; t++) {
		const double *a = planar.uv + 2 * planar.triangle[3 * t], *b = planar.uv + 2 * planar.triangle[3 * t + 1];
		const double *c = planar.uv + 2 * planar.triangle[3 * t + 2];
		const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
		assert_true(twice > 0);
		area += twice / 2;
	}
	assert_near(area, 14, 1e-9); /* 16 - 2 */
	assert_true(planar.point_count > 100);
	planar_free(&planar);
	enum { TEETH = 50 };
	double comb[2 * (2 * TEETH + 2)];
	size_t n = 0;
	const size_t comb_start[] = {0, 2 * TEETH + 2};
	for (int i = 0; i < 2 * TEETH; i++) {
		comb[n++] = i;
		comb[n++] = i % 2 ? 1 : 100;
	}
	comb[n++] = 2 * TEETH;
	comb[n++] = 0;
	comb[n++] = -1;
	comb[n++] = 0;
	assert_true(planar_make(&planar, comb, comb_start, 1, true, 0));
	assert_int_equal(planar.triangle_count, 2 * TEETH);
	planar_free(&planar);
	/* a loop that crosses itself is no region */
	static const double bow[] = {0, 0, 2, 2, 2, 0, 0, 3};
	static const size_t bow_start[] = {0, 4};
	assert_false(planar_make(&planar, bow, bow_start, 1, true, 0));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_part_is_whole),     cmocka_unit_test(figures_converge),    cmocka_unit_test(faces_are_what_they_say),
		cmocka_unit_test(density_is_as_asked),     cmocka_unit_test(changes_keep_what_they_should), cmocka_unit_test(plane_regions),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
