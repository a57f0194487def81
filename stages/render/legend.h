/* The colour bar of a picture with its two numbers. */
#ifndef CAGEWRIGHT_LEGEND_H
#define CAGEWRIGHT_LEGEND_H

#include "stages/render/scene.h"

/* Draw the scene's legend into the lower left of 3 * width * height bytes, rows from the top; nothing when it has none or the
 * picture is too small for it. */
void legend_draw(unsigned char *rgb, int width, int height, const struct scene *scene);

#endif
