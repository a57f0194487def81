/* PLY as columnar tables: any element, any property, nothing lost on the way through.
 *
 * A stage reads a file into a struct ply, takes the columns that it knows, adds or replaces what is its job, and writes
 * the same struct: elements, properties and comments that it does not know pass untouched, in their order, with their
 * numbers as they were written. See ply(5). */
#ifndef CAGEWRIGHT_PLY_H
#define CAGEWRIGHT_PLY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "formats/fault.h"
#include "formats/input.h"
#include "formats/memory.h"

enum ply_encoding { PLY_ASCII, PLY_BINARY_LITTLE, PLY_BINARY_BIG };
enum ply_type { PLY_INT8, PLY_UINT8, PLY_INT16, PLY_UINT16, PLY_INT32, PLY_UINT32, PLY_FLOAT32, PLY_FLOAT64 };

/* One property of one element. Every PLY scalar fits a double exactly. */
struct ply_column {
	char *name;
	enum ply_type type;
	bool is_list;
	enum ply_type count_type; /* of a list's length */
	double *value;            /* scalars: element count values; lists: start[element count] values */
	size_t *start;            /* lists: item i is value[start[i]] .. value[start[i + 1]]; NULL for scalars */
	struct ply_written *written; /* private: texts of an ascii file that differ from how we would print them */
};

struct ply_element {
	char *name;
	size_t count;
	struct ply_column *column;
	size_t column_count;
};

struct ply {
	enum ply_encoding encoding; /* as read; ascii for a new one. The writer obeys it */
	char **comment;             /* whole header lines "comment ..." and "obj_info ...", in order */
	size_t comment_count;
	struct ply_element *element;
	size_t element_count;
};

void ply_init(struct ply *ply);
void ply_free(struct ply *ply);

/* Read a whole file. Faults name line (ascii and header) or byte (binary) and element: wrong magic, unknown type,
 * duplicate names, counts that the remaining bytes cannot hold, text that is no number, integers out of their type's
 * range, too few or too many data. Non-finite floats are accepted here (schemas refuse them). */
bool ply_read(struct ply *ply, const struct input *input, struct fault *fault);

/* Write in ply->encoding. write(read(write(x))) == write(x) byte for byte. Stream errors are left to output_commit. */
void ply_write(FILE *file, const struct ply *ply);

/* NULL when absent. */
struct ply_element *ply_element(const struct ply *ply, const char *name);
struct ply_column *ply_column(const struct ply_element *element, const char *name);

/* Add an element, or empty the one of that name in its place and give it a new count. The pointer holds until the next element is added. */
struct ply_element *ply_put_element(struct ply *ply, const char *name, size_t count);
void ply_drop_element(struct ply *ply, const char *name);

/* Add a scalar property or replace the one of that name; returns its values (element count, zeroed) to be filled. */
double *ply_put_scalar(struct ply_element *element, const char *name, enum ply_type type);

/* Add or replace a list property; start (element count + 1 offsets) and value are copied. The count type is uint8 when
 * every list is at most 255 long, else int32. */
void ply_put_list(struct ply_element *element, const char *name, enum ply_type type, const size_t *start, const double *value);
void ply_drop_column(struct ply_element *element, const char *name);

/* Append a header line "comment ...", printf-like; line ends in the text become spaces. */
void ply_comment(struct ply *ply, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* What a schema asks for: the element or column, or a fault "shown: element 'face' has no property 'patch'". */
struct ply_element *ply_want_element(const struct ply *ply, const char *name, const char *shown, struct fault *fault);
const struct ply_column *ply_want_scalar(const struct ply_element *element, const char *name, const char *shown, struct fault *fault);
const struct ply_column *ply_want_list(const struct ply_element *element, const char *name, const char *shown, struct fault *fault);

/* Copy a column of whole numbers to an idx_t array (caller frees), refusing values outside [low, high). For lists the flat values. */
idx_t *ply_indices(const struct ply_element *element, const struct ply_column *column, long long low, long long high,
                   const char *shown, struct fault *fault);

/* Read x y z (any scalar type) of an element into an interleaved array of 3 * count finite doubles (caller frees). */
double *ply_points(const struct ply_element *element, const char *shown, struct fault *fault);
void ply_put_points(struct ply_element *element, const double *xyz);

/* ply_want_scalar and ply_indices in one. */
idx_t *ply_index_scalar(const struct ply_element *element, const char *name, long long low, long long high, const char *shown,
                        struct fault *fault);
/* One scalar property as finite doubles (caller frees); NULL with a fault when it is absent or a value is nan or inf. */
double *ply_numbers(const struct ply_element *element, const char *name, const char *shown, struct fault *fault);
/* Three scalar properties interleaved, as ply_points does for x y z. */
double *ply_triples(const struct ply_element *element, const char *const name[3], const char *shown, struct fault *fault);
void ply_put_triples(struct ply_element *element, const char *const name[3], const double *xyz);
/* Index columns: a scalar of an integer type (element count values), or int32 lists (start has element count + 1 offsets). */
void ply_put_indices(struct ply_element *element, const char *name, enum ply_type type, const idx_t *index);
void ply_put_index_lists(struct ply_element *element, const char *name, const size_t *start, const idx_t *index);

#endif
