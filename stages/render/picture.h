/* Pixels to a PNG file. */
#ifndef CAGEWRIGHT_PICTURE_H
#define CAGEWRIGHT_PICTURE_H

#include <stdbool.h>
#include <stdio.h>

#include "formats/fault.h"

/* Write 8-bit RGB rows from the top, without time or text. Faults: EX_SYSTEM. */
bool picture_write(FILE *file, const unsigned char *rgb, int width, int height, struct fault *fault);

#endif
