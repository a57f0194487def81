/* Questions about connectivity that see the geometry (see ffx_ask.h). */
#include "formats/ffx_ask.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "formats/ffx_angle.h"

#define DEGREES(x) ((x)*ANGLE_TURN / 360)

enum { ASK_ALONG, ASK_CLOSE, ASK_NEW };

static unsigned least(size_t a, unsigned b)
{
	return a < b ? (unsigned)a : b;
}

/* Parts of 15 degrees up to half a turn. */
#define CORNER_CLASSES 12
static unsigned corner_class(int angle)
{
	return least((size_t)angle / DEGREES(15), CORNER_CLASSES - 1);
}

/* Of a whole turn and more, in parts of 30 degrees around the whole ones. */
#define TOTAL_CLASSES 16
static unsigned total_class(int64_t angle)
{
	return least((size_t)(angle + DEGREES(15)) / DEGREES(30), TOTAL_CLASSES - 1);
}

/* Flat, then by 20, 50, 80, 100 degrees on the two sides; none. */
#define BEND_CLASSES 12
#define BEND_NONE 11
static unsigned bend_class(int bend)
{
	const int size = abs(bend);
	const unsigned class = size < DEGREES(3)     ? 0
			       : size < DEGREES(20)  ? 1
			       : size < DEGREES(50)  ? 2
			       : size < DEGREES(80)  ? 3
			       : size < DEGREES(100) ? 4
						     : 5;
	return class == 0 ? 0 : 2 * class - (bend > 0);
}

#define RATIO_CLASSES 5
static unsigned ratio_class(const int64_t a[3], const int64_t b[3])
{
	const int64_t x = vector_dot(a, a), y = vector_dot(b, b); /* squares */
	return 9 * x < y ? 0 : 9 * x < 4 * y ? 1 : 4 * x <= 9 * y ? 2 : x <= 9 * y ? 3 : 4;
}

/* How far q is off the plane through foot: within half a step, 1.5, then by the angle from reach, on two sides. */
#define PLANE_CLASSES 10
static unsigned plane_class(const int64_t normal[3], const int32_t *foot, const int32_t *q, const int32_t *reach)
{
	const int64_t size = vector_length(normal);
	if (size == 0)
		return 0;
	int64_t to[3], from[3];
	vector_between(to, foot, q);
	vector_between(from, reach, q);
	const int64_t off = vector_dot(normal, to), far = llabs(off);
	if (2 * far <= size)
		return 0;
	if (2 * far <= 3 * size)
		return 1;
	const int64_t distance = far / size, length = vector_length(from);
	const unsigned class = 6 * distance < length ? 0 : 5 * distance < 2 * length ? 1 : 3 * distance < 2 * length ? 2 : 3;
	return 2 + 2 * class + (off > 0);
}

static const int64_t *face_normal(const struct forward *f, idx_t half)
{
	const idx_t face = f->face[half];
	return face == NO_INDEX ? NULL : f->normal + 3 * (size_t)face;
}

/* Bend at a boundary half-edge between the face behind it and a plane with that normal. */
static unsigned bend_at(const struct forward *f, idx_t half, const int64_t normal[3])
{
	const int64_t *other = face_normal(f, half ^ 1);
	if (!other || vector_is_zero(other) || vector_is_zero(normal))
		return BEND_NONE;
	int64_t edge[3];
	vector_between(edge, forward_point(f, f->origin[half]), forward_point(f, forward_end(f, half)));
	return bend_class(angle_bend(normal, other, edge));
}

static void triangle_normal(int64_t out[3], const int32_t *a, const int32_t *b, const int32_t *c)
{
	int64_t u[3], v[3];
	vector_between(u, a, b);
	vector_between(v, a, c);
	vector_cross(out, u, v);
	vector_shrink(out);
}

/* How well a vertex fits into the face: by its plane, or, when that is not known, by the bend at the gate. */
#define FIT_CLASSES (PLANE_CLASSES + BEND_CLASSES)
static unsigned fit_class(const struct forward *f, const struct step *step, idx_t vertex, const int32_t *reach)
{
	const int32_t *a = forward_point(f, f->origin[step->gate]), *q = forward_point(f, vertex);
	if (!vector_is_zero(step->normal))
		return plane_class(step->normal, a, q, reach);
	int64_t normal[3];
	triangle_normal(normal, a, forward_point(f, forward_end(f, step->gate)), q);
	return PLANE_CLASSES + bend_at(f, step->gate, normal);
}

static unsigned degree_class(const struct forward *f, idx_t half)
{
	return f->face[half] == NO_INDEX ? 0 : 1 + least((size_t)f->degree[f->face[half]] - 3, 3);
}
#define DEGREE_CLASSES 5

static unsigned valence_class(const struct forward *f, idx_t vertex)
{
	return least(f->valence[vertex], 4);
}
#define VALENCE_CLASSES 5

static int angle_at(const struct forward *f, idx_t from, idx_t at, idx_t to)
{
	int64_t u[3], v[3];
	vector_between(u, forward_point(f, at), forward_point(f, from));
	vector_between(v, forward_point(f, at), forward_point(f, to));
	return angle_between(u, v);
}

static unsigned ratio_at(const struct forward *f, idx_t a, idx_t b, idx_t c, idx_t d)
{
	int64_t u[3], v[3];
	vector_between(u, forward_point(f, a), forward_point(f, b));
	vector_between(v, forward_point(f, c), forward_point(f, d));
	return ratio_class(u, v);
}

static unsigned answer(struct forward *f, unsigned question, const unsigned *input, size_t count, unsigned truth)
{
	for (size_t i = 0; i < count; i++) {
		assert(input[i] < ASK_ROOM);
		mix_context(f->coder, CONTEXT_ASK + (question * ASK_INPUTS + i) * ASK_ROOM + input[i],
			    WEIGHT_ASK + (question * ASK_INPUTS + i) * CONFIDENCE_CLASSES);
	}
	return mix_code(f->coder, truth);
}

unsigned ask_along(struct forward *f, const struct step *step, bool is_behind, bool closes, unsigned truth)
{
	/* At an end of the chain: c, with p in the chain before it and the boundary's half-edge o to d; the other end is e. */
	const idx_t o = is_behind ? f->before[step->first] : step->out;
	const idx_t c = is_behind ? step->e : step->c, d = is_behind ? f->origin[o] : forward_end(f, o);
	const idx_t p = is_behind ? step->s : step->p, e = is_behind ? step->c : step->e;
	const unsigned k = least(step->count - 1, 3), fit = fit_class(f, step, d, forward_point(f, c));
	const int angle = angle_at(f, p, c, d);
	const unsigned corner = corner_class(angle), total = total_class((int64_t)f->used[c] + angle);
	int64_t normal[3];
	if (!vector_is_zero(step->normal))
		memcpy(normal, step->normal, sizeof normal);
	else if (is_behind)
		triangle_normal(normal, forward_point(f, p), forward_point(f, d), forward_point(f, c));
	else
		triangle_normal(normal, forward_point(f, p), forward_point(f, c), forward_point(f, d));
	const unsigned across = bend_at(f, o, normal), valence = valence_class(f, c);
	const unsigned used = least((size_t)f->used[c] / DEGREES(45), 8), ratio = ratio_at(f, c, d, p, c);
	const unsigned place = closes ? 3 : is_behind ? 1 + (step->count > 1) : 0;
	/* Where the gap would be left: the angle between the way back and the boundary. */
	const unsigned rest = closes ? 0 : corner_class(angle_at(f, c, d, e));
	const unsigned input[] = {
		fit * CORNER_CLASSES + corner,
		(total * VALENCE_CLASSES + valence) * 4 + k,
		across * FIT_CLASSES + fit,
		(corner * 9 + used) * 4 + k,
		((k * 4 + place) * VALENCE_CLASSES + valence) * 3 + least(step->fresh, 2),
		((ratio * CORNER_CLASSES + corner) * 4 + place),
		((degree_class(f, o ^ 1) * DEGREE_CLASSES + degree_class(f, step->gate ^ 1)) * 4 + k) * 4 + place,
		fit * TOTAL_CLASSES + total,
		(corner * CORNER_CLASSES + rest) * 3 + least(k, 2),
	};
	return answer(f, ASK_ALONG, input, sizeof input / sizeof *input, truth);
}

unsigned ask_close(struct forward *f, const struct step *step, unsigned truth)
{
	const idx_t c = step->c, e = step->e;
	const unsigned k = least(step->count - 2, 4), fresh = least(step->fresh, 2), known = least(step->known - 2, 3);
	const int angle_e = angle_at(f, c, e, step->s), angle_c = angle_at(f, step->p, c, e);
	const unsigned at_e = corner_class(angle_e), at_c = corner_class(angle_c);
	const unsigned gap = ratio_at(f, c, e, e, step->s);
	const unsigned total_e = total_class((int64_t)f->used[e] + angle_e), total_c = total_class((int64_t)f->used[c] + angle_c);
	const unsigned edge_gate = degree_class(f, step->gate ^ 1), edge_first = degree_class(f, step->first ^ 1);
	const idx_t x = f->origin[f->before[step->first]], d = forward_end(f, step->out);
	const unsigned fit_x = fit_class(f, step, x, forward_point(f, e)), fit_d = fit_class(f, step, d, forward_point(f, c));
	const unsigned input[] = {
		((k * CORNER_CLASSES + at_e) * 3 + fresh) * 2 + (known > 0),
		((k * CORNER_CLASSES + at_c) * 3 + fresh) * 2 + (known > 0),
		(at_e * CORNER_CLASSES + at_c) * 3 + fresh,
		((total_e * 3 + fresh) * 4 + known) * 2 + (k > 1),
		((total_c * 3 + fresh) * 4 + known) * 2 + (k > 1),
		((k * 3 + fresh) * RATIO_CLASSES + gap) * 4 + known,
		((k * 3 + fresh) * DEGREE_CLASSES + edge_gate) * DEGREE_CLASSES + edge_first,
		(fit_x * 3 + fresh) * 5 + k,
		(fit_d * 3 + fresh) * 5 + k,
	};
	return answer(f, ASK_CLOSE, input, sizeof input / sizeof *input, truth);
}

unsigned ask_new(struct forward *f, const struct step *step, unsigned truth)
{
	const idx_t c = step->c, e = step->e, v = step->nearest;
	const unsigned k = least(step->count - 1, 4), fresh = least(step->fresh, 2), bound = least(f->bound_count / 3, 5);
	const idx_t x = f->origin[f->before[step->first]], d = forward_end(f, step->out);
	const unsigned fit = fit_class(f, step, v, forward_point(f, c));
	const unsigned fit_x = fit_class(f, step, x, forward_point(f, e)), fit_d = fit_class(f, step, d, forward_point(f, c));
	const unsigned total = total_class(f->used[v]);
	/* Twice the square of the distance, by that of the gap. */
	int64_t gap[3];
	vector_between(gap, forward_point(f, c), forward_point(f, e));
	const int64_t width = vector_dot(gap, gap);
	unsigned near = 0;
	while (near < 7 && step->distance > width << near >> 1)
		near++;
	const unsigned where = v == x                                              ? 2
			       : f->origin[f->before[f->before[step->first]]] == v ? 1
			       : forward_end(f, f->after[step->out]) == v          ? 3
										   : 0;
	const unsigned input[] = {
		(k * 3 + fresh) * 6 + bound,
		(fit_x * 3 + fresh) * 5 + k,
		(fit_d * 3 + fresh) * 5 + k,
		(total_class(f->used[c]) * 3 + fresh) * VALENCE_CLASSES + valence_class(f, c),
		(total_class(f->used[e]) * 3 + fresh) * VALENCE_CLASSES + valence_class(f, e),
		(fit * 8 + near) * 2 + (fresh > 0),
		(total * 8 + near) * 3 + fresh,
		fit * TOTAL_CLASSES + total,
		((where * 8 + near) * 3 + fresh) * 5 + k,
	};
	return answer(f, ASK_NEW, input, sizeof input / sizeof *input, truth);
}
