/* A binary heap of vertices by cost: see minheap.h. */
#include "stages/rectify/minheap.h"

#include <assert.h>
#include <stdbool.h>

static bool is_before(struct minheap_entry a, struct minheap_entry b)
{
	return a.key < b.key || (a.key == b.key && a.vertex < b.vertex);
}

void minheap_push(struct minheap *heap, double key, idx_t vertex)
{
	const struct minheap_entry e = {key, vertex};
	if (heap->count == heap->room) {
		heap->room = 2 * heap->room + 64;
		heap->entry = mem_resize(heap->entry, heap->room, sizeof *heap->entry);
	}
	size_t i = heap->count++;
	for (; i > 0 && is_before(e, heap->entry[(i - 1) / 2]); i = (i - 1) / 2)
		heap->entry[i] = heap->entry[(i - 1) / 2];
	heap->entry[i] = e;
}

struct minheap_entry minheap_pop(struct minheap *heap)
{
	assert(heap->count > 0);
	const struct minheap_entry top = heap->entry[0], last = heap->entry[--heap->count];
	size_t i = 0;
	for (;;) {
		size_t child = 2 * i + 1;
		if (child >= heap->count)
			break;
		if (child + 1 < heap->count && is_before(heap->entry[child + 1], heap->entry[child]))
			child++;
		if (!is_before(heap->entry[child], last))
			break;
		heap->entry[i] = heap->entry[child];
		i = child;
	}
	heap->entry[i] = last;
	return top;
}
