/* Polygon meshes as flat arrays, and reading them from any foreign file.
 *
 * STL OFF OBJ PLY OM, each also .gz. The readers are ours: OpenMesh's turn doubles to floats, lose what comments surround,
 * take damaged files for good ones, and end the program in others. Nothing is repaired here. See cagewright-mesh(5). */
#ifndef CAGEWRIGHT_MESH_H
#define CAGEWRIGHT_MESH_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/fault.h"
#include "formats/input.h"
#include "formats/memory.h"

/* Faces are given by offsets: face f is corner[face_start[f]] .. corner[face_start[f + 1]), counter-clockwise from outside. */
struct mesh {
	double *xyz;          /* 3 * vertex_count, finite, model units */
	size_t vertex_count;
	idx_t *corner;        /* face_start[face_count] indices below vertex_count */
	size_t *face_start;   /* face_count + 1 offsets, rising, from 0 */
	size_t face_count;
};

void mesh_free(struct mesh *mesh);

/* Coordinates beyond this are refused: sixth powers of lengths must be doubles. */
#define MESH_COORDINATE_LIMIT 1e50

/* Read any supported file. The format is told by content where it has a magic (ply, OFF, OM, binary STL size rule),
 * else by the extension of input->shown. Every number, index and promised count is checked.
 * STL comes unwelded: three vertices a facet, facets in file order. */
bool mesh_read(struct mesh *mesh, const struct input *input, struct fault *fault);

/* Has every face vertices of its own, three in a row? So STL files come; the opposite of an indexed mesh. */
bool mesh_is_unwelded(const struct mesh *mesh);

/* Unite vertices at equal positions (-0 equals 0), or, with tolerance > 0, within that distance (model units; union of
 * chains). Faces keep their order and may collapse; the first vertex of a group stays where it is. Writes the new index
 * of each old vertex to map (vertex_count) when not NULL. Returns how many vertices went away. O(n log n). */
size_t mesh_weld(struct mesh *mesh, double tolerance, idx_t *map);

/* Bounding box; returns the longest side (0 for no vertices). low and high have room for 3, either may be NULL. */
double mesh_bounds(const double *xyz, size_t vertex_count, double low[3], double high[3]);

#endif
