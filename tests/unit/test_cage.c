#include "tests/unit/helpers.h"

#include "formats/cage.h"

static const char head[] = "ply\nformat ascii 1.0\ncomment cagewright scheme quadtri\ncomment kept\n";
static const char body[] =
	"element vertex 5\nproperty float x\nproperty float y\nproperty float z\nproperty uchar corner\n"
	"element face 3\nproperty list uchar int vertex_indices\nproperty int patch\n"
	"element edge 5\nproperty int vertex1\nproperty int vertex2\nproperty uchar sharp\nend_header\n"
	"0 0 0 0\n1 0 0 0\n1 1 0 1\n0 1 0 0\n2 0.5 0 0\n"
	"3 0 1 2 4\n3 0 2 3 5\n3 1 4 2 4\n";

static bool read_cage(struct cage *cage, struct ply *ply, const char *edges, struct fault *fault)
{
	char text[2000];
	snprintf(text, sizeof text, "%s%s%s", head, body, edges);
	return ply_of(ply, text, fault) && cage_from_ply(cage, ply, "t.ply", fault);
}

static void reads_a_cage(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply ply;
	struct cage cage;
	/* 0 2 and 2 1 are inner edges (the latter named twice), 0 1 is border, 2 3 not sharp */
	assert_true(read_cage(&cage, &ply, "2 1 1\n1 0 1\n0 2 1\n1 2 1\n2 3 0\n", &fault));
	assert_int_equal(cage.scheme, SCHEME_QUADTRI);
	assert_int_equal(cage.vertex_count, 5);
	assert_int_equal(cage.face_count, 3);
	assert_int_equal(cage.face_start[2], 6);
	assert_int_equal(cage.face_corner[6], 1);
	assert_int_equal(cage.face_patch[1], 5);
	assert_int_equal(cage.corner[2], 1);
	assert_null(cage.net);
	/* sorted, lower vertex first, once, without the border edge */
	assert_int_equal(cage.sharp_count, 2);
	const idx_t sharp[4] = {0, 2, 1, 2};
	assert_memory_equal(cage.sharp, sharp, sizeof sharp);
	cage_free(&cage);
	ply_free(&ply);
}

static void comes_back(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply ply, copy;
	struct cage cage, back;
	assert_true(read_cage(&cage, &ply, "2 1 1\n1 0 0\n0 2 1\n1 2 1\n2 3 0\n", &fault));
	static const idx_t net[5] = {3, -1, -1, 0, 7};
	cage.net = mem_copy(net, 5, sizeof *net);
	for (int scheme = SCHEME_QUADTRI; scheme <= SCHEME_CATMULLCLARK; scheme++) {
		cage.scheme = (enum cage_scheme)scheme;
		ply_init(&copy);
		/* the comment is replaced, others stay */
		ply_comment(&copy, "cagewright scheme loop");
		ply_comment(&copy, "kept");
		cage_to_ply(&copy, &cage);
		assert_int_equal(copy.comment_count, 2);
		assert_string_equal(copy.comment[0], "comment kept");
		assert_true(cage_from_ply(&back, &copy, "t.ply", &fault));
		assert_int_equal(back.scheme, scheme);
		assert_memory_equal(back.xyz, cage.xyz, 15 * sizeof *cage.xyz);
		assert_memory_equal(back.corner, cage.corner, 5);
		assert_memory_equal(back.net, net, sizeof net);
		assert_memory_equal(back.face_corner, cage.face_corner, 9 * sizeof *cage.face_corner);
		assert_memory_equal(back.face_start, cage.face_start, 4 * sizeof *cage.face_start);
		assert_memory_equal(back.face_patch, cage.face_patch, 3 * sizeof *cage.face_patch);
		assert_int_equal(back.sharp_count, cage.sharp_count);
		assert_memory_equal(back.sharp, cage.sharp, 2 * cage.sharp_count * sizeof *cage.sharp);
		cage_free(&back);
		ply_free(&copy);
	}
	cage_free(&cage);
	ply_free(&ply);
}

static void passes_unknown_elements(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply ply;
	struct cage cage;
	assert_true(read_cage(&cage, &ply, "2 1 1\n1 0 0\n0 2 1\n1 2 1\n2 3 0\n", &fault));
	ply_put_scalar(ply_put_element(&ply, "patch", 1), "kind", PLY_UINT8)[0] = 3;
	cage_to_ply(&ply, &cage);
	assert_true(ply_column(ply_element(&ply, "patch"), "kind")->value[0] == 3);
	assert_string_equal(ply.comment[0], "comment kept");
	cage_free(&cage);
	ply_free(&ply);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(reads_a_cage),
		cmocka_unit_test(comes_back),
		cmocka_unit_test(passes_unknown_elements),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
