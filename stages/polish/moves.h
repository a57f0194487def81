/* Edits of a cage that the search tries: fewer faces, fewer vertices, other edges, other tags. */
#ifndef CAGEWRIGHT_MOVES_H
#define CAGEWRIGHT_MOVES_H

#include "stages/polish/sketch.h"

enum move_kind {
	MOVE_MERGE,    /* the two faces at a smooth edge become one; smooth vertices left with two edges dissolve */
	MOVE_COLLAPSE, /* the ends of an edge become one vertex */
	MOVE_REMOVE,   /* the faces around a smooth vertex become one */
	MOVE_SWAP,     /* a smooth edge turns by one place in the polygon of its two faces, to the left */
	MOVE_CHORD,    /* a face is cut in two between two of its corners */
	MOVE_SPLIT,    /* a new vertex on an edge; on a smooth one with cuts to the far corners of its faces */
	MOVE_CREASE,   /* an edge becomes a crease or stops being one */
	MOVE_CORNER,   /* a vertex becomes an explicit corner or stops being one */
	MOVE_KINDS
};

/* Vertices by name (sketch.id), so that a move outlives edits elsewhere: the edge a-b; the vertex a; the chord from a to b, which
 * are corners of one face; a swap moves both ends to the next corner. */
struct move {
	enum move_kind kind;
	idx_t a, b;
};

/* New index of every vertex and face by its old one, NO_INDEX for those that are gone. A face that is not the same polygon with the
 * same edges any more counts as gone. touched: vertices of *out whose neighbourhood or tags are new. */
struct move_trace {
	idx_t *face;
	idx_t *touched;
	size_t touched_count;
};
void move_trace_free(struct move_trace *trace);

/* *out becomes the edited copy of in. False, and nothing to free, when the move is not possible or would not leave an oriented manifold of
 * the same topology that can be subdivided. index: vertex by name (sketch_index). */
bool move_apply(struct sketch *out, struct move_trace *trace, const struct sketch *in, const idx_t *index, struct move move);

/* index[id] = vertex or NO_INDEX, for all ids below sketch->next_id; the caller frees. */
idx_t *sketch_index(const struct sketch *sketch);

#endif
