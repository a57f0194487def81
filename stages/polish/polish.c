/* polish: a cage and the dense mesh that it stands for go in, a cage of fewer bytes within the same bounds comes out, on the grid that
 * facefix packs it with.
 *
 * Removal, local search and joint rounding judged by the decoded surface; see polish(1). After Hoppe et al., "Piecewise smooth surface
 * reconstruction" (SIGGRAPH 1994): edits of the mesh with local refits under an energy of error and size, here with polygons in place of
 * triangles and coded bits in place of a count of vertices. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh.h"
#include "formats/number.h"
#include "stages/geometry/trimesh.h"
#include "stages/polish/plan.h"
#include "stages/tool/tool.h"

enum { SCHEMA = 1, CAGE_SCHEMA = 1 };

static const char usage[] =
	"usage: polish --mesh mesh [-qv] [--mean length] [--max length] [--effort n]\n"
	"              [--level n] [--binary] [--no-provenance] [-o output] [file]\n"
	"Make a cage cheaper to pack while it stays within bounds of the dense mesh.\n"
	"  -m, --mesh FILE     the dense mesh: any file that curv or deviate reads\n"
	"      --mean LENGTH   mean distance allowed, both ways (default 0.1%)\n"
	"      --max LENGTH    largest distance allowed (default 1%)\n"
	"      --effort N      0 (only put it on a grid) to 9 (search for minutes); default 5\n"
	"      --level N       subdivision level that is measured (default 4)\n"
	"  -o, --output FILE   write there instead of stdout\n"
	"      --binary        write binary PLY\n"
	"      --no-provenance leave out the comment line of this stage\n"
	"  -q, -v, --help, --version\n";

struct options {
	const char *mesh, *in;
	struct tool_length mean, max;
	int effort, level;
	struct tool_common common;
};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.mean = {0.1, true}, .max = {1, true}, .effort = 5, .level = 4};
	const struct tool_option table[] = {
		{"mesh", 'm', TOOL_TEXT, &opt.mesh, 0, 0},
		{"mean", 0, TOOL_LENGTH, &opt.mean, 0, 0},
		{"max", 0, TOOL_LENGTH, &opt.max, 0, 0},
		{"effort", 'e', TOOL_INTEGER, &opt.effort, 0, 9},
		{"level", 0, TOOL_INTEGER, &opt.level, 1, 6},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	if (!opt.mesh)
		tool_die(EX_BAD_USAGE, "--mesh is missing: which dense mesh does the cage stand for?");
	return opt;
}

static void read_surface(struct trimesh *surface, const char *path)
{
	struct fault fault = {0};
	struct input input;
	struct mesh mesh;
	if (!input_read(&input, path, &fault) || !mesh_read(&mesh, &input, &fault) || !trimesh_from_mesh(surface, &mesh, input.shown, &fault))
		tool_fail(&fault);
	if (!(surface->area > 0) || !isfinite(surface->area))
		tool_die(EX_BAD_INPUT, "%s: a surface %s", input.shown, surface->area > 0 ? "with an area beyond all numbers" : "without area");
	input_free(&input);
}

/* Enough that a face of the cage gets some dozens; more take longer and change little. */
static size_t sample_count(const struct cage *cage, int effort)
{
	enum { A_VERTEX = 30, LEAST = 3000, MOST = 8000, MOST_LONG = 20000 };
	const size_t count = A_VERTEX * cage->vertex_count, most = effort > 6 ? MOST_LONG : MOST;
	return count < LEAST ? LEAST : count > most ? most : count;
}

/* Points that somebody moved before the cage was made of them (see cagewright-cage(5)). */
static bool has_held_points(const struct ply *document)
{
	static const char key[] = "comment cagewright held ";
	for (size_t i = 0; i < document->comment_count; i++)
		if (strncmp(document->comment[i], key, sizeof key - 1) == 0)
			return true;
	return false;
}

static void length_text(char text[NUM_TEXT_SIZE + 1], struct tool_length length)
{
	const size_t end = num_print(text, length.value);
	if (length.is_percent)
		text[end] = '%', text[end + 1] = 0;
}

static void report(const char *shown, const struct plan_result *r)
{
	static const char *const kind[MOVE_KINDS] = {"merged", "collapsed", "removed", "swapped", "cut", "split", "creased", "cornered"};
	tool_say("%s: %zu vertices, %zu faces before; %zu vertices, %zu faces after", shown, r->start_vertices, r->start_faces, r->cage.vertex_count,
	         r->cage.face_count);
	if (r->is_collapsed)
		tool_say("%s: begun at the mesh, collapsed", shown);
	tool_say("tried=%zu done=%zu rounded=%zu measured=%zu", r->search.tried, r->search.done, r->rounded, r->measured);
	for (int k = 0; k < MOVE_KINDS; k++)
		if (r->search.by_kind[k] > 0)
			tool_say("%s=%zu", kind[k], r->search.by_kind[k]);
	tool_say("bytes=%zu mean_side=%.6g max_side=%.6g", r->bytes, r->errors.mean, r->errors.max);
	if (!r->is_within)
		tool_warn("%s: no cage within the bounds was found: mean %.3g%%, largest %.3g%% of the longest side, %.3g%% of the area turned away", shown,
		          100 * r->errors.mean, 100 * r->errors.max, 100 * r->errors.turned);
	if (r->is_given)
		tool_say("%s: left as it was: no cage on a grid is nearer to the bounds", shown);
}

int main(int argc, char **argv)
{
	tool_init("polish");
	const struct options opt = parse_options(argc, argv);
	struct fault fault = {0};
	struct ply document;
	const char *shown;
	tool_read_ply(&document, opt.in, &shown);
	tool_check_schema(&document, shown, "assemble", CAGE_SCHEMA);
	tool_check_schema(&document, shown, "polish", SCHEMA);
	struct cage cage;
	if (!cage_from_ply(&cage, &document, shown, &fault))
		tool_fail(&fault);
	if (cage.face_count == 0)
		tool_die(EX_BAD_INPUT, "%s: the cage has no faces", shown);
	char mean[NUM_TEXT_SIZE + 1], max[NUM_TEXT_SIZE + 1];
	length_text(mean, opt.mean), length_text(max, opt.max);
	if (has_held_points(&document)) {
		tool_warn("%s: left as it is: points of its curves were moved by hand", shown);
		tool_write_ply(&document, &opt.common, SCHEMA, "held");
		cage_free(&cage);
		ply_free(&document);
		return EX_DONE;
	}
	struct trimesh surface = {0};
	read_surface(&surface, opt.mesh);

	double low[3], high[3], middle[3];
	const double side = mesh_bounds(surface.mesh.xyz, surface.mesh.vertex_count, low, high);
	for (int k = 0; k < 3; k++)
		middle[k] = low[k] / 2 + high[k] / 2;
	for (size_t i = 0; i < 3 * surface.mesh.vertex_count; i++)
		surface.mesh.xyz[i] = (surface.mesh.xyz[i] - middle[i % 3]) / side;
	struct sketch sketch;
	if (!sketch_from_cage(&sketch, &cage, middle, side, &fault))
		tool_die(fault.code, "%s: %s", shown, fault.text);
	struct target target;
	const size_t samples = sample_count(&cage, opt.effort);
	target_start(&target, surface.mesh.xyz, surface.mesh.vertex_count, surface.triangle, surface.triangle_count, samples, samples / 2, SHARP_DEG);
	const struct plan_options options = {.mean = tool_length_in_units(opt.mean, side) / side, .max = tool_length_in_units(opt.max, side) / side,
	                                     .level = opt.level, .effort = opt.effort, .middle = middle, .scale = side, .progress = tool_progress, .say = tool_say};
	struct plan_result result;
	if (!plan_run(&result, &cage, &sketch, &target, &options))
		tool_die(EX_BAD_INPUT, "%s: the cage does not fit on any grid", shown);
	report(shown, &result);
	cage_to_ply(&document, &result.cage);
	tool_write_ply(&document, &opt.common, SCHEMA, "mean=%s max=%s effort=%d level=%d", mean, max, opt.effort, opt.level);
	cage_free(&result.cage), cage_free(&cage);
	target_free(&target);
	trimesh_free(&surface);
	ply_free(&document);
	return EX_DONE;
}
