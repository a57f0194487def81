/* Cut closed patches and patches with handles: see patchcut.h. */
#include "stages/rectify/patchcut.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/eigen3.h"
#include "stages/geometry/vector.h"
#include "stages/geometry/wedge.h"
#include "stages/rectify/labelsmooth.h"
#include "stages/rectify/patchmesh.h"

#define ROUND_LIMIT 40
#define SECTOR_ERROR 0.001     /* of the longest side, that a ring of sectors may miss its circle by */
#define SECTORS_LEAST 4
#define SECTORS_MOST 12
#define SECTOR_TRIANGLES 8     /* a sector should have, on coarse tori */
#define STAR_SHARE 0.95        /* of the area that must look away from the centre */
#define BALL_SHARE 0.65        /* of a sphere: a patch that covers more cannot be spanned from its border */
#define LEVELS 9               /* level sets tried a bisection, at equal shares of the area */
#define ROUND_AXES 0.02        /* principal moments nearer than this (of the largest) have no axes of their own */
#define PIECE_SHARE 0.1        /* loose pieces of a part below this share join a sibling */
#define RINGS 4
#define SMOOTH_ROUNDS 3

enum region_kind { REGION_NONE, REGION_SIDE, REGION_SECTOR, REGION_LEVEL };

/* Where a part wants to be. */
struct region {
	enum region_kind kind;
	int part;                /* side 0..5 (axis, then its sign), sector, or 0 near and 1 far */
	double centre[3], axis[3][3];
	double extent[3];        /* sides: half lengths of the box */
	double width;            /* sectors: radians; levels: the level */
};

struct cutter {
	struct partition *p;
	struct region *region;   /* a label */
	idx_t *family;           /* a label: the cut of this round that it belongs to, -1 none */
	double *scale;           /* a label */
	size_t room;             /* labels that the three have room for */
	double *field;           /* a triangle: distance for levels */
	idx_t *local;            /* a triangle, for patchmesh */
};

static void make_room(struct cutter *c)
{
	if (c->p->patch_count <= c->room)
		return;
	const size_t room = 2 * c->p->patch_count;
	c->region = mem_resize(c->region, room, sizeof *c->region);
	c->family = mem_resize(c->family, room, sizeof *c->family);
	c->scale = mem_resize(c->scale, room, sizeof *c->scale);
	for (size_t l = c->room; l < room; l++) {
		c->region[l] = (struct region){.kind = REGION_NONE};
		c->family[l] = -1;
		c->scale[l] = c->p->scale;
	}
	c->room = room;
}

/* Coordinates of a triangle's middle in a region's frame, by its box. */
static void box_coordinates(double out[3], const struct region *r, const double x[3])
{
	double d[3];
	sub3(d, x, r->centre);
	for (int i = 0; i < 3; i++)
		out[i] = dot3(d, r->axis[i]) / r->extent[i];
}

static double around(const struct region *r, const double x[3])
{
	double d[3];
	sub3(d, x, r->centre);
	const double angle = atan2(dot3(d, r->axis[1]), dot3(d, r->axis[0]));
	return angle < 0 ? angle + 2 * PI : angle;
}

/* How far a triangle's middle is outside a region, a length; 0 inside. */
static double outside(const struct cutter *c, const struct region *r, idx_t triangle)
{
	const double *x = c->p->centroid + 3 * triangle;
	if (r->kind == REGION_LEVEL)
		return fmax(0, r->part == 0 ? c->field[triangle] - r->width : r->width - c->field[triangle]);
	if (r->kind == REGION_SECTOR) {
		const double middle = (r->part + 0.5) * r->width;
		double d[3];
		sub3(d, x, r->centre);
		add_scaled3(d, -dot3(d, r->axis[2]), r->axis[2]);
		const double off = fabs(remainder(around(r, x) - middle, 2 * PI));
		return fmax(0, off - 0.5 * r->width) * norm3(d);
	}
	double b[3];
	box_coordinates(b, r, x);
	const int axis = r->part / 2;
	const double own = r->part % 2 ? -b[axis] : b[axis];
	double others = 0, extent = r->extent[axis];
	for (int i = 0; i < 3; i++)
		if (i != axis && fabs(b[i]) > others)
			others = fabs(b[i]), extent = fmin(r->extent[axis], r->extent[i]);
	return fmax(0, others - own) * extent / sqrt(2);
}

static double region_cost(const void *context, idx_t triangle, idx_t label)
{
	const struct cutter *c = context;
	const double d = outside(c, &c->region[label], triangle) / c->scale[label];
	return fmin(d * d, 4);
}

/* Principal axes, ascending moments; where moments tie, the coordinate axes decide, so that a ball's cuts lie straight. */
static void principal_axes(double axis[3][3], const double matrix[6])
{
	double value[3], vector[3][3];
	eigen3_symmetric(value, vector, matrix);
	const double near = ROUND_AXES * value[2];
	const bool low = value[1] - value[0] < near, high = value[2] - value[1] < near;
	if (low && high) {
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++)
				axis[i][k] = i == k;
		return;
	}
	memcpy(axis, vector, sizeof vector);
	if (!low && !high)
		return;
	/* one axis is certain: the others as near to coordinate axes as they can be */
	const double *certain = vector[low ? 2 : 0];
	int least = 0;
	for (int k = 1; k < 3; k++)
		if (fabs(certain[k]) < fabs(certain[least]))
			least = k;
	double u[3] = {0}, w[3];
	u[least] = 1;
	copy3(w, certain);
	add_scaled3(u, -dot3(u, w), w);
	normalise3(u);
	copy3(axis[2], w);
	copy3(axis[0], u);
	cross3(axis[1], w, u);
}

/* A box around the patch along its principal axes. Returns whether the patch looks away from its middle. */
static bool fit_box(struct region *box, const struct partition *p, const idx_t *list, size_t count)
{
	double total = 0, away = 0, matrix[6] = {0};
	for (size_t i = 0; i < count; i++) {
		total += p->area[list[i]];
		add_scaled3(box->centre, p->area[list[i]], p->centroid + 3 * list[i]);
	}
	if (!(total > 0))
		return false;
	scale3(box->centre, 1 / total);
	for (size_t i = 0; i < count; i++) {
		double d[3];
		const double a = p->area[list[i]];
		sub3(d, p->centroid + 3 * list[i], box->centre);
		matrix[0] += a * d[0] * d[0];
		matrix[1] += a * d[0] * d[1];
		matrix[2] += a * d[0] * d[2];
		matrix[3] += a * d[1] * d[1];
		matrix[4] += a * d[1] * d[2];
		matrix[5] += a * d[2] * d[2];
		if (dot3(d, p->normal + 3 * list[i]) > 0)
			away += a;
	}
	principal_axes(box->axis, matrix);
	for (size_t i = 0; i < count; i++) {
		double d[3];
		sub3(d, p->centroid + 3 * list[i], box->centre);
		for (int k = 0; k < 3; k++)
			box->extent[k] = fmax(box->extent[k], fabs(dot3(d, box->axis[k])));
	}
	const double longest = fmax(box->extent[0], fmax(box->extent[1], box->extent[2]));
	for (int k = 0; k < 3; k++)
		box->extent[k] = fmax(box->extent[k], 1e-3 * longest); /* a flat patch: any size will do */
	return longest > 0 && fmax(away, total - away) > STAR_SHARE * total;
}

/* True for a patch that is most of a sphere. */
static bool is_ball(const struct partition *p, idx_t label, const idx_t *list, size_t count)
{
	const struct dense_patch *patch = &p->patch[label];
	if (patch->kind != PATCH_SPHERE)
		return false;
	double area = 0;
	for (size_t i = 0; i < count; i++)
		area += p->area[list[i]];
	return area > BALL_SHARE * 4 * PI * patch->radius * patch->radius;
}

/* A cube around a sphere, one side to where the border is, so that it stays within one part if it is small. */
static void fit_ball(struct region *box, const struct partition *p, idx_t label, const idx_t *list, size_t count)
{
	double *away = box->axis[2], matrix[6] = {0};
	copy3(box->centre, p->patch[label].point);
	for (size_t i = 0; i < count; i++) {
		double d[3];
		sub3(d, p->centroid + 3 * list[i], box->centre);
		add_scaled3(away, p->area[list[i]], d);
	}
	if (!(normalise3(away) > 0))
		away[2] = 1;
	/* the rank-one matrix of one certain direction */
	for (int i = 0, k = 0; i < 3; i++)
		for (int j = i; j < 3; j++)
			matrix[k++] = away[i] * away[j];
	principal_axes(box->axis, matrix);
	for (int k = 0; k < 3; k++)
		box->extent[k] = p->patch[label].radius;
}

/* Sectors around a torus' axis, the first border at a vertex of the mesh. */
static int fit_sectors(struct region *sector, const struct partition *p, idx_t label, const idx_t *list, size_t count)
{
	const struct dense_patch *torus = &p->patch[label];
	double d[3];
	copy3(sector->centre, torus->point);
	copy3(sector->axis[2], torus->axis);
	sub3(d, p->xyz + 3 * p->half.origin[3 * list[0]], torus->point);
	add_scaled3(d, -dot3(d, torus->axis), torus->axis);
	if (!(normalise3(d) > 0))
		return 1;
	copy3(sector->axis[0], d);
	cross3(sector->axis[1], sector->axis[2], d);
	/* a ring of k control points misses a circle of radius r by about 2.3 r / k^4 */
	double wanted = ceil(pow(2.3 * (torus->radius + torus->radius2) / SECTOR_ERROR, 0.25));
	wanted = fmin(fmax(wanted, SECTORS_LEAST), SECTORS_MOST);
	while (wanted > 2 && (double)count < wanted * SECTOR_TRIANGLES)
		wanted--;
	sector->width = 2 * PI / wanted;
	return (int)wanted;
}

struct by_field {
	double field;
	double area;
	idx_t triangle;
};

static int compare_fields(const void *a, const void *b)
{
	const struct by_field *p = a, *q = b;
	if (p->field != q->field)
		return p->field < q->field ? -1 : 1;
	return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

static idx_t farthest(const double *distance, size_t count)
{
	size_t best = 0;
	for (size_t v = 1; v < count; v++)
		if (distance[v] < INFINITY && distance[v] > distance[best])
			best = v;
	return (idx_t)best;
}

/* How bad a division of a patch is: handles and closed parts first, then the number of parts, then the length of the cut. */
static double badness(const struct patchmesh *m, const idx_t *side, double area)
{
	const size_t n = m->half.face_count;
	idx_t *component = mem_array(n, sizeof *component);
	const size_t count = patch_components(component, side, &m->half);
	struct patch_topology *t = mem_array(count, sizeof *t);
	double bad = 0, length = 0;
	patch_topologies(t, count, component, &m->half);
	for (size_t i = 0; i < count; i++)
		bad += 10 * (double)(t[i].genus + (t[i].border_loops == 0)) + 0.5 + (t[i].border_loops > 2 ? 0.25 : 0);
	for (size_t h = 0; h < m->half.half_count; h++) {
		const idx_t twin = m->half.twin[h];
		if (twin > (idx_t)h && side[h / 3] != side[twin / 3])
			length += distance3(m->xyz + 3 * m->half.origin[h], m->xyz + 3 * m->half.origin[twin]);
	}
	free(component);
	free(t);
	return bad + length / sqrt(area);
}

/* Distance from a far point, and the best of its level sets. Writes the field; returns the level. */
static double fit_level(struct cutter *c, const idx_t *list, size_t count)
{
	struct partition *p = c->p;
	struct patchmesh m;
	patchmesh_cut_out(&m, &p->half, p->xyz, list, count, c->local);
	double *distance = mem_array(m.half.vertex_count, sizeof *distance), total = 0, level = 0, best = INFINITY;
	struct by_field *order = mem_array(count, sizeof *order);
	idx_t *side = mem_array(count, sizeof *side), from = 0;
	/* twice: a point far from any point, then the distances from it */
	for (int sweep = 0; sweep < 2; sweep++) {
		patchmesh_distances(distance, &m, &from, 1);
		if (sweep == 0)
			from = farthest(distance, m.half.vertex_count);
	}
	for (size_t i = 0; i < count; i++) {
		double field = 0;
		for (size_t k = 0; k < 3; k++)
			field += distance[m.half.origin[3 * i + k]] / 3;
		c->field[list[i]] = field;
		order[i] = (struct by_field){field, p->area[list[i]], (idx_t)i};
		total += p->area[list[i]];
	}
	qsort(order, count, sizeof *order, compare_fields);
	double below = 0;
	for (size_t i = 0, next = 1; i + 1 < count && next <= LEVELS; i++) {
		below += order[i].area;
		if (below * (LEVELS + 1) < total * (double)next || !(order[i + 1].field > order[i].field))
			continue;
		while (next <= LEVELS && below * (LEVELS + 1) >= total * (double)next)
			next++;
		const double tried = 0.5 * (order[i].field + order[i + 1].field);
		for (size_t k = 0; k < count; k++)
			side[order[k].triangle] = order[k].field > tried;
		const double bad = badness(&m, side, total);
		if (bad < best)
			best = bad, level = tried;
	}
	if (!(best < INFINITY)) { /* all distances alike: any division is as good */
		for (size_t i = 0; i < count; i++)
			c->field[list[order[i].triangle]] = (double)i / (double)count;
		level = 0.5 - 0.5 / (double)count;
	}
	free(distance);
	free(order);
	free(side);
	patchmesh_free(&m);
	return level;
}

/* Give every triangle of a patch the part of its nearest region. Returns false when all got the same. */
static bool divide(struct cutter *c, idx_t label, const idx_t *list, size_t count, const struct region *shape, int part_count, idx_t family)
{
	struct partition *p = c->p;
	idx_t name[SECTORS_MOST + 6];
	int *part = mem_array(count, sizeof *part), used = 0;
	for (int k = 0; k < part_count; k++)
		name[k] = NO_INDEX;
	for (size_t i = 0; i < count; i++) {
		double best = INFINITY;
		for (int k = 0; k < part_count; k++) {
			struct region r = *shape;
			r.part = k;
			const double d = outside(c, &r, list[i]);
			if (d < best)
				best = d, part[i] = k;
		}
		used += name[part[i]] == NO_INDEX;
		name[part[i]] = label;
	}
	if (used > 1) {
		double area = 0;
		for (size_t i = 0; i < count; i++)
			area += p->area[list[i]];
		bool is_first = true;
		for (int k = 0; k < part_count; k++) {
			if (name[k] == NO_INDEX)
				continue;
			if (!is_first)
				name[k] = partition_add(p, label, false);
			is_first = false;
			make_room(c);
			c->region[name[k]] = *shape;
			c->region[name[k]].part = k;
			c->family[name[k]] = family;
			/* height of an equilateral triangle of the mean area */
			c->scale[name[k]] = sqrt(sqrt(3) * area / (double)count);
		}
		for (size_t i = 0; i < count; i++)
			p->label[list[i]] = name[part[i]];
	}
	free(part);
	return used > 1;
}

static void cut_one(struct cutter *c, idx_t label, const struct patch_topology *topology, const idx_t *list, size_t count, idx_t family)
{
	const struct partition *p = c->p;
	struct region shape = {.kind = REGION_SIDE};
	/* a part that a shape has left with a handle is a case for level sets */
	const bool is_first = c->region[label].kind == REGION_NONE;
	if (is_first && topology->genus == 0 && topology->border_loops > 0) {
		fit_ball(&shape, p, label, list, count);
		divide(c, label, list, count, &shape, 6, family);
		return;
	}
	if (is_first && topology->genus == 0 && fit_box(&shape, p, list, count) && divide(c, label, list, count, &shape, 6, family))
		return;
	if (is_first && topology->genus > 0 && p->patch[label].kind == PATCH_TORUS) {
		shape = (struct region){.kind = REGION_SECTOR};
		const int sectors = fit_sectors(&shape, p, label, list, count);
		if (sectors > 1 && divide(c, label, list, count, &shape, sectors, family))
			return;
	}
	shape = (struct region){.kind = REGION_LEVEL, .width = fit_level(c, list, count)};
	divide(c, label, list, count, &shape, 2, family);
}

void patchcut(struct partition *p, struct patchcut_counts *counts)
{
	const size_t n = p->half.face_count, patches_before = p->patch_count;
	struct cutter c = {.p = p};
	*counts = (struct patchcut_counts){0};
	c.field = mem_array(n, sizeof *c.field);
	c.local = mem_array(n, sizeof *c.local);
	for (size_t t = 0; t < n; t++)
		c.local[t] = NO_INDEX;
	make_room(&c);
	for (int round = 0;; round++) {
		const size_t patch_count = p->patch_count;
		struct patch_topology *topology = mem_array(patch_count, sizeof *topology);
		size_t *start, bad = 0;
		idx_t *list;
		patch_topologies(topology, patch_count, p->label, &p->half);
		partition_lists(p, &start, &list);
		for (size_t l = 0; l < patch_count; l++) {
			c.family[l] = -1;
			const struct patch_topology *t = &topology[l];
			if (t->faces < 2 || t->components != 1)
				continue;
			const bool is_whole = t->border_loops == 0 || t->genus > 0;
			if (!is_whole && (round > 0 || !is_ball(p, (idx_t)l, list + start[l], start[l + 1] - start[l])))
				continue;
			bad += is_whole;
			if (round == 0)
				t->genus > 0 ? counts->handles++ : t->border_loops > 0 ? counts->balls++ : counts->closed++;
			if (round < ROUND_LIMIT)
				cut_one(&c, (idx_t)l, t, list + start[l], start[l + 1] - start[l], (idx_t)l);
		}
		free(topology);
		free(start);
		free(list);
		counts->unsolved = bad;
		if (p->patch_count == patch_count || round == ROUND_LIMIT)
			break;
		counts->rounds++;
		struct labelsmooth_counts ignored = {0};
		const struct labelsmooth_options options = {region_cost, &c, c.family, c.scale, NULL, RINGS, 0.5, SMOOTH_ROUNDS};
		labelsmooth(p, &options, &ignored);
		partition_split(p, 0, PIECE_SHARE, true, NULL, NULL);
		make_room(&c);
	}
	counts->parts = p->patch_count - patches_before;
	free(c.region);
	free(c.family);
	free(c.scale);
	free(c.field);
	free(c.local);
}
