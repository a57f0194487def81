/* Changes to the polygons of a plot, which can be taken back. */
#ifndef CAGEWRIGHT_CHANGE_H
#define CAGEWRIGHT_CHANGE_H

#include "stages/assemble/plot.h"

/* One thing that can be done. */
enum way {
	WAY_CHORD,  /* polygon one, or the union of one and two, is cut by the chord a b; or not at all (a is NO_INDEX) */
	WAY_SPLIT,  /* the edge a b between one and two gets a point in its middle, joined to c in one and to d in two (NO_INDEX: to none) */
	WAY_CENTRE, /* polygon one gets a point in its middle, joined to all its corners */
};
struct change {
	enum way way;
	idx_t one, two; /* polygons, NO_INDEX: none */
	idx_t a, b, c, d;
	unsigned char crease; /* of the chord; of the edge between a and the new point */
	double cost;          /* about that many bytes */
	double rough;         /* what it makes of the folded area, by a few steps */
};

/* Polygons with more corners get no point in their middle. */
enum { CHANGE_MOST_CENTRE = 6, CHANGE_MOST_CORE = 2 + CHANGE_MOST_CENTRE };

/* What a change put aside. */
struct undo {
	struct polygon one, two;
	size_t count, points;
};

/* Do it: the first part takes the place of polygon one, the second that of two, others come last. Creases at vertices are counted anew. False, and
 * nothing done, where the two polygons share more than an edge, or no point is left. */
bool change_apply(struct undo *undo, struct plot *plot, const struct change *change);
void change_take_back(const struct undo *undo, struct plot *plot, const struct change *change);

/* The polygons that a change that was done has made; returns how many. */
size_t change_made(idx_t made[CHANGE_MOST_CORE], const struct plot *plot, const struct undo *undo, const struct change *change);

/* Place of a vertex in a polygon, its count when it is not there; and the next place around. */
size_t polygon_find(const struct polygon *p, idx_t vertex);
static inline size_t polygon_after(const struct polygon *p, size_t i)
{
	return i + 1 < p->count ? i + 1 : 0;
}
void polygon_free(struct polygon *p);

/* The union of two polygons over their only common edge; false when they share more, which a vertex twice gives away. */
bool polygon_unite(struct polygon *out, const struct polygon *p, const struct polygon *q);
/* Polygon p with vertex v after corner i. */
void polygon_with(struct polygon *out, const struct polygon *p, size_t i, idx_t v);

#endif
