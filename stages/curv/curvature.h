/* From a clean mesh to the dense mesh with sharp edges, wedges and curvatures: what curv does, free of I/O. */
#ifndef CAGEWRIGHT_CURVATURE_H
#define CAGEWRIGHT_CURVATURE_H

#include "formats/dense.h"
#include "formats/mesh.h"
#include "stages/curv/normalcycle.h"
#include "stages/curv/sharp.h"

struct curvature_options {
	struct sharp_options sharp;
	double radius;          /* model units, 0: automatic */
};

/* mesh: oriented manifold of triangles in model units; cut: 2 * cut_count vertices of edges that a repair opened.
 * Fills *dense (dense_free it) without labels; counts may be NULL. Faults: not such a mesh, no extent. */
bool curvature_compute(struct dense *dense, struct sharp_counts *counts, const struct mesh *mesh, const idx_t *cut, size_t cut_count,
                       const struct curvature_options *options, struct fault *fault);

#endif
