#include "stages/render/raster.h"

#include <GL/osmesa.h>
#include <math.h>
#include <stdlib.h>

#include "stages/geometry/vector.h"

/* Each pixel of the picture is the mean of SUPER * SUPER drawn ones. */
#define SUPER 2
/* Empty rim around the part, a share of the picture's shorter side. */
#define RIM 0.04
/* How much lines and dots are moved towards the eye, a share of the scene's size: enough to win against the faces
 * that they lie on, too little to show through a wall. */
#define LIFT 0.002
/* Dots have this many corners. */
#define DOT_CORNERS 24

/* Orthographic camera: axes in space, and what part of the eye plane is shown. */
struct camera {
	double right[3], up[3], back[3]; /* unit; back points to the eye */
	double centre[3];                /* model point in the middle of the picture */
	double half_width, half_height;  /* model units */
	double depth;                    /* half of the scene's extent along the view */
	double pixel;                    /* model units a pixel of the finished picture */
	double lift;                     /* of lines, a share of depth */
};

static void extend(double low[3], double high[3], const struct camera *camera, const double p[3])
{
	const double at[3] = {dot3(p, camera->right), dot3(p, camera->up), dot3(p, camera->back)};
	for (int k = 0; k < 3; k++) {
		low[k] = fmin(low[k], at[k]);
		high[k] = fmax(high[k], at[k]);
	}
}

static void aim(struct camera *camera, const struct scene *scene, const struct view *view)
{
	const double a = view->azimuth_deg / DEGREES, e = view->elevation_deg / DEGREES;
	const double right[3] = {-sin(a), cos(a), 0}, back[3] = {cos(e) * cos(a), cos(e) * sin(a), sin(e)};
	copy3(camera->right, right);
	copy3(camera->back, back);
	cross3(camera->up, back, right);

	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
	for (size_t i = 0; i < 3 * scene->triangle_count; i++)
		extend(low, high, camera, scene->xyz + 3 * (size_t)scene->triangle[i]);
	for (size_t i = 0; i < scene->line_count; i++) {
		extend(low, high, camera, scene->line[i].from);
		extend(low, high, camera, scene->line[i].to);
	}
	for (size_t i = 0; i < scene->dot_count; i++)
		extend(low, high, camera, scene->dot[i].centre);
	if (!(high[0] >= low[0])) /* nothing to show */
		for (int k = 0; k < 3; k++)
			low[k] = high[k] = 0;

	camera->centre[0] = camera->centre[1] = camera->centre[2] = 0;
	const double *const axis[3] = {camera->right, camera->up, camera->back};
	for (int k = 0; k < 3; k++)
		add_scaled3(camera->centre, low[k] / 2 + high[k] / 2, axis[k]);
	const double wide = (high[0] - low[0]) / 2, tall = (high[1] - low[1]) / 2;
	const double shorter = fmin(view->width, view->height), inner_w = view->width - 2 * RIM * shorter, inner_h = view->height - 2 * RIM * shorter;
	camera->pixel = fmax(2 * wide / inner_w, 2 * tall / inner_h);
	camera->depth = (high[2] - low[2]) / 2;
	if (!(camera->pixel > 0))
		camera->pixel = camera->depth > 0 ? camera->depth / shorter : 1;
	if (view->has_centre) { /* the depth range must still hold all of the part */
		double d[3];
		sub3(d, view->centre, camera->centre);
		camera->depth += fabs(dot3(d, camera->back));
		copy3(camera->centre, view->centre);
	}
	camera->pixel /= fmax(1, view->zoom);
	camera->half_width = camera->pixel * view->width / 2;
	camera->half_height = camera->pixel * view->height / 2;
	camera->depth = fmax(camera->depth, camera->pixel * shorter * 0.01);
	camera->lift = LIFT / fmax(1, view->zoom);
}

/* Model point to the cube [-1, 1]^3 of the picture, lifted towards the eye by a share of the scene's depth. */
static void project(float out[3], const struct camera *camera, const double p[3], double lift)
{
	double d[3];
	sub3(d, p, camera->centre);
	out[0] = (float)(dot3(d, camera->right) / camera->half_width);
	out[1] = (float)(dot3(d, camera->up) / camera->half_height);
	/* 0.9: room for what is lifted. */
	out[2] = (float)(-0.9 * dot3(d, camera->back) / camera->depth - lift);
}

static double lit(const double normal[3], const struct camera *camera)
{
	/* Key light from above left of the eye, weak fill from the right below, the rest from everywhere. */
	double key[3] = {0, 0, 0}, fill[3] = {0, 0, 0};
	const double *const axis[3] = {camera->right, camera->up, camera->back};
	static const double key_at[3] = {-0.40, 0.62, 0.67}, fill_at[3] = {0.75, -0.20, 0.63};
	for (int k = 0; k < 3; k++) {
		add_scaled3(key, key_at[k], axis[k]);
		add_scaled3(fill, fill_at[k], axis[k]);
	}
	return 0.46 + 0.58 * fmax(0, dot3(normal, key)) + 0.22 * fmax(0, dot3(normal, fill));
}

static unsigned char shade(unsigned char channel, double light)
{
	return (unsigned char)lround(fmin(255, channel * light));
}

static void draw_surface(const struct scene *scene, const struct camera *camera)
{
	const size_t count = 3 * scene->triangle_count;
	float *position = mem_array(3 * count, sizeof *position);
	struct colour *colour = mem_array(count, sizeof *colour);
	static const struct colour inside = {205, 120, 125}; /* the side that should never be seen of a closed part */
	for (size_t t = 0; t < scene->triangle_count; t++) {
		const double *at[3];
		double across[3];
		for (int k = 0; k < 3; k++)
			at[k] = scene->xyz + 3 * (size_t)scene->triangle[3 * t + k];
		area_vector3(across, at[0], at[1], at[2]);
		const bool from_inside = dot3(across, camera->back) < 0;
		for (int k = 0; k < 3; k++) {
			const size_t c = 3 * t + k;
			project(position + 3 * c, camera, at[k], 0);
			double normal[3];
			for (int i = 0; i < 3; i++)
				normal[i] = from_inside ? -scene->normal[3 * c + i] : scene->normal[3 * c + i];
			const double light = lit(normal, camera);
			const struct colour base = from_inside ? palette_mix(inside, scene->colour[c], 0.15) : scene->colour[c];
			colour[c] = (struct colour){shade(base.red, light), shade(base.green, light), shade(base.blue, light)};
		}
	}
	glEnable(GL_POLYGON_OFFSET_FILL);
	glPolygonOffset(1, 1);
	glEnableClientState(GL_VERTEX_ARRAY);
	glEnableClientState(GL_COLOR_ARRAY);
	glVertexPointer(3, GL_FLOAT, 0, position);
	glColorPointer(3, GL_UNSIGNED_BYTE, 0, colour);
	const size_t most = 3 * 1000000; /* glDrawArrays counts in int */
	for (size_t first = 0; first < count; first += most)
		glDrawArrays(GL_TRIANGLES, (GLint)first, (GLsizei)(count - first < most ? count - first : most));
	glFinish();
	glDisableClientState(GL_VERTEX_ARRAY);
	glDisableClientState(GL_COLOR_ARRAY);
	glDisable(GL_POLYGON_OFFSET_FILL);
	free(position);
	free(colour);
}

/* Without a surface nothing hides what lies behind: let it fade instead. depth in [-1, 1], far is 1. */
static struct colour faded(struct colour colour, float depth, bool fades)
{
	static const struct colour white = {255, 255, 255};
	return fades ? palette_mix(colour, white, 0.35 + 0.35 * depth) : colour;
}

static void set_colour(struct colour colour)
{
	glColor3ub(colour.red, colour.green, colour.blue);
}

/* The four corners of a line of some width: a rectangle in the picture, half a width longer at each end, so that chains of short
 * lines have no gaps (GL's own wide lines have). */
static void line_corners(float out[12], const struct camera *camera, const struct scene_line *line)
{
	/* Wider lines win over narrower ones. */
	const double lift = camera->lift * (1 + 0.2 * fmin(line->width, 5));
	float at[2][3];
	project(at[0], camera, line->from, lift);
	project(at[1], camera, line->to, lift);
	const double to_x = camera->half_width / camera->pixel, to_y = camera->half_height / camera->pixel; /* cube to pixels */
	double dx = (at[1][0] - at[0][0]) * to_x, dy = (at[1][1] - at[0][1]) * to_y;
	const double length = hypot(dx, dy), half = line->width / 2;
	dx = length > 0 ? half * dx / length : half;
	dy = length > 0 ? half * dy / length : 0;
	/* The depth runs on too, else long and short pieces of one line would not lie in one plane. */
	const double deeper = (at[1][2] - at[0][2]) * (length > 0 ? fmin(0.5, half / length) : 0);
	static const int end[4] = {0, 0, 1, 1}, side[4] = {1, -1, -1, 1};
	for (int i = 0; i < 4; i++) {
		const int along = end[i] == 0 ? -1 : 1;
		out[3 * i] = (float)(at[end[i]][0] + (along * dx - side[i] * dy) / to_x);
		out[3 * i + 1] = (float)(at[end[i]][1] + (along * dy + side[i] * dx) / to_y);
		out[3 * i + 2] = (float)(at[end[i]][2] + along * deeper);
	}
}

static void draw_lines(const struct scene *scene, const struct camera *camera)
{
	const bool fades = scene->triangle_count == 0;
	const size_t most = 100000; /* lines at a time, to keep the arrays small */
	float *position = mem_array(12 * (scene->line_count < most ? scene->line_count : most), sizeof *position);
	struct colour *colour = mem_array(4 * (scene->line_count < most ? scene->line_count : most), sizeof *colour);
	glEnableClientState(GL_VERTEX_ARRAY);
	glEnableClientState(GL_COLOR_ARRAY);
	for (size_t first = 0; first < scene->line_count; first += most) {
		const size_t count = scene->line_count - first < most ? scene->line_count - first : most;
		for (size_t i = 0; i < count; i++) {
			line_corners(position + 12 * i, camera, &scene->line[first + i]);
			for (int k = 0; k < 4; k++)
				colour[4 * i + k] = faded(scene->line[first + i].colour, position[12 * i + 3 * k + 2], fades);
		}
		glVertexPointer(3, GL_FLOAT, 0, position);
		glColorPointer(3, GL_UNSIGNED_BYTE, 0, colour);
		glDrawArrays(GL_QUADS, 0, (GLsizei)(4 * count));
		glFinish();
	}
	glDisableClientState(GL_VERTEX_ARRAY);
	glDisableClientState(GL_COLOR_ARRAY);
	free(position);
	free(colour);
}

static void draw_disc(const float at[3], double radius_x, double radius_y, double inner)
{
	glBegin(GL_TRIANGLE_STRIP);
	for (int i = 0; i <= DOT_CORNERS; i++) {
		const double turn = 2 * PI * (i % DOT_CORNERS) / DOT_CORNERS, x = radius_x * cos(turn), y = radius_y * sin(turn);
		glVertex3f((float)(at[0] + inner * x), (float)(at[1] + inner * y), at[2]);
		glVertex3f((float)(at[0] + x), (float)(at[1] + y), at[2]);
	}
	glEnd();
}

static void draw_dots(const struct scene *scene, const struct camera *camera)
{
	const bool fades = scene->triangle_count == 0;
	for (size_t i = 0; i < scene->dot_count; i++) {
		const struct scene_dot *dot = &scene->dot[i];
		float at[3];
		project(at, camera, dot->centre, 3 * camera->lift);
		const struct colour colour = faded(dot->colour, at[2], fades);
		const double x = camera->pixel / camera->half_width, y = camera->pixel / camera->half_height;
		if (dot->is_ring) {
			at[2] = -1;
			glColor3ub(255, 255, 255);
			draw_disc(at, (dot->radius + 1.2) * x, (dot->radius + 1.2) * y, 0.6);
			set_colour(dot->colour);
			draw_disc(at, dot->radius * x, dot->radius * y, 0.72);
		} else { /* a thin dark rim keeps dots apart from what they lie on */
			set_colour(palette_mix(colour, (struct colour){0, 0, 0}, 0.6));
			draw_disc(at, (dot->radius + 0.8) * x, (dot->radius + 0.8) * y, 0);
			set_colour(colour);
			at[2] -= (float)(0.05 * camera->lift);
			draw_disc(at, dot->radius * x, dot->radius * y, 0);
		}
	}
}

static void halve(unsigned char *rgb, const unsigned char *rgba, int width, int height)
{
	for (int y = 0; y < height; y++)
		for (int x = 0; x < width; x++)
			for (int k = 0; k < 3; k++) {
				int sum = 0;
				for (int i = 0; i < SUPER * SUPER; i++) {
					const size_t row = (size_t)(SUPER * y + i / SUPER), column = (size_t)(SUPER * x + i % SUPER);
					sum += rgba[4 * (row * (size_t)(SUPER * width) + column) + k];
				}
				rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + k] = (unsigned char)((sum + SUPER * SUPER / 2) / (SUPER * SUPER));
			}
}

bool raster_draw(unsigned char **rgb, const struct scene *scene, const struct view *view, struct fault *fault)
{
	const int width = SUPER * view->width, height = SUPER * view->height;
	const OSMesaContext context = OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, NULL);
	if (context == NULL)
		return fault_set(fault, EX_SYSTEM, "OSMesa gives no drawing context");
	unsigned char *rgba = mem_array(4 * (size_t)width * (size_t)height, 1);
	if (!OSMesaMakeCurrent(context, rgba, GL_UNSIGNED_BYTE, width, height)) {
		OSMesaDestroyContext(context);
		free(rgba);
		return fault_set(fault, EX_SYSTEM, "OSMesa cannot draw %d x %d pixels", width, height);
	}
	OSMesaPixelStore(OSMESA_Y_UP, 0);
	struct camera camera;
	aim(&camera, scene, view);
	glViewport(0, 0, width, height);
	glClearColor(1, 1, 1, 1);
	glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
	glEnable(GL_DEPTH_TEST);
	glDepthFunc(GL_LEQUAL);
	glShadeModel(GL_SMOOTH);
	glDisable(GL_DITHER);
	if (scene->triangle_count > 0)
		draw_surface(scene, &camera);
	draw_lines(scene, &camera);
	draw_dots(scene, &camera);
	glFinish();
	*rgb = mem_array(3 * (size_t)view->width * (size_t)view->height, 1);
	halve(*rgb, rgba, view->width, view->height);
	OSMesaMakeCurrent(NULL, NULL, 0, 0, 0);
	OSMesaDestroyContext(context);
	free(rgba);
	return true;
}
