#include "formats/cage.h"

#include <stdlib.h>
#include <string.h>

static const char *const scheme_name[3] = {"quadtri", "loop", "catmullclark"};
static const char scheme_comment[] = "comment cagewright scheme ";

void cage_free(struct cage *cage)
{
	free(cage->xyz);
	free(cage->corner);
	free(cage->net);
	free(cage->face_corner);
	free(cage->face_start);
	free(cage->face_patch);
	free(cage->sharp);
	*cage = (struct cage){0};
}

void cage_copy(struct cage *out, const struct cage *in)
{
	const size_t corners = in->face_start[in->face_count];
	*out = *in;
	out->xyz = mem_copy(in->xyz, 3 * in->vertex_count, sizeof *in->xyz);
	out->corner = in->corner ? mem_copy(in->corner, in->vertex_count, sizeof *in->corner) : NULL;
	out->net = in->net ? mem_copy(in->net, in->vertex_count, sizeof *in->net) : NULL;
	out->face_corner = mem_copy(in->face_corner, corners, sizeof *in->face_corner);
	out->face_start = mem_copy(in->face_start, in->face_count + 1, sizeof *in->face_start);
	out->face_patch = in->face_patch ? mem_copy(in->face_patch, in->face_count, sizeof *in->face_patch) : NULL;
	out->sharp = mem_copy(in->sharp, 2 * in->sharp_count, sizeof *in->sharp);
}

static bool read_scheme(struct cage *cage, const struct ply *ply, const char *shown, struct fault *fault)
{
	const char *found = NULL;
	for (size_t c = 0; c < ply->comment_count; c++) {
		if (strncmp(ply->comment[c], scheme_comment, sizeof scheme_comment - 1) != 0)
			continue;
		if (found)
			return fault_set(fault, EX_BAD_INPUT, "%s: two comments 'cagewright scheme'", shown);
		found = ply->comment[c] + sizeof scheme_comment - 1;
	}
	if (!found)
		return fault_set(fault, EX_BAD_INPUT, "%s: no comment 'cagewright scheme' says which rules the cage is for", shown);
	for (int s = 0; s < 3; s++) {
		if (strcmp(found, scheme_name[s]) == 0) {
			cage->scheme = (enum cage_scheme)s;
			return true;
		}
	}
	return fault_set(fault, EX_BAD_INPUT, "%s: unknown scheme '%.40s'", shown, found);
}

static bool read_vertices(struct cage *cage, const struct ply_element *vertex, const char *shown, struct fault *fault)
{
	cage->vertex_count = vertex->count;
	cage->xyz = ply_points(vertex, shown, fault);
	if (!cage->xyz)
		return false;
	cage->corner = mem_array(vertex->count, 1);
	if (ply_column(vertex, "corner")) {
		idx_t *corner = ply_index_scalar(vertex, "corner", 0, 2, shown, fault);
		if (!corner)
			return false;
		for (size_t v = 0; v < vertex->count; v++)
			cage->corner[v] = (unsigned char)corner[v];
		free(corner);
	}
	if (ply_column(vertex, "net"))
		cage->net = ply_index_scalar(vertex, "net", -1, (long long)INDEX_LIMIT, shown, fault);
	return fault->code == EX_DONE;
}

static int compare_indices(const void *a, const void *b)
{
	const idx_t x = *(const idx_t *)a, y = *(const idx_t *)b;
	return (x > y) - (x < y);
}

/* Does no vertex stand twice in the face? room has space for its corners. */
static bool is_simple(const idx_t *corner, size_t count, idx_t *room)
{
	memcpy(room, corner, count * sizeof *room);
	qsort(room, count, sizeof *room, compare_indices);
	for (size_t i = 1; i < count; i++)
		if (room[i] == room[i - 1])
			return false;
	return true;
}

static bool read_faces(struct cage *cage, const struct ply_element *face, const char *shown, struct fault *fault)
{
	cage->face_count = face->count;
	const struct ply_column *corners = ply_want_list(face, "vertex_indices", shown, fault);
	if (!corners)
		return false;
	cage->face_corner = ply_indices(face, corners, 0, (long long)cage->vertex_count, shown, fault);
	if (!cage->face_corner)
		return false;
	cage->face_start = mem_copy(corners->start, face->count + 1, sizeof *cage->face_start);
	idx_t *room = mem_array(corners->start[face->count], sizeof *room);
	bool good = true;
	for (size_t f = 0; good && f < face->count; f++) {
		const size_t count = corners->start[f + 1] - corners->start[f];
		if (count < 3)
			good = fault_set(fault, EX_BAD_INPUT, "%s: face %zu: %zu vertices; a face has at least 3", shown, f, count);
		else if (!is_simple(cage->face_corner + corners->start[f], count, room))
			good = fault_set(fault, EX_BAD_INPUT, "%s: face %zu: a vertex stands twice in the face", shown, f);
	}
	free(room);
	if (!good)
		return false;
	if (ply_column(face, "patch"))
		cage->face_patch = ply_index_scalar(face, "patch", 0, (long long)INDEX_LIMIT, shown, fault);
	else
		cage->face_patch = mem_array(face->count, sizeof *cage->face_patch);
	return cage->face_patch != NULL;
}

/* An edge by its vertices, lower first. */
struct pair {
	idx_t low, high;
};

static struct pair pair_of(idx_t a, idx_t b)
{
	return a < b ? (struct pair){a, b} : (struct pair){b, a};
}

static int compare_pairs(const void *a, const void *b)
{
	const struct pair *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	return (x->high > y->high) - (x->high < y->high);
}

/* Every side of every face, sorted: an edge stands there once for each of its faces. */
static struct pair *sorted_sides(const struct cage *cage)
{
	const size_t count = cage->face_start[cage->face_count];
	struct pair *side = mem_array(count, sizeof *side);
	for (size_t f = 0; f < cage->face_count; f++) {
		const size_t first = cage->face_start[f], end = cage->face_start[f + 1];
		for (size_t c = first; c < end; c++)
			side[c] = pair_of(cage->face_corner[c], cage->face_corner[c + 1 < end ? c + 1 : first]);
	}
	qsort(side, count, sizeof *side, compare_pairs);
	return side;
}

static bool read_edges(struct cage *cage, const struct ply_element *edge, const char *shown, struct fault *fault)
{
	idx_t *vertex1 = NULL, *vertex2 = NULL, *sharp = NULL;
	struct pair *crease = NULL, *side = NULL;
	size_t count = 0;
	if (!(vertex1 = ply_index_scalar(edge, "vertex1", 0, (long long)cage->vertex_count, shown, fault)) ||
	    !(vertex2 = ply_index_scalar(edge, "vertex2", 0, (long long)cage->vertex_count, shown, fault)) ||
	    !(sharp = ply_index_scalar(edge, "sharp", 0, 2, shown, fault)))
		goto done;
	crease = mem_array(edge->count, sizeof *crease);
	side = sorted_sides(cage);
	const size_t side_count = cage->face_start[cage->face_count];
	for (size_t e = 0; e < edge->count; e++) {
		if (!sharp[e])
			continue;
		const struct pair pair = pair_of(vertex1[e], vertex2[e]);
		const struct pair *found = bsearch(&pair, side, side_count, sizeof *side, compare_pairs);
		if (!found) {
			fault_set(fault, EX_BAD_INPUT, "%s: edge %zu: no face has the sharp edge %" PRIidx " %" PRIidx, shown, e, pair.low,
			          pair.high);
			goto done;
		}
		/* sides of one face are creases by themselves */
		const bool twice = (found > side && compare_pairs(found - 1, &pair) == 0) ||
		                   (found + 1 < side + side_count && compare_pairs(found + 1, &pair) == 0);
		if (twice)
			crease[count++] = pair;
	}
	qsort(crease, count, sizeof *crease, compare_pairs);
	cage->sharp = mem_array(2 * count, sizeof *cage->sharp);
	for (size_t i = 0; i < count; i++) {
		if (i && compare_pairs(&crease[i - 1], &crease[i]) == 0)
			continue;
		cage->sharp[2 * cage->sharp_count] = crease[i].low;
		cage->sharp[2 * cage->sharp_count + 1] = crease[i].high;
		cage->sharp_count++;
	}
done:
	free(vertex1);
	free(vertex2);
	free(sharp);
	free(crease);
	free(side);
	return fault->code == EX_DONE;
}

/* "grid": what polish has put the vertices on. A person who moved a vertex leaves the rest as it was: whether a vertex is on the grid is
 * for its reader to see. */
static bool read_grid(struct cage *cage, const struct ply_element *grid, const char *shown, struct fault *fault)
{
	if (grid->count != 1)
		return fault_set(fault, EX_BAD_INPUT, "%s: element 'grid' has %zu rows, not one", shown, grid->count);
	double *origin = ply_points(grid, shown, fault), *step = origin ? ply_numbers(grid, "step", shown, fault) : NULL;
	if (step) {
		cage->grid_step = *step;
		for (int k = 0; k < 3; k++)
			cage->grid_origin[k] = origin[k];
		if (!(*step > 0))
			fault_set(fault, EX_BAD_INPUT, "%s: the step of the grid is not positive", shown);
	}
	free(origin), free(step);
	return fault->code == EX_DONE;
}

bool cage_from_ply(struct cage *cage, const struct ply *ply, const char *shown, struct fault *fault)
{
	*cage = (struct cage){0};
	const struct ply_element *vertex = ply_want_element(ply, "vertex", shown, fault);
	const struct ply_element *face = vertex ? ply_want_element(ply, "face", shown, fault) : NULL;
	const struct ply_element *edge = ply_element(ply, "edge");
	bool good = face && read_scheme(cage, ply, shown, fault) && read_vertices(cage, vertex, shown, fault) &&
	            read_faces(cage, face, shown, fault);
	if (good && edge)
		good = read_edges(cage, edge, shown, fault);
	else if (good)
		cage->sharp = mem_array(0, sizeof *cage->sharp);
	const struct ply_element *grid = ply_element(ply, "grid");
	if (good && grid)
		good = read_grid(cage, grid, shown, fault);
	if (!good)
		cage_free(cage);
	return good;
}

static void put_scheme(struct ply *ply, enum cage_scheme scheme)
{
	size_t kept = 0;
	for (size_t c = 0; c < ply->comment_count; c++) {
		if (strncmp(ply->comment[c], scheme_comment, sizeof scheme_comment - 1) == 0)
			free(ply->comment[c]);
		else
			ply->comment[kept++] = ply->comment[c];
	}
	ply->comment_count = kept;
	ply_comment(ply, "cagewright scheme %s", scheme_name[scheme]);
}

void cage_to_ply(struct ply *ply, const struct cage *cage)
{
	put_scheme(ply, cage->scheme);
	struct ply_element *vertex = ply_put_element(ply, "vertex", cage->vertex_count);
	ply_put_points(vertex, cage->xyz);
	double *corner = ply_put_scalar(vertex, "corner", PLY_UINT8);
	for (size_t v = 0; v < cage->vertex_count; v++)
		corner[v] = cage->corner ? cage->corner[v] : 0;
	if (cage->net)
		ply_put_indices(vertex, "net", PLY_INT32, cage->net);
	struct ply_element *face = ply_put_element(ply, "face", cage->face_count);
	ply_put_index_lists(face, "vertex_indices", cage->face_start, cage->face_corner);
	double *patch = ply_put_scalar(face, "patch", PLY_INT32);
	for (size_t f = 0; f < cage->face_count; f++)
		patch[f] = cage->face_patch ? cage->face_patch[f] : 0;
	struct ply_element *edge = ply_put_element(ply, "edge", cage->sharp_count);
	double *vertex1 = ply_put_scalar(edge, "vertex1", PLY_INT32);
	double *vertex2 = ply_put_scalar(edge, "vertex2", PLY_INT32);
	double *sharp = ply_put_scalar(edge, "sharp", PLY_UINT8);
	for (size_t e = 0; e < cage->sharp_count; e++) {
		vertex1[e] = cage->sharp[2 * e];
		vertex2[e] = cage->sharp[2 * e + 1];
		sharp[e] = 1;
	}
	ply_drop_element(ply, "grid");
	if (cage->grid_step > 0) {
		struct ply_element *grid = ply_put_element(ply, "grid", 1);
		*ply_put_scalar(grid, "step", PLY_FLOAT64) = cage->grid_step;
		ply_put_points(grid, cage->grid_origin);
	}
}
