/* Merge patches that are too narrow to be seen (the patch method's section 10, row 19). */
#ifndef CAGEWRIGHT_SLIVER_H
#define CAGEWRIGHT_SLIVER_H

#include "stages/rectify/partition.h"

/* A patch is a sliver when it is nowhere wider than width (longest side 1): twice its area over its perimeter, which is
 * the mean width of a strip, and twice the distance of every vertex from its border are at most that, and no point is
 * farther than that from the neighbour with the longest common border. It joins that neighbour; sharp edges between the
 * two become smooth (partition.kind). Smallest first. Returns the number of merged patches; edges (may be NULL) the number of sharp edges that went. */
size_t sliver_merge(struct partition *p, double width, size_t *edges);

#endif
