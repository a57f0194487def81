/* Local cages to one mesh: welding by network point, checks, creases and corners (the patch method's section 6, 1 to 4). */
#ifndef CAGEWRIGHT_WELD_H
#define CAGEWRIGHT_WELD_H

#include "formats/cage.h"
#include "formats/fault.h"
#include "formats/network.h"
#include "stages/assemble/polymesh.h"

struct weld_report {
	size_t unused; /* network points that no face uses */
	size_t split;  /* vertices added because several fans met in one */
	size_t border; /* edges with one face */
};

/* cage: local cages with net; network: whose points they are and whose curves are creases (kind sharp) or borders.
 * Positions of welded vertices are the network's. Faults (EX_BAD_INPUT) name patch and curve: net out of range, a face that
 * has a vertex twice after welding, an edge with more than two faces, two faces that run the same way, an edge with one face
 * that is on no border curve (a crack), a control edge of a curve that no face has, two curves with one control edge. */
bool weld(struct polymesh *mesh, struct weld_report *report, const struct cage *cage, const struct network *network,
	  struct fault *fault);

#endif
