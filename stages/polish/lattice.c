#include "stages/polish/lattice.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/vector.h"
#include "stages/polish/refit.h"

#define DENSE_LIMIT 1600    /* unknowns up to which points are rounded one after the other with all others following (Babai) */
#define TABLE_LIMIT 3000    /* vertices up to which the form is kept */
#define PROXIMAL 1e-4       /* of the mean diagonal entry */
#define MOST_SWEEPS 40
#define MOST_BITS_WON 12    /* by one step of one coordinate: what costs more is not coded to see */

void lattice_free(struct lattice *lattice)
{
	free(lattice->grid);
	lattice->grid = NULL;
}

/* --- the cost near a position as a quadratic form --------------------------------------------------------------------------- */

/* change of cost = right . d + d . H d / 2 for shifts d of the vertices */
struct form {
	size_t count;        /* vertices */
	idx_t *slot;         /* count x count: block, or NO_INDEX */
	double *block;       /* 9 a block: H of row vertex, column vertex */
	size_t block_count, block_room;
	idx_t *neighbour;    /* those with a block, by row: neighbour_start */
	size_t *neighbour_start;
	double *right;
};

static void form_free(struct form *form)
{
	free(form->slot), free(form->block), free(form->neighbour), free(form->neighbour_start), free(form->right);
	*form = (struct form){0};
}

static double *form_block(struct form *form, idx_t i, idx_t j)
{
	idx_t *slot = &form->slot[(size_t)i * form->count + (size_t)j];
	if (*slot == NO_INDEX) {
		if (form->block_count == form->block_room)
			form->block = mem_resize(form->block, 9 * (form->block_room = 2 * form->block_room + 1024), sizeof *form->block);
		memset(&form->block[9 * form->block_count], 0, 9 * sizeof *form->block);
		*slot = (idx_t)form->block_count++;
	}
	return &form->block[9 * (size_t)*slot];
}

static void form_build(struct form *form, const struct whole *whole, const struct judge *judge, size_t vertex_count)
{
	*form = (struct form){.count = vertex_count};
	form->slot = mem_array(vertex_count * vertex_count, sizeof *form->slot);
	memset(form->slot, -1, vertex_count * vertex_count * sizeof *form->slot);
	form->right = mem_array(3 * vertex_count, sizeof *form->right);
	const struct view *view = &whole->view;
	for (size_t i = 0; i < view_equations(view); i++) {
		struct equation q;
		idx_t index[ROW_LIMIT];
		double c[ROW_LIMIT], r[3];
		if (!view_equation(&q, view, judge, view->spot_area, i))
			continue;
		const size_t count = whole_row(index, c, whole, &q);
		sub3(r, q.point, q.target);
		const double height = dot3(r, q.normal), w = q.weight, tangential = REFIT_TANGENTIAL * w;
		for (size_t a = 0; a < count; a++) {
			for (int k = 0; k < 3; k++)
				form->right[3 * (size_t)index[a] + k] += c[a] * (w * height * q.normal[k] + tangential * r[k]);
			for (size_t b = 0; b < count; b++) {
				double *block = form_block(form, index[a], index[b]);
				const double cc = c[a] * c[b], cw = cc * w;
				for (int k = 0; k < 3; k++) {
					for (int l = 0; l < 3; l++)
						block[3 * k + l] += cw * q.normal[k] * q.normal[l];
					block[3 * k + k] += cc * tangential;
				}
			}
		}
	}
	double scale = 0;
	for (size_t v = 0; v < vertex_count; v++)
		for (int k = 0; k < 3; k++)
			scale += form_block(form, (idx_t)v, (idx_t)v)[4 * k];
	scale = PROXIMAL * scale / (3 * (double)vertex_count) + 1e-12;
	for (size_t v = 0; v < vertex_count; v++)
		for (int k = 0; k < 3; k++)
			form_block(form, (idx_t)v, (idx_t)v)[4 * k] += scale;
	form->neighbour = mem_array(form->block_count, sizeof *form->neighbour);
	form->neighbour_start = mem_array(vertex_count + 1, sizeof *form->neighbour_start);
	size_t n = 0;
	for (size_t i = 0; i < vertex_count; i++) {
		for (size_t j = 0; j < vertex_count; j++)
			if (form->slot[i * vertex_count + j] != NO_INDEX)
				form->neighbour[n++] = (idx_t)j;
		form->neighbour_start[i + 1] = n;
	}
}

/* out = H d */
static void form_apply(double *out, const struct form *form, const double *d)
{
	memset(out, 0, 3 * form->count * sizeof *out);
	for (size_t i = 0; i < form->count; i++)
		for (size_t e = form->neighbour_start[i]; e < form->neighbour_start[i + 1]; e++) {
			const size_t j = (size_t)form->neighbour[e];
			const double *b = &form->block[9 * (size_t)form->slot[i * form->count + j]];
			for (int k = 0; k < 3; k++)
				out[3 * i + k] += b[3 * k] * d[3 * j] + b[3 * k + 1] * d[3 * j + 1] + b[3 * k + 2] * d[3 * j + 2];
		}
}

/* One coordinate moves by delta: the gradient follows. */
static void form_move(double *gradient, const struct form *form, size_t vertex, int axis, double delta)
{
	for (size_t e = form->neighbour_start[vertex]; e < form->neighbour_start[vertex + 1]; e++) {
		const size_t j = (size_t)form->neighbour[e];
		const double *b = &form->block[9 * (size_t)form->slot[vertex * form->count + j]];
		for (int k = 0; k < 3; k++)
			gradient[3 * j + k] += b[3 * axis + k] * delta;
	}
}

static double form_curvature(const struct form *form, size_t vertex, int axis)
{
	return form->block[9 * (size_t)form->slot[vertex * form->count + vertex] + 4 * axis];
}

/* --- rounding ------------------------------------------------------------------------------------------------------------------ */

/* Babai's nearest plane: coordinate by coordinate, each time the best place given those already rounded, with the rest free to follow.
 * at: present positions. False when the form is too large or not definite. */
static bool round_babai(struct lattice *l, const struct form *form, const double *at)
{
	const size_t n = 3 * form->count;
	if (n > DENSE_LIMIT)
		return false;
	double *matrix = mem_array(n * n, sizeof *matrix), *best = mem_array(n, sizeof *best), *d = mem_array(n, sizeof *d);
	for (size_t i = 0; i < form->count; i++)
		for (size_t e = form->neighbour_start[i]; e < form->neighbour_start[i + 1]; e++) {
			const size_t j = (size_t)form->neighbour[e];
			for (size_t k = 0; k < 9; k++)
				matrix[(3 * i + k / 3) * n + 3 * j + k % 3] = form->block[9 * (size_t)form->slot[i * form->count + j] + k];
		}
	for (size_t i = 0; i < n; i++)
		best[i] = -form->right[i];
	const bool is_definite = LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'U', (int)n, matrix, (int)n) == 0 &&
	                         LAPACKE_dpotrs(LAPACK_ROW_MAJOR, 'U', (int)n, 1, matrix, (int)n, best, 1) == 0;
	for (size_t i = n; is_definite && i-- > 0;) {
		double centre = best[i];
		const double *row = &matrix[i * n];
		for (size_t j = i + 1; j < n; j++)
			centre -= row[j] * (d[j] - best[j]) / row[i];
		const double g = round((at[i] + centre - l->origin[i % 3]) / l->step);
		l->grid[i] = (int32_t)g;
		d[i] = l->origin[i % 3] + l->step * g - at[i];
	}
	free(matrix), free(best), free(d);
	return is_definite;
}

static void lattice_positions(double *xyz, const struct lattice *l, size_t vertex_count)
{
	for (size_t i = 0; i < 3 * vertex_count; i++)
		xyz[i] = l->origin[i % 3] + l->step * l->grid[i];
}

/* Single steps that lower the form, until there is none. */
static void descend(struct lattice *l, const struct form *form, const double *at)
{
	const size_t n = 3 * form->count;
	double *d = mem_array(n, sizeof *d), *gradient = mem_array(n, sizeof *gradient);
	lattice_positions(d, l, form->count);
	for (size_t i = 0; i < n; i++)
		d[i] -= at[i];
	form_apply(gradient, form, d);
	for (size_t i = 0; i < n; i++)
		gradient[i] += form->right[i];
	bool has_moved = true;
	for (int sweep = 0; sweep < MOST_SWEEPS && has_moved; sweep++) {
		has_moved = false;
		for (size_t i = 0; i < n; i++) {
			const double delta = gradient[i] > 0 ? -l->step : l->step, h = form_curvature(form, i / 3, (int)(i % 3));
			if (gradient[i] * delta + h * delta * delta / 2 >= -1e-15)
				continue;
			l->grid[i] += gradient[i] > 0 ? -1 : 1;
			form_move(gradient, form, i / 3, (int)(i % 3), delta);
			has_moved = true;
		}
	}
	free(d), free(gradient);
}

/* The step and the origin that suit the rounded coordinates best: four unknowns, linear. */
static void fit_frame(struct lattice *l, const struct form *form, const double *at)
{
	const size_t n = 3 * form->count;
	double *u[5], *hu = mem_array(n, sizeof *hu), matrix[16], right[4];
	for (int j = 0; j < 5; j++)
		u[j] = mem_array(n, sizeof *u[j]);
	for (size_t i = 0; i < n; i++) {
		u[i % 3][i] = 1;
		u[3][i] = l->grid[i];
		u[4][i] = l->origin[i % 3] + l->step * l->grid[i] - at[i];
	}
	/* gradient at the present frame */
	form_apply(hu, form, u[4]);
	for (int j = 0; j < 4; j++) {
		right[j] = 0;
		for (size_t i = 0; i < n; i++)
			right[j] -= u[j][i] * (hu[i] + form->right[i]);
	}
	for (int a = 0; a < 4; a++) {
		form_apply(hu, form, u[a]);
		for (int b = 0; b < 4; b++) {
			matrix[4 * a + b] = 0;
			for (size_t i = 0; i < n; i++)
				matrix[4 * a + b] += u[b][i] * hu[i];
		}
	}
	if (LAPACKE_dposv(LAPACK_ROW_MAJOR, 'L', 4, 1, matrix, 4, right, 1) == 0 && fabs(right[3]) < l->step / 4) {
		for (int k = 0; k < 3; k++)
			l->origin[k] += right[k];
		l->step += right[3];
	}
	for (int j = 0; j < 5; j++)
		free(u[j]);
	free(hu);
}

/* Coordinates from 0. */
static void from_zero(struct lattice *l, size_t vertex_count)
{
	for (size_t k = 0; k < 3; k++) {
		int32_t low = INT32_MAX;
		for (size_t v = 0; v < vertex_count; v++)
			low = l->grid[3 * v + k] < low ? l->grid[3 * v + k] : low;
		for (size_t v = 0; v < vertex_count; v++)
			l->grid[3 * v + k] -= low;
		l->origin[k] += l->step * low;
	}
}

static bool has_flat_edge(const struct lattice *l, const struct sketch *s)
{
	for (size_t h = 0; h < s->face_start[s->face_count]; h++)
		if (memcmp(&l->grid[3 * (size_t)s->face_corner[h]], &l->grid[3 * (size_t)sketch_head(s, (idx_t)h)], 3 * sizeof *l->grid) == 0)
			return true;
	return false;
}

bool lattice_round(struct lattice *l, struct candidate *c, const struct judge *judge, double step, int rounds)
{
	struct sketch *s = &c->sketch;
	const size_t n = 3 * s->vertex_count;
	*l = (struct lattice){.step = step, .grid = mem_array(n, sizeof *l->grid)};
	for (int k = 0; k < 3; k++) {
		l->origin[k] = INFINITY;
		for (size_t v = 0; v < s->vertex_count; v++)
			l->origin[k] = fmin(l->origin[k], s->xyz[3 * v + k]);
	}
	for (size_t i = 0; i < n; i++)
		l->grid[i] = (int32_t)round((s->xyz[i] - l->origin[i % 3]) / step);
	if (rounds > 0 && s->vertex_count <= TABLE_LIMIT) {
		struct whole whole;
		whole_open(&whole, judge, s);
		struct lattice best = {.grid = NULL};
		double best_cost = INFINITY;
		for (int r = 0; r < rounds; r++) {
			struct form form;
			form_build(&form, &whole, judge, s->vertex_count);
			*judge->work += 8 * view_equations(&whole.view);
			if (r == 0) {
				round_babai(l, &form, s->xyz);
				descend(l, &form, s->xyz);
				fit_frame(l, &form, s->xyz);
			}
			descend(l, &form, s->xyz);
			fit_frame(l, &form, s->xyz);
			form_free(&form);
			lattice_positions(s->xyz, l, s->vertex_count);
			view_move(&whole.view, judge, s);
			const double cost = view_cost(&whole.view, judge, whole.view.spot_area);
			if (cost < best_cost) {
				best_cost = cost;
				free(best.grid);
				best = *l;
				best.grid = mem_copy(l->grid, n, sizeof *l->grid);
			}
		}
		whole_free(&whole);
		if (best.grid) {
			free(l->grid);
			*l = best;
		}
	}
	from_zero(l, s->vertex_count);
	lattice_positions(s->xyz, l, s->vertex_count);
	errors_free(&c->errors);
	judge_all(&c->errors, judge, s);
	if (!has_flat_edge(l, s))
		return true;
	lattice_free(l);
	return false;
}

/* --- streams ---------------------------------------------------------------------------------------------------------------------- */

void lattice_to_cage(struct cage *cage, const struct lattice *l, const struct sketch *s, const double middle[3], double scale)
{
	sketch_to_cage(cage, s, middle, scale);
	cage->grid_step = scale * l->step;
	for (int k = 0; k < 3; k++)
		cage->grid_origin[k] = middle[k] + scale * l->origin[k];
	for (size_t i = 0; i < 3 * s->vertex_count; i++)
		cage->xyz[i] = cage->grid_origin[i % 3] + cage->grid_step * l->grid[i];
}

bool lattice_to_ffx(struct ffx *ffx, const struct lattice *l, const struct sketch *s, const double middle[3], double scale)
{
	struct cage cage;
	struct fault fault = {0};
	lattice_to_cage(&cage, l, s, middle, scale);
	const bool fits = ffx_from_cage(ffx, &cage, &fault);
	cage_free(&cage);
	return fits;
}

void lattice_snap(struct lattice *l, struct candidate *c, const struct judge *judge, const double middle[3], double scale)
{
	struct ffx ffx;
	if (!lattice_to_ffx(&ffx, l, &c->sketch, middle, scale))
		return;
	l->step = ffx.frame.step / scale;
	for (int k = 0; k < 3; k++)
		l->origin[k] = (ldexp(ffx.frame.step * (double)ffx.frame.origin[k], -(int)ffx.frame.origin_bits) - middle[k]) / scale;
	ffx_free(&ffx);
	lattice_positions(c->sketch.xyz, l, c->sketch.vertex_count);
	errors_free(&c->errors);
	judge_all(&c->errors, judge, &c->sketch);
}

/* Bits of the stream from one start edge; INFINITY when it cannot be coded. */
static double stream_bits(struct ffx_work *work, const struct ffx *ffx, size_t root)
{
	struct fault fault = {0};
	return 8 * ffx_cost(work, ffx, root, NULL, &fault);
}

/* One vertex: the best of its six neighbours on the grid, if it is better than where it is. */
struct settling {
	struct lattice *lattice;
	struct candidate *c;
	const struct judge *judge;
	struct ffx ffx;
	struct ffx_work *work;
	size_t root;
	int32_t steps;
	double bits, lambda;
	idx_t *same; /* 0 1 2 ...: faces and vertices stay what they are */
};

static bool settle_vertex(struct settling *st, idx_t vertex)
{
	struct sketch *s = &st->c->sketch;
	const struct errors *errors = &st->c->errors;
	size_t face_count, sample_count = 0;
	idx_t *face = sketch_faces_near(&face_count, s, &vertex, 1, 2), *sample = mem_array(st->judge->target->count, sizeof *sample);
	double area = 0;
	for (size_t f = 0; f < s->face_count; f++)
		area += errors->face[f].area;
	for (size_t i = 0; i < face_count; i++)
		for (size_t k = errors->face_first[face[i]]; k < errors->face_first[face[i] + 1]; k++)
			sample[sample_count++] = errors->face_sample[k];
	struct view view;
	view_open(&view, st->judge, s, face, face_count, sample, sample_count);
	const double before = view_cost(&view, st->judge, area);
	double best = -1e-9, best_bits = st->bits;
	int best_axis = -1, best_sign = 0;
	for (int axis = 0; axis < 3; axis++)
		for (int sign = -1; sign <= 1; sign += 2) {
			int32_t *grid = &st->ffx.grid[3 * (size_t)vertex + axis];
			double *x = &s->xyz[3 * (size_t)vertex + axis];
			const double old = *x;
			if (*grid + sign < 0 || *grid + sign > st->steps)
				continue;
			*x += sign * st->lattice->step;
			view_move(&view, st->judge, s);
			const double change = view_cost(&view, st->judge, area) - before;
			if (change < st->lambda * MOST_BITS_WON) {
				*grid += sign;
				*st->judge->work += CODER_WORK * s->vertex_count;
				const double bits = stream_bits(st->work, &st->ffx, st->root), gain = change + st->lambda * (bits - st->bits);
				if (gain < best)
					best = gain, best_axis = axis, best_sign = sign, best_bits = bits;
				*grid -= sign;
			}
			*x = old;
		}
	if (best_axis < 0) {
		view_free(&view);
		free(face), free(sample);
		return false;
	}
	st->ffx.grid[3 * (size_t)vertex + best_axis] += best_sign;
	st->lattice->grid[3 * (size_t)vertex + best_axis] += best_sign;
	s->xyz[3 * (size_t)vertex + best_axis] += best_sign * st->lattice->step;
	const bool is_flat = has_flat_edge(st->lattice, s);
	if (is_flat) {
		st->ffx.grid[3 * (size_t)vertex + best_axis] -= best_sign;
		st->lattice->grid[3 * (size_t)vertex + best_axis] -= best_sign;
		s->xyz[3 * (size_t)vertex + best_axis] -= best_sign * st->lattice->step;
	} else {
		struct errors now;
		st->bits = best_bits;
		view_move(&view, st->judge, s);
		judge_edit(&now, st->judge, s, &view, errors, st->same, s->face_count, st->same, s->vertex_count);
		errors_free(&st->c->errors);
		st->c->errors = now;
	}
	view_free(&view);
	free(face), free(sample);
	return !is_flat;
}

size_t lattice_settle(struct lattice *l, struct candidate *c, const struct judge *judge, double lambda, int sweeps)
{
	const double zero[3] = {0};
	struct settling st = {.lattice = l, .c = c, .judge = judge, .lambda = lambda};
	if (!lattice_to_ffx(&st.ffx, l, &c->sketch, zero, 1))
		return 0;
	unsigned char *bytes;
	size_t size, taken = 0;
	struct ffx_report report;
	struct fault fault = {0};
	const struct ffx_options options = {.root_limit = 8};
	if (ffx_encode(&bytes, &size, &report, &st.ffx, &options, &fault)) {
		free(bytes);
		st.root = report.root;
		st.ffx.method = report.method;
		st.work = ffx_work_new();
		st.steps = ffx_grid_steps(st.ffx.grid_code);
		st.bits = stream_bits(st.work, &st.ffx, st.root);
		const size_t most = c->sketch.vertex_count > c->sketch.face_count ? c->sketch.vertex_count : c->sketch.face_count;
		st.same = mem_array(most, sizeof *st.same);
		for (size_t i = 0; i < most; i++)
			st.same[i] = (idx_t)i;
		for (int sweep = 0; sweep < sweeps; sweep++) {
			size_t here = 0;
			for (size_t v = 0; v < c->sketch.vertex_count; v++)
				here += settle_vertex(&st, (idx_t)v);
			taken += here;
			if (here == 0)
				break;
		}
	}
	ffx_work_free(st.work);
	free(st.same);
	ffx_free(&st.ffx);
	from_zero(l, c->sketch.vertex_count);
	if (taken > 0) {
		errors_free(&c->errors);
		judge_all(&c->errors, judge, &c->sketch);
	}
	return taken;
}
