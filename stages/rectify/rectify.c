/* rectify: a segmented mesh in; smooth borders, no slivers, and patches of genus 0 with a border out.
 *
 * Label energy by minimum cuts, contour tracking on request; see rectify(1) and cagewright-dense(5). */
#include "formats/dense.h"
#include "formats/mesh.h"
#include "stages/geometry/patchsummary.h"
#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"
#include "stages/rectify/rectification.h"
#include "stages/tool/tool.h"

#define SCHEMA 1

static const char usage[] =
	"usage: rectify [-qv] [--sliver length] [--no-sliver] [--min-area ratio]\n"
	"               [--track] [--score degrees] [--passes number] [--no-smooth]\n"
	"               [--no-cut] [--binary] [--no-provenance] [-o file] [file]\n";

struct options {
	struct tool_common common;
	const char *in;
	struct tool_length sliver;
	double min_area;      /* share of the total area */
	bool is_no_sliver, is_track, is_no_smooth, is_no_cut;
	double score_deg;
	int passes;
};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.sliver = {0.2, true}, .min_area = 5e-4, .score_deg = 25, .passes = 2};
	const struct tool_option table[] = {
		{"sliver", 0, TOOL_LENGTH, &opt.sliver, 0, 0},
		{"no-sliver", 0, TOOL_FLAG, &opt.is_no_sliver, 0, 0},
		{"min-area", 0, TOOL_NUMBER, &opt.min_area, 0, 0.1},
		{"track", 't', TOOL_FLAG, &opt.is_track, 0, 0},
		{"score", 0, TOOL_NUMBER, &opt.score_deg, 0, 90},
		{"passes", 0, TOOL_INTEGER, &opt.passes, 1, 10},
		{"no-smooth", 0, TOOL_FLAG, &opt.is_no_smooth, 0, 0},
		{"no-cut", 0, TOOL_FLAG, &opt.is_no_cut, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	return opt;
}

static void report_summary(const struct dense *dense)
{
	struct patch_summary s;
	struct fault fault = {0};
	if (!tool_is_verbose() || !patch_summarise(&s, dense, &fault))
		return;
	tool_say("curves between them: %zu sharp, %zu smooth, %zu border, with %zu nodes", s.curves[CURVE_SHARP], s.curves[CURVE_SMOOTH], s.curves[CURVE_BORDER],
	         s.nodes);
	tool_say("border loops: %zu in all, most of them %zu of patch %d; %zu closed patches, %zu with handles (%ld)", s.loops, s.most_loops_count,
	         (int)s.most_loops, s.closed, s.handled, s.genus);
	if (s.worst != NO_INDEX)
		tool_say("worst patch: %d, a %s, with a vertex %.3g off it at %.6g %.6g %.6g", (int)s.worst, primitive_kind_name[dense->patch[s.worst].kind],
		         s.worst_distance, s.worst_at[0], s.worst_at[1], s.worst_at[2]);
}

static void report(const struct dense *dense, const struct rectification_counts *c, const struct options *opt)
{
	size_t kind[PATCH_KIND_COUNT] = {0};
	for (size_t l = 0; l < dense->patch_count; l++)
		kind[dense->patch[l].kind]++;
	if (c->slivers > 0)
		tool_say("slivers: %zu patches merged into neighbours, %zu sharp edges went", c->slivers, c->sliver_edges);
	if (opt->is_track)
		tool_say("contour tracking: %zu of %zu smooth border edges correct, %zu paths drawn, %zu ends kept, %d passes", c->track.correct,
		         c->track.border_edges, c->track.tracked, c->track.kept, c->track.passes);
	tool_say("smoothing: %zu triangles relabelled in %d rounds", c->smooth.relabelled, c->smooth.rounds);
	tool_say("pieces: %zu became patches, %zu joined a neighbour", c->split, c->absorbed);
	tool_say("triangles of another patch than before: %zu of %zu", c->changed, dense->triangle_count);
	if (!opt->is_no_cut)
		tool_say("cuts: %zu closed patches, %zu with handles, %zu balls, %zu parts added", c->cut.closed, c->cut.handles, c->cut.balls, c->cut.parts);
	tool_say("patches: %zu plane, %zu cylinder, %zu cone, %zu sphere, %zu torus, %zu free", kind[PATCH_PLANE], kind[PATCH_CYLINDER],
	         kind[PATCH_CONE], kind[PATCH_SPHERE], kind[PATCH_TORUS], kind[PATCH_FREE]);
}

int main(int argc, char **argv)
{
	tool_init("rectify");
	const struct options opt = parse_options(argc, argv);
	struct fault fault = {0};
	struct ply document;
	struct dense dense;
	const char *shown;
	tool_read_ply(&document, opt.in, &shown);
	tool_check_schema(&document, shown, "curv", 1);
	tool_check_schema(&document, shown, "segment", 1);
	if (!dense_from_ply(&dense, &document, true, shown, &fault))
		tool_fail(&fault);

	const double side = mesh_bounds(dense.xyz, dense.vertex_count, NULL, NULL);
	const double sliver = opt.is_no_sliver ? 0 : tool_length_in_units(opt.sliver, side);
	const size_t edges_before = dense.edge_count;
	const struct rectification_options how = {sliver, opt.min_area, opt.is_no_smooth, opt.is_no_cut, opt.is_track, opt.score_deg / DEGREES, opt.passes};
	struct rectification_counts counts;
	if (!rectification(&dense, &counts, &how, shown, &fault))
		tool_fail(&fault);
	report(&dense, &counts, &opt);
	report_summary(&dense);
	if (counts.cut.unsolved > 0)
		tool_warn("%s: %zu patches are still closed or have handles", shown, counts.cut.unsolved);
	if (dense.edge_count != edges_before)
		dense_to_ply(&document, &dense);
	else
		dense_labels_to_ply(&document, &dense);
	tool_write_ply(&document, &opt.common, SCHEMA, "sliver=%g%s%s%s", sliver, opt.is_track ? " track" : "", opt.is_no_smooth ? " no-smooth" : "",
	               opt.is_no_cut ? " no-cut" : "");
	dense_free(&dense);
	ply_free(&document);
	return EX_DONE;
}
