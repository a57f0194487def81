/* measured: run a command within bounds of time and memory, and add a line on what it took to a file. See usage. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const char usage[] =
	"usage: measured LOG NAME SECONDS MIB COMMAND [ARGUMENT...]\n"
	"Run COMMAND; after SECONDS of wall clock it is killed, more than MIB of address space it does not get.\n"
	"Adds the line NAME, seconds, KiB of memory at most, exit status (128 + signal) to LOG, separated by tabs.\n"
	"Ends with the status of COMMAND.\n";

static volatile sig_atomic_t too_late;
static volatile pid_t child;

static void on_alarm(int signal_number)
{
	(void)signal_number;
	too_late = 1;
	kill(child, SIGKILL);
}

static double seconds_now(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static unsigned long positive(const char *text)
{
	char *end;
	errno = 0;
	const unsigned long number = strtoul(text, &end, 10);
	if (errno || *end || end == text || number == 0 || number > 1000000) {
		fputs(usage, stderr);
		exit(2);
	}
	return number;
}

int main(int argc, char **argv)
{
	if (argc < 6) {
		fputs(usage, stderr);
		return 2;
	}
	const unsigned long seconds = positive(argv[3]), mib = positive(argv[4]);
	struct sigaction action = {.sa_handler = on_alarm};
	sigaction(SIGALRM, &action, NULL);
	const double start = seconds_now();
	child = fork();
	if (child < 0) {
		perror("measured: fork");
		return 4;
	}
	if (child == 0) {
		const struct rlimit limit = {mib << 20, mib << 20};
		setrlimit(RLIMIT_AS, &limit);
		execvp(argv[5], argv + 5);
		perror(argv[5]);
		_exit(127);
	}
	alarm((unsigned)seconds);
	int status = 0;
	struct rusage spent;
	while (wait4(child, &status, 0, &spent) < 0)
		if (errno != EINTR) {
			perror("measured: wait4");
			return 4;
		}
	alarm(0);
	const int code = too_late ? 124 : WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
	FILE *log = fopen(argv[1], "a");
	if (!log || fprintf(log, "%s\t%.2f\t%ld\t%d\n", argv[2], seconds_now() - start, spent.ru_maxrss, code) < 0 || fclose(log) != 0) {
		perror(argv[1]);
		return 4;
	}
	return code;
}
