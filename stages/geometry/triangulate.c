#include "stages/geometry/triangulate.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/vector.h"

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

void triangulate_polygon(idx_t *restrict triangle, const double *restrict xyz, const idx_t *restrict corner, size_t count)
{
	double normal[3];
	newell_normal(normal, xyz, corner, count);
	idx_t *out = triangle;
	if (count == 3) {
		put(&out, corner[0], corner[1], corner[2]);
	} else if (count == 4) {
		cut_quad(triangle, normal, xyz, corner);
	} else if (count <= TRIANGULATE_EARS_MOST) {
		cut_ears(triangle, normal, xyz, corner, count);
	} else {
		for (size_t i = 1; i + 1 < count; i++)
			put(&out, corner[0], corner[i], corner[i + 1]);
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
