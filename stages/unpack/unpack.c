/* unpack: an FFX stream in, its cage or the refined surface out.
 *
 * Decodes (formats/ffx) and subdivides (stages/geometry/subdivide). Needs libc, libm and zlib only. */
#include <string.h>

#include "formats/cage.h"
#include "formats/export.h"
#include "formats/ffx.h"
#include "formats/mesh.h"
#include "stages/geometry/subdivide.h"
#include "stages/tool/tool.h"

#define CAGE_SCHEMA 1
#define FACE_LIMIT 50000000

struct options {
	const char *in;
	bool cage, check;
	int level;
	struct tool_common common;
};

static const char usage[] =
	"usage: unpack [-qv] [-o output] [--cage | --check | --level n] [--binary] [file]\n"
	"  --level n       refine n times, 0 to 8 (default 4)\n"
	"  --cage          write the cage itself, with its creases and corners when it goes to PLY\n"
	"  --check         write nothing; exit 1 when the stream is damaged\n"
	"  -o, --output f  write there instead of to stdout; ply, obj, off, stl, stla by the extension, stdout is ply\n";

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.level = -1};
	const struct tool_option table[] = {
		{"level", 'l', TOOL_INTEGER, &opt.level, 0, 8},
		{"cage", 0, TOOL_FLAG, &opt.cage, 0, 0},
		{"check", 0, TOOL_FLAG, &opt.check, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	if (opt.cage + opt.check + (opt.level >= 0) > 1)
		tool_die(EX_BAD_USAGE, "--cage, --check and --level exclude each other");
	if (opt.level < 0)
		opt.level = 4;
	return opt;
}

static void output_extension(char extension[8], const char *path)
{
	if (!path || strcmp(path, "-") == 0) {
		strcpy(extension, "ply");
		return;
	}
	path_extension(extension, path);
	if (strncmp(path, "/dev/", 5) == 0 && extension[0] == '\0')
		strcpy(extension, "ply");
	if (!export_knows(extension))
		tool_die(EX_BAD_USAGE, "%s: no writer for this extension; ply, obj, off, stl or stla", path);
}

static void write_cage(const struct cage *cage, const struct tool_common *common)
{
	struct ply ply;
	ply_init(&ply);
	cage_to_ply(&ply, cage);
	tool_write_ply(&ply, common, CAGE_SCHEMA, "cage");
	ply_free(&ply);
}

static void write_mesh(const struct mesh *mesh, const char *extension, const struct tool_common *common)
{
	struct fault fault = {0};
	struct output output;
	if (!output_open(&output, common->output, &fault) || !export_mesh(output.file, extension, mesh, common->binary, &fault) ||
	    !output_commit(&output, &fault))
		tool_fail(&fault);
}

/* The refined surface; its arrays belong to the level. */
static struct mesh refine(struct level *level, const struct cage *cage, int steps, const char *shown)
{
	struct fault fault = {0};
	struct level base;
	if (!level_from_cage(&base, cage, &fault))
		tool_die(fault.code, "%s: %s", shown, fault.text);
	size_t faces = cage->face_count;
	if (steps > 0) {
		faces = cage->face_start[cage->face_count]; /* every corner gives a face, triangles one more, and each of them
							       four */
		for (int i = 1; i < steps && faces <= FACE_LIMIT; i++)
			faces *= 4;
	}
	if (faces > FACE_LIMIT)
		tool_die(EX_BAD_INPUT, "%s: level %d has more than %d faces; take a lower one", shown, steps, FACE_LIMIT);
	level_refine(level, &base, cage->scheme, steps);
	level_free(&base);
	return (struct mesh){level->xyz, level->vertex_count, level->face_corner, level->face_start, level->face_count};
}

int main(int argc, char **argv)
{
	tool_init("unpack");
	const struct options opt = parse_options(argc, argv);
	char extension[8];
	output_extension(extension, opt.common.output);
	struct fault fault = {0};
	struct input input;
	if (!input_read(&input, opt.in, &fault))
		tool_fail(&fault);
	struct ffx ffx;
	if (!ffx_decode(&ffx, input.data, input.size, input.shown, &fault)) {
		if (opt.check && fault.code == EX_BAD_INPUT)
			fault.code = EX_NO;
		tool_fail(&fault);
	}
	tool_say("vertices=%zu faces=%zu sharp=%zu steps=%d bytes=%zu", ffx.vertex_count, ffx.face_count, ffx.sharp_count,
		 (int)ffx_grid_steps(ffx.grid_code), input.size);
	if (opt.check)
		return EX_DONE;
	struct cage cage;
	ffx_to_cage(&cage, &ffx);
	if (opt.cage && strcmp(extension, "ply") == 0) {
		write_cage(&cage, &opt.common);
	} else if (opt.cage) {
		const struct mesh mesh = {cage.xyz, cage.vertex_count, cage.face_corner, cage.face_start, cage.face_count};
		write_mesh(&mesh, extension, &opt.common);
	} else {
		struct level level;
		const struct mesh mesh = refine(&level, &cage, opt.level, input.shown);
		write_mesh(&mesh, extension, &opt.common);
		level_free(&level);
	}
	cage_free(&cage);
	ffx_free(&ffx);
	input_free(&input);
	return EX_DONE;
}
