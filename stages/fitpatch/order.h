/* Patches in an order of their own: what is computed must not depend on how they are numbered. */
#ifndef CAGEWRIGHT_ORDER_H
#define CAGEWRIGHT_ORDER_H

#include "formats/dense.h"
#include "formats/network.h"

/* Number the patches of a mesh and of the network on it by their first triangle (patches without any come last). Returns the
 * former number of each patch (dense->patch_count, caller frees). O(n log n). */
idx_t *order_patches(struct dense *dense, struct network *network);

#endif
