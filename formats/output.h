/* An output that is whole or absent: written beside its place, moved there when complete. */
#ifndef CAGEWRIGHT_OUTPUT_H
#define CAGEWRIGHT_OUTPUT_H

#include <stdbool.h>
#include <stdio.h>

#include "formats/fault.h"

struct output {
	FILE *file;            /* write here */
	char *path;            /* where it ends up; NULL for stdout */
	char *temporary;       /* where it is until then */
};

/* path NULL or "-": stdout. A temporary file beside path is removed when the program ends without output_commit,
 * also at SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE and SIGXCPU; a file beyond the limit of the shell (SIGXFSZ) is a failed
 * write. One output at a time may be open. Device files are written directly. */
bool output_open(struct output *output, const char *path, struct fault *fault);

/* Check the stream, close, rename. On failure the old file is as it was. */
bool output_commit(struct output *output, struct fault *fault);
void output_drop(struct output *output);

#endif
