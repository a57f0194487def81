/* Both coders of connectivity: random polygon meshes of any genus, with holes, in several pieces, there and back.
 *
 *	build/tests/test_facefixer [meshes]     1000 when not said; 10000 for the full run */
#include "tests/unit/ffx_helpers.h"

static uint64_t mesh_count = 1000;

/* Genus from the encoder's own count of vertices, edges, faces, holes and components: V - E + F + H = 2 C - 2 G. */
static long genus_of(const struct ffx_report *r)
{
	return (2 * (long)r->component_count - (long)r->vertex_count + (long)r->edge_count - (long)r->face_count -
		(long)r->hole_count) /
	       2;
}

static void assert_counts(const struct ffx_report *report)
{
	/* Face Fixer: one M a handle; one label an edge, and one more a component, whose start edge is told twice. */
	assert_int_equal(report->handle_count, genus_of(report));
	assert_int_equal(report->label_count,
			 report->edge_count + (report->method == FFX_FACE_FIXER ? report->component_count : 0));
}

static void test_random_meshes(void **state)
{
	(void)state;
	size_t coded = 0, refused = 0, with_handles = 0, with_holes = 0, with_pieces = 0, most_handles = 0;
	for (uint64_t seed = 1; seed <= mesh_count; seed++) {
		struct cage cage, other;
		if (!any_random_mesh(&cage, seed))
			continue;
		if (sample_chance(0.15) && any_random_mesh(&other, seed + 1000000)) {
			sample_add(&cage, &other);
			cage_free(&other);
		}
		cage.scheme = (enum cage_scheme)sample_random(3);
		sample_tag(&cage, 30, sample_chance(0.3) ? 0.2 : 0.01);
		struct ffx ffx = ffx_scattered(&cage);
		ffx.method = seed % 2 ? FFX_FORWARD : FFX_FACE_FIXER;
		unsigned char *bytes;
		size_t size;
		struct ffx_report report;
		struct fault fault = {0};
		const struct ffx_options options = {.root_limit = 1};
		if (!ffx_encode(&bytes, &size, &report, &ffx, &options, &fault)) {
			/* Blocks may touch along an edge or at a vertex, holes too; nothing else is wrong with them. */
			if (!strstr(fault.text, "faces") && !strstr(fault.text, "fan"))
				fail_msg("seed %d: %s", (int)seed, fault.text);
			refused++;
		} else {
			free(bytes);
			free(round_trip(&ffx, &size, &report, 1 + sample_random(2)));
			assert_counts(&report);
			coded++;
			with_handles += report.handle_count > 0;
			with_holes += report.hole_count > 0;
			with_pieces += report.component_count > 1;
			most_handles = report.handle_count > most_handles ? report.handle_count : most_handles;
		}
		free(ffx.grid);
		cage_free(&cage);
	}
	/* The sample is what it promises to be. */
	assert_true(coded > mesh_count / 2 && with_handles > mesh_count / 20 && with_holes > mesh_count / 20 &&
		    with_pieces > mesh_count / 40);
	assert_true(most_handles >= 3);
}

/* From every start edge the same cage comes back. */
static void test_every_root(void **state)
{
	(void)state;
	struct cage cage = sample_plate(3, 2, 0.3, 1); /* six holes through a plate: genus 6 */
	sample_tag(&cage, 30, 0);
	struct ffx ffx = ffx_scattered(&cage);
	for (size_t roots = 1; roots < 40; roots++) {
		size_t size;
		struct ffx_report report;
		free(round_trip(&ffx, &size, &report, roots));
		assert_int_equal(report.handle_count, 6);
		assert_counts(&report);
	}
	free(ffx.grid);
	cage_free(&cage);
}

static void assert_mesh(struct cage *cage, size_t vertices, size_t edges, size_t faces, size_t holes, size_t handles,
			size_t components)
{
	struct ffx ffx = ffx_scattered(cage);
	size_t size;
	struct ffx_report report;
	free(round_trip(&ffx, &size, &report, 0));
	assert_int_equal(report.vertex_count, vertices);
	assert_int_equal(report.edge_count, edges);
	assert_int_equal(report.face_count, faces);
	assert_int_equal(report.hole_count, holes);
	assert_int_equal(report.handle_count, handles);
	assert_int_equal(report.component_count, components);
	assert_counts(&report);
	free(ffx.grid);
	cage_free(cage);
}

static struct cage made(const idx_t *faces, size_t face_count, size_t degree, size_t vertices)
{
	struct cage cage = {0};
	for (size_t v = 0; v < vertices; v++)
		sample_vertex(&cage, 0, 0, 0);
	for (size_t f = 0; f < face_count; f++)
		sample_face(&cage, faces + degree * f, degree);
	return cage;
}

static void test_known_meshes(void **state)
{
	(void)state;
	struct cage tetrahedron = made((const idx_t[]){0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}, 4, 3, 4);
	assert_mesh(&tetrahedron, 4, 6, 4, 0, 0, 1);
	const idx_t box[] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
	struct cage cube = made(box, 6, 4, 8);
	assert_mesh(&cube, 8, 12, 6, 0, 0, 1);
	struct cage open_cube = made(box, 5, 4, 8); /* the sixth face is a hole of four edges */
	assert_mesh(&open_cube, 8, 12, 5, 1, 0, 1);
	struct cage triangle = made((const idx_t[]){0, 1, 2}, 1, 3, 3); /* its outside is a hole */
	assert_mesh(&triangle, 3, 3, 1, 1, 0, 1);
	struct cage strip = made((const idx_t[]){0, 1, 3, 2, 2, 3, 5, 4, 4, 5, 7, 6}, 3, 4, 8);
	assert_mesh(&strip, 8, 10, 3, 1, 0, 1);
	struct cage torus = sample_torus(4, 3);
	assert_mesh(&torus, 12, 24, 12, 0, 1, 1);
	struct cage pieces = made(box, 6, 4, 8), ring = sample_torus(3, 3);
	sample_add(&pieces, &ring);
	cage_free(&ring);
	assert_mesh(&pieces, 17, 30, 15, 0, 1, 2);
	const double profile[2][2] = {{1, 0}, {1, 1}};
	struct cage prism = sample_turned(profile, 2, 7, false);
	assert_mesh(&prism, 14, 21, 9, 0, 0, 1);
	struct cage two_holes = sample_plate(2, 1, 0.2, 1); /* a double torus */
	sample_drop_faces(&two_holes, (bool[64]){false});
	const size_t v = two_holes.vertex_count, f = two_holes.face_count, e = v + f + 2; /* V - E + F = 2 - 2 * 2 */
	assert_mesh(&two_holes, v, e, f, 0, 2, 1);
}

/* Time grows with the mesh, not with its square: 16 times the faces must not take 64 times as long. */
static void test_linear(void **state)
{
	(void)state;
	double seconds[2] = {0};
	for (int i = 0; i < 2; i++) {
		const int n = i ? 80 : 20;
		struct cage cage = sample_torus(n, n);
		struct ffx ffx = ffx_scattered(&cage);
		struct timespec start, end;
		clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &start);
		size_t size;
		struct ffx_report report;
		free(round_trip(&ffx, &size, &report, 1));
		clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
		seconds[i] = (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
		free(ffx.grid);
		cage_free(&cage);
	}
	assert_true(seconds[1] < 64 * seconds[0] + 0.05);
}

int main(int argc, char **argv)
{
	if (argc > 1)
		mesh_count = (uint64_t)strtoul(argv[1], NULL, 10);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_known_meshes),
		cmocka_unit_test(test_every_root),
		cmocka_unit_test(test_random_meshes),
		cmocka_unit_test(test_linear),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
