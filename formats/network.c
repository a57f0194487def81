#include "formats/network.h"

#include <math.h>
#include <stdlib.h>

/* How much a control polygon's length may differ from the recorded one before it counts as moved by hand: well above
 * the rounding of a different order of summation, far below any edit. */
#define EDIT_TOLERANCE 1e-9

void network_free(struct network *network)
{
	free(network->xyz);
	free(network->kind);
	free(network->curve);
	free(network->point);
	*network = (struct network){0};
}

static bool read_vertices(struct network *network, const struct ply_element *vertex, const char *shown, struct fault *fault)
{
	network->vertex_count = vertex->count;
	network->xyz = ply_points(vertex, shown, fault);
	if (!network->xyz)
		return false;
	idx_t *kind = ply_index_scalar(vertex, "kind", POINT_CORNER, POINT_CREASE + 1, shown, fault);
	if (!kind)
		return false;
	network->kind = mem_array(vertex->count, 1);
	for (size_t v = 0; v < vertex->count; v++)
		network->kind[v] = (unsigned char)kind[v];
	free(kind);
	return true;
}

static bool check_curve(const struct network *network, size_t c, const char *shown, struct fault *fault)
{
	const struct curve *curve = &network->curve[c];
	const size_t least = curve->closed ? 3 : 2;
	if (curve->count < least)
		return fault_set(fault, EX_BAD_INPUT, "%s: curve %zu: %zu points; %s curve has at least %zu", shown, c, curve->count,
		                 curve->closed ? "a closed" : "an open", least);
	const idx_t *point = network->point + curve->first;
	for (size_t i = 0; i < curve->count; i++) {
		const bool is_last = i + 1 == curve->count;
		if (is_last && !curve->closed)
			break;
		if (point[i] == point[is_last ? 0 : i + 1])
			return fault_set(fault, EX_BAD_INPUT, "%s: curve %zu: vertex %" PRIidx " follows itself", shown, c, point[i]);
	}
	return true;
}

static bool read_curves(struct network *network, const struct ply_element *element, const char *shown, struct fault *fault)
{
	network->curve_count = element->count;
	network->curve = mem_array(element->count, sizeof *network->curve);
	const struct ply_column *points = ply_want_list(element, "vertex_indices", shown, fault);
	if (!points)
		return false;
	network->point_count = points->start[element->count];
	network->point = ply_indices(element, points, 0, (long long)network->vertex_count, shown, fault);
	if (!network->point)
		return false;
	idx_t *left = NULL, *right = NULL, *kind = NULL, *closed = NULL;
	double *error = NULL, *length = NULL;
	bool good = false;
	if ((left = ply_index_scalar(element, "left", -1, (long long)INDEX_LIMIT, shown, fault)) &&
	    (right = ply_index_scalar(element, "right", -1, (long long)INDEX_LIMIT, shown, fault)) &&
	    (kind = ply_index_scalar(element, "kind", CURVE_SHARP, CURVE_BORDER + 1, shown, fault)) &&
	    (closed = ply_index_scalar(element, "closed", 0, 2, shown, fault)) &&
	    (error = ply_numbers(element, "error", shown, fault)) &&
	    (length = ply_numbers(element, "length", shown, fault))) {
		good = true;
		for (size_t c = 0; good && c < element->count; c++) {
			network->curve[c] = (struct curve){
				.left = left[c],
				.right = right[c],
				.kind = (enum curve_kind)kind[c],
				.closed = closed[c] != 0,
				.first = points->start[c],
				.count = points->start[c + 1] - points->start[c],
				.error = error[c],
				.length = length[c],
			};
			good = check_curve(network, c, shown, fault);
		}
	}
	free(left);
	free(right);
	free(kind);
	free(closed);
	free(error);
	free(length);
	return good;
}

bool network_from_ply(struct network *network, const struct ply *ply, const char *vertex_element, const char *shown, struct fault *fault)
{
	*network = (struct network){0};
	const struct ply_element *vertex = ply_want_element(ply, vertex_element, shown, fault);
	const struct ply_element *curve = vertex ? ply_want_element(ply, "curve", shown, fault) : NULL;
	if (curve && read_vertices(network, vertex, shown, fault) && read_curves(network, curve, shown, fault))
		return true;
	network_free(network);
	return false;
}

/* The sides of the control polygons, each once a curve, so that any viewer draws them. */
static void put_edges(struct ply *ply, const struct network *network)
{
	size_t count = 0;
	for (size_t c = 0; c < network->curve_count; c++)
		count += network->curve[c].count - !network->curve[c].closed;
	struct ply_element *edge = ply_put_element(ply, "edge", count);
	double *vertex1 = ply_put_scalar(edge, "vertex1", PLY_INT32);
	double *vertex2 = ply_put_scalar(edge, "vertex2", PLY_INT32);
	double *curve_of = ply_put_scalar(edge, "curve", PLY_INT32);
	size_t e = 0;
	for (size_t c = 0; c < network->curve_count; c++) {
		const struct curve *curve = &network->curve[c];
		const idx_t *point = network->point + curve->first;
		for (size_t i = 0; i < curve->count - !curve->closed; i++, e++) {
			vertex1[e] = point[i];
			vertex2[e] = point[(i + 1) % curve->count];
			curve_of[e] = (double)c;
		}
	}
}

void network_to_ply(struct ply *ply, const struct network *network, const char *vertex_element)
{
	struct ply_element *vertex = ply_put_element(ply, vertex_element, network->vertex_count);
	ply_put_points(vertex, network->xyz);
	double *kind = ply_put_scalar(vertex, "kind", PLY_UINT8);
	for (size_t v = 0; v < network->vertex_count; v++)
		kind[v] = network->kind[v];

	const size_t count = network->curve_count;
	struct ply_element *element = ply_put_element(ply, "curve", count);
	double *left = ply_put_scalar(element, "left", PLY_INT32);
	double *right = ply_put_scalar(element, "right", PLY_INT32);
	double *curve_kind = ply_put_scalar(element, "kind", PLY_UINT8);
	double *closed = ply_put_scalar(element, "closed", PLY_UINT8);
	double *error = ply_put_scalar(element, "error", PLY_FLOAT64);
	double *length = ply_put_scalar(element, "length", PLY_FLOAT64);
	/* curves need not stand in point in their order */
	size_t *start = mem_array(count + 1, sizeof *start);
	for (size_t c = 0; c < count; c++)
		start[c + 1] = start[c] + network->curve[c].count;
	idx_t *point = mem_array(start[count], sizeof *point);
	for (size_t c = 0; c < count; c++) {
		const struct curve *curve = &network->curve[c];
		left[c] = curve->left;
		right[c] = curve->right;
		curve_kind[c] = curve->kind;
		closed[c] = curve->closed;
		error[c] = curve->error;
		length[c] = curve->length;
		for (size_t i = 0; i < curve->count; i++)
			point[start[c] + i] = network->point[curve->first + i];
	}
	ply_put_index_lists(element, "vertex_indices", start, point);
	free(start);
	free(point);
	if (ply_element(ply, vertex_element) == ply_element(ply, "vertex"))
		put_edges(ply, network);
}

double network_curve_length(const struct network *network, const struct curve *curve)
{
	const idx_t *point = network->point + curve->first;
	double length = 0;
	for (size_t i = 0; i + !curve->closed < curve->count; i++) {
		const double *a = network->xyz + 3 * (size_t)point[i], *b = network->xyz + 3 * (size_t)point[(i + 1) % curve->count];
		length += sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
	}
	return length;
}

bool network_curve_edited(const struct network *network, const struct curve *curve)
{
	const double now = network_curve_length(network, curve);
	return fabs(now - curve->length) > EDIT_TOLERANCE * fmax(fabs(now), fabs(curve->length));
}
