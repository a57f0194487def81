/* Grids and frames: where an FFX cage lies and how large it is (see ffx.h and ffx(5)). */
#include <math.h>

#include "formats/ffx.h"
#include "formats/ffx_payload.h"

int32_t ffx_grid_steps(unsigned code)
{
	/* 65536 * 2^(i / 16) */
	static const uint32_t octave[16] = {65536, 68438, 71468,  74632,  77936,  81386,  84990,  88752,
					    92682, 96785, 101070, 105545, 110218, 115098, 120194, 125515};
	return (int32_t)(((uint64_t)octave[code % 16] << (3 + code / 16)) >> 16) - 1;
}

unsigned ffx_grid_code(int32_t steps)
{
	unsigned code = 0;
	while (code < FFX_GRID_CODES && ffx_grid_steps(code) < steps)
		code++;
	return code;
}

/* Binary digits of the step: so many that the far end of the grid is as near to its place as the origin. */
static int mantissa_bits(int32_t steps, unsigned origin_bits)
{
	int bits = 0;
	while (steps >> bits > 0)
		bits++;
	return bits + (int)origin_bits;
}

double ffx_frame_step(double step, int32_t steps, unsigned origin_bits)
{
	if (!(step >= ldexp(1, -120) && step <= ldexp(1, 120)))
		return 0;
	int exponent;
	const double mantissa = frexp(step, &exponent); /* [0.5, 1) */
	const int bits = mantissa_bits(steps, origin_bits);
	return ldexp(round(ldexp(mantissa, bits)), exponent - bits);
}

bool ffx_frame_choose(struct ffx_frame *frame, const double low[3], double side, int32_t steps)
{
	*frame = (struct ffx_frame){.step = ffx_frame_step(side / steps, steps, FFX_FRAME_BITS), .origin_bits = FFX_FRAME_BITS};
	if (frame->step == 0)
		return false;
	for (int k = 0; k < 3; k++) {
		const double whole = round(ldexp(low[k] / frame->step, (int)frame->origin_bits));
		if (!(fabs(whole) <= (double)FFX_ORIGIN_LIMIT))
			return false;
		frame->origin[k] = (int64_t)whole;
	}
	return true;
}

static uint64_t code_raw(struct ffx_coder *coder, int bits, uint64_t value)
{
	uint64_t out = 0;
	for (; bits > 0; bits -= bits > 16 ? 16 : bits) {
		const int part = bits > 16 ? 16 : bits;
		out = out << part |
		      model_uniform(coder, (uint32_t)1 << part, (uint32_t)(value >> (bits - part) & (((uint32_t)1 << part) - 1)));
	}
	return out;
}

#define STEP_BIAS 128
#define COMMON_LEAST (-24) /* exponents of steps from 2^-25 to 2^7 take 5 bits */

static int code_exponent(struct ffx_coder *coder, int exponent)
{
	const unsigned is_rare = model_fixed(coder, RANGE_ONE / 16, exponent < COMMON_LEAST || exponent >= COMMON_LEAST + 32);
	if (is_rare)
		return (int)code_raw(coder, 8, (uint64_t)(exponent + STEP_BIAS)) - STEP_BIAS;
	return (int)code_raw(coder, 5, (uint64_t)(exponent - COMMON_LEAST)) + COMMON_LEAST;
}

static int digits_of(uint64_t x)
{
	return x ? 64 - __builtin_clzll(x) : 0;
}

/* Most origins lie between the grid's length below zero and zero, many of the others as near above it. */
static int64_t code_origin(struct ffx_coder *coder, int64_t reach, int64_t origin)
{
	if (!model_fixed(coder, 3 * RANGE_ONE / 8, origin > 0 || origin < -reach))
		return -(int64_t)model_uniform(coder, (uint32_t)reach + 1, (uint32_t)-origin);
	if (!model_fixed(coder, RANGE_ONE / 3, origin < 0 || origin > reach))
		return 1 + (int64_t)model_uniform(coder, (uint32_t)reach, (uint32_t)origin - 1);
	const unsigned is_negative = model_fixed(coder, RANGE_ONE / 2, origin < 0);
	const uint64_t size = (uint64_t)(origin < 0 ? -origin : origin);
	int digits = digits_of((uint64_t)reach);
	while (digits < 49 && model_fixed(coder, RANGE_ONE / 2, digits < digits_of(size)))
		digits++;
	const uint64_t top = (uint64_t)1 << (digits - 1), value = top | code_raw(coder, digits - 1, size & (top - 1));
	return is_negative ? -(int64_t)value : (int64_t)value;
}

bool frame_code(struct ffx_coder *coder, struct ffx_frame *frame, int32_t steps, struct fault *fault)
{
	const unsigned is_fine = model_fixed(coder, RANGE_ONE / 64, frame->origin_bits > 3);
	frame->origin_bits = model_uniform(coder, is_fine ? 16 : 4, frame->origin_bits);
	const int bits = mantissa_bits(steps, frame->origin_bits);
	int exponent = 0;
	const double mantissa = frame->step > 0 ? frexp(frame->step, &exponent) : 0.5;
	exponent = code_exponent(coder, exponent);
	const uint64_t top = (uint64_t)1 << (bits - 1);
	const uint64_t whole = top | code_raw(coder, bits - 1, (uint64_t)ldexp(mantissa, bits) & (top - 1));
	frame->step = ldexp((double)whole, exponent - bits);
	for (int k = 0; k < 3; k++) {
		frame->origin[k] = code_origin(coder, (int64_t)steps << frame->origin_bits, frame->origin[k]);
		if (frame->origin[k] < -FFX_ORIGIN_LIMIT || frame->origin[k] > FFX_ORIGIN_LIMIT)
			return fault_set(fault, EX_BAD_INPUT, "the frame is out of range");
	}
	if (!(frame->step >= ldexp(1, -120) && frame->step <= ldexp(1, 120)))
		return fault_set(fault, EX_BAD_INPUT, "the frame is out of range");
	return true;
}
