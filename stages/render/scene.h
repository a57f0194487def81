/* What a picture shows: coloured triangles, lines and dots in space. Knows no files and no graphics library. */
#ifndef CAGEWRIGHT_SCENE_H
#define CAGEWRIGHT_SCENE_H

#include <stdbool.h>

#include "formats/memory.h"
#include "stages/render/palette.h"

struct scene_line {
	double from[3], to[3];
	struct colour colour;
	float width;            /* pixels of the finished picture */
};

struct scene_dot {
	double centre[3];
	struct colour colour;
	float radius;           /* pixels of the finished picture */
	bool is_ring;           /* hollow, in front of everything: a marker */
};

struct scene {
	size_t vertex_count, triangle_count, line_count, dot_count;
	double *xyz;            /* 3 a vertex, model units */
	idx_t *triangle;        /* 3 a triangle, counter-clockwise from outside */
	float *normal;          /* 9 a triangle: unit, one a corner; after scene_smooth or set by the builder */
	struct colour *colour;  /* 3 a triangle: one a corner */
	struct scene_line *line;
	struct scene_dot *dot;
	size_t line_room, dot_room;
	/* Legend: a bar from colours of scale[0..1], its ends labelled with the numbers. */
	bool has_legend;
	enum colour_scale legend_scale;
	double legend_low, legend_high;
	const char *legend_unit;    /* "%" or "" */
};

void scene_free(struct scene *scene);

/* Give the scene its surface: copies of the arrays, all triangles of one colour, corner normals those of the faces. */
void scene_set_surface(struct scene *scene, const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count,
                       struct colour colour);

void scene_add_line(struct scene *scene, const double from[3], const double to[3], struct colour colour, float width);
void scene_add_dot(struct scene *scene, const double centre[3], struct colour colour, float radius, bool is_ring);

/* Corner normals: the mean, weighted by corner angle, over the triangles around a vertex that are joined through edges which bend by less than
 * crease_deg and are not listed in sharp (2 * sharp_count vertex indices, lower first). O(n log n). */
void scene_smooth(struct scene *scene, double crease_deg, const idx_t *sharp, size_t sharp_count);

/* Add a line for every edge: of the polygons given (face_start as in struct mesh), each once. */
void scene_add_edges(struct scene *scene, const double *xyz, const idx_t *corner, const size_t *face_start, size_t face_count,
                     struct colour colour, float width);

/* Add lines along the edges of the scene's surface that bend by more than crease_deg, that have one triangle, or more than two. */
void scene_add_features(struct scene *scene, double crease_deg, struct colour crease, struct colour border, struct colour crossing);

/* Add a line along every edge of the scene's surface whose two triangles have different labels (one a triangle). */
void scene_add_label_borders(struct scene *scene, const idx_t *label, struct colour colour, float width);

#endif
