#include "formats/fault.h"

#include <stdarg.h>
#include <stdio.h>

bool fault_set(struct fault *fault, enum exit_code code, const char *format, ...)
{
	if (fault->code != EX_DONE)
		return false;
	fault->code = code;
	va_list args;
	va_start(args, format);
	vsnprintf(fault->text, sizeof fault->text, format, args);
	va_end(args);
	/* One line, whatever a file or its name contains: escape sequences must not reach a terminal. */
	for (char *c = fault->text; *c; c++)
		if ((unsigned char)*c < 32 || *c == 127)
			*c = '?';
	return false;
}
