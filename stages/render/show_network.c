/* Networks of subdivision curves: limits of the curves, control polygons, control points by kind. */
#include <stdlib.h>

#include "formats/network.h"
#include "stages/geometry/curve.h"
#include "stages/geometry/vector.h"
#include "stages/render/show.h"

/* Straight pieces between the limits of two control points. */
#define PIECES 12

static void add_curve(struct scene *scene, const struct curve *curve, const double *points)
{
	static const struct colour of_kind[3] = {{20, 20, 24}, {40, 95, 215}, {10, 130, 60}};
	const size_t spans = curve->closed ? curve->count : curve->count - 1;
	double from[3], to[3];
	curve_point(from, points, curve->count, curve->closed, 0);
	for (size_t i = 1; i <= spans * PIECES; i++) {
		const double u = (double)i / PIECES;
		curve_point(to, points, curve->count, curve->closed, curve->closed && i == spans * PIECES ? 0 : u);
		scene_add_line(scene, from, to, of_kind[curve->kind], 2.2f);
		copy3(from, to);
	}
}

bool show_network(struct scene *scene, const struct ply *ply, const char *vertex_element, const char *shown, struct fault *fault)
{
	static const struct colour polygon = {205, 150, 120};
	static const struct {
		struct colour colour;
		float radius;
	} dot[3] = {{{215, 30, 40}, 4.0f}, {{245, 160, 20}, 3.6f}, {{90, 90, 100}, 2.2f}};
	struct network network;
	if (!network_from_ply(&network, ply, vertex_element, shown, fault))
		return false;
	double *points = mem_array(3 * network.point_count, sizeof *points);
	for (size_t i = 0; i < network.point_count; i++)
		copy3(points + 3 * i, network.xyz + 3 * (size_t)network.point[i]);
	for (size_t c = 0; c < network.curve_count; c++) {
		const struct curve *curve = &network.curve[c];
		for (size_t i = 0; i + 1 < curve->count + curve->closed; i++)
			scene_add_line(scene, points + 3 * (curve->first + i), points + 3 * (curve->first + (i + 1) % curve->count), polygon, 0.8f);
	}
	for (size_t c = 0; c < network.curve_count; c++)
		add_curve(scene, &network.curve[c], points + 3 * network.curve[c].first);
	for (size_t v = 0; v < network.vertex_count; v++)
		scene_add_dot(scene, network.xyz + 3 * v, dot[network.kind[v]].colour, dot[network.kind[v]].radius, false);
	free(points);
	network_free(&network);
	return true;
}
