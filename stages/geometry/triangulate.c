#include "stages/geometry/triangulate.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/vector.h"

/* Cells and corners that the search for the ears of one large polygon may look at. */
#define LARGE_STEPS ((size_t)100000000)

/* Twice the signed area of a, b, c seen against the unit normal. */
static double area_seen(const double normal[3], const double *xyz, idx_t a, idx_t b, idx_t c)
{
	double n[3];
	area_vector3(n, xyz + 3 * (size_t)a, xyz + 3 * (size_t)b, xyz + 3 * (size_t)c);
	return dot3(n, normal);
}

static void newell_normal(double normal[3], const double *xyz, const idx_t *corner, size_t count)
{
	normal[0] = normal[1] = normal[2] = 0;
	for (size_t i = 1; i + 1 < count; i++) { /* as a sum of fan areas: exact under large offsets */
		double n[3];
		area_vector3(n, xyz + 3 * (size_t)corner[0], xyz + 3 * (size_t)corner[i], xyz + 3 * (size_t)corner[i + 1]);
		add_scaled3(normal, 1, n);
	}
	normalise3(normal);
}

static void put(idx_t **out, idx_t a, idx_t b, idx_t c)
{
	(*out)[0] = a, (*out)[1] = b, (*out)[2] = c;
	*out += 3;
}

static void cut_quad(idx_t *out, const double normal[3], const double *xyz, const idx_t *q)
{
	const double by02 = fmin(area_seen(normal, xyz, q[0], q[1], q[2]), area_seen(normal, xyz, q[0], q[2], q[3]));
	const double by13 = fmin(area_seen(normal, xyz, q[1], q[2], q[3]), area_seen(normal, xyz, q[1], q[3], q[0]));
	const double length02 = distance3(xyz + 3 * (size_t)q[0], xyz + 3 * (size_t)q[2]);
	const double length13 = distance3(xyz + 3 * (size_t)q[1], xyz + 3 * (size_t)q[3]);
	if (by02 > 0 && by13 > 0 ? length02 <= length13 : by02 >= by13) {
		put(&out, q[0], q[1], q[2]);
		put(&out, q[0], q[2], q[3]);
	} else {
		put(&out, q[1], q[2], q[3]);
		put(&out, q[1], q[3], q[0]);
	}
}

/* How good an ear i is: area over squared perimeter; less than -1 when it is no ear (turned over, or another corner inside). */
static double ear_quality(const double normal[3], const double *xyz, const idx_t *corner, const size_t *before, const size_t *after, size_t i)
{
	const idx_t a = corner[before[i]], b = corner[i], c = corner[after[i]];
	const double area = area_seen(normal, xyz, a, b, c);
	const double *pa = xyz + 3 * (size_t)a, *pb = xyz + 3 * (size_t)b, *pc = xyz + 3 * (size_t)c;
	const double round = distance3(pa, pb) + distance3(pb, pc) + distance3(pc, pa);
	const double quality = round > 0 ? area / (round * round) : 0;
	if (!(area > 0))
		return quality - 2;
	for (size_t j = after[after[i]]; j != before[i]; j = after[j]) {
		const idx_t o = corner[j];
		if (o != a && o != b && o != c && area_seen(normal, xyz, a, b, o) >= 0 && area_seen(normal, xyz, b, c, o) >= 0 &&
		    area_seen(normal, xyz, c, a, o) >= 0)
			return quality - 4;
	}
	return quality;
}

static size_t best_ear(const double *quality, const size_t *after, size_t head)
{
	size_t best = head;
	for (size_t i = after[head]; i != head; i = after[i])
		if (quality[i] > quality[best])
			best = i;
	return best;
}

static void cut_ears(idx_t *out, const double normal[3], const double *xyz, const idx_t *corner, size_t count)
{
	size_t *before = mem_array(count, sizeof *before), *after = mem_array(count, sizeof *after);
	double *quality = mem_array(count, sizeof *quality);
	for (size_t i = 0; i < count; i++) {
		before[i] = (i + count - 1) % count;
		after[i] = (i + 1) % count;
	}
	for (size_t i = 0; i < count; i++)
		quality[i] = ear_quality(normal, xyz, corner, before, after, i);
	size_t head = 0;
	int looks_left = 64;
	for (size_t left = count; left > 3; left--) {
		size_t best = best_ear(quality, after, head);
		/* An ear that was blocked by a corner now gone still counts as none. A simple polygon always has two ears, so when
		 * none is known look at all again, but not without end: crossing polygons have none. */
		if (quality[best] < -1 && looks_left-- > 0) {
			size_t i = head;
			do
				quality[i] = ear_quality(normal, xyz, corner, before, after, i);
			while ((i = after[i]) != head);
			best = best_ear(quality, after, head);
		}
		const size_t a = before[best], c = after[best];
		put(&out, corner[a], corner[best], corner[c]);
		after[a] = c;
		before[c] = a;
		if (best == head)
			head = c;
		quality[a] = ear_quality(normal, xyz, corner, before, after, a);
		quality[c] = ear_quality(normal, xyz, corner, before, after, c);
	}
	put(&out, corner[before[head]], corner[head], corner[after[head]]);
	free(before);
	free(after);
	free(quality);
}

/* A large polygon in its plane. Only reflex corners can lie in an ear, so those are kept in a grid. */
struct large {
	const idx_t *corner;
	size_t count;
	double (*at)[2];
	size_t *before, *after;
	unsigned char *is_reflex; /* and still there */
	double low[2], cell;    /* square cells, about one a corner */
	size_t side[2];         /* cells along each axis */
	size_t *cell_start, *cell_corner;
	size_t steps_left;
};

static double turn(const struct large *large, size_t a, size_t b, size_t c)
{
	const double *p = large->at[a], *q = large->at[b], *r = large->at[c];
	return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

static size_t cell_of(const struct large *large, int axis, double x)
{
	const double at = (x - large->low[axis]) / large->cell;
	return at > 0 ? (size_t)fmin(at, (double)(large->side[axis] - 1)) : 0;
}

static bool is_at(const struct large *large, size_t i, size_t j)
{
	return large->at[i][0] == large->at[j][0] && large->at[i][1] == large->at[j][1];
}

static bool is_ear(struct large *large, size_t i)
{
	const size_t a = large->before[i], c = large->after[i];
	if (!(turn(large, a, i, c) > 0))
		return false;
	size_t first[2], last[2];
	for (int k = 0; k < 2; k++) {
		const double x = large->at[a][k], y = large->at[i][k], z = large->at[c][k];
		first[k] = cell_of(large, k, fmin(x, fmin(y, z)));
		last[k] = cell_of(large, k, fmax(x, fmax(y, z)));
	}
	for (size_t v = first[1]; v <= last[1]; v++)
		for (size_t u = first[0]; u <= last[0]; u++) {
			const size_t cell = v * large->side[0] + u;
			large->steps_left -= large->steps_left > 0;
			for (size_t k = large->cell_start[cell]; k < large->cell_start[cell + 1]; k++) {
				const size_t j = large->cell_corner[k];
				large->steps_left -= large->steps_left > 0;
				if (large->is_reflex[j] && !is_at(large, j, a) && !is_at(large, j, i) && !is_at(large, j, c) && turn(large, a, i, j) >= 0 &&
				    turn(large, i, c, j) >= 0 && turn(large, c, a, j) >= 0)
					return false;
			}
		}
	return true;
}

/* A corner between two sides of one line, or the given one when there is none. */
static size_t straight_corner(struct large *large, size_t from, size_t left)
{
	large->steps_left -= large->steps_left < left ? large->steps_left : left;
	size_t i = from;
	do {
		if (turn(large, large->before[i], i, large->after[i]) == 0)
			return i;
		i = large->after[i];
	} while (i != from);
	return from;
}

static void fill_grid(struct large *large)
{
	double high[2] = {-INFINITY, -INFINITY};
	large->low[0] = large->low[1] = INFINITY;
	for (size_t i = 0; i < large->count; i++)
		for (int k = 0; k < 2; k++) {
			large->low[k] = fmin(large->low[k], large->at[i][k]);
			high[k] = fmax(high[k], large->at[i][k]);
		}
	const double width = high[0] - large->low[0], height = high[1] - large->low[1], n = (double)large->count;
	large->cell = fmax(sqrt(width * height / n), fmax(width, height) / n);
	if (!(large->cell > 0))
		large->cell = 1;
	large->side[0] = 1 + (size_t)fmin(width / large->cell, n);
	large->side[1] = 1 + (size_t)fmin(height / large->cell, n);
	const size_t cells = large->side[0] * large->side[1];
	large->cell_start = mem_array(cells + 2, sizeof *large->cell_start);
	large->cell_corner = mem_array(large->count, sizeof *large->cell_corner);
	for (int pass = 0; pass < 2; pass++) { /* count, then place */
		for (size_t i = 0; i < large->count; i++) {
			if (!large->is_reflex[i])
				continue;
			const size_t cell = cell_of(large, 1, large->at[i][1]) * large->side[0] + cell_of(large, 0, large->at[i][0]);
			if (pass == 0)
				large->cell_start[cell + 2]++;
			else
				large->cell_corner[large->cell_start[cell + 1]++] = i;
		}
		for (size_t cell = 0; pass == 0 && cell < cells; cell++)
			large->cell_start[cell + 2] += large->cell_start[cell + 1];
	}
}

static void cut_large(idx_t *out, const double normal[3], const double *xyz, const idx_t *corner, size_t count)
{
	struct large large = {.corner = corner, .count = count, .steps_left = LARGE_STEPS};
	large.at = mem_array(count, sizeof *large.at);
	large.before = mem_array(count, sizeof *large.before);
	large.after = mem_array(count, sizeof *large.after);
	large.is_reflex = mem_array(count, 1);
	/* Leave out the axis that the normal follows most; the other two in the order that keeps the orientation. */
	const double size[3] = {fabs(normal[0]), fabs(normal[1]), fabs(normal[2])};
	const int drop = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
	const int u = normal[drop] >= 0 ? (drop + 1) % 3 : (drop + 2) % 3, v = 3 - drop - u;
	for (size_t i = 0; i < count; i++) {
		large.at[i][0] = xyz[3 * (size_t)corner[i] + u];
		large.at[i][1] = xyz[3 * (size_t)corner[i] + v];
		large.before[i] = (i + count - 1) % count;
		large.after[i] = (i + 1) % count;
	}
	for (size_t i = 0; i < count; i++)
		large.is_reflex[i] = !(turn(&large, large.before[i], i, large.after[i]) > 0);
	fill_grid(&large);
	size_t i = 0, since_cut = 0;
	for (size_t left = count; left > 3;) {
		/* After a round without an ear cut a straight corner: such corners on the third side of an ear block it. When there is
		 * none (a polygon that crosses itself), or when this takes too long, cut what is there. */
		if (large.steps_left > 0 && since_cut < left && !is_ear(&large, i)) {
			i = large.after[i];
			since_cut++;
			continue;
		}
		if (large.steps_left > 0 && since_cut >= left)
			i = straight_corner(&large, i, left);
		const size_t a = large.before[i], c = large.after[i];
		put(&out, corner[a], corner[i], corner[c]);
		large.after[a] = c;
		large.before[c] = a;
		large.is_reflex[i] = 0;
		large.is_reflex[a] = large.is_reflex[a] && !(turn(&large, large.before[a], a, c) > 0);
		large.is_reflex[c] = large.is_reflex[c] && !(turn(&large, a, c, large.after[c]) > 0);
		left--;
		since_cut = 0;
		i = large.after[c]; /* not the neighbour at once: that would make fans */
	}
	put(&out, corner[large.before[i]], corner[i], corner[large.after[i]]);
	free(large.at);
	free(large.before);
	free(large.after);
	free(large.is_reflex);
	free(large.cell_start);
	free(large.cell_corner);
}

void triangulate_polygon(idx_t *restrict triangle, const double *restrict xyz, const idx_t *restrict corner, size_t count)
{
	double normal[3];
	newell_normal(normal, xyz, corner, count);
	idx_t *out = triangle;
	if (count == 3) {
		put(&out, corner[0], corner[1], corner[2]);
	} else if (count == 4) {
		cut_quad(triangle, normal, xyz, corner);
	} else if (count <= TRIANGULATE_BEST_MOST) {
		cut_ears(out, normal, xyz, corner, count);
	} else {
		cut_large(out, normal, xyz, corner, count);
	}
}

idx_t *triangulate_mesh(size_t *triangle_count, idx_t **face, const double *xyz, const idx_t *corner, const size_t *face_start,
                        size_t face_count)
{
	size_t total = 0;
	for (size_t f = 0; f < face_count; f++) {
		const size_t count = face_start[f + 1] - face_start[f];
		total += count >= 3 ? count - 2 : 0;
	}
	idx_t *triangle = mem_array(3 * total, sizeof *triangle);
	if (face != NULL)
		*face = mem_array(total, sizeof **face);
	size_t done = 0;
	for (size_t f = 0; f < face_count; f++) {
		const size_t count = face_start[f + 1] - face_start[f];
		if (count < 3)
			continue;
		triangulate_polygon(triangle + 3 * done, xyz, corner + face_start[f], count);
		for (size_t i = 0; i + 2 < count; i++, done++)
			if (face != NULL)
				(*face)[done] = (idx_t)f;
	}
	*triangle_count = total;
	return triangle;
}
