#include "formats/mesh_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "formats/number.h"

struct text text_begin(const struct input *input, char comment, struct fault *fault)
{
	const char *begin = (const char *)input->data;
	return (struct text){begin, begin + input->size, 1, 1, comment, input->shown, fault};
}

static bool is_blank(char c)
{
	return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

bool text_word_of_line(struct text *text, struct word *word)
{
	while (text->at < text->end && is_blank(*text->at))
		text->at++;
	if (text->comment && text->at < text->end && *text->at == text->comment)
		while (text->at < text->end && *text->at != '\n')
			text->at++;
	text->line = text->next_line;
	if (text->at == text->end || *text->at == '\n')
		return false;
	word->text = text->at;
	while (text->at < text->end && !is_blank(*text->at) && *text->at != '\n' &&
	       !(text->comment && *text->at == text->comment))
		text->at++;
	word->length = (size_t)(text->at - word->text);
	return true;
}

bool text_word(struct text *text, struct word *word)
{
	while (!text_word_of_line(text, word)) {
		if (text->at == text->end)
			return false;
		text->at++;
		text->next_line++;
	}
	return true;
}

void text_skip_line(struct text *text)
{
	while (text->at < text->end && *text->at != '\n')
		text->at++;
}

bool word_is(struct word word, const char *lower_case)
{
	return strlen(lower_case) == word.length && strncasecmp(word.text, lower_case, word.length) == 0;
}

bool text_fault(const struct text *text, const char *format, ...)
{
	char what[300];
	va_list args;
	va_start(args, format);
	vsnprintf(what, sizeof what, format, args);
	va_end(args);
	return fault_set(text->fault, EX_BAD_INPUT, "%s:%zu: %s", text->shown, text->line, what);
}

bool text_coordinate(struct text *text, struct word word, double *value)
{
	if (!num_parse(word.text, word.length, value))
		return text_fault(text, "'%.*s' is not a number", (int)(word.length < 40 ? word.length : 40), word.text);
	if (!isfinite(*value))
		return text_fault(text, "coordinate is not a finite number");
	if (fabs(*value) > MESH_COORDINATE_LIMIT)
		return text_fault(text, "coordinate %.3g is beyond %g", *value, MESH_COORDINATE_LIMIT);
	return true;
}

void builder_init(struct mesh_builder *builder)
{
	*builder = (struct mesh_builder){.vertex_room = 256, .corner_room = 1024, .face_room = 256};
	builder->mesh.xyz = mem_array(3 * builder->vertex_room, sizeof *builder->mesh.xyz);
	builder->mesh.corner = mem_array(builder->corner_room, sizeof *builder->mesh.corner);
	builder->mesh.face_start = mem_array(builder->face_room + 1, sizeof *builder->mesh.face_start);
}

void builder_vertex(struct mesh_builder *builder, const double xyz[3])
{
	struct mesh *const mesh = &builder->mesh;
	if (mesh->vertex_count == builder->vertex_room)
		mesh->xyz = mem_resize(mesh->xyz, 3 * (builder->vertex_room *= 2), sizeof *mesh->xyz);
	for (int i = 0; i < 3; i++)
		mesh->xyz[3 * mesh->vertex_count + (size_t)i] = xyz[i];
	mesh->vertex_count++;
}

/* Until its face ends, face_start[face_count + 1] counts the corners so far. */
void builder_corner(struct mesh_builder *builder, idx_t vertex)
{
	struct mesh *const mesh = &builder->mesh;
	size_t *const used = &mesh->face_start[mesh->face_count + 1];
	if (*used == builder->corner_room)
		mesh->corner = mem_resize(mesh->corner, builder->corner_room *= 2, sizeof *mesh->corner);
	mesh->corner[(*used)++] = vertex;
}

void builder_end_face(struct mesh_builder *builder)
{
	struct mesh *const mesh = &builder->mesh;
	mesh->face_count++;
	if (mesh->face_count == builder->face_room)
		mesh->face_start = mem_resize(mesh->face_start, (builder->face_room *= 2) + 1, sizeof *mesh->face_start);
	mesh->face_start[mesh->face_count + 1] = mesh->face_start[mesh->face_count];
}
