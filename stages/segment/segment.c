/* segment: the dense mesh in, the same with a patch for every triangle out.
 *
 * Analytic surfaces by growing and refitting, curvature clusters (Lavoue et al. 2005) elsewhere, see segment(1). */
#include <stdio.h>
#include <stdlib.h>

#include "formats/dense.h"
#include "formats/number.h"
#include "stages/geometry/patchsummary.h"
#include "stages/geometry/primitive.h"
#include "stages/segment/region_tidy.h"
#include "stages/segment/segment_classic.h"
#include "stages/segment/segment_primitives.h"
#include "stages/tool/tool.h"

#define SCHEMA 1
#define CURV_SCHEMA 1

static const char usage[] =
	"usage: segment [-qv] [--tolerance length] [--classic] [--clusters count]\n"
	"               [--merge distance] [--amin share] [--patches count]\n"
	"               [--binary] [--no-provenance] [-o file] [file]\n";

struct options {
	struct tool_common common;
	const char *in;
	struct tool_length tolerance; /* value 0: automatic */
	bool is_classic;
	int clusters;                 /* 0: automatic */
	double merge;                 /* D_stop, asinh units of curvature * longest side */
	double least_share;           /* of the area */
	int patches;                  /* most free-form patches */
};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.merge = 0.25, .least_share = 5e-4, .patches = 60};
	const struct tool_option table[] = {
		{"tolerance", 't', TOOL_LENGTH, &opt.tolerance, 0, 0},
		{"classic", 'c', TOOL_FLAG, &opt.is_classic, 0, 0},
		{"clusters", 0, TOOL_INTEGER, &opt.clusters, 1, 15},
		{"merge", 'm', TOOL_NUMBER, &opt.merge, 0, 100},
		{"amin", 'a', TOOL_NUMBER, &opt.least_share, 0, 0.1},
		{"patches", 'p', TOOL_INTEGER, &opt.patches, 1, 100000},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	return opt;
}

static void report_patches(const struct regions *r)
{
	size_t count[PATCH_KIND_COUNT] = {0};
	double area[PATCH_KIND_COUNT] = {0};
	for (size_t i = 0; i < r->count; i++) {
		count[r->patch[i].kind]++;
		area[r->patch[i].kind] += r->patch[i].area;
	}
	for (int k = 0; k < PATCH_KIND_COUNT; k++)
		if (count[k])
			tool_say("%zu %s, %.2f %% of the area", count[k], primitive_kind_name[k], 100 * area[k] / r->facets->total_area);
	tool_say("%zu patches", r->count);
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

static void by_surfaces(struct regions *r, const struct dense *dense, const struct options *opt, const struct classic_options *classic)
{
	const double side = r->facets->side;
	const struct primitives_options options = {
		.distance = opt->tolerance.value > 0 ? tool_length_in_units(opt->tolerance, side) / side : 0,
		.least_area = opt->least_share,
	};
	struct primitives_report report;
	segment_primitives(r, &options, &report);
	tool_say("vertices lie %.3g off their surfaces (root mean square)", report.noise * side);
	for (int l = 0; l < PRIMITIVES_LEVELS; l++)
		if (report.area_share[l] > 0)
			tool_say("tolerance %.3g for %.2f %% of the area", report.distance[l] * side, 100 * report.area_share[l]);
	if (report.free_share > 0)
		tool_say("no surface explains %.2f %% of the area: divided by curvature", 100 * report.free_share);
	segment_free(r, dense, classic);
	regions_renumber(r);
}

static void by_curvature(struct regions *r, const struct dense *dense, const struct classic_options *classic)
{
	struct classic_report report;
	segment_classic(r, dense, classic, &report);
	tool_say("%d clusters of curvature, %zu regions grown, %zu united", report.clusters, report.grown, report.united);
}

int main(int argc, char **argv)
{
	tool_init("segment");
	const struct options opt = parse_options(argc, argv);
	struct ply ply;
	struct dense dense;
	struct fault fault = {0};
	const char *shown;
	tool_read_ply(&ply, opt.in, &shown);
	tool_check_schema(&ply, shown, "curv", CURV_SCHEMA);
	if (!dense_from_ply(&dense, &ply, false, shown, &fault))
		tool_fail(&fault);
	if (dense.triangle_count == 0)
		tool_die(EX_BAD_INPUT, "%s: no triangles to segment", shown);

	struct facets facets;
	struct regions regions;
	facets_build(&facets, &dense);
	regions_init(&regions, &facets);
	const double side = facets.side;
	const struct classic_options classic = {
		.clusters = opt.clusters, .stop = opt.merge, .least_area = opt.least_share, .charts_most = (size_t)opt.patches,
		.distance = opt.tolerance.value > 0 ? tool_length_in_units(opt.tolerance, side) / side : 5e-5,
	};
	if (opt.is_classic)
		by_curvature(&regions, &dense, &classic);
	else
		by_surfaces(&regions, &dense, &opt, &classic);
	tidy_measure(&regions, 0);
	report_patches(&regions);

	free(dense.label);
	free(dense.patch);
	dense.label = mem_copy(regions.label, dense.triangle_count, sizeof *dense.label);
	dense.patch = mem_copy(regions.patch, regions.count, sizeof *dense.patch);
	dense.patch_count = regions.count;
	for (size_t i = 0; i < dense.patch_count; i++) {
		facets_to_model(&facets, &dense.patch[i]);
		dense.patch[i].parent = (idx_t)i;
	}
	report_summary(&dense);
	dense_labels_to_ply(&ply, &dense);
	regions_free(&regions);
	facets_free(&facets);
	dense_free(&dense);

	char tolerance[NUM_TEXT_SIZE + 2] = "auto", clusters[NUM_TEXT_SIZE] = "auto";
	if (opt.tolerance.value > 0)
		snprintf(tolerance, sizeof tolerance, "%.9g%s", opt.tolerance.value, opt.tolerance.is_percent ? "%" : "");
	if (opt.clusters)
		snprintf(clusters, sizeof clusters, "%d", opt.clusters);
	if (opt.is_classic)
		tool_write_ply(&ply, &opt.common, SCHEMA, "mode=classic clusters=%s merge=%.9g amin=%.9g", clusters, opt.merge, opt.least_share);
	else
		tool_write_ply(&ply, &opt.common, SCHEMA, "mode=primitives tolerance=%s amin=%.9g patches=%d", tolerance, opt.least_share, opt.patches);
	ply_free(&ply);
	return EX_DONE;
}
