/* An editable cage: the polygons with their connectivity, small enough to be copied whole for every edit that is tried. */
#ifndef CAGEWRIGHT_SKETCH_H
#define CAGEWRIGHT_SKETCH_H

#include <stdbool.h>

#include "formats/cage.h"
#include "stages/geometry/subdivide.h"

/* Half-edge h is corner h of the faces: from the vertex face_corner[h] to the next corner's. */
struct sketch {
	enum cage_scheme scheme;
	size_t vertex_count, face_count;
	double *xyz;           /* 3 a vertex; inside polish the target's longest side is 1 */
	idx_t *id;             /* a vertex: its name, kept through all edits */
	unsigned char *corner; /* a vertex: 1 = explicit corner */
	size_t *face_start;    /* face_count + 1 */
	idx_t *face_corner;
	idx_t *face_patch;
	idx_t *face_id;        /* a face: its name; a face that an edit changes gets a new one */
	unsigned char *sharp;  /* a half-edge: 1 at creases and borders, the same on both sides */
	idx_t *twin;           /* a half-edge; NO_INDEX at borders */
	idx_t *face;           /* a half-edge */
	idx_t *outgoing;       /* a vertex: a half-edge from it; at a border the one without twin */
	idx_t next_id, next_face_id;
};

void sketch_free(struct sketch *sketch);
void sketch_copy(struct sketch *out, const struct sketch *in);
/* Positions become (x - middle) / scale. Faults as level_from_cage. */
bool sketch_from_cage(struct sketch *sketch, const struct cage *cage, const double middle[3], double scale, struct fault *fault);
/* The reverse; explicit corner flags where three creases meet are left out. */
void sketch_to_cage(struct cage *cage, const struct sketch *sketch, const double middle[3], double scale);

static inline idx_t sketch_next(const struct sketch *s, idx_t h)
{
	const idx_t f = s->face[h];
	return (size_t)h + 1 == s->face_start[f + 1] ? (idx_t)s->face_start[f] : h + 1;
}
static inline idx_t sketch_previous(const struct sketch *s, idx_t h)
{
	const idx_t f = s->face[h];
	return (size_t)h == s->face_start[f] ? (idx_t)s->face_start[f + 1] - 1 : h - 1;
}
static inline idx_t sketch_head(const struct sketch *s, idx_t h) { return s->face_corner[sketch_next(s, h)]; }
static inline size_t sketch_degree(const struct sketch *s, idx_t f) { return s->face_start[f + 1] - s->face_start[f]; }
/* The half-edge of the same origin that follows counter-clockwise; NO_INDEX behind the last one at a border. */
static inline idx_t sketch_turn(const struct sketch *s, idx_t h) { return s->twin[sketch_previous(s, h)]; }

/* Half-edge from vertex a to b, NO_INDEX when there is none. */
idx_t sketch_half(const struct sketch *s, idx_t a, idx_t b);
/* Edges at a vertex (valence), sharp ones among them (borders count), and whether it lies on a border. */
struct sketch_star { size_t valence, sharp; bool on_border; };
struct sketch_star sketch_star(const struct sketch *s, idx_t v);
/* Does the vertex keep its place under subdivision? */
bool sketch_is_corner(const struct sketch *s, idx_t v);
size_t sketch_edge_count(const struct sketch *s);

/* Faces around the vertices and so on for so many rings; with 2 rings all those whose surface depends on them. The caller frees. */
idx_t *sketch_faces_near(size_t *count, const struct sketch *s, const idx_t *vertex, size_t vertex_count, int rings);

/* Fill twin, face, outgoing from the polygons; make sharp equal on both sides. False when the polygons are no oriented manifold
 * with one fan at each vertex, or a vertex cannot be subdivided: without face, inside with valence 2 unless both edges are sharp. */
bool sketch_connect(struct sketch *s);
/* As level 0 for subdivision: arrays shared with the sketch but for corner, which the caller frees. */
struct level sketch_level(const struct sketch *s);

#endif
