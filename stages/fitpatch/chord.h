/* What a control edge across a patch costs: the coherency score of Lavoue, Dupont and Baskurt (the patch method's
 * section 5.1), with what makes it usable on CAD meshes. */
#ifndef CAGEWRIGHT_CHORD_H
#define CAGEWRIGHT_CHORD_H

#include <stdbool.h>

#include "formats/dense.h"
#include "stages/fitpatch/sheet.h"
#include "stages/geometry/nearest.h"

/* Edges between control points that exist already, anywhere in the cage: a second one would be a double edge. */
struct edge_set;
struct edge_set *edge_set_new(void);
void edge_set_free(struct edge_set *set);
bool edge_set_has(const struct edge_set *set, idx_t a, idx_t b);
void edge_set_add(struct edge_set *set, idx_t a, idx_t b);

struct chord_context {
	const struct dense *dense;
	const struct nearest *nearest;
	const struct sheet *sheet;
	const double *control;    /* 3 a control point: sheet vertices that are one count as folded where either place is */
	const struct edge_set *taken;
	idx_t patch;
	bool is_plane;
	double diameter;          /* of the patch */
	struct chord_cache *cache;/* scores found so far, by pair of sheet vertices */
};
void chord_open(struct chord_context *context);
void chord_close(struct chord_context *context);

/* For struct sheet_cost: context is a struct chord_context. In degrees: coherency score (22.5 where the surface has no
 * direction), 10 x length / diameter, and up to 45 for a chord that leaves the surface. INFINITY when the edge is taken. */
double chord_cost(void *context, idx_t a, idx_t b);
/* A triangle that turns away from the surface under its centre, or is a sliver. */
double chord_triangle_cost(void *context, idx_t a, idx_t b, idx_t c);

#endif
