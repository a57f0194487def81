/* The PLY document: elements and properties added, replaced, dropped, asked for. Reading: ply_read.c, writing: ply_write.c. */
#include "formats/ply.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "formats/number.h"
#include "formats/ply_internal.h"

const char *const ply_type_name[8] = {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};

size_t ply_type_size(enum ply_type type)
{
	static const size_t size[8] = {1, 1, 2, 2, 4, 4, 4, 8};
	return size[type];
}

bool ply_type_is_float(enum ply_type type)
{
	return type == PLY_FLOAT32 || type == PLY_FLOAT64;
}

void ply_type_range(enum ply_type type, long long *low, long long *high)
{
	static const long long range[6][2] = {{INT8_MIN, INT8_MAX}, {0, UINT8_MAX}, {INT16_MIN, INT16_MAX},
	                                      {0, UINT16_MAX}, {INT32_MIN, INT32_MAX}, {0, UINT32_MAX}};
	*low = range[type][0];
	*high = range[type][1];
}

static void written_free(struct ply_column *column)
{
	if (column->written) {
		free(column->written->item);
		free(column->written->pool);
		free(column->written);
	}
	column->written = NULL;
}

void ply_written_add(struct ply_column *column, size_t index, const char *text, size_t length)
{
	if (!column->written)
		column->written = mem_array(1, sizeof *column->written);
	struct ply_written *w = column->written;
	if (w->count == w->room) {
		w->room = w->room ? 2 * w->room : 16;
		w->item = mem_resize(w->item, w->room, sizeof *w->item);
	}
	if (w->pool_room - w->pool_size < length) {
		w->pool_room = 2 * w->pool_room + length + 64;
		w->pool = mem_resize(w->pool, w->pool_room, 1);
	}
	memcpy(w->pool + w->pool_size, text, length);
	w->item[w->count++] = (struct ply_written_item){index, w->pool_size, length, column->value[index]};
	w->pool_size += length;
}

static void column_free(struct ply_column *column)
{
	written_free(column);
	free(column->name);
	free(column->value);
	free(column->start);
}

static void element_clear(struct ply_element *element)
{
	for (size_t c = 0; c < element->column_count; c++)
		column_free(&element->column[c]);
	free(element->column);
	element->column = NULL;
	element->column_count = 0;
}

void ply_init(struct ply *ply)
{
	*ply = (struct ply){.encoding = PLY_ASCII};
}

void ply_free(struct ply *ply)
{
	for (size_t e = 0; e < ply->element_count; e++) {
		element_clear(&ply->element[e]);
		free(ply->element[e].name);
	}
	for (size_t c = 0; c < ply->comment_count; c++)
		free(ply->comment[c]);
	free(ply->element);
	free(ply->comment);
	ply_init(ply);
}

struct ply_element *ply_element(const struct ply *ply, const char *name)
{
	for (size_t e = 0; e < ply->element_count; e++)
		if (strcmp(ply->element[e].name, name) == 0)
			return &ply->element[e];
	return NULL;
}

struct ply_column *ply_column(const struct ply_element *element, const char *name)
{
	for (size_t c = 0; c < element->column_count; c++)
		if (strcmp(element->column[c].name, name) == 0)
			return &element->column[c];
	return NULL;
}

struct ply_element *ply_put_element(struct ply *ply, const char *name, size_t count)
{
	struct ply_element *element = ply_element(ply, name);
	if (element) {
		element_clear(element);
		element->count = count;
		return element;
	}
	ply->element = mem_resize(ply->element, ply->element_count + 1, sizeof *ply->element);
	element = &ply->element[ply->element_count++];
	*element = (struct ply_element){.name = mem_copy(name, strlen(name) + 1, 1), .count = count};
	return element;
}

void ply_drop_element(struct ply *ply, const char *name)
{
	struct ply_element *element = ply_element(ply, name);
	if (!element)
		return;
	element_clear(element);
	free(element->name);
	const size_t behind = (size_t)(ply->element + ply->element_count - element) - 1;
	memmove(element, element + 1, behind * sizeof *element);
	ply->element_count--;
}

/* A column of that name without values, in its old place or behind the others. */
static struct ply_column *put_column(struct ply_element *element, const char *name)
{
	struct ply_column *column = ply_column(element, name);
	if (column) {
		column_free(column);
	} else {
		element->column = mem_resize(element->column, element->column_count + 1, sizeof *element->column);
		column = &element->column[element->column_count++];
	}
	*column = (struct ply_column){.name = mem_copy(name, strlen(name) + 1, 1)};
	return column;
}

double *ply_put_scalar(struct ply_element *element, const char *name, enum ply_type type)
{
	struct ply_column *column = put_column(element, name);
	column->type = type;
	column->value = mem_array(element->count, sizeof *column->value);
	return column->value;
}

void ply_put_list(struct ply_element *element, const char *name, enum ply_type type, const size_t *start, const double *value)
{
	struct ply_column *column = put_column(element, name);
	column->type = type;
	column->is_list = true;
	column->count_type = PLY_UINT8;
	for (size_t i = 0; i < element->count; i++)
		if (start[i + 1] - start[i] > UINT8_MAX)
			column->count_type = PLY_INT32;
	column->start = mem_copy(start, element->count + 1, sizeof *start);
	column->value = mem_copy(value, start[element->count], sizeof *value);
}

void ply_drop_column(struct ply_element *element, const char *name)
{
	struct ply_column *column = ply_column(element, name);
	if (!column)
		return;
	column_free(column);
	const size_t behind = (size_t)(element->column + element->column_count - column) - 1;
	memmove(column, column + 1, behind * sizeof *column);
	element->column_count--;
}

void ply_comment(struct ply *ply, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	char *line = NULL;
	const int length = vsnprintf(NULL, 0, format, args);
	va_end(args);
	const size_t prefix = strlen("comment ");
	line = mem_array(prefix + (length > 0 ? (size_t)length : 0) + 1, 1);
	memcpy(line, "comment ", prefix);
	va_start(args, format);
	if (length > 0)
		vsnprintf(line + prefix, (size_t)length + 1, format, args);
	va_end(args);
	for (char *c = line; *c; c++)
		if (*c == '\n' || *c == '\r')
			*c = ' ';
	ply->comment = mem_resize(ply->comment, ply->comment_count + 1, sizeof *ply->comment);
	ply->comment[ply->comment_count++] = line;
}

struct ply_element *ply_want_element(const struct ply *ply, const char *name, const char *shown, struct fault *fault)
{
	struct ply_element *element = ply_element(ply, name);
	if (!element)
		fault_set(fault, EX_BAD_INPUT, "%s: there is no element '%s'", shown, name);
	return element;
}

static const struct ply_column *want_column(const struct ply_element *element, const char *name, bool list, const char *shown,
                                            struct fault *fault)
{
	const struct ply_column *column = ply_column(element, name);
	/* both spellings are common for faces */
	if (!column && strcmp(name, "vertex_indices") == 0)
		column = ply_column(element, "vertex_index");
	if (!column) {
		fault_set(fault, EX_BAD_INPUT, "%s: element '%s' has no property '%s'", shown, element->name, name);
		return NULL;
	}
	if (column->is_list != list) {
		fault_set(fault, EX_BAD_INPUT, "%s: element '%s': property '%s' is %s list", shown, element->name, column->name,
		          list ? "no" : "a");
		return NULL;
	}
	return column;
}

const struct ply_column *ply_want_scalar(const struct ply_element *element, const char *name, const char *shown, struct fault *fault)
{
	return want_column(element, name, false, shown, fault);
}

const struct ply_column *ply_want_list(const struct ply_element *element, const char *name, const char *shown, struct fault *fault)
{
	return want_column(element, name, true, shown, fault);
}

/* Which item holds the flat value at index? */
static size_t item_of(const struct ply_element *element, const struct ply_column *column, size_t index)
{
	if (!column->is_list)
		return index;
	size_t low = 0, high = element->count;
	while (high - low > 1) {
		const size_t middle = low + (high - low) / 2;
		if (column->start[middle] <= index)
			low = middle;
		else
			high = middle;
	}
	return low;
}

idx_t *ply_indices(const struct ply_element *element, const struct ply_column *column, long long low, long long high,
                   const char *shown, struct fault *fault)
{
	const size_t count = column->is_list ? column->start[element->count] : element->count;
	if (high > (long long)INDEX_LIMIT)
		high = (long long)INDEX_LIMIT;
	idx_t *index = mem_array(count, sizeof *index);
	for (size_t i = 0; i < count; i++) {
		const double value = column->value[i];
		if (value >= (double)low && value < (double)high && value == floor(value)) {
			index[i] = (idx_t)value;
			continue;
		}
		char text[NUM_TEXT_SIZE];
		num_print(text, value);
		if (high <= low)
			fault_set(fault, EX_BAD_INPUT, "%s: %s %zu: %s: %s does not exist, there are none", shown, element->name,
			          item_of(element, column, i), column->name, text);
		else if (value == floor(value))
			fault_set(fault, EX_BAD_INPUT, "%s: %s %zu: %s: %s is not within %lld to %lld", shown, element->name,
			          item_of(element, column, i), column->name, text, low, high - 1);
		else
			fault_set(fault, EX_BAD_INPUT, "%s: %s %zu: %s: %s is no whole number", shown, element->name,
			          item_of(element, column, i), column->name, text);
		free(index);
		return NULL;
	}
	return index;
}

idx_t *ply_index_scalar(const struct ply_element *element, const char *name, long long low, long long high, const char *shown,
                        struct fault *fault)
{
	const struct ply_column *column = ply_want_scalar(element, name, shown, fault);
	return column ? ply_indices(element, column, low, high, shown, fault) : NULL;
}

double *ply_numbers(const struct ply_element *element, const char *name, const char *shown, struct fault *fault)
{
	const struct ply_column *column = ply_want_scalar(element, name, shown, fault);
	if (!column)
		return NULL;
	for (size_t i = 0; i < element->count; i++) {
		if (!isfinite(column->value[i])) {
			fault_set(fault, EX_BAD_INPUT, "%s: %s %zu: %s is not a finite number", shown, element->name, i, name);
			return NULL;
		}
	}
	return mem_copy(column->value, element->count, sizeof *column->value);
}

double *ply_triples(const struct ply_element *element, const char *const name[3], const char *shown, struct fault *fault)
{
	double *xyz = mem_array(element->count, 3 * sizeof *xyz);
	for (int k = 0; k < 3; k++) {
		double *values = ply_numbers(element, name[k], shown, fault);
		if (!values) {
			free(xyz);
			return NULL;
		}
		for (size_t i = 0; i < element->count; i++)
			xyz[3 * i + k] = values[i];
		free(values);
	}
	return xyz;
}

void ply_put_triples(struct ply_element *element, const char *const name[3], const double *xyz)
{
	for (int k = 0; k < 3; k++) {
		double *values = ply_put_scalar(element, name[k], PLY_FLOAT64);
		for (size_t i = 0; i < element->count; i++)
			values[i] = xyz[3 * i + k];
	}
}

static const char *const position[3] = {"x", "y", "z"};

double *ply_points(const struct ply_element *element, const char *shown, struct fault *fault)
{
	return ply_triples(element, position, shown, fault);
}

void ply_put_points(struct ply_element *element, const double *xyz)
{
	ply_put_triples(element, position, xyz);
}

void ply_put_indices(struct ply_element *element, const char *name, enum ply_type type, const idx_t *index)
{
	double *values = ply_put_scalar(element, name, type);
	for (size_t i = 0; i < element->count; i++)
		values[i] = index[i];
}

void ply_put_index_lists(struct ply_element *element, const char *name, const size_t *start, const idx_t *index)
{
	const size_t count = start[element->count];
	double *values = mem_array(count, sizeof *values);
	for (size_t i = 0; i < count; i++)
		values[i] = index[i];
	ply_put_list(element, name, PLY_INT32, start, values);
	free(values);
}
