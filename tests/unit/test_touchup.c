/* Touching up: the worst patches, one at a time. */
#include "tests/unit/fitpatch_rig.h"

#include "stages/fitpatch/touchup.h"

static struct patch_error *fit(struct rig *rig)
{
	struct fault fault = {0};
	struct patch_error *error = mem_array(rig->dense.patch_count, sizeof *error);
	rig_layout(rig);
	if (!rounds_fit(&rig->draft, &rig->layouts, error, &rig->rounds, &fault))
		fail_msg("%s", fault.text);
	return error;
}

static void waves(double p[3], double u, double v) { p[0] = u, p[1] = v, p[2] = 0.08 * sin(9 * u) * cos(7 * v); }

/* A part within its bounds is left alone, to the bit, and costs no fit. */
static void test_good_part(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_box(1, 1, 1), 4e-3, 1e-3);
	struct patch_error *error = fit(&rig);
	double *before = mem_copy(rig.draft.control.xyz, 3 * rig.draft.control.count, sizeof *before);
	const size_t points = rig.draft.control.count, work = rig.work;
	touch_up(&rig.draft, &rig.layouts, error, &rig.rounds);
	assert_int_equal(rig.draft.control.count, points);
	assert_memory_equal(before, rig.draft.control.xyz, 3 * points * sizeof *before);
	assert_int_equal(rig.work, work);
	free(before), free(error);
	rig_free(&rig);
}

/* A wavy sheet that got no rounds is far off with the few points that it began with. Touching it up gives it more, until it is within
 * half of that; the error that is told is the one of the cage. */
static void test_waves(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(20, PATCH_FREE, waves), 8e-3, 2e-3);
	rig.rounds.limit = 0;
	struct patch_error *error = fit(&rig);
	const double before = error[0].max;
	const size_t faces = rig.draft.polygons.count;
	assert_true(before > 0.02);
	rig.rounds.bounds = (struct bounds){before / 2, error[0].mean};
	touch_up(&rig.draft, &rig.layouts, error, &rig.rounds);
	assert_true(error[0].max <= before / 2);
	assert_true(rig.draft.polygons.count > faces);
	assert_near(rig_error(&rig, NULL), error[0].max, 0);
	rig_check_draft(&rig.draft, NULL);
	rig_check_curves(&rig.draft);
	free(error);
	rig_free(&rig);
}

/* Waves for x < 1, planes up to 2 and 3. The waves may spoil the plane beside them, not the last one: its points away from the others stay
 * where they are, to the bit. */
static void waves_and_planes(double p[3], double u, double v)
{
	p[0] = 3 * u, p[1] = v;
	p[2] = p[0] < 1 ? 0.08 * sin(2 * M_PI * p[0]) * sin(2 * M_PI * p[0]) * cos(7 * v) : 0;
}

static void test_neighbour(void **state)
{
	(void)state;
	enum { N = 24 };
	struct mesh mesh = {0};
	for (int j = 0; j <= N; j++)
		for (int i = 0; i <= N; i++) {
			double p[3];
			waves_and_planes(p, (double)i / N, (double)j / N);
			shape_vertex(&mesh, p[0], p[1], p[2]);
		}
	idx_t *label = mem_array(2 * N * N, sizeof *label);
	for (idx_t j = 0; j < N; j++)
		for (idx_t i = 0; i < N; i++) {
			const idx_t a = j * (N + 1) + i;
			shape_quad(&mesh, a, a + 1, a + N + 2, a + N + 1);
			label[2 * (j * N + i)] = label[2 * (j * N + i) + 1] = i / (N / 3);
		}
	const enum patch_kind kinds[3] = {PATCH_FREE, PATCH_PLANE, PATCH_PLANE};
	struct rig rig;
	rig_make(&rig, rig_dense(&mesh, label, 3, kinds), 8e-3, 2e-3);
	rig.rounds.limit = 0;
	struct patch_error *error = fit(&rig);
	assert_true(error[0].max > 8e-3);
	const size_t points = rig.draft.control.count;
	double *before = mem_copy(rig.draft.control.xyz, 3 * points, sizeof *before);
	const double max = error[0].max;
	rig.rounds.bounds = (struct bounds){max / 2, error[0].mean};
	touch_up(&rig.draft, &rig.layouts, error, &rig.rounds);	assert_true(error[0].max < max);
	assert_true(rig.draft.control.count > points);
	size_t far = 0;
	for (size_t i = 0; i < points; i++)
		if (before[3 * i] > 2.1) {
			assert_memory_equal(&before[3 * i], &rig.draft.control.xyz[3 * i], 3 * sizeof *before);
			far++;
		}
	assert_true(far >= 2);
	free(label), free(before), free(error);
	shape_free(&mesh);
	rig_free(&rig);
}

/* A part that is ten times as far out as it may be wants more than touching up: no fit is spent on it. */
static void test_hopeless(void **state)
{
	(void)state;
	struct rig rig;
	rig_make(&rig, rig_sheet(20, PATCH_FREE, waves), 8e-3, 2e-3);
	rig.rounds.limit = 0;
	struct patch_error *error = fit(&rig);
	rig.rounds.bounds = (struct bounds){error[0].max / 10, error[0].mean};
	const size_t work = rig.work;
	touch_up(&rig.draft, &rig.layouts, error, &rig.rounds);
	assert_int_equal(rig.work, work);
	free(error);
	rig_free(&rig);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_good_part), cmocka_unit_test(test_waves), cmocka_unit_test(test_neighbour),
	                                   cmocka_unit_test(test_hopeless)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
