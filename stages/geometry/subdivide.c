/* The uniform refiner. Edges are found once, by sorting, on the level that comes in; from there on the edges of the next level
 * follow from those of this one: two halves of each edge and one inner edge a corner (triangles: the edge that cuts the corner;
 * quads: from the midpoint of the corner's edge to the centre). They are numbered in the order of their first corner, as sorting
 * would do, so that n steps at once give the same bytes as n times one step. The corners of the children of a face with corners
 * s .. s + d - 1 are 4 s .. 4 (s + d) - 1 in both splits. */
#include "stages/geometry/subdivide.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/subdivide_mask.h"
#include "stages/geometry/subdivide_room.h"
#include "stages/geometry/subdivide_topology.h"

/* Rules of vertices: entries of the mask table that exist on every level; those of the first levels' vertices follow. */
enum { RULE_CORNER, RULE_CREASE, RULE_TRIANGLES_6, RULE_MIXED_5, RULE_QUADS_4, RULE_FIRST };

/* One side of a crease. */
struct side {
	idx_t first, k, degree; /* of its face: first corner, place of this corner, number of corners */
	idx_t edge, a, b;
	bool is_primary;        /* exactly one side an edge is */
};

/* Faces of equal degree that follow each other. */
struct run {
	size_t degree, face_count;
};

/* Level l with all that is needed to make level l + 1. */
struct refiner {
	enum cage_scheme scheme;
	size_t vertex_count, edge_count, corner_count;
	double *xyz;
	idx_t *corner, *edge;   /* corner_count: vertex and edge of each corner */
	struct side *side;
	size_t side_count;
	struct run *run;
	size_t run_count;
	idx_t *rule;            /* a vertex: entry of mask */
	struct step_mask *mask; /* the whole table, owned by level_refine */
	void *room;             /* where all arrays are that no level_refine hands out */
};

static double *at(double *xyz, size_t vertex)
{
	return xyz + 3 * vertex;
}

/* Numbers of the edges of the next level while they are given out. */
struct numbering {
	idx_t *half;            /* 2 an edge: number + 1 of its half at the lower vertex, then of the other; 0: none yet */
	idx_t count;
};

static inline idx_t number_half(struct numbering *numbering, idx_t edge, bool is_at_higher)
{
	idx_t *slot = numbering->half + 2 * (size_t)edge + is_at_higher;
	if (*slot == 0)
		*slot = ++numbering->count;
	return *slot - 1;
}

/* Children of a face of any degree: a quad (v[k], middle of edge k, centre, middle of the edge before) at each corner. */
static inline void split_to_quads(idx_t *restrict out, const idx_t *v, const idx_t *e, size_t degree, idx_t vertex_count, idx_t centre)
{
	for (size_t k = 0, before = degree - 1; k < degree; before = k++) {
		out[4 * k] = v[k];
		out[4 * k + 1] = vertex_count + e[k];
		out[4 * k + 2] = centre;
		out[4 * k + 3] = vertex_count + e[before];
	}
}

static inline void number_quads(idx_t *restrict out, struct numbering *numbering, const idx_t *v, const idx_t *e, size_t degree)
{
	/* from the first quad's point of view the inner edges come in the order: its own, the last quad's, then one a quad */
	const size_t last = degree - 1;
	for (size_t k = 0, before = last; k < degree; before = k++) {
		const size_t next = k == last ? 0 : k + 1;
		out[4 * k] = number_half(numbering, e[k], v[k] > v[next]);
		if (k < last)
			out[4 * k + 1] = numbering->count++;
		if (k == 0)
			out[4 * last + 1] = numbering->count++;
		out[4 * k + 2] = out[4 * before + 1];
		out[4 * k + 3] = number_half(numbering, e[before], v[k] > v[before]);
	}
}

static inline void split_to_triangles(idx_t *restrict out, const idx_t *v, const idx_t *e, idx_t vertex_count)
{
	for (int k = 0; k < 3; k++) {
		out[3 * k] = v[k];
		out[3 * k + 1] = vertex_count + e[k];
		out[3 * k + 2] = vertex_count + e[(k + 2) % 3];
		out[9 + k] = vertex_count + e[k];
	}
}

static inline void number_triangles(idx_t *restrict out, struct numbering *numbering, const idx_t *v, const idx_t *e)
{
	for (int k = 0; k < 3; k++) {
		const int before = (k + 2) % 3, next = (k + 1) % 3;
		out[3 * k] = number_half(numbering, e[k], v[k] > v[next]);
		out[3 * k + 1] = numbering->count++;
		out[3 * k + 2] = number_half(numbering, e[before], v[k] > v[before]);
		out[9 + before] = out[3 * k + 1]; /* the middle triangle runs from the middle of edge k - 1 to that of edge k past corner k */
	}
}

/* Sums for the masks that one face gives; out is the next level, zero at the start. An edge point is
 * (a + b) / 8 + centre / 8 + (midpoints of the neighbouring edges) / 16 from each face that becomes quads and
 * 3 (a + b) / 16 + c / 8 from each triangle: the rule (1/4; 1/8; 1/16) of a vertex of valence 4, 5 or 6 on the split mesh. */
static void triangle_sums(double *restrict out, const double *restrict xyz, const idx_t *v, const idx_t *e, size_t vertex_count)
{
	const double *a = xyz + 3 * (size_t)v[0], *b = xyz + 3 * (size_t)v[1], *c = xyz + 3 * (size_t)v[2];
	double *va = at(out, (size_t)v[0]), *vb = at(out, (size_t)v[1]), *vc = at(out, (size_t)v[2]);
	double *ab = at(out, vertex_count + (size_t)e[0]), *bc = at(out, vertex_count + (size_t)e[1]), *ca = at(out, vertex_count + (size_t)e[2]);
	for (int i = 0; i < 3; i++) {
		const double x = a[i], y = b[i], z = c[i];
		va[i] += y;
		vb[i] += z;
		vc[i] += x;
		ab[i] += (x + y) * (3.0 / 16) + z * (1.0 / 8);
		bc[i] += (y + z) * (3.0 / 16) + x * (1.0 / 8);
		ca[i] += (z + x) * (3.0 / 16) + y * (1.0 / 8);
	}
}

/* For a quad all that is (a + b) / 8 + centre / 4. */
static void quad_sums(double *restrict out, const double *restrict xyz, const idx_t *v, const idx_t *e, size_t vertex_count, size_t centre)
{
	const double *a = xyz + 3 * (size_t)v[0], *b = xyz + 3 * (size_t)v[1], *c = xyz + 3 * (size_t)v[2], *d = xyz + 3 * (size_t)v[3];
	double *va = at(out, (size_t)v[0]), *vb = at(out, (size_t)v[1]), *vc = at(out, (size_t)v[2]), *vd = at(out, (size_t)v[3]);
	double *ab = at(out, vertex_count + (size_t)e[0]), *bc = at(out, vertex_count + (size_t)e[1]);
	double *cd = at(out, vertex_count + (size_t)e[2]), *da = at(out, vertex_count + (size_t)e[3]), *m = at(out, centre);
	for (int i = 0; i < 3; i++) {
		const double x = a[i], y = b[i], z = c[i], w = d[i], s = ((x + z) + (y + w)) * (1.0 / 4), q = s * (1.0 / 4);
		va[i] += y + s;
		vb[i] += z + s;
		vc[i] += w + s;
		vd[i] += x + s;
		ab[i] += (x + y) * (1.0 / 8) + q;
		bc[i] += (y + z) * (1.0 / 8) + q;
		cd[i] += (z + w) * (1.0 / 8) + q;
		da[i] += (w + x) * (1.0 / 8) + q;
		m[i] = s;
	}
}

/* Degree above 4, or a triangle under Catmull-Clark, whose edge points are (a + b + both centres) / 4. */
static void polygon_sums(double *restrict out, const double *restrict xyz, const idx_t *v, const idx_t *e, size_t degree,
                         size_t vertex_count, size_t centre, enum cage_scheme scheme)
{
	double s[3] = {0, 0, 0};
	for (size_t k = 0; k < degree; k++)
		for (int i = 0; i < 3; i++)
			s[i] += xyz[3 * (size_t)v[k] + (size_t)i];
	for (int i = 0; i < 3; i++)
		at(out, centre)[i] = s[i] /= (double)degree;
	for (size_t k = 0; k < degree; k++) {
		const size_t before = (k + degree - 1) % degree, next = (k + 1) % degree, after = (k + 2) % degree;
		const double *a = xyz + 3 * (size_t)v[k], *b = xyz + 3 * (size_t)v[next];
		const double *p = xyz + 3 * (size_t)v[before], *q = xyz + 3 * (size_t)v[after];
		double *va = at(out, (size_t)v[k]), *ab = at(out, vertex_count + (size_t)e[k]);
		for (int i = 0; i < 3; i++) {
			va[i] += b[i] + s[i];
			ab[i] += (a[i] + b[i]) * (1.0 / 8);
			ab[i] += scheme == SCHEME_CATMULLCLARK ? s[i] * (1.0 / 4) : s[i] * (1.0 / 8) + ((a[i] + b[i]) + (p[i] + q[i])) * (1.0 / 32);
		}
	}
}

/* Crease points from creases alone, corners stay, the others by their masks. */
static void finish_positions(double *restrict out, const struct refiner *r)
{
	for (size_t s = 0; s < r->side_count; s++) {
		const struct side *side = r->side + s;
		const double *a = at(r->xyz, (size_t)side->a), *b = at(r->xyz, (size_t)side->b);
		double *ab = at(out, r->vertex_count + (size_t)side->edge);
		for (int i = 0; i < 3; i++) {
			ab[i] = (a[i] + b[i]) * (1.0 / 2);
			if (r->rule[side->a] == RULE_CREASE)
				at(out, (size_t)side->a)[i] = 0;
			if (r->rule[side->b] == RULE_CREASE)
				at(out, (size_t)side->b)[i] = 0;
		}
	}
	for (size_t s = 0; s < r->side_count; s++) {
		const struct side *side = r->side + s;
		const idx_t end[2] = {side->a, side->b};
		for (int k = 0; side->is_primary && k < 2; k++)
			if (r->rule[end[k]] == RULE_CREASE)
				for (int i = 0; i < 3; i++)
					at(out, (size_t)end[k])[i] += at(r->xyz, (size_t)end[1 - k])[i];
	}
	for (size_t v = 0; v < r->vertex_count; v++) {
		const struct step_mask m = r->mask[r->rule[v]];
		const double *p = at(r->xyz, v);
		double *q = at(out, v);
		for (int i = 0; i < 3; i++)
			q[i] = p[i] + m.beta * (q[i] - m.count * p[i]);
	}
}

/* The sides of the halves of every crease, into out->side. numbering NULL: their edges are not needed. */
static void split_sides(struct refiner *out, const struct refiner *r, struct numbering *numbering)
{
	out->side_count = 2 * r->side_count;
	for (size_t s = 0; s < r->side_count; s++) {
		const struct side g = r->side[s];
		const idx_t d = splits_to_quads((size_t)g.degree, r->scheme) ? 4 : 3, middle = (idx_t)r->vertex_count + g.edge;
		const idx_t half[2] = {numbering ? number_half(numbering, g.edge, g.a > g.b) : NO_INDEX,
		                       numbering ? number_half(numbering, g.edge, g.b > g.a) : NO_INDEX};
		out->side[2 * s] = (struct side){4 * g.first + d * g.k, 0, d, half[0], g.a, middle, g.is_primary};
		out->side[2 * s + 1] =
		        (struct side){4 * g.first + d * ((g.k + 1) % g.degree), d - 1, d, half[1], middle, g.b, g.is_primary};
	}
}

/* One step. first_centre_mask: entry of the mask table for the first centre of a face, those of the others follow it; or
 * RULE_QUADS_4 for all. When is_last, what only the next step needs is left out. */
static void refine_once(struct refiner *out, const struct refiner *r, bool is_last, idx_t first_centre_mask)
{
	size_t centre_count = 0;
	for (size_t i = 0; i < r->run_count; i++)
		if (splits_to_quads(r->run[i].degree, r->scheme))
			centre_count += r->run[i].face_count;
	const size_t v_count = r->vertex_count;
	*out = (struct refiner){.scheme = r->scheme,
	                        .vertex_count = v_count + r->edge_count + centre_count,
	                        .edge_count = 2 * r->edge_count + r->corner_count,
	                        .corner_count = 4 * r->corner_count,
	                        .mask = r->mask};
	struct numbering numbering = {0};
	size_t room = room_piece(2 * r->side_count, sizeof *out->side);
	if (!is_last)
		room += room_piece(3 * out->vertex_count, sizeof *out->xyz) + 2 * room_piece(out->corner_count, sizeof *out->corner) +
		        room_piece(out->vertex_count, sizeof *out->rule) + room_piece(r->run_count, sizeof *out->run) +
		        room_piece(2 * r->edge_count, sizeof *numbering.half);
	unsigned char *next = out->room = room_array(room, 1);
	out->side = room_take(&next, 2 * r->side_count, sizeof *out->side);
	if (is_last) {
		out->xyz = room_array(3 * out->vertex_count, sizeof *out->xyz);
		out->corner = room_array(out->corner_count, sizeof *out->corner);
	} else {
		out->xyz = room_take(&next, 3 * out->vertex_count, sizeof *out->xyz);
		out->corner = room_take(&next, out->corner_count, sizeof *out->corner);
		out->edge = room_take(&next, out->corner_count, sizeof *out->edge);
		out->rule = room_take(&next, out->vertex_count, sizeof *out->rule);
		out->run = room_take(&next, r->run_count, sizeof *out->run);
		numbering.half = room_take(&next, 2 * r->edge_count, sizeof *numbering.half);
		memset(numbering.half, 0, 2 * r->edge_count * sizeof *numbering.half);
		memcpy(out->rule, r->rule, v_count * sizeof *out->rule);
		for (size_t i = v_count; i < v_count + r->edge_count; i++)
			out->rule[i] = RULE_QUADS_4; /* one less for each triangle at the edge */
		for (size_t i = 0; i < centre_count; i++)
			out->rule[v_count + r->edge_count + i] = first_centre_mask == RULE_QUADS_4 ? RULE_QUADS_4 : first_centre_mask + (idx_t)i;
	}
	/* sums start at nothing, centres are not summed up */
	memset(out->xyz, 0, 3 * (v_count + r->edge_count) * sizeof *out->xyz);
	size_t h = 0, centre = v_count + r->edge_count;
	for (size_t i = 0; i < r->run_count; i++) {
		const size_t degree = r->run[i].degree;
		const bool quads = splits_to_quads(degree, r->scheme);
		for (size_t f = 0; f < r->run[i].face_count; f++, h += degree) {
			const idx_t *v = r->corner + h, *e = r->edge + h;
			if (!quads) {
				triangle_sums(out->xyz, r->xyz, v, e, v_count);
				split_to_triangles(out->corner + 4 * h, v, e, (idx_t)v_count);
				if (is_last)
					continue;
				number_triangles(out->edge + 4 * h, &numbering, v, e);
				for (int k = 0; k < 3; k++)
					out->rule[v_count + (size_t)e[k]]--;
				continue;
			}
			if (degree == 4)
				quad_sums(out->xyz, r->xyz, v, e, v_count, centre);
			else
				polygon_sums(out->xyz, r->xyz, v, e, degree, v_count, centre, r->scheme);
			split_to_quads(out->corner + 4 * h, v, e, degree, (idx_t)v_count, (idx_t)centre++);
			if (!is_last)
				number_quads(out->edge + 4 * h, &numbering, v, e, degree);
		}
		if (!is_last) {
			const size_t d = quads ? 4 : 3, count = r->run[i].face_count * (quads ? degree : 4);
			if (out->run_count > 0 && out->run[out->run_count - 1].degree == d)
				out->run[out->run_count - 1].face_count += count;
			else
				out->run[out->run_count++] = (struct run){d, count};
		}
	}
	finish_positions(out->xyz, r);
	split_sides(out, r, is_last ? NULL : &numbering);
	if (!is_last)
		for (size_t s = 0; s < r->side_count; s++)
			out->rule[v_count + (size_t)r->side[s].edge] = RULE_CREASE;
}

/* The level that comes in, with its edges, creases, runs and masks; room for centre_count masks of first centres. */
static void refiner_start(struct refiner *r, const struct level *in, enum cage_scheme scheme)
{
	struct topology t;
	topology_build(&t, in, scheme);
	*r = (struct refiner){.scheme = scheme,
	                      .vertex_count = in->vertex_count,
	                      .edge_count = t.edge_count,
	                      .corner_count = in->face_start[in->face_count]};
	size_t sides = 0;
	for (size_t h = 0; h < r->corner_count; h++)
		sides += t.crease[t.edge[h]];
	unsigned char *next = r->room =
	        room_array(room_piece(3 * r->vertex_count, sizeof *r->xyz) + 2 * room_piece(r->corner_count, sizeof *r->corner) +
	                           room_piece(sides, sizeof *r->side) + room_piece(in->face_count, sizeof *r->run) +
	                           room_piece(r->vertex_count, sizeof *r->rule),
	                   1);
	r->xyz = room_take(&next, 3 * r->vertex_count, sizeof *r->xyz);
	r->corner = room_take(&next, r->corner_count, sizeof *r->corner);
	r->edge = room_take(&next, r->corner_count, sizeof *r->edge);
	r->side = room_take(&next, sides, sizeof *r->side);
	r->run = room_take(&next, in->face_count, sizeof *r->run);
	r->rule = room_take(&next, r->vertex_count, sizeof *r->rule);
	if (r->corner_count > 0) {
		memcpy(r->xyz, in->xyz, 3 * r->vertex_count * sizeof *r->xyz);
		memcpy(r->corner, in->face_corner, r->corner_count * sizeof *r->corner);
		memcpy(r->edge, t.edge, r->corner_count * sizeof *r->edge);
	}
	for (size_t f = 0; f < in->face_count; f++) {
		const size_t degree = in->face_start[f + 1] - in->face_start[f];
		if (r->run_count == 0 || r->run[r->run_count - 1].degree != degree)
			r->run[r->run_count++] = (struct run){degree, 0};
		r->run[r->run_count - 1].face_count++;
	}
	for (size_t h = 0; h < r->corner_count; h++) {
		if (!t.crease[t.edge[h]])
			continue;
		const size_t first = in->face_start[t.face[h]], degree = in->face_start[t.face[h] + 1] - first;
		r->side[r->side_count++] = (struct side){(idx_t)first,
		                                         (idx_t)(h - first),
		                                         (idx_t)degree,
		                                         t.edge[h],
		                                         in->face_corner[h],
		                                         in->face_corner[corner_next(in, &t, h)],
		                                         t.half[2 * (size_t)t.edge[h]] == (idx_t)h};
	}
	/* one mask a vertex, then one a centre of the faces that come in; valence and quads stay what they are on all levels */
	r->mask = mem_array(RULE_FIRST + in->vertex_count + in->face_count, sizeof *r->mask);
	r->mask[RULE_CORNER] = step_mask_corner();
	r->mask[RULE_CREASE] = step_mask_crease();
	r->mask[RULE_TRIANGLES_6] = step_mask_smooth(6, 0);
	r->mask[RULE_MIXED_5] = step_mask_smooth(5, 2);
	r->mask[RULE_QUADS_4] = step_mask_smooth(4, 4);
	size_t mask_count = RULE_FIRST;
	for (size_t v = 0; v < in->vertex_count; v++) {
		if (t.kind[v] == KIND_CORNER || t.kind[v] == KIND_CREASE) {
			r->rule[v] = t.kind[v] == KIND_CORNER ? RULE_CORNER : RULE_CREASE;
		} else if (t.valence[v] == 4 && t.quads[v] == 4) {
			r->rule[v] = RULE_QUADS_4;
		} else if (t.valence[v] == 6 && t.quads[v] == 0) {
			r->rule[v] = RULE_TRIANGLES_6;
		} else {
			r->mask[mask_count] = step_mask_smooth((size_t)t.valence[v], (size_t)t.quads[v]);
			r->rule[v] = (idx_t)mask_count++;
		}
	}
	const size_t first_centre = RULE_FIRST + in->vertex_count;
	for (size_t f = 0, centre = 0; f < in->face_count; f++) {
		const size_t degree = in->face_start[f + 1] - in->face_start[f];
		if (splits_to_quads(degree, scheme))
			r->mask[first_centre + centre++] = step_mask_smooth(degree, degree);
	}
	topology_free(&t);
}

/* Faces and corners of the children of a face of this degree after so many steps. */
static size_t face_children(size_t degree, enum cage_scheme scheme, int steps)
{
	if (steps == 0)
		return 1;
	return splits_to_quads(degree, scheme) ? degree << (2 * (steps - 1)) : (size_t)1 << (2 * steps);
}

void level_refined_size(size_t *vertices, size_t *faces, size_t *corners, const struct level *in, enum cage_scheme scheme, int steps)
{
	size_t v = in->vertex_count, c = in->face_start[in->face_count], triangles = 0, others = 0;
	for (size_t f = 0; f < in->face_count; f++)
		if (splits_to_quads(in->face_start[f + 1] - in->face_start[f], scheme))
			others++;
		else
			triangles++;
	struct topology t = {0};
	if (steps > 0)
		topology_build(&t, in, scheme);
	size_t e = t.edge_count;
	topology_free(&t);
	bool fits = true;
	for (int s = 0; s < steps && c > 0 && fits; s++) {
		/* corners are the most numerous, at least two a new edge */
		fits = c <= INDEX_LIMIT / 4;
		v += e + others;
		e = 2 * e + c;
		others = c - 3 * triangles; /* every corner of a polygon becomes a quad */
		triangles *= 4;
		c *= 4;
	}
	if (vertices)
		*vertices = fits ? v : SIZE_MAX;
	if (faces)
		*faces = fits ? triangles + others : SIZE_MAX;
	if (corners)
		*corners = fits ? c : SIZE_MAX;
}

/* Faces of the last level: where their corners start, and which face they come from. */
static void set_faces(struct level *out, const struct level *in, enum cage_scheme scheme, int steps)
{
	for (size_t f = 0; f < in->face_count; f++)
		out->face_count += face_children(in->face_start[f + 1] - in->face_start[f], scheme, steps);
	out->face_start = room_array(out->face_count + 1, sizeof *out->face_start);
	out->face_origin = room_array(out->face_count, sizeof *out->face_origin);
	size_t *restrict face_start = out->face_start;
	idx_t *restrict face_origin = out->face_origin;
	size_t start = 0;
	for (size_t f = 0; f < in->face_count; f++) {
		const size_t degree = in->face_start[f + 1] - in->face_start[f], count = face_children(degree, scheme, steps);
		const size_t stride = steps == 0 ? degree : splits_to_quads(degree, scheme) ? 4 : 3;
		for (size_t k = 0; k < count; k++)
			face_start[k] = start + k * stride;
		for (size_t k = 0; k < count; k++)
			face_origin[k] = in->face_origin[f];
		face_start += count;
		face_origin += count;
		start += count * stride;
	}
	*face_start = start;
}

void level_refine(struct level *out, const struct level *in, enum cage_scheme scheme, int steps)
{
	memset(out, 0, sizeof *out);
	struct refiner r;
	refiner_start(&r, in, scheme);
	struct step_mask *mask = r.mask;
	for (int s = 0; s < steps; s++) {
		assert(r.corner_count <= INDEX_LIMIT / 4);
		struct refiner next;
		refine_once(&next, &r, s == steps - 1, s == 0 ? (idx_t)(RULE_FIRST + in->vertex_count) : RULE_QUADS_4);
		free(r.room);
		r = next;
	}
	out->vertex_count = r.vertex_count;
	out->xyz = steps > 0 ? r.xyz : mem_copy(r.xyz, 3 * r.vertex_count, sizeof *r.xyz);
	out->face_corner = steps > 0 ? r.corner : mem_copy(r.corner, r.corner_count, sizeof *r.corner);
	out->corner = room_zeroed(out->vertex_count, 1);
	for (size_t v = 0; v < in->vertex_count; v++)
		out->corner[v] = in->corner[v];
	out->sharp = room_zeroed(r.corner_count, 1);
	for (size_t s = 0; s < r.side_count; s++)
		out->sharp[r.side[s].first + r.side[s].k] = 1;
	set_faces(out, in, scheme, steps);
	free(r.room);
	free(mask);
}
