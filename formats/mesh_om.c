/* OM, the binary format of OpenMesh: vertices and faces of versions 1 and 2, everything else passes by. Read here and not by
 * the library, which ends the program when a chunk is damaged.
 *
 * "OM", a letter for the kind of mesh, a byte for the version; counts of vertices, faces, edges; then chunks, each with a
 * 16-bit header and data whose size follows from the header and the counts. All little-endian. */
#include <stdlib.h>
#include <string.h>

#include "formats/mesh_text.h"

enum { ENTITY_VERTEX = 0, ENTITY_MESH = 1, ENTITY_FACE = 2, ENTITY_EDGE = 4, ENTITY_HALFEDGE = 6, ENTITY_END = 7 };
enum { TYPE_POSITION = 0, TYPE_NORMAL = 1, TYPE_TEXTURE = 2, TYPE_STATUS = 3, TYPE_COLOUR = 4, TYPE_TOPOLOGY = 7 };

#define OM_HEADER_SIZE ((size_t)16)

struct om {
	const struct input *input;
	struct fault *fault;
	size_t at; /* the next byte */
	size_t vertex_count, face_count, edge_count;
	char kind;        /* T, Q, P */
	unsigned version; /* major */
	idx_t *next, *to; /* of each half-edge, version 2 */
	idx_t *first;     /* half-edge of each face, version 2 */
};

struct chunk {
	unsigned entity, type, dimensions;
	size_t scalar_size;
	bool has_name, is_float;
};

static bool om_fault(const struct om *om, const char *what)
{
	return fault_set(om->fault, EX_BAD_INPUT, "%s: byte %zu: %s", om->input->shown, om->at, what);
}

/* Is there room for count things of so many bytes? */
static bool want(const struct om *om, size_t count, size_t size)
{
	const size_t rest = om->input->size - om->at;
	return size == 0 || count <= rest / size || om_fault(om, "the file ends inside a chunk");
}

static uint64_t take(struct om *om, size_t size)
{
	uint64_t value = 0;
	for (size_t i = 0; i < size; i++)
		value |= (uint64_t)om->input->data[om->at++] << 8 * i;
	return value;
}

/* A signed index of size bytes; what is no index of count things, and not the allowed -1, becomes -2. */
static idx_t take_index(struct om *om, size_t size, size_t count)
{
	const uint64_t bits = take(om, size), sign = (uint64_t)1 << (8 * size - 1);
	if (bits == (sign - 1) + sign)
		return NO_INDEX;
	return bits < count ? (idx_t)bits : -2;
}

static bool read_positions(struct om *om, struct mesh *mesh, const struct chunk *chunk)
{
	if (mesh->xyz || !chunk->is_float || chunk->dimensions != 3 || (chunk->scalar_size != 4 && chunk->scalar_size != 8))
		return om_fault(om, "positions that are not three floats or doubles a vertex, once");
	if (!want(om, om->vertex_count, 3 * chunk->scalar_size))
		return false;
	mesh->vertex_count = om->vertex_count;
	mesh->xyz = mem_array(3 * om->vertex_count, sizeof *mesh->xyz);
	for (size_t i = 0; i < 3 * om->vertex_count; i++) {
		if (chunk->scalar_size == 8) {
			const uint64_t bits = take(om, 8);
			memcpy(&mesh->xyz[i], &bits, sizeof bits);
		} else {
			const uint32_t bits = (uint32_t)take(om, 4);
			float value;
			memcpy(&value, &bits, sizeof bits);
			mesh->xyz[i] = value;
		}
	}
	return true;
}

/* Version 1: the vertices of each face, whose number is said only for the kind P. */
static bool read_faces(struct om *om, struct mesh_builder *builder, const struct chunk *chunk)
{
	for (size_t f = 0; f < om->face_count; f++) {
		size_t corners = om->kind == 'T' ? 3 : 4;
		if (om->kind == 'P') {
			if (!want(om, 1, 2))
				return false;
			corners = (size_t)take(om, 2);
		}
		if (!want(om, corners, chunk->scalar_size))
			return false;
		for (size_t k = 0; k < corners; k++) {
			const uint64_t vertex = take(om, chunk->scalar_size);
			if (vertex >= om->vertex_count)
				return om_fault(om, "a face with a vertex that is not there");
			builder_corner(builder, (idx_t)vertex);
		}
		builder_end_face(builder);
	}
	return true;
}

/* Version 2: for each half-edge the next one, the vertex it runs to, its face (unused: faces name their first). */
static bool read_half_edges(struct om *om, const struct chunk *chunk)
{
	const size_t count = 2 * om->edge_count;
	if (om->next || !want(om, count, 3 * chunk->scalar_size))
		return om_fault(om, "half-edges twice");
	om->next = mem_array(count, sizeof *om->next);
	om->to = mem_array(count, sizeof *om->to);
	for (size_t h = 0; h < count; h++) {
		om->next[h] = take_index(om, chunk->scalar_size, count);
		om->to[h] = take_index(om, chunk->scalar_size, om->vertex_count);
		take(om, chunk->scalar_size);
	}
	return true;
}

static bool read_first_half_edges(struct om *om, const struct chunk *chunk)
{
	if (om->first || !want(om, om->face_count, chunk->scalar_size))
		return om_fault(om, "faces twice");
	om->first = mem_array(om->face_count, sizeof *om->first);
	for (size_t f = 0; f < om->face_count; f++)
		om->first[f] = take_index(om, chunk->scalar_size, 2 * om->edge_count);
	return true;
}

static bool skip_chunk(struct om *om, const struct chunk *chunk)
{
	const size_t count = chunk->entity == ENTITY_VERTEX     ? om->vertex_count
			     : chunk->entity == ENTITY_FACE     ? om->face_count
			     : chunk->entity == ENTITY_EDGE     ? om->edge_count
			     : chunk->entity == ENTITY_HALFEDGE ? 2 * om->edge_count
								: 0;
	size_t size = chunk->dimensions * chunk->scalar_size;
	if (chunk->has_name || chunk->entity == ENTITY_MESH || (chunk->entity & 1) != 0 ||
	    (chunk->type > TYPE_COLOUR && chunk->type != TYPE_TOPOLOGY))
		return om_fault(om, "a chunk of an unknown kind: save the mesh without properties of your own");
	if (chunk->type == TYPE_STATUS)
		size = 4; /* whatever its header says */
	else if (chunk->type == TYPE_TOPOLOGY)
		size = chunk->scalar_size; /* its dimensions are left over as well */
	if (!want(om, count, size))
		return false;
	om->at += count * size;
	return true;
}

static bool read_chunks(struct om *om, struct mesh_builder *builder)
{
	for (;;) {
		if (!want(om, 1, 2))
			return false;
		const unsigned header = (unsigned)take(om, 2);
		struct chunk chunk = {.entity = header >> 2 & 7, .type = header >> 5 & 15, .dimensions = (header >> 11 & 7) + 1};
		chunk.has_name = header >> 1 & 1;
		chunk.is_float = header >> 10 & 1;
		if (chunk.entity == ENTITY_END)
			return true;
		const unsigned bits = header >> 14 & 3;
		/* In topology chunks the float bit is left over from the chunk before. */
		chunk.scalar_size = chunk.is_float && chunk.type != TYPE_TOPOLOGY ? (size_t)4 << bits : (size_t)1 << bits;
		bool good;
		if (chunk.entity == ENTITY_VERTEX && chunk.type == TYPE_POSITION)
			good = read_positions(om, &builder->mesh, &chunk);
		else if (chunk.entity == ENTITY_FACE && chunk.type == TYPE_TOPOLOGY)
			good = om->version < 2 ? read_faces(om, builder, &chunk) : read_first_half_edges(om, &chunk);
		else if (chunk.entity == ENTITY_HALFEDGE && chunk.type == TYPE_TOPOLOGY)
			good = read_half_edges(om, &chunk);
		else /* among them an outgoing half-edge of each vertex */
			good = skip_chunk(om, &chunk);
		if (!good)
			return false;
	}
}

/* Version 2: walk around each face. A half-edge has one face, so that no walk is longer than what is left. */
static bool walk_faces(struct om *om, struct mesh_builder *builder)
{
	if (!om->next || !om->first)
		return om_fault(om, "the file ends without faces");
	unsigned char *used = mem_array(2 * om->edge_count, 1);
	bool good = true;
	for (size_t f = 0; f < om->face_count && good; f++) {
		const idx_t first = om->first[f];
		idx_t h = first;
		do {
			good = h >= 0 && !used[h] && om->to[h] >= 0;
			if (!good)
				break;
			used[h] = 1;
			builder_corner(builder, om->to[h]);
			h = om->next[h];
		} while (h != first);
		builder_end_face(builder);
	}
	free(used);
	return good || om_fault(om, "the half-edges do not run around the faces");
}

static bool read_om(struct om *om, struct mesh_builder *builder)
{
	if (om->input->size < OM_HEADER_SIZE || om->input->data[0] != 'O' || om->input->data[1] != 'M' ||
	    !strchr("TQP", om->input->data[2]) || om->input->data[2] == 0)
		return om_fault(om, "no OM file");
	om->kind = (char)om->input->data[2];
	om->version = om->input->data[3] >> 5;
	if (om->version < 1 || om->version > 2)
		return om_fault(om, "only versions 1 and 2 of OM can be read");
	om->at = 4;
	om->vertex_count = (size_t)take(om, 4);
	om->face_count = (size_t)take(om, 4);
	om->edge_count = (size_t)take(om, 4);
	if (om->vertex_count > om->input->size / 12 || om->face_count > om->input->size || om->edge_count > om->input->size)
		return om_fault(om, "more is promised than the file can hold");
	if (!read_chunks(om, builder))
		return false;
	if (!builder->mesh.xyz)
		return om_fault(om, "the file ends without positions");
	return om->version < 2 || walk_faces(om, builder);
}

bool mesh_read_om(struct mesh *mesh, const struct input *input, struct fault *fault)
{
	struct om om = {.input = input, .fault = fault};
	struct mesh_builder builder;
	builder_init(&builder);
	free(builder.mesh.xyz); /* they come all at once */
	builder.mesh.xyz = NULL;
	const bool good = read_om(&om, &builder);
	*mesh = builder.mesh;
	if (!good)
		mesh_free(mesh);
	free(om.next), free(om.to), free(om.first);
	return good;
}
