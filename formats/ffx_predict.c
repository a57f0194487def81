/* Predicting a vertex from those already known (see ffx_predict.h).
 *
 * Within-face parallelograms before across-edge ones: Isenburg and Alliez, "Compressing polygon mesh geometry with parallelogram
 * prediction" (2002); regular polygons in the spirit of Isenburg, Ivrissimtzis, Gumhold and Seidel (2005). */
#include "formats/ffx_predict.h"

#include <stdlib.h>
#include <string.h>

#define FAN_LIMIT 64  /* half-edges around a vertex that are looked at */
#define REACH 3       /* vertices along a face that a guess needs */
#define PLANE_REACH 6 /* vertices along a face, each way, that a plane is taken from */

/* --- order ----------------------------------------------------------------------------------------------------------- */

enum { CLASS_TOUCHED, CLASS_ACROSS, CLASS_FACE, CLASS_FACES, CLASS_COUNT };

struct ordering {
	const struct ffx_surface *surface;
	idx_t *rank;             /* NO_INDEX as long as unknown */
	unsigned char *class;    /* 1 + the best class that it was queued with, 0 before */
	unsigned char *is_ready; /* a half-edge: its origin is predicted inside its face */
	idx_t *queue[CLASS_COUNT];
	size_t head[CLASS_COUNT], tail[CLASS_COUNT];
};

static void promote(struct ordering *o, idx_t vertex, unsigned class)
{
	if (o->rank[vertex] != NO_INDEX || o->class[vertex] > class)
		return;
	o->class[vertex] = (unsigned char)(class + 1);
	o->queue[class][o->tail[class]++] = vertex;
}

static bool is_known(const struct ordering *o, idx_t half)
{
	return o->rank[o->surface->origin[half]] != NO_INDEX;
}

/* Is there an in-face guess at the origin of half? Parallelogram in quads, three known in a row in larger faces. */
static bool face_predicts(const struct ordering *o, idx_t half)
{
	const struct ffx_surface *s = o->surface;
	if (s->degree[s->face[half]] < 4)
		return false;
	const idx_t n1 = s->next[half], n2 = s->next[n1], n3 = s->next[n2];
	const idx_t p1 = s->previous[half], p2 = s->previous[p1], p3 = s->previous[p2];
	return (is_known(o, n1) && is_known(o, n2) && is_known(o, n3)) || (is_known(o, p1) && is_known(o, p2) && is_known(o, p3));
}

static void learn_inside(struct ordering *o, idx_t half)
{
	const struct ffx_surface *s = o->surface;
	idx_t h = half;
	for (int i = 0; i < REACH; i++)
		h = s->previous[h];
	for (int i = 0; i < 2 * REACH + 1; i++, h = s->next[h]) {
		if (is_known(o, h) || o->is_ready[h] || !face_predicts(o, h))
			continue;
		o->is_ready[h] = 1;
		promote(o, s->origin[h], o->class[s->origin[h]] > CLASS_FACE ? CLASS_FACES : CLASS_FACE);
	}
}

/* A triangle next to a known edge of a face with a known vertex behind it. */
static void learn_across(struct ordering *o, idx_t half)
{
	const struct ffx_surface *s = o->surface;
	idx_t e = half;
	for (int i = 0; i < 3; i++, e = s->next[e]) {
		const idx_t t = s->twin[e];
		if (s->degree[s->face[t]] == 3 && is_known(o, e) && is_known(o, t) && is_known(o, s->previous[e]))
			promote(o, s->origin[s->previous[t]], CLASS_ACROSS);
	}
}

static void learn(struct ordering *o, idx_t vertex)
{
	const struct ffx_surface *s = o->surface;
	idx_t h = s->outgoing[vertex];
	do {
		promote(o, surface_end(s, h), CLASS_TOUCHED);
		learn_inside(o, h);
		if (!s->hole[s->face[h]] && s->degree[s->face[h]] <= 4)
			learn_across(o, h);
		h = surface_turn(s, h);
	} while (h != s->outgoing[vertex]);
}

void predict_order(idx_t *order, idx_t *rank, const struct ffx_surface *surface)
{
	struct ordering o = {.surface = surface, .rank = rank};
	const size_t count = surface->vertex_count;
	o.class = mem_array(count, 1);
	o.is_ready = mem_array(surface->half_count, 1);
	for (int c = 0; c < CLASS_COUNT; c++)
		o.queue[c] = mem_array(count, sizeof(idx_t));
	for (size_t v = 0; v < count; v++)
		rank[v] = NO_INDEX;
	size_t done = 0, component = 0;
	while (done < count) {
		int c = CLASS_COUNT - 1;
		while (c >= 0 && o.head[c] == o.tail[c])
			c--;
		idx_t v;
		if (c >= 0)
			v = o.queue[c][o.head[c]++];
		else
			v = surface->origin[surface->root[component++]];
		if (rank[v] != NO_INDEX)
			continue;
		rank[v] = (idx_t)done;
		order[done++] = v;
		learn(&o, v);
	}
	free(o.class);
	free(o.is_ready);
	for (int c = 0; c < CLASS_COUNT; c++)
		free(o.queue[c]);
}

/* --- guesses at points ---------------------------------------------------------------------------------------------- */

/* 65536 * (1 + 2 cos(360 degrees / n)), n = 4 .. 32: with three consecutive vertices u v w of a regular n-gon the next is
 * u + this * (w - v). */
static const int32_t polygon_ratio[] = {65536,  106039, 131072, 147258, 158218, 165943, 171575, 175801, 179048, 181594,
					183628, 185276, 186631, 187757, 188703, 189506, 190193, 190785, 191299, 191747,
					192142, 192490, 192799, 193075, 193322, 193544, 193744, 193925, 194089};

static int32_t ratio_of(idx_t degree)
{
	return polygon_ratio[(degree > 32 ? 32 : degree) - 4];
}

struct view {
	const struct ffx_surface *surface;
	const idx_t *rank;
	idx_t at; /* rank of the vertex to be predicted */
	const int32_t *grid;
};

/* The position of a half-edge's origin, NULL when not yet known. */
static const int32_t *seen(const struct view *view, idx_t half)
{
	const idx_t v = view->surface->origin[half];
	return view->rank[v] < view->at ? view->grid + 3 * (size_t)v : NULL;
}

static void add_guess(struct guesses *guesses, enum ffx_expert kind, const int32_t at[3], size_t limit)
{
	size_t same = 0;
	for (size_t i = 0; i < guesses->guess_count; i++)
		same += guesses->guess[i].kind == kind;
	if (guesses->guess_count == FIRST_GUESS_LIMIT || same >= limit)
		return;
	struct guess *guess = &guesses->guess[guesses->guess_count++];
	guess->kind = kind;
	memcpy(guess->at, at, sizeof guess->at);
}

static void guess_parallelogram(struct guesses *guesses, enum ffx_expert kind, const int32_t *a, const int32_t *b,
				const int32_t *opposite)
{
	int32_t at[3];
	for (int k = 0; k < 3; k++)
		at[k] = a[k] + b[k] - opposite[k];
	add_guess(guesses, kind, at, 3);
}

static void guess_polygon(struct guesses *guesses, const int32_t *u, const int32_t *v, const int32_t *w, idx_t degree)
{
	int32_t at[3];
	for (int k = 0; k < 3; k++)
		at[k] = u[k] + (int32_t)shift_down((int64_t)ratio_of(degree) * (w[k] - v[k]) + 32768, 16);
	add_guess(guesses, EXPERT_POLYGON, at, 3);
}

static void guess_inside(struct guesses *guesses, const struct view *view, idx_t half)
{
	const struct ffx_surface *s = view->surface;
	const idx_t degree = s->degree[s->face[half]];
	const idx_t n1 = s->next[half], p1 = s->previous[half];
	const int32_t *next = seen(view, n1), *previous = seen(view, p1);
	if (degree == 3) {
		const idx_t t = s->twin[n1]; /* the side opposite to the vertex, seen from its other face */
		const idx_t far = s->previous[t], far2 = s->next[s->next[t]];
		const int32_t *a = seen(view, far), *b = seen(view, far2);
		if (!next || !previous || s->hole[s->face[t]] || !a || !b)
			return;
		int32_t middle[3];
		for (int k = 0; k < 3; k++)
			middle[k] = (int32_t)shift_down((int64_t)a[k] + b[k], 1);
		guess_parallelogram(guesses, EXPERT_ACROSS, next, previous, middle);
		return;
	}
	const idx_t n2 = s->next[n1], p2 = s->previous[p1];
	const int32_t *next2 = seen(view, n2), *previous2 = seen(view, p2);
	if (degree == 4) {
		if (next && previous && next2)
			guess_parallelogram(guesses, EXPERT_QUAD, next, previous, next2);
	} else {
		const int32_t *next3 = seen(view, s->next[n2]), *previous3 = seen(view, s->previous[p2]);
		if (next && next2 && next3)
			guess_polygon(guesses, next3, next2, next, degree);
		if (previous && previous2 && previous3)
			guess_polygon(guesses, previous3, previous2, previous, degree);
	}
	if (next2)
		add_guess(guesses, EXPERT_DIAGONAL, next2, 2);
	else if (previous2)
		add_guess(guesses, EXPERT_DIAGONAL, previous2, 2);
}

/* Straight on through a neighbour of valence 4. */
static void guess_extension(struct guesses *guesses, const struct view *view, idx_t half)
{
	const struct ffx_surface *s = view->surface;
	const idx_t t = s->twin[half];
	const int32_t *near = seen(view, t);
	if (!near)
		return;
	const idx_t opposite = surface_turn(s, surface_turn(s, t));
	if (surface_turn(s, surface_turn(s, opposite)) != t || opposite == t)
		return;
	const int32_t *far = seen(view, s->twin[opposite]);
	if (far)
		guess_parallelogram(guesses, EXPERT_EXTEND, near, near, far);
}

static void guess_neighbours(struct guesses *guesses, const struct view *view, const idx_t *fan, size_t fan_count)
{
	idx_t nearest[3] = {NO_INDEX, NO_INDEX, NO_INDEX}; /* vertices, latest first */
	for (size_t i = 0; i < fan_count; i++) {
		idx_t v = surface_end(view->surface, fan[i]);
		if (view->rank[v] >= view->at)
			continue;
		for (int j = 0; j < 3; j++) {
			if (nearest[j] == NO_INDEX || view->rank[nearest[j]] < view->rank[v]) {
				const idx_t pushed = nearest[j];
				nearest[j] = v;
				if (pushed == NO_INDEX)
					break;
				v = pushed;
			}
		}
	}
	static const enum ffx_expert kind[3] = {EXPERT_NEIGHBOUR, EXPERT_NEIGHBOUR2, EXPERT_NEIGHBOUR3};
	for (int j = 0; j < 3 && nearest[j] != NO_INDEX; j++)
		add_guess(guesses, kind[j], view->grid + 3 * (size_t)nearest[j], 1);
}

static void guess_mean(struct guesses *guesses)
{
	int64_t sum[3] = {0};
	int32_t count = 0;
	for (size_t i = 0; i < guesses->guess_count; i++) {
		if (guesses->guess[i].kind > EXPERT_ACROSS)
			continue;
		for (int k = 0; k < 3; k++)
			sum[k] += guesses->guess[i].at[k];
		count++;
	}
	if (count < 2)
		return;
	int32_t at[3];
	for (int k = 0; k < 3; k++) {
		const int64_t twice = 2 * sum[k] + count;
		at[k] = (int32_t)(twice >= 0 ? twice / (2 * count) : -((-twice + 2 * count - 1) / (2 * count)));
	}
	add_guess(guesses, EXPERT_MEAN, at, 1);
}

/* --- planes ------------------------------------------------------------------------------------------------------------ */

static int64_t magnitude(const int64_t n[3])
{
	int64_t most = 0;
	for (int k = 0; k < 3; k++) {
		most = llabs(n[k]) > most ? llabs(n[k]) : most;
	}
	return most;
}

void predict_add_plane(struct guesses *guesses, enum ffx_expert kind, const int32_t *const *point, int count)
{
	if (guesses->plane_count == PLANE_LIMIT)
		return;
	int64_t best = 0, normal[3] = {0};
	const int32_t *foot = NULL;
	for (int i = 0; i < count; i++) {
		for (int j = i + 1; j < count; j++) {
			for (int k = j + 1; k < count; k++) {
				int64_t u[3], v[3], n[3];
				for (int d = 0; d < 3; d++) {
					u[d] = point[j][d] - point[i][d];
					v[d] = point[k][d] - point[i][d];
				}
				for (int d = 0; d < 3; d++)
					n[d] = u[(d + 1) % 3] * v[(d + 2) % 3] - u[(d + 2) % 3] * v[(d + 1) % 3];
				const int64_t size = llabs(n[0]) + llabs(n[1]) + llabs(n[2]);
				if (size > best) {
					best = size;
					memcpy(normal, n, sizeof normal);
					foot = point[i];
				}
			}
		}
	}
	if (!foot)
		return;
	int bits = 0;
	while (magnitude(normal) >> bits > 32767)
		bits++;
	struct plane *plane = &guesses->plane[guesses->plane_count++];
	plane->kind = kind;
	plane->offset = 0;
	for (int k = 0; k < 3; k++) {
		plane->normal[k] = (int32_t)(normal[k] < 0 ? -(-normal[k] >> bits) : normal[k] >> bits);
		plane->offset += (int64_t)plane->normal[k] * foot[k];
	}
}

/* The plane of the three known vertices of a face near half that span the largest area. */
static void find_plane(struct guesses *guesses, const struct view *view, idx_t half)
{
	const struct ffx_surface *s = view->surface;
	const idx_t face = s->face[half];
	if (s->degree[face] < 4 || s->hole[face] || guesses->plane_count == PLANE_LIMIT)
		return;
	const int32_t *point[2 * PLANE_REACH];
	int count = 0;
	const int steps = s->degree[face] - 1 < 2 * PLANE_REACH ? s->degree[face] - 1 : 2 * PLANE_REACH;
	idx_t h = half;
	for (int i = 0; i < steps / 2; i++)
		h = s->previous[h];
	for (int i = 0; i < steps + 1; i++, h = s->next[h]) {
		const int32_t *p = h == half ? NULL : seen(view, h);
		if (p && count < 2 * PLANE_REACH)
			point[count++] = p;
	}
	predict_add_plane(guesses, EXPERT_PLANE, point, count);
}

/* Best told coordinates last: of one plane the steepest, of two the ones across their line. */
void predict_choose_axes(struct guesses *guesses)
{
	int *axis = guesses->axis;
	axis[0] = 0, axis[1] = 1, axis[2] = 2;
	if (guesses->plane_count == 0)
		return;
	const int32_t *a = guesses->plane[0].normal;
	int64_t line[3] = {0};
	for (size_t i = 1; i < guesses->plane_count; i++) {
		const int32_t *b = guesses->plane[i].normal;
		int64_t n[3];
		for (int k = 0; k < 3; k++)
			n[k] = (int64_t)a[(k + 1) % 3] * b[(k + 2) % 3] - (int64_t)a[(k + 2) % 3] * b[(k + 1) % 3];
		if (magnitude(n) > magnitude(line))
			memcpy(line, n, sizeof line);
	}
	int steepest = 0;
	for (int k = 1; k < 3; k++)
		if (abs(a[k]) > abs(a[steepest]))
			steepest = k;
	int first = -1;
	if (magnitude(line) > 0) {
		first = 0;
		for (int k = 1; k < 3; k++)
			if (llabs(line[k]) > llabs(line[first]))
				first = k;
	}
	if (first == steepest)
		first = -1;
	axis[2] = steepest;
	axis[0] = first >= 0 ? first : steepest == 0 ? 1 : 0;
	axis[1] = 3 - axis[0] - axis[2];
}

/* Nearest whole number to numerator / denominator, halves up, kept near the grid; false when the denominator is 0. */
static bool divide(int32_t *value, __int128 numerator, __int128 denominator)
{
	if (denominator == 0)
		return false;
	if (denominator < 0) {
		numerator = -numerator;
		denominator = -denominator;
	}
	const __int128 twice = 2 * numerator + denominator, by = 2 * denominator;
	const __int128 whole = twice >= 0 ? twice / by : -((-twice + by - 1) / by);
	*value = (int32_t)(whole < -65536 ? -65536 : whole > 131072 ? 131072 : whole);
	return true;
}

static int32_t steepness(const int32_t normal[3])
{
	int32_t most = 0;
	for (int k = 0; k < 3; k++)
		most = abs(normal[k]) > most ? abs(normal[k]) : most;
	return most;
}

static enum ffx_expert line_kind(const struct plane *a, const struct plane *b)
{
	if (a->kind == EXPERT_PLANE)
		return EXPERT_LINE;
	return a->kind == FORE_PLANE || b->kind == FORE_PLANE ? FORE_LINE : FORE_LINE_OTHER;
}

size_t predict_from_planes(int32_t *value, enum ffx_expert *kind, const struct guesses *guesses, int step, const int32_t point[3])
{
	size_t count = 0;
	const size_t planes = guesses->plane_count;
	const int k = guesses->axis[step];
	int64_t rest[PLANE_LIMIT]; /* offset less what is known */
	for (size_t i = 0; i < planes; i++) {
		rest[i] = guesses->plane[i].offset;
		for (int j = 0; j < step; j++)
			rest[i] -= (int64_t)guesses->plane[i].normal[guesses->axis[j]] * point[guesses->axis[j]];
	}
	/* A plane that is steep in the axis tells it, whatever the unknown ones: they weigh nothing in it. */
	for (size_t i = 0; i < planes && count < PLANE_LIMIT; i++) {
		const int32_t *n = guesses->plane[i].normal;
		bool is_told = n[k] != 0;
		int64_t most = 0;
		for (int j = 0; j < 3; j++) {
			most = abs(n[j]) > most ? abs(n[j]) : most;
			if (j > step && n[guesses->axis[j]] != 0)
				is_told = false;
		}
		if (is_told && 8 * (int64_t)abs(n[k]) >= most && divide(&value[count], rest[i], n[k]))
			kind[count++] = guesses->plane[i].kind;
	}
	if (step == 2)
		return count;
	const int l = guesses->axis[step + 1];
	for (size_t i = 0; i < planes; i++) {
		for (size_t j = i + 1; j < planes && count < PLANE_LIMIT; j++) {
			const int32_t *a = guesses->plane[i].normal, *b = guesses->plane[j].normal;
			if (step == 1) {
				const int64_t area = (int64_t)a[k] * b[l] - (int64_t)a[l] * b[k];
				/* Planes nearly along each other tell nothing. */
				if (16 * llabs(area) < (int64_t)steepness(a) * steepness(b))
					continue;
				if (divide(&value[count], (__int128)rest[i] * b[l] - (__int128)rest[j] * a[l], area))
					kind[count++] = line_kind(&guesses->plane[i], &guesses->plane[j]);
				continue;
			}
			const int m = guesses->axis[2];
			for (size_t h = j + 1; h < planes && count < PLANE_LIMIT; h++) {
				const int32_t *c = guesses->plane[h].normal;
				const int64_t bc = (int64_t)b[l] * c[m] - (int64_t)b[m] * c[l],
					      ca = (int64_t)c[l] * a[m] - (int64_t)c[m] * a[l];
				const int64_t ab = (int64_t)a[l] * b[m] - (int64_t)a[m] * b[l];
				const __int128 volume = (__int128)a[k] * bc + (__int128)b[k] * ca + (__int128)c[k] * ab;
				const __int128 full = (__int128)steepness(a) * steepness(b) * steepness(c);
				if (32 * volume < full && -32 * volume < full)
					continue;
				if (divide(&value[count],
					   (__int128)rest[i] * bc + (__int128)rest[j] * ca + (__int128)rest[h] * ab, volume))
					kind[count++] = guesses->plane[i].kind == EXPERT_PLANE ? EXPERT_POINT : FORE_POINT;
			}
		}
	}
	return count;
}

void predict_vertex(struct guesses *guesses, const struct ffx_surface *surface, const idx_t *order, const idx_t *rank, size_t at,
		    const int32_t *grid)
{
	guesses->guess_count = guesses->plane_count = 0;
	guesses->phase = -1;
	const struct view view = {surface, rank, (idx_t)at, grid};
	const idx_t vertex = order[at];
	idx_t fan[FAN_LIMIT];
	size_t fan_count = 0;
	idx_t h = surface->outgoing[vertex];
	do {
		fan[fan_count++] = h;
		h = surface_turn(surface, h);
	} while (h != surface->outgoing[vertex] && fan_count < FAN_LIMIT);
	for (size_t i = 0; i < fan_count; i++)
		guess_inside(guesses, &view, fan[i]);
	guess_mean(guesses);
	guess_neighbours(guesses, &view, fan, fan_count);
	for (size_t i = 0; i < fan_count; i++)
		guess_extension(guesses, &view, fan[i]);
	if (at > 0)
		add_guess(guesses, EXPERT_LAST, grid + 3 * (size_t)order[at - 1], 1);
	for (size_t i = 0; i < fan_count; i++)
		find_plane(guesses, &view, fan[i]);
	predict_choose_axes(guesses);
}
