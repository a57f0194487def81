#include "tests/unit/helpers.h"

#include <dirent.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "formats/output.h"

static char folder[64];

static int setup(void **state)
{
	(void)state;
	folder_make(folder);
	return 0;
}

static int teardown(void **state)
{
	(void)state;
	folder_remove(folder);
	return 0;
}

static const char *in_folder(const char *name)
{
	static char path[200];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	return path;
}

static int file_count(void)
{
	DIR *dir = opendir(folder);
	int count = 0;
	while (readdir(dir))
		count++;
	closedir(dir);
	return count - 2; /* . and .. */
}

static void is_absent_until_committed(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct output output;
	char text[100];
	assert_true(output_open(&output, in_folder("new"), &fault));
	fputs("text", output.file);
	assert_int_not_equal(access(in_folder("new"), F_OK), 0);
	assert_true(output_commit(&output, &fault));
	file_text(text, sizeof text, in_folder("new"));
	assert_string_equal(text, "text");
	assert_int_equal(file_count(), 1);
	/* as any program would have made it, not with mkstemp's mode */
	struct stat status;
	const mode_t mask = umask(0);
	umask(mask);
	assert_int_equal(stat(in_folder("new"), &status), 0);
	assert_int_equal(status.st_mode & 0777, 0666 & ~mask);
	unlink(in_folder("new"));
}

static void old_file_stays_when_dropped(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct output output;
	char text[100];
	file_write(in_folder("old"), "old", 3);
	assert_true(output_open(&output, in_folder("old"), &fault));
	fputs("new", output.file);
	output_drop(&output);
	file_text(text, sizeof text, in_folder("old"));
	assert_string_equal(text, "old");
	assert_int_equal(file_count(), 1);
	unlink(in_folder("old"));
}

static void keeps_mode_and_links(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct output output;
	char text[100], target[200];
	strcpy(target, in_folder("target"));
	file_write(target, "old", 3);
	chmod(target, 0640);
	assert_int_equal(symlink("target", in_folder("link")), 0);
	assert_true(output_open(&output, in_folder("link"), &fault));
	fputs("new", output.file);
	assert_true(output_commit(&output, &fault));
	struct stat status;
	assert_int_equal(lstat(in_folder("link"), &status), 0);
	assert_true(S_ISLNK(status.st_mode));
	file_text(text, sizeof text, target);
	assert_string_equal(text, "new");
	assert_int_equal(stat(target, &status), 0);
	assert_int_equal(status.st_mode & 0777, 0640);
	unlink(in_folder("link"));
	unlink(target);
}

static void half_done(void *context)
{
	const int signal_number = *(const int *)context;
	struct fault fault = {0};
	struct output output;
	if (!output_open(&output, in_folder("half"), &fault))
		exit(9);
	fputs("half", output.file);
	fflush(output.file);
	if (signal_number)
		raise(signal_number);
	exit(3);
}

static void leaves_nothing_when_ended(void **state)
{
	(void)state;
	int signals[] = {0, SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU};
	for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
		const struct ending ending = run_child(half_done, &signals[i]);
		if (signals[i])
			assert_int_equal(ending.signal, signals[i]);
		else
			assert_int_equal(ending.exit_code, 3);
		assert_int_equal(file_count(), 0);
	}
}

static void says_why_it_cannot_write(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct output output;
	assert_false(output_open(&output, in_folder("none/file"), &fault));
	assert_int_equal(fault.code, EX_SYSTEM);
	assert_contains(fault.text, "none/file: No such file or directory");
	fault = (struct fault){0};
	assert_false(output_open(&output, folder, &fault));
	assert_int_equal(fault.code, EX_SYSTEM);
	assert_contains(fault.text, "Is a directory");
	fault = (struct fault){0};
	assert_true(output_open(&output, "/dev/full", &fault));
	fputs("text", output.file);
	assert_false(output_commit(&output, &fault));
	assert_int_equal(fault.code, EX_SYSTEM);
	assert_contains(fault.text, "/dev/full: No space left on device");
}

static void beyond_limit(void *context)
{
	(void)context;
	struct fault fault = {0};
	struct output output;
	const struct rlimit limit = {4096, 4096};
	setrlimit(RLIMIT_FSIZE, &limit);
	if (!output_open(&output, in_folder("large"), &fault))
		exit(9);
	for (int i = 0; i < 10000; i++)
		fputs("text", output.file);
	if (!output_commit(&output, &fault)) {
		fputs(fault.text, stderr);
		exit((int)fault.code);
	}
}

/* The kernel would end the program for it. */
static void says_that_a_file_grew_too_large(void **state)
{
	(void)state;
	const struct ending ending = run_child(beyond_limit, NULL);
	assert_int_equal(ending.signal, 0);
	assert_int_equal(ending.exit_code, EX_SYSTEM);
	assert_contains(ending.err, "large: File too large");
	assert_int_equal(file_count(), 0);
}

static void to_stdout(void *context)
{
	const bool is_closed = *(const bool *)context;
	struct fault fault = {0};
	struct output output;
	if (is_closed)
		close(STDOUT_FILENO);
	if (!output_open(&output, "-", &fault)) {
		fputs(fault.text, stderr);
		exit((int)fault.code);
	}
	fputs("text", output.file);
	if (!output_commit(&output, &fault))
		exit((int)fault.code);
}

static void writes_stdout(void **state)
{
	(void)state;
	bool is_closed = false;
	struct ending ending = run_child(to_stdout, &is_closed);
	assert_int_equal(ending.exit_code, 0);
	assert_string_equal(ending.out, "text");
	is_closed = true;
	ending = run_child(to_stdout, &is_closed);
	assert_int_equal(ending.exit_code, EX_SYSTEM);
	assert_contains(ending.err, "<stdout>: Bad file descriptor");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(is_absent_until_committed), cmocka_unit_test(old_file_stays_when_dropped),
		cmocka_unit_test(keeps_mode_and_links),      cmocka_unit_test(leaves_nothing_when_ended),
		cmocka_unit_test(says_why_it_cannot_write),
		cmocka_unit_test(says_that_a_file_grew_too_large),  cmocka_unit_test(writes_stdout),
	};
	return cmocka_run_group_tests(tests, setup, teardown);
}
