/* A binary heap of vertices by cost, ties by index: the queue of Dijkstra's algorithm. */
#ifndef CAGEWRIGHT_MINHEAP_H
#define CAGEWRIGHT_MINHEAP_H

#include <stddef.h>

#include "formats/memory.h"

struct minheap_entry {
	double key;
	idx_t vertex;
};

/* Zero-initialised: empty. Grows as needed; free(entry) in the end. */
struct minheap {
	struct minheap_entry *entry;
	size_t count, room;
};

void minheap_push(struct minheap *heap, double key, idx_t vertex);

/* The least entry; the heap must not be empty. */
struct minheap_entry minheap_pop(struct minheap *heap);

#endif
