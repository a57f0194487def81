/* Subdivision of cages: Stam-Loop quad/triangle, Loop, Catmull-Clark, with creases, corners, darts, n-gons and borders.
 *
 * Rules: patch-pipeline method, section 9 (Stam and Loop 2003; Loop 1987; Catmull and Clark 1978). Needs libc only. */
#ifndef CAGEWRIGHT_SUBDIVIDE_H
#define CAGEWRIGHT_SUBDIVIDE_H

#include <stdbool.h>

#include "formats/cage.h"
#include "formats/fault.h"
#include "formats/memory.h"

/* A mesh at some level. Vertices of the level before come first, in their order. */
struct level {
	size_t vertex_count, face_count;
	double *xyz;            /* 3 a vertex */
	idx_t *face_corner;     /* face_start[face_count] */
	size_t *face_start;     /* face_count + 1 */
	idx_t *face_origin;     /* the cage face that each face comes from */
	unsigned char *corner;  /* a vertex: keeps its place (explicit corner of the cage, or three or more sharp edges) */
	unsigned char *sharp;   /* a corner h of face_corner: 1 when the edge from it to the next corner is sharp or a border */
};
void level_free(struct level *level);

/* The cage itself as level 0. Faults (EX_BAD_INPUT), each naming its vertices and faces: not an oriented manifold with one fan of
 * faces at every vertex (borders are allowed), faces of less than three or repeated vertices, vertices without face, a sharp edge that
 * no face has, a face that is no triangle under Loop. The file's name is the caller's to add. */
bool level_from_cage(struct level *level, const struct cage *cage, struct fault *fault);

/* Vertices, faces and corners (entries of face_corner) after so many steps; SIZE_MAX where that is more than a level can hold
 * (INDEX_LIMIT). Any of the three pointers may be NULL. */
void level_refined_size(size_t *vertices, size_t *faces, size_t *corners, const struct level *in, enum cage_scheme scheme, int steps);

/* Fast uniform refiner: n steps with any levels between freed. The result is triangles and quads from level 1 on. The faces of
 * a face stay together, in its order: with the split into triangles those at its corners, then the middle one; else those at its
 * corners. New vertices: one an edge, then one at the middle of each face that becomes quads. Sizes must fit
 * (level_refined_size). n steps at once give the same bytes as n times one step. About 10 ns a vertex of the result, and
 * as much again for fresh memory in huge pages, three times that where the system has none. */
void level_refine(struct level *out, const struct level *in, enum cage_scheme scheme, int steps);

/* Move every vertex to its limit position, in place. Where there are n-gons (under Catmull-Clark: triangles), which have no
 * limit masks, through the next level. */
void level_to_limit(struct level *level, enum cage_scheme scheme);

/* Sparse matrix, compressed rows: (row_start, column, weight). */
struct sparse {
	size_t row_count, column_count;
	size_t *row_start;      /* row_count + 1 */
	idx_t *column;          /* rising in a row */
	double *weight;
};
void sparse_free(struct sparse *sparse);
/* out[3 * row] = sum of weight * in[3 * column], three coordinates at once. */
void sparse_apply(double *restrict out, const struct sparse *sparse, const double *restrict in);
void sparse_multiply(struct sparse *out, const struct sparse *left, const struct sparse *right);

/* The operator of n steps (and the limit when to_limit): rows = vertices of the refined mesh, columns = cage vertices.
 * *refined gets the connectivity, with positions. All rows sum to 1. */
void subdivide_operator(struct sparse *operator, struct level *refined, const struct level *in, enum cage_scheme scheme, int steps, bool to_limit);

/* Unit normals of the limit surface at every vertex of a level that has not been moved to its limit: from limit tangents; at
 * creases and corners, and where tangents vanish, the mean of the adjacent face normals (zero where these cancel). */
void level_normals(double *normal, const struct level *level, enum cage_scheme scheme);

#endif
