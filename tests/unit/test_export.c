/* What export writes, mesh_read reads back. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "formats/export.h"

/* A quad and a pentagon with coordinates that are no floats. */
static struct mesh sample(void)
{
	static const double xyz[] = {0, 0, 0, 1.0 / 3, 0, 0, 1, 1, 0, 0, 0.1, 0, -1e-7, -2.5, 1e20, 3, -1, 0};
	static const idx_t corner[] = {0, 1, 2, 3, 5, 2, 1, 0, 4};
	static const size_t start[] = {0, 4, 9};
	return (struct mesh){mem_copy(xyz, 18, sizeof *xyz), 6, mem_copy(corner, 9, sizeof *corner),
			     mem_copy(start, 3, sizeof *start), 2};
}

static void write_to(char **data, size_t *size, const char *extension, const struct mesh *mesh, bool binary)
{
	struct fault fault = {0};
	FILE *file = open_memstream(data, size);
	assert_non_null(file);
	assert_true(export_mesh(file, extension, mesh, binary, &fault));
	assert_int_equal(fclose(file), 0);
}

static struct mesh read_back(const char *shown, char *data, size_t size)
{
	const struct input input = {shown, (unsigned char *)data, size};
	struct fault fault = {0};
	struct mesh mesh;
	if (!mesh_read(&mesh, &input, &fault))
		fail_msg("%s", fault.text);
	return mesh;
}

/* Indexed formats lose nothing, and write the same bytes when they write what they read. */
static void indexed_formats_are_exact(void **state)
{
	(void)state;
	static const struct {
		const char *extension, *shown;
		bool binary;
	} way[] = {{"ply", "a.ply", false}, {"ply", "a.ply", true}, {"off", "a.off", false}, {"obj", "a.obj", false}};
	for (size_t i = 0; i < sizeof way / sizeof *way; i++) {
		struct mesh mesh = sample();
		char *data, *again;
		size_t size, again_size;
		write_to(&data, &size, way[i].extension, &mesh, way[i].binary);
		struct mesh back = read_back(way[i].shown, data, size);
		assert_int_equal(back.vertex_count, mesh.vertex_count);
		assert_int_equal(back.face_count, mesh.face_count);
		assert_memory_equal(back.xyz, mesh.xyz, 18 * sizeof *mesh.xyz);
		assert_memory_equal(back.corner, mesh.corner, 9 * sizeof *mesh.corner);
		assert_memory_equal(back.face_start, mesh.face_start, 3 * sizeof *mesh.face_start);
		write_to(&again, &again_size, way[i].extension, &back, way[i].binary);
		assert_int_equal(again_size, size);
		assert_memory_equal(again, data, size);
		free(data), free(again);
		mesh_free(&mesh), mesh_free(&back);
	}
}

/* Vertex 1 lies between the two faces, on the way 0 1 2 that they share: both are fans around it. */
static void stl_cuts_polygons(void **state)
{
	(void)state;
	static const idx_t want[] = {1, 2, 3, 1, 3, 0, 1, 0, 4, 1, 4, 5, 1, 5, 2};
	for (int as_text = 0; as_text < 2; as_text++) {
		struct mesh mesh = sample();
		char *data;
		size_t size;
		write_to(&data, &size, as_text ? "stla" : "stl", &mesh, false);
		if (!as_text)
			assert_int_equal(size, 84 + 50 * 5);
		struct mesh back = read_back("a.stl", data, size);
		assert_int_equal(back.face_count, 5);
		for (size_t h = 0; h < 15; h++)
			for (size_t i = 0; i < 3; i++)
				assert_true((float)back.xyz[3 * h + i] == (float)mesh.xyz[3 * (size_t)want[h] + i]);
		free(data);
		mesh_free(&mesh), mesh_free(&back);
	}
}

/* Both diagonals of a square are equally long: that from the lowest vertex is taken, wherever the list begins. */
static void stl_ties_by_lowest_vertex(void **state)
{
	(void)state;
	const double xyz[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
	for (idx_t first = 0; first < 4; first++) {
		const idx_t corner[] = {first, (first + 1) % 4, (first + 2) % 4, (first + 3) % 4};
		const size_t start[] = {0, 4};
		struct mesh mesh = {mem_copy(xyz, 12, sizeof *xyz), 4, mem_copy(corner, 4, sizeof *corner),
				    mem_copy(start, 2, sizeof *start), 1};
		char *data;
		size_t size;
		write_to(&data, &size, "stl", &mesh, false);
		struct mesh back = read_back("a.stl", data, size);
		int at_origin = 0;
		for (size_t h = 0; h < 6; h++)
			at_origin += back.xyz[3 * h] == 0 && back.xyz[3 * h + 1] == 0;
		assert_int_equal(at_origin, 2); /* both triangles have vertex 0 */
		free(data);
		mesh_free(&mesh), mesh_free(&back);
	}
}

static void stl_refuses_what_is_no_float(void **state)
{
	(void)state;
	struct mesh mesh = sample();
	mesh.xyz[4] = 1e39;
	struct fault fault = {0};
	char *data;
	size_t size;
	FILE *file = open_memstream(&data, &size);
	assert_false(export_mesh(file, "stl", &mesh, false, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	fclose(file);
	free(data);
	mesh_free(&mesh);
}

/* A cube whose top is two quads around a tip that only they have: the diagonals from corner to corner are the shorter ones, but would
 * be one edge of four triangles. Cut through the tip all edges have two. */
static void stl_keeps_edges_apart(void **state)
{
	(void)state;
	static const double xyz[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 0.5, 0.5, 4};
	static const idx_t corner[] = {3, 2, 1, 0, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7, 4, 5, 8, 7, 5, 6, 7, 8};
	static const size_t start[] = {0, 4, 8, 12, 16, 20, 24, 28};
	struct mesh mesh = {mem_copy(xyz, 27, sizeof *xyz), 9, mem_copy(corner, 28, sizeof *corner), mem_copy(start, 8, sizeof *start), 7};
	char *data;
	size_t size;
	write_to(&data, &size, "stl", &mesh, false);
	struct mesh back = read_back("a.stl", data, size);
	mesh_weld(&back, 0, NULL);
	assert_int_equal(back.vertex_count, 9);
	assert_int_equal(back.face_count, 14);
	int uses[9][9] = {{0}};
	for (size_t h = 0; h < 3 * back.face_count; h++)
		uses[back.corner[h]][back.corner[h % 3 == 2 ? h - 2 : h + 1]]++;
	for (int a = 0; a < 9; a++)
		for (int b = 0; b < 9; b++)
			assert_true(uses[a][b] <= 1);
	free(data);
	mesh_free(&mesh);
	mesh_free(&back);
}

static void unknown_formats_are_refused(void **state)
{
	(void)state;
	assert_true(export_knows("ply") && export_knows("stl") && export_knows("stla") && export_knows("off") &&
		    export_knows("obj"));
	assert_false(export_knows("") || export_knows("step") || export_knows("STL"));
	struct mesh mesh = sample();
	struct fault fault = {0};
	assert_false(export_mesh(stderr, "step", &mesh, false, &fault));
	assert_int_equal(fault.code, EX_BAD_USAGE);
	mesh_free(&mesh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(indexed_formats_are_exact),   cmocka_unit_test(stl_cuts_polygons),
		cmocka_unit_test(stl_ties_by_lowest_vertex),   cmocka_unit_test(stl_refuses_what_is_no_float),
		cmocka_unit_test(stl_keeps_edges_apart),       cmocka_unit_test(unknown_formats_are_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
