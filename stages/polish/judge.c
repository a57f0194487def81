#include "stages/polish/judge.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/sample.h"
#include "stages/geometry/trimesh.h"
#include "stages/geometry/vector.h"

#define TURNED_COST 0.02     /* longest sides: a thousandth of the area turned costs as much as 2e-5 of mean distance */
#define FOLDED_COST 1.0      /* nobody wants a fold, however small: a ten-thousandth of the area is dear */
#define OVER_COST 20         /* slope above the largest distance wanted */
#define LIMIT_COST 300       /* and above the limit: one sample in some thousands must weigh more than many bits */
#define GROUP 16             /* samples that search the surface together */
#define LEAST_COSINE (-0.2)  /* feet on triangles that look the other way are penalised */

double judge_cost(const struct judge *judge, double d, bool is_turned)
{
	return d + d * d / judge->max + OVER_COST * fmax(0, d - judge->max) + LIMIT_COST * fmax(0, d - judge->limit) + (is_turned ? TURNED_COST : 0);
}

double judge_slope(const struct judge *judge, double d)
{
	return 1 + 2 * d / judge->max + (d > judge->max ? OVER_COST : 0) + (d > judge->limit ? LIMIT_COST : 0);
}

/* --- target ---------------------------------------------------------------------------------------------------------------- */

struct dense_side {
	idx_t a, b, triangle;
};
static int compare_sides(const void *x, const void *y)
{
	const struct dense_side *s = x, *t = y;
	if (s->a != t->a)
		return s->a < t->a ? -1 : 1;
	if (s->b != t->b)
		return s->b < t->b ? -1 : 1;
	return (s->triangle > t->triangle) - (s->triangle < t->triangle);
}

static void triangle_normal(double n[3], const struct target *t, idx_t triangle)
{
	const idx_t *c = &t->triangle[3 * (size_t)triangle];
	area_vector3(n, &t->xyz[3 * (size_t)c[0]], &t->xyz[3 * (size_t)c[1]], &t->xyz[3 * (size_t)c[2]]);
	normalise3(n);
}

/* Ends of sharp edges and their middles, thinned to `most`. */
static void sample_sharp(struct target *t, size_t most, double sharp_deg)
{
	struct dense_side *side = mem_array(3 * t->triangle_count, sizeof *side);
	for (size_t h = 0; h < 3 * t->triangle_count; h++) {
		const idx_t a = t->triangle[h], b = t->triangle[h % 3 == 2 ? h - 2 : h + 1];
		side[h] = (struct dense_side){a < b ? a : b, a < b ? b : a, (idx_t)(h / 3)};
	}
	qsort(side, 3 * t->triangle_count, sizeof *side, compare_sides);
	size_t sharp = 0;
	for (size_t i = 0; i + 1 < 3 * t->triangle_count; i++) {
		if (side[i].a != side[i + 1].a || side[i].b != side[i + 1].b)
			continue;
		double n[3], m[3];
		triangle_normal(n, t, side[i].triangle), triangle_normal(m, t, side[i + 1].triangle);
		if (norm3(n) > 0.5 && norm3(m) > 0.5 && angle3(n, m) * DEGREES > sharp_deg)
			side[sharp++] = side[i];
	}
	const size_t stride = sharp / (most / 2 + 1) + 1;
	for (size_t i = 0; i < sharp; i += stride) {
		double n[3];
		triangle_normal(n, t, side[i].triangle);
		for (int j = 0; j < 2; j++) {
			double *p = &t->point[3 * t->count];
			for (int k = 0; k < 3; k++) {
				const double a = t->xyz[3 * (size_t)side[i].a + k], b = t->xyz[3 * (size_t)side[i].b + k];
				p[k] = j ? (a + b) / 2 : a;
			}
			copy3(&t->normal[3 * t->count++], n);
		}
	}
	free(side);
}

/* Neighbours in space one after the other: along a Z-order curve. */
struct place {
	uint64_t code;
	size_t sample;
};
static int compare_places(const void *a, const void *b)
{
	const struct place *p = a, *q = b;
	if (p->code != q->code)
		return p->code < q->code ? -1 : 1;
	return (p->sample > q->sample) - (p->sample < q->sample);
}

static void sort_samples(struct target *t)
{
	struct place *place = mem_array(t->area_count, sizeof *place);
	for (size_t i = 0; i < t->area_count; i++) {
		place[i].sample = i;
		for (int bit = 9; bit >= 0; bit--)
			for (int k = 0; k < 3; k++) {
				const double x = fmin(fmax(t->point[3 * i + k] + 0.5, 0), 0.999999);
				place[i].code = place[i].code << 1 | ((uint64_t)(x * 1024) >> bit & 1);
			}
	}
	qsort(place, t->area_count, sizeof *place, compare_places);
	double *point = mem_copy(t->point, 3 * t->area_count, sizeof *point), *normal = mem_copy(t->normal, 3 * t->area_count, sizeof *normal);
	for (size_t i = 0; i < t->area_count; i++) {
		copy3(&t->point[3 * i], &point[3 * place[i].sample]);
		copy3(&t->normal[3 * i], &normal[3 * place[i].sample]);
	}
	free(place), free(point), free(normal);
}

static void take_samples(struct target *t, size_t samples, size_t sharp_samples, double sharp_deg)
{
	t->area_count = t->count = samples;
	t->point = mem_array(3 * (samples + sharp_samples + 4), sizeof *t->point);
	t->normal = mem_array(3 * (samples + sharp_samples + 4), sizeof *t->normal);
	idx_t *on = mem_array(samples, sizeof *on);
	t->area = sample_surface(t->point, on, samples, t->xyz, t->triangle, t->triangle_count, 1);
	for (size_t i = 0; i < samples; i++)
		triangle_normal(&t->normal[3 * i], t, on[i]);
	free(on);
	sort_samples(t);
	sample_sharp(t, sharp_samples, sharp_deg);
}

void target_start(struct target *t, const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count, size_t samples,
                  size_t sharp_samples, double sharp_deg)
{
	*t = (struct target){.vertex_count = vertex_count, .triangle_count = triangle_count};
	t->xyz = mem_copy(xyz, 3 * vertex_count, sizeof *xyz);
	t->triangle = mem_copy(triangle, 3 * triangle_count, sizeof *triangle);
	t->nearest = nearest_new(t->xyz, vertex_count, t->triangle, triangle_count);
	take_samples(t, samples, sharp_samples, sharp_deg);
}

void target_resample(struct target *t, const struct target *base, size_t samples, size_t sharp_samples, double sharp_deg)
{
	*t = *base;
	t->is_borrowed = true;
	take_samples(t, samples, sharp_samples, sharp_deg);
}

void target_free(struct target *t)
{
	if (!t->is_borrowed) {
		nearest_free(t->nearest);
		free(t->xyz), free(t->triangle);
	}
	free(t->point), free(t->normal);
	*t = (struct target){0};
}

/* --- one part of a surface --------------------------------------------------------------------------------------------------- */

/* Where the cage's vertices and the quarters of its creases come to lie the surface has its peaks: they stick out farther than any middle
 * of a face. */
static void add_tip(struct view *view, unsigned char *seen, idx_t fine, idx_t vertex)
{
	if (!seen[fine])
		view->tip[view->tip_count++] = (struct tip){.corner = {fine, fine, fine}, .vertex = vertex, .foot.triangle = NO_INDEX};
	seen[fine] = 1;
}

static void list_tips(struct view *view, const struct judge *judge)
{
	const struct skin *skin = &view->skin;
	unsigned char *seen = mem_array(skin->fine.vertex_count, 1);
	view->tip = mem_array(skin->fine.vertex_count, sizeof *view->tip);
	for (size_t r = 0, h = 0; r < skin->root_count; r++)
		for (size_t k = 0; h < skin->part.face_start[r + 1]; h++, k++) {
			const idx_t vertex = skin->part.face_corner[h];
			add_tip(view, seen, vertex, vertex);
			idx_t side[3];
			skin_side(side, skin, r, k, skin->part.face_start[r + 1] - skin->part.face_start[r]);
			for (int i = 0; skin->part.sharp[h] && i < 3; i++)
				add_tip(view, seen, side[i], vertex);
		}
	const size_t fine_faces = skin->first[skin->root_count] << (2 * (skin->steps - 1));
	if (judge->peaks == PEAKS_ALL)
		for (size_t h = 0; h < skin->fine.face_start[fine_faces]; h++)
			add_tip(view, seen, skin->fine.face_corner[h], skin->part.face_corner[0]);
	/* the first corner of a child is one of its parent's, but for the middle one of a triangle */
	for (size_t f = 0; judge->peaks == PEAKS_SOME && f < fine_faces; f++)
		if (f % 4 < 3 || skin->fine.face_start[f + 1] - skin->fine.face_start[f] == 4)
			add_tip(view, seen, skin->fine.face_corner[skin->fine.face_start[f]], skin->part.face_corner[0]);
	free(seen);
}

static double tip_cost(const struct judge *judge, const struct tip *tip)
{
	return TIP_WEIGHT * fmax(0, judge_cost(judge, tip->foot.distance, false) - judge_cost(judge, judge->max, false));
}

/* A point that has hardly moved: its foot stays on the same triangle. */
static void follow_foot(struct foot *foot, const struct target *t, const double p[3])
{
	const idx_t *c = &t->triangle[3 * (size_t)foot->triangle];
	foot->distance = nearest_on_triangle(foot->point, foot->weight, p, &t->xyz[3 * (size_t)c[0]], &t->xyz[3 * (size_t)c[1]], &t->xyz[3 * (size_t)c[2]]);
}

static void measure_tips(struct view *view, const struct judge *judge)
{
	view->tip_sum = view->tip_worst = 0;
	for (size_t i = 0; i < view->tip_count; i++) {
		struct tip *tip = &view->tip[i];
		const double *p = &view->skin.fine.xyz[3 * (size_t)tip->corner[0]];
		const struct nearest_filter filter = {.hint = 1 + tip->foot.triangle};
		if (tip->foot.triangle != NO_INDEX && view->skin.shift[tip->corner[0]] < SKIN_HARDLY)
			follow_foot(&tip->foot, judge->target, p);
		else
			tip->foot = nearest_point(judge->target->nearest, p, INFINITY, &filter);
		view->tip_worst = fmax(view->tip_worst, tip->foot.distance);
		view->tip_sum += tip_cost(judge, tip);
	}
}

/* Which spots of a root look away from the quarter that they lie in, or with it from the whole root: they are folded over as a whole. What
 * spans less than 180 degrees is never taken for a fold. */
static void find_folds(struct skin_spot *spot, size_t count, int steps)
{
	const size_t quarter = steps == 3 ? 4 : 1;
	double whole[3] = {0};
	for (size_t i = 0; i < count; i++)
		add_scaled3(whole, spot[i].area, spot[i].normal);
	for (size_t from = 0; from < count; from += quarter) {
		double part[3] = {0};
		for (size_t i = from; i < from + quarter; i++)
			add_scaled3(part, spot[i].area, spot[i].normal);
		const bool is_part_folded = dot3(part, whole) < 0;
		for (size_t i = from; i < from + quarter; i++)
			if (is_part_folded || dot3(spot[i].normal, part) < 0)
				spot[i].folded = spot[i].area;
	}
}

void view_move(struct view *view, const struct judge *judge, const struct sketch *sketch)
{
	const struct target *t = judge->target;
	if (sketch)
		skin_move(&view->skin, sketch);
	view->sample_sum = view->spot_sum = view->spot_area = 0;
	*judge->work += view->sample_count + 2 * view->spot_count + view->tip_count;
	struct skin_order order = {0};
	for (size_t first = 0; first < view->sample_count; first += GROUP) {
		const size_t end = first + GROUP < view->sample_count ? first + GROUP : view->sample_count;
		float box[6] = {FLT_MAX, FLT_MAX, FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};
		for (size_t i = first; i < end; i++)
			for (int k = 0; k < 3; k++) {
				const float x = (float)t->point[3 * (size_t)view->sample[i] + k];
				box[k] = fminf(box[k], x), box[3 + k] = fmaxf(box[3 + k], x);
			}
		skin_order(&order, &view->skin, box);
		for (size_t i = first; i < end; i++) {
			const size_t s = (size_t)view->sample[i];
			const double *p = &t->point[3 * s], *n = &t->normal[3 * s];
			view->foot[i] = sketch ? skin_follow(&view->skin, &order, p, n, &view->foot[i])
			                       : skin_nearest(&view->skin, &order, p, n, i > first ? view->foot[i - 1].fine : NO_INDEX);
			const double cost = judge_cost(judge, view->foot[i].measure, view->foot[i].is_turned);
			view->sample_sum += s < t->area_count ? cost : fmax(0, cost - judge_cost(judge, judge->max, false));
		}
	}
	skin_order_free(&order);
	idx_t near = 0;
	size_t n = 0;
	for (size_t r = 0; r < view->skin.root_count; r++) {
		const size_t count = skin_spot_count(&view->skin, r);
		for (size_t i = 0; i < count; i++) {
			copy3(view->spot_before[n + i], view->spot[n + i].point);
			skin_spot(&view->spot[n + i], &view->skin, r, i);
		}
		find_folds(&view->spot[n], count, view->skin.steps);
		for (size_t i = 0; i < count; i++, n++) {
			struct skin_spot *spot = &view->spot[n];
			view->spot_root[n] = (idx_t)r;
			const struct nearest_filter filter = {.normal = spot->normal, .least_dot = LEAST_COSINE, .reach = 1, .slack = SKIN_PENALTY,
			                                      .hint = sketch && view->spot_foot[n].triangle != NO_INDEX ? 1 + view->spot_foot[n].triangle : near};
			if (sketch && distance3(view->spot_before[n], spot->point) < (double)SKIN_HARDLY && view->spot_foot[n].triangle != NO_INDEX)
				follow_foot(&view->spot_foot[n], t, spot->point);
			else
				view->spot_foot[n] = nearest_point(t->nearest, spot->point, INFINITY, &filter);
			const struct foot *foot = &view->spot_foot[n];
			near = 1 + foot->triangle;
			const bool is_turned = dot3(foot->normal, spot->normal) < LEAST_COSINE;
			view->spot_cost[n] = judge_cost(judge, foot->distance + (is_turned ? SKIN_PENALTY : 0), is_turned) +
			                     FOLDED_COST * spot->folded / fmax(spot->area, 1e-30);
			view->spot_sum += spot->area * view->spot_cost[n];
			view->spot_area += spot->area;
		}
	}
	measure_tips(view, judge);
}

void view_open(struct view *view, const struct judge *judge, const struct sketch *sketch, const idx_t *face, size_t face_count,
               const idx_t *sample, size_t sample_count)
{
	*view = (struct view){.sample = sample, .sample_count = sample_count};
	skin_build(&view->skin, sketch, face, face_count, judge->steps);
	for (size_t r = 0; r < view->skin.root_count; r++)
		view->spot_count += skin_spot_count(&view->skin, r);
	view->foot = mem_array(sample_count, sizeof *view->foot);
	view->spot = mem_array(view->spot_count, sizeof *view->spot);
	view->spot_foot = mem_array(view->spot_count, sizeof *view->spot_foot);
	view->spot_root = mem_array(view->spot_count, sizeof *view->spot_root);
	view->spot_before = mem_array(view->spot_count, sizeof *view->spot_before);
	view->spot_cost = mem_array(view->spot_count, sizeof *view->spot_cost);
	list_tips(view, judge);
	view_move(view, judge, NULL);
}

void view_free(struct view *view)
{
	skin_free(&view->skin);
	free(view->foot), free(view->spot), free(view->spot_foot), free(view->spot_root), free(view->spot_before), free(view->spot_cost), free(view->tip);
	*view = (struct view){0};
}

/* --- the whole ---------------------------------------------------------------------------------------------------------------- */

void errors_free(struct errors *errors)
{
	free(errors->sample), free(errors->tip), free(errors->tip_worst), free(errors->face), free(errors->face_first), free(errors->face_sample);
	*errors = (struct errors){0};
}

static void list_samples(struct errors *errors, size_t samples, size_t faces)
{
	errors->face_first = mem_array(faces + 2, sizeof *errors->face_first);
	errors->face_sample = mem_array(samples, sizeof *errors->face_sample);
	size_t *first = errors->face_first;
	for (size_t i = 0; i < samples; i++)
		first[errors->sample[i].face + 2]++;
	for (size_t f = 0; f < faces; f++)
		first[f + 2] += first[f + 1];
	for (size_t i = 0; i < samples; i++)
		errors->face_sample[first[errors->sample[i].face + 1]++] = (idx_t)i;
}

/* What a view knows of its samples, faces and vertices. */
static void take_view(struct errors *errors, const struct judge *judge, const struct view *view)
{
	const struct target *t = judge->target;
	for (size_t i = 0; i < view->sample_count; i++) {
		const struct skin_foot *foot = &view->foot[i];
		double cost = judge_cost(judge, foot->measure, foot->is_turned);
		if ((size_t)view->sample[i] >= t->area_count)
			cost = fmax(0, cost - judge_cost(judge, judge->max, false));
		errors->sample[view->sample[i]] = (struct sample_error){view->skin.face[foot->root], (float)cost, (float)foot->distance, foot->is_turned};
	}
	for (size_t r = 0; r < view->skin.root_count; r++)
		errors->face[view->skin.face[r]] = (struct face_error){0};
	for (size_t n = 0; n < view->spot_count; n++) {
		const struct skin_spot *spot = &view->spot[n];
		const struct foot *foot = &view->spot_foot[n];
		struct face_error *e = &errors->face[view->skin.face[view->spot_root[n]]];
		e->area += spot->area, e->cost += spot->area * view->spot_cost[n], e->distance += spot->area * foot->distance;
		e->worst = fmax(e->worst, foot->distance);
		e->folded += spot->folded;
		e->turned += dot3(foot->normal, spot->normal) < LEAST_COSINE ? spot->area : spot->folded;
	}
	for (size_t i = 0; i < view->tip_count; i++) {
		const idx_t v = view->skin.part_vertex[view->tip[i].vertex];
		errors->tip[v] += (float)tip_cost(judge, &view->tip[i]);
		errors->tip_worst[v] = fmaxf(errors->tip_worst[v], (float)view->tip[i].foot.distance);
	}
}

static void sum_up(struct errors *errors, const struct judge *judge, const struct sketch *sketch)
{
	const struct target *t = judge->target;
	double forward = 0, turned = 0, cost = 0, backward = 0, area = 0, face_cost = 0, turned_area = 0, folded = 0;
	for (size_t i = 0; i < t->count; i++) {
		const struct sample_error *e = &errors->sample[i];
		cost += (double)e->cost;
		errors->max = fmax(errors->max, (double)e->distance);
		if (i < t->area_count)
			forward += (double)e->distance, turned += e->is_turned;
	}
	for (size_t f = 0; f < sketch->face_count; f++) {
		const struct face_error *e = &errors->face[f];
		area += e->area, face_cost += e->cost, backward += e->distance, turned_area += e->turned, folded += e->folded;
		errors->max = fmax(errors->max, e->worst);
	}
	for (size_t v = 0; v < sketch->vertex_count; v++) {
		cost += (double)errors->tip[v];
		errors->max = fmax(errors->max, (double)errors->tip_worst[v]);
	}
	errors->cost = cost / (double)t->area_count / 2 + face_cost / area / 2;
	errors->mean = (forward / (double)t->area_count + backward / area) / 2;
	errors->turned = fmax(turned / (double)t->area_count, turned_area / area);
	errors->folded = folded / area;
	list_samples(errors, t->count, sketch->face_count);
}

static void make_errors(struct errors *errors, const struct judge *judge, const struct sketch *sketch)
{
	*errors = (struct errors){.sample = mem_array(judge->target->count, sizeof *errors->sample), .face = mem_array(sketch->face_count, sizeof *errors->face)};
	errors->tip = mem_array(sketch->vertex_count, sizeof *errors->tip);
	errors->tip_worst = mem_array(sketch->vertex_count, sizeof *errors->tip_worst);
}

void judge_all(struct errors *errors, const struct judge *judge, const struct sketch *sketch)
{
	const size_t samples = judge->target->count;
	idx_t *face = mem_array(sketch->face_count, sizeof *face), *all = mem_array(samples, sizeof *all);
	for (size_t f = 0; f < sketch->face_count; f++)
		face[f] = (idx_t)f;
	for (size_t i = 0; i < samples; i++)
		all[i] = (idx_t)i;
	struct view view;
	view_open(&view, judge, sketch, face, sketch->face_count, all, samples);
	make_errors(errors, judge, sketch);
	take_view(errors, judge, &view);
	sum_up(errors, judge, sketch);
	view_free(&view);
	free(face), free(all);
}

void judge_edit(struct errors *errors, const struct judge *judge, const struct sketch *sketch, const struct view *view, const struct errors *before,
                const idx_t *face, size_t old_faces, const idx_t *vertex, size_t old_vertices)
{
	make_errors(errors, judge, sketch);
	for (size_t i = 0; i < judge->target->count; i++) {
		errors->sample[i] = before->sample[i];
		errors->sample[i].face = face[before->sample[i].face]; /* NO_INDEX only where the view knows better */
	}
	for (size_t f = 0; f < old_faces; f++)
		if (face[f] != NO_INDEX)
			errors->face[face[f]] = before->face[f];
	take_view(errors, judge, view);
	/* the view has all that there is of its inner vertices, but of those on its rim only what lies on its side */
	unsigned char *is_inner = mem_array(sketch->vertex_count, 1), *is_viewed = mem_array(sketch->face_count, 1);
	for (size_t r = 0; r < view->skin.root_count; r++)
		is_viewed[view->skin.face[r]] = 1;
	memset(is_inner, 1, sketch->vertex_count);
	for (size_t f = 0; f < sketch->face_count; f++)
		for (size_t h = sketch->face_start[f]; h < sketch->face_start[f + 1] && !is_viewed[f]; h++)
			is_inner[sketch->face_corner[h]] = 0;
	for (size_t v = 0; v < old_vertices; v++)
		if (vertex[v] != NO_INDEX && !is_inner[vertex[v]]) {
			errors->tip[vertex[v]] = fmaxf(errors->tip[vertex[v]], before->tip[v]);
			errors->tip_worst[vertex[v]] = fmaxf(errors->tip_worst[vertex[v]], before->tip_worst[v]);
		}
	free(is_inner), free(is_viewed);
	sum_up(errors, judge, sketch);
}
