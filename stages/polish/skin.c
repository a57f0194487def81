#include "stages/polish/skin.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/nearest.h"
#include "stages/geometry/vector.h"

#define LEAST_AGREEMENT (-0.2) /* cosine of normals from which on faces are taken to look the same way */

/* --- the part that is refined ------------------------------------------------------------------------------------------ */

/* Listed faces first, then those that share a vertex with one. */
static idx_t *ring_faces(size_t *count, const struct sketch *s, const idx_t *face, size_t face_count)
{
	idx_t *list = mem_array(s->face_count, sizeof *list);
	unsigned char *seen = mem_array(s->face_count, 1);
	*count = 0;
	for (size_t i = 0; i < face_count; i++)
		seen[face[i]] = 1, list[(*count)++] = face[i];
	for (size_t i = 0; i < face_count; i++)
		for (size_t k = s->face_start[face[i]]; k < s->face_start[face[i] + 1]; k++) {
			const idx_t start = s->outgoing[s->face_corner[k]];
			for (idx_t h = start; h != NO_INDEX;) {
				const idx_t f = s->face[h];
				if (!seen[f])
					seen[f] = 1, list[(*count)++] = f;
				h = sketch_turn(s, h);
				if (h == start)
					break;
			}
		}
	free(seen);
	return list;
}

static void cut_part(struct skin *skin, const struct sketch *s, size_t part_faces)
{
	struct level *part = &skin->part;
	idx_t *number = mem_array(s->vertex_count, sizeof *number);
	memset(number, -1, s->vertex_count * sizeof *number);
	size_t halves = 0;
	for (size_t i = 0; i < part_faces; i++)
		halves += sketch_degree(s, skin->face[i]);
	*part = (struct level){.face_count = part_faces};
	part->face_corner = mem_array(halves, sizeof *part->face_corner);
	part->face_start = mem_array(part_faces + 1, sizeof *part->face_start);
	part->face_origin = mem_array(part_faces, sizeof *part->face_origin);
	part->sharp = mem_array(halves, 1);
	skin->part_vertex = mem_array(s->vertex_count, sizeof *skin->part_vertex);
	size_t n = 0;
	unsigned char *inside = mem_array(s->face_count, 1);
	for (size_t i = 0; i < part_faces; i++)
		inside[skin->face[i]] = 1;
	for (size_t i = 0; i < part_faces; i++) {
		const idx_t f = skin->face[i];
		part->face_origin[i] = (idx_t)i;
		for (size_t h = s->face_start[f]; h < s->face_start[f + 1]; h++) {
			const idx_t v = s->face_corner[h];
			if (number[v] == NO_INDEX)
				number[v] = (idx_t)part->vertex_count, skin->part_vertex[part->vertex_count++] = v;
			part->face_corner[n] = number[v];
			part->sharp[n++] = s->sharp[h] || s->twin[h] == NO_INDEX || !inside[s->face[s->twin[h]]];
		}
		part->face_start[i + 1] = n;
	}
	part->corner = mem_array(part->vertex_count, 1);
	part->xyz = mem_array(3 * part->vertex_count, sizeof *part->xyz);
	for (size_t v = 0; v < part->vertex_count; v++)
		part->corner[v] = sketch_is_corner(s, skin->part_vertex[v]);
	free(inside), free(number);
}

/* A part may touch itself at a vertex in two fans; the rules need one. The rim of the part does not matter: such vertices are split. */
static void split_fans(struct skin *skin, const struct sketch *s)
{
	struct level *part = &skin->part;
	const size_t halves = part->face_start[part->face_count], old = part->vertex_count;
	/* number of fans = number of half-edges around without twin inside, for vertices that are not whole */
	idx_t *place = mem_array(halves, sizeof *place); /* half of the part -> half of the sketch */
	idx_t *back = mem_array(s->face_start[s->face_count], sizeof *back);
	memset(back, -1, s->face_start[s->face_count] * sizeof *back);
	size_t n = 0;
	for (size_t i = 0; i < part->face_count; i++)
		for (size_t h = s->face_start[skin->face[i]]; h < s->face_start[skin->face[i] + 1]; h++)
			back[h] = (idx_t)n, place[n++] = (idx_t)h;
	unsigned char *used = mem_array(old, 1);
	size_t extra = 0;
	idx_t *fresh = NULL;
	for (size_t h = 0; h < halves; h++) {
		const idx_t t = s->twin[place[h]];
		if (t != NO_INDEX && back[t] != NO_INDEX)
			continue;
		/* h starts a fan at its origin: nothing on its right */
		const idx_t v = part->face_corner[h];
		if ((size_t)v < old && !used[v]) {
			used[v] = 1;
			continue;
		}
		fresh = mem_resize(fresh, extra + 1, sizeof *fresh);
		fresh[extra] = v;
		const idx_t number = (idx_t)(old + extra++);
		for (idx_t g = place[h]; g != NO_INDEX && back[g] != NO_INDEX; g = sketch_turn(s, g))
			part->face_corner[back[g]] = number;
	}
	if (extra > 0) {
		part->corner = mem_resize(part->corner, old + extra, 1);
		part->xyz = mem_resize(part->xyz, 3 * (old + extra), sizeof *part->xyz);
		skin->part_vertex = mem_resize(skin->part_vertex, old + extra, sizeof *skin->part_vertex);
		for (size_t i = 0; i < extra; i++) {
			part->corner[old + i] = part->corner[fresh[i]];
			skin->part_vertex[old + i] = skin->part_vertex[fresh[i]];
		}
		part->vertex_count = old + extra;
	}
	free(place), free(back), free(used), free(fresh);
}

/* --- boxes ---------------------------------------------------------------------------------------------------------------- */

static void box_empty(float box[6])
{
	for (int k = 0; k < 3; k++)
		box[k] = FLT_MAX, box[3 + k] = -FLT_MAX;
}
static void box_join(float box[6], const float other[6])
{
	for (int k = 0; k < 3; k++) {
		box[k] = other[k] < box[k] ? other[k] : box[k];
		box[3 + k] = other[3 + k] > box[3 + k] ? other[3 + k] : box[3 + k];
	}
}
static inline float larger(float a, float b) { return a > b ? a : b; }
static float box_gap2(const float box[6], const float p[3])
{
	float sum = 0;
	for (int k = 0; k < 3; k++) {
		const float low = box[k] - p[k], high = p[k] - box[3 + k], gap = low > high ? low : high;
		sum += gap > 0 ? gap * gap : 0;
	}
	return sum;
}

/* The box of a fine face, and its normal. */
static void box_leaf(float box[6], float normal[3], const struct level *fine, size_t f)
{
	box_empty(box);
	const size_t from = fine->face_start[f], degree = fine->face_start[f + 1] - from;
	const double *v[4];
	for (size_t i = 0; i < degree; i++) {
		v[i] = &fine->xyz[3 * (size_t)fine->face_corner[from + i]];
		for (int k = 0; k < 3; k++) {
			const float x = (float)v[i][k];
			box[k] = x < box[k] ? x : box[k], box[3 + k] = x > box[3 + k] ? x : box[3 + k];
		}
	}
	double n[3], d1[3], d2[3];
	if (degree == 4) {
		sub3(d1, v[2], v[0]), sub3(d2, v[3], v[1]);
		cross3(n, d1, d2);
	} else {
		area_vector3(n, v[0], v[1], v[2]);
	}
	normalise3(n);
	for (int k = 0; k < 3; k++)
		normal[k] = (float)n[k];
}

static void make_boxes(struct skin *skin)
{
	const int last = skin->steps - 2; /* block level of the leaves */
	for (int l = last; l >= 0; l--)
		for (size_t b = 0; b < skin->first[skin->root_count] << (2 * l); b++)
			for (size_t c = 0; c < 4; c++) {
				float box[6];
				if (l == last) {
					box_leaf(box, skin->normal[4 * b + c], &skin->fine, 4 * b + c);
				} else {
					box_empty(box);
					for (int k = 0; k < 3; k++)
						for (int i = 0; i < 4; i++) {
							box[k] = fminf(box[k], skin->block[l + 1][4 * b + c][k][i]);
							box[3 + k] = fmaxf(box[3 + k], skin->block[l + 1][4 * b + c][3 + k][i]);
						}
				}
				for (int k = 0; k < 6; k++)
					skin->block[l][b][k][c] = box[k];
			}
	for (size_t r = 0; r < skin->root_count; r += SKIN_BUNDLE)
		box_empty(skin->bundle_box[r / SKIN_BUNDLE]);
	for (size_t r = 0; r < skin->root_count; r++) {
		float whole[6];
		box_empty(whole);
		for (size_t c = skin->first[r]; c < skin->first[r + 1]; c++) {
			box_empty(skin->box[c]);
			for (int k = 0; k < 3; k++)
				for (int i = 0; i < 4; i++) {
					skin->box[c][k] = fminf(skin->box[c][k], skin->block[0][c][k][i]);
					skin->box[c][3 + k] = fmaxf(skin->box[c][3 + k], skin->block[0][c][3 + k][i]);
				}
			box_join(whole, skin->box[c]);
		}
		for (size_t k = 0; k < 6; k++)
			skin->root_box[k * skin->root_count + r] = whole[k];
		box_join(skin->bundle_box[r / SKIN_BUNDLE], whole);
	}
}

void skin_move(struct skin *skin, const struct sketch *s)
{
	for (size_t v = 0; v < skin->part.vertex_count; v++)
		copy3(&skin->part.xyz[3 * v], &s->xyz[3 * (size_t)skin->part_vertex[v]]);
	double *const before = skin->fine.xyz;
	skin->fine.xyz = NULL;
	level_free(&skin->fine);
	level_refine(&skin->fine, &skin->part, s->scheme, skin->steps);
	if (!skin->shift)
		skin->shift = mem_array(skin->fine.vertex_count, sizeof *skin->shift);
	for (size_t v = 0; before && v < skin->fine.vertex_count; v++)
		skin->shift[v] = (float)distance3(&before[3 * v], &skin->fine.xyz[3 * v]);
	free(before);
	make_boxes(skin);
}

void skin_build(struct skin *skin, const struct sketch *s, const idx_t *face, size_t face_count, int steps)
{
	*skin = (struct skin){.root_count = face_count, .steps = steps, .scheme = s->scheme};
	size_t part_faces;
	skin->face = ring_faces(&part_faces, s, face, face_count);
	cut_part(skin, s, part_faces);
	split_fans(skin, s);
	skin->first = mem_array(face_count + 1, sizeof *skin->first);
	for (size_t r = 0; r < face_count; r++) {
		const size_t degree = sketch_degree(s, skin->face[r]);
		skin->first[r + 1] = skin->first[r] + (degree == 3 && s->scheme != SCHEME_CATMULLCLARK ? 4 : degree);
	}
	skin->root_box = mem_array(6 * face_count, sizeof *skin->root_box);
	skin->bundle_box = mem_array(face_count / SKIN_BUNDLE + 1, sizeof *skin->bundle_box);
	skin->box = mem_array(skin->first[face_count], sizeof *skin->box);
	for (int l = 0; l < steps - 1; l++)
		skin->block[l] = mem_array(skin->first[face_count] << (2 * l), sizeof *skin->block[l]);
	skin->normal = mem_array(skin->first[face_count] << (2 * (steps - 1)), sizeof *skin->normal);
	skin_move(skin, s);
}

void skin_free(struct skin *skin)
{
	level_free(&skin->fine), level_free(&skin->part);
	free(skin->shift), free(skin->face), free(skin->first), free(skin->root_box), free(skin->normal), free(skin->part_vertex);
	free(skin->bundle_box), free(skin->box), free(skin->block[0]), free(skin->block[1]);
	*skin = (struct skin){0};
}

/* --- nearest points --------------------------------------------------------------------------------------------------------- */

struct query {
	const struct skin *skin;
	const double *p, *normal;
	float pf[3];
	double best; /* measure */
	struct skin_foot foot;
};

/* The nearest point of the side from a along u, by its distance squared; along: 0 to 1. */
static double on_side(double *along, const double w[3], const double u[3], double uu, double wu)
{
	double d2 = 0;
	*along = wu <= 0 ? 0 : wu >= uu ? 1 : wu / uu;
	for (int k = 0; k < 3; k++) {
		const double d = w[k] - *along * u[k];
		d2 += d * d;
	}
	return d2;
}

/* Nearest point of a triangle; nearest_on_triangle with its care for slivers takes several times longer. Outside the
 * triangle the nearest point lies on a side that the point is beyond. INFINITY when the plane alone is farther away than bound. */
static double on_triangle(double point[3], double weight[3], const double p[3], const double a[3], const double b[3], const double c[3], double bound)
{
	double u[3], v[3], w[3], n[3];
	sub3(u, b, a), sub3(v, c, a), sub3(w, p, a);
	cross3(n, u, v);
	const double det = dot3(n, n), height = dot3(w, n);
	if (bound <= 0 || height * height >= bound * bound * det)
		return INFINITY;
	const double uu = dot3(u, u), uv = dot3(u, v), vv = dot3(v, v), wu = dot3(w, u), wv = dot3(w, v);
	if (!(det > 1e-6 * uu * vv))
		return nearest_on_triangle(point, weight, p, a, b, c);
	const double s = vv * wu - uv * wv, t = uu * wv - uv * wu;
	double best = INFINITY, along;
	if (s >= 0 && t >= 0 && s + t <= det) {
		weight[1] = s / det, weight[2] = t / det;
		best = height * height / det;
	} else {
		if (s < 0) {
			best = on_side(&along, w, v, vv, wv);
			weight[1] = 0, weight[2] = along;
		}
		if (t < 0) {
			const double d2 = on_side(&along, w, u, uu, wu);
			if (d2 < best)
				best = d2, weight[1] = along, weight[2] = 0;
		}
		if (s + t > det) {
			double e[3], wb[3];
			sub3(e, v, u), sub3(wb, w, u);
			const double d2 = on_side(&along, wb, e, vv - 2 * uv + uu, dot3(wb, e));
			if (d2 < best)
				best = d2, weight[1] = 1 - along, weight[2] = along;
		}
	}
	weight[0] = fmax(0, 1 - weight[1] - weight[2]);
	for (int k = 0; k < 3; k++)
		point[k] = a[k] + weight[1] * u[k] + weight[2] * v[k];
	return sqrt(best);
}

static void try_leaf(struct query *q, idx_t f, idx_t root)
{
	const struct level *fine = &q->skin->fine;
	const size_t from = fine->face_start[f], degree = fine->face_start[f + 1] - from;
	const float *n = q->skin->normal[f];
	const bool is_turned = n[0] * q->normal[0] + n[1] * q->normal[1] + n[2] * q->normal[2] < LEAST_AGREEMENT;
	const double penalty = is_turned ? SKIN_PENALTY : 0;
	for (size_t i = 0; i + 2 < degree; i++) {
		const idx_t corner[3] = {fine->face_corner[from], fine->face_corner[from + i + 1], fine->face_corner[from + i + 2]};
		double point[3], weight[3];
		const double d = on_triangle(point, weight, q->p, &fine->xyz[3 * (size_t)corner[0]], &fine->xyz[3 * (size_t)corner[1]],
		                                     &fine->xyz[3 * (size_t)corner[2]], q->best - penalty);
		const double measure = d + penalty;
		if (measure < q->best) {
			q->best = measure;
			q->foot = (struct skin_foot){.root = root, .fine = f, .distance = d, .measure = measure, .is_turned = is_turned};
			memcpy(q->foot.corner, corner, sizeof corner);
			memcpy(q->foot.weight, weight, sizeof weight);
			memcpy(q->foot.point, point, sizeof point);
		}
	}
}

#define NEARER(q) ((float)((q)->best * (q)->best * 1.0001 + 1e-12))

/* Four children in the order of their distance: the first good answer comes early and spares the rest. */
static void descend(struct query *q, int level, size_t parent, idx_t root)
{
	const float (*box)[4] = (const float(*)[4])q->skin->block[level][parent];
	float gap[4];
#pragma omp simd
	for (int c = 0; c < 4; c++) {
		const float x = larger(larger(box[0][c] - q->pf[0], q->pf[0] - box[3][c]), 0), y = larger(larger(box[1][c] - q->pf[1], q->pf[1] - box[4][c]), 0),
		            z = larger(larger(box[2][c] - q->pf[2], q->pf[2] - box[5][c]), 0);
		gap[c] = x * x + y * y + z * z;
	}
	for (int visited = 0; visited < 4; visited++) {
		int next = 0;
		for (int c = 1; c < 4; c++)
			next = gap[c] < gap[next] ? c : next;
		if (!(gap[next] < NEARER(q)))
			return;
		gap[next] = FLT_MAX;
		const size_t f = 4 * parent + (size_t)next;
		if (level == 1 || level == q->skin->steps - 2)
			try_leaf(q, (idx_t)f, root);
		else
			descend(q, level + 1, f, root);
	}
}

static void try_root(struct query *q, size_t r)
{
	const struct skin *skin = q->skin;
	float box[6];
	for (size_t k = 0; k < 6; k++)
		box[k] = skin->root_box[k * skin->root_count + r];
	if (!(box_gap2(box, q->pf) < NEARER(q)))
		return;
	for (size_t c = skin->first[r]; c < skin->first[r + 1]; c++)
		if (box_gap2(skin->box[c], q->pf) < NEARER(q))
			descend(q, 0, c, (idx_t)r);
}

void skin_order(struct skin_order *order, const struct skin *skin, const float box[6])
{
	const size_t n = skin->root_count;
	if (!order->gap) {
		order->gap = mem_array(2 * n, sizeof *order->gap);
		order->root = mem_array(n, sizeof *order->root);
	}
	float *restrict gap = order->gap + n;
	const float *restrict low = skin->root_box, *restrict high = skin->root_box + 3 * n;
#pragma omp simd
	for (size_t r = 0; r < n; r++) {
		const float x = larger(larger(low[r] - box[3], box[0] - high[r]), 0), y = larger(larger(low[n + r] - box[4], box[1] - high[n + r]), 0),
		            z = larger(larger(low[2 * n + r] - box[5], box[2] - high[2 * n + r]), 0);
		gap[r] = x * x + y * y + z * z;
	}
	/* what is near is enough: the few nearest sorted, the others behind in any order with the least gap among them */
	enum { NEAR = 24 };
	order->count = 0;
	float rest = FLT_MAX;
	for (size_t r = 0; r < n; r++) {
		const float g = gap[r];
		if (order->count == NEAR && !(g < order->gap[NEAR - 1])) {
			rest = g < rest ? g : rest;
			continue;
		}
		size_t i = order->count;
		if (i == NEAR)
			rest = order->gap[--i] < rest ? order->gap[i] : rest;
		else
			order->count++;
		for (; i > 0 && order->gap[i - 1] > g; i--)
			order->gap[i] = order->gap[i - 1], order->root[i] = order->root[i - 1];
		order->gap[i] = g, order->root[i] = (idx_t)r;
	}
	order->rest = rest;
}

void skin_order_free(struct skin_order *order)
{
	free(order->gap), free(order->root);
	*order = (struct skin_order){0};
}

struct skin_foot skin_nearest(const struct skin *skin, const struct skin_order *order, const double p[3], const double normal[3], idx_t hint)
{
	struct query q = {.skin = skin, .p = p, .normal = normal, .pf = {(float)p[0], (float)p[1], (float)p[2]}, .best = 1e3};
	q.foot.fine = q.foot.root = NO_INDEX;
	if (hint != NO_INDEX)
		try_leaf(&q, hint, skin->fine.face_origin[hint]);
	for (size_t i = 0; i < order->count && order->gap[i] < NEARER(&q); i++)
		try_root(&q, (size_t)order->root[i]);
	for (size_t first = 0; order->rest < NEARER(&q) && first < skin->root_count; first += SKIN_BUNDLE) {
		if (!(box_gap2(skin->bundle_box[first / SKIN_BUNDLE], q.pf) < NEARER(&q)))
			continue;
		for (size_t r = first; r < first + SKIN_BUNDLE && r < skin->root_count; r++)
			try_root(&q, r);
	}
	return q.foot;
}

struct skin_foot skin_follow(const struct skin *skin, const struct skin_order *order, const double p[3], const double normal[3],
                             const struct skin_foot *foot)
{
	for (int i = 0; i < 3; i++)
		if (skin->shift[foot->corner[i]] > SKIN_HARDLY)
			return skin_nearest(skin, order, p, normal, foot->fine);
	struct query q = {.skin = skin, .p = p, .normal = normal, .best = 1e3};
	q.foot.fine = q.foot.root = NO_INDEX;
	try_leaf(&q, foot->fine, foot->root);
	const idx_t block = foot->fine & ~(idx_t)3;
	for (idx_t f = block; f < block + 4; f++)
		if (f != foot->fine)
			try_leaf(&q, f, foot->root);
	return q.foot;
}

/* --- reverse samples ---------------------------------------------------------------------------------------------------------- */

size_t skin_spot_count(const struct skin *skin, size_t root)
{
	return (skin->first[root + 1] - skin->first[root]) << (2 * (skin->steps - 2));
}

void skin_spot(struct skin_spot *spot, const struct skin *skin, size_t root, size_t index)
{
	const struct level *fine = &skin->fine;
	const size_t block = (skin->first[root] << (2 * (skin->steps - 1))) + 4 * index;
	const bool is_triangle = fine->face_start[block + 1] - fine->face_start[block] == 3;
	double sum[3] = {0}, area[4];
	for (size_t i = 0; i < 4; i++) {
		const idx_t *c = &fine->face_corner[fine->face_start[block + i]];
		double n[3], m[3] = {0};
		area_vector3(n, &fine->xyz[3 * (size_t)c[0]], &fine->xyz[3 * (size_t)c[1]], &fine->xyz[3 * (size_t)c[2]]);
		if (!is_triangle)
			area_vector3(m, &fine->xyz[3 * (size_t)c[0]], &fine->xyz[3 * (size_t)c[2]], &fine->xyz[3 * (size_t)c[3]]);
		add_scaled3(sum, 0.5, n), add_scaled3(sum, 0.5, m);
		area[i] = (norm3(n) + norm3(m)) / 2;
	}
	copy3(spot->normal, sum);
	normalise3(spot->normal);
	spot->area = spot->folded = 0;
	for (size_t i = 0; i < 4; i++) {
		const float *n = skin->normal[block + i];
		spot->area += area[i];
		if (n[0] * spot->normal[0] + n[1] * spot->normal[1] + n[2] * spot->normal[2] < 0)
			spot->folded += area[i];
	}
	/* the middle triangle is the last child; the middle of a quad is the third corner of each child */
	const idx_t *c = &fine->face_corner[fine->face_start[is_triangle ? block + 3 : block]];
	for (int i = 0; i < 3; i++) {
		spot->corner[i] = is_triangle ? c[i] : c[2];
		spot->weight[i] = is_triangle ? 1.0 / 3 : i == 0;
	}
	for (int k = 0; k < 3; k++)
		spot->point[k] = is_triangle ? (fine->xyz[3 * (size_t)c[0] + k] + fine->xyz[3 * (size_t)c[1] + k] + fine->xyz[3 * (size_t)c[2] + k]) / 3
		                             : fine->xyz[3 * (size_t)c[2] + k];
}

/* The child at corner k has the middle of side k as its second corner and that of the side before as its last, and so has the child's
 * child there the quarters of the sides. */
void skin_side(idx_t vertex[3], const struct skin *skin, size_t root, size_t k, size_t degree)
{
	const size_t next = k + 1 < degree ? k + 1 : 0, child = 4 * (skin->first[root] + k), other = 4 * (skin->first[root] + next);
	const size_t last = skin->fine.face_start[4 * child + 1] - skin->fine.face_start[4 * child] - 1;
	const size_t scale = skin->steps == 3 ? 4 : 1;
	vertex[1] = skin->fine.face_corner[skin->fine.face_start[scale * (child + 1)]];
	vertex[0] = vertex[2] = vertex[1];
	if (skin->steps == 3) {
		vertex[0] = skin->fine.face_corner[skin->fine.face_start[4 * child + 1]];
		vertex[2] = skin->fine.face_corner[skin->fine.face_start[4 * other + last]];
	}
}

/* Subdivision is linear and treats the three coordinates alike: refining unit vectors in place of positions gives three columns at
 * a time. */
void skin_columns(double *column, const struct skin *skin, const idx_t *vertex, size_t count)
{
	struct level unit = skin->part;
	unit.xyz = mem_array(3 * unit.vertex_count, sizeof *unit.xyz);
	for (size_t i = 0; i < count; i += 3) {
		const size_t here = count - i < 3 ? count - i : 3;
		memset(unit.xyz, 0, 3 * unit.vertex_count * sizeof *unit.xyz);
		for (size_t p = 0; p < unit.vertex_count; p++)
			for (size_t k = 0; k < here; k++)
				if (skin->part_vertex[p] == vertex[i + k])
					unit.xyz[3 * p + k] = 1;
		struct level fine;
		level_refine(&fine, &unit, skin->scheme, skin->steps);
		for (size_t v = 0; v < fine.vertex_count; v++)
			for (size_t k = 0; k < here; k++)
				column[v * count + i + k] = fine.xyz[3 * v + k];
		level_free(&fine);
	}
	free(unit.xyz);
}
