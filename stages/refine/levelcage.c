#include "stages/refine/levelcage.h"

#include <stdlib.h>
#include <string.h>

/* An edge that is marked in both its faces; borders are marked in their only one. */
struct marked {
	idx_t low, high;
};

static int compare_marked(const void *a, const void *b)
{
	const struct marked *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	return (x->high > y->high) - (x->high < y->high);
}

static void collect_sharp(struct cage *cage, const struct level *level)
{
	const size_t corner_count = level->face_start[level->face_count];
	size_t count = 0;
	for (size_t h = 0; h < corner_count; h++)
		count += level->sharp[h];
	struct marked *marked = mem_array(count, sizeof *marked);
	count = 0;
	for (size_t f = 0; f < level->face_count; f++) {
		const size_t first = level->face_start[f], end = level->face_start[f + 1];
		for (size_t h = first; h < end; h++) {
			const idx_t a = level->face_corner[h], b = level->face_corner[h + 1 == end ? first : h + 1];
			if (level->sharp[h])
				marked[count++] = a < b ? (struct marked){a, b} : (struct marked){b, a};
		}
	}
	qsort(marked, count, sizeof *marked, compare_marked);
	cage->sharp = mem_array(count, sizeof *cage->sharp); /* two sides an edge: enough */
	for (size_t i = 0; i + 1 < count; i++)
		if (compare_marked(marked + i, marked + i + 1) == 0) {
			cage->sharp[2 * cage->sharp_count] = marked[i].low;
			cage->sharp[2 * cage->sharp_count + 1] = marked[i].high;
			cage->sharp_count++;
		}
	free(marked);
}

void levelcage(struct cage *cage, struct level *level, const struct cage *origin)
{
	*cage = (struct cage){.scheme = origin->scheme, .vertex_count = level->vertex_count, .face_count = level->face_count};
	collect_sharp(cage, level);
	cage->xyz = level->xyz;
	cage->corner = level->corner;
	cage->face_corner = level->face_corner;
	cage->face_start = level->face_start;
	level->xyz = NULL;
	level->corner = NULL;
	level->face_corner = NULL;
	level->face_start = NULL;
	cage->face_patch = mem_array(level->face_count, sizeof *cage->face_patch);
	for (size_t f = 0; f < level->face_count; f++)
		cage->face_patch[f] = origin->face_patch ? origin->face_patch[level->face_origin[f]] : 0;
	level_free(level);
}
