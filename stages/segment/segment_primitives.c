/* Partition by analytic surfaces: search, borders, remains, at the tolerance that explains each part best. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/primitive_search.h"
#include "stages/segment/region_tidy.h"
#include "stages/segment/segment_primitives.h"

/* Tolerances, longest side 1: single precision of STL files and the modellers' own; decimated and subdivided meshes;
 * remeshed ones; scans. A wider one is taken for a smooth part when it lowers the cost of the description by the factor. */
static const double level_distance[PRIMITIVES_LEVELS] = {5e-5, 2e-4, 8e-4, 2e-3};
static const double level_gain[PRIMITIVES_LEVELS] = {1, 0.8, 0.65, 0.5};
#define NOISY_DISTANCE 1.5e-4
#define ANGLE_TOLERANCE 0.05   /* radians: 3 degrees */
#define COST_FREE_REGION 3.0   /* in patches of an analytic surface */
#define COST_FREE_AREA 60.0    /* the same for a whole mesh without explanation */
#define COST_FREE_PART 100.0   /* more than that for one part that is met only roughly: it is none of surfaces */
#define LOOSE 0.3              /* root mean square distance over the tolerance */
#define GENTLE_MEAN 0.7        /* length of the mean normal */
#define LOSS_MOST 0.02         /* share of a part that a wider tolerance may explain less */
#define SURE_TRIANGLES 10.0    /* a region, on average */
#define SURE_GAIN 0.5
#define FREE_SHARE 0.2
#define FACETED_REGIONS 16     /* planes, of a part that may be nothing but its facets ... */
#define FACETED_TRIANGLES 2.2  /* each of so many triangles at most, on average ... */
#define FACETED_EVEN 0.7       /* and of about one size: share of them that would, being equal, have the same sum of squared areas */
#define CLEAN_COST 4.0         /* a part so cheap needs no other tolerance, when it was met at the closest one ... */
#define WHOLE_COST 1.5         /* ... else only one that is a single surface */

static double mean_length(const struct facets *f)
{
	double sum = 0;
	for (size_t h = 0; h < 3 * f->triangle_count; h++)
		sum += f->length[h];
	return f->triangle_count ? sum / (3 * (double)f->triangle_count) : 0;
}

/* A modeller puts no vertices inside a plane; a remesher does. Share of vertices of large flats that lie inside one. */
static bool is_dense(const struct facets *f, const struct flats *flats)
{
	idx_t *of = mem_array(f->vertex_count, sizeof *of);
	size_t inside = 0, all = 0;
	for (size_t v = 0; v < f->vertex_count; v++)
		of[v] = NO_INDEX;
	/* -1 none yet, -2 several */
	for (size_t c = 0; c < 3 * f->triangle_count; c++) {
		const idx_t flat = flats->of[c / 3], v = f->triangle[c];
		of[v] = of[v] == NO_INDEX || of[v] == flat ? flat : -2;
	}
	for (size_t v = 0; v < f->vertex_count; v++)
		if (of[v] != NO_INDEX) {
			all++;
			inside += of[v] >= 0;
		}
	free(of);
	/* a mesh without planes, on which nearly every triangle is a flat of its own, is dense when there are many */
	return 5 * inside > all || (flats->count > 1000 && 2 * flats->count > f->triangle_count);
}

static void segment_at(struct regions *r, double distance, double least_share)
{
	const struct facets *f = r->facets;
	const bool is_noisy = distance > NOISY_DISTANCE;
	struct flats flats;
	flats_build(&flats, f, fmin(0.2 * distance, 2e-5), 0.01);
	const struct search_options search = {
		.distance = distance, .angle = ANGLE_TOLERANCE,
		.least_area = is_noisy ? least_share * f->total_area : 0,
		.work_most = 20000000 + 100 * f->triangle_count,
	};
	const struct tidy_options tidy = {
		.distance = distance, .angle = ANGLE_TOLERANCE,
		.smoothness = 0.5 * mean_length(f),
		.least_area = least_share * f->total_area, .is_noisy = is_noisy,
		.is_dense = is_dense(f, &flats),
	};
	primitive_search(r, &flats, &search);
	tidy_free_regions(r);
	tidy_flat_regions(r, distance);
	tidy_borders(r, &tidy, 8);
	regions_split(r);
	tidy_absorb(r, &tidy);
	tidy_share_flats(r, &flats, &tidy);
	tidy_unite(r, &flats, &tidy);
	tidy_measure(r, distance);
	tidy_borders(r, &tidy, 20);
	regions_split(r);
	tidy_absorb(r, &tidy);
	tidy_unite(r, &flats, &tidy);
	tidy_measure(r, distance);
	flats_free(&flats);
}

/* What the present regions of each smooth part cost, and the area of it that none of them explains. */
static void part_costs(double *cost, double *unexplained, const struct regions *r, const unsigned char *level, const double *distance)
{
	const struct facets *f = r->facets;
	unsigned char *is_counted = mem_array(r->count, 1);
	memset(cost, 0, f->smooth_part_count * sizeof *cost);
	memset(unexplained, 0, f->smooth_part_count * sizeof *unexplained);
	for (size_t t = 0; t < f->triangle_count; t++) {
		const idx_t label = r->label[t];
		const bool is_free = r->patch[label].kind == PATCH_FREE;
		bool is_explained = !is_free;
		for (int k = 0; k < 3 && is_explained; k++)
			is_explained = fabs(primitive_distance(&r->patch[label], f->xyz + 3 * f->triangle[3 * t + k])) <= 2 * distance[level[f->smooth_part[t]]];
		unexplained[f->smooth_part[t]] += is_explained ? 0 : f->area[t];
		if (!is_explained)
			cost[f->smooth_part[t]] += COST_FREE_AREA * f->area[t] / f->total_area;
		if (!is_counted[label])
			cost[f->smooth_part[t]] += is_free ? COST_FREE_REGION : 1;
		is_counted[label] = 1;
	}
	free(is_counted);
}

/* Smooth parts that are cheaper as free-form become one free region: many surfaces that are met only roughly, or some
 * that share a gently bent part without being its faces (their vertices fill the tolerance, those of faces lie well within). */
static void whole_free_parts(struct regions *r, double *cost, const unsigned char *level, const double *distance)
{
	const struct facets *f = r->facets;
	const size_t parts = f->smooth_part_count;
	double *left = mem_array(parts, sizeof *left), *square = mem_array(parts, sizeof *square), *area = mem_array(parts, sizeof *area), *normal = mem_array(3 * parts, sizeof *normal);
	idx_t *fresh = mem_array(parts, sizeof *fresh);
	const struct dense_patch none = {.kind = PATCH_FREE};
	part_costs(cost, left, r, level, distance);
	for (size_t t = 0; t < f->triangle_count; t++) {
		const idx_t p = f->smooth_part[t];
		const struct dense_patch *patch = &r->patch[r->label[t]];
		area[p] += f->area[t];
		add_scaled3(normal + 3 * p, f->area[t], f->normal + 3 * t);
		for (int k = 0; k < 3 && patch->kind != PATCH_FREE; k++) {
			const double d = primitive_distance(patch, f->xyz + 3 * f->triangle[3 * t + k]) / distance[level[p]];
			square[p] += f->area[t] / 3 * fmin(4, d * d);
		}
	}
	for (size_t p = 0; p < parts; p++) {
		const bool is_rough = distance[level[p]] > NOISY_DISTANCE;
		const bool is_loose = square[p] > LOOSE * LOOSE * area[p], is_gentle = norm3(normal + 3 * p) > GENTLE_MEAN * area[p];
		const bool is_free = is_rough && ((is_loose && is_gentle && cost[p] > COST_FREE_REGION + 1) ||
		                                  ((is_loose || left[p] > FREE_SHARE * area[p]) && cost[p] > COST_FREE_PART));
		fresh[p] = is_free ? regions_add(r, &none) : NO_INDEX;
	}
	for (size_t t = 0; t < f->triangle_count; t++)
		if (fresh[f->smooth_part[t]] != NO_INDEX)
			r->label[t] = fresh[f->smooth_part[t]];
	free(left);
	free(square);
	free(area);
	free(normal);
	free(fresh);
}

/* A coarse free-form part is planes triangle by triangle: a description no shorter than the mesh. Faces of a polyhedron
 * with bevels are as few triangles each, but of different sizes. */
static void faceted_parts(struct regions *r)
{
	const struct facets *f = r->facets;
	const size_t parts = f->smooth_part_count, before = r->count;
	double *area = mem_array(parts, sizeof *area), *squares = mem_array(parts, sizeof *squares), *size = mem_array(before, sizeof *size);
	size_t *regions = mem_array(parts, sizeof *regions), *triangles = mem_array(parts, sizeof *triangles);
	unsigned char *is_curved = mem_array(parts, 1);
	idx_t *fresh = mem_array(parts, sizeof *fresh), *part_of = mem_array(before, sizeof *part_of);
	const struct dense_patch none = {.kind = PATCH_FREE};
	for (size_t i = 0; i < before; i++)
		part_of[i] = NO_INDEX;
	for (size_t t = 0; t < f->triangle_count; t++) {
		size[r->label[t]] += f->area[t];
		part_of[r->label[t]] = f->smooth_part[t];
		area[f->smooth_part[t]] += f->area[t];
		triangles[f->smooth_part[t]]++;
	}
	for (size_t i = 0; i < before; i++)
		if (part_of[i] != NO_INDEX) {
			regions[part_of[i]]++;
			squares[part_of[i]] += size[i] * size[i];
			is_curved[part_of[i]] |= r->patch[i].kind != PATCH_PLANE;
		}
	for (size_t p = 0; p < parts; p++) {
		const bool is_faceted = !is_curved[p] && regions[p] >= FACETED_REGIONS && (double)triangles[p] <= FACETED_TRIANGLES * (double)regions[p] &&
		                        area[p] * area[p] > FACETED_EVEN * (double)regions[p] * squares[p];
		fresh[p] = is_faceted ? regions_add(r, &none) : NO_INDEX;
	}
	for (size_t t = 0; t < f->triangle_count; t++)
		if (fresh[f->smooth_part[t]] != NO_INDEX)
			r->label[t] = fresh[f->smooth_part[t]];
	free(area);
	free(squares);
	free(size);
	free(regions);
	free(triangles);
	free(is_curved);
	free(fresh);
	free(part_of);
}

/* In noisy parts edges are sharp by accident, and cut off more than slivers. */
static void absorb_specks(struct regions *r, const unsigned char *level, const double *distance, double least_area)
{
	const struct facets *f = r->facets;
	double *reach = mem_array(r->count, sizeof *reach), *speck_area = mem_array(r->count, sizeof *speck_area);
	bool is_noisy = false;
	for (size_t t = 0; t < f->triangle_count; t++) {
		const double d = distance[level[f->smooth_part[t]]];
		reach[r->label[t]] = (d > NOISY_DISTANCE ? 6 : 3) * d;
		is_noisy = is_noisy || d > NOISY_DISTANCE;
	}
	for (size_t i = 0; i < r->count; i++)
		speck_area[i] = is_noisy ? least_area / 2 : least_area / 10;
	tidy_specks(r, speck_area, reach);
	free(reach);
	free(speck_area);
}

void segment_primitives(struct regions *r, const struct primitives_options *options, struct primitives_report *report)
{
	const struct facets *f = r->facets;
	double *cost = mem_array(f->smooth_part_count, sizeof *cost), *other = mem_array(f->smooth_part_count, sizeof *other);
	double *left = mem_array(f->smooth_part_count, sizeof *left), *other_left = mem_array(f->smooth_part_count, sizeof *other_left);
	double *part_area = mem_array(f->smooth_part_count, sizeof *part_area);
	unsigned char *is_taken = mem_array(f->smooth_part_count, 1), *is_sure = mem_array(f->smooth_part_count, 1);
	unsigned char *is_open = mem_array(f->smooth_part_count, 1);
	size_t *part_triangles = mem_array(f->smooth_part_count, sizeof *part_triangles);
	for (size_t t = 0; t < f->triangle_count; t++) {
		part_area[f->smooth_part[t]] += f->area[t];
		part_triangles[f->smooth_part[t]]++;
	}
	unsigned char *level = mem_array(f->smooth_part_count, 1), *trial_level = mem_array(f->smooth_part_count, 1);
	*report = (struct primitives_report){0};
	memcpy(report->distance, level_distance, sizeof level_distance);
	if (options->distance > 0)
		report->distance[0] = options->distance;
	segment_at(r, report->distance[0], options->least_area);
	for (int l = 1; l < PRIMITIVES_LEVELS && !(options->distance > 0); l++) {
		struct regions trial;
		bool is_any = false;
		part_costs(cost, left, r, level, report->distance);
		regions_init(&trial, f);
		/* faces of many triangles each that explain all at the closest tolerance are the part's faces, however many they are: one look
		 * further is enough */
		for (size_t p = 0; p < f->smooth_part_count; p++) {
			is_sure[p] = level[p] == 0 && left[p] < LOSS_MOST * part_area[p] && (double)part_triangles[p] > SURE_TRIANGLES * cost[p];
			is_open[p] = cost[p] > (level[p] > 0 ? WHOLE_COST : CLEAN_COST) && (l < 2 || !is_sure[p]);
		}
		const struct dense_patch none = {.kind = PATCH_FREE};
		const idx_t outside = regions_add(&trial, &none);
		for (size_t t = 0; t < f->triangle_count; t++) {
			const idx_t p = f->smooth_part[t];
			trial.label[t] = is_open[p] ? NO_INDEX : outside;
			is_any = is_any || is_open[p];
		}
		if (is_any) {
			segment_at(&trial, level_distance[l], options->least_area);
			memset(trial_level, l, f->smooth_part_count);
			part_costs(other, other_left, &trial, trial_level, report->distance);
			const size_t offset = r->count;
			for (size_t i = 0; i < trial.count; i++)
				regions_add(r, &trial.patch[i]);
			/* compared with the best so far, whatever its level; a wider tolerance must not explain less */
			for (size_t p = 0; p < f->smooth_part_count; p++)
				is_taken[p] = is_open[p] && other[p] < (is_sure[p] ? SURE_GAIN : level_gain[l]) * cost[p] &&
				              other_left[p] <= left[p] + LOSS_MOST * part_area[p];
			for (size_t t = 0; t < f->triangle_count; t++)
				if (is_taken[f->smooth_part[t]])
					r->label[t] = (idx_t)offset + trial.label[t];
			for (size_t p = 0; p < f->smooth_part_count; p++)
				if (is_taken[p])
					level[p] = (unsigned char)l;
		}
		regions_free(&trial);
		regions_renumber(r);
	}
	whole_free_parts(r, cost, level, report->distance);
	faceted_parts(r);
	absorb_specks(r, level, report->distance, options->least_area * f->total_area);
	regions_renumber(r);
	tidy_measure(r, 0);
	double free_area = 0, squares = 0, explained = 0;
	for (size_t t = 0; t < f->triangle_count; t++) {
		const struct dense_patch *p = &r->patch[r->label[t]];
		const double share = f->area[t] / f->total_area;
		report->area_share[level[f->smooth_part[t]]] += share;
		if (p->kind == PATCH_FREE) {
			free_area += share;
			continue;
		}
		for (int k = 0; k < 3; k++) {
			const double d = primitive_distance(p, f->xyz + 3 * f->triangle[3 * t + k]);
			squares += d * d;
		}
		explained += 3;
	}
	report->free_share = free_area;
	report->noise = explained > 0 ? sqrt(squares / explained) : 0;
	free(cost);
	free(other);
	free(level);
	free(trial_level);
	free(left);
	free(other_left);
	free(part_area);
	free(part_triangles);
	free(is_taken);
	free(is_sure);
	free(is_open);
}
