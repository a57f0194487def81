#include "formats/output.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "formats/memory.h"

/* What a dying program has to remove; one output at a time. */
static char *volatile pending;
static bool is_prepared;

static void remove_pending(void)
{
	if (pending)
		unlink(pending);
	pending = NULL;
}

static void remove_and_die(int number)
{
	remove_pending();
	signal(number, SIG_DFL);
	raise(number);
}

static void prepare(void)
{
	if (is_prepared)
		return;
	is_prepared = true;
	atexit(remove_pending);
	static const int deadly[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU};
	for (size_t i = 0; i < sizeof deadly / sizeof *deadly; i++) {
		struct sigaction old;
		/* nohup and background jobs ignore signals: leave them ignored */
		if (sigaction(deadly[i], NULL, &old) == 0 && old.sa_handler == SIG_DFL)
			signal(deadly[i], remove_and_die);
	}
}

static bool fail(struct output *output, const char *path, struct fault *fault)
{
	fault_set(fault, EX_SYSTEM, "%s: %s", path, strerror(errno));
	output_drop(output);
	return false;
}

/* A file in the target's folder, so that rename() stays within one file system. */
static char *temporary_beside(const char *path)
{
	const char *slash = strrchr(path, '/');
	const size_t folder = slash ? (size_t)(slash + 1 - path) : 0;
	const char *name = path + folder;
	char *temporary = mem_array(strlen(path) + 10, 1);
	memcpy(temporary, path, folder);
	temporary[folder] = '.';
	/* a name of the greatest length has no room for what we add */
	const size_t kept = strlen(name) < 200 ? strlen(name) : 200;
	memcpy(temporary + folder + 1, name, kept);
	strcpy(temporary + folder + 1 + kept, ".XXXXXX");
	return temporary;
}

bool output_open(struct output *output, const char *path, struct fault *fault)
{
	*output = (struct output){0};
	/* a file beyond the limit of the shell is a failed write with a message, not a sudden end */
	signal(SIGXFSZ, SIG_IGN);
	if (!path || strcmp(path, "-") == 0) {
		if (fcntl(STDOUT_FILENO, F_GETFD) < 0)
			return fault_set(fault, EX_SYSTEM, "<stdout>: %s", strerror(errno));
		output->file = stdout;
		return true;
	}
	struct stat status;
	const bool exists = stat(path, &status) == 0;
	if (exists && S_ISDIR(status.st_mode)) {
		errno = EISDIR;
		return fail(output, path, fault);
	}
	if (exists && !S_ISREG(status.st_mode)) {
		output->path = mem_copy(path, strlen(path) + 1, 1);
		output->file = fopen(path, "wb");
		return output->file ? true : fail(output, path, fault);
	}
	if (exists && access(path, W_OK) != 0)
		return fail(output, path, fault);
	/* replace what a symbolic link points at, not the link */
	char *real = exists ? realpath(path, NULL) : NULL;
	output->path = real ? real : mem_copy(path, strlen(path) + 1, 1);
	output->temporary = temporary_beside(output->path);
	prepare();
	const int fd = mkstemp(output->temporary);
	if (fd < 0) {
		free(output->temporary);
		output->temporary = NULL;
		return fail(output, path, fault);
	}
	pending = output->temporary;
	const mode_t mask = umask(0);
	umask(mask);
	if (fchmod(fd, exists ? status.st_mode & 0777 : 0666 & ~mask) != 0) {
		close(fd);
		return fail(output, path, fault);
	}
	output->file = fdopen(fd, "wb");
	if (!output->file) {
		close(fd);
		return fail(output, path, fault);
	}
	return true;
}

bool output_commit(struct output *output, struct fault *fault)
{
	const char *shown = output->path ? output->path : "<stdout>";
	errno = 0;
	bool good = fflush(output->file) == 0 && !ferror(output->file);
	int reason = errno;
	if (!good && !reason) {
		/* an earlier write failed, and its reason is gone with errno: the next one fails for the same reason */
		clearerr(output->file);
		if (fputc('\n', output->file) == EOF || fflush(output->file) != 0)
			reason = errno;
	}
	/* closing tells of errors that only the file system knows (quota, network) */
	const int closed = fclose(output->file);
	output->file = NULL;
	if (!good)
		errno = reason ? reason : EIO;
	good = good && closed == 0;
	if (good && output->temporary)
		good = rename(output->temporary, output->path) == 0;
	if (!good)
		return fail(output, shown, fault);
	pending = NULL;
	free(output->temporary);
	output->temporary = NULL;
	output_drop(output);
	return true;
}

void output_drop(struct output *output)
{
	if (output->file && output->file != stdout)
		fclose(output->file);
	if (output->temporary)
		remove_pending();
	free(output->temporary);
	free(output->path);
	*output = (struct output){0};
}
