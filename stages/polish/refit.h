/* Moving control points so that the surface follows the target: weighted least squares on tangent planes, both ways. */
#ifndef CAGEWRIGHT_REFIT_H
#define CAGEWRIGHT_REFIT_H

#include "stages/polish/judge.h"

/* Move the listed vertices of the sketch so that the cost of the view (judge_view_cost) falls; steps that do not lower it are halved, then
 * dropped. total_area: of the whole refined surface. goal: where a cost is good enough to matter; fitting ends when it is out of reach.
 * Returns the cost reached. For few vertices: O(samples * count^2). */
double refit_few(struct sketch *sketch, struct view *view, const struct judge *judge, const idx_t *vertex, size_t count, double total_area,
                 double goal, int iterations);

/* All vertices at once; fills *errors (freed before if needed by the caller) with those of the result. */
void refit_all(struct sketch *sketch, struct errors *errors, const struct judge *judge, int iterations);

/* (mean over the samples + integral over the spots / area) / 2 of a view */
double view_cost(const struct view *view, const struct judge *judge, double total_area);

/* The linear equation that a sample or spot gives: sum of coefficient * P[index] should lie in the plane through target with this normal. */
struct equation {
	const idx_t *corner;  /* fine vertices */
	const double *corner_weight;
	const double *target, *normal, *point;
	double weight;
};
/* The i-th of view_equations(); false when it says nothing. */
static inline size_t view_equations(const struct view *view) { return view->sample_count + view->spot_count + view->tip_count; }
bool view_equation(struct equation *equation, const struct view *view, const struct judge *judge, double total_area, size_t i);

/* The whole surface under judgement, with the subdivision operator: equations over all vertices. */
struct whole {
	struct view view;
	struct sparse operator; /* rows: fine vertices; columns: vertices of the part */
	idx_t *face, *sample;   /* all of them */
};
#define ROW_LIMIT 256
void whole_open(struct whole *whole, const struct judge *judge, const struct sketch *sketch);
void whole_free(struct whole *whole);
/* Coefficients of the vertices of the sketch in an equation; returns their number, at most ROW_LIMIT, 0 when there are more. */
size_t whole_row(idx_t *index, double *coefficient, const struct whole *whole, const struct equation *equation);

#define REFIT_TANGENTIAL 0.003 /* weight of the distance along the tangent plane: weak, so that the surface may slide */

#endif
