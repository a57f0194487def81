/* Nearest points: one triangle against known feet, the tree against a search of all triangles. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "stages/geometry/nearest.h"
#include "stages/geometry/vector.h"

static void assert_near(double got, double want, double tolerance)
{
	if (!(fabs(got - want) <= tolerance))
		fail_msg("%.17g is not within %g of %.17g", got, tolerance, want);
}

static void assert_near3(const double *got, const double *want, double tolerance)
{
	for (int k = 0; k < 3; k++)
		assert_near(got[k], want[k], tolerance);
}

/* xorshift64: the same numbers on every machine. */
static double random_unit(uint64_t *state)
{
	*state ^= *state << 13;
	*state ^= *state >> 7;
	*state ^= *state << 17;
	return (double)(*state >> 11) / 9007199254740992.0;
}

static const double A[3] = {0, 0, 0}, B[3] = {4, 0, 0}, C[3] = {0, 3, 0};

static void seven_regions(void **state)
{
	(void)state;
	/* A right triangle in the plane z = 0: the foot is the point itself with z = 0 when it is inside, else on a side or corner.
	 * (4, 3, 0) is nearest to the hypotenuse at its distance 12 / 5 from the origin's side: 2.4. */
	static const struct {
		double p[3], foot[3], distance;
	} cases[] = {
		{{1, 1, 2}, {1, 1, 0}, 2},
		{{-1, -1, 0}, {0, 0, 0}, M_SQRT2},
		{{6, -1, 0}, {4, 0, 0}, 2.2360679774997896},
		{{-1, 5, 2}, {0, 3, 0}, 3},
		{{2, -2, 0}, {2, 0, 0}, 2},
		{{-2, 1, 0}, {0, 1, 0}, 2},
		{{4, 3, 0}, {4 - 2.4 * 0.6, 3 - 2.4 * 0.8, 0}, 2.4},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		double point[3], weight[3], sum[3] = {0, 0, 0};
		const double distance = nearest_on_triangle(point, weight, cases[i].p, A, B, C);
		assert_near(distance, cases[i].distance, 1e-14);
		assert_near3(point, cases[i].foot, 1e-14);
		assert_near(weight[0] + weight[1] + weight[2], 1, 1e-15);
		add_scaled3(sum, weight[0], A);
		add_scaled3(sum, weight[1], B);
		add_scaled3(sum, weight[2], C);
		assert_near3(sum, point, 1e-14);
	}
}

static void slivers_and_no_area(void **state)
{
	(void)state;
	double point[3], weight[3];
	/* Length 1, height 1e-12, seen from a distance 1: the weights of its inside are rounding errors, its long side is not. */
	const double a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {0.5, 1e-12, 0}, p[3] = {0.25, 0.6, 0.8};
	assert_near(nearest_on_triangle(point, weight, p, a, b, c), 1, 1e-11);
	assert_near(point[0], 0.25, 1e-6);
	/* A segment and a point. */
	const double half[3] = {0.5, 0, 0};
	assert_near(nearest_on_triangle(point, weight, p, a, b, half), 1, 1e-15);
	assert_near(nearest_on_triangle(point, weight, p, a, a, a), norm3(p), 1e-15);
	assert_near(weight[0] + weight[1] + weight[2], 1, 0);
	/* Coordinates at the ends of what a float can hold. */
	const double s[3][3] = {{0, 0, 0}, {4e38, 0, 0}, {0, 3e38, 0}}, q[3] = {1e38, 1e38, 2e38};
	assert_near(nearest_on_triangle(point, weight, q, s[0], s[1], s[2]) / 2e38, 1, 1e-14);
	const double t[3][3] = {{0, 0, 0}, {4e-38, 0, 0}, {0, 3e-38, 0}}, r[3] = {1e-38, 1e-38, 2e-38};
	assert_near(nearest_on_triangle(point, weight, r, t[0], t[1], t[2]) / 2e-38, 1, 1e-14);
}

enum { SOUP_VERTICES = 300, SOUP_TRIANGLES = 700 };
struct soup {
	double xyz[3 * SOUP_VERTICES];
	idx_t triangle[3 * SOUP_TRIANGLES];
};

/* Triangles of random vertices, many sharing vertices (ties), every 50th without area. */
static void random_soup(struct soup *soup, double scale, double offset, uint64_t *state)
{
	for (int i = 0; i < 3 * SOUP_VERTICES; i++)
		soup->xyz[i] = offset + scale * random_unit(state);
	for (int t = 0; t < SOUP_TRIANGLES; t++) {
		const int first = (int)(random_unit(state) * SOUP_VERTICES);
		for (int k = 0; k < 3; k++)
			soup->triangle[3 * t + k] = (idx_t)((first + (int)(random_unit(state) * 20)) % SOUP_VERTICES);
		if (t % 50 == 0)
			soup->triangle[3 * t + 1] = soup->triangle[3 * t];
	}
}

static struct foot search_all(const struct soup *soup, const double p[3], const idx_t *label, idx_t only)
{
	struct foot best = {.triangle = NO_INDEX, .distance = INFINITY};
	for (idx_t t = 0; t < SOUP_TRIANGLES; t++) {
		if (label != NULL && label[t] != only)
			continue;
		double point[3], weight[3];
		const idx_t *corner = soup->triangle + 3 * t;
		const double distance = nearest_on_triangle(point, weight, p, soup->xyz + 3 * corner[0], soup->xyz + 3 * corner[1], soup->xyz + 3 * corner[2]);
		if (distance < best.distance) {
			best.distance = distance;
			best.triangle = t;
			copy3(best.point, point);
		}
	}
	return best;
}

static void tree_equals_search_of_all(void **state)
{
	(void)state;
	/* Far from the origin, tiny, huge: single precision in the coordinates themselves would fail for all but the first. */
	static const double place[][2] = {{1, 0}, {1, 1e7}, {1e-20, 0}, {1e25, -3e25}};
	uint64_t seed = 88172645463325252u;
	idx_t label[SOUP_TRIANGLES];
	for (idx_t t = 0; t < SOUP_TRIANGLES; t++)
		label[t] = t % 7;
	for (size_t s = 0; s < sizeof place / sizeof *place; s++) {
		struct soup soup;
		random_soup(&soup, place[s][0], place[s][1], &seed);
		struct nearest *nearest = nearest_new(soup.xyz, SOUP_VERTICES, soup.triangle, SOUP_TRIANGLES);
		for (int i = 0; i < 400; i++) {
			double p[3];
			for (int k = 0; k < 3; k++)
				p[k] = place[s][1] + place[s][0] * (4 * random_unit(&seed) - 1.5);
			if (i % 4 == 0) /* a vertex: many triangles at distance 0, the lowest index wins */
				copy3(p, soup.xyz + 3 * (i % SOUP_VERTICES));
			const struct nearest_filter filter = {.label = label, .only = i % 7};
			for (int labelled = 0; labelled < 2; labelled++) {
				const struct foot want = search_all(&soup, p, labelled ? label : NULL, i % 7);
				const struct foot got = nearest_point(nearest, p, INFINITY, labelled ? &filter : NULL);
				assert_int_equal(got.triangle, want.triangle);
				assert_true(got.distance == want.distance);
				assert_near3(got.point, want.point, 0);
				if (want.distance > 0) { /* the bound is inclusive, and nothing is found below it */
					assert_int_equal(nearest_point(nearest, p, want.distance, labelled ? &filter : NULL).triangle, want.triangle);
					assert_int_equal(nearest_point(nearest, p, want.distance * (1 - 1e-12), labelled ? &filter : NULL).triangle, NO_INDEX);
				}
			}
		}
		nearest_free(nearest);
	}
}

/* Slivers along one line, as in a twisted rod: each is a candidate all along it, and most are told to be too far by that line alone. */
static void slivers_of_one_rod(void **state)
{
	(void)state;
	static const double place[][2] = {{1, 0}, {1, 1e7}, {1e-20, 0}, {1e25, -3e25}};
	uint64_t seed = 4101842887655102017u;
	for (size_t s = 0; s < sizeof place / sizeof *place; s++) {
		struct soup soup;
		random_soup(&soup, place[s][0] * 1e-3, place[s][1], &seed);
		for (int i = 0; i < 3 * SOUP_VERTICES; i++)
			soup.xyz[i] += i / 3 % 2 * place[s][0]; /* every other vertex at the far end */
		struct nearest *nearest = nearest_new(soup.xyz, SOUP_VERTICES, soup.triangle, SOUP_TRIANGLES);
		for (int i = 0; i < 400; i++) {
			double p[3];
			const double along = random_unit(&seed);
			for (int k = 0; k < 3; k++)
				p[k] = place[s][1] + place[s][0] * (along + 1e-3 * random_unit(&seed));
			const struct foot want = search_all(&soup, p, NULL, 0), got = nearest_point(nearest, p, INFINITY, NULL);
			assert_int_equal(got.triangle, want.triangle);
			assert_true(got.distance == want.distance);
		}
		nearest_free(nearest);
	}
}

static void far_queries(void **state)
{
	(void)state;
	uint64_t seed = 12345;
	struct soup soup;
	random_soup(&soup, 1, 0, &seed);
	struct nearest *nearest = nearest_new(soup.xyz, SOUP_VERTICES, soup.triangle, SOUP_TRIANGLES);
	for (double far = 10; far < 1e40; far *= 1e3) {
		const double p[3] = {far, -far / 3, far / 7};
		assert_int_equal(nearest_point(nearest, p, INFINITY, NULL).triangle, search_all(&soup, p, NULL, 0).triangle);
	}
	const double nowhere[3] = {NAN, 0, 0}, infinite[3] = {0, INFINITY, 0};
	assert_int_equal(nearest_point(nearest, nowhere, INFINITY, NULL).triangle, NO_INDEX);
	assert_int_equal(nearest_point(nearest, infinite, INFINITY, NULL).triangle, NO_INDEX);
	nearest_free(nearest);
	nearest = nearest_new(soup.xyz, SOUP_VERTICES, soup.triangle, 0);
	assert_int_equal(nearest_point(nearest, soup.xyz, INFINITY, NULL).triangle, NO_INDEX);
	nearest_free(nearest);
	nearest_free(NULL);
}

static void normal_preference(void **state)
{
	(void)state;
	/* A plate from z = 0 (normal down, triangle 0) to z = 1 (normal up, triangle 1): from z = 0.4 the lower side is nearer, and
	 * the upper one, at distance 0.6, is preferred only within a reach of 1.5. */
	const double xyz[] = {0, 0, 0, 0, 9, 0, 9, 0, 0, 0, 0, 1, 9, 0, 1, 0, 9, 1}, up[3] = {0, 0, 1}, p[3] = {1, 1, 0.4};
	const idx_t triangle[] = {0, 1, 2, 3, 4, 5};
	struct nearest *nearest = nearest_new(xyz, 6, triangle, 2);
	struct nearest_filter filter = {.normal = up, .least_dot = 0.5, .reach = 1.6};
	assert_int_equal(nearest_point(nearest, p, INFINITY, NULL).triangle, 0);
	const struct foot preferred = nearest_point(nearest, p, INFINITY, &filter);
	assert_int_equal(preferred.triangle, 1);
	assert_near(preferred.distance, 0.6, 1e-15);
	assert_near3(preferred.normal, up, 0);
	filter.reach = 1.4;
	assert_int_equal(nearest_point(nearest, p, INFINITY, &filter).triangle, 0);
	filter.slack = 0.1;
	assert_int_equal(nearest_point(nearest, p, INFINITY, &filter).triangle, 1);
	nearest_free(nearest);
}

static void count_visit(void *user, idx_t triangle, const double point[3], double distance)
{
	(void)point;
	(void)distance;
	((int *)user)[triangle]++;
}

static void all_within(void **state)
{
	(void)state;
	uint64_t seed = 777;
	struct soup soup;
	random_soup(&soup, 1, 5, &seed);
	struct nearest *nearest = nearest_new(soup.xyz, SOUP_VERTICES, soup.triangle, SOUP_TRIANGLES);
	for (int i = 0; i < 50; i++) {
		const double p[3] = {5 + random_unit(&seed), 5 + random_unit(&seed), 5 + random_unit(&seed)}, radius = 0.3 * random_unit(&seed);
		int visits[SOUP_TRIANGLES] = {0};
		nearest_within(nearest, p, radius, count_visit, visits);
		for (idx_t t = 0; t < SOUP_TRIANGLES; t++) {
			double point[3], weight[3];
			const idx_t *corner = soup.triangle + 3 * t;
			const double distance = nearest_on_triangle(point, weight, p, soup.xyz + 3 * corner[0], soup.xyz + 3 * corner[1], soup.xyz + 3 * corner[2]);
			assert_int_equal(visits[t], distance <= radius ? 1 : 0);
		}
	}
	nearest_free(nearest);
}

static void expect_same(const struct foot *got, const struct foot *want)
{
	assert_int_equal(got->triangle, want->triangle);
	if (want->triangle == NO_INDEX)
		return;
	assert_true(got->distance == want->distance);
	for (int k = 0; k < 3; k++)
		assert_true(got->point[k] == want->point[k]);
}

/* The tree by labels gives the same bits as the search of all, whatever the hint, also after its vertices have gone anywhere. */
static void labelled_equals_search_of_all(void **state)
{
	(void)state;
	uint64_t seed = 4242;
	struct soup soup, moved;
	random_soup(&soup, 2, 100, &seed);
	idx_t label[SOUP_TRIANGLES], other[SOUP_TRIANGLES];
	for (int t = 0; t < SOUP_TRIANGLES; t++) {
		label[t] = t == 5 ? 40 : (idx_t)(7 * random_unit(&seed)) - 2; /* one label with a single triangle */
		other[t] = (idx_t)(3 * random_unit(&seed));
	}
	struct nearest *nearest = nearest_new_labelled(soup.xyz, SOUP_VERTICES, soup.triangle, SOUP_TRIANGLES, label);
	for (int round = 0; round < 3; round++) {
		for (int i = 0; i < 300; i++) {
			double p[3];
			for (int k = 0; k < 3; k++)
				p[k] = i % 9 == 0 ? soup.xyz[3 * (i % SOUP_VERTICES) + k] : 99 + 4 * random_unit(&seed);
			struct nearest_filter filter = {.label = label, .only = i % 10 == 0 ? 40 : i % 10 - 3};
			filter.hint = i % 3 ? (idx_t)(random_unit(&seed) * SOUP_TRIANGLES) + 1 : 0;
			struct foot want = search_all(&soup, p, label, filter.only), got = nearest_point(nearest, p, INFINITY, &filter);
			expect_same(&got, &want);
			/* within a bound that is just too small, and just large enough */
			if (want.triangle != NO_INDEX) {
				got = nearest_point(nearest, p, want.distance, &filter);
				expect_same(&got, &want);
				got = nearest_point(nearest, p, nextafter(want.distance, -1), &filter);
				assert_int_equal(got.triangle, NO_INDEX);
			}
			filter.label = other, filter.only = i % 3;
			want = search_all(&soup, p, other, filter.only), got = nearest_point(nearest, p, INFINITY, &filter);
			expect_same(&got, &want);
			want = search_all(&soup, p, NULL, 0), got = nearest_point(nearest, p, INFINITY, NULL);
			expect_same(&got, &want);
			int visits[SOUP_TRIANGLES] = {0}, expected = 0, found = 0;
			nearest_within(nearest, p, 0.5, count_visit, visits);
			for (idx_t t = 0; t < SOUP_TRIANGLES; t++) {
				double point[3], weight[3];
				const idx_t *corner = soup.triangle + 3 * t;
				expected += nearest_on_triangle(point, weight, p, soup.xyz + 3 * corner[0], soup.xyz + 3 * corner[1], soup.xyz + 3 * corner[2]) <= 0.5;
				found += visits[t];
			}
			assert_int_equal(found, expected);
		}
		random_soup(&moved, round ? 0.1 : 2, round ? 101 : 100, &seed);
		memcpy(soup.xyz, moved.xyz, sizeof soup.xyz);
		nearest_move(nearest);
	}
	nearest_free(nearest);
	/* no triangles at all */
	nearest = nearest_new_labelled(soup.xyz, SOUP_VERTICES, soup.triangle, 0, label);
	nearest_move(nearest);
	assert_int_equal(nearest_point(nearest, soup.xyz, INFINITY, NULL).triangle, NO_INDEX);
	nearest_free(nearest);
}

/* The weights of a foot in the plane say which sides to look at; all sides and the inside say the same. */
static void skipped_sides_do_not_matter(void **state)
{
	(void)state;
	uint64_t seed = 99;
	for (int i = 0; i < 20000; i++) {
		double v[3][3], p[3], point[3], weight[3], foot[3];
		const double flat = pow(10, -12 * random_unit(&seed)), far = pow(10, 6 * random_unit(&seed) - 3);
		for (int k = 0; k < 3; k++) {
			for (int j = 0; j < 3; j++)
				v[j][k] = (k == 1 ? flat : 1) * random_unit(&seed);
			p[k] = v[0][k] + far * (random_unit(&seed) - 0.5);
		}
		const double distance = nearest_on_triangle(point, weight, p, v[0], v[1], v[2]);
		double least = INFINITY;
		for (int j = 0; j < 3; j++) { /* a triangle without area gives the nearest point of its sides */
			double unused[3];
			least = fmin(least, nearest_on_triangle(foot, unused, p, v[j], v[(j + 1) % 3], v[j]));
		}
		assert_true(distance <= least * (1 + 1e-15));
		assert_near(distance3(p, point), distance, 1e-15 * (1 + distance));
		for (int j = 0; j < 3; j++)
			assert_true(weight[j] >= 0);
		double sum[3] = {0, 0, 0};
		for (int j = 0; j < 3; j++)
			add_scaled3(sum, weight[j], v[j]);
		assert_near3(sum, point, 1e-12);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(seven_regions),
		cmocka_unit_test(slivers_and_no_area),
		cmocka_unit_test(tree_equals_search_of_all),
		cmocka_unit_test(slivers_of_one_rod),
		cmocka_unit_test(far_queries),
		cmocka_unit_test(normal_preference),
		cmocka_unit_test(all_within),
		cmocka_unit_test(labelled_equals_search_of_all),
		cmocka_unit_test(skipped_sides_do_not_matter),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
