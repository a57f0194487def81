/* The refined surface of a cage, or of a part of it, with nearest points on it. */
#ifndef CAGEWRIGHT_SKIN_H
#define CAGEWRIGHT_SKIN_H

#include "stages/polish/sketch.h"

#define SKIN_PENALTY 3e-3 /* a face that looks the other way counts as so much farther (longest side 1) */

#define SKIN_BUNDLE 16

/* Faces come in blocks of four children from level 1 on, in order: boxes around them are a tree. */
struct skin {
	struct level fine;
	idx_t *face;          /* face of the sketch by root (face of the refined part) */
	size_t root_count;    /* those that may answer; others were only refined for their neighbours' sake */
	size_t *first;        /* root_count + 1: first child of a root at level 1 */
	int steps;            /* 2 or 3 */
	enum cage_scheme scheme;
	float *root_box;      /* low x y z, high x y z: six arrays of root_count, so that all gaps are found at once */
	float (*bundle_box)[6]; /* of SKIN_BUNDLE roots one after the other */
	float (*box)[6];      /* of level 1 */
	float (*block[2])[6][4]; /* of the levels after it: of four children at once */
	float (*normal)[3];   /* unit, of each fine face */
	float *shift;         /* how far each fine vertex went in the last skin_move */
	struct level part;    /* what was refined */
	idx_t *part_vertex;   /* vertex of the sketch by vertex of the part */
};

struct skin_foot {
	idx_t root, fine;     /* fine: a face of the finest level; NO_INDEX when the skin is empty */
	idx_t corner[3];      /* fine vertices, with weights */
	double weight[3];
	double point[3];
	double distance;
	double measure;       /* distance, with the penalty when the normals disagree */
	bool is_turned;
};

/* Refine the faces listed (of any order); others around them come along so that the listed ones are as in the whole. steps: 2 or 3. */
void skin_build(struct skin *skin, const struct sketch *sketch, const idx_t *face, size_t face_count, int steps);
void skin_free(struct skin *skin);
/* New positions of the sketch's vertices: refine again, boxes and normals too. */
void skin_move(struct skin *skin, const struct sketch *sketch);

/* The nearest roots in the order of their distance from the box of some points: queries for these points look no further than they must. */
struct skin_order {
	float *gap; /* squared, rising, of the nearest */
	idx_t *root;
	size_t count;
	float rest; /* least gap of the others */
};
void skin_order(struct skin_order *order, const struct skin *skin, const float box[6]);
void skin_order_free(struct skin_order *order);

/* The nearest point for a sample with unit normal (outward). Faces turned by more than about 100 degrees are penalised. hint: a fine face
 * to begin with, or NO_INDEX; it changes the time only. order: of a box that p lies in. */
struct skin_foot skin_nearest(const struct skin *skin, const struct skin_order *order, const double p[3], const double normal[3], idx_t hint);

/* The same for a sample whose foot was `foot` before a skin_move: where the surface has hardly moved the faces next to it are enough. */
struct skin_foot skin_follow(const struct skin *skin, const struct skin_order *order, const double p[3], const double normal[3],
                             const struct skin_foot *foot);
#define SKIN_HARDLY 3e-4f /* longest sides */

/* The reverse samples of a root: the middles of its faces at level steps - 1. Each is a mean of fine vertices. */
struct skin_spot {
	idx_t corner[3];
	double weight[3];
	double point[3], normal[3];
	double area;
	double folded; /* area of its fine faces that look away from the spot's normal */
};
size_t skin_spot_count(const struct skin *skin, size_t root);
void skin_spot(struct skin_spot *spot, const struct skin *skin, size_t root, size_t index);

/* The fine vertices at a quarter, the middle and three quarters of side k of a root's polygon of so many sides. */
void skin_side(idx_t vertex[3], const struct skin *skin, size_t root, size_t k, size_t degree);

/* How much each fine vertex depends on each of count vertices of the sketch: column[fine vertex * count + i]. */
void skin_columns(double *column, const struct skin *skin, const idx_t *vertex, size_t count);

#endif
