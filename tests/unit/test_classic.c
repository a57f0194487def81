/* The published segmentation: clusters of curvature, growing, merging; and charts of free regions. */
#include "stages/segment/classic_cluster.h"
#include "stages/segment/classic_merge.h"
#include "stages/segment/free_charts.h"
#include "tests/unit/segmented.h"

static size_t classic_patches(const char *name, const struct part_options *part, const struct classic_options *options, double *rand)
{
	struct segmented s;
	struct classic_report report;
	segmented_part(&s, name, part);
	segment_classic(&s.regions, &s.dense, options, &report);
	segmented_assert_sound(&s);
	*rand = segmented_rand(&s, s.regions.label, s.truth);
	const size_t count = s.regions.count;
	segmented_free(&s);
	return count;
}

/* Constant curvature on every face: the clusters are the kinds of face, the regions the faces. */
static void test_constant_curvature(void **state)
{
	(void)state;
	double rand;
	const struct classic_options options = SEGMENTED_CLASSIC;
	assert_int_equal(classic_patches("cube", &(struct part_options){.nasty = true}, &options, &rand), 6);
	assert_near(rand, 1, 1e-9);
	assert_int_equal(classic_patches("cylinder", &(struct part_options){.nasty = true, .facets = 24}, &options, &rand), 3);
	assert_near(rand, 1, 1e-9);
	assert_int_equal(classic_patches("cylinder", &(struct part_options){.facets = 36, .edge = 5}, &options, &rand), 3);
	assert_near(rand, 1, 1e-9);
	assert_int_equal(classic_patches("icosphere", &(struct part_options){.target = 1000}, &options, &rand), 1);
}

/* Curvature cannot tell where a tangent fillet ends to better than the radius of its estimate: most of the area is right. */
static void test_tangent(void **state)
{
	(void)state;
	double rand;
	const struct classic_options options = SEGMENTED_CLASSIC;
	assert_in_range(classic_patches("filleted", &(struct part_options){.target = 4000}, &options, &rand), 7, 16);
	assert_true(rand > 0.9);
}

/* Three values of curvature: K = 3 separates them exactly; the automatic choice finds that three are enough. */
static void test_clusters(void **state)
{
	(void)state;
	struct segmented s;
	segmented_part(&s, "icosphere", &(struct part_options){.target = 1000});
	const size_t n = s.facets.triangle_count;
	struct curvature_feature feature;
	curvature_feature_build(&feature, &s.dense, &s.facets);
	for (size_t t = 0; t < n; t++) {
		feature.value[2 * t] = t % 4 == 3 ? 0 : (double)(t % 4) * 0.1;
		feature.value[2 * t + 1] = t % 4 == 3 ? 0 : 1 + (double)(t % 4);
		feature.is_flat[t] = t % 4 == 3;
	}
	unsigned char *cluster = mem_array(n, 1);
	for (int fixed = 3; fixed >= 0; fixed -= 3) {
		assert_int_equal(classic_cluster(cluster, &s.regions, &feature, fixed), 3);
		for (size_t t = 0; t < n; t++) {
			/* flat triangles have the fixed cluster 0, the others go with their kind */
			if (t % 4 == 3)
				assert_int_equal(cluster[t], 0);
			else
				assert_int_equal(cluster[t], cluster[t % 4]);
		}
		assert_int_not_equal(cluster[0], cluster[1]);
		assert_int_not_equal(cluster[1], cluster[2]);
		assert_int_not_equal(cluster[0], cluster[2]);
	}
	free(cluster);
	curvature_feature_free(&feature);
	segmented_free(&s);
}

/* One region a triangle: merging unites what has one curvature and stops at sharp edges. */
static void test_merge(void **state)
{
	(void)state;
	struct segmented s;
	struct curvature_feature feature;
	const struct dense_patch free_patch = {.kind = PATCH_FREE};
	segmented_part(&s, "cube", &(struct part_options){.target = 1000});
	curvature_feature_build(&feature, &s.dense, &s.facets);
	for (size_t t = 0; t < s.facets.triangle_count; t++)
		s.regions.label[t] = regions_add(&s.regions, &free_patch);
	const size_t unions = classic_merge(&s.regions, &s.dense, &feature, &(struct merge_options){0.25, 5e-4 * s.facets.total_area});
	assert_int_equal(unions, s.facets.triangle_count - 6);
	assert_near(segmented_rand(&s, s.regions.label, s.truth), 1, 1e-9);
	curvature_feature_free(&feature);
	segmented_free(&s);
}

/* D_stop 0 and no small regions: nothing unites; a region of an analytic surface never does. */
static void test_merge_stops(void **state)
{
	(void)state;
	struct segmented s;
	struct curvature_feature feature;
	segmented_part(&s, "icosphere", &(struct part_options){.target = 1000});
	curvature_feature_build(&feature, &s.dense, &s.facets);
	const struct dense_patch patch[2] = {{.kind = PATCH_FREE}, {.kind = PATCH_SPHERE, .radius = 0.5, .sign = 1}};
	for (int k = 0; k < 2; k++)
		regions_add(&s.regions, &patch[k]);
	for (size_t t = 0; t < s.facets.triangle_count; t++)
		s.regions.label[t] = s.facets.centroid[3 * t] > 0;
	assert_int_equal(classic_merge(&s.regions, &s.dense, &feature, &(struct merge_options){100, s.facets.total_area}), 0);
	s.regions.patch[1].kind = PATCH_FREE;
	assert_int_equal(classic_merge(&s.regions, &s.dense, &feature, &(struct merge_options){100, s.facets.total_area}), 1);
	curvature_feature_free(&feature);
	segmented_free(&s);
}

/* A sphere as one free region, whose mean normal is 0, comes apart into connected caps that are flat enough, and never into more pieces
 * than allowed. */
static void test_charts(void **state)
{
	(void)state;
	struct segmented s;
	segmented_part(&s, "icosphere", &(struct part_options){.target = 2000});
	const struct dense_patch free_patch = {.kind = PATCH_FREE};
	for (int bounded = 0; bounded < 2; bounded++) {
		s.regions.count = 0;
		regions_add(&s.regions, &free_patch);
		memset(s.regions.label, 0, s.facets.triangle_count * sizeof *s.regions.label);
		const struct chart_options options = {0.7, 1e-3 * s.facets.total_area, bounded ? 3 : 100};
		const size_t cuts = free_charts(&s.regions, &options);
		assert_int_equal(s.regions.count, cuts + 1);
		regions_renumber(&s.regions);
		tidy_measure(&s.regions, 0);
		segmented_assert_sound(&s);
		if (bounded) {
			assert_int_equal(s.regions.count, 3);
			continue;
		}
		assert_in_range(s.regions.count, 4, 16);
		for (size_t i = 0; i < s.regions.count; i++) {
			double sum[3] = {0, 0, 0};
			for (size_t t = 0; t < s.facets.triangle_count; t++)
				if ((size_t)s.regions.label[t] == i)
					add_scaled3(sum, s.facets.area[t], s.facets.normal + 3 * t);
			assert_true(norm3(sum) >= 0.7 * s.regions.patch[i].area);
		}
	}
	segmented_free(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_constant_curvature), cmocka_unit_test(test_tangent), cmocka_unit_test(test_clusters),
		cmocka_unit_test(test_merge), cmocka_unit_test(test_merge_stops), cmocka_unit_test(test_charts),
	};
	return cmocka_run_group_tests_name("classic", tests, NULL, NULL);
}
