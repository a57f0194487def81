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
	size_t *work;                   /* fits times faces, counted up */
	const idx_t *name;              /* what people call each patch */
	void (*say)(const char *format, ...) __attribute__((format(printf, 1, 2))); /* what happens, for people */
};

/* How the patches of a draft were laid out, patch_count each. */
struct layouts {
	unsigned char *kind;   /* enum layout_kind */
	unsigned char *detail; /* see struct layout_context */
};

/* Lay out the patches with chosen[patch] != 0 (NULL: all) over the control points as they are now; their former faces go. */
bool rounds_layout(struct draft *draft, const struct rounds *rounds, const struct layouts *layouts, const unsigned char *chosen, struct fault *fault);

/* Fit, measure, and give more points to the patches that are out of bounds or folded, until none is or the rounds are over.
 * error (patch_count) is that of the draft in the end. */
bool rounds_fit(struct draft *draft, struct layouts *layouts, struct patch_error *error, const struct rounds *rounds, struct fault *fault);

/* Curves along which two surfaces join tangentially (candidate[curve]) are creases so far: a smooth rule there draws a coarse cage
 * with very unlike edge lengths far off its border. Make them smooth together, and those whose patches do not keep their error
 * creases again. Returns how many stay smooth in *smooth. */
bool rounds_relax(struct draft *draft, struct patch_error *error, size_t *smooth, const unsigned char *candidate, const struct rounds *rounds,
                  struct fault *fault);

#endif
