/* Any mesh file to a clean mesh: triangles, manifold, oriented, with a count of every repair.
 * The preparation of the patch method, section 0.5 (stages/geometry/repair.h). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/export.h"
#include "formats/mesh.h"
#include "formats/number.h"
#include "stages/geometry/repair.h"
#include "stages/geometry/vector.h"
#include "stages/tool/tool.h"

#define WELD_DEFAULT 1e-6 /* of the diagonal of the box (section 0.5) */

struct options {
	struct tool_common common;
	const char *in, *report;
	struct tool_length weld;
	bool exact, check;
};

static const char usage[] =
	"usage: mend [-qv] [-w length | --exact] [--check] [--report file] [-o output] [--binary] [--no-provenance] [file]\n"
	"  -w, --weld length  unite border vertices within this distance, model units or % of the longest side\n"
	"                     (default 1e-6 of the diagonal)\n"
	"  --exact            unite equal positions only\n"
	"  --check            write no mesh; exit 1 when something would be repaired\n"
	"  --report file      write counts and components there, key=value lines\n"
	"  -o, --output f     write there instead of to stdout; the extension tells the format: ply, obj, off, stl, stla\n"
	"  --binary           write binary PLY\n"
	"  --no-provenance    accepted for uniformity: nothing names this tool in its output\n";

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {0};
	const struct tool_option table[] = {
		{"weld", 'w', TOOL_LENGTH, &opt.weld, 0, 0},
		{"exact", 0, TOOL_FLAG, &opt.exact, 0, 0},
		{"check", 0, TOOL_FLAG, &opt.check, 0, 0},
		{"report", 0, TOOL_TEXT, &opt.report, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	if (opt.exact && opt.weld.value > 0)
		tool_die(EX_BAD_USAGE, "--exact and --weld exclude each other");
	return opt;
}

static double weld_relative(const struct options *opt, const struct mesh *mesh)
{
	if (opt->exact)
		return 0;
	if (!(opt->weld.value > 0))
		return WELD_DEFAULT;
	double low[3], high[3];
	const double side = mesh_bounds(mesh->xyz, mesh->vertex_count, low, high), diagonal = distance3(low, high);
	return diagonal > 0 ? tool_length_in_units(opt->weld, side) / diagonal : 0;
}

/* What every file of its kind needs is no repair: an STL has its vertices three to a facet, and polygons are no damage. */
static bool is_conversion(enum repair_kind kind, bool is_stl)
{
	return kind == REPAIR_POLYGON_TRIANGULATED || (kind == REPAIR_WELDED_EXACT && is_stl);
}

static void write_whole(const char *path, const char *extension, const struct mesh *mesh, bool binary)
{
	struct fault fault = {0};
	struct output output;
	if (!output_open(&output, path, &fault))
		tool_fail(&fault);
	if (!export_mesh(output.file, extension, mesh, binary, &fault)) {
		output_drop(&output);
		tool_fail(&fault);
	}
	if (!output_commit(&output, &fault))
		tool_fail(&fault);
}

/* "zero-area face removed" -> "zero_area_face_removed" */
static void put_key(FILE *file, const char *name)
{
	for (; *name; name++)
		putc(*name == ' ' || *name == '-' ? '_' : *name, file);
}

static void write_report(const char *path, const struct repair_report *report)
{
	struct fault fault = {0};
	struct output output;
	if (!output_open(&output, path, &fault))
		tool_fail(&fault);
	for (int k = 0; k < REPAIR_KIND_COUNT; k++) {
		put_key(output.file, repair_name[k]);
		fprintf(output.file, "=%zu\n", report->count[k]);
	}
	fprintf(output.file, "components=%zu\n", report->component_count);
	for (size_t i = 0; i < report->component_count; i++) {
		const struct repair_component *c = &report->component[i];
		fprintf(output.file, "component.%zu.vertices=%zu\ncomponent.%zu.edges=%zu\ncomponent.%zu.faces=%zu\n", i,
			c->vertices, i, c->edges, i, c->faces);
		fprintf(output.file, "component.%zu.euler=%ld\ncomponent.%zu.borders=%zu\ncomponent.%zu.genus=%ld\n", i, c->euler,
			i, c->border_loops, i, c->genus);
		if (c->border_loops == 0) {
			char volume[NUM_TEXT_SIZE];
			num_print(volume, c->volume);
			fprintf(output.file, "component.%zu.volume=%s\n", i, volume);
		}
	}
	if (!output_commit(&output, &fault))
		tool_fail(&fault);
}

static void tell(const struct repair_report *report, const char *shown, bool is_stl)
{
	for (int k = 0; k < REPAIR_KIND_COUNT; k++) {
		if (report->count[k] == 0)
			continue;
		const char *what = report->count[k] == 1 ? repair_name[k] : repair_plural[k];
		if (is_conversion((enum repair_kind)k, is_stl))
			tool_say("%s: %zu %s", shown, report->count[k], what);
		else
			tool_warn("%s: %zu %s", shown, report->count[k], what);
	}
	for (size_t i = 0; tool_is_verbose() && i < report->component_count; i++) {
		const struct repair_component *c = &report->component[i];
		char volume[NUM_TEXT_SIZE] = "-";
		if (c->border_loops == 0)
			num_print(volume, c->volume);
		tool_say("%s: component %zu: V=%zu E=%zu F=%zu chi=%ld borders=%zu genus=%ld volume=%s", shown, i, c->vertices,
			 c->edges, c->faces, c->euler, c->border_loops, c->genus, volume);
	}
}

int main(int argc, char **argv)
{
	tool_init("mend");
	const struct options opt = parse_options(argc, argv);
	char extension[8] = "";
	if (opt.common.output)
		path_extension(extension, opt.common.output);
	if (!extension[0])
		strcpy(extension, "ply");
	if (!export_knows(extension))
		tool_die(EX_BAD_USAGE, "no writer for '.%s' files (ply, obj, off, stl, stla)", extension);

	struct fault fault = {0};
	struct input input;
	struct mesh mesh;
	if (!input_read(&input, opt.in, &fault) || !mesh_read(&mesh, &input, &fault))
		tool_fail(&fault);
	const bool is_stl = mesh_is_unwelded(&mesh);
	const struct repair_options repair = {weld_relative(&opt, &mesh)};
	struct repair_report report;
	if (!repair_mesh(&mesh, &repair, &report, &fault))
		tool_die(fault.code, "%s: %s", input.shown, fault.text);
	tell(&report, input.shown, is_stl);
	bool is_clean = true;
	for (int k = 0; k < REPAIR_KIND_COUNT; k++)
		is_clean = is_clean && (report.count[k] == 0 || is_conversion((enum repair_kind)k, is_stl));
	if (!opt.check)
		write_whole(opt.common.output, extension, &mesh, opt.common.binary);
	if (opt.report)
		write_report(opt.report, &report);
	mesh_free(&mesh);
	repair_report_free(&report);
	input_free(&input);
	return opt.check && !is_clean ? EX_NO : EX_DONE;
}
