/* Cages: coarse control meshes of piecewise-smooth subdivision surfaces. Struct, read, write, check of
 * PART.fitpatch.ply (local cages, one a patch), PART.assemble.ply and PART.polish.ply (see cagewright-cage(5)). */
#ifndef CAGEWRIGHT_CAGE_H
#define CAGEWRIGHT_CAGE_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/ply.h"

enum cage_scheme { SCHEME_QUADTRI = 0, SCHEME_LOOP = 1, SCHEME_CATMULLCLARK = 2 };

struct cage {
	enum cage_scheme scheme;
	double *xyz;             /* 3 a vertex, model units */
	size_t vertex_count;
	unsigned char *corner;   /* a vertex: 1 = explicit corner, interpolated although only two sharp edges meet there */
	idx_t *net;              /* local cages: the network vertex it is, or -1. NULL in welded cages */
	idx_t *face_corner;      /* face_start[face_count] vertex indices, counter-clockwise from outside */
	size_t *face_start;      /* face_count + 1 */
	idx_t *face_patch;       /* patch of each face */
	size_t face_count;
	idx_t *sharp;            /* 2 * sharp_count vertex indices, lower first, sorted: edges that are creases. Border edges
	                            (one face) are creases by themselves and are not listed */
	size_t sharp_count;
	double grid_step;        /* > 0: the positions lie on a grid of this step, model units, with its origin; 0: anywhere */
	double grid_origin[3];
};

void cage_free(struct cage *cage);
void cage_copy(struct cage *out, const struct cage *in);

/* Read "vertex" (x y z; corner and net optional), "face" (vertex_indices, at least 3 a face, patch optional), "edge"
 * (vertex1 vertex2 sharp; optional), comment "cagewright scheme", "grid" (one row: step x y z; optional). Faults: indices out of range, a vertex twice in a face,
 * a sharp edge that no face has, non-finite numbers, an unknown scheme. */
bool cage_from_ply(struct cage *cage, const struct ply *ply, const char *shown, struct fault *fault);
void cage_to_ply(struct ply *ply, const struct cage *cage);

#endif
