/* Colours by distance to another surface. */
#include <math.h>
#include <stdlib.h>

#include "formats/mesh.h"
#include "stages/geometry/nearest.h"
#include "stages/geometry/vector.h"
#include "stages/render/show.h"

/* Triangles are cut until their sides are about this share of the part ... */
#define PIECE 0.01
/* ... as long as there are not more than this many. */
#define PIECES_MOST 1000000
#define CUTS_MOST 64

static double longest_side(const struct scene *scene, size_t t)
{
	double longest = 0;
	for (int k = 0; k < 3; k++)
		longest = fmax(longest, distance3(scene->xyz + 3 * (size_t)scene->triangle[3 * t + k],
		                                  scene->xyz + 3 * (size_t)scene->triangle[3 * t + (k + 1) % 3]));
	return longest;
}

static size_t cuts(double longest, double piece)
{
	return longest > piece ? (size_t)fmin(CUTS_MOST, ceil(longest / piece)) : 1;
}

/* Put cuts * cuts small triangles in place of triangle t; normals run linearly. Returns how many. */
static size_t cut_triangle(struct scene *fine, size_t vertex, size_t first, const struct scene *scene, size_t t, size_t n)
{
	/* Rows of points from corner 0: row i has i + 1 points, point (i, j) = 0 + i/n (1 - 0) + j/n (2 - 1). */
	const size_t row0 = vertex;
	for (size_t i = 0; i <= n; i++)
		for (size_t j = 0; j <= i; j++, vertex++) {
			const double w[3] = {1 - (double)i / (double)n, (double)(i - j) / (double)n, (double)j / (double)n};
			for (int d = 0; d < 3; d++) {
				fine->xyz[3 * vertex + d] = 0;
				for (int k = 0; k < 3; k++)
					fine->xyz[3 * vertex + d] += w[k] * scene->xyz[3 * (size_t)scene->triangle[3 * t + k] + d];
			}
		}
	size_t done = first;
	for (size_t i = 0; i < n; i++)
		for (size_t j = 0; j < 2 * i + 1; j++, done++) {
			const size_t a = row0 + i * (i + 1) / 2 + j / 2, b = row0 + (i + 1) * (i + 2) / 2 + j / 2;
			idx_t *corner = fine->triangle + 3 * done;
			if (j % 2 == 0)
				corner[0] = (idx_t)a, corner[1] = (idx_t)b, corner[2] = (idx_t)(b + 1);
			else
				corner[0] = (idx_t)a, corner[1] = (idx_t)(b + 1), corner[2] = (idx_t)(a + 1);
			for (int k = 0; k < 3; k++) {
				const size_t at = (size_t)corner[k] - row0;
				size_t row = (size_t)((sqrt(8.0 * (double)at + 1) - 1) / 2);
				while (row * (row + 1) / 2 > at)
					row--;
				while ((row + 1) * (row + 2) / 2 <= at)
					row++;
				const size_t along = at - row * (row + 1) / 2;
				const double w[3] = {1 - (double)row / (double)n, (double)(row - along) / (double)n, (double)along / (double)n};
				double normal[3] = {0, 0, 0};
				for (int d = 0; d < 3; d++)
					for (int c = 0; c < 3; c++)
						normal[d] += w[c] * (double)scene->normal[9 * t + 3 * c + d];
				normalise3(normal);
				for (int d = 0; d < 3; d++)
					fine->normal[9 * done + 3 * k + d] = (float)normal[d];
			}
		}
	return done - first;
}

/* Cut the scene's long triangles into pieces. */
static void cut_surface(struct scene *scene, double side)
{
	double piece = PIECE * side;
	size_t triangle_count, vertex_count;
	for (int doublings = 0;; doublings++, piece *= 1.5) {
		triangle_count = vertex_count = 0;
		for (size_t t = 0; t < scene->triangle_count; t++) {
			const size_t n = cuts(longest_side(scene, t), piece);
			triangle_count += n * n;
			vertex_count += (n + 1) * (n + 2) / 2;
		}
		if (triangle_count <= PIECES_MOST || triangle_count == scene->triangle_count || doublings > 20)
			break;
	}
	if (triangle_count == scene->triangle_count)
		return;
	struct scene fine = {0};
	fine.xyz = mem_array(3 * vertex_count, sizeof *fine.xyz);
	fine.triangle = mem_array(3 * triangle_count, sizeof *fine.triangle);
	fine.normal = mem_array(9 * triangle_count, sizeof *fine.normal);
	for (size_t t = 0; t < scene->triangle_count; t++) {
		const size_t n = cuts(longest_side(scene, t), piece);
		fine.triangle_count += cut_triangle(&fine, fine.vertex_count, fine.triangle_count, scene, t, n);
		fine.vertex_count += (n + 1) * (n + 2) / 2;
	}
	free(scene->xyz);
	free(scene->triangle);
	free(scene->normal);
	free(scene->colour);
	scene->xyz = fine.xyz;
	scene->triangle = fine.triangle;
	scene->normal = fine.normal;
	scene->colour = mem_array(3 * triangle_count, sizeof *scene->colour);
	scene->vertex_count = vertex_count;
	scene->triangle_count = triangle_count;
}

/* Distances of all points to a tree; returns the index of the largest. */
static size_t measure(double *distance, const double *xyz, size_t count, const struct nearest *to)
{
#pragma omp parallel for schedule(dynamic, 512)
	for (size_t v = 0; v < count; v++)
		distance[v] = nearest_point(to, xyz + 3 * v, INFINITY, NULL).distance;
	size_t worst = 0;
	for (size_t v = 1; v < count; v++)
		if (distance[v] > distance[worst])
			worst = v;
	return worst;
}

/* Sum of the area vectors of the triangles with a corner there: which way the surface faces. */
static void facing(double normal[3], const double at[3], const double *xyz, const idx_t *triangle, size_t count)
{
	normal[0] = normal[1] = normal[2] = 0;
	for (size_t t = 0; t < count; t++) {
		const double *x[3];
		bool is_there = false;
		for (int k = 0; k < 3; k++) {
			x[k] = xyz + 3 * (size_t)triangle[3 * t + k];
			is_there = is_there || (x[k][0] == at[0] && x[k][1] == at[1] && x[k][2] == at[2]);
		}
		if (!is_there)
			continue;
		double area[3];
		area_vector3(area, x[0], x[1], x[2]);
		/* equal shares, whatever the size: the eye is to see all sides of an edge */
		if (normalise3(area) > 0)
			add_scaled3(normal, 1, area);
	}
	if (!(normalise3(normal) > 0))
		normal[2] = 1;
}

bool show_deviation(struct scene *scene, const struct trimesh *against, double top, struct show_worst *found, struct fault *fault)
{
	const double side = mesh_bounds(against->mesh.xyz, against->mesh.vertex_count, NULL, NULL);
	if (scene->triangle_count == 0)
		return fault_set(fault, EX_BAD_INPUT, "nothing to colour by deviation: the file has no faces");
	if (!(side > 0))
		return fault_set(fault, EX_BAD_INPUT, "the surface to compare with has no size");
	cut_surface(scene, side);
	struct nearest *to = nearest_new(against->mesh.xyz, against->mesh.vertex_count, against->triangle, against->triangle_count);
	double *distance = mem_array(scene->vertex_count, sizeof *distance);
	const size_t worst = measure(distance, scene->xyz, scene->vertex_count, to);
	nearest_free(to);

	/* The other way: what the shown surface lacks. */
	struct nearest *back = nearest_new(scene->xyz, scene->vertex_count, scene->triangle, scene->triangle_count);
	double *missing = mem_array(against->mesh.vertex_count, sizeof *missing);
	const size_t most_missing = measure(missing, against->mesh.xyz, against->mesh.vertex_count, back);
	nearest_free(back);
	const bool is_missing = missing[most_missing] > distance[worst];
	const double largest = is_missing ? missing[most_missing] : distance[worst];
	scene_add_dot(scene, is_missing ? against->mesh.xyz + 3 * most_missing : scene->xyz + 3 * worst, (struct colour){190, 0, 190}, 9, true);

	if (found) {
		*found = (struct show_worst){.distance = largest, .is_missing = is_missing};
		copy3(found->at, is_missing ? against->mesh.xyz + 3 * most_missing : scene->xyz + 3 * worst);
		if (is_missing)
			facing(found->normal, found->at, against->mesh.xyz, against->triangle, against->triangle_count);
		else
			facing(found->normal, found->at, scene->xyz, scene->triangle, scene->triangle_count);
		for (size_t v = 0; v < scene->vertex_count; v++)
			found->mean += distance[v] / (double)scene->vertex_count;
	}
	const double scale = top > 0 ? top : largest;
	for (size_t c = 0; c < 3 * scene->triangle_count; c++)
		scene->colour[c] = palette_scale(SCALE_HEAT, scale > 0 ? distance[scene->triangle[c]] / scale : 0);
	scene->has_legend = true;
	scene->legend_scale = SCALE_HEAT;
	scene->legend_low = 0;
	scene->legend_high = 100 * scale / side;
	scene->legend_unit = "%";
	free(distance);
	free(missing);
	return true;
}
