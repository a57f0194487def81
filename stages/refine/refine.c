/* refine: a cage in, its mesh after some steps of subdivision out, or the limits of that mesh's vertices.
 *
 * Rules: Stam and Loop 2003 (quads and triangles), Loop 1987, Catmull and Clark 1978, with creases as in section 9 of the patch
 * method. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/cage.h"
#include "formats/export.h"
#include "stages/geometry/subdivide.h"
#include "stages/refine/levelcage.h"
#include "stages/tool/tool.h"

enum { SCHEMA = 1, MOST_STEPS = 12 };

struct options {
	const char *path;
	int level;
	bool limit;
	const char *scheme;     /* NULL: as the cage says */
	char extension[8];      /* of the output */
	struct tool_common common;
};

static const char usage[] =
	"usage: refine [-qv] [-l n] [--limit] [--scheme name] [-o output] [--binary] [--no-provenance] [cage.ply]\n"
	"  -l, --level n   steps of subdivision, 0 to 12 (default 4)\n"
	"  --limit         move the vertices of that level to the limit surface\n"
	"  --scheme name   quadtri, loop or catmullclark, whatever the cage says\n"
	"  -o, --output f  write there instead of to stdout; the extension tells the format: ply, obj, off, stl, stla\n"
	"  --binary        write binary PLY\n"
	"  --no-provenance leave out the comment that names this tool and its options\n";

static const char *const scheme_name[3] = {"quadtri", "loop", "catmullclark"};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.level = 4};
	const struct tool_option table[] = {
		{"level", 'l', TOOL_INTEGER, &opt.level, 0, MOST_STEPS},
		{"limit", 0, TOOL_FLAG, &opt.limit, 0, 0},
		{"scheme", 0, TOOL_TEXT, &opt.scheme, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.path = first < argc ? argv[first] : NULL;
	if (opt.scheme) {
		int known = 0;
		for (int s = 0; s < 3; s++)
			known += strcmp(opt.scheme, scheme_name[s]) == 0;
		if (!known)
			tool_die(EX_BAD_USAGE, "unknown scheme '%s' (quadtri, loop, catmullclark)", opt.scheme);
	}
	if (opt.common.output) {
		const size_t length = strlen(opt.common.output);
		if (length > 3 && strcmp(opt.common.output + length - 3, ".gz") == 0)
			tool_die(EX_BAD_USAGE, "cannot write compressed files: '%s'", opt.common.output);
		path_extension(opt.extension, opt.common.output);
	}
	if (!*opt.extension)
		strcpy(opt.extension, "ply");
	if (!export_knows(opt.extension))
		tool_die(EX_BAD_USAGE, "no writer for '.%s' files (ply, obj, off, stl, stla)", opt.extension);
	return opt;
}

/* Drop what the cage says about its scheme; say name instead unless that is NULL. */
static void replace_scheme(struct ply *ply, const char *name)
{
	static const char prefix[] = "comment cagewright scheme";
	size_t kept = 0;
	for (size_t c = 0; c < ply->comment_count; c++)
		if (strncmp(ply->comment[c], prefix, sizeof prefix - 1) == 0)
			free(ply->comment[c]);
		else
			ply->comment[kept++] = ply->comment[c];
	ply->comment_count = kept;
	if (name)
		ply_comment(ply, "cagewright scheme %s", name);
}

static void read_cage(struct cage *cage, struct level *level, struct ply *ply, const struct options *opt, const char **shown)
{
	struct fault fault = {0};
	tool_read_ply(ply, opt->path, shown);
	static const char *const writers[] = {"fitpatch", "assemble", "polish", "refine"};
	for (size_t i = 0; i < sizeof writers / sizeof *writers; i++)
		tool_check_schema(ply, *shown, writers[i], 1);
	if (opt->scheme)
		replace_scheme(ply, opt->scheme);
	if (!cage_from_ply(cage, ply, *shown, &fault))
		tool_fail(&fault);
	if (!level_from_cage(level, cage, &fault))
		tool_die(fault.code, "%s: %s", *shown, fault.text);
}

static void write_other(const struct cage *mesh, const struct options *opt)
{
	struct fault fault = {0};
	struct output output;
	const struct mesh plain = {mesh->xyz, mesh->vertex_count, mesh->face_corner, mesh->face_start, mesh->face_count};
	if (!output_open(&output, opt->common.output, &fault) ||
	    !export_mesh(output.file, opt->extension, &plain, opt->common.binary, &fault) || !output_commit(&output, &fault))
		tool_fail(&fault);
}

static void report_cage(const struct cage *cage)
{
	static const char *const scheme[] = {[SCHEME_QUADTRI] = "quad/triangle", [SCHEME_LOOP] = "Loop", [SCHEME_CATMULLCLARK] = "Catmull-Clark"};
	size_t triangles = 0, quads = 0, corners = 0;
	for (size_t f = 0; f < cage->face_count; f++) {
		const size_t sides = cage->face_start[f + 1] - cage->face_start[f];
		triangles += sides == 3;
		quads += sides == 4;
	}
	for (size_t v = 0; v < cage->vertex_count; v++)
		corners += cage->corner[v] != 0;
	tool_say("%s cage: %zu vertices, %zu explicit corners, %zu triangles, %zu quads, %zu larger faces, %zu creases", scheme[cage->scheme],
	         cage->vertex_count, corners, triangles, quads, cage->face_count - triangles - quads, cage->sharp_count);
}

int main(int argc, char **argv)
{
	tool_init("refine");
	const struct options opt = parse_options(argc, argv);
	const char *shown;
	struct ply ply;
	struct cage cage, mesh;
	struct level level, refined;
	read_cage(&cage, &level, &ply, &opt, &shown);

	report_cage(&cage);
	size_t corners;
	level_refined_size(NULL, NULL, &corners, &level, cage.scheme, opt.level);
	if (corners > INDEX_LIMIT)
		tool_die(EX_BAD_INPUT, "%s: level %d has more than %zu face corners", shown, opt.level, INDEX_LIMIT);
	level_refine(&refined, &level, cage.scheme, opt.level);
	level_free(&level);
	if (opt.limit)
		level_to_limit(&refined, cage.scheme);
	levelcage(&mesh, &refined, &cage);
	tool_say("%zu vertices, %zu faces", mesh.vertex_count, mesh.face_count);

	if (strcmp(opt.extension, "ply") == 0) {
		cage_to_ply(&ply, &mesh);
		if (opt.limit)
			replace_scheme(&ply, NULL); /* limit points are no control points: subdivided again they would shrink */
		tool_write_ply(&ply, &opt.common, SCHEMA, "level=%d%s", opt.level, opt.limit ? " limit" : "");
	} else {
		write_other(&mesh, &opt);
	}
	ply_free(&ply);
	cage_free(&cage);
	cage_free(&mesh);
	return EX_DONE;
}
