#include "formats/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats/fault.h"

static void (*on_failure)(const char *text);

void mem_on_failure(void (*handler)(const char *text))
{
	on_failure = handler;
}

void mem_fail(const char *text)
{
	if (on_failure)
		on_failure(text);
	fprintf(stderr, "%s\n", text);
	exit(EX_SYSTEM);
}

static _Noreturn void fail(size_t count, size_t item_size)
{
	char text[120];
	snprintf(text, sizeof text, "out of memory: cannot take room for %zu items of %zu bytes", count, item_size);
	mem_fail(text);
}

void *mem_array(size_t count, size_t item_size)
{
	const size_t size = item_size ? item_size : 1;
	void *room = calloc(count ? count : 1, size);
	if (!room)
		fail(count, size);
	return room;
}

void *mem_resize(void *old, size_t count, size_t item_size)
{
	const size_t size = item_size ? item_size : 1;
	void *room = reallocarray(old, count ? count : 1, size);
	if (!room)
		fail(count, size);
	return room;
}

void *mem_copy(const void *from, size_t count, size_t item_size)
{
	void *room = mem_array(count, item_size);
	if (count && item_size)
		memcpy(room, from, count * item_size);
	return room;
}
