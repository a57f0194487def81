/* Masks of one subdivision step (Loop 1987, Catmull and Clark 1978, Stam and Loop 2003).
 *
 * The published rules smooth the vertices of the linearly split mesh. Put together with the split they read on the old mesh:
 * a midpoint is (v + w) / 2, so a weight b on the midpoints is b / 2 on the neighbours and b / 2 more on v for each. */
#include "stages/geometry/subdivide_mask.h"

#include <math.h>

#include "stages/geometry/vector.h"

/* Correction p <- q + eta (q - p) at mixed vertices, by (edges, quads): the third eigenvalue of the local matrix becomes the
 * square of the second. Part of the stream version: unpack must use the very same numbers. */
static double correction(size_t edges, size_t quads)
{
	static const struct {
		size_t edges, quads;
		double eta;
	} table[] = {{3, 1, 0.80597}, {3, 2, 0.61539}, {4, 1, 0.34792}, {4, 2, 0.21380}, {4, 3, 0.10550}, {2, 1, -0.20505}};
	for (size_t i = 0; i < sizeof table / sizeof *table; i++)
		if (table[i].edges == edges && table[i].quads == quads)
			return table[i].eta;
	return 0;
}

struct step_mask step_mask_corner(void)
{
	return (struct step_mask){0, 0};
}

struct step_mask step_mask_crease(void)
{
	return (struct step_mask){1.0 / 8, 2};
}

struct step_mask step_mask_smooth(size_t edges, size_t quads)
{
	const double n = (double)edges;
	if (quads == 0) {
		/* centre A = 2 (3/8 + cos(2 pi / n) / 4)^2 - 1/4 on the split mesh */
		const double g = 3.0 / 8 + cos(2 * PI / n) / 4;
		return (struct step_mask){(5.0 / 4 - 2 * g * g) / (2 * n), n};
	}
	if (quads == edges)
		return (struct step_mask){1 / (n * n), 2 * n};
	const double alpha = 1 / (1 + n / 2 + (double)quads / 4);
	return (struct step_mask){(1 + correction(edges, quads)) * alpha / 4, n + (double)quads};
}
