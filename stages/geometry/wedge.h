/* Wedges, patches and the edges between them on a triangle mesh.
 *
 * A wedge is a maximal fan of triangles around a vertex that no feature edge (sharp, border, cut) crosses; a dart's end
 * has one wedge. Half-edge h is corner h of the triangle list, as in half.h. */
#ifndef CAGEWRIGHT_WEDGE_H
#define CAGEWRIGHT_WEDGE_H

#include <stdbool.h>

#include "formats/dense.h"
#include "stages/geometry/half.h"

/* Number the wedges vertex by vertex, counter-clockwise within a vertex. feature[h] != 0 stops a fan at the edge of
 * half-edge h (both twins carry the mark). Writes the wedge of every corner to triangle_wedge (half_count) and, when not
 * NULL, the vertex of each wedge to *wedge_vertex (caller frees). Returns the number of wedges. O(n). */
size_t wedge_number(idx_t *triangle_wedge, idx_t **wedge_vertex, const struct half *half, const unsigned char *feature);

/* kind[h] (half_count) = enum edge_kind of the edge of half-edge h from dense->edge, 0 for smooth edges; edges without
 * twin that the file does not list count as EDGE_BORDER. Listed pairs that are no edge of the mesh are a fault
 * (EX_BAD_INPUT). O(n log n). */
bool wedge_mark_edges(unsigned char *kind, const struct dense *dense, const struct half *half, const char *shown, struct fault *fault);

/* bend[h] (half_count): bending angle of the edge in radians, > 0 convex, 0 at borders; normal: 3 a triangle, unit.
 * beta = atan2((n1 x n2) . e, n1 . n2), the patch method's section 0.2. */
void wedge_bends(double *bend, const double *xyz, const double *normal, const struct half *half);

/* Unit normals of triangles for angles between them. A triangle lower than thin (same unit as xyz) has a normal that
 * the rounding of its coordinates decides; it takes the normal of the neighbour over its longest edge instead (or of
 * the nearest sound triangle that can be reached so). normal: 3 a triangle; stays 0 where nothing sound is connected. */
void wedge_triangle_normals(double *normal, const double *xyz, const struct half *half, double thin);

/* Split labels into edge-connected components: component[t] in [0, returned count), numbered by lowest triangle. O(n). */
size_t patch_components(idx_t *component, const idx_t *label, const struct half *half);

/* Topology of each patch, after splitting vertices at which a patch touches itself (one copy a fan). */
struct patch_topology {
	size_t vertices, edges, faces, border_loops, components;
	long euler;
	long genus;          /* (2 - border_loops - euler) / 2, of an edge-connected patch */
};

/* Fill topology (patch_count) of all patches. Interior sharp edges (same label on both sides) count as interior. O(n). */
void patch_topologies(struct patch_topology *topology, size_t patch_count, const idx_t *label, const struct half *half);

/* Two patches side by side; first < second. */
struct patch_adjacency {
	idx_t first, second;
	double length;       /* of the common border */
	double sharp_length; /* of its sharp and cut part */
};

/* Neighbouring patches sorted by (first, second); kind as of wedge_mark_edges or NULL. Returns their number; *list
 * belongs to the caller. O(n log n). */
size_t patch_adjacencies(struct patch_adjacency **list, const idx_t *label, const double *xyz, const unsigned char *kind, const struct half *half);

#endif
