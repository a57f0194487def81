/* How every tool behaves: options, messages, progress, exit codes. See cagewright(7). */
#ifndef CAGEWRIGHT_TOOL_H
#define CAGEWRIGHT_TOOL_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/fault.h"
#include "formats/input.h"
#include "formats/output.h"
#include "formats/ply.h"

/* First line of every main: the tool's name in messages. */
void tool_init(const char *name);

/* Print "NAME: text" on stderr and end with the fault's code. Never returns. */
_Noreturn void tool_fail(const struct fault *fault);
/* The same with a text of one's own. */
_Noreturn void tool_die(enum exit_code code, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* "NAME: warning: text" unless -q. */
void tool_warn(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* "NAME: text" only with -v. */
void tool_say(const char *format, ...) __attribute__((format(printf, 1, 2)));
bool tool_is_verbose(void);

/* One progress line, only when stderr is a terminal and more than half a second has passed; done in [0, total]. */
void tool_progress(const char *what, size_t done, size_t total);

/* A length option: model units, or per cent of the longest side ("0.1%"). */
struct tool_length {
	double value;    /* > 0 */
	bool is_percent;
};
double tool_length_in_units(struct tool_length length, double longest_side);

/* Options. Each tool declares a table and gets every value checked for form and range.
 *
 *	static const struct tool_option table[] = {
 *		{"sharp", 's', TOOL_NUMBER, &opt.sharp_deg, 0, 180},
 *		{"classic", 0, TOOL_FLAG, &opt.classic, 0, 0},
 *		{"tol", 't', TOOL_LENGTH, &opt.tol, 0, 0},
 *		{"level", 'l', TOOL_INTEGER, &opt.level, 0, 8},       value is an int
 *		{"mesh", 'm', TOOL_TEXT, &opt.mesh, 0, 0},            value is a const char *
 *		{0},
 *	};
 *
 * Added for every tool: --help (prints usage on stdout, exit 0), --version, -q --quiet, -v --verbose, -o --output FILE,
 * --binary, --no-provenance. "--name value" and "--name=value"; "--" ends options. Wrong usage: one line and exit 2. */
enum tool_option_kind { TOOL_FLAG, TOOL_NUMBER, TOOL_INTEGER, TOOL_LENGTH, TOOL_TEXT };
struct tool_option {
	const char *name;
	char letter;            /* 0 for none */
	enum tool_option_kind kind;
	void *value;            /* bool, double, int, struct tool_length or const char * as the kind says */
	double low, high;       /* numbers and integers: allowed range, inclusive */
};
struct tool_common {
	const char *output;     /* -o, NULL for stdout */
	bool binary;            /* --binary */
	bool no_provenance;     /* --no-provenance */
};

/* Returns the index of the first operand in argv; operands are argv[i..argc). Refuses fewer than least or more than most of them. */
int tool_options(int argc, char **argv, const char *usage, const struct tool_option *table, struct tool_common *common, int least, int most);

/* The usual filter: read PLY from path or stdin, or die. */
void tool_read_ply(struct ply *ply, const char *path, const char **shown);

/* Add "comment cagewright NAME SCHEMA options" (unless --no-provenance; an earlier line of the same stage is replaced),
 * set the encoding by --binary, write whole or not at all, or die. */
void tool_write_ply(struct ply *ply, const struct tool_common *common, int schema, const char *format, ...)
	__attribute__((format(printf, 4, 5)));

/* Refuse a file whose line of the given stage has a schema newer than known. */
void tool_check_schema(const struct ply *ply, const char *shown, const char *stage, int known);

#endif
