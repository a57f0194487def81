/* What the tests of formats and tools share: inputs from text, children whose exit and messages are looked at. */
#ifndef CAGEWRIGHT_TESTS_HELPERS_H
#define CAGEWRIGHT_TESTS_HELPERS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "formats/ply.h"

/* cmocka 1.1.5 compares floats only */
#define assert_near(actual, wanted, tolerance)                                                                       \
	do {                                                                                                             \
		const double near_actual = (actual), near_wanted = (wanted);                                                  \
		if (!(fabs(near_actual - near_wanted) <= (tolerance)))                                                        \
			fail_msg("%s:%d: %s is %.17g, not %.17g", __FILE__, __LINE__, #actual, near_actual, near_wanted);          \
	} while (0)

/* Does text contain part? Says both when it does not. */
#define assert_contains(text, part)                                                                                  \
	do {                                                                                                             \
		if (!strstr((text), (part)))                                                                                  \
			fail_msg("%s:%d: '%s' does not contain '%s'", __FILE__, __LINE__, (text), (part));                         \
	} while (0)

/* An input named "t.ply" with these bytes; release with input_free. */
static inline struct input input_of(const void *data, size_t size)
{
	struct input input = {.shown = "t.ply", .data = malloc(size + 1), .size = size};
	memcpy(input.data, data, size);
	input.data[size] = 0;
	return input;
}

static inline bool ply_of(struct ply *ply, const char *text, struct fault *fault)
{
	struct input input = input_of(text, strlen(text));
	const bool good = ply_read(ply, &input, fault);
	input_free(&input);
	return good;
}

/* What ply_write makes, with a 0 behind it; caller frees. */
static inline char *ply_text(const struct ply *ply, size_t *size)
{
	char *text = NULL;
	size_t length = 0;
	FILE *file = open_memstream(&text, &length);
	ply_write(file, ply);
	fclose(file);
	if (size)
		*size = length;
	return text;
}

/* How a child ended and what it said. */
struct ending {
	int exit_code; /* -1: by a signal */
	int signal;
	char out[4000], err[4000];
};

/* Run the function in a child with its output caught; returning from it is exit 0. */
static inline struct ending run_child(void (*function)(void *context), void *context)
{
	struct ending ending = {.exit_code = -1};
	FILE *out = tmpfile(), *err = tmpfile();
	fflush(NULL);
	const pid_t child = fork();
	if (child == 0) {
		dup2(fileno(out), STDOUT_FILENO);
		dup2(fileno(err), STDERR_FILENO);
		function(context);
		exit(0);
	}
	int status = 0;
	waitpid(child, &status, 0);
	if (WIFEXITED(status))
		ending.exit_code = WEXITSTATUS(status);
	else
		ending.signal = WTERMSIG(status);
	rewind(out);
	rewind(err);
	ending.out[fread(ending.out, 1, sizeof ending.out - 1, out)] = 0;
	ending.err[fread(ending.err, 1, sizeof ending.err - 1, err)] = 0;
	fclose(out);
	fclose(err);
	return ending;
}

/* A new empty folder; remove with folder_remove. */
static inline void folder_make(char path[64])
{
	strcpy(path, "/tmp/cagewright.XXXXXX");
	if (!mkdtemp(path))
		abort();
}

static inline void folder_remove(const char *path)
{
	char command[128];
	snprintf(command, sizeof command, "rm -rf %s", path);
	if (system(command) != 0)
		abort();
}

static inline void file_write(const char *path, const void *data, size_t size)
{
	FILE *file = fopen(path, "wb");
	if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0)
		abort();
}

/* The content as text, "" when there is no such file. */
static inline void file_text(char *text, size_t room, const char *path)
{
	text[0] = 0;
	FILE *file = fopen(path, "rb");
	if (!file)
		return;
	text[fread(text, 1, room - 1, file)] = 0;
	fclose(file);
}

#endif
