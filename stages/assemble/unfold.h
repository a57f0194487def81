/* Faces laid out anew where their surface folds over. */
#ifndef CAGEWRIGHT_UNFOLD_H
#define CAGEWRIGHT_UNFOLD_H

#include "formats/cage.h"
#include "formats/dense.h"

struct unfold_report {
	size_t folded;  /* faces with folds before */
	size_t left;    /* after */
	size_t creased; /* edges that became creases */
	size_t redrawn; /* edges drawn elsewhere, added or taken out */
	size_t added;   /* vertices */
	double before, after; /* area that lies upside down, square model units */
};

/* Look for folds and take them out, piece by piece.
 *
 * Flat pieces are faces joined without a crease, or of one patch, within planar (model units) of one plane. There the surface is that plane
 * whatever the edges are, as long as nothing folds over. It does at corners that turn outward by more than half a turn, where the rule draws the
 * middle of an inner edge towards the mean of the corner's two creases, which is outside (Biermann, Levin and Zorin 2000, section 3.2), and where
 * large faces end between close curves. One edge at a time is made a crease (it must end at vertices that are corners already or lie inside), drawn
 * elsewhere, added or taken out, or gets a point, whatever leaves the least area upside down after so many steps of subdivision, until there is
 * none or nothing helps.
 * In pieces of other known surfaces, where edges give the shape, they become creases or are swapped, as far as the surface stays in its place.
 *
 * patch: surfaces by number, for all patches of the cage; faces of known planes may be farther from flat. NULL: nothing is known, flat is flat.
 * Time is bounded: O(n log n) without folds, and a few seconds for any number of them. */
void unfold(struct unfold_report *report, struct cage *cage, const struct dense_patch *patch, double planar, int steps);

#endif
