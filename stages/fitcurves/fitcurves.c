/* fitcurves: a segmented mesh in, the network of subdivision curves along its patch borders out.
 *
 * Squared-distance minimisation with as few control points as the tolerance allows, see fitcurves(1) and
 * cagewright-network(5). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/dense.h"
#include "formats/network.h"
#include "formats/number.h"
#include "stages/fitcurves/netfit.h"
#include "stages/geometry/border.h"
#include "stages/tool/tool.h"

#define SCHEMA 1
/* Newest schemas of the files that are read. */
#define KNOWN_DENSE_SCHEMA 1
/* Squares of lengths, and squares of these, stay within the range of double. */
#define LEAST_SIDE 1e-60
#define MOST_SIDE 1e60

static const char usage[] = "usage: fitcurves [-qv] [--tol length] [--mean length] [--corner degrees]\n"
			    "                 [--smooth degrees] [--free-counts] [--binary]\n"
			    "                 [--no-provenance] [-o file] [file]\n";

struct options {
	struct tool_common common;
	const char *in;
	struct tool_length tol, mean; /* of the whole surface; curves get half of them */
	double corner_deg, smooth_deg;
	bool free_counts;
};

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.tol = {0.4, true}, .mean = {0.1, true}, .corner_deg = 45, .smooth_deg = 8};
	const struct tool_option table[] = {
		{"tol", 't', TOOL_LENGTH, &opt.tol, 0, 0},
		{"mean", 'm', TOOL_LENGTH, &opt.mean, 0, 0},
		{"corner", 'c', TOOL_NUMBER, &opt.corner_deg, 10, 120},
		{"smooth", 's', TOOL_NUMBER, &opt.smooth_deg, 0, 90},
		{"free-counts", 0, TOOL_FLAG, &opt.free_counts, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 0, 1);
	opt.in = first < argc ? argv[first] : NULL;
	return opt;
}

static double longest_side(const struct dense *dense)
{
	double side = 0;
	for (size_t k = 0; k < 3; k++) {
		double low = INFINITY, high = -INFINITY;
		for (size_t v = 0; v < dense->vertex_count; v++)
			low = fmin(low, dense->xyz[3 * v + k]), high = fmax(high, dense->xyz[3 * v + k]);
		side = fmax(side, high - low);
	}
	return side;
}

/* A length option as it was given, for the header. */
static const char *length_text(char text[NUM_TEXT_SIZE + 1], struct tool_length length)
{
	const size_t end = num_print(text, length.value);
	if (length.is_percent)
		text[end] = '%', text[end + 1] = 0;
	return text;
}

/* What the cage's Euler characteristic must be; assemble(1) looks at it. */
static void put_euler(struct ply *document, long euler)
{
	static const char key[] = "comment cagewright-euler ";
	size_t kept = 0;
	for (size_t c = 0; c < document->comment_count; c++) {
		if (strncmp(document->comment[c], key, sizeof key - 1) == 0)
			free(document->comment[c]);
		else
			document->comment[kept++] = document->comment[c];
	}
	document->comment_count = kept;
	ply_comment(document, "cagewright-euler %ld", euler);
}

int main(int argc, char **argv)
{
	tool_init("fitcurves");
	const struct options opt = parse_options(argc, argv);
	struct ply document;
	struct dense dense;
	struct fault fault = {0};
	const char *shown;
	tool_read_ply(&document, opt.in, &shown);
	tool_check_schema(&document, shown, "curv", KNOWN_DENSE_SCHEMA);
	tool_check_schema(&document, shown, "segment", KNOWN_DENSE_SCHEMA);
	tool_check_schema(&document, shown, "rectify", KNOWN_DENSE_SCHEMA);
	if (!dense_from_ply(&dense, &document, true, shown, &fault))
		tool_fail(&fault);
	const double side = longest_side(&dense);
	if (!(side > LEAST_SIDE && side < MOST_SIDE))
		tool_die(EX_BAD_INPUT, "%s: the longest side of the part, %g, cannot be computed with", shown, side);
	struct border_options border_options = BORDER_DEFAULTS;
	border_options.corner_deg = opt.corner_deg;
	border_options.smooth_deg = opt.smooth_deg;
	struct border_network border;
	if (!border_extract(&border, &dense, border_options, &fault))
		tool_die(fault.code, "%s: %s", shown, fault.text);
	struct netfit_options options = {
		.max = tool_length_in_units(opt.tol, side) / 2,
		.mean = tool_length_in_units(opt.mean, side) / 2,
		.free_counts = opt.free_counts,
	};
	struct network network;
	struct netfit_report report;
	netfit(&network, &report, &dense, &border, options);
	if (report.missed > 0)
		tool_warn("%s: %zu of %zu curves outside the tolerance, by at most %g", shown, report.missed, report.curves,
			  report.worst);
	tool_say("%s: %zu curves (%zu closed, %zu straight), %zu nodes, %zu control points", shown, report.curves, report.closed,
		 report.straight, report.nodes, report.points);
	tool_say("%s: %zu curves harmonised, %zu contracted, %zu relaxed, %zu smoothed, %zu points added for the rules, %zu "
		 "against crossings, %zu interior sharp "
		 "edges left out",
		 shown, report.harmonised, report.contracted, report.relaxed, report.smoothed, report.split, report.uncrossed,
		 border.dart_edge_count);
	tool_say("%s: largest error %g (%.4f%% of the longest side)", shown, report.error,
		 side > 0 ? 100 * report.error / side : 0);

	ply_drop_element(&document, "face");
	ply_drop_element(&document, "wedge");
	network_to_ply(&document, &network, "vertex");
	border_options_to_ply(&document, border_options);
	put_euler(&document, border.euler);
	char tol[NUM_TEXT_SIZE + 1], mean[NUM_TEXT_SIZE + 1], corner[NUM_TEXT_SIZE], smooth[NUM_TEXT_SIZE];
	num_print(corner, opt.corner_deg);
	num_print(smooth, opt.smooth_deg);
	tool_write_ply(&document, &opt.common, SCHEMA, "tol=%s mean=%s corner=%sdeg smooth=%sdeg%s", length_text(tol, opt.tol),
		       length_text(mean, opt.mean), corner, smooth, opt.free_counts ? " free-counts" : "");
	network_free(&network);
	border_free(&border);
	dense_free(&dense);
	ply_free(&document);
	return EX_DONE;
}
