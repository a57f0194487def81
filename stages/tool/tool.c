/* How every tool behaves: see tool.h. The only place below main that prints to the terminal or ends the program. */
#include "stages/tool/tool.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "formats/memory.h"
#include "formats/number.h"

#define VERSION "0.1.0"

/* Said once at the start of a program and read everywhere: the name, -q, -v, and whether a progress line is on screen. */
static struct {
	const char *name;
	bool quiet, verbose;
	bool progress_shown;
	struct timespec started;
} tool = {.name = "cagewright"};

static void clear_progress(void)
{
	if (tool.progress_shown)
		fputs("\r\033[K", stderr);
	tool.progress_shown = false;
}

static void say(const char *prefix, const char *format, va_list args)
{
	clear_progress();
	char text[1000];
	vsnprintf(text, sizeof text, format, args);
	for (char *c = text; *c; c++)
		if ((unsigned char)*c < 32 || *c == 127)
			*c = '?';
	fprintf(stderr, "%s: %s%s\n", tool.name, prefix, text);
}

static void memory_failed(const char *text)
{
	tool_die(EX_SYSTEM, "%s", text);
}

void tool_init(const char *name)
{
	tool.name = name;
	clock_gettime(CLOCK_MONOTONIC, &tool.started);
	mem_on_failure(memory_failed);
}

void tool_fail(const struct fault *fault)
{
	if (fault->code == EX_DONE)
		tool_die(EX_BUG, "a failure without a reason");
	tool_die(fault->code, "%s", fault->text);
}

void tool_die(enum exit_code code, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	say("", format, args);
	va_end(args);
	exit((int)code);
}

void tool_warn(const char *format, ...)
{
	if (tool.quiet)
		return;
	va_list args;
	va_start(args, format);
	say("warning: ", format, args);
	va_end(args);
}

void tool_say(const char *format, ...)
{
	if (!tool.verbose)
		return;
	va_list args;
	va_start(args, format);
	say("", format, args);
	va_end(args);
}

bool tool_is_verbose(void)
{
	return tool.verbose;
}

void tool_progress(const char *what, size_t done, size_t total)
{
	if (tool.quiet || !isatty(STDERR_FILENO))
		return;
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	const double seconds = (double)(now.tv_sec - tool.started.tv_sec) + 1e-9 * (double)(now.tv_nsec - tool.started.tv_nsec);
	if (done >= total) {
		clear_progress();
	} else if (seconds > 0.5) {
		fprintf(stderr, "\r%s: %s %3.0f%%\033[K", tool.name, what, 100.0 * (double)done / (double)total);
		fflush(stderr);
		tool.progress_shown = true;
	}
}

double tool_length_in_units(struct tool_length length, double longest_side)
{
	return length.is_percent ? length.value / 100 * longest_side : length.value;
}

/* ---- options ---- */

static _Noreturn void wrong_usage(const char *what, const char *name)
{
	tool_die(EX_BAD_USAGE, "%s '%s' (see %s --help)", what, name, tool.name);
}

/* Shown without needless zeros, for messages about ranges. */
static void refuse_range(const struct tool_option *option, const char *text)
{
	char low[NUM_TEXT_SIZE], high[NUM_TEXT_SIZE];
	num_print(low, option->low);
	num_print(high, option->high);
	tool_die(EX_BAD_USAGE, "option --%s: %s is not within %s to %s", option->name, text, low, high);
}

static void take_length(const struct tool_option *option, const char *text)
{
	struct tool_length *length = option->value;
	size_t size = strlen(text);
	length->is_percent = size > 0 && text[size - 1] == '%';
	if (length->is_percent)
		size--;
	if (!num_parse(text, size, &length->value) || !isfinite(length->value))
		tool_die(EX_BAD_USAGE, "option --%s: '%s' is no length (a number, or per cent of the longest side)", option->name, text);
	if (!(length->value > 0))
		tool_die(EX_BAD_USAGE, "option --%s: %s is not greater than 0", option->name, text);
}

static void take_value(const struct tool_option *option, const char *text)
{
	long long whole;
	double number;
	switch (option->kind) {
	case TOOL_FLAG:
		*(bool *)option->value = true;
		break;
	case TOOL_NUMBER:
		if (!num_parse(text, strlen(text), &number) || isnan(number))
			tool_die(EX_BAD_USAGE, "option --%s: '%s' is not a number", option->name, text);
		if (number < option->low || number > option->high)
			refuse_range(option, text);
		*(double *)option->value = number;
		break;
	case TOOL_INTEGER:
		if (!num_parse_integer(text, strlen(text), INT64_MIN, INT64_MAX, &whole))
			tool_die(EX_BAD_USAGE, "option --%s: '%s' is not a whole number", option->name, text);
		if ((double)whole < option->low || (double)whole > option->high)
			refuse_range(option, text);
		*(int *)option->value = (int)whole;
		break;
	case TOOL_LENGTH:
		take_length(option, text);
		break;
	case TOOL_TEXT:
		*(const char **)option->value = text;
		break;
	}
}

struct common_values {
	bool help, version, quiet, verbose, binary, no_provenance;
	const char *output;
};

/* letter 0: by name[0..length), else by letter. The tool's own table goes first. shown: for the message when there is none. */
static const struct tool_option *find_option(const struct tool_option *own, const struct tool_option *common, const char *name,
                                             size_t length, char letter, const char *shown)
{
	const struct tool_option *const tables[2] = {own, common};
	for (int t = 0; t < 2; t++)
		for (const struct tool_option *o = tables[t]; o && o->name; o++)
			if (letter ? o->letter == letter : strlen(o->name) == length && memcmp(o->name, name, length) == 0)
				return o;
	wrong_usage("unknown option", shown);
}

static const char *next_argument(const struct tool_option *option, int argc, char **argv, int *at)
{
	if (*at + 1 >= argc)
		tool_die(EX_BAD_USAGE, "option --%s wants a value (see %s --help)", option->name, tool.name);
	return argv[++*at];
}

static void take_long(const struct tool_option *own, const struct tool_option *common, int argc, char **argv, int *at)
{
	const char *name = argv[*at] + 2;
	const char *equals = strchr(name, '=');
	const size_t length = equals ? (size_t)(equals - name) : strlen(name);
	const struct tool_option *option = find_option(own, common, name, length, 0, argv[*at]);
	if (option->kind == TOOL_FLAG && equals)
		tool_die(EX_BAD_USAGE, "option --%s takes no value", option->name);
	if (option->kind == TOOL_FLAG)
		take_value(option, NULL);
	else
		take_value(option, equals ? equals + 1 : next_argument(option, argc, argv, at));
}

/* "-qv", "-ofile", "-o file" */
static void take_letters(const struct tool_option *own, const struct tool_option *common, int argc, char **argv, int *at)
{
	for (const char *letter = argv[*at] + 1; *letter; letter++) {
		const char shown[3] = {'-', *letter, 0};
		const struct tool_option *option = find_option(own, common, NULL, 0, *letter, shown);
		if (option->kind == TOOL_FLAG) {
			take_value(option, NULL);
			continue;
		}
		take_value(option, letter[1] ? letter + 1 : next_argument(option, argc, argv, at));
		return;
	}
}

static _Noreturn void answer(const char *text)
{
	fputs(text, stdout);
	if (fflush(stdout) != 0 || ferror(stdout))
		tool_die(EX_SYSTEM, "<stdout>: cannot write");
	exit(EX_DONE);
}

int tool_options(int argc, char **argv, const char *usage, const struct tool_option *table, struct tool_common *common, int least, int most)
{
	struct common_values v = {0};
	const struct tool_option shared[] = {
		{"help", 'h', TOOL_FLAG, &v.help, 0, 0},
		{"version", 0, TOOL_FLAG, &v.version, 0, 0},
		{"quiet", 'q', TOOL_FLAG, &v.quiet, 0, 0},
		{"verbose", 'v', TOOL_FLAG, &v.verbose, 0, 0},
		{"output", 'o', TOOL_TEXT, &v.output, 0, 0},
		{"binary", 0, TOOL_FLAG, &v.binary, 0, 0},
		{"no-provenance", 0, TOOL_FLAG, &v.no_provenance, 0, 0},
		{0},
	};
	/* Operands may stand between options: they are collected over the options that were read, then moved to the end. */
	int operands = 0;
	char **operand = argv + (argc > 0);
	for (int i = 1; i < argc; i++) {
		if (strcmp(argv[i], "--") == 0) {
			while (++i < argc)
				operand[operands++] = argv[i];
		} else if (argv[i][0] != '-' || argv[i][1] == 0) {
			operand[operands++] = argv[i];
		} else if (argv[i][1] == '-') {
			take_long(table, shared, argc, argv, &i);
		} else {
			take_letters(table, shared, argc, argv, &i);
		}
		if (v.help)
			answer(usage);
		if (v.version) {
			char text[100];
			snprintf(text, sizeof text, "%s (cagewright) %s\n", tool.name, VERSION);
			answer(text);
		}
	}
	tool.quiet = v.quiet;
	tool.verbose = v.verbose;
	*common = (struct tool_common){v.output, v.binary, v.no_provenance};
	if (operands < least)
		tool_die(EX_BAD_USAGE, "%d %s wanted, %d given (see %s --help)", least, least == 1 ? "file" : "files", operands, tool.name);
	if (operands > most)
		wrong_usage("one operand too many:", operand[most]);
	memmove(argv + argc - operands, operand, (size_t)operands * sizeof *operand);
	return argc - operands;
}

/* ---- documents ---- */

void tool_read_ply(struct ply *ply, const char *path, const char **shown)
{
	struct fault fault = {0};
	struct input input;
	if (!input_read(&input, path, &fault))
		tool_fail(&fault);
	*shown = input.shown;
	if (!ply_read(ply, &input, &fault))
		tool_fail(&fault);
	input_free(&input);
}

/* Is this header line "comment cagewright STAGE ..."? Returns what follows the stage's name, else NULL. */
static const char *provenance_of(const char *comment, const char *stage)
{
	static const char prefix[] = "comment cagewright ";
	const size_t length = strlen(stage);
	if (strncmp(comment, prefix, sizeof prefix - 1) != 0)
		return NULL;
	const char *at = comment + sizeof prefix - 1;
	if (strncmp(at, stage, length) != 0 || (at[length] != ' ' && at[length] != 0))
		return NULL;
	return at + length;
}

static void drop_provenance(struct ply *ply, const char *stage)
{
	size_t kept = 0;
	for (size_t c = 0; c < ply->comment_count; c++) {
		if (provenance_of(ply->comment[c], stage))
			free(ply->comment[c]);
		else
			ply->comment[kept++] = ply->comment[c];
	}
	ply->comment_count = kept;
}

void tool_write_ply(struct ply *ply, const struct tool_common *common, int schema, const char *format, ...)
{
	drop_provenance(ply, tool.name);
	if (!common->no_provenance) {
		va_list args;
		char text[1000];
		va_start(args, format);
		vsnprintf(text, sizeof text, format, args);
		va_end(args);
		ply_comment(ply, "cagewright %s %d%s%s", tool.name, schema, *text ? " " : "", text);
	}
	ply->encoding = common->binary ? PLY_BINARY_LITTLE : PLY_ASCII;
	struct fault fault = {0};
	struct output output;
	if (!output_open(&output, common->output, &fault))
		tool_fail(&fault);
	ply_write(output.file, ply);
	if (!output_commit(&output, &fault))
		tool_fail(&fault);
}

void tool_check_schema(const struct ply *ply, const char *shown, const char *stage, int known)
{
	for (size_t c = 0; c < ply->comment_count; c++) {
		const char *rest = provenance_of(ply->comment[c], stage);
		if (!rest)
			continue;
		while (*rest == ' ')
			rest++;
		long long schema;
		if (!num_parse_integer(rest, strcspn(rest, " "), 1, INT32_MAX, &schema))
			tool_die(EX_BAD_INPUT, "%s: bad schema number in '%s'", shown, ply->comment[c]);
		if (schema > known)
			tool_die(EX_BAD_INPUT, "%s: written by %s with schema %lld; this %s reads schemas up to %d", shown, stage, schema,
			         tool.name, known);
	}
}
