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
#define MASS_SHIFT 14

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
	int32_t at;
	size_t histogram, second;
	unsigned hits;                            /* HIT_STATES */
	uint32_t zero, side[2][SIDE_CLASSES + 1]; /* masses: of residual 0; below each class on the negative and positive side */
	uint32_t total;
	int classes;
	bool is_out;
	uint32_t low, middle, high; /* mass below the interval's ends */
};

/* The rest is left for expert_start. */
static void expert_set(struct expert *expert, enum ffx_expert kind, int32_t at, unsigned hits)
{
	expert->kind = kind;
	expert->at = at;
	expert->hits = hits;
}

/* classes: as many as residuals on this grid can reach. */
static void expert_start(struct expert *expert, const struct ffx_model *model, int classes)
{
	const uint16_t *count = model->histogram[expert->histogram];
	expert->zero = (uint32_t)count[0] << MASS_SHIFT;
	for (int s = 0; s < 2; s++) {
		expert->side[s][0] = 0;
		for (int e = 0; e < classes; e++)
			expert->side[s][e + 1] = expert->side[s][e] + ((uint32_t)count[1 + 2 * e + s] << MASS_SHIFT);
	}
	expert->classes = classes;
	expert->total = expert->zero + expert->side[0][classes] + expert->side[1][classes];
}

/* Mass of the residuals 1 .. size on one side. */
static inline uint32_t side_mass(const struct expert *expert, int side, int64_t size)
{
	if (size <= 0)
		return 0;
	if (size >= (int64_t)1 << (expert->classes - 1))
		return expert->side[side][expert->classes];
	const int e = size == 1 ? 0 : 64 - __builtin_clzll((uint64_t)size - 1);
	if (e == 0)
		return expert->side[side][1];
	const int64_t inside = size - ((int64_t)1 << (e - 1)); /* of 2^(e-1) values */
	return expert->side[side][e] + (((expert->side[side][e + 1] - expert->side[side][e]) >> (e - 1)) * (uint32_t)inside);
}

/* Mass of all values below x. */
static inline uint32_t mass_below(const struct expert *expert, int64_t x)
{
	const int64_t residual = x - expert->at;
	const uint32_t negative = expert->side[0][expert->classes];
	if (residual <= 0)
		return negative - side_mass(expert, 0, -residual);
	return negative + expert->zero + side_mass(expert, 1, residual - 1);
}

static void expert_learn(const struct expert *expert, struct ffx_model *model, int32_t value)
{
	uint16_t *count = model->histogram[expert->histogram];
	const int class = class_of((int64_t)value - expert->at);
	count[class] = (uint16_t)(count[class] + HISTOGRAM_ONE);
	/* Several experts may share a histogram: its sum may have grown since total was taken, but that waits until the next one.
	 */
	if ((expert->total >> MASS_SHIFT) + HISTOGRAM_ONE > HISTOGRAM_LIMIT)
		for (int i = 0; i < HISTOGRAM_CLASSES; i++)
			count[i] = (uint16_t)((count[i] + 1) / 2);
	if (model->training)
		model->training->histogram[expert->histogram][class]++;
}

static void seen_add(struct seen_values *seen, int32_t value)
{
	for (size_t node = ((size_t)1 << seen->bits) + (size_t)value; node > 0; node /= 2)
		seen->count[node]++;
}

static unsigned alive_class(const struct expert *expert)
{
	const uint32_t alive = expert->high - expert->low, total = expert->total;
	return alive > total / 2 ? 0 : alive > total / 8 ? 1 : alive > total / 64 ? 2 : 3;
}

static unsigned level_class(int bits, int level)
{
	return level >= bits - 2 ? 0 : level >= 5 ? 1 : level >= 2 ? 2 : 3;
}

static int32_t code_coordinate(struct geometry *g, int axis, int phase, struct expert *expert, size_t expert_count, int32_t value)
{
	for (size_t i = 0; i < expert_count; i++) {
		expert_start(&expert[i], g->coder->model, g->bits + 3 < SIDE_CLASSES ? g->bits + 3 : SIDE_CLASSES);
		expert[i].low = mass_below(&expert[i], 0);
		expert[i].high = mass_below(&expert[i], g->steps + (int64_t)1);
	}
	const size_t company = phase >= 0 ? (size_t)phase : expert_count <= 5 ? 0 : expert_count <= 9 ? 1 : 2;
	const size_t cache = phase >= 0 ? 2 : 0;
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
				e->is_out = e->high - e->low <= e->total >> 10;
				if (e->is_out) /* wrong by far, and stays so */
					continue;
				e->middle = mass_below(e, middle);
				const size_t weight =
					(((e->kind * (size_t)ALIVE_CLASSES + alive_class(e)) * HIT_STATES + e->hits) *
						 LEVEL_CLASSES +
					 rung) * COMPANY_CLASSES +
					company;
				mix_logit_twice(g->coder,
						model_log2(e->high - e->middle + 1) - model_log2(e->middle - e->low + 1),
						WEIGHT_EXPERT + weight, e->second);
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
					(((cache + s) * CACHE_CLASSES + class) * LEVEL_CLASSES + rung) * COMPANY_CLASSES +
					company;
				mix_logit(g->coder,
					  model_log2(16 * (uint64_t)count[2 * node + 1] + 2) -
						  model_log2(16 * (uint64_t)count[2 * node] + 2),
					  WEIGHT_CACHE + weight);
			}
			bit = mix_code(g->coder, value >> level & 1);
		}
		for (size_t i = 0; i < expert_count && !bit_known; i++) {
			if (expert[i].is_out)
				continue;
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

void geometry_vertex(struct geometry *g, const struct guesses *guesses, int32_t point[3])
{
	unsigned hits[GUESS_LIMIT] = {0};
	for (int step = 0; step < 3; step++) {
		const int axis = guesses->axis[step];
		struct expert expert[GUESS_LIMIT + PLANE_LIMIT];
		size_t count = 0;
		for (size_t i = 0; i < guesses->guess_count; i++)
			expert_set(&expert[count++], guesses->guess[i].kind, guesses->guess[i].at[axis], hits[i]);
		int32_t told[PLANE_LIMIT];
		enum ffx_expert kind[PLANE_LIMIT];
		const size_t told_count = predict_from_planes(told, kind, guesses, step, point);
		for (size_t i = 0; i < told_count; i++)
			expert_set(&expert[count++], kind[i], told[i], 0);
		for (size_t i = 0; i < count; i++) {
			size_t agree = 0;
			for (size_t j = 0; j < count; j++)
				agree += j != i && expert[j].at == expert[i].at;
			expert[i].second = WEIGHT_SECOND + (expert[i].kind * (size_t)3 + (size_t)step) * AGREE_CLASSES +
					   (agree < AGREE_CLASSES ? agree : AGREE_CLASSES - 1);
			expert[i].histogram = (expert[i].kind * (size_t)HIT_STATES + expert[i].hits) * SCALE_CLASSES + g->scale;
		}
		point[axis] = code_coordinate(g, axis, guesses->phase, expert, count, point[axis]);
		for (size_t i = 0; i < guesses->guess_count; i++) {
			const bool is_hit = guesses->guess[i].at[axis] == point[axis];
			hits[i] = is_hit ? (step == 0 || hits[i] == 1 ? 1 : 2) : 3;
		}
	}
}

void geometry_start(struct geometry *g, struct ffx_coder *coder, int32_t steps)
{
	int bits = 0;
	while (steps >> bits > 0)
		bits++;
	g->coder = coder;
	g->steps = steps;
	g->scale = (unsigned)(bits <= 7 ? 0 : bits >= 11 ? 4 : bits - 7);
	for (int i = 0; i < 4; i++) {
		const size_t size = (size_t)2 << bits;
		if (!g->seen[i].count || g->bits != bits)
			g->seen[i].count = mem_resize(g->seen[i].count, size, sizeof(uint32_t));
		memset(g->seen[i].count, 0, size * sizeof(uint32_t));
		g->seen[i].bits = bits;
	}
	g->bits = bits;
}

void geometry_free(struct geometry *g)
{
	for (int i = 0; i < 4; i++)
		free(g->seen[i].count);
	*g = (struct geometry){0};
}

bool geometry_code(struct ffx_coder *coder, const struct ffx_surface *surface, const idx_t *order, const idx_t *rank,
		   int32_t *grid, int32_t steps, struct fault *fault)
{
	struct geometry g = {0};
	geometry_start(&g, coder, steps);
	bool is_good = true;
	for (size_t i = 0; i < surface->vertex_count && is_good; i++) {
		struct guesses guesses;
		predict_vertex(&guesses, surface, order, rank, i, grid);
		geometry_vertex(&g, &guesses, grid + 3 * (size_t)order[i]);
		if (coder->range.is_overrun)
			is_good = fault_set(fault, EX_BAD_INPUT, "the stream ends too early");
	}
	geometry_free(&g);
	return is_good;
}
