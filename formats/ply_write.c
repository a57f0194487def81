/* Writing PLY: the canonical form of a document, the same bytes for the same document. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/number.h"
#include "formats/ply.h"
#include "formats/ply_internal.h"

/* Collects small writes. */
struct sink {
	FILE *file;
	size_t used;
	char room[1 << 16];
};

static void sink_flush(struct sink *sink)
{
	fwrite(sink->room, 1, sink->used, sink->file);
	sink->used = 0;
}

static void put(struct sink *sink, const char *bytes, size_t count)
{
	if (count > sizeof sink->room - sink->used)
		sink_flush(sink);
	if (count > sizeof sink->room) {
		fwrite(bytes, 1, count, sink->file);
		return;
	}
	memcpy(sink->room + sink->used, bytes, count);
	sink->used += count;
}

static void put_text(struct sink *sink, const char *text)
{
	put(sink, text, strlen(text));
}

static void put_size(struct sink *sink, size_t number)
{
	char text[NUM_TEXT_SIZE];
	put(sink, text, num_print(text, (double)number));
}

/* What is stored for a value that does not fit its type: the nearest that does. Stages never need it; it keeps a wrong
 * value from being undefined behaviour. */
static long long to_whole(double value, enum ply_type type)
{
	long long low, high;
	ply_type_range(type, &low, &high);
	if (!(value > (double)low)) /* nan too */
		return low;
	return value < (double)high ? (long long)value : high;
}

static size_t print_value(char text[NUM_TEXT_SIZE], double value, enum ply_type type)
{
	if (type == PLY_FLOAT64)
		return num_print(text, value);
	if (type == PLY_FLOAT32)
		return num_print_float(text, (float)value);
	return num_print(text, (double)to_whole(value, type));
}

static void put_binary(struct sink *sink, double value, enum ply_type type, bool big)
{
	const size_t size = ply_type_size(type);
	union { uint32_t bits; float value; } single;
	union { uint64_t bits; double value; } twice;
	uint64_t bits;
	if (type == PLY_FLOAT64) {
		twice.value = value;
		bits = twice.bits;
	} else if (type == PLY_FLOAT32) {
		single.value = (float)value;
		bits = single.bits;
	} else {
		bits = (uint64_t)to_whole(value, type);
	}
	char bytes[8];
	for (size_t i = 0; i < size; i++)
		bytes[i] = (char)(bits >> 8 * (big ? size - 1 - i : i));
	put(sink, bytes, size);
}

static void write_header(struct sink *sink, const struct ply *ply)
{
	static const char *const format[3] = {"ascii", "binary_little_endian", "binary_big_endian"};
	put_text(sink, "ply\nformat ");
	put_text(sink, format[ply->encoding]);
	put_text(sink, " 1.0\n");
	for (size_t c = 0; c < ply->comment_count; c++) {
		put_text(sink, ply->comment[c]);
		put_text(sink, "\n");
	}
	for (size_t e = 0; e < ply->element_count; e++) {
		const struct ply_element *element = &ply->element[e];
		put_text(sink, "element ");
		put_text(sink, element->name);
		put_text(sink, " ");
		put_size(sink, element->count);
		put_text(sink, "\n");
		for (size_t c = 0; c < element->column_count; c++) {
			const struct ply_column *column = &element->column[c];
			put_text(sink, column->is_list ? "property list " : "property ");
			if (column->is_list) {
				put_text(sink, ply_type_name[column->count_type]);
				put_text(sink, " ");
			}
			put_text(sink, ply_type_name[column->type]);
			put_text(sink, " ");
			put_text(sink, column->name);
			put_text(sink, "\n");
		}
	}
	put_text(sink, "end_header\n");
}

static bool same_number(double a, double b)
{
	return memcmp(&a, &b, sizeof a) == 0;
}

/* next: the first kept text of the column at or behind index. */
static void put_ascii(struct sink *sink, const struct ply_column *column, size_t index, size_t *next)
{
	const struct ply_written *w = column->written;
	if (w && *next < w->count && w->item[*next].index == index) {
		const struct ply_written_item *item = &w->item[(*next)++];
		if (same_number(item->number, column->value[index])) {
			put(sink, w->pool + item->text, item->length);
			return;
		}
	}
	char text[NUM_TEXT_SIZE];
	put(sink, text, print_value(text, column->value[index], column->type));
}

static void write_ascii(struct sink *sink, const struct ply_element *element)
{
	if (!element->column_count)
		return;
	size_t *next = mem_array(element->column_count, sizeof *next);
	for (size_t i = 0; i < element->count; i++) {
		for (size_t c = 0; c < element->column_count; c++) {
			const struct ply_column *column = &element->column[c];
			if (c)
				put(sink, " ", 1);
			if (!column->is_list) {
				put_ascii(sink, column, i, &next[c]);
				continue;
			}
			put_size(sink, column->start[i + 1] - column->start[i]);
			for (size_t k = column->start[i]; k < column->start[i + 1]; k++) {
				put(sink, " ", 1);
				put_ascii(sink, column, k, &next[c]);
			}
		}
		put(sink, "\n", 1);
	}
	free(next);
}

static void write_binary(struct sink *sink, const struct ply_element *element, bool big)
{
	for (size_t i = 0; i < element->count; i++) {
		for (size_t c = 0; c < element->column_count; c++) {
			const struct ply_column *column = &element->column[c];
			size_t first = i, end = i + 1;
			if (column->is_list) {
				first = column->start[i];
				end = column->start[i + 1];
				put_binary(sink, (double)(end - first), column->count_type, big);
			}
			for (size_t k = first; k < end; k++)
				put_binary(sink, column->value[k], column->type, big);
		}
	}
}

void ply_write(FILE *file, const struct ply *ply)
{
	struct sink *sink = mem_array(1, sizeof *sink);
	sink->file = file;
	write_header(sink, ply);
	for (size_t e = 0; e < ply->element_count; e++) {
		if (ply->encoding == PLY_ASCII)
			write_ascii(sink, &ply->element[e]);
		else
			write_binary(sink, &ply->element[e], ply->encoding == PLY_BINARY_BIG);
	}
	sink_flush(sink);
	free(sink);
}
