/* Changes to the polygons of a plot. */
#include "stages/assemble/change.h"

#include <stdlib.h>

#include "stages/geometry/vector.h"

size_t polygon_find(const struct polygon *p, idx_t vertex)
{
	size_t i = 0;
	while (i < p->count && p->corner[i] != vertex)
		i++;
	return i;
}

void polygon_free(struct polygon *p)
{
	free(p->corner), free(p->crease);
	*p = (struct polygon){0};
}

bool polygon_unite(struct polygon *out, const struct polygon *p, const struct polygon *q)
{
	*out = (struct polygon){mem_array(p->count + q->count, sizeof *out->corner), mem_array(p->count + q->count, 1), 0, false, 0};
	size_t i = 0, j = 0;
	bool found = false;
	for (size_t k = 0; k < p->count && !found; k++) {
		j = polygon_find(q, p->corner[polygon_after(p, k)]);
		if (j < q->count && q->corner[polygon_after(q, j)] == p->corner[k])
			found = true, i = k;
	}
	for (size_t k = polygon_after(p, i); found && k != i; k = polygon_after(p, k))
		out->corner[out->count] = p->corner[k], out->crease[out->count++] = p->crease[k];
	for (size_t k = polygon_after(q, j); found && k != j; k = polygon_after(q, k))
		out->corner[out->count] = q->corner[k], out->crease[out->count++] = q->crease[k];
	for (size_t k = 0; k < out->count && found; k++)
		for (size_t l = k + 1; l < out->count && found; l++)
			found = out->corner[k] != out->corner[l];
	if (!found)
		polygon_free(out);
	return found;
}

/* The part of p from corner i on to corner j, closed by a chord. */
static void cut_part(struct polygon *out, const struct polygon *p, size_t i, size_t j, unsigned char crease)
{
	*out = (struct polygon){mem_array(p->count, sizeof *out->corner), mem_array(p->count, 1), 0, false, 0};
	for (size_t k = i;; k = polygon_after(p, k)) {
		out->corner[out->count] = p->corner[k];
		out->crease[out->count++] = k == j ? crease : p->crease[k];
		if (k == j)
			break;
	}
}

void polygon_with(struct polygon *out, const struct polygon *p, size_t i, idx_t v)
{
	*out = (struct polygon){mem_array(p->count + 1, sizeof *out->corner), mem_array(p->count + 1, 1), 0, false, 0};
	for (size_t k = 0; k < p->count; k++) {
		out->corner[out->count] = p->corner[k], out->crease[out->count++] = p->crease[k];
		if (k == i)
			out->corner[out->count] = v, out->crease[out->count++] = p->crease[k];
	}
}

static void middle_of(double middle[3], const struct plot *plot, const struct polygon *p)
{
	middle[0] = middle[1] = middle[2] = 0;
	for (size_t k = 0; k < p->count; k++)
		add_scaled3(middle, 1.0 / (double)p->count, plot->points->xyz + 3 * (size_t)p->corner[k]);
}

/* Parts of the polygons that a change touches. */
struct parts {
	struct polygon item[CHANGE_MOST_CENTRE > 4 ? CHANGE_MOST_CENTRE : 4];
	size_t count;
};

/* p itself, or its two parts beside the chord from corner a to b. */
static void add_parts(struct parts *parts, struct polygon *p, idx_t a, idx_t b, unsigned char crease)
{
	if (b == NO_INDEX) {
		parts->item[parts->count++] = *p;
		return;
	}
	const size_t i = polygon_find(p, a), j = polygon_find(p, b);
	cut_part(&parts->item[parts->count++], p, i, j, crease);
	cut_part(&parts->item[parts->count++], p, j, i, crease);
	polygon_free(p);
}

static bool chord_parts(struct parts *parts, const struct plot *plot, const struct change *change)
{
	const struct polygon *p = &plot->polygon[change->one];
	struct polygon both;
	if (change->two != NO_INDEX) {
		if (!polygon_unite(&both, p, &plot->polygon[change->two]))
			return false;
	} else {
		cut_part(&both, p, 0, p->count - 1, p->crease[p->count - 1]);
	}
	add_parts(parts, &both, change->a, change->a == NO_INDEX ? NO_INDEX : change->b, change->crease);
	if (change->a != NO_INDEX)
		plot->points->creases[change->a] += change->crease, plot->points->creases[change->b] += change->crease;
	return true;
}

static bool split_parts(struct parts *parts, struct plot *plot, const struct change *change)
{
	const struct polygon *p = &plot->polygon[change->one], *q = &plot->polygon[change->two];
	const double *a = plot->points->xyz + 3 * (size_t)change->a, *b = plot->points->xyz + 3 * (size_t)change->b;
	const double at[3] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
	const idx_t m = plot_new_point(plot, at);
	if (m == NO_INDEX)
		return false;
	struct polygon one, two;
	polygon_with(&one, p, polygon_find(p, change->a), m);
	polygon_with(&two, q, polygon_find(q, change->b), m);
	one.crease[polygon_find(&one, change->a)] = change->crease; /* a to m */
	two.crease[polygon_find(&two, m)] = change->crease;         /* m to a */
	add_parts(parts, &one, m, change->c, 0);
	if (parts->count == 2) { /* the second polygon keeps its place */
		struct parts rest = {0};
		add_parts(&rest, &two, m, change->d, 0);
		const struct polygon second = parts->item[1];
		parts->item[1] = rest.item[0];
		parts->item[parts->count++] = second;
		if (rest.count > 1)
			parts->item[parts->count++] = rest.item[1];
	} else {
		add_parts(parts, &two, m, change->d, 0);
	}
	plot->points->creases[change->a] += change->crease, plot->points->creases[m] += change->crease;
	return true;
}

static bool centre_parts(struct parts *parts, struct plot *plot, const struct change *change)
{
	const struct polygon *p = &plot->polygon[change->one];
	double at[3];
	middle_of(at, plot, p);
	const idx_t m = plot_new_point(plot, at);
	if (m == NO_INDEX)
		return false;
	for (size_t k = 0; k < p->count; k++) {
		const size_t next = polygon_after(p, k);
		const idx_t corner[3] = {p->corner[k], p->corner[next], m};
		const unsigned char crease[3] = {p->crease[k], change->crease && corner[1] == change->a, change->crease && corner[0] == change->a};
		parts->item[parts->count++] = (struct polygon){mem_copy(corner, 3, sizeof *corner), mem_copy(crease, 3, 1), 3, false, 0};
	}
	if (change->crease)
		plot->points->creases[change->a]++, plot->points->creases[m]++;
	return true;
}

bool change_apply(struct undo *undo, struct plot *plot, const struct change *change)
{
	struct parts parts = {0};
	*undo = (struct undo){plot->polygon[change->one], {0}, plot->count, plot->points->count};
	if (change->two != NO_INDEX)
		undo->two = plot->polygon[change->two];
	if (!(change->way == WAY_CHORD ? chord_parts(&parts, plot, change) : change->way == WAY_SPLIT ? split_parts(&parts, plot, change) : centre_parts(&parts, plot, change)))
		return false;
	size_t used = 0;
	plot->polygon[change->one] = parts.item[used++];
	if (change->two != NO_INDEX)
		plot->polygon[change->two] = used < parts.count ? parts.item[used++] : (struct polygon){0};
	for (; used < parts.count; used++) {
		plot_add(plot, parts.item[used].corner, parts.item[used].crease, parts.item[used].count, false);
		polygon_free(&parts.item[used]);
	}
	return true;
}

void change_take_back(const struct undo *undo, struct plot *plot, const struct change *change)
{
	polygon_free(&plot->polygon[change->one]);
	plot->polygon[change->one] = undo->one;
	if (change->two != NO_INDEX) {
		polygon_free(&plot->polygon[change->two]);
		plot->polygon[change->two] = undo->two;
	}
	while (plot->count > undo->count)
		polygon_free(&plot->polygon[--plot->count]);
	plot->points->count = undo->points;
	if (change->a != NO_INDEX)
		plot->points->creases[change->a] -= change->crease;
	if (change->a != NO_INDEX && change->way == WAY_CHORD)
		plot->points->creases[change->b] -= change->crease;
}

size_t change_made(idx_t made[CHANGE_MOST_CORE], const struct plot *plot, const struct undo *undo, const struct change *change)
{
	size_t count = 0;
	made[count++] = change->one;
	if (change->two != NO_INDEX)
		made[count++] = change->two;
	for (size_t i = undo->count; i < plot->count; i++)
		made[count++] = (idx_t)i;
	return count;
}

