/* A tree of boxes over a triangle mesh with a subtree for the triangles of every label, for searches that come again and again while
 * the vertices move. */
#ifndef CAGEWRIGHT_LABELTREE_H
#define CAGEWRIGHT_LABELTREE_H

#include <stdbool.h>

#include "formats/memory.h"

struct label_tree; /* opaque; searches of one tree may run in several threads */

/* Keeps pointers to xyz and triangle (3 * triangle_count, at least one triangle): they must outlive it. label holds any numbers.
 * O(n log n); the tree depends on the input alone. */
struct label_tree *label_tree_new(const double *xyz, const idx_t *triangle, size_t triangle_count, const idx_t *label);
void label_tree_free(struct label_tree *tree);

/* The vertices have moved: new boxes in the old tree, O(n). Searches stay right however far they moved, and fast while neighbours stay
 * neighbours. */
void label_tree_refit(struct label_tree *tree);

/* Measures a triangle; returns how far out the search goes on (the nearest distance so far). */
typedef double label_tree_visitor(void *user, idx_t triangle);

/* Call visit for triangles near p, the nearer box first: at least for all triangles that are not farther from p than the visitor's
 * last answer (at the start: limit), where distances may carry the rounding errors of a few operations. only_label: none but those
 * of that label. */
void label_tree_search(const struct label_tree *tree, const double p[3], double limit, bool only_label, idx_t label, label_tree_visitor *visit,
                       void *user);

#endif
