/* Predicting a vertex of an FFX stream from those already known: in integers. Private to formats/ffx*. */
#ifndef CAGEWRIGHT_FFX_PREDICT_H
#define CAGEWRIGHT_FFX_PREDICT_H

#include <stdbool.h>

#include "formats/ffx_model.h"
#include "formats/ffx_surface.h"

/* The order of the vertices: always the one that can be predicted best next, from the surface's roots on. order and rank
 * (its inverse) have room for vertex_count. O(n). */
void predict_order(idx_t *order, idx_t *rank, const struct ffx_surface *surface);

/* A guess at the whole point. */
struct guess {
	enum ffx_expert kind;
	int32_t at[3];
};

/* The plane normal . x = offset, |normal| < 2^15 each. */
struct plane {
	enum ffx_expert kind; /* EXPERT_PLANE, or one of FORE_PLANE... */
	int32_t normal[3];
	int64_t offset;
};

#define GUESS_LIMIT 24 /* the first method makes 14 at most */
#define FIRST_GUESS_LIMIT 14
#define PLANE_LIMIT 4
struct guesses {
	struct guess guess[GUESS_LIMIT];
	size_t guess_count;
	struct plane plane[PLANE_LIMIT]; /* of faces that the vertex is in */
	size_t plane_count;
	int axis[3]; /* in which order its coordinates are coded: those that planes tell come last */
	int phase;   /* of the forward coder: how many of the face's corners are known: 0 two, 1 three, 2 more; -1 elsewhere */
};

/* Guesses at the vertex of rank at from the vertices of lower rank. grid: 3 a vertex. O(1) apart from the first 64 faces around
 * it. */
void predict_vertex(struct guesses *guesses, const struct ffx_surface *surface, const idx_t *order, const idx_t *rank, size_t at,
		    const int32_t *grid);

/* The plane of the three of count points that span the largest area; none when they are in a row, or there is no more room. */
void predict_add_plane(struct guesses *guesses, enum ffx_expert kind, const int32_t *const *point, int count);
/* Sets axis by the planes. */
void predict_choose_axes(struct guesses *guesses);

/* Where planes put coordinate axis[step] when axis[0 .. step) of point are known: values and their kinds (EXPERT_PLANE,
 * EXPERT_LINE, EXPERT_POINT), at most PLANE_LIMIT. Returns how many. */
size_t predict_from_planes(int32_t *value, enum ffx_expert *kind, const struct guesses *guesses, int step,
			   const int32_t point[3]);

#endif
