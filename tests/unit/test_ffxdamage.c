/* Damaged streams with checksums that agree: refused, or a valid cage that can be refined. Never a crash, a hang, much memory.
 *
 *	build/tests/test_ffxdamage [streams]     3000 when not said; 100000 for the full run */
#include "tests/unit/ffx_helpers.h"

#include <sys/resource.h>

#include "stages/geometry/subdivide.h"

static uint64_t stream_count = 3000;

#define BASE_STREAMS 24
#define SIZE_LIMIT 6000

static unsigned char *base_stream(size_t *size, uint64_t seed)
{
	for (;; seed += 1000) {
		struct cage cage;
		if (!any_random_mesh(&cage, seed))
			continue;
		sample_tag(&cage, 30, 0.05);
		struct ffx ffx = ffx_rounded(&cage, 30 + (unsigned)(seed % 100));
		ffx.has_frame = seed % 2 && ffx_frame_choose(&ffx.frame, (double[]){1, 2, 3}, 4, ffx_grid_steps(ffx.grid_code));
		ffx.face_patch = seed % 3 ? NULL : cage.face_patch;
		ffx.method = seed % 4 == 3 ? FFX_FACE_FIXER : FFX_FORWARD;
		unsigned char *bytes = NULL;
		struct ffx_report report;
		struct fault fault = {0};
		const bool is_good = ffx_encode(&bytes, size, &report, &ffx, &(struct ffx_options){.root_limit = 1}, &fault);
		free(ffx.grid);
		cage_free(&cage);
		if (is_good && *size <= SIZE_LIMIT)
			return bytes;
		free(bytes);
	}
}

/* Change stream in place (room: 2 * SIZE_LIMIT); returns its new size. */
static size_t damage(unsigned char *bytes, size_t size, const unsigned char *other, size_t other_size)
{
	for (uint32_t changes = 1 + sample_random(3); changes > 0 && size > 6; changes--) {
		const size_t at = sample_random((uint32_t)size);
		switch (sample_random(6)) {
		case 0:
		case 1:
			bytes[at] ^= (unsigned char)(1 << sample_random(8));
			break;
		case 2:
			bytes[at] = (unsigned char)sample_random(256);
			break;
		case 3:
			size -= sample_random((uint32_t)(size / 2));
			break;
		case 4: /* a piece put in again */ {
			const size_t length = 1 + sample_random(16);
			if (at + length < size && size + length < 2 * SIZE_LIMIT) {
				memmove(bytes + at + length, bytes + at, size - at);
				size += length;
			}
			break;
		}
		default: /* the rest of another stream */
			if (at < other_size) {
				memcpy(bytes + at, other + at, other_size - at);
				size = other_size;
			}
			break;
		}
	}
	return size;
}

static void assert_valid(const struct ffx *ffx)
{
	/* What the encoder accepts is an oriented manifold on the grid. */
	unsigned char *bytes;
	size_t size;
	struct ffx_report report;
	struct fault fault = {0};
	if (!ffx_encode(&bytes, &size, &report, ffx, &(struct ffx_options){.root_limit = 1}, &fault))
		fail_msg("decoded to a wrong cage: %s", fault.text);
	free(bytes);
	struct cage cage;
	ffx_to_cage(&cage, ffx);
	struct level base, refined;
	if (level_from_cage(&base, &cage, &fault)) { /* Loop's rules refuse quads */
		level_refine(&refined, &base, cage.scheme, 1);
		assert_true(refined.face_count >= cage.face_count);
		for (size_t i = 0; i < 3 * refined.vertex_count; i++)
			assert_true(isfinite(refined.xyz[i]));
		level_free(&refined);
		level_free(&base);
	}
	cage_free(&cage);
}

static void test_damage(void **state)
{
	(void)state;
	unsigned char *base[BASE_STREAMS];
	size_t base_size[BASE_STREAMS];
	for (uint64_t i = 0; i < BASE_STREAMS; i++)
		base[i] = base_stream(&base_size[i], i + 1);
	unsigned char *bytes = mem_array(2 * SIZE_LIMIT, 1);
	size_t accepted = 0, refused = 0;
	for (uint64_t n = 0; n < stream_count; n++) {
		sample_seed(n + 77);
		const size_t i = n % BASE_STREAMS, j = sample_random(BASE_STREAMS);
		memcpy(bytes, base[i], base_size[i]);
		const size_t size = damage(bytes, base_size[i], base[j], base_size[j]);
		if (n % 8)
			seal(bytes, size);
		struct ffx ffx;
		struct fault fault = {0};
		if (ffx_decode(&ffx, bytes, size, "damaged", &fault)) {
			assert_valid(&ffx);
			ffx_free(&ffx);
			accepted++;
		} else {
			assert_int_equal(fault.code, EX_BAD_INPUT);
			assert_contains(fault.text, "damaged: ");
			refused++;
		}
	}
	/* Both happen: the damage reaches positions and flags as well as connectivity. */
	assert_true(accepted > stream_count / 50 && refused > stream_count / 50);
	struct rusage usage;
	getrusage(RUSAGE_SELF, &usage);
#ifndef __SANITIZE_ADDRESS__
	assert_true(usage.ru_maxrss < 256 * 1024);
#endif
	for (size_t i = 0; i < BASE_STREAMS; i++)
		free(base[i]);
	free(bytes);
}

/* Streams made of noise behind a good header. */
static void test_noise(void **state)
{
	(void)state;
	for (uint64_t n = 0; n < stream_count / 3; n++) {
		sample_seed(n + 5);
		unsigned char bytes[300];
		const size_t size = 7 + sample_random(sizeof bytes - 7);
		for (size_t i = 0; i < size; i++)
			bytes[i] = (unsigned char)(sample_chance(0.9) ? sample_random(256) : n % 3 == 0 ? 255 : 0);
		bytes[0] = 0xfa;
		bytes[1] = (unsigned char)(FFX_VERSION | (n % 3) << 2 | (n / 3 % 2) << 4 | (n / 6 % 2) << 5 | (n % 2) << 6);
		bytes[2] = (unsigned char)(n % FFX_GRID_CODES);
		seal(bytes, size);
		struct ffx ffx;
		struct fault fault = {0};
		if (ffx_decode(&ffx, bytes, size, "noise", &fault)) {
			assert_valid(&ffx);
			ffx_free(&ffx);
		}
	}
}

int main(int argc, char **argv)
{
	if (argc > 1)
		stream_count = (uint64_t)strtoul(argv[1], NULL, 10);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_damage),
		cmocka_unit_test(test_noise),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
