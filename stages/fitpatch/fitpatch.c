/* fitpatch: a network of curves and the dense mesh that it lies on go in, the local control polyhedron of every patch comes out,
 * fitted together to the mesh (quad/triangle inversion after Lavoue, Dupont and Baskurt 2005 to 2007). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh.h"
#include "stages/fitpatch/anchor.h"
#include "stages/fitpatch/enrich.h"
#include "stages/fitpatch/joint.h"
#include "stages/fitpatch/layout.h"
#include "stages/fitpatch/local.h"
#include "stages/geometry/border.h"
#include "stages/geometry/half.h"
#include "stages/geometry/sample.h"
#include "stages/geometry/vector.h"
#include "stages/tool/tool.h"

static const char usage[] =
	"usage: fitpatch --mesh MESH.ply [options] [FILE]\n"
	"Fit a control polyhedron to every patch that a network of curves bounds.\n"
	"  -m, --mesh FILE     the dense mesh with its patches (from rectify)\n"
	"  -t, --tol LENGTH    largest distance allowed (default 0.4%)\n"
	"      --mean LENGTH   mean distance allowed (default 0.1%)\n"
	"      --level N       subdivision steps before samples are taken (default 2)\n"
	"      --iter N        iterations of a fit (default 5)\n"
	"      --rounds N      rounds of refinement where the error is too large (default 6)\n"
	"      --sd KIND       squared distance: sided, abs, point or tangent (default sided)\n"
	"  -o, --output FILE   write there instead of stdout\n"
	"      --binary        write binary PLY\n"
	"      --no-provenance leave out the comment line of this stage\n"
	"  -q, -v, --help, --version\n";

/* Reverse samples for a part: enough that a patch of a thousandth of the area gets a few. */
enum { SAMPLES = 6000, SCHEMA = 1 };

struct options {
	const char *mesh, *variant_name;
	struct tool_length max, mean;
	int level, iterations, rounds;
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

struct bounds {
	double max, mean; /* model units */
};

/* Fit, measure, and give more points to the patches that are out of bounds, until none is or the rounds are over. */
static bool fit_rounds(struct draft *draft, struct patch_error *error, const struct target *target, const struct joint_options *joint,
                       const struct bounds *bounds, int rounds, struct fault *fault)
{
	const struct dense *dense = target->dense;
	unsigned char *want = mem_array(dense->patch_count, 1);
	bool good = false;
	for (int round = 0;; round++) {
		double *face_error = mem_array(draft->polygons.count, sizeof *face_error);
		good = joint_fit(draft, target, joint, fault) && joint_measure(error, face_error, dense->patch_count, draft, target, fault);
		if (!good) {
			free(face_error);
			break;
		}
		double sum = 0, area = 0, worst = 0;
		for (size_t p = 0; p < dense->patch_count; p++) {
			sum += error[p].mean * dense->patch[p].area, area += dense->patch[p].area;
			worst = fmax(worst, error[p].max);
		}
		const double mean = area > 0 ? sum / area : 0;
		tool_say("round %d: %zu faces, mean %.4g, max %.4g (bounds %.4g, %.4g)", round, draft->polygons.count, mean, worst, bounds->mean, bounds->max);
		size_t wanted = 0;
		for (size_t p = 0; p < dense->patch_count; p++) {
			want[p] = error[p].max > bounds->max || (mean > bounds->mean && error[p].mean > bounds->mean);
			wanted += want[p];
		}
		const size_t steps = wanted && round < rounds ? enrich(draft, target, error, face_error, want, bounds->max) : 0;
		free(face_error);
		if (steps == 0)
			break;
		tool_say("%zu patches out of bounds, %zu refinements", wanted, steps);
	}
	free(want);
	return good;
}

/* Curves along which two surfaces join tangentially start as creases: a smooth rule there draws a coarse cage with very unlike
 * edge lengths far off its border. When everything fits, they are made smooth together, and those whose patches do not keep
 * their error go back. */
static bool relax_creases(struct draft *draft, struct patch_error *error, const unsigned char *candidate, const struct target *target,
                          const struct joint_options *joint, const struct bounds *bounds, struct fault *fault)
{
	const struct dense *dense = target->dense;
	struct network *network = &draft->network;
	double *kept = mem_copy(draft->control.xyz, 3 * draft->control.count, sizeof *kept);
	struct patch_error *now = mem_array(dense->patch_count, sizeof *now);
	size_t smooth = 0;
	for (size_t k = 0; k < network->curve_count; k++)
		if (candidate[k])
			network->curve[k].kind = CURVE_SMOOTH, smooth++;
	const size_t candidates = smooth;
	bool good = true;
	for (int pass = 0; smooth > 0 && pass < 6; pass++) {
		memcpy(draft->control.xyz, kept, 3 * draft->control.count * sizeof *kept);
		good = joint_fit(draft, target, joint, fault) && joint_measure(now, NULL, dense->patch_count, draft, target, fault);
		if (!good)
			break;
		size_t back = 0;
		for (size_t k = 0; k < network->curve_count; k++) {
			if (network->curve[k].kind != CURVE_SMOOTH || !candidate[k])
				continue;
			bool worse = pass == 5; /* patience ends with creases */
			for (int side_of = 0; side_of < 2; side_of++) {
				const idx_t p = side_of ? network->curve[k].right : network->curve[k].left;
				if (p >= 0)
					worse |= now[p].max > fmax(bounds->max / 2, 1.1 * error[p].max) || now[p].mean > fmax(bounds->mean / 2, 1.1 * error[p].mean);
			}
			if (worse)
				network->curve[k].kind = CURVE_SHARP, back++;
		}
		smooth -= back;
		if (back == 0)
			break;
	}
	if (good && smooth > 0) {
		memcpy(error, now, dense->patch_count * sizeof *now);
	} else if (good) {
		memcpy(draft->control.xyz, kept, 3 * draft->control.count * sizeof *kept);
	}
	if (candidates > 0)
		tool_say("%zu of %zu tangential curves are smooth", smooth, candidates);
	free(kept), free(now);
	return good;
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
	    || !half_build_triangles(&half, dense.triangle, dense.triangle_count, dense.vertex_count, &fault)
	    || !border_extract(&border, &dense, BORDER_DEFAULTS, &fault))
		tool_fail(&fault);

	const double side = mesh_bounds(dense.xyz, dense.vertex_count, NULL, NULL);
	const double max = tool_length_in_units(options.max, side), mean = tool_length_in_units(options.mean, side);
	idx_t *chain_of_curve = mem_array(network.curve_count, sizeof *chain_of_curve);
	border_match(chain_of_curve, &border, &dense, &network);
	struct anchors anchors;
	anchors_place(&anchors, &dense, &half, &border, &network, chain_of_curve);
	struct nearest *nearest = nearest_new(dense.xyz, dense.vertex_count, dense.triangle, dense.triangle_count);

	struct draft draft;
	draft_start(&draft, &network);
	unsigned char *tangential = mem_array(network.curve_count, 1);
	for (size_t k = 0; k < network.curve_count; k++) {
		const struct curve *curve = &network.curve[k];
		if (curve->kind != CURVE_SMOOTH || curve->left < 0 || curve->right < 0 || dense.patch[curve->left].parent == dense.patch[curve->right].parent)
			continue;
		tangential[k] = 1;
		draft.network.curve[k].kind = CURVE_SHARP;
	}
	struct edge_set *taken = edge_set_new();
	for (size_t k = 0; k < network.curve_count; k++) {
		const struct curve *curve = &network.curve[k];
		for (size_t i = 0; i + !curve->closed < curve->count; i++)
			edge_set_add(taken, network.point[curve->first + i], network.point[curve->first + (i + 1) % curve->count]);
	}
	struct layout_context context = {&dense, half.twin, nearest, &anchors, max, fmin(max / 2, mean), taken, &draft.control, &draft.polygons};
	size_t layouts[LAYOUT_KIND_COUNT] = {0};
	size_t *list_start;
	idx_t *list;
	label_lists(&list_start, &list, dense.label, dense.triangle_count, dense.patch_count);
	for (size_t p = 0; p < dense.patch_count; p++) {
		enum layout_kind kind;
		if (!layout_patch(&kind, &context, (idx_t)p, &list[list_start[p]], list_start[p + 1] - list_start[p], &fault))
			tool_fail(&fault);
		layouts[kind]++;
		tool_progress("patches", p + 1, dense.patch_count);
	}
	tool_say("%zu patches: %zu one face, %zu bands, %zu grids, %zu by chords; %zu control points, %zu faces", dense.patch_count,
	         layouts[LAYOUT_FACE], layouts[LAYOUT_BAND], layouts[LAYOUT_GRID], layouts[LAYOUT_CHORDS], draft.control.count, draft.polygons.count);

	double *sample = mem_array(3 * SAMPLES, sizeof *sample);
	idx_t *sample_triangle = mem_array(SAMPLES, sizeof *sample_triangle);
	sample_surface(sample, sample_triangle, SAMPLES, dense.xyz, dense.triangle, dense.triangle_count, 1);
	const struct target target = {&dense, nearest, &border, sample, sample_triangle, SAMPLES};
	const struct joint_options joint = {options.iterations, options.level, options.variant};
	struct patch_error *error = mem_array(dense.patch_count, sizeof *error);
	const struct bounds bounds = {max, mean};
	if (!fit_rounds(&draft, error, &target, &joint, &bounds, options.rounds, &fault)
	    || !relax_creases(&draft, error, tangential, &target, &joint, &bounds, &fault))
		tool_fail(&fault);
	for (size_t p = 0; p < dense.patch_count; p++)
		tool_say("patch %zu kind %d: mean %.3g%% max %.3g%% of the longest side, normals %.2f degrees, worst at %.4g %.4g %.4g", p, dense.patch[p].kind,
		         100 * error[p].mean / side, 100 * error[p].max / side, error[p].normal_deg, error[p].worst_point[0], error[p].worst_point[1],
		         error[p].worst_point[2]);
	local_to_ply(&document, &draft);
	tool_write_ply(&document, &options.common, SCHEMA, "level=%d iter=%d sd=%s", options.level, options.iterations, options.variant_name);
	return EX_DONE;
}
