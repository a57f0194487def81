#include "tests/unit/helpers.h"

#include "stages/tool/tool.h"

/* Options of an invented tool, printed as they were understood. */
static void show_options(void *context)
{
	char **argv = context;
	int argc = 0;
	while (argv[argc])
		argc++;
	double sharp = 40;
	bool classic = false;
	int level = 4;
	struct tool_length tolerance = {0.1, true};
	const char *mesh = NULL;
	const struct tool_option table[] = {
		{"sharp", 's', TOOL_NUMBER, &sharp, 0, 180},
		{"classic", 0, TOOL_FLAG, &classic, 0, 0},
		{"level", 'l', TOOL_INTEGER, &level, 0, 8},
		{"tolerance", 't', TOOL_LENGTH, &tolerance, 0, 0},
		{"mesh", 'm', TOOL_TEXT, &mesh, 0, 0},
		{0},
	};
	struct tool_common common;
	tool_init("probe");
	const int first = tool_options(argc, argv, "usage: probe [FILE]\n", table, &common, 0, 2);
	printf("sharp=%g classic=%d level=%d tolerance=%g%s mesh=%s o=%s binary=%d bare=%d verbose=%d files=", sharp, classic, level,
	       tolerance.value, tolerance.is_percent ? "%" : "", mesh ? mesh : "none", common.output ? common.output : "none",
	       common.binary, common.no_provenance, tool_is_verbose());
	for (int i = first; i < argc; i++)
		printf("%s,", argv[i]);
}

static struct ending with_arguments(const char *line)
{
	static char copy[500];
	char *argv[20] = {(char[]){"probe"}};
	int argc = 1;
	snprintf(copy, sizeof copy, "%s", line);
	for (char *word = strtok(copy, " "); word; word = strtok(NULL, " "))
		argv[argc++] = strcmp(word, "''") == 0 ? word + 2 : word;
	argv[argc] = NULL;
	return run_child(show_options, argv);
}

static void understands(const char *line, const char *wanted)
{
	const struct ending ending = with_arguments(line);
	if (ending.exit_code != 0)
		fail_msg("'%s': %s", line, ending.err);
	assert_contains(ending.out, wanted);
	assert_string_equal(ending.err, "");
}

static void refuses(const char *line, const char *message)
{
	const struct ending ending = with_arguments(line);
	assert_int_equal(ending.exit_code, EX_BAD_USAGE);
	assert_string_equal(ending.out, "");
	char wanted[300];
	snprintf(wanted, sizeof wanted, "probe: %s\n", message);
	assert_string_equal(ending.err, wanted);
}

static void takes_options(void **state)
{
	(void)state;
	understands("", "sharp=40 classic=0 level=4 tolerance=0.1% mesh=none o=none binary=0 bare=0 verbose=0 files=");
	understands("--sharp 30 --classic --level=8 --tolerance 0.5", "sharp=30 classic=1 level=8 tolerance=0.5 mesh=none");
	understands("-s30 -l 2 -t 1% -m file", "sharp=30 classic=0 level=2 tolerance=1% mesh=file");
	understands("-vo out --binary --no-provenance", "o=out binary=1 bare=1 verbose=1");
	understands("--output=out --quiet", "o=out");
	/* operands keep their order, wherever they stand; - is one; behind -- everything is */
	understands("a --classic -", "classic=1 level=4 tolerance=0.1% mesh=none o=none binary=0 bare=0 verbose=0 files=a,-,");
	understands("--classic -- --sharp -l", "files=--sharp,-l,");
	understands("--sharp 1e1", "sharp=10");
	understands("--mesh -", "mesh=-");
	/* the last one counts */
	understands("--sharp 1 --sharp 2", "sharp=2");
}

static void refuses_wrong_usage(void **state)
{
	(void)state;
	refuses("--blunt", "unknown option '--blunt' (see probe --help)");
	refuses("--sharpp=3", "unknown option '--sharpp=3' (see probe --help)");
	refuses("--shar 3", "unknown option '--shar' (see probe --help)");
	refuses("-x", "unknown option '-x' (see probe --help)");
	refuses("-vx", "unknown option '-x' (see probe --help)");
	refuses("--sharp", "option --sharp wants a value (see probe --help)");
	refuses("-l", "option --level wants a value (see probe --help)");
	refuses("--classic=1", "option --classic takes no value");
	refuses("--sharp forty", "option --sharp: 'forty' is not a number");
	refuses("--sharp=", "option --sharp: '' is not a number");
	refuses("--sharp nan", "option --sharp: 'nan' is not a number");
	refuses("--sharp 40deg", "option --sharp: '40deg' is not a number");
	refuses("--sharp 0,5", "option --sharp: '0,5' is not a number");
	refuses("--sharp 181", "option --sharp: 181 is not within 0 to 180");
	refuses("--sharp -1", "option --sharp: -1 is not within 0 to 180");
	refuses("--level 9", "option --level: 9 is not within 0 to 8");
	refuses("--level 2.5", "option --level: '2.5' is not a whole number");
	refuses("--level 99999999999999999999", "option --level: '99999999999999999999' is not a whole number");
	refuses("--tolerance 0", "option --tolerance: 0 is not greater than 0");
	refuses("--tolerance -1%", "option --tolerance: -1% is not greater than 0");
	refuses("--tolerance %", "option --tolerance: '%' is no length (a number, or per cent of the longest side)");
	refuses("--tolerance inf", "option --tolerance: 'inf' is no length (a number, or per cent of the longest side)");
	refuses("a b c", "one operand too many: 'c' (see probe --help)");
}

static void answers(void **state)
{
	(void)state;
	struct ending ending = with_arguments("--help");
	assert_int_equal(ending.exit_code, 0);
	assert_string_equal(ending.out, "usage: probe [FILE]\n");
	assert_string_equal(ending.err, "");
	/* even before a mistake that follows */
	ending = with_arguments("--version --blunt");
	assert_int_equal(ending.exit_code, 0);
	assert_string_equal(ending.out, "probe (cagewright) 0.1.0\n");
}

static void want_one(void *context)
{
	(void)context;
	char *argv[] = {(char[]){"probe"}, NULL};
	struct tool_common common;
	const struct tool_option table[] = {{0}};
	tool_init("probe");
	tool_options(1, argv, "", table, &common, 1, 1);
}

static void counts_operands(void **state)
{
	(void)state;
	const struct ending ending = run_child(want_one, NULL);
	assert_int_equal(ending.exit_code, EX_BAD_USAGE);
	assert_string_equal(ending.err, "probe: 1 file wanted, 0 given (see probe --help)\n");
}

static void talk(void *context)
{
	char **argv = context;
	struct tool_common common;
	const struct tool_option table[] = {{0}};
	tool_init("probe");
	tool_options(2, argv, "", table, &common, 0, 0);
	tool_warn("patch %d is odd", 3);
	tool_say("done in %d steps", 5);
	tool_progress("fitting", 1, 10); /* stderr is no terminal: nothing */
	struct fault fault = {0};
	fault_set(&fault, EX_BAD_INPUT, "a\tb\033[31m");
	fault_set(&fault, EX_SYSTEM, "a second fault changes nothing");
	tool_fail(&fault);
}

static void talks_as_asked(void **state)
{
	(void)state;
	static const char *const said[3][2] = {
		{"-q", "probe: a?b?[31m\n"},
		{"-v", "probe: warning: patch 3 is odd\nprobe: done in 5 steps\nprobe: a?b?[31m\n"},
		{"--", "probe: warning: patch 3 is odd\nprobe: a?b?[31m\n"},
	};
	for (int i = 0; i < 3; i++) {
		char option[10];
		strcpy(option, said[i][0]);
		char *argv[] = {(char[]){"probe"}, option, NULL};
		const struct ending ending = run_child(talk, argv);
		assert_int_equal(ending.exit_code, EX_BAD_INPUT);
		assert_string_equal(ending.err, said[i][1]);
	}
}

static void run_out_of_memory(void *context)
{
	(void)context;
	tool_init("probe");
	mem_array(SIZE_MAX / 16, 8);
}

static void memory_is_there_or_ends_the_program(void **state)
{
	(void)state;
	if (getenv("ASAN_OPTIONS") == NULL) {
		const struct ending ending = run_child(run_out_of_memory, NULL);
		/* address sanitizers end such a request themselves */
		if (!strstr(ending.err, "Sanitizer")) {
			assert_int_equal(ending.exit_code, EX_SYSTEM);
			assert_string_equal(ending.err, "probe: out of memory: cannot take room for 1152921504606846975 items of 8 bytes\n");
		}
	}
	/* nothing is still something that free() takes */
	void *nothing = mem_array(0, 8);
	assert_non_null(nothing);
	free(nothing);
}

static void lengths(void **state)
{
	(void)state;
	assert_near(tool_length_in_units((struct tool_length){0.5, false}, 200), 0.5, 0);
	assert_near(tool_length_in_units((struct tool_length){0.5, true}, 200), 1, 1e-15);
}

static const char document[] = "ply\nformat binary_little_endian 1.0\ncomment cagewright probe 1 old\ncomment cagewright probed 2\n"
                               "comment cagewright curv 1 sharp=40deg\nelement a 1\nproperty uchar b\nend_header\n\x07";

struct run {
	const char *argument;
	const char *path;
};

/* The usual filter, to stdout or a file. */
static void filter(void *context)
{
	struct run *run = context;
	char argument[100];
	strcpy(argument, run->argument);
	char *argv[] = {(char[]){"probe"}, argument, NULL};
	struct tool_common common;
	const struct tool_option table[] = {{0}};
	tool_init("probe");
	tool_options(2, argv, "", table, &common, 0, 0);
	struct ply ply;
	const char *shown;
	tool_read_ply(&ply, run->path, &shown);
	tool_check_schema(&ply, shown, "curv", 1);
	tool_write_ply(&ply, &common, 3, "level=%d", 4);
	ply_free(&ply);
}

static void reads_and_writes_documents(void **state)
{
	(void)state;
	char folder[64], path[100], out[150], text[1000];
	folder_make(folder);
	snprintf(path, sizeof path, "%s/in.ply", folder);
	file_write(path, document, sizeof document - 1);
	struct run run = {"-q", path};
	struct ending ending = run_child(filter, &run);
	assert_int_equal(ending.exit_code, 0);
	/* its own earlier line is replaced, the others stay; ascii unless --binary */
	assert_string_equal(ending.out, "ply\nformat ascii 1.0\ncomment cagewright probed 2\ncomment cagewright curv 1 sharp=40deg\n"
	                                "comment cagewright probe 3 level=4\nelement a 1\nproperty uchar b\nend_header\n7\n");
	run.argument = "--binary";
	ending = run_child(filter, &run);
	assert_contains(ending.out, "format binary_little_endian 1.0\n");
	run.argument = "--no-provenance";
	ending = run_child(filter, &run);
	assert_null(strstr(ending.out, "comment cagewright probe "));
	snprintf(out, sizeof out, "-o%s/out.ply", folder);
	run.argument = out;
	ending = run_child(filter, &run);
	assert_int_equal(ending.exit_code, 0);
	assert_string_equal(ending.out, "");
	file_text(text, sizeof text, out + 2);
	assert_contains(text, "end_header\n7\n");
	run.path = "/nowhere/in.ply";
	ending = run_child(filter, &run);
	assert_int_equal(ending.exit_code, EX_SYSTEM);
	assert_string_equal(ending.err, "probe: /nowhere/in.ply: No such file or directory\n");
	folder_remove(folder);
}

static void refuses_newer_schemas(void **state)
{
	(void)state;
	char folder[64], path[100], wanted[300];
	folder_make(folder);
	snprintf(path, sizeof path, "%s/in.ply", folder);
	static const struct {
		const char *line, *message;
	} newer[] = {
		{"curv 2 sharp=40deg", "written by curv with schema 2; this probe reads schemas up to 1"},
		{"curv two", "bad schema number in 'comment cagewright curv two'"},
		{"curv", "bad schema number in 'comment cagewright curv'"},
	};
	for (size_t i = 0; i < sizeof newer / sizeof *newer; i++) {
		char text[200];
		snprintf(text, sizeof text, "ply\nformat ascii 1.0\ncomment cagewright %s\nend_header\n", newer[i].line);
		file_write(path, text, strlen(text));
		struct run run = {"-q", path};
		const struct ending ending = run_child(filter, &run);
		assert_int_equal(ending.exit_code, EX_BAD_INPUT);
		snprintf(wanted, sizeof wanted, "probe: %s: %s\n", path, newer[i].message);
		assert_string_equal(ending.err, wanted);
		assert_string_equal(ending.out, "");
	}
	folder_remove(folder);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(takes_options),
		cmocka_unit_test(refuses_wrong_usage),
		cmocka_unit_test(answers),
		cmocka_unit_test(counts_operands),
		cmocka_unit_test(talks_as_asked),
		cmocka_unit_test(memory_is_there_or_ends_the_program),
		cmocka_unit_test(lengths),
		cmocka_unit_test(reads_and_writes_documents),
		cmocka_unit_test(refuses_newer_schemas),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
