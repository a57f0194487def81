/* segment: the dense mesh in, the same with a patch for every triangle out.
 *
 * Analytic surfaces by growing and refitting, see segment(1). */
#include <stdlib.h>
#include <string.h>

#include "formats/dense.h"
#include "stages/segment/segment_primitives.h"
#include "stages/tool/tool.h"

#define SCHEMA 1
#define CURV_SCHEMA 1

static const char usage[] =
	"usage: segment [-qv] [--tolerance length] [--amin share]\n"
	"               [--binary] [--no-provenance] [-o file] [file]\n";

struct options {
	struct tool_common common;
	const char *in;
	struct tool_length tolerance; /* value 0: automatic */
	double least_share;
};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.least_share = 5e-4};
	const struct tool_option table[] = {
		{"tolerance", 't', TOOL_LENGTH, &opt.tolerance, 0, 0},
		{"amin", 'a', TOOL_NUMBER, &opt.least_share, 0, 0.1},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	return opt;
}

static void report_patches(const struct regions *r, const struct primitives_report *p, double side)
{
	size_t count[PATCH_KIND_COUNT] = {0};
	double area[PATCH_KIND_COUNT] = {0};
	if (!tool_is_verbose())
		return;
	for (size_t i = 0; i < r->count; i++) {
		count[r->patch[i].kind]++;
		area[r->patch[i].kind] += r->patch[i].area;
	}
	tool_say("noise %.3g (root mean square distance of vertices to their surfaces)", p->noise * side);
	for (int l = 0; l < PRIMITIVES_LEVELS; l++)
		if (p->area_share[l] > 0)
			tool_say("tolerance %.3g: %.2f %% of the area", p->distance[l] * side, 100 * p->area_share[l]);
	for (int k = 0; k < PATCH_KIND_COUNT; k++)
		if (count[k])
			tool_say("%zu %s, %.2f %% of the area", count[k], primitive_kind_name[k], 100 * area[k] / r->facets->total_area);
	tool_say("%zu patches", r->count);
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

	struct facets facets;
	struct regions regions;
	struct primitives_report report;
	facets_build(&facets, &dense);
	regions_init(&regions, &facets);
	const double side = facets.side;
	const struct primitives_options primitives = {
		.distance = opt.tolerance.value > 0 ? tool_length_in_units(opt.tolerance, side) / side : 0,
		.least_area = opt.least_share,
	};
	segment_primitives(&regions, &primitives, &report);
	report_patches(&regions, &report, side);

	free(dense.label);
	free(dense.patch);
	dense.label = mem_copy(regions.label, dense.triangle_count, sizeof *dense.label);
	dense.patch = mem_copy(regions.patch, regions.count, sizeof *dense.patch);
	dense.patch_count = regions.count;
	for (size_t i = 0; i < dense.patch_count; i++) {
		facets_to_model(&facets, &dense.patch[i]);
		dense.patch[i].parent = (idx_t)i;
	}
	dense_labels_to_ply(&ply, &dense);
	regions_free(&regions);
	facets_free(&facets);
	dense_free(&dense);
	if (opt.tolerance.value > 0)
		tool_write_ply(&ply, &opt.common, SCHEMA, "tolerance=%.6g amin=%.6g", primitives.distance * side, opt.least_share);
	else
		tool_write_ply(&ply, &opt.common, SCHEMA, "tolerance=auto amin=%.6g", opt.least_share);
	ply_free(&ply);
	return EX_DONE;
}
