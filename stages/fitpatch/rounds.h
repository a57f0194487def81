/* Laying out, fitting and refining until a part is within its bounds. */
#ifndef CAGEWRIGHT_ROUNDS_H
#define CAGEWRIGHT_ROUNDS_H

#include "stages/fitpatch/joint.h"
#include "stages/geometry/half.h"

struct bounds {
	double max, mean; /* model units: largest distance of every patch, mean of the part */
};

struct rounds {
	const struct target *target;
	const struct half *half;        /* of the dense mesh */
	const idx_t *chain_of_curve;    /* the border chain that each curve follows */
	struct joint_options joint;
	struct bounds bounds;
	int limit;                      /* rounds of refinement at most */
	size_t *work;                   /* fits times faces, counted up: about a millisecond each */
	size_t most_work;               /* after which no round begins */
	const idx_t *name;              /* what people call each patch */
	void (*say)(const char *format, ...) __attribute__((format(printf, 1, 2))); /* what happens, for people */
};

/* The share of its work that a part gets, in (0, 1]: very large meshes have spent their time on the way here. */
double rounds_work_share(const struct dense *dense);

/* How the patches of a draft were laid out, patch_count each. */
struct layouts {
	unsigned char *kind;   /* enum layout_kind */
	unsigned char *detail; /* see struct layout_context */
	unsigned char *faceted; /* 1: creases on all chords */
};

/* The state of a part after a fit. */
struct part_state {
	double mean, worst, folded; /* folded: share of the area */
};
struct part_state rounds_state(const struct patch_error *error, const struct dense *dense);
/* Lower is better; everything within the bounds without folds is 2. A hundredth of the area folded is as bad as an error of twice the
 * bound. */
double rounds_badness(const struct part_state *state, const struct bounds *bounds);
/* What counts as within the bounds in the end: those of this stage are a part of what was asked for. */
#define ROUNDS_SLACK 1.15
bool rounds_within(const struct part_state *state, const struct bounds *bounds);

/* One fit of all points but those with still[control point] (NULL: none). */
bool rounds_fit_points(struct draft *draft, const struct rounds *rounds, const unsigned char *still, struct fault *fault);

/* First the points inside patches, with the borders where the curves were fitted; then all. A patch that folds or gets worse by its
 * moving borders (it has too few points inside, and pushes its borders out instead) gets them back, until no patch does. Measures
 * the patches, and the faces (NULL: not). */
bool rounds_fit_once(struct draft *draft, struct patch_error *error, struct face_error *face_error, const struct rounds *rounds, struct fault *fault);

/* A last fit with finer samples. The target's samples meet the flat triangles between those of the surface, which lie inside of a
 * convex surface by their sagitta and push it out by a part of that; a step of subdivision leaves a quarter. Too dear for every
 * round. Kept when it is better. */
bool rounds_settle(struct draft *draft, struct patch_error *error, const struct rounds *rounds, struct fault *fault);

/* copy_of NULL: all 0. */
struct layouts layouts_new(size_t patch_count, const struct layouts *copy_of);
void layouts_free(struct layouts *layouts);

/* Lay out the patches with chosen[patch] != 0 (NULL: all) over the control points as they are now; their former faces go. */
bool rounds_layout(struct draft *draft, const struct rounds *rounds, const struct layouts *layouts, const unsigned char *chosen, struct fault *fault);

/* Fit, measure, and give more points to the patches that are out of bounds or folded, until none is or the rounds are over.
 * error (patch_count) is that of the draft in the end. */
bool rounds_fit(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds, struct fault *fault);

/* Curves along which two surfaces join tangentially are creases so far: a smooth rule there draws a coarse cage
 * with very unlike edge lengths far off its border. Make them smooth together, and those whose patches do not keep their error
 * creases again. Returns how many stay smooth in *smooth. */
bool rounds_relax(struct draft *draft, struct patch_error *error, size_t *smooth, const struct rounds *rounds,
                  struct fault *fault);

#endif
