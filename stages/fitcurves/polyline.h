/* The polylines of mesh edges that curves are fitted to: lengths, curvature, what deviation they ask for, foot points. */
#ifndef CAGEWRIGHT_POLYLINE_H
#define CAGEWRIGHT_POLYLINE_H

#include <stdbool.h>
#include <stddef.h>

/* Arrays are by vertex; segment i runs from vertex i to the next (closed: also from the last to the first). */
struct polyline {
	size_t count, segment_count;
	bool closed;
	double *xyz;
	double *arc; /* count + 1: length up to each vertex; closed: arc[count] is the whole length */
	double length;
	double *tangent;   /* 3 a vertex, unit: bisector of its two segments */
	double *curvature; /* 3 a vertex: curvature vector by turning angle, 0 where the turn is a kink (> 50 degrees) or an end
			    */
	double *turn;      /* turning angle at each vertex, radians; 0 at ends */
	double *slack; /* a segment: how far its smooth original may stand off: sagitta of a coarse arc, steps of a jagged border
			*/
	double noise;  /* median residual of local cubics: > 0 for the staircases of patch borders */
};

/* Copies count points. Repeated points are dropped (a closed polyline's last may not repeat its first). */
void polyline_init(struct polyline *line, const double *xyz, size_t count, bool closed);
void polyline_free(struct polyline *line);

/* Does the line zigzag by a good part of its edges, as borders along remeshed triangles do? */
bool polyline_is_jagged(const struct polyline *line);

/* Replace inner vertices by local least-squares cubics over nine neighbours (Savitzky and Golay 1964), ends stay. */
void polyline_smooth(struct polyline *line);

struct polyline_foot {
	double point[3], tangent[3], curvature[3];
	double arc; /* [0, length] */
	double distance;
	size_t segment;
};

/* Nearest point of the part between arcs from and to (closed: any real numbers, at most one turn apart; open: clamped). */
struct polyline_foot polyline_nearest(const struct polyline *line, const double p[3], double from, double to);

/* The point at an arc length (closed: modulo the length). */
void polyline_at(double out[3], const struct polyline *line, double arc);

/* The arc length on to of the place at an arc length on from, a changed version with the same vertices or
 * one more on each segment (any real number on closed lines). */
double polyline_carry(const struct polyline *to, const struct polyline *from, double arc);

/* Segment that holds an arc length in [0, length]. */
size_t polyline_segment(const struct polyline *line, double arc);

#endif
