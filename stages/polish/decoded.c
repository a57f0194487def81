#include "stages/polish/decoded.h"

#include <stdlib.h>

#include "stages/geometry/deviation.h"
#include "stages/geometry/trimesh.h"
#include "stages/geometry/vector.h"

/* Triangles of quads by the shorter diagonal, as they are written for other programs. */
static idx_t *split_level(size_t *count, const struct level *level)
{
	idx_t *triangle = mem_array(3 * (level->face_start[level->face_count] - 2 * level->face_count), sizeof *triangle), *out = triangle;
	for (size_t f = 0; f < level->face_count; f++) {
		const idx_t *c = &level->face_corner[level->face_start[f]];
		const size_t degree = level->face_start[f + 1] - level->face_start[f];
		const double *x = level->xyz;
		size_t from = 0;
		if (degree == 4 && distance3(&x[3 * (size_t)c[1]], &x[3 * (size_t)c[3]]) < distance3(&x[3 * (size_t)c[0]], &x[3 * (size_t)c[2]]))
			from = 1;
		for (size_t i = 1; i + 1 < degree; i++)
			*out++ = c[from], *out++ = c[(from + i) % degree], *out++ = c[(from + i + 1) % degree];
	}
	*count = (size_t)(out - triangle) / 3;
	return triangle;
}

/* Does the mesh stay the surface that its faces say when it is written as single triangles of single-precision numbers? Points of different
 * faces that fall together open or join edges. */
static bool is_sound(const struct level *fine, const idx_t *triangle, size_t count, const double middle[3], double scale)
{
	struct fault fault = {0};
	struct mesh indexed = {.xyz = mem_copy(fine->xyz, 3 * fine->vertex_count, sizeof *fine->xyz), .vertex_count = fine->vertex_count, .face_count = count};
	struct mesh soup = {.xyz = mem_array(9 * count, sizeof *soup.xyz), .vertex_count = 3 * count, .face_count = count};
	indexed.corner = mem_copy(triangle, 3 * count, sizeof *triangle), soup.corner = mem_array(3 * count, sizeof *soup.corner);
	indexed.face_start = mem_array(count + 1, sizeof *indexed.face_start), soup.face_start = mem_array(count + 1, sizeof *soup.face_start);
	for (size_t i = 0; i < 3 * count; i++) {
		soup.corner[i] = (idx_t)i;
		for (int k = 0; k < 3; k++)
			soup.xyz[3 * i + k] = (double)(float)(middle[k] + scale * fine->xyz[3 * (size_t)triangle[i] + k]);
	}
	for (size_t f = 0; f <= count; f++)
		indexed.face_start[f] = soup.face_start[f] = 3 * f;
	struct trimesh a = {0}, b = {0};
	const bool is_read = trimesh_from_mesh(&a, &indexed, "", &fault) && trimesh_from_mesh(&b, &soup, "", &fault);
	const bool is_good = is_read && b.nonmanifold_count <= a.nonmanifold_count && b.open_count == a.open_count;
	trimesh_free(&a), trimesh_free(&b);
	return is_good;
}

/* The share of the area that looks away from the block of four faces that it lies in, or with that from the block's own block: what a fold-over
 * looks like from within. Children of a face follow each other; two levels are looked at, so that what bends by less than 180 degrees over a sixteenth
 * of a face is never taken for a fold. */
static double folded_share(const struct level *fine, const idx_t *triangle, size_t count, int level)
{
	enum { BLOCK = 4, PARENT = 16 };
	if (level < 2)
		return 0;
	double (*normal)[3] = mem_array(fine->face_count, sizeof *normal), folded = 0, area = 0;
	for (size_t t = 0, f = 0; t < count; f++)
		for (const size_t end = t + (fine->face_start[f + 1] - fine->face_start[f] - 2); t < end; t++) {
			double n[3];
			area_vector3(n, &fine->xyz[3 * (size_t)triangle[3 * t]], &fine->xyz[3 * (size_t)triangle[3 * t + 1]], &fine->xyz[3 * (size_t)triangle[3 * t + 2]]);
			add_scaled3(normal[f], 1, n);
			area += norm3(n);
		}
	size_t t = 0;
	for (size_t first = 0; first + PARENT <= fine->face_count; first += PARENT) {
		double parent[3] = {0}, block[PARENT / BLOCK][3] = {{0}};
		for (size_t f = 0; f < PARENT; f++)
			add_scaled3(block[f / BLOCK], 1, normal[first + f]), add_scaled3(parent, 1, normal[first + f]);
		for (size_t f = 0; f < PARENT; f++) {
			const bool is_block_folded = dot3(block[f / BLOCK], parent) < 0;
			for (const size_t end = t + (fine->face_start[first + f + 1] - fine->face_start[first + f] - 2); t < end; t++) {
				double n[3];
				area_vector3(n, &fine->xyz[3 * (size_t)triangle[3 * t]], &fine->xyz[3 * (size_t)triangle[3 * t + 1]], &fine->xyz[3 * (size_t)triangle[3 * t + 2]]);
				folded += is_block_folded || dot3(n, block[f / BLOCK]) < 0 ? norm3(n) : 0;
			}
		}
	}
	free(normal);
	return folded / area;
}

bool decoded_measure(struct decoded_errors *errors, const struct target *t, const struct cage *cage, int steps, const double middle[3], double scale,
                     bool takes_unsound)
{
	struct fault fault = {0};
	struct level level, fine;
	if (!level_from_cage(&level, cage, &fault))
		return false;
	for (size_t i = 0; i < 3 * level.vertex_count; i++)
		level.xyz[i] = (level.xyz[i] - middle[i % 3]) / scale;
	level_refine(&fine, &level, cage->scheme, steps);
	size_t count;
	idx_t *triangle = split_level(&count, &fine);
	const struct deviation_surface a = {t->xyz, t->vertex_count, t->triangle, t->triangle_count}, b = {fine.xyz, fine.vertex_count, triangle, count};
	const struct deviation_options options = DEVIATION_DEFAULTS; /* those of deviate(1), so that it says the same */
	struct deviation deviation;
	const bool is_measured = (takes_unsound || is_sound(&fine, triangle, count, middle, scale)) && deviation_measure(&deviation, &a, &b, &options, &fault);
	if (is_measured)
		*errors = (struct decoded_errors){deviation.both.mean / deviation.side, deviation.both.max / deviation.side, deviation.both.folded_share,
		                                  folded_share(&fine, triangle, count, steps)};
	free(triangle);
	level_free(&level), level_free(&fine);
	return is_measured;
}
