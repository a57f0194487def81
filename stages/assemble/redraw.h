/* Edges of one plot drawn elsewhere, until nothing folds over. */
#ifndef CAGEWRIGHT_REDRAW_H
#define CAGEWRIGHT_REDRAW_H

#include "stages/assemble/plot.h"
#include "stages/assemble/unfold.h"

/* Edges that a cage has, or had, or got: no second one may join the same two vertices. */
struct edge_list {
	idx_t *pair; /* lower vertex first; the first sorted ones sorted, added ones behind */
	size_t count, sorted, room;
};
void edge_list_make(struct edge_list *edges, const struct cage *cage);
void edge_list_free(struct edge_list *edges);

/* Look for folds in the plot and get rid of them where that can be done. Fixed polygons and bent plots may move by shift (model units). Adds to the report and to
 * the edges. Returns whether a polygon changed; those that were there first keep their places. */
bool redraw(struct unfold_report *report, struct plot *plot, struct edge_list *edges, double shift, int steps);

#endif
