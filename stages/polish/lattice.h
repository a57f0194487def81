/* Putting a cage on a coarse integer grid so that its surface suffers least: the grid's step and place are free, and the points are
 * rounded together, not one by one. */
#ifndef CAGEWRIGHT_LATTICE_H
#define CAGEWRIGHT_LATTICE_H

#include "formats/ffx.h"
#include "stages/polish/search.h"

#define CODER_WORK 16 /* samples looked at in the time that a vertex takes to code */

struct lattice {
	double step, origin[3]; /* position = origin + step * grid; longest side 1 */
	int32_t *grid;          /* 3 a vertex, from 0 */
};
void lattice_free(struct lattice *lattice);

/* Round the candidate's cage to a grid of this step (about: the step is fitted too). Its positions become those of the grid, its errors
 * are measured anew. rounds: fits of the grid and roundings; 0: every
 * coordinate goes to its nearest value, which keeps equal ones equal. False when two vertices of a face fall together. */
bool lattice_round(struct lattice *lattice, struct candidate *candidate, const struct judge *judge, double step, int rounds);

/* Move the grid to the nearest place and step that a stream's frame can hold, and the candidate with it; its errors are measured anew. */
void lattice_snap(struct lattice *lattice, struct candidate *candidate, const struct judge *judge, const double middle[3], double scale);

/* Better and cheaper coordinates: single steps of one coordinate are taken where cost + lambda * bits falls, the cost by the surface itself,
 * the bits by the coder. One sweep looks at all vertices, worst places first. Returns how many steps were taken. */
size_t lattice_settle(struct lattice *lattice, struct candidate *candidate, const struct judge *judge, double lambda, int sweeps);

/* The cage on its grid, in model units. scale, middle: as in sketch_to_cage. */
void lattice_to_cage(struct cage *cage, const struct lattice *lattice, const struct sketch *sketch, const double middle[3], double scale);

/* The stream's struct; the caller frees it. False when the grid has more steps than a stream can hold. */
bool lattice_to_ffx(struct ffx *ffx, const struct lattice *lattice, const struct sketch *sketch, const double middle[3], double scale);

#endif
