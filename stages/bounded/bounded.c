/* bounded: run a command within bounds of time and memory, and note what it took.
 *
 * The command gets a process group of its own, so that all it started ends with it: at the bound of time, when bounded is
 * told to end, and with --tied when the process that started bounded is gone. Memory is bounded by RLIMIT_AS, which every
 * process below inherits. */
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "stages/tool/tool.h"

/* Statuses that are not the command's; those of timeout(1) and env(1). */
enum { TOO_LATE = 124, OWN_FAILURE = 125, NOT_EXECUTABLE = 126, NOT_FOUND = 127 };
/* Between SIGTERM and SIGKILL: what a stage needs to remove its unfinished file. */
static const double grace_seconds = 2;

struct options {
	double seconds; /* of wall clock; 0: no bound */
	double mib;     /* of address space for each process; 0: no bound */
	const char *log, *name;
	bool is_tied;
	char **command;
};

static const char usage[] =
	"usage: bounded [-qv] [--seconds n] [--mib n] [--log file] [--name text] [--tied]\n"
	"               -- command [argument ...]\n";

/* Everything after "--" is the command's, whatever it looks like. */
static struct options parse_options(int argc, char **argv)
{
	struct options opt = {0};
	struct tool_common common;
	const struct tool_option table[] = {
		{"seconds", 0, TOOL_NUMBER, &opt.seconds, 0, 1e8},
		{"mib", 0, TOOL_NUMBER, &opt.mib, 0, 1e8},
		{"log", 0, TOOL_TEXT, &opt.log, 0, 0},
		{"name", 0, TOOL_TEXT, &opt.name, 0, 0},
		{"tied", 0, TOOL_FLAG, &opt.is_tied, 0, 0},
		{0},
	};
	int own = 1;
	while (own < argc && strcmp(argv[own], "--") != 0)
		own++;
	tool_options(own, argv, usage, table, &common, 0, 0);
	if (own + 1 >= argc)
		tool_die(EX_BAD_USAGE, "no command after -- (see bounded --help)");
	opt.command = argv + own + 1;
	if (!opt.name)
		opt.name = opt.command[0];
	return opt;
}

static double seconds_now(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

_Noreturn static void fail(const char *what)
{
	fprintf(stderr, "bounded: %s: %s\n", what, strerror(errno));
	exit(OWN_FAILURE);
}

_Noreturn static void run_command(char **command, double mib, const sigset_t *mask)
{
	setpgid(0, 0);
	/* the last resort: bounded itself was killed by SIGKILL */
	prctl(PR_SET_PDEATHSIG, SIGKILL);
	if (mib > 0) {
		struct rlimit limit;
		if (getrlimit(RLIMIT_AS, &limit) != 0)
			fail("memory");
		const rlim_t wanted = (rlim_t)(mib * (1 << 20));
		/* a limit that is lower already stays */
		if (limit.rlim_max == RLIM_INFINITY || limit.rlim_max > wanted)
			limit.rlim_max = wanted;
		if (limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur > limit.rlim_max)
			limit.rlim_cur = limit.rlim_max;
		if (setrlimit(RLIMIT_AS, &limit) != 0)
			fail("memory");
	}
	sigprocmask(SIG_SETMASK, mask, NULL);
	execvp(command[0], command);
	const int status = errno == ENOENT ? NOT_FOUND : NOT_EXECUTABLE;
	fprintf(stderr, "bounded: %s: %s\n", command[0], strerror(errno));
	_exit(status);
}

/* A signal for the group, stopped processes too. */
static void signal_group(pid_t group, int number)
{
	kill(-group, number);
	kill(-group, SIGCONT);
}

struct spent {
	int status; /* as wait(2) gives it */
	long peak_kib;
};

/* Collect all who have ended. Returns whether the command is among them. The largest memory is that of the largest process
 * of all, orphans included, which come to us. */
static bool collect(pid_t command, struct spent *spent)
{
	struct rusage usage_of;
	bool is_over = false;
	int status;
	for (pid_t pid; (pid = wait4(-1, &status, WNOHANG, &usage_of)) > 0;) {
		if (usage_of.ru_maxrss > spent->peak_kib)
			spent->peak_kib = usage_of.ru_maxrss;
		if (pid == command) {
			spent->status = status;
			is_over = true;
		}
	}
	return is_over;
}

int main(int argc, char **argv)
{
	tool_init("bounded");
	const struct options opt = parse_options(argc, argv);
	sigset_t watched, before;
	sigemptyset(&watched);
	const int number[] = {SIGCHLD, SIGTERM, SIGINT, SIGHUP, SIGQUIT};
	for (size_t i = 0; i < sizeof number / sizeof *number; i++)
		sigaddset(&watched, number[i]);
	sigprocmask(SIG_BLOCK, &watched, &before);
	/* who ignores SIGCHLD passes that on, and then there is nothing to wait for */
	signal(SIGCHLD, SIG_DFL);
	const pid_t parent = getppid();
	if (opt.is_tied) {
		prctl(PR_SET_PDEATHSIG, SIGTERM);
		if (getppid() != parent) /* gone just before */
			raise(SIGTERM);
	}
	prctl(PR_SET_CHILD_SUBREAPER, 1);
	const double start = seconds_now();
	const pid_t child = fork();
	if (child < 0)
		fail("fork");
	if (child == 0)
		run_command(opt.command, opt.mib, &before);
	setpgid(child, child); /* whoever of the two is first */

	struct spent spent = {0};
	int told = 0;
	bool is_late = false;
	double end = opt.seconds > 0 ? start + opt.seconds : INFINITY;
	while (!collect(child, &spent)) {
		const double left = fmin(fmax(end - seconds_now(), 0), 3600);
		const struct timespec wait = {(time_t)left, (long)(1e9 * (left - floor(left)))};
		const int got = sigtimedwait(&watched, NULL, &wait);
		if (got > 0 && got != SIGCHLD && !told && !is_late) {
			told = got;
			signal_group(child, told);
			end = seconds_now() + grace_seconds;
		} else if (seconds_now() >= end) {
			if (told || is_late) {
				signal_group(child, SIGKILL);
				end = INFINITY;
			} else {
				is_late = true;
				signal_group(child, SIGTERM);
				end = seconds_now() + grace_seconds;
			}
		}
	}
	/* what the command left behind */
	signal_group(child, SIGKILL);
	collect(child, &spent);

	if (is_late)
		fprintf(stderr, "bounded: stopped after %g seconds\n", opt.seconds);
	const int code = is_late ? TOO_LATE : WIFSIGNALED(spent.status) ? 128 + WTERMSIG(spent.status) : WEXITSTATUS(spent.status);
	if (opt.log) {
		FILE *log = fopen(opt.log, "a");
		if (!log || fprintf(log, "%s\t%.2f\t%ld\t%d\n", opt.name, seconds_now() - start, spent.peak_kib, code) < 0 || fclose(log) != 0)
			fail(opt.log);
	}
	if (told) {
		/* end as one who was told to: a shell then stops, too */
		signal(told, SIG_DFL);
		sigprocmask(SIG_SETMASK, &before, NULL);
		raise(told);
	}
	return code;
}
