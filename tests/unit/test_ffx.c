/* FFX streams: sizes, frames, refusals, and that the same cage gives the same bytes. */
#include "tests/unit/ffx_helpers.h"

#include <dirent.h>

#include "formats/input.h"

static struct cage box(void)
{
	struct cage cage = {0};
	for (int i = 0; i < 8; i++)
		sample_vertex(&cage, i >> 2 & 1, i >> 1 & 1, i & 1);
	sample_quad(&cage, 0, 1, 3, 2);
	sample_quad(&cage, 4, 6, 7, 5);
	sample_quad(&cage, 0, 4, 5, 1);
	sample_quad(&cage, 2, 3, 7, 6);
	sample_quad(&cage, 0, 2, 6, 4);
	sample_quad(&cage, 1, 5, 7, 3);
	sample_tag(&cage, 30, 0);
	return cage;
}

/* The sizes that the method promises (patch-pipeline, section 8.8), without frame and checksum, on 1023 steps. */
static void test_sizes(void **state)
{
	(void)state;
	struct cage cube = box();
	assert_int_equal(cube.sharp_count, 12);
	struct ffx ffx = ffx_rounded(&cube, ffx_grid_code(1023));
	size_t size;
	struct ffx_report report;
	free(round_trip(&ffx, &size, &report, 0));
	assert_int_equal(report.bytes_total, size);
	assert_int_equal(report.bytes_header, 3 + 2);
	assert_true(size <= 16);
	free(ffx.grid);
	cage_free(&cube);

	/* A cylinder capped by two hexagons. */
	const double profile[2][2] = {{1, 0}, {1, 1.5}};
	struct cage cylinder = sample_turned(profile, 2, 6, false);
	sample_tag(&cylinder, 70, 0);
	assert_int_equal(cylinder.vertex_count, 12);
	assert_int_equal(cylinder.sharp_count, 12);
	ffx = ffx_rounded(&cylinder, ffx_grid_code(1023));
	free(round_trip(&ffx, &size, &report, 0));
	assert_true(size <= 40);
	free(ffx.grid);
	cage_free(&cylinder);
}

/* The parts of the report add up to the stream, to a byte for the end of the range coder. */
static void test_report(void **state)
{
	(void)state;
	struct cage cage = sample_plate(3, 3, 0.2, 0.5);
	sample_tag(&cage, 30, 0);
	struct ffx ffx = ffx_rounded(&cage, 100);
	size_t size;
	struct ffx_report report;
	free(round_trip(&ffx, &size, &report, 5));
	assert_near((double)report.bytes_header + report.bytes_frame + report.bytes_c + report.bytes_g + report.bytes_f,
		    (double)size, 1);
	assert_true(report.bytes_c > 0 && report.bytes_g > 0 && report.bytes_f > 0);
	free(ffx.grid);
	cage_free(&cage);
}

/* What an encoding costs is what it comes to, whatever the memory was used for before; and the first bytes tell a stream. */
static void test_cost(void **state)
{
	(void)state;
	struct ffx_work *work = ffx_work_new();
	for (uint64_t seed = 1; seed < 40; seed++) {
		struct cage cage;
		if (!any_random_mesh(&cage, seed))
			continue;
		sample_tag(&cage, 30, 0.05);
		struct ffx ffx = ffx_rounded(&cage, 70);
		ffx.method = seed % 3 ? FFX_FORWARD : FFX_FACE_FIXER;
		ffx.has_frame = ffx_frame_choose(&ffx.frame, (double[]){-1, -2, -3}, 4, ffx_grid_steps(70));
		unsigned char *bytes;
		size_t size;
		struct ffx_report encoded, costed;
		struct fault fault = {0};
		const struct ffx_options options = {.root_limit = 1, .first_root = seed};
		if (ffx_encode(&bytes, &size, &encoded, &ffx, &options, &fault)) {
			const double cost = ffx_cost(work, &ffx, seed, &costed, &fault);
			if (size <= 1024)
				assert_near((double)size, cost, 1.1);
			assert_near(costed.bytes_c + costed.bytes_g + costed.bytes_f,
				    encoded.bytes_c + encoded.bytes_g + encoded.bytes_f, 0);
			assert_int_equal(costed.handle_count, encoded.handle_count);
			assert_true(ffx_cost(work, &ffx, seed, NULL, &fault) == cost);
			assert_true(ffx_is_stream(bytes, size));
			assert_false(ffx_is_stream((const unsigned char *)"ply", 3));
			free(bytes);
		} else {
			assert_true(ffx_cost(work, &ffx, seed, NULL, &fault) == HUGE_VAL);
		}
		free(ffx.grid);
		cage_free(&cage);
	}
	ffx_work_free(work);
}

/* More start edges never make it larger; the same call gives the same bytes. */
static void test_roots_and_repeats(void **state)
{
	(void)state;
	sample_seed(5);
	struct cage cage = sample_plate(2, 2, 0.2, 0.5);
	sample_tag(&cage, 30, 0.05);
	struct ffx ffx = ffx_rounded(&cage, 90);
	size_t one, many, again;
	struct ffx_report report;
	unsigned char *a = round_trip(&ffx, &one, &report, 1), *b = round_trip(&ffx, &many, &report, 0),
		      *c = round_trip(&ffx, &again, &report, 0);
	assert_true(many <= one);
	assert_int_equal(many, again);
	assert_memory_equal(b, c, many);
	free(a);
	free(b);
	free(c);
	free(ffx.grid);
	cage_free(&cage);
}

/* Decoding and encoding again keeps the cage; corner flags and schemes pass. */
static void test_flags_and_schemes(void **state)
{
	(void)state;
	for (uint64_t seed = 1; seed < 40; seed++) {
		struct cage cage;
		if (!any_random_mesh(&cage, seed))
			continue;
		sample_tag(&cage, 40, 0.3); /* many corners and sharp edges at random, darts too */
		cage.scheme = (enum cage_scheme)(seed % 3);
		struct ffx ffx = ffx_scattered(&cage), out;
		unsigned char *bytes;
		size_t size;
		struct ffx_report report;
		struct fault fault = {0};
		if (ffx_encode(&bytes, &size, &report, &ffx, NULL, &fault)) {
			assert_true(ffx_decode(&out, bytes, size, "t.ffx", &fault));
			assert_same_cage(&ffx, &out);
			size_t again_size;
			free(round_trip(&out, &again_size, &report, 2));
			ffx_free(&out);
			free(bytes);
		}
		free(ffx.grid);
		cage_free(&cage);
	}
}

/* Patches come back as the same partition of the faces. */
static void test_patches(void **state)
{
	(void)state;
	struct cage cage = sample_plate(3, 2, 0.2, 0.5);
	sample_tag(&cage, 30, 0);
	struct ffx ffx = ffx_scattered(&cage), out;
	idx_t *patch = mem_array(cage.face_count, sizeof *patch);
	for (size_t f = 0; f < cage.face_count; f++)
		patch[f] = (idx_t)(1000000 - 77 * (f % 5));
	ffx.face_patch = patch;
	size_t size;
	unsigned char *bytes;
	struct ffx_report report;
	struct fault fault = {0};
	assert_true(ffx_encode(&bytes, &size, &report, &ffx, NULL, &fault));
	assert_true(ffx_decode(&out, bytes, size, "t.ffx", &fault));
	assert_non_null(out.face_patch);
	/* Faces are found again by the sum of their corners' places; each old patch must go to one new one. */
	idx_t to[5] = {-1, -1, -1, -1, -1}, most = -1;
	for (size_t f = 0; f < cage.face_count; f++) {
		idx_t found = -1;
		for (size_t g = 0; g < out.face_count && found < 0; g++) {
			int64_t a[3] = {0}, b[3] = {0};
			for (size_t h = ffx.face_start[f]; h < ffx.face_start[f + 1]; h++)
				for (int k = 0; k < 3; k++)
					a[k] += ffx.grid[3 * ffx.face_corner[h] + k];
			for (size_t h = out.face_start[g]; h < out.face_start[g + 1]; h++)
				for (int k = 0; k < 3; k++)
					b[k] += out.grid[3 * out.face_corner[h] + k];
			if (memcmp(a, b, sizeof a) == 0)
				found = out.face_patch[g];
		}
		assert_true(found >= 0 && (to[f % 5] < 0 || to[f % 5] == found));
		to[f % 5] = found;
		most = found > most ? found : most;
	}
	assert_int_equal(most, 4);
	ffx_free(&out);
	free(bytes);
	free(patch);
	free(ffx.grid);
	cage_free(&cage);
}

/* The lowest corner comes back within 1/16 step, the far end within 3/16, and that takes 7 bytes. */
static void test_frame(void **state)
{
	(void)state;
	const double place[][4] = {{0, 0, 0, 1},        {-25, -25, 0, 50},      {12.345678, -987.654321, 0.001, 3.3},
				   {1e6, -2e6, 3e6, 1}, {1e-9, 0, -1e-9, 1e-8}, {-1e30, 1e30, 0, 1e31}};
	struct cage cube = box();
	for (size_t i = 0; i < sizeof place / sizeof *place; i++) {
		for (unsigned code = 20; code < FFX_GRID_CODES; code += 37) {
			struct ffx ffx = ffx_of(&cube, code), out;
			const int32_t steps = ffx_grid_steps(code);
			for (size_t v = 0; v < 24; v++)
				ffx.grid[v] = cube.xyz[v] > 0 ? steps : 0;
			ffx.has_frame = true;
			assert_true(ffx_frame_choose(&ffx.frame, place[i], place[i][3], steps));
			size_t size;
			struct ffx_report report;
			unsigned char *bytes = round_trip(&ffx, &size, &report, 1);
			/* 7 bytes on grids like those of small cages; the others are unusually far away for their size */
			if (i < 2 && steps < 300)
				assert_true(report.bytes_frame <= 7);
			assert_true(report.bytes_frame <= 34);
			struct fault fault = {0};
			assert_true(ffx_decode(&out, bytes, size, "t.ffx", &fault));
			struct cage back;
			ffx_to_cage(&back, &out);
			double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
			for (size_t v = 0; v < 24; v++) {
				low[v % 3] = fmin(low[v % 3], back.xyz[v]);
				high[v % 3] = fmax(high[v % 3], back.xyz[v]);
			}
			for (int k = 0; k < 3; k++) {
				assert_near(low[k], place[i][k], place[i][3] / steps / 15.9);
				assert_near(high[k], place[i][k] + place[i][3], 3 * place[i][3] / steps / 15.9);
			}
			cage_free(&back);
			ffx_free(&out);
			free(bytes);
			free(ffx.grid);
		}
	}
	struct ffx_frame frame;
	assert_false(ffx_frame_choose(&frame, (double[]){1e20, 0, 0}, 1, 100)); /* 1e22 steps from the origin */
	assert_false(ffx_frame_choose(&frame, (double[]){0, 0, 0}, 1e-40, 100));
	cage_free(&cube);
}

/* Steps of the grids: powers of two less one at every 16th code, strictly rising, found again by their number. */
static void test_grids(void **state)
{
	(void)state;
	for (unsigned code = 0; code < FFX_GRID_CODES; code++) {
		if (code % 16 == 0)
			assert_int_equal(ffx_grid_steps(code), (1 << (3 + code / 16)) - 1);
		if (code > 0)
			assert_true(ffx_grid_steps(code) >= ffx_grid_steps(code - 1));
		assert_true(ffx_grid_steps(ffx_grid_code(ffx_grid_steps(code))) == ffx_grid_steps(code));
	}
	assert_int_equal(ffx_grid_code(65536), FFX_GRID_CODES);
}

static void assert_refused(const struct ffx *ffx, const char *message)
{
	unsigned char *bytes;
	size_t size;
	struct ffx_report report;
	struct fault fault = {0};
	assert_false(ffx_encode(&bytes, &size, &report, ffx, NULL, &fault));
	assert_contains(fault.text, message);
}

static void test_refused_cages(void **state)
{
	(void)state;
	struct cage cube = box();
	struct ffx ffx = ffx_rounded(&cube, 50);
	ffx.grid[5] = ffx_grid_steps(50) + 1;
	assert_refused(&ffx, "outside the grid");
	ffx.grid[5] = 0;
	ffx.face_count = 0;
	assert_refused(&ffx, "no faces");
	ffx.face_count = 6;
	idx_t saved = cube.face_corner[1];
	cube.face_corner[1] = cube.face_corner[0];
	assert_refused(&ffx, "twice");
	cube.face_corner[1] = 8;
	assert_refused(&ffx, "does not exist");
	cube.face_corner[1] = cube.face_corner[3], cube.face_corner[3] = saved; /* turned over */
	assert_refused(&ffx, "oriented against");
	cube.face_corner[3] = cube.face_corner[1], cube.face_corner[1] = saved;
	idx_t diagonal[2] = {0, 7};
	ffx.sharp = diagonal;
	ffx.sharp_count = 1;
	assert_refused(&ffx, "no face has an edge");
	free(ffx.grid);
	cage_free(&cube);

	/* Two triangles that share a vertex only. */
	struct cage bow = {0};
	for (int i = 0; i < 5; i++)
		sample_vertex(&bow, i, i * i, 0);
	sample_face(&bow, (idx_t[]){0, 1, 2}, 3);
	sample_face(&bow, (idx_t[]){0, 3, 4}, 3);
	ffx = ffx_rounded(&bow, 50);
	assert_refused(&ffx, "more than one fan");
	free(ffx.grid);
	sample_vertex(&bow, 9, 9, 9);
	bow.face_count = 1;
	ffx = ffx_rounded(&bow, 50);
	assert_refused(&ffx, "has no face");
	free(ffx.grid);
	/* Three triangles at one edge. */
	bow.face_count = 0;
	sample_face(&bow, (idx_t[]){0, 1, 2}, 3);
	sample_face(&bow, (idx_t[]){1, 0, 3}, 3);
	sample_face(&bow, (idx_t[]){0, 1, 4}, 3);
	ffx = ffx_rounded(&bow, 50);
	assert_refused(&ffx, "has 3 faces");
	free(ffx.grid);
	cage_free(&bow);
}

static void assert_stream_refused(const unsigned char *bytes, size_t size, const char *message)
{
	struct fault fault = {0};
	if (ffx_check(bytes, size, "x.ffx", &fault))
		fail_msg("accepted %zu bytes that are wrong: %s", size, message);
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_contains(fault.text, "x.ffx: ");
	assert_contains(fault.text, message);
}

static void test_refused_streams(void **state)
{
	(void)state;
	struct cage cube = box();
	struct ffx ffx = ffx_rounded(&cube, 100);
	ffx.has_frame = true;
	assert_true(ffx_frame_choose(&ffx.frame, (double[]){1, 2, 3}, 4, ffx_grid_steps(100)));
	size_t size;
	struct ffx_report report;
	unsigned char *good = round_trip(&ffx, &size, &report, 1), *bytes = mem_array(size + 8, 1);
	struct fault fault = {0};
	assert_true(ffx_check(good, size, "x.ffx", &fault));
	const struct {
		size_t at;
		unsigned char flip;
		const char *message;
	} change[] = {
		{0, 1, "not an FFX stream"},
		{1, 2, "FFX version 3 is not known here"},
		{1, 12, "unknown subdivision scheme 3"},
		{1, 128, "an unknown flag is set"},
		{2, 128, "there is no grid 228"},
	};
	for (size_t i = 0; i < sizeof change / sizeof *change; i++) {
		memcpy(bytes, good, size);
		const unsigned char was = good[change[i].at];
		bytes[change[i].at] = (unsigned char)(change[i].flip ? was ^ change[i].flip : 0);
		seal(bytes, size);
		assert_stream_refused(bytes, size, change[i].message);
	}
	for (size_t cut = 0; cut < size; cut++)
		assert_stream_refused(good, cut, "");
	for (size_t bit = 0; bit < 8 * size; bit++) {
		memcpy(bytes, good, size);
		bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
		assert_stream_refused(bytes, size, "");
	}
	/* Something behind the payload, with a checksum that knows of it. */
	memcpy(bytes, good, size);
	memset(bytes + size, 0x55, 8);
	seal(bytes, size + 8);
	assert_stream_refused(bytes, size + 8, "damaged: ");
	free(bytes);
	free(good);
	free(ffx.grid);
	cage_free(&cube);
}

/* Cages that compress beyond the decoder's limit on labels are padded, and long streams end in the longer checksum. */
static void test_long_and_regular(void **state)
{
	(void)state;
	struct cage flat = {0};
	const int n = 64;
	for (int i = 0; i < n * n; i++)
		sample_vertex(&flat, i % n, i / n, 0);
	for (int i = 0; i + 1 < n; i++)
		for (int j = 0; j + 1 < n; j++)
			sample_quad(&flat, (idx_t)(j * n + i), (idx_t)(j * n + i + 1), (idx_t)(j * n + i + n + 1),
				    (idx_t)(j * n + i + n));
	struct ffx ffx = ffx_rounded(&flat, ffx_grid_code(63));
	size_t size;
	struct ffx_report report;
	free(round_trip(&ffx, &size, &report, 1));
	assert_true(report.label_count > 4096);
	assert_true(4096 + 64 * size >= report.label_count);
	free(ffx.grid);
	ffx = ffx_scattered(&flat);
	free(round_trip(&ffx, &size, &report, 1));
	assert_true(size > 1024);
	assert_int_equal(report.bytes_header, 3 + 4);
	free(ffx.grid);
	cage_free(&flat);
}

/* Every file under tests/formats/ffx: passed ones decode and encode again, failed ones are refused. Run from the root of the
 * tree. */
static void test_files(void **state)
{
	(void)state;
	for (int passed = 0; passed < 2; passed++) {
		const char *folder = passed ? "tests/formats/ffx/passed" : "tests/formats/ffx/failed";
		DIR *dir = opendir(folder);
		assert_non_null(dir);
		size_t count = 0;
		for (struct dirent *entry; (entry = readdir(dir));) {
			if (entry->d_name[0] == '.')
				continue;
			char path[400];
			snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
			struct input input;
			struct fault fault = {0};
			struct ffx ffx;
			assert_true(input_read(&input, path, &fault));
			const bool is_good = ffx_decode(&ffx, input.data, input.size, path, &fault);
			if (is_good != passed)
				fail_msg("%s: %s", path, is_good ? "was accepted" : fault.text);
			if (is_good) {
				size_t size;
				struct ffx_report report;
				unsigned char *bytes;
				assert_true(ffx_encode(&bytes, &size, &report, &ffx, NULL, &fault));
				free(bytes);
				ffx_free(&ffx);
			}
			input_free(&input);
			count++;
		}
		closedir(dir);
		assert_true(count > 5);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sizes),
		cmocka_unit_test(test_report),
		cmocka_unit_test(test_cost),
		cmocka_unit_test(test_roots_and_repeats),
		cmocka_unit_test(test_flags_and_schemes),
		cmocka_unit_test(test_patches),
		cmocka_unit_test(test_frame),
		cmocka_unit_test(test_grids),
		cmocka_unit_test(test_refused_cages),
		cmocka_unit_test(test_refused_streams),
		cmocka_unit_test(test_long_and_regular),
		cmocka_unit_test(test_files),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
