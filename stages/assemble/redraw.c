/* Edges drawn elsewhere: one change at a time, judged by the surface that comes of it. */
#include "stages/assemble/redraw.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/assemble/change.h"
#include "stages/geometry/nearest.h"
#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"

/* Folds of less than this share of the plot's area are none: numbers are not exact. */
static const double no_fold = 1e-7;
/* A change must take this share of the folds that it touches; what leaves less than the second share has done it. */
static const double least_gain = 0.1, nearly_all = 0.02;
/* New points, which cost more, must leave less than this share. */
static const double most_left = 0.4;
/* Steps of subdivision that are enough to choose among many changes, and how many of them get a second look. */
enum { ROUGH_STEPS = 3, SECOND_LOOKS = 8 };
/* Larger polygons are cut from their kept vertices only. */
enum { MOST_FREE_CORNERS = 14 };
/* The new point of an edge is joined to no corner of a polygon larger than this. */
enum { MOST_SPLIT_CORNERS = 8 };
/* Faces refined for all plots together. */
static const size_t most_work = 40000000;

static int compare_pairs(const void *a, const void *b)
{
	const idx_t *x = a, *y = b;
	if (x[0] != y[0])
		return x[0] < y[0] ? -1 : 1;
	return (x[1] > y[1]) - (x[1] < y[1]);
}

void edge_list_make(struct edge_list *edges, const struct cage *cage)
{
	const size_t n = cage->face_start[cage->face_count];
	*edges = (struct edge_list){.pair = mem_array(2 * n, sizeof *edges->pair), .room = n};
	for (size_t f = 0; f < cage->face_count; f++)
		for (size_t h = cage->face_start[f]; h < cage->face_start[f + 1]; h++) {
			const idx_t a = cage->face_corner[h], b = cage->face_corner[h + 1 < cage->face_start[f + 1] ? h + 1 : cage->face_start[f]];
			edges->pair[2 * h] = a < b ? a : b, edges->pair[2 * h + 1] = a < b ? b : a;
		}
	qsort(edges->pair, n, 2 * sizeof *edges->pair, compare_pairs);
	edges->count = edges->sorted = n;
}

void edge_list_free(struct edge_list *edges)
{
	free(edges->pair);
	*edges = (struct edge_list){0};
}

static bool edge_list_has(const struct edge_list *edges, idx_t a, idx_t b)
{
	const idx_t pair[2] = {a < b ? a : b, a < b ? b : a};
	if (bsearch(pair, edges->pair, edges->sorted, sizeof pair, compare_pairs))
		return true;
	for (size_t i = edges->sorted; i < edges->count; i++)
		if (edges->pair[2 * i] == pair[0] && edges->pair[2 * i + 1] == pair[1])
			return true;
	return false;
}

static void edge_list_add(struct edge_list *edges, idx_t a, idx_t b)
{
	if (edges->count == edges->room)
		edges->pair = mem_resize(edges->pair, 2 * (edges->room += edges->room / 2 + 16), sizeof *edges->pair);
	edges->pair[2 * edges->count] = a < b ? a : b, edges->pair[2 * edges->count++ + 1] = a < b ? b : a;
}

static int compare_changes(const void *a, const void *b)
{
	const struct change *x = a, *y = b;
	if (x->rough != y->rough)
		return x->rough < y->rough ? -1 : 1;
	if (x->cost != y->cost)
		return x->cost < y->cost ? -1 : 1;
	const idx_t p[8] = {(idx_t)x->way, x->one, x->two, x->a, x->b, x->c, x->d, x->crease}, q[8] = {(idx_t)y->way, y->one, y->two, y->a, y->b, y->c, y->d, y->crease};
	for (int k = 0; k < 8; k++)
		if (p[k] != q[k])
			return p[k] < q[k] ? -1 : 1;
	return 0;
}

struct changes {
	struct change *item;
	size_t count, room;
};

static void changes_add(struct changes *changes, struct change change)
{
	if (changes->count == changes->room)
		changes->item = mem_resize(changes->item, changes->room += changes->room / 2 + 32, sizeof *changes->item);
	changes->item[changes->count++] = change;
}

static double up_area(const struct plot *plot, idx_t a, idx_t b, idx_t c)
{
	double doubled[3];
	area_vector3(doubled, plot->points->xyz + 3 * (size_t)a, plot->points->xyz + 3 * (size_t)b, plot->points->xyz + 3 * (size_t)c);
	if (!plot->bent)
		return dot3(doubled, plot->normal);
	double normal[3];
	primitive_foot(plot->bent, plot->points->xyz + 3 * (size_t)a, NULL, normal);
	return dot3(doubled, normal);
}

/* Does the way from corner i to corner j of p lie in it, as far as the corners say? */
static bool is_inside(const struct plot *plot, const struct polygon *p, size_t i, size_t j)
{
	const size_t ends[2] = {i, j};
	for (int k = 0; k < 2; k++) { /* between the two edges there */
		const size_t at = ends[k];
		const idx_t v = p->corner[at], to = p->corner[ends[1 - k]], next = p->corner[polygon_after(p, at)], previous = p->corner[at > 0 ? at - 1 : p->count - 1];
		const bool left = up_area(plot, v, next, to) > 0, right = up_area(plot, v, to, previous) > 0;
		if (up_area(plot, v, next, previous) > 0 ? !left || !right : !left && !right)
			return false;
	}
	const idx_t a = p->corner[i], b = p->corner[j];
	for (size_t k = 0; k < p->count; k++) {
		const size_t l = polygon_after(p, k);
		if (k == i || k == j || l == i || l == j)
			continue;
		const idx_t c = p->corner[k], d = p->corner[l];
		if ((up_area(plot, a, b, c) > 0) != (up_area(plot, a, b, d) > 0) && (up_area(plot, c, d, a) > 0) != (up_area(plot, c, d, b) > 0))
			return false;
	}
	return true;
}

/* A state of the search. */
struct search {
	struct plot *plot;
	struct edge_list *edges;
	double shift;           /* fixed polygons, and bent plots, may move by this */
	int steps;
};

/* May a crease end here without a change to what lies around? */
static bool may_end(const struct search *search, idx_t v)
{
	return plot_is_kept(search->plot, v) || (search->plot->points->creases[v] == 0 && !search->plot->points->open[v]);
}

/* Edges at an inner vertex must stay three. */
static size_t edges_at(const struct plot *plot, idx_t v)
{
	size_t count = 0;
	for (size_t i = 0; i < plot->count; i++)
		count += polygon_find(&plot->polygon[i], v) < plot->polygon[i].count;
	return count;
}

/* All chords of p, which is polygon one, or one and two united. */
static void list_chords(struct changes *changes, const struct search *search, const struct polygon *p, idx_t one, idx_t two, const idx_t old[2])
{
	const double cost = two == NO_INDEX ? 1 : 0;
	for (size_t i = 0; i < p->count; i++)
		for (size_t j = i + 2; j < p->count; j++) {
			const idx_t a = p->corner[i], b = p->corner[j];
			if (i == 0 && j + 1 == p->count)
				continue;
			if (p->count > MOST_FREE_CORNERS && !plot_is_kept(search->plot, a) && !plot_is_kept(search->plot, b))
				continue;
			const bool same = old && ((a == old[0] && b == old[1]) || (a == old[1] && b == old[0]));
			if (same || edge_list_has(search->edges, a, b) || !is_inside(search->plot, p, i, j))
				continue;
			changes_add(changes, (struct change){WAY_CHORD, one, two, a, b, 0, 0, 0, cost, 0});
			if (may_end(search, a) && may_end(search, b))
				changes_add(changes, (struct change){WAY_CHORD, one, two, a, b, 0, 0, 1, cost + 0.3, 0});
		}
}

/* Polygon beside edge k of polygon i, or NO_INDEX. */
static idx_t beside(const struct plot *plot, size_t i, size_t k)
{
	const struct polygon *p = &plot->polygon[i];
	const idx_t a = p->corner[k], b = p->corner[polygon_after(p, k)];
	for (size_t j = 0; j < plot->count; j++) {
		const struct polygon *q = &plot->polygon[j];
		const size_t at = j == i ? q->count : polygon_find(q, b);
		if (at < q->count && q->corner[polygon_after(q, at)] == a)
			return (idx_t)j;
	}
	return NO_INDEX;
}

/* What can be done about polygon i: at its edges, and in it. */
static void list_changes(struct changes *changes, const struct search *search, size_t i)
{
	const struct plot *plot = search->plot;
	const struct polygon *p = &plot->polygon[i];
	if (!plot->bent)
		list_chords(changes, search, p, (idx_t)i, NO_INDEX, NULL);
	for (size_t k = 0; k < p->count; k++) {
		const idx_t j = p->crease[k] ? NO_INDEX : beside(plot, i, k);
		if (j == NO_INDEX || plot->polygon[j].fixed)
			continue;
		const idx_t end[2] = {p->corner[k], p->corner[polygon_after(p, k)]};
		if (may_end(search, end[0]) && may_end(search, end[1]))
			changes_add(changes, (struct change){WAY_CHORD, (idx_t)i, j, end[0], end[1], 0, 0, 1, 0.3, 0});
		if (!plot->bent)
			list_chords(changes, search, &plot->polygon[j], j, NO_INDEX, NULL);
		struct polygon both;
		if (!polygon_unite(&both, p, &plot->polygon[j]))
			continue;
		bool stays = true;
		for (int e = 0; e < 2; e++)
			stays &= plot->points->creases[end[e]] >= 2 || edges_at(plot, end[e]) > 3;
		if (stays) {
			if (!plot->bent)
				changes_add(changes, (struct change){WAY_CHORD, (idx_t)i, j, NO_INDEX, NO_INDEX, 0, 0, 0, -1, 0});
			list_chords(changes, search, &both, (idx_t)i, j, end);
		}
		polygon_free(&both);
	}
}

/* New points for what no other change helps with: polygon i, and its edges. */
static void list_points(struct changes *changes, const struct search *search, size_t i)
{
	struct plot *plot = search->plot;
	const struct polygon *p = &plot->polygon[i];
	const size_t points = plot->points->count;
	double at[3];
	if (points == plot->points->room)
		return;
	if (p->count <= CHANGE_MOST_CENTRE && !plot->bent) {
		changes_add(changes, (struct change){WAY_CENTRE, (idx_t)i, NO_INDEX, NO_INDEX, NO_INDEX, 0, 0, 0, 3 + (double)p->count, 0});
		for (size_t k = 0; k < p->count; k++)
			if (plot_is_kept(plot, p->corner[k]))
				changes_add(changes, (struct change){WAY_CENTRE, (idx_t)i, NO_INDEX, p->corner[k], NO_INDEX, 0, 0, 1, 3.3 + (double)p->count, 0});
	}
	for (size_t k = 0; k < p->count; k++) {
		const idx_t j = p->crease[k] ? NO_INDEX : beside(plot, i, k);
		if (j == NO_INDEX || plot->polygon[j].fixed)
			continue;
		const struct polygon *q = &plot->polygon[j];
		const idx_t a = p->corner[k], b = p->corner[polygon_after(p, k)];
		for (int c = 0; c < 3; c++)
			at[c] = (plot->points->xyz[3 * (size_t)a + (size_t)c] + plot->points->xyz[3 * (size_t)b + (size_t)c]) / 2;
		const idx_t m = plot_new_point(plot, at);
		struct polygon one, two;
		polygon_with(&one, p, k, m);
		polygon_with(&two, q, polygon_find(q, b), m);
		/* c and d from "none" on; one of them must be joined, or the point would have two edges */
		for (size_t c = 0; c <= one.count; c++) {
			if (c < one.count && (p->count > MOST_SPLIT_CORNERS || one.corner[c] == m || one.corner[c] == a || one.corner[c] == b ||
					      !is_inside(plot, &one, polygon_find(&one, m), c)))
				continue;
			for (size_t d = 0; d <= two.count; d++) {
				if ((c == one.count && d == two.count) ||
				    (d < two.count && (q->count > MOST_SPLIT_CORNERS || two.corner[d] == m || two.corner[d] == a || two.corner[d] == b ||
						       !is_inside(plot, &two, polygon_find(&two, m), d))))
					continue;
				const double cost = 3 + (c < one.count) + (d < two.count);
				struct change change = {WAY_SPLIT, (idx_t)i, j, a, b, c < one.count ? one.corner[c] : NO_INDEX, d < two.count ? two.corner[d] : NO_INDEX, 0, cost, 0};
				if (!plot->bent)
					changes_add(changes, change);
				change.crease = 1, change.cost += 0.3;
				if (plot_is_kept(plot, a))
					changes_add(changes, change);
				struct change back = {WAY_SPLIT, j, (idx_t)i, b, a, change.d, change.c, 1, change.cost, 0};
				if (plot_is_kept(plot, b))
					changes_add(changes, back);
			}
		}
		polygon_free(&one), polygon_free(&two);
		plot->points->count = points;
	}
}

/* Do the fixed polygons near a change that was done stay where they were? */
static bool keeps_fixed(struct search *search, const struct change *change, struct undo *undo)
{
	struct plot *plot = search->plot;
	idx_t core[CHANGE_MOST_CORE];
	size_t count, old_count;
	double *at = plot_surface(&count, plot, core, change_made(core, plot, undo, change), true, ROUGH_STEPS);
	if (!at)
		return true;
	change_take_back(undo, plot, change);
	double *old = plot_surface(&old_count, plot, core, change->two == NO_INDEX ? 1 : 2, true, ROUGH_STEPS), most = 0;
	change_apply(undo, plot, change);
	for (size_t i = 0; i < 3 * count && count == old_count; i++)
		most = fmax(most, distance3(at + 3 * i, old + 3 * i));
	free(at), free(old);
	return count == old_count && most <= search->shift;
}

/* Does a bent plot lie where it was before a change that was done? What was folded may go. */
static bool keeps_shape(struct search *search, const struct change *change, struct undo *undo)
{
	struct plot *plot = search->plot;
	if (!plot->bent)
		return true;
	idx_t core[CHANGE_MOST_CORE];
	size_t count, old_count;
	double *at = plot_surface(&count, plot, core, change_made(core, plot, undo, change), false, ROUGH_STEPS);
	change_take_back(undo, plot, change);
	double *old = plot_surface(&old_count, plot, core, change->two == NO_INDEX ? 1 : 2, false, ROUGH_STEPS);
	change_apply(undo, plot, change);
	bool good = at && old;
	if (good) {
		idx_t *triangle = mem_array(3 * old_count, sizeof *triangle), *label = mem_array(old_count, sizeof *label);
		for (size_t i = 0; i < 3 * old_count; i++)
			triangle[i] = (idx_t)i;
		struct nearest *nearest = nearest_new_labelled(old, 3 * old_count, triangle, old_count, label);
		const struct nearest_filter own = {.label = label};
		for (size_t i = 0; i < 3 * count && good; i++)
			good = nearest_point(nearest, at + 3 * i, INFINITY, &own).distance <= search->shift;
		nearest_free(nearest);
		free(triangle), free(label);
	}
	free(at), free(old);
	return good;
}

/* Folded area near a change before and after it, INFINITY when check finds that it moves what must stay; take it back unless it is to stay. */
static void try_change(double *was, double *is, struct search *search, const struct change *change, int steps, bool check, bool stay)
{
	struct plot *plot = search->plot;
	struct undo undo;
	*was = 0, *is = INFINITY;
	if (!change_apply(&undo, plot, change))
		return;
	idx_t core[CHANGE_MOST_CORE], *touched;
	double *folded;
	size_t touched_count;
	*is = plot_fold(&folded, &touched, &touched_count, plot, core, change_made(core, plot, &undo, change), steps);
	for (size_t i = 0; i < touched_count; i++)
		if (touched[i] != change->one && touched[i] != change->two && (size_t)touched[i] < undo.count)
			*was += plot->polygon[touched[i]].folded;
	*was += undo.one.folded + undo.two.folded;
	if (check && isfinite(*is) && !(keeps_fixed(search, change, &undo) && keeps_shape(search, change, &undo)))
		*is = INFINITY;
	if (!stay) {
		change_take_back(&undo, plot, change);
	} else {
		for (size_t i = 0; i < touched_count; i++)
			plot->polygon[touched[i]].folded = folded[i];
		polygon_free(&undo.one), polygon_free(&undo.two);
	}
	free(folded), free(touched);
}

/* The change that is worth most to polygon i, of those listed; false when none is. */
static bool find_best(struct change *best, struct search *search, struct changes *changes, size_t i)
{
	double was, is, best_score = 0;
	bool found = false;
	for (size_t c = 0; c < changes->count && *search->plot->work < most_work; c++) {
		try_change(&was, &is, search, &changes->item[c], ROUGH_STEPS, false, false);
		changes->item[c].rough = is - was;
	}
	if (changes->count > 0)
		qsort(changes->item, changes->count, sizeof *changes->item, compare_changes);
	for (size_t c = 0; c < changes->count && c < SECOND_LOOKS; c++) {
		try_change(&was, &is, search, &changes->item[c], search->steps, true, false);
		const double own = search->plot->polygon[i].folded;
		if (!(was - is > least_gain * own) || (changes->item[c].way != WAY_CHORD && !(is < most_left * was)))
			continue;
		/* all that reach the goal are equal but for their cost */
		const double left = fmax(0, is - nearly_all * was), score = (was - is) - left - 1e-3 * own * changes->item[c].cost;
		if (!found || score > best_score)
			*best = changes->item[c], best_score = score, found = true;
	}
	return found;
}

/* Improve on polygon i; false when nothing helps. New points only where nothing else does. */
static bool improve(struct unfold_report *report, struct search *search, size_t i)
{
	struct changes changes = {0};
	struct change best;
	list_changes(&changes, search, i);
	bool found = find_best(&best, search, &changes, i);
	if (!found) {
		changes.count = 0;
		list_points(&changes, search, i);
		found = find_best(&best, search, &changes, i);
	}
	free(changes.item);
	if (!found)
		return false;
	double was, is;
	const size_t before = search->plot->count;
	try_change(&was, &is, search, &best, search->steps, false, true);
	const struct plot *plot = search->plot;
	if (best.way == WAY_CHORD && best.a != NO_INDEX)
		edge_list_add(search->edges, best.a, best.b);
	for (size_t k = 0; best.way != WAY_CHORD && k < 2 + plot->count - before; k++) {
		const idx_t at = k == 0 ? best.one : k == 1 ? best.two : (idx_t)(before + k - 2);
		if (at == NO_INDEX)
			continue;
		const struct polygon *p = &plot->polygon[at];
		const size_t here = polygon_find(p, (idx_t)plot->points->count - 1);
		if (here < p->count)
			edge_list_add(search->edges, p->corner[here], p->corner[polygon_after(p, here)]);
	}
	report->creased += best.crease;
	report->redrawn += !best.crease && best.way == WAY_CHORD;
	return true;
}

bool redraw(struct unfold_report *report, struct plot *plot, struct edge_list *edges, double shift, int steps)
{
	struct search search = {plot, edges, shift, steps};
	idx_t *all = mem_array(plot->count, sizeof *all), *touched;
	double *folded, area = 0;
	size_t touched_count;
	for (size_t i = 0; i < plot->count; i++)
		all[i] = (idx_t)i;
	plot_fold(&folded, &touched, &touched_count, plot, all, plot->count, steps);
	for (size_t i = 0; i < touched_count; i++)
		plot->polygon[touched[i]].folded = folded[i];
	free(all), free(folded), free(touched);
	for (size_t i = 0; i < plot->count; i++) {
		const struct polygon *p = &plot->polygon[i];
		for (size_t k = 1; k + 1 < p->count && !p->fixed; k++)
			area += up_area(plot, p->corner[0], p->corner[k], p->corner[k + 1]) / 2;
	}
	const double limit = no_fold * fabs(area);
	for (size_t i = 0; i < plot->count; i++)
		report->folded += plot->polygon[i].folded > limit, report->before += plot->polygon[i].folded;
	bool changed = false;
	size_t hopeless_room = plot->count;
	unsigned char *hopeless = mem_array(hopeless_room, 1);
	while (*plot->work < most_work) {
		size_t worst = plot->count;
		for (size_t i = 0; i < plot->count; i++)
			if (plot->polygon[i].folded > limit && !hopeless[i] && !plot->polygon[i].fixed &&
			    (worst == plot->count || plot->polygon[i].folded > plot->polygon[worst].folded))
				worst = i;
		if (worst == plot->count)
			break;
		if (improve(report, &search, worst)) {
			changed = true;
			if (plot->count > hopeless_room)
				hopeless = mem_resize(hopeless, hopeless_room = 2 * plot->count, 1);
			memset(hopeless, 0, hopeless_room);
		} else {
			hopeless[worst] = 1;
		}
	}
	for (size_t i = 0; i < plot->count; i++)
		report->left += plot->polygon[i].folded > limit, report->after += plot->polygon[i].folded;
	free(hopeless);
	return changed;
}
