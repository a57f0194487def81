/* Enrichment of a cage by strips and stars (in place of the method's section 5.5, which opens a union of faces and stars it:
 * strips keep quads quads, and a row of points is what a surface that bends too much between two rows lacks). */
#include "stages/fitpatch/enrich.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/fitpatch/frame.h"
#include "stages/geometry/polygon.h"
#include "stages/geometry/vector.h"

/* A face that can still change. */
struct ring {
	idx_t *corner;
	size_t count;
	idx_t patch;
	bool touched; /* in this round: its error is of another shape */
};

struct mesh_edit {
	struct draft *draft;
	const struct target *target;
	struct ring *ring;
	size_t count, capacity;
	/* Directed edge a -> b: the face that has it. Open addressing on the pair. */
	struct directed {
		idx_t a, b, face;
	} *edge;
	size_t room, used;
	/* Edges split in the current step: a closed strip meets its first one again. */
	struct split {
		idx_t a, b, point;
	} *split;
	size_t split_count, split_capacity;
};

static size_t edge_slot(const struct mesh_edit *edit, idx_t a, idx_t b)
{
	uint64_t x = ((uint64_t)(uint32_t)a << 32 | (uint32_t)b) * 0x9e3779b97f4a7c15u;
	size_t i = (size_t)(x >> 24) & (edit->room - 1);
	while (edit->edge[i].a != NO_INDEX && (edit->edge[i].a != a || edit->edge[i].b != b))
		i = (i + 1) & (edit->room - 1);
	return i;
}

static void index_face(struct mesh_edit *edit, size_t f)
{
	const struct ring *ring = &edit->ring[f];
	if (2 * (edit->used + ring->count) > edit->room) {
		struct directed *old = edit->edge;
		const size_t old_room = edit->room;
		edit->room = edit->room ? 2 * edit->room : 1024;
		while (edit->room < 4 * (edit->used + ring->count))
			edit->room *= 2;
		edit->edge = mem_array(edit->room, sizeof *edit->edge);
		memset(edit->edge, 0xff, edit->room * sizeof *edit->edge);
		for (size_t i = 0; i < old_room; i++)
			if (old[i].a != NO_INDEX)
				edit->edge[edge_slot(edit, old[i].a, old[i].b)] = old[i];
		free(old);
	}
	for (size_t i = 0; i < ring->count; i++) {
		const idx_t a = ring->corner[i], b = ring->corner[(i + 1) % ring->count];
		struct directed *slot = &edit->edge[edge_slot(edit, a, b)];
		edit->used += slot->a == NO_INDEX;
		*slot = (struct directed){a, b, (idx_t)f};
	}
}

/* The face with directed edge a -> b. Entries of edges that are gone stay in the table: checked against the face itself. */
static idx_t face_with(const struct mesh_edit *edit, idx_t a, idx_t b)
{
	const struct directed *slot = &edit->edge[edge_slot(edit, a, b)];
	if (slot->a == NO_INDEX)
		return NO_INDEX;
	const struct ring *ring = &edit->ring[slot->face];
	for (size_t i = 0; i < ring->count; i++)
		if (ring->corner[i] == a && ring->corner[(i + 1) % ring->count] == b)
			return slot->face;
	return NO_INDEX;
}

static void set_ring(struct mesh_edit *edit, size_t f, const idx_t *corner, size_t count, idx_t patch)
{
	if (f == edit->count) {
		if (edit->count == edit->capacity) {
			edit->capacity += edit->capacity / 2 + 64;
			edit->ring = mem_resize(edit->ring, edit->capacity, sizeof *edit->ring);
		}
		edit->ring[edit->count++] = (struct ring){0};
	}
	idx_t *copy = mem_copy(corner, count, sizeof *corner);
	free(edit->ring[f].corner);
	edit->ring[f] = (struct ring){copy, count, patch, true};
	index_face(edit, f);
}

/* A new point between two control points: on their curve when a curve joins them (it becomes one of its points), else inside a patch. */
static idx_t middle_point(struct draft *draft, idx_t a, idx_t b)
{
	double middle[3];
	for (int k = 0; k < 3; k++)
		middle[k] = (draft->control.xyz[3 * (size_t)a + (size_t)k] + draft->control.xyz[3 * (size_t)b + (size_t)k]) / 2;
	struct network *network = &draft->network;
	for (size_t c = 0; draft->control.role[a] != POINT_INSIDE && draft->control.role[b] != POINT_INSIDE && c < network->curve_count; c++) {
		struct curve *curve = &network->curve[c];
		for (size_t i = 0; i + !curve->closed < curve->count; i++) {
			const idx_t p = network->point[curve->first + i], q = network->point[curve->first + (i + 1) % curve->count];
			if (!((p == a && q == b) || (p == b && q == a)))
				continue;
			const idx_t point = control_add(&draft->control, middle, POINT_CREASE);
			draft->control.held[point] = draft->control.held[a] && draft->control.held[b];
			network->point = mem_resize(network->point, network->point_count + 1, sizeof *network->point);
			const size_t at = curve->first + i + 1;
			memmove(&network->point[at + 1], &network->point[at], (network->point_count - at) * sizeof *network->point);
			network->point[at] = point;
			network->point_count++;
			curve->count++;
			for (size_t d = 0; d < network->curve_count; d++)
				if (d != c && network->curve[d].first >= at)
					network->curve[d].first++;
			return point;
		}
	}
	return control_add(&draft->control, middle, POINT_INSIDE);
}

/* The point of the current step between a and b. */
static idx_t split_point(struct mesh_edit *edit, idx_t a, idx_t b)
{
	for (size_t i = 0; i < edit->split_count; i++)
		if ((edit->split[i].a == a && edit->split[i].b == b) || (edit->split[i].a == b && edit->split[i].b == a))
			return edit->split[i].point;
	if (edit->split_count == edit->split_capacity) {
		edit->split_capacity = 2 * edit->split_capacity + 16;
		edit->split = mem_resize(edit->split, edit->split_capacity, sizeof *edit->split);
	}
	const idx_t point = middle_point(edit->draft, a, b);
	edit->split[edit->split_count++] = (struct split){a, b, point};
	return point;
}

static bool is_plane(const struct mesh_edit *edit, idx_t patch)
{
	return edit->target->dense->patch && edit->target->dense->patch[patch].kind == PATCH_PLANE;
}

/* Put a point into the edge a -> b of a face. */
static void insert_corner(struct mesh_edit *edit, size_t f, idx_t a, idx_t b, idx_t point)
{
	const struct ring *ring = &edit->ring[f];
	idx_t *corner = mem_array(ring->count + 1, sizeof *corner);
	size_t count = 0;
	for (size_t i = 0; i < ring->count; i++) {
		corner[count++] = ring->corner[i];
		if (ring->corner[i] == a && ring->corner[(i + 1) % ring->count] == b)
			corner[count++] = point;
	}
	set_ring(edit, f, corner, count, ring->patch);
	free(corner);
}

/* Edge a -> b of some face got a point: tell the face on its other side, and go on through quads. */
static void spread(struct mesh_edit *edit, idx_t a, idx_t b, idx_t point)
{
	for (size_t guard = 0; guard < edit->count + 1; guard++) {
		const idx_t f = face_with(edit, b, a);
		if (f == NO_INDEX)
			return;
		const struct ring *ring = &edit->ring[f];
		size_t at = 0;
		while (ring->corner[at] != b || ring->corner[(at + 1) % ring->count] != a)
			at++;
		const size_t n = ring->count;
		const idx_t patch = ring->patch;
		if (n == 3) {
			/* Two triangles: an edge to the opposite corner. */
			const idx_t c = ring->corner[(at + 2) % 3];
			const idx_t one[3] = {b, point, c}, two[3] = {point, a, c};
			set_ring(edit, (size_t)f, one, 3, patch);
			set_ring(edit, edit->count, two, 3, patch);
			return;
		}
		if (n > 4 || is_plane(edit, patch) || ring->touched) {
			insert_corner(edit, (size_t)f, b, a, point);
			return;
		}
		/* A quad (b a c d) becomes (b point next d) and (point a c next). */
		const idx_t c = ring->corner[(at + 2) % 4], d = ring->corner[(at + 3) % 4];
		const idx_t next = split_point(edit, c, d);
		const idx_t one[4] = {b, point, next, d}, two[4] = {point, a, c, next};
		set_ring(edit, (size_t)f, one, 4, patch);
		set_ring(edit, edit->count, two, 4, patch);
		a = c, b = d, point = next;
		/* The next face has d -> c; seen from here the edge runs c -> d. */
	}
}

static struct foot foot_of(const struct mesh_edit *edit, idx_t patch, const double p[3])
{
	return frame_foot(edit->target->nearest, edit->target->dense, patch, p);
}

static void edge_frame(struct frame *frame, double middle[3], const struct mesh_edit *edit, idx_t patch, idx_t a, idx_t b)
{
	const double *xyz = edit->draft->control.xyz;
	for (int k = 0; k < 3; k++)
		middle[k] = (xyz[3 * (size_t)a + (size_t)k] + xyz[3 * (size_t)b + (size_t)k]) / 2;
	const struct foot foot = foot_of(edit, patch, middle);
	*frame = (struct frame){0};
	if (foot.triangle != NO_INDEX)
		frame_at(frame, edit->target->dense, &foot);
}

/* Split quad f and its strip across the direction in which the target turns more. */
static void split_quad(struct mesh_edit *edit, size_t f)
{
	const idx_t patch = edit->ring[f].patch;
	idx_t q[4];
	memcpy(q, edit->ring[f].corner, sizeof q);
	struct frame frame[4];
	double middle[4][3];
	for (int i = 0; i < 4; i++)
		edge_frame(&frame[i], middle[i], edit, patch, q[i], q[(i + 1) % 4]);
	const double first = angle3(frame[0].normal, frame[2].normal) * distance3(middle[0], middle[2]);
	const double second = angle3(frame[1].normal, frame[3].normal) * distance3(middle[1], middle[3]);
	if (second > first) { /* turn the quad so that the bending runs from edge 0 to edge 2 */
		const idx_t t = q[0];
		q[0] = q[1], q[1] = q[2], q[2] = q[3], q[3] = t;
	}
	const idx_t one = split_point(edit, q[1], q[2]), two = split_point(edit, q[3], q[0]);
	const idx_t low[4] = {q[0], q[1], one, two}, high[4] = {two, one, q[2], q[3]};
	set_ring(edit, f, low, 4, patch);
	set_ring(edit, edit->count, high, 4, patch);
	spread(edit, q[1], q[2], one);
	/* Unless the strip is closed and has come round to the other edge. */
	if (face_with(edit, q[0], q[3]) != NO_INDEX)
		spread(edit, q[3], q[0], two);
}

static void split_triangle(struct mesh_edit *edit, size_t f)
{
	const idx_t patch = edit->ring[f].patch;
	idx_t c[3];
	memcpy(c, edit->ring[f].corner, sizeof c);
	const double *xyz = edit->draft->control.xyz;
	int longest = 0;
	for (int i = 1; i < 3; i++)
		if (distance3(&xyz[3 * (size_t)c[i]], &xyz[3 * (size_t)c[(i + 1) % 3]]) > distance3(&xyz[3 * (size_t)c[longest]], &xyz[3 * (size_t)c[(longest + 1) % 3]]))
			longest = i;
	const idx_t a = c[longest], b = c[(longest + 1) % 3], o = c[(longest + 2) % 3];
	const idx_t point = split_point(edit, a, b);
	const idx_t one[3] = {a, point, o}, two[3] = {point, b, o};
	set_ring(edit, f, one, 3, patch);
	set_ring(edit, edit->count, two, 3, patch);
	spread(edit, a, b, point);
}

/* A point in the middle, joined to every corner, or to every second one when that gives quads. */
static void star_polygon(struct mesh_edit *edit, size_t f)
{
	const struct ring old = edit->ring[f];
	idx_t *corner = mem_copy(old.corner, old.count, sizeof *corner);
	double centre[3], normal[3];
	polygon_plane(centre, normal, edit->draft->control.xyz, corner, old.count);
	const struct foot foot = foot_of(edit, old.patch, centre);
	const idx_t point = control_add(&edit->draft->control, foot.triangle == NO_INDEX ? centre : foot.point, POINT_INSIDE);
	const size_t stride = old.count >= 6 && old.count % 2 == 0 ? 2 : 1;
	for (size_t i = 0; i < old.count; i += stride) {
		idx_t part[4];
		for (size_t k = 0; k <= stride; k++)
			part[k] = corner[(i + k) % old.count];
		part[stride + 1] = point;
		set_ring(edit, i == 0 ? f : edit->count, part, stride + 2, old.patch);
	}
	free(corner);
}

/* A side of a patch's border: control points a -> b of a face. */
struct side {
	idx_t a, b;
	size_t face;
};

/* All sides of a patch's border (caller frees): edges of its faces between control points of curves that no other face of it has. */
static struct side *border_sides(size_t *count, const struct mesh_edit *edit, idx_t patch)
{
	const unsigned char *role = edit->draft->control.role;
	size_t room = 0;
	for (size_t f = 0; f < edit->count; f++)
		room += edit->ring[f].patch == patch ? edit->ring[f].count : 0;
	struct side *side = mem_array(room, sizeof *side);
	*count = 0;
	for (size_t f = 0; f < edit->count; f++) {
		const struct ring *ring = &edit->ring[f];
		for (size_t i = 0; ring->patch == patch && i < ring->count; i++) {
			const idx_t a = ring->corner[i], b = ring->corner[(i + 1) % ring->count];
			const idx_t across = face_with(edit, b, a);
			if (role[a] != POINT_INSIDE && role[b] != POINT_INSIDE && (across == NO_INDEX || edit->ring[across].patch != patch))
				side[(*count)++] = (struct side){a, b, f};
		}
	}
	return side;
}

static void split_border(struct mesh_edit *edit, const struct side *side)
{
	const idx_t point = split_point(edit, side->a, side->b);
	insert_corner(edit, side->face, side->a, side->b, point);
	spread(edit, side->a, side->b, point);
}

/* Twice the signed area of a, b, c seen along normal. */
static double turn(const double *a, const double *b, const double *c, const double normal[3])
{
	double area[3];
	area_vector3(area, a, b, c);
	return dot3(area, normal);
}

/* Where the control polygons of a plane patch's borders cross, no faces between them can lie flat: the longer side of each
 * crossing pair is split, which draws its polygon towards its curve. Returns how many were. O(sides^2). */
static size_t split_crossings(struct mesh_edit *edit, idx_t patch)
{
	size_t count, steps = 0;
	struct side *side = border_sides(&count, edit, patch);
	unsigned char *split = mem_array(count, 1);
	const double *xyz = edit->draft->control.xyz, *normal = edit->target->dense->patch[patch].axis;
	for (size_t i = 0; i < count; i++)
		for (size_t j = i + 1; j < count; j++) {
			if (side[i].a == side[j].a || side[i].a == side[j].b || side[i].b == side[j].a || side[i].b == side[j].b)
				continue;
			const double *a = &xyz[3 * (size_t)side[i].a], *b = &xyz[3 * (size_t)side[i].b];
			const double *c = &xyz[3 * (size_t)side[j].a], *d = &xyz[3 * (size_t)side[j].b];
			if (turn(a, b, c, normal) * turn(a, b, d, normal) < 0 && turn(c, d, a, normal) * turn(c, d, b, normal) < 0)
				split[distance3(a, b) >= distance3(c, d) ? i : j] = 1;
		}
	for (size_t i = 0; i < count; i++)
		if (split[i]) {
			/* An earlier step may have changed the face. */
			const idx_t face = face_with(edit, side[i].a, side[i].b);
			if (face == NO_INDEX)
				continue;
			side[i].face = (size_t)face;
			edit->split_count = 0;
			split_border(edit, &side[i]);
			steps++;
		}
	free(side), free(split);
	return steps;
}

/* The side of the patch's border nearest to p gets a point. */
static bool split_nearest_side(struct mesh_edit *edit, idx_t patch, const double p[3])
{
	size_t count, best = 0;
	struct side *side = border_sides(&count, edit, patch);
	const double *xyz = edit->draft->control.xyz;
	double least = INFINITY;
	for (size_t i = 0; i < count; i++) {
		double along[3], offset[3];
		sub3(along, &xyz[3 * (size_t)side[i].b], &xyz[3 * (size_t)side[i].a]);
		sub3(offset, p, &xyz[3 * (size_t)side[i].a]);
		const double squared = dot3(along, along);
		const double t = squared > 0 ? fmin(fmax(dot3(offset, along) / squared, 0), 1) : 0;
		add_scaled3(offset, -t, along);
		if (norm3(offset) < least)
			least = norm3(offset), best = i;
	}
	if (count > 0)
		split_border(edit, &side[best]);
	free(side);
	return count > 0;
}

struct pick {
	double error;
	idx_t face;
};

static int worst_first(const void *a, const void *b)
{
	const struct pick *x = a, *y = b;
	return x->error != y->error ? (x->error > y->error ? -1 : 1) : (x->face > y->face) - (x->face < y->face);
}

/* The steps of this round: faces with their error. */
static size_t pick_faces(struct pick *pick, const struct polygons *polygons, const struct patch_error *error, const struct face_error *face_error,
                         const unsigned char *want, double floor)
{
	size_t picks = 0;
	for (size_t f = 0; f < polygons->count; f++) {
		const struct patch_error *patch = &error[polygons->patch[f]];
		bool take = false;
		if (want[polygons->patch[f]] == WANT_INSIDE)
			take = face_error[f].distance > fmin(floor, 0.999 * patch->max) && face_error[f].distance > 0.5 * patch->max;
		else if (want[polygons->patch[f]] == WANT_BORDER)
			take = patch->folded > 0 ? face_error[f].folded > 0 : (idx_t)f == patch->worst_face;
		if (take)
			pick[picks++] = (struct pick){face_error[f].distance, (idx_t)f};
	}
	qsort(pick, picks, sizeof *pick, worst_first);
	return picks;
}

size_t enrich(struct draft *draft, const struct target *target, const struct patch_error *error, const struct face_error *face_error,
              const unsigned char *want, double floor, unsigned char *touched)
{
	struct mesh_edit edit = {.draft = draft, .target = target};
	struct polygons *polygons = &draft->polygons;
	struct pick *pick = mem_array(polygons->count, sizeof *pick);
	const size_t picks = pick_faces(pick, polygons, error, face_error, want, floor);
	for (size_t f = 0; f < polygons->count; f++) {
		set_ring(&edit, f, &polygons->corner[polygons->start[f]], polygons->start[f + 1] - polygons->start[f], polygons->patch[f]);
		edit.ring[f].touched = false;
	}
	size_t steps = 0;
	unsigned char *border_done = mem_array(target->dense->patch_count, 1);
	for (size_t i = 0; i < picks; i++) {
		const size_t f = (size_t)pick[i].face;
		const idx_t p = edit.ring[f].patch;
		edit.split_count = 0;
		if (want[p] == WANT_BORDER) {
			if (border_done[p])
				continue;
			border_done[p] = 1;
			const size_t crossings = is_plane(&edit, p) ? split_crossings(&edit, p) : 0;
			steps += crossings ? crossings : split_nearest_side(&edit, p, error[p].folded > 0 ? error[p].fold_point : error[p].worst_point);
			continue;
		}
		if (edit.ring[f].touched)
			continue;
		if (edit.ring[f].count == 4)
			split_quad(&edit, f);
		else if (edit.ring[f].count == 3)
			split_triangle(&edit, f);
		else
			star_polygon(&edit, f);
		steps++;
	}
	free(pick), free(border_done);
	polygons_free(polygons);
	polygons_init(polygons);
	for (size_t f = 0; f < edit.count; f++) {
		const struct ring *ring = &edit.ring[f];
		polygons_add(polygons, ring->corner, ring->count, ring->patch);
		touched[ring->patch] |= ring->touched;
		free(ring->corner);
	}
	polygons_by_patch(polygons, target->dense->patch_count);
	free(edit.ring), free(edit.edge), free(edit.split);
	return steps;
}
