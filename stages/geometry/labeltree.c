/* A tree of boxes, halved at the median of the triangles' middles along their longest extent; above the labels' subtrees the same over
 * whole labels. One triangle a leaf: testing a box is much cheaper than measuring a triangle. */
#include "stages/geometry/labeltree.h"

#include <math.h>
#include <stdlib.h>

/* Rounding errors of a measured distance (about ten operations on coordinates), as a share of the largest coordinate and of the
 * distance itself; generous, since it costs nothing. */
static const double rounding = 1e-14;

struct node {
	double low[3], high[3];
	idx_t child;    /* the first of two nodes side by side, behind this one; NO_INDEX in a leaf */
	idx_t triangle; /* of a leaf */
};

struct label_tree {
	const double *xyz;
	const idx_t *triangle;
	struct node *node;
	size_t node_count;
	idx_t *label;   /* rising, no number twice */
	idx_t *root;    /* a label: the node of its subtree */
	size_t label_count;
	double extent;  /* the largest absolute coordinate */
};

/* A triangle or a whole label on its way into the tree. */
struct item {
	double middle[3];
	idx_t label, number;
};

struct builder {
	struct label_tree *tree;
	struct item *item;   /* triangles, sorted by label */
	struct item *group;  /* labels; number is the place among the labels */
	size_t *group_start; /* a place among the labels: its first triangle */
};

static int compare_labels(const void *a, const void *b)
{
	const struct item *x = a, *y = b;
	return x->label != y->label ? (x->label > y->label) - (x->label < y->label) : (x->number > y->number) - (x->number < y->number);
}

static inline bool comes_before(const struct item *a, const struct item *b, int axis)
{
	return a->middle[axis] != b->middle[axis] ? a->middle[axis] < b->middle[axis] : a->number < b->number;
}

/* Hoare's selection: item[middle] gets its place in the order along the axis; ties by number, so that the tree is the same everywhere. */
static void select_median(struct item *item, size_t count, size_t middle, int axis)
{
	size_t low = 0, high = count; /* [low, high) holds it */
	while (high - low > 1) {
		/* median of three: sorted input must not be the worst case */
		const struct item *a = &item[low], *b = &item[low + (high - low) / 2], *c = &item[high - 1];
		const struct item *median = comes_before(a, b, axis) ? (comes_before(b, c, axis) ? b : comes_before(a, c, axis) ? c : a)
		                                                     : (comes_before(a, c, axis) ? a : comes_before(b, c, axis) ? c : b);
		const struct item pivot = *median;
		size_t i = low, j = high - 1;
		for (;;) {
			while (comes_before(&item[i], &pivot, axis))
				i++;
			while (comes_before(&pivot, &item[j], axis))
				j--;
			if (i >= j)
				break;
			const struct item swap = item[i];
			item[i++] = item[j];
			item[j--] = swap;
		}
		/* [low, i) lie before or at the pivot, (j, high) at or behind it */
		if (middle <= j && j + 1 < high)
			high = j + 1;
		else if (middle >= i && i > low)
			low = i;
		else
			return;
	}
}

/* Order items so that the first half lies before the second along the longest extent; returns the size of the first half. */
static size_t halve(struct item *item, size_t count)
{
	double extent[3];
	for (int k = 0; k < 3; k++) {
		double low = item[0].middle[k], high = low;
		for (size_t i = 1; i < count; i++) {
			const double x = item[i].middle[k];
			low = x < low ? x : low;
			high = x > high ? x : high;
		}
		extent[k] = high - low;
	}
	int axis = 0;
	for (int k = 1; k < 3; k++)
		if (extent[k] > extent[axis])
			axis = k;
	select_median(item, count, count / 2, axis);
	return count / 2;
}

/* Both recursions halve: 31 levels each at most. */
static void build_triangles(struct builder *builder, size_t at, struct item *item, size_t count)
{
	struct label_tree *tree = builder->tree;
	if (count == 1) {
		tree->node[at].child = NO_INDEX;
		tree->node[at].triangle = item->number;
		return;
	}
	const size_t half = halve(item, count), child = tree->node_count;
	tree->node_count += 2;
	tree->node[at].child = (idx_t)child;
	build_triangles(builder, child, item, half);
	build_triangles(builder, child + 1, item + half, count - half);
}

static void build_groups(struct builder *builder, size_t at, struct item *group, size_t count)
{
	struct label_tree *tree = builder->tree;
	if (count == 1) {
		const size_t g = (size_t)group->number;
		tree->root[g] = (idx_t)at;
		build_triangles(builder, at, builder->item + builder->group_start[g], builder->group_start[g + 1] - builder->group_start[g]);
		return;
	}
	const size_t half = halve(group, count), child = tree->node_count;
	tree->node_count += 2;
	tree->node[at].child = (idx_t)child;
	build_groups(builder, child, group, half);
	build_groups(builder, child + 1, group + half, count - half);
}

struct label_tree *label_tree_new(const double *xyz, const idx_t *triangle, size_t triangle_count, const idx_t *label)
{
	struct label_tree *tree = mem_array(1, sizeof *tree);
	tree->xyz = xyz;
	tree->triangle = triangle;
	struct builder builder = {.tree = tree, .item = mem_array(triangle_count, sizeof *builder.item)};
	for (size_t t = 0; t < triangle_count; t++) {
		struct item *item = &builder.item[t];
		item->label = label[t];
		item->number = (idx_t)t;
		for (size_t k = 0; k < 3; k++)
			item->middle[k] = xyz[3 * (size_t)triangle[3 * t] + k] / 3 + xyz[3 * (size_t)triangle[3 * t + 1] + k] / 3
			                  + xyz[3 * (size_t)triangle[3 * t + 2] + k] / 3;
	}
	bool is_sorted = true;
	for (size_t i = 1; i < triangle_count; i++)
		is_sorted &= label[i - 1] <= label[i];
	if (!is_sorted)
		qsort(builder.item, triangle_count, sizeof *builder.item, compare_labels);
	for (size_t i = 0; i < triangle_count; i++)
		tree->label_count += i == 0 || builder.item[i].label != builder.item[i - 1].label;
	tree->label = mem_array(tree->label_count, sizeof *tree->label);
	tree->root = mem_array(tree->label_count, sizeof *tree->root);
	builder.group = mem_array(tree->label_count, sizeof *builder.group);
	builder.group_start = mem_array(tree->label_count + 1, sizeof *builder.group_start);
	for (size_t i = 0, g = 0; i < triangle_count; g++) {
		struct item *group = &builder.group[g];
		group->label = tree->label[g] = builder.item[i].label;
		group->number = (idx_t)g;
		builder.group_start[g] = i;
		for (; i < triangle_count && builder.item[i].label == group->label; i++)
			for (int k = 0; k < 3; k++)
				group->middle[k] += builder.item[i].middle[k];
		for (int k = 0; k < 3; k++)
			group->middle[k] /= (double)(i - builder.group_start[g]);
		builder.group_start[g + 1] = i;
	}
	tree->node = mem_array(2 * triangle_count - 1, sizeof *tree->node);
	tree->node_count = 1;
	build_groups(&builder, 0, builder.group, tree->label_count);
	free(builder.item);
	free(builder.group);
	free(builder.group_start);
	label_tree_refit(tree);
	return tree;
}

void label_tree_free(struct label_tree *tree)
{
	if (tree == NULL)
		return;
	free(tree->node);
	free(tree->label);
	free(tree->root);
	free(tree);
}

void label_tree_refit(struct label_tree *tree)
{
	/* children come behind their parents */
	for (size_t n = tree->node_count; n-- > 0;) {
		struct node *node = &tree->node[n];
		if (node->child == NO_INDEX) {
			const idx_t *t = tree->triangle + 3 * (size_t)node->triangle;
			const double *a = tree->xyz + 3 * (size_t)t[0], *b = tree->xyz + 3 * (size_t)t[1], *c = tree->xyz + 3 * (size_t)t[2];
			for (int k = 0; k < 3; k++) {
				const double low = a[k] < b[k] ? a[k] : b[k], high = a[k] < b[k] ? b[k] : a[k];
				node->low[k] = c[k] < low ? c[k] : low;
				node->high[k] = c[k] > high ? c[k] : high;
			}
		} else {
			const struct node *one = &tree->node[node->child], *two = one + 1;
			for (int k = 0; k < 3; k++) {
				node->low[k] = one->low[k] < two->low[k] ? one->low[k] : two->low[k];
				node->high[k] = one->high[k] > two->high[k] ? one->high[k] : two->high[k];
			}
		}
	}
	tree->extent = 0;
	for (int k = 0; k < 3; k++)
		tree->extent = fmax(tree->extent, fmax(fabs(tree->node->low[k]), fabs(tree->node->high[k])));
}

/* Squared distance of p from a box; 0 inside. */
static inline double box_squared(const struct node *node, const double p[3])
{
	double squared = 0;
	for (int k = 0; k < 3; k++) {
		const double below = node->low[k] - p[k], above = p[k] - node->high[k];
		double d = below > above ? below : above;
		d = d > 0 ? d : 0;
		squared += d * d;
	}
	return squared;
}

static size_t find_root(const struct label_tree *tree, idx_t label)
{
	size_t low = 0, high = tree->label_count;
	while (low < high) {
		const size_t middle = (low + high) / 2;
		if (tree->label[middle] < label)
			low = middle + 1;
		else
			high = middle;
	}
	return low < tree->label_count && tree->label[low] == label ? (size_t)tree->root[low] : SIZE_MAX;
}

static inline double reach_squared(double limit, double slack)
{
	const double reach = limit * (1 + rounding) + slack;
	return reach * reach;
}

void label_tree_search(const struct label_tree *tree, const double p[3], double limit, bool only_label, idx_t label, label_tree_visitor *visit,
                       void *user)
{
	const size_t root = only_label ? find_root(tree, label) : 0;
	if (root == SIZE_MAX)
		return;
	const double slack = rounding * (tree->extent + fabs(p[0]) + fabs(p[1]) + fabs(p[2]));
	double reach = reach_squared(limit, slack);
	struct {
		idx_t node;
		double squared;
	} stack[64]; /* one a level: 31 in a label, as many above */
	size_t depth = 0;
	stack[depth].node = (idx_t)root;
	stack[depth++].squared = box_squared(&tree->node[root], p);
	while (depth > 0) {
		depth--;
		if (stack[depth].squared > reach)
			continue;
		const struct node *node = &tree->node[stack[depth].node];
		bool is_near = true;
		while (is_near && node->child != NO_INDEX) {
			const struct node *one = &tree->node[node->child], *two = one + 1;
			double first = box_squared(one, p), second = box_squared(two, p);
			idx_t other = node->child + 1;
			if (second < first) {
				const double swap = first;
				first = second, second = swap;
				one = two;
				other--;
			}
			if (!(second > reach)) {
				stack[depth].node = other;
				stack[depth++].squared = second;
			}
			is_near = !(first > reach);
			node = one;
		}
		if (is_near)
			reach = reach_squared(visit(user, node->triangle), slack);
	}
}
