/* Reading foreign meshes, welding, bounds. */
#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "formats/mesh.h"

static struct input text_input(const char *shown, const char *text)
{
	return (struct input){shown, (unsigned char *)text, strlen(text)};
}

static bool read_text(struct mesh *mesh, const char *shown, const char *text, struct fault *fault)
{
	const struct input input = text_input(shown, text);
	*fault = (struct fault){0};
	return mesh_read(mesh, &input, fault);
}

static int compare_names(const void *a, const void *b)
{
	return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* The files of a folder, sorted; returns how many. */
static size_t list_folder(char **name, size_t most, const char *folder)
{
	DIR *directory = opendir(folder);
	assert_non_null(directory);
	size_t count = 0;
	for (struct dirent *entry; (entry = readdir(directory));)
		if (entry->d_name[0] != '.') {
			assert_true(count < most);
			name[count++] = strdup(entry->d_name);
		}
	closedir(directory);
	qsort(name, count, sizeof *name, compare_names);
	return count;
}

/* Every file that must be read is; every one that must be refused is, with the message that messages.txt has for it. */
static void conform(const char *kind)
{
	char path[200], *name[100], line[500];
	snprintf(path, sizeof path, "tests/formats/%s/passed", kind);
	size_t count = list_folder(name, 100, path);
	assert_true(count >= 8);
	for (size_t i = 0; i < count; i++) {
		struct input input;
		struct mesh mesh;
		struct fault fault = {0};
		snprintf(path, sizeof path, "tests/formats/%s/passed/%s", kind, name[i]);
		if (!input_read(&input, path, &fault) || !mesh_read(&mesh, &input, &fault))
			fail_msg("%s", fault.text);
		mesh_free(&mesh);
		input_free(&input);
		free(name[i]);
	}
	snprintf(path, sizeof path, "tests/formats/%s/messages.txt", kind);
	FILE *messages = fopen(path, "r");
	assert_non_null(messages);
	snprintf(path, sizeof path, "tests/formats/%s/failed", kind);
	count = list_folder(name, 100, path);
	assert_true(count >= 15);
	for (size_t i = 0; i < count; i++) {
		struct input input;
		struct mesh mesh;
		struct fault fault = {0};
		snprintf(path, sizeof path, "tests/formats/%s/failed/%s", kind, name[i]);
		assert_true(input_read(&input, path, &fault));
		if (mesh_read(&mesh, &input, &fault))
			fail_msg("%s was read", path);
		assert_int_equal(fault.code, EX_BAD_INPUT);
		assert_non_null(fgets(line, sizeof line, messages)); /* in the order of the names */
		line[strcspn(line, "\n")] = 0;
		assert_string_equal(fault.text + strlen(path) - strlen(name[i]), line);
		input_free(&input);
		free(name[i]);
	}
	assert_null(fgets(line, sizeof line, messages));
	fclose(messages);
}

static void off_conforms(void **state)
{
	(void)state, conform("off");
}
static void obj_conforms(void **state)
{
	(void)state, conform("obj");
}
static void stl_conforms(void **state)
{
	(void)state, conform("stl");
}
static void om_conforms(void **state)
{
	(void)state, conform("om");
}

static void off_keeps_doubles(void **state)
{
	(void)state;
	struct mesh mesh;
	struct fault fault;
	/* 0.1 and 1/3 are no floats; 1e39 is beyond them. */
	assert_true(read_text(&mesh, "a.off", "OFF\n3 1 0\n0.1 0 0\n0.3333333333333333 1 0\n0 1e39 0\n3 0 1 2\n", &fault));
	assert_true(mesh.xyz[0] == 0.1 && mesh.xyz[3] == 0.3333333333333333 && mesh.xyz[7] == 1e39);
	mesh_free(&mesh);
}

static void obj_indices_from_the_end(void **state)
{
	(void)state;
	struct mesh mesh;
	struct fault fault;
	/* -1 is the last vertex before the face, not of the file. */
	assert_true(read_text(&mesh, "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf 1 2 -1\n", &fault));
	const idx_t want[] = {0, 1, 2, 0, 1, 3};
	assert_int_equal(mesh.face_count, 2);
	assert_memory_equal(mesh.corner, want, sizeof want);
	mesh_free(&mesh);
}

static void stl_stays_unwelded(void **state)
{
	(void)state;
	struct mesh mesh;
	struct fault fault;
	static const char text[] =
		"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
		"facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
	assert_true(read_text(&mesh, "a.stl", text, &fault));
	assert_true(mesh_is_unwelded(&mesh));
	assert_int_equal(mesh.vertex_count, 6);
	assert_int_equal(mesh.face_count, 2); /* the collapsed one too: whoever drops it says so */
	mesh_free(&mesh);
}

static void kinds_are_known_by_content(void **state)
{
	(void)state;
	struct mesh mesh;
	struct fault fault;
	assert_true(read_text(&mesh, "<stdin>", "# hello\nOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", &fault));
	mesh_free(&mesh);
	assert_true(read_text(&mesh, "<stdin>",
			      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
			      "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
			      &fault));
	assert_int_equal(mesh.face_count, 1);
	mesh_free(&mesh);
	/* The content against the name. */
	assert_true(read_text(&mesh, "part.stl", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", &fault));
	mesh_free(&mesh);
	assert_false(read_text(&mesh, "<stdin>", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
}

static void ply_is_checked(void **state)
{
	(void)state;
	struct mesh mesh;
	struct fault fault;
	static const char head[] =
		"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
		"element face 1\nproperty list uchar int vertex_indices\nend_header\n";
	static const char *const bad[] = {"0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
					  "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
					  "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n",
					  "0 0 0\n1 0 0\n0 1 0\n2 0 1\n",
					  "0 0 0\n1 0 0\n0 1 0\n3 0 1\n",
					  "0 0 0\n1 0 0\n",
					  ""};
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
		char text[400];
		snprintf(text, sizeof text, "%s%s", head, bad[i]);
		assert_false(read_text(&mesh, "a.ply", text, &fault));
		assert_int_equal(fault.code, EX_BAD_INPUT);
		assert_true(strncmp(fault.text, "a.ply:", 6) == 0);
	}
}

/* Written by OpenMesh 9 from four triangles around a corner; half-edges give each face back, beginning anywhere. */
static void om_faces_are_walked(void **state)
{
	(void)state;
	static const idx_t want[4][3] = {{0, 3, 2}, {0, 2, 1}, {0, 1, 4}, {1, 2, 4}};
	struct input input;
	struct mesh mesh;
	struct fault fault = {0};
	assert_true(input_read(&input, "tests/formats/om/passed/polygons_version_2.om", &fault));
	assert_true(mesh_read(&mesh, &input, &fault));
	assert_int_equal(mesh.vertex_count, 5);
	assert_int_equal(mesh.face_count, 4);
	assert_true(mesh.xyz[12] == 0.1f && mesh.xyz[13] == 0 && mesh.xyz[14] == 1);
	for (size_t f = 0; f < 4; f++) {
		const idx_t *c = mesh.corner + 3 * f;
		assert_int_equal(mesh.face_start[f + 1], 3 * (f + 1));
		bool same = false;
		for (int turn = 0; turn < 3; turn++)
			same |= c[0] == want[f][turn] && c[1] == want[f][(turn + 1) % 3] && c[2] == want[f][(turn + 2) % 3];
		assert_true(same);
	}
	mesh_free(&mesh);
	input_free(&input);
}

static void build(struct mesh *mesh, const double *xyz, size_t vertices, const idx_t *corner, size_t triangles)
{
	*mesh = (struct mesh){mem_copy(xyz, 3 * vertices, sizeof *xyz), vertices, mem_copy(corner, 3 * triangles, sizeof *corner),
			      mem_array(triangles + 1, sizeof(size_t)), triangles};
	for (size_t f = 0; f <= triangles; f++)
		mesh->face_start[f] = 3 * f;
}

static void weld_exact(void **state)
{
	(void)state;
	struct mesh mesh;
	/* 3 lies where 0 does, its zero with the other sign; 4 misses 1 by the last bit. */
	const double xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, -0.0, 0, -0.0, nextafter(1, 2), 0, 0};
	const idx_t corner[] = {0, 1, 2, 3, 4, 2};
	build(&mesh, xyz, 5, corner, 2);
	idx_t map[5];
	assert_int_equal(mesh_weld(&mesh, 0, map), 1);
	const idx_t want[] = {0, 1, 2, 0, 3}, faces[] = {0, 1, 2, 0, 3, 2};
	assert_memory_equal(map, want, sizeof want);
	assert_memory_equal(mesh.corner, faces, sizeof faces);
	assert_int_equal(mesh.vertex_count, 4);
	assert_true(mesh.xyz[9] == nextafter(1, 2));
	mesh_free(&mesh);
}

static void weld_chains_within_tolerance(void **state)
{
	(void)state;
	struct mesh mesh;
	/* 0, 0.9, 1.8 are a chain of steps below 1, though its ends are 1.8 apart; 3 is 1.2 from the last. */
	const double xyz[] = {0.9, 0, 0, 3, 0, 0, 1.8, 0, 0, 0, 0, 0};
	const idx_t corner[] = {0, 1, 2, 1, 2, 3};
	build(&mesh, xyz, 4, corner, 2);
	assert_int_equal(mesh_weld(&mesh, 1, NULL), 2);
	assert_true(mesh.xyz[0] == 0.9 && mesh.xyz[3] == 3); /* the first of a group stays where it is */
	mesh_free(&mesh);
}

/* Against all pairs, on random points: the grid looks at every neighbour that it must. */
static void weld_equals_brute_force(void **state)
{
	(void)state;
	enum { COUNT = 600 };
	double xyz[3 * COUNT];
	uint32_t seed = 12345;
	for (size_t i = 0; i < 3 * COUNT; i++) {
		seed = seed * 1664525u + 1013904223u;
		xyz[i] = (double)(seed >> 8) / (1 << 24);
	}
	const idx_t corner[] = {0, 1, 2};
	for (double tolerance = 0.02; tolerance < 0.2; tolerance *= 2) {
		idx_t parent[COUNT], map[COUNT];
		for (idx_t i = 0; i < COUNT; i++)
			parent[i] = i;
		for (bool changed = true; changed;) {
			changed = false;
			for (size_t i = 0; i < COUNT; i++)
				for (size_t j = 0; j < i; j++) {
					const double dx = xyz[3 * i] - xyz[3 * j], dy = xyz[3 * i + 1] - xyz[3 * j + 1],
						     dz = xyz[3 * i + 2] - xyz[3 * j + 2];
					if (dx * dx + dy * dy + dz * dz > tolerance * tolerance || parent[i] == parent[j])
						continue;
					parent[i] = parent[j] = parent[i] < parent[j] ? parent[i] : parent[j];
					changed = true;
				}
		}
		struct mesh mesh;
		build(&mesh, xyz, COUNT, corner, 1);
		mesh_weld(&mesh, tolerance, map);
		for (size_t i = 0; i < COUNT; i++)
			for (size_t j = 0; j < i; j++)
				assert_int_equal(map[i] == map[j], parent[i] == parent[j]);
		mesh_free(&mesh);
	}
}

static void bounds(void **state)
{
	(void)state;
	const double xyz[] = {1, 2, 3, -1, 5, 3};
	double low[3], high[3];
	assert_true(mesh_bounds(xyz, 2, low, high) == 3);
	assert_true(low[0] == -1 && low[1] == 2 && low[2] == 3 && high[0] == 1 && high[1] == 5 && high[2] == 3);
	assert_true(mesh_bounds(NULL, 0, NULL, NULL) == 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(off_conforms),
		cmocka_unit_test(obj_conforms),
		cmocka_unit_test(stl_conforms),
		cmocka_unit_test(om_conforms),
		cmocka_unit_test(off_keeps_doubles),
		cmocka_unit_test(obj_indices_from_the_end),
		cmocka_unit_test(stl_stays_unwelded),
		cmocka_unit_test(kinds_are_known_by_content),
		cmocka_unit_test(ply_is_checked),
		cmocka_unit_test(om_faces_are_walked),
		cmocka_unit_test(weld_exact),
		cmocka_unit_test(weld_chains_within_tolerance),
		cmocka_unit_test(weld_equals_brute_force),
		cmocka_unit_test(bounds),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
