/* Minimum cut of an undirected graph with terminals. */
#ifndef CAGEWRIGHT_MINCUT_H
#define CAGEWRIGHT_MINCUT_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/memory.h"

/* An undirected edge; cutting it costs weight >= 0. */
struct mincut_edge {
	idx_t a, b;
	double weight;
};

/* Divide node_count nodes in two so that the sum of side_cost[2 * i + side[i]] and of the weights of edges between the
 * sides is least. side[i] is 0 or 1; where both are as good, 1. Y. Dinitz's algorithm (1970) on the residual graph, with at most phase_limit
 * phases: returns false when that was not enough (side is then a cut, but not the least). */
bool mincut_solve(unsigned char *side, size_t node_count, const double *side_cost, const struct mincut_edge *edge, size_t edge_count,
                  size_t phase_limit);

#endif
