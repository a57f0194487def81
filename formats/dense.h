/* The dense mesh between curv, segment and rectify: struct, read, write, check of PART.curv.ply, PART.segment.ply,
 * PART.rectify.ply (see cagewright-dense(5)). */
#ifndef CAGEWRIGHT_DENSE_H
#define CAGEWRIGHT_DENSE_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/ply.h"

enum edge_kind { EDGE_SHARP = 1, EDGE_BORDER = 2, EDGE_CUT = 3 }; /* cut: non-manifold or Moebius input, split there */

enum wedge_quality {
	WEDGE_GOOD = 0,
	WEDGE_ISOTROPIC = 1, /* directions carry no information: anisotropy < 0.2 or |k| * radius < 0.02 */
	WEDGE_FLAT = 2,      /* nothing bent in reach: curvatures are 0 */
	WEDGE_SINGULAR = 3,  /* cone apex, pole of slivers: treat as isotropic */
};

enum patch_kind { PATCH_PLANE = 0, PATCH_CYLINDER = 1, PATCH_CONE = 2, PATCH_SPHERE = 3, PATCH_TORUS = 4, PATCH_FREE = 5 };
#define PATCH_KIND_COUNT 6

struct dense_edge {
	idx_t vertex1, vertex2;
	double angle_deg;      /* bending, > 0 convex, < 0 concave; 0 at borders */
	enum edge_kind kind;
};

/* One analytic surface or free-form region. Unused parameters are 0. Lengths in model units. */
struct dense_patch {
	enum patch_kind kind;
	double point[3];       /* plane: a point on it; cylinder: a point of the axis; cone: apex; sphere, torus: centre */
	double axis[3];        /* unit; plane: outward normal; cylinder, cone, torus: axis (cone: from the apex into the cone) */
	double radius;         /* cylinder, sphere; torus: of the centre circle. Cone: 0 */
	double radius2;        /* torus: of the tube; cone: half opening angle in degrees */
	double sign;           /* +1: the surface bulges outward (a shaft), -1: inward (a bore); 0 for planes and free */
	double area;           /* of its triangles */
	double residual;       /* largest distance of its vertices to the surface; 0 for free */
	idx_t parent;          /* patches cut from one surface by virtual borders share it; else the patch itself */
};

/* Triangles and wedges. A wedge is a fan of triangles around a vertex that no sharp, border or cut edge crosses. */
struct dense {
	size_t vertex_count, triangle_count, wedge_count, edge_count, patch_count;
	double *xyz;           /* 3 a vertex, model units */
	idx_t *triangle;       /* 3 a triangle, vertices */
	idx_t *triangle_wedge; /* 3 a triangle, the wedge at each corner */
	idx_t *label;          /* patch of each triangle, [0, patch_count); NULL before segment */
	idx_t *wedge_vertex;
	double *wedge_normal;  /* 3 a wedge, unit */
	double *kmin, *kmax;   /* 1 / model unit, |kmin| <= |kmax|, convex > 0 */
	double *dmin;          /* 3 a wedge, unit, tangent: direction of kmin */
	double *anisotropy;    /* [0, 1], see patch-pipeline: (|kmax| - |kmin|) / (|kmax| + |kmin| + 0.2 / side) */
	unsigned char *quality;/* enum wedge_quality */
	struct dense_edge *edge; /* only sharp, border and cut edges */
	struct dense_patch *patch; /* NULL before segment */
};

void dense_free(struct dense *dense);

/* Take what is known from a PLY file. Faults (EX_BAD_INPUT): missing elements, indices out of range, non-finite numbers,
 * a face that is no triangle, a wedge of another vertex, labels without a patch. label and patch stay NULL when the
 * file has none; want_labels makes that a fault. */
bool dense_from_ply(struct dense *dense, const struct ply *ply, bool want_labels, const char *shown, struct fault *fault);

/* Put everything (vertex, face, wedge, edge elements) into a document, replacing what it had; labels and patches when there are some. */
void dense_to_ply(struct ply *ply, const struct dense *dense);

/* Put only face.patch and the patch element: what segment and rectify add; the rest passes as it was. */
void dense_labels_to_ply(struct ply *ply, const struct dense *dense);

#endif
