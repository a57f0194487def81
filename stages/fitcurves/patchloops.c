/* Border loops from chains: sides sorted by patch and start node, then followed. */
#include "stages/fitcurves/patchloops.h"

#include <stdlib.h>

#include "formats/memory.h"

struct start {
	idx_t patch, node;
	struct side side;
};

static int compare_starts(const void *a, const void *b)
{
	const struct start *x = a, *y = b;
	if (x->patch != y->patch)
		return x->patch < y->patch ? -1 : 1;
	if (x->node != y->node)
		return x->node < y->node ? -1 : 1;
	if (x->side.chain != y->side.chain)
		return x->side.chain < y->side.chain ? -1 : 1;
	return (int)x->side.reversed - (int)y->side.reversed;
}

/* First entry of (patch, node) in the sorted list, or count. */
static size_t find_start(const struct start *start, size_t count, idx_t patch, idx_t node)
{
	size_t low = 0, high = count;
	while (low < high) {
		const size_t middle = (low + high) / 2;
		if (start[middle].patch < patch || (start[middle].patch == patch && start[middle].node < node))
			low = middle + 1;
		else
			high = middle;
	}
	return low < count && start[low].patch == patch && start[low].node == node ? low : count;
}

void patchloops_init(struct patchloops *loops, const struct border_network *border, const idx_t *node, const bool *is_gone,
		     size_t patch_count)
{
	struct start *start = mem_array(2 * border->chain_count, sizeof *start);
	size_t count = 0;
	for (size_t c = 0; c < border->chain_count; c++) {
		if (is_gone && is_gone[c])
			continue;
		start[count++] = (struct start){border->chain[c].left, node[2 * c], {(idx_t)c, false}};
		if (border->chain[c].right >= 0)
			start[count++] = (struct start){border->chain[c].right, node[2 * c + 1], {(idx_t)c, true}};
	}
	qsort(start, count, sizeof *start, compare_starts);
	bool *used = mem_array(count, sizeof *used);
	*loops = (struct patchloops){.patch_count = patch_count};
	loops->first_loop = mem_array(patch_count + 1, sizeof *loops->first_loop);
	loops->first_side = mem_array(count + 1, sizeof *loops->first_side);
	loops->side = mem_array(count, sizeof *loops->side);
	loops->touches_itself = mem_array(count, sizeof *loops->touches_itself);
	size_t sides = 0, patch = 0;
	for (size_t i = 0; i < count; i++) {
		for (; patch < (size_t)start[i].patch; patch++)
			loops->first_loop[patch + 1] = loops->loop_count;
		if (used[i])
			continue;
		size_t at = i;
		while (at < count && !used[at]) {
			used[at] = true;
			const struct side side = start[at].side;
			loops->side[sides++] = side;
			if (border->chain[side.chain].closed)
				break;
			const idx_t end = node[2 * (size_t)side.chain + !side.reversed];
			at = find_start(start, count, start[i].patch, end);
			if (at + 1 < count && start[at + 1].patch == start[i].patch && start[at + 1].node == end)
				loops->touches_itself[loops->loop_count] = true;
			while (at < count && used[at] && at + 1 < count && start[at + 1].patch == start[i].patch &&
			       start[at + 1].node == end)
				at++;
		}
		loops->first_side[++loops->loop_count] = sides;
	}
	for (; patch < patch_count; patch++)
		loops->first_loop[patch + 1] = loops->loop_count;
	free(start), free(used);
}

void patchloops_free(struct patchloops *loops)
{
	free(loops->first_loop), free(loops->first_side), free(loops->side), free(loops->touches_itself);
	*loops = (struct patchloops){0};
}
