/* Face Fixer, forward: from half-edges to labels (see ffx_connect.h). */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "formats/ffx_connect.h"

void labels_free(struct labels *labels)
{
	free(labels->label);
	free(labels->component_end);
	*labels = (struct labels){0};
}

/* An active boundary is a cycle of half-edges whose left side is still to be done; it starts at its gate. */
struct boundary {
	idx_t gate, length;
	size_t place; /* in the stack, while it waits there */
};

struct walk {
	const struct ffx_surface *surface;
	struct labels *labels;
	idx_t *after, *before; /* a half-edge on a boundary: its neighbours there */
	idx_t *owner;          /* its boundary, NO_INDEX outside */
	unsigned char *done;   /* a face */
	struct boundary *boundary;
	size_t boundary_count;
	idx_t *stack; /* boundaries that wait */
	size_t depth;
};

static void join(struct walk *walk, idx_t a, idx_t b)
{
	walk->after[a] = b;
	walk->before[b] = a;
}

static void own(struct walk *walk, idx_t from, idx_t length, idx_t owner)
{
	for (idx_t i = 0; i < length; i++, from = walk->after[from])
		walk->owner[from] = owner;
}

static enum ffx_label face_label(idx_t degree)
{
	return degree == 3 ? LABEL_F3 : degree == 4 ? LABEL_F4 : degree == 5 ? LABEL_F5 : degree == 6 ? LABEL_F6 : LABEL_F7;
}

/* F or H: the gate's face is done; the boundary, two half-edges long at least, goes around it. */
static idx_t fix_face(struct walk *walk, idx_t current, struct label *label)
{
	const struct ffx_surface *s = walk->surface;
	struct boundary *b = &walk->boundary[current];
	const idx_t g = b->gate, f = s->face[g];
	label->degree = s->degree[f];
	label->kind = (unsigned char)(s->hole[f] ? LABEL_H : face_label(label->degree));
	walk->done[f] = 1;
	const idx_t following = walk->after[g], leading = walk->before[g];
	walk->owner[g] = NO_INDEX;
	idx_t last = leading;
	for (idx_t h = s->previous[g]; h != g; h = s->previous[h]) {
		const idx_t t = s->twin[h];
		walk->owner[t] = current;
		join(walk, last, t);
		last = t;
	}
	join(walk, last, following);
	b->gate = last;
	b->length += label->degree - 2;
	return current;
}

/* S: the twin lies inside the same boundary, which falls apart into two. The shorter one gets a new name. */
static idx_t split(struct walk *walk, idx_t current, idx_t p)
{
	struct boundary *b = &walk->boundary[current];
	const idx_t g = b->gate, first = walk->after[g], last = walk->before[g], left = walk->before[p], right = walk->after[p];
	/* Lengths by walking from both ends at once. */
	idx_t shorter = 1;
	for (idx_t x = first, y = right; x != left && y != last; x = walk->after[x], y = walk->after[y])
		shorter++;
	idx_t x = first;
	for (idx_t i = 1; i < shorter; i++)
		x = walk->after[x];
	const bool near_is_shorter = x == left;
	const idx_t total = b->length - 2, near = near_is_shorter ? shorter : total - shorter;
	join(walk, left, first);
	join(walk, last, right);
	const idx_t fresh = (idx_t)walk->boundary_count++;
	if (near_is_shorter)
		own(walk, first, near, fresh);
	else
		own(walk, right, total - near, fresh);
	const idx_t waiting = near_is_shorter ? current : fresh, next = near_is_shorter ? fresh : current;
	walk->boundary[waiting] = (struct boundary){right, total - near, walk->depth};
	walk->boundary[next] = (struct boundary){first, near, 0};
	walk->stack[walk->depth++] = waiting;
	return next;
}

/* M: the twin lies on a boundary that waits; the two become one. */
static idx_t merge(struct walk *walk, idx_t current, idx_t p, struct label *label)
{
	struct boundary *b = &walk->boundary[current];
	const idx_t other = walk->owner[p];
	const struct boundary o = walk->boundary[other];
	const idx_t g = b->gate, first = walk->after[g], last = walk->before[g];
	label->kind = LABEL_M;
	label->depth = (idx_t)(walk->depth - 1 - o.place);
	label->length = o.length;
	label->index = 0;
	for (idx_t h = o.gate; h != p; h = walk->after[h])
		label->index++;
	for (size_t i = o.place; i + 1 < walk->depth; i++) {
		walk->stack[i] = walk->stack[i + 1];
		walk->boundary[walk->stack[i]].place = i;
	}
	walk->depth--;
	const idx_t start = walk->after[p], end = walk->before[p];
	const idx_t length = b->length - 1 + o.length - 1;
	/* A boundary has two sides at least, so both parts are there. */
	idx_t kept = current;
	if (o.length <= b->length) {
		own(walk, o.gate, o.length, current);
	} else {
		own(walk, g, b->length, other);
		kept = other;
	}
	join(walk, end, first);
	join(walk, last, start);
	walk->boundary[kept] = (struct boundary){start, length, 0};
	return kept;
}

static void walk_component(struct walk *walk, idx_t root)
{
	const struct ffx_surface *s = walk->surface;
	idx_t current = (idx_t)walk->boundary_count++;
	const idx_t back = s->twin[root];
	join(walk, root, back);
	join(walk, back, root);
	walk->owner[root] = walk->owner[back] = current;
	walk->boundary[current] = (struct boundary){root, 2, 0};
	for (;;) {
		struct boundary *b = &walk->boundary[current];
		const idx_t g = b->gate, p = s->twin[g];
		struct label *label = &walk->labels->label[walk->labels->count++];
		*label = (struct label){.gate = g, .twin = p};
		if (!walk->done[s->face[g]]) {
			current = fix_face(walk, current, label);
			continue;
		}
		const idx_t first = walk->after[g], last = walk->before[g];
		if (walk->owner[p] != current) {
			current = merge(walk, current, p, label);
			walk->labels->handle_count++;
		} else if (b->length == 2) {
			label->kind = LABEL_E;
			walk->owner[g] = walk->owner[p] = NO_INDEX;
			if (walk->depth == 0)
				return;
			current = walk->stack[--walk->depth];
			continue;
		} else if (p == first) {
			label->kind = LABEL_R;
			b->gate = walk->after[p];
			b->length -= 2;
			join(walk, last, b->gate);
		} else if (p == last) {
			label->kind = LABEL_L;
			b->gate = first;
			b->length -= 2;
			join(walk, walk->before[p], first);
		} else {
			label->kind = LABEL_S;
			current = split(walk, current, p);
		}
		walk->owner[g] = walk->owner[p] = NO_INDEX;
	}
}

void labels_make(struct labels *labels, const struct ffx_surface *surface, idx_t root)
{
	/* One label an edge and one more a component; a component has two faces, holes counted, at least. */
	const size_t label_room = surface->half_count / 2 + surface->face_count;
	*labels = (struct labels){0};
	labels->label = mem_array(label_room, sizeof *labels->label);
	labels->component_end = mem_array(surface->face_count, sizeof *labels->component_end);
	struct walk walk = {.surface = surface, .labels = labels};
	walk.after = mem_array(surface->half_count, sizeof(idx_t));
	walk.before = mem_array(surface->half_count, sizeof(idx_t));
	walk.owner = mem_array(surface->half_count, sizeof(idx_t));
	memset(walk.owner, 0xff, surface->half_count * sizeof(idx_t));
	walk.done = mem_array(surface->face_count, 1);
	walk.boundary = mem_array(label_room, sizeof *walk.boundary);
	walk.stack = mem_array(label_room, sizeof(idx_t));
	idx_t next_root = root;
	for (size_t h = 0;; h++) {
		walk_component(&walk, next_root);
		labels->component_end[labels->component_count++] = labels->count;
		while (h < surface->half_count && walk.done[surface->face[h]])
			h++;
		if (h == surface->half_count)
			break;
		next_root = (idx_t)h;
	}
	assert(labels->count <= label_room);
	free(walk.after);
	free(walk.before);
	free(walk.owner);
	free(walk.done);
	free(walk.boundary);
	free(walk.stack);
}
