/* One patch cut out as a mesh of its own. */
#ifndef CAGEWRIGHT_PATCHMESH_H
#define CAGEWRIGHT_PATCHMESH_H

#include "stages/geometry/half.h"

/* Local triangle i is list[i] of the whole mesh; vertices at which the patch touches itself are split, one a fan. */
struct patchmesh {
	struct half half;
	idx_t *vertex;   /* whole mesh's vertex of each local one */
	double *xyz;     /* 3 a local vertex */
};

/* list: triangle_count triangles of the mesh. local: face_count of the mesh, all NO_INDEX, and so again afterwards. */
void patchmesh_cut_out(struct patchmesh *part, const struct half *half, const double *xyz, const idx_t *list, size_t triangle_count, idx_t *local);
void patchmesh_free(struct patchmesh *part);

/* Distance along edges from the sources (distance 0) to every vertex, INFINITY where there is no way. Dijkstra, ties by index. */
void patchmesh_distances(double *distance, const struct patchmesh *part, const idx_t *source, size_t source_count);

#endif
