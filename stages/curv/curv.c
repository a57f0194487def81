/* curv: any mesh file in, the clean dense mesh with sharp edges, wedges and curvatures out.
 *
 * Normal-cycle tensors (Cohen-Steiner and Morvan 2003) a wedge, see curv(1) and cagewright-dense(5). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/dense.h"
#include "formats/input.h"
#include "formats/mesh.h"
#include "stages/curv/curvature.h"
#include "stages/geometry/repair.h"
#include "stages/geometry/vector.h"
#include "stages/tool/tool.h"

#define SCHEMA 1

static const char usage[] =
	"usage: curv [-qv] [--sharp degrees] [--sharp-strict] [--radius length]\n"
	"            [--weld ratio] [--prep-only] [--binary] [--no-provenance]\n"
	"            [-o file] [file]\n";

struct options {
	struct tool_common common;
	const char *in;
	double sharp_deg;
	bool is_sharp_strict;
	struct tool_length radius; /* value 0: automatic */
	double weld_relative;      /* of the bounding box's diagonal */
	bool is_prep_only;
};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.sharp_deg = 40, .weld_relative = 1e-6};
	const struct tool_option table[] = {
		{"sharp", 's', TOOL_NUMBER, &opt.sharp_deg, 1, 180},
		{"sharp-strict", 0, TOOL_FLAG, &opt.is_sharp_strict, 0, 0},
		{"radius", 'r', TOOL_LENGTH, &opt.radius, 0, 0},
		{"weld", 'w', TOOL_NUMBER, &opt.weld_relative, 0, 0.01},
		{"prep-only", 0, TOOL_FLAG, &opt.is_prep_only, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	return opt;
}

/* Repairs that every sound file of some format needs are told only when asked for. */
static void report_repairs(const struct repair_report *report, const char *shown)
{
	for (int kind = 0; kind < REPAIR_KIND_COUNT; kind++) {
		if (report->count[kind] == 0)
			continue;
		if (kind == REPAIR_WELDED_EXACT || kind == REPAIR_POLYGON_TRIANGULATED || kind == REPAIR_UNUSED_VERTEX)
			tool_say("%s: %zu %s", shown, report->count[kind], repair_name[kind]);
		else
			tool_warn("%s: %zu %s", shown, report->count[kind], repair_name[kind]);
	}
	for (size_t i = 0; i < report->component_count; i++) {
		const struct repair_component *c = &report->component[i];
		tool_say("component %zu: %zu vertices, %zu edges, %zu faces, euler %ld, border loops %zu, genus %ld, volume %g", i, c->vertices, c->edges,
		         c->faces, c->euler, c->border_loops, c->genus, c->volume);
	}
}

static void report_result(const struct dense *dense, const struct sharp_counts *sharp)
{
	size_t edge[4] = {0}, quality[4] = {0};
	for (size_t i = 0; i < dense->edge_count; i++)
		edge[dense->edge[i].kind]++;
	for (size_t w = 0; w < dense->wedge_count; w++)
		quality[dense->quality[w]]++;
	tool_say("edges: %zu sharp, %zu border, %zu cut", edge[EDGE_SHARP], edge[EDGE_BORDER], edge[EDGE_CUT]);
	tool_say("sharp edges: %zu over the angle, less %zu in regular bends and %zu alone, %zu added to open chains", sharp->over_angle,
	         sharp->regular, sharp->lonely, sharp->extended);
	size_t sharpest = dense->edge_count;
	for (size_t i = 0; i < dense->edge_count; i++)
		if (dense->edge[i].kind == EDGE_SHARP && (sharpest == dense->edge_count || fabs(dense->edge[i].angle_deg) > fabs(dense->edge[sharpest].angle_deg)))
			sharpest = i;
	if (sharpest < dense->edge_count) {
		const double *x = dense->xyz + 3 * (size_t)dense->edge[sharpest].vertex1;
		tool_say("sharpest bend: %.4g degrees at %.6g %.6g %.6g", dense->edge[sharpest].angle_deg, x[0], x[1], x[2]);
	}
	tool_say("wedges: %zu, %zu good, %zu isotropic, %zu flat, %zu singular", dense->wedge_count, quality[WEDGE_GOOD], quality[WEDGE_ISOTROPIC],
	         quality[WEDGE_FLAT], quality[WEDGE_SINGULAR]);
}

/* Only vertex and face, for --prep-only. */
static void put_mesh(struct ply *document, const struct mesh *mesh)
{
	ply_put_points(ply_put_element(document, "vertex", mesh->vertex_count), mesh->xyz);
	double *corner = mem_array(mesh->face_start[mesh->face_count], sizeof *corner);
	for (size_t i = 0; i < mesh->face_start[mesh->face_count]; i++)
		corner[i] = mesh->corner[i];
	ply_put_list(ply_put_element(document, "face", mesh->face_count), "vertex_indices", PLY_INT32, mesh->face_start, corner);
	free(corner);
}

/* True for an element that curv makes anew, or that a later stage made from what curv makes anew. */
static bool is_ours(const char *name)
{
	static const char *const ours[] = {"vertex", "face", "wedge", "edge", "patch"};
	for (size_t i = 0; i < sizeof ours / sizeof *ours; i++)
		if (strcmp(name, ours[i]) == 0)
			return true;
	return false;
}

/* A PLY file's comments are passed on. Its other elements may name vertices by number and would be wrong beside the
 * vertices of a repaired mesh: they are dropped, and that is said. */
static void take_document(struct ply *document, const struct input *input)
{
	struct fault ignored = {0};
	ply_init(document);
	if (input->size < 4 || memcmp(input->data, "ply", 3) != 0)
		return;
	if (!ply_read(document, input, &ignored)) { /* mesh_read has judged the file already */
		ply_free(document);
		ply_init(document);
		return;
	}
	document->encoding = PLY_ASCII;
	while (document->element_count > 0) {
		if (!is_ours(document->element[0].name))
			tool_warn("%s: element '%s' dropped", input->shown, document->element[0].name);
		ply_drop_element(document, document->element[0].name);
	}
}

int main(int argc, char **argv)
{
	tool_init("curv");
	const struct options opt = parse_options(argc, argv);
	struct fault fault = {0};
	struct input input;
	struct mesh mesh;
	struct ply document;
	if (!input_read(&input, opt.in, &fault) || !mesh_read(&mesh, &input, &fault))
		tool_fail(&fault);
	const char *shown = input.shown;
	take_document(&document, &input);
	input_free(&input);

	struct repair_report report;
	const struct repair_options repair = {opt.weld_relative};
	if (!repair_mesh(&mesh, &repair, &report, &fault))
		tool_die(fault.code, "%s: %s", shown, fault.text);
	report_repairs(&report, shown);
	if (opt.is_prep_only) {
		put_mesh(&document, &mesh);
		tool_write_ply(&document, &opt.common, SCHEMA, "prep-only");
	} else {
		const double side = mesh_bounds(mesh.xyz, mesh.vertex_count, NULL, NULL);
		const double radius = opt.radius.value > 0 ? tool_length_in_units(opt.radius, side) : 0;
		const struct curvature_options how = {{opt.sharp_deg / DEGREES, opt.is_sharp_strict}, radius};
		struct dense dense;
		struct sharp_counts counts;
		if (!curvature_compute(&dense, &counts, &mesh, report.cut, report.cut_count, &how, &fault))
			tool_die(fault.code, "%s: %s", shown, fault.text);
		report_result(&dense, &counts);
		dense_to_ply(&document, &dense);
		if (radius > 0)
			tool_write_ply(&document, &opt.common, SCHEMA, "sharp=%gdeg%s radius=%g", opt.sharp_deg, opt.is_sharp_strict ? " strict" : "", radius);
		else
			tool_write_ply(&document, &opt.common, SCHEMA, "sharp=%gdeg%s radius=auto", opt.sharp_deg, opt.is_sharp_strict ? " strict" : "");
		dense_free(&dense);
	}
	repair_report_free(&report);
	mesh_free(&mesh);
	ply_free(&document);
	return EX_DONE;
}
