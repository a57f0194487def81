/* A refined level as a cage: patches, corners and creases come along, and the surface is the same. */
#include "tests/unit/cage_samples.h"

#include "stages/refine/levelcage.h"

/* A cube with a sharp rim on top, one explicit corner on it, and without its bottom: a border. */
static void cage_of_a_level_gives_the_same_surface(void **state)
{
	(void)state;
	struct cage cage = cage_make(cube_xyz, 8, cube_faces + 5, SCHEME_QUADTRI);
	cage_sharpen(&cage, (const int[]){4, 5, 5, 6, 6, 7, 7, 4, -1, -1});
	cage.corner[6] = 1;
	for (size_t f = 0; f < cage.face_count; f++)
		cage.face_patch[f] = 10 + (idx_t)f;
	struct level in = level_make(&cage), l1, want, got;
	level_refine(&l1, &in, cage.scheme, 1);
	level_refine(&want, &in, cage.scheme, 3);
	struct cage next;
	levelcage(&next, &l1, &cage);
	assert_int_equal(next.face_count, 20);
	for (size_t f = 0; f < next.face_count; f++)
		assert_int_equal(next.face_patch[f], 10 + f / 4);
	/* eight halves of the rim; the border is a crease by itself and not listed */
	assert_int_equal(next.sharp_count, 8);
	for (size_t s = 0; s < 8; s++) {
		assert_true(next.sharp[2 * s] < next.sharp[2 * s + 1]);
		assert_true(s == 0 || next.sharp[2 * s - 2] < next.sharp[2 * s] ||
		            (next.sharp[2 * s - 2] == next.sharp[2 * s] && next.sharp[2 * s - 1] < next.sharp[2 * s + 1]));
	}
	for (size_t v = 0; v < next.vertex_count; v++)
		assert_int_equal(next.corner[v], v == 6);
	struct level again = level_make(&next);
	level_refine(&got, &again, next.scheme, 2);
	assert_int_equal(got.vertex_count, want.vertex_count);
	assert_memory_equal(got.xyz, want.xyz, 3 * want.vertex_count * sizeof *want.xyz);
	assert_memory_equal(got.face_corner, want.face_corner, 4 * want.face_count * sizeof *want.face_corner);
	level_free(&in);
	level_free(&want);
	level_free(&got);
	level_free(&again);
	cage_drop(&cage);
	cage_drop(&next);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(cage_of_a_level_gives_the_same_surface),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
