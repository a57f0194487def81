#include "stages/geometry/trimesh.h"

#include <stdlib.h>

#include "stages/geometry/triangulate.h"
#include "stages/geometry/vector.h"

/* Three vertices a face, each used once: what STL gives. */
static bool is_soup(const struct mesh *mesh)
{
	if (mesh->vertex_count != 3 * mesh->face_count || mesh->face_start[mesh->face_count] != mesh->vertex_count)
		return false;
	for (size_t i = 0; i < mesh->vertex_count; i++)
		if (mesh->corner[i] != (idx_t)i)
			return false;
	return true;
}

static int compare_edges(const void *a, const void *b)
{
	const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

static void count_edges(struct trimesh *trimesh)
{
	const size_t count = 3 * trimesh->triangle_count;
	uint64_t *edge = mem_array(count, sizeof *edge);
	for (size_t i = 0; i < count; i++) {
		const uint64_t a = (uint64_t)trimesh->triangle[i], b = (uint64_t)trimesh->triangle[i % 3 == 2 ? i - 2 : i + 1];
		edge[i] = a < b ? a << 32 | b : b << 32 | a;
	}
	qsort(edge, count, sizeof *edge, compare_edges);
	for (size_t i = 0, j; i < count; i = j) {
		for (j = i + 1; j < count && edge[j] == edge[i]; j++)
			;
		trimesh->open_count += j - i == 1;
		trimesh->nonmanifold_count += j - i > 2;
	}
	free(edge);
}

static void add_up(struct trimesh *trimesh)
{
	const double *xyz = trimesh->mesh.xyz;
	unsigned char *used = mem_array(trimesh->mesh.vertex_count, 1);
	const double *origin = xyz + 3 * (size_t)trimesh->triangle[0]; /* on the part: no loss under large offsets */
	for (size_t t = 0; t < trimesh->triangle_count; t++) {
		const idx_t *corner = trimesh->triangle + 3 * t;
		double n[3], arm[3];
		area_vector3(n, xyz + 3 * (size_t)corner[0], xyz + 3 * (size_t)corner[1], xyz + 3 * (size_t)corner[2]);
		sub3(arm, xyz + 3 * (size_t)corner[0], origin);
		const double area = norm3(n) / 2;
		trimesh->area += area;
		trimesh->volume += dot3(arm, n) / 6;
		trimesh->degenerate_count += !(area > 0);
		for (int k = 0; k < 3; k++) {
			trimesh->used_count += !used[corner[k]];
			used[corner[k]] = 1;
		}
	}
	free(used);
}

bool trimesh_from_mesh(struct trimesh *trimesh, struct mesh *from, const char *shown, struct fault *fault)
{
	*trimesh = (struct trimesh){.mesh = *from};
	*from = (struct mesh){0};
	struct mesh *mesh = &trimesh->mesh;
	if (is_soup(mesh))
		mesh_weld(mesh, 0, NULL);
	trimesh->triangle = triangulate_mesh(&trimesh->triangle_count, NULL, mesh->xyz, mesh->corner, mesh->face_start, mesh->face_count);
	if (trimesh->triangle_count == 0) {
		trimesh_free(trimesh);
		return fault_set(fault, EX_BAD_INPUT, "%s: no faces", shown);
	}
	count_edges(trimesh);
	add_up(trimesh);
	return true;
}

void trimesh_free(struct trimesh *trimesh)
{
	mesh_free(&trimesh->mesh);
	free(trimesh->triangle);
	*trimesh = (struct trimesh){0};
}
