/* A draft from a network, and back into a document of local cages. */
#ifndef CAGEWRIGHT_LOCAL_H
#define CAGEWRIGHT_LOCAL_H

#include "formats/ply.h"
#include "stages/fitpatch/joint.h"

/* Control points are the network's vertices; curves are copied. Points of curves that were moved by hand are held. */
void draft_start(struct draft *draft, const struct network *network);
/* Curves along which two surfaces join smoothly become creases, and tangential: see rounds_relax. */
void draft_sharpen(struct draft *draft, const struct dense *dense);
void draft_copy(struct draft *to, const struct draft *from);
void draft_free(struct draft *draft);

/* Add the sides of all curves. */
void draft_curve_edges(struct edge_set *edges, const struct draft *draft);

/* Triangles by label: those of patch p are list[start[p]] .. list[start[p + 1]), rising. Caller frees both. */
void label_lists(size_t **start, idx_t **list, const idx_t *label, size_t count, size_t patch_count);

/* Put vertex (x y z net), face (vertex_indices patch), netpoint and curve; drop the network's own vertex and edge elements. */
void local_to_ply(struct ply *ply, const struct draft *draft);

#endif
