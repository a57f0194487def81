/* Any bytes as a PLY file: refused with a message, or read, and then writing, reading and writing gives the same bytes. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "formats/ply.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	unsigned char *bytes = mem_array(size + 1, 1);
	memcpy(bytes, data, size);
	char *text[2] = {NULL, NULL};
	size_t length[2] = {0, 0};
	struct input input = {"x.ply", bytes, size};
	for (int pass = 0; pass < 2; pass++) {
		struct ply ply;
		struct fault fault = {0};
		if (!ply_read(&ply, &input, &fault)) {
			if (pass > 0)
				abort();
			break;
		}
		FILE *file = open_memstream(&text[pass], &length[pass]);
		ply_write(file, &ply);
		fclose(file);
		ply_free(&ply);
		input = (struct input){"y.ply", (unsigned char *)text[pass], length[pass]};
	}
	if (text[1] && (length[0] != length[1] || memcmp(text[0], text[1], length[0]) != 0))
		abort();
	free(bytes), free(text[0]), free(text[1]);
	return 0;
}
