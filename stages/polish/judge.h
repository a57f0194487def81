/* How well a cage follows the target, as one number that small edits change locally. */
#ifndef CAGEWRIGHT_JUDGE_H
#define CAGEWRIGHT_JUDGE_H

#include "stages/geometry/nearest.h"
#include "stages/polish/skin.h"

/* The dense mesh, moved and scaled so that its longest side is 1. */
struct target {
	double *xyz;
	idx_t *triangle;
	size_t vertex_count, triangle_count;
	double area;
	struct nearest *nearest;
	bool is_borrowed; /* mesh and tree belong to another target */
	/* samples: area_count uniform by area, then points on sharp edges, which count for the maximum only */
	size_t area_count, count;
	double *point, *normal;
};
/* Takes triangles as they are; sharp_deg: bending of edges that get samples of their own, at most sharp_samples. */
void target_start(struct target *target, const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count,
                  size_t samples, size_t sharp_samples, double sharp_deg);
/* The same mesh with other samples; base must outlive it. */
void target_resample(struct target *out, const struct target *base, size_t samples, size_t sharp_samples, double sharp_deg);
void target_free(struct target *target);

struct judge {
	const struct target *target;
	double max;       /* distances above this are dear */
	double limit;     /* and above this very dear: the largest that is allowed, less a margin */
	int steps;        /* subdivision level that is looked at, 2 or 3 */
	size_t *work;     /* counts samples looked at, as a measure of time that is the same on every machine */
	enum { PEAKS_FEW, PEAKS_SOME, PEAKS_ALL } peaks; /* where the largest distance is looked for besides samples and spots: at the vertices
	                                                    of the cage and its creases, of the next to last level, of the last level */
};

#define TIP_WEIGHT 4 /* samples that a vertex of the cage counts for when it is too far */

/* The cost of a distance: d + d^2 / max, with a steep slope above max and a very steep one above limit, and more for a sample that is
 * turned. Lengths: longest side 1. */
double judge_cost(const struct judge *judge, double distance, bool is_turned);
/* Its derivative by distance. */
double judge_slope(const struct judge *judge, double distance);

/* What is known of each sample and face. Errors are means over both directions: halves of the mean over samples and the mean over the
 * surface's area. */
struct sample_error {
	idx_t face; /* of the sketch */
	float cost, distance;
	unsigned char is_turned;
};
struct face_error {
	double cost, distance, area, turned, folded, worst; /* integrals over the face; the largest distance */
};
struct errors {
	struct sample_error *sample;
	struct face_error *face;
	size_t *face_first; /* samples of face f: face_sample[face_first[f]] .. */
	idx_t *face_sample;
	float *tip;         /* a vertex of the sketch: cost of its being too far, */
	float *tip_worst;   /* and the largest distance of it and its creases */
	double cost;        /* of all, longest sides */
	double mean, max;   /* distance */
	double turned;      /* share of the area, the larger of both directions */
	double folded;      /* share of the surface's area that looks away from what it is a part of */
};
void errors_free(struct errors *errors);

/* Measure a whole sketch. */
void judge_all(struct errors *errors, const struct judge *judge, const struct sketch *sketch);

/* Part of a judgement under way: a skin, the samples that fall on it, their feet and those of its spots. */
struct view {
	struct skin skin;
	const idx_t *sample;
	size_t sample_count;
	struct skin_foot *foot;
	size_t spot_count;
	struct skin_spot *spot;
	struct foot *spot_foot;
	idx_t *spot_root;
	double (*spot_before)[3]; /* where the spots were before the last move */
	struct tip { /* a vertex of the cage, or the middle of a crease, on the surface */
		idx_t corner[3]; /* the fine vertex, three times */
		idx_t vertex;    /* of the part: itself, or where the crease's half-edge starts */
		struct foot foot;
	} *tip;
	size_t tip_count;
	double *spot_cost;  /* filled by view_measure */
	double sample_sum, spot_sum, spot_area; /* of cost; of cost * area; of area */
	double tip_sum, tip_worst; /* over the cage's own vertices: cost above the largest distance wanted; the largest distance */
};
/* sample stays the caller's. */
void view_open(struct view *view, const struct judge *judge, const struct sketch *sketch, const idx_t *face, size_t face_count,
               const idx_t *sample, size_t sample_count);
void view_free(struct view *view);
/* The sketch's vertices have moved. */
void view_move(struct view *view, const struct judge *judge, const struct sketch *sketch);

/* The errors of an edited sketch from those before the edit and a view of its changed faces (those that view_open was given, with all samples of
 * the faces that they replace). face: by old face its index now, NO_INDEX for those gone; vertex: the same for vertices. What lies elsewhere is
 * taken over as it was; samples there that come nearer to a changed face are not looked for. O(samples). */
void judge_edit(struct errors *errors, const struct judge *judge, const struct sketch *sketch, const struct view *view, const struct errors *before,
                const idx_t *face, size_t old_faces, const idx_t *vertex, size_t old_vertices);

#endif
