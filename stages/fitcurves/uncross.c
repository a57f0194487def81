/* Pairwise tests of control segments, patch by patch. */
#include "stages/fitcurves/uncross.h"

#include <math.h>
#include <stdlib.h>

#include "formats/memory.h"
#include "stages/geometry/curve.h"
#include "stages/geometry/vector.h"

/* A patch with more control segments is left alone: it is no part of a machine, and the tests are quadratic. */
#define MOST_SEGMENTS 3000

struct segment {
	double a[2], b[2];
	size_t chain;
};

static double side_of(const double a[2], const double b[2], const double p[2])
{
	return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/* Do they cut each other inside? Common ends and touching do not count. */
static bool is_cut(const struct segment *s, const struct segment *t)
{
	if (fmax(s->a[0], s->b[0]) < fmin(t->a[0], t->b[0]) || fmax(t->a[0], t->b[0]) < fmin(s->a[0], s->b[0]) ||
	    fmax(s->a[1], s->b[1]) < fmin(t->a[1], t->b[1]) || fmax(t->a[1], t->b[1]) < fmin(s->a[1], s->b[1]))
		return false;
	return side_of(s->a, s->b, t->a) * side_of(s->a, s->b, t->b) < 0 &&
	       side_of(t->a, t->b, s->a) * side_of(t->a, t->b, s->b) < 0;
}

/* Largest distance between a control point and its place on the curve. */
static double stand_off(const struct curvefit *fit)
{
	double most = 0;
	for (size_t i = 0; i < fit->count; i++) {
		double limit[3];
		curve_limit(limit, fit->xyz, fit->count, fit->closed, i);
		most = fmax(most, distance3(limit, fit->xyz + 3 * i));
	}
	return most;
}

/* The control segments of a chain, in two directions of the plane. */
static size_t project_chain(struct segment *segment, const struct curvefit *fit, size_t chain, double direction[2][3])
{
	const size_t spans = fit->closed ? fit->count : fit->count - 1;
	for (size_t i = 0; i < spans; i++) {
		segment[i].chain = chain;
		for (size_t k = 0; k < 2; k++) {
			segment[i].a[k] = dot3(direction[k], fit->xyz + 3 * i);
			segment[i].b[k] = dot3(direction[k], fit->xyz + 3 * ((i + 1) % fit->count));
		}
	}
	return spans;
}

static void span_plane(double direction[2][3], const double normal[3])
{
	size_t least = 0;
	for (size_t k = 1; k < 3; k++)
		if (fabs(normal[k]) < fabs(normal[least]))
			least = k;
	double unit[3] = {0, 0, 0};
	unit[least] = 1;
	cross3(direction[0], normal, unit);
	normalise3(direction[0]);
	cross3(direction[1], normal, direction[0]);
}

size_t uncross(struct curvefit *fit, const struct polyline *line, const struct curvefit_options *options,
	       const struct border_network *border, const bool *is_gone, const struct dense_patch *patch, size_t patch_count,
	       const size_t *class_size)
{
	const size_t n = border->chain_count;
	size_t *start = mem_array(patch_count + 2, sizeof *start), *chain = mem_array(2 * n, sizeof *chain);
	for (int pass = 0; pass < 2; pass++) {
		for (size_t c = 0; c < n; c++) {
			const idx_t beside[2] = {border->chain[c].left, border->chain[c].right};
			if ((is_gone && is_gone[c]) || !(line[c].length > 0))
				continue;
			for (int k = 0; k < 2; k++) {
				if (beside[k] < 0 || patch[beside[k]].kind != PATCH_PLANE)
					continue;
				if (pass == 0)
					start[beside[k] + 2]++;
				else
					chain[start[beside[k] + 1]++] = c;
			}
		}
		for (size_t p = 0; pass == 0 && p < patch_count; p++)
			start[p + 2] += start[p + 1];
	}
	/* A point more takes off about 2 / count of the distance, and costs one for each curve of the class. */
	double *off = mem_array(n, sizeof *off);
	bool *raise = mem_array(n, sizeof *raise);
	for (size_t c = 0; c < n; c++)
		off[c] = -1;
	struct segment *segment = mem_array(MOST_SEGMENTS, sizeof *segment);
	for (size_t p = 0; p < patch_count; p++) {
		size_t count = 0;
		bool fits = true;
		double direction[2][3];
		span_plane(direction, patch[p].axis);
		for (size_t i = start[p]; i < start[p + 1] && fits; i++) {
			fits = count + fit[chain[i]].count <= MOST_SEGMENTS;
			if (fits)
				count += project_chain(segment + count, fit + chain[i], chain[i], direction);
		}
		for (size_t i = 0; i < count && fits; i++)
			for (size_t j = i + 1; j < count; j++) {
				if (!is_cut(segment + i, segment + j))
					continue;
				const size_t pair[2] = {segment[i].chain, segment[j].chain};
				for (int k = 0; k < 2; k++)
					if (off[pair[k]] < 0)
						off[pair[k]] = stand_off(fit + pair[k]) /
							       (double)(fit[pair[k]].count * class_size[pair[k]]);
				raise[off[pair[1]] > off[pair[0]] ? pair[1] : pair[0]] = true;
			}
	}
	size_t raised = 0;
	for (size_t c = 0; c < n; c++)
		if (raise[c] && fit[c].count < CURVEFIT_MOST_POINTS) {
			curvefit_raise(fit + c, line + c, options[c], fit[c].count + 1);
			raised++;
		}
	free(start), free(chain), free(off), free(raise), free(segment);
	return raised;
}
