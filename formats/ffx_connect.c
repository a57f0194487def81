/* Face Fixer, backward: from labels to half-edges, and the coding of the labels (see ffx_connect.h).
 *
 * The encoder runs this too, on the labels that it knows: both sides see the same half-built surface, which is the context. */
#include "formats/ffx_connect.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* What waits while another boundary is active. */
struct waiting {
	idx_t gate, length;
};

struct rebuild {
	struct ffx_coder *coder;
	/* Half-edges come in pairs: 2 i and 2 i + 1 are the sides of label i's edge. */
	idx_t *after, *before; /* neighbours on the boundary */
	idx_t *next, *origin, *face;
	size_t half_count, half_room;
	unsigned char *valence; /* a vertex: its faces so far, up to VALENCE_CAP - 1 */
	unsigned char *open;    /* a vertex: boundary corners at it, up to 255 */
	size_t vertex_count, vertex_room;
	idx_t *first, *degree;
	unsigned char *hole;
	size_t face_count, face_room;
	struct waiting *stack;
	size_t depth, stack_room;
	idx_t gate, length;     /* the active boundary */
	size_t component_faces; /* of this component so far */
	size_t merge_work;
	unsigned previous, previous2; /* labels */
	idx_t *root;
	size_t component_count, root_room;
};

static void rebuild_free(struct rebuild *r)
{
	free(r->after);
	free(r->before);
	free(r->next);
	free(r->origin);
	free(r->face);
	free(r->valence);
	free(r->open);
	free(r->first);
	free(r->degree);
	free(r->hole);
	free(r->stack);
	free(r->root);
}

static size_t grown(size_t room)
{
	return room < 32 ? 64 : 2 * room;
}

/* Room for what one label can add. */
static void reserve(struct rebuild *r)
{
	if (r->half_count + 2 > r->half_room) {
		r->half_room = grown(r->half_room);
		r->after = mem_resize(r->after, r->half_room, sizeof(idx_t));
		r->before = mem_resize(r->before, r->half_room, sizeof(idx_t));
		r->next = mem_resize(r->next, r->half_room, sizeof(idx_t));
		r->origin = mem_resize(r->origin, r->half_room, sizeof(idx_t));
		r->face = mem_resize(r->face, r->half_room, sizeof(idx_t));
	}
	if (r->vertex_count + 2 > r->vertex_room) {
		r->vertex_room = grown(r->vertex_room);
		r->valence = mem_resize(r->valence, r->vertex_room, 1);
		r->open = mem_resize(r->open, r->vertex_room, 1);
	}
	if (r->face_count + 1 > r->face_room) {
		r->face_room = grown(r->face_room);
		r->first = mem_resize(r->first, r->face_room, sizeof(idx_t));
		r->degree = mem_resize(r->degree, r->face_room, sizeof(idx_t));
		r->hole = mem_resize(r->hole, r->face_room, 1);
	}
	if (r->depth + 1 > r->stack_room) {
		r->stack_room = grown(r->stack_room);
		r->stack = mem_resize(r->stack, r->stack_room, sizeof *r->stack);
	}
	if (r->component_count + 1 > r->root_room) {
		r->root_room = grown(r->root_room);
		r->root = mem_resize(r->root, r->root_room, sizeof(idx_t));
	}
}

static void join(struct rebuild *r, idx_t a, idx_t b)
{
	r->after[a] = b;
	r->before[b] = a;
}

static idx_t new_vertex(struct rebuild *r)
{
	r->valence[r->vertex_count] = 0;
	r->open[r->vertex_count] = 1;
	return (idx_t)r->vertex_count++;
}

static void open_corner(struct rebuild *r, idx_t vertex)
{
	if (r->open[vertex] < 255)
		r->open[vertex]++;
}

/* --- what each label does ---------------------------------------------------------------------------------------- */

static void undo_e(struct rebuild *r, idx_t g, idx_t p, bool is_start)
{
	if (!is_start)
		r->stack[r->depth++] = (struct waiting){r->gate, r->length};
	join(r, g, p);
	join(r, p, g);
	r->origin[g] = new_vertex(r);
	r->origin[p] = new_vertex(r);
	r->gate = g;
	r->length = 2;
}

/* R and L: an edge with a free tip, which the boundary passes on both sides. */
static void undo_r(struct rebuild *r, idx_t g, idx_t p)
{
	const idx_t b = r->gate, last = r->before[b], v = r->origin[b];
	join(r, last, g);
	join(r, g, p);
	join(r, p, b);
	r->origin[g] = v;
	r->origin[p] = new_vertex(r);
	open_corner(r, v);
	r->gate = g;
	r->length += 2;
}

static void undo_l(struct rebuild *r, idx_t g, idx_t p)
{
	const idx_t b = r->gate, last = r->before[b], v = r->origin[b];
	join(r, last, p);
	join(r, p, g);
	join(r, g, b);
	r->origin[p] = v;
	r->origin[g] = new_vertex(r);
	open_corner(r, v);
	r->gate = g;
	r->length += 2;
}

static void undo_s(struct rebuild *r, idx_t g, idx_t p)
{
	const struct waiting other = r->stack[--r->depth];
	const idx_t near = r->gate, near_end = r->before[near], far = other.gate, far_end = r->before[far];
	r->origin[g] = r->origin[far];
	r->origin[p] = r->origin[near];
	join(r, g, near);
	join(r, near_end, p);
	join(r, p, far);
	join(r, far_end, g);
	open_corner(r, r->origin[g]);
	open_corner(r, r->origin[p]);
	r->gate = g;
	r->length += other.length + 2;
}

static void undo_m(struct rebuild *r, idx_t g, idx_t p, const struct label *label)
{
	/* The first length - 1 half-edges and p become a boundary of their own, g and the rest stay. */
	const idx_t b = r->gate, end = r->before[b];
	idx_t cut = b; /* the last one that goes */
	for (idx_t i = 0; i < label->length - 2; i++)
		cut = r->after[cut];
	const idx_t rest = r->after[cut];
	r->origin[g] = r->origin[b];
	r->origin[p] = r->origin[rest];
	open_corner(r, r->origin[g]);
	open_corner(r, r->origin[p]);
	join(r, p, b);
	join(r, cut, p);
	join(r, end, g);
	join(r, g, rest);
	idx_t gate = p; /* the twin's place in that boundary is index */
	for (idx_t i = 0; i < label->index; i++)
		gate = r->before[gate];
	memmove(r->stack + r->depth - label->depth + 1, r->stack + r->depth - label->depth,
		(size_t)label->depth * sizeof *r->stack);
	r->stack[r->depth - label->depth] = (struct waiting){gate, label->length};
	r->depth++;
	r->gate = g;
	r->length += 2 - label->length;
}

/* F and H: the gate and the degree - 2 half-edges before it get a face on their outer side, closed by g. */
static void undo_face(struct rebuild *r, idx_t g, idx_t p, const struct label *label)
{
	const idx_t face = (idx_t)r->face_count++, following = r->after[r->gate];
	r->first[face] = g;
	r->degree[face] = label->degree;
	r->hole[face] = label->kind == LABEL_H;
	idx_t x = r->gate, front = g;
	for (idx_t i = 0;; i++) {
		r->next[front] = x ^ 1;
		front = x ^ 1;
		r->face[front] = face;
		if (i == label->degree - 2)
			break;
		if (r->open[r->origin[x]] < 255)
			r->open[r->origin[x]]--;
		x = r->before[x];
	}
	r->next[front] = g;
	r->face[g] = face;
	const idx_t leading = r->before[x];
	r->origin[g] = r->origin[x];
	r->origin[p] = r->origin[following];
	join(r, leading, g);
	join(r, g, following);
	idx_t h = g;
	do {
		unsigned char *valence = &r->valence[r->origin[h]];
		if (*valence < VALENCE_CAP - 1)
			++*valence;
		h = r->next[h];
	} while (h != g);
	r->gate = g;
	r->length += 2 - label->degree;
	r->component_faces++;
}

/* --- coding of labels --------------------------------------------------------------------------------------------- */

static unsigned length_class(idx_t length)
{
	return length - 2 < LENGTH_CAP - 1 ? (unsigned)(length - 2) : LENGTH_CAP - 1;
}

/* What lies on the inner side of a boundary half-edge. */
static unsigned face_class(const struct rebuild *r, idx_t half)
{
	const idx_t f = r->face[half];
	if (f == NO_INDEX)
		return 0;
	if (r->hole[f] || r->degree[f] > 6)
		return 4;
	return r->degree[f] == 3 ? 1 : r->degree[f] == 4 ? 2 : 3;
}

static bool is_possible(const struct rebuild *r, unsigned kind)
{
	static const unsigned char least[LABEL_COUNT] = {
		[LABEL_F4] = 4, [LABEL_F3] = 3, [LABEL_F5] = 5, [LABEL_F6] = 6, [LABEL_F7] = 7, [LABEL_H] = 3};
	if (kind == LABEL_S)
		return r->depth > 0;
	return r->length >= least[kind];
}

static void code_kind(struct rebuild *r, struct label *label)
{
	const idx_t gate = r->gate, last = r->before[gate];
	const idx_t start = r->origin[gate];
	const unsigned at_start = r->valence[start], at_end = r->valence[r->origin[r->after[gate]]],
		       at_last = r->valence[r->origin[last]];
	const unsigned length = length_class(r->length), is_shared = r->open[start] > 1;
	const unsigned at_last2 = r->valence[r->origin[r->before[last]]], is_last_shared = r->open[r->origin[last]] > 1;
	const unsigned face = face_class(r, gate), last_face = face_class(r, last);
	const unsigned short_length = length < 2 ? length : 2;
	const unsigned input[LABEL_INPUTS] = {
		r->previous * LENGTH_CAP + length,
		r->previous * LABEL_COUNT + r->previous2,
		(at_start * VALENCE_CAP + at_end) * 2 + is_shared,
		(r->previous * VALENCE_CAP + at_start) * LENGTH_CAP + length,
		(r->previous * VALENCE_CAP + at_end) * 2 + is_shared,
		(at_start * VALENCE_CAP + at_last) * VALENCE_CAP + at_end,
		((face * VALENCE_CAP + at_start) * VALENCE_CAP + at_last) * 3 + short_length,
		(face * 5 + last_face) * LENGTH_CAP + length,
		((at_start * VALENCE_CAP + at_last) * VALENCE_CAP + at_last2) * 4 + is_shared * 2 + is_last_shared,
	};
	static const size_t size[LABEL_INPUTS] = {LABEL_SIZE_0, LABEL_SIZE_1, LABEL_SIZE_2, LABEL_SIZE_3, LABEL_SIZE_4,
						  LABEL_SIZE_5, LABEL_SIZE_6, LABEL_SIZE_7, LABEL_SIZE_8};
	unsigned kind = 0;
	for (; kind < LABEL_M; kind++) {
		if (!is_possible(r, kind))
			continue;
		size_t base = CONTEXT_LABEL + kind * (size_t)LABEL_SIZE;
		for (size_t i = 0; i < LABEL_INPUTS; i++) {
			mix_context(r->coder, base + input[i], WEIGHT_LABEL + (kind * LABEL_INPUTS + i) * CONFIDENCE_CLASSES);
			base += size[i];
		}
		if (mix_code(r->coder, label->kind == kind))
			break;
	}
	label->kind = (unsigned char)kind;
}

/* Code one label; false when its numbers contradict the state. */
static bool code_label(struct rebuild *r, struct label *label)
{
	code_kind(r, label);
	switch (label->kind) {
	case LABEL_F3:
		label->degree = 3;
		break;
	case LABEL_F4:
		label->degree = 4;
		break;
	case LABEL_F5:
		label->degree = 5;
		break;
	case LABEL_F6:
		label->degree = 6;
		break;
	case LABEL_F7: {
		const uint32_t limit = (uint32_t)r->length - 7;
		const uint32_t more = model_golomb(r->coder, CONTEXT_DEGREE, limit, (uint32_t)label->degree - 7);
		if (more > limit)
			return false;
		label->degree = (idx_t)more + 7;
		break;
	}
	case LABEL_H: {
		const uint32_t limit = (uint32_t)r->length - 3;
		const uint32_t more =
			model_golomb(r->coder, CONTEXT_DEGREE + CONTEXT_DEGREE_SIZE, limit, (uint32_t)label->degree - 3);
		if (more > limit)
			return false;
		label->degree = (idx_t)more + 3;
		break;
	}
	case LABEL_M:
		label->depth = (idx_t)model_uniform(r->coder, (uint32_t)r->depth + 1, (uint32_t)label->depth);
		label->length = (idx_t)model_uniform(r->coder, (uint32_t)r->length - 1, (uint32_t)label->length - 2) + 2;
		label->index = (idx_t)model_uniform(r->coder, (uint32_t)label->length, (uint32_t)label->index);
		r->merge_work += (size_t)label->length + (size_t)label->index + (size_t)label->depth;
		return r->merge_work <= MERGE_WORK_LIMIT;
	default:
		break;
	}
	return true;
}

static void undo(struct rebuild *r, const struct label *label, bool is_start)
{
	const idx_t g = (idx_t)r->half_count, p = g + 1;
	r->half_count += 2;
	r->face[g] = r->face[p] = NO_INDEX;
	switch (label->kind) {
	case LABEL_E:
		undo_e(r, g, p, is_start);
		break;
	case LABEL_R:
		undo_r(r, g, p);
		break;
	case LABEL_L:
		undo_l(r, g, p);
		break;
	case LABEL_S:
		undo_s(r, g, p);
		break;
	case LABEL_M:
		undo_m(r, g, p, label);
		break;
	default:
		undo_face(r, g, p, label);
		break;
	}
	r->previous2 = r->previous;
	r->previous = label->kind;
}

/* One component, from its last label to its first. labels: those of the component, or NULL. */
static bool code_component(struct rebuild *r, const struct label *labels, size_t label_count, size_t label_limit,
			   struct fault *fault)
{
	r->previous = r->previous2 = LABEL_E;
	r->component_faces = 0;
	struct label label = {.kind = LABEL_E};
	for (size_t i = 0;; i++) {
		reserve(r);
		if (r->half_count / 2 >= label_limit)
			return fault_set(fault, EX_BAD_INPUT, "more edges than a stream of this size can have");
		if (labels)
			label = labels[label_count - 1 - i];
		if (i > 0 && !code_label(r, &label))
			return fault_set(fault, EX_BAD_INPUT, "connectivity contradicts itself at edge %zu", r->half_count / 2);
		if (r->coder->range.is_overrun)
			return fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
		undo(r, &label, i == 0);
		const idx_t a = r->gate, b = r->after[a];
		if (r->depth == 0 && r->length == 2 && r->component_faces > 0 && b != (a ^ 1)) {
			const size_t context = CONTEXT_DONE + (label.kind == LABEL_F4   ? 0
							       : label.kind == LABEL_F3 ? 1
							       : label.kind == LABEL_H  ? 2
											: 3);
			if (model_bit(r->coder, context, labels && i + 1 == label_count))
				break;
		}
	}
	r->root[r->component_count++] = r->gate;
	return true;
}

/* --- the finished surface ----------------------------------------------------------------------------------------- */

/* Drop the two halves of each component's start edge that no face uses, and renumber. */
static void take_surface(struct ffx_surface *surface, const struct rebuild *r, idx_t *original)
{
	*surface = (struct ffx_surface){
		.face_count = r->face_count, .vertex_count = r->vertex_count, .component_count = r->component_count};
	idx_t *number = mem_array(r->half_count, sizeof *number);
	size_t count = 0;
	for (size_t h = 0; h < r->half_count; h++) {
		number[h] = r->face[h] == NO_INDEX ? NO_INDEX : (idx_t)count;
		if (r->face[h] != NO_INDEX) {
			if (original)
				original[count] = original[h];
			count++;
		}
	}
	surface->half_count = count;
	surface->next = mem_array(count, sizeof(idx_t));
	surface->previous = mem_array(count, sizeof(idx_t));
	surface->twin = mem_array(count, sizeof(idx_t));
	surface->origin = mem_array(count, sizeof(idx_t));
	surface->face = mem_array(count, sizeof(idx_t));
	surface->first = mem_array(r->face_count, sizeof(idx_t));
	surface->degree = mem_copy(r->degree, r->face_count, sizeof(idx_t));
	surface->hole = mem_copy(r->hole, r->face_count, 1);
	surface->outgoing = mem_array(r->vertex_count, sizeof(idx_t));
	surface->root = mem_array(r->component_count, sizeof(idx_t));
	for (size_t f = 0; f < r->face_count; f++) {
		surface->first[f] = number[r->first[f]];
		surface->hole_count += r->hole[f];
	}
	for (size_t h = 0; h < r->half_count; h++) {
		const idx_t n = number[h];
		if (n == NO_INDEX)
			continue;
		surface->next[n] = number[r->next[h]];
		surface->previous[surface->next[n]] = n;
		surface->twin[n] = number[h ^ 1]; /* NO_INDEX at the start edges */
		surface->origin[n] = r->origin[h];
		surface->face[n] = r->face[h];
		surface->outgoing[r->origin[h]] = n;
	}
	for (size_t c = 0; c < r->component_count; c++) {
		const idx_t a = number[r->root[c]], b = number[r->after[r->root[c]]];
		surface->twin[a] = b;
		surface->twin[b] = a;
		surface->root[c] = a;
	}
	free(number);
}

bool connect_code(struct ffx_coder *coder, struct ffx_surface *surface, const struct labels *labels, idx_t **original,
		  size_t label_limit, struct fault *fault)
{
	*surface = (struct ffx_surface){0};
	struct rebuild r = {.coder = coder};
	bool is_good = true;
	for (size_t c = 0, first = 0; is_good; c++) {
		const size_t end = labels ? labels->component_end[c] : 0;
		is_good = code_component(&r, labels ? labels->label + first : NULL, end - first, label_limit, fault);
		first = end;
		if (is_good && !model_bit(coder, CONTEXT_MORE, labels && c + 1 < labels->component_count))
			break;
	}
	if (is_good) {
		idx_t *from = NULL;
		if (labels) {
			/* Labels are numbered backward in each component. */
			from = mem_array(r.half_count, sizeof *from);
			size_t pair = 0;
			for (size_t c = 0, first = 0; c < labels->component_count; first = labels->component_end[c++])
				for (size_t i = labels->component_end[c]; i-- > first; pair++) {
					from[2 * pair] = labels->label[i].gate;
					from[2 * pair + 1] = labels->label[i].twin;
				}
		}
		take_surface(surface, &r, from);
		if (labels)
			*original = from;
		else
			is_good = surface_check(surface, fault);
		if (!is_good)
			surface_free(surface);
	}
	rebuild_free(&r);
	return is_good;
}
