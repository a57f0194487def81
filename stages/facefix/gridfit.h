/* Putting a cage on an integer grid: as coarse as the tolerance allows. */
#ifndef CAGEWRIGHT_GRIDFIT_H
#define CAGEWRIGHT_GRIDFIT_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/cage.h"
#include "formats/fault.h"
#include "formats/ffx.h"
#include "stages/geometry/subdivide.h"

/* Fill *ffx with the cage on grid grid_code: frame, positions, faces, flags; patches when with_patches. The longest side gets as
 * many steps as the grid has and the lowest corner is its origin, both within 1e-6 of the longest side. Faults: a cage without
 * extent or too far from the origin. */
bool gridfit_round(struct ffx *ffx, const struct cage *cage, unsigned grid_code, bool with_patches, struct fault *fault);

/* Coordinate i of cage->xyz in steps of the grid, before rounding. */
double gridfit_exact(const struct cage *cage, const struct ffx *ffx, size_t i);

/* What rounding broke. */
struct gridfit_damage {
	size_t collapsed; /* faces with two vertices at one place that were apart before */
	size_t turned;    /* corners whose sub-quad changed its orientation */
	size_t overlaid;  /* vertices and edges that came to lie on others (gridmend_count) */
};
/* Sub-quads with sides of less than small (model units) may turn: they are not seen at that tolerance. */
struct gridfit_damage gridfit_check(const struct cage *cage, const struct ffx *ffx, double small);
/* Those of one face: corners turned. */
size_t gridfit_turned_corners(const struct cage *cage, const struct ffx *ffx, size_t face, double small);
#define GRIDFIT_SMALL_TOLERANCES 4 /* small, in tolerances of the mean */
#define GRIDFIT_SMALL_SIDE 1e-3    /* small, of the longest side, when there is no tolerance */

#define GRIDFIT_MAX_OVER_MEAN 8 /* allowed largest deviation, in tolerances of the mean */

struct gridfit_choice {
	unsigned grid_code;
	double mean, max; /* deviation of the refined surfaces along the normal, model units; 0 when not measured */
	unsigned finer;   /* how many coarser grids were near enough but collapsed or turned something, or could not be mended */
};

/* The coarsest grid on which the refined surface deviates by at most tolerance in the mean and 8 tolerance at most (model units),
 * and on which nothing collapses or turns (small: 4 tolerance) or, mended (gridmend), lies on something else. Refined to level 3, or less for cages so large that this gives
 * more than 200,000 faces. The finest grid is taken, with a warning left to the caller (choice->mean > tolerance), when none
 * does. */
bool gridfit_choose(struct gridfit_choice *choice, const struct cage *cage, double tolerance, struct fault *fault);

/* Measures how far roundings of one cage move its refined surface. */
struct gridfit_ruler {
	const struct cage *cage;
	struct level base, target; /* the cage, and it refined */
	int level;
};
bool gridfit_ruler_start(struct gridfit_ruler *ruler, const struct cage *cage, struct fault *fault);
void gridfit_ruler_free(struct gridfit_ruler *ruler);
/* Mean and largest deviation along the normal, model units. */
void gridfit_deviation(double *mean, double *max, struct gridfit_ruler *ruler, const struct ffx *ffx);

#endif
