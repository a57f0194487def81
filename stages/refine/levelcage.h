/* A refined level as a cage again: it subdivides to the same surface. */
#ifndef CAGEWRIGHT_LEVELCAGE_H
#define CAGEWRIGHT_LEVELCAGE_H

#include "stages/geometry/subdivide.h"

/* cage takes the arrays of level that it needs; the rest is freed. origin: the cage that level comes from (patches, scheme). */
void levelcage(struct cage *cage, struct level *level, const struct cage *origin);

#endif
