/* Reads every file under tests/formats/FORMAT/passed and failed. Run from the root of the tree. */
#include "tests/unit/helpers.h"

#include <dirent.h>

#include "formats/cage.h"
#include "formats/dense.h"
#include "formats/input.h"
#include "formats/network.h"

/* Read a file as its format; in case of success write it twice: write(read(write(x))) must be write(x). */
typedef bool check_file(const char *path, struct fault *fault);

typedef bool schema_check(struct ply *ply, const char *shown, struct fault *fault);

/* Through the schema and back into the document. */
static bool dense_round(struct ply *ply, const char *shown, struct fault *fault)
{
	struct dense dense;
	if (!dense_from_ply(&dense, ply, false, shown, fault))
		return false;
	dense_to_ply(ply, &dense);
	dense_free(&dense);
	return true;
}

static bool network_round(struct ply *ply, const char *shown, struct fault *fault)
{
	struct network network;
	if (!network_from_ply(&network, ply, "vertex", shown, fault))
		return false;
	network_to_ply(ply, &network, "vertex");
	network_free(&network);
	return true;
}

static bool cage_round(struct ply *ply, const char *shown, struct fault *fault)
{
	struct cage cage;
	if (!cage_from_ply(&cage, ply, shown, fault))
		return false;
	cage_to_ply(ply, &cage);
	cage_free(&cage);
	return true;
}

static bool no_schema(struct ply *ply, const char *shown, struct fault *fault)
{
	(void)ply;
	(void)shown;
	(void)fault;
	return true;
}

static bool check_ply(const char *path, schema_check *schema, struct fault *fault)
{
	struct input input;
	struct ply ply;
	if (!input_read(&input, path, fault))
		fail_msg("%s", fault->text);
	bool good = ply_read(&ply, &input, fault);
	input_free(&input);
	if (!good)
		return false;
	good = schema(&ply, path, fault);
	if (good) {
		size_t size, again_size;
		char *text = ply_text(&ply, &size);
		struct input back = input_of(text, size);
		struct ply again;
		if (!ply_read(&again, &back, fault) || !schema(&again, path, fault))
			fail_msg("%s: what was written cannot be read: %s", path, fault->text);
		char *again_text = ply_text(&again, &again_size);
		if (again_size != size || memcmp(again_text, text, size) != 0)
			fail_msg("%s: written again it is different", path);
		free(text);
		free(again_text);
		input_free(&back);
		ply_free(&again);
	}
	ply_free(&ply);
	return good;
}

static bool file_ply(const char *path, struct fault *fault)
{
	return check_ply(path, no_schema, fault);
}

static bool file_dense(const char *path, struct fault *fault)
{
	return check_ply(path, dense_round, fault);
}

static bool file_network(const char *path, struct fault *fault)
{
	return check_ply(path, network_round, fault);
}

static bool file_cage(const char *path, struct fault *fault)
{
	return check_ply(path, cage_round, fault);
}

static const struct {
	const char *format;
	check_file *check;
	int least_passed, least_failed; /* so that an empty folder is no success */
} formats[] = {
	{"ply", file_ply, 15, 75},
	{"dense", file_dense, 5, 25},
	{"network", file_network, 4, 20},
	{"cage", file_cage, 5, 24},
};

static int visible(const struct dirent *entry)
{
	return entry->d_name[0] != '.';
}

static int run_folder(size_t format, bool passed)
{
	char folder[100], path[400];
	snprintf(folder, sizeof folder, "tests/formats/%s/%s", formats[format].format, passed ? "passed" : "failed");
	struct dirent **entry;
	const int count = scandir(folder, &entry, visible, alphasort);
	if (count < 0)
		fail_msg("%s: cannot be opened (the tests run from the root of the tree)", folder);
	for (int i = 0; i < count; i++) {
		snprintf(path, sizeof path, "%s/%s", folder, entry[i]->d_name);
		struct fault fault = {0};
		const bool good = formats[format].check(path, &fault);
		if (passed && !good)
			fail_msg("refused: %s", fault.text);
		if (!passed) {
			if (good)
				fail_msg("%s: accepted", path);
			assert_int_equal(fault.code, EX_BAD_INPUT);
			/* the message begins with the file's name and then says something, in one line */
			assert_ptr_equal(strstr(fault.text, path), fault.text);
			assert_true(strlen(fault.text) > strlen(path) + 10);
			assert_null(strchr(fault.text, '\n'));
			if (getenv("SHOW_MESSAGES"))
				print_message("%s\n", fault.text);
		}
		free(entry[i]);
	}
	free(entry);
	return count;
}

static void passed_files_are_read(void **state)
{
	(void)state;
	for (size_t f = 0; f < sizeof formats / sizeof *formats; f++)
		assert_true(run_folder(f, true) >= formats[f].least_passed);
}

static void failed_files_are_refused(void **state)
{
	(void)state;
	for (size_t f = 0; f < sizeof formats / sizeof *formats; f++)
		assert_true(run_folder(f, false) >= formats[f].least_failed);
}

/* The example of each format's page: the lines between ".Bd" and ".Ed" that begin with "ply". */
static void examples_of_pages_are_read(void **state)
{
	(void)state;
	for (size_t f = 0; f < sizeof formats / sizeof *formats; f++) {
		char page[100], path[100], folder[64];
		static char text[100000];
		snprintf(page, sizeof page, "man/man5/cagewright-%s.5", formats[f].format);
		file_text(text, sizeof text, page);
		char *start = strstr(text, "\nply\nformat");
		char *end = start ? strstr(start, "\n.Ed\n") : NULL;
		if (!end)
			fail_msg("%s: no example", page);
		folder_make(folder);
		snprintf(path, sizeof path, "%s/example.ply", folder);
		file_write(path, start + 1, (size_t)(end - start));
		struct fault fault = {0};
		const bool good = formats[f].check(path, &fault);
		folder_remove(folder);
		if (!good)
			fail_msg("%s: %s", page, fault.text);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(passed_files_are_read),
		cmocka_unit_test(failed_files_are_refused),
		cmocka_unit_test(examples_of_pages_are_read),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
