/* Drawing a scene to pixels with OSMesa: orthographic, software only, the same bytes every time. */
#ifndef CAGEWRIGHT_RASTER_H
#define CAGEWRIGHT_RASTER_H

#include <stdbool.h>

#include "formats/fault.h"
#include "stages/render/scene.h"

struct view {
	double azimuth_deg;     /* of the eye around z, from x towards y */
	double elevation_deg;   /* of the eye above the xy plane, [-90, 90] */
	int width, height;      /* pixels */
	double zoom;            /* >= 1: how much larger than the whole part would be; 0 is taken as 1 */
	bool has_centre;        /* else the middle of the part is in the middle of the picture */
	double centre[3];
};

/* Largest side of a picture in pixels: with supersampling still within what OSMesa draws. */
#define RASTER_SIDE_MOST 4096

/* rgb: 3 * width * height bytes, rows from the top; caller frees. Fills the picture with all that the scene has.
 * Faults: EX_SYSTEM when OSMesa gives no context. */
bool raster_draw(unsigned char **rgb, const struct scene *scene, const struct view *view, struct fault *fault);

#endif
