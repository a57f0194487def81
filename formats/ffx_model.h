/* The probability model under an FFX stream: adaptive counts, residual histograms and a logistic mixer, in integers.
 *
 * Private to formats/ffx*. Every binary decision is coded from several inputs. An input is a logit in 1/256 of log2, from the
 * counts of a context or from an expert's masses; the mixer adds them with weights (Mattern 2012, "Mixing strategies in data
 * compression"; the idea is Mahoney's PAQ), codes the bit, and lets counts and weights learn. Initial counts, histograms and
 * weights were trained on cages and are compiled in (ffx_tables.c): a stream is too short to learn them. */
#ifndef CAGEWRIGHT_FFX_MODEL_H
#define CAGEWRIGHT_FFX_MODEL_H

#include <assert.h>
#include <stdbool.h>

#include "formats/range.h"

/* --- labels of connectivity ------------------------------------------------------------------------------------- */
enum ffx_label {
	LABEL_F4,
	LABEL_R,
	LABEL_F3,
	LABEL_L,
	LABEL_E,
	LABEL_S,
	LABEL_F5,
	LABEL_F6,
	LABEL_F7,
	LABEL_H,
	LABEL_M,
	LABEL_COUNT
};

#define VALENCE_CAP 6 /* valences 0..5 and more */
#define LENGTH_CAP 6  /* boundary lengths 2, 3, 4, 5, 6, more */
#define LABEL_INPUTS 9
enum {
	CONTEXT_DONE = 0,
	CONTEXT_MORE = CONTEXT_DONE + 4,
	CONTEXT_DEGREE = CONTEXT_MORE + 1, /* Exp-Golomb of long faces, of holes: 2 x 32 */
	CONTEXT_DEGREE_SIZE = 32,
	/* --- flags: sharp edges, corners, patches --- */
	DIHEDRAL_CLASSES = 6,
	SHARP_INPUTS = 7,
	CONTEXT_SHARP = CONTEXT_DEGREE + 2 * CONTEXT_DEGREE_SIZE,
	SHARP_SIZE = 486, /* room of one input */
	CORNER_INPUTS = 3,
	CONTEXT_CORNER = CONTEXT_SHARP + SHARP_INPUTS * SHARP_SIZE,
	CORNER_SIZE = 96,
	CONTEXT_PATCH = CONTEXT_CORNER + CORNER_INPUTS * CORNER_SIZE,
	PATCH_SIZE = 3 * DIHEDRAL_CLASSES,
	/* --- forward coder: borders, components, and the questions about each corner of a face --- */
	CONTEXT_BORDER = CONTEXT_PATCH + PATCH_SIZE, /* 4 */
	CONTEXT_HAS_BORDER = CONTEXT_BORDER + 4,
	CONTEXT_MORE_FORWARD,
	CONTEXT_RANK, /* Exp-Golomb */
	CONTEXT_ASK = CONTEXT_RANK + 32,
	ASK_COUNT = 3, /* along, close, new */
	ASK_INPUTS = 9,
	ASK_ROOM = 480, /* of one input */
	/* --- Face Fixer --- */
	CONTEXT_LABEL = CONTEXT_ASK + ASK_COUNT * ASK_INPUTS * ASK_ROOM, /* a node of the label tree, in each of its inputs */
	LABEL_SIZE_0 = LABEL_COUNT * LENGTH_CAP,
	LABEL_SIZE_1 = LABEL_COUNT * LABEL_COUNT,
	LABEL_SIZE_2 = VALENCE_CAP * VALENCE_CAP * 2,
	LABEL_SIZE_3 = LABEL_COUNT * VALENCE_CAP * LENGTH_CAP,
	LABEL_SIZE_4 = LABEL_COUNT * VALENCE_CAP * 2,
	LABEL_SIZE_5 = VALENCE_CAP * VALENCE_CAP * VALENCE_CAP,
	LABEL_SIZE_6 = 5 * VALENCE_CAP * VALENCE_CAP * 3,
	LABEL_SIZE_7 = 5 * 5 * LENGTH_CAP,
	LABEL_SIZE_8 = VALENCE_CAP * VALENCE_CAP * VALENCE_CAP * 4,
	LABEL_SIZE = LABEL_SIZE_0 + LABEL_SIZE_1 + LABEL_SIZE_2 + LABEL_SIZE_3 + LABEL_SIZE_4 + LABEL_SIZE_5 + LABEL_SIZE_6 +
		     LABEL_SIZE_7 + LABEL_SIZE_8,
	FFX_CONTEXTS = CONTEXT_LABEL + LABEL_COUNT * LABEL_SIZE,
};

/* --- experts of geometry: what kind of prediction ---------------------------------------------------------------- */
enum ffx_expert {
	EXPERT_QUAD,       /* parallelogram inside a quad */
	EXPERT_POLYGON,    /* regular polygon from three consecutive vertices of a face of 5 and more */
	EXPERT_ACROSS,     /* parallelogram across an edge */
	EXPERT_MEAN,       /* mean of those above when there are two or more */
	EXPERT_NEIGHBOUR,  /* a known neighbour's coordinate: the latest */
	EXPERT_NEIGHBOUR2, /* the one before */
	EXPERT_NEIGHBOUR3, /* others */
	EXPERT_DIAGONAL,   /* the vertex opposite in a quad, or two away in a larger face */
	EXPERT_EXTEND,     /* straight on from two vertices in a row */
	EXPERT_PLANE,      /* one plane and two known axes */
	EXPERT_LINE,       /* two planes and one known axis */
	EXPERT_POINT,      /* three planes */
	EXPERT_LAST,       /* the vertex coded before */
	/* Of the forward coder. p is the corner before the new one, n the next known one; d, d2 the boundary's vertices from p
	 * on, outside the face, x, x2 those from n backward; q the corner before p across the last old edge, r behind n likewise.
	 */
	FORE_QUAD,      /* p + n - the opposite corner */
	FORE_ACROSS,    /* a triangle's across its old edge */
	FORE_POLYGON,   /* regular polygon from three corners in a row */
	FORE_PREVIOUS,  /* p + x - n */
	FORE_STRAIGHT,  /* 2 p - q, 2 n - r */
	FORE_FOLLOWING, /* p + d2 - d, n + x2 - x */
	FORE_MEAN,      /* of those */
	FORE_C,         /* coordinates of p, n, the ones next to them, and those above */
	FORE_A,
	FORE_P,
	FORE_B,
	FORE_X,
	FORE_D,
	FORE_X2,
	FORE_D2,
	FORE_Q,
	FORE_R,
	FORE_LAST,         /* the vertex placed before */
	FORE_PLANE,        /* the face's */
	FORE_PLANE_BEHIND, /* p d d2 */
	FORE_PLANE_BEFORE, /* n x x2 */
	FORE_PLANE_ACROSS, /* of the face across, when it alone is known */
	FORE_LINE,         /* two planes, the face's among them */
	FORE_LINE_OTHER,   /* two others */
	FORE_POINT,        /* three */
	EXPERT_COUNT,
};
#define HIT_STATES 4    /* of an expert at earlier axes of the same vertex: none yet, all hit, last hit, last missed */
#define SCALE_CLASSES 5 /* of the grid: up to 7 bits, 8, 9, 10, more */
#define HISTOGRAM_CLASSES 35
#define ALIVE_CLASSES 4
#define LEVEL_CLASSES 4
#define CACHE_CLASSES 6
#define COMPANY_CLASSES 3

enum {
	FFX_HISTOGRAMS = EXPERT_COUNT * HIT_STATES * SCALE_CLASSES,
	CONFIDENCE_CLASSES = 6, /* how often a context has been seen */
	WEIGHT_LABEL = 0,
	WEIGHT_DONE = WEIGHT_LABEL + LABEL_COUNT * LABEL_INPUTS * CONFIDENCE_CLASSES,
	WEIGHT_SHARP = WEIGHT_DONE + CONFIDENCE_CLASSES,
	WEIGHT_CORNER = WEIGHT_SHARP + SHARP_INPUTS * CONFIDENCE_CLASSES,
	WEIGHT_PATCH = WEIGHT_CORNER + CORNER_INPUTS * CONFIDENCE_CLASSES,
	WEIGHT_EXPERT = WEIGHT_PATCH + CONFIDENCE_CLASSES,
	WEIGHT_CACHE = WEIGHT_EXPERT + EXPERT_COUNT * ALIVE_CLASSES * HIT_STATES * LEVEL_CLASSES * COMPANY_CLASSES,
	AGREE_CLASSES = 4, /* a second weight of each expert, by the place of the axis and how many others say the same */
	WEIGHT_SECOND = WEIGHT_CACHE + 4 * CACHE_CLASSES * LEVEL_CLASSES * COMPANY_CLASSES,
	WEIGHT_ASK = WEIGHT_SECOND + EXPERT_COUNT * 3 * AGREE_CLASSES,
	FFX_WEIGHTS = WEIGHT_ASK + ASK_COUNT * ASK_INPUTS * CONFIDENCE_CLASSES,
};

#define TABLE_LEVELS 8
#define TABLE_SHARES 31
#define TABLE_CLASSES ((HISTOGRAM_CLASSES + 1) / 2)

/* --- tables (ffx_tables.c, written by tests/train) --- */
extern const unsigned char ffx_table_context[];                                 /* packed, see model_unpack */
extern const signed char ffx_table_weight[FFX_WEIGHTS];                         /* 1/64 */
extern const unsigned char ffx_table_histogram[FFX_HISTOGRAMS * TABLE_CLASSES]; /* of 0, +-1, ...: 16 log2 of 1/64 observation */

/* --- the model ---------------------------------------------------------------------------------------------------- */
struct ffx_training; /* tests/train looks on through this */
struct ffx_model {
	uint16_t count[2 * FFX_CONTEXTS];                      /* 1/32 of an observation */
	int32_t weight[FFX_WEIGHTS];                           /* 1/65536 */
	uint16_t histogram[FFX_HISTOGRAMS][HISTOGRAM_CLASSES]; /* 1/64 of an observation */
	struct ffx_training *training;
};
struct ffx_training {
	uint64_t count[2 * FFX_CONTEXTS];
	uint64_t histogram[FFX_HISTOGRAMS][HISTOGRAM_CLASSES];
	int weight_shift; /* learning: larger is slower */
};

#define MIX_LIMIT 40
struct ffx_coder {
	struct range range;
	struct ffx_model *model;
	size_t input_count;
	int32_t logit[MIX_LIMIT];
	uint32_t weight[MIX_LIMIT], second[MIX_LIMIT], context[MIX_LIMIT]; /* UINT32_MAX: none */
	uint64_t cost;                                                     /* 1/4096 bit, of all decisions so far */
};

/* Start with the compiled tables. */
void model_init(struct ffx_model *model);
/* A copy of another, started model; of what the forward coder needs only, when that is all that was or will be used. */
void model_reset(struct ffx_model *model, const struct ffx_model *start, bool is_forward);
/* From packed tables: those compiled in, or others (tests/train). */
void model_unpack(struct ffx_model *model, const unsigned char *context, const signed char *weight,
		  const unsigned char *histogram);
/* What a packed context, 1 to 248, and a packed count, 0 to 255, mean in the model's units. */
void model_context_of(uint16_t count[2], unsigned code);
uint16_t model_histogram_of(unsigned code);

/* log2(x) in 1/256, x > 0. */
extern const uint8_t model_log2_table[256];
static inline int32_t model_log2(uint64_t x)
{
	assert(x > 0);
	const int top = 63 - __builtin_clzll(x);
	return top * 256 + model_log2_table[(top > 8 ? x >> (top - 8) : x << (8 - top)) & 255];
}

/* Collect the inputs of one decision, then code it. */
void mix_context(struct ffx_coder *coder, size_t context, size_t weight); /* weight: the first of CONFIDENCE_CLASSES */
#define LOGIT_LIMIT (12 * 256)
static inline void mix_logit(struct ffx_coder *coder, int32_t logit, size_t weight) /* > 0: the bit is rather 1 */
{
	assert(coder->input_count < MIX_LIMIT && weight < FFX_WEIGHTS);
	const size_t i = coder->input_count++;
	coder->logit[i] = logit > LOGIT_LIMIT ? LOGIT_LIMIT : logit < -LOGIT_LIMIT ? -LOGIT_LIMIT : logit;
	coder->weight[i] = (uint32_t)weight;
	coder->second[i] = coder->context[i] = UINT32_MAX;
}
static inline void mix_logit_twice(struct ffx_coder *coder, int32_t logit, size_t weight, size_t second) /* their sum counts */
{
	mix_logit(coder, logit, weight);
	coder->second[coder->input_count - 1] = (uint32_t)second;
}
unsigned mix_code(struct ffx_coder *coder, unsigned bit);

/* One bit that is 1 with probability / RANGE_ONE. */
unsigned model_fixed(struct ffx_coder *coder, uint32_t probability, unsigned bit);
/* One bit from one context, without mixing. */
unsigned model_bit(struct ffx_coder *coder, size_t context, unsigned bit);
/* Equally likely values. */
uint32_t model_uniform(struct ffx_coder *coder, uint32_t count, uint32_t value);
/* Exp-Golomb with adaptive bits: 32 contexts from the first one on. value <= limit < 2^30; larger decoded values come back as
 * limit + 1. */
uint32_t model_golomb(struct ffx_coder *coder, size_t context, uint32_t limit, uint32_t value);

/* Arithmetic shift to the right with rounding down, whatever the compiler does with negative numbers. */
static inline int64_t shift_down(int64_t x, int bits)
{
	return x >= 0 ? x >> bits : -((-x + ((int64_t)1 << bits) - 1) >> bits);
}

#endif
