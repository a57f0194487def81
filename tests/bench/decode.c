/* decode: how fast streams become cages and surfaces, on one core.
 *
 * usage: decode [-qv] [-o output] [--rounds n] stream...
 * A row for each stream: milliseconds to its cage and to level 4, from bytes in memory to arrays in memory; millions of vertices
 * a second from the cage to level 5; and, where the program is built with OpenSubdiv, the same from the same cage by the rules of
 * Catmull and Clark, which both know: ours, OpenSubdiv's, and how many times faster ours is. Nothing is kept from one time to the
 * next, and memory goes back to the system in between, as in a program that decodes one stream. All kinds take turns within a
 * round; a figure is the median of the rounds, in columns that end in _best the best one. Processor time, so that other programs
 * on the machine disturb little. */
#include <malloc.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "formats/cage.h"
#include "formats/ffx.h"
#include "stages/geometry/subdivide.h"
#include "stages/tool/tool.h"

#include "tests/bench/decode_opensubdiv.h"

#define SHOWN_LEVEL 4
#define FINE_LEVEL 5

/* What is timed, seconds. */
enum timed { TO_CAGE, TO_LEVEL, REFINE, REFINE_CC, REFINE_OSD, RATIO, TIMED_COUNT };

struct options {
	int rounds;
	struct tool_common common;
};

static const char usage[] = "usage: decode [-qv] [-o output] [--rounds n] stream...\n"
			    "  --rounds n      times that each is measured (default 101)\n";

static double now(void)
{
	struct timespec t;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
	return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One core from here on: the one that we are on. */
static void stay_on_core(void)
{
	cpu_set_t set;
	CPU_ZERO(&set);
	CPU_SET(sched_getcpu(), &set);
	sched_setaffinity(0, sizeof set, &set);
}

static void stop_on(const struct fault *fault, const char *shown)
{
	if (fault->code)
		tool_die(fault->code, "%s: %s", shown, fault->text);
}

/* Stream to cage, and on to a level where level is not NULL. */
static double decode_once(struct cage *cage, struct level *level, const struct input *input)
{
	struct fault fault = {0};
	const double before = now();
	struct ffx ffx;
	if (!ffx_decode(&ffx, input->data, input->size, input->shown, &fault))
		tool_fail(&fault);
	ffx_to_cage(cage, &ffx);
	ffx_free(&ffx);
	if (level) {
		struct level base;
		level_from_cage(&base, cage, &fault);
		stop_on(&fault, input->shown);
		level_refine(level, &base, cage->scheme, SHOWN_LEVEL);
		level_free(&base);
	}
	return now() - before;
}

static double refine_once(size_t *vertices, double sum[2], const struct cage *cage, enum cage_scheme scheme, const char *shown)
{
	struct fault fault = {0};
	const double before = now();
	struct level base, level;
	level_from_cage(&base, cage, &fault);
	stop_on(&fault, shown);
	level_refine(&level, &base, scheme, FINE_LEVEL);
	level_free(&base);
	const double seconds = now() - before;
	*vertices = level.vertex_count;
	sum[0] = sum[1] = 0;
	for (size_t i = 0; i < 3 * level.vertex_count; i++) {
		sum[0] += level.xyz[i];
		sum[1] += level.xyz[i] * level.xyz[i];
	}
	level_free(&level);
	return seconds;
}

static int compare_seconds(const void *left, const void *right)
{
	const double a = *(const double *)left, b = *(const double *)right;
	return (a > b) - (a < b);
}

static void osd_cage_make(struct osd_cage *osd, const struct cage *cage)
{
	const size_t corner_count = cage->face_start[cage->face_count];
	float *xyz = mem_array(3 * cage->vertex_count, sizeof *xyz);
	for (size_t i = 0; i < 3 * cage->vertex_count; i++)
		xyz[i] = (float)cage->xyz[i];
	int *degree = mem_array(cage->face_count, sizeof *degree), *corner = mem_array(cage->vertex_count, sizeof *corner);
	for (size_t f = 0; f < cage->face_count; f++)
		degree[f] = (int)(cage->face_start[f + 1] - cage->face_start[f]);
	int corners = 0;
	for (size_t v = 0; cage->corner && v < cage->vertex_count; v++)
		if (cage->corner[v])
			corner[corners++] = (int)v;
	*osd = (struct osd_cage){.vertex_count = (int)cage->vertex_count,
				 .face_count = (int)cage->face_count,
				 .sharp_count = (int)cage->sharp_count,
				 .corner_count = corners,
				 .xyz = xyz,
				 .face_degree = degree,
				 .face_vertex = mem_copy(cage->face_corner, corner_count, sizeof *cage->face_corner),
				 .sharp = mem_copy(cage->sharp, 2 * cage->sharp_count, sizeof *cage->sharp),
				 .corner = corner};
}

static void osd_cage_free(struct osd_cage *osd)
{
	free((void *)osd->xyz);
	free((void *)osd->face_degree);
	free((void *)osd->face_vertex);
	free((void *)osd->sharp);
	free((void *)osd->corner);
}

/* The same surface: as many vertices, the same sums as far as single precision goes. */
static void check_same(size_t ours, const double sum[2], size_t theirs, const double osd_sum[2], const char *shown)
{
	const double room = 1e-4 * sqrt(sum[1] * 3 * (double)ours), square_room = 1e-4 * sum[1];
	if (ours != theirs || !(fabs(sum[0] - osd_sum[0]) <= room && fabs(sum[1] - osd_sum[1]) <= square_room))
		tool_die(EX_BUG,
			 "%s: OpenSubdiv has another surface: %zu and %zu vertices, sums %.9g and %.9g, of squares %.9g and %.9g",
			 shown, ours, theirs, sum[0], osd_sum[0], sum[1], osd_sum[1]);
}

int main(int argc, char **argv)
{
	tool_init("decode");
	struct options opt = {.rounds = 101};
	const struct tool_option table[] = {{"rounds", 'n', TOOL_INTEGER, &opt.rounds, 1, 100000}, {0}};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 1, argc);
	/* constant, so that the allocator does not learn to keep large pieces */
	mallopt(M_MMAP_THRESHOLD, 128 * 1024);
	mallopt(M_TRIM_THRESHOLD, 128 * 1024);
	stay_on_core();
	struct fault fault = {0};
	struct output output;
	if (!output_open(&output, opt.common.output, &fault))
		tool_fail(&fault);
	fputs("stream\tbytes\tcage_vertices\tcage_ms\tcage_ms_best\tlevel4_ms\tlevel4_ms_best\tlevel5_vertices\tlevel5_Mv_"
	      "s\tlevel5_Mv_s_best",
	      output.file);
	fputs("\tcc_vertices\tcc_Mv_s\tosd_Mv_s\tcc_by_osd\n", output.file);
	double *seconds[TIMED_COUNT];
	for (int k = 0; k < TIMED_COUNT; k++)
		seconds[k] = mem_array((size_t)opt.rounds, sizeof **seconds);
	for (int i = first; i < argc; i++) {
		struct input input;
		if (!input_read(&input, argv[i], &fault))
			tool_fail(&fault);
		struct cage cage;
		decode_once(&cage, NULL, &input);
		size_t vertices = 0, cc_vertices = 0;
		double sum[2];
		struct osd_cage osd;
		osd_cage_make(&osd, &cage);
		for (int r = 0; r < opt.rounds; r++) {
			struct cage again;
			struct level level;
			malloc_trim(0);
			seconds[TO_CAGE][r] = decode_once(&again, NULL, &input);
			cage_free(&again);
			malloc_trim(0);
			seconds[TO_LEVEL][r] = decode_once(&again, &level, &input);
			level_free(&level);
			cage_free(&again);
			malloc_trim(0);
			seconds[REFINE][r] = refine_once(&vertices, sum, &cage, cage.scheme, input.shown);
			malloc_trim(0);
			seconds[REFINE_CC][r] = refine_once(&cc_vertices, sum, &cage, SCHEME_CATMULLCLARK, input.shown);
			if (!osd_refine)
				continue;
			size_t osd_vertices;
			double osd_sum[2];
			malloc_trim(0);
			seconds[REFINE_OSD][r] = osd_refine(&osd_vertices, osd_sum, &osd, FINE_LEVEL);
			if (seconds[REFINE_OSD][r] < 0)
				tool_die(EX_BUG, "%s: OpenSubdiv does not take this cage", input.shown);
			check_same(cc_vertices, sum, osd_vertices, osd_sum, input.shown);
			seconds[RATIO][r] = seconds[REFINE_OSD][r] / seconds[REFINE_CC][r];
		}
		double median[TIMED_COUNT], best[TIMED_COUNT];
		for (int k = 0; k < TIMED_COUNT; k++) {
			qsort(seconds[k], (size_t)opt.rounds, sizeof **seconds, compare_seconds);
			median[k] = seconds[k][opt.rounds / 2];
			best[k] = seconds[k][0];
		}
		fprintf(output.file, "%s\t%zu\t%zu\t%.3f\t%.3f\t%.3f\t%.3f\t%zu\t%.1f\t%.1f", input.shown, input.size,
			cage.vertex_count, 1e3 * median[TO_CAGE], 1e3 * best[TO_CAGE], 1e3 * median[TO_LEVEL],
			1e3 * best[TO_LEVEL], vertices, 1e-6 * (double)vertices / median[REFINE],
			1e-6 * (double)vertices / best[REFINE]);
		fprintf(output.file, "\t%zu\t%.1f", cc_vertices, 1e-6 * (double)cc_vertices / median[REFINE_CC]);
		if (osd_refine)
			fprintf(output.file, "\t%.1f\t%.2f\n", 1e-6 * (double)cc_vertices / median[REFINE_OSD], median[RATIO]);
		else
			fputs("\t-\t-\n", output.file);
		osd_cage_free(&osd);
		cage_free(&cage);
		input_free(&input);
	}
	for (int k = 0; k < TIMED_COUNT; k++)
		free(seconds[k]);
	if (!output_commit(&output, &fault))
		tool_fail(&fault);
	return EX_DONE;
}
