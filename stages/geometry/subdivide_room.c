#include "stages/geometry/subdivide_room.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

#include "formats/memory.h"

#define HUGE_PAGE ((size_t)2 * 1024 * 1024)
#define CACHE_LINE ((size_t)64)

void *room_array(size_t count, size_t item_size)
{
#ifdef MADV_HUGEPAGE
	const size_t most = SIZE_MAX - HUGE_PAGE;
	if (item_size > 0 && count <= most / item_size && count * item_size >= ROOM_LARGE) {
		const size_t size = (count * item_size + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
		void *room = aligned_alloc(HUGE_PAGE, size);
		if (room) {
			madvise(room, size, MADV_HUGEPAGE); /* a wish: without it everything works, only slower */
			return room;
		}
	}
#endif
	return mem_resize(NULL, count, item_size);
}

void *room_zeroed(size_t count, size_t item_size)
{
	void *room = room_array(count, item_size);
	memset(room, 0, count * item_size);
	return room;
}

size_t room_piece(size_t count, size_t item_size)
{
	return (count * item_size + CACHE_LINE - 1) / CACHE_LINE * CACHE_LINE;
}

void *room_take(unsigned char **free_room, size_t count, size_t item_size)
{
	void *piece = *free_room;
	*free_room += room_piece(count, item_size);
	return piece;
}
