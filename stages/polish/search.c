#include "stages/polish/search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/polish/refit.h"

/* Rates of the coder in bits, from the streams of many cages. */
#define BITS_VERTEX 15.0
#define BITS_EDGE 1.9
#define BITS_CORNER 4.0
#define BITS_CREASE 0.25

#define REFITS_TRIAL 2   /* iterations for an edit under trial */
#define REFIT_EVERY 8    /* edits between fits of all points */
#define REFITS_ALL 2
#define FOLDED_SLACK 1e-7  /* share of the area: rounding of sums */
#define TURNED_LIMIT 4e-4 /* share of the area that may look the other way, if it did not before */
#define MOST_REFUSED 6   /* edits in a row that went too far: the others are dearer */

void candidate_free(struct candidate *c)
{
	sketch_free(&c->sketch);
	errors_free(&c->errors);
}

void candidate_copy(struct candidate *out, const struct candidate *in)
{
	sketch_copy(&out->sketch, &in->sketch);
	out->errors = (struct errors){0};
	out->errors.cost = in->errors.cost, out->errors.mean = in->errors.mean, out->errors.max = in->errors.max, out->errors.turned = in->errors.turned, out->errors.folded = in->errors.folded;
}

void search_add(struct search_report *sum, const struct search_report *report)
{
	sum->tried += report->tried, sum->done += report->done;
	for (int k = 0; k < MOVE_KINDS; k++)
		sum->by_kind[k] += report->by_kind[k];
}

double search_bits(const struct sketch *s)
{
	size_t corners = 0, creases = 0;
	for (size_t v = 0; v < s->vertex_count; v++)
		corners += s->corner[v] && sketch_star(s, (idx_t)v).sharp < 3;
	for (size_t h = 0; h < s->face_start[s->face_count]; h++)
		creases += s->sharp[h] && s->twin[h] > (idx_t)h;
	return BITS_VERTEX * (double)s->vertex_count + BITS_EDGE * (double)sketch_edge_count(s) + BITS_CORNER * (double)corners +
	       BITS_CREASE * (double)creases;
}

/* --- one edit under trial ----------------------------------------------------------------------------------------------- */

struct trial {
	struct sketch sketch;
	double cost, bits; /* changes against before */
	struct move_trace trace;
	struct view view;  /* of the changed faces */
	idx_t *face, *sample;
};

static void trial_close(struct trial *trial)
{
	view_free(&trial->view);
	free(trial->face), free(trial->sample);
	move_trace_free(&trial->trace);
}

static void trial_free(struct trial *trial)
{
	trial_close(trial);
	sketch_free(&trial->sketch);
}

/* Try one edit: false when it is not possible. rate: cost that a bit may be worth; fitting is cut short where the edit cannot reach it. */
static bool try_move(struct trial *trial, const struct candidate *c, const struct judge *judge, const idx_t *index, struct move move,
                     double rate, int iterations)
{
	struct move_trace *const trace = &trial->trace;
	if (!move_apply(&trial->sketch, trace, &c->sketch, index, move))
		return false;
	struct sketch *s = &trial->sketch;
	size_t face_count, sample_count = 0;
	trial->face = sketch_faces_near(&face_count, s, trace->touched, trace->touched_count, 2);
	/* samples of the old faces that are gone or changed */
	unsigned char *changed = mem_array(s->face_count, 1);
	for (size_t i = 0; i < face_count; i++)
		changed[trial->face[i]] = 1;
	trial->sample = mem_array(judge->target->count, sizeof *trial->sample);
	double before_samples = 0, before_spots = 0, total_area = 0;
	unsigned char *counted = mem_array(c->sketch.vertex_count, 1);
	for (size_t f = 0; f < c->sketch.face_count; f++) {
		total_area += c->errors.face[f].area;
		if (trace->face[f] != NO_INDEX && !changed[trace->face[f]])
			continue;
		before_spots += c->errors.face[f].cost;
		for (size_t h = c->sketch.face_start[f]; h < c->sketch.face_start[f + 1]; h++) {
			const idx_t v = c->sketch.face_corner[h];
			before_samples += counted[v] ? 0 : (double)c->errors.tip[v];
			counted[v] = 1;
		}
		for (size_t i = c->errors.face_first[f]; i < c->errors.face_first[f + 1]; i++) {
			trial->sample[sample_count++] = c->errors.face_sample[i];
			before_samples += (double)c->errors.sample[c->errors.face_sample[i]].cost;
		}
	}
	free(changed), free(counted);
	const double before = (before_samples / (double)judge->target->area_count + before_spots / total_area) / 2;
	view_open(&trial->view, judge, s, trial->face, face_count, trial->sample, sample_count);
	trial->bits = search_bits(s) - search_bits(&c->sketch);
	trial->cost = refit_few(s, &trial->view, judge, trace->touched, trace->touched_count, total_area, before - rate * trial->bits, iterations) - before;
	return true;
}

/* The candidate that the trial makes of c; the trial is used up. */
static struct candidate trial_take(struct trial *trial, const struct candidate *c, const struct judge *judge)
{
	struct candidate next = {.sketch = trial->sketch};
	idx_t *index = sketch_index(&trial->sketch), *vertex = mem_array(c->sketch.vertex_count, sizeof *vertex);
	for (size_t v = 0; v < c->sketch.vertex_count; v++)
		vertex[v] = index[c->sketch.id[v]];
	judge_edit(&next.errors, judge, &next.sketch, &trial->view, &c->errors, trial->trace.face, c->sketch.face_count, vertex, c->sketch.vertex_count);
	free(index), free(vertex);
	trial_close(trial);
	return next;
}

/* --- removal --------------------------------------------------------------------------------------------------------------- */

struct entry {
	struct move move;
	double slope;   /* cost a bit */
	bool is_fitted; /* else the slope is a guess of what fitting would leave of it */
};

struct queue {
	struct entry *entry; /* heap, least slope first */
	size_t count, room;
	struct move *seen;   /* hash table of the moves in the heap; kind MOVE_KINDS: free */
	size_t seen_count, seen_room;
};

static size_t seen_slot(const struct queue *q, struct move m)
{
	size_t i = ((size_t)m.a * 0x9E3779B97F4A7C15u ^ (size_t)(m.b + 1) * 0xC2B2AE3D27D4EB4Fu ^ (size_t)m.kind * 0x165667B19E3779F9u) >> 20;
	for (i %= q->seen_room; q->seen[i].kind != MOVE_KINDS; i = (i + 1) % q->seen_room)
		if (q->seen[i].kind == m.kind && q->seen[i].a == m.a && q->seen[i].b == m.b)
			break;
	return i;
}

/* True when the move was not there yet. */
static bool see(struct queue *q, struct move m)
{
	if (2 * (q->seen_count + 1) > q->seen_room) {
		struct move *const old = q->seen;
		const size_t old_room = q->seen_room;
		q->seen = mem_array(q->seen_room = 2 * old_room + 1024, sizeof *q->seen);
		for (size_t i = 0; i < q->seen_room; i++)
			q->seen[i].kind = MOVE_KINDS;
		for (size_t i = 0; i < old_room; i++)
			if (old[i].kind != MOVE_KINDS)
				q->seen[seen_slot(q, old[i])] = old[i];
		free(old);
	}
	const size_t i = seen_slot(q, m);
	if (q->seen[i].kind != MOVE_KINDS)
		return false;
	q->seen[i] = m;
	q->seen_count++;
	return true;
}

static bool is_less(const struct entry *a, const struct entry *b)
{
	if (a->slope != b->slope)
		return a->slope < b->slope;
	if (a->move.kind != b->move.kind)
		return a->move.kind < b->move.kind;
	if (a->move.a != b->move.a)
		return a->move.a < b->move.a;
	return a->move.b < b->move.b;
}

static void push(struct queue *q, struct entry entry)
{
	if (q->count == q->room)
		q->entry = mem_resize(q->entry, q->room = 2 * q->room + 64, sizeof *q->entry);
	size_t i = q->count++;
	for (; i > 0 && is_less(&entry, &q->entry[(i - 1) / 2]); i = (i - 1) / 2)
		q->entry[i] = q->entry[(i - 1) / 2];
	q->entry[i] = entry;
}

static struct entry pop(struct queue *q)
{
	const struct entry top = q->entry[0], last = q->entry[--q->count];
	size_t i = 0;
	for (size_t child; (child = 2 * i + 1) < q->count; i = child) {
		if (child + 1 < q->count && is_less(&q->entry[child + 1], &q->entry[child]))
			child++;
		if (!is_less(&q->entry[child], &last))
			break;
		q->entry[i] = q->entry[child];
	}
	if (q->count > 0)
		q->entry[i] = last;
	return top;
}

/* The removals at one half-edge's edge and origin. */
static size_t removals_at(struct move out[3], const struct sketch *s, idx_t h, bool with_vertex)
{
	const idx_t a = s->id[s->face_corner[h]], b = s->id[sketch_head(s, h)];
	size_t count = 0;
	if (s->twin[h] == NO_INDEX || a < b) {
		if (!s->sharp[h] && s->scheme != SCHEME_LOOP)
			out[count++] = (struct move){MOVE_MERGE, a, b};
		out[count++] = (struct move){MOVE_COLLAPSE, a, b};
	}
	if (with_vertex && s->scheme != SCHEME_LOOP)
		out[count++] = (struct move){MOVE_REMOVE, a, -1};
	return count;
}

/* The last edit that came near a vertex, by name. */
struct stamps {
	size_t *of_id;
	size_t room, now;
};

static void make_room(struct stamps *stamps, const struct sketch *s)
{
	if ((size_t)s->next_id > stamps->room) {
		const size_t room = 2 * (size_t)s->next_id;
		stamps->of_id = mem_resize(stamps->of_id, room, sizeof *stamps->of_id);
		memset(stamps->of_id + stamps->room, 0, (room - stamps->room) * sizeof *stamps->of_id);
		stamps->room = room;
	}
}

/* Fitting takes most of a cost away: a twentieth is left at least where an edit is worth something. */
static double guess(double cost) { return cost > 0 ? cost / 20 : cost; }

static void try_and_push(struct queue *queue, const struct candidate *c, const struct judge *judge, const idx_t *index, struct move move,
                         struct search_report *report)
{
	struct trial trial;
	if (!see(queue, move) || !try_move(&trial, c, judge, index, move, INFINITY, 0))
		return;
	report->tried++;
	if (trial.bits < 0)
		push(queue, (struct entry){move, guess(trial.cost) / -trial.bits, false});
	trial_free(&trial);
}

/* Trials of all removals at vertices stamped now. */
static void try_near(struct queue *queue, const struct candidate *c, const struct judge *judge, const struct stamps *stamps, size_t most_work,
                     struct search_report *report)
{
	const struct sketch *s = &c->sketch;
	idx_t *index = sketch_index(s);
	for (size_t h = 0; h < s->face_start[s->face_count]; h++) {
		const idx_t v = s->face_corner[h], w = sketch_head(s, (idx_t)h);
		if (stamps->of_id[s->id[v]] != stamps->now && stamps->of_id[s->id[w]] != stamps->now)
			continue;
		struct move move[3];
		if (*judge->work >= most_work)
			break;
		const size_t count = removals_at(move, s, (idx_t)h, s->outgoing[v] == (idx_t)h && stamps->of_id[s->id[v]] == stamps->now);
		for (size_t i = 0; i < count; i++)
			try_and_push(queue, c, judge, index, move[i], report);
	}
	free(index);
}

/* Mark the vertices of faces that are new (by name) in after. */
static void mark_new(struct stamps *stamps, const struct sketch *after, idx_t first_new_face)
{
	make_room(stamps, after);
	stamps->now++;
	for (size_t f = 0; f < after->face_count; f++)
		if (after->face_id[f] >= first_new_face)
			for (size_t h = after->face_start[f]; h < after->face_start[f + 1]; h++)
				stamps->of_id[after->id[after->face_corner[h]]] = stamps->now;
}

/* Worse in what no saving makes up for: folds, or a distance beyond the limit. */
static bool spoils(const struct errors *now, const struct errors *before, const struct judge *judge)
{
	return now->folded > before->folded + FOLDED_SLACK || now->turned > fmax(before->turned, TURNED_LIMIT) || (now->max > judge->limit && now->max > 1.001 * before->max);
}

/* Fit all points; as it was when that spoils something. */
static void fit_again(struct candidate *c, const struct judge *judge)
{
	struct candidate fitted = {0};
	sketch_copy(&fitted.sketch, &c->sketch);
	refit_all(&fitted.sketch, &fitted.errors, judge, REFITS_ALL);
	if (spoils(&fitted.errors, &c->errors, judge)) {
		candidate_free(&fitted);
		return;
	}
	candidate_free(c);
	*c = fitted;
}

void search_reduce(struct candidate *c, const struct judge *judge, double most_mean, size_t most_work, struct search_report *report)
{
	struct queue queue = {0};
	struct stamps stamps = {0};
	mark_new(&stamps, &c->sketch, 0);
	try_near(&queue, c, judge, &stamps, most_work, report);
	size_t since_fit = 0, refused = 0;
	while (queue.count > 0 && *judge->work < most_work) {
		const struct entry entry = pop(&queue);
		idx_t *index = sketch_index(&c->sketch);
		struct trial trial;
		const bool is_possible = index[entry.move.a] != NO_INDEX && (entry.move.b < 0 || index[entry.move.b] != NO_INDEX) &&
		                         try_move(&trial, c, judge, index, entry.move, queue.count > 0 ? 2 * fabs(queue.entry[0].slope) + 1e-9 : INFINITY, REFITS_TRIAL);
		free(index);
		if (!is_possible)
			continue;
		report->tried++;
		const double slope = trial.bits < 0 ? trial.cost / -trial.bits : INFINITY;
		/* a guess, or tried before something near it changed: others may be cheaper now */
		if (queue.count > 0 && slope > queue.entry[0].slope && (!entry.is_fitted || slope > entry.slope)) {
			if (trial.bits < 0)
				push(&queue, (struct entry){entry.move, slope, true});
			trial_free(&trial);
			continue;
		}
		struct candidate next = trial_take(&trial, c, judge);
		const idx_t first_new = c->sketch.next_face_id;
		const bool is_far = next.errors.mean > most_mean;
		if (++since_fit >= REFIT_EVERY + c->sketch.vertex_count / 16 || (is_far && since_fit > 1)) {
			fit_again(&next, judge);
			since_fit = 0;
		}
		if (next.errors.mean > most_mean || spoils(&next.errors, &c->errors, judge)) {
			const bool is_too_far = next.errors.mean > most_mean;
			candidate_free(&next);
			if (is_too_far && ++refused > MOST_REFUSED)
				break;
			continue;
		}
		refused = 0;
		candidate_free(c);
		*c = next;
		report->done++, report->by_kind[entry.move.kind]++;
		mark_new(&stamps, &c->sketch, first_new);
		try_near(&queue, c, judge, &stamps, most_work, report);
	}
	free(queue.entry), free(queue.seen), free(stamps.of_id);
}

/* --- local search -------------------------------------------------------------------------------------------------------------- */

struct move_list {
	struct move *move;
	size_t count, room;
};
static void list(struct move_list *l, enum move_kind kind, idx_t a, idx_t b)
{
	if (l->count == l->room)
		l->move = mem_resize(l->move, l->room = 2 * l->room + 256, sizeof *l->move);
	l->move[l->count++] = (struct move){kind, a, b};
}

static void list_moves(struct move_list *l, const struct sketch *s)
{
	const bool is_loop = s->scheme == SCHEME_LOOP;
	for (size_t h = 0; h < s->face_start[s->face_count]; h++) {
		const idx_t v = s->face_corner[h], a = s->id[v], b = s->id[sketch_head(s, (idx_t)h)];
		struct move move[3];
		const size_t count = removals_at(move, s, (idx_t)h, s->outgoing[v] == (idx_t)h);
		for (size_t i = 0; i < count; i++)
			list(l, move[i].kind, move[i].a, move[i].b);
		if (s->twin[h] == NO_INDEX || a < b) {
			if (!s->sharp[h])
				list(l, MOVE_SWAP, a, b);
			if (s->twin[h] != NO_INDEX)
				list(l, MOVE_CREASE, a, b);
			list(l, MOVE_SPLIT, a, b);
		}
		if (s->outgoing[v] == (idx_t)h && sketch_star(s, v).sharp == 2)
			list(l, MOVE_CORNER, a, -1);
	}
	for (size_t f = 0; f < s->face_count && !is_loop; f++) {
		const size_t from = s->face_start[f], n = s->face_start[f + 1] - from;
		for (size_t i = 0; i < n && n <= 16; i++)
			for (size_t j = i + 2; j < n && (i > 0 || j + 1 < n); j++)
				list(l, MOVE_CHORD, s->id[s->face_corner[from + i]], s->id[s->face_corner[from + j]]);
	}
}

size_t search_improve(struct candidate *c, const struct judge *judge, double lambda, size_t most_work, struct search_report *report)
{
	struct move_list l = {0};
	list_moves(&l, &c->sketch);
	size_t taken = 0;
	idx_t *index = sketch_index(&c->sketch);
	for (size_t i = 0; i < l.count && *judge->work < most_work; i++) {
		const struct move move = l.move[i];
		if (index[move.a] == NO_INDEX || (move.b >= 0 && index[move.b] == NO_INDEX))
			continue;
		struct trial trial;
		if (!try_move(&trial, c, judge, index, move, lambda, REFITS_TRIAL))
			continue;
		report->tried++;
		if (trial.cost + lambda * trial.bits >= -1e-9) {
			trial_free(&trial);
			continue;
		}
		struct candidate next = trial_take(&trial, c, judge);
		const double gain = next.errors.cost - c->errors.cost + lambda * (search_bits(&next.sketch) - search_bits(&c->sketch));
		if (gain >= 0 || spoils(&next.errors, &c->errors, judge)) {
			candidate_free(&next);
			continue;
		}
		candidate_free(c);
		*c = next;
		taken++, report->done++, report->by_kind[move.kind]++;
		free(index);
		index = sketch_index(&c->sketch);
	}
	free(index), free(l.move);
	fit_again(c, judge);
	return taken;
}
