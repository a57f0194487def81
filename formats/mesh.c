#include "formats/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void mesh_free(struct mesh *mesh)
{
	free(mesh->xyz);
	free(mesh->corner);
	free(mesh->face_start);
	*mesh = (struct mesh){0};
}

bool mesh_is_unwelded(const struct mesh *mesh)
{
	if (mesh->vertex_count != 3 * mesh->face_count || mesh->face_start[mesh->face_count] != mesh->vertex_count)
		return false;
	for (size_t h = 0; h < mesh->vertex_count; h++)
		if (mesh->corner[h] != (idx_t)h)
			return false;
	return true;
}

double mesh_bounds(const double *xyz, size_t vertex_count, double low[3], double high[3])
{
	double longest = 0;
	for (size_t i = 0; i < 3; i++) {
		double least = vertex_count ? xyz[i] : 0, most = least;
		for (size_t v = 1; v < vertex_count; v++) {
			least = fmin(least, xyz[3 * v + i]);
			most = fmax(most, xyz[3 * v + i]);
		}
		longest = fmax(longest, most - least);
		if (low)
			low[i] = least;
		if (high)
			high[i] = most;
	}
	return longest;
}

/* Three doubles that are equal when their bits are: -0 becomes 0. */
struct key {
	uint64_t bits[3];
};

static struct key key_of(const double xyz[3])
{
	struct key key;
	for (int i = 0; i < 3; i++) {
		const double value = xyz[i] == 0 ? 0 : xyz[i];
		memcpy(&key.bits[i], &value, sizeof value);
	}
	return key;
}

static size_t hash_of(struct key key)
{
	uint64_t hash = 0;
	for (int i = 0; i < 3; i++) {
		hash = (hash ^ key.bits[i]) * 0x9E3779B97F4A7C15u; /* 2^64 / golden ratio */
		hash ^= hash >> 32;
	}
	return (size_t)hash;
}

/* Number points so that equal ones get the number of the first of them. */
struct key_table {
	struct key *key;
	idx_t *slot; /* the point that a slot belongs to */
	size_t mask;
};

static struct key_table table_new(size_t count)
{
	size_t size = 16;
	while (size < 2 * count)
		size *= 2;
	struct key_table table = {mem_array(count, sizeof *table.key), mem_array(size, sizeof *table.slot), size - 1};
	memset(table.slot, 0xff, size * sizeof *table.slot);
	return table;
}

static void table_free(struct key_table *table)
{
	free(table->key);
	free(table->slot);
}

static bool same_key(struct key a, struct key b)
{
	return a.bits[0] == b.bits[0] && a.bits[1] == b.bits[1] && a.bits[2] == b.bits[2];
}

/* The slot of a key: it holds the first point with this key, or NO_INDEX. */
static idx_t *table_find(const struct key_table *table, struct key key)
{
	size_t i = hash_of(key) & table->mask;
	while (table->slot[i] != NO_INDEX && !same_key(table->key[table->slot[i]], key))
		i = (i + 1) & table->mask;
	return &table->slot[i];
}

static idx_t find_root(idx_t *parent, idx_t v)
{
	while (parent[v] != v)
		v = parent[v] = parent[parent[v]];
	return v;
}

/* The lower index is the root, so that the first vertex of a group stays. */
static void unite(idx_t *parent, idx_t a, idx_t b)
{
	a = find_root(parent, a);
	b = find_root(parent, b);
	if (a != b)
		parent[a > b ? a : b] = a < b ? a : b;
}

static double squared_distance(const double *a, const double *b)
{
	double sum = 0;
	for (int i = 0; i < 3; i++)
		sum += (a[i] - b[i]) * (a[i] - b[i]);
	return sum;
}

/* Some pair of the two chains of points within reach, so that they unite. */
static bool chains_touch(const double *xyz, const idx_t *next, idx_t first, idx_t second, double squared)
{
	for (idx_t a = first; a != NO_INDEX; a = next[a])
		for (idx_t b = second; b != NO_INDEX; b = next[b])
			if (squared_distance(xyz + 3 * (size_t)a, xyz + 3 * (size_t)b) <= squared)
				return true;
	return false;
}

/* A grid whose cells have a diagonal just below the tolerance: all points of a cell belong together, and what else is
 * within reach lies at most two cells away. parent: one of each group of equal points is its own root. */
static void unite_near(idx_t *parent, const double *xyz, size_t vertex_count, double tolerance)
{
	const double cell = tolerance / 1.7320509, squared = tolerance * tolerance;
	double low[3];
	mesh_bounds(xyz, vertex_count, low, NULL);
	struct key_table table = table_new(vertex_count);
	double *place = mem_array(3 * vertex_count, sizeof *place); /* cell coordinates, whole numbers */
	idx_t *next = mem_array(vertex_count, sizeof *next);        /* further points in the cell of v */
	for (size_t v = 0; v < vertex_count; v++) {
		for (size_t i = 0; i < 3; i++)
			place[3 * v + i] = floor((xyz[3 * v + i] - low[i]) / cell);
		table.key[v] = key_of(place + 3 * v);
		next[v] = NO_INDEX;
		if (parent[v] != (idx_t)v)
			continue;
		idx_t *const slot = table_find(&table, table.key[v]);
		if (*slot == NO_INDEX) {
			*slot = (idx_t)v;
		} else {
			next[v] = next[*slot];
			next[*slot] = (idx_t)v;
		}
	}
	for (size_t v = 0; v < vertex_count; v++) {
		if (*table_find(&table, table.key[v]) != (idx_t)v)
			continue;
		for (idx_t w = next[v]; w != NO_INDEX; w = next[w])
			unite(parent, (idx_t)v, w);
		for (int n = 63; n < 125; n++) { /* half of the 124 neighbours: the other half looks here */
			const double step[3] = {n / 25 - 2, n / 5 % 5 - 2, n % 5 - 2};
			double there[3];
			for (size_t i = 0; i < 3; i++)
				there[i] = place[3 * v + i] + step[i];
			const idx_t other = *table_find(&table, key_of(there));
			if (other != NO_INDEX && find_root(parent, (idx_t)v) != find_root(parent, other) &&
			    chains_touch(xyz, next, (idx_t)v, other, squared))
				unite(parent, (idx_t)v, other);
		}
	}
	table_free(&table);
	free(place);
	free(next);
}

size_t mesh_weld(struct mesh *mesh, double tolerance, idx_t *map)
{
	const size_t old_count = mesh->vertex_count;
	idx_t *parent = mem_array(old_count, sizeof *parent);
	struct key_table table = table_new(old_count);
	for (size_t v = 0; v < old_count; v++) {
		table.key[v] = key_of(mesh->xyz + 3 * v);
		idx_t *const slot = table_find(&table, table.key[v]);
		if (*slot == NO_INDEX)
			*slot = (idx_t)v;
		parent[v] = *slot;
	}
	table_free(&table);
	if (tolerance > 0)
		unite_near(parent, mesh->xyz, old_count, tolerance);
	idx_t *number = map ? map : mem_array(old_count, sizeof *number);
	mesh->vertex_count = 0;
	for (size_t v = 0; v < old_count; v++) {
		const idx_t root = find_root(parent, (idx_t)v);
		if (root != (idx_t)v) {
			number[v] = number[root]; /* roots come first */
			continue;
		}
		memmove(mesh->xyz + 3 * mesh->vertex_count, mesh->xyz + 3 * v, 3 * sizeof *mesh->xyz);
		number[v] = (idx_t)mesh->vertex_count++;
	}
	for (size_t h = 0; h < mesh->face_start[mesh->face_count]; h++)
		mesh->corner[h] = number[mesh->corner[h]];
	if (!map)
		free(number);
	free(parent);
	return old_count - mesh->vertex_count;
}
