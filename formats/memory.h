/* Memory that is there or ends the program: one message, exit 4, in one place. */
#ifndef CAGEWRIGHT_MEMORY_H
#define CAGEWRIGHT_MEMORY_H

#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>

/* Every index into vertices, faces, edges, half-edges; NO_INDEX where there is none.
 * Counts and products of counts are size_t. */
typedef int32_t idx_t;
#define PRIidx PRId32
#define NO_INDEX ((idx_t)-1)
#define INDEX_LIMIT ((size_t)INT32_MAX)

/* Room for count items of item_size bytes, zeroed; never NULL (a count of 0 gives one byte). Release with free().
 * Ends the program with exit 4 and a message that says how much was asked for when there is none. */
void *mem_array(size_t count, size_t item_size);

/* The same for growth: like reallocarray, the added part is not zeroed; never NULL. */
void *mem_resize(void *old, size_t count, size_t item_size);

/* A copy of count items; never NULL. */
void *mem_copy(const void *from, size_t count, size_t item_size);

/* Who says the message: the tools set a handler that prints it with their name and ends the program. Without one (or
 * when it returns) the bare text goes to stderr and the program ends with exit 4. */
void mem_on_failure(void (*handler)(const char *text));

/* The same end for a library that had no memory, with a text of one's own. */
_Noreturn void mem_fail(const char *text);

#endif
