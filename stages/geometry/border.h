/* The borders between the patches of a labelled mesh as chains of mesh edges between nodes
 * (the patch method's section 4.1). fitcurves fits one subdivision curve to each chain; fitpatch finds by it which mesh
 * border belongs to which curve. */
#ifndef CAGEWRIGHT_BORDER_H
#define CAGEWRIGHT_BORDER_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/dense.h"
#include "formats/fault.h"
#include "formats/network.h"
#include "formats/ply.h"

struct border_options {
	double corner_deg; /* a chain that turns by more than this has a node there */
	double smooth_deg; /* normals of both sides that differ by less, beyond what the tessellation explains, make a
			      smooth chain; 0: only patches cut from one surface do */
	bool darts;        /* also interior sharp chains, with the same patch on both sides */
};

/* 45 and 8 degrees (sections 4.1 and 10, hazard 20), no darts. */
#define BORDER_DEFAULTS ((struct border_options){45, 8, false})

/* The options travel with the network as "comment cagewright-border corner=45 smooth=8", so that a later stage finds the same
 * chains. Read: the defaults where there is no such comment or it says nothing sensible. */
struct border_options border_options_from_ply(const struct ply *ply);
void border_options_to_ply(struct ply *ply, struct border_options options);

struct border_chain {
	idx_t left, right; /* patches, left when walking along the vertices: left < right, or right -1 outside */
	enum curve_kind
		kind; /* sharp, smooth (a virtual border of one surface, or a tangent-continuous one), border of the mesh */
	bool closed;  /* without node; the seam is the vertex of lowest x, then y, then z */
	size_t first,
		count; /* its mesh vertices: vertex[first] .. vertex[first + count); open: with both ends, closed: each once */
};

struct border_network {
	long euler; /* characteristic of the whole mesh: vertices in use - edges + triangles */
	size_t node_count, chain_count, vertex_count;
	idx_t *node;              /* mesh vertices, ascending */
	unsigned char *node_kind; /* enum point_kind: POINT_CORNER where exactly two sharp or border chains meet in a kink
				     (an explicit corner of the cage), else POINT_JUNCTION */
	idx_t *node_of_vertex;    /* dense vertex_count: index into node or NO_INDEX */
	struct border_chain *chain;
	idx_t *vertex;          /* vertices of all chains, one after the other */
	size_t dart_edge_count; /* sharp edges with one patch on both sides (a chain only with options.darts) */
};

/* dense needs label; patch may be NULL (then every patch is its own parent). Faults (EX_BAD_INPUT): an edge with more than
 * two triangles, or with two in the same direction. The order of chains follows the lowest half-edge of each. O(n). */
bool border_extract(struct border_network *network, const struct dense *dense, struct border_options options,
		    struct fault *fault);
void border_free(struct border_network *network);

/* Which chain each curve of a fitted network follows: chain_of_curve[curve_count], NO_INDEX when no chain separates the
 * same patches. Among several the one whose end points and middle are nearest. */
void border_match(idx_t *chain_of_curve, const struct border_network *border, const struct dense *dense,
		  const struct network *network);

#endif
