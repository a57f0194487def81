/* Coding of positions: each coordinate bit by bit from the top, every expert a distribution over all values.
 *
 * An expert's guess and its residual histogram say how likely the upper half of the current interval is; the logits of all
 * experts and of the values seen before are mixed. Equal coordinates, planes and smooth continuation need no flags this way. */
#include "formats/ffx_geometry.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "formats/ffx_predict.h"

#define SIDE_CLASSES 17 /* |residual| 1, 2, 3-4, 5-8, ... 32769-65536 */
#define HISTOGRAM_ONE 64
#define HISTOGRAM_LIMIT (400 * HISTOGRAM_ONE)
#define MASS_SHIFT 16

/* A histogram's class: 0 for residual 0, then pairs of - and +. */
static int class_of(int64_t residual)
{
	if (residual == 0)
		return 0;
	uint64_t size = (uint64_t)(residual < 0 ? -residual : residual);
	if (size > 65536)
		size = 65536;
	const int e = size == 1 ? 0 : 64 - __builtin_clzll(size - 1);
	return 1 + 2 * e + (residual > 0);
}

struct expert {
	enum ffx_expert kind;
	int guess; /* which guess of the vertex it is, or -1 */
	int32_t at;
	size_t histogram;
	unsigned hits;                            /* HIT_STATES */
	uint64_t zero, side[2][SIDE_CLASSES + 1]; /* masses: of residual 0; below each class on the negative and positive side */
	uint64_t total;
	uint64_t low, middle, high; /* mass below the interval's ends */
};

static void expert_start(struct expert *expert, const struct ffx_model *model)
{
	const uint16_t *count = model->histogram[expert->histogram];
	expert->zero = (uint64_t)count[0] << MASS_SHIFT;
	for (int s = 0; s < 2; s++) {
		expert->side[s][0] = 0;
		for (int e = 0; e < SIDE_CLASSES; e++)
			expert->side[s][e + 1] = expert->side[s][e] + ((uint64_t)count[1 + 2 * e + s] << MASS_SHIFT);
	}
	expert->total = expert->zero + expert->side[0][SIDE_CLASSES] + expert->side[1][SIDE_CLASSES];
}

/* Mass of the residuals 1 .. size on one side. */
static uint64_t side_mass(const struct expert *expert, int side, int64_t size)
{
	if (size <= 0)
		return 0;
	if (size >= 65536)
		return expert->side[side][SIDE_CLASSES];
	const int e = size == 1 ? 0 : 64 - __builtin_clzll((uint64_t)size - 1);
	if (e == 0)
		return expert->side[side][1];
	const int64_t inside = size - ((int64_t)1 << (e - 1)); /* of 2^(e-1) values */
	return expert->side[side][e] + (((expert->side[side][e + 1] - expert->side[side][e]) >> (e - 1)) * (uint64_t)inside);
}

/* Mass of all values below x. */
static uint64_t mass_below(const struct expert *expert, int64_t x)
{
	const int64_t residual = x - expert->at;
	const uint64_t negative = expert->side[0][SIDE_CLASSES];
	if (residual <= 0)
		return negative - side_mass(expert, 0, -residual);
	return negative + expert->zero + side_mass(expert, 1, residual - 1);
}

static void expert_learn(const struct expert *expert, struct ffx_model *model, int32_t value)
{
	uint16_t *count = model->histogram[expert->histogram];
	const int class = class_of((int64_t)value - expert->at);
	count[class] = (uint16_t)(count[class] + HISTOGRAM_ONE);
	uint32_t sum = 0;
	for (int i = 0; i < HISTOGRAM_CLASSES; i++)
		sum += count[i];
	if (sum > HISTOGRAM_LIMIT)
		for (int i = 0; i < HISTOGRAM_CLASSES; i++)
			count[i] = (uint16_t)((count[i] + 1) / 2);
	if (model->training)
		model->training->histogram[expert->histogram][class]++;
}

/* How often each value has been seen: a binary tree of counts, its root at 1. */
struct seen_values {
	uint32_t *count;
	int bits;
};

static void seen_add(struct seen_values *seen, int32_t value)
{
	for (size_t node = ((size_t)1 << seen->bits) + (size_t)value; node > 0; node /= 2)
		seen->count[node]++;
}

struct geometry {
	struct ffx_coder *coder;
	int32_t steps;
	int bits;
	unsigned scale;             /* SCALE_CLASSES */
	struct seen_values seen[4]; /* by axis, and all */
};

static unsigned alive_class(const struct expert *expert)
{
	const uint64_t alive = expert->high - expert->low, total = expert->total;
	return alive > total / 2 ? 0 : alive > total / 8 ? 1 : alive > total / 64 ? 2 : alive > total / 1024 ? 3 : 4;
}

static unsigned level_class(int bits, int level)
{
	return level >= bits - 2 ? 0 : level >= 5 ? 1 : level >= 2 ? 2 : 3;
}

static int32_t code_coordinate(struct geometry *g, int axis, struct expert *expert, size_t expert_count, int32_t value)
{
	for (size_t i = 0; i < expert_count; i++) {
		expert_start(&expert[i], g->coder->model);
		expert[i].low = mass_below(&expert[i], 0);
		expert[i].high = mass_below(&expert[i], g->steps + (int64_t)1);
	}
	const size_t company = expert_count <= 5 ? 0 : expert_count <= 9 ? 1 : 2;
	int32_t low = 0;
	size_t node = 1;
	for (int level = g->bits - 1; level >= 0; level--) {
		const int32_t middle = low + ((int32_t)1 << level);
		const unsigned bit_known = middle > g->steps;
		unsigned bit = 0;
		if (!bit_known) {
			const size_t rung = level_class(g->bits, level);
			for (size_t i = 0; i < expert_count; i++) {
				struct expert *e = &expert[i];
				e->middle = mass_below(e, middle);
				const size_t weight =
					(((e->kind * (size_t)ALIVE_CLASSES + alive_class(e)) * HIT_STATES + e->hits) *
						 LEVEL_CLASSES +
					 rung) * COMPANY_CLASSES +
					company;
				mix_logit(g->coder, model_log2(e->high - e->middle + 1) - model_log2(e->middle - e->low + 1),
					  WEIGHT_EXPERT + weight);
			}
			for (size_t s = 0; s < 2; s++) {
				const uint32_t *count = g->seen[s == 0 ? axis : 3].count;
				const uint32_t all = count[node];
				if (all == 0)
					continue;
				const size_t class = all <= 1    ? 0
						     : all <= 2  ? 1
						     : all <= 4  ? 2
						     : all <= 8  ? 3
						     : all <= 20 ? 4
								 : 5;
				const size_t weight =
					((s * CACHE_CLASSES + class) * LEVEL_CLASSES + rung) * COMPANY_CLASSES + company;
				mix_logit(g->coder,
					  model_log2(16 * (uint64_t)count[2 * node + 1] + 2) -
						  model_log2(16 * (uint64_t)count[2 * node] + 2),
					  WEIGHT_CACHE + weight);
			}
			bit = mix_code(g->coder, value >> level & 1);
		}
		for (size_t i = 0; i < expert_count && !bit_known; i++) {
			if (bit)
				expert[i].low = expert[i].middle;
			else
				expert[i].high = expert[i].middle;
		}
		node = 2 * node + bit;
		if (bit)
			low = middle;
	}
	for (size_t i = 0; i < expert_count; i++)
		expert_learn(&expert[i], g->coder->model, low);
	seen_add(&g->seen[axis], low);
	seen_add(&g->seen[3], low);
	return low;
}

static void code_vertex(struct geometry *g, const struct guesses *guesses, int32_t point[3])
{
	unsigned hits[GUESS_LIMIT] = {0};
	for (int step = 0; step < 3; step++) {
		const int axis = guesses->axis[step];
		struct expert expert[GUESS_LIMIT + PLANE_LIMIT];
		size_t count = 0;
		for (size_t i = 0; i < guesses->guess_count; i++)
			expert[count++] = (struct expert){.kind = guesses->guess[i].kind,
							  .guess = (int)i,
							  .at = guesses->guess[i].at[axis],
							  .hits = hits[i]};
		int32_t told[PLANE_LIMIT];
		enum ffx_expert kind[PLANE_LIMIT];
		const size_t told_count = predict_from_planes(told, kind, guesses, step, point);
		for (size_t i = 0; i < told_count; i++)
			expert[count++] = (struct expert){.kind = kind[i], .guess = -1, .at = told[i]};
		for (size_t i = 0; i < count; i++)
			expert[i].histogram = (expert[i].kind * (size_t)HIT_STATES + expert[i].hits) * SCALE_CLASSES + g->scale;
		point[axis] = code_coordinate(g, axis, expert, count, point[axis]);
		for (size_t i = 0; i < guesses->guess_count; i++) {
			const bool is_hit = guesses->guess[i].at[axis] == point[axis];
			hits[i] = is_hit ? (step == 0 || hits[i] == 1 ? 1 : 2) : 3;
		}
	}
}

bool geometry_code(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const idx_t *rank,
		   int32_t *grid, int32_t steps, struct fault *fault)
{
	struct geometry g = {.coder = coder, .steps = steps};
	while (steps >> g.bits > 0)
		g.bits++;
	g.scale = (unsigned)(g.bits <= 7 ? 0 : g.bits >= 11 ? 4 : g.bits - 7);
	for (int i = 0; i < 4; i++) {
		g.seen[i].bits = g.bits;
		g.seen[i].count = mem_array((size_t)2 << g.bits, sizeof(uint32_t));
	}
	bool is_good = true;
	for (size_t i = 0; i < surface->vertex_count && is_good; i++) {
		struct guesses guesses;
		predict_vertex(&guesses, surface, order, rank, i, grid);
		code_vertex(&g, &guesses, grid + 3 * (size_t)order[i]);
		if (coder->range.is_overrun)
			is_good = fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
	}
	for (int i = 0; i < 4; i++)
		free(g.seen[i].count);
	return is_good;
}
