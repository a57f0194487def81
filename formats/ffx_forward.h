/* The forward coder of an FFX stream: faces grow around a finished region, and each vertex gets its position as soon as it
 * appears. Private to formats/ffx*.
 *
 * The walk is a gate coder (Touma and Gotsman 1998, Rossignac's Edgebreaker 1999, Kronrod and Gotsman 2001 for faces of any
 * degree). Because positions are known on both sides, the questions about connectivity see angles, bends and planes. */
#ifndef CAGEWRIGHT_FFX_FORWARD_H
#define CAGEWRIGHT_FFX_FORWARD_H

#include <stdbool.h>

#include "formats/fault.h"
#include "formats/ffx_geometry.h"
#include "formats/ffx_model.h"
#include "formats/ffx_predict.h"
#include "formats/ffx_surface.h"

/* A boundary half-edge that a face may jump to. */
struct far {
	int64_t distance; /* squares */
	idx_t half;
};

/* The half-built surface. Half-edges come in pairs, 2 i and 2 i + 1. A half-edge without a face is on the boundary of the
 * finished region; those boundary half-edges that have been told to be a border of the cage are dead. */
struct forward {
	struct ffx_coder *coder;
	struct geometry geometry;
	/* half-edges */
	idx_t *next, *previous, *origin, *face;
	idx_t *after, *before; /* on the boundary: neighbours there */
	idx_t *place;          /* on the boundary: where in bound */
	unsigned char *is_dead;
	idx_t *source; /* encoding: the half-edge of the encoded surface */
	size_t half_count, half_room;
	/* vertices, in the order in which they appear */
	int32_t *grid;
	int32_t *used;          /* angles of the faces there so far, 1/4096 turn */
	unsigned char *valence; /* faces so far, up to 255 */
	idx_t *mark;            /* 1 + the last face that it is in */
	size_t vertex_count, vertex_room;
	size_t placed; /* vertices whose places are known */
	/* faces */
	idx_t *first, *degree;
	int64_t *normal; /* 3 a face, below 2^15 */
	size_t face_count, face_room;
	idx_t *bound; /* all boundary half-edges */
	size_t bound_count, alive_count;
	/* the face that grows */
	idx_t *path;   /* its half-edges in order; before the first one is final: from the gate on */
	idx_t *corner; /* where a half-edge starts: the boundary's half-edge that starts there, NO_INDEX at new vertices */
	idx_t *behind; /* half-edges that lead to the gate, backward */
	unsigned char *is_known; /* a corner, numbered as path: is its place known? */
	size_t path_count, behind_count, path_room;
	struct far *far; /* room for candidates */
	size_t far_room;
	size_t component_start; /* first vertex of this component */
	idx_t *root;            /* a component: its first half-edge */
	size_t component_count, root_room;
	size_t work, edge_limit;
	bool has_border;
	/* encoding */
	const struct ffx_surface *surface;
	const int32_t *surface_grid;
	idx_t *built, *number; /* a half-edge, a vertex of the encoded surface: here, or NO_INDEX */
	size_t built_room, number_room;
	uint64_t cost_g;
};

void forward_free(struct forward *forward);

/* --- the half-built surface (ffx_growth.c) --- */
static inline idx_t forward_end(const struct forward *forward, idx_t half)
{
	return forward->origin[half ^ 1];
}
static inline const int32_t *forward_point(const struct forward *forward, idx_t vertex)
{
	return forward->grid + 3 * (size_t)vertex;
}
/* Is the vertex in the face that grows? */
static inline bool forward_has(const struct forward *forward, idx_t vertex)
{
	return forward->mark[vertex] == (idx_t)forward->face_count + 1;
}
/* Room for one more pair of half-edges, vertex, face and corner. */
void forward_reserve(struct forward *forward);
/* Make b follow a on the boundary. */
void forward_join(struct forward *forward, idx_t a, idx_t b);
void forward_bound_add(struct forward *forward, idx_t half);
void forward_bound_remove(struct forward *forward, idx_t half);
/* A new pair from a to b; source: what its first half-edge is, when encoding. */
idx_t forward_pair(struct forward *forward, idx_t a, idx_t b, idx_t source);
/* A vertex without a place yet. */
idx_t forward_vertex(struct forward *forward, idx_t source);

/* More steps along boundaries than this are refused; the encoder then takes the other method. */
#define FORWARD_WORK_LIMIT ((size_t)1 << 26)

/* Code connectivity and positions. Encoding: surface and grid given, from half-edge root. Decoding: surface NULL. *forward is
 * zero or was used before; its memory is used again. edge_limit: more are refused. Faults (EX_BAD_INPUT): too early an end,
 * contradictions, too much work. */
bool forward_code(struct forward *forward, struct ffx_coder *coder, const struct ffx_surface *surface, const int32_t *grid,
		  idx_t root, int32_t steps, size_t edge_limit, struct fault *fault);

/* What was built as a surface of its own, borders closed by holes. When it was decoded call surface_check, too. */
void forward_surface(struct ffx_surface *surface, const struct forward *forward);

/* A face as far as it is known. Its old corners in a row around the gate are the chain: from e, with s behind it, to c, with p
 * before it; fresh vertices, whose places are not yet known, follow behind c. */
struct step {
	idx_t gate;
	idx_t first, last; /* the chain's half-edges at its ends */
	idx_t p, c, e, s;  /* vertices */
	idx_t out;         /* the boundary's half-edge that starts at c there */
	size_t count;      /* half-edges so far */
	size_t known;      /* corners whose places are known */
	unsigned fresh;    /* new vertices since c */
	int64_t normal[3]; /* of the known corners, below 2^15; 0 for two */
	idx_t nearest;     /* old vertex outside the face nearest to both ends of the gap, NO_INDEX: none */
	int64_t distance;  /* of it: both squares together */
};

/* Guesses at corner number at of the face in path, the first of its unknown ones; the next known one is gap places on. */
void foresee(struct guesses *guesses, const struct forward *forward, size_t at, size_t gap);
/* At the first two vertices of a component. */
void foresee_first(struct guesses *guesses, const struct forward *forward);

#endif
