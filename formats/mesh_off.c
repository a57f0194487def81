/* OFF (Geomview's ascii variants in three dimensions). Not through OpenMesh, whose reader turns doubles to floats
 * and stumbles over comments and blank lines. */
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "formats/mesh_text.h"
#include "formats/number.h"

/* "OFF" with any of the prefixes that announce what else a vertex has. What stands behind it in the same word
 * ("OFF8 6 12") belongs to the counts. */
static bool read_keyword(struct text *text)
{
	struct word word;
	if (!text_word(text, &word))
		return text_fault(text, "the file is empty");
	size_t i = 0;
	if (word.length >= 2 && strncmp(word.text, "ST", 2) == 0)
		i = 2;
	for (const char *prefix = "CN"; *prefix; prefix++)
		if (i < word.length && word.text[i] == *prefix)
			i++;
	if (i + 4 <= word.length && (word.text[i] == '4' || word.text[i] == 'n') &&
	    (word.text[i + 1] == 'n' || word.text[i + 1] == 'O'))
		return text_fault(text, "only OFF files in three dimensions can be read");
	if (word.length < i + 3 || strncasecmp(word.text + i, "off", 3) != 0)
		return text_fault(text, "'OFF' should stand at the beginning");
	text->at = word.text + i + 3;
	const char *const after = text->at;
	if (text_word_of_line(text, &word) && word_is(word, "binary"))
		return text_fault(text, "binary OFF files cannot be read");
	text->at = after;
	return true;
}

static bool read_count(struct text *text, const char *what, size_t *count)
{
	struct word word;
	long long value;
	if (!text_word(text, &word))
		return text_fault(text, "the file ends before the number of %s", what);
	if (!num_parse_integer(word.text, word.length, 0, (long long)INDEX_LIMIT, &value))
		return text_fault(text, "'%.*s' is not a number of %s", (int)(word.length < 40 ? word.length : 40), word.text,
				  what);
	*count = (size_t)value;
	return true;
}

static bool read_vertices(struct text *text, struct mesh *mesh)
{
	for (size_t v = 0; v < mesh->vertex_count; v++) {
		for (size_t i = 0; i < 3; i++) {
			struct word word;
			if (!text_word(text, &word))
				return text_fault(text, "the file ends after %zu of %zu vertices", v, mesh->vertex_count);
			if (!text_coordinate(text, word, &mesh->xyz[3 * v + i]))
				return false;
		}
		text_skip_line(text); /* colours, normals, texture */
	}
	return true;
}

static bool read_face(struct text *text, struct mesh_builder *builder, size_t face, size_t face_count)
{
	struct word word;
	long long corners, vertex;
	if (!text_word(text, &word))
		return text_fault(text, "the file ends after %zu of %zu faces", face, face_count);
	if (!num_parse_integer(word.text, word.length, 0, (long long)INDEX_LIMIT, &corners))
		return text_fault(text, "face %zu: '%.*s' is not a number of corners", face,
				  (int)(word.length < 40 ? word.length : 40), word.text);
	if (corners < 3)
		return text_fault(text, "face %zu has only %lld corners", face, corners);
	for (long long k = 0; k < corners; k++) {
		if (!text_word(text, &word))
			return text_fault(text, "the file ends inside face %zu of %zu", face, face_count);
		if (!num_parse_integer(word.text, word.length, 0, (long long)builder->mesh.vertex_count - 1, &vertex))
			return text_fault(text, "face %zu: '%.*s' is not one of the vertices 0 to %zu", face,
					  (int)(word.length < 40 ? word.length : 40), word.text, builder->mesh.vertex_count - 1);
		builder_corner(builder, (idx_t)vertex);
	}
	builder_end_face(builder);
	text_skip_line(text); /* colours */
	return true;
}

static bool read_body(struct text *text, struct mesh_builder *builder)
{
	size_t vertices, faces, edges;
	struct word word;
	if (!read_keyword(text) || !read_count(text, "vertices", &vertices))
		return false;
	const size_t line = text->line;
	if (!read_count(text, "faces", &faces))
		return false;
	/* The number of edges: unused, often 0, sometimes absent from a line that has the other two. */
	const char *const after = text->at;
	if (text->line != line || text_word_of_line(text, &word)) {
		text->at = after;
		if (!read_count(text, "edges", &edges))
			return false;
	}
	text_skip_line(text);
	/* Two characters a number at least: nothing is allocated for what the file cannot hold. */
	if (vertices > (size_t)(text->end - text->at) / 6)
		return text_fault(text, "%zu vertices are promised, more than the file can hold", vertices);
	if (faces > (size_t)(text->end - text->at) / 8)
		return text_fault(text, "%zu faces are promised, more than the file can hold", faces);
	builder->mesh.xyz = mem_resize(builder->mesh.xyz, 3 * vertices + 1, sizeof *builder->mesh.xyz);
	builder->mesh.vertex_count = vertices;
	if (!read_vertices(text, &builder->mesh))
		return false;
	for (size_t f = 0; f < faces; f++)
		if (!read_face(text, builder, f, faces))
			return false;
	if (text_word(text, &word))
		return text_fault(text, "more data after the last of %zu faces", faces);
	return true;
}

bool mesh_read_off(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	struct text text = text_begin(input, '#', fault);
	struct mesh_builder builder;
	builder_init(&builder);
	const bool good = read_body(&text, &builder);
	*mesh = builder.mesh;
	if (!good)
		mesh_free(mesh);
	return good;
}
