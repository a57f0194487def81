/* Edges of polygon lists by counting sort, checks of a cage, and the cage as level 0. */
#include "stages/geometry/subdivide_topology.h"

#include <stdlib.h>
#include <string.h>

/* Corners sorted by the lower, then the higher vertex of their edge; equal edges by corner. start: first of each lower vertex. */
static void sort_corners(idx_t *order, size_t *start, const struct level *level)
{
	const size_t corner_count = level->face_start[level->face_count], vertex_count = level->vertex_count;
	idx_t *end = mem_array(corner_count, sizeof *end), *by_high = mem_array(corner_count, sizeof *by_high);
	memset(start, 0, (vertex_count + 1) * sizeof *start);
	for (size_t f = 0; f < level->face_count; f++) {
		const size_t first = level->face_start[f], last = level->face_start[f + 1] - 1;
		for (size_t h = first; h < last; h++)
			end[h] = level->face_corner[h + 1];
		end[last] = level->face_corner[first];
	}
	for (int pass = 0; pass < 2; pass++) {
		/* pass 0: by the higher vertex; pass 1: by the lower, which keeps the order of pass 0 among equals */
		memset(start, 0, (vertex_count + 1) * sizeof *start);
		for (size_t h = 0; h < corner_count; h++) {
			const idx_t a = level->face_corner[h], b = end[h];
			start[((a < b) == (pass == 1) ? a : b) + 1]++;
		}
		for (size_t v = 0; v < vertex_count; v++)
			start[v + 1] += start[v];
		for (size_t i = 0; i < corner_count; i++) {
			const size_t h = pass ? (size_t)by_high[i] : i;
			const idx_t a = level->face_corner[h], b = end[h];
			(pass ? order : by_high)[start[(a < b) == (pass == 1) ? a : b]++] = (idx_t)h;
		}
		/* the fill moved every start to its end: shift back */
		memmove(start + 1, start, vertex_count * sizeof *start);
		start[0] = 0;
	}
	free(end);
	free(by_high);
}

/* The vertex at the other end of corner h. */
static idx_t corner_end(const struct level *level, const struct topology *topology, size_t h)
{
	return level->face_corner[corner_next(level, topology, h)];
}

static bool same_edge(const struct level *level, const struct topology *topology, idx_t g, idx_t h)
{
	const idx_t a = level->face_corner[g], b = corner_end(level, topology, (size_t)g);
	const idx_t c = level->face_corner[h], d = corner_end(level, topology, (size_t)h);
	return (a == c && b == d) || (a == d && b == c);
}

static void build_faces(struct topology *topology, const struct level *level)
{
	topology->face = mem_array(level->face_start[level->face_count], sizeof *topology->face);
	for (size_t f = 0; f < level->face_count; f++)
		for (size_t h = level->face_start[f]; h < level->face_start[f + 1]; h++)
			topology->face[h] = (idx_t)f;
}

/* Number the edges and pair their corners; a fault when an edge has more than two faces or two of one direction.
 * order and start as from sort_corners. */
static bool build_edges(struct topology *topology, const struct level *level, const idx_t *order, struct fault *fault)
{
	const size_t corner_count = level->face_start[level->face_count];
	topology->edge = mem_array(corner_count, sizeof *topology->edge);
	/* first the partner of each corner, in edge[]; then numbers in the order of corners */
	for (size_t i = 0, j; i < corner_count; i = j) {
		for (j = i + 1; j < corner_count && same_edge(level, topology, order[i], order[j]); j++)
			;
		const idx_t first = order[i], a = level->face_corner[first], b = corner_end(level, topology, (size_t)first);
		if (j - i > 2)
			return fault_set(fault, EX_BAD_INPUT,
			                 "edge %" PRIidx "-%" PRIidx " has %zu faces (%" PRIidx ", %" PRIidx ", %" PRIidx "%s)", a, b, j - i,
			                 topology->face[first], topology->face[order[i + 1]], topology->face[order[i + 2]],
			                 j - i > 3 ? ", ..." : "");
		if (j - i == 2 && level->face_corner[order[i + 1]] == a)
			return fault_set(fault, EX_BAD_INPUT,
			                 "faces %" PRIidx " and %" PRIidx " run along edge %" PRIidx "-%" PRIidx
			                 " in the same direction: orientations differ",
			                 topology->face[first], topology->face[order[i + 1]], a, b);
		topology->edge[first] = j - i == 2 ? order[i + 1] : NO_INDEX;
		if (j - i == 2)
			topology->edge[order[i + 1]] = first;
	}
	topology->half = mem_array(2 * corner_count, sizeof *topology->half);
	size_t count = 0;
	for (size_t h = 0; h < corner_count; h++) {
		const idx_t partner = topology->edge[h];
		if (partner != NO_INDEX && (size_t)partner < h) {
			topology->edge[h] = topology->edge[partner];
			continue;
		}
		topology->half[2 * count] = (idx_t)h;
		topology->half[2 * count + 1] = partner;
		topology->edge[h] = (idx_t)count++;
	}
	topology->edge_count = count;
	return true;
}

/* Creases and kinds from the level's sharp and corner flags. */
static void build_kinds(struct topology *topology, const struct level *level, enum cage_scheme scheme)
{
	topology->crease = mem_array(topology->edge_count, 1);
	topology->kind = mem_array(level->vertex_count, 1);
	topology->valence = mem_array(level->vertex_count, sizeof *topology->valence);
	topology->quads = mem_array(level->vertex_count, sizeof *topology->quads);
	for (size_t f = 0; f < level->face_count; f++) {
		const size_t first = level->face_start[f], last = level->face_start[f + 1];
		const bool quads = splits_to_quads(last - first, scheme);
		for (size_t h = first; h < last; h++) {
			topology->valence[level->face_corner[h]]++;
			topology->quads[level->face_corner[h]] += quads;
		}
	}
	unsigned char *kind = topology->kind; /* counts up to KIND_CORNER: no, one, two, three or more creases */
	for (size_t e = 0; e < topology->edge_count; e++) {
		const idx_t h = topology->half[2 * e], twin = topology->half[2 * e + 1];
		topology->crease[e] = twin == NO_INDEX || level->sharp[h] || level->sharp[twin];
		if (!topology->crease[e])
			continue;
		const idx_t a = level->face_corner[h], b = corner_end(level, topology, (size_t)h);
		if (kind[a] < KIND_CORNER)
			kind[a]++;
		if (kind[b] < KIND_CORNER)
			kind[b]++;
	}
	for (size_t v = 0; v < level->vertex_count; v++)
		if (level->corner[v])
			kind[v] = KIND_CORNER;
}

void topology_free(struct topology *topology)
{
	free(topology->edge);
	free(topology->half);
	free(topology->face);
	free(topology->crease);
	free(topology->kind);
	free(topology->valence);
	free(topology->quads);
	memset(topology, 0, sizeof *topology);
}

void topology_build(struct topology *topology, const struct level *level, enum cage_scheme scheme)
{
	memset(topology, 0, sizeof *topology);
	build_faces(topology, level);
	idx_t *order = mem_array(level->face_start[level->face_count], sizeof *order);
	size_t *start = mem_array(level->vertex_count + 1, sizeof *start);
	sort_corners(order, start, level);
	struct fault none = {0};
	build_edges(topology, level, order, &none); /* a level is a manifold: checked when it was made */
	build_kinds(topology, level, scheme);
	free(order);
	free(start);
}

/* Counts that fit the index type, faces of at least three different vertices in range. */
static bool check_faces(const struct cage *cage, struct fault *fault)
{
	const size_t corner_count = cage->face_count ? cage->face_start[cage->face_count] : 0;
	if (cage->face_count > INDEX_LIMIT || corner_count > INDEX_LIMIT || cage->vertex_count > INDEX_LIMIT)
		return fault_set(fault, EX_BAD_INPUT, "the cage has more than %zu elements", INDEX_LIMIT);
	idx_t *seen = mem_array(cage->vertex_count, sizeof *seen); /* last face that had the vertex, plus one */
	bool good = true;
	for (size_t f = 0; good && f < cage->face_count; f++) {
		const size_t degree = cage->face_start[f + 1] - cage->face_start[f];
		if (degree < 3)
			good = fault_set(fault, EX_BAD_INPUT, "face %zu has %zu vertices, less than 3", f, degree);
		else if (cage->scheme == SCHEME_LOOP && degree != 3)
			good = fault_set(fault, EX_BAD_INPUT, "face %zu has %zu vertices: Loop subdivision needs triangles", f, degree);
		for (size_t h = cage->face_start[f]; good && h < cage->face_start[f + 1]; h++) {
			const idx_t v = cage->face_corner[h];
			if (v < 0 || (size_t)v >= cage->vertex_count)
				good = fault_set(fault, EX_BAD_INPUT, "face %zu: there is no vertex %" PRIidx, f, v);
			else if (seen[v] == (idx_t)f + 1)
				good = fault_set(fault, EX_BAD_INPUT, "face %zu has vertex %" PRIidx " twice", f, v);
			else
				seen[v] = (idx_t)f + 1;
		}
	}
	for (size_t v = 0; good && v < cage->vertex_count; v++)
		if (seen[v] == 0)
			good = fault_set(fault, EX_BAD_INPUT, "vertex %zu has no face", v);
	free(seen);
	return good;
}

/* Corners of the same vertex that are reached from h by crossing edges, until a border or h again. */
static void walk_fan(unsigned char *seen, const struct level *level, const struct topology *topology, size_t h)
{
	for (;;) {
		seen[h] = 1;
		const idx_t twin = corner_twin(topology, corner_previous(level, topology, h));
		if (twin == NO_INDEX || seen[twin])
			return;
		h = (size_t)twin;
	}
}

/* One fan of faces at every vertex. */
static bool check_fans(const struct level *level, const struct topology *topology, struct fault *fault)
{
	const size_t corner_count = level->face_start[level->face_count];
	unsigned char *seen = mem_array(corner_count, 1), *fan = mem_array(level->vertex_count, 1);
	bool good = true;
	/* open fans from their first edge, then what is left: closed ones from anywhere */
	for (int closed = 0; good && closed < 2; closed++)
		for (size_t h = 0; good && h < corner_count; h++) {
			if (seen[h] || (!closed && corner_twin(topology, h) != NO_INDEX))
				continue;
			const idx_t v = level->face_corner[h];
			if (fan[v])
				good = fault_set(fault, EX_BAD_INPUT, "vertex %" PRIidx " has more than one fan of faces (one with face %" PRIidx ")",
				                 v, topology->face[h]);
			fan[v] = 1;
			walk_fan(seen, level, topology, h);
		}
	free(seen);
	free(fan);
	return good;
}

/* Mark both corners of every listed edge. order and start as from sort_corners. */
static bool mark_sharp(struct level *level, const struct topology *topology, const struct cage *cage, const idx_t *order,
                       const size_t *start, struct fault *fault)
{
	for (size_t s = 0; s < cage->sharp_count; s++) {
		const idx_t a = cage->sharp[2 * s], b = cage->sharp[2 * s + 1], low = a < b ? a : b, high = a < b ? b : a;
		size_t i = 0, end = 0;
		if (low >= 0 && (size_t)high < cage->vertex_count) {
			i = start[low];
			end = start[low + 1];
		}
		/* first corner of the bucket whose edge ends at high or later */
		while (i < end) {
			const size_t middle = i + (end - i) / 2;
			const size_t h = (size_t)order[middle];
			const idx_t c = level->face_corner[h], d = corner_end(level, topology, h);
			if ((c == low ? d : c) < high)
				i = middle + 1;
			else
				end = middle;
		}
		bool found = false;
		if (low >= 0 && (size_t)high < cage->vertex_count)
			for (; i < start[low + 1]; i++) {
				const size_t h = (size_t)order[i];
				const idx_t c = level->face_corner[h], d = corner_end(level, topology, h);
				if ((c == low ? d : c) != high)
					break;
				level->sharp[h] = 1;
				found = true;
			}
		if (!found)
			return fault_set(fault, EX_BAD_INPUT, "sharp edge %" PRIidx "-%" PRIidx " is no edge of a face", a, b);
	}
	return true;
}

bool level_from_cage(struct level *level, const struct cage *cage, struct fault *fault)
{
	memset(level, 0, sizeof *level);
	if (!check_faces(cage, fault))
		return false;
	const size_t corner_count = cage->face_count ? cage->face_start[cage->face_count] : 0;
	level->vertex_count = cage->vertex_count;
	level->face_count = cage->face_count;
	level->xyz = mem_copy(cage->xyz, 3 * cage->vertex_count, sizeof *level->xyz);
	level->face_corner = mem_copy(cage->face_corner, corner_count, sizeof *level->face_corner);
	level->face_start = mem_array(cage->face_count + 1, sizeof *level->face_start);
	if (cage->face_count)
		memcpy(level->face_start, cage->face_start, (cage->face_count + 1) * sizeof *level->face_start);
	level->face_origin = mem_array(cage->face_count, sizeof *level->face_origin);
	for (size_t f = 0; f < cage->face_count; f++)
		level->face_origin[f] = (idx_t)f;
	level->corner = mem_array(cage->vertex_count, 1);
	level->sharp = mem_array(corner_count, 1);

	struct topology topology = {0};
	build_faces(&topology, level);
	idx_t *order = mem_array(corner_count, sizeof *order);
	size_t *start = mem_array(cage->vertex_count + 1, sizeof *start);
	sort_corners(order, start, level);
	const bool good = build_edges(&topology, level, order, fault) && check_fans(level, &topology, fault) &&
	                  mark_sharp(level, &topology, cage, order, start, fault);
	free(order);
	free(start);
	if (good) {
		if (cage->corner)
			for (size_t v = 0; v < cage->vertex_count; v++)
				level->corner[v] = cage->corner[v] != 0;
		build_kinds(&topology, level, cage->scheme);
		/* from here on borders are creases like others, and corners are known as such */
		for (size_t h = 0; h < corner_count; h++)
			level->sharp[h] = topology.crease[topology.edge[h]];
		for (size_t v = 0; v < cage->vertex_count; v++)
			level->corner[v] = topology.kind[v] == KIND_CORNER;
	}
	topology_free(&topology);
	if (!good)
		level_free(level);
	return good;
}

void level_free(struct level *level)
{
	if (level == NULL)
		return;
	free(level->xyz);
	free(level->face_corner);
	free(level->face_start);
	free(level->face_origin);
	free(level->corner);
	free(level->sharp);
	memset(level, 0, sizeof *level);
}
