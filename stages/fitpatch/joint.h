/* Fitting all control points of a cage together to the dense mesh (the patch method's sections 5.4 and 6.3). */
#ifndef CAGEWRIGHT_JOINT_H
#define CAGEWRIGHT_JOINT_H

#include <stdbool.h>

#include "formats/cage.h"
#include "formats/dense.h"
#include "formats/fault.h"
#include "formats/network.h"
#include "stages/fitpatch/layout.h"
#include "stages/geometry/border.h"
#include "stages/geometry/nearest.h"
#include "stages/geometry/sqdist.h"

/* A cage in the making: control points, faces over them, and the curves that bound the patches. */
struct draft {
	struct control control;
	struct polygons polygons;
	struct network network;   /* curves over control points: positions are control.xyz, kinds control.role */
	idx_t *seam;               /* 3 a seam, a chord of a plane patch that is a crease: its points, the patch */
	size_t seam_count;
	unsigned char *tangential; /* a curve: 1 where two surfaces join smoothly, though it is a crease so far (NULL: none) */
};

/* What is fitted to. */
struct target {
	const struct dense *dense;
	const struct nearest *nearest;      /* labelled by dense->label */
	const idx_t *surface;               /* a triangle: its patch's parent; feet are looked for on whole surfaces, as the virtual borders
	                                       that cut them have no place of their own */
	const struct nearest *on_surface;   /* labelled by that */
	const struct border_network *border;
	const double *sample;     /* 3 a sample, uniform by area over the dense mesh */
	const idx_t *sample_triangle;
	size_t sample_count;
};

struct joint_options {
	int iterations;           /* at most */
	int steps;                /* subdivision steps before samples are taken */
	enum sqdist_variant variant;
};

/* How far a patch is from its part of the target; lengths in model units. */
struct patch_error {
	double mean, max;         /* both ways: mean of means, larger maximum */
	double normal_deg;        /* mean angle between normals at reverse samples */
	idx_t worst_face;         /* the polygon where the maximum is */
	double worst_point[3];    /* and where, on the target or the surface */
	double folded;            /* area of the surface that is turned by more than 90 degrees from the target under it */
	double fold_point[3];     /* the middle of its largest triangle */
};

/* Make the cage that the draft stands for; vertex_of[control.count] (caller frees) gives the cage vertex of each control point,
 * NO_INDEX for points that no face uses. */
void draft_cage(struct cage *cage, idx_t **vertex_of, const struct draft *draft);

/* Optimise all control points that are not held, by a person or by still[control point] (NULL: none). False with a fault when the draft is no
 * manifold cage. */
bool joint_fit(struct draft *draft, const struct target *target, const struct joint_options *options, const unsigned char *still, struct fault *fault);

/* What is wrong with a control polygon. */
struct face_error {
	double distance;  /* the largest of its samples, both ways */
	double folded;    /* area */
};

/* Error of each patch (patch_count) of the draft as it is, and of every polygon (face may be NULL). */
bool joint_measure(struct patch_error *error, struct face_error *face, size_t patch_count, const struct draft *draft, const struct target *target, struct fault *fault);

#endif
