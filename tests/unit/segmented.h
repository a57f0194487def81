/* Sample parts with their dense meshes and true faces, and how well two partitions agree, for the tests of segment. */
#ifndef CAGEWRIGHT_SEGMENTED_H
#define CAGEWRIGHT_SEGMENTED_H

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "formats/memory.h"
#include "stages/curv/curvature.h"
#include "stages/geometry/vector.h"
#include "stages/segment/region_tidy.h"
#include "stages/segment/segment_classic.h"
#include "stages/segment/segment_primitives.h"
#include "tests/fixtures/parts.h"

/* cmocka 1.1.5 compares floats as float. */
#define assert_near(actual, wanted, tolerance)                                                                               \
	do {                                                                                                                 \
		const double actual_ = (actual), wanted_ = (wanted), tolerance_ = (tolerance);                               \
		if (!(fabs(actual_ - wanted_) <= tolerance_))                                                                \
			fail_msg("%s = %.17g, wanted %.17g within %g", #actual, actual_, wanted_, tolerance_);               \
	} while (0)

struct segmented {
	struct dense dense;
	struct facets facets;
	struct regions regions;
	idx_t *truth;             /* true face of each triangle; NULL for meshes that are no sample part */
	struct solid_face *face;
	size_t face_count;
};

static inline void segmented_free(struct segmented *s)
{
	regions_free(&s->regions);
	facets_free(&s->facets);
	dense_free(&s->dense);
	free(s->truth);
	free(s->face);
}

/* The dense mesh as curv makes it, not yet segmented. */
static inline void segmented_dense(struct segmented *s, const double *xyz, size_t vertices, const idx_t *triangle, size_t triangles)
{
	struct mesh mesh = {.xyz = mem_copy(xyz, 3 * vertices, sizeof *xyz), .vertex_count = vertices, .corner = mem_copy(triangle, 3 * triangles, sizeof *triangle),
	                    .face_start = mem_array(triangles + 1, sizeof *mesh.face_start), .face_count = triangles};
	struct fault fault = {0};
	const struct curvature_options options = {.sharp = {.angle_rad = 40 / DEGREES}};
	for (size_t t = 0; t <= triangles; t++)
		mesh.face_start[t] = 3 * t;
	*s = (struct segmented){0};
	if (!curvature_compute(&s->dense, NULL, &mesh, NULL, 0, &options, &fault))
		fail_msg("%s", fault.text);
	mesh_free(&mesh);
	facets_build(&s->facets, &s->dense);
	regions_init(&s->regions, &s->facets);
}

static inline void segmented_part(struct segmented *s, const char *name, const struct part_options *options)
{
	struct solid solid;
	if (!part_make(&solid, name, options))
		fail_msg("no part %s", name);
	idx_t *triangle = mem_array(3 * solid.triangle_count, sizeof *triangle);
	for (size_t i = 0; i < 3 * solid.triangle_count; i++)
		triangle[i] = (idx_t)solid.triangle[i];
	segmented_dense(s, solid.xyz, solid.vertex_count, triangle, solid.triangle_count);
	s->truth = mem_array(solid.triangle_count, sizeof *s->truth);
	for (size_t t = 0; t < solid.triangle_count; t++)
		s->truth[t] = (idx_t)solid.triangle_face[t];
	s->face = mem_copy(solid.face, solid.face_count, sizeof *solid.face);
	s->face_count = solid.face_count;
	free(triangle);
	solid_free(&solid);
}

#define SEGMENTED_CLASSIC ((struct classic_options){.stop = 0.25, .least_area = 5e-4, .charts_most = 60, .distance = 5e-5})

/* What bin/segment does by default. */
static inline struct primitives_report segmented_run(struct segmented *s)
{
	struct primitives_report report;
	segment_primitives(&s->regions, &(struct primitives_options){.least_area = 5e-4}, &report);
	segment_free(&s->regions, &s->dense, &SEGMENTED_CLASSIC);
	regions_renumber(&s->regions);
	tidy_measure(&s->regions, 0);
	return report;
}

/* Adjusted Rand index of two partitions of the triangles weighted by area (Hubert, Arabie 1985): 1 when they are equal. */
static inline double segmented_rand(const struct segmented *s, const idx_t *a, const idx_t *b)
{
	size_t n = s->facets.triangle_count, na = 0, nb = 0;
	for (size_t t = 0; t < n; t++) {
		na = (size_t)a[t] >= na ? (size_t)a[t] + 1 : na;
		nb = (size_t)b[t] >= nb ? (size_t)b[t] + 1 : nb;
	}
	double *both = mem_array(na * nb, sizeof *both), *in_a = mem_array(na, sizeof *in_a), *in_b = mem_array(nb, sizeof *in_b);
	double sum = 0, sum_a = 0, sum_b = 0, total = 0;
	for (size_t t = 0; t < n; t++) {
		const double area = s->facets.area[t];
		both[(size_t)a[t] * nb + (size_t)b[t]] += area;
		in_a[a[t]] += area;
		in_b[b[t]] += area;
		total += area;
	}
	for (size_t i = 0; i < na * nb; i++)
		sum += both[i] * both[i];
	for (size_t i = 0; i < na; i++)
		sum_a += in_a[i] * in_a[i];
	for (size_t i = 0; i < nb; i++)
		sum_b += in_b[i] * in_b[i];
	free(both);
	free(in_a);
	free(in_b);
	const double expected = sum_a * sum_b / (total * total), most = (sum_a + sum_b) / 2;
	return most - expected > 1e-12 * total * total ? (sum - expected) / (most - expected) : 1;
}

/* Every label is used, first occurrences rise by one, every region is connected over edges. */
static inline void segmented_assert_sound(const struct segmented *s)
{
	const struct facets *f = &s->facets;
	const struct regions *r = &s->regions;
	idx_t next = 0, *queue = mem_array(f->triangle_count, sizeof *queue);
	unsigned char *is_seen = mem_array(f->triangle_count, 1), *is_begun = mem_array(r->count, 1);
	for (size_t t = 0; t < f->triangle_count; t++) {
		assert_in_range(r->label[t], 0, next);
		next += r->label[t] == next;
		if (is_seen[t])
			continue;
		assert_false(is_begun[r->label[t]]); /* a second part of the same region */
		is_begun[r->label[t]] = 1;
		size_t head = 0, tail = 0;
		queue[tail++] = (idx_t)t;
		is_seen[t] = 1;
		while (head < tail) {
			const idx_t at = queue[head++];
			for (int k = 0; k < 3; k++) {
				const idx_t to = f->neighbour[3 * at + k];
				if (to == NO_INDEX || is_seen[to] || r->label[to] != r->label[t])
					continue;
				is_seen[to] = 1;
				queue[tail++] = to;
			}
		}
	}
	assert_int_equal(next, r->count);
	double area = 0;
	for (size_t i = 0; i < r->count; i++)
		area += r->patch[i].area;
	assert_near(area / f->total_area, 1, 1e-9);
	free(queue);
	free(is_seen);
	free(is_begun);
}

#endif
