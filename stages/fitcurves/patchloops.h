/* The border loops of each patch as cycles of border chains. */
#ifndef CAGEWRIGHT_PATCHLOOPS_H
#define CAGEWRIGHT_PATCHLOOPS_H

#include <stdbool.h>

#include "stages/geometry/border.h"

/* A chain seen from one of its patches, which lies on the left when walking along it so. */
struct side {
	idx_t chain;
	bool reversed;
};

struct patchloops {
	size_t patch_count, loop_count;
	size_t *first_loop;   /* patch_count + 1: loops of each patch */
	size_t *first_side;   /* loop_count + 1: sides of each loop */
	struct side *side;    /* in order along the loop */
	bool *touches_itself; /* a loop: its patch comes to one of its nodes twice, so the order there is a guess */
};

/* node[2 c], node[2 c + 1]: the nodes at the start and end of chain c (NO_INDEX for closed chains), numbers below node_count.
 * Chains with is_gone[c] are left out (is_gone may be NULL). */
void patchloops_init(struct patchloops *loops, const struct border_network *border, const idx_t *node, const bool *is_gone,
		     size_t patch_count);
void patchloops_free(struct patchloops *loops);

#endif
