/* rand_index: how well the patches of a segmented file agree with the true faces of a sample part.
 *
 * usage: rand_index PART.segment.ply FACES
 * FACES has the number of the true face of each triangle, one a line, as build/parts --faces writes it. Prints
 * rand=X patches=N faces=M, X the adjusted Rand index (Hubert, Arabie, Comparing partitions, 1985) with triangles weighted
 * by area: 1 for equal partitions, about 0 for unrelated ones. Patches cut from one by virtual borders count as one. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/dense.h"
#include "formats/number.h"
#include "stages/geometry/vector.h"
#include "stages/tool/tool.h"

struct cell {
	idx_t patch, face;
	double area;
};

static int compare_cells(const void *left, const void *right)
{
	const struct cell *a = left, *b = right;
	if (a->patch != b->patch)
		return a->patch < b->patch ? -1 : 1;
	return (a->face > b->face) - (a->face < b->face);
}

/* One whole number a line, count of them. */
static idx_t *read_faces(const char *path, size_t count)
{
	struct input input;
	struct fault fault = {0};
	if (!input_read(&input, path, &fault))
		tool_fail(&fault);
	idx_t *face = mem_array(count, sizeof *face);
	const char *at = (const char *)input.data;
	for (size_t i = 0; i < count; i++) {
		const size_t length = strcspn(at, "\n");
		long long value;
		if (!num_parse_integer(at, length, 0, (long long)INDEX_LIMIT, &value))
			tool_die(EX_BAD_INPUT, "%s:%zu: not a face number", input.shown, i + 1);
		face[i] = (idx_t)value;
		at += length + (at[length] == '\n');
	}
	if (*at)
		tool_die(EX_BAD_INPUT, "%s: more lines than the %zu triangles", input.shown, count);
	input_free(&input);
	return face;
}

/* Sum of squares of the areas of groups: pairs of points in the same group. */
static double pairs_by_patch(const struct cell *cell, size_t count, size_t groups, bool by_face)
{
	double *sum = mem_array(groups, sizeof *sum), pairs = 0;
	for (size_t i = 0; i < count; i++)
		sum[by_face ? cell[i].face : cell[i].patch] += cell[i].area;
	for (size_t i = 0; i < groups; i++)
		pairs += sum[i] * sum[i];
	free(sum);
	return pairs;
}

int main(int argc, char **argv)
{
	tool_init("rand_index");
	struct ply ply;
	struct dense dense;
	struct fault fault = {0};
	const char *shown;
	if (argc != 3)
		tool_die(EX_BAD_USAGE, "usage: rand_index PART.segment.ply FACES");
	tool_read_ply(&ply, argv[1], &shown);
	if (!dense_from_ply(&dense, &ply, true, shown, &fault))
		tool_fail(&fault);
	const size_t count = dense.triangle_count;
	/* the lowest id stands for all of one parent */
	idx_t *whole = mem_array(dense.patch_count, sizeof *whole), *first = mem_array(dense.patch_count, sizeof *first);
	size_t patches = 0;
	for (size_t i = 0; i < dense.patch_count; i++) {
		const idx_t parent = dense.patch[i].parent;
		const bool is_known = parent >= 0 && (size_t)parent < dense.patch_count;
		if (is_known && first[parent]) {
			whole[i] = first[parent] - 1;
			continue;
		}
		whole[i] = (idx_t)i;
		patches++;
		if (is_known)
			first[parent] = (idx_t)i + 1;
	}
	idx_t *face = read_faces(argv[2], count);
	struct cell *cell = mem_array(count, sizeof *cell);
	idx_t faces = 0;
	double total = 0, both = 0;
	for (size_t t = 0; t < count; t++) {
		double n[3];
		area_vector3(n, dense.xyz + 3 * dense.triangle[3 * t], dense.xyz + 3 * dense.triangle[3 * t + 1], dense.xyz + 3 * dense.triangle[3 * t + 2]);
		cell[t] = (struct cell){whole[dense.label[t]], face[t], norm3(n) / 2};
		total += cell[t].area;
		faces = face[t] >= faces ? face[t] + 1 : faces;
	}
	qsort(cell, count, sizeof *cell, compare_cells);
	for (size_t i = 0, end; i < count; i = end) {
		double sum = 0;
		for (end = i; end < count && cell[end].patch == cell[i].patch && cell[end].face == cell[i].face; end++)
			sum += cell[end].area;
		both += sum * sum;
	}
	const double a = pairs_by_patch(cell, count, dense.patch_count, false), b = pairs_by_patch(cell, count, (size_t)faces, true);
	const double expected = a * b / (total * total), most = (a + b) / 2;
	/* one patch, one face: nothing to expect */
	printf("rand=%.6f patches=%zu faces=%d\n", most - expected > 1e-12 * total * total ? (both - expected) / (most - expected) : 1, patches, (int)faces);
	free(whole);
	free(first);
	free(face);
	free(cell);
	dense_free(&dense);
	ply_free(&ply);
	return 0;
}
