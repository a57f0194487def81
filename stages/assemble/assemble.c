/* assemble: local cages of patches in, one welded cage with creases and corners out.
 *
 * See assemble(1) and cagewright-cage(5). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/cage.h"
#include "formats/dense.h"
#include "formats/network.h"
#include "formats/number.h"
#include "stages/assemble/polymesh.h"
#include "stages/assemble/tidy.h"
#include "stages/assemble/unfold.h"
#include "stages/assemble/weld.h"
#include "stages/tool/tool.h"

#define SCHEMA 1
#define KNOWN_FITPATCH_SCHEMA 1
#define UNFOLD_STEPS 4 /* the level at which parts are measured and unpacked by default */

static const char usage[] = "usage: assemble [-qv] [--planar length] [--no-tidy] [--no-unfold] [--binary]\n"
			    "                [--no-provenance] [-o file] [file]\n";

struct options {
	struct tool_common common;
	const char *in;
	struct tool_length planar; /* faces this near to one plane are one face */
	bool no_tidy, no_unfold;
};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.planar = {0.02, true}};
	const struct tool_option table[] = {
		{"planar", 'p', TOOL_LENGTH, &opt.planar, 0, 0},
		{"no-tidy", 0, TOOL_FLAG, &opt.no_tidy, 0, 0},
		{"no-unfold", 0, TOOL_FLAG, &opt.no_unfold, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	return opt;
}

static double longest_side(const struct polymesh *mesh)
{
	double side = 0;
	for (size_t k = 0; k < 3; k++) {
		double low = INFINITY, high = -INFINITY;
		for (size_t v = 0; v < mesh->vertex_count; v++)
			low = fmin(low, mesh->xyz[3 * v + k]), high = fmax(high, mesh->xyz[3 * v + k]);
		side = fmax(side, high - low);
	}
	return side;
}

/* "comment cagewright-euler N": the sum over the components of the mesh that the cage stands for. */
static bool wanted_euler(const struct ply *document, long *euler)
{
	static const char key[] = "comment cagewright-euler ";
	for (size_t c = 0; c < document->comment_count; c++) {
		const char *text = document->comment[c];
		long long value;
		if (strncmp(text, key, sizeof key - 1) == 0 &&
		    num_parse_integer(text + sizeof key - 1, strlen(text) - (sizeof key - 1), -1000000000, 1000000000, &value)) {
			*euler = (long)value;
			return true;
		}
	}
	return false;
}

/* Euler characteristics as the mesh has them now; ends the program when their sum is not the wanted one. */
static void check_euler(const struct polymesh *mesh, const struct ply *document, const char *shown, bool report)
{
	long *euler, sum = 0, wanted;
	const size_t count = polymesh_euler(&euler, mesh);
	for (size_t i = 0; i < count; i++) {
		sum += euler[i];
		if (report)
			tool_say("%s: component %zu: euler %ld", shown, i, euler[i]);
	}
	free(euler);
	if (wanted_euler(document, &wanted) && wanted != sum)
		tool_die(EX_BAD_INPUT, "%s: the cage's euler characteristic is %ld, the part's %ld", shown, sum, wanted);
}

/* The surfaces of the patches, by number; NULL when the file does not say. */
static struct dense_patch *read_patches(const struct ply *document, const struct cage *cage)
{
	static const char *const name[] = {"kind", "px", "py", "pz", "ax", "ay", "az", "radius", "radius2", "sign"};
	enum { COLUMNS = sizeof name / sizeof *name };
	const double *value[COLUMNS];
	size_t count = 0;
	for (size_t f = 0; f < cage->face_count; f++)
		if ((size_t)cage->face_patch[f] >= count)
			count = (size_t)cage->face_patch[f] + 1;
	const struct ply_element *element = ply_element(document, "patch");
	if (!element || element->count < count)
		return NULL;
	for (size_t c = 0; c < COLUMNS; c++) {
		const struct ply_column *column = ply_column(element, name[c]);
		if (!column || column->is_list)
			return NULL;
		value[c] = column->value;
	}
	struct dense_patch *patch = mem_array(element->count, sizeof *patch);
	for (size_t p = 0; p < element->count; p++) {
		patch[p] = (struct dense_patch){.kind = PATCH_FREE, .radius = value[7][p], .radius2 = value[8][p], .sign = value[9][p], .parent = (idx_t)p};
		if (value[0][p] >= 0 && value[0][p] < PATCH_KIND_COUNT)
			patch[p].kind = (enum patch_kind)value[0][p];
		for (size_t k = 0; k < 3; k++)
			patch[p].point[k] = value[1 + k][p], patch[p].axis[k] = value[4 + k][p];
	}
	return patch;
}

int main(int argc, char **argv)
{
	tool_init("assemble");
	const struct options opt = parse_options(argc, argv);
	struct ply document;
	struct cage local, cage;
	struct network network;
	struct polymesh mesh;
	struct weld_report welded;
	struct fault fault = {0};
	const char *shown;
	tool_read_ply(&document, opt.in, &shown);
	tool_check_schema(&document, shown, "fitpatch", KNOWN_FITPATCH_SCHEMA);
	if (!cage_from_ply(&local, &document, shown, &fault) || !network_from_ply(&network, &document, "netpoint", shown, &fault))
		tool_fail(&fault);
	if (!local.net)
		tool_die(EX_BAD_INPUT, "%s: element 'vertex' has no property 'net'", shown);
	if (!weld(&mesh, &welded, &local, &network, &fault))
		tool_die(fault.code, "%s: %s", shown, fault.text);
	if (welded.unused > 0)
		tool_warn("%s: %zu network points that no face uses were left out", shown, welded.unused);
	if (welded.split > 0)
		tool_warn("%s: %zu vertices added where several fans of faces met in one", shown, welded.split);
	check_euler(&mesh, &document, shown, false);
	struct tidy_report tidied = {0};
	if (opt.no_tidy)
		tidied.dissolved = tidy_dissolve(&mesh);
	else
		tidy(&tidied, &mesh, tool_length_in_units(opt.planar, longest_side(&mesh)));
	check_euler(&mesh, &document, shown, true);
	polymesh_to_cage(&cage, &mesh);
	if (!opt.no_tidy && !opt.no_unfold) {
		struct unfold_report unfolded;
		struct dense_patch *patch = read_patches(&document, &cage);
		unfold(&unfolded, &cage, patch, tool_length_in_units(opt.planar, longest_side(&mesh)), UNFOLD_STEPS);
		tool_say("%s: %zu faces folded over, %zu do still: %zu edges became creases, %zu were redrawn, %zu vertices added", shown,
			 unfolded.folded, unfolded.left, unfolded.creased, unfolded.redrawn, unfolded.added);
		free(patch);
	}
	size_t corners = 0;
	for (size_t v = 0; v < cage.vertex_count; v++)
		corners += cage.corner[v];
	tool_say("%s: %zu vertices dissolved, %zu faces joined, %zu crease vertices dropped", shown, tidied.dissolved,
		 tidied.merged, tidied.straightened);
	tool_say("%s: %zu vertices, %zu faces, %zu creases, %zu border edges, %zu explicit corners", shown, cage.vertex_count,
		 cage.face_count, cage.sharp_count, welded.border, corners);

	/* the network's points and curves are the cage's now; what the clean-up took away they would still name */
	ply_drop_element(&document, "netpoint");
	ply_drop_element(&document, "curve");
	ply_drop_element(&document, "edge");
	struct ply_element *vertex = ply_element(&document, "vertex");
	ply_drop_column(vertex, "net");
	cage_to_ply(&document, &cage);
	char planar[NUM_TEXT_SIZE + 1];
	const size_t end = num_print(planar, opt.planar.value);
	if (opt.planar.is_percent)
		planar[end] = '%', planar[end + 1] = 0;
	tool_write_ply(&document, &opt.common, SCHEMA, "planar=%s%s%s", planar, opt.no_tidy ? " no-tidy" : "",
		      opt.no_unfold ? " no-unfold" : "");
	cage_free(&cage), cage_free(&local);
	network_free(&network);
	polymesh_free(&mesh);
	ply_free(&document);
	return EX_DONE;
}
