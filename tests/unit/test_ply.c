#include "tests/unit/helpers.h"

#include <time.h>

/* A pyramid's worth of everything: comments, obj_info, a list, an element of a program we do not know. */
static const char sample[] =
	"ply\n"
	"format ascii 1.0\n"
	"comment made by hand\n"
	"obj_info scanner 7\n"
	"element vertex 3\n"
	"property double x\n"
	"property double y\n"
	"property float z\n"
	"property uchar red\n"
	"element face 2\n"
	"property list uchar int vertex_indices\n"
	"property short tag\n"
	"element weather 1\n"
	"property float rain\n"
	"property list ushort double wind\n"
	"end_header\n"
	"0 0.5 0.1 255\n"
	"1 -2.25 1e-07 0\n"
	"3 0.3333333333333333 7 12\n"
	"3 0 1 2 -5\n"
	"0 6\n"
	"1.5 2 0.25 1e+300\n";

static void takes_columns(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply ply;
	assert_true(ply_of(&ply, sample, &fault));
	assert_int_equal(ply.element_count, 3);
	const struct ply_element *vertex = ply_element(&ply, "vertex"), *face = ply_element(&ply, "face");
	assert_int_equal(vertex->count, 3);
	assert_true(ply_column(vertex, "y")->value[1] == -2.25);
	assert_true(ply_column(vertex, "z")->value[0] == (double)0.1f); /* a float column holds floats */
	assert_true(ply_column(vertex, "red")->value[0] == 255);
	const struct ply_column *corners = ply_column(face, "vertex_indices");
	assert_true(corners->is_list);
	assert_int_equal(corners->start[1], 3);
	assert_int_equal(corners->start[2], 3); /* an empty list */
	assert_true(corners->value[2] == 2);
	assert_null(ply_element(&ply, "edge"));
	assert_null(ply_column(face, "patch"));
	assert_int_equal(ply.comment_count, 2);
	assert_string_equal(ply.comment[0], "comment made by hand");
	assert_string_equal(ply.comment[1], "obj_info scanner 7");
	ply_free(&ply);
}

static void writes_what_it_read(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply ply;
	assert_true(ply_of(&ply, sample, &fault));
	char *text = ply_text(&ply, NULL);
	assert_string_equal(text, sample);
	free(text);
	ply_free(&ply);
}

static void all_encodings_hold_the_same(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply ply;
	assert_true(ply_of(&ply, sample, &fault));
	for (int encoding = PLY_BINARY_LITTLE; encoding <= PLY_BINARY_BIG; encoding++) {
		size_t size, again_size;
		ply.encoding = (enum ply_encoding)encoding;
		char *text = ply_text(&ply, &size);
		struct input input = input_of(text, size);
		struct ply back;
		assert_true(ply_read(&back, &input, &fault));
		assert_int_equal(back.encoding, encoding);
		char *again = ply_text(&back, &again_size);
		assert_int_equal(again_size, size);
		assert_memory_equal(again, text, size);
		free(again);
		back.encoding = PLY_ASCII;
		again = ply_text(&back, NULL);
		assert_string_equal(again, sample);
		free(again);
		free(text);
		input_free(&input);
		ply_free(&back);
	}
	ply_free(&ply);
}

/* Bytes written out by hand from the specification: 1 and 258 as int, 1.5 as float. */
static void binary_is_in_the_order_it_says(void **state)
{
	(void)state;
	static const char little[] = "ply\nformat binary_little_endian 1.0\nelement a 1\nproperty list uchar int b\nproperty float c\n"
	                             "end_header\n\x02\x01\0\0\0\x02\x01\0\0\0\0\xc0\x3f";
	static const char big[] = "ply\nformat binary_big_endian 1.0\nelement a 1\nproperty list uchar int b\nproperty float c\n"
	                          "end_header\n\x02\0\0\0\x01\0\0\x01\x02\x3f\xc0\0\0";
	for (int k = 0; k < 2; k++) {
		struct fault fault = {0};
		struct input input = k ? input_of(big, sizeof big - 1) : input_of(little, sizeof little - 1);
		struct ply ply;
		assert_true(ply_read(&ply, &input, &fault));
		const struct ply_column *list = ply_column(&ply.element[0], "b");
		assert_true(list->value[0] == 1 && list->value[1] == 258);
		assert_true(ply_column(&ply.element[0], "c")->value[0] == 1.5);
		input_free(&input);
		ply_free(&ply);
	}
}

static void numbers_stay_as_written(void **state)
{
	(void)state;
	static const char text[] = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty double y\nproperty int n\n"
	                           "property list uchar double l\nend_header\n"
	                           "1.50 +2 -0 2 3.14159265358979323846 0.10\n"
	                           ".5 1E3 007 1 nan\n";
	struct fault fault = {0};
	struct ply ply;
	assert_true(ply_of(&ply, text, &fault));
	char *out = ply_text(&ply, NULL);
	assert_string_equal(out, text);
	free(out);
	/* a number that a stage changes is printed anew, the others are not touched */
	ply_column(&ply.element[0], "x")->value[0] = 2;
	ply_column(&ply.element[0], "l")->value[1] = 0.5;
	out = ply_text(&ply, NULL);
	assert_contains(out, "\n2 +2 -0 2 3.14159265358979323846 0.5\n.5 1E3 007 1 nan\n");
	free(out);
	ply_free(&ply);
}

/* Every column of a program's file may be printed in any of these ways; all must come out as they went in. */
static void any_number_form_passes(void **state)
{
	(void)state;
	static const char *const form[] = {"0", "-0", "0.0", "00", "1", "1.", "1.0", "10", "10.50", "0.001", "0.0001", "0.00010",
	                                   "0.00001", "1e-05", "1e-5", "1E-05", "123456", "1234567", "12345678", "123456789.25",
	                                   "16777217", "99999999999", "999999999999999", "1000000000000000", "1e+15", "1e15",
	                                   "0.1234567", "0.12345678901234567", "1.7976931348623157e+308", "1e999", "-inf", "NaN",
	                                   "3.4028235e+38", "3.5e38", "4.9406564584124654e-324", "5e-324", "9007199254740993"};
	for (int is_double = 0; is_double < 2; is_double++) {
		for (size_t i = 0; i < sizeof form / sizeof *form; i++) {
			char text[200];
			snprintf(text, sizeof text, "ply\nformat ascii 1.0\nelement a 1\nproperty %s b\nend_header\n%s\n",
			         is_double ? "double" : "float", form[i]);
			struct fault fault = {0};
			struct ply ply;
			assert_true(ply_of(&ply, text, &fault));
			char *out = ply_text(&ply, NULL);
			assert_string_equal(out, text);
			free(out);
			ply_free(&ply);
		}
	}
}

static void reads_both_line_ends(void **state)
{
	(void)state;
	char crlf[2 * sizeof sample];
	size_t size = 0;
	for (const char *c = sample; *c; c++) {
		if (*c == '\n')
			crlf[size++] = '\r';
		crlf[size++] = *c;
	}
	crlf[size] = 0;
	struct fault fault = {0};
	struct ply ply;
	assert_true(ply_of(&ply, crlf, &fault));
	char *out = ply_text(&ply, NULL);
	assert_string_equal(out, sample);
	free(out);
	ply_free(&ply);
	/* blanks, tabs, empty lines and a missing last line end do no harm */
	assert_true(ply_of(&ply, "ply\nformat ascii 1.0\n\nelement  a\t2\nproperty int\tb\nend_header\n 1 \n\n\t2", &fault));
	assert_true(ply_column(&ply.element[0], "b")->value[1] == 2);
	ply_free(&ply);
}

static void builds_documents(void **state)
{
	(void)state;
	struct ply ply;
	ply_init(&ply);
	ply_comment(&ply, "one %d\ntwo", 1);
	struct ply_element *a = ply_put_element(&ply, "a", 2);
	double *b = ply_put_scalar(a, "b", PLY_INT8);
	b[0] = -128;
	b[1] = 127;
	const size_t start[] = {0, 1, 3};
	const double value[] = {1.5, 2, 3};
	ply_put_list(a, "c", PLY_FLOAT64, start, value);
	struct ply_element *z = ply_put_element(&ply, "z", 1);
	ply_put_scalar(z, "zz", PLY_UINT32)[0] = 4294967295.0;
	ply_put_scalar(ply_put_element(&ply, "gone", 1), "x", PLY_FLOAT32);
	ply_drop_element(&ply, "gone");
	ply_drop_element(&ply, "never was");
	char *out = ply_text(&ply, NULL);
	assert_string_equal(out, "ply\nformat ascii 1.0\ncomment one 1 two\nelement a 2\nproperty char b\n"
	                         "property list uchar double c\nelement z 1\nproperty uint zz\nend_header\n"
	                         "-128 1 1.5\n127 2 2 3\n4294967295\n");
	free(out);
	/* an element that is put again keeps its place and loses its columns; so does a column */
	a = ply_put_element(&ply, "a", 1);
	assert_int_equal(a->column_count, 0);
	ply_put_scalar(a, "d", PLY_UINT8)[0] = 1;
	ply_put_scalar(a, "e", PLY_UINT8)[0] = 2;
	ply_put_scalar(a, "d", PLY_FLOAT64)[0] = 0.5;
	out = ply_text(&ply, NULL);
	assert_contains(out, "element a 1\nproperty double d\nproperty uchar e\nelement z 1\n");
	assert_contains(out, "\n0.5 2\n4294967295\n");
	free(out);
	ply_drop_column(ply_element(&ply, "a"), "d");
	assert_null(ply_column(ply_element(&ply, "a"), "d"));
	ply_free(&ply);
}

static void long_lists_get_a_wide_count(void **state)
{
	(void)state;
	struct ply ply;
	ply_init(&ply);
	double value[300];
	for (int i = 0; i < 300; i++)
		value[i] = i;
	const size_t start[] = {0, 300};
	ply_put_list(ply_put_element(&ply, "a", 1), "l", PLY_INT32, start, value);
	ply.encoding = PLY_BINARY_BIG;
	size_t size;
	char *out = ply_text(&ply, &size);
	assert_contains(out, "property list int int l\n");
	struct input input = input_of(out, size);
	struct fault fault = {0};
	struct ply back;
	assert_true(ply_read(&back, &input, &fault));
	assert_int_equal(back.element[0].column[0].start[1], 300);
	assert_true(back.element[0].column[0].value[299] == 299);
	ply_free(&back);
	input_free(&input);
	free(out);
	ply_free(&ply);
}

static void wrong_values_are_clamped_not_undefined(void **state)
{
	(void)state;
	struct ply ply;
	ply_init(&ply);
	double *v = ply_put_scalar(ply_put_element(&ply, "a", 3), "b", PLY_UINT8);
	v[0] = 256;
	v[1] = -1;
	v[2] = NAN;
	char *out = ply_text(&ply, NULL);
	assert_contains(out, "end_header\n255\n0\n0\n");
	free(out);
	ply_free(&ply);
}

static void schema_questions(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply ply;
	assert_true(ply_of(&ply, "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
	                         "element face 2\nproperty list uchar int vertex_index\nproperty float tag\nend_header\n"
	                         "0 1 2\n3 inf 5\n3 0 1 2\n3 0 9 1\n7 0.5\n",
	                    &fault) == false);
	assert_contains(fault.text, "t.ply:13: face 0: the line ends before property 'tag'");
	fault = (struct fault){0};
	assert_true(ply_of(&ply, "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
	                         "element face 2\nproperty list uchar int vertex_index\nproperty float tag\nend_header\n"
	                         "0 1 2\n3 inf 5\n3 0 1 2 1\n3 0 9 1 0.5\n",
	                    &fault));
	const struct ply_element *vertex = ply_want_element(&ply, "vertex", "t.ply", &fault);
	assert_null(ply_points(vertex, "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: vertex 1: y is not a finite number");
	fault = (struct fault){0};
	const struct ply_element *face = ply_want_element(&ply, "face", "t.ply", &fault);
	/* the other spelling of the name is known */
	const struct ply_column *corners = ply_want_list(face, "vertex_indices", "t.ply", &fault);
	assert_non_null(corners);
	assert_null(ply_indices(face, corners, 0, 2, "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: face 0: vertex_index: 2 is not within 0 to 1");
	fault = (struct fault){0};
	assert_null(ply_indices(face, corners, 0, 9, "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: face 1: vertex_index: 9 is not within 0 to 8");
	fault = (struct fault){0};
	idx_t *index = ply_indices(face, corners, 0, 10, "t.ply", &fault);
	assert_int_equal(index[4], 9);
	free(index);
	assert_null(ply_index_scalar(face, "tag", 0, 10, "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: face 1: tag: 0.5 is no whole number");
	fault = (struct fault){0};
	assert_null(ply_want_element(&ply, "wedge", "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: there is no element 'wedge'");
	fault = (struct fault){0};
	assert_null(ply_want_scalar(face, "patch", "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: element 'face' has no property 'patch'");
	fault = (struct fault){0};
	assert_null(ply_want_scalar(face, "vertex_index", "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: element 'face': property 'vertex_index' is a list");
	fault = (struct fault){0};
	assert_null(ply_want_list(face, "tag", "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: element 'face': property 'tag' is no list");
	ply_free(&ply);
}

/* Counts and lengths that promise more than the file holds must not take memory for it: this returns at once. */
static void promises_are_bounded(void **state)
{
	(void)state;
	static const char *const liars[] = {
		"ply\nformat ascii 1.0\nelement a 2000000000\nproperty int b\nend_header\n1\n",
		"ply\nformat ascii 1.0\nelement a 2000000000\nend_header\n",
		"ply\nformat binary_little_endian 1.0\nelement a 2000000000\nproperty list int double b\nend_header\n1",
		"ply\nformat binary_little_endian 1.0\nelement a 1\nproperty list uint double b\nend_header\n\xff\xff\xff\xff",
		"ply\nformat binary_little_endian 1.0\nelement a 1\nproperty list int double b\nend_header\n\xff\xff\xff\xff",
		"ply\nformat ascii 1.0\nelement a 1\nproperty list uint double b\nend_header\n4000000000 1\n",
		"ply\nformat ascii 1.0\nelement a 99999999999999999999\nend_header\n",
	};
	for (size_t i = 0; i < sizeof liars / sizeof *liars; i++) {
		struct fault fault = {0};
		struct ply ply;
		assert_false(ply_of(&ply, liars[i], &fault));
		assert_int_equal(fault.code, EX_BAD_INPUT);
	}
}

/* Cut anywhere, a file is refused and nothing leaks: every prefix of the sample in each encoding. */
static void every_prefix_is_refused(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply whole;
	assert_true(ply_of(&whole, sample, &fault));
	for (int encoding = PLY_ASCII; encoding <= PLY_BINARY_BIG; encoding++) {
		size_t size;
		whole.encoding = (enum ply_encoding)encoding;
		char *text = ply_text(&whole, &size);
		/* "1", "1e+3", "1e+30" are numbers too: an ascii file may be cut within the last one and nobody can tell */
		const size_t last = encoding == PLY_ASCII ? size - strlen("1e+300\n") + 1 : size;
		for (size_t cut = 0; cut < last; cut++) {
			struct input input = input_of(text, cut);
			struct ply ply;
			fault = (struct fault){0};
			if (ply_read(&ply, &input, &fault))
				fail_msg("encoding %d: the first %zu bytes were accepted", encoding, cut);
			assert_int_equal(fault.code, EX_BAD_INPUT);
			input_free(&input);
		}
		free(text);
	}
	ply_free(&whole);
}

/* Flipped bytes may or may not be valid, but never more than that. */
static void damage_is_survived(void **state)
{
	(void)state;
	struct fault fault = {0};
	struct ply whole;
	assert_true(ply_of(&whole, sample, &fault));
	for (int encoding = PLY_ASCII; encoding <= PLY_BINARY_BIG; encoding++) {
		size_t size;
		whole.encoding = (enum ply_encoding)encoding;
		char *text = ply_text(&whole, &size);
		for (size_t at = 0; at < size; at++) {
			for (int bit = 0; bit < 8; bit++) {
				struct input input = input_of(text, size);
				input.data[at] ^= (unsigned char)(1 << bit);
				struct ply ply;
				fault = (struct fault){0};
				if (ply_read(&ply, &input, &fault))
					ply_free(&ply);
				else
					assert_int_equal(fault.code, EX_BAD_INPUT);
				input_free(&input);
			}
		}
		free(text);
	}
	ply_free(&whole);
}

/* A mesh of 100000 triangles with doubles and lists reads fast enough for every stage of a pipeline to do it. */
static void large_tables_are_quick(void **state)
{
	(void)state;
	struct ply ply;
	ply_init(&ply);
	const size_t count = 100000;
	struct ply_element *a = ply_put_element(&ply, "a", count);
	for (int c = 0; c < 5; c++) {
		double *v = ply_put_scalar(a, (char[]){(char)('a' + c), 0}, PLY_FLOAT64);
		for (size_t i = 0; i < count; i++)
			v[i] = sin((double)i + c);
	}
	char *text = ply_text(&ply, NULL);
	ply_free(&ply);
	struct fault fault = {0};
	const clock_t before = clock();
	assert_true(ply_of(&ply, text, &fault));
	/* 0.05 s at home; the bound is for slow machines and sanitizers */
	assert_true((double)(clock() - before) / CLOCKS_PER_SEC < 2);
	char *again = ply_text(&ply, NULL);
	assert_string_equal(again, text);
	free(again);
	free(text);
	ply_free(&ply);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(takes_columns),
		cmocka_unit_test(writes_what_it_read),
		cmocka_unit_test(all_encodings_hold_the_same),
		cmocka_unit_test(binary_is_in_the_order_it_says),
		cmocka_unit_test(numbers_stay_as_written),
		cmocka_unit_test(any_number_form_passes),
		cmocka_unit_test(reads_both_line_ends),
		cmocka_unit_test(builds_documents),
		cmocka_unit_test(long_lists_get_a_wide_count),
		cmocka_unit_test(wrong_values_are_clamped_not_undefined),
		cmocka_unit_test(schema_questions),
		cmocka_unit_test(promises_are_bounded),
		cmocka_unit_test(every_prefix_is_refused),
		cmocka_unit_test(damage_is_survived),
		cmocka_unit_test(large_tables_are_quick),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
