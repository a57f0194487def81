/* Meshes for other programs. */
#include "formats/export.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "formats/number.h"

bool export_knows(const char *extension)
{
	static const char *const known[] = {"ply", "obj", "off", "stl", "stla"};
	for (size_t i = 0; i < sizeof known / sizeof *known; i++)
		if (strcmp(extension, known[i]) == 0)
			return true;
	return false;
}

static void put_number(FILE *file, double value)
{
	char text[NUM_TEXT_SIZE];
	const size_t length = num_print(text, value);
	fwrite(text, 1, length, file);
}

static void put_points(FILE *file, const char *before, const struct mesh *mesh)
{
	for (size_t v = 0; v < mesh->vertex_count; v++) {
		fputs(before, file);
		for (size_t i = 0; i < 3; i++) {
			if (i)
				putc(' ', file);
			put_number(file, mesh->xyz[3 * v + i]);
		}
		putc('\n', file);
	}
}

/* "4 0 1 2 3" or, for OBJ, "f 1 2 3 4". */
static void put_faces(FILE *file, bool with_count, idx_t base, const struct mesh *mesh)
{
	for (size_t f = 0; f < mesh->face_count; f++) {
		if (with_count)
			fprintf(file, "%zu", mesh->face_start[f + 1] - mesh->face_start[f]);
		else
			putc('f', file);
		for (size_t h = mesh->face_start[f]; h < mesh->face_start[f + 1]; h++)
			fprintf(file, " %lld", (long long)mesh->corner[h] + base);
		putc('\n', file);
	}
}

static void write_off(FILE *file, const struct mesh *mesh)
{
	fprintf(file, "OFF\n%zu %zu 0\n", mesh->vertex_count, mesh->face_count);
	put_points(file, "", mesh);
	put_faces(file, true, 0, mesh);
}

static void write_obj(FILE *file, const struct mesh *mesh)
{
	put_points(file, "v ", mesh);
	put_faces(file, false, 1, mesh);
}

static void put_little(FILE *file, uint64_t bits, int bytes)
{
	for (int i = 0; i < bytes; i++)
		putc((int)(bits >> 8 * i & 255), file);
}

static void put_float(FILE *file, float value)
{
	uint32_t bits;
	memcpy(&bits, &value, sizeof bits);
	put_little(file, bits, 4);
}

static void put_double(FILE *file, double value)
{
	uint64_t bits;
	memcpy(&bits, &value, sizeof bits);
	put_little(file, bits, 8);
}

static void write_ply(FILE *file, const struct mesh *mesh, bool binary)
{
	size_t longest = 0;
	for (size_t f = 0; f < mesh->face_count; f++)
		if (mesh->face_start[f + 1] - mesh->face_start[f] > longest)
			longest = mesh->face_start[f + 1] - mesh->face_start[f];
	const bool wide = longest > 255;
	fprintf(file, "ply\nformat %s 1.0\nelement vertex %zu\nproperty double x\nproperty double y\nproperty double z\n",
		binary ? "binary_little_endian" : "ascii", mesh->vertex_count);
	fprintf(file, "element face %zu\nproperty list %s int vertex_indices\nend_header\n", mesh->face_count,
		wide ? "int" : "uchar");
	if (!binary) {
		put_points(file, "", mesh);
		put_faces(file, true, 0, mesh);
		return;
	}
	for (size_t i = 0; i < 3 * mesh->vertex_count; i++)
		put_double(file, mesh->xyz[i]);
	for (size_t f = 0; f < mesh->face_count; f++) {
		put_little(file, mesh->face_start[f + 1] - mesh->face_start[f], wide ? 4 : 1);
		for (size_t h = mesh->face_start[f]; h < mesh->face_start[f + 1]; h++)
			put_little(file, (uint32_t)mesh->corner[h], 4);
	}
}

/* A facet as floats, with its unit normal (0 for a collapsed one, as the format's own readers expect). */
struct facet {
	float normal[3], corner[3][3];
};

static struct facet facet_of(const struct mesh *mesh, idx_t a, idx_t b, idx_t c)
{
	struct facet facet;
	const idx_t corner[3] = {a, b, c};
	double p[3][3], n[3];
	for (size_t k = 0; k < 3; k++)
		for (size_t i = 0; i < 3; i++) {
			p[k][i] = mesh->xyz[3 * (size_t)corner[k] + i];
			facet.corner[k][i] = (float)p[k][i];
		}
	for (int i = 0; i < 3; i++) {
		const int j = (i + 1) % 3, k = (i + 2) % 3;
		n[i] = (p[1][j] - p[0][j]) * (p[2][k] - p[0][k]) - (p[1][k] - p[0][k]) * (p[2][j] - p[0][j]);
	}
	const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
	for (int i = 0; i < 3; i++)
		facet.normal[i] = length > 0 ? (float)(n[i] / length) : 0;
	return facet;
}

static void put_facet_text(FILE *file, const struct facet *facet)
{
	char text[NUM_TEXT_SIZE];
	fputs("facet normal", file);
	for (int i = 0; i < 3; i++) {
		num_print_float(text, facet->normal[i]);
		fprintf(file, " %s", text);
	}
	fputs("\nouter loop\n", file);
	for (int k = 0; k < 3; k++) {
		fputs("vertex", file);
		for (int i = 0; i < 3; i++) {
			num_print_float(text, facet->corner[k][i]);
			fprintf(file, " %s", text);
		}
		putc('\n', file);
	}
	fputs("endloop\nendfacet\n", file);
}

static void put_facet(FILE *file, const struct facet *facet, bool as_text)
{
	if (as_text) {
		put_facet_text(file, facet);
		return;
	}
	for (int i = 0; i < 3; i++)
		put_float(file, facet->normal[i]);
	for (int k = 0; k < 3; k++)
		for (int i = 0; i < 3; i++)
			put_float(file, facet->corner[k][i]);
	put_little(file, 0, 2);
}

static double squared_length(const struct mesh *mesh, idx_t a, idx_t b)
{
	double sum = 0;
	for (size_t i = 0; i < 3; i++) {
		const double d = mesh->xyz[3 * (size_t)a + i] - mesh->xyz[3 * (size_t)b + i];
		sum += d * d;
	}
	return sum;
}

/* Which vertices lie between two faces that have both their edges: there the neighbours after and before them are the same. */
static unsigned char *find_tips(const struct mesh *mesh)
{
	unsigned char *faces = mem_array(mesh->vertex_count, 1);
	int64_t *open = mem_array(mesh->vertex_count, sizeof *open);
	for (size_t f = 0; f < mesh->face_count; f++)
		for (size_t low = mesh->face_start[f], high = mesh->face_start[f + 1], i = low; i < high; i++) {
			const idx_t v = mesh->corner[i];
			if (faces[v] < 3)
				faces[v]++;
			open[v] += mesh->corner[i + 1 < high ? i + 1 : low] - mesh->corner[i > low ? i - 1 : high - 1];
		}
	for (size_t v = 0; v < mesh->vertex_count; v++)
		faces[v] = faces[v] == 2 && open[v] == 0;
	free(open);
	return faces;
}

/* From which corner the fan of a face starts: a tip, as the other diagonals of its two faces would be one edge of four
 * triangles; else a quad's shorter diagonal, of equal ones that with the lowest vertex. */
static size_t fan_start(const struct mesh *mesh, const unsigned char *tip, const idx_t *corner, size_t count)
{
	for (size_t i = 0; count > 3 && i < count; i++)
		if (tip[corner[i]])
			return i;
	if (count != 4)
		return 0;
	const double even = squared_length(mesh, corner[0], corner[2]), odd = squared_length(mesh, corner[1], corner[3]);
	if (even != odd)
		return odd < even;
	const idx_t lowest_even = corner[0] < corner[2] ? corner[0] : corner[2],
		    lowest_odd = corner[1] < corner[3] ? corner[1] : corner[3];
	return lowest_odd < lowest_even;
}

static bool write_stl(FILE *file, const struct mesh *mesh, bool as_text, struct fault *fault)
{
	size_t count = 0;
	for (size_t i = 0; i < 3 * mesh->vertex_count; i++)
		if (!isfinite((float)mesh->xyz[i]))
			return fault_set(fault, EX_BAD_INPUT, "vertex %zu: coordinate %.3g is too large for STL", i / 3,
					 mesh->xyz[i]);
	for (size_t f = 0; f < mesh->face_count; f++)
		count += mesh->face_start[f + 1] - mesh->face_start[f] - 2;
	if (count > UINT32_MAX)
		return fault_set(fault, EX_BAD_INPUT, "%zu facets are too many for STL", count);
	if (as_text) {
		fputs("solid cagewright\n", file);
	} else {
		char header[80] = "binary STL"; /* must not begin with "solid" */
		fwrite(header, 1, sizeof header, file);
		put_little(file, count, 4);
	}
	unsigned char *tip = find_tips(mesh);
	for (size_t f = 0; f < mesh->face_count; f++) {
		const idx_t *corner = mesh->corner + mesh->face_start[f];
		const size_t corners = mesh->face_start[f + 1] - mesh->face_start[f];
		const size_t first = fan_start(mesh, tip, corner, corners);
		for (size_t k = 1; k + 1 < corners; k++) {
			const struct facet facet =
				facet_of(mesh, corner[first], corner[(first + k) % corners], corner[(first + k + 1) % corners]);
			put_facet(file, &facet, as_text);
		}
	}
	free(tip);
	if (as_text)
		fputs("endsolid cagewright\n", file);
	return true;
}

bool export_mesh(FILE *file, const char *extension, const struct mesh *mesh, bool binary_ply, struct fault *fault)
{
	if (strcmp(extension, "ply") == 0)
		write_ply(file, mesh, binary_ply);
	else if (strcmp(extension, "off") == 0)
		write_off(file, mesh);
	else if (strcmp(extension, "obj") == 0)
		write_obj(file, mesh);
	else if (strcmp(extension, "stl") == 0 || strcmp(extension, "stla") == 0)
		return write_stl(file, mesh, extension[3] == 'a', fault);
	else
		return fault_set(fault, EX_BAD_USAGE, "no writer for '.%s' files (ply, obj, off, stl, stla)", extension);
	return true;
}
