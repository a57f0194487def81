#include "stages/polish/plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/polish/refit.h"
#include "stages/polish/start.h"

#define MAX_SHARE 0.75          /* of the largest distance allowed from which on distances are dear: measured peaks are higher than samples' */
#define LIMIT_SHARE 0.93
#define MEAN_SLACK 0.99         /* an estimate above this share of the bound is not measured */
#define SLOPE 2.5               /* d log(mean) / d log(bits) near the end, from many parts: what a bit is worth */
#define SETTLE_MEAN 1.04        /* rounded cages outside the bounds by less than this may come within by settling */
#define SETTLE_MAX 1.5
#define SETTLE_FOLDED 1e-3      /* share of the area beyond what is allowed */
#define COARSEST 14.0           /* grid steps in means allowed, from coarse to fine */
#define FINEST 1.5
#define FINEST_SHARE 12         /* of the mean: steps for a cage that only just follows the part */
#define STEP_RATIO 1.0905077    /* an eighth of an octave */
#define WORK_SMALL 1.6e7        /* samples looked at for a small cage */
#define WORK_EDGE 8e4           /* and more for each edge */
#define LARGE 800               /* vertices from which on a cage is not searched: little could be tried in any time */
#define QUICK 150               /* vertices from which on few grids are tried */
#define SMALL 48                /* vertices up to which all grids are tried, with the points as they came too */
#define HOPELESS_BYTES 6        /* more than the best so far before the coordinates are made cheaper: not looked at */
#define MOST_START 600          /* vertices of a collapsed mesh that a search of less than minutes can bring down */
#define PEAK_RETRY 1.06         /* a largest distance outside the bound by less than this is settled once more, with a lower limit */
#define MOST_TURNED 1e-3        /* share of the area that may look away from the mesh, unless more does in the cage as given */
#define MOST_FOLDED 5e-6        /* and from what it is a part of: a cage with more counts for */
#define FOLD_SURCHARGE 1.1      /* so many times its bytes */
#define PEAK_REFITS 4
#define LEAST_TRIED 3           /* grids that are settled for a small cage, whatever work is left; one less for others */
#define START_MEAN 0.3          /* of the mean allowed: where a collapsed mesh begins, */
#define START_MEAN_LARGE 0.55   /* and when that takes many vertices */
#define MOST_PASSES 4           /* of removal and local search for one stop, while removal ends early: */
#define NEARLY 0.9              /* local search lets it go on */
#define MEASURE_WORK 1000000    /* samples looked at in the time of a measurement of the decoded mesh */

struct plan {
	const struct target *target;
	const struct plan_options *options;
	struct judge judge, strict; /* strict sees more samples: for what is rounded */
	struct plan_result *result;
	bool has_result;
	size_t most_work;
	double most_turned, most_folded; /* shares of the area */
	bool takes_unsound; /* parts of the given cage touch already */
	struct decoded_errors measured; /* the last cage that was decoded */
};

#define tell(p, ...) ((p)->options->say ? (p)->options->say(__VA_ARGS__) : (void)0)

/* --- one rounded cage ---------------------------------------------------------------------------------------------------------------- */

/* The stream's size, 0 when it cannot be made; with decoded, what comes out of it. */
static size_t stream_bytes(struct cage *decoded, const struct plan *p, const struct lattice *l, const struct sketch *s, size_t roots)
{
	struct ffx ffx, back;
	struct fault fault = {0};
	struct ffx_report report;
	const struct ffx_options options = {.root_limit = roots};
	unsigned char *bytes;
	size_t size = 0;
	if (!lattice_to_ffx(&ffx, l, s, p->options->middle, p->options->scale))
		return 0;
	*p->judge.work += CODER_WORK * s->vertex_count * (roots ? roots : 8);
	if (ffx_encode(&bytes, &size, &report, &ffx, &options, &fault)) {
		if (decoded && ffx_decode(&back, bytes, size, "stream", &fault)) {
			ffx_to_cage(decoded, &back);
			ffx_free(&back);
		} else if (decoded) {
			size = 0;
		}
		free(bytes);
	}
	ffx_free(&ffx);
	return size;
}

/* How far outside the bounds, 0 within. */
static double excess(const struct plan *p, const struct decoded_errors *e)
{
	return fmax(0, e->mean / p->options->mean - 1) + fmax(0, e->max / p->options->max - 1) + fmax(0, e->turned / p->most_turned - 1);
}

/* What a cage within the bounds costs: tiny folds at cusps are hardly seen, but one without them may take more bytes. */
static double price(const struct plan *p, size_t bytes, const struct decoded_errors *e)
{
	return (double)bytes * (e->folded > p->most_folded ? FOLD_SURCHARGE : 1);
}

static bool measure(struct decoded_errors *errors, const struct plan *p, const struct cage *cage)
{
	return decoded_measure(errors, p->target, cage, p->options->level, p->options->middle, p->options->scale, p->takes_unsound);
}

/* Pack, unpack, measure, and keep when it is the best so far: fewer bytes within the bounds, else nearer to them. Returns whether it is
 * within. The order of faces is that of the stream: largest distances are found by climbing from samples, which depend on it. */
static bool offer(struct plan *p, const struct lattice *l, const struct sketch *s)
{
	struct plan_result *r = p->result;
	struct cage cage, decoded;
	p->measured = (struct decoded_errors){INFINITY, INFINITY, 1, 1};
	const size_t bytes = stream_bytes(&decoded, p, l, s, 0);
	if (bytes == 0)
		return false;
	r->measured++;
	*p->judge.work += MEASURE_WORK;
	struct decoded_errors errors;
	const bool is_measured = measure(&errors, p, &decoded);
	cage_free(&decoded);
	if (!is_measured)
		return false;
	p->measured = errors;
	lattice_to_cage(&cage, l, s, p->options->middle, p->options->scale);
	tell(p, "decoded: %zu bytes, mean %.4g, largest %.4g; turned %.3g, folded %.3g of the area", bytes, errors.mean, errors.max, errors.turned, errors.folded);
	const double now = excess(p, &errors), before = p->has_result ? excess(p, &r->errors) : INFINITY;
	const bool is_better = now == 0 ? before > 0 || price(p, bytes, &errors) < price(p, r->bytes, &r->errors) : now < before;
	if (is_better) {
		if (p->has_result)
			cage_free(&r->cage);
		r->cage = cage, r->bytes = bytes, r->errors = errors, r->is_within = now == 0;
		p->has_result = true;
	} else {
		cage_free(&cage);
	}
	return now == 0;
}

/* A grid worth a closer look. */
struct promise {
	double step;
	size_t bytes;
	int rounds; /* of lattice_round */
};
static int compare_promises(const void *a, const void *b)
{
	const struct promise *p = a, *q = b;
	if (p->bytes != q->bytes)
		return p->bytes < q->bytes ? -1 : 1;
	if (p->step != q->step)
		return p->step > q->step ? -1 : 1;
	return p->rounds - q->rounds;
}

enum { GRIDS = 26 };
static double grid_step(const struct plan *p, int i) { return COARSEST * p->options->mean * pow(STEP_RATIO, -i); }

/* What has been seen of a candidate's grids. */
struct survey {
	struct promise promise[2 * GRIDS];
	size_t count;
	double mean[2][GRIDS]; /* by way of rounding and grid; 0: not looked at */
	double max[2][GRIDS];
};

/* Cages whose points have been fitted are rounded in two ways; others stay as they are, as their maker may have put points in rows. */
static const int rounds_of_way[2] = {0, 3};

static void look_at_grid(struct survey *survey, struct plan *p, const struct candidate *c, int i, int way)
{
	if (survey->mean[way][i] > 0)
		return;
	struct candidate k;
	struct lattice l;
	const double step = grid_step(p, i);
	survey->mean[way][i] = survey->max[way][i] = INFINITY;
	candidate_copy(&k, c);
	if (lattice_round(&l, &k, &p->judge, step, rounds_of_way[way])) {
		p->result->rounded++;
		survey->mean[way][i] = k.errors.mean, survey->max[way][i] = k.errors.max;
		const bool may_do = k.errors.mean < SETTLE_MEAN * p->options->mean && k.errors.max < SETTLE_MAX * p->options->max &&
		                    k.errors.folded < p->most_folded + SETTLE_FOLDED;
		const size_t bytes = may_do ? stream_bytes(NULL, p, &l, &k.sketch, 4) : 0;
		if (bytes > 0)
			survey->promise[survey->count++] = (struct promise){step, bytes, rounds_of_way[way]};
		lattice_free(&l);
	}
	candidate_free(&k);
}

/* Grids from coarse to fine: from a little above the coarsest that may come within the bounds to a little below it. Which of them ends
 * smallest is a matter of luck; small cages get all. */
static void survey_grids(struct survey *survey, struct plan *p, const struct candidate *c, bool is_fitted, size_t most_work)
{
	const bool is_quick = p->options->effort < 7 && c->sketch.vertex_count > QUICK;
	const int before = is_quick ? 1 : 3, most_enough = is_quick ? 2 : 4;
	const double bound = p->options->mean;
	int first = 0, last = GRIDS - 1, enough = 0;
	while (c->sketch.vertex_count > SMALL && first < last) {
		const int middle = (first + last) / 2;
		look_at_grid(survey, p, c, middle, is_fitted);
		if (survey->mean[is_fitted][middle] < SETTLE_MEAN * bound)
			last = middle;
		else
			first = middle + 1;
	}
	for (int i = first > before ? first - before : 0; i < GRIDS && enough < most_enough && (survey->count == 0 || *p->judge.work < most_work); i++) {
		bool is_enough = false;
		for (int way = 0; way < 1 + is_fitted; way++) {
			look_at_grid(survey, p, c, i, way);
			is_enough |= survey->mean[way][i] < 0.9 * bound && survey->max[way][i] < p->options->max;
		}
		enough += is_enough;
	}
	qsort(survey->promise, survey->count, sizeof *survey->promise, compare_promises);
}

/* Make the coordinates cheaper and better, and offer the result; true when it is within the bounds and has no folds. Where only the largest distance is a
 * little too large, once more with a limit as much lower. */
static bool settle(struct plan *p, const struct candidate *c, const struct promise *promise, double lambda)
{
	const struct plan_options *o = p->options;
	struct judge judge = p->strict;
	struct candidate k;
	struct lattice l;
	bool is_within = false;
	candidate_copy(&k, c);
	if (lattice_round(&l, &k, &judge, promise->step, promise->rounds)) {
		const int sweeps = k.sketch.vertex_count > LARGE ? 0 : o->effort > 5 ? 3 : 1;
		for (int attempt = 0; attempt < 2; attempt++) {
			lattice_snap(&l, &k, &judge, o->middle, o->scale);
			lattice_settle(&l, &k, &judge, lambda, sweeps);
			lattice_snap(&l, &k, &judge, o->middle, o->scale);
			const size_t bytes = stream_bytes(NULL, p, &l, &k.sketch, 0);
			tell(p, "settled on %.0f steps: %zu bytes, then %zu; mean %.4g, largest %.4g, folded %.3g", 1 / promise->step, promise->bytes, bytes,
			     k.errors.mean, k.errors.max, k.errors.folded);
			if (bytes == 0 || k.errors.mean > MEAN_SLACK * o->mean || k.errors.max > o->max || (p->result->is_within && (double)bytes >= price(p, p->result->bytes, &p->result->errors)))
				break;
			is_within = offer(p, &l, &k.sketch) && p->measured.folded <= p->most_folded;
			if (is_within || sweeps == 0 || p->measured.mean > o->mean || p->measured.max > PEAK_RETRY * o->max || p->measured.max <= o->max)
				break;
			judge.limit *= 0.98 * o->max / p->measured.max, judge.max *= 0.98 * o->max / p->measured.max;
		}
		lattice_free(&l);
	}
	candidate_free(&k);
	return is_within;
}

/* Round to grids, then settle the cheapest that may come within the bounds, until one does. */
static void round_candidate(struct plan *p, const struct candidate *c, double lambda, bool is_fitted, size_t most_work)
{
	struct survey *survey = mem_array(1, sizeof *survey);
	struct candidate smoothed = {0};
	if (is_fitted) {
		/* peaks that the search did not see are pulled in */
		struct errors seen;
		judge_all(&seen, &p->strict, &c->sketch);
		if (seen.max > p->strict.limit) {
			sketch_copy(&smoothed.sketch, &c->sketch);
			refit_all(&smoothed.sketch, &smoothed.errors, &p->strict, PEAK_REFITS);
			tell(p, "peaks: largest %.4g, fitted again %.4g", seen.max, smoothed.errors.max);
			c = &smoothed;
		}
		errors_free(&seen);
	}
	survey_grids(survey, p, c, is_fitted, most_work);
	const int effort = p->options->effort;
	const size_t most = effort > 6 ? 12 : effort > 3 ? 5 : 3, least = c->sketch.vertex_count > QUICK ? 2 : LEAST_TRIED;
	bool is_within = false;
	for (size_t i = 0; i < survey->count && i < most && !is_within && (i < least || *p->judge.work < most_work); i++) {
		if (p->result->is_within && survey->promise[i].bytes > p->result->bytes + HOPELESS_BYTES)
			break;
		is_within = settle(p, c, &survey->promise[i], lambda);
	}
	free(survey);
	/* a cage that only just follows the part needs a fine grid */
	double before = INFINITY;
	for (double step = FINEST * p->options->mean; is_fitted && !p->result->is_within && step > p->options->mean / FINEST_SHARE; step /= 2) {
		struct candidate k;
		struct lattice l;
		candidate_copy(&k, c);
		if (lattice_round(&l, &k, &p->strict, step, 2)) {
			p->result->rounded++;
			lattice_snap(&l, &k, &p->strict, p->options->middle, p->options->scale);
			offer(p, &l, &k.sketch);
			lattice_free(&l);
		}
		candidate_free(&k);
		/* what a finer grid does not mend is not the grid's fault */
		const double now = excess(p, &p->measured);
		if (now > before / 2)
			break;
		before = now;
	}
	candidate_free(&smoothed);
}

/* --- the whole -------------------------------------------------------------------------------------------------------------------------- */

static double worth_of_a_bit(const struct plan *p, const struct candidate *c)
{
	return SLOPE * p->options->mean / search_bits(&c->sketch);
}

/* Shares of the mean allowed at which the search stops to round what it has. Rounding adds to the mean, the more the coarser: which share ends
 * smallest cannot be told before. */
static const double stop_few[] = {0.65}, stop_some[] = {0.5, 0.66}, stop_usual[] = {0.5, 0.62, 0.74}, stop_many[] = {0.45, 0.53, 0.61, 0.69, 0.77, 0.85};
static const struct effort {
	const double *stop;
	int stops, passes; /* of local search at each */
} efforts[10] = {
	{NULL, 0, 0},        {stop_few, 1, 0},    {stop_few, 1, 1},    {stop_some, 2, 1}, {stop_some, 2, 1},
	{stop_usual, 3, 1}, {stop_usual, 3, 2}, {stop_many, 6, 1}, {stop_many, 6, 2}, {stop_many, 6, 3},
};

/* In samples looked at: some twenty seconds for small cages at the usual effort, twice that for larger ones, and less again for those
 * where little could be tried in any time. */
static size_t work_allowed(int effort, size_t vertices, size_t edges)
{
	const double usual = vertices > LARGE ? WORK_SMALL : fmin(WORK_SMALL + WORK_EDGE * (double)edges, 3 * WORK_SMALL);
	return (size_t)(usual * fmax(effort * effort / 25.0, 0.1));
}

/* The cage as it came, when nothing on a grid is as near to the bounds: facefix finds a grid for it. */
static void keep_given(struct plan *p, const struct cage *given)
{
	struct decoded_errors errors;
	struct plan_result *r = p->result;
	if (r->is_within || !measure(&errors, p, given) || excess(p, &errors) > (p->has_result ? excess(p, &r->errors) : INFINITY))
		return;
	if (p->has_result)
		cage_free(&r->cage);
	cage_copy(&r->cage, given);
	r->cage.grid_step = 0;
	r->bytes = 0, r->errors = errors, r->is_within = excess(p, &errors) == 0, r->is_given = p->has_result = true;
}

/* The bytes that a search from here may end with, in some unit. */
static double outlook(const struct plan *p, const struct candidate *c)
{
	return search_bits(&c->sketch) * pow(c->errors.mean / p->options->mean, 1 / SLOPE) * sqrt(fmax(1, c->errors.max / p->judge.limit));
}

/* Search from one start, to be rounded on the way; uses it up. */
static void search_from(struct plan *p, struct candidate *c, size_t most_work)
{
	const struct plan_options *o = p->options;
	const struct effort *effort = &efforts[o->effort];
	const size_t from = *p->judge.work, room = most_work > from ? most_work - from : 0;
	for (int i = 0; i < effort->stops && (i == 0 || *p->judge.work < most_work); i++) {
		if (o->progress)
			o->progress("searching", (size_t)i, (size_t)effort->stops);
		struct search_report report = {0};
		/* the first stop does most of the search; rounding has its share at the end */
		const size_t share = from + room / 2 + room / 3 * (size_t)i / (size_t)effort->stops;
		const double stop = effort->stop[i] * o->mean;
		for (int pass = 0; pass <= effort->passes || (pass < MOST_PASSES && c->errors.mean < NEARLY * stop); pass++) {
			const size_t done = report.done;
			search_reduce(c, &p->judge, stop, share, &report);
			if (pass < effort->passes || c->errors.mean < NEARLY * stop)
				search_improve(c, &p->judge, worth_of_a_bit(p, c), share, &report);
			if (report.done == done)
				break;
		}
		search_add(&p->result->search, &report);
		if (i > 0 && report.done == 0)
			continue;
		tell(p, "searched: %zu vertices, %zu faces, about %.0f bytes, mean %.3g, largest %.3g of the longest side before rounding", c->sketch.vertex_count,
		    c->sketch.face_count, search_bits(&c->sketch) / 8, c->errors.mean, c->errors.max);
		round_candidate(p, c, worth_of_a_bit(p, c), true, from + room / 2 + room / 2 * (size_t)(i + 1) / (size_t)effort->stops);
	}
	candidate_free(c);
}

bool plan_run(struct plan_result *result, const struct cage *given, struct sketch *sketch, const struct target *target, const struct plan_options *options)
{
	size_t work = 0;
	*result = (struct plan_result){.start_vertices = sketch->vertex_count, .start_faces = sketch->face_count};
	struct plan p = {.target = target, .options = options, .result = result};
	struct target dense;
	target_resample(&dense, target, target->area_count * 3 / 2, target->area_count, SHARP_DEG);
	p.judge = (struct judge){target, MAX_SHARE * options->max, LIMIT_SHARE * options->max, 3, &work, PEAKS_SOME};
	p.strict = (struct judge){&dense, p.judge.max, p.judge.limit, 3, &work, PEAKS_ALL};
	p.most_work = work_allowed(options->effort, sketch->vertex_count, sketch_edge_count(sketch));
	const bool is_large = given->vertex_count > LARGE;
	struct decoded_errors start = {.turned = is_large ? 1 : 0};
	p.takes_unsound = !is_large && !measure(&start, &p, given);
	if (p.takes_unsound)
		measure(&start, &p, given);
	p.most_turned = fmax(start.turned, MOST_TURNED), p.most_folded = fmax(start.folded, MOST_FOLDED);
	struct candidate as_given = {.sketch = *sketch}, c, collapsed;
	*sketch = (struct sketch){0};
	judge_all(&as_given.errors, &p.judge, &as_given.sketch);
	if (!is_large && (options->effort < 3 || given->vertex_count <= SMALL))
		round_candidate(&p, &as_given, worth_of_a_bit(&p, &as_given), false, p.most_work);
	work = 0; /* a search must have its share, however little effort is allowed */
	sketch_copy(&c.sketch, &as_given.sketch);
	refit_all(&c.sketch, &c.errors, &p.judge, is_large ? 1 : 8);
	if (options->effort == 0) {
		if (!is_large)
			round_candidate(&p, &c, worth_of_a_bit(&p, &c), true, p.most_work);
		candidate_free(&c);
	} else {
		const bool has_other = c.sketch.scheme != SCHEME_CATMULLCLARK &&
		                       start_collapsed(&collapsed, c.sketch.scheme, &p.judge, START_MEAN * options->mean, START_MEAN_LARGE * options->mean,
		                                       options->effort < 7 ? MOST_START : LARGE, SHARP_DEG);
		if (has_other) {
			const double cage_outlook = outlook(&p, &c), mesh_outlook = outlook(&p, &collapsed);
			tell(&p, "the cage has %zu vertices and may come down to %.0f bytes, the mesh collapsed has %zu and %.0f", c.sketch.vertex_count,
			     cage_outlook / 8, collapsed.sketch.vertex_count, mesh_outlook / 8);
			result->is_collapsed = mesh_outlook < cage_outlook;
			if (result->is_collapsed) {
				const struct candidate other = c;
				c = collapsed, collapsed = other;
			}
			p.most_work = work_allowed(options->effort, c.sketch.vertex_count, sketch_edge_count(&c.sketch));
		}
		const bool with_both = has_other && options->effort > 6;
		const size_t start_work = work;
		if (c.sketch.vertex_count <= LARGE)
			search_from(&p, &c, start_work + (with_both ? p.most_work / 2 : p.most_work));
		else
			candidate_free(&c);
		if (with_both && collapsed.sketch.vertex_count <= LARGE)
			search_from(&p, &collapsed, start_work + p.most_work);
		else if (has_other)
			candidate_free(&collapsed);
	}
	if (!result->is_within && options->effort >= 3 && given->vertex_count > SMALL && given->vertex_count <= QUICK)
		round_candidate(&p, &as_given, worth_of_a_bit(&p, &as_given), false, 0);
	candidate_free(&as_given);
	target_free(&dense);
	keep_given(&p, given);
	tell(&p, "work: %.3g samples", (double)work);
	return p.has_result;
}
