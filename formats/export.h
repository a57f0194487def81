/* Writing meshes for other programs: PLY, OBJ, OFF, STL (binary; "stla" ascii). Needs libc only. */
#ifndef CAGEWRIGHT_EXPORT_H
#define CAGEWRIGHT_EXPORT_H

#include <stdbool.h>
#include <stdio.h>

#include "formats/fault.h"
#include "formats/mesh.h"

/* Is there a writer for this extension (lower case, without dot)? */
bool export_knows(const char *extension);

/* Write by extension. STL triangulates: faces as a fan around an inner vertex of two faces, else quads by the shorter diagonal
 * (ties: the one from the lower vertex index), larger polygons around the first corner. Text has the shortest numbers that read back exactly.
 * PLY is binary little-endian with double coordinates when binary_ply, else ascii. */
bool export_mesh(FILE *file, const char *extension, const struct mesh *mesh, bool binary_ply, struct fault *fault);

#endif
