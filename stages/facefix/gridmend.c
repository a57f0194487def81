/* Mending a rounded cage by single steps (patch method, section 12.4: what the grid must keep). All tests of direction and place are exact,
 * in integers. */
#include "stages/facefix/gridmend.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/facefix/gridfit.h"
#include "stages/geometry/vector.h"

#define PASSES 8
#define FAR_LIMIT 2 /* steps from the exact value, each coordinate */

/* Edges and faces around each vertex, in compressed rows, and the vertices at each grid point in chains of a hash table. */
struct around {
	const struct cage *cage;
	struct ffx *ffx;
	size_t *ring_start; /* vertex_count + 1 */
	idx_t *ring;        /* the vertices at the other end of its edges, rising */
	idx_t *tip;         /* 2 an entry of ring: the ends before and after it, seen from outside; -1 beyond a border */
	size_t *face_start; /* vertex_count + 1 */
	idx_t *face;
	idx_t *head, *next; /* next[v]: another vertex in the same slot, -1 at the end */
	size_t slots;       /* power of 2 */
	struct ray *ray;    /* room for the largest ring */
	double small;
};

struct ray {
	int64_t to[3]; /* without common divisor */
	idx_t end;
};

static int compare_indices(const void *left, const void *right)
{
	const idx_t a = *(const idx_t *)left, b = *(const idx_t *)right;
	return (a > b) - (a < b);
}

static int compare_rays(const void *left, const void *right)
{
	const struct ray *a = left, *b = right;
	for (int k = 0; k < 3; k++)
		if (a->to[k] != b->to[k])
			return a->to[k] < b->to[k] ? -1 : 1;
	return (a->end > b->end) - (a->end < b->end);
}

static size_t slot_of(const struct around *m, const int32_t *at)
{
	uint64_t hash = 0;
	for (int k = 0; k < 3; k++)
		hash = (hash ^ (uint32_t)at[k]) * 0x9e3779b97f4a7c15u;
	return (hash >> 32) & (m->slots - 1);
}

static void link_vertex(struct around *m, idx_t v)
{
	const size_t slot = slot_of(m, m->ffx->grid + 3 * (size_t)v);
	m->next[v] = m->head[slot];
	m->head[slot] = v;
}

static void unlink_vertex(struct around *m, idx_t v)
{
	idx_t *at = &m->head[slot_of(m, m->ffx->grid + 3 * (size_t)v)];
	while (*at != v)
		at = &m->next[*at];
	*at = m->next[v];
}

static size_t ring_index(const struct around *m, idx_t v, idx_t end)
{
	const idx_t *first = m->ring + m->ring_start[v];
	return (const idx_t *)bsearch(&end, first, m->ring_start[v + 1] - m->ring_start[v], sizeof end, compare_indices) - m->ring;
}

static void around_build(struct around *m, struct ffx *ffx, const struct cage *cage, double small)
{
	const size_t vertices = cage->vertex_count, corners = cage->face_start[cage->face_count];
	*m = (struct around){.cage = cage, .ffx = ffx, .small = small, .slots = 16};
	m->ring_start = mem_array(vertices + 1, sizeof *m->ring_start);
	m->face_start = mem_array(vertices + 1, sizeof *m->face_start);
	m->face = mem_array(corners + 1, sizeof *m->face);
	m->ring = mem_array(2 * corners + 1, sizeof *m->ring);
	size_t *fill = mem_array(vertices + 1, sizeof *fill);
	for (size_t h = 0; h < corners; h++)
		m->face_start[cage->face_corner[h] + 1]++;
	for (size_t v = 0; v < vertices; v++)
		m->face_start[v + 1] += m->face_start[v];
	for (size_t f = 0; f < cage->face_count; f++) {
		const idx_t *corner = cage->face_corner + cage->face_start[f];
		const size_t n = cage->face_start[f + 1] - cage->face_start[f];
		for (size_t i = 0; i < n; i++) {
			const size_t v = corner[i], at = m->face_start[v] + fill[v]++;
			m->face[at] = (idx_t)f;
			m->ring[2 * at] = corner[(i + 1) % n];
			m->ring[2 * at + 1] = corner[(i + n - 1) % n];
		}
	}
	free(fill);
	size_t count = 0, longest = 0;
	for (size_t v = 0; v < vertices; v++) {
		const size_t from = 2 * m->face_start[v], to = 2 * m->face_start[v + 1];
		m->ring_start[v] = count;
		qsort(m->ring + from, to - from, sizeof *m->ring, compare_indices);
		for (size_t i = from; i < to; i++)
			if (i == from || m->ring[i] != m->ring[i - 1])
				m->ring[count++] = m->ring[i]; /* never ahead of what is read */
		longest = count - m->ring_start[v] > longest ? count - m->ring_start[v] : longest;
	}
	m->ring_start[vertices] = count;
	m->ray = mem_array(longest + 1, sizeof *m->ray);
	m->tip = mem_array(2 * count + 1, sizeof *m->tip);
	memset(m->tip, 0xff, 2 * count * sizeof *m->tip);
	for (size_t f = 0; f < cage->face_count; f++) {
		const idx_t *corner = cage->face_corner + cage->face_start[f];
		const size_t n = cage->face_start[f + 1] - cage->face_start[f];
		for (size_t i = 0; i < n; i++) {
			const idx_t after = corner[(i + 1) % n], before = corner[(i + n - 1) % n];
			m->tip[2 * ring_index(m, corner[i], after)] = before;
			m->tip[2 * ring_index(m, corner[i], before) + 1] = after;
		}
	}
	while (m->slots < 2 * vertices)
		m->slots *= 2;
	m->head = mem_array(m->slots, sizeof *m->head);
	m->next = mem_array(vertices, sizeof *m->next);
	memset(m->head, 0xff, m->slots * sizeof *m->head);
	for (size_t v = 0; v < vertices; v++)
		link_vertex(m, (idx_t)v);
}

static void around_free(struct around *m)
{
	free(m->ring_start);
	free(m->ring);
	free(m->tip);
	free(m->face_start);
	free(m->face);
	free(m->head);
	free(m->next);
	free(m->ray);
}

static bool were_apart(const struct around *m, idx_t a, idx_t b)
{
	return distance3(m->cage->xyz + 3 * (size_t)a, m->cage->xyz + 3 * (size_t)b) > 0;
}

static bool at_one_point(const struct around *m, idx_t a, idx_t b)
{
	return memcmp(m->ffx->grid + 3 * (size_t)a, m->ffx->grid + 3 * (size_t)b, 3 * sizeof *m->ffx->grid) == 0;
}

/* Another vertex at the point of v that was elsewhere, -1 when there is none; *count gets how many. */
static idx_t company(size_t *count, const struct around *m, idx_t v)
{
	idx_t found = -1;
	for (idx_t u = m->head[slot_of(m, m->ffx->grid + 3 * (size_t)v)]; u >= 0; u = m->next[u])
		if (u != v && at_one_point(m, u, v) && were_apart(m, u, v)) {
			found = u;
			++*count;
		}
	return found;
}

static void edge_vector(int64_t out[3], const struct around *m, idx_t from, idx_t to)
{
	for (int k = 0; k < 3; k++)
		out[k] = (int64_t)m->ffx->grid[3 * (size_t)to + k] - m->ffx->grid[3 * (size_t)from + k];
}

static int64_t common_divisor(int64_t a, int64_t b)
{
	a = a < 0 ? -a : a;
	b = b < 0 ? -b : b;
	while (b) {
		const int64_t rest = a % b;
		a = b;
		b = rest;
	}
	return a;
}

/* Pairs of edges at v in one direction; the ends of the last pair go to pair (may be NULL). Edges without length are left to
 * company(). */
static size_t pairs_at(struct around *m, idx_t v, idx_t pair[2])
{
	size_t rays = 0, count = 0;
	for (size_t i = m->ring_start[v]; i < m->ring_start[v + 1]; i++) {
		struct ray *ray = &m->ray[rays];
		ray->end = m->ring[i];
		edge_vector(ray->to, m, v, ray->end);
		const int64_t divisor = common_divisor(common_divisor(ray->to[0], ray->to[1]), ray->to[2]);
		if (divisor == 0)
			continue;
		for (int k = 0; k < 3; k++)
			ray->to[k] /= divisor;
		rays++;
	}
	qsort(m->ray, rays, sizeof *m->ray, compare_rays);
	for (size_t i = 1; i < rays; i++)
		if (memcmp(m->ray[i].to, m->ray[i - 1].to, sizeof m->ray[i].to) == 0 && were_apart(m, m->ray[i].end, m->ray[i - 1].end)) {
			count++;
			if (pair) {
				pair[0] = m->ray[i - 1].end;
				pair[1] = m->ray[i].end;
			}
		}
	return count;
}

/* Edges at a that leave in the direction of its edge to v. */
static size_t pairs_with(const struct around *m, idx_t a, idx_t v)
{
	int64_t to[3], other[3];
	size_t count = 0;
	edge_vector(to, m, a, v);
	for (size_t i = m->ring_start[a]; i < m->ring_start[a + 1]; i++) {
		if (m->ring[i] == v)
			continue;
		edge_vector(other, m, a, m->ring[i]);
		/* Components are below 2^16: products fit. */
		count += to[1] * other[2] == to[2] * other[1] && to[2] * other[0] == to[0] * other[2] &&
			 to[0] * other[1] == to[1] * other[0] && to[0] * other[0] + to[1] * other[1] + to[2] * other[2] > 0 &&
			 were_apart(m, v, m->ring[i]);
	}
	return count;
}

static void cross_exact(int64_t out[3], const int64_t a[3], const int64_t b[3])
{
	for (int k = 0; k < 3; k++)
		out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Do the faces at edge i of the rings, which is one of v, lie on each other in one plane? */
static bool is_folded(const struct around *m, idx_t v, size_t i)
{
	const idx_t *tip = m->tip + 2 * i;
	if (tip[0] < 0 || tip[1] < 0 || tip[0] == tip[1])
		return false;
	int64_t along[3], arm[2][3], normal[2][3];
	edge_vector(along, m, v, m->ring[i]);
	for (int side = 0; side < 2; side++) {
		edge_vector(arm[side], m, v, tip[side]);
		cross_exact(normal[side], along, arm[side]);
	}
	/* Below 2^51. */
	if (normal[0][0] * arm[1][0] + normal[0][1] * arm[1][1] + normal[0][2] * arm[1][2] != 0)
		return false;
	for (int k = 0; k < 3; k++)
		if (normal[0][k] != 0) /* parallel to the other one: the same way? */
			return (normal[0][k] > 0) == (normal[1][k] > 0) && normal[1][k] != 0;
	return false; /* without area: seen by pairs_at, or harmless */
}

/* Where v is an end or a tip at a. */
static size_t folds_with(const struct around *m, idx_t a, idx_t v)
{
	size_t count = 0;
	for (size_t i = m->ring_start[a]; i < m->ring_start[a + 1]; i++)
		if (m->ring[i] == v || m->tip[2 * i] == v || m->tip[2 * i + 1] == v)
			count += is_folded(m, a, i);
	return count;
}

/* Folded edges of v; *last gets the last one. */
static size_t folds_at(const struct around *m, idx_t v, size_t *last)
{
	size_t count = 0;
	for (size_t i = m->ring_start[v]; i < m->ring_start[v + 1]; i++)
		if (is_folded(m, v, i)) {
			count++;
			*last = i;
		}
	return count;
}

/* What is wrong at v. */
static size_t wrong_at(struct around *m, idx_t v)
{
	size_t last, count = pairs_at(m, v, NULL) + folds_at(m, v, &last);
	company(&count, m, v);
	return count;
}

/* What a move of v can change. */
static size_t wrong_around(struct around *m, idx_t v)
{
	size_t count = wrong_at(m, v);
	for (size_t i = m->ring_start[v]; i < m->ring_start[v + 1]; i++)
		count += pairs_with(m, m->ring[i], v) + folds_with(m, m->ring[i], v);
	return count;
}

static size_t turned_around(const struct around *m, idx_t v)
{
	size_t count = 0;
	for (size_t i = m->face_start[v]; i < m->face_start[v + 1]; i++)
		count += gridfit_turned_corners(m->cage, m->ffx, (size_t)m->face[i], m->small);
	return count;
}

static double distance_from_exact(const struct ffx *ffx, const struct cage *cage, idx_t v)
{
	double sum = 0;
	for (int k = 0; k < 3; k++) {
		const size_t i = 3 * (size_t)v + k;
		const double off = gridfit_exact(cage, ffx, i) - ffx->grid[i];
		if (fabs(off) >= FAR_LIMIT)
			return INFINITY;
		sum += off * off;
	}
	return sum;
}

struct move {
	idx_t vertex;
	int32_t to[3];
	size_t wrong;
	double far;
};

/* The best move of v, when it is better than *best. */
static void try_vertex(struct move *best, struct around *m, idx_t v)
{
	struct ffx *ffx = m->ffx;
	int32_t *at = ffx->grid + 3 * (size_t)v;
	const int32_t steps = ffx_grid_steps(ffx->grid_code), home[3] = {at[0], at[1], at[2]};
	const size_t wrong_before = wrong_around(m, v), turned_before = turned_around(m, v);
	for (int way = 0; way < 27; way++) {
		const int32_t to[3] = {home[0] + way % 3 - 1, home[1] + way / 3 % 3 - 1, home[2] + way / 9 - 1};
		bool is_inside = way != 13; /* 13: stays */
		for (int k = 0; k < 3; k++)
			is_inside = is_inside && to[k] >= 0 && to[k] <= steps;
		if (!is_inside)
			continue;
		unlink_vertex(m, v);
		memcpy(at, to, sizeof to);
		link_vertex(m, v);
		const double far = distance_from_exact(ffx, m->cage, v);
		if (far < INFINITY) {
			const size_t wrong = wrong_around(m, v);
			if (wrong < wrong_before && (wrong < best->wrong || (wrong == best->wrong && far < best->far)) &&
			    turned_around(m, v) <= turned_before) {
				*best = (struct move){.vertex = v, .wrong = wrong, .far = far};
				memcpy(best->to, to, sizeof to);
			}
		}
		unlink_vertex(m, v);
		memcpy(at, home, sizeof home);
		link_vertex(m, v);
	}
}

/* One move for the first thing that is wrong at v. */
static bool mend_at(struct around *m, idx_t v)
{
	size_t count = 0, i_folded;
	idx_t at_fault[4] = {v, -1, -1, -1};
	if (pairs_at(m, v, at_fault + 1) == 0) {
		at_fault[1] = company(&count, m, v);
		if (count == 0 && folds_at(m, v, &i_folded) > 0) {
			at_fault[1] = m->ring[i_folded];
			at_fault[2] = m->tip[2 * i_folded];
			at_fault[3] = m->tip[2 * i_folded + 1];
		}
	}
	struct move best = {.vertex = -1, .wrong = SIZE_MAX};
	for (int i = 0; i < 4; i++)
		if (at_fault[i] >= 0)
			try_vertex(&best, m, at_fault[i]);
	if (best.vertex < 0)
		return false;
	unlink_vertex(m, best.vertex);
	memcpy(m->ffx->grid + 3 * (size_t)best.vertex, best.to, sizeof best.to);
	link_vertex(m, best.vertex);
	return true;
}

static size_t count_all(struct around *m)
{
	size_t count = 0;
	for (size_t v = 0; v < m->cage->vertex_count; v++)
		count += wrong_at(m, (idx_t)v);
	return count;
}

size_t gridmend_count(const struct ffx *ffx, const struct cage *cage)
{
	struct around m;
	around_build(&m, (struct ffx *)ffx, cage, 0); /* nothing is moved */
	const size_t count = count_all(&m);
	around_free(&m);
	return count;
}

void gridmend(struct ffx *ffx, struct gridmend_report *report, const struct cage *cage, double small)
{
	*report = (struct gridmend_report){0};
	struct around m;
	around_build(&m, ffx, cage, small);
	report->found = report->left = count_all(&m);
	for (int pass = 0; pass < PASSES && report->left > 0; pass++) {
		size_t moved = 0;
		for (size_t v = 0; v < cage->vertex_count; v++)
			moved += wrong_at(&m, (idx_t)v) > 0 && mend_at(&m, (idx_t)v);
		report->left = count_all(&m);
		report->moved += moved;
		if (moved == 0)
			break;
	}
	around_free(&m);
}
