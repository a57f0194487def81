/* Reading PLY: header, then tables. Every count is bounded by what the remaining bytes can hold before memory is taken. */
#include <stdlib.h>
#include <string.h>

#include "formats/number.h"
#include "formats/ply.h"
#include "formats/ply_internal.h"

/* More elements or properties than any real file has; bounds the search for duplicate names. */
#define NAME_LIMIT 1000

struct reader {
	struct ply *ply;
	const char *shown;
	const char *start, *at, *end;
	size_t line; /* of `at`, from 1 */
	struct fault *fault;
};

struct word {
	const char *text;
	size_t length;
};

/* ---- header ---- */

/* The next line without its end, or false at the end of data. */
static bool next_line(struct reader *r, struct word *line)
{
	if (r->at == r->end)
		return false;
	const char *stop = memchr(r->at, '\n', (size_t)(r->end - r->at));
	const char *next = stop ? stop + 1 : r->end;
	if (!stop)
		stop = r->end;
	/* all of them: careless conversions leave several, and a comment that ended in one would lose it when read again */
	while (stop > r->at && stop[-1] == '\r')
		stop--;
	*line = (struct word){r->at, (size_t)(stop - r->at)};
	r->at = next;
	return true;
}

static bool is_blank(char c)
{
	return c == ' ' || c == '\t';
}

static struct word next_word(struct word *rest)
{
	const char *at = rest->text, *const end = rest->text + rest->length;
	while (at < end && is_blank(*at))
		at++;
	const char *stop = at;
	while (stop < end && !is_blank(*stop))
		stop++;
	rest->text = stop;
	rest->length = (size_t)(end - stop);
	return (struct word){at, (size_t)(stop - at)};
}

static bool is_word(struct word word, const char *text)
{
	return word.length == strlen(text) && memcmp(word.text, text, word.length) == 0;
}

static char *copy_word(struct word word)
{
	char *copy = mem_array(word.length + 1, 1);
	memcpy(copy, word.text, word.length);
	return copy;
}

#define SHOWN_LENGTH 40

/* For messages: a word of reasonable length, without bytes that end a string or steer a terminal. */
static const char *show(char room[SHOWN_LENGTH + 1], struct word word)
{
	const size_t length = word.length < SHOWN_LENGTH ? word.length : SHOWN_LENGTH;
	for (size_t i = 0; i < length; i++)
		room[i] = (unsigned char)word.text[i] < ' ' ? '?' : word.text[i];
	room[length] = 0;
	return room;
}

static bool header_fault(struct reader *r, const char *what, struct word word)
{
	char room[SHOWN_LENGTH + 1];
	return fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: %s '%s'", r->shown, r->line, what, show(room, word));
}

static bool parse_type(struct reader *r, struct word word, enum ply_type *type)
{
	static const char *const sized[8] = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
	for (int t = 0; t < 8; t++) {
		if (is_word(word, ply_type_name[t]) || is_word(word, sized[t])) {
			*type = (enum ply_type)t;
			return true;
		}
	}
	return word.length ? header_fault(r, "unknown type", word)
	                   : fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: property without type", r->shown, r->line);
}

static bool parse_format(struct reader *r, struct word rest)
{
	static const char *const name[3] = {"ascii", "binary_little_endian", "binary_big_endian"};
	const struct word word = next_word(&rest), version = next_word(&rest);
	if (!is_word(version, "1.0"))
		return header_fault(r, "unknown PLY version", version);
	for (int f = 0; f < 3; f++) {
		if (is_word(word, name[f])) {
			r->ply->encoding = (enum ply_encoding)f;
			return true;
		}
	}
	return header_fault(r, "unknown PLY format", word);
}

static bool parse_element(struct reader *r, struct word rest)
{
	const struct word name = next_word(&rest), number = next_word(&rest);
	long long count;
	if (!name.length || !number.length)
		return header_fault(r, "element without name or count", name);
	if (!num_parse_integer(number.text, number.length, 0, (long long)INDEX_LIMIT - 1, &count))
		return header_fault(r, "bad element count", number);
	if (next_word(&rest).length)
		return header_fault(r, "something stands behind the count of element", name);
	char *copy = copy_word(name);
	bool good = true;
	if (ply_element(r->ply, copy))
		good = header_fault(r, "a second element", name);
	else if (r->ply->element_count == NAME_LIMIT)
		good = header_fault(r, "too many elements at", name);
	else
		ply_put_element(r->ply, copy, (size_t)count);
	free(copy);
	return good;
}

static bool parse_property(struct reader *r, struct word rest)
{
	if (!r->ply->element_count)
		return header_fault(r, "property before any element:", rest);
	struct ply_element *element = &r->ply->element[r->ply->element_count - 1];
	struct ply_column column = {0};
	struct word word = next_word(&rest);
	if (is_word(word, "list")) {
		column.is_list = true;
		word = next_word(&rest);
		if (!parse_type(r, word, &column.count_type))
			return false;
		if (ply_type_is_float(column.count_type))
			return header_fault(r, "a list's length cannot be of type", word);
		word = next_word(&rest);
	}
	if (!parse_type(r, word, &column.type))
		return false;
	const struct word name = next_word(&rest);
	if (!name.length)
		return header_fault(r, "property without name in element", (struct word){element->name, strlen(element->name)});
	if (next_word(&rest).length)
		return header_fault(r, "something stands behind the name of property", name);
	if (element->column_count == NAME_LIMIT)
		return header_fault(r, "too many properties at", name);
	column.name = copy_word(name);
	if (ply_column(element, column.name)) {
		free(column.name);
		return header_fault(r, "a second property", name);
	}
	element->column = mem_resize(element->column, element->column_count + 1, sizeof column);
	element->column[element->column_count++] = column;
	return true;
}

static bool read_header(struct reader *r)
{
	struct word line;
	bool has_format = false;
	r->line = 1;
	if (!next_line(r, &line) || !is_word(line, "ply"))
		return fault_set(r->fault, EX_BAD_INPUT, "%s:1: not a PLY file: the first line is not 'ply'", r->shown);
	size_t comment_room = 0;
	for (;;) {
		r->line++;
		if (!next_line(r, &line))
			return fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: the header has no end", r->shown, r->line);
		if (memchr(line.text, 0, line.length))
			return fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: binary data in the header", r->shown, r->line);
		struct word rest = line;
		const struct word key = next_word(&rest);
		bool good = true;
		if (key.length == 0) {
			continue;
		} else if (is_word(key, "comment") || is_word(key, "obj_info")) {
			struct ply *ply = r->ply;
			if (ply->comment_count == comment_room) {
				comment_room = comment_room ? 2 * comment_room : 8;
				ply->comment = mem_resize(ply->comment, comment_room, sizeof *ply->comment);
			}
			ply->comment[ply->comment_count++] = copy_word((struct word){key.text, (size_t)(line.text + line.length - key.text)});
		} else if (is_word(key, "format")) {
			good = has_format ? header_fault(r, "a second", key) : parse_format(r, rest);
			has_format = true;
		} else if (is_word(key, "element")) {
			good = parse_element(r, rest);
		} else if (is_word(key, "property")) {
			good = parse_property(r, rest);
		} else if (is_word(key, "end_header")) {
			r->line++;
			if (!has_format)
				return fault_set(r->fault, EX_BAD_INPUT, "%s: the header has no format line", r->shown);
			return true;
		} else {
			good = header_fault(r, "unknown header line", key);
		}
		if (!good)
			return false;
	}
}

/* ---- tables ---- */

static bool short_fault(struct reader *r, const struct ply_element *element)
{
	return fault_set(r->fault, EX_BAD_INPUT, "%s: element '%s': %zu promised, the file is too short for them", r->shown,
	                 element->name, element->count);
}

/* Take memory for a table once its rows, of at least least_bytes each, are known to fit what is left of the file. */
static bool prepare_table(struct reader *r, struct ply_element *element, size_t least_bytes)
{
	/* a row of an element without properties takes no bytes: bound it by the file all the same */
	const size_t bytes = least_bytes ? (size_t)(r->end - r->at) + 1 : (size_t)(r->end - r->start);
	if (element->count > bytes / (least_bytes ? least_bytes : 1))
		return short_fault(r, element);
	for (size_t c = 0; c < element->column_count; c++) {
		struct ply_column *column = &element->column[c];
		if (column->is_list)
			column->start = mem_array(element->count + 1, sizeof *column->start);
		column->value = mem_array(element->count, sizeof *column->value);
	}
	return true;
}

/* Room for more values of a list column; *room is what value has. */
static void list_grow(struct ply_column *column, size_t *room, size_t need)
{
	if (need <= *room)
		return;
	*room = need > 2 * *room ? need : 2 * *room;
	column->value = mem_resize(column->value, *room, sizeof *column->value);
}

/* Would we print this number just so? True for the plain forms: "12", "-0.05", "1e-07" with at most 15 significant
 * digits (every such decimal is the shortest one of its double) for doubles, 6 for floats. */
static bool is_plain(const char *text, size_t length, bool is_float, int digits_limit)
{
	const char *at = text, *const end = text + length;
	if (at < end && *at == '-')
		at++;
	const char *whole = at;
	while (at < end && (unsigned)(*at - '0') < 10)
		at++;
	const size_t whole_digits = (size_t)(at - whole);
	const int whole_limit = digits_limit == 6 ? 7 : 15; /* whole numbers below 2^24 are exact in a float */
	if (whole_digits == 0 || (whole[0] == '0' && whole_digits > 1))
		return false;
	if (at == end) /* "-0" is no integer, but a float */
		return (whole[0] != '0' || whole == text || is_float) && whole_digits <= (size_t)(is_float ? whole_limit : 10);
	if (!is_float || *at != '.' || whole_digits > (size_t)digits_limit)
		return false;
	const char *fraction = ++at;
	while (at < end && (unsigned)(*at - '0') < 10)
		at++;
	if (at != end || at == fraction || at[-1] == '0')
		return false;
	size_t digits = whole_digits + (size_t)(at - fraction);
	if (whole[0] == '0') {
		size_t zeros = 0;
		while (fraction[zeros] == '0')
			zeros++;
		if (zeros > 3) /* printed with an exponent */
			return false;
		digits -= 1 + zeros;
	}
	return digits <= (size_t)digits_limit;
}

static bool would_print(const char *text, size_t length, enum ply_type type, double value)
{
	const bool is_float = ply_type_is_float(type);
	if (is_plain(text, length, is_float, type == PLY_FLOAT32 ? 6 : 15))
		return true;
	char ours[NUM_TEXT_SIZE];
	const size_t made = type == PLY_FLOAT32 ? num_print_float(ours, (float)value) : num_print(ours, value);
	return made == length && memcmp(ours, text, length) == 0;
}

static bool ascii_fault(struct reader *r, const struct ply_element *element, size_t item, const char *what, struct word word)
{
	char room[SHOWN_LENGTH + 1];
	return fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: %s %zu: %s '%s'", r->shown, r->line, element->name, item, what,
	                 show(room, word));
}

/* The next number of a line: false with a fault when there is none or it is none of its type. */
static bool ascii_number(struct reader *r, struct word *rest, const struct ply_element *element, size_t item, const char *name,
                         enum ply_type type, struct word *word, double *value)
{
	*word = next_word(rest);
	if (!word->length)
		return fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: %s %zu: the line ends before property '%s'", r->shown, r->line,
		                 element->name, item, name);
	if (ply_type_is_float(type)) {
		if (!num_parse(word->text, word->length, value))
			return ascii_fault(r, element, item, "not a number:", *word);
		if (type == PLY_FLOAT32)
			*value = (double)(float)*value;
		return true;
	}
	long long low, high, whole;
	ply_type_range(type, &low, &high);
	if (!num_parse_integer(word->text, word->length, low, high, &whole)) {
		const size_t sign = word->text[0] == '-' || word->text[0] == '+';
		size_t digits = 0;
		while (sign + digits < word->length && (unsigned)(word->text[sign + digits] - '0') < 10)
			digits++;
		if (digits && sign + digits == word->length)
			return ascii_fault(r, element, item, "out of the property's range:", *word);
		return ascii_fault(r, element, item, "not a whole number:", *word);
	}
	*value = (double)whole;
	return true;
}

static bool ascii_row(struct reader *r, struct ply_element *element, size_t item, struct word rest, size_t *room)
{
	struct word word;
	double value;
	for (size_t c = 0; c < element->column_count; c++) {
		struct ply_column *column = &element->column[c];
		size_t first = item, count = 1;
		if (column->is_list) {
			if (!ascii_number(r, &rest, element, item, column->name, column->count_type, &word, &value))
				return false;
			/* each value takes a blank and a digit */
			if (value < 0 || value > (double)(rest.length / 2))
				return ascii_fault(r, element, item, "the line does not hold a list of length", word);
			first = column->start[item];
			count = (size_t)value;
			column->start[item + 1] = first + count;
			list_grow(column, &room[c], first + count);
		}
		for (size_t i = first; i < first + count; i++) {
			if (!ascii_number(r, &rest, element, item, column->name, column->type, &word, &value))
				return false;
			column->value[i] = value;
			if (!would_print(word.text, word.length, column->type, value))
				ply_written_add(column, i, word.text, word.length);
		}
	}
	word = next_word(&rest);
	if (word.length)
		return ascii_fault(r, element, item, "the line goes on behind the last property:", word);
	return true;
}

static bool is_empty(struct word line)
{
	return next_word(&line).length == 0;
}

static bool ascii_table(struct reader *r, struct ply_element *element)
{
	if (!prepare_table(r, element, 2 * element->column_count))
		return false;
	if (!element->column_count)
		return true;
	size_t *room = mem_array(element->column_count, sizeof *room);
	for (size_t c = 0; c < element->column_count; c++)
		room[c] = element->count;
	bool good = true;
	for (size_t i = 0; good && i < element->count; i++) {
		struct word line = {0};
		bool found = false;
		while ((found = next_line(r, &line)) && is_empty(line))
			r->line++;
		if (!found)
			good = fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: the file ends before %s %zu of %zu", r->shown, r->line,
			                 element->name, i, element->count);
		else
			good = ascii_row(r, element, i, line, room);
		r->line++;
	}
	free(room);
	return good;
}

static double binary_value(const unsigned char *at, enum ply_type type, bool big)
{
	const size_t size = ply_type_size(type);
	uint64_t bits = 0;
	for (size_t i = 0; i < size; i++)
		bits |= (uint64_t)at[i] << 8 * (big ? size - 1 - i : i);
	union { uint32_t bits; float value; } single;
	union { uint64_t bits; double value; } twice;
	switch (type) {
	case PLY_INT8: return (int8_t)bits;
	case PLY_INT16: return (int16_t)bits;
	case PLY_INT32: return (int32_t)bits;
	case PLY_FLOAT32: single.bits = (uint32_t)bits; return (double)single.value;
	case PLY_FLOAT64: twice.bits = bits; return twice.value;
	default: return (double)bits;
	}
}

static bool binary_list(struct reader *r, struct ply_element *element, struct ply_column *column, size_t item, size_t *room, bool big)
{
	const size_t head = ply_type_size(column->count_type), size = ply_type_size(column->type);
	if ((size_t)(r->end - r->at) < head)
		return short_fault(r, element);
	const double count = binary_value((const unsigned char *)r->at, column->count_type, big);
	r->at += head;
	if (count < 0 || count > (double)((size_t)(r->end - r->at) / size))
		return fault_set(r->fault, EX_BAD_INPUT, "%s: byte %zu: %s %zu: the file does not hold a list of length %lld", r->shown,
		                 (size_t)(r->at - r->start) - head, element->name, item, (long long)count);
	const size_t first = column->start[item], end = first + (size_t)count;
	list_grow(column, room, end);
	for (size_t i = first; i < end; i++, r->at += size)
		column->value[i] = binary_value((const unsigned char *)r->at, column->type, big);
	column->start[item + 1] = end;
	return true;
}

static bool binary_table(struct reader *r, struct ply_element *element)
{
	const bool big = r->ply->encoding == PLY_BINARY_BIG;
	size_t least = 0;
	for (size_t c = 0; c < element->column_count; c++)
		least += ply_type_size(element->column[c].is_list ? element->column[c].count_type : element->column[c].type);
	if (!prepare_table(r, element, least))
		return false;
	size_t *room = mem_array(element->column_count, sizeof *room);
	for (size_t c = 0; c < element->column_count; c++)
		room[c] = element->count;
	bool good = true;
	for (size_t i = 0; good && i < element->count; i++) {
		for (size_t c = 0; good && c < element->column_count; c++) {
			struct ply_column *column = &element->column[c];
			const size_t size = ply_type_size(column->type);
			if (column->is_list) {
				good = binary_list(r, element, column, i, &room[c], big);
			} else if ((size_t)(r->end - r->at) < size) {
				good = short_fault(r, element);
			} else {
				column->value[i] = binary_value((const unsigned char *)r->at, column->type, big);
				r->at += size;
			}
		}
	}
	free(room);
	return good;
}

static bool read_tables(struct reader *r)
{
	const bool ascii = r->ply->encoding == PLY_ASCII;
	for (size_t e = 0; e < r->ply->element_count; e++)
		if (!(ascii ? ascii_table : binary_table)(r, &r->ply->element[e]))
			return false;
	if (!ascii) {
		if (r->at != r->end)
			return fault_set(r->fault, EX_BAD_INPUT, "%s: byte %zu: %zu bytes stand behind the last element", r->shown,
			                 (size_t)(r->at - r->start), (size_t)(r->end - r->at));
		return true;
	}
	for (struct word line; next_line(r, &line); r->line++)
		if (!is_empty(line))
			return fault_set(r->fault, EX_BAD_INPUT, "%s:%zu: a line behind the last element", r->shown, r->line);
	return true;
}

bool ply_read(struct ply *ply, const struct input *input, struct fault *fault)
{
	ply_init(ply);
	const char *data = (const char *)input->data;
	if (input->size == 0) /* what a pipe gives when the stage before has failed */
		return fault_set(fault, EX_BAD_INPUT, "%s: the file is empty", input->shown);
	struct reader r = {ply, input->shown, data, data, data + input->size, 1, fault};
	if (read_header(&r) && read_tables(&r))
		return true;
	ply_free(ply);
	return false;
}
