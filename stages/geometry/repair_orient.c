/* Step 6: one orientation for each component, outward where it is closed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"
#include "stages/geometry/vector.h"

/* Rays to find out whether one component is inside of another, and how near to the rim of a triangle (in barycentric
 * coordinates), or its plane to the start (in lengths of the ray), a hit may be to count. */
#define RAY_LIMIT 12
#define RAY_MARGIN 1e-9

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
	idx_t outermost[3]; /* the vertex furthest along each axis */
	bool is_closed;
	bool was_mixed;      /* had triangles of both orientations */
	size_t first, count; /* its triangles in a list by component */
	bool is_void;        /* inside of an odd number of others */
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
	const size_t *triangle; /* of each item of the tree */
	double from[3], to[3];
	size_t self;
	bool is_boxed; /* some other box has all of this component in it */
	bool is_odd, is_doubtful;
};

/* What is inside of another component has its box inside of the other's box. */
static bool may_contain(const struct ray_query *query, size_t other)
{
	const struct component *in = &query->component[query->self], *out = &query->component[other];
	bool inside = other != query->self && out->is_closed;
	for (int i = 0; i < 3; i++)
		inside = inside && in->low[i] >= out->low[i] && in->high[i] <= out->high[i];
	return inside;
}

static void visit_box(void *user, size_t item)
{
	struct ray_query *const query = user;
	query->is_boxed = query->is_boxed || may_contain(query, item);
}

/* Moeller and Trumbore 1997. */
static bool ray_hits(struct ray_query *query, const double a[3], const double b[3], const double c[3])
{
	double along[3], ab[3], ac[3], to_a[3], p[3], q[3];
	sub3(along, query->to, query->from);
	sub3(ab, b, a);
	sub3(ac, c, a);
	cross3(p, along, ac);
	const double det = dot3(ab, p);
	if (det == 0)
		return false;
	sub3(to_a, query->from, a);
	const double u = dot3(to_a, p) / det;
	cross3(q, to_a, ab);
	const double v = dot3(along, q) / det, t = dot3(ac, q) / det, least = fmin(t, fmin(fmin(u, v), 1 - u - v));
	if (fabs(least) < RAY_MARGIN)
		query->is_doubtful = true;
	return least > 0;
}

static void visit_triangle(void *user, size_t item)
{
	struct ray_query *const query = user;
	const size_t t = query->triangle[item];
	if (!may_contain(query, (size_t)query->component_of[t]))
		return;
	const double *corner[3];
	for (size_t k = 0; k < 3; k++)
		corner[k] = query->soup->xyz + 3 * (size_t)query->soup->triangle[3 * t + k];
	query->is_odd ^= ray_hits(query, corner[0], corner[1], corner[2]);
}

/* Is the component inside of an odd number of others? Rays from its outermost vertices, then from the middles of triangles,
 * until two agree. A ray that grazes an edge, or starts on another surface (bodies may touch), does not count. */
static bool find_void(struct ray_query *query, const struct box_tree *tree, const size_t *by_component)
{
	/* No direction that a part would have. */
	static const double skew[3][3] = {{1, 0.0713, 0.0391}, {0.0437, 1, 0.0677}, {0.0811, 0.0353, 1}};
	const struct component *c = &query->component[query->self];
	const struct soup *soup = query->soup;
	int votes[2] = {0, 0};
	for (size_t r = 0; r < RAY_LIMIT; r++) {
		if (r < 3) {
			copy3(query->from, soup->xyz + 3 * (size_t)c->outermost[r]);
		} else {
			const idx_t *corner = soup->triangle + 3 * by_component[c->first + (r - 3) * c->count / (RAY_LIMIT - 3)];
			for (size_t i = 0; i < 3; i++)
				query->from[i] = (soup->xyz[3 * (size_t)corner[0] + i] + soup->xyz[3 * (size_t)corner[1] + i] +
						  soup->xyz[3 * (size_t)corner[2] + i]) /
						 3;
		}
		copy3(query->to, query->from);
		add_scaled3(query->to, 3 * soup->side, skew[r % 3]);
		query->is_odd = query->is_doubtful = false;
		box_tree_segment(tree, query->from, query->to, 0, visit_triangle, query);
		if (!query->is_doubtful && ++votes[query->is_odd] == 2)
			return query->is_odd;
	}
	return votes[1] > votes[0];
}

static struct box_tree triangle_tree(const struct soup *soup, const size_t *triangle, size_t count)
{
	double *box = mem_array(6 * count, sizeof *box);
	for (size_t k = 0; k < count; k++)
		for (size_t i = 0; i < 3; i++) {
			const idx_t *corner = soup->triangle + 3 * triangle[k];
			const double a = soup->xyz[3 * (size_t)corner[0] + i], b = soup->xyz[3 * (size_t)corner[1] + i],
				     c = soup->xyz[3 * (size_t)corner[2] + i];
			box[6 * k + i] = fmin(a, fmin(b, c));
			box[6 * k + 3 + i] = fmax(a, fmax(b, c));
		}
	struct box_tree tree = box_tree_new(box, count);
	free(box);
	return tree;
}

/* Fills is_void of the closed components. */
static void find_voids(struct component *component, const struct soup *soup, const idx_t *component_of, size_t component_count)
{
	double *box = mem_array(6 * component_count, sizeof *box);
	size_t *triangle = mem_array(soup->triangle_count, sizeof *triangle), closed = 0;
	for (size_t t = 0; t < soup->triangle_count; t++)
		component[component_of[t]].count++;
	for (size_t c = 0; c < component_count; c++) {
		copy3(box + 6 * c, component[c].low);
		copy3(box + 6 * c + 3, component[c].high);
		component[c].first = closed;
		if (component[c].is_closed)
			closed += component[c].count;
		component[c].count = 0;
	}
	for (size_t t = 0; t < soup->triangle_count; t++) {
		struct component *const c = &component[component_of[t]];
		if (c->is_closed)
			triangle[c->first + c->count++] = t;
	}
	struct box_tree around = box_tree_new(box, component_count), tree = triangle_tree(soup, triangle, closed);
	free(box);
	for (size_t c = 0; c < component_count; c++) {
		struct ray_query query = {
			.soup = soup, .component_of = component_of, .component = component, .triangle = triangle, .self = c};
		const double *at = soup->xyz + 3 * (size_t)component[c].outermost[0];
		if (component[c].is_closed)
			box_tree_segment(&around, at, at, 0, visit_box, &query);
		component[c].is_void = query.is_boxed && find_void(&query, &tree, triangle);
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
		find_voids(component, soup, component_of, component_count);
	for (size_t t = 0; t < soup->triangle_count; t++) /* cuts have added triangles at the end */
		component[component_of[t]].was_mixed |= t < turned_count && turned[t];
	unsigned char *to_turn = mem_array(component_count, 1);
	for (size_t c = 0; c < component_count; c++) {
		to_turn[c] = component[c].is_closed &&
			     (component[c].is_void ? component[c].was_mixed && component[c].volume > 0 : component[c].volume < 0);
		soup->report->count[REPAIR_COMPONENT_TURNED] += to_turn[c];
	}
	for (size_t t = 0; t < soup->triangle_count; t++)
		if (to_turn[component_of[t]])
			turn(soup, t);
	free(to_turn);
	free(component);
	free(component_of);
}
