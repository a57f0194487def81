/* Cages on integer grids: what rounding costs, and that the grid comes through files and streams as it is. */
#include "tests/unit/polish_rig.h"

#include "stages/polish/lattice.h"
#include "stages/polish/refit.h"

static struct target target_of(const struct sketch *s, size_t samples)
{
	struct rig_mesh mesh = rig_dense(s, 3);
	struct target target;
	target_start(&target, mesh.xyz, mesh.vertex_count, mesh.triangle, mesh.triangle_count, samples, samples / 4, 30);
	rig_mesh_free(&mesh);
	return target;
}
static size_t looked_at; /* counts on; nobody asks */
static struct judge judge_of(const struct target *target) { return (struct judge){.target = target, .max = 0.0075, .limit = 0.0095, .steps = 3, .work = &looked_at}; }

static struct candidate candidate_of(const struct sketch *s, const struct judge *judge)
{
	struct candidate c = {0};
	sketch_copy(&c.sketch, s);
	judge_all(&c.errors, judge, &c.sketch);
	return c;
}

/* Positions are origin + step * grid, and the grid begins at 0. */
static void check_lattice(const struct lattice *l, const struct sketch *s)
{
	int32_t low[3] = {INT32_MAX, INT32_MAX, INT32_MAX};
	for (size_t i = 0; i < 3 * s->vertex_count; i++) {
		assert_near(s->xyz[i], l->origin[i % 3] + l->step * l->grid[i], 1e-13);
		low[i % 3] = l->grid[i] < low[i % 3] ? l->grid[i] : low[i % 3];
	}
	for (int k = 0; k < 3; k++)
		assert_int_equal(low[k], 0);
}

/* A cube whose side is a whole number of steps loses nothing. With other steps it loses a share of one: its side could be a whole number
 * of steps a little longer or shorter. */
static void test_cube(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(true);
	struct target t = target_of(&cube, 1500);
	const struct judge judge = judge_of(&t);
	static const double steps[] = {1, 2, 3, 7, 12, 40, 100, 333, 1.1, 4.35, 14.3, 36.8, 72.8, 101.6, 347.1};
	for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
		struct candidate c = candidate_of(&cube, &judge);
		struct lattice l;
		assert_true(lattice_round(&l, &c, &judge, 1 / steps[i], 3));
		check_lattice(&l, &c.sketch);
		const bool is_whole = steps[i] == floor(steps[i]);
		assert_near(l.step, 1 / steps[i], (is_whole ? 1e-9 : 0.2) / steps[i]);
		assert_near(c.errors.max, 0, is_whole ? 1e-9 : 1.5 / steps[i]);
		assert_near(c.errors.mean, 0, is_whole ? 1e-9 : 0.125 / steps[i]);
		lattice_free(&l);
		candidate_free(&c);
	}
	/* With steps of twice its side all its points would be one. */
	struct candidate c = candidate_of(&cube, &judge);
	struct lattice l;
	assert_false(lattice_round(&l, &c, &judge, 3, 2));
	assert_null(l.grid);
	candidate_free(&c);
	sketch_free(&cube), target_free(&t);
}

/* A cage turned out of the axes, that its mesh is made of: known, and on no grid. */
static struct sketch turned(int which)
{
	struct sketch s = which == 0 ? rig_prism(6) : which == 1 ? rig_quads(6, 5, true) : rig_cube(false);
	for (size_t v = 0; v < s.vertex_count; v++) {
		double *p = &s.xyz[3 * v];
		const double x = 0.83 * p[0] - 0.55 * p[1], y = 0.55 * p[0] + 0.83 * p[1], z = p[2];
		p[0] = 0.8 * x + 0.02, p[1] = 0.77 * y - 0.29 * z, p[2] = 0.29 * y + 0.77 * z;
	}
	return s;
}

static double cost_of(const struct sketch *s, const struct judge *judge)
{
	struct errors e;
	judge_all(&e, judge, s);
	const double cost = e.cost;
	errors_free(&e);
	return cost;
}

static void test_better_than_one_by_one(void **state)
{
	(void)state;
	double won = 0, count = 0;
	for (int which = 0; which < 3; which++) {
		struct sketch s = turned(which);
		struct target t = target_of(&s, 1500);
		const struct judge judge = judge_of(&t);
		for (double step = 0.05; step > 0.002; step /= 3) {
			struct candidate c = candidate_of(&s, &judge);
			struct sketch plain;
			struct lattice l;
			assert_true(lattice_round(&l, &c, &judge, step, 3));
			check_lattice(&l, &c.sketch);
			sketch_copy(&plain, &s);
			for (size_t i = 0; i < 3 * s.vertex_count; i++)
				plain.xyz[i] = step * round(s.xyz[i] / step);
			const double together = cost_of(&c.sketch, &judge), alone = cost_of(&plain, &judge);
			if (!(together <= alone))
				fail_msg("cage %d, step %g: %g together, %g one by one", which, step, together, alone);
			assert_near(c.errors.cost, together, 1e-12);
			won += log(alone / together), count++;
			lattice_free(&l), candidate_free(&c), sketch_free(&plain);
		}
		sketch_free(&s), target_free(&t);
	}
	/* not just by luck: half as much on average */
	assert_true(exp(won / count) > 1.5);
}

/* Bits of the stream from one start edge. */
static double bits_of(const struct lattice *l, const struct sketch *s, size_t *root, enum ffx_method *method)
{
	struct ffx ffx;
	struct fault fault = {0};
	assert_true(lattice_to_ffx(&ffx, l, s, rig_zero, 1));
	if (*method == FFX_BEST) {
		unsigned char *bytes;
		size_t size;
		struct ffx_report report;
		const struct ffx_options options = {.root_limit = 8};
		assert_true(ffx_encode(&bytes, &size, &report, &ffx, &options, &fault));
		free(bytes);
		*root = report.root, *method = report.method;
	}
	ffx.method = *method;
	struct ffx_work *work = ffx_work_new();
	const double bits = 8 * ffx_cost(work, &ffx, *root, NULL, &fault);
	ffx_work_free(work);
	ffx_free(&ffx);
	return bits;
}

/* Steps are taken only where cost + lambda * bits falls: the sum after is at most that before, and with a larger lambda fewer bits are
 * left. */
static void test_settle(void **state)
{
	(void)state;
	for (int which = 0; which < 3; which++) {
		struct sketch s = turned(which);
		struct target t = target_of(&s, 1000);
		const struct judge judge = judge_of(&t);
		double least_bits = INFINITY;
		for (int i = 0; i < 2; i++) {
			const double lambda = i == 0 ? 1e-6 : 1e-4;
			struct candidate c = candidate_of(&s, &judge);
			struct lattice l;
			assert_true(lattice_round(&l, &c, &judge, 0.01, 2));
			size_t root = 0;
			enum ffx_method method = FFX_BEST;
			const double bits = bits_of(&l, &c.sketch, &root, &method), cost = c.errors.cost;
			const size_t taken = lattice_settle(&l, &c, &judge, lambda, 2);
			check_lattice(&l, &c.sketch);
			const double bits_after = bits_of(&l, &c.sketch, &root, &method);
			assert_near(c.errors.cost, cost_of(&c.sketch, &judge), 1e-12);
			if (!(c.errors.cost + lambda * bits_after <= cost + lambda * bits + 1e-3 * cost))
				fail_msg("cage %d, lambda %g: cost %g bits %g became %g and %g", which, lambda, cost, bits, c.errors.cost, bits_after);
			if (i == 1) {
				assert_true(taken > 0);
				assert_true(bits_after < bits);
				assert_true(bits_after <= least_bits);
			}
			least_bits = bits_after;
			lattice_free(&l), candidate_free(&c);
		}
		sketch_free(&s), target_free(&t);
	}
}

static struct cage lattice_cage(const double middle[3], double scale, int32_t **grid)
{
	struct sketch s = turned(0);
	struct target t = target_of(&s, 500);
	const struct judge judge = judge_of(&t);
	struct candidate c = candidate_of(&s, &judge);
	struct lattice l;
	struct cage cage;
	assert_true(lattice_round(&l, &c, &judge, 0.02, 2));
	lattice_to_cage(&cage, &l, &c.sketch, middle, scale);
	assert_near(cage.grid_step, scale * l.step, 1e-12 * scale);
	for (int k = 0; k < 3; k++)
		assert_near(cage.grid_origin[k], middle[k] + scale * l.origin[k], 1e-9);
	*grid = mem_copy(l.grid, 3 * s.vertex_count, sizeof **grid);
	lattice_free(&l), candidate_free(&c);
	sketch_free(&s), target_free(&t);
	return cage;
}

/* The text of the file as it is read back. */
static bool read_back(struct cage *cage, const char *text, struct fault *fault)
{
	struct input input = {.shown = "t.ply", .data = mem_copy(text, strlen(text) + 1, 1), .size = strlen(text)};
	struct ply ply;
	bool is_good = ply_read(&ply, &input, fault);
	if (is_good) {
		is_good = cage_from_ply(cage, &ply, "t.ply", fault);
		ply_free(&ply);
	}
	input_free(&input);
	return is_good;
}
static char *text_of(const struct cage *cage)
{
	struct ply ply;
	char *text = NULL;
	size_t size = 0;
	ply_init(&ply);
	cage_to_ply(&ply, cage);
	FILE *file = open_memstream(&text, &size);
	ply_write(file, &ply);
	fclose(file);
	ply_free(&ply);
	return text;
}

/* Grid, file, grid: the same numbers; and the stream that facefix writes holds the very grid. */
static void test_files(void **state)
{
	(void)state;
	const double middle[3] = {120, -35.5, 7e3};
	int32_t *grid;
	struct cage cage = lattice_cage(middle, 250, &grid), back;
	struct fault fault = {0};
	char *text = text_of(&cage);
	assert_non_null(strstr(text, "element grid 1\n"));
	assert_true(read_back(&back, text, &fault));
	assert_near(back.grid_step, cage.grid_step, 0);
	assert_memory_equal(back.grid_origin, cage.grid_origin, sizeof cage.grid_origin);
	assert_memory_equal(back.xyz, cage.xyz, 3 * cage.vertex_count * sizeof *cage.xyz);
	struct ffx ffx, decoded;
	assert_true(ffx_from_cage(&ffx, &back, &fault));
	assert_memory_equal(ffx.grid, grid, 3 * cage.vertex_count * sizeof *grid);
	assert_true(ffx.has_frame);
	unsigned char *bytes;
	size_t size;
	struct ffx_report report;
	const struct ffx_options options = {.root_limit = 4};
	assert_true(ffx_encode(&bytes, &size, &report, &ffx, &options, &fault));
	assert_true(ffx_decode(&decoded, bytes, size, "t.ffx", &fault));
	struct cage out;
	ffx_to_cage(&out, &decoded);
	assert_int_equal(out.vertex_count, cage.vertex_count);
	/* Vertices come in another order: each has one of ours within a fifth of a step, which is what a frame may be off. */
	for (size_t v = 0; v < out.vertex_count; v++) {
		double best = INFINITY;
		for (size_t w = 0; w < cage.vertex_count; w++) {
			double worst = 0;
			for (int k = 0; k < 3; k++)
				worst = fmax(worst, fabs(out.xyz[3 * v + k] - cage.xyz[3 * w + k]));
			best = fmin(best, worst);
		}
		assert_true(best < 0.2 * cage.grid_step);
	}
	cage_free(&out), ffx_free(&decoded), ffx_free(&ffx), free(bytes);
	/* A cage without grid writes none, also into a document that had one. */
	struct ply ply;
	ply_init(&ply);
	cage_to_ply(&ply, &cage);
	assert_non_null(ply_element(&ply, "grid"));
	back.grid_step = 0;
	cage_to_ply(&ply, &back);
	assert_null(ply_element(&ply, "grid"));
	ply_free(&ply);
	cage_free(&back), cage_free(&cage);
	free(text), free(grid);
}

static void test_moved_vertex(void **state)
{
	(void)state;
	int32_t *grid;
	struct cage cage = lattice_cage(rig_zero, 10, &grid);
	struct ffx ffx;
	struct fault fault = {0};
	/* Written with nine digits a coordinate is still where it was; moved by a tenth of a step it is not. */
	cage.xyz[3 * 4 + 1] += 1e-4 * cage.grid_step;
	assert_true(ffx_from_cage(&ffx, &cage, &fault));
	assert_memory_equal(ffx.grid, grid, 3 * cage.vertex_count * sizeof *grid);
	ffx_free(&ffx);
	cage.xyz[3 * 4 + 1] += 0.1 * cage.grid_step;
	assert_false(ffx_from_cage(&ffx, &cage, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_non_null(strstr(fault.text, "vertex 4 is not on the grid"));
	/* A whole step away is on the grid again. */
	cage.xyz[3 * 4 + 1] += 0.8999 * cage.grid_step;
	fault = (struct fault){0};
	assert_true(ffx_from_cage(&ffx, &cage, &fault));
	ffx_free(&ffx);
	/* Further than a stream reaches. */
	cage.xyz[3 * 4 + 1] += 70000 * cage.grid_step;
	assert_false(ffx_from_cage(&ffx, &cage, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	cage_free(&cage);
	free(grid);
}

static void test_bad_grids(void **state)
{
	(void)state;
	static const struct {
		const char *rows, *said;
	} bad[] = {
		{"element grid 2\nproperty double step\nproperty double x\nproperty double y\nproperty double z\nend_header\n1 0 0 0\n1 0 0 0\n", "2 rows"},
		{"element grid 0\nproperty double step\nproperty double x\nproperty double y\nproperty double z\nend_header\n", "0 rows"},
		{"element grid 1\nproperty double step\nproperty double x\nproperty double y\nproperty double z\nend_header\n0 0 0 0\n", "not positive"},
		{"element grid 1\nproperty double step\nproperty double x\nproperty double y\nproperty double z\nend_header\n-1 0 0 0\n", "not positive"},
		{"element grid 1\nproperty double step\nproperty double x\nproperty double y\nproperty double z\nend_header\nnan 0 0 0\n", "finite"},
		{"element grid 1\nproperty double step\nproperty double x\nproperty double y\nproperty double z\nend_header\n1 0 inf 0\n", "finite"},
		{"element grid 1\nproperty double step\nproperty double x\nproperty double y\nend_header\n1 0 0\n", "'z'"},
		{"element grid 1\nproperty double x\nproperty double y\nproperty double z\nend_header\n0 0 0\n", "'step'"},
	};
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
		char text[1000];
		const char *const rows = strstr(bad[i].rows, "end_header\n") + 11;
		snprintf(text, sizeof text,
		         "ply\nformat ascii 1.0\ncomment cagewright scheme quadtri\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
		         "element face 1\nproperty list uchar int vertex_indices\n%.*s0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n%s",
		         (int)(rows - bad[i].rows), bad[i].rows, rows);
		struct cage cage;
		struct fault fault = {0};
		assert_false(read_back(&cage, text, &fault));
		assert_int_equal(fault.code, EX_BAD_INPUT);
		if (!strstr(fault.text, bad[i].said))
			fail_msg("grid %zu: %s", i, fault.text);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_cube),  cmocka_unit_test(test_better_than_one_by_one), cmocka_unit_test(test_settle),
		cmocka_unit_test(test_files), cmocka_unit_test(test_moved_vertex),           cmocka_unit_test(test_bad_grids),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
