#include "formats/input.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

#include "formats/memory.h"

#define FIRST_ROOM ((size_t)1 << 16)

static bool too_large(const struct input *input, struct fault *fault)
{
	return fault_set(fault, EX_BAD_INPUT, "%s: more than %zu MiB of data", input->shown, INPUT_SIZE_LIMIT >> 20);
}

static bool read_stream(struct input *input, FILE *file, size_t expected, struct fault *fault)
{
	size_t room = expected + 1 > FIRST_ROOM ? expected + 1 : FIRST_ROOM;
	input->data = mem_resize(NULL, room + 1, 1);
	for (;;) {
		const size_t got = fread(input->data + input->size, 1, room - input->size, file);
		input->size += got;
		if (ferror(file))
			return fault_set(fault, EX_SYSTEM, "%s: %s", input->shown, strerror(errno));
		if (input->size > INPUT_SIZE_LIMIT)
			return too_large(input, fault);
		if (input->size < room)
			return true; /* a short fread without error is the end */
		room *= 2;
		input->data = mem_resize(input->data, room + 1, 1);
	}
}

/* Replace compressed data by what it holds: one or more gzip members, then nothing but zeros. */
static bool inflate_whole(struct input *input, struct fault *fault)
{
	z_stream z = {.next_in = input->data, .avail_in = (uInt)input->size};
	if (inflateInit2(&z, 15 + 16) != Z_OK)
		return fault_set(fault, EX_SYSTEM, "%s: cannot start zlib", input->shown);
	size_t room = input->size * 4 > FIRST_ROOM ? input->size * 4 : FIRST_ROOM, size = 0;
	unsigned char *data = mem_resize(NULL, room + 1, 1);
	bool good = false;
	for (;;) {
		const size_t ask = room - size;
		z.next_out = data + size;
		z.avail_out = ask > UINT32_MAX ? UINT32_MAX : (uInt)ask;
		const size_t before = z.avail_out;
		const int status = inflate(&z, Z_NO_FLUSH);
		size += before - z.avail_out;
		if (size > INPUT_SIZE_LIMIT) {
			too_large(input, fault);
			break;
		}
		if (status == Z_STREAM_END) {
			while (z.avail_in && *z.next_in == 0) { /* padding of tapes and discs */
				z.next_in++;
				z.avail_in--;
			}
			if (z.avail_in == 0) {
				good = true;
				break;
			}
			if (z.avail_in < 2 || z.next_in[0] != 0x1f || z.next_in[1] != 0x8b || inflateReset(&z) != Z_OK) {
				fault_set(fault, EX_BAD_INPUT, "%s: byte %zu: garbage behind the gzip data", input->shown,
				          input->size - z.avail_in);
				break;
			}
			continue;
		}
		if (status == Z_MEM_ERROR) {
			fault_set(fault, EX_SYSTEM, "%s: zlib is out of memory", input->shown);
			break;
		}
		if (status != Z_OK && status != Z_BUF_ERROR) {
			fault_set(fault, EX_BAD_INPUT, "%s: byte %zu: damaged gzip data", input->shown, input->size - z.avail_in);
			break;
		}
		if (z.avail_out == 0) {
			room *= 2;
			data = mem_resize(data, room + 1, 1);
		} else if (z.avail_in == 0) {
			fault_set(fault, EX_BAD_INPUT, "%s: the gzip data ends too early", input->shown);
			break;
		}
	}
	inflateEnd(&z);
	free(input->data);
	input->data = data;
	input->size = size;
	return good;
}

bool input_read(struct input *input, const char *path, struct fault *fault)
{
	const bool is_stdin = !path || strcmp(path, "-") == 0;
	*input = (struct input){.shown = is_stdin ? "<stdin>" : path};
	FILE *file = is_stdin ? stdin : fopen(path, "rb");
	if (!file)
		return fault_set(fault, EX_SYSTEM, "%s: %s", input->shown, strerror(errno));
	struct stat status;
	size_t expected = 0;
	bool good = true;
	if (fstat(fileno(file), &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0) {
		expected = (size_t)status.st_size;
		if (expected > INPUT_SIZE_LIMIT)
			good = too_large(input, fault);
	}
	good = good && read_stream(input, file, expected, fault);
	if (!is_stdin)
		fclose(file);
	if (good && input->size >= 2 && input->data[0] == 0x1f && input->data[1] == 0x8b)
		good = inflate_whole(input, fault);
	if (!good) {
		input_free(input);
		return false;
	}
	input->data[input->size] = 0;
	return true;
}

void input_free(struct input *input)
{
	free(input->data);
	input->data = NULL;
	input->size = 0;
}

void path_extension(char extension[8], const char *path)
{
	extension[0] = 0;
	const char *slash = strrchr(path, '/');
	const char *name = slash ? slash + 1 : path;
	size_t length = strlen(name);
	if (length > 3 && strcasecmp(name + length - 3, ".gz") == 0)
		length -= 3;
	size_t start = length;
	while (start > 0 && name[start - 1] != '.')
		start--;
	/* start == 0: no dot; start == 1: a hidden file without extension */
	if (start < 2 || length - start >= 8)
		return;
	for (size_t i = start; i < length; i++)
		extension[i - start] = (char)tolower((unsigned char)name[i]);
	extension[length - start] = 0;
}
