/* OpenMesh behind C: reading foreign files, half-edge connectivity, edge-collapse simplification.
 * No C++ type, exception or allocation crosses this line: arrays come from malloc, errors as text in the caller's buffer. */
#ifndef CAGEWRIGHT_SHIM_OPENMESH_H
#define CAGEWRIGHT_SHIM_OPENMESH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raw polygons of a file in memory (data, size; extension such as "off" picks the reader). xyz: 3 * *vertex_count doubles,
 * corner / face_start as in struct mesh (indices unchecked, may be out of range); caller frees. 0, or -1 with a message. */
int shim_read(const void *data, size_t size, const char *extension, double **xyz, size_t *vertex_count, int64_t **corner,
              size_t **face_start, size_t *face_count, char *message, size_t message_size);

/* twin[h] for each corner h of the faces, -1 at borders. 0; -1 when the faces are not an oriented manifold. */
int shim_twins(int32_t *twin, const int32_t *corner, const size_t *face_start, size_t face_count, size_t vertex_count,
               char *message, size_t message_size);

/* Half-edge collapses by quadric error, in order of error, until none costs less than max_error (squared distance, xyz
 * units) or face_target faces are left. Vertices with locked[v] stay; edges listed in feature (2 a edge) are only collapsed along themselves; border
 * edges too. Writes the surviving triangles (indices into the old vertices) over triangle; returns their number, or -1. */
long shim_simplify(int32_t *triangle, size_t triangle_count, const double *xyz, size_t vertex_count, const unsigned char *locked,
                   const int32_t *feature, size_t feature_count, double max_error, size_t face_target, char *message, size_t message_size);

#ifdef __cplusplus
}
#endif
#endif
