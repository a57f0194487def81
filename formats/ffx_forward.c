/* The forward coder: the walk (see ffx_forward.h). */
#include "formats/ffx_forward.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "formats/ffx_angle.h"
#include "formats/ffx_ask.h"

static void place_vertex(struct forward *f, const struct guesses *guesses, idx_t v)
{
	const uint64_t before = f->coder->cost;
	geometry_vertex(&f->geometry, guesses, f->grid + 3 * (size_t)v);
	f->cost_g += f->coder->cost - before;
	f->placed++;
}

/* --- one face -------------------------------------------------------------------------------------------------------- */

/* Is the boundary's corner before half, at its origin, all border? */
static bool is_shut(const struct forward *f, idx_t half)
{
	return f->is_dead[half] && f->is_dead[f->before[half]];
}

static int compare_far(const void *left, const void *right)
{
	const struct far *a = left, *b = right;
	if (a->distance != b->distance)
		return a->distance < b->distance ? -1 : 1;
	return a->half < b->half ? -1 : a->half > b->half;
}

/* May the face go on over a new edge to the corner of boundary half-edge x? */
static bool is_target(const struct forward *f, const struct step *step, idx_t x)
{
	return !forward_has(f, f->origin[x]) && !is_shut(f, x) && (step->fresh > 0 || f->origin[x] != forward_end(f, step->out));
}

/* How far a vertex is from both ends of the gap: the sum of squares. The one before the chain comes late: its edge to e is not of
 * this face. */
static int64_t distance_of(const struct forward *f, const struct step *step, idx_t x)
{
	int64_t d[3], from[3];
	vector_between(d, forward_point(f, step->c), forward_point(f, f->origin[x]));
	vector_between(from, forward_point(f, step->e), forward_point(f, f->origin[x]));
	const int64_t sum = vector_dot(d, d) + vector_dot(from, from);
	return f->origin[x] == f->origin[f->before[step->first]] ? 16 * sum : sum;
}

static void find_nearest(struct forward *f, struct step *step)
{
	step->nearest = NO_INDEX;
	for (size_t i = 0; i < f->bound_count; i++) {
		const idx_t x = f->bound[i];
		if (!is_target(f, step, x))
			continue;
		const int64_t distance = distance_of(f, step, x);
		if (step->nearest == NO_INDEX || distance < step->distance) {
			step->nearest = f->origin[x];
			step->distance = distance;
		}
	}
	f->work += f->bound_count;
}

/* Which boundary corner does the face jump to? They are numbered by distance. Encoding: target is known. NO_INDEX when there is
 * none. */
static idx_t code_target(struct forward *f, const struct step *step, idx_t target)
{
	if (f->far_room < f->bound_count) {
		f->far_room = f->half_room;
		f->far = mem_resize(f->far, f->far_room, sizeof *f->far);
	}
	size_t count = 0, rank = 0;
	for (size_t i = 0; i < f->bound_count; i++)
		if (is_target(f, step, f->bound[i]))
			f->far[count++] = (struct far){distance_of(f, step, f->bound[i]), f->bound[i]};
	f->work += 8 * f->bound_count;
	if (count == 0)
		return NO_INDEX;
	qsort(f->far, count, sizeof *f->far, compare_far);
	if (f->surface)
		while (f->far[rank].half != target)
			rank++;
	rank = model_golomb(f->coder, CONTEXT_RANK, (uint32_t)count - 1, (uint32_t)rank);
	return rank < count ? f->far[rank].half : NO_INDEX;
}

/* Encoding: the boundary's half-edge behind the corner of the face's half-edge that starts at the same vertex. */
static idx_t boundary_behind(const struct forward *f, idx_t source)
{
	const struct ffx_surface *s = f->surface;
	idx_t e = source;
	while (f->built[e] == NO_INDEX || f->face[f->built[e]] != NO_INDEX)
		e = surface_turn(s, e);
	return f->built[e];
}

static void push(struct forward *f, idx_t half, idx_t corner)
{
	f->corner[f->path_count] = corner;
	f->is_known[f->path_count] = corner != NO_INDEX;
	f->path[f->path_count++] = half;
	forward_reserve(f);
}

static void enter(struct forward *f, idx_t vertex)
{
	f->mark[vertex] = (idx_t)f->face_count + 1;
}

/* Newell's normal of the known corners; faces with very many are judged by those next to the gate. */
#define NORMAL_CORNERS 16
static void known_normal(struct forward *f, struct step *step)
{
	int64_t sum[3] = {0};
	const int32_t *foot = forward_point(f, f->origin[step->gate]);
	const int32_t *last = NULL;
	const size_t behind = f->behind_count < NORMAL_CORNERS ? f->behind_count : NORMAL_CORNERS;
	const size_t ahead = f->path_count < NORMAL_CORNERS ? f->path_count : NORMAL_CORNERS;
	step->known = 0;
	for (size_t i = 0; i < behind + ahead + 1; i++) {
		const int32_t *at;
		if (i < behind)
			at = forward_point(f, f->origin[f->behind[behind - 1 - i]]);
		else if (i == behind)
			at = foot;
		else if (i - behind < ahead && f->corner[i - behind] == NO_INDEX)
			continue;
		else
			at = forward_point(f, i - behind < ahead ? f->origin[f->path[i - behind]] : step->c);
		if (i == behind + ahead && step->fresh > 0)
			continue;
		if (last) {
			int64_t u[3], w[3], cross[3];
			vector_between(u, foot, last);
			vector_between(w, foot, at);
			vector_cross(cross, u, w);
			for (int k = 0; k < 3; k++)
				sum[k] += cross[k];
		}
		last = at;
		step->known++;
	}
	vector_shrink(sum);
	memcpy(step->normal, sum, sizeof sum);
}

/* The finished face takes its half-edges; the boundary goes around it. */
static void close_face(struct forward *f)
{
	const size_t n = f->path_count;
	const idx_t face = (idx_t)f->face_count++;
	for (size_t i = 0; i < n; i++) {
		const idx_t in = f->path[i], out = f->path[i + 1 < n ? i + 1 : 0];
		/* corner[i + 1] is NO_INDEX where in or out was on the boundary, else what follows the face there. New half-edges
		 * have no place yet: after is unset, so they are told by is_dead == 2. */
		const bool in_is_new = f->is_dead[in] == 2, out_is_new = f->is_dead[out] == 2;
		if (!in_is_new && out_is_new) {
			forward_join(f, out ^ 1, f->after[in]);
		} else if (in_is_new && !out_is_new) {
			forward_join(f, f->before[out], in ^ 1);
		} else if (in_is_new) {
			const idx_t behind = f->corner[i + 1 < n ? i + 1 : 0];
			if (behind == NO_INDEX) {
				forward_join(f, out ^ 1, in ^ 1);
			} else {
				const idx_t ahead = f->before[behind];
				forward_join(f, ahead, in ^ 1);
				forward_join(f, out ^ 1, behind);
			}
		}
	}
	int64_t normal[3] = {0};
	const int32_t *foot = forward_point(f, f->origin[f->path[0]]);
	for (size_t i = 0; i < n; i++) {
		const idx_t h = f->path[i], following = f->path[i + 1 < n ? i + 1 : 0];
		if (f->is_dead[h] == 2)
			forward_bound_add(f, h ^ 1);
		else
			forward_bound_remove(f, h);
		f->is_dead[h] = 0;
		f->face[h] = face;
		f->next[h] = following;
		f->previous[following] = h;
		int64_t u[3], v[3], cross[3];
		vector_between(u, foot, forward_point(f, f->origin[h]));
		vector_between(v, foot, forward_point(f, forward_end(f, h)));
		vector_cross(cross, u, v);
		for (int k = 0; k < 3; k++)
			normal[k] += cross[k];
	}
	vector_shrink(normal);
	memcpy(f->normal + 3 * (size_t)face, normal, sizeof normal);
	f->first[face] = f->path[0];
	f->degree[face] = (idx_t)n;
	for (size_t i = 0; i < n; i++) {
		const idx_t h = f->path[i], v = f->origin[h];
		int64_t to[3], from[3];
		vector_between(to, forward_point(f, v), forward_point(f, forward_end(f, h)));
		vector_between(from, forward_point(f, v), forward_point(f, f->origin[f->previous[h]]));
		if (f->used[v] < 1 << 24)
			f->used[v] += angle_between(to, from);
		if (f->valence[v] < 255)
			f->valence[v]++;
	}
}

/* The chain of old corners around the gate. True when it closes the face. */
static bool extend_ahead(struct forward *f, struct step *step)
{
	const struct ffx_surface *s = f->surface;
	for (;;) {
		const idx_t o = step->out;
		const bool closes = f->after[o] == step->first && forward_end(f, o) == step->e;
		if (f->is_dead[o] || (closes ? step->count < 2 : forward_has(f, forward_end(f, o))))
			return false;
		const unsigned truth = s && s->next[f->source[step->last]] == f->source[o];
		if (!ask_along(f, step, false, closes, truth))
			return false;
		push(f, o, o);
		step->count++;
		step->p = step->c;
		step->c = forward_end(f, o);
		step->last = o;
		step->out = f->after[o];
		if (closes)
			return true;
		enter(f, step->c);
		known_normal(f, step);
	}
}

static void extend_behind(struct forward *f, struct step *step)
{
	const struct ffx_surface *s = f->surface;
	for (;;) {
		const idx_t h = f->before[step->first];
		if (f->is_dead[h] || forward_has(f, f->origin[h]))
			return;
		const unsigned truth = s && s->previous[f->source[step->first]] == f->source[h];
		if (!ask_along(f, step, true, false, truth))
			return;
		f->behind[f->behind_count++] = h;
		forward_reserve(f);
		step->count++;
		step->s = step->e;
		step->e = f->origin[h];
		step->first = h;
		enter(f, step->e);
		known_normal(f, step);
	}
}

static bool is_within_limits(const struct forward *f, struct fault *fault)
{
	if (f->half_count / 2 > f->edge_limit)
		return fault_set(fault, EX_BAD_INPUT, "more edges than a stream of this size can have");
	if (f->work > FORWARD_WORK_LIMIT)
		return fault_set(fault, EX_BAD_INPUT, "connectivity asks for too much work");
	return true;
}

/* From c back to e: new vertices, and old ones that the face jumps to. */
static bool fill_gap(struct forward *f, struct step *step, struct fault *fault)
{
	const struct ffx_surface *s = f->surface;
	idx_t cursor = step->c, in = step->last, out = step->out;
	for (;;) {
		const idx_t t = s ? s->next[f->source[in]] : NO_INDEX;
		const bool may_close = step->count >= 2 && !(step->fresh == 0 && out == f->before[step->first]);
		if (may_close && ask_close(f, step, s && s->next[t] == f->source[step->first])) {
			const idx_t h = forward_pair(f, cursor, step->e, t);
			f->is_dead[h] = 2;
			push(f, h, out);
			return true;
		}
		const idx_t u = s ? surface_end(s, t) : NO_INDEX;
		find_nearest(f, step);
		const bool is_new = step->nearest == NO_INDEX || ask_new(f, step, s && f->number[u] == NO_INDEX);
		idx_t v, target = NO_INDEX;
		if (is_new) {
			v = forward_vertex(f, u);
		} else {
			target = code_target(f, step, s ? boundary_behind(f, s->next[t]) : NO_INDEX);
			if (target == NO_INDEX)
				return fault_set(fault, EX_BAD_INPUT, "connectivity contradicts itself at face %zu",
						 f->face_count);
			v = f->origin[target];
		}
		const idx_t h = forward_pair(f, cursor, v, t);
		f->is_dead[h] = 2;
		push(f, h, out);
		enter(f, v);
		step->count++;
		cursor = v;
		in = h;
		out = target;
		if (is_new) {
			step->fresh++;
		} else {
			step->p = step->c;
			step->c = v;
			step->fresh = 0;
			step->last = h;
			step->out = target;
			known_normal(f, step);
			if (extend_ahead(f, step))
				return true;
			cursor = step->c;
			in = step->last;
			out = step->out;
		}
		if (f->coder->range.is_overrun)
			return fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
		if (!is_within_limits(f, fault))
			return false;
	}
}

static bool code_face(struct forward *f, idx_t gate, struct fault *fault)
{
	struct step step = {.gate = gate,
			    .first = gate,
			    .last = gate,
			    .p = f->origin[gate],
			    .c = forward_end(f, gate),
			    .e = f->origin[gate],
			    .s = forward_end(f, gate),
			    .out = f->after[gate],
			    .count = 1};
	f->path_count = f->behind_count = 0;
	push(f, gate, gate);
	enter(f, step.e);
	enter(f, step.c);
	known_normal(f, &step);
	if (!extend_ahead(f, &step)) {
		extend_behind(f, &step);
		if (!fill_gap(f, &step, fault))
			return false;
	}
	/* The path from its first half-edge on. */
	const size_t n = f->behind_count;
	memmove(f->path + n, f->path, f->path_count * sizeof *f->path);
	memmove(f->corner + n, f->corner, f->path_count * sizeof *f->corner);
	memmove(f->is_known + n, f->is_known, f->path_count);
	f->path_count += n;
	for (size_t i = 0; i < n; i++) {
		f->path[i] = f->corner[i] = f->behind[n - 1 - i];
		f->is_known[i] = 1;
	}
	f->behind_count = 0;
	for (size_t i = 0, known = 0; i < f->path_count; i++) {
		if (f->is_known[i])
			continue;
		for (known = known > i ? known : i + 1; known < f->path_count && !f->is_known[known]; known++)
			;
		struct guesses guesses;
		foresee(&guesses, f, i, known - i);
		place_vertex(f, &guesses, f->origin[f->path[i]]);
		f->is_known[i] = 1;
		if (f->coder->range.is_overrun)
			return fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
	}
	close_face(f);
	return true;
}

/* --- components ------------------------------------------------------------------------------------------------------- */

/* The boundary half-edge whose end has the most angle used; of those the latest. */
static idx_t choose_gate(struct forward *f)
{
	idx_t best = NO_INDEX;
	int32_t most = -1;
	for (size_t i = 0; i < f->bound_count; i++) {
		const idx_t h = f->bound[i];
		if (f->is_dead[h])
			continue;
		const int32_t used = f->used[forward_end(f, h)];
		if (used > most || (used == most && h > best)) {
			most = used;
			best = h;
		}
	}
	f->work += f->bound_count;
	return best;
}

static bool code_component(struct forward *f, idx_t root, struct fault *fault)
{
	const struct ffx_surface *s = f->surface;
	forward_reserve(f);
	f->component_start = f->vertex_count;
	struct guesses guesses;
	foresee_first(&guesses, f);
	const idx_t a = forward_vertex(f, s ? s->origin[root] : NO_INDEX);
	place_vertex(f, &guesses, a);
	forward_reserve(f);
	foresee_first(&guesses, f);
	const idx_t b = forward_vertex(f, s ? surface_end(s, root) : NO_INDEX);
	place_vertex(f, &guesses, b);
	const idx_t first = forward_pair(f, a, b, root);
	forward_join(f, first, first ^ 1);
	forward_join(f, first ^ 1, first);
	f->bound_count = f->alive_count = 0;
	forward_bound_add(f, first);
	forward_bound_add(f, first ^ 1);
	f->root[f->component_count++] = first;
	/* both sides alike at first: the root's own comes first */
	idx_t gate = first;
	while (f->alive_count > 0) {
		forward_reserve(f);
		if (!is_within_limits(f, fault))
			return false;
		bool is_border = false;
		if (f->has_border) {
			const unsigned context = f->is_dead[f->before[gate]] + 2u * f->is_dead[f->after[gate]];
			is_border = model_bit(f->coder, CONTEXT_BORDER + context, s && s->hole[s->face[f->source[gate]]]);
		}
		if (is_border) {
			f->is_dead[gate] = 1;
			f->alive_count--;
		} else if (!code_face(f, gate, fault)) {
			return false;
		}
		gate = choose_gate(f);
	}
	return true;
}

bool forward_code(struct forward *f, struct ffx_coder *coder, const struct ffx_surface *surface, const int32_t *grid, idx_t root,
		  int32_t steps, size_t edge_limit, struct fault *fault)
{
	f->coder = coder;
	f->surface = surface;
	f->surface_grid = grid;
	f->edge_limit = edge_limit;
	f->half_count = f->vertex_count = f->face_count = f->bound_count = f->path_count = f->behind_count = f->component_count =
		0;
	f->work = f->placed = 0;
	f->cost_g = 0;
	geometry_start(&f->geometry, coder, steps);
	if (surface) {
		if (f->built_room < surface->half_count) {
			f->built_room = surface->half_count;
			f->built = mem_resize(f->built, f->built_room, sizeof(idx_t));
		}
		if (f->number_room < surface->vertex_count) {
			f->number_room = surface->vertex_count;
			f->number = mem_resize(f->number, f->number_room, sizeof(idx_t));
		}
		memset(f->built, 0xff, surface->half_count * sizeof(idx_t));
		memset(f->number, 0xff, surface->vertex_count * sizeof(idx_t));
	}
	f->has_border = model_bit(coder, CONTEXT_HAS_BORDER, surface && surface->hole_count > 0);
	idx_t next_root = root;
	for (size_t h = 0;;) {
		if (!code_component(f, next_root, fault))
			return false;
		bool is_more = false;
		if (surface) {
			while (h < surface->half_count && f->built[h] != NO_INDEX)
				h++;
			is_more = h < surface->half_count;
			next_root = (idx_t)h;
		}
		if (!model_bit(coder, CONTEXT_MORE_FORWARD, is_more))
			break;
	}
	if (coder->range.is_overrun)
		return fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
	return true;
}
