/* From a cage within bounds to one of the fewest bytes within the same bounds: reduce, improve, round, measure, again and again, and keep
 * the best. */
#ifndef CAGEWRIGHT_PLAN_H
#define CAGEWRIGHT_PLAN_H

#include "stages/polish/decoded.h"
#include "stages/polish/lattice.h"

#define SHARP_DEG 30 /* edges of the dense mesh that get samples of their own */

struct plan_options {
	double mean, max;   /* bounds of the deviation as decoded, longest sides */
	int level;          /* subdivision level that is measured */
	int effort;         /* 0 to 9 */
	const double *middle;
	double scale;       /* of the target: model = middle + scale * x */
	void (*progress)(const char *what, size_t done, size_t total);
	void (*say)(const char *format, ...) __attribute__((format(printf, 1, 2)));
};

struct plan_result {
	struct cage cage;     /* on its grid, model units */
	size_t bytes;
	struct decoded_errors errors;
	bool is_within;
	bool is_collapsed;    /* the search began at the collapsed mesh */
	bool is_given;        /* the cage as it came, on no grid: nothing on one was nearer to the bounds */
	struct search_report search;
	size_t rounded, measured; /* candidates that were rounded, and decoded */
	size_t start_vertices, start_faces;
};

/* sketch: given with the target's longest side 1; it is used up. The time is bounded by effort and size, not by the clock. False when the cage cannot be rounded or coded at all (*result is
 * empty then). */
bool plan_run(struct plan_result *result, const struct cage *given, struct sketch *sketch, const struct target *target,
              const struct plan_options *options);

#endif
