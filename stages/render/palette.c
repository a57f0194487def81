#include "stages/render/palette.h"

#include <math.h>

static unsigned char to_byte(double x)
{
	return (unsigned char)lround(255 * fmin(1, fmax(0, x)));
}

static struct colour from_hsv(double hue, double saturation, double value)
{
	double channel[3];
	for (int k = 0; k < 3; k++) {
		const double turn = fmod(hue * 6 + (k == 0 ? 5 : k == 1 ? 3 : 1), 6);
		channel[k] = value - value * saturation * fmax(0, fmin(1, fmin(turn, 4 - turn)));
	}
	return (struct colour){to_byte(channel[0]), to_byte(channel[1]), to_byte(channel[2])};
}

struct colour palette_patch(size_t i)
{
	static const double level[5][2] = {{0.50, 0.96}, {0.62, 0.80}, {0.30, 0.98}, {0.70, 0.95}, {0.42, 0.76}}; /* saturation, value */
	const double *sv = level[i % 5];
	return from_hsv(fmod(0.58 + (double)i * 0.6180339887498949, 1), sv[0], sv[1]);
}

struct colour palette_mix(struct colour a, struct colour b, double share_of_b)
{
	const double s = fmin(1, fmax(0, share_of_b));
	return (struct colour){to_byte((a.red * (1 - s) + b.red * s) / 255), to_byte((a.green * (1 - s) + b.green * s) / 255),
	                       to_byte((a.blue * (1 - s) + b.blue * s) / 255)};
}

struct colour palette_scale(enum colour_scale scale, double share)
{
	static const struct colour diverging[5] = {{20, 50, 140}, {90, 150, 220}, {225, 225, 222}, {235, 130, 90}, {150, 15, 25}};
	static const struct colour heat[5] = {{215, 222, 226}, {150, 205, 120}, {250, 225, 70}, {235, 100, 35}, {110, 0, 20}};
	const struct colour *stop = scale == SCALE_DIVERGING ? diverging : heat;
	const double at = isnan(share) ? 0 : 4 * fmin(1, fmax(0, share));
	const int below = at >= 4 ? 3 : (int)at;
	return palette_mix(stop[below], stop[below + 1], at - below);
}
