/* Cutting free-form regions into compact pieces of moderate turn. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/geometry/vector.h"
#include "stages/segment/free_charts.h"

#define LLOYD_ITERATIONS 6
#define PLACE_WEIGHT 0.35   /* squared distance to the piece's centre over the region's extent, against squared normal difference:
                               keeps pieces compact where normals alone do not decide */

struct proxy {
	double normal[3], centre[3], area;
};

struct flood_entry {
	double cost;
	idx_t triangle;
	int proxy;
};

struct cutter {
	const struct facets *facets;
	struct regions *regions;
	struct flood_entry *heap;
	size_t heap_count, heap_capacity;
	signed char *side;        /* a triangle: proxy that took it, -1 */
};

static bool comes_before(const struct flood_entry *a, const struct flood_entry *b)
{
	if (a->cost != b->cost)
		return a->cost < b->cost;
	return a->triangle != b->triangle ? a->triangle < b->triangle : a->proxy < b->proxy;
}

static void push(struct cutter *c, struct flood_entry entry)
{
	if (c->heap_count == c->heap_capacity) {
		c->heap_capacity = c->heap_capacity ? 2 * c->heap_capacity : 256;
		c->heap = mem_resize(c->heap, c->heap_capacity, sizeof *c->heap);
	}
	size_t i = c->heap_count++;
	while (i && comes_before(&entry, &c->heap[(i - 1) / 2])) {
		c->heap[i] = c->heap[(i - 1) / 2];
		i = (i - 1) / 2;
	}
	c->heap[i] = entry;
}

static struct flood_entry pop(struct cutter *c)
{
	const struct flood_entry top = c->heap[0], last = c->heap[--c->heap_count];
	size_t i = 0;
	for (;;) {
		size_t child = 2 * i + 1;
		if (child >= c->heap_count)
			break;
		if (child + 1 < c->heap_count && comes_before(&c->heap[child + 1], &c->heap[child]))
			child++;
		if (!comes_before(&c->heap[child], &last))
			break;
		c->heap[i] = c->heap[child];
		i = child;
	}
	if (c->heap_count)
		c->heap[i] = last;
	return top;
}

static double chart_cost(const struct facets *f, const struct proxy *p, double extent, idx_t t)
{
	const double d = distance3(f->normal + 3 * t, p->normal), e = distance3(f->centroid + 3 * t, p->centre) / extent;
	return d * d + PLACE_WEIGHT * e * e;
}

static void measure_proxy(struct proxy *p, const struct facets *f, const idx_t *part, size_t count, const signed char *side, int which)
{
	*p = (struct proxy){{0}, {0}, 0};
	for (size_t i = 0; i < count; i++) {
		if (side && side[part[i]] != which)
			continue;
		add_scaled3(p->normal, f->area[part[i]], f->normal + 3 * part[i]);
		add_scaled3(p->centre, f->area[part[i]], f->centroid + 3 * part[i]);
		p->area += f->area[part[i]];
	}
	if (p->area > 0)
		scale3(p->centre, 1 / p->area);
}

/* Triangle of the part that costs least (or most) for a proxy. */
static idx_t extreme(const struct facets *f, const struct proxy *p, double extent, const idx_t *part, size_t count, const signed char *side, int which, double sign)
{
	idx_t best = part[0];
	double least = INFINITY;
	for (size_t i = 0; i < count; i++) {
		if (side && side[part[i]] != which)
			continue;
		const double cost = sign * chart_cost(f, p, extent, part[i]);
		if (cost < least)
			least = cost, best = part[i];
	}
	return best;
}

/* Grow both proxies over the region from their seeds, cheapest triangle first. */
static void flood(struct cutter *c, const struct proxy proxy[2], double extent, const idx_t seed[2], const idx_t *part, size_t count)
{
	const struct facets *f = c->facets;
	const idx_t label = c->regions->label[part[0]];
	for (size_t i = 0; i < count; i++)
		c->side[part[i]] = -1;
	c->heap_count = 0;
	for (int k = 0; k < 2; k++)
		push(c, (struct flood_entry){0, seed[k], k});
	while (c->heap_count) {
		const struct flood_entry e = pop(c);
		if (c->side[e.triangle] >= 0)
			continue;
		c->side[e.triangle] = (signed char)e.proxy;
		for (int k = 0; k < 3; k++) {
			const idx_t h = 3 * e.triangle + k, to = f->neighbour[h];
			if (f->is_sharp[h] || c->regions->label[to] != label || c->side[to] >= 0)
				continue;
			push(c, (struct flood_entry){chart_cost(f, &proxy[e.proxy], extent, to), to, e.proxy});
		}
	}
}

/* Cut one region in two; false when there is nothing to cut. side tells the halves. */
static bool bisect(struct cutter *c, const idx_t *part, size_t count)
{
	const struct facets *f = c->facets;
	struct proxy whole, proxy[2];
	if (count < 2)
		return false;
	measure_proxy(&whole, f, part, count, NULL, 0);
	normalise3(whole.normal);
	double extent = 0;
	for (size_t i = 0; i < count; i++)
		extent = fmax(extent, distance3(f->centroid + 3 * part[i], whole.centre));
	if (!(extent > 0))
		return false;
	idx_t seed[2];
	seed[0] = extreme(f, &whole, extent, part, count, NULL, 0, -1);
	for (int k = 0; k < 2; k++) {
		copy3(proxy[k].normal, f->normal + 3 * seed[0]);
		copy3(proxy[k].centre, f->centroid + 3 * seed[0]);
		if (k == 0)
			seed[1] = extreme(f, &proxy[0], extent, part, count, NULL, 0, -1);
	}
	copy3(proxy[1].normal, f->normal + 3 * seed[1]);
	copy3(proxy[1].centre, f->centroid + 3 * seed[1]);
	if (seed[0] == seed[1])
		return false;
	for (int i = 0; i < LLOYD_ITERATIONS; i++) {
		flood(c, proxy, extent, seed, part, count);
		const idx_t old[2] = {seed[0], seed[1]};
		for (int k = 0; k < 2; k++) {
			measure_proxy(&proxy[k], f, part, count, c->side, k);
			normalise3(proxy[k].normal);
			seed[k] = extreme(f, &proxy[k], extent, part, count, c->side, k, 1);
		}
		if (old[0] == seed[0] && old[1] == seed[1])
			break;
	}
	return true;
}

struct job {
	double badness;
	idx_t region;
	idx_t *part;
	size_t count;
};

/* How much a region needs a cut: its area times how short its mean normal is; 0 when it needs none. */
static double badness_of(const struct facets *f, const struct chart_options *o, const idx_t *part, size_t count)
{
	struct proxy p;
	measure_proxy(&p, f, part, count, NULL, 0);
	if (p.area < 2 * o->least_area || !(p.area > 0))
		return 0;
	const double mean = norm3(p.normal) / p.area;
	return mean >= o->least_mean ? 0 : p.area * (1 - mean);
}

size_t free_charts(struct regions *r, const struct chart_options *o)
{
	const struct facets *f = r->facets;
	struct cutter c = {.facets = f, .regions = r, .side = mem_array(f->triangle_count, 1)};
	size_t *start, cuts = 0, jobs = 0, capacity = 64, pieces = 0;
	idx_t *member;
	struct job *job = mem_array(capacity, sizeof *job);
	regions_members(r, &start, &member);
	const size_t first_count = r->count;
	for (size_t i = 0; i < first_count; i++) {
		const size_t count = start[i + 1] - start[i];
		if (r->patch[i].kind != PATCH_FREE || !count)
			continue;
		pieces++;
		const double badness = badness_of(f, o, member + start[i], count);
		if (!(badness > 0))
			continue;
		if (jobs == capacity)
			job = mem_resize(job, capacity *= 2, sizeof *job);
		job[jobs++] = (struct job){badness, (idx_t)i, mem_copy(member + start[i], count, sizeof *member), count};
	}
	while (jobs) {
		size_t worst = 0;
		for (size_t i = 1; i < jobs; i++)
			if (job[i].badness > job[worst].badness || (job[i].badness == job[worst].badness && job[i].region < job[worst].region))
				worst = i;
		const struct job now = job[worst];
		job[worst] = job[--jobs];
		if (pieces < o->pieces_most && bisect(&c, now.part, now.count)) {
			const struct dense_patch copy = r->patch[now.region];
			const idx_t fresh = regions_add(r, &copy);
			idx_t *half[2] = {mem_array(now.count, sizeof *member), mem_array(now.count, sizeof *member)};
			size_t count[2] = {0, 0};
			for (size_t i = 0; i < now.count; i++) {
				const int k = c.side[now.part[i]] == 1;
				half[k][count[k]++] = now.part[i];
				if (k)
					r->label[now.part[i]] = fresh;
			}
			pieces++;
			cuts++;
			for (int k = 0; k < 2; k++) {
				const double badness = badness_of(f, o, half[k], count[k]);
				if (!(badness > 0)) {
					free(half[k]);
					continue;
				}
				if (jobs == capacity)
					job = mem_resize(job, capacity *= 2, sizeof *job);
				job[jobs++] = (struct job){badness, k ? fresh : now.region, half[k], count[k]};
			}
		}
		free(now.part);
	}
	free(job);
	free(start);
	free(member);
	free(c.heap);
	free(c.side);
	return cuts;
}
