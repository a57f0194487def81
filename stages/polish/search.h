/* Fewer points and faces for a cage while it still follows the target. */
#ifndef CAGEWRIGHT_SEARCH_H
#define CAGEWRIGHT_SEARCH_H

#include "stages/polish/judge.h"
#include "stages/polish/moves.h"

/* The cage as the search has it, with what is known of it. */
struct candidate {
	struct sketch sketch;
	struct errors errors;
};
void candidate_free(struct candidate *candidate);
void candidate_copy(struct candidate *out, const struct candidate *in);

/* About how many bits a cage takes when coded. */
double search_bits(const struct sketch *sketch);

struct search_report {
	size_t tried, done;
	size_t by_kind[MOVE_KINDS];
};

void search_add(struct search_report *sum, const struct search_report *report);

/* Greedy removal: merge, collapse, remove, always the edit that costs least error a bit, until the mean distance would exceed most_mean or
 * no edit is left. most_work: end when judge->work is beyond. */
void search_reduce(struct candidate *candidate, const struct judge *judge, double most_mean, size_t most_work, struct search_report *report);

/* Local search: every edit that lowers cost + lambda * bits is taken; lambda in longest sides a bit. One pass over all edits. Returns
 * how many were taken. */
size_t search_improve(struct candidate *candidate, const struct judge *judge, double lambda, size_t most_work, struct search_report *report);

#endif
