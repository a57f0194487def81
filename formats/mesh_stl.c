/* STL, both kinds, as it is: three vertices a facet, collapsed facets too. (OpenMesh's reader unites equal positions,
 * leaves collapsed facets out, and takes a truncated file for a whole one: repairs that nobody would hear of.) */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh_text.h"

#define STL_HEADER_SIZE ((size_t)84)
#define STL_FACET_SIZE ((size_t)50)

static bool want_words(struct text *text, const char *const *wanted, size_t facet)
{
	for (; *wanted; wanted++) {
		struct word word;
		if (!text_word(text, &word))
			return text_fault(text, "facet %zu: the file ends where '%s' should stand", facet, *wanted);
		if (!word_is(word, *wanted))
			return text_fault(text, "facet %zu: '%.*s' where '%s' should stand", facet,
					  (int)(word.length < 40 ? word.length : 40), word.text, *wanted);
	}
	return true;
}

static bool read_vertex(struct text *text, double xyz[3], size_t facet)
{
	for (int i = 0; i < 3; i++) {
		struct word word;
		if (!text_word(text, &word))
			return text_fault(text, "facet %zu: the file ends inside a vertex", facet);
		if (!text_coordinate(text, word, &xyz[i]))
			return false;
	}
	return true;
}

/* What follows "facet normal". The normal itself is not used: many writers leave it 0 or nan. */
static bool read_facet(struct text *text, struct mesh_builder *builder, size_t facet)
{
	struct word word;
	if (!want_words(text, (const char *const[]){"normal", NULL}, facet))
		return false;
	for (int i = 0; i < 3; i++)
		if (!text_word(text, &word))
			return text_fault(text, "facet %zu: the file ends inside the normal", facet);
	if (!want_words(text, (const char *const[]){"outer", "loop", NULL}, facet))
		return false;
	int corners = 0;
	while (text_word(text, &word) && word_is(word, "vertex")) {
		double xyz[3];
		if (corners++ == 3)
			return text_fault(text, "facet %zu has more than 3 vertices", facet);
		if (!read_vertex(text, xyz, facet))
			return false;
		builder_corner(builder, (idx_t)builder->mesh.vertex_count);
		builder_vertex(builder, xyz);
	}
	if (text->at == text->end)
		return text_fault(text, "facet %zu: the file ends inside the facet", facet);
	if (!word_is(word, "endloop"))
		return text_fault(text, "facet %zu: '%.*s' where 'vertex' or 'endloop' should stand", facet,
				  (int)(word.length < 40 ? word.length : 40), word.text);
	if (corners < 3)
		return text_fault(text, "facet %zu has only %d vertices", facet, corners);
	builder_end_face(builder);
	return want_words(text, (const char *const[]){"endfacet", NULL}, facet);
}

static bool read_solids(struct text *text, struct mesh_builder *builder)
{
	struct word word;
	while (text_word(text, &word)) {
		if (!word_is(word, "solid"))
			return text_fault(text, "'%.*s' where 'solid' should stand", (int)(word.length < 40 ? word.length : 40),
					  word.text);
		text_skip_line(text); /* its name */
		for (;;) {
			if (!text_word(text, &word))
				return text_fault(text, "the file ends without 'endsolid' after %zu facets",
						  builder->mesh.face_count);
			if (word_is(word, "endsolid"))
				break;
			if (!word_is(word, "facet"))
				return text_fault(text, "'%.*s' where 'facet' or 'endsolid' should stand",
						  (int)(word.length < 40 ? word.length : 40), word.text);
			if (builder->mesh.vertex_count + 3 > INDEX_LIMIT)
				return text_fault(text, "too many facets");
			if (!read_facet(text, builder, builder->mesh.face_count + 1))
				return false;
		}
		text_skip_line(text);
	}
	return true;
}

bool mesh_read_stl_text(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	struct text text = text_begin(input, 0, fault);
	struct mesh_builder builder;
	builder_init(&builder);
	const bool good = read_solids(&text, &builder);
	*mesh = builder.mesh;
	if (!good)
		mesh_free(mesh);
	return good;
}

static uint32_t little32(const unsigned char *bytes)
{
	return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

bool mesh_read_stl_binary(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	*mesh = (struct mesh){0};
	if (input->size < STL_HEADER_SIZE)
		return fault_set(fault, EX_BAD_INPUT,
				 "%s: no STL file: text begins with 'solid', and %zu bytes are too few for a binary one",
				 input->shown, input->size);
	const size_t promised = little32(input->data + 80), rest = input->size - STL_HEADER_SIZE;
	if (rest != promised * STL_FACET_SIZE)
		return fault_set(fault, EX_BAD_INPUT, "%s: byte 80: the header promises %zu facets, the file has room for %zu%s",
				 input->shown, promised, rest / STL_FACET_SIZE, rest % STL_FACET_SIZE ? " and a part" : "");
	mesh->vertex_count = 3 * promised;
	mesh->face_count = promised;
	mesh->xyz = mem_array(9 * promised, sizeof *mesh->xyz);
	mesh->corner = mem_array(3 * promised, sizeof *mesh->corner);
	mesh->face_start = mem_array(promised + 1, sizeof *mesh->face_start);
	for (size_t f = 0; f < promised; f++) {
		const unsigned char *facet = input->data + STL_HEADER_SIZE + STL_FACET_SIZE * f;
		for (size_t i = 0; i < 9; i++) {
			const uint32_t bits = little32(facet + 12 + 4 * i);
			float value;
			memcpy(&value, &bits, sizeof value);
			if (!isfinite(value)) {
				mesh_free(mesh);
				return fault_set(fault, EX_BAD_INPUT,
						 "%s: byte %zu: facet %zu: coordinate is not a finite number", input->shown,
						 STL_HEADER_SIZE + STL_FACET_SIZE * f + 12 + 4 * i, f + 1);
			}
			mesh->xyz[9 * f + i] = value;
		}
		for (size_t k = 0; k < 3; k++)
			mesh->corner[3 * f + k] = (idx_t)(3 * f + k);
		mesh->face_start[f + 1] = 3 * (f + 1);
	}
	return true;
}
