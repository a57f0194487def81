/* Control edges and vertices that say nothing, taken out (the patch method's section 6, 4 and 5). */
#ifndef CAGEWRIGHT_TIDY_H
#define CAGEWRIGHT_TIDY_H

#include "stages/assemble/polymesh.h"

struct tidy_report {
	size_t dissolved;    /* smooth inner vertices with two edges */
	size_t merged;       /* faces that joined a coplanar neighbour */
	size_t straightened; /* crease vertices on straight creases */
};

/* Faces do not grow beyond this many vertices. */
#define TIDY_MOST_CORNERS 250

/* Join faces across edges that are no creases when both, and all faces around the edge's ends up to the next creases, lie in one
 * plane within planar (model units), the union has no vertex twice, and it stays star-shaped from its centroid: the limit
 * surface is that plane before and after. Then drop crease vertices with two edges on straight creases. Vertices with two
 * edges that no crease passes are dissolved, or their two faces joined. Every face keeps three vertices, no edge becomes double.
 */
void tidy(struct tidy_report *report, struct polymesh *mesh, double planar);

/* Only the dissolving, which is not optional. */
size_t tidy_dissolve(struct polymesh *mesh);

#endif
