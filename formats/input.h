/* A whole input in memory: a file, a gzip-compressed file, or stdin. */
#ifndef CAGEWRIGHT_INPUT_H
#define CAGEWRIGHT_INPUT_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/fault.h"

struct input {
	const char *shown;         /* the name for messages: the path as given, "<stdin>" for "-" or NULL */
	unsigned char *data;       /* size bytes and one 0 byte behind them, so that text scanners can stop */
	size_t size;
};

/* Most bytes that an input may have after decompression; more is refused (a gzip bomb would fill the memory). */
#define INPUT_SIZE_LIMIT ((size_t)1 << 30)

/* Read path ("-" or NULL: stdin) whole; gzip is recognised by its first two bytes, whatever the name.
 * Faults: EX_SYSTEM when it cannot be opened or read, EX_BAD_INPUT for damaged or too large data. */
bool input_read(struct input *input, const char *path, struct fault *fault);
void input_free(struct input *input);

/* The extension of a path in lower case without a final ".gz" ("Part.STL.gz" -> "stl"), "" when there is none. */
void path_extension(char extension[8], const char *path);

#endif
