/* fitpatch: a network of curves and the dense mesh that it lies on go in, the local control polyhedron of every patch comes out,
 * fitted together to the mesh (quad/triangle inversion after Lavoue, Dupont and Baskurt 2005 to 2007). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh.h"
#include "stages/fitpatch/collapse.h"
#include "stages/fitpatch/facet.h"
#include "stages/fitpatch/local.h"
#include "stages/fitpatch/order.h"
#include "stages/fitpatch/rounds.h"
#include "stages/fitpatch/touchup.h"
#include "stages/geometry/border.h"
#include "stages/geometry/half.h"
#include "stages/geometry/sample.h"
#include "stages/geometry/vector.h"
#include "stages/tool/tool.h"

static const char usage[] =
	"usage: fitpatch --mesh mesh [-qv] [--tol length] [--mean length] [--level n]\n"
	"                [--iter n] [--rounds n] [--sd kind] [--no-fallback]\n"
	"                [--binary] [--no-provenance] [-o output] [file]\n"
	"Fit a control polyhedron to every patch that a network of curves bounds.\n"
	"  -m, --mesh FILE     the dense mesh with its patches (from rectify)\n"
	"  -t, --tol LENGTH    largest distance allowed (default 0.4%)\n"
	"      --mean LENGTH   mean distance allowed (default 0.1%)\n"
	"      --level N       subdivision steps before samples are taken (default 2)\n"
	"      --iter N        iterations of a fit (default 5)\n"
	"      --rounds N      rounds of refinement where the error is too large (default 6)\n"
	"      --sd KIND       squared distance: sided, abs, point or tangent (default sided)\n"
	"      --no-fallback   no facets and no edge collapse where the error stays too large\n"
	"  -o, --output FILE   write there instead of stdout\n"
	"      --binary        write binary PLY\n"
	"      --no-provenance leave out the comment line of this stage\n"
	"  -q, -v, --help, --version\n";

/* Reverse samples for a part: enough that a patch of a thousandth of the area gets a few. */
enum { SAMPLES = 6000, SCHEMA = 1 };
/* Free forms start with points inside (struct layout_context, detail): a dome over a few border points would only fold. */
enum { FREE_DETAIL = 3 };
/* Areas pass through text: equal but for the last digits. */
#define AREA_SLACK 1e-6

struct options {
	const char *mesh, *variant_name;
	struct tool_length max, mean;
	int level, iterations, rounds;
	bool no_fallback;
	enum sqdist_variant variant;
	struct tool_common common;
};

static int parse_options(struct options *options, int argc, char **argv)
{
	*options = (struct options){.variant_name = "sided", .max = {0.4, true}, .mean = {0.1, true}, .level = 2, .iterations = 5, .rounds = 6};
	const struct tool_option table[] = {
		{"mesh", 'm', TOOL_TEXT, &options->mesh, 0, 0},
		{"tol", 't', TOOL_LENGTH, &options->max, 0, 0},
		{"mean", 0, TOOL_LENGTH, &options->mean, 0, 0},
		{"level", 0, TOOL_INTEGER, &options->level, 1, 4},
		{"iter", 0, TOOL_INTEGER, &options->iterations, 0, 50},
		{"rounds", 0, TOOL_INTEGER, &options->rounds, 0, 50},
		{"no-fallback", 0, TOOL_FLAG, &options->no_fallback, 0, 0},
		{"sd", 0, TOOL_TEXT, &options->variant_name, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &options->common, 0, 1);
	static const char *const names[] = {"sided", "abs", "point", "tangent"};
	int found = -1;
	for (int i = 0; i < 4; i++)
		if (strcmp(options->variant_name, names[i]) == 0)
			found = i;
	if (found < 0)
		tool_die(EX_BAD_USAGE, "--sd must be sided, abs, point or tangent, not '%s'", options->variant_name);
	options->variant = (enum sqdist_variant)found;
	if (!options->mesh)
		tool_die(EX_BAD_USAGE, "--mesh is missing: which dense mesh do the patches lie on?");
	return first;
}

/* Patches travel with the network: those of another part, or of a mesh that was segmented anew, are told by number and area. */
static bool same_patches(const struct ply *document, const char *shown, const struct dense *dense, const char *mesh_shown, struct fault *fault)
{
	const struct ply_element *element = ply_element(document, "patch");
	const struct ply_column *area = element ? ply_column(element, "area") : NULL;
	if (!area || area->is_list)
		return true; /* a network by hand: its curves alone must fit */
	if (element->count != dense->patch_count)
		return fault_set(fault, EX_BAD_INPUT, "%s: %zu patches, but %s has %zu: files of different parts", shown, element->count, mesh_shown,
		                 dense->patch_count);
	for (size_t p = 0; p < dense->patch_count; p++)
		if (!(fabs(area->value[p] - dense->patch[p].area) <= AREA_SLACK * dense->patch[p].area))
			return fault_set(fault, EX_BAD_INPUT, "%s: patch %zu has area %.6g, but %.6g in %s: files of different parts", shown, p, area->value[p],
			                 dense->patch[p].area, mesh_shown);
	return true;
}

/* A control point farther away than this, in longest sides, was put there by mistake, or in another unit. */
#define FARTHEST_SIDES 10

static bool within_reach(const struct network *network, const struct dense *dense, double side, const char *shown, struct fault *fault)
{
	double low[3], high[3], middle[3];
	mesh_bounds(dense->xyz, dense->vertex_count, low, high);
	for (int k = 0; k < 3; k++)
		middle[k] = low[k] / 2 + high[k] / 2;
	for (size_t v = 0; v < network->vertex_count; v++)
		if (!(distance3(&network->xyz[3 * v], middle) <= FARTHEST_SIDES * side))
			return fault_set(fault, EX_BAD_INPUT, "%s: vertex %zu lies more than %d longest sides away from the mesh", shown, v, FARTHEST_SIDES);
	return true;
}

/* What a patch is called in the file; others than those of the mesh (-1: none) were not renamed. */
static idx_t number_in_file(const idx_t *former, const struct dense *dense, idx_t patch)
{
	return patch >= 0 && (size_t)patch < dense->patch_count ? former[patch] : patch;
}

/* All patches of the draft get the numbers of the file. */
static void restore_numbers(struct draft *draft, const idx_t *former, const struct dense *dense)
{
	for (size_t f = 0; f < draft->polygons.count; f++)
		draft->polygons.patch[f] = former[draft->polygons.patch[f]];
	for (size_t i = 0; i < draft->seam_count; i++)
		draft->seam[3 * i + 2] = former[draft->seam[3 * i + 2]];
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		struct curve *curve = &draft->network.curve[k];
		curve->left = number_in_file(former, dense, curve->left), curve->right = number_in_file(former, dense, curve->right);
	}
}

/* The border chain that each curve follows, for every one of them. */
static bool match_curves(idx_t *chain_of_curve, const struct border_network *border, const struct dense *dense, const struct network *network,
                         const idx_t *former, const char *shown, const char *mesh_shown, struct fault *fault)
{
	border_match(chain_of_curve, border, dense, network);
	for (size_t k = 0; k < network->curve_count; k++)
		if (chain_of_curve[k] == NO_INDEX)
			return fault_set(fault, EX_BAD_INPUT, "%s: curve %zu: %s has no such border between patches %" PRIidx " and %" PRIidx, shown, k, mesh_shown,
			                 number_in_file(former, dense, network->curve[k].left), number_in_file(former, dense, network->curve[k].right));
	return true;
}

/* A bound of the time. Rounds seldom get a scan within its bounds: the collapse after them should have its turn soon. */
static size_t most_work(const struct dense *dense)
{
	enum { PRIMITIVES = 15000, FREE_FORMS = 5000 };
	double area = 0, free_area = 0;
	for (size_t p = 0; p < dense->patch_count; p++) {
		area += dense->patch[p].area;
		free_area += dense->patch[p].kind == PATCH_FREE ? dense->patch[p].area : 0;
	}
	return (size_t)(rounds_work_share(dense) * (free_area > area / 2 ? FREE_FORMS : PRIMITIVES));
}

/* What a person should know of a part that did not become what the stage is for. */
static void report_fallback(const char *shown, const struct layouts *layouts, size_t patches, enum collapse collapse)
{
	size_t faceted = 0;
	for (size_t p = 0; p < patches; p++)
		faceted += layouts->faceted[p];
	if (collapse == COLLAPSE_FACETS)
		tool_warn("%s: no smooth cage is within the tolerance: the part is flat facets", shown);
	else if (faceted > 0)
		tool_warn("%s: %zu of %zu patches are flat facets: nothing smooth of few points followed them", shown, faceted, patches);
	if (collapse == COLLAPSE_SMOOTH)
		tool_say("%s: the cage is by edge collapse", shown);
}

int main(int argc, char **argv)
{
	tool_init("fitpatch");
	struct options options;
	const int first = parse_options(&options, argc, argv);
	struct fault fault = {0};

	struct ply document, mesh_document;
	const char *shown, *mesh_shown;
	tool_read_ply(&document, first < argc ? argv[first] : NULL, &shown);
	tool_check_schema(&document, shown, "fitcurves", 1);
	tool_read_ply(&mesh_document, options.mesh, &mesh_shown);
	tool_check_schema(&mesh_document, mesh_shown, "rectify", 1);
	struct network network;
	struct dense dense;
	struct half half;
	struct border_network border;
	if (!network_from_ply(&network, &document, "vertex", shown, &fault) || !dense_from_ply(&dense, &mesh_document, true, mesh_shown, &fault)
	    || !same_patches(&document, shown, &dense, mesh_shown, &fault))
		tool_fail(&fault);
	/* Messages about the input are over, which use the file's numbers, but for those that restore them. */
	idx_t *former = order_patches(&dense, &network);
	if (!half_build_triangles(&half, dense.triangle, dense.triangle_count, dense.vertex_count, &fault)
	    || !border_extract(&border, &dense, border_options_from_ply(&document), &fault))
		tool_die(fault.code, "%s: %s", mesh_shown, fault.text);

	const double side = mesh_bounds(dense.xyz, dense.vertex_count, NULL, NULL);
	const double max = tool_length_in_units(options.max, side), mean = tool_length_in_units(options.mean, side);
	idx_t *chain_of_curve = mem_array(network.curve_count, sizeof *chain_of_curve);
	if (!within_reach(&network, &dense, side, shown, &fault) || !match_curves(chain_of_curve, &border, &dense, &network, former, shown, mesh_shown, &fault))
		tool_fail(&fault);
	struct nearest *nearest = nearest_new_labelled(dense.xyz, dense.vertex_count, dense.triangle, dense.triangle_count, dense.label);

	struct draft draft;
	draft_start(&draft, &network);
	draft_sharpen(&draft, &dense);
	double *sample = mem_array(3 * SAMPLES, sizeof *sample);
	idx_t *sample_triangle = mem_array(SAMPLES, sizeof *sample_triangle);
	sample_surface(sample, sample_triangle, SAMPLES, dense.xyz, dense.triangle, dense.triangle_count, 1);
	idx_t *surface = mem_array(dense.triangle_count, sizeof *surface);
	for (size_t t = 0; t < dense.triangle_count; t++)
		surface[t] = dense.patch[dense.label[t]].parent;
	struct nearest *on_surface = nearest_new_labelled(dense.xyz, dense.vertex_count, dense.triangle, dense.triangle_count, surface);
	const struct target target = {&dense, nearest, surface, on_surface, &border, sample, sample_triangle, SAMPLES};
	size_t work = 0;
	const struct rounds rounds = {&target, &half, chain_of_curve, {options.iterations, options.level, options.variant}, {max, mean}, options.rounds, &work, most_work(&dense), former, tool_say};
	struct patch_error *error = mem_array(dense.patch_count, sizeof *error);
	struct layouts layouts = layouts_new(dense.patch_count, NULL);
	for (size_t p = 0; p < dense.patch_count; p++)
		layouts.detail[p] = dense.patch[p].kind == PATCH_FREE ? FREE_DETAIL : 0;
	size_t smooth = 0;
	if (!rounds_layout(&draft, &rounds, &layouts, NULL, &fault) || !rounds_fit(&draft, &layouts, error, &rounds, &fault))
		tool_die(fault.code, "%s: %s", shown, fault.text);
	if (options.rounds > 0)
		touch_up(&draft, &layouts, error, &rounds);
	/* What is out of bounds yet: facets for the patches concerned, or another cage for the whole part. */
	if (!options.no_fallback && options.rounds > 0) {
		if (facet_rest(&draft, &layouts, error, &rounds))
			touch_up(&draft, &layouts, error, &rounds);
		const enum collapse collapse = collapse_try(&draft, &layouts, error, &rounds);
		report_fallback(shown, &layouts, dense.patch_count, collapse);
	}
	if (!rounds_relax(&draft, error, &smooth, &rounds, &fault))
		tool_die(fault.code, "%s: %s", shown, fault.text);
	size_t tangential = 0;
	for (size_t k = 0; k < draft.network.curve_count; k++)
		tangential += draft.tangential[k];
	tool_say("%zu of %zu tangential curves are smooth", smooth, tangential);
	for (size_t p = 0; p < dense.patch_count; p++)
		tool_say("patch %zu kind %d: mean %.3g%% max %.3g%% of the longest side, normals %.2f degrees, worst at %.4g %.4g %.4g", (size_t)former[p], dense.patch[p].kind,
		         100 * error[p].mean / side, 100 * error[p].max / side, error[p].normal_deg, error[p].worst_point[0], error[p].worst_point[1],
		         error[p].worst_point[2]);
	restore_numbers(&draft, former, &dense);
	local_to_ply(&document, &draft);
	tool_write_ply(&document, &options.common, SCHEMA, "level=%d iter=%d sd=%s", options.level, options.iterations, options.variant_name);
	draft_free(&draft);
	layouts_free(&layouts);
	free(error), free(sample), free(sample_triangle), free(surface), free(former), free(chain_of_curve);
	nearest_free(nearest), nearest_free(on_surface);
	border_free(&border);
	half_free(&half);
	network_free(&network);
	dense_free(&dense);
	ply_free(&document), ply_free(&mesh_document);
	return EX_DONE;
}
