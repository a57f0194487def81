/* The order of the repairs, and the report. */
#include "stages/geometry/repair.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/half.h"
#include "stages/geometry/repair_internal.h"
#include "stages/geometry/triangulate.h"
#include "stages/geometry/vector.h"

const char *const repair_name[REPAIR_KIND_COUNT] = {
	[REPAIR_POLYGON_TRIANGULATED] = "polygon triangulated",
	[REPAIR_WELDED_EXACT] = "vertex welded",
	[REPAIR_WELDED_NEAR] = "vertex welded within tolerance",
	[REPAIR_COLLAPSED_FACE] = "collapsed face removed",
	[REPAIR_DUPLICATE_FACE] = "duplicate face removed",
	[REPAIR_ZERO_AREA_FACE] = "zero-area face removed",
	[REPAIR_CAP_FLIPPED] = "zero-area face flipped away",
	[REPAIR_T_JUNCTION_SPLIT] = "T-junction split",
	[REPAIR_NONMANIFOLD_EDGE_CUT] = "non-manifold edge cut",
	[REPAIR_NONMANIFOLD_VERTEX_SPLIT] = "non-manifold vertex split",
	[REPAIR_FACE_FLIPPED] = "face turned over",
	[REPAIR_MOEBIUS_CUT] = "edge of a one-sided surface cut",
	[REPAIR_COMPONENT_TURNED] = "component turned inside out",
	[REPAIR_UNUSED_VERTEX] = "unused vertex removed",
};

const char *const repair_plural[REPAIR_KIND_COUNT] = {
	[REPAIR_POLYGON_TRIANGULATED] = "polygons triangulated",
	[REPAIR_WELDED_EXACT] = "vertices welded",
	[REPAIR_WELDED_NEAR] = "vertices welded within tolerance",
	[REPAIR_COLLAPSED_FACE] = "collapsed faces removed",
	[REPAIR_DUPLICATE_FACE] = "duplicate faces removed",
	[REPAIR_ZERO_AREA_FACE] = "zero-area faces removed",
	[REPAIR_CAP_FLIPPED] = "zero-area faces flipped away",
	[REPAIR_T_JUNCTION_SPLIT] = "T-junctions split",
	[REPAIR_NONMANIFOLD_EDGE_CUT] = "non-manifold edges cut",
	[REPAIR_NONMANIFOLD_VERTEX_SPLIT] = "non-manifold vertices split",
	[REPAIR_FACE_FLIPPED] = "faces turned over",
	[REPAIR_MOEBIUS_CUT] = "edges of a one-sided surface cut",
	[REPAIR_COMPONENT_TURNED] = "components turned inside out",
	[REPAIR_UNUSED_VERTEX] = "unused vertices removed",
};

void repair_report_free(struct repair_report *report)
{
	free(report->component);
	free(report->cut);
	*report = (struct repair_report){0};
}

/* A face without the vertices that welding put next to an equal one. */
static size_t without_repeats(idx_t *loop, const idx_t *corner, size_t count)
{
	size_t kept = 0;
	for (size_t k = 0; k < count; k++)
		if (kept == 0 || loop[kept - 1] != corner[k])
			loop[kept++] = corner[k];
	while (kept > 1 && loop[kept - 1] == loop[0])
		kept--;
	return kept;
}

/* Triangles of all faces; takes the vertices of mesh. */
static void triangulate(struct soup *soup, struct mesh *mesh)
{
	size_t longest = 3;
	for (size_t f = 0; f < mesh->face_count; f++) {
		const size_t corners = mesh->face_start[f + 1] - mesh->face_start[f];
		longest = corners > longest ? corners : longest;
	}
	idx_t *loop = mem_array(longest, sizeof *loop), *cut = mem_array(3 * longest, sizeof *cut);
	soup->triangle_room = mesh->face_start[mesh->face_count];
	soup->triangle = mem_array(3 * soup->triangle_room, sizeof *soup->triangle);
	for (size_t f = 0; f < mesh->face_count; f++) {
		const size_t corners = mesh->face_start[f + 1] - mesh->face_start[f];
		const size_t kept = without_repeats(loop, mesh->corner + mesh->face_start[f], corners);
		soup->report->count[REPAIR_POLYGON_TRIANGULATED] += corners > 3;
		if (kept < 3) {
			soup->report->count[REPAIR_COLLAPSED_FACE]++;
			continue;
		}
		triangulate_polygon(cut, mesh->xyz, loop, kept);
		for (size_t t = 0; t < kept - 2; t++)
			soup_add_triangle(soup, cut[3 * t], cut[3 * t + 1], cut[3 * t + 2]);
	}
	free(loop);
	free(cut);
	soup->xyz = mesh->xyz;
	soup->vertex_count = soup->vertex_room = mesh->vertex_count;
	mesh->xyz = NULL;
	mesh_free(mesh);
}

/* Number the vertices that are used, in their order, and list the opened edges. */
static void compact(struct mesh *mesh, struct soup *soup)
{
	struct repair_report *const report = soup->report;
	idx_t *number = mem_array(soup->vertex_count, sizeof *number);
	for (size_t h = 0; h < 3 * soup->triangle_count; h++)
		number[soup->triangle[h]] = 1;
	size_t used = 0;
	for (size_t v = 0; v < soup->vertex_count; v++) {
		if (!number[v])
			continue;
		memmove(soup->xyz + 3 * used, soup->xyz + 3 * v, 3 * sizeof *soup->xyz);
		number[v] = (idx_t)used++;
	}
	for (size_t h = 0; h < 3 * soup->triangle_count; h++) {
		soup->triangle[h] = number[soup->triangle[h]];
		report->cut_count += soup->opened[h];
	}
	report->cut = mem_array(2 * report->cut_count, sizeof *report->cut);
	for (size_t h = 0, n = 0; h < 3 * soup->triangle_count; h++)
		if (soup->opened[h]) {
			report->cut[n++] = soup->triangle[h];
			report->cut[n++] = soup->triangle[next_half(h)];
		}
	mesh->xyz = soup->xyz;
	mesh->vertex_count = used;
	mesh->corner = soup->triangle;
	mesh->face_count = soup->triangle_count;
	mesh->face_start = mem_array(mesh->face_count + 1, sizeof *mesh->face_start);
	for (size_t f = 0; f <= mesh->face_count; f++)
		mesh->face_start[f] = 3 * f;
	soup->xyz = NULL;
	soup->triangle = NULL;
	free(number);
}

static void count_border_loops(struct repair_report *report, const struct half *half, const idx_t *component_of)
{
	unsigned char *seen = mem_array(half->half_count, 1);
	for (size_t first = 0; first < half->half_count; first++) {
		if (half->twin[first] != NO_INDEX || seen[first])
			continue;
		report->component[component_of[first / 3]].border_loops++;
		for (size_t h = first; !seen[h];) {
			seen[h] = 1;
			for (h = (size_t)half->next[h]; half->twin[h] != NO_INDEX; h = (size_t)half->next[half->twin[h]])
				;
		}
	}
	free(seen);
}

/* Step 7: V, E, F, Euler characteristic, border loops, genus, volume of each component. */
static bool describe(struct repair_report *report, const struct mesh *mesh, const idx_t *component_of, size_t component_count,
		     struct fault *fault)
{
	struct half half;
	struct fault why = {0};
	if (!half_build_triangles(&half, mesh->corner, mesh->face_count, mesh->vertex_count, &why))
		return fault_set(fault, EX_BUG, "the repaired mesh is no manifold: %s", why.text);
	report->component_count = component_count;
	report->component = mem_array(component_count, sizeof *report->component);
	double low[3];
	mesh_bounds(mesh->xyz, mesh->vertex_count, low, NULL);
	for (size_t t = 0; t < mesh->face_count; t++) {
		struct repair_component *const c = &report->component[component_of[t]];
		double corner[3][3], normal[3];
		for (size_t k = 0; k < 3; k++) {
			const size_t h = 3 * t + k;
			c->edges += half.twin[h] == NO_INDEX || (size_t)half.twin[h] > h;
			c->vertices += half.outgoing[half.origin[h]] == (idx_t)h;
			sub3(corner[k], mesh->xyz + 3 * (size_t)mesh->corner[h], low);
		}
		c->faces++;
		cross3(normal, corner[1], corner[2]);
		c->volume += dot3(corner[0], normal);
	}
	count_border_loops(report, &half, component_of);
	for (size_t i = 0; i < component_count; i++) {
		struct repair_component *const c = &report->component[i];
		c->volume /= 6;
		c->euler = (long)c->vertices - (long)c->edges + (long)c->faces;
		c->genus = (2 - (long)c->border_loops - c->euler) / 2;
	}
	half_free(&half);
	return true;
}

/* Those that no face of the input has; what other repairs leave over is theirs. */
static size_t count_unused(const struct mesh *mesh)
{
	unsigned char *used = mem_array(mesh->vertex_count, 1);
	size_t unused = mesh->vertex_count;
	for (size_t h = 0; h < mesh->face_start[mesh->face_count]; h++) {
		unused -= !used[mesh->corner[h]];
		used[mesh->corner[h]] = 1;
	}
	free(used);
	return unused;
}

static void soup_free(struct soup *soup)
{
	free(soup->xyz);
	free(soup->triangle);
	free(soup->pair);
	free(soup->opened);
}

/* Steps 2 to 4 without the cuts: everything that changes which triangles there are. */
static void clean(struct soup *soup, double weld_relative)
{
	soup_drop_collapsed(soup);
	soup_drop_duplicates(soup);
	if (weld_relative > 0 && soup_has_border(soup)) {
		soup_weld_border(soup, weld_relative * soup->diagonal);
		soup_drop_collapsed(soup);
		soup_drop_duplicates(soup);
	}
	soup_flatten(soup);
	if (soup_has_border(soup)) {
		soup_split_junctions(soup, fmax(weld_relative, 1e-12) * soup->diagonal);
		soup_drop_duplicates(soup);
	}
}

/* The same vertices and the same triangles, in their order. */
static bool is_same(const struct mesh *a, const struct mesh *b)
{
	const size_t corners = a->face_start[a->face_count];
	return a->vertex_count == b->vertex_count && a->face_count == b->face_count && corners == b->face_start[b->face_count] &&
	       memcmp(a->xyz, b->xyz, 3 * a->vertex_count * sizeof *a->xyz) == 0 &&
	       memcmp(a->corner, b->corner, corners * sizeof *a->corner) == 0;
}

bool repair_mesh(struct mesh *mesh, const struct repair_options *options, struct repair_report *report, struct fault *fault)
{
	*report = (struct repair_report){0};
	struct mesh given = {mem_copy(mesh->xyz, 3 * mesh->vertex_count, sizeof *mesh->xyz), mesh->vertex_count,
			     mem_copy(mesh->corner, mesh->face_start[mesh->face_count], sizeof *mesh->corner),
			     mem_copy(mesh->face_start, mesh->face_count + 1, sizeof *mesh->face_start), mesh->face_count};
	report->count[REPAIR_WELDED_EXACT] = mesh_weld(mesh, 0, NULL);
	report->count[REPAIR_UNUSED_VERTEX] = count_unused(mesh);
	struct soup soup = {.report = report};
	double low[3], high[3];
	soup.side = mesh_bounds(mesh->xyz, mesh->vertex_count, low, high);
	soup.diagonal = distance3(low, high);
	triangulate(&soup, mesh);
	clean(&soup, options->weld_relative);
	if (soup.triangle_count == 0) {
		mesh_free(&given);
		soup_free(&soup);
		return fault_set(fault, EX_BAD_INPUT, "no face has an area");
	}
	soup_pair(&soup);
	const size_t count = soup.triangle_count;
	unsigned char *mixed = soup_orient(&soup);
	soup_split_fans(&soup);
	soup_turn_outward(&soup, mixed, count);
	free(mixed);
	size_t component_count;
	idx_t *component_of = soup_components(&soup, &component_count);
	compact(mesh, &soup);
	const bool good = describe(report, mesh, component_of, component_count, fault);
	/* Vertices that an earlier repair took apart were welded and taken apart again: that is no repair. */
	if (is_same(mesh, &given))
		memset(report->count, 0, sizeof report->count);
	mesh_free(&given);
	free(component_of);
	soup_free(&soup);
	return good;
}
