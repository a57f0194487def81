/* Colours of pictures. */
#ifndef CAGEWRIGHT_PALETTE_H
#define CAGEWRIGHT_PALETTE_H

#include <stddef.h>

struct colour {
	unsigned char red, green, blue;
};

/* Colour of patch i: hues in golden-angle steps, five brightnesses in turn, so that near numbers look far apart. */
struct colour palette_patch(size_t i);

enum colour_scale {
	SCALE_DIVERGING,  /* blue - light grey - red, the middle is 0 */
	SCALE_HEAT,       /* light grey - yellow - red - black-red */
};

/* Colour at share in [0, 1] of a scale; outside it the end's colour. */
struct colour palette_scale(enum colour_scale scale, double share);

struct colour palette_mix(struct colour a, struct colour b, double share_of_b);

#endif
