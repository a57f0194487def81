/* The probability model under an FFX stream (see ffx_model.h). */
#include "formats/ffx_model.h"

#include <assert.h>
#include <string.h>

/* 4096 * log2(1 + i / 256) */
static const uint16_t log2_table[257] = {
	0,    23,   46,   69,   92,   114,  137,  159,  182,  204,  226,  249,  271,  293,  315,  336,  358,  380,  402,  423,
	445,  466,  487,  508,  530,  551,  572,  593,  613,  634,  655,  675,  696,  716,  737,  757,  778,  798,  818,  838,
	858,  878,  898,  918,  937,  957,  977,  996,  1016, 1035, 1054, 1074, 1093, 1112, 1131, 1150, 1169, 1188, 1207, 1226,
	1244, 1263, 1282, 1300, 1319, 1337, 1355, 1374, 1392, 1410, 1428, 1446, 1465, 1483, 1500, 1518, 1536, 1554, 1572, 1589,
	1607, 1624, 1642, 1659, 1677, 1694, 1712, 1729, 1746, 1763, 1780, 1797, 1814, 1831, 1848, 1865, 1882, 1899, 1915, 1932,
	1949, 1965, 1982, 1998, 2015, 2031, 2047, 2064, 2080, 2096, 2112, 2128, 2145, 2161, 2177, 2192, 2208, 2224, 2240, 2256,
	2272, 2287, 2303, 2319, 2334, 2350, 2365, 2381, 2396, 2411, 2427, 2442, 2457, 2472, 2488, 2503, 2518, 2533, 2548, 2563,
	2578, 2593, 2608, 2622, 2637, 2652, 2667, 2681, 2696, 2711, 2725, 2740, 2754, 2769, 2783, 2798, 2812, 2826, 2841, 2855,
	2869, 2883, 2897, 2911, 2926, 2940, 2954, 2968, 2982, 2995, 3009, 3023, 3037, 3051, 3065, 3078, 3092, 3106, 3119, 3133,
	3146, 3160, 3174, 3187, 3200, 3214, 3227, 3241, 3254, 3267, 3280, 3294, 3307, 3320, 3333, 3346, 3359, 3373, 3386, 3399,
	3412, 3424, 3437, 3450, 3463, 3476, 3489, 3502, 3514, 3527, 3540, 3552, 3565, 3578, 3590, 3603, 3615, 3628, 3640, 3653,
	3665, 3678, 3690, 3702, 3715, 3727, 3739, 3751, 3764, 3776, 3788, 3800, 3812, 3824, 3836, 3849, 3861, 3873, 3885, 3896,
	3908, 3920, 3932, 3944, 3956, 3968, 3979, 3991, 4003, 4015, 4026, 4038, 4050, 4061, 4073, 4084, 4096,
};

/* 65536 * 2^(i / 256) */
static const uint32_t exp2_table[256] = {
	65536,  65714,  65892,  66071,  66250,  66429,  66609,  66790,  66971,  67153,  67335,  67517,  67700,  67884,  68068,
	68252,  68438,  68623,  68809,  68996,  69183,  69370,  69558,  69747,  69936,  70126,  70316,  70507,  70698,  70889,
	71082,  71274,  71468,  71661,  71856,  72050,  72246,  72442,  72638,  72835,  73032,  73230,  73429,  73628,  73828,
	74028,  74229,  74430,  74632,  74834,  75037,  75240,  75444,  75649,  75854,  76060,  76266,  76473,  76680,  76888,
	77096,  77305,  77515,  77725,  77936,  78147,  78359,  78572,  78785,  78998,  79212,  79427,  79642,  79858,  80075,
	80292,  80510,  80728,  80947,  81166,  81386,  81607,  81828,  82050,  82273,  82496,  82719,  82944,  83169,  83394,
	83620,  83847,  84074,  84302,  84531,  84760,  84990,  85220,  85451,  85683,  85915,  86148,  86382,  86616,  86851,
	87086,  87322,  87559,  87796,  88034,  88273,  88513,  88752,  88993,  89234,  89476,  89719,  89962,  90206,  90451,
	90696,  90942,  91188,  91436,  91684,  91932,  92181,  92431,  92682,  92933,  93185,  93438,  93691,  93945,  94200,
	94455,  94711,  94968,  95226,  95484,  95743,  96002,  96263,  96524,  96785,  97048,  97311,  97575,  97839,  98104,
	98370,  98637,  98905,  99173,  99442,  99711,  99982,  100253, 100524, 100797, 101070, 101344, 101619, 101895, 102171,
	102448, 102726, 103004, 103283, 103564, 103844, 104126, 104408, 104691, 104975, 105260, 105545, 105831, 106118, 106406,
	106694, 106984, 107274, 107565, 107856, 108149, 108442, 108736, 109031, 109326, 109623, 109920, 110218, 110517, 110816,
	111117, 111418, 111720, 112023, 112327, 112631, 112937, 113243, 113550, 113858, 114167, 114476, 114787, 115098, 115410,
	115723, 116036, 116351, 116667, 116983, 117300, 117618, 117937, 118257, 118577, 118899, 119221, 119544, 119869, 120194,
	120519, 120846, 121174, 121502, 121832, 122162, 122493, 122825, 123158, 123492, 123827, 124163, 124500, 124837, 125176,
	125515, 125855, 126197, 126539, 126882, 127226, 127571, 127917, 128263, 128611, 128960, 129310, 129660, 130012, 130364,
	130718,
};

/* 256 * log2(1 + (i + 1/2) / 256) */
const uint8_t model_log2_table[256] = {
	1,   2,   4,   5,   6,   8,   9,   11,  12,  13,  15,  16,  18,  19,  20,  22,  23,  24,  26,  27,  28,  30,  31,  32,
	34,  35,  36,  38,  39,  40,  42,  43,  44,  45,  47,  48,  49,  50,  52,  53,  54,  55,  57,  58,  59,  60,  62,  63,
	64,  65,  66,  68,  69,  70,  71,  72,  74,  75,  76,  77,  78,  80,  81,  82,  83,  84,  85,  86,  88,  89,  90,  91,
	92,  93,  94,  95,  97,  98,  99,  100, 101, 102, 103, 104, 105, 106, 108, 109, 110, 111, 112, 113, 114, 115, 116, 117,
	118, 119, 120, 121, 122, 123, 124, 125, 126, 127, 128, 129, 131, 132, 133, 134, 135, 136, 137, 138, 139, 140, 140, 141,
	142, 143, 144, 145, 146, 147, 148, 149, 150, 151, 152, 153, 154, 155, 156, 157, 158, 159, 160, 161, 162, 163, 163, 164,
	165, 166, 167, 168, 169, 170, 171, 172, 173, 173, 174, 175, 176, 177, 178, 179, 180, 181, 182, 182, 183, 184, 185, 186,
	187, 188, 189, 189, 190, 191, 192, 193, 194, 195, 195, 196, 197, 198, 199, 200, 200, 201, 202, 203, 204, 205, 205, 206,
	207, 208, 209, 210, 210, 211, 212, 213, 214, 214, 215, 216, 217, 218, 218, 219, 220, 221, 222, 222, 223, 224, 225, 226,
	226, 227, 228, 229, 229, 230, 231, 232, 233, 233, 234, 235, 236, 236, 237, 238, 239, 239, 240, 241, 242, 242, 243, 244,
	245, 245, 246, 247, 248, 248, 249, 250, 251, 251, 252, 253, 253, 254, 255, 255,
};

#define COUNT_ONE 32   /* one observation */
#define COUNT_START 13 /* the 0.4 that each side of a context has before anything is seen (Krichevsky and Trofimov take 0.5) */
#define COUNT_LIMIT (255 * COUNT_ONE)
#define PROBABILITY_LEAST 16 /* of RANGE_ONE: bounds the cost of a surprise, and the decisions that a byte can hold */
#define LEARN_SHIFT 15

/* log2(x) in 1/4096. */
static int32_t log2_fine(uint64_t x)
{
	assert(x > 0);
	const int top = 63 - __builtin_clzll(x);
	const uint64_t mantissa = (top > 24 ? x >> (top - 24) : x << (24 - top)) & 0xffffff;
	const uint32_t i = (uint32_t)(mantissa >> 16), part = (uint32_t)(mantissa & 0xffff);
	return top * 4096 + log2_table[i] + (int32_t)((log2_table[i + 1] - log2_table[i]) * (uint64_t)part >> 16);
}

/* The probability of 1 for a logit: RANGE_ONE / (1 + 2^-logit). */
static uint32_t squash(int32_t logit)
{
	const bool is_negative = logit < 0;
	const uint32_t size = (uint32_t)(is_negative ? -logit : logit);
	/* 2^size, 16 bits behind the point; size is below 12 * 256 + 1 */
	const uint64_t power = (uint64_t)exp2_table[size & 255] << (size >> 8);
	const uint32_t small = (uint32_t)(((uint64_t)1 << 32) / (power + 65536));
	const uint32_t bounded = small < PROBABILITY_LEAST ? PROBABILITY_LEAST : small;
	return is_negative ? bounded : RANGE_ONE - bounded;
}

/* A packed context: 1 + 31 level + share. The level says how often it was seen, in 1/32 observations, the share how many of those
 * were ones, in 1/4096. */
static const uint16_t seen_levels[TABLE_LEVELS] = {11, 32, 64, 128, 256, 448, 640, 960};
static const uint16_t share_of_ones[TABLE_SHARES] = {6,    10,   15,   23,   36,   55,   84,   128,  193,  289,  428,
						     623,  885,  1218, 1615, 2048, 2481, 2878, 3211, 3473, 3668, 3807,
						     3903, 3968, 4012, 4041, 4060, 4073, 4081, 4086, 4090};
/* 65536 * 2^(i / 16) is every 16th of exp2_table. */

void model_context_of(uint16_t count[2], unsigned code)
{
	const uint32_t all = seen_levels[(code - 1) / TABLE_SHARES];
	count[1] = (uint16_t)((all * share_of_ones[(code - 1) % TABLE_SHARES] + 2048) >> 12);
	count[0] = (uint16_t)(all - count[1]);
}

uint16_t model_histogram_of(unsigned code)
{
	return (uint16_t)((((uint64_t)exp2_table[code % 16 * 16] << (code / 16)) + 32768) >> 16);
}

void model_unpack(struct ffx_model *model, const unsigned char *context, const signed char *weight,
		  const unsigned char *histogram)
{
	memset(model, 0, sizeof *model);
	/* A zero and a number stand for so many contexts that were never seen. */
	for (size_t i = 0; i < FFX_CONTEXTS; context++) {
		if (*context == 0)
			i += *++context;
		else
			model_context_of(model->count + 2 * i++, *context);
	}
	for (size_t i = 0; i < FFX_WEIGHTS; i++)
		model->weight[i] = weight[i] * 1024;
	for (size_t i = 0; i < FFX_HISTOGRAMS; i++)
		for (size_t k = 0; k < HISTOGRAM_CLASSES; k++)
			model->histogram[i][k] = model_histogram_of(histogram[i * TABLE_CLASSES + (k + 1) / 2]);
}

void model_init(struct ffx_model *model)
{
	model_unpack(model, ffx_table_context, ffx_table_weight, ffx_table_histogram);
}

void model_reset(struct ffx_model *model, const struct ffx_model *start, bool is_forward)
{
	if (!is_forward) {
		memcpy(model, start, sizeof *model);
		return;
	}
	memcpy(model->count, start->count, 2 * (size_t)CONTEXT_LABEL * sizeof *model->count);
	memcpy(model->weight, start->weight, sizeof model->weight);
	memcpy(model->histogram, start->histogram, sizeof model->histogram);
}

static unsigned confidence(uint32_t seen)
{
	if (seen < COUNT_ONE / 2)
		return 0;
	return seen < 2 * COUNT_ONE ? 1 : seen < 5 * COUNT_ONE ? 2 : seen < 12 * COUNT_ONE ? 3 : seen < 40 * COUNT_ONE ? 4 : 5;
}

static void update_count(struct ffx_model *model, size_t context, unsigned bit)
{
	uint16_t *n = model->count + 2 * context;
	n[bit] = (uint16_t)(n[bit] + COUNT_ONE);
	if (n[0] + n[1] > COUNT_LIMIT) {
		n[0] /= 2;
		n[1] /= 2;
	}
	if (model->training)
		model->training->count[2 * context + bit]++;
}

void mix_context(struct ffx_coder *coder, size_t context, size_t weight)
{
	assert(context < FFX_CONTEXTS);
	const uint16_t *n = coder->model->count + 2 * context;
	mix_logit(coder, model_log2(n[1] + COUNT_START) - model_log2(n[0] + COUNT_START), weight + confidence(n[0] + n[1]));
	coder->context[coder->input_count - 1] = (uint32_t)context;
}

static unsigned code_bit(struct ffx_coder *coder, uint32_t probability, unsigned bit)
{
	bit = range_bit(&coder->range, probability, bit);
	coder->cost += (uint64_t)(16 * 4096 - log2_fine(bit ? probability : RANGE_ONE - probability));
	return bit;
}

static void learn_weight(struct ffx_model *model, size_t weight, int32_t by)
{
	const int32_t learned = model->weight[weight] + by;
	model->weight[weight] = learned > 8 * 65536 ? 8 * 65536 : learned < -8 * 65536 ? -8 * 65536 : learned;
}

unsigned mix_code(struct ffx_coder *coder, unsigned bit)
{
	struct ffx_model *model = coder->model;
	int64_t sum = 0;
	for (size_t i = 0; i < coder->input_count; i++) {
		int64_t weight = model->weight[coder->weight[i]];
		if (coder->second[i] != UINT32_MAX)
			weight += model->weight[coder->second[i]];
		sum += weight * coder->logit[i];
	}
	sum = shift_down(sum, 16);
	const uint32_t probability = squash((int32_t)(sum > LOGIT_LIMIT ? LOGIT_LIMIT : sum < -LOGIT_LIMIT ? -LOGIT_LIMIT : sum));
	bit = code_bit(coder, probability, bit);
	const int32_t miss = (int32_t)(bit ? RANGE_ONE : 0) - (int32_t)probability;
	const int shift = model->training ? model->training->weight_shift : LEARN_SHIFT;
	for (size_t i = 0; i < coder->input_count; i++) {
		/* Rounded down: 2^30 keeps what is shifted above 0. */
		const int32_t by = (int32_t)((uint32_t)(miss * coder->logit[i] + (1 << 30)) >> shift) - (1 << (30 - shift));
		learn_weight(model, coder->weight[i], by);
		if (coder->second[i] != UINT32_MAX)
			learn_weight(model, coder->second[i], by);
		if (coder->context[i] != UINT32_MAX)
			update_count(model, coder->context[i], bit);
	}
	coder->input_count = 0;
	return bit;
}

unsigned model_fixed(struct ffx_coder *coder, uint32_t probability, unsigned bit)
{
	return code_bit(coder, probability, bit);
}

unsigned model_bit(struct ffx_coder *coder, size_t context, unsigned bit)
{
	const uint16_t *n = coder->model->count + 2 * context;
	const uint32_t zero = n[0] + COUNT_START, one = n[1] + COUNT_START;
	uint32_t probability = (uint32_t)((uint64_t)one * RANGE_ONE / (zero + one));
	if (probability < PROBABILITY_LEAST)
		probability = PROBABILITY_LEAST;
	if (probability > RANGE_ONE - PROBABILITY_LEAST)
		probability = RANGE_ONE - PROBABILITY_LEAST;
	bit = code_bit(coder, probability, bit);
	update_count(coder->model, context, bit);
	return bit;
}

uint32_t model_uniform(struct ffx_coder *coder, uint32_t count, uint32_t value)
{
	coder->cost += (uint64_t)log2_fine(count);
	return count > 1 ? range_uniform(&coder->range, count, value) : 0;
}

uint32_t model_golomb(struct ffx_coder *coder, size_t context, uint32_t limit, uint32_t value)
{
	assert(limit < 1u << 30);
	int bits = 0; /* value + 1 has bits + 1 binary digits */
	while ((value + 1) >> bits > 1)
		bits++;
	int k = 0;
	while (k < 30 && (uint32_t)1 << k <= limit + 1 && model_bit(coder, context + (k < 15 ? k : 15), k < bits))
		k++;
	if (k == 30 || (uint32_t)1 << k > limit + 1)
		return limit + 1;
	uint32_t decoded = 1;
	for (int i = k - 1; i >= 0; i--) {
		const unsigned bit = (value + 1) >> i & 1;
		decoded = decoded << 1 | (i == k - 1 ? model_bit(coder, context + 16 + (k < 15 ? k : 15), bit)
						     : range_bit(&coder->range, RANGE_ONE / 2, bit));
		if (i < k - 1)
			coder->cost += 4096;
	}
	return decoded - 1 <= limit ? decoded - 1 : limit + 1;
}
