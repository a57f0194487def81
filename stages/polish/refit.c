#include "stages/polish/refit.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/lsq.h"
#include "stages/geometry/vector.h"

#define LEAST_DISTANCE 3e-4 /* weights stop rising below */
#define MOST_WEIGHT_DISTANCE 0.05
#define PROXIMAL 1e-3       /* of the mean diagonal entry: keeps points where nothing pulls */
#define HALVINGS 2
#define PROMISE 3           /* times the fall of the quadratic form: more than that was never seen to come of a step */

double view_cost(const struct view *view, const struct judge *judge, double total_area)
{
	return (view->sample_sum + view->tip_sum) / (double)judge->target->area_count / 2 + view->spot_sum / total_area / 2;
}

/* Iteratively reweighted: the weight makes the gradient of w r^2 / 2 that of the cost. */
static double weight_of(const struct judge *judge, double d)
{
	return judge_slope(judge, d) / fmax(d, LEAST_DISTANCE);
}

bool view_equation(struct equation *q, const struct view *view, const struct judge *judge, double total_area, size_t i)
{
	const struct target *t = judge->target;
	if (i < view->sample_count) {
		const size_t s = (size_t)view->sample[i];
		const struct skin_foot *foot = &view->foot[i];
		const bool is_extra = s >= t->area_count;
		if (foot->distance > MOST_WEIGHT_DISTANCE || (is_extra && foot->distance < judge->max))
			return false;
		*q = (struct equation){foot->corner, foot->weight, &t->point[3 * s], &t->normal[3 * s], foot->point,
		                       weight_of(judge, foot->distance) / (2 * (double)t->area_count)};
		return true;
	}
	i -= view->sample_count;
	if (i >= view->spot_count) {
		static const double one[3] = {1, 0, 0};
		const struct tip *tip = &view->tip[i - view->spot_count];
		if (tip->foot.distance < judge->max || tip->foot.distance > MOST_WEIGHT_DISTANCE)
			return false;
		*q = (struct equation){tip->corner, one, tip->foot.point, tip->foot.normal, &view->skin.fine.xyz[3 * (size_t)tip->corner[0]],
		                       TIP_WEIGHT * weight_of(judge, tip->foot.distance) / (2 * (double)t->area_count)};
		return true;
	}
	const struct foot *foot = &view->spot_foot[i];
	const struct skin_spot *spot = &view->spot[i];
	if (foot->distance > MOST_WEIGHT_DISTANCE || !(spot->area > 0) || !(dot3(foot->normal, foot->normal) > 0.5))
		return false;
	*q = (struct equation){spot->corner, spot->weight, foot->point, foot->normal, spot->point,
	                       weight_of(judge, foot->distance) * spot->area / (2 * total_area)};
	return true;
}

/* --- few ------------------------------------------------------------------------------------------------------------------ */

/* Normal equations for shifts of the vertices: matrix n x n (lower half by rows), right n, n = 3 count. */
static void gather_few(double *matrix, double *right, const struct view *view, const struct judge *judge, const double *column, size_t count,
                       double total_area)
{
	const size_t n = 3 * count;
	double *c = mem_array(count, sizeof *c);
	size_t *used = mem_array(count, sizeof *used);
	memset(matrix, 0, n * n * sizeof *matrix), memset(right, 0, n * sizeof *right);
	for (size_t i = 0; i < view_equations(view); i++) {
		struct equation q;
		if (!view_equation(&q, view, judge, total_area, i))
			continue;
		size_t used_count = 0;
		for (size_t j = 0; j < count; j++) {
			c[j] = 0;
			for (int k = 0; k < 3; k++)
				c[j] += q.corner_weight[k] * column[(size_t)q.corner[k] * count + j];
			if (fabs(c[j]) > 1e-5)
				used[used_count++] = j;
		}
		if (used_count == 0)
			continue;
		double r[3];
		sub3(r, q.point, q.target);
		const double height = dot3(r, q.normal), w = q.weight, tangential = REFIT_TANGENTIAL * w;
		for (size_t a = 0; a < used_count; a++) {
			const size_t ja = used[a];
			for (int k = 0; k < 3; k++)
				right[3 * ja + k] -= c[ja] * (w * height * q.normal[k] + tangential * r[k]);
			for (size_t b = 0; b <= a; b++) {
				const size_t jb = used[b];
				const double cc = c[ja] * c[jb], cw = cc * w, ct = cc * tangential;
				for (int k = 0; k < 3; k++) {
					double *row = &matrix[(3 * ja + k) * n + 3 * jb];
					const double m = cw * q.normal[k];
					row[0] += m * q.normal[0], row[1] += m * q.normal[1], row[2] += m * q.normal[2];
					row[k] += ct;
				}
			}
		}
	}
	double scale = 0;
	for (size_t i = 0; i < n; i++)
		scale += matrix[i * n + i];
	scale = scale / (double)n * PROXIMAL + 1e-12;
	for (size_t i = 0; i < n; i++)
		matrix[i * n + i] += scale;
	free(c), free(used);
}

static void shift(struct sketch *s, const idx_t *vertex, size_t count, const double *by, double factor)
{
	for (size_t j = 0; j < count; j++)
		add_scaled3(&s->xyz[3 * (size_t)vertex[j]], factor, &by[3 * j]);
}

double refit_few(struct sketch *s, struct view *view, const struct judge *judge, const idx_t *vertex, size_t count, double total_area, double goal,
                 int iterations)
{
	double cost = view_cost(view, judge, total_area);
	if (count == 0)
		return cost;
	const size_t n = 3 * count;
	double *column = mem_array(view->skin.fine.vertex_count * count, sizeof *column);
	double *matrix = mem_array(n * n, sizeof *matrix), *right = mem_array(n, sizeof *right);
	skin_columns(column, &view->skin, vertex, count);
	double *gradient = mem_array(n, sizeof *gradient);
	for (int i = 0; i < iterations; i++) {
		gather_few(matrix, right, view, judge, column, count, total_area);
		memcpy(gradient, right, n * sizeof *gradient);
		if (LAPACKE_dposv(LAPACK_ROW_MAJOR, 'L', (int)n, 1, matrix, (int)n, right, 1) != 0)
			break;
		double factor = 1, reached = cost, promised = 0;
		for (size_t k = 0; k < n; k++)
			promised += gradient[k] * right[k] / 2;
		if (cost - PROMISE * promised > goal)
			break;
		shift(s, vertex, count, right, factor);
		for (int k = 0; k <= HALVINGS; k++) {
			view_move(view, judge, s);
			reached = view_cost(view, judge, total_area);
			if (reached < cost)
				break;
			shift(s, vertex, count, right, -factor / 2);
			factor /= 2;
		}
		if (!(reached < cost)) {
			shift(s, vertex, count, right, -factor);
			view_move(view, judge, s);
			break;
		}
		const bool is_little = reached > 0.995 * cost || reached - (cost - reached) / 2 > goal;
		cost = reached;
		if (is_little)
			break;
	}
	free(column), free(matrix), free(right), free(gradient);
	return cost;
}

/* --- all --------------------------------------------------------------------------------------------------------------------- */

size_t whole_row(idx_t *index, double *coefficient, const struct whole *whole, const struct equation *q)
{
	const struct sparse *operator = &whole->operator;
	size_t count = 0;
	for (int k = 0; k < 3; k++) {
		const size_t row = (size_t)q->corner[k];
		if (q->corner_weight[k] == 0)
			continue;
		for (size_t e = operator->row_start[row]; e < operator->row_start[row + 1]; e++) {
			size_t j = 0;
			const idx_t v = whole->view.skin.part_vertex[operator->column[e]];
			while (j < count && index[j] != v)
				j++;
			if (j == count) {
				if (count == ROW_LIMIT)
					return 0;
				index[count] = v, coefficient[count++] = 0;
			}
			coefficient[j] += q->corner_weight[k] * operator->weight[e];
		}
	}
	return count;
}

void whole_open(struct whole *whole, const struct judge *judge, const struct sketch *s)
{
	const struct target *t = judge->target;
	whole->face = mem_array(s->face_count, sizeof *whole->face), whole->sample = mem_array(t->count, sizeof *whole->sample);
	for (size_t f = 0; f < s->face_count; f++)
		whole->face[f] = (idx_t)f;
	for (size_t i = 0; i < t->count; i++)
		whole->sample[i] = (idx_t)i;
	view_open(&whole->view, judge, s, whole->face, s->face_count, whole->sample, t->count);
	struct level refined;
	subdivide_operator(&whole->operator, &refined, &whole->view.skin.part, s->scheme, judge->steps, false);
	level_free(&refined);
}

void whole_free(struct whole *whole)
{
	view_free(&whole->view);
	sparse_free(&whole->operator);
	free(whole->face), free(whole->sample);
}

static double whole_area(const struct view *view) { return view->spot_area; }

void refit_all(struct sketch *s, struct errors *errors, const struct judge *judge, int iterations)
{
	struct whole whole;
	whole_open(&whole, judge, s);
	struct view *const view = &whole.view;
	double *start = mem_array(3 * s->vertex_count, sizeof *start);
	double *best = mem_copy(s->xyz, 3 * s->vertex_count, sizeof *best);
	double cost = view_cost(view, judge, whole_area(view));
	for (int i = 0; i < iterations; i++) {
		*judge->work += 8 * view_equations(view); /* building and solving */
		memcpy(start, s->xyz, 3 * s->vertex_count * sizeof *start);
		struct lsq *lsq = lsq_new(s->vertex_count, start, NULL);
		for (size_t k = 0; k < view_equations(view); k++) {
			struct equation q;
			idx_t index[ROW_LIMIT];
			double coefficient[ROW_LIMIT];
			if (!view_equation(&q, view, judge, whole_area(view), k))
				continue;
			const size_t count = whole_row(index, coefficient, &whole, &q);
			const double *n = q.normal, w = REFIT_TANGENTIAL;
			const double metric[6] = {n[0] * n[0] + w, n[0] * n[1], n[0] * n[2], n[1] * n[1] + w, n[1] * n[2], n[2] * n[2] + w};
			if (count > 0)
				lsq_add(lsq, index, coefficient, count, q.target, metric, q.weight);
		}
		const double scale = lsq_scale(lsq) * PROXIMAL + 1e-12;
		for (size_t v = 0; v < s->vertex_count; v++)
			lsq_add_point(lsq, (idx_t)v, &start[3 * v], scale);
		const bool is_solved = lsq_solve(lsq, s->xyz);
		lsq_free(lsq);
		if (!is_solved)
			break;
		double reached = cost;
		for (int k = 0; k <= HALVINGS; k++) {
			view_move(view, judge, s);
			reached = view_cost(view, judge, whole_area(view));
			if (reached < cost)
				break;
			for (size_t v = 0; v < 3 * s->vertex_count; v++)
				s->xyz[v] = (s->xyz[v] + start[v]) / 2;
		}
		if (!(reached < cost))
			break;
		const bool is_little = reached > 0.998 * cost;
		cost = reached;
		memcpy(best, s->xyz, 3 * s->vertex_count * sizeof *best);
		if (is_little)
			break;
	}
	memcpy(s->xyz, best, 3 * s->vertex_count * sizeof *best);
	whole_free(&whole);
	free(start), free(best);
	judge_all(errors, judge, s);
}
