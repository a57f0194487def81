/* Step 6: one orientation for each component, outward where it is closed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"
#include "stages/geometry/vector.h"

/* Turn triangle t over: corners a, b, c become a, c, b; its edges keep their pairs. */
static void turn(struct soup *soup, size_t t)
{
	idx_t *corner = soup->triangle + 3 * t, *pair = soup->pair + 3 * t;
	unsigned char *opened = soup->opened + 3 * t;
	const idx_t b = corner[1], first = pair[0];
	const unsigned char first_opened = opened[0];
	corner[1] = corner[2];
	corner[2] = b;
	pair[0] = pair[2];
	pair[2] = first;
	opened[0] = opened[2];
	opened[2] = first_opened;
	for (size_t k = 0; k < 3; k++)
		if (pair[k] != NO_INDEX)
			soup->pair[pair[k]] = (idx_t)(3 * t + k);
}

/* Breadth first from the lowest triangle of each component. Where two ways around contradict each other (a Moebius
 * band), the edge is cut. Of the two orientations a component takes the one that more of its triangles have. */
unsigned char *soup_orient(struct soup *soup)
{
	const size_t count = soup->triangle_count;
	enum { UNSEEN, KEPT, TURNED };
	unsigned char *state = mem_array(count, 1), *touched = mem_array(count, 1);
	idx_t *queue = mem_array(count, sizeof *queue);
	for (size_t seed = 0; seed < count; seed++) {
		if (state[seed] != UNSEEN)
			continue;
		size_t taken = 0, filled = 0, turned = 0;
		state[seed] = KEPT;
		queue[filled++] = (idx_t)seed;
		while (taken < filled) {
			const size_t t = (size_t)queue[taken++];
			turned += state[t] == TURNED;
			for (size_t h = 3 * t; h < 3 * t + 3; h++) {
				const idx_t g = soup->pair[h];
				if (g == NO_INDEX)
					continue;
				const bool same_way = soup->triangle[g] == soup->triangle[h];
				const unsigned char wanted = same_way == (state[t] == KEPT) ? TURNED : KEPT;
				if (state[g / 3] == UNSEEN) {
					state[g / 3] = wanted;
					queue[filled++] = g / 3;
				} else if (state[g / 3] != wanted) {
					soup->pair[h] = soup->pair[g] = NO_INDEX;
					soup->opened[h] = soup->opened[g] = 1;
					soup->report->count[REPAIR_MOEBIUS_CUT]++;
				}
			}
		}
		const unsigned char minority = 2 * turned > filled ? KEPT : TURNED;
		const bool some = turned > 0 && turned < filled;
		for (size_t i = 0; i < filled; i++) {
			touched[queue[i]] = some;
			if (state[queue[i]] == minority) {
				turn(soup, (size_t)queue[i]);
				soup->report->count[REPAIR_FACE_FLIPPED]++;
			}
		}
	}
	free(state);
	free(queue);
	return touched;
}

struct component {
	double low[3], high[3], volume;
	idx_t outermost[3];     /* the vertex furthest along each axis */
	bool is_closed;
	bool was_mixed;         /* had triangles of both orientations */
	unsigned char odd[3];   /* by each of three rays: inside an odd number of others */
};

static struct component *measure(const struct soup *soup, const idx_t *component_of, size_t component_count)
{
	struct component *component = mem_array(component_count, sizeof *component);
	for (size_t c = 0; c < component_count; c++) {
		component[c].is_closed = true;
		for (int i = 0; i < 3; i++) {
			component[c].low[i] = INFINITY;
			component[c].high[i] = -INFINITY;
		}
	}
	for (size_t h = 0; h < 3 * soup->triangle_count; h++) {
		struct component *const c = &component[component_of[h / 3]];
		const double *p = soup->xyz + 3 * (size_t)soup->triangle[h];
		c->is_closed = c->is_closed && soup->pair[h] != NO_INDEX;
		for (int i = 0; i < 3; i++) {
			c->low[i] = fmin(c->low[i], p[i]);
			if (p[i] > c->high[i]) {
				c->high[i] = p[i];
				c->outermost[i] = soup->triangle[h];
			}
		}
	}
	for (size_t t = 0; t < soup->triangle_count; t++) {
		struct component *const c = &component[component_of[t]];
		double corner[3][3], normal[3];
		for (int k = 0; k < 3; k++) /* from the component's own corner: far from the origin sums would cancel */
			sub3(corner[k], soup->xyz + 3 * (size_t)soup->triangle[3 * t + (size_t)k], c->low);
		cross3(normal, corner[1], corner[2]);
		c->volume += dot3(corner[0], normal) / 6;
	}
	return component;
}

struct ray_query {
	const struct soup *soup;
	const idx_t *component_of;
	const struct component *component;
	const size_t *triangle;         /* of each item of the tree */
	const double *from, *to;
	size_t self;
	bool inside_box, is_odd;
};

static void visit_box(void *user, size_t item)
{
	struct ray_query *const query = user;
	const struct component *c = &query->component[item];
	if (item == query->self || !c->is_closed)
		return;
	for (int i = 0; i < 3; i++)
		if (query->from[i] < c->low[i] || query->from[i] > c->high[i])
			return;
	query->inside_box = true;
}

/* Moeller and Trumbore 1997. */
static bool ray_hits(const double from[3], const double to[3], const double a[3], const double b[3], const double c[3])
{
	double along[3], ab[3], ac[3], to_a[3], p[3], q[3];
	sub3(along, to, from);
	sub3(ab, b, a);
	sub3(ac, c, a);
	cross3(p, along, ac);
	const double det = dot3(ab, p);
	if (det == 0)
		return false;
	sub3(to_a, from, a);
	const double u = dot3(to_a, p) / det;
	cross3(q, to_a, ab);
	const double v = dot3(along, q) / det, t = dot3(ac, q) / det;
	return u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < 1;
}

static void visit_triangle(void *user, size_t item)
{
	struct ray_query *const query = user;
	const size_t t = query->triangle[item];
	if ((size_t)query->component_of[t] == query->self)
		return;
	const double *corner[3];
	for (size_t k = 0; k < 3; k++)
		corner[k] = query->soup->xyz + 3 * (size_t)query->soup->triangle[3 * t + k];
	query->is_odd ^= ray_hits(query->from, query->to, corner[0], corner[1], corner[2]);
}

/* Which closed components lie inside an odd number of other closed ones: rays from the outermost vertices along
 * skew directions, two of three decide (a vertex may lie on another surface, a ray may graze an edge). */
static void find_depths(struct component *component, const struct soup *soup, const idx_t *component_of, size_t component_count)
{
	double *box = mem_array(6 * component_count, sizeof *box);
	for (size_t c = 0; c < component_count; c++) {
		copy3(box + 6 * c, component[c].low);
		copy3(box + 6 * c + 3, component[c].high);
	}
	struct box_tree around = box_tree_new(box, component_count);
	size_t *triangle = mem_array(soup->triangle_count, sizeof *triangle), closed = 0;
	for (size_t t = 0; t < soup->triangle_count; t++)
		if (component[component_of[t]].is_closed)
			triangle[closed++] = t;
	free(box);
	box = mem_array(6 * closed, sizeof *box);
	for (size_t k = 0; k < closed; k++)
		for (size_t i = 0; i < 3; i++) {
			const idx_t *corner = soup->triangle + 3 * triangle[k];
			const double a = soup->xyz[3 * (size_t)corner[0] + i], b = soup->xyz[3 * (size_t)corner[1] + i], c = soup->xyz[3 * (size_t)corner[2] + i];
			box[6 * k + i] = fmin(a, fmin(b, c));
			box[6 * k + 3 + i] = fmax(a, fmax(b, c));
		}
	struct box_tree tree = box_tree_new(box, closed);
	free(box);
	/* No direction that a part would have. */
	static const double skew[3][3] = {{1, 0.0713, 0.0391}, {0.0437, 1, 0.0677}, {0.0811, 0.0353, 1}};
	for (size_t c = 0; c < component_count; c++)
		for (int r = 0; r < 3 && component[c].is_closed; r++) {
			double to[3];
			struct ray_query query = {.soup = soup, .component_of = component_of, .component = component, .triangle = triangle, .to = to, .self = c};
			query.from = soup->xyz + 3 * (size_t)component[c].outermost[r];
			box_tree_segment(&around, query.from, query.from, 0, visit_box, &query);
			if (!query.inside_box)
				continue;
			copy3(to, query.from);
			add_scaled3(to, 3 * soup->side, skew[r]);
			box_tree_segment(&tree, query.from, to, 0, visit_triangle, &query);
			component[c].odd[r] = query.is_odd;
		}
	box_tree_free(&tree);
	box_tree_free(&around);
	free(triangle);
}

/* Closed components get positive volume. One inside an odd number of others bounds a void, or is a body in a body (as in
 * overlapping assemblies): it says so by its orientation, and stays; if it has none it is taken for a void. */
void soup_turn_outward(struct soup *soup, const unsigned char *turned, size_t turned_count)
{
	size_t component_count;
	idx_t *component_of = soup_components(soup, &component_count);
	struct component *component = measure(soup, component_of, component_count);
	if (component_count > 1)
		find_depths(component, soup, component_of, component_count);
	for (size_t t = 0; t < soup->triangle_count; t++) /* cuts have added triangles at the end */
		component[component_of[t]].was_mixed |= t < turned_count && turned[t];
	unsigned char *to_turn = mem_array(component_count, 1);
	for (size_t c = 0; c < component_count; c++) {
		const bool is_void = component[c].odd[0] + component[c].odd[1] + component[c].odd[2] >= 2;
		to_turn[c] = component[c].is_closed && (is_void ? component[c].was_mixed && component[c].volume > 0 : component[c].volume < 0);
		soup->report->count[REPAIR_COMPONENT_TURNED] += to_turn[c];
	}
	for (size_t t = 0; t < soup->triangle_count; t++)
		if (to_turn[component_of[t]])
			turn(soup, t);
	free(to_turn);
	free(component);
	free(component_of);
}
