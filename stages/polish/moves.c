#include "stages/polish/moves.h"

#include <stdlib.h>
#include <string.h>

#define MOST_DEGREE 40 /* a larger face is a bad shape for the rules, and nothing is won by it */

void move_trace_free(struct move_trace *trace)
{
	free(trace->face), free(trace->touched);
	*trace = (struct move_trace){0};
}

idx_t *sketch_index(const struct sketch *s)
{
	idx_t *index = mem_array((size_t)s->next_id, sizeof *index);
	memset(index, -1, (size_t)s->next_id * sizeof *index);
	for (size_t v = 0; v < s->vertex_count; v++)
		index[s->id[v]] = (idx_t)v;
	return index;
}

/* --- the edited copy, polygon by polygon ------------------------------------------------------------------------------ */

/* What an edit has to say: old faces that go, polygons that come (indices of old vertices, then new ones), vertices that become others. */
struct edit {
	const struct sketch *in;
	unsigned char *gone;          /* an old face */
	idx_t rename_from, rename_to; /* a collapse */
	idx_t dissolve[2 * MOST_DEGREE];
	size_t dissolve_count;
	struct polygon {
		idx_t vertex[MOST_DEGREE];
		unsigned char sharp[MOST_DEGREE]; /* of the edge to the next */
		size_t degree;
		idx_t patch;
	} polygon[4];
	size_t polygon_count;
	double new_xyz[3];
	bool has_new, new_corner;
	idx_t touched[4 * MOST_DEGREE]; /* old vertices, or vertex_count for the new one */
	size_t touched_count;
	bool is_good;
};

static void touch(struct edit *e, idx_t v)
{
	for (size_t i = 0; i < e->touched_count; i++)
		if (e->touched[i] == v)
			return;
	if (e->touched_count < sizeof e->touched / sizeof *e->touched)
		e->touched[e->touched_count++] = v;
}

static struct polygon *new_polygon(struct edit *e, idx_t patch)
{
	struct polygon *p = &e->polygon[e->polygon_count++];
	p->degree = 0, p->patch = patch;
	return p;
}

static void append(struct edit *e, struct polygon *p, idx_t vertex, unsigned char sharp)
{
	if (p->degree == MOST_DEGREE) {
		e->is_good = false;
		return;
	}
	p->vertex[p->degree] = vertex, p->sharp[p->degree++] = sharp;
}

/* Corners of a face from half-edge `from` on, `count` of them. */
static void append_run(struct edit *e, struct polygon *p, idx_t from, size_t count)
{
	for (idx_t h = from; count > 0; count--, h = sketch_next(e->in, h))
		append(e, p, e->in->face_corner[h], e->in->sharp[h]);
}

static bool is_dissolved(const struct edit *e, idx_t v)
{
	for (size_t i = 0; i < e->dissolve_count; i++)
		if (e->dissolve[i] == v)
			return true;
	return false;
}

/* A smooth vertex inside that keeps two edges once `lost` of its edges are gone: it would not be one any more. */
static void dissolve_if_bare(struct edit *e, idx_t v, size_t lost)
{
	const struct sketch_star star = sketch_star(e->in, v);
	if (!star.on_border && star.valence == lost + 2 && star.sharp == 0 && e->dissolve_count < 2 * MOST_DEGREE)
		e->dissolve[e->dissolve_count++] = v;
}

/* Writes a polygon to the copy: renamed, without dissolved vertices and without edges of no length. Returns false when a vertex comes
 * twice; *degree 0 when nothing is left of it. */
static bool clean_polygon(struct polygon *p, const struct edit *e)
{
	size_t count = 0;
	for (size_t i = 0; i < p->degree; i++) {
		idx_t v = p->vertex[i];
		if (e->rename_from != NO_INDEX && v == e->rename_from)
			v = e->rename_to;
		if (is_dissolved(e, v))
			continue;
		if (count > 0 && p->vertex[count - 1] == v) {
			p->sharp[count - 1] = p->sharp[i]; /* the edge between the two was the collapsed one */
			continue;
		}
		p->vertex[count] = v, p->sharp[count++] = p->sharp[i];
	}
	while (count > 1 && p->vertex[0] == p->vertex[count - 1])
		count--;
	for (size_t i = 0; i < count; i++)
		for (size_t j = i + 1; j < count; j++)
			if (p->vertex[i] == p->vertex[j])
				return false;
	p->degree = count;
	return true;
}

struct copy {
	struct sketch *out;
	size_t corner_count;
	idx_t (*fold)[3]; /* edges of faces that became a line: their two sides are one edge now, sharp if one was */
	size_t fold_count;
};

static void write_face(struct copy *c, const struct polygon *p, idx_t id)
{
	struct sketch *out = c->out;
	for (size_t i = 0; i < p->degree; i++) {
		out->face_corner[c->corner_count] = p->vertex[i];
		out->sharp[c->corner_count++] = p->sharp[i];
	}
	out->face_patch[out->face_count] = p->patch;
	out->face_id[out->face_count] = id >= 0 ? id : out->next_face_id++;
	out->face_start[++out->face_count] = c->corner_count;
}

static bool write_polygon(struct copy *c, struct polygon *p, const struct edit *e)
{
	if (!clean_polygon(p, e))
		return false;
	if (p->degree > 2)
		write_face(c, p, -1);
	else if (p->degree == 2 && (p->sharp[0] || p->sharp[1]))
		c->fold[c->fold_count][0] = p->vertex[0], c->fold[c->fold_count][1] = p->vertex[1], c->fold_count++;
	return true;
}

/* Drop vertices that no face uses; *map: new index by old. */
static void compact(struct sketch *out, idx_t *map)
{
	memset(map, -1, out->vertex_count * sizeof *map);
	for (size_t h = 0; h < out->face_start[out->face_count]; h++)
		map[out->face_corner[h]] = 0;
	size_t count = 0;
	for (size_t v = 0; v < out->vertex_count; v++) {
		if (map[v] == NO_INDEX)
			continue;
		map[v] = (idx_t)count;
		memmove(&out->xyz[3 * count], &out->xyz[3 * v], 3 * sizeof *out->xyz);
		out->id[count] = out->id[v], out->corner[count] = out->corner[v];
		count++;
	}
	out->vertex_count = count;
	for (size_t h = 0; h < out->face_start[out->face_count]; h++)
		out->face_corner[h] = map[out->face_corner[h]];
}

/* Edge flags that the twins of folded faces' sides carried. */
static void sharpen_folds(const struct copy *c, const idx_t *map)
{
	for (size_t i = 0; i < c->fold_count; i++) {
		const idx_t a = map[c->fold[i][0]], b = map[c->fold[i][1]];
		for (size_t h = 0, f = 0; h < c->corner_count; h++) {
			while (c->out->face_start[f + 1] <= h)
				f++;
			const size_t n = h + 1 == c->out->face_start[f + 1] ? c->out->face_start[f] : h + 1;
			if ((c->out->face_corner[h] == a && c->out->face_corner[n] == b) || (c->out->face_corner[h] == b && c->out->face_corner[n] == a))
				c->out->sharp[h] = 1;
		}
	}
}

static bool has_changed_face(const struct edit *e, size_t f)
{
	if (e->gone[f])
		return true;
	for (size_t h = e->in->face_start[f]; h < e->in->face_start[f + 1]; h++) {
		const idx_t v = e->in->face_corner[h];
		if (v == e->rename_from || is_dissolved(e, v))
			return true;
	}
	return false;
}

static long euler(const struct sketch *s) { return (long)s->vertex_count + (long)s->face_count - (long)sketch_edge_count(s); }

static bool build(struct sketch *out, struct move_trace *trace, struct edit *e)
{
	const struct sketch *in = e->in;
	size_t extra = 0;
	for (size_t i = 0; i < e->polygon_count; i++)
		extra += e->polygon[i].degree;
	const size_t halves = in->face_start[in->face_count] + extra, vertices = in->vertex_count + 1;
	*out = (struct sketch){.scheme = in->scheme, .vertex_count = in->vertex_count + e->has_new, .next_id = in->next_id + e->has_new,
	                       .next_face_id = in->next_face_id};
	out->xyz = mem_resize(NULL, 3 * vertices, sizeof *out->xyz);
	memcpy(out->xyz, in->xyz, 3 * in->vertex_count * sizeof *out->xyz);
	out->id = mem_resize(NULL, vertices, sizeof *out->id);
	memcpy(out->id, in->id, in->vertex_count * sizeof *out->id);
	out->corner = mem_resize(NULL, vertices, 1);
	memcpy(out->corner, in->corner, in->vertex_count);
	if (e->has_new) {
		memcpy(&out->xyz[3 * in->vertex_count], e->new_xyz, sizeof e->new_xyz);
		out->id[in->vertex_count] = in->next_id, out->corner[in->vertex_count] = e->new_corner;
	}
	if (e->rename_to != NO_INDEX) {
		memcpy(&out->xyz[3 * (size_t)e->rename_to], e->new_xyz, sizeof e->new_xyz);
		out->corner[e->rename_to] = e->new_corner;
	}
	const size_t faces = in->face_count + e->polygon_count;
	out->face_start = mem_array(faces + 1, sizeof *out->face_start);
	out->face_corner = mem_array(halves, sizeof *out->face_corner);
	out->sharp = mem_array(halves, 1);
	out->face_patch = mem_array(faces, sizeof *out->face_patch);
	out->face_id = mem_array(faces, sizeof *out->face_id);
	trace->face = mem_array(in->face_count, sizeof *trace->face);
	struct copy c = {.out = out, .fold = mem_array(in->face_count + 4, sizeof *c.fold)};
	bool is_good = e->is_good;
	for (size_t f = 0; f < in->face_count && is_good; f++) {
		trace->face[f] = NO_INDEX;
		if (e->gone[f])
			continue;
		const size_t degree = sketch_degree(in, (idx_t)f);
		if (has_changed_face(e, f)) {
			struct polygon p = {.patch = in->face_patch[f]};
			is_good = degree <= MOST_DEGREE;
			if (is_good)
				append_run(e, &p, (idx_t)in->face_start[f], degree);
			is_good = is_good && write_polygon(&c, &p, e);
			continue;
		}
		trace->face[f] = (idx_t)out->face_count;
		memcpy(out->face_corner + c.corner_count, in->face_corner + in->face_start[f], degree * sizeof *out->face_corner);
		memcpy(out->sharp + c.corner_count, in->sharp + in->face_start[f], degree);
		out->face_patch[out->face_count] = in->face_patch[f];
		out->face_id[out->face_count] = in->face_id[f];
		c.corner_count += degree;
		out->face_start[++out->face_count] = c.corner_count;
	}
	for (size_t i = 0; i < e->polygon_count && is_good; i++)
		is_good = write_polygon(&c, &e->polygon[i], e);
	idx_t *map = mem_array(vertices, sizeof *map);
	if (is_good) {
		compact(out, map);
		sharpen_folds(&c, map);
		is_good = sketch_connect(out) && euler(out) == euler(in);
		if (is_good && out->scheme == SCHEME_LOOP)
			for (size_t f = 0; f < out->face_count && is_good; f++)
				is_good = sketch_degree(out, (idx_t)f) == 3;
	}
	if (is_good) {
		trace->touched = mem_array(e->touched_count + 1, sizeof *trace->touched);
		for (size_t i = 0; i < e->touched_count; i++) {
			const idx_t v = e->touched[i] == e->rename_from ? e->rename_to : e->touched[i];
			if (v == NO_INDEX || map[v] == NO_INDEX)
				continue;
			size_t k = 0;
			while (k < trace->touched_count && trace->touched[k] != map[v])
				k++;
			if (k == trace->touched_count)
				trace->touched[trace->touched_count++] = map[v];
		}
	}
	free(map), free(c.fold);
	if (!is_good) {
		sketch_free(out);
		move_trace_free(trace);
	}
	return is_good;
}

/* --- the moves ------------------------------------------------------------------------------------------------------------ */

/* Both faces of smooth edge h as one polygon without the edge, starting at its head in h's face. */
static struct polygon *join(struct edit *e, idx_t h)
{
	const struct sketch *in = e->in;
	const idx_t t = in->twin[h], f = in->face[h], g = in->face[t];
	e->gone[f] = e->gone[g] = 1;
	struct polygon *p = new_polygon(e, in->face_patch[f]);
	append_run(e, p, sketch_next(in, h), sketch_degree(in, f) - 1);
	append_run(e, p, sketch_next(in, t), sketch_degree(in, g) - 1);
	return p;
}

static bool is_inner_smooth(const struct sketch *s, idx_t h) { return h != NO_INDEX && !s->sharp[h] && s->twin[h] != NO_INDEX && s->face[h] != s->face[s->twin[h]]; }

static void touch_polygon(struct edit *e, const struct polygon *p)
{
	for (size_t i = 0; i < p->degree; i++)
		touch(e, p->vertex[i]);
}

static bool merge(struct edit *e, idx_t h)
{
	const struct sketch *in = e->in;
	if (!is_inner_smooth(in, h))
		return false;
	touch_polygon(e, join(e, h));
	dissolve_if_bare(e, in->face_corner[h], 1);
	dissolve_if_bare(e, sketch_head(in, h), 1);
	return true;
}

static bool remove_vertex(struct edit *e, idx_t v)
{
	const struct sketch *in = e->in;
	const struct sketch_star star = sketch_star(in, v);
	if (star.on_border || star.sharp > 0)
		return false;
	const idx_t start = in->outgoing[v];
	struct polygon *p = new_polygon(e, in->face_patch[in->face[start]]);
	idx_t h = start;
	do {
		const idx_t f = in->face[h];
		if (e->gone[f])
			return false; /* a face that meets the vertex twice is no manifold's */
		e->gone[f] = 1;
		append_run(e, p, sketch_next(in, h), sketch_degree(in, f) - 2);
		dissolve_if_bare(e, sketch_head(in, h), 1);
		h = sketch_turn(in, h);
	} while (h != start);
	touch_polygon(e, p);
	return true;
}

static bool collapse(struct edit *e, idx_t h)
{
	const struct sketch *in = e->in;
	if (h == NO_INDEX)
		return false;
	const idx_t a = in->face_corner[h], b = sketch_head(in, h);
	const struct sketch_star sa = sketch_star(in, a), sb = sketch_star(in, b);
	if (sa.sharp > 0 && sb.sharp > 0 && !in->sharp[h])
		return false; /* two creases would become one */
	const int ra = in->corner[a] || sa.sharp >= 3 ? 3 : sa.sharp > 0, rb = in->corner[b] || sb.sharp >= 3 ? 3 : sb.sharp > 0;
	const bool keep_a = ra > rb, keep_b = rb > ra;
	for (int k = 0; k < 3; k++) {
		const double xa = in->xyz[3 * (size_t)a + k], xb = in->xyz[3 * (size_t)b + k];
		e->new_xyz[k] = keep_a ? xa : keep_b ? xb : (xa + xb) / 2;
	}
	e->new_corner = in->corner[a] || in->corner[b];
	e->rename_from = a, e->rename_to = b;
	touch(e, b);
	/* vertices that lose an edge because a triangle became a line; with two edges left they go */
	for (int side = 0; side < 2; side++) {
		const idx_t g = side ? in->twin[h] : h;
		if (g == NO_INDEX || sketch_degree(in, in->face[g]) != 3)
			continue;
		const idx_t v = in->face_corner[sketch_previous(in, g)];
		touch(e, v);
		dissolve_if_bare(e, v, 1);
	}
	return true;
}

static bool swap(struct edit *e, idx_t h)
{
	const struct sketch *in = e->in;
	if (!is_inner_smooth(in, h))
		return false;
	const size_t cut = sketch_degree(in, in->face[h]) - 1;
	const struct polygon whole = *join(e, h);
	if (!e->is_good)
		return false;
	e->polygon_count = 0;
	/* corners 0 .. cut were h's face: the edge ran from cut to 0 and runs from cut + 1 to 1 now */
	const size_t n = whole.degree, from = (cut + 1) % n, to = 1;
	if (n < 4)
		return false;
	struct polygon *p = new_polygon(e, whole.patch), *q = new_polygon(e, whole.patch);
	p->patch = in->face_patch[in->face[h]], q->patch = in->face_patch[in->face[in->twin[h]]];
	size_t i = to;
	for (; i != from; i = (i + 1) % n)
		append(e, p, whole.vertex[i], whole.sharp[i]);
	append(e, p, whole.vertex[from], 0);
	for (; i != to; i = (i + 1) % n)
		append(e, q, whole.vertex[i], whole.sharp[i]);
	append(e, q, whole.vertex[to], 0);
	touch_polygon(e, &whole);
	return p->degree >= 3 && q->degree >= 3 && sketch_half(in, whole.vertex[from], whole.vertex[to]) == NO_INDEX &&
	       sketch_half(in, whole.vertex[to], whole.vertex[from]) == NO_INDEX;
}

/* Half-edges of one face that start at a and b: NO_INDEX when no face has both, or they are next to each other. */
static void find_chord(const struct sketch *in, idx_t a, idx_t b, idx_t *ha, idx_t *hb)
{
	*ha = *hb = NO_INDEX;
	const idx_t start = in->outgoing[a];
	for (idx_t h = start; h != NO_INDEX;) {
		for (idx_t g = sketch_next(in, sketch_next(in, h)); g != h && sketch_next(in, g) != h; g = sketch_next(in, g))
			if (in->face_corner[g] == b) {
				*ha = h, *hb = g;
				return;
			}
		h = sketch_turn(in, h);
		if (h == start)
			break;
	}
}

static bool chord(struct edit *e, idx_t a, idx_t b)
{
	const struct sketch *in = e->in;
	idx_t ha, hb;
	find_chord(in, a, b, &ha, &hb);
	if (ha == NO_INDEX || sketch_half(in, a, b) != NO_INDEX || sketch_half(in, b, a) != NO_INDEX)
		return false;
	const idx_t f = in->face[ha];
	e->gone[f] = 1;
	struct polygon *p = new_polygon(e, in->face_patch[f]), *q = new_polygon(e, in->face_patch[f]);
	for (idx_t h = ha; h != hb; h = sketch_next(in, h))
		append(e, p, in->face_corner[h], in->sharp[h]);
	append(e, p, b, 0);
	for (idx_t h = hb; h != ha; h = sketch_next(in, h))
		append(e, q, in->face_corner[h], in->sharp[h]);
	append(e, q, a, 0);
	touch_polygon(e, p), touch_polygon(e, q);
	return true;
}

/* The face of h with a new vertex behind h's origin; cut from there to the corner farthest along the face when that is wanted. */
static void split_side(struct edit *e, idx_t h, bool with_cut)
{
	const struct sketch *in = e->in;
	const idx_t f = in->face[h], fresh = (idx_t)in->vertex_count;
	const size_t degree = sketch_degree(in, f), far = (degree + 1) / 2; /* in steps along the face from h's origin */
	e->gone[f] = 1;
	struct polygon *p = new_polygon(e, in->face_patch[f]);
	append(e, p, fresh, in->sharp[h]);
	append_run(e, p, sketch_next(in, h), with_cut ? far : degree - 1);
	struct polygon *q = p;
	if (with_cut) {
		p->sharp[p->degree - 1] = 0;
		q = new_polygon(e, in->face_patch[f]);
		append(e, q, fresh, 0);
		idx_t g = h;
		for (size_t i = 0; i < far; i++)
			g = sketch_next(in, g);
		append_run(e, q, g, degree - far);
	}
	append(e, q, in->face_corner[h], in->sharp[h]);
	for (size_t i = 0; i < degree; i++, h = sketch_next(in, h))
		touch(e, in->face_corner[h]);
}

static bool split(struct edit *e, idx_t h)
{
	const struct sketch *in = e->in;
	if (h == NO_INDEX)
		return false;
	const idx_t a = in->face_corner[h], b = sketch_head(in, h);
	for (int k = 0; k < 3; k++)
		e->new_xyz[k] = (in->xyz[3 * (size_t)a + k] + in->xyz[3 * (size_t)b + k]) / 2;
	e->has_new = true;
	const bool with_cut = !in->sharp[h];
	split_side(e, h, with_cut);
	if (in->twin[h] != NO_INDEX)
		split_side(e, in->twin[h], with_cut);
	touch(e, (idx_t)in->vertex_count);
	return true;
}

static bool retag(struct edit *e, struct sketch *out, struct move_trace *trace, idx_t h, idx_t v)
{
	const struct sketch *in = e->in;
	if (h == NO_INDEX ? sketch_star(in, v).sharp != 2 && !in->corner[v] : in->twin[h] == NO_INDEX)
		return false;
	sketch_copy(out, in);
	*trace = (struct move_trace){.face = mem_array(in->face_count, sizeof *trace->face), .touched = mem_array(2, sizeof *trace->touched)};
	for (size_t f = 0; f < in->face_count; f++)
		trace->face[f] = (idx_t)f;
	if (h == NO_INDEX) {
		out->corner[v] = !out->corner[v];
		trace->touched[trace->touched_count++] = v;
	} else {
		out->sharp[h] = out->sharp[in->twin[h]] = !in->sharp[h];
		trace->touched[trace->touched_count++] = in->face_corner[h];
		trace->touched[trace->touched_count++] = sketch_head(in, h);
		bool is_good = true;
		for (int i = 0; i < 2; i++) {
			const struct sketch_star star = sketch_star(out, trace->touched[i]);
			is_good = is_good && (star.on_border || star.valence > 2 || star.sharp == 2);
		}
		if (!is_good) {
			sketch_free(out), move_trace_free(trace);
			return false;
		}
	}
	return true;
}

bool move_apply(struct sketch *out, struct move_trace *trace, const struct sketch *in, const idx_t *index, struct move move)
{
	const idx_t a = index[move.a], b = move.b >= 0 ? index[move.b] : NO_INDEX;
	if (a == NO_INDEX || (move.b >= 0 && b == NO_INDEX))
		return false;
	*trace = (struct move_trace){0};
	idx_t h = b == NO_INDEX ? NO_INDEX : sketch_half(in, a, b);
	if (h == NO_INDEX && b != NO_INDEX) {
		const idx_t g = sketch_half(in, b, a); /* at a border one side alone */
		h = g == NO_INDEX || in->twin[g] != NO_INDEX ? NO_INDEX : g;
	}
	struct edit *e = mem_array(1, sizeof *e);
	*e = (struct edit){.in = in, .rename_from = NO_INDEX, .rename_to = NO_INDEX, .is_good = true};
	if (move.kind == MOVE_CREASE || move.kind == MOVE_CORNER) {
		const bool is_done = (move.kind == MOVE_CORNER || h != NO_INDEX) && retag(e, out, trace, move.kind == MOVE_CORNER ? NO_INDEX : h, a);
		free(e);
		return is_done;
	}
	e->gone = mem_array(in->face_count, 1);
	bool is_good = false;
	switch (move.kind) {
	case MOVE_MERGE: is_good = merge(e, h); break;
	case MOVE_COLLAPSE: is_good = collapse(e, h); break;
	case MOVE_REMOVE: is_good = remove_vertex(e, a); break;
	case MOVE_SWAP: is_good = swap(e, h); break;
	case MOVE_CHORD: is_good = chord(e, a, b); break;
	case MOVE_SPLIT: is_good = split(e, h); break;
	default: break;
	}
	is_good = is_good && e->is_good && build(out, trace, e);
	free(e->gone), free(e);
	return is_good;
}
