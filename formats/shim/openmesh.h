/* OpenMesh behind C: half-edge connectivity, edge-collapse simplification.
 * No C++ type, exception or allocation crosses this line: arrays come from malloc, errors as text in the caller's buffer. */
#ifndef CAGEWRIGHT_SHIM_OPENMESH_H
#define CAGEWRIGHT_SHIM_OPENMESH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* twin[h] for each corner h of the faces, -1 at borders. 0; -1 when the faces are not an oriented manifold. */
int shim_twins(int32_t *twin, const int32_t *corner, const size_t *face_start, size_t face_count, size_t vertex_count,
               char *message, size_t message_size);

/* Half-edge collapses in order of error, until none costs less than max_error or face_target faces are left. The error of a
 * vertex is a squared distance in xyz units: the mean over the planes of the triangles that it stands for (Garland and Heckbert
 * 1997, weighted by area), or over the planes across its border and feature edges when that is larger. Vertices with locked[v]
 * (may be NULL) stay, as do ends and meetings of chains; edges listed in feature (2 vertices each) and border edges collapse only
 * along themselves; no triangle turns by more than 60 degrees in one collapse. Writes the surviving triangles (indices into the
 * old vertices) over triangle, and which of the old ones each is to origin[triangle_count] (may be NULL); returns their number, or -1
 * with a message. */
long shim_simplify(int32_t *triangle, int32_t *origin, size_t triangle_count, const double *xyz, size_t vertex_count, const unsigned char *locked,
                   const int32_t *feature, size_t feature_count, double max_error, size_t face_target, char *message, size_t message_size);

#ifdef __cplusplus
}
#endif
#endif
