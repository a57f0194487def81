/* What went wrong, said once: formats and methods fill it, tools print it.
 *
 * No function below the tools prints or exits. Those that can fail return false and fill a fault with the
 * text of the message without the tool's name ("part.stl:12: facet 3: normal is not a number") and the exit code. */
#ifndef CAGEWRIGHT_FAULT_H
#define CAGEWRIGHT_FAULT_H

#include <stdbool.h>

/* Exit codes of every tool (see cagewright(7)). */
enum exit_code {
	EX_DONE = 0,      /* done, output complete */
	EX_NO = 1,        /* the answer is no (checkers only) */
	EX_BAD_USAGE = 2, /* wrong usage; nothing was read */
	EX_BAD_INPUT = 3, /* the input is wrong */
	EX_SYSTEM = 4,    /* the system failed: open, read, write, memory */
	EX_BUG = 5,       /* an internal check failed */
};

struct fault {
	enum exit_code code; /* EX_DONE as long as nothing is wrong */
	char text[400];      /* one line, lowercase, no final stop */
};

/* Fill *fault (printf-like; control characters of the arguments are shown as '?'). Returns false, so that a reader
 * can `return fault_set(...)`. The first fault stays: a second call changes nothing. */
bool fault_set(struct fault *fault, enum exit_code code, const char *format, ...)
	__attribute__((format(printf, 3, 4)));

#endif
