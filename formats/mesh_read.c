/* Which reader a file is for; PLY; what all meshes must obey. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "formats/mesh_text.h"
#include "formats/ply.h"

static bool ply_faces(struct mesh *mesh, const struct ply *ply, const char *shown, struct fault *fault)
{
	const struct ply_element *face = ply_element(ply, "face");
	if (!face && ply_element(ply, "tristrips"))
		return fault_set(fault, EX_BAD_INPUT, "%s: triangle strips cannot be read: save the mesh with an element 'face'",
				 shown);
	if (!(face = ply_want_element(ply, "face", shown, fault)))
		return false;
	const struct ply_column *list = ply_want_list(face, "vertex_indices", shown, fault);
	if (!list)
		return false;
	if (!(mesh->corner = ply_indices(face, list, 0, (long long)mesh->vertex_count, shown, fault)))
		return false;
	mesh->face_count = face->count;
	mesh->face_start = mem_copy(list->start, face->count + 1, sizeof *list->start);
	return true;
}

static bool read_ply(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	struct ply ply;
	if (!ply_read(&ply, input, fault))
		return false;
	const struct ply_element *vertex = ply_want_element(&ply, "vertex", input->shown, fault);
	if (vertex)
		mesh->xyz = ply_points(vertex, input->shown, fault);
	if (mesh->xyz)
		mesh->vertex_count = vertex->count;
	const bool good = mesh->xyz && ply_faces(mesh, &ply, input->shown, fault);
	ply_free(&ply);
	return good;
}

static size_t little32(const unsigned char *bytes)
{
	return bytes[0] | (size_t)bytes[1] << 8 | (size_t)bytes[2] << 16 | (size_t)bytes[3] << 24;
}

static bool starts_with(const struct input *input, const char *word)
{
	const size_t length = strlen(word);
	return input->size >= length && strncasecmp((const char *)input->data, word, length) == 0;
}

/* The first word, comments passed over, is OFF with or without its prefixes. */
static bool looks_like_off(const struct input *input)
{
	struct fault none = {0};
	struct text text = text_begin(input, '#', &none);
	struct word word;
	if (!text_word(&text, &word))
		return false;
	for (size_t i = 0; i + 3 <= word.length && i <= 6; i++)
		if (strncmp(word.text + i, "OFF", 3) == 0)
			return true;
	return false;
}

/* "OM", the kind of mesh, a known version. */
static bool looks_like_om(const struct input *input)
{
	return input->size >= 4 && memcmp(input->data, "OM", 2) == 0 && memchr("TQP", input->data[2], 3) &&
	       (input->data[3] >> 5 == 1 || input->data[3] >> 5 == 2);
}

/* Text begins with "solid" and goes on with "facet" or "endsolid"; many binary files have "solid" in their header as well. */
static bool looks_like_text_stl(const struct input *input)
{
	struct fault none = {0};
	struct text text = text_begin(input, 0, &none);
	struct word word;
	if (!text_word(&text, &word) || !word_is(word, "solid"))
		return false;
	text_skip_line(&text);
	return !text_word(&text, &word) || word_is(word, "facet") || word_is(word, "endsolid");
}

static bool has_stl_size(const struct input *input)
{
	return input->size >= 84 && input->size == 84 + 50 * little32(input->data + 80);
}

static bool read_by_kind(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	char extension[8];
	path_extension(extension, input->shown ? input->shown : "");
	if (input->size == 0)
		return fault_set(fault, EX_BAD_INPUT, "%s: the file is empty", input->shown);
	/* What the content says counts more than the name; OBJ has nothing to say. */
	if (starts_with(input, "ply\n") || starts_with(input, "ply\r"))
		return read_ply(mesh, input, fault);
	if (has_stl_size(input))
		return mesh_read_stl_binary(mesh, input, fault);
	if (looks_like_om(input))
		return mesh_read_om(mesh, input, fault);
	if (strcmp(extension, "obj") == 0)
		return mesh_read_obj(mesh, input, fault);
	if (looks_like_off(input))
		return mesh_read_off(mesh, input, fault);
	if (looks_like_text_stl(input))
		return mesh_read_stl_text(mesh, input, fault);
	if (strcmp(extension, "stl") == 0)
		return starts_with(input, "solid") && !memchr(input->data, 0, input->size)
			       ? mesh_read_stl_text(mesh, input, fault)
			       : mesh_read_stl_binary(mesh, input, fault);
	if (strcmp(extension, "off") == 0)
		return mesh_read_off(mesh, input, fault);
	if (strcmp(extension, "ply") == 0)
		return read_ply(mesh, input, fault);
	if (strcmp(extension, "om") == 0)
		return mesh_read_om(mesh, input, fault);
	return fault_set(fault, EX_BAD_INPUT,
			 "%s: not a mesh that can be read: STL, OFF, PLY and OM are known by their content, OBJ by its name",
			 input->shown);
}

static bool check(const struct mesh *mesh, const char *shown, struct fault *fault)
{
	if (mesh->vertex_count == 0 || mesh->face_count == 0)
		return fault_set(fault, EX_BAD_INPUT, "%s: the mesh has %zu vertices and %zu faces: nothing to work on", shown,
				 mesh->vertex_count, mesh->face_count);
	if (mesh->vertex_count > INDEX_LIMIT || mesh->face_start[mesh->face_count] > INDEX_LIMIT)
		return fault_set(fault, EX_BAD_INPUT, "%s: the mesh is too large", shown);
	for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
		if (!isfinite(mesh->xyz[i]))
			return fault_set(fault, EX_BAD_INPUT, "%s: vertex %zu: coordinate is not a finite number", shown, i / 3);
		if (fabs(mesh->xyz[i]) > MESH_COORDINATE_LIMIT)
			return fault_set(fault, EX_BAD_INPUT, "%s: vertex %zu: coordinate %.3g is beyond %g", shown, i / 3,
					 mesh->xyz[i], MESH_COORDINATE_LIMIT);
	}
	for (size_t f = 0; f < mesh->face_count; f++)
		if (mesh->face_start[f + 1] - mesh->face_start[f] < 3)
			return fault_set(fault, EX_BAD_INPUT, "%s: face %zu has only %zu corners", shown, f,
					 mesh->face_start[f + 1] - mesh->face_start[f]);
	return true;
}

bool mesh_read(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	*mesh = (struct mesh){0};
	if (read_by_kind(mesh, input, fault) && check(mesh, input->shown, fault))
		return true;
	mesh_free(mesh);
	return false;
}
