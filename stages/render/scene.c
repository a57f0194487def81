#include "stages/render/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/vector.h"

void scene_free(struct scene *scene)
{
	free(scene->xyz);
	free(scene->triangle);
	free(scene->normal);
	free(scene->colour);
	free(scene->line);
	free(scene->dot);
	*scene = (struct scene){0};
}

static const double *corner_point(const struct scene *scene, size_t t, int k)
{
	return scene->xyz + 3 * (size_t)scene->triangle[3 * t + k];
}

void scene_set_surface(struct scene *scene, const double *xyz, size_t vertex_count, const idx_t *triangle, size_t triangle_count,
                       struct colour colour)
{
	free(scene->xyz);
	free(scene->triangle);
	free(scene->normal);
	free(scene->colour);
	scene->vertex_count = vertex_count;
	scene->triangle_count = triangle_count;
	scene->xyz = mem_copy(xyz, 3 * vertex_count, sizeof *xyz);
	scene->triangle = mem_copy(triangle, 3 * triangle_count, sizeof *triangle);
	scene->normal = mem_array(9 * triangle_count, sizeof *scene->normal);
	scene->colour = mem_array(3 * triangle_count, sizeof *scene->colour);
	for (size_t t = 0; t < triangle_count; t++) {
		double n[3];
		area_vector3(n, corner_point(scene, t, 0), corner_point(scene, t, 1), corner_point(scene, t, 2));
		normalise3(n);
		for (int k = 0; k < 3; k++) {
			scene->colour[3 * t + k] = colour;
			for (int i = 0; i < 3; i++)
				scene->normal[9 * t + 3 * k + i] = (float)n[i];
		}
	}
}

void scene_add_line(struct scene *scene, const double from[3], const double to[3], struct colour colour, float width)
{
	if (scene->line_count == scene->line_room) {
		scene->line_room = scene->line_room > 0 ? 2 * scene->line_room : 256;
		scene->line = mem_resize(scene->line, scene->line_room, sizeof *scene->line);
	}
	struct scene_line *line = &scene->line[scene->line_count++];
	copy3(line->from, from);
	copy3(line->to, to);
	line->colour = colour;
	line->width = width;
}

void scene_add_dot(struct scene *scene, const double centre[3], struct colour colour, float radius, bool is_ring)
{
	if (scene->dot_count == scene->dot_room) {
		scene->dot_room = scene->dot_room > 0 ? 2 * scene->dot_room : 64;
		scene->dot = mem_resize(scene->dot, scene->dot_room, sizeof *scene->dot);
	}
	struct scene_dot *dot = &scene->dot[scene->dot_count++];
	copy3(dot->centre, centre);
	dot->colour = colour;
	dot->radius = radius;
	dot->is_ring = is_ring;
}

/* An edge with the corner that it starts from; sorting brings the sides of one edge together. */
struct side {
	uint64_t key;     /* lower vertex << 32 | higher */
	size_t corner;
};

static int compare_sides(const void *a, const void *b)
{
	const struct side *x = a, *y = b;
	if (x->key != y->key)
		return x->key < y->key ? -1 : 1;
	return (x->corner > y->corner) - (x->corner < y->corner);
}

static uint64_t edge_key(idx_t a, idx_t b)
{
	return a < b ? (uint64_t)a << 32 | (uint64_t)b : (uint64_t)b << 32 | (uint64_t)a;
}

static struct side *sorted_sides(const struct scene *scene)
{
	const size_t corner_count = 3 * scene->triangle_count;
	struct side *side = mem_array(corner_count, sizeof *side);
	for (size_t c = 0; c < corner_count; c++)
		side[c] = (struct side){edge_key(scene->triangle[c], scene->triangle[c % 3 == 2 ? c - 2 : c + 1]), c};
	qsort(side, corner_count, sizeof *side, compare_sides);
	return side;
}

static int compare_keys(const void *a, const void *b)
{
	const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

static size_t find_root(size_t *parent, size_t i)
{
	while (parent[i] != i)
		i = parent[i] = parent[parent[i]];
	return i;
}

static void unite(size_t *parent, size_t a, size_t b)
{
	a = find_root(parent, a);
	b = find_root(parent, b);
	if (a != b)
		parent[a < b ? b : a] = a < b ? a : b;
}

/* The corner of triangle t at vertex v. */
static size_t corner_at(const struct scene *scene, size_t t, idx_t v)
{
	const idx_t *corner = scene->triangle + 3 * t;
	return 3 * t + (corner[0] == v ? 0 : corner[1] == v ? 1 : 2);
}

static void join_across_edges(size_t *parent, const struct scene *scene, const double *face_normal, double crease_deg,
                              const uint64_t *sharp, size_t sharp_count)
{
	const size_t corner_count = 3 * scene->triangle_count;
	struct side *side = sorted_sides(scene);
	for (size_t i = 0, j; i < corner_count; i = j) {
		for (j = i + 1; j < corner_count && side[j].key == side[i].key; j++)
			;
		if (j - i != 2) /* a border, or sheets that cross: no smooth way over */
			continue;
		const size_t s = side[i].corner / 3, t = side[i + 1].corner / 3;
		if (s == t || angle3(face_normal + 3 * s, face_normal + 3 * t) * DEGREES > crease_deg)
			continue;
		if (sharp_count > 0 && bsearch(&side[i].key, sharp, sharp_count, sizeof *sharp, compare_keys) != NULL)
			continue;
		const idx_t ends[2] = {(idx_t)(side[i].key >> 32), (idx_t)(side[i].key & 0xffffffffu)};
		for (int k = 0; k < 2; k++)
			unite(parent, corner_at(scene, s, ends[k]), corner_at(scene, t, ends[k]));
	}
	free(side);
}

void scene_smooth(struct scene *scene, double crease_deg, const idx_t *sharp, size_t sharp_count)
{
	const size_t corner_count = 3 * scene->triangle_count;
	double *face_normal = mem_array(corner_count, sizeof *face_normal);
	double *sum = mem_array(3 * corner_count, sizeof *sum);
	size_t *parent = mem_array(corner_count, sizeof *parent);
	uint64_t *sharp_key = mem_array(sharp_count, sizeof *sharp_key);
	for (size_t i = 0; i < sharp_count; i++)
		sharp_key[i] = edge_key(sharp[2 * i], sharp[2 * i + 1]);
	qsort(sharp_key, sharp_count, sizeof *sharp_key, compare_keys);
	for (size_t t = 0; t < scene->triangle_count; t++) {
		area_vector3(face_normal + 3 * t, corner_point(scene, t, 0), corner_point(scene, t, 1), corner_point(scene, t, 2));
		normalise3(face_normal + 3 * t);
	}
	for (size_t c = 0; c < corner_count; c++)
		parent[c] = c;
	join_across_edges(parent, scene, face_normal, crease_deg, sharp_key, sharp_count);

	for (size_t t = 0; t < scene->triangle_count; t++)
		for (int k = 0; k < 3; k++) {
			double u[3], v[3];
			sub3(u, corner_point(scene, t, (k + 1) % 3), corner_point(scene, t, k));
			sub3(v, corner_point(scene, t, (k + 2) % 3), corner_point(scene, t, k));
			add_scaled3(sum + 3 * find_root(parent, 3 * t + k), angle3(u, v), face_normal + 3 * t);
		}
	for (size_t c = 0; c < corner_count; c++) {
		double n[3];
		copy3(n, sum + 3 * find_root(parent, c));
		if (normalise3(n) > 0)
			for (int i = 0; i < 3; i++)
				scene->normal[3 * c + i] = (float)n[i];
	}
	free(face_normal);
	free(sum);
	free(parent);
	free(sharp_key);
}

void scene_add_edges(struct scene *scene, const double *xyz, const idx_t *corner, const size_t *face_start, size_t face_count,
                     struct colour colour, float width)
{
	const size_t count = face_start[face_count];
	uint64_t *key = mem_array(count, sizeof *key);
	for (size_t f = 0; f < face_count; f++)
		for (size_t c = face_start[f]; c < face_start[f + 1]; c++)
			key[c] = edge_key(corner[c], corner[c + 1 < face_start[f + 1] ? c + 1 : face_start[f]]);
	qsort(key, count, sizeof *key, compare_keys);
	for (size_t i = 0; i < count; i++)
		if (i == 0 || key[i] != key[i - 1])
			scene_add_line(scene, xyz + 3 * (size_t)(key[i] >> 32), xyz + 3 * (size_t)(key[i] & 0xffffffffu), colour, width);
	free(key);
}

void scene_add_label_borders(struct scene *scene, const idx_t *label, struct colour colour, float width)
{
	struct side *side = sorted_sides(scene);
	const size_t corner_count = 3 * scene->triangle_count;
	for (size_t i = 0; i + 1 < corner_count; i++)
		if (side[i].key == side[i + 1].key && label[side[i].corner / 3] != label[side[i + 1].corner / 3])
			scene_add_line(scene, scene->xyz + 3 * (size_t)(side[i].key >> 32), scene->xyz + 3 * (size_t)(side[i].key & 0xffffffffu), colour,
			               width);
	free(side);
}

void scene_add_features(struct scene *scene, double crease_deg, struct colour crease, struct colour border, struct colour crossing)
{
	struct side *side = sorted_sides(scene);
	const size_t corner_count = 3 * scene->triangle_count;
	for (size_t i = 0, j; i < corner_count; i = j) {
		for (j = i + 1; j < corner_count && side[j].key == side[i].key; j++)
			;
		double bend = 0;
		if (j - i == 2) {
			double n[2][3];
			for (int k = 0; k < 2; k++) {
				const size_t t = side[i + k].corner / 3;
				area_vector3(n[k], corner_point(scene, t, 0), corner_point(scene, t, 1), corner_point(scene, t, 2));
				normalise3(n[k]);
			}
			bend = angle3(n[0], n[1]) * DEGREES;
			if (bend <= crease_deg)
				continue;
		}
		scene_add_line(scene, scene->xyz + 3 * (size_t)(side[i].key >> 32), scene->xyz + 3 * (size_t)(side[i].key & 0xffffffffu),
		               j - i == 1 ? border : j - i == 2 ? crease : crossing, j - i == 2 ? 1.0f : 2.4f);
	}
	free(side);
}
