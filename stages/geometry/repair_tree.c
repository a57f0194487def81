/* A tree of boxes, halved at the median of their centres along the longest side. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/repair_internal.h"

#define LEAF_SIZE 4

struct builder {
	const double *box;
	double *centre; /* 3 an item: low + high */
	struct box_tree *tree;
};

/* By centre along one axis, ties by index, so that the tree is the same everywhere. */
static bool is_before(const struct builder *builder, int axis, size_t a, size_t b)
{
	const double ca = builder->centre[3 * a + (size_t)axis], cb = builder->centre[3 * b + (size_t)axis];
	return ca < cb || (ca == cb && a < b);
}

/* Hoare's selection with the median of three: item[middle] gets its place in the order. */
static void select_median(const struct builder *builder, int axis, size_t low, size_t high, size_t middle)
{
	size_t *const item = builder->tree->item;
	while (high - low > 1) {
		const size_t a = item[low], b = item[low + (high - low) / 2], c = item[high - 1];
		const size_t pivot = is_before(builder, axis, a, b) ? (is_before(builder, axis, b, c)   ? b
								       : is_before(builder, axis, a, c) ? c
													: a)
								    : (is_before(builder, axis, a, c)   ? a
								       : is_before(builder, axis, b, c) ? c
													: b);
		size_t i = low, j = high - 1;
		for (;;) {
			while (is_before(builder, axis, item[i], pivot))
				i++;
			while (is_before(builder, axis, pivot, item[j]))
				j--;
			if (i >= j)
				break;
			const size_t swap = item[i];
			item[i] = item[j];
			item[j] = swap;
			i++;
			j--;
		}
		/* [low, i) before or at the pivot, [j + 1, high) at or behind it */
		if (middle <= j && j + 1 < high)
			high = j + 1;
		else if (middle >= i && i > low)
			low = i;
		else
			return;
	}
}

/* Node n covers items [low, high); its children are n + 1 and the node behind n + 1's part. Returns
 * the node behind its own. */
static size_t build(struct builder *builder, size_t node, size_t low, size_t high)
{
	struct box_tree *const tree = builder->tree;
	double *const box = tree->box + 6 * node;
	double centre_low[3], centre_high[3];
	for (size_t i = 0; i < 3; i++) {
		box[i] = centre_low[i] = INFINITY;
		box[3 + i] = centre_high[i] = -INFINITY;
		for (size_t k = low; k < high; k++) {
			const size_t item = tree->item[k];
			box[i] = fmin(box[i], builder->box[6 * item + i]);
			box[3 + i] = fmax(box[3 + i], builder->box[6 * item + 3 + i]);
			centre_low[i] = fmin(centre_low[i], builder->centre[3 * item + i]);
			centre_high[i] = fmax(centre_high[i], builder->centre[3 * item + i]);
		}
	}
	if (high - low <= LEAF_SIZE)
		return tree->behind[node] = node + 1;
	int axis = 0;
	for (int i = 1; i < 3; i++)
		if (centre_high[i] - centre_low[i] > centre_high[axis] - centre_low[axis])
			axis = i;
	const size_t middle = low + (high - low) / 2;
	select_median(builder, axis, low, high, middle);
	const size_t second = build(builder, node + 1, low, middle);
	return tree->behind[node] = build(builder, second, middle, high);
}

/* As many nodes as build() makes for count items. */
static size_t count_nodes(size_t count)
{
	return count <= LEAF_SIZE ? 1 : 1 + count_nodes(count / 2) + count_nodes(count - count / 2);
}

struct box_tree box_tree_new(const double *box, size_t item_count)
{
	struct box_tree tree = {.item_count = item_count, .item = mem_array(item_count, sizeof *tree.item)};
	tree.node_count = item_count ? count_nodes(item_count) : 0;
	tree.box = mem_array(6 * tree.node_count, sizeof *tree.box);
	tree.behind = mem_array(tree.node_count, sizeof *tree.behind);
	struct builder builder = {box, mem_array(3 * item_count, sizeof *builder.centre), &tree};
	for (size_t k = 0; k < item_count; k++) {
		tree.item[k] = k;
		for (size_t i = 0; i < 3; i++)
			builder.centre[3 * k + i] = box[6 * k + i] + box[6 * k + 3 + i];
	}
	if (item_count)
		build(&builder, 0, 0, item_count);
	free(builder.centre);
	return tree;
}

void box_tree_free(struct box_tree *tree)
{
	free(tree->box);
	free(tree->behind);
	free(tree->item);
	*tree = (struct box_tree){0};
}

struct segment {
	const double *from, *to;
	double inverse[3]; /* 1 / (to - from) */
	double reach;
	void (*visit)(void *user, size_t item);
	void *user;
};

/* Does the segment come into the box, grown by reach on all sides? Slabs (Kay and Kajiya 1986). Comparisons in place of
 * fmin, which the compiler must call. */
static bool meets(const double *box, const struct segment *segment)
{
	double enter = 0, leave = 1;
	for (int i = 0; i < 3; i++) {
		const double start = segment->from[i], low = box[i] - segment->reach, high = box[3 + i] + segment->reach;
		if (start == segment->to[i]) {
			if (start < low || start > high)
				return false;
			continue;
		}
		const double a = (low - start) * segment->inverse[i], b = (high - start) * segment->inverse[i];
		const double first = a < b ? a : b, second = a < b ? b : a;
		enter = first > enter ? first : enter;
		leave = second < leave ? second : leave;
	}
	return enter <= leave;
}

/* Returns the node behind this one's part. */
static size_t walk(const struct box_tree *tree, size_t node, size_t low, size_t high, const struct segment *segment)
{
	if (!meets(tree->box + 6 * node, segment))
		return tree->behind[node];
	if (high - low <= LEAF_SIZE) {
		for (size_t k = low; k < high; k++)
			segment->visit(segment->user, tree->item[k]);
		return node + 1;
	}
	const size_t middle = low + (high - low) / 2;
	return walk(tree, walk(tree, node + 1, low, middle, segment), middle, high, segment);
}

void box_tree_segment(const struct box_tree *tree, const double from[3], const double to[3], double reach,
		      void (*visit)(void *user, size_t item), void *user)
{
	struct segment segment = {from, to, {0}, reach, visit, user};
	for (int i = 0; i < 3; i++)
		segment.inverse[i] = 1 / (to[i] - from[i]); /* unused where they are equal */
	if (tree->node_count)
		walk(tree, 0, 0, tree->item_count, &segment);
}
