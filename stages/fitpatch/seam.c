/* Seams of plane patches. */
#include "stages/fitpatch/seam.h"

#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/fitpatch/local.h"
#include "stages/geometry/vector.h"

/* Of the area that a straight middle would give, this share must be left to each quarter beside a chord. */
static const double least_share = 0.15;

/* A side of a plane face. */
struct side {
	idx_t low, high; /* its control points */
	idx_t face, from;
};

static int compare_sides(const void *a, const void *b)
{
	const struct side *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	if (x->high != y->high)
		return x->high < y->high ? -1 : 1;
	return (x->face > y->face) - (x->face < y->face);
}

/* Points where creases end or meet by three, whatever becomes of tangential ones: one more crease changes nothing there. */
static unsigned char *find_corners(const struct draft *draft)
{
	unsigned char *creases = mem_array(draft->control.count, 1);
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		const struct curve *curve = &draft->network.curve[k];
		if (curve->kind == CURVE_SMOOTH || (draft->tangential && draft->tangential[k]) || curve->closed)
			continue;
		for (int end = 0; end < 2; end++) {
			const idx_t point = draft->network.point[curve->first + (end ? curve->count - 1 : 0)];
			if (creases[point] < 3)
				creases[point]++;
		}
	}
	for (size_t i = 0; i < draft->control.count; i++)
		creases[i] = draft->control.role[i] == POINT_CORNER || (creases[i] >= 3 && draft->control.role[i] != POINT_INSIDE);
	return creases;
}

static void face_middle(double middle[3], const struct draft *draft, size_t face)
{
	const size_t low = draft->polygons.start[face], high = draft->polygons.start[face + 1];
	middle[0] = middle[1] = middle[2] = 0;
	for (size_t i = low; i < high; i++)
		add_scaled3(middle, 1.0 / (double)(high - low), &draft->control.xyz[3 * (size_t)draft->polygons.corner[i]]);
}

/* Do the quarters of one face beside the chord a to b keep their side, when its middle goes to m? */
static bool keeps_side(const double a[3], const double b[3], const double m[3], const double middle[3])
{
	double whole[3], first[3], second[3];
	area_vector3(whole, a, b, middle);
	area_vector3(first, a, m, middle);
	area_vector3(second, m, b, middle);
	const double least = least_share / 2 * dot3(whole, whole);
	return dot3(first, whole) > least && dot3(second, whole) > least;
}

void seams_find(struct draft *draft, const struct dense *dense, const unsigned char *all)
{
	const struct polygons *polygons = &draft->polygons;
	unsigned char *corner = find_corners(draft);
	struct edge_set *curves = edge_set_new();
	draft_curve_edges(curves, draft);
	struct side *side = mem_array(polygons->start[polygons->count], sizeof *side);
	size_t sides = 0;
	for (size_t f = 0; f < polygons->count; f++) {
		if (dense->patch[polygons->patch[f]].kind != PATCH_PLANE && !all[polygons->patch[f]])
			continue;
		const size_t low = polygons->start[f], high = polygons->start[f + 1];
		for (size_t i = low; i < high; i++) {
			const idx_t a = polygons->corner[i], b = polygons->corner[i + 1 < high ? i + 1 : low];
			if (((corner[a] && corner[b]) || all[polygons->patch[f]]) && !edge_set_has(curves, a, b))
				side[sides++] = (struct side){a < b ? a : b, a < b ? b : a, (idx_t)f, a};
		}
	}
	qsort(side, sides, sizeof *side, compare_sides);
	free(draft->seam);
	draft->seam = mem_array(3 * (sides / 2), sizeof *draft->seam);
	draft->seam_count = 0;
	for (size_t i = 0; i + 1 < sides; i++) {
		const struct side *s = &side[i], *t = &side[i + 1];
		if (s->low != t->low || s->high != t->high || polygons->patch[s->face] != polygons->patch[t->face])
			continue;
		const idx_t to = s->from == s->low ? s->high : s->low;
		const double *a = &draft->control.xyz[3 * (size_t)s->from], *b = &draft->control.xyz[3 * (size_t)to];
		double one[3], two[3], m[3];
		face_middle(one, draft, (size_t)s->face);
		face_middle(two, draft, (size_t)t->face);
		for (int k = 0; k < 3; k++)
			m[k] = (a[k] + b[k] + one[k] + two[k]) / 4;
		if (!all[polygons->patch[s->face]] && keeps_side(a, b, m, one) && keeps_side(b, a, m, two))
			continue;
		idx_t *seam = &draft->seam[3 * draft->seam_count++];
		seam[0] = s->low, seam[1] = s->high, seam[2] = polygons->patch[s->face];
	}
	edge_set_free(curves);
	free(side), free(corner);
}
