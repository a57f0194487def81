/* Plots: flat pieces of a cage whose faces may be drawn anew, and how much their surface folds over. */
#ifndef CAGEWRIGHT_PLOT_H
#define CAGEWRIGHT_PLOT_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/dense.h"
#include "formats/memory.h"

struct polygon {
	idx_t *corner;         /* vertices, counter-clockwise */
	unsigned char *crease; /* an edge, from corner i to the next: 1 = crease */
	size_t count;          /* 0: gone */
	bool fixed;            /* beside the plot, joined to it without a crease: shapes it, but stays as it is */
	double folded;         /* area of its surface that lies upside down */
};

/* The vertices of a cage, and new ones behind them. */
struct points {
	double *xyz;                    /* 3 a vertex, model units */
	unsigned char *corner;          /* a vertex: explicit corner */
	idx_t *creases;                 /* a vertex: edges in the whole cage that are creases, borders too */
	unsigned char *open;            /* a vertex: 1 where a fixed polygon of the present plot is */
	size_t count, room;             /* no more than room are ever made */
};

struct plot {
	struct points *points;
	struct polygon *polygon;
	size_t count, room;
	double normal[3];               /* unit: the side that is up, */
	const struct dense_patch *bent; /* or the surface that says so, where the plot is no plane */
	double margin;                  /* vertices may yet move against each other by this, model units */
	size_t *work;                   /* faces refined, counted up: about a tenth of a microsecond each */
};

void plot_add(struct plot *plot, const idx_t *corner, const unsigned char *crease, size_t count, bool fixed);
void plot_free(struct plot *plot);
/* A new vertex; NO_INDEX when there is no room for one. */
idx_t plot_new_point(struct plot *plot, const double xyz[3]);

/* Vertices that every step of subdivision leaves in their place. */
static inline bool plot_is_kept(const struct plot *plot, idx_t vertex)
{
	return plot->points->corner[vertex] || plot->points->creases[vertex] >= 3;
}

/* The surface of the polygons that share a vertex with the chosen ones after so many steps: of the fixed ones, or of the others. Triangles, nine numbers
 * each (caller frees); NULL when there are none, or no manifold. */
double *plot_surface(size_t *count, const struct plot *plot, const idx_t *core, size_t core_count, bool fixed, int steps);

/* The area that lies upside down after so many steps of subdivision, of the chosen polygons (core, their indices) and of all that share a
 * vertex with them but the fixed ones; of each on its own: folded[i] of touched[i] (caller frees; polygon indices, rising), or NULL. INFINITY when
 * the polygons are no manifold. The surface of a polygon depends on those that touch it and no others, so only what is near is refined. */
double plot_fold(double **folded, idx_t **touched, size_t *touched_count, const struct plot *plot, const idx_t *core, size_t core_count,
		 int steps);

#endif
