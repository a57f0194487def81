/* Planar faces joined, straight creases thinned, idle vertices dissolved. */
#include "stages/assemble/tidy.h"

#include <math.h>
#include <stdlib.h>

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
	while (chain < TIDY_MOST_CORNERS && mesh->twin[mesh->next[*last]] != NO_INDEX && mesh->next[mesh->twin[mesh->next[*last]]] == mesh->twin[*last])
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
	const idx_t a = mesh->previous[first], b = mesh->next[mesh->twin[first]], c = mesh->previous[mesh->twin[last]], d = mesh->next[last];
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

struct candidate {
	double length;
	idx_t half;
};

static int compare_candidates(const void *a, const void *b)
{
	const struct candidate *x = a, *y = b;
	if (x->length != y->length)
		return x->length > y->length ? -1 : 1;
	return (x->half > y->half) - (x->half < y->half);
}

/* Longest edges first: they are the ones that cut faces into slivers. */
static size_t join_planar(struct polymesh *mesh, double planar)
{
	struct candidate *candidate = mem_array(mesh->half_count, sizeof *candidate);
	size_t count = 0, joined = 0;
	for (size_t h = 0; h < mesh->half_count; h++)
		if (!mesh->half_gone[h] && !polymesh_is_crease(mesh, (idx_t)h) && mesh->twin[h] > (idx_t)h)
			candidate[count++] = (struct candidate){
				distance3(mesh->xyz + 3 * (size_t)mesh->origin[h], mesh->xyz + 3 * (size_t)target_of(mesh, (idx_t)h)), (idx_t)h};
	qsort(candidate, count, sizeof *candidate, compare_candidates);
	for (size_t i = 0; i < count; i++) {
		const idx_t h = candidate[i].half;
		idx_t first, last, corner[TIDY_MOST_CORNERS];
		if (mesh->half_gone[h] || mesh->face[h] == mesh->face[mesh->twin[h]] || !shared_chain(&first, &last, mesh, h))
			continue;
		bool creased = false;
		for (idx_t e = first; !creased; e = mesh->next[e]) {
			creased = polymesh_is_crease(mesh, e);
			if (e == last)
				break;
		}
		if (creased)
			continue;
		const size_t n = union_corners(corner, mesh, first, last);
		if (n < 3 || n >= TIDY_MOST_CORNERS || has_repeat(corner, n))
			continue;
		double centre[3], normal[3];
		polygon_plane(centre, normal, mesh->xyz, corner, n);
		if (polygon_star(mesh->xyz, corner, n, normal) < LEAST_STAR)
			continue;
		/* starts of the chain's end edges: first at one end, the twin of last at the other */
		if (!sector_in_plane(mesh, first, centre, normal, planar) || !sector_in_plane(mesh, mesh->twin[last], centre, normal, planar))
			continue;
		bool inner_flat = true;
		for (idx_t e = first; e != last && inner_flat; e = mesh->next[e])
			inner_flat = sector_in_plane(mesh, mesh->next[e], centre, normal, planar);
		if (!inner_flat)
			continue;
		join_faces(mesh, first, last);
		joined++;
	}
	free(candidate);
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
			good = polygon_flatness(mesh->xyz, corner, n) <= planar && polygon_star(mesh->xyz, kept, m, normal) >= LEAST_STAR;
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
