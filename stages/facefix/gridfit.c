/* Putting a cage on an integer grid (patch method, sections 8.5 and 12.4). */
#include "stages/facefix/gridfit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh.h"
#include "stages/facefix/gridmend.h"
#include "stages/geometry/vector.h"

#define MEASURED_FACES 200000
#define MEASURED_LEVEL 3

double gridfit_exact(const struct cage *cage, const struct ffx *ffx, size_t i)
{
	return cage->xyz[i] / ffx->frame.step - ldexp((double)ffx->frame.origin[i % 3], -(int)ffx->frame.origin_bits);
}

bool gridfit_round(struct ffx *ffx, const struct cage *cage, unsigned grid_code, bool with_patches, struct fault *fault)
{
	memset(ffx, 0, sizeof *ffx);
	double low[3], high[3];
	const double side = mesh_bounds(cage->xyz, cage->vertex_count, low, high);
	if (!(side > 0))
		return fault_set(fault, EX_BAD_INPUT, "the cage has no extent");
	const int32_t steps = ffx_grid_steps(grid_code);
	ffx->scheme = cage->scheme;
	ffx->grid_code = grid_code;
	ffx->has_frame = true;
	if (!ffx_frame_choose(&ffx->frame, low, side, steps))
		return fault_set(fault, EX_BAD_INPUT,
				 "a cage with sides of %g units at (%g %g %g) is beyond what a stream can hold", side, low[0],
				 low[1], low[2]);
	ffx->vertex_count = cage->vertex_count;
	ffx->grid = mem_array(3 * cage->vertex_count, sizeof *ffx->grid);
	for (size_t i = 0; i < 3 * cage->vertex_count; i++) {
		const double at = round(gridfit_exact(cage, ffx, i));
		ffx->grid[i] = (int32_t)fmin(fmax(at, 0), steps);
	}
	ffx->face_count = cage->face_count;
	ffx->face_start = mem_copy(cage->face_start, cage->face_count + 1, sizeof *cage->face_start);
	ffx->face_corner = mem_copy(cage->face_corner, cage->face_start[cage->face_count], sizeof *cage->face_corner);
	if (with_patches)
		ffx->face_patch = mem_copy(cage->face_patch, cage->face_count, sizeof *cage->face_patch);
	ffx->sharp = mem_copy(cage->sharp, 2 * cage->sharp_count, sizeof *cage->sharp);
	ffx->sharp_count = cage->sharp_count;
	ffx->corner = mem_copy(cage->corner, cage->vertex_count, 1);
	return true;
}

/* A multiple (4 n, for n corners) of the area vector of the sub-quad at corner i of a face: vertex, middle of the side after it,
 * centre of the face, middle of the side before it. sum: of the corners. Exact where the coordinates are integers. */
static void subquad(double out[3], const double before[3], const double at[3], const double after[3], const double sum[3], size_t n)
{
	double along[3], across[3];
	for (int k = 0; k < 3; k++)
		along[k] = sum[k] - (double)n * at[k];
	sub3(across, before, after);
	cross3(out, along, across);
}

static void point_of(double exact[3], double rounded[3], const struct cage *cage, const struct ffx *ffx, idx_t v)
{
	for (int k = 0; k < 3; k++) {
		exact[k] = cage->xyz[3 * (size_t)v + k];
		rounded[k] = ffx->grid[3 * (size_t)v + k];
	}
}

size_t gridfit_turned_corners(const struct cage *cage, const struct ffx *ffx, size_t face, double small)
{
	const idx_t *corner = cage->face_corner + cage->face_start[face];
	const size_t n = cage->face_start[face + 1] - cage->face_start[face];
	size_t count = 0;
	double exact[3][3], rounded[3][3], exact_sum[3] = {0}, rounded_sum[3] = {0};
	for (size_t i = 0; i < n; i++) {
		point_of(exact[0], rounded[0], cage, ffx, corner[i]);
		add_scaled3(exact_sum, 1, exact[0]);
		add_scaled3(rounded_sum, 1, rounded[0]);
	}
	for (size_t i = 0; i < n; i++) {
		double before[3], after[3];
		point_of(exact[0], rounded[0], cage, ffx, corner[(i + n - 1) % n]);
		point_of(exact[1], rounded[1], cage, ffx, corner[i]);
		point_of(exact[2], rounded[2], cage, ffx, corner[(i + 1) % n]);
		subquad(before, exact[0], exact[1], exact[2], exact_sum, n);
		subquad(after, rounded[0], rounded[1], rounded[2], rounded_sum, n);
		count += norm3(before) > 4 * small * small * (double)n && dot3(before, after) <= 0;
	}
	return count;
}

/* Two corners of a face at one place that were apart before? Sorted by place, so that long faces cost no square. */
struct place {
	int32_t at[3];
	const double *before;
};

static int compare_places(const void *left, const void *right)
{
	const struct place *a = left, *b = right;
	for (int k = 0; k < 3; k++)
		if (a->at[k] != b->at[k])
			return a->at[k] < b->at[k] ? -1 : 1;
	for (int k = 0; k < 3; k++)
		if (a->before[k] != b->before[k])
			return a->before[k] < b->before[k] ? -1 : 1;
	return 0;
}

static bool collapses(struct place *place, const struct cage *cage, const struct ffx *ffx, const idx_t *corner, size_t n)
{
	for (size_t i = 0; i < n; i++) {
		memcpy(place[i].at, ffx->grid + 3 * (size_t)corner[i], sizeof place[i].at);
		place[i].before = cage->xyz + 3 * (size_t)corner[i];
	}
	qsort(place, n, sizeof *place, compare_places);
	for (size_t i = 1; i < n; i++)
		if (memcmp(place[i].at, place[i - 1].at, sizeof place[i].at) == 0 &&
		    distance3(place[i].before, place[i - 1].before) > 0)
			return true;
	return false;
}

struct gridfit_damage gridfit_check(const struct cage *cage, const struct ffx *ffx, double small)
{
	struct gridfit_damage damage = {0};
	size_t longest = 0;
	for (size_t f = 0; f < cage->face_count; f++)
		longest = cage->face_start[f + 1] - cage->face_start[f] > longest ? cage->face_start[f + 1] - cage->face_start[f]
										  : longest;
	struct place *place = mem_array(longest, sizeof *place);
	for (size_t f = 0; f < cage->face_count; f++) {
		damage.turned += gridfit_turned_corners(cage, ffx, f, small);
		damage.collapsed += collapses(place, cage, ffx, cage->face_corner + cage->face_start[f],
					      cage->face_start[f + 1] - cage->face_start[f]);
	}
	free(place);
	damage.overlaid = gridmend_count(ffx, cage);
	return damage;
}

/* Mean (by area) and largest displacement along the faces' normals between two refinements of one cage. */
static void measure(double *mean, double *max, const struct level *a, const struct level *b)
{
	double sum = 0, area_sum = 0, most = 0;
	for (size_t f = 0; f < a->face_count; f++) {
		const idx_t *corner = a->face_corner + a->face_start[f];
		const size_t n = a->face_start[f + 1] - a->face_start[f];
		double normal[3] = {0};
		for (size_t i = 2; i < n; i++) {
			double part[3];
			area_vector3(part, a->xyz + 3 * (size_t)corner[0], a->xyz + 3 * (size_t)corner[i - 1],
				     a->xyz + 3 * (size_t)corner[i]);
			add_scaled3(normal, 0.5, part);
		}
		const double area = normalise3(normal);
		double local = 0;
		for (size_t i = 0; i < n; i++) {
			double moved[3];
			sub3(moved, b->xyz + 3 * (size_t)corner[i], a->xyz + 3 * (size_t)corner[i]);
			const double off = fabs(dot3(moved, normal));
			local += off / (double)n;
			most = off > most ? off : most;
		}
		sum += local * area;
		area_sum += area;
	}
	*mean = area_sum > 0 ? sum / area_sum : 0;
	*max = most;
}

bool gridfit_ruler_start(struct gridfit_ruler *ruler, const struct cage *cage, struct fault *fault)
{
	*ruler = (struct gridfit_ruler){.cage = cage, .level = MEASURED_LEVEL};
	if (!level_from_cage(&ruler->base, cage, fault))
		return false;
	size_t faces = cage->face_start[cage->face_count] * 16; /* at level 3: each corner gives a quad and that 16 */
	for (; ruler->level > 1 && faces > MEASURED_FACES; ruler->level--)
		faces /= 4;
	level_refine(&ruler->target, &ruler->base, cage->scheme, ruler->level);
	return true;
}

void gridfit_ruler_free(struct gridfit_ruler *ruler)
{
	level_free(&ruler->base);
	level_free(&ruler->target);
}

void gridfit_deviation(double *mean, double *max, struct gridfit_ruler *ruler, const struct ffx *ffx)
{
	struct cage rounded;
	ffx_to_cage(&rounded, ffx);
	memcpy(ruler->base.xyz, rounded.xyz, 3 * rounded.vertex_count * sizeof *ruler->base.xyz);
	struct level refined;
	level_refine(&refined, &ruler->base, ruler->cage->scheme, ruler->level);
	measure(mean, max, &ruler->target, &refined);
	level_free(&refined);
	cage_free(&rounded);
}

static bool is_within(struct gridfit_choice *choice, struct gridfit_ruler *ruler, const struct ffx *ffx, double tolerance)
{
	gridfit_deviation(&choice->mean, &choice->max, ruler, ffx);
	return choice->mean <= tolerance && choice->max <= GRIDFIT_MAX_OVER_MEAN * tolerance;
}

bool gridfit_choose(struct gridfit_choice *choice, const struct cage *cage, double tolerance, struct fault *fault)
{
	*choice = (struct gridfit_choice){0};
	struct gridfit_ruler ruler;
	if (!gridfit_ruler_start(&ruler, cage, fault))
		return false;
	const double side = mesh_bounds(cage->xyz, cage->vertex_count, NULL, NULL);
	/* Rounding moves the surface by about a fifth of a step in the mean: grids ten times coarser need not be tried. */
	const double coarsest = fmin(0.02 * side / tolerance, 40000);
	bool is_good = true;
	for (unsigned code = ffx_grid_code((int32_t)fmax(coarsest, 7));; code++) {
		struct ffx ffx;
		is_good = gridfit_round(&ffx, cage, code, false, fault);
		if (!is_good)
			break;
		bool is_near = is_within(choice, &ruler, &ffx, tolerance), is_whole = true;
		if (is_near) {
			const double small = GRIDFIT_SMALL_TOLERANCES * tolerance;
			struct gridmend_report mended;
			gridmend(&ffx, &mended, cage, small);
			is_near = mended.moved == 0 || is_within(choice, &ruler, &ffx, tolerance);
			const struct gridfit_damage damage = gridfit_check(cage, &ffx, small);
			is_whole = damage.collapsed == 0 && damage.turned == 0 && damage.overlaid == 0;
			choice->finer += !(is_near && is_whole);
		}
		ffx_free(&ffx);
		choice->grid_code = code;
		if ((is_near && is_whole) || code + 1 == FFX_GRID_CODES)
			break;
	}
	gridfit_ruler_free(&ruler);
	return is_good;
}
