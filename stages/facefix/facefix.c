/* facefix: a cage in, an FFX stream of a few hundred bytes out.
 *
 * Rounds the control points to a grid and codes them, connectivity and flags with one adaptive range coder (formats/ffx): faces
 * growing forward, or by the labels of Face Fixer (Isenburg and Snoeyink 2000). */
#include <stdlib.h>
#include <string.h>

#include "formats/cage.h"
#include "formats/ffx.h"
#include "formats/mesh.h"
#include "stages/facefix/cheaper.h"
#include "stages/facefix/gridfit.h"
#include "stages/facefix/gridmend.h"
#include "stages/tool/tool.h"

#define CAGE_SCHEMA 1 /* newest schema of assemble's and polish's files that is known here */

struct options {
	const char *in;
	int bits; /* 0: by tolerance */
	int roots;
	struct tool_length tolerance;
	bool no_frame, groups, nearest;
	bool uses_grid; /* take the cage's own grid when it has one: nothing else was asked for */
	const char *labels;
	enum ffx_method method;
	struct tool_common common;
};

static const char usage[] =
	"usage: facefix [-qv] [-o output] [--bits n | --tolerance length] [--groups] [--labels method] [--nearest] [--no-frame] "
	"[--roots n] [file]\n"
	"  --bits n          grid of 2^n - 1 steps on the longest side, 3 to 16 (default: by tolerance)\n"
	"  --tolerance l     coarsest grid that moves the surface by no more than this in the mean and 8 times this at\n"
	"                    most: model units, or % of the longest side (default: the grid that polish has put the cage\n"
	"                    on; 0.03% for other cages)\n"
	"  --groups          store which patch each face belongs to\n"
	"  --labels m        forward: faces grow, positions in between; facefixer: Face Fixer's labels first; best: the\n"
	"                    smaller of both (default)\n"
	"  --nearest         round every coordinate to the nearest, not to the cheapest within the tolerance\n"
	"  --no-frame        leave out place and size: the longest side becomes 1\n"
	"  --roots n         start edges to try, 1 to 100000; the smallest stream is kept (default: as many as is quick)\n"
	"  -o, --output f    write there instead of to stdout\n";

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {0};
	const struct tool_option table[] = {
		{"bits", 'b', TOOL_INTEGER, &opt.bits, 3, 16},
		{"tolerance", 't', TOOL_LENGTH, &opt.tolerance, 0, 0},
		{"groups", 0, TOOL_FLAG, &opt.groups, 0, 0},
		{"labels", 0, TOOL_TEXT, &opt.labels, 0, 0},
		{"nearest", 0, TOOL_FLAG, &opt.nearest, 0, 0},
		{"no-frame", 0, TOOL_FLAG, &opt.no_frame, 0, 0},
		{"roots", 0, TOOL_INTEGER, &opt.roots, 1, 100000},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	opt.uses_grid = !opt.bits && !(opt.tolerance.value > 0);
	if (!(opt.tolerance.value > 0))
		opt.tolerance = (struct tool_length){0.03, true};
	static const char *const method[] = {[FFX_BEST] = "best", [FFX_FORWARD] = "forward", [FFX_FACE_FIXER] = "facefixer"};
	for (; opt.labels && opt.method <= FFX_FACE_FIXER && strcmp(opt.labels, method[opt.method]) != 0; opt.method++)
		;
	if (opt.method > FFX_FACE_FIXER)
		tool_die(EX_BAD_USAGE, "--labels %s: best, forward or facefixer", opt.labels);
	return opt;
}

/* A fault of the cage, with its file's name in front. */
static _Noreturn void fail(const char *shown, const struct fault *fault)
{
	tool_die(fault->code, "%s: %s", shown, fault->text);
}

/* The grid that polish has chosen. False when the cage has none, or was moved off it since. */
static bool take_grid(struct ffx *ffx, const struct cage *cage, const struct options *opt, const char *shown)
{
	struct fault fault = {0};
	if (!opt->uses_grid || !(cage->grid_step > 0))
		return false;
	if (!ffx_from_cage(ffx, cage, &fault)) {
		tool_warn("%s: %s: all are rounded anew", shown, fault.text);
		return false;
	}
	if (opt->groups)
		ffx->face_patch = mem_copy(cage->face_patch, cage->face_count, sizeof *cage->face_patch);
	ffx->has_frame = !opt->no_frame;
	ffx->method = opt->method;
	return true;
}

static void put_on_grid(struct ffx *ffx, const struct cage *cage, const struct options *opt, const char *shown)
{
	struct fault fault = {0};
	const double side = mesh_bounds(cage->xyz, cage->vertex_count, NULL, NULL);
	double small = GRIDFIT_SMALL_SIDE * side;
	unsigned code;
	if (opt->bits) {
		code = ffx_grid_code((1 << opt->bits) - 1);
	} else {
		struct gridfit_choice choice;
		const double tolerance = tool_length_in_units(opt->tolerance, side);
		if (!gridfit_choose(&choice, cage, tolerance, &fault))
			fail(shown, &fault);
		code = choice.grid_code;
		small = GRIDFIT_SMALL_TOLERANCES * tolerance;
		if (choice.mean > tolerance || choice.max > 8 * tolerance)
			tool_warn("%s: even the finest grid moves the surface by %g in the mean and %g at most", shown,
				  choice.mean, choice.max);
		tool_say("grid_mean=%.9g grid_max=%.9g grids_passed_by=%u", choice.mean, choice.max, choice.finer);
	}
	if (!gridfit_round(ffx, cage, code, opt->groups, &fault))
		fail(shown, &fault);
	struct gridmend_report mended;
	gridmend(ffx, &mended, cage, small);
	tool_say("overlaid=%zu mended_by=%zu", mended.found, mended.moved);
	const struct gridfit_damage damage = gridfit_check(cage, ffx, small);
	if (damage.collapsed || damage.turned)
		tool_warn("%s: %zu faces collapse and %zu corners turn on a grid of %d steps", shown, damage.collapsed,
			  damage.turned, (int)ffx_grid_steps(code));
	if (damage.overlaid)
		tool_warn("%s: %zu vertices or edges lie on others on a grid of %d steps", shown, damage.overlaid,
			  (int)ffx_grid_steps(code));
	ffx->has_frame = !opt->no_frame;
	ffx->method = opt->method;
}

static void pack(unsigned char **bytes, size_t *size, struct ffx_report *report, struct ffx *ffx, const struct cage *cage,
		 const struct options *opt, bool is_rounded, const char *shown)
{
	struct fault fault = {0};
	struct ffx_options options = {.root_limit = (size_t)opt->roots};
	if (!ffx_encode(bytes, size, report, ffx, &options, &fault))
		fail(shown, &fault);
	if (opt->bits || opt->nearest || is_rounded)
		return;
	free(*bytes);
	ffx->method = report->method; /* the search keeps to the better one */
	struct cheaper_report cheaper;
	const double tolerance = tool_length_in_units(opt->tolerance, mesh_bounds(cage->xyz, cage->vertex_count, NULL, NULL));
	if (!cheaper_round(ffx, &cheaper, cage, tolerance, report->root, &fault))
		fail(shown, &fault);
	tool_say("tried=%zu moved=%zu payload_before=%.1f payload_after=%.1f mean=%.9g max=%.9g", cheaper.tried, cheaper.moved,
		 cheaper.bytes_before, cheaper.bytes_after, cheaper.mean, cheaper.max);
	options.first_root = report->root;
	if (!ffx_encode(bytes, size, report, ffx, &options, &fault))
		fail(shown, &fault);
}

int main(int argc, char **argv)
{
	tool_init("facefix");
	const struct options opt = parse_options(argc, argv);
	struct ply ply;
	const char *shown;
	tool_read_ply(&ply, opt.in, &shown);
	tool_check_schema(&ply, shown, "assemble", CAGE_SCHEMA);
	tool_check_schema(&ply, shown, "polish", CAGE_SCHEMA);
	struct fault fault = {0};
	struct cage cage;
	if (!cage_from_ply(&cage, &ply, shown, &fault))
		tool_fail(&fault);
	ply_free(&ply);
	if (cage.face_count == 0)
		tool_die(EX_BAD_INPUT, "%s: the cage has no faces", shown);

	struct ffx ffx;
	const bool is_rounded = take_grid(&ffx, &cage, &opt, shown);
	if (!is_rounded)
		put_on_grid(&ffx, &cage, &opt, shown);
	unsigned char *bytes;
	size_t size;
	struct ffx_report report;
	pack(&bytes, &size, &report, &ffx, &cage, &opt, is_rounded, shown);

	struct output output;
	if (!output_open(&output, opt.common.output, &fault))
		tool_fail(&fault);
	fwrite(bytes, 1, size, output.file);
	if (!output_commit(&output, &fault))
		tool_fail(&fault);
	tool_say("vertices=%zu edges=%zu faces=%zu sharp=%zu holes=%zu components=%zu handles=%zu steps=%d", report.vertex_count,
		 report.edge_count, report.face_count, ffx.sharp_count, report.hole_count, report.component_count,
		 report.handle_count, (int)ffx_grid_steps(ffx.grid_code));
	tool_say("method=%s bytes_c=%.1f bytes_g=%.1f bytes_f=%.1f bytes_frame=%.1f bytes_header=%zu bytes_total=%zu",
		 report.method == FFX_FORWARD ? "forward" : "facefixer", report.bytes_c, report.bytes_g,
		 report.bytes_f, report.bytes_frame, report.bytes_header, report.bytes_total);
	free(bytes);
	ffx_free(&ffx);
	cage_free(&cage);
	return EX_DONE;
}
