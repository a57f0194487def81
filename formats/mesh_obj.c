/* OBJ: vertices and polygons; everything else passes by. Not through OpenMesh, whose reader turns doubles to floats,
 * leaves out faces with indices from the end, and opens the material files that the text names. */
#include <stdlib.h>
#include <string.h>

#include "formats/mesh_text.h"
#include "formats/number.h"

/* A word of this line, where a backslash at its end joins the next line to it. */
static bool next_word(struct text *text, struct word *word)
{
	while (text_word_of_line(text, word)) {
		if (word->text[word->length - 1] != '\\')
			return true;
		if (word->length > 1) { /* come back to it alone */
			word->length--;
			text->at = word->text + word->length;
			return true;
		}
		const char *at = text->at;
		while (at < text->end && *at == '\r')
			at++;
		if (at == text->end || *at != '\n')
			return true;
		text->at = at + 1;
		text->next_line++;
	}
	return false;
}

static bool read_vertex(struct text *text, struct mesh_builder *builder)
{
	double xyz[3];
	for (int i = 0; i < 3; i++) {
		struct word word;
		if (!next_word(text, &word))
			return text_fault(text, "a vertex with only %d coordinates", i);
		if (!text_coordinate(text, word, &xyz[i]))
			return false;
	}
	if (builder->mesh.vertex_count == INDEX_LIMIT)
		return text_fault(text, "too many vertices");
	builder_vertex(builder, xyz);
	for (struct word more; next_word(text, &more);) /* a weight or a colour */
		;
	return true;
}

/* 7, 7/1, 7/1/3, 7//3; -1 is the last vertex so far. Indices ahead are checked when all vertices are known. */
static bool read_face(struct text *text, struct mesh_builder *builder)
{
	struct word word;
	int corners = 0;
	while (next_word(text, &word)) {
		const char *slash = memchr(word.text, '/', word.length);
		const size_t length = slash ? (size_t)(slash - word.text) : word.length;
		const long long last = (long long)builder->mesh.vertex_count;
		long long index;
		if (!num_parse_integer(word.text, length, -last, (long long)INDEX_LIMIT, &index) || index == 0)
			return text_fault(text, "face %zu: '%.*s' names no vertex", builder->mesh.face_count + 1,
					  (int)(word.length < 40 ? word.length : 40), word.text);
		if (builder->mesh.face_start[builder->mesh.face_count + 1] == INDEX_LIMIT)
			return text_fault(text, "too many faces");
		builder_corner(builder, (idx_t)(index > 0 ? index - 1 : last + index));
		corners++;
	}
	if (corners < 3)
		return text_fault(text, "face %zu has only %d corners", builder->mesh.face_count + 1, corners);
	builder_end_face(builder);
	return true;
}

static bool read_lines(struct text *text, struct mesh_builder *builder)
{
	size_t *face_line = NULL, room = 0; /* for messages about indices ahead */
	struct word word;
	bool good = true;
	while (good && text_word(text, &word)) {
		const size_t line = text->line;
		if (word_is(word, "v")) {
			good = read_vertex(text, builder);
		} else if (word_is(word, "f")) {
			good = read_face(text, builder);
			if (builder->mesh.face_count > room)
				face_line = mem_resize(face_line, room = 2 * builder->mesh.face_count, sizeof *face_line);
			if (good)
				face_line[builder->mesh.face_count - 1] = line;
		} else {
			while (next_word(text, &word))
				;
		}
	}
	for (size_t f = 0; good && f < builder->mesh.face_count; f++)
		for (size_t h = builder->mesh.face_start[f]; good && h < builder->mesh.face_start[f + 1]; h++)
			if ((size_t)builder->mesh.corner[h] >= builder->mesh.vertex_count) {
				text->line = face_line[f];
				good = text_fault(text, "face %zu: vertex %" PRIidx " of %zu", f + 1, builder->mesh.corner[h] + 1,
						  builder->mesh.vertex_count);
			}
	free(face_line);
	return good;
}

bool mesh_read_obj(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	struct text text = text_begin(input, '#', fault);
	struct mesh_builder builder;
	builder_init(&builder);
	const bool good = read_lines(&text, &builder);
	*mesh = builder.mesh;
	if (!good)
		mesh_free(mesh);
	return good;
}
