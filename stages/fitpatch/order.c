/* Numbering patches by their first triangle. */
#include "stages/fitpatch/order.h"

#include <stdlib.h>

#include "formats/memory.h"

struct part {
	idx_t parent, patch;
};

static int compare_parts(const void *a, const void *b)
{
	const struct part *x = a, *y = b;
	return x->parent != y->parent ? (x->parent > y->parent) - (x->parent < y->parent) : (x->patch > y->patch) - (x->patch < y->patch);
}

idx_t *order_patches(struct dense *dense, struct network *network)
{
	const size_t patches = dense->patch_count;
	idx_t *former = mem_array(patches, sizeof *former), *rank = mem_array(patches, sizeof *rank);
	size_t ranked = 0;
	for (size_t p = 0; p < patches; p++)
		rank[p] = NO_INDEX;
	for (size_t t = 0; t < dense->triangle_count; t++)
		if (rank[dense->label[t]] == NO_INDEX)
			former[ranked] = dense->label[t], rank[dense->label[t]] = (idx_t)ranked++;
	for (size_t p = 0; p < patches; p++)
		if (rank[p] == NO_INDEX)
			former[ranked] = (idx_t)p, rank[p] = (idx_t)ranked++;
	for (size_t t = 0; t < dense->triangle_count; t++)
		dense->label[t] = rank[dense->label[t]];
	struct dense_patch *sorted = mem_array(patches, sizeof *sorted);
	struct part *part = mem_array(patches, sizeof *part);
	for (size_t p = 0; p < patches; p++) {
		sorted[p] = dense->patch[former[p]];
		part[p] = (struct part){sorted[p].parent, (idx_t)p};
	}
	/* A parent is any number that the parts of one surface share: from now on that of its first part. */
	qsort(part, patches, sizeof *part, compare_parts);
	for (size_t i = 0, first = 0; i < patches; i++) {
		first = part[i].parent == part[first].parent ? first : i;
		sorted[part[i].patch].parent = part[first].patch;
	}
	free(dense->patch);
	dense->patch = sorted;
	for (size_t k = 0; k < network->curve_count; k++) {
		struct curve *curve = &network->curve[k];
		if (curve->left >= 0 && (size_t)curve->left < patches)
			curve->left = rank[curve->left];
		if (curve->right >= 0 && (size_t)curve->right < patches)
			curve->right = rank[curve->right];
	}
	free(rank), free(part);
	return former;
}
