/* Wedges, patches and the edges between them: see wedge.h. */
#include "stages/geometry/wedge.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/vector.h"

/* The outgoing half-edge counter-clockwise behind h around its origin, NO_INDEX over a border. */
static idx_t turn_left(const struct half *half, idx_t h)
{
	return half->twin[half->previous[h]];
}

/* The outgoing half-edge clockwise behind h, NO_INDEX over a border. */
static idx_t turn_right(const struct half *half, idx_t h)
{
	return half->twin[h] == NO_INDEX ? NO_INDEX : half->next[half->twin[h]];
}

/* Where a walk to the left around vertex v meets every corner and no wedge is entered in its middle: at the border,
 * else at a feature edge, else anywhere. */
static idx_t fan_start(const struct half *half, const unsigned char *feature, size_t v)
{
	const idx_t first = half->outgoing[v];
	idx_t start = first;
	for (idx_t h = first;;) {
		if (feature[h])
			start = h;
		const idx_t right = turn_right(half, h);
		if (right == NO_INDEX)
			return h;
		if (right == first)
			return start;
		h = right;
	}
}

size_t wedge_number(idx_t *triangle_wedge, idx_t **wedge_vertex, const struct half *half, const unsigned char *feature)
{
	size_t count = 0;
	for (size_t v = 0; v < half->vertex_count; v++) {
		if (half->outgoing[v] == NO_INDEX)
			continue;
		const idx_t start = fan_start(half, feature, v);
		idx_t h = start;
		do {
			if (h != start && feature[h])
				count++;
			triangle_wedge[h] = (idx_t)count;
			h = turn_left(half, h);
		} while (h != NO_INDEX && h != start);
		count++;
	}
	if (wedge_vertex) {
		*wedge_vertex = mem_array(count, sizeof **wedge_vertex);
		for (size_t h = 0; h < half->half_count; h++)
			(*wedge_vertex)[triangle_wedge[h]] = half->origin[h];
	}
	return count;
}

/* An edge by its vertices, to look half-edges up. */
struct edge_key {
	idx_t low, high, half;
};

static int compare_keys(const void *a, const void *b)
{
	const struct edge_key *p = a, *q = b;
	if (p->low != q->low)
		return p->low < q->low ? -1 : 1;
	if (p->high != q->high)
		return p->high < q->high ? -1 : 1;
	return (p->half > q->half) - (p->half < q->half);
}

static struct edge_key edge_key(idx_t a, idx_t b, idx_t h)
{
	return (struct edge_key){a < b ? a : b, a < b ? b : a, h};
}

bool wedge_mark_edges(unsigned char *kind, const struct dense *dense, const struct half *half, const char *shown, struct fault *fault)
{
	struct edge_key *key = mem_array(half->half_count, sizeof *key);
	size_t count = 0;
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t twin = half->twin[h];
		kind[h] = twin == NO_INDEX ? EDGE_BORDER : 0;
		if (twin == NO_INDEX || (idx_t)h < twin)
			key[count++] = edge_key(half->origin[h], half->origin[half->next[h]], (idx_t)h);
	}
	qsort(key, count, sizeof *key, compare_keys);
	bool is_good = true;
	for (size_t e = 0; is_good && e < dense->edge_count; e++) {
		const struct edge_key want = edge_key(dense->edge[e].vertex1, dense->edge[e].vertex2, NO_INDEX);
		size_t low = 0, high = count;
		while (low < high) {
			const size_t middle = low + (high - low) / 2;
			if (compare_keys(&key[middle], &want) < 0)
				low = middle + 1;
			else
				high = middle;
		}
		if (low == count || key[low].low != want.low || key[low].high != want.high) {
			is_good = fault_set(fault, EX_BAD_INPUT, "%s: edge %zu: vertices %" PRIidx " and %" PRIidx " are no edge of the mesh",
			                    shown, e, dense->edge[e].vertex1, dense->edge[e].vertex2);
			break;
		}
		const idx_t h = key[low].half;
		kind[h] = (unsigned char)dense->edge[e].kind;
		if (half->twin[h] != NO_INDEX)
			kind[half->twin[h]] = kind[h];
	}
	free(key);
	return is_good;
}

void wedge_bends(double *bend, const double *xyz, const double *normal, const struct half *half)
{
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t twin = half->twin[h];
		bend[h] = 0;
		if (twin == NO_INDEX)
			continue;
		if (twin < (idx_t)h) {
			bend[h] = bend[twin]; /* the same bits on both sides */
			continue;
		}
		const double *n1 = normal + 3 * half->face[h], *n2 = normal + 3 * half->face[twin];
		double e[3], c[3];
		sub3(e, xyz + 3 * half->origin[half->next[h]], xyz + 3 * half->origin[h]);
		normalise3(e);
		cross3(c, n1, n2);
		const double sine = dot3(c, e), cosine = dot3(n1, n2);
		if (sine != 0 || cosine != 0) /* a missing normal bends nothing */
			bend[h] = atan2(sine, cosine);
	}
}

void wedge_triangle_normals(double *normal, const double *xyz, const struct half *half, double thin)
{
	const size_t n = half->face_count;
	idx_t *queue = mem_array(n, sizeof *queue), *longest = mem_array(n, sizeof *longest);
	unsigned char *done = mem_array(n, 1);
	size_t tail = 0;
	for (size_t t = 0; t < n; t++) {
		const double *p[3];
		double *out = normal + 3 * t;
		double best = -1;
		for (int k = 0; k < 3; k++)
			p[k] = xyz + 3 * half->origin[3 * t + k];
		for (int k = 0; k < 3; k++) {
			const double length = distance3(p[k], p[(k + 1) % 3]);
			if (length > best)
				best = length, longest[t] = (idx_t)(3 * t + k);
		}
		area_vector3(out, p[0], p[1], p[2]);
		const double area2 = normalise3(out);
		done[t] = area2 > thin * best;
		if (done[t])
			queue[tail++] = (idx_t)t;
		else
			memset(out, 0, 3 * sizeof *out);
	}
	/* breadth first from sound triangles; over its longest edge first, over any edge in the end */
	for (int any_edge = 0; any_edge < 2; any_edge++) {
		for (size_t i = 0; i < tail; i++) {
			const idx_t t = queue[i];
			for (int k = 0; k < 3; k++) {
				const idx_t twin = half->twin[3 * t + k];
				if (twin == NO_INDEX || done[half->face[twin]])
					continue;
				const idx_t other = half->face[twin];
				if (!any_edge && longest[other] != twin)
					continue;
				copy3(normal + 3 * other, normal + 3 * t);
				done[other] = 1;
				queue[tail++] = other;
			}
		}
	}
	free(queue);
	free(longest);
	free(done);
}

size_t patch_components(idx_t *component, const idx_t *label, const struct half *half)
{
	const size_t n = half->face_count;
	idx_t *stack = mem_array(n, sizeof *stack);
	size_t count = 0;
	for (size_t t = 0; t < n; t++)
		component[t] = NO_INDEX;
	for (size_t seed = 0; seed < n; seed++) {
		if (component[seed] != NO_INDEX)
			continue;
		size_t top = 0;
		stack[top++] = (idx_t)seed;
		component[seed] = (idx_t)count;
		while (top > 0) {
			const idx_t t = stack[--top];
			for (int k = 0; k < 3; k++) {
				const idx_t twin = half->twin[3 * t + k];
				if (twin == NO_INDEX)
					continue;
				const idx_t other = half->face[twin];
				if (component[other] == NO_INDEX && (!label || label[other] == label[t])) {
					component[other] = (idx_t)count;
					stack[top++] = other;
				}
			}
		}
		count++;
	}
	free(stack);
	return count;
}

/* True when the patch of half-edge h ends at its edge. */
static bool is_patch_border(const struct half *half, const idx_t *label, idx_t h)
{
	const idx_t twin = half->twin[h];
	return twin == NO_INDEX || label[half->face[twin]] != label[half->face[h]];
}

void patch_topologies(struct patch_topology *topology, size_t patch_count, const idx_t *label, const struct half *half)
{
	memset(topology, 0, patch_count * sizeof *topology);
	idx_t *component = mem_array(half->face_count, sizeof *component);
	const size_t component_count = patch_components(component, label, half);
	unsigned char *seen = mem_array(component_count, 1);
	for (size_t t = 0; t < half->face_count; t++) {
		struct patch_topology *p = &topology[label[t]];
		p->faces++;
		if (!seen[component[t]]) {
			seen[component[t]] = 1;
			p->components++;
		}
	}
	free(seen);
	free(component);

	unsigned char *feature = mem_array(half->half_count, 1);
	unsigned char *walked = mem_array(half->half_count, 1);
	for (size_t h = 0; h < half->half_count; h++) {
		feature[h] = is_patch_border(half, label, (idx_t)h);
		if (feature[h] || (idx_t)h < half->twin[h])
			topology[label[half->face[h]]].edges++;
	}
	/* fans bounded by patch borders are the vertices after splitting */
	for (size_t v = 0; v < half->vertex_count; v++) {
		if (half->outgoing[v] == NO_INDEX)
			continue;
		const idx_t start = fan_start(half, feature, v);
		idx_t h = start;
		do {
			if (h == start || feature[h])
				topology[label[half->face[h]]].vertices++;
			h = turn_left(half, h);
		} while (h != NO_INDEX && h != start);
	}
	/* border loops: from the end of a border half-edge turn through the patch to its next border half-edge */
	for (size_t h = 0; h < half->half_count; h++) {
		if (!feature[h] || walked[h])
			continue;
		topology[label[half->face[h]]].border_loops++;
		idx_t g = (idx_t)h;
		do {
			walked[g] = 1;
			g = half->next[g];
			while (!feature[g])
				g = half->next[half->twin[g]];
		} while (!walked[g]);
	}
	for (size_t p = 0; p < patch_count; p++) {
		struct patch_topology *q = &topology[p];
		q->euler = (long)q->vertices - (long)q->edges + (long)q->faces;
		q->genus = (2 - (long)q->border_loops - q->euler) / 2;
	}
	free(feature);
	free(walked);
}

static int compare_adjacencies(const void *a, const void *b)
{
	const struct patch_adjacency *p = a, *q = b;
	if (p->first != q->first)
		return p->first < q->first ? -1 : 1;
	if (p->second != q->second)
		return p->second < q->second ? -1 : 1;
	/* only lengths are left to differ: any order that depends on them alone gives the same sums */
	if (p->length != q->length)
		return p->length < q->length ? -1 : 1;
	return (p->sharp_length > q->sharp_length) - (p->sharp_length < q->sharp_length);
}

size_t patch_adjacencies(struct patch_adjacency **list, const idx_t *label, const double *xyz, const unsigned char *kind, const struct half *half)
{
	struct patch_adjacency *a = mem_array(half->half_count / 2 + 1, sizeof *a);
	size_t count = 0;
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t twin = half->twin[h];
		if (twin == NO_INDEX || twin < (idx_t)h)
			continue;
		const idx_t l = label[half->face[h]], r = label[half->face[twin]];
		if (l == r)
			continue;
		const double length = distance3(xyz + 3 * half->origin[h], xyz + 3 * half->origin[twin]);
		a[count++] = (struct patch_adjacency){l < r ? l : r, l < r ? r : l, length, kind && kind[h] ? length : 0};
	}
	qsort(a, count, sizeof *a, compare_adjacencies);
	size_t kept = 0;
	for (size_t i = 0; i < count; i++) {
		if (kept > 0 && a[kept - 1].first == a[i].first && a[kept - 1].second == a[i].second) {
			a[kept - 1].length += a[i].length;
			a[kept - 1].sharp_length += a[i].sharp_length;
		} else {
			a[kept++] = a[i];
		}
	}
	*list = a;
	return kept;
}
