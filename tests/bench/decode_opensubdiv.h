/* OpenSubdiv behind a C function, for tests/bench/decode.c alone. */
#ifndef CAGEWRIGHT_DECODE_OPENSUBDIV_H
#define CAGEWRIGHT_DECODE_OPENSUBDIV_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A cage as OpenSubdiv takes it. */
struct osd_cage {
	int vertex_count, face_count, sharp_count, corner_count;
	const float *xyz;       /* 3 a vertex */
	const int *face_degree; /* a face */
	const int *face_vertex;
	const int *sharp;  /* 2 an edge, not the border */
	const int *corner; /* vertices that keep their place */
};

/* From the cage to vertices and faces of the level, everything anew: topology, uniform refinement with no more on the last level
 * than its faces, positions in single precision level by level. Seconds of the processor, or -1 when OpenSubdiv refuses the cage;
 * the number of vertices and the sums of all their coordinates and of their squares, for comparison. NULL in programs that are
 * built without OpenSubdiv. */
double osd_refine(size_t *vertices, double sum[2], const struct osd_cage *cage, int level) __attribute__((weak));

#ifdef __cplusplus
}
#endif

#endif
