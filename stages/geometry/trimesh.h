/* A mesh as triangles, and what can be counted on them. */
#ifndef CAGEWRIGHT_TRIMESH_H
#define CAGEWRIGHT_TRIMESH_H

#include "formats/mesh.h"

struct trimesh {
	struct mesh mesh;           /* a soup of triangles (STL) is welded at equal positions */
	idx_t *triangle;            /* 3 a triangle, from its polygons */
	size_t triangle_count;
	size_t used_count;          /* vertices of triangles */
	size_t degenerate_count;    /* triangles without area */
	size_t open_count;          /* edges of one triangle */
	size_t nonmanifold_count;   /* edges of more than two */
	double area, volume;        /* volume: signed, by the divergence theorem; means something only when nothing is open */
};

/* Takes the arrays of mesh over (mesh is empty afterwards). Faults: no faces (shown names the file). O(n log n). */
bool trimesh_from_mesh(struct trimesh *trimesh, struct mesh *mesh, const char *shown, struct fault *fault);
void trimesh_free(struct trimesh *trimesh);

#endif
