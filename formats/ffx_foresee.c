/* Guesses of the forward coder at a new vertex: corners, parallelograms and planes around the place where it appears (see
 * ffx_forward.h). */
#include <stdlib.h>
#include <string.h>

#include "formats/ffx_angle.h"
#include "formats/ffx_forward.h"
#include "formats/ffx_predict.h"

#define PLANE_CORNERS 10 /* of the face, its last ones */

static void guess(struct guesses *g, enum ffx_expert kind, const int32_t *at)
{
	if (g->guess_count == GUESS_LIMIT)
		return;
	g->guess[g->guess_count].kind = kind;
	memcpy(g->guess[g->guess_count++].at, at, sizeof g->guess[0].at);
}

/* from + b - a */
static void guess_step(struct guesses *g, enum ffx_expert kind, const int32_t *from, const int32_t *a, const int32_t *b)
{
	int32_t at[3];
	for (int k = 0; k < 3; k++)
		at[k] = from[k] + b[k] - a[k];
	guess(g, kind, at);
}

static void guess_mean(struct guesses *g)
{
	if (g->guess_count < 2)
		return;
	int32_t at[3];
	const int32_t n = (int32_t)g->guess_count;
	for (int k = 0; k < 3; k++) {
		int64_t sum = 0;
		for (int i = 0; i < n; i++)
			sum += g->guess[i].at[k];
		const int64_t twice = 2 * sum + n;
		at[k] = (int32_t)(twice >= 0 ? twice / (2 * n) : -((-twice + 2 * n - 1) / (2 * n)));
	}
	guess(g, FORE_MEAN, at);
}

/* The corner some places on around the face. */
static size_t corner_at(const struct forward *f, size_t at, ptrdiff_t by)
{
	const size_t n = f->path_count;
	return (at + (size_t)((ptrdiff_t)n + by)) % n;
}

static const int32_t *known_at(const struct forward *f, size_t corner)
{
	return f->is_known[corner] ? forward_point(f, f->origin[f->path[corner]]) : NULL;
}

/* 65536 * (1 + 2 cos(360 degrees / n)), n = 4 to 12 */
static const int32_t polygon_ratio[] = {65536, 106039, 131072, 147258, 158218, 165943, 171575, 175801, 179048};

static void guess_polygon(struct guesses *g, const int32_t *u, const int32_t *v, const int32_t *w, size_t degree)
{
	const int32_t ratio = polygon_ratio[(degree > 12 ? 12 : degree) - 4];
	int32_t at[3];
	for (int k = 0; k < 3; k++)
		at[k] = u[k] + (int32_t)shift_down((int64_t)ratio * (w[k] - v[k]) + 32768, 16);
	guess(g, FORE_POLYGON, at);
}

static void guess_place(struct guesses *g, enum ffx_expert kind, const int32_t *at)
{
	if (at)
		guess(g, kind, at);
}

void foresee(struct guesses *g, const struct forward *f, size_t at, size_t gap)
{
	const size_t n = f->path_count;
	/* Known corners: p1 before, p2, p3 before that, n1 the next one that is known, gap places on, n2, n3 behind that. */
	const size_t i_p1 = corner_at(f, at, -1), i_p2 = corner_at(f, at, -2), i_n1 = (at + gap) % n;
	const int32_t *p1 = known_at(f, i_p1), *p2 = known_at(f, i_p2), *n1 = known_at(f, i_n1);
	const int32_t *p3 = known_at(f, corner_at(f, at, -3)), *n2 = known_at(f, corner_at(f, i_n1, 1));
	const int32_t *n3 = known_at(f, corner_at(f, i_n1, 2));
	*g = (struct guesses){.phase = gap == 1 ? 0 : gap == 2 ? 1 : 2};
	/* What lies outside the face at its known ends. */
	const int32_t *x = NULL, *x2 = NULL, *d = NULL, *d2 = NULL, *q = NULL, *r = NULL;
	if (f->corner[i_n1] != NO_INDEX) {
		const idx_t before = f->before[f->corner[i_n1]];
		if (!forward_has(f, f->origin[before])) {
			x = forward_point(f, f->origin[before]);
			x2 = forward_point(f, f->origin[f->before[before]]);
		}
	}
	if (f->corner[i_p1] != NO_INDEX) {
		const idx_t out = f->corner[i_p1];
		if (!forward_has(f, forward_end(f, out))) {
			d = forward_point(f, forward_end(f, out));
			d2 = forward_point(f, forward_end(f, f->after[out]));
		}
	}
	const idx_t in = f->path[i_p2], out = f->path[i_n1];
	if (f->face[in ^ 1] != NO_INDEX)
		q = forward_point(f, f->origin[f->previous[in ^ 1]]);
	if (f->face[out ^ 1] != NO_INDEX)
		r = forward_point(f, forward_end(f, f->next[out ^ 1]));

	/* points */
	if (n == 4 && gap == 1 && n2)
		guess_step(g, FORE_QUAD, p1, n2, n1);
	if (n == 3 && f->face[out ^ 1] != NO_INDEX) {
		int32_t middle[3];
		for (int k = 0; k < 3; k++)
			middle[k] = (int32_t)shift_down((int64_t)q[k] + r[k], 1);
		guess_step(g, FORE_ACROSS, p1, middle, n1);
	}
	if (n > 4 && p2 && p3)
		guess_polygon(g, p3, p2, p1, n);
	if (n > 4 && gap == 1 && n2 && n3)
		guess_polygon(g, n3, n2, n1, n);
	if (gap == 2 && x)
		guess_step(g, FORE_PREVIOUS, p1, n1, x);
	if (q && n > 3)
		guess_step(g, FORE_STRAIGHT, p1, q, p1);
	if (r && gap == 1 && n > 3)
		guess_step(g, FORE_STRAIGHT, n1, r, n1);
	if (d)
		guess_step(g, FORE_FOLLOWING, p1, d, d2);
	if (x && gap == 1)
		guess_step(g, FORE_FOLLOWING, n1, x, x2);
	guess_mean(g);
	guess_place(g, FORE_C, p1);
	guess_place(g, FORE_A, n1);
	if (p2 != n1)
		guess_place(g, FORE_P, p2);
	if (n2 != p1 && n2 != p2)
		guess_place(g, FORE_B, n2);
	guess_place(g, FORE_X, x);
	guess_place(g, FORE_D, d);
	guess_place(g, FORE_X2, x2);
	guess_place(g, FORE_D2, d2);
	if (q != n1)
		guess_place(g, FORE_Q, q);
	if (r != q && r != p1)
		guess_place(g, FORE_R, r);
	if (f->placed > 0 && f->grid + 3 * (f->placed - 1) != p1)
		guess(g, FORE_LAST, f->grid + 3 * (f->placed - 1));

	/* planes */
	const int32_t *corner[PLANE_CORNERS];
	int count = 0;
	for (size_t i = 0; i < n && i < 4 * PLANE_CORNERS && count < PLANE_CORNERS; i++) {
		if (i == n - 1)
			break;
		const ptrdiff_t by = i % 2 ? -(ptrdiff_t)(i / 2) - 1 : (ptrdiff_t)(i / 2) + 1;
		const int32_t *place = known_at(f, corner_at(f, at, by));
		if (place)
			corner[count++] = place;
	}
	if (count > 2)
		predict_add_plane(g, FORE_PLANE, corner, count);
	if (d)
		predict_add_plane(g, FORE_PLANE_BEHIND, (const int32_t *[]){p1, d, d2}, 3);
	if (x && gap == 1)
		predict_add_plane(g, FORE_PLANE_BEFORE, (const int32_t *[]){n1, x, x2}, 3);
	if (count <= 2 && q)
		predict_add_plane(g, FORE_PLANE_ACROSS, (const int32_t *[]){p1, p2, q}, 3);
	predict_choose_axes(g);
}

void foresee_first(struct guesses *g, const struct forward *f)
{
	*g = (struct guesses){.phase = 0};
	if (f->placed > 0)
		guess(g, f->placed > f->component_start ? FORE_C : FORE_LAST, forward_point(f, (idx_t)f->placed - 1));
	predict_choose_axes(g);
}
