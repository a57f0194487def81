/* Coherency of control edges with the surface under them. */
#include "stages/fitpatch/chord.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/fitpatch/frame.h"
#include "stages/geometry/vector.h"

/* A hash set of pairs, and one with values: open addressing, power of two. */
struct slot {
	idx_t a, b; /* a < b; a NO_INDEX: empty */
	double value;
};

struct edge_set {
	struct slot *slot;
	size_t room, count;
};

/* Height over longest side of a triangle that is as good as a line. */
static const double flat_height = 1e-3;

static size_t slot_hash(idx_t a, idx_t b, size_t room)
{
	uint64_t x = ((uint64_t)(uint32_t)a << 32) | (uint32_t)b;
	x *= 0x9e3779b97f4a7c15u; /* Fibonacci hashing */
	return (size_t)(x >> 20) & (room - 1);
}

static struct slot *slot_find(const struct edge_set *set, idx_t a, idx_t b)
{
	size_t i = slot_hash(a, b, set->room);
	while (set->slot[i].a != NO_INDEX && (set->slot[i].a != a || set->slot[i].b != b))
		i = (i + 1) & (set->room - 1);
	return &set->slot[i];
}

static void set_make(struct edge_set *set, size_t room)
{
	*set = (struct edge_set){.slot = mem_array(room, sizeof *set->slot), .room = room};
	for (size_t i = 0; i < room; i++)
		set->slot[i].a = NO_INDEX;
}

static struct slot *set_put(struct edge_set *set, idx_t a, idx_t b)
{
	if (2 * (set->count + 1) > set->room) {
		struct edge_set larger;
		set_make(&larger, 2 * set->room);
		for (size_t i = 0; i < set->room; i++)
			if (set->slot[i].a != NO_INDEX)
				*slot_find(&larger, set->slot[i].a, set->slot[i].b) = set->slot[i];
		larger.count = set->count;
		free(set->slot);
		*set = larger;
	}
	struct slot *slot = slot_find(set, a, b);
	if (slot->a == NO_INDEX) {
		slot->a = a, slot->b = b;
		set->count++;
	}
	return slot;
}

struct edge_set *edge_set_new(void)
{
	struct edge_set *set = mem_array(1, sizeof *set);
	set_make(set, 64);
	return set;
}

void edge_set_free(struct edge_set *set)
{
	if (set)
		free(set->slot);
	free(set);
}

bool edge_set_has(const struct edge_set *set, idx_t a, idx_t b)
{
	return slot_find(set, a < b ? a : b, a < b ? b : a)->a != NO_INDEX;
}

void edge_set_add(struct edge_set *set, idx_t a, idx_t b) { set_put(set, a < b ? a : b, a < b ? b : a); }

struct chord_cache {
	struct edge_set pairs;
};

void chord_open(struct chord_context *context)
{
	context->cache = mem_array(1, sizeof *context->cache);
	set_make(&context->cache->pairs, 256);
}

void chord_close(struct chord_context *context)
{
	free(context->cache->pairs.slot);
	free(context->cache);
	context->cache = NULL;
}

static struct foot foot_on_patch(const struct chord_context *context, const double p[3])
{
	return frame_foot(context->nearest, context->dense, context->patch, p);
}

/* SC = min(sum a theta_min, sum a theta_max) / sum a over samples of the chord laid on the surface (its feet stand for the
 * geodesic: they bend the same way, and cost one query each). theta_min + theta_max = 90 degrees after projection. */
static double score(const struct chord_context *context, const double a[3], const double b[3])
{
	enum { SAMPLES = 4 };
	double chord[3], along = 0, across = 0, weight = 0, off = 0;
	sub3(chord, b, a);
	const double length = norm3(chord);
	if (!(length > 0))
		return 90;
	for (int i = 1; i <= SAMPLES; i++) {
		double p[3];
		copy3(p, a);
		add_scaled3(p, (double)i / (SAMPLES + 1), chord);
		const struct foot foot = foot_on_patch(context, p);
		if (foot.triangle == NO_INDEX)
			continue;
		off = fmax(off, foot.distance);
		if (context->is_plane)
			continue;
		struct frame frame;
		frame_at(&frame, context->dense, &foot);
		double flat[3];
		copy3(flat, chord);
		add_scaled3(flat, -dot3(flat, frame.normal), frame.normal);
		double theta = angle3(flat, frame.e1) * DEGREES;
		theta = theta > 90 ? 180 - theta : theta;
		along += frame.anisotropy * theta;
		across += frame.anisotropy * (90 - theta);
		weight += frame.anisotropy;
	}
	const double coherency = weight > 0.05 * SAMPLES ? fmin(along, across) / weight : 22.5;
	/* A chord that cuts a tenth of its length deep leaves the surface: it runs across the direction of bending. */
	return coherency + 10 * length / context->diameter + 45 * fmin(1, off / (0.1 * length));
}

double chord_cost(void *opaque, idx_t a, idx_t b)
{
	struct chord_context *context = opaque;
	const struct sheet *sheet = context->sheet;
	const idx_t p = sheet->point[a], q = sheet->point[b];
	if (p != NO_INDEX && q != NO_INDEX && (p == q || edge_set_has(context->taken, p, q)))
		return INFINITY;
	const idx_t low = a < b ? a : b, high = a < b ? b : a;
	struct slot *slot = slot_find(&context->cache->pairs, low, high);
	if (slot->a == NO_INDEX) {
		const double value = score(context, &sheet->xyz[3 * (size_t)low], &sheet->xyz[3 * (size_t)high]);
		slot = set_put(&context->cache->pairs, low, high);
		slot->value = value;
	}
	return slot->value;
}

/* Where the control point is that a vertex stands for; points inside a patch are still where the surface is. */
static const double *control_of(const struct chord_context *context, idx_t vertex)
{
	const idx_t point = context->sheet->point[vertex];
	return point == NO_INDEX ? &context->sheet->xyz[3 * (size_t)vertex] : &context->control[3 * (size_t)point];
}

double chord_triangle_cost(void *opaque, idx_t a, idx_t b, idx_t c)
{
	const struct chord_context *context = opaque;
	const double *p = &context->sheet->xyz[3 * (size_t)a], *q = &context->sheet->xyz[3 * (size_t)b], *r = &context->sheet->xyz[3 * (size_t)c];
	double normal[3], centre[3], outer[3];
	area_vector3(normal, p, q, r);
	const double doubled = normalise3(normal);
	const double longest = fmax(distance3(p, q), fmax(distance3(q, r), distance3(r, p)));
	for (int k = 0; k < 3; k++)
		centre[k] = (p[k] + q[k] + r[k]) / 3;
	const struct foot foot = foot_on_patch(context, centre);
	area_vector3(outer, control_of(context, a), control_of(context, b), control_of(context, c));
	normalise3(outer);
	const double turn = foot.triangle == NO_INDEX || doubled <= 0 ? 0 : fmin(dot3(foot.normal, normal), dot3(foot.normal, outer));
	const double fold = turn < 0.3 ? 1000 * (0.3 - turn) : 0;
	const double height = longest > 0 ? doubled / longest / longest : 0; /* relative; 0.87 for an equilateral triangle */
	/* A triangle without height has an edge on its neighbour's two: refined, they are one. */
	return fold + (height < 0.1 ? 20 * (1 - height / 0.1) : 0) + (height < flat_height ? 500 : 0);
}
