/* Planar faces joined, straight creases thinned, idle vertices dissolved. */
#include "stages/assemble/tidy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/polygon.h"
#include "stages/geometry/vector.h"

/* Joined faces keep at least this much of a regular polygon's smallest sub-quad (polygon_star). */
#define LEAST_STAR 0.05
/* Faces of one plane point the same way: cosine. */
#define SAME_WAY 0.9

static idx_t target_of(const struct polymesh *mesh, idx_t half)
{
	return mesh->origin[mesh->next[half]];
}

/* Number of edges at the start of half-edge h: around its fan. Stops counting at most. */
static size_t valence(const struct polymesh *mesh, idx_t h, size_t most)
{
	size_t count = 1;
	idx_t at = h;
	while (count < most) { /* counter-clockwise */
		const idx_t before = mesh->previous[at];
		at = mesh->twin[before];
		if (at == h)
			return count;
		count++;
		if (at == NO_INDEX)
			break;
	}
	if (at != NO_INDEX)
		return count;
	for (at = h; count < most;) { /* clockwise from h to the other border */
		const idx_t t = mesh->twin[at];
		if (t == NO_INDEX)
			break;
		at = mesh->next[t];
		count++;
	}
	return count;
}

static size_t face_corners(idx_t *corner, const struct polymesh *mesh, idx_t half, size_t most)
{
	size_t count = 0;
	idx_t h = half;
	do {
		if (count == most)
			return most + 1;
		corner[count++] = mesh->origin[h];
		h = mesh->next[h];
	} while (h != half);
	return count;
}

static bool has_repeat(const idx_t *corner, size_t count)
{
	for (size_t i = 0; i < count; i++)
		for (size_t j = i + 1; j < count; j++)
			if (corner[i] == corner[j])
				return true;
	return false;
}

/* Do vertices a and b share an edge? Looks around the fan of half-edge h, which starts at a. */
static bool has_edge(const struct polymesh *mesh, idx_t h, idx_t b)
{
	idx_t at = h;
	do {
		if (target_of(mesh, at) == b || mesh->origin[mesh->previous[at]] == b)
			return true;
		at = mesh->twin[mesh->previous[at]];
	} while (at != NO_INDEX && at != h);
	for (idx_t t = mesh->twin[h]; at == NO_INDEX && t != NO_INDEX; t = mesh->twin[mesh->next[t]])
		if (target_of(mesh, mesh->next[t]) == b)
			return true;
	return false;
}

static bool face_in_plane(const struct polymesh *mesh, idx_t half, const double centre[3], const double normal[3], double planar)
{
	idx_t corner[TIDY_MOST_CORNERS];
	const size_t count = face_corners(corner, mesh, half, TIDY_MOST_CORNERS);
	if (count > TIDY_MOST_CORNERS)
		return false;
	double own_centre[3], own_normal[3];
	polygon_plane(own_centre, own_normal, mesh->xyz, corner, count);
	if (dot3(own_normal, normal) < SAME_WAY)
		return false;
	for (size_t i = 0; i < count; i++) {
		double d[3];
		sub3(d, mesh->xyz + 3 * (size_t)corner[i], centre);
		if (fabs(dot3(d, normal)) > planar)
			return false;
	}
	return true;
}

/* All faces around the start of h, from h both ways up to creases, lie in the plane. */
static bool sector_in_plane(const struct polymesh *mesh, idx_t h, const double centre[3], const double normal[3], double planar)
{
	if (!face_in_plane(mesh, h, centre, normal, planar))
		return false;
	idx_t at = h;
	while (!polymesh_is_crease(mesh, mesh->previous[at])) {
		at = mesh->twin[mesh->previous[at]];
		if (at == h)
			return true;
		if (!face_in_plane(mesh, at, centre, normal, planar))
			return false;
	}
	for (at = h; !polymesh_is_crease(mesh, at);) {
		at = mesh->next[mesh->twin[at]];
		if (!face_in_plane(mesh, at, centre, normal, planar))
			return false;
	}
	return true;
}

/* The chain of edges that the faces of h share around it: from first to last along h's face. False when they share more
 * edges than that chain, or nothing but it. */
static bool shared_chain(idx_t *first, idx_t *last, const struct polymesh *mesh, idx_t h)
{
	const idx_t g = mesh->face[mesh->twin[h]];
	size_t chain = 1, shared = 0, sides = 0;
	*first = *last = h;
	while (chain < TIDY_MOST_CORNERS && mesh->twin[mesh->next[*last]] != NO_INDEX &&
	       mesh->next[mesh->twin[mesh->next[*last]]] == mesh->twin[*last])
		*last = mesh->next[*last], chain++;
	while (chain < TIDY_MOST_CORNERS && mesh->twin[mesh->previous[*first]] != NO_INDEX &&
	       mesh->previous[mesh->twin[mesh->previous[*first]]] == mesh->twin[*first])
		*first = mesh->previous[*first], chain++;
	idx_t at = h;
	do {
		shared += mesh->twin[at] != NO_INDEX && mesh->face[mesh->twin[at]] == g;
		sides++;
		at = mesh->next[at];
	} while (at != h);
	return shared == chain && chain < sides;
}

/* Corners of the union of two faces whose shared chain runs from first to last. */
static size_t union_corners(idx_t *corner, const struct polymesh *mesh, idx_t first, idx_t last)
{
	size_t count = 0;
	for (idx_t h = mesh->next[last]; h != first && count < TIDY_MOST_CORNERS; h = mesh->next[h])
		corner[count++] = mesh->origin[h];
	/* the other face's rest begins where the first face's ended: at the start of the chain */
	for (idx_t h = mesh->next[mesh->twin[first]]; h != mesh->twin[last] && count < TIDY_MOST_CORNERS; h = mesh->next[h])
		corner[count++] = mesh->origin[h];
	return count;
}

/* Take the chain out; the second face goes. */
static void join_faces(struct polymesh *mesh, idx_t first, idx_t last)
{
	const idx_t keep = mesh->face[first], drop = mesh->face[mesh->twin[first]];
	const idx_t a = mesh->previous[first], b = mesh->next[mesh->twin[first]], c = mesh->previous[mesh->twin[last]],
		    d = mesh->next[last];
	for (idx_t h = b; h != mesh->twin[last]; h = mesh->next[h])
		mesh->face[h] = keep;
	for (idx_t h = first;; h = mesh->next[h]) {
		mesh->half_gone[h] = mesh->half_gone[mesh->twin[h]] = true;
		if (h == last)
			break;
	}
	mesh->next[a] = b, mesh->previous[b] = a;
	mesh->next[c] = d, mesh->previous[d] = c;
	mesh->face_half[keep] = d;
	if (mesh->face_patch[drop] < mesh->face_patch[keep])
		mesh->face_patch[keep] = mesh->face_patch[drop];
	mesh->face_half[drop] = NO_INDEX;
}

/* Does the vertex at the start of h stay where it is: an explicit corner, or three or more creases? */
static bool is_kept(const struct polymesh *mesh, idx_t h)
{
	size_t creases = 0;
	idx_t at = h;
	do { /* counter-clockwise */
		creases += polymesh_is_crease(mesh, at);
		const idx_t before = mesh->previous[at];
		at = mesh->twin[before];
		if (at == NO_INDEX)
			creases++; /* the other border edge */
	} while (at != NO_INDEX && at != h);
	if (at == NO_INDEX)
		for (idx_t t = mesh->twin[h]; t != NO_INDEX; t = mesh->twin[at]) { /* clockwise */
			at = mesh->next[t];
			creases += polymesh_is_crease(mesh, at);
		}
	return creases >= 3 || mesh->corner[mesh->origin[h]];
}

/* Would the union turn outward at a vertex that is kept? Only the ends of the chain that goes get another angle. */
static bool fills_a_kink(const struct polymesh *mesh, idx_t first, idx_t last, const idx_t *corner, size_t count, const double normal[3])
{
	const idx_t end[2] = {first, mesh->twin[last]}; /* both start at their end of the chain */
	for (int k = 0; k < 2; k++)
		for (size_t i = 0; i < count; i++)
			if (corner[i] == mesh->origin[end[k]] && polygon_turn_deg(mesh->xyz, corner, count, i, normal) < -POLYGON_REFLEX_DEG && is_kept(mesh, end[k]))
				return true;
	return false;
}

/* Join the faces of h when that changes nothing and leaves them at least as star-shaped as least_star. */
static bool try_join(struct polymesh *mesh, idx_t h, double planar, double least_star)
{
	idx_t first, last, corner[TIDY_MOST_CORNERS];
	if (mesh->half_gone[h] || mesh->face[h] == mesh->face[mesh->twin[h]] || !shared_chain(&first, &last, mesh, h))
		return false;
	for (idx_t e = first;; e = mesh->next[e]) {
		if (polymesh_is_crease(mesh, e))
			return false;
		if (e == last)
			break;
	}
	const size_t n = union_corners(corner, mesh, first, last);
	if (n < 3 || n >= TIDY_MOST_CORNERS || has_repeat(corner, n))
		return false;
	double centre[3], normal[3];
	polygon_plane(centre, normal, mesh->xyz, corner, n);
	if (polygon_star(mesh->xyz, corner, n, normal) < least_star || fills_a_kink(mesh, first, last, corner, n, normal))
		return false;
	/* starts of the chain's end edges: first at one end, the twin of last at the other */
	if (!sector_in_plane(mesh, first, centre, normal, planar) ||
	    !sector_in_plane(mesh, mesh->twin[last], centre, normal, planar))
		return false;
	for (idx_t e = first; e != last; e = mesh->next[e])
		if (!sector_in_plane(mesh, mesh->next[e], centre, normal, planar))
			return false;
	join_faces(mesh, first, last);
	return true;
}

struct candidate {
	double key;
	idx_t half;
};

static int compare_candidates(const void *a, const void *b)
{
	const struct candidate *x = a, *y = b;
	if (x->key != y->key)
		return x->key > y->key ? -1 : 1;
	return (x->half > y->half) - (x->half < y->half);
}

/* Greedy joining ends differently in different orders; which is best depends on the patch. */
struct order {
	int sign;           /* 1: longest edges first, -1: shortest */
	size_t level_count; /* several passes, the first for unions that stay well shaped only */
};
static const struct order order[] = {{1, 1}, {-1, 1}, {1, 5}, {-1, 5}};
enum { ORDER_COUNT = sizeof order / sizeof *order };
static const double level[5] = {LEAST_STAR, 0.1, 0.2, 0.35, 0.5};

/* Smaller of the patches on the sides of h. */
static idx_t patch_of(const struct polymesh *mesh, idx_t h)
{
	const idx_t a = mesh->face_patch[mesh->face[h]], b = mesh->face_patch[mesh->face[mesh->twin[h]]];
	return a < b ? a : b;
}

/* Joins in one order. only (by patch number, or NULL): take edges of patches whose entry is this order. gain (by patch
 * number, or NULL) counts the joins. */
static size_t join_in_order(struct polymesh *mesh, double planar, size_t which, const unsigned char *only, size_t *gain)
{
	struct candidate *candidate = mem_array(mesh->half_count, sizeof *candidate);
	size_t count = 0, joined = 0;
	for (size_t h = 0; h < mesh->half_count; h++)
		if (!mesh->half_gone[h] && !polymesh_is_crease(mesh, (idx_t)h) && mesh->twin[h] > (idx_t)h &&
		    (!only || only[patch_of(mesh, (idx_t)h)] == which))
			candidate[count++] = (struct candidate){
				order[which].sign * distance3(mesh->xyz + 3 * (size_t)mesh->origin[h],
							      mesh->xyz + 3 * (size_t)target_of(mesh, (idx_t)h)),
				(idx_t)h};
	qsort(candidate, count, sizeof *candidate, compare_candidates);
	for (size_t pass = order[which].level_count; pass-- > 0;)
		for (size_t i = 0; i < count; i++) {
			const idx_t h = candidate[i].half;
			if (mesh->half_gone[h])
				continue;
			const idx_t patch = patch_of(mesh, h);
			if (!try_join(mesh, h, planar, level[pass]))
				continue;
			joined++;
			if (gain)
				gain[patch]++;
		}
	free(candidate);
	return joined;
}

/* Every order on a copy, then for each patch the one that joined most (the first of equals). */
static size_t join_planar(struct polymesh *mesh, double planar)
{
	size_t patch_count = 0;
	for (size_t f = 0; f < mesh->face_count; f++)
		if ((size_t)mesh->face_patch[f] >= patch_count)
			patch_count = (size_t)mesh->face_patch[f] + 1;
	unsigned char *best = mem_array(patch_count, 1);
	size_t *most = mem_array(patch_count, sizeof *most), *gain = mem_array(patch_count, sizeof *gain), joined = 0;
	for (size_t which = 0; which < ORDER_COUNT; which++) {
		struct polymesh copy;
		polymesh_copy(&copy, mesh);
		memset(gain, 0, patch_count * sizeof *gain);
		join_in_order(&copy, planar, which, NULL, gain);
		polymesh_free(&copy);
		for (size_t p = 0; p < patch_count; p++)
			if (gain[p] > most[p])
				most[p] = gain[p], best[p] = (unsigned char)which;
	}
	for (size_t which = 0; which < ORDER_COUNT; which++)
		joined += join_in_order(mesh, planar, which, best, NULL);
	free(best), free(most), free(gain);
	return joined;
}

/* Take out vertex v = origin of h, which has two edges: previous of h and h, and their twins when they have some. */
static void drop_vertex(struct polymesh *mesh, idx_t h)
{
	const idx_t p = mesh->previous[h], t = mesh->twin[h];
	/* p takes h's place and runs on to its end */
	mesh->next[p] = mesh->next[h];
	mesh->previous[mesh->next[h]] = p;
	mesh->half_gone[h] = true;
	if (mesh->face_half[mesh->face[p]] == h)
		mesh->face_half[mesh->face[p]] = p;
	if (t != NO_INDEX) { /* t: q -> v, its next v -> p */
		const idx_t u = mesh->next[t];
		mesh->next[t] = mesh->next[u];
		mesh->previous[mesh->next[u]] = t;
		mesh->half_gone[u] = true;
		if (mesh->face_half[mesh->face[t]] == u)
			mesh->face_half[mesh->face[t]] = t;
		mesh->twin[p] = t, mesh->twin[t] = p;
	}
}

static size_t face_size(const struct polymesh *mesh, idx_t half)
{
	size_t count = 0;
	idx_t h = half;
	do {
		count++;
		h = mesh->next[h];
	} while (h != half);
	return count;
}

/* May v = origin of h (two edges) go without a double edge or a face of two vertices? */
static bool may_drop(const struct polymesh *mesh, idx_t h)
{
	const idx_t p = mesh->origin[mesh->previous[h]], q = target_of(mesh, h);
	if (face_size(mesh, h) <= 3 || (mesh->twin[h] != NO_INDEX && face_size(mesh, mesh->twin[h]) <= 3))
		return false;
	return p != q && !has_edge(mesh, mesh->next[h], p);
}

size_t tidy_dissolve(struct polymesh *mesh)
{
	size_t count = 0;
	for (size_t i = 0; i < mesh->half_count; i++) {
		const idx_t h = (idx_t)i;
		if (mesh->half_gone[i] || mesh->twin[h] == NO_INDEX || valence(mesh, h, 3) != 2)
			continue;
		const idx_t p = mesh->previous[h];
		if (mesh->twin[p] == NO_INDEX || polymesh_is_crease(mesh, h) || polymesh_is_crease(mesh, p))
			continue;
		if (may_drop(mesh, h)) {
			drop_vertex(mesh, h);
			count++;
			continue;
		}
		idx_t first, last, corner[TIDY_MOST_CORNERS];
		if (mesh->face[h] == mesh->face[mesh->twin[h]] || !shared_chain(&first, &last, mesh, h))
			continue;
		const size_t n = union_corners(corner, mesh, first, last);
		if (n >= 3 && n < TIDY_MOST_CORNERS && !has_repeat(corner, n)) {
			join_faces(mesh, first, last);
			count++;
		}
	}
	return count;
}

/* One step along a crease: *over is the vertex walked to, *from the one before. Goes on to the next when exactly two creases
 * and no explicit corner are at *over, else returns false. */
static bool walk_crease(idx_t *from, idx_t *over, const struct polymesh *mesh, const idx_t *outgoing)
{
	const idx_t v = *over, start = outgoing[v];
	idx_t end[3];
	size_t count = 0;
	if (mesh->corner[v])
		return false;
	idx_t h = start;
	do {
		if (polymesh_is_crease(mesh, h) && count < 3)
			end[count++] = target_of(mesh, h);
		const idx_t p = mesh->previous[h];
		if (mesh->twin[p] == NO_INDEX && count < 3)
			end[count++] = mesh->origin[p];
		h = mesh->twin[p];
	} while (h != NO_INDEX && h != start);
	if (h == NO_INDEX) /* a border: outgoing lies beside it, the rest of the fan is on the other side */
		for (idx_t t = mesh->twin[start]; t != NO_INDEX; t = mesh->twin[mesh->next[t]])
			if (polymesh_is_crease(mesh, mesh->next[t]) && count < 3)
				end[count++] = target_of(mesh, mesh->next[t]);
	if (count != 2)
		return false;
	const idx_t to = end[0] == *from ? end[1] : end[0];
	*from = v, *over = to;
	return true;
}

/* Does the whole crease through v, between its corners, run straight within planar? */
static bool is_straight(const struct polymesh *mesh, const idx_t *outgoing, idx_t v, idx_t p, idx_t q, double planar)
{
	double direction[3];
	sub3(direction, mesh->xyz + 3 * (size_t)q, mesh->xyz + 3 * (size_t)p);
	if (normalise3(direction) == 0)
		return false;
	for (int side = 0; side < 2; side++) {
		idx_t from = v, at = side ? p : q;
		for (size_t step = 0; step < mesh->vertex_count; step++) {
			double d[3];
			sub3(d, mesh->xyz + 3 * (size_t)at, mesh->xyz + 3 * (size_t)v);
			const double along = dot3(d, direction);
			add_scaled3(d, -along, direction);
			if (norm3(d) > planar || (side ? along >= 0 : along <= 0) || at == v)
				return false;
			if (!walk_crease(&from, &at, mesh, outgoing))
				break;
		}
	}
	return true;
}

static size_t straighten(struct polymesh *mesh, double planar)
{
	idx_t *outgoing = mem_array(mesh->vertex_count, sizeof *outgoing);
	size_t count = 0;
	polymesh_outgoing(outgoing, mesh);
	for (size_t v = 0; v < mesh->vertex_count; v++) {
		idx_t h = outgoing[v];
		if (h == NO_INDEX || mesh->corner[v] || valence(mesh, h, 3) != 2)
			continue;
		const idx_t p = mesh->origin[mesh->previous[h]], q = target_of(mesh, h);
		if (!polymesh_is_crease(mesh, h) || !polymesh_is_crease(mesh, mesh->previous[h]))
			continue;
		if (!may_drop(mesh, h) || !is_straight(mesh, outgoing, (idx_t)v, p, q, planar))
			continue;
		/* both faces stay as good as they were */
		bool good = true;
		const idx_t side[2] = {h, mesh->twin[h]};
		for (int k = 0; k < 2 && good; k++) {
			idx_t corner[TIDY_MOST_CORNERS], kept[TIDY_MOST_CORNERS];
			if (side[k] == NO_INDEX)
				continue;
			const size_t n = face_corners(corner, mesh, side[k], TIDY_MOST_CORNERS);
			if (n > TIDY_MOST_CORNERS) {
				good = false;
				continue;
			}
			size_t m = 0;
			for (size_t i = 0; i < n; i++)
				if (corner[i] != (idx_t)v)
					kept[m++] = corner[i];
			double centre[3], normal[3];
			polygon_plane(centre, normal, mesh->xyz, corner, n);
			good = polygon_flatness(mesh->xyz, corner, n) <= planar &&
			       polygon_star(mesh->xyz, kept, m, normal) >= LEAST_STAR;
			/* Where a face turns outward at a kept vertex, it folds over its own border there, as far as half its sides:
			 * points beside such a vertex are there to keep that small. */
			for (size_t i = 0; i < m && good; i++)
				good = (kept[i] != p && kept[i] != q) || polygon_turn_deg(mesh->xyz, kept, m, i, normal) >= -POLYGON_REFLEX_DEG;
		}
		if (!good)
			continue;
		drop_vertex(mesh, h); /* its half-edges started at v alone, so the others' outgoing ones stay */
		outgoing[v] = NO_INDEX;
		count++;
	}
	free(outgoing);
	return count;
}

void tidy(struct tidy_report *report, struct polymesh *mesh, double planar)
{
	*report = (struct tidy_report){0};
	report->dissolved = tidy_dissolve(mesh);
	for (int round = 0; round < 2; round++) {
		report->merged += join_planar(mesh, planar);
		report->straightened += straighten(mesh, planar);
	}
	report->dissolved += tidy_dissolve(mesh);
}
