/* The border loops of a sheet, as control points, and the layouts that follow from two loops, four sides or a round one. */
#ifndef CAGEWRIGHT_LOOPS_H
#define CAGEWRIGHT_LOOPS_H

#include <stdbool.h>

#include "stages/fitpatch/layout.h"

/* Points of all loops one after the other, the patch on the left. */
struct loops {
	size_t count, *start;  /* loops; start[count + 1] into vertex */
	idx_t *vertex;         /* sheet vertices that stand for control points */
	double *turn_deg;      /* how much the mesh border turns there */
};
void loops_find(struct loops *loops, const struct sheet *sheet);
void loops_free(struct loops *loops);

/* Two loops of equal count: a band of quads, with inner rings where the surface bends between them. False (nothing added)
 * when the patch is no such band. */
bool loops_band(struct layout_context *context, const struct sheet *sheet, const struct loops *loops, idx_t patch);

/* One loop with four corners whose opposite sides have equal counts: a grid of quads (Coons 1967, laid on the surface). */
bool loops_grid(struct layout_context *context, const struct sheet *sheet, const struct loops *loops, idx_t patch);

/* One loop without corners around a part that bulges, such as a half sphere: rings of quads that close at the top. */
bool loops_dome(struct layout_context *context, const struct sheet *sheet, const struct loops *loops, idx_t patch);

#endif
