/* A mesh file as the CGAL programs of this folder want it. They are C++ because CGAL is a library of C++ headers alone;
 * nothing of the product uses it. */
#ifndef CAGEWRIGHT_SOUP_H
#define CAGEWRIGHT_SOUP_H

#include <cstdio>
#include <cstdlib>
#include <array>
#include <vector>

#define _Noreturn [[noreturn]]
extern "C" {
#include "formats/mesh.h"
}

/* Points and triangles; indices are below points.size(). */
template <class Point> struct soup {
	std::vector<Point> points;
	std::vector<std::array<idx_t, 3>> triangles;
	double side;	/* longest side of the bounding box */
};

/* Read path, unite equal positions, cut polygons into fans. Triangles whose corners became one are left out. Ends the
 * program with a message when the file cannot be read. */
template <class Point> soup<Point> soup_read(const char *tool, const char *path)
{
	struct fault fault = {};
	struct input input;
	struct mesh mesh;
	if (!input_read(&input, path, &fault) || !mesh_read(&mesh, &input, &fault)) {
		std::fprintf(stderr, "%s: %s\n", tool, fault.text);
		std::exit(fault.code);
	}
	mesh_weld(&mesh, 0, nullptr);
	soup<Point> result;
	result.side = mesh_bounds(mesh.xyz, mesh.vertex_count, nullptr, nullptr);
	for (size_t v = 0; v < mesh.vertex_count; v++)
		result.points.emplace_back(mesh.xyz[3 * v], mesh.xyz[3 * v + 1], mesh.xyz[3 * v + 2]);
	for (size_t f = 0; f < mesh.face_count; f++)
		for (size_t c = mesh.face_start[f] + 2; c < mesh.face_start[f + 1]; c++) {
			const std::array<idx_t, 3> t = {mesh.corner[mesh.face_start[f]], mesh.corner[c - 1], mesh.corner[c]};
			if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
				result.triangles.push_back(t);
		}
	mesh_free(&mesh);
	input_free(&input);
	return result;
}

#endif
