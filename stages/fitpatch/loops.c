/* Bands and grids: what harmonised borders ask for. */
#include "stages/fitpatch/loops.h"

#include <math.h>
#include <stdlib.h>

#include "stages/fitpatch/frame.h"
#include "stages/geometry/vector.h"

/* A border that turns by more has a corner of a four-sided patch there. */
static const double side_turn_deg = 30;
/* More rings or rows than this are left to the enrichment. */
enum { MOST_ROWS = 8 };

void loops_find(struct loops *loops, const struct sheet *sheet)
{
	*loops = (struct loops){0};
	const size_t halves = 3 * sheet->triangle_count;
	unsigned char *seen = mem_array(halves, 1);
	loops->start = mem_array(halves + 1, sizeof *loops->start);
	loops->vertex = mem_array(halves, sizeof *loops->vertex);
	loops->turn_deg = mem_array(halves, sizeof *loops->turn_deg);
	size_t used = 0;
	for (size_t g = 0; g < halves; g++) {
		if (sheet->origin[g] == NO_INDEX || sheet->twin[g] != NO_INDEX || seen[g])
			continue;
		idx_t h = (idx_t)g;
		do {
			seen[h] = 1;
			idx_t next = sheet_next(h);
			while (sheet->twin[next] != NO_INDEX)
				next = sheet_next(sheet->twin[next]);
			const idx_t v = sheet->origin[next];
			if (sheet->point[v] != NO_INDEX) {
				double in[3], out[3];
				sub3(in, &sheet->xyz[3 * (size_t)v], &sheet->xyz[3 * (size_t)sheet->origin[h]]);
				sub3(out, &sheet->xyz[3 * (size_t)sheet_target(sheet, next)], &sheet->xyz[3 * (size_t)v]);
				loops->vertex[used] = v;
				loops->turn_deg[used++] = angle3(in, out) * DEGREES;
			}
			h = next;
		} while (h != (idx_t)g);
		loops->start[++loops->count] = used;
	}
	free(seen);
}

void loops_free(struct loops *loops)
{
	free(loops->start), free(loops->vertex), free(loops->turn_deg);
	*loops = (struct loops){0};
}

static struct foot foot_on(const struct layout_context *context, idx_t patch, const double p[3])
{
	return frame_foot(context->nearest, context->dense, patch, p);
}

/* Rows of control points needed between a and b so that the bending between them is met. Natural-end B-spline arcs of m inner
 * points miss a circle of radius rho by about 5.6e-9 rho (angle / (m + 1))^4, angle in degrees (fit to the method's table 4.5). */
static size_t rows_between(const struct layout_context *context, idx_t patch, const double a[3], const double b[3])
{
	enum { STEPS = 8 };
	double angle = 0, length = 0, last_normal[3], last_point[3];
	for (int i = 0; i <= STEPS; i++) {
		double p[3];
		/* Not quite from the ends: the normal there may be the neighbour's. */
		const double t = 0.02 + 0.96 * i / STEPS;
		for (int k = 0; k < 3; k++)
			p[k] = a[k] + t * (b[k] - a[k]);
		const struct foot foot = foot_on(context, patch, p);
		if (foot.triangle == NO_INDEX)
			return 0;
		struct frame frame;
		frame_at(&frame, context->dense, &foot);
		if (i > 0) {
			angle += angle3(frame.normal, last_normal) * DEGREES;
			length += distance3(foot.point, last_point);
		}
		copy3(last_normal, frame.normal);
		copy3(last_point, foot.point);
	}
	if (angle < 5)
		return 0;
	const double radius = length / (angle / DEGREES), allowed = context->tolerance / 2;
	const double step = pow(allowed / (5.6e-9 * radius), 0.25); /* degrees a row may span */
	const double rows = ceil(angle / step) - 1;
	return rows < 0 ? 0 : rows > MOST_ROWS ? MOST_ROWS : (size_t)rows;
}

static void add_quad(struct layout_context *context, idx_t patch, idx_t a, idx_t b, idx_t c, idx_t d)
{
	const idx_t corner[4] = {a, b, c, d};
	polygons_add(context->polygons, corner, 4, patch);
}

static bool may_join(const struct layout_context *context, idx_t a, idx_t b) { return a != b && !edge_set_has(context->taken, a, b); }

bool loops_band(struct layout_context *context, const struct sheet *sheet, const struct loops *loops, idx_t patch)
{
	if (loops->count != 2)
		return false;
	const size_t n = loops->start[1];
	if (n < 3 || loops->start[2] - n != n)
		return false;
	const idx_t *one = loops->vertex, *two = loops->vertex + n;
	size_t shift = 0;
	double least = INFINITY;
	for (size_t s = 0; s < n; s++) {
		double sum = 0;
		for (size_t i = 0; i < n; i++) {
			const double d = distance3(&sheet->xyz[3 * (size_t)one[i]], &sheet->xyz[3 * (size_t)two[(s + n - i) % n]]);
			sum += d * d;
		}
		if (sum < least)
			least = sum, shift = s;
	}
	size_t rows = 0;
	for (size_t i = 0; i < n; i++) {
		const idx_t a = one[i], b = two[(shift + n - i) % n];
		const size_t here = rows_between(context, patch, &sheet->xyz[3 * (size_t)a], &sheet->xyz[3 * (size_t)b]);
		rows = here > rows ? here : rows;
	}
	if (rows == 0)
		for (size_t i = 0; i < n; i++)
			if (!may_join(context, sheet->point[one[i]], sheet->point[two[(shift + n - i) % n]]))
				rows = 1; /* an inner ring keeps clear of the edge that is there */
	idx_t *ring = mem_array(2 * n, sizeof *ring), *last = ring, *next = ring + n;
	for (size_t i = 0; i < n; i++)
		last[i] = sheet->point[one[i]];
	for (size_t row = 1; row <= rows + 1; row++) {
		for (size_t i = 0; i < n; i++) {
			const idx_t b = two[(shift + n - i) % n];
			if (row == rows + 1) {
				next[i] = sheet->point[b];
				continue;
			}
			double p[3];
			const double t = (double)row / (double)(rows + 1);
			for (int k = 0; k < 3; k++)
				p[k] = (1 - t) * sheet->xyz[3 * (size_t)one[i] + (size_t)k] + t * sheet->xyz[3 * (size_t)b + (size_t)k];
			next[i] = control_add(context->control, foot_on(context, patch, p).point, POINT_INSIDE);
		}
		for (size_t i = 0; i < n; i++) {
			add_quad(context, patch, last[i], last[(i + 1) % n], next[(i + 1) % n], next[i]);
			edge_set_add(context->taken, last[i], next[i]);
		}
		idx_t *swap = last;
		last = next, next = swap;
	}
	free(ring);
	return true;
}

/* Are there four nodes where the border turns? By the mesh, or by the control points: cuts through a surface run in steps along
 * the mesh, and their first step says nothing. */
static bool four_corners(size_t corner[4], const struct layout_context *context, const struct sheet *sheet, const struct loops *loops, bool by_mesh)
{
	const size_t n = loops->start[1];
	size_t corners = 0;
	for (size_t i = 0; i < n; i++) {
		if (context->control->role[sheet->point[loops->vertex[i]]] == POINT_CREASE)
			continue;
		double in[3], out[3];
		const double *at = &sheet->xyz[3 * (size_t)loops->vertex[i]];
		sub3(in, at, &sheet->xyz[3 * (size_t)loops->vertex[(i + n - 1) % n]]);
		sub3(out, &sheet->xyz[3 * (size_t)loops->vertex[(i + 1) % n]], at);
		if ((by_mesh ? loops->turn_deg[i] : angle3(in, out) * DEGREES) <= side_turn_deg)
			continue;
		if (corners == 4)
			return false;
		corner[corners++] = i;
	}
	return corners == 4;
}

bool loops_grid(struct layout_context *context, const struct sheet *sheet, const struct loops *loops, idx_t patch)
{
	if (loops->count != 1)
		return false;
	const size_t n = loops->start[1];
	size_t corner[4];
	if (!four_corners(corner, context, sheet, loops, true) && !four_corners(corner, context, sheet, loops, false))
		return false;
	const size_t across = corner[1] - corner[0], along = corner[2] - corner[1];
	if (corner[3] - corner[2] != across || n - (corner[3] - corner[0]) != along)
		return false;
	/* Grid of (across + 1) x (along + 1) points, g[j][i]: j = 0 is the first side, walking on around the loop. */
	const size_t wide = across + 1, high = along + 1;
	if (across == 1 && along == 1)
		return false; /* one quad: the general way finds it and checks it */
	idx_t *g = mem_array(wide * high, sizeof *g);
	double *at = mem_array(3 * wide * high, sizeof *at);
#define SIDE(i) loops->vertex[(corner[0] + (i)) % n]
	for (size_t j = 0; j < high; j++)
		for (size_t i = 0; i < wide; i++) {
			idx_t v = NO_INDEX;
			if (j == 0)
				v = SIDE(i);
			else if (i == across)
				v = SIDE(across + j);
			else if (j == along)
				v = SIDE(across + along + (across - i));
			else if (i == 0)
				v = SIDE(2 * across + along + (along - j));
			g[j * wide + i] = v == NO_INDEX ? NO_INDEX : sheet->point[v];
			if (v != NO_INDEX)
				copy3(&at[3 * (j * wide + i)], &sheet->xyz[3 * (size_t)v]);
		}
#undef SIDE
	bool good = true;
	/* Chords straight from side to side must be free. */
	if (along == 1)
		for (size_t i = 1; i < across; i++)
			good &= may_join(context, g[i], g[wide + i]);
	if (across == 1)
		for (size_t j = 1; j < along; j++)
			good &= may_join(context, g[j * wide], g[j * wide + 1]);
	if (good) {
		for (size_t j = 1; j < along; j++)
			for (size_t i = 1; i < across; i++) {
				const double u = (double)i / (double)across, v = (double)j / (double)along;
				const double *left = &at[3 * (j * wide)], *right = &at[3 * (j * wide + across)], *bottom = &at[3 * i], *top = &at[3 * (along * wide + i)];
				const double *c00 = at, *c10 = &at[3 * across], *c01 = &at[3 * (along * wide)], *c11 = &at[3 * (along * wide + across)];
				double p[3];
				for (int k = 0; k < 3; k++)
					p[k] = (1 - u) * left[k] + u * right[k] + (1 - v) * bottom[k] + v * top[k]
					       - ((1 - u) * (1 - v) * c00[k] + u * (1 - v) * c10[k] + (1 - u) * v * c01[k] + u * v * c11[k]);
				const struct foot foot = foot_on(context, patch, p);
				g[j * wide + i] = control_add(context->control, foot.point, POINT_INSIDE);
			}
		for (size_t j = 0; j < along; j++)
			for (size_t i = 0; i < across; i++) {
				const idx_t a = g[j * wide + i], b = g[j * wide + i + 1], c = g[(j + 1) * wide + i + 1], d = g[(j + 1) * wide + i];
				add_quad(context, patch, a, b, c, d);
				edge_set_add(context->taken, a, b), edge_set_add(context->taken, b, c);
				edge_set_add(context->taken, c, d), edge_set_add(context->taken, d, a);
			}
	}
	free(g), free(at);
	return good;
}

/* The point of the patch over the middle of its only loop: the vertex nearest to the line through it along the loop's area vector. */
static bool find_pole(double pole[3], double axis[3], double centre[3], const struct sheet *sheet, const struct loops *loops)
{
	const size_t n = loops->start[1];
	centre[0] = centre[1] = centre[2] = 0;
	axis[0] = axis[1] = axis[2] = 0;
	for (size_t i = 0; i < n; i++)
		add_scaled3(centre, 1.0 / (double)n, &sheet->xyz[3 * (size_t)loops->vertex[i]]);
	for (size_t i = 0; i < n; i++) {
		double doubled[3];
		area_vector3(doubled, centre, &sheet->xyz[3 * (size_t)loops->vertex[i]], &sheet->xyz[3 * (size_t)loops->vertex[(i + 1) % n]]);
		add_scaled3(axis, 1, doubled);
	}
	if (!(normalise3(axis) > 0))
		return false;
	double least = INFINITY;
	for (size_t v = 0; v < sheet->vertex_count; v++) {
		if (sheet->outgoing[v] == NO_INDEX || sheet_on_border(sheet, (idx_t)v))
			continue;
		double offset[3];
		sub3(offset, &sheet->xyz[3 * v], centre);
		add_scaled3(offset, -dot3(offset, axis), axis);
		const double away = norm3(offset);
		if (away < least)
			least = away, copy3(pole, &sheet->xyz[3 * v]);
	}
	return isfinite(least);
}

/* Does every point of the loop lie on from the one before, seen along the axis? */
static bool runs_around(const double axis[3], const double centre[3], const struct sheet *sheet, const struct loops *loops)
{
	const size_t n = loops->start[1];
	for (size_t i = 0; i < n; i++) {
		double doubled[3];
		area_vector3(doubled, centre, &sheet->xyz[3 * (size_t)loops->vertex[i]], &sheet->xyz[3 * (size_t)loops->vertex[(i + 1) % n]]);
		if (!(dot3(doubled, axis) > 0.3 * norm3(doubled)))
			return false;
	}
	return true;
}

bool loops_dome(struct layout_context *context, const struct sheet *sheet, const struct loops *loops, idx_t patch)
{
	if (loops->count != 1)
		return false;
	const size_t n = loops->start[1];
	if (n < 4)
		return false;
	for (size_t i = 0; i < n; i++)
		if (context->control->role[sheet->point[loops->vertex[i]]] != POINT_CREASE)
			return false;
	double centre[3], axis[3], pole[3];
	if (!find_pole(pole, axis, centre, sheet, loops) || !runs_around(axis, centre, sheet, loops))
		return false;
	size_t rows = 0;
	for (size_t i = 0; i < n; i++) {
		const size_t here = rows_between(context, patch, &sheet->xyz[3 * (size_t)loops->vertex[i]], pole);
		rows = here > rows ? here : rows;
	}
	if (rows == 0)
		return false; /* as good as flat */
	/* An even ring is closed by quads around the pole, another by a polygon: that spans two steps of its rows in one. */
	const bool has_pole = n % 2 == 0 && n >= 6;
	const double steps = (double)rows + (has_pole ? 1 : 0.5);
	idx_t *ring = mem_array(2 * n, sizeof *ring), *last = ring, *next = ring + n;
	for (size_t i = 0; i < n; i++)
		last[i] = sheet->point[loops->vertex[i]];
	for (size_t row = 1; row <= rows; row++) {
		for (size_t i = 0; i < n; i++) {
			double p[3];
			const double t = (double)row / steps;
			for (int k = 0; k < 3; k++)
				p[k] = (1 - t) * sheet->xyz[3 * (size_t)loops->vertex[i] + (size_t)k] + t * pole[k];
			next[i] = control_add(context->control, foot_on(context, patch, p).point, POINT_INSIDE);
		}
		for (size_t i = 0; i < n; i++)
			add_quad(context, patch, last[i], last[(i + 1) % n], next[(i + 1) % n], next[i]);
		idx_t *swap = last;
		last = next, next = swap;
	}
	if (has_pole) {
		const idx_t top = control_add(context->control, pole, POINT_INSIDE);
		for (size_t i = 0; i < n; i += 2)
			add_quad(context, patch, top, last[i], last[i + 1], last[(i + 2) % n]);
	} else {
		polygons_add(context->polygons, last, n, patch);
	}
	free(ring);
	return true;
}
