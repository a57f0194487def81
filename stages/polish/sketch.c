#include "stages/polish/sketch.h"

#include <stdlib.h>
#include <string.h>

void sketch_free(struct sketch *s)
{
	free(s->xyz), free(s->id), free(s->corner), free(s->face_start), free(s->face_corner), free(s->face_patch), free(s->face_id);
	free(s->sharp), free(s->twin), free(s->face), free(s->outgoing);
	*s = (struct sketch){0};
}

void sketch_copy(struct sketch *out, const struct sketch *in)
{
	const size_t v = in->vertex_count, f = in->face_count, h = in->face_start[f];
	*out = *in;
	out->xyz = mem_copy(in->xyz, 3 * v, sizeof *in->xyz);
	out->id = mem_copy(in->id, v, sizeof *in->id);
	out->corner = mem_copy(in->corner, v, sizeof *in->corner);
	out->face_start = mem_copy(in->face_start, f + 1, sizeof *in->face_start);
	out->face_corner = mem_copy(in->face_corner, h, sizeof *in->face_corner);
	out->face_patch = mem_copy(in->face_patch, f, sizeof *in->face_patch);
	out->face_id = mem_copy(in->face_id, f, sizeof *in->face_id);
	out->sharp = mem_copy(in->sharp, h, sizeof *in->sharp);
	out->twin = mem_copy(in->twin, h, sizeof *in->twin);
	out->face = mem_copy(in->face, h, sizeof *in->face);
	out->outgoing = mem_copy(in->outgoing, v, sizeof *in->outgoing);
}

/* --- connectivity -------------------------------------------------------------------------------------------------- */

/* Twins by sorting half-edges into buckets of their lower vertex: cages have few edges at a vertex. */
static bool find_twins(struct sketch *s)
{
	const size_t halves = s->face_start[s->face_count];
	idx_t *first = mem_array(s->vertex_count, sizeof *first), *link = mem_array(halves, sizeof *link);
	memset(first, -1, s->vertex_count * sizeof *first);
	bool is_good = true;
	for (size_t h = 0; h < halves && is_good; h++) {
		const idx_t a = s->face_corner[h], b = sketch_head(s, (idx_t)h), low = a < b ? a : b;
		s->twin[h] = NO_INDEX;
		is_good = a != b;
		for (idx_t g = first[low]; g != NO_INDEX && is_good; g = link[g]) {
			const idx_t ga = s->face_corner[g], gb = sketch_head(s, g);
			if (ga == a && gb == b)
				is_good = false;
			else if (ga == b && gb == a && s->twin[g] == NO_INDEX)
				s->twin[g] = (idx_t)h, s->twin[h] = g;
		}
		link[h] = first[low], first[low] = (idx_t)h;
	}
	free(first), free(link);
	return is_good;
}

struct sketch_star sketch_star(const struct sketch *s, idx_t v)
{
	struct sketch_star star = {0};
	const idx_t start = s->outgoing[v];
	for (idx_t h = start; h != NO_INDEX;) {
		star.valence++, star.sharp += s->sharp[h];
		const idx_t p = sketch_previous(s, h);
		h = s->twin[p];
		if (h == NO_INDEX)
			star.on_border = true, star.valence++, star.sharp++;
		else if (h == start)
			break;
	}
	return star;
}

bool sketch_is_corner(const struct sketch *s, idx_t v) { return s->corner[v] || sketch_star(s, v).sharp >= 3; }

static bool one_fan_each(const struct sketch *s)
{
	size_t *uses = mem_array(s->vertex_count, sizeof *uses);
	for (size_t h = 0; h < s->face_start[s->face_count]; h++)
		uses[s->face_corner[h]]++;
	bool is_good = true;
	for (size_t v = 0; v < s->vertex_count && is_good; v++) {
		if (uses[v] == 0) {
			is_good = false;
			break;
		}
		const struct sketch_star star = sketch_star(s, (idx_t)v);
		is_good = star.valence - star.on_border == uses[v];
		if (!star.on_border && star.valence == 2)
			is_good = is_good && star.sharp == 2;
	}
	free(uses);
	return is_good;
}

bool sketch_connect(struct sketch *s)
{
	const size_t halves = s->face_start[s->face_count];
	s->twin = mem_resize(s->twin, halves, sizeof *s->twin);
	s->face = mem_resize(s->face, halves, sizeof *s->face);
	s->outgoing = mem_resize(s->outgoing, s->vertex_count, sizeof *s->outgoing);
	for (size_t f = 0; f < s->face_count; f++) {
		if (sketch_degree(s, (idx_t)f) < 3)
			return false;
		for (size_t h = s->face_start[f]; h < s->face_start[f + 1]; h++)
			s->face[h] = (idx_t)f;
	}
	if (!find_twins(s))
		return false;
	memset(s->outgoing, -1, s->vertex_count * sizeof *s->outgoing);
	for (size_t h = 0; h < halves; h++) {
		const idx_t v = s->face_corner[h], t = s->twin[h];
		if (t == NO_INDEX)
			s->sharp[h] = 1;
		else if (s->sharp[t])
			s->sharp[h] = 1;
		if (s->outgoing[v] == NO_INDEX || t == NO_INDEX)
			s->outgoing[v] = (idx_t)h;
	}
	for (size_t h = 0; h < halves; h++)
		if (s->twin[h] != NO_INDEX && s->sharp[s->twin[h]])
			s->sharp[h] = 1;
	return one_fan_each(s);
}

idx_t sketch_half(const struct sketch *s, idx_t a, idx_t b)
{
	const idx_t start = s->outgoing[a];
	for (idx_t h = start; h != NO_INDEX;) {
		if (sketch_head(s, h) == b)
			return h;
		h = sketch_turn(s, h);
		if (h == start)
			break;
	}
	return NO_INDEX;
}

size_t sketch_edge_count(const struct sketch *s)
{
	size_t count = 0;
	for (size_t h = 0; h < s->face_start[s->face_count]; h++)
		count += s->twin[h] == NO_INDEX || s->twin[h] > (idx_t)h;
	return count;
}

/* --- from and to other forms ---------------------------------------------------------------------------------------- */

bool sketch_from_cage(struct sketch *s, const struct cage *cage, const double middle[3], double scale, struct fault *fault)
{
	struct level level;
	if (!level_from_cage(&level, cage, fault))
		return false;
	const size_t halves = cage->face_start[cage->face_count];
	*s = (struct sketch){.scheme = cage->scheme, .vertex_count = cage->vertex_count, .face_count = cage->face_count};
	s->xyz = mem_array(3 * s->vertex_count, sizeof *s->xyz);
	for (size_t i = 0; i < 3 * s->vertex_count; i++)
		s->xyz[i] = (cage->xyz[i] - middle[i % 3]) / scale;
	s->id = mem_array(s->vertex_count, sizeof *s->id);
	for (size_t v = 0; v < s->vertex_count; v++)
		s->id[v] = (idx_t)v;
	s->next_id = (idx_t)s->vertex_count;
	s->corner = cage->corner ? mem_copy(cage->corner, s->vertex_count, 1) : mem_array(s->vertex_count, 1);
	s->face_start = mem_copy(cage->face_start, s->face_count + 1, sizeof *s->face_start);
	s->face_corner = mem_copy(cage->face_corner, halves, sizeof *s->face_corner);
	s->face_patch = cage->face_patch ? mem_copy(cage->face_patch, s->face_count, sizeof *s->face_patch)
	                                 : mem_array(s->face_count, sizeof *s->face_patch);
	s->face_id = mem_array(s->face_count, sizeof *s->face_id);
	for (size_t f = 0; f < s->face_count; f++)
		s->face_id[f] = (idx_t)f;
	s->next_face_id = (idx_t)s->face_count;
	s->sharp = mem_copy(level.sharp, halves, 1);
	level_free(&level);
	if (!sketch_connect(s)) {
		sketch_free(s);
		return fault_set(fault, EX_BAD_INPUT, "a vertex inside the cage has two edges that are not both creases");
	}
	return true;
}

void sketch_to_cage(struct cage *cage, const struct sketch *s, const double middle[3], double scale)
{
	const size_t halves = s->face_start[s->face_count];
	*cage = (struct cage){.scheme = s->scheme, .vertex_count = s->vertex_count, .face_count = s->face_count};
	cage->xyz = mem_array(3 * s->vertex_count, sizeof *cage->xyz);
	for (size_t i = 0; i < 3 * s->vertex_count; i++)
		cage->xyz[i] = middle[i % 3] + scale * s->xyz[i];
	cage->corner = mem_array(s->vertex_count, 1);
	for (size_t v = 0; v < s->vertex_count; v++)
		cage->corner[v] = s->corner[v] && sketch_star(s, (idx_t)v).sharp < 3;
	cage->face_start = mem_copy(s->face_start, s->face_count + 1, sizeof *cage->face_start);
	cage->face_corner = mem_copy(s->face_corner, halves, sizeof *cage->face_corner);
	cage->face_patch = mem_copy(s->face_patch, s->face_count, sizeof *cage->face_patch);
	cage->sharp = mem_array(halves, sizeof *cage->sharp);
	/* sorted by lower, then by higher vertex: edges of each lower vertex by insertion, few as they are */
	for (size_t v = 0; v < s->vertex_count; v++) {
		const size_t from = cage->sharp_count;
		const idx_t start = s->outgoing[v];
		for (idx_t h = start; h != NO_INDEX;) {
			const idx_t b = sketch_head(s, h);
			if (s->sharp[h] && s->twin[h] != NO_INDEX && b > (idx_t)v) {
				size_t i = cage->sharp_count++;
				for (; i > from && cage->sharp[2 * (i - 1) + 1] > b; i--)
					cage->sharp[2 * i + 1] = cage->sharp[2 * i - 1], cage->sharp[2 * i] = (idx_t)v;
				cage->sharp[2 * i] = (idx_t)v, cage->sharp[2 * i + 1] = b;
			}
			h = sketch_turn(s, h);
			if (h == start)
				break;
		}
	}
}

struct level sketch_level(const struct sketch *s)
{
	struct level level = {.vertex_count = s->vertex_count, .face_count = s->face_count, .xyz = s->xyz, .face_corner = s->face_corner,
	                      .face_start = s->face_start, .face_origin = NULL, .sharp = s->sharp};
	level.corner = mem_array(s->vertex_count, 1);
	for (size_t v = 0; v < s->vertex_count; v++)
		level.corner[v] = sketch_is_corner(s, (idx_t)v);
	level.face_origin = mem_array(s->face_count, sizeof *level.face_origin);
	for (size_t f = 0; f < s->face_count; f++)
		level.face_origin[f] = (idx_t)f;
	return level;
}

static void add_star_faces(const struct sketch *s, idx_t v, unsigned char *seen, idx_t *list, size_t *count)
{
	const idx_t start = s->outgoing[v];
	for (idx_t h = start; h != NO_INDEX;) {
		if (!seen[s->face[h]])
			seen[s->face[h]] = 1, list[(*count)++] = s->face[h];
		h = sketch_turn(s, h);
		if (h == start)
			break;
	}
}

idx_t *sketch_faces_near(size_t *count, const struct sketch *s, const idx_t *vertex, size_t vertex_count, int rings)
{
	idx_t *list = mem_array(s->face_count, sizeof *list);
	unsigned char *seen = mem_array(s->face_count, 1);
	*count = 0;
	for (size_t i = 0; i < vertex_count; i++)
		add_star_faces(s, vertex[i], seen, list, count);
	for (int r = 1; r < rings; r++) {
		const size_t inner = *count;
		for (size_t i = 0; i < inner; i++)
			for (size_t h = s->face_start[list[i]]; h < s->face_start[list[i] + 1]; h++)
				add_star_faces(s, s->face_corner[h], seen, list, count);
	}
	free(seen);
	return list;
}
