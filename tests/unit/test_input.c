#include "tests/unit/helpers.h"

#include <sys/stat.h>
#include <zlib.h>

#include "formats/input.h"

static char folder[64];

static int setup(void **state)
{
	(void)state;
	folder_make(folder);
	return 0;
}

static int teardown(void **state)
{
	(void)state;
	folder_remove(folder);
	return 0;
}

static const char *in_folder(const char *name)
{
	static char path[200];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	return path;
}

/* One gzip member. */
static size_t pack(unsigned char *to, size_t room, const char *text)
{
	z_stream z = {0};
	deflateInit2(&z, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
	z.next_in = (unsigned char *)(uintptr_t)text;
	z.avail_in = (uInt)strlen(text);
	z.next_out = to;
	z.avail_out = (uInt)room;
	deflate(&z, Z_FINISH);
	const size_t size = room - z.avail_out;
	deflateEnd(&z);
	return size;
}

static void reads_plain_files(void **state)
{
	(void)state;
	file_write(in_folder("a.txt"), "hello", 5);
	struct fault fault = {0};
	struct input input;
	assert_true(input_read(&input, in_folder("a.txt"), &fault));
	assert_int_equal(input.size, 5);
	assert_string_equal((char *)input.data, "hello"); /* a 0 stands behind the data */
	assert_string_equal(input.shown, in_folder("a.txt"));
	input_free(&input);
	file_write(in_folder("empty"), "", 0);
	assert_true(input_read(&input, in_folder("empty"), &fault));
	assert_int_equal(input.size, 0);
	input_free(&input);
}

static void reads_large_files(void **state)
{
	(void)state;
	/* larger than the first room */
	const size_t size = 300000;
	char *data = malloc(size);
	for (size_t i = 0; i < size; i++)
		data[i] = (char)(i * 7);
	file_write(in_folder("large"), data, size);
	struct fault fault = {0};
	struct input input;
	assert_true(input_read(&input, in_folder("large"), &fault));
	assert_int_equal(input.size, size);
	assert_memory_equal(input.data, data, size);
	input_free(&input);
	free(data);
}

static void says_why_it_cannot_open(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct input input;
	assert_false(input_read(&input, in_folder("none"), &fault));
	assert_int_equal(fault.code, EX_SYSTEM);
	assert_contains(fault.text, "none: No such file or directory");
	fault = (struct fault){0};
	assert_false(input_read(&input, folder, &fault));
	assert_int_equal(fault.code, EX_SYSTEM);
	assert_contains(fault.text, "Is a directory");
}

static void unpacks_gzip_by_content(void **state)
{
	(void)state;
	unsigned char data[400];
	/* two members, as `cat a.gz b.gz` makes them, then padding; the name says nothing of gzip */
	size_t size = pack(data, 150, "first ");
	size += pack(data + size, 150, "second");
	memset(data + size, 0, 30);
	file_write(in_folder("two.stl"), data, size + 30);
	struct fault fault = {0};
	struct input input;
	assert_true(input_read(&input, in_folder("two.stl"), &fault));
	assert_string_equal((char *)input.data, "first second");
	input_free(&input);
	/* a name that promises gzip is not believed either */
	file_write(in_folder("plain.gz"), "plain", 5);
	assert_true(input_read(&input, in_folder("plain.gz"), &fault));
	assert_string_equal((char *)input.data, "plain");
	input_free(&input);
}

static void refuses_damaged_gzip(void **state)
{
	(void)state;
	unsigned char data[400];
	const size_t size = pack(data, 200, "some text that is long enough to be cut in the middle, then read");
	struct input input;
	struct fault fault = {0};
	file_write(in_folder("cut.gz"), data, size / 2);
	assert_false(input_read(&input, in_folder("cut.gz"), &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_contains(fault.text, "ends too early");
	fault = (struct fault){0};
	memcpy(data + size, "garbage", 7);
	file_write(in_folder("more.gz"), data, size + 7);
	assert_false(input_read(&input, in_folder("more.gz"), &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_contains(fault.text, "garbage behind");
	fault = (struct fault){0};
	data[size - 6] ^= 1; /* the checksum */
	file_write(in_folder("bad.gz"), data, size);
	assert_false(input_read(&input, in_folder("bad.gz"), &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_contains(fault.text, "damaged gzip data");
	fault = (struct fault){0};
	file_write(in_folder("two.gz"), "\x1f\x8b", 2);
	assert_false(input_read(&input, in_folder("two.gz"), &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
}

static void refuses_too_much(void **state)
{
	(void)state;
	/* a file with a hole takes no room on disk */
	FILE *file = fopen(in_folder("huge"), "wb");
	assert_non_null(file);
	assert_int_equal(ftruncate(fileno(file), (off_t)INPUT_SIZE_LIMIT + 1), 0);
	fclose(file);
	struct fault fault = {0};
	struct input input;
	assert_false(input_read(&input, in_folder("huge"), &fault));
	assert_int_equal(fault.code, EX_BAD_INPUT);
	assert_contains(fault.text, "more than 1024 MiB");
}

static void from_stdin(void *context)
{
	(void)context;
	struct fault fault = {0};
	struct input input;
	if (!freopen(in_folder("in"), "rb", stdin) || !input_read(&input, "-", &fault))
		exit(1);
	printf("%s|%s", input.shown, input.data);
	input_free(&input);
}

static void reads_stdin(void **state)
{
	(void)state;
	file_write(in_folder("in"), "text", 4);
	const struct ending ending = run_child(from_stdin, NULL);
	assert_int_equal(ending.exit_code, 0);
	assert_string_equal(ending.out, "<stdin>|text");
}

static void finds_extensions(void **state)
{
	(void)state;
	static const char *const known[][2] = {
		{"part.stl", "stl"}, {"Part.STL.gz", "stl"}, {"a/b.c/part", ""}, {"a.b/part.off", "off"}, {"part", ""},
		{".stl", ""},        {"part.", ""},          {"part.gz", ""},    {"x.tar.GZ", "tar"},      {"part.longextension", ""},
		{"", ""},            {"dir.stl/", ""},       {"a.1234567", "1234567"}, {"a.12345678", ""},
	};
	for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
		char extension[8];
		path_extension(extension, known[i][0]);
		if (strcmp(extension, known[i][1]) != 0)
			fail_msg("'%s' gives '%s'", known[i][0], extension);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(reads_plain_files),    cmocka_unit_test(reads_large_files), cmocka_unit_test(says_why_it_cannot_open),
		cmocka_unit_test(unpacks_gzip_by_content), cmocka_unit_test(refuses_damaged_gzip), cmocka_unit_test(refuses_too_much),
		cmocka_unit_test(reads_stdin),          cmocka_unit_test(finds_extensions),
	};
	return cmocka_run_group_tests(tests, setup, teardown);
}
