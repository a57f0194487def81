/* What the tests of polish share: small cages as sketches, dense meshes of known shapes, and what must hold of any sketch. */
#ifndef CAGEWRIGHT_POLISH_RIG_H
#define CAGEWRIGHT_POLISH_RIG_H

#include "tests/unit/cage_samples.h"

#include <stdio.h>

#include "stages/polish/sketch.h"

static const double rig_zero[3] = {0, 0, 0};
static const int rig_no_pairs[] = {-1, -1};
static const int cube_edges[] = {0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7, -1, -1};

/* Takes the cage. */
static inline struct sketch rig_sketch(struct cage cage)
{
	struct sketch sketch;
	struct fault fault = {0};
	if (!sketch_from_cage(&sketch, &cage, rig_zero, 1, &fault))
		fail_msg("%s", fault.text);
	cage_drop(&cage);
	return sketch;
}

static inline struct sketch rig_make(const double *xyz, size_t vertex_count, const int *faces, const int *sharp)
{
	struct cage cage = cage_make(xyz, vertex_count, faces, SCHEME_QUADTRI);
	cage_sharpen(&cage, sharp);
	return rig_sketch(cage);
}

/* n x m quads; closed: a torus, else a square of side 1 at z = 0. Vertex i + n' j, n' = n or n + 1. */
static inline struct sketch rig_quads(int n, int m, bool is_closed)
{
	const int across = n + !is_closed, up = m + !is_closed;
	double *xyz = mem_array((size_t)(3 * across * up), sizeof *xyz);
	int *faces = mem_array((size_t)(5 * n * m + 1), sizeof *faces), k = 0;
	for (int j = 0; j < up; j++)
		for (int i = 0; i < across; i++) {
			double *p = &xyz[3 * (j * across + i)];
			const double u = 2 * 3.14159265358979323846 * i / n, v = 2 * 3.14159265358979323846 * j / m;
			p[0] = is_closed ? (0.35 + 0.12 * cos(v)) * cos(u) : (double)i / n;
			p[1] = is_closed ? (0.35 + 0.12 * cos(v)) * sin(u) : (double)j / m;
			p[2] = is_closed ? 0.12 * sin(v) : 0;
		}
	for (int j = 0; j < m; j++)
		for (int i = 0; i < n; i++) {
			const int i2 = (i + 1) % across, j2 = (j + 1) % up;
			faces[k++] = j * across + i, faces[k++] = j * across + i2, faces[k++] = j2 * across + i2, faces[k++] = j2 * across + i, faces[k++] = -1;
		}
	faces[k] = -2;
	struct sketch sketch = rig_make(xyz, (size_t)(across * up), faces, rig_no_pairs);
	free(xyz), free(faces);
	return sketch;
}

/* Prism over a regular polygon of n sides, radius 0.5, height 1, both rims creases: faces 0 and 1 are the caps. */
static inline struct sketch rig_prism(int n)
{
	double *xyz = mem_array((size_t)(6 * n), sizeof *xyz);
	int *faces = mem_array((size_t)(2 * (n + 1) + 5 * n + 1), sizeof *faces), *sharp = mem_array((size_t)(4 * n + 2), sizeof *sharp), k = 0, s = 0;
	for (int i = 0; i < 2 * n; i++) {
		const double angle = 2 * 3.14159265358979323846 * (i % n) / n;
		xyz[3 * i] = 0.5 * cos(angle), xyz[3 * i + 1] = 0.5 * sin(angle), xyz[3 * i + 2] = i < n ? -0.5 : 0.5;
	}
	for (int i = n; i-- > 0;)
		faces[k++] = i;
	faces[k++] = -1;
	for (int i = 0; i < n; i++)
		faces[k++] = n + i;
	faces[k++] = -1;
	for (int i = 0; i < n; i++) {
		const int j = (i + 1) % n;
		faces[k++] = i, faces[k++] = j, faces[k++] = n + j, faces[k++] = n + i, faces[k++] = -1;
		sharp[s++] = i, sharp[s++] = j, sharp[s++] = n + i, sharp[s++] = n + j;
	}
	faces[k] = -2, sharp[s] = sharp[s + 1] = -1;
	struct sketch sketch = rig_make(xyz, (size_t)(2 * n), faces, sharp);
	free(xyz), free(faces), free(sharp);
	return sketch;
}

/* Cube of side 1 about the origin, all edges creases or none. */
static inline struct sketch rig_cube(bool is_sharp)
{
	double xyz[24];
	for (int i = 0; i < 24; i++)
		xyz[i] = cube_xyz[i] / 2;
	return rig_make(xyz, 8, cube_faces, is_sharp ? cube_edges : rig_no_pairs);
}

/* The sketch refined as triangles: a dense mesh whose best cage is known. */
struct rig_mesh {
	double *xyz;
	idx_t *triangle;
	size_t vertex_count, triangle_count;
};
static inline struct rig_mesh rig_dense(const struct sketch *sketch, int steps)
{
	struct level level = sketch_level(sketch), fine;
	level_refine(&fine, &level, sketch->scheme, steps);
	struct rig_mesh mesh = {.xyz = mem_copy(fine.xyz, 3 * fine.vertex_count, sizeof *mesh.xyz), .vertex_count = fine.vertex_count};
	mesh.triangle = mem_array(6 * fine.face_count, sizeof *mesh.triangle);
	for (size_t f = 0; f < fine.face_count; f++) {
		const idx_t *c = &fine.face_corner[fine.face_start[f]];
		for (size_t i = 1; i + 1 < fine.face_start[f + 1] - fine.face_start[f]; i++) {
			idx_t *t = &mesh.triangle[3 * mesh.triangle_count++];
			t[0] = c[0], t[1] = c[i], t[2] = c[i + 1];
		}
	}
	level_free(&fine);
	free(level.corner), free(level.face_origin);
	return mesh;
}
static inline void rig_mesh_free(struct rig_mesh *mesh)
{
	free(mesh->xyz), free(mesh->triangle);
}

static inline long rig_euler(const struct sketch *s)
{
	return (long)s->vertex_count - (long)sketch_edge_count(s) + (long)s->face_count;
}

static inline idx_t rig_root(idx_t *parent, idx_t i)
{
	while (parent[i] != i)
		i = parent[i] = parent[parent[i]];
	return i;
}
/* Pieces, and closed chains of border edges. */
static inline void rig_topology(size_t *pieces, size_t *loops, const struct sketch *s)
{
	const size_t n = s->vertex_count, halves = s->face_start[s->face_count];
	idx_t *all = mem_array(n, sizeof *all), *rim = mem_array(n, sizeof *rim);
	for (size_t v = 0; v < n; v++)
		all[v] = rim[v] = (idx_t)v;
	unsigned char *on_rim = mem_array(n, 1);
	for (size_t h = 0; h < halves; h++) {
		const idx_t a = s->face_corner[h], b = sketch_head(s, (idx_t)h);
		all[rig_root(all, a)] = rig_root(all, b);
		if (s->twin[h] == NO_INDEX)
			rim[rig_root(rim, a)] = rig_root(rim, b), on_rim[a] = on_rim[b] = 1;
	}
	*pieces = *loops = 0;
	for (size_t v = 0; v < n; v++)
		*pieces += all[v] == (idx_t)v, *loops += on_rim[v] && rim[v] == (idx_t)v;
	free(all), free(rim), free(on_rim);
}

/* What the header says of a sketch. */
static inline void rig_check(const struct sketch *s)
{
	const size_t halves = s->face_start[s->face_count];
	for (size_t h = 0; h < halves; h++) {
		const idx_t t = s->twin[h];
		assert_in_range(s->face_corner[h], 0, s->vertex_count - 1);
		assert_true((size_t)h >= s->face_start[s->face[h]] && (size_t)h < s->face_start[s->face[h] + 1]);
		if (t == NO_INDEX) {
			assert_int_equal(s->sharp[h], 1);
			continue;
		}
		assert_int_equal(s->twin[t], h);
		assert_int_equal(s->face_corner[t], sketch_head(s, (idx_t)h));
		assert_int_equal(s->sharp[t], s->sharp[h]);
	}
	for (size_t v = 0; v < s->vertex_count; v++) {
		const struct sketch_star star = sketch_star(s, (idx_t)v);
		assert_int_equal(s->face_corner[s->outgoing[v]], v);
		assert_true(s->id[v] >= 0 && s->id[v] < s->next_id);
		assert_true(star.on_border || star.valence > 2 || star.sharp == 2);
	}
	for (size_t f = 0; f < s->face_count; f++)
		assert_true(sketch_degree(s, (idx_t)f) >= 3 && s->face_id[f] >= 0 && s->face_id[f] < s->next_face_id);
}

/* The face with these vertices in this order, from any of them on; NO_INDEX when there is none. */
static inline idx_t rig_face(const struct sketch *s, const idx_t *vertex, size_t count)
{
	for (size_t f = 0; f < s->face_count; f++) {
		const size_t from = s->face_start[f];
		if (sketch_degree(s, (idx_t)f) != count)
			continue;
		for (size_t turn = 0; turn < count; turn++) {
			size_t same = 0;
			while (same < count && s->id[s->face_corner[from + (turn + same) % count]] == vertex[same])
				same++;
			if (same == count)
				return (idx_t)f;
		}
	}
	return NO_INDEX;
}

#endif
