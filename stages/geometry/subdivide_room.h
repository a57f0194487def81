/* Room for the large arrays of refined levels. Private to subdivision. */
#ifndef CAGEWRIGHT_SUBDIVIDE_ROOM_H
#define CAGEWRIGHT_SUBDIVIDE_ROOM_H

#include <stddef.h>

/* Room for count items of item_size bytes, not zeroed; never NULL. Release with free(). Ends the program as mem_array does when
 * there is none.
 *
 * From ROOM_LARGE bytes on it asks for huge pages and takes whole ones: a fresh page of 4 KiB costs more than a microsecond, at
 * 57 bytes a vertex three times what subdivision itself does; in pages of 2 MiB the same memory costs a quarter of that or less, and
 * from about this size on also when the rest of the last one is not used. Where the system has none it is plain memory. */
#define ROOM_LARGE ((size_t)768 * 1024)
void *room_array(size_t count, size_t item_size);
void *room_zeroed(size_t count, size_t item_size);

/* Several arrays in one room: their sizes are summed up with room_piece, then they are taken in any order. */
size_t room_piece(size_t count, size_t item_size);
void *room_take(unsigned char **free_room, size_t count, size_t item_size);

#endif
