/* A dense mesh with its labels: see partition.h. */
#include "stages/rectify/partition.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh.h"
#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"
#include "stages/geometry/wedge.h"

#define THIN 1e-5 /* lower triangles have no normal of their own, as in curv */

static int compare_doubles(const void *a, const void *b)
{
	const double p = *(const double *)a, q = *(const double *)b;
	return (p > q) - (p < q);
}

static void measure_triangles(struct partition *p)
{
	const struct half *half = &p->half;
	const struct dense *dense = p->dense;
	const size_t n = half->face_count;
	double *width = mem_array(n, sizeof *width);
	p->total_area = 0;
	for (size_t t = 0; t < n; t++) {
		double area[3], longest = 0, kmin = 0, kmax = 0;
		const double *corner[3];
		for (int k = 0; k < 3; k++) {
			const idx_t h = (idx_t)(3 * t) + k, w = dense->triangle_wedge[h];
			corner[k] = p->xyz + 3 * half->origin[h];
			p->length[h] = distance3(corner[k], p->xyz + 3 * half->origin[half->next[h]]);
			longest = fmax(longest, p->length[h]);
			kmin += dense->kmin[w] * p->side / 3;
			kmax += dense->kmax[w] * p->side / 3;
			for (int i = 0; i < 3; i++)
				p->centroid[3 * t + i] += corner[k][i] / 3;
		}
		area_vector3(area, corner[0], corner[1], corner[2]);
		p->area[t] = 0.5 * norm3(area);
		p->total_area += p->area[t];
		p->curvature[2 * t] = asinh(kmin);
		p->curvature[2 * t + 1] = asinh(kmax);
		width[t] = longest > 0 ? 2 * p->area[t] / longest : 0;
	}
	qsort(width, n, sizeof *width, compare_doubles);
	p->scale = n > 0 ? width[n / 2] : 0;
	free(width);
}

/* The surface of a patch in relative lengths. */
static void make_relative(struct dense_patch *patch, const double low[3], double side)
{
	for (int i = 0; i < 3; i++)
		patch->point[i] = (patch->point[i] - low[i]) / side;
	patch->radius /= side;
	patch->residual /= side;
	if (patch->kind == PATCH_TORUS)
		patch->radius2 /= side;
}

bool partition_new(struct partition *p, const struct dense *dense, const char *shown, struct fault *fault)
{
	*p = (struct partition){.dense = dense};
	struct fault inner = {0};
	if (!half_build_triangles(&p->half, dense->triangle, dense->triangle_count, dense->vertex_count, &inner))
		return fault_set(fault, inner.code, "%s: %s", shown, inner.text);
	const size_t n = dense->triangle_count;
	p->kind = mem_array(3 * n, 1);
	if (!wedge_mark_edges(p->kind, dense, &p->half, shown, fault)) {
		partition_free(p);
		return false;
	}
	p->side = mesh_bounds(dense->xyz, dense->vertex_count, p->low, NULL);
	if (!(p->side > 0)) {
		partition_free(p);
		return fault_set(fault, EX_BAD_INPUT, "%s: the mesh has no extent", shown);
	}
	p->xyz = mem_array(dense->vertex_count, 3 * sizeof *p->xyz);
	for (size_t i = 0; i < 3 * dense->vertex_count; i++)
		p->xyz[i] = (dense->xyz[i] - p->low[i % 3]) / p->side;
	p->bend = mem_array(3 * n, sizeof *p->bend);
	p->length = mem_array(3 * n, sizeof *p->length);
	p->area = mem_array(n, sizeof *p->area);
	p->normal = mem_array(n, 3 * sizeof *p->normal);
	p->centroid = mem_array(n, 3 * sizeof *p->centroid);
	p->curvature = mem_array(n, 2 * sizeof *p->curvature);
	wedge_triangle_normals(p->normal, p->xyz, &p->half, THIN);
	wedge_bends(p->bend, p->xyz, p->normal, &p->half);
	measure_triangles(p);
	p->label = mem_copy(dense->label, n, sizeof *dense->label);
	p->patch_count = p->patch_room = p->group_count = dense->patch_count;
	p->patch = mem_copy(dense->patch, p->patch_count, sizeof *dense->patch);
	p->group = mem_array(p->patch_count, sizeof *p->group);
	p->mean_curvature = mem_array(p->patch_count, 2 * sizeof *p->mean_curvature);
	p->normal_spread = mem_array(p->patch_count, sizeof *p->normal_spread);
	p->distance_spread = mem_array(p->patch_count, sizeof *p->distance_spread);
	p->curvature_variance = mem_array(p->patch_count, sizeof *p->curvature_variance);
	p->patch_area = mem_array(p->patch_count, sizeof *p->patch_area);
	for (size_t l = 0; l < p->patch_count; l++) {
		make_relative(&p->patch[l], p->low, p->side);
		const idx_t parent = p->patch[l].parent;
		p->group[l] = parent >= 0 && (size_t)parent < p->patch_count ? parent : (idx_t)l;
	}
	partition_refresh(p);
	return true;
}

void partition_free(struct partition *p)
{
	half_free(&p->half);
	free(p->xyz);
	free(p->kind);
	free(p->bend);
	free(p->length);
	free(p->area);
	free(p->normal);
	free(p->centroid);
	free(p->curvature);
	free(p->label);
	free(p->patch);
	free(p->group);
	free(p->mean_curvature);
	free(p->curvature_variance);
	free(p->normal_spread);
	free(p->distance_spread);
	free(p->patch_area);
	*p = (struct partition){0};
}

idx_t partition_add(struct partition *p, idx_t like, bool own_group)
{
	if (p->patch_count == p->patch_room) {
		p->patch_room = 2 * p->patch_room + 16;
		p->patch = mem_resize(p->patch, p->patch_room, sizeof *p->patch);
		p->group = mem_resize(p->group, p->patch_room, sizeof *p->group);
		p->mean_curvature = mem_resize(p->mean_curvature, p->patch_room, 2 * sizeof *p->mean_curvature);
		p->normal_spread = mem_resize(p->normal_spread, p->patch_room, sizeof *p->normal_spread);
		p->distance_spread = mem_resize(p->distance_spread, p->patch_room, sizeof *p->distance_spread);
		p->curvature_variance = mem_resize(p->curvature_variance, p->patch_room, sizeof *p->curvature_variance);
		p->patch_area = mem_resize(p->patch_area, p->patch_room, sizeof *p->patch_area);
	}
	const size_t l = p->patch_count++;
	p->patch[l] = p->patch[like];
	p->group[l] = own_group ? (idx_t)p->group_count++ : p->group[like];
	p->mean_curvature[2 * l] = p->mean_curvature[2 * like];
	p->mean_curvature[2 * l + 1] = p->mean_curvature[2 * like + 1];
	p->curvature_variance[l] = p->curvature_variance[like];
	p->normal_spread[l] = p->normal_spread[like];
	p->distance_spread[l] = p->distance_spread[like];
	p->patch_area[l] = 0;
	return (idx_t)l;
}

void partition_refresh(struct partition *p)
{
	memset(p->patch_area, 0, p->patch_count * sizeof *p->patch_area);
	memset(p->curvature_variance, 0, p->patch_count * sizeof *p->curvature_variance);
	memset(p->mean_curvature, 0, 2 * p->patch_count * sizeof *p->mean_curvature);
	for (size_t t = 0; t < p->half.face_count; t++) {
		const idx_t l = p->label[t];
		p->patch_area[l] += p->area[t];
		for (int i = 0; i < 2; i++)
			p->mean_curvature[2 * l + i] += p->area[t] * p->curvature[2 * t + i];
	}
	for (size_t l = 0; l < p->patch_count; l++)
		for (int i = 0; i < 2; i++)
			if (p->patch_area[l] > 0)
				p->mean_curvature[2 * l + i] /= p->patch_area[l];
	for (size_t t = 0; t < p->half.face_count; t++) {
		const idx_t l = p->label[t];
		for (int i = 0; i < 2 && p->patch_area[l] > 0; i++) {
			const double off = p->curvature[2 * t + i] - p->mean_curvature[2 * l + i];
			p->curvature_variance[l] += p->area[t] / p->patch_area[l] * off * off;
		}
	}
}

void partition_lists(const struct partition *p, size_t **start, idx_t **list)
{
	const size_t n = p->half.face_count;
	size_t *s = mem_array(p->patch_count + 2, sizeof *s);
	idx_t *l = mem_array(n, sizeof *l);
	for (size_t t = 0; t < n; t++)
		s[p->label[t] + 2]++;
	for (size_t i = 0; i < p->patch_count; i++)
		s[i + 2] += s[i + 1];
	for (size_t t = 0; t < n; t++)
		l[s[p->label[t] + 1]++] = (idx_t)t;
	*start = s;
	*list = l;
}

void partition_deviation(double *angle_rad, double *distance, const struct partition *p, idx_t triangle, idx_t label)
{
	const struct dense_patch *patch = &p->patch[label];
	double normal[3];
	primitive_foot(patch, p->centroid + 3 * triangle, NULL, normal);
	*angle_rad = angle3(normal, p->normal + 3 * triangle);
	*distance = 0;
	for (int k = 0; k < 3; k++)
		*distance = fmax(*distance, fabs(primitive_distance(patch, p->xyz + 3 * p->half.origin[3 * triangle + k])));
}

void partition_measure_spread(struct partition *p)
{
	size_t *start;
	idx_t *list;
	double *angle = mem_array(p->half.face_count, sizeof *angle), *distance = mem_array(p->half.face_count, sizeof *distance);
	partition_lists(p, &start, &list);
	for (size_t l = 0; l < p->patch_count; l++) {
		const size_t first = start[l], count = start[l + 1] - start[l];
		p->normal_spread[l] = p->distance_spread[l] = 0;
		if (p->patch[l].kind == PATCH_FREE || count == 0)
			continue;
		for (size_t i = first; i < first + count; i++)
			partition_deviation(&angle[i], &distance[i], p, list[i], (idx_t)l);
		qsort(angle + first, count, sizeof *angle, compare_doubles);
		qsort(distance + first, count, sizeof *distance, compare_doubles);
		p->normal_spread[l] = angle[first + count / 2];
		p->distance_spread[l] = distance[first + count / 2];
	}
	free(start);
	free(list);
	free(angle);
	free(distance);
}

/* One neighbour of a component and the length of the smooth border with it. */
struct contact {
	idx_t component, label;
	double length;
};

static int compare_contacts(const void *a, const void *b)
{
	const struct contact *p = a, *q = b;
	if (p->component != q->component)
		return p->component < q->component ? -1 : 1;
	if (p->label != q->label)
		return p->label < q->label ? -1 : 1;
	return (p->length > q->length) - (p->length < q->length);
}

/* host[c] = label of the neighbour with the longest common smooth border, NO_INDEX for none; lengths are summed. */
static void find_hosts(idx_t *host, size_t component_count, const struct partition *p, const idx_t *component, const unsigned char *wanted,
                       bool siblings_only)
{
	const struct half *half = &p->half;
	size_t count = 0;
	for (size_t c = 0; c < component_count; c++)
		host[c] = NO_INDEX;
	struct contact *contact = mem_array(half->half_count, sizeof *contact);
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t twin = half->twin[h], c = component[half->face[h]];
		if (twin == NO_INDEX || p->kind[h] || !wanted[c])
			continue;
		const idx_t other = half->face[twin];
		if (component[other] == c || (siblings_only && p->group[p->label[other]] != p->group[p->label[half->face[h]]]))
			continue;
		/* another component that is going to move is no host */
		if (wanted[component[other]])
			continue;
		contact[count++] = (struct contact){c, p->label[other], p->length[h]};
	}
	qsort(contact, count, sizeof *contact, compare_contacts);
	double best = 0;
	for (size_t i = 0, end; i < count; i = end) {
		double length = 0;
		for (end = i; end < count && contact[end].component == contact[i].component && contact[end].label == contact[i].label; end++)
			length += contact[end].length;
		const idx_t c = contact[i].component;
		if (host[c] == NO_INDEX || length > best)
			host[c] = contact[i].label, best = length;
	}
	free(contact);
}

void partition_split(struct partition *p, double tiny_area, double tiny_share, bool siblings_only, size_t *split, size_t *absorbed)
{
	const size_t n = p->half.face_count;
	idx_t *component = mem_array(n, sizeof *component);
	const size_t count = patch_components(component, p->label, &p->half);
	double *area = mem_array(count, sizeof *area);
	idx_t *of = mem_array(count, sizeof *of), *largest = mem_array(p->patch_count, sizeof *largest), *host = mem_array(count, sizeof *host);
	unsigned char *is_tiny = mem_array(count, 1);
	size_t split_count = 0, absorbed_count = 0;
	partition_refresh(p);
	for (size_t t = 0; t < n; t++) {
		area[component[t]] += p->area[t];
		of[component[t]] = p->label[t];
	}
	for (size_t l = 0; l < p->patch_count; l++)
		largest[l] = NO_INDEX;
	for (size_t c = 0; c < count; c++)
		if (largest[of[c]] == NO_INDEX || area[c] > area[largest[of[c]]])
			largest[of[c]] = (idx_t)c;
	for (size_t c = 0; c < count; c++)
		is_tiny[c] = largest[of[c]] != (idx_t)c && area[c] < fmax(tiny_area, tiny_share * p->patch_area[of[c]]);
	find_hosts(host, count, p, component, is_tiny, siblings_only);
	for (size_t c = 0; c < count; c++) {
		if (largest[of[c]] == (idx_t)c) {
			host[c] = of[c];
		} else if (host[c] != NO_INDEX) {
			absorbed_count++;
		} else {
			host[c] = partition_add(p, of[c], !siblings_only);
			split_count++;
		}
	}
	for (size_t t = 0; t < n; t++)
		p->label[t] = host[component[t]];
	partition_refresh(p);
	if (split)
		*split += split_count;
	if (absorbed)
		*absorbed += absorbed_count;
	free(component);
	free(area);
	free(of);
	free(largest);
	free(host);
	free(is_tiny);
}

static int compare_pairs(const void *a, const void *b)
{
	const idx_t *p = a, *q = b;
	if (p[0] != q[0])
		return p[0] < q[0] ? -1 : 1;
	return (p[1] > q[1]) - (p[1] < q[1]);
}

/* Keep the listed edges that still are features. */
static void drop_smooth_edges(const struct partition *p, struct dense *dense)
{
	const struct half *half = &p->half;
	idx_t *pair = mem_array(half->half_count, 2 * sizeof *pair);
	size_t count = 0, kept = 0;
	for (size_t h = 0; h < half->half_count; h++) {
		const idx_t a = half->origin[h], b = half->origin[half->next[h]];
		if (!p->kind[h])
			continue;
		pair[2 * count] = a < b ? a : b;
		pair[2 * count + 1] = a < b ? b : a;
		count++;
	}
	qsort(pair, count, 2 * sizeof *pair, compare_pairs);
	for (size_t e = 0; e < dense->edge_count; e++) {
		const idx_t a = dense->edge[e].vertex1, b = dense->edge[e].vertex2;
		const idx_t want[2] = {a < b ? a : b, a < b ? b : a};
		if (bsearch(want, pair, count, 2 * sizeof *pair, compare_pairs))
			dense->edge[kept++] = dense->edge[e];
	}
	dense->edge_count = kept;
	free(pair);
}

void partition_finish(const struct partition *p, struct dense *dense)
{
	const size_t n = p->half.face_count;
	size_t *size = mem_array(p->patch_count, sizeof *size);
	idx_t *name = mem_array(p->patch_count, sizeof *name), *parent = mem_array(p->group_count, sizeof *parent);
	for (size_t t = 0; t < n; t++)
		size[p->label[t]]++;
	size_t kept = 0;
	for (size_t g = 0; g < p->group_count; g++)
		parent[g] = NO_INDEX;
	for (size_t l = 0; l < p->patch_count; l++) {
		name[l] = NO_INDEX;
		if (size[l] == 0)
			continue;
		name[l] = (idx_t)kept++;
		if (parent[p->group[l]] == NO_INDEX)
			parent[p->group[l]] = name[l];
	}
	struct dense_patch *patch = mem_array(kept, sizeof *patch);
	for (size_t l = 0; l < p->patch_count; l++) {
		if (name[l] == NO_INDEX)
			continue;
		struct dense_patch *q = &patch[name[l]];
		*q = p->patch[l];
		for (int i = 0; i < 3; i++)
			q->point[i] = q->kind == PATCH_FREE ? 0 : q->point[i] * p->side + p->low[i];
		q->radius *= p->side;
		if (q->kind == PATCH_TORUS)
			q->radius2 *= p->side;
		q->area = q->residual = 0;
		q->parent = parent[p->group[l]];
	}
	for (size_t t = 0; t < n; t++) {
		struct dense_patch *q = &patch[name[p->label[t]]];
		q->area += p->area[t] * p->side * p->side;
		if (q->kind == PATCH_FREE)
			continue;
		for (int k = 0; k < 3; k++)
			q->residual = fmax(q->residual, fabs(primitive_distance(q, dense->xyz + 3 * dense->triangle[3 * t + k])));
	}
	for (size_t t = 0; t < n; t++)
		dense->label[t] = name[p->label[t]];
	free(dense->patch);
	dense->patch = patch;
	dense->patch_count = kept;
	drop_smooth_edges(p, dense);
	free(size);
	free(name);
	free(parent);
}
