/* Words and lines of the text mesh formats. Private to the readers of formats/mesh_*.c. */
#ifndef CAGEWRIGHT_MESH_TEXT_H
#define CAGEWRIGHT_MESH_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include "formats/fault.h"
#include "formats/mesh.h"

struct text {
	const char *at, *end;
	size_t line;      /* of the last word, from 1 */
	size_t next_line; /* of at */
	char comment;     /* starts a comment that ends with the line; 0: there are none */
	const char *shown;
	struct fault *fault;
};

struct word {
	const char *text;
	size_t length;
};

struct text text_begin(const struct input *input, char comment, struct fault *fault);

/* The next word, on this line or a later one; false at the end of the file. */
bool text_word(struct text *text, struct word *word);
/* The next word of this line; false at its end. */
bool text_word_of_line(struct text *text, struct word *word);
void text_skip_line(struct text *text);

bool word_is(struct word word, const char *lower_case); /* in any case of letters */

/* Fault "shown:line: what". Returns false. */
bool text_fault(const struct text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* A finite coordinate of a readable size, or a fault that says which vertex of which thing it is. */
bool text_coordinate(struct text *text, struct word word, double *value);

/* Meshes that grow. */
struct mesh_builder {
	struct mesh mesh;
	size_t vertex_room, corner_room, face_room;
};
void builder_init(struct mesh_builder *builder);
void builder_vertex(struct mesh_builder *builder, const double xyz[3]);
void builder_corner(struct mesh_builder *builder, idx_t vertex);
void builder_end_face(struct mesh_builder *builder);

/* The readers. Each fills *mesh, or frees it and reports. */
bool mesh_read_stl_text(struct mesh *mesh, const struct input *input, struct fault *fault);
bool mesh_read_stl_binary(struct mesh *mesh, const struct input *input, struct fault *fault);
bool mesh_read_off(struct mesh *mesh, const struct input *input, struct fault *fault);
bool mesh_read_om(struct mesh *mesh, const struct input *input, struct fault *fault);
bool mesh_read_obj(struct mesh *mesh, const struct input *input, struct fault *fault);

#endif
