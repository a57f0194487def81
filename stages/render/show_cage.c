/* Cages: the control mesh, or the surface that it stands for. */
#include <stdlib.h>

#include "stages/geometry/subdivide.h"
#include "stages/geometry/triangulate.h"
#include "stages/geometry/vector.h"
#include "stages/render/show.h"

/* Refined surfaces bend little between neighbours, and their creases are known. */
#define CREASE_DEG 50

static const struct colour plain = {186, 198, 210}, thin = {70, 75, 80};
static const struct colour crease = {20, 20, 24}, border = {10, 130, 60}, corner_dot = {215, 30, 40};

/* A polygon mesh with creases: what both a cage and a refined level give. */
struct polygons {
	const double *xyz;
	size_t vertex_count, face_count;
	const idx_t *corner;
	const size_t *face_start;
};

static struct colour face_colour(const struct cage *cage, size_t face, enum colouring colouring)
{
	return colouring == COLOUR_AUTO || colouring == COLOUR_PATCH ? palette_patch((size_t)cage->face_patch[face]) : plain;
}

/* Set the surface, coloured by patch; face_origin NULL: the faces are the cage's own. */
static void set_faces(struct scene *scene, const struct polygons *polygons, const struct cage *cage, const idx_t *face_origin,
                      enum colouring colouring)
{
	size_t triangle_count;
	idx_t *face;
	idx_t *triangle = triangulate_mesh(&triangle_count, &face, polygons->xyz, polygons->corner, polygons->face_start, polygons->face_count);
	scene_set_surface(scene, polygons->xyz, polygons->vertex_count, triangle, triangle_count, plain);
	for (size_t c = 0; c < 3 * triangle_count; c++) {
		const size_t f = (size_t)face[c / 3];
		scene->colour[c] = face_colour(cage, face_origin != NULL ? (size_t)face_origin[f] : f, colouring);
	}
	free(triangle);
	free(face);
}

static int compare_keys(const void *a, const void *b)
{
	const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* The edge from corner c of face f to the next corner: lower vertex << 32 | higher. */
static uint64_t side_key(const struct polygons *polygons, size_t f, size_t c)
{
	const uint64_t a = (uint64_t)polygons->corner[c];
	const uint64_t b = (uint64_t)polygons->corner[c + 1 < polygons->face_start[f + 1] ? c + 1 : polygons->face_start[f]];
	return a < b ? a << 32 | b : b << 32 | a;
}

/* Edges of one face only. */
static void add_borders(struct scene *scene, const struct polygons *polygons, float width)
{
	const size_t count = polygons->face_start[polygons->face_count];
	uint64_t *key = mem_array(count, sizeof *key);
	for (size_t f = 0; f < polygons->face_count; f++)
		for (size_t c = polygons->face_start[f]; c < polygons->face_start[f + 1]; c++)
			key[c] = side_key(polygons, f, c);
	qsort(key, count, sizeof *key, compare_keys);
	for (size_t i = 0; i < count; i++)
		if ((i == 0 || key[i] != key[i - 1]) && (i + 1 == count || key[i] != key[i + 1]))
			scene_add_line(scene, polygons->xyz + 3 * (size_t)(key[i] >> 32), polygons->xyz + 3 * (size_t)(key[i] & 0xffffffffu), border,
			               width);
	free(key);
}

/* Drawn as it is, whether or not it could be refined: pictures are for finding mistakes. */
static void show_control(struct scene *scene, const struct cage *cage, enum colouring colouring)
{
	const struct polygons polygons = {cage->xyz, cage->vertex_count, cage->face_count, cage->face_corner, cage->face_start};
	set_faces(scene, &polygons, cage, NULL, colouring);
	scene_add_edges(scene, cage->xyz, cage->face_corner, cage->face_start, cage->face_count, thin, 0.9f);
	if (cage->net == NULL) /* the borders of local cages are the curves of the network */
		add_borders(scene, &polygons, 3.0f);
	for (size_t e = 0; e < cage->sharp_count; e++)
		scene_add_line(scene, cage->xyz + 3 * (size_t)cage->sharp[2 * e], cage->xyz + 3 * (size_t)cage->sharp[2 * e + 1], crease, 2.6f);
	for (size_t v = 0; v < cage->vertex_count; v++)
		if (cage->net != NULL)
			continue; /* drawn with the network */
		else if (cage->corner[v])
			scene_add_dot(scene, cage->xyz + 3 * v, corner_dot, 4.0f, false);
		else
			scene_add_dot(scene, cage->xyz + 3 * v, (struct colour){90, 90, 100}, 1.8f, false);
}

static void show_level(struct scene *scene, const struct level *level, const struct cage *cage, const struct show_options *options)
{
	const struct polygons polygons = {level->xyz, level->vertex_count, level->face_count, level->face_corner, level->face_start};
	set_faces(scene, &polygons, cage, level->face_origin, options->colouring);
	/* The sharp sides of all faces: inner creases come twice; borders, which are sharp by themselves, once. */
	const size_t corner_count = level->face_start[level->face_count];
	uint64_t *key = mem_array(corner_count, sizeof *key);
	idx_t *sharp = mem_array(corner_count + 1, sizeof *sharp);
	size_t key_count = 0, sharp_count = 0;
	for (size_t f = 0; f < level->face_count; f++)
		for (size_t c = level->face_start[f]; c < level->face_start[f + 1]; c++)
			if (level->sharp[c])
				key[key_count++] = side_key(&polygons, f, c);
	qsort(key, key_count, sizeof *key, compare_keys);
	for (size_t i = 1; i < key_count; i++)
		if (key[i] == key[i - 1]) {
			const idx_t a = (idx_t)(key[i] >> 32), b = (idx_t)(key[i] & 0xffffffffu);
			scene_add_line(scene, level->xyz + 3 * (size_t)a, level->xyz + 3 * (size_t)b, crease, 1.8f);
			sharp[2 * sharp_count] = a;
			sharp[2 * sharp_count + 1] = b;
			sharp_count++;
		}
	free(key);
	scene_smooth(scene, CREASE_DEG, sharp, sharp_count);
	free(sharp);
	if (options->edges)
		scene_add_edges(scene, level->xyz, level->face_corner, level->face_start, level->face_count, thin, 0.7f);
	if (cage->net == NULL)
		add_borders(scene, &polygons, 2.4f);
	for (size_t v = 0; v < level->vertex_count && cage->net == NULL; v++)
		if (level->corner[v])
			scene_add_dot(scene, level->xyz + 3 * v, corner_dot, 3.0f, false);
}

bool show_cage(struct scene *scene, const struct cage *cage, const char *shown, const struct show_options *options, struct fault *fault)
{
	if (options->colouring == COLOUR_CURVATURE)
		return fault_set(fault, EX_BAD_INPUT, "%s: a cage has no curvatures to colour by", shown);
	if (options->level == 0) {
		show_control(scene, cage, options->colouring);
		return true;
	}
	struct fault inner = {0};
	struct level first, last;
	if (!level_from_cage(&first, cage, &inner))
		return fault_set(fault, inner.code, "%s: %s", shown, inner.text);
	level_refine(&last, &first, cage->scheme, options->level);
	level_to_limit(&last, cage->scheme);
	show_level(scene, &last, cage, options);
	level_free(&first);
	level_free(&last);
	return true;
}
