/* What ply.c, ply_read.c and ply_write.c share and nobody else needs. */
#ifndef CAGEWRIGHT_PLY_INTERNAL_H
#define CAGEWRIGHT_PLY_INTERNAL_H

#include "formats/ply.h"

/* Texts of an ascii column that are not what we would print ("1.50", "+3", more digits than a double holds), by rising
 * index into value. number is what the text said: a value changed since then is printed anew. */
struct ply_written {
	size_t count, room, pool_size, pool_room;
	struct ply_written_item {
		size_t index;  /* into ply_column.value */
		size_t text;   /* offset into pool */
		size_t length;
		double number;
	} *item;
	char *pool;
};

extern const char *const ply_type_name[8];
size_t ply_type_size(enum ply_type type);
bool ply_type_is_float(enum ply_type type);
/* Range of an integer type. */
void ply_type_range(enum ply_type type, long long *low, long long *high);

void ply_written_add(struct ply_column *column, size_t index, const char *text, size_t length);

#endif
