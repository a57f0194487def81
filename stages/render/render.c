/* render: any file of the project or a foreign mesh in, a PNG picture out.
 *
 * Orthographic, flat light, drawn in software by OSMesa: the same file gives the same picture. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh.h"
#include "formats/number.h"
#include "stages/geometry/vector.h"
#include "stages/render/legend.h"
#include "stages/render/picture.h"
#include "stages/render/raster.h"
#include "stages/render/show.h"
#include "stages/tool/tool.h"

#define WORST_ZOOM 4 /* the worst place and a quarter of the part around it */

struct options {
	const char *path;
	const char *against;        /* NULL: none */
	struct show_options show;
	struct tool_length range;   /* top of the deviation scale; value 0: the largest */
	struct view view;
	bool is_worst;              /* the view is of the worst place */
	bool has_zoom;
	struct tool_common common;
};

static const char usage[] =
	"usage: render [-qv] [--colour how] [--against mesh] [--range length] [--edges]\n"
	"              [--level n] [--view azimuth,elevation|worst] [--zoom factor]\n"
	"              [--centre x,y,z] [--size widthxheight] [-o file] [file]\n";

/* Numbers with a separator between them, each within its range. */
static bool parse_numbers(double *value, size_t count, const char *text, char separator, const double *low, const double *high)
{
	for (size_t i = 0; i < count; i++) {
		const char *end = i + 1 < count ? strchr(text, separator) : text + strlen(text);
		if (end == NULL || !num_parse(text, (size_t)(end - text), &value[i]) || !(value[i] >= low[i] && value[i] <= high[i]))
			return false;
		text = end + 1;
	}
	return true;
}

static enum colouring parse_colouring(const char *text)
{
	static const char *const name[] = {"auto", "shaded", "patch", "curvature", "deviation"};
	for (size_t i = 0; i < sizeof name / sizeof *name; i++)
		if (strcmp(text, name[i]) == 0)
			return (enum colouring)i;
	tool_die(EX_BAD_USAGE, "--colour: '%s' is not shaded, patch, curvature or deviation", text);
}

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.view = {.azimuth_deg = -60, .elevation_deg = 25, .width = 800, .height = 600, .zoom = 0}};
	const char *colour = "auto", *view = NULL, *size = NULL, *centre = NULL;
	const struct tool_option table[] = {
		{"colour", 0, TOOL_TEXT, &colour, 0, 0},
		{"against", 0, TOOL_TEXT, &opt.against, 0, 0},
		{"range", 0, TOOL_LENGTH, &opt.range, 0, 0},
		{"edges", 0, TOOL_FLAG, &opt.show.edges, 0, 0},
		{"level", 0, TOOL_INTEGER, &opt.show.level, 0, 7},
		{"view", 0, TOOL_TEXT, &view, 0, 0},
		{"zoom", 0, TOOL_NUMBER, &opt.view.zoom, 1, 1000},
		{"centre", 0, TOOL_TEXT, &centre, 0, 0},
		{"size", 0, TOOL_TEXT, &size, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.path = first < argc ? argv[first] : NULL;
	opt.show.colouring = parse_colouring(colour);
	double pair[2];
	opt.has_zoom = opt.view.zoom > 0;
	if (view != NULL && strcmp(view, "worst") == 0) {
		opt.is_worst = true;
	} else if (view != NULL) {
		if (!parse_numbers(pair, 2, view, ',', (const double[]){-360, -90}, (const double[]){360, 90}))
			tool_die(EX_BAD_USAGE, "--view: '%s' is not azimuth,elevation within +-360 and +-90 degrees", view);
		opt.view.azimuth_deg = pair[0];
		opt.view.elevation_deg = pair[1];
	}
	if (size != NULL) {
		if (!parse_numbers(pair, 2, size, 'x', (const double[]){16, 16}, (const double[]){RASTER_SIDE_MOST, RASTER_SIDE_MOST}) ||
		    pair[0] != (int)pair[0] || pair[1] != (int)pair[1])
			tool_die(EX_BAD_USAGE, "--size: '%s' is not widthxheight in pixels, each 16 to %d", size, RASTER_SIDE_MOST);
		opt.view.width = (int)pair[0];
		opt.view.height = (int)pair[1];
	}
	if (centre != NULL) {
		static const double least[3] = {-1e300, -1e300, -1e300}, most[3] = {1e300, 1e300, 1e300};
		if (!parse_numbers(opt.view.centre, 3, centre, ',', least, most))
			tool_die(EX_BAD_USAGE, "--centre: '%s' is not x,y,z in model units", centre);
		opt.view.has_centre = true;
	}
	if (opt.show.colouring == COLOUR_DEVIATION && opt.against == NULL)
		tool_die(EX_BAD_USAGE, "--colour deviation needs --against");
	if (opt.is_worst && opt.show.colouring != COLOUR_DEVIATION)
		tool_die(EX_BAD_USAGE, "--view worst needs --colour deviation");
	return opt;
}

/* Look at the worst place from where its surface faces. */
static void aim_at(struct view *view, const struct show_worst *worst, bool has_zoom)
{
	const double *n = worst->normal;
	/* of a surface that faces straight up or down, the front is below in the picture */
	const double level = hypot(n[0], n[1]);
	view->azimuth_deg = level > 1e-9 ? atan2(n[1], n[0]) * DEGREES : -90;
	view->elevation_deg = atan2(n[2], level) * DEGREES;
	if (!view->has_centre)
		copy3(view->centre, worst->at);
	view->has_centre = true;
	if (!has_zoom)
		view->zoom = WORST_ZOOM;
}

static void read_surface(struct trimesh *surface, const char *path)
{
	struct fault fault = {0};
	struct input input;
	struct mesh mesh;
	if (!input_read(&input, path, &fault) || !mesh_read(&mesh, &input, &fault) || !trimesh_from_mesh(surface, &mesh, input.shown, &fault))
		tool_fail(&fault);
	input_free(&input);
}

int main(int argc, char **argv)
{
	tool_init("render");
	const struct options opt = parse_options(argc, argv);
	struct view view = opt.view;
	struct fault fault = {0};
	struct input input;
	struct scene scene = {0};
	if (!input_read(&input, opt.path, &fault) || !show_file(&scene, &input, &opt.show, &fault))
		tool_fail(&fault);
	if (opt.against != NULL) {
		struct trimesh against;
		read_surface(&against, opt.against);
		const double side = mesh_bounds(against.mesh.xyz, against.mesh.vertex_count, NULL, NULL);
		const double top = opt.range.value > 0 ? tool_length_in_units(opt.range, side) : 0;
		if (opt.show.colouring == COLOUR_DEVIATION) {
			struct show_worst worst;
			if (!show_deviation(&scene, &against, top, &worst, &fault))
				tool_die(fault.code, "%s: %s", input.shown, fault.text);
			tool_say("largest distance %.4g (%.4g %% of the longest side) at %.6g %.6g %.6g, on %s", worst.distance, 100 * worst.distance / side,
			         worst.at[0], worst.at[1], worst.at[2], worst.is_missing ? opt.against : input.shown);
			tool_say("mean distance over the corners of what is drawn: %.4g (%.4g %%)", worst.mean, 100 * worst.mean / side);
			if (opt.is_worst)
				aim_at(&view, &worst, opt.has_zoom);
		} else if (scene.triangle_count == 0) {
			show_ghost(&scene, &against);
		}
		trimesh_free(&against);
	}
	tool_say("%zu triangles, %zu lines, %zu dots, from azimuth %.4g, elevation %.4g, zoom %.4g", scene.triangle_count, scene.line_count, scene.dot_count,
	         view.azimuth_deg, view.elevation_deg, fmax(1, view.zoom));
	unsigned char *rgb;
	if (!raster_draw(&rgb, &scene, &view, &fault))
		tool_fail(&fault);
	legend_draw(rgb, opt.view.width, opt.view.height, &scene);
	struct output output;
	if (!output_open(&output, opt.common.output, &fault) ||
	    !picture_write(output.file, rgb, opt.view.width, opt.view.height, &fault) || !output_commit(&output, &fault))
		tool_fail(&fault);
	free(rgb);
	scene_free(&scene);
	input_free(&input);
	return EX_DONE;
}
