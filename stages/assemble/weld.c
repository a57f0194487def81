/* Weld by network id. */
#include "stages/assemble/weld.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A side of a face or a control edge of a curve. */
struct side {
	idx_t low, high;
	idx_t item; /* half-edge or curve */
};

static int compare_sides(const void *a, const void *b)
{
	const struct side *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	if (x->high != y->high)
		return x->high < y->high ? -1 : 1;
	return (x->item > y->item) - (x->item < y->item);
}

static bool is_same_edge(const struct side *a, const struct side *b)
{
	return a->low == b->low && a->high == b->high;
}

/* First of the sorted sides with these ends, or NULL. */
static const struct side *find_side(const struct side *side, size_t count, const struct side *wanted)
{
	size_t low = 0, high = count;
	while (low < high) {
		const size_t middle = (low + high) / 2;
		if (side[middle].low < wanted->low || (side[middle].low == wanted->low && side[middle].high < wanted->high))
			low = middle + 1;
		else
			high = middle;
	}
	return low < count && is_same_edge(side + low, wanted) ? side + low : NULL;
}

/* Vertex of the welded mesh for each vertex of the local cages: network points first, then the others, both in order. */
static idx_t *name_vertices(size_t *vertex_count, size_t *unused, double **xyz, idx_t **net_of, const struct cage *cage,
			    const struct network *network, struct fault *fault)
{
	idx_t *point_name = mem_array(network->vertex_count, sizeof *point_name);
	for (size_t v = 0; v < cage->vertex_count; v++) {
		const idx_t net = cage->net ? cage->net[v] : NO_INDEX;
		if (net != NO_INDEX && (size_t)net >= network->vertex_count) {
			fault_set(fault, EX_BAD_INPUT, "vertex %zu: there is no network point %" PRIidx, v, net);
			free(point_name);
			return NULL;
		}
		if (net != NO_INDEX)
			point_name[net] = 1;
	}
	*vertex_count = *unused = 0;
	*xyz = mem_array(3 * (network->vertex_count + cage->vertex_count), sizeof **xyz);
	*net_of = mem_array(network->vertex_count + cage->vertex_count, sizeof **net_of);
	for (size_t i = 0; i < network->vertex_count; i++) {
		if (!point_name[i]) {
			++*unused;
			continue;
		}
		memcpy(*xyz + 3 * *vertex_count, network->xyz + 3 * i, 3 * sizeof **xyz);
		(*net_of)[*vertex_count] = (idx_t)i;
		point_name[i] = (idx_t)++ * vertex_count; /* plus one: 0 stays "unused" */
	}
	idx_t *name = mem_array(cage->vertex_count, sizeof *name);
	for (size_t v = 0; v < cage->vertex_count; v++) {
		const idx_t net = cage->net ? cage->net[v] : NO_INDEX;
		if (net != NO_INDEX) {
			name[v] = point_name[net] - 1;
			continue;
		}
		memcpy(*xyz + 3 * *vertex_count, cage->xyz + 3 * v, 3 * sizeof **xyz);
		(*net_of)[*vertex_count] = NO_INDEX;
		name[v] = (idx_t)(*vertex_count)++;
	}
	free(point_name);
	return name;
}

/* Control edges of all curves, in network points, sorted; two curves may not share one. */
static struct side *curve_sides(size_t *count, const struct network *network, struct fault *fault)
{
	struct side *side = mem_array(network->point_count, sizeof *side);
	*count = 0;
	for (size_t c = 0; c < network->curve_count; c++) {
		const struct curve *curve = network->curve + c;
		for (size_t i = 0; i + !curve->closed < curve->count; i++) {
			const idx_t a = network->point[curve->first + i],
				    b = network->point[curve->first + (i + 1) % curve->count];
			side[(*count)++] = (struct side){a < b ? a : b, a < b ? b : a, (idx_t)c};
		}
	}
	qsort(side, *count, sizeof *side, compare_sides);
	for (size_t i = 1; i < *count; i++)
		if (is_same_edge(side + i - 1, side + i)) {
			fault_set(fault, EX_BAD_INPUT,
				  "curves %" PRIidx " and %" PRIidx " both have the control edge %" PRIidx " %" PRIidx,
				  side[i - 1].item, side[i].item, side[i].low, side[i].high);
			free(side);
			return NULL;
		}
	return side;
}

/* "control edge 3 8 of curve 5" or "control edge inside the patch". */
static void describe(char text[120], const struct side *edge, const struct side *curve, const idx_t *net_of)
{
	if (curve)
		snprintf(text, 120, "control edge %" PRIidx " %" PRIidx " of curve %" PRIidx, curve->low, curve->high,
			 curve->item);
	else
		snprintf(text, 120, "inner control edge %" PRIidx " %" PRIidx, net_of[edge->low], net_of[edge->high]);
}

static bool pair_sides(struct polymesh *mesh, size_t *border, const struct side *side, const struct side *of_curve,
		       size_t curve_side_count, const struct network *network, const idx_t *net_of, struct fault *fault)
{
	for (size_t i = 0, j; i < mesh->half_count; i = j) {
		for (j = i; j < mesh->half_count && is_same_edge(side + j, side + i); j++)
			;
		const idx_t h = side[i].item, g = j - i > 1 ? side[i + 1].item : NO_INDEX;
		const idx_t a = net_of[side[i].low], b = net_of[side[i].high], patch = mesh->face_patch[mesh->face[h]];
		const struct side in_network = {a < b ? a : b, a < b ? b : a, 0};
		const struct side *curve =
			a != NO_INDEX && b != NO_INDEX ? find_side(of_curve, curve_side_count, &in_network) : NULL;
		const enum curve_kind kind = curve ? network->curve[curve->item].kind : CURVE_SMOOTH;
		char edge[120];
		describe(edge, side + i, curve, net_of);
		if (j - i > 2)
			return fault_set(fault, EX_BAD_INPUT, "patch %" PRIidx ": %s has %zu faces", patch, edge, j - i);
		if (j - i == 1) {
			if (!curve || network->curve[curve->item].right >= 0)
				return fault_set(fault, EX_BAD_INPUT, "patch %" PRIidx ": crack: %s has a face on one side only",
						 patch, edge);
			++*border;
			continue;
		}
		if (mesh->origin[h] == mesh->origin[g])
			return fault_set(fault, EX_BAD_INPUT,
					 "patches %" PRIidx " and %" PRIidx ": two faces run along the %s the same way", patch,
					 mesh->face_patch[mesh->face[g]], edge);
		mesh->twin[h] = g, mesh->twin[g] = h;
		mesh->sharp[h] = mesh->sharp[g] = curve && kind != CURVE_SMOOTH;
	}
	return true;
}

static int compare_indices(const void *a, const void *b)
{
	const idx_t x = *(const idx_t *)a, y = *(const idx_t *)b;
	return (x > y) - (x < y);
}

/* After welding a face may come to one point twice, when its patch lies between two curves that share it. */
static bool check_faces(const struct cage *cage, const idx_t *corner, const idx_t *net_of, struct fault *fault)
{
	size_t most = 0;
	for (size_t f = 0; f < cage->face_count; f++)
		most = cage->face_start[f + 1] - cage->face_start[f] > most ? cage->face_start[f + 1] - cage->face_start[f]
									    : most;
	idx_t *sorted = mem_array(most, sizeof *sorted);
	bool ok = true;
	for (size_t f = 0; f < cage->face_count && ok; f++) {
		const size_t count = cage->face_start[f + 1] - cage->face_start[f];
		memcpy(sorted, corner + cage->face_start[f], count * sizeof *sorted);
		qsort(sorted, count, sizeof *sorted, compare_indices);
		for (size_t i = 1; i < count && ok; i++)
			if (sorted[i] == sorted[i - 1])
				ok = fault_set(fault, EX_BAD_INPUT,
					       "patch %" PRIidx ": face %zu has network point %" PRIidx " twice",
					       cage->face_patch[f], f, net_of[sorted[i]]);
	}
	free(sorted);
	return ok;
}

/* Every control edge of every curve has a face. */
static bool check_curves(const struct side *of_curve, size_t count, const struct network *network, const struct side *side,
			 size_t half_count, const idx_t *name_of_point, struct fault *fault)
{
	for (size_t i = 0; i < count; i++) {
		const idx_t a = name_of_point[of_curve[i].low], b = name_of_point[of_curve[i].high];
		const struct side wanted = {a < b ? a : b, a < b ? b : a, 0};
		if (a == NO_INDEX || b == NO_INDEX || !find_side(side, half_count, &wanted)) {
			const struct curve *curve = network->curve + of_curve[i].item;
			return fault_set(fault, EX_BAD_INPUT,
					 "curve %" PRIidx " between patches %" PRIidx " and %" PRIidx
					 ": no face has its control edge %" PRIidx " %" PRIidx,
					 of_curve[i].item, curve->left, curve->right, of_curve[i].low, of_curve[i].high);
		}
	}
	return true;
}

/* Explicit corners: kinks of the network where exactly two creases meet (three and more are corners by rule). */
static void mark_corners(struct polymesh *mesh, const struct network *network, const idx_t *net_of)
{
	unsigned char *creases = mem_array(mesh->vertex_count, 1);
	for (size_t h = 0; h < mesh->half_count; h++) {
		if (!polymesh_is_crease(mesh, (idx_t)h) || (mesh->twin[h] != NO_INDEX && mesh->twin[h] < (idx_t)h))
			continue;
		const idx_t end[2] = {mesh->origin[h], mesh->origin[mesh->next[h]]};
		for (int k = 0; k < 2; k++)
			if (creases[end[k]] < 3)
				creases[end[k]]++;
	}
	for (size_t v = 0; v < mesh->vertex_count; v++)
		mesh->corner[v] = net_of[v] != NO_INDEX && network->kind[net_of[v]] == POINT_CORNER && creases[v] == 2;
	free(creases);
}

bool weld(struct polymesh *mesh, struct weld_report *report, const struct cage *cage, const struct network *network,
	  struct fault *fault)
{
	*report = (struct weld_report){0};
	*mesh = (struct polymesh){0};
	const size_t half_count = cage->face_start[cage->face_count];
	size_t vertex_count = 0, curve_side_count = 0;
	double *xyz = NULL;
	idx_t *net_of = NULL, *name = NULL, *corner = NULL, *name_of_point = NULL;
	struct side *of_curve = NULL, *side = NULL;
	bool ok = false;
	if (!(name = name_vertices(&vertex_count, &report->unused, &xyz, &net_of, cage, network, fault)) ||
	    !(of_curve = curve_sides(&curve_side_count, network, fault)))
		goto done;
	corner = mem_array(half_count, sizeof *corner);
	for (size_t h = 0; h < half_count; h++)
		corner[h] = name[cage->face_corner[h]];
	if (!check_faces(cage, corner, net_of, fault))
		goto done;
	polymesh_init(mesh, xyz, vertex_count, corner, cage->face_start, cage->face_patch, cage->face_count);
	side = mem_array(half_count, sizeof *side);
	for (size_t h = 0; h < half_count; h++) {
		const idx_t a = mesh->origin[h], b = mesh->origin[mesh->next[h]];
		side[h] = (struct side){a < b ? a : b, a < b ? b : a, (idx_t)h};
	}
	qsort(side, half_count, sizeof *side, compare_sides);
	name_of_point = mem_array(network->vertex_count, sizeof *name_of_point);
	for (size_t i = 0; i < network->vertex_count; i++)
		name_of_point[i] = NO_INDEX;
	for (size_t v = 0; v < vertex_count; v++)
		if (net_of[v] != NO_INDEX)
			name_of_point[net_of[v]] = (idx_t)v;
	ok = check_curves(of_curve, curve_side_count, network, side, half_count, name_of_point, fault) &&
	     pair_sides(mesh, &report->border, side, of_curve, curve_side_count, network, net_of, fault);
	if (ok) {
		mark_corners(mesh, network, net_of);
		report->split = polymesh_split_fans(mesh);
	}
done:
	free(xyz), free(net_of), free(name), free(corner), free(name_of_point), free(of_curve), free(side);
	if (!ok)
		polymesh_free(mesh);
	return ok;
}
