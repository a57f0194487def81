/* Drafts from and to documents. */
#include "stages/fitpatch/local.h"

#include <stdlib.h>
#include <string.h>

#include "formats/cage.h"
#include "stages/geometry/vector.h"

void draft_start(struct draft *draft, const struct network *network)
{
	*draft = (struct draft){0};
	for (size_t i = 0; i < network->vertex_count; i++)
		control_add(&draft->control, &network->xyz[3 * i], network->kind[i]);
	for (size_t k = 0; k < network->curve_count; k++)
		if (network_curve_edited(network, &network->curve[k]))
			for (size_t i = 0; i < network->curve[k].count; i++)
				draft->control.held[network->point[network->curve[k].first + i]] = 1;
	polygons_init(&draft->polygons);
	draft->network = (struct network){.vertex_count = network->vertex_count, .curve_count = network->curve_count, .point_count = network->point_count};
	draft->network.curve = mem_copy(network->curve, network->curve_count, sizeof *network->curve);
	draft->network.point = mem_copy(network->point, network->point_count, sizeof *network->point);
}

void draft_sharpen(struct draft *draft, const struct dense *dense)
{
	draft->tangential = mem_array(draft->network.curve_count, 1);
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		struct curve *curve = &draft->network.curve[k];
		if (curve->kind != CURVE_SMOOTH || curve->left < 0 || curve->right < 0)
			continue;
		const struct dense_patch *left = &dense->patch[curve->left], *right = &dense->patch[curve->right];
		/* Parts of one surface, and of one free form, are smooth from the start. */
		if (left->parent == right->parent || (left->kind == PATCH_FREE && right->kind == PATCH_FREE))
			continue;
		draft->tangential[k] = 1;
		curve->kind = CURVE_SHARP;
	}
}

void draft_copy(struct draft *to, const struct draft *from)
{
	*to = *from;
	const struct control *control = &from->control;
	to->control.xyz = mem_copy(control->xyz, 3 * control->count, sizeof *control->xyz);
	to->control.role = mem_copy(control->role, control->count, 1);
	to->control.held = mem_copy(control->held, control->count, 1);
	to->control.capacity = control->count;
	const struct polygons *polygons = &from->polygons;
	to->polygons.corner = mem_copy(polygons->corner, polygons->start[polygons->count], sizeof *polygons->corner);
	to->polygons.start = mem_copy(polygons->start, polygons->count + 1, sizeof *polygons->start);
	to->polygons.patch = mem_copy(polygons->patch, polygons->count, sizeof *polygons->patch);
	to->polygons.capacity = polygons->count;
	to->polygons.corner_capacity = polygons->start[polygons->count];
	to->network.curve = mem_copy(from->network.curve, from->network.curve_count, sizeof *from->network.curve);
	to->network.point = mem_copy(from->network.point, from->network.point_count, sizeof *from->network.point);
	to->seam = from->seam ? mem_copy(from->seam, 3 * from->seam_count, sizeof *from->seam) : NULL;
	to->tangential = from->tangential ? mem_copy(from->tangential, from->network.curve_count, 1) : NULL;
}

void draft_free(struct draft *draft)
{
	control_free(&draft->control);
	polygons_free(&draft->polygons);
	free(draft->network.curve), free(draft->network.point), free(draft->tangential), free(draft->seam);
	*draft = (struct draft){0};
}

void draft_curve_edges(struct edge_set *edges, const struct draft *draft)
{
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		const struct curve *curve = &draft->network.curve[k];
		const idx_t *point = &draft->network.point[curve->first];
		for (size_t i = 0; i + !curve->closed < curve->count; i++)
			edge_set_add(edges, point[i], point[(i + 1) % curve->count]);
	}
}

void label_lists(size_t **start, idx_t **list, const idx_t *label, size_t count, size_t patch_count)
{
	*start = mem_array(patch_count + 2, sizeof **start);
	*list = mem_array(count, sizeof **list);
	for (size_t t = 0; t < count; t++)
		(*start)[label[t] + 2]++;
	for (size_t p = 0; p < patch_count; p++)
		(*start)[p + 2] += (*start)[p + 1];
	for (size_t t = 0; t < count; t++)
		(*list)[(*start)[label[t] + 1]++] = (idx_t)t;
}

/* Network points keep their order; those that refinement put on curves come after them. */
static size_t number_net(idx_t *net, const struct draft *draft)
{
	size_t count = 0;
	memset(net, 0xff, draft->control.count * sizeof *net);
	for (size_t k = 0; k < draft->network.curve_count; k++)
		for (size_t i = 0; i < draft->network.curve[k].count; i++)
			net[draft->network.point[draft->network.curve[k].first + i]] = 0;
	for (size_t i = 0; i < draft->seam_count; i++)
		net[draft->seam[3 * i]] = net[draft->seam[3 * i + 1]] = 0;
	for (size_t i = 0; i < draft->control.count; i++)
		if (net[i] != NO_INDEX)
			net[i] = (idx_t)count++;
	return count;
}

void local_to_ply(struct ply *ply, const struct draft *draft)
{
	const struct polygons *polygons = &draft->polygons;
	const size_t corners = polygons->start[polygons->count];
	idx_t *net = mem_array(draft->control.count, sizeof *net);
	struct network network = draft->network;
	network.vertex_count = number_net(net, draft);
	struct cage fitted;
	idx_t *vertex_of;
	draft_cage(&fitted, &vertex_of, draft);
	network.xyz = mem_array(3 * network.vertex_count, sizeof *network.xyz);
	network.kind = mem_array(network.vertex_count, 1);
	network.curve = mem_array(network.curve_count + draft->seam_count, sizeof *network.curve);
	memcpy(network.curve, draft->network.curve, network.curve_count * sizeof *network.curve);
	network.point = mem_array(network.point_count + 2 * draft->seam_count, sizeof *network.point);
	for (size_t i = 0; i < draft->control.count; i++)
		if (net[i] != NO_INDEX) {
			copy3(&network.xyz[3 * (size_t)net[i]], &draft->control.xyz[3 * i]);
			/* What the fit took for a corner is one from now on, whatever became of the curves that met there. */
			const unsigned char role = draft->control.role[i];
			network.kind[net[i]] = role == POINT_CREASE ? role : vertex_of[i] != NO_INDEX && fitted.corner[vertex_of[i]] ? POINT_CORNER : POINT_JUNCTION;
		}
	cage_free(&fitted);
	free(vertex_of);
	for (size_t i = 0; i < network.point_count; i++)
		network.point[i] = net[draft->network.point[i]];
	for (size_t i = 0; i < draft->seam_count; i++) { /* chords with one patch on both sides */
		const idx_t patch = draft->seam[3 * i + 2];
		network.curve[network.curve_count++] = (struct curve){.left = patch, .right = patch, .kind = CURVE_SHARP, .first = network.point_count, .count = 2};
		network.point[network.point_count++] = net[draft->seam[3 * i]], network.point[network.point_count++] = net[draft->seam[3 * i + 1]];
	}
	for (size_t k = 0; k < network.curve_count; k++)
		network.curve[k].length = network_curve_length(&network, &network.curve[k]);

	/* Each patch in its own vertices, patches in order of their first face; faces keep their order within a patch. */
	struct cage cage = {.scheme = SCHEME_QUADTRI, .face_count = polygons->count};
	cage.xyz = mem_array(3 * corners, sizeof *cage.xyz);
	cage.corner = mem_array(corners, 1);
	cage.net = mem_array(corners, sizeof *cage.net);
	cage.face_corner = mem_array(corners, sizeof *cage.face_corner);
	cage.face_start = mem_copy(polygons->start, polygons->count + 1, sizeof *polygons->start);
	cage.face_patch = mem_copy(polygons->patch, polygons->count, sizeof *polygons->patch);
	idx_t *local = mem_array(draft->control.count, sizeof *local), *of_patch = mem_array(draft->control.count, sizeof *of_patch);
	memset(of_patch, 0xff, draft->control.count * sizeof *of_patch);
	for (size_t f = 0; f < polygons->count; f++)
		for (size_t h = polygons->start[f]; h < polygons->start[f + 1]; h++) {
			const idx_t point = polygons->corner[h];
			if (of_patch[point] != polygons->patch[f]) {
				of_patch[point] = polygons->patch[f];
				local[point] = (idx_t)cage.vertex_count++;
				copy3(&cage.xyz[3 * (size_t)local[point]], &draft->control.xyz[3 * (size_t)point]);
				cage.net[local[point]] = net[point];
			}
			cage.face_corner[h] = local[point];
		}
	ply_drop_element(ply, "edge");
	cage_to_ply(ply, &cage);
	network_to_ply(ply, &network, "netpoint");
	size_t held = 0;
	for (size_t i = 0; i < draft->control.count; i++)
		held += draft->control.held[i] && net[i] != NO_INDEX;
	if (held > 0)
		ply_comment(ply, "cagewright held %zu", held);
	free(local), free(of_patch), free(net);
	cage_free(&cage);
	network_free(&network);
}
