/* Pictures of known things: how much of the picture a cube covers, which side is seen, what is drawn of each kind of file. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <png.h>

#include "formats/cage.h"
#include "formats/dense.h"
#include "formats/network.h"
#include "stages/geometry/vector.h"
#include "stages/render/legend.h"
#include "stages/render/picture.h"
#include "stages/render/raster.h"
#include "stages/render/show.h"

static void assert_near(double got, double want, double tolerance)
{
	if (!(fabs(got - want) <= tolerance))
		fail_msg("%.17g is not within %g of %.17g", got, tolerance, want);
}

static const char cube_off[] =
	"OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
	"4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

static const struct show_options plain_options = {.colouring = COLOUR_AUTO};

static bool show_text(struct scene *scene, const char *text, const char *shown, const struct show_options *options, struct fault *fault)
{
	const struct input input = {.shown = shown, .data = (unsigned char *)(uintptr_t)text, .size = strlen(text)};
	*scene = (struct scene){0};
	return show_file(scene, &input, options, fault);
}

/* Write a document as the tools do and show it. */
static bool show_document(struct scene *scene, const struct ply *ply, const struct show_options *options, struct fault *fault)
{
	char *text = NULL;
	size_t size = 0;
	FILE *file = open_memstream(&text, &size);
	ply_write(file, ply);
	fclose(file);
	const bool done = show_text(scene, text, "part.ply", options, fault);
	free(text);
	return done;
}

static void cube_scene(struct scene *scene)
{
	struct fault fault = {0};
	if (!show_text(scene, cube_off, "cube.off", &plain_options, &fault))
		fail_msg("%s", fault.text);
}

static unsigned char *draw(const struct scene *scene, double azimuth, double elevation, int width, int height)
{
	const struct view view = {.azimuth_deg = azimuth, .elevation_deg = elevation, .width = width, .height = height};
	unsigned char *rgb;
	struct fault fault = {0};
	if (!raster_draw(&rgb, scene, &view, &fault))
		fail_msg("%s", fault.text);
	return rgb;
}

static bool is_white(const unsigned char *pixel)
{
	return pixel[0] == 255 && pixel[1] == 255 && pixel[2] == 255;
}

static double coverage(const unsigned char *rgb, int count)
{
	int covered = 0;
	for (int i = 0; i < count; i++)
		covered += !is_white(rgb + 3 * i);
	return (double)covered / count;
}

static int compare_ints(const void *a, const void *b)
{
	return *(const int *)a - *(const int *)b;
}

static int distinct_colours(const unsigned char *rgb, int count)
{
	int *value = mem_array((size_t)count, sizeof *value), distinct = 0;
	for (int i = 0; i < count; i++)
		value[i] = rgb[3 * i] << 16 | rgb[3 * i + 1] << 8 | rgb[3 * i + 2];
	qsort(value, (size_t)count, sizeof *value, compare_ints);
	for (int i = 0; i < count; i++)
		distinct += i == 0 || value[i] != value[i - 1];
	free(value);
	return distinct;
}

static void cube_from_its_sides(void **state)
{
	(void)state;
	/* Seen straight on, a cube is a square that fills the picture but for a rim of 4 % a side: 0.92^2 of it. */
	struct scene scene;
	cube_scene(&scene);
	const size_t line_count = scene.line_count;
	scene.line_count = 0; /* its edges would stand out by half their width */
	static const double eye[6][2] = {{0, 0}, {90, 0}, {180, 0}, {-90, 0}, {30, 90}, {0, -90}};
	for (int i = 0; i < 6; i++) {
		unsigned char *rgb = draw(&scene, eye[i][0], eye[i][1], 200, 200);
		/* At (30, 90) the square stands turned by 30 degrees and is smaller: its diagonal extent is cos 30 + sin 30. */
		const double wanted = i == 4 ? pow(0.92 / (cos(PI / 6) + sin(PI / 6)), 2) : 0.92 * 0.92;
		assert_near(coverage(rgb, 200 * 200), wanted, 0.012);
		free(rgb);
	}
	scene.line_count = line_count;
	/* Three-quarter views show three differently lit sides; a wide picture is filled by height. */
	unsigned char *rgb = draw(&scene, -60, 25, 400, 200);
	assert_true(distinct_colours(rgb, 400 * 200) > 8); /* three sides, lines, ground, and mixtures at their rims */
	assert_true(coverage(rgb, 400 * 200) > 0.25);
	assert_true(coverage(rgb, 400 * 200) < 0.5);
	/* The same scene gives the same bytes. */
	unsigned char *again = draw(&scene, -60, 25, 400, 200);
	assert_memory_equal(rgb, again, 400 * 200 * 3);
	free(rgb);
	free(again);
	scene_free(&scene);
}

static void right_way_round(void **state)
{
	(void)state;
	/* From the front (azimuth -90) x runs to the right and z up; from the side (azimuth 0) y runs to the right. */
	struct scene scene;
	for (int side = 0; side < 2; side++) {
		cube_scene(&scene);
		const double front[3] = {0.9, 0, 0.9}, beside[3] = {1, 0.9, 0.9};
		scene_add_dot(&scene, side == 0 ? front : beside, (struct colour){255, 0, 0}, 6, false);
		unsigned char *rgb = draw(&scene, side == 0 ? -90 : 0, 0, 200, 200);
		long sum_x = 0, sum_y = 0, count = 0;
		for (int i = 0; i < 200 * 200; i++)
			if (rgb[3 * i] > 200 && rgb[3 * i + 1] < 60 && rgb[3 * i + 2] < 60) {
				sum_x += i % 200;
				sum_y += i / 200;
				count++;
			}
		assert_true(count > 80);
		assert_near((double)sum_x / (double)count, 100 + 0.4 * 184, 1.5);
		assert_near((double)sum_y / (double)count, 100 - 0.4 * 184, 1.5);
		free(rgb);
		scene_free(&scene);
	}
}

static void zoomed_into_a_corner(void **state)
{
	(void)state;
	/* The cube's corner in the middle, seen from the right side: the cube covers the quarter to the left of and below it. */
	struct scene scene;
	cube_scene(&scene);
	scene.line_count = 0;
	const struct view view = {.width = 100, .height = 100, .zoom = 4, .has_centre = true, .centre = {1, 1, 1}};
	unsigned char *rgb;
	struct fault fault = {0};
	assert_true(raster_draw(&rgb, &scene, &view, &fault));
	assert_near(coverage(rgb, 100 * 100), 0.25, 0.012);
	assert_false(is_white(rgb + 3 * (99 * 100)));
	assert_true(is_white(rgb + 3 * 99));
	free(rgb);
	scene_free(&scene);
}

static void near_hides_far_and_inside_is_marked(void **state)
{
	(void)state;
	/* Two facing squares of an open box: the one towards the eye hides the other; from behind a surface shows its inside colour. */
	const double xyz[] = {0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, -1, 0, 0, -1, 1, 0, -1, 1, 1, -1, 0, 1};
	const idx_t near_first[] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
	struct scene scene = {0};
	scene_set_surface(&scene, xyz, 8, near_first, 4, (struct colour){0, 200, 0});
	for (int c = 6; c < 12; c++)
		scene.colour[c] = (struct colour){0, 0, 200};
	unsigned char *rgb = draw(&scene, 0, 0, 64, 64);
	const unsigned char *middle = rgb + 3 * (32 * 64 + 32);
	assert_true(middle[1] > 100 && middle[0] == 0 && middle[2] == 0);
	free(rgb);
	rgb = draw(&scene, 180, 0, 64, 64);
	middle = rgb + 3 * (32 * 64 + 32);
	assert_true(middle[0] > middle[1] && middle[0] > middle[2]); /* reddish */
	free(rgb);
	scene_free(&scene);
}

static void nothing_and_one_point(void **state)
{
	(void)state;
	struct scene scene = {0};
	unsigned char *rgb = draw(&scene, 0, 0, 32, 16);
	assert_near(coverage(rgb, 32 * 16), 0, 0);
	free(rgb);
	const double there[3] = {1e30, -1e30, 0};
	scene_add_dot(&scene, there, (struct colour){255, 0, 0}, 4, false);
	rgb = draw(&scene, 0, 0, 32, 16);
	assert_true(coverage(rgb, 32 * 16) > 0.05);
	free(rgb);
	scene_free(&scene);
}

static void smooth_normals_stop_at_creases(void **state)
{
	(void)state;
	/* Cube corners keep the three normals of their faces; with all edges smooth (limit 100 degrees) they are the diagonal. */
	struct scene scene;
	cube_scene(&scene);
	for (size_t c = 0; c < 3 * scene.triangle_count; c++) {
		const float *n = scene.normal + 3 * c;
		assert_near(fabs(n[0]) + fabs(n[1]) + fabs(n[2]), 1, 1e-6);
	}
	scene_smooth(&scene, 100, NULL, 0);
	for (size_t c = 0; c < 3 * scene.triangle_count; c++)
		for (int k = 0; k < 3; k++)
			assert_near(fabs(scene.normal[3 * c + k]), 1 / sqrt(3), 1e-6);
	/* One edge listed as sharp, 0-1 between bottom and front: around it a fan of one end still joins both sides over the third face. */
	const idx_t sharp[] = {0, 1, 0, 2, 0, 4};
	scene_smooth(&scene, 100, sharp, 3);
	for (size_t c = 0; c < 3 * scene.triangle_count; c++)
		if (scene.triangle[c] == 0) {
			const float *n = scene.normal + 3 * c;
			assert_near(fabs(n[0]) + fabs(n[1]) + fabs(n[2]), 1, 1e-6);
		}
	scene_free(&scene);
}

static void labels_and_features(void **state)
{
	(void)state;
	struct scene scene;
	cube_scene(&scene); /* draws the twelve edges of the cube, but not the six diagonals */
	assert_int_equal(scene.line_count, 12);
	idx_t label[12];
	for (int t = 0; t < 12; t++)
		label[t] = t / 2 == 0; /* the bottom alone */
	scene_add_label_borders(&scene, label, (struct colour){0, 0, 0}, 1);
	assert_int_equal(scene.line_count, 12 + 4);
	scene_free(&scene);
	const struct show_options edges = {.edges = true};
	struct fault fault = {0};
	assert_true(show_text(&scene, cube_off, "cube.off", &edges, &fault));
	assert_int_equal(scene.line_count, 12 + 12); /* quads: no diagonals */
	scene_free(&scene);
}

/* A network of one closed curve of four points and one open one of two. */
static void make_network(struct ply *ply)
{
	double xyz[] = {3, 0, 0, 0, 3, 0, -3, 0, 0, 0, -3, 0, 0, 0, 1, 0, 0, 2};
	unsigned char kind[] = {2, 2, 2, 2, 0, 1};
	idx_t point[] = {0, 1, 2, 3, 4, 5};
	struct curve curve[2] = {{0, 1, CURVE_SMOOTH, true, 0, 4, 0.1, 0}, {1, 0, CURVE_SHARP, false, 4, 2, 0, 0}};
	const struct network network = {.vertex_count = 6, .curve_count = 2, .point_count = 6, .xyz = xyz, .kind = kind, .curve = curve, .point = point};
	for (int c = 0; c < 2; c++)
		curve[c].length = network_curve_length(&network, &curve[c]);
	ply_init(ply);
	network_to_ply(ply, &network, "vertex");
}

static void network_is_drawn_as_smooth_curves(void **state)
{
	(void)state;
	struct ply ply;
	struct scene scene;
	struct fault fault = {0};
	make_network(&ply);
	if (!show_document(&scene, &ply, &plain_options, &fault))
		fail_msg("%s", fault.text);
	assert_int_equal(scene.triangle_count, 0);
	assert_int_equal(scene.dot_count, 6);
	/* Control polygons of 4 and 1 sides; curves of 4 and 1 spans in 12 pieces each. */
	assert_int_equal(scene.line_count, 5 + 5 * 12);
	/* The limit of (3, 0, 0) between (0, -3, 0) and (0, 3, 0) is (1, 4, 1) / 6 of them: x = 2. All of the curve lies between the
	 * inscribed and the circumscribed circle of its limits, far inside the control polygon's corners. */
	double most = 0;
	for (size_t i = 5; i < 5 + 4 * 12; i++)
		most = fmax(most, norm3(scene.line[i].from));
	assert_near(most, 2, 1e-12);
	assert_near(scene.line[5].from[0], 2, 1e-12);
	assert_near(distance3(scene.line[5 + 47].to, scene.line[5].from), 0, 1e-12); /* it closes */
	unsigned char *rgb = draw(&scene, -60, 25, 200, 150);
	assert_true(distinct_colours(rgb, 200 * 150) > 50);
	assert_true(coverage(rgb, 200 * 150) < 0.2);
	free(rgb);
	scene_free(&scene);
	ply_free(&ply);
}

static void make_cube_cage(struct ply *ply, bool is_sharp)
{
	double xyz[24];
	for (int i = 0; i < 24; i++)
		xyz[i] = i / 3 >> i % 3 & 1;
	idx_t corner[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
	size_t start[7];
	idx_t patch[6], sharp[24] = {0, 1, 0, 2, 0, 4, 1, 3, 1, 5, 2, 3, 2, 6, 3, 7, 4, 5, 4, 6, 5, 7, 6, 7};
	unsigned char flag[8] = {1};
	for (int f = 0; f <= 6; f++)
		start[f] = 4 * (size_t)f;
	for (int f = 0; f < 6; f++)
		patch[f] = f;
	const struct cage cage = {.scheme = SCHEME_QUADTRI, .xyz = xyz, .vertex_count = 8, .corner = flag, .face_corner = corner,
	                          .face_start = start, .face_patch = patch, .face_count = 6, .sharp = sharp, .sharp_count = is_sharp ? 12 : 0};
	ply_init(ply);
	cage_to_ply(ply, &cage);
}

static void cage_and_its_surface(void **state)
{
	(void)state;
	struct ply ply;
	struct scene scene;
	struct fault fault = {0};
	make_cube_cage(&ply, true);
	assert_true(show_document(&scene, &ply, &plain_options, &fault));
	assert_int_equal(scene.triangle_count, 12);
	assert_int_equal(scene.line_count, 12 + 12); /* control edges, and all are creases */
	assert_int_equal(scene.dot_count, 8);
	scene_free(&scene);
	/* All edges sharp: twice refined the surface is the cube itself, each of 12 creases in four pieces, six faces of 16 quads. */
	const struct show_options twice = {.level = 2};
	assert_true(show_document(&scene, &ply, &twice, &fault));
	assert_int_equal(scene.triangle_count, 6 * 16 * 2);
	assert_int_equal(scene.line_count, 12 * 4);
	assert_int_equal(scene.dot_count, 8);
	for (size_t i = 0; i < scene.line_count; i++)
		for (int k = 0; k < 3; k++)
			assert_true(scene.line[i].from[k] >= -1e-12 && scene.line[i].from[k] <= 1 + 1e-12);
	/* Six patches, six colours. */
	unsigned seen = 0;
	for (size_t t = 0; t < scene.triangle_count; t++)
		for (size_t p = 0; p < 6; p++) {
			const struct colour colour = palette_patch(p);
			if (memcmp(&scene.colour[3 * t], &colour, sizeof colour) == 0)
				seen |= 1u << p;
		}
	assert_int_equal(seen, 63);
	scene_free(&scene);
	ply_free(&ply);
	/* All smooth: rounded, smaller than the cube, no creases; the one explicit corner is where it was. */
	make_cube_cage(&ply, false);
	assert_true(show_document(&scene, &ply, &twice, &fault));
	assert_int_equal(scene.line_count, 0);
	assert_int_equal(scene.dot_count, 1);
	assert_near(norm3(scene.dot[0].centre), 0, 1e-12);
	scene_free(&scene);
	ply_free(&ply);
}

static void local_cages_have_corners_where_curves_end(void **state)
{
	(void)state;
	/* One square patch, its border four straight curves from corner to corner: the limit surface fills the square to its corners. Were
	 * they smooth border points, it would be rounded. */
	double xyz[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
	idx_t net[] = {0, 1, 2, 3}, corner[] = {0, 1, 2, 3}, patch[] = {0}, point[] = {0, 1, 1, 2, 2, 3, 3, 0};
	size_t start[] = {0, 4};
	unsigned char flag[4] = {0}, kind[4] = {POINT_CORNER, POINT_CORNER, POINT_JUNCTION, POINT_CORNER};
	struct curve curve[4];
	for (int c = 0; c < 4; c++)
		curve[c] = (struct curve){0, -1, CURVE_SHARP, false, 2 * (size_t)c, 2, 0, 1};
	const struct cage cage = {.xyz = xyz, .vertex_count = 4, .corner = flag, .net = net, .face_corner = corner, .face_start = start,
	                          .face_patch = patch, .face_count = 1};
	const struct network network = {.vertex_count = 4, .curve_count = 4, .point_count = 8, .xyz = xyz, .kind = kind, .curve = curve, .point = point};
	struct ply ply;
	ply_init(&ply);
	cage_to_ply(&ply, &cage);
	network_to_ply(&ply, &network, "netpoint");
	struct scene scene;
	struct fault fault = {0};
	const struct show_options thrice = {.level = 3};
	if (!show_document(&scene, &ply, &thrice, &fault))
		fail_msg("%s", fault.text);
	double area = 0;
	for (size_t t = 0; t < scene.triangle_count; t++) {
		double n[3];
		area_vector3(n, scene.xyz + 3 * scene.triangle[3 * t], scene.xyz + 3 * scene.triangle[3 * t + 1], scene.xyz + 3 * scene.triangle[3 * t + 2]);
		area += norm3(n) / 2;
	}
	assert_near(area, 1, 1e-9);
	assert_int_equal(scene.line_count, 4 + 4 * 12); /* control polygons and curves, no borders besides */
	assert_int_equal(scene.dot_count, 4);
	scene_free(&scene);
	/* A vertex that names a network point which is not there. */
	net[3] = 4;
	ply_free(&ply);
	ply_init(&ply);
	cage_to_ply(&ply, &cage);
	network_to_ply(&ply, &network, "netpoint");
	assert_false(show_document(&scene, &ply, &thrice, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	ply_free(&ply);
}

static void deviation_colours(void **state)
{
	(void)state;
	/* A cube against one that is 0.1 taller: the top is the farthest, the sides by less, and the ring is at the top. */
	char taller[sizeof cube_off];
	strcpy(taller, cube_off);
	struct scene scene, other;
	cube_scene(&scene);
	cube_scene(&other);
	struct mesh mesh = {.vertex_count = 8, .face_count = 12};
	mesh.xyz = mem_copy(other.xyz, 24, sizeof(double));
	for (int v = 4; v < 8; v++)
		mesh.xyz[3 * v + 2] = 1.1;
	mesh.corner = mem_copy(other.triangle, 36, sizeof(idx_t));
	mesh.face_start = mem_array(13, sizeof *mesh.face_start);
	for (size_t f = 0; f <= 12; f++)
		mesh.face_start[f] = 3 * f;
	struct trimesh against;
	struct fault fault = {0};
	assert_true(trimesh_from_mesh(&against, &mesh, "taller.off", &fault));
	struct show_worst worst;
	assert_true(show_deviation(&scene, &against, 0, &worst, &fault));
	/* both tops are 0.1 away from each other; the worst point is on one of them and faces up, if aslant at its rim */
	assert_near(worst.distance, 0.1, 1e-12);
	assert_true(worst.at[2] >= 1 && worst.normal[2] > 0.3);
	assert_near(norm3(worst.normal), 1, 1e-12);
	assert_true(worst.mean > 0 && worst.mean < 0.1);
	assert_true(scene.has_legend);
	assert_near(scene.legend_high, 100 * 0.1 / 1.1, 1e-9);
	assert_int_equal(scene.dot_count, 1);
	assert_true(scene.dot[0].is_ring);
	assert_true(scene.dot[0].centre[2] >= 1);
	const struct colour most = palette_scale(SCALE_HEAT, 1), none = palette_scale(SCALE_HEAT, 0);
	size_t top = 0, cold = 0;
	for (size_t c = 0; c < 3 * scene.triangle_count; c++) {
		const double *p = scene.xyz + 3 * scene.triangle[c];
		if (p[2] == 1 && p[0] > 0.2 && p[0] < 0.8 && p[1] > 0.2 && p[1] < 0.8) {
			assert_memory_equal(&scene.colour[c], &most, sizeof most);
			top++;
		}
		if (p[2] < 0.5) {
			assert_memory_equal(&scene.colour[c], &none, sizeof none);
			cold++;
		}
	}
	assert_true(top > 1000 && cold > 1000); /* two triangles became many */
	/* Cutting does not move the surface: the area is the cube's. */
	double area = 0;
	for (size_t t = 0; t < scene.triangle_count; t++) {
		double n[3];
		area_vector3(n, scene.xyz + 3 * scene.triangle[3 * t], scene.xyz + 3 * scene.triangle[3 * t + 1], scene.xyz + 3 * scene.triangle[3 * t + 2]);
		area += norm3(n) / 2;
	}
	assert_near(area, 6, 1e-9);
	trimesh_free(&against);
	scene_free(&scene);
	scene_free(&other);
}

static void faults(void **state)
{
	(void)state;
	struct scene scene;
	struct fault fault = {0};
	assert_false(show_text(&scene, "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nend_header\n1\n", "cut.ply", &plain_options, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_memory_equal(fault.text, "cut.ply", 7);
	fault = (struct fault){0};
	assert_false(show_text(&scene, "OFF\n1 0 0\n0 0 0\n", "empty.off", &plain_options, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	fault = (struct fault){0};
	const struct show_options patch = {.colouring = COLOUR_PATCH};
	assert_false(show_text(&scene, cube_off, "cube.off", &patch, &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_string_equal(fault.text, "cube.off: a plain mesh has no patches to colour by");
	fault = (struct fault){0};
	struct ply ply;
	make_cube_cage(&ply, true);
	const struct show_options curvature = {.colouring = COLOUR_CURVATURE};
	assert_false(show_document(&scene, &ply, &curvature, &fault));
	assert_string_equal(fault.text, "part.ply: a cage has no curvatures to colour by");
	ply_free(&ply);
}

static void png_reads_back(void **state)
{
	(void)state;
	struct scene scene;
	cube_scene(&scene);
	scene.has_legend = true;
	scene.legend_scale = SCALE_HEAT;
	scene.legend_high = 1.5;
	scene.legend_unit = "%";
	unsigned char *rgb = draw(&scene, -60, 25, 320, 240);
	const int before = distinct_colours(rgb, 320 * 240);
	legend_draw(rgb, 320, 240, &scene);
	assert_true(distinct_colours(rgb, 320 * 240) > before + 40);
	char *bytes = NULL;
	size_t size = 0;
	FILE *file = open_memstream(&bytes, &size);
	struct fault fault = {0};
	assert_true(picture_write(file, rgb, 320, 240, &fault));
	fclose(file);
	png_image image = {.version = PNG_IMAGE_VERSION};
	assert_true(png_image_begin_read_from_memory(&image, bytes, size));
	assert_int_equal(image.width, 320);
	assert_int_equal(image.height, 240);
	image.format = PNG_FORMAT_RGB;
	unsigned char *back = mem_array(PNG_IMAGE_SIZE(image), 1);
	assert_true(png_image_finish_read(&image, NULL, back, 0, NULL));
	assert_memory_equal(back, rgb, 320 * 240 * 3);
	free(back);
	free(bytes);
	free(rgb);
	/* A legend that does not fit is left out, and writes nowhere. */
	rgb = draw(&scene, 0, 0, 16, 16);
	unsigned char *same = mem_copy(rgb, 16 * 16 * 3, 1);
	legend_draw(rgb, 16, 16, &scene);
	assert_memory_equal(rgb, same, 16 * 16 * 3);
	free(same);
	free(rgb);
	scene_free(&scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(cube_from_its_sides),
		cmocka_unit_test(right_way_round),
		cmocka_unit_test(zoomed_into_a_corner),
		cmocka_unit_test(near_hides_far_and_inside_is_marked),
		cmocka_unit_test(nothing_and_one_point),
		cmocka_unit_test(smooth_normals_stop_at_creases),
		cmocka_unit_test(labels_and_features),
		cmocka_unit_test(network_is_drawn_as_smooth_curves),
		cmocka_unit_test(cage_and_its_surface),
		cmocka_unit_test(local_cages_have_corners_where_curves_end),
		cmocka_unit_test(deviation_colours),
		cmocka_unit_test(faults),
		cmocka_unit_test(png_reads_back),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
