/* Makes cages to train the FFX coder on from dense meshes: like those that polish ends with.
 *
 *	build/corpus FOLDER mesh.stl ...
 *
 * Each mesh is simplified by edge collapses with quadrics (Garland and Heckbert 1997) to about 40, 60, 90 and 140 vertices. Then
 * neighbouring faces that are nearly in a plane are merged to polygons, vertices inside straight edges go, coordinates that
 *nearly agree are made equal, as a search for few bytes would do, and edges that bend become sharp. Writes
 *FOLDER/name-vertices.ply. */
#include <stdio.h>

#include "formats/mesh.h"
#include "formats/output.h"
#include "formats/ply.h"
#include "tests/fixtures/samplecages.h"

#define FACE_LIMIT 60000 /* larger meshes are left out: this is no fast simplifier */

struct ring {
	idx_t *face;
	size_t count, room;
};

struct simple {
	size_t vertex_count, face_count, alive_vertices;
	double *xyz;
	double (*quadric)[10];
	idx_t (*corner)[3]; /* NO_INDEX in corner[f][0]: gone */
	struct ring *ring;
	unsigned *version; /* a vertex: changes since the start */
};

static void ring_add(struct ring *ring, idx_t face)
{
	if (ring->count == ring->room) {
		ring->room = ring->room ? 2 * ring->room : 8;
		ring->face = mem_resize(ring->face, ring->room, sizeof(idx_t));
	}
	ring->face[ring->count++] = face;
}

static double normal_of(double n[3], const double *a, const double *b, const double *c)
{
	double u[3], v[3];
	for (int k = 0; k < 3; k++)
		u[k] = b[k] - a[k], v[k] = c[k] - a[k];
	for (int k = 0; k < 3; k++)
		n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
	const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
	for (int k = 0; k < 3; k++)
		n[k] /= length > 0 ? length : 1;
	return length / 2;
}

static void add_plane(double q[10], const double n[3], const double *at, double weight)
{
	const double p[4] = {n[0], n[1], n[2], -(n[0] * at[0] + n[1] * at[1] + n[2] * at[2])};
	for (int i = 0, m = 0; i < 4; i++)
		for (int j = i; j < 4; j++, m++)
			q[m] += weight * p[i] * p[j];
}

static double quadric_at(const double q[10], const double *x)
{
	return q[0] * x[0] * x[0] + 2 * q[1] * x[0] * x[1] + 2 * q[2] * x[0] * x[2] + 2 * q[3] * x[0] + q[4] * x[1] * x[1] +
	       2 * q[5] * x[1] * x[2] + 2 * q[6] * x[1] + q[7] * x[2] * x[2] + 2 * q[8] * x[2] + q[9];
}

/* Where the edge a b collapses to, and what that costs. */
static double best_place(double out[3], const struct simple *s, idx_t a, idx_t b)
{
	double q[10];
	for (int i = 0; i < 10; i++)
		q[i] = s->quadric[a][i] + s->quadric[b][i];
	const double *p[2] = {s->xyz + 3 * (size_t)a, s->xyz + 3 * (size_t)b};
	double middle[3], best = HUGE_VAL;
	for (int k = 0; k < 3; k++)
		middle[k] = (p[0][k] + p[1][k]) / 2;
	/* Pulled to the middle a little, so that it is never singular. */
	const double pull = 1e-4 * (q[0] + q[4] + q[7]) + 1e-30;
	const double m[3][3] = {{q[0] + pull, q[1], q[2]}, {q[1], q[4] + pull, q[5]}, {q[2], q[5], q[7] + pull}};
	const double r[3] = {pull * middle[0] - q[3], pull * middle[1] - q[6], pull * middle[2] - q[8]};
	const double c0 = m[1][1] * m[2][2] - m[1][2] * m[2][1], c1 = m[1][2] * m[2][0] - m[1][0] * m[2][2],
		     c2 = m[1][0] * m[2][1] - m[1][1] * m[2][0], det = m[0][0] * c0 + m[0][1] * c1 + m[0][2] * c2;
	double solved[3];
	for (int k = 0; k < 3; k++) {
		double t[3][3];
		memcpy(t, m, sizeof t);
		for (int i = 0; i < 3; i++)
			t[i][k] = r[i];
		solved[k] =
			(t[0][0] * (t[1][1] * t[2][2] - t[1][2] * t[2][1]) - t[0][1] * (t[1][0] * t[2][2] - t[1][2] * t[2][0]) +
			 t[0][2] * (t[1][0] * t[2][1] - t[1][1] * t[2][0])) /
			det;
	}
	const double *choice[4] = {solved, middle, p[0], p[1]};
	for (int i = 0; i < 4; i++) {
		const double cost = quadric_at(q, choice[i]);
		if (cost < best - 1e-15) {
			best = cost;
			memcpy(out, choice[i], 3 * sizeof *out);
		}
	}
	return best;
}

struct candidate {
	double cost;
	idx_t a, b;
	unsigned version_a, version_b;
};

struct heap {
	struct candidate *item;
	size_t count, room;
};

static bool is_less(const struct candidate *x, const struct candidate *y)
{
	return x->cost != y->cost ? x->cost < y->cost : x->a != y->a ? x->a < y->a : x->b < y->b;
}

static void heap_push(struct heap *heap, struct candidate item)
{
	if (heap->count == heap->room) {
		heap->room = heap->room ? 2 * heap->room : 1024;
		heap->item = mem_resize(heap->item, heap->room, sizeof *heap->item);
	}
	size_t i = heap->count++;
	for (; i > 0 && is_less(&item, &heap->item[(i - 1) / 2]); i = (i - 1) / 2)
		heap->item[i] = heap->item[(i - 1) / 2];
	heap->item[i] = item;
}

static struct candidate heap_pop(struct heap *heap)
{
	const struct candidate top = heap->item[0], last = heap->item[--heap->count];
	size_t i = 0;
	for (;;) {
		size_t child = 2 * i + 1;
		if (child >= heap->count)
			break;
		if (child + 1 < heap->count && is_less(&heap->item[child + 1], &heap->item[child]))
			child++;
		if (!is_less(&heap->item[child], &last))
			break;
		heap->item[i] = heap->item[child];
		i = child;
	}
	heap->item[i] = last;
	return top;
}

static void push_edge(struct heap *heap, const struct simple *s, idx_t a, idx_t b)
{
	double at[3];
	heap_push(heap, (struct candidate){best_place(at, s, a, b), a < b ? a : b, a < b ? b : a, s->version[a < b ? a : b],
					   s->version[a < b ? b : a]});
}

static bool has_vertex(const idx_t corner[3], idx_t v)
{
	return corner[0] == v || corner[1] == v || corner[2] == v;
}

/* May a b become one vertex at place? Exactly two common neighbours, and no face turns over. */
static bool may_collapse(const struct simple *s, idx_t a, idx_t b, const double place[3])
{
	int common_faces = 0, common_vertices = 0;
	for (int side = 0; side < 2; side++) {
		const idx_t v = side ? b : a, w = side ? a : b;
		for (size_t i = 0; i < s->ring[v].count; i++) {
			const idx_t *c = s->corner[s->ring[v].face[i]];
			if (has_vertex(c, w)) {
				common_faces++;
				continue;
			}
			double before[3], after[3];
			const double *p[3];
			for (int k = 0; k < 3; k++)
				p[k] = s->xyz + 3 * (size_t)c[k];
			normal_of(before, p[0], p[1], p[2]);
			for (int k = 0; k < 3; k++)
				if (c[k] == v)
					p[k] = place;
			if (normal_of(after, p[0], p[1], p[2]) <= 0 ||
			    before[0] * after[0] + before[1] * after[1] + before[2] * after[2] < 0.2)
				return false;
			if (side)
				continue;
			for (int k = 0; k < 3; k++) {
				if (c[k] == a || c[(k + 1) % 3] != a)
					continue; /* c[k]: the neighbour before a, once for each neighbour */
				for (size_t j = 0; j < s->ring[b].count; j++)
					if (has_vertex(s->corner[s->ring[b].face[j]], c[k])) {
						common_vertices++;
						break;
					}
			}
		}
	}
	/* Of the two common neighbours of a manifold edge one comes before a in a face without b. */
	return common_faces == 4 && common_vertices == 1;
}

static void collapse(struct simple *s, struct heap *heap, idx_t a, idx_t b, const double place[3])
{
	memcpy(s->xyz + 3 * (size_t)a, place, 3 * sizeof *place);
	for (int i = 0; i < 10; i++)
		s->quadric[a][i] += s->quadric[b][i];
	for (size_t i = 0; i < s->ring[b].count; i++) {
		const idx_t f = s->ring[b].face[i];
		if (has_vertex(s->corner[f], a)) {
			for (int k = 0; k < 3; k++) {
				const idx_t v = s->corner[f][k];
				struct ring *ring = &s->ring[v];
				if (v == b)
					continue;
				for (size_t j = 0; j < ring->count; j++)
					if (ring->face[j] == f)
						ring->face[j--] = ring->face[--ring->count];
			}
			s->corner[f][0] = NO_INDEX;
			continue;
		}
		for (int k = 0; k < 3; k++)
			if (s->corner[f][k] == b)
				s->corner[f][k] = a;
		ring_add(&s->ring[a], f);
	}
	s->ring[b].count = 0;
	s->version[a]++;
	s->version[b]++;
	s->alive_vertices--;
	for (size_t i = 0; i < s->ring[a].count; i++)
		for (int k = 0; k < 3; k++) {
			const idx_t v = s->corner[s->ring[a].face[i]][k];
			if (v != a)
				push_edge(heap, s, a, v);
		}
}

static struct cage take_cage(const struct simple *s)
{
	struct cage cage = {0};
	idx_t *number = mem_array(s->vertex_count, sizeof *number);
	for (size_t f = 0; f < s->face_count; f++) {
		idx_t corner[3];
		if (s->corner[f][0] == NO_INDEX)
			continue;
		for (int k = 0; k < 3; k++) {
			const idx_t v = s->corner[f][k];
			if (number[v] == 0)
				number[v] = 1 + sample_vertex(&cage, s->xyz[3 * v], s->xyz[3 * v + 1], s->xyz[3 * v + 2]);
			corner[k] = number[v] - 1;
		}
		sample_face(&cage, corner, 3);
	}
	free(number);
	return cage;
}

/* --- polygons ----------------------------------------------------------------------------------------------------------- */

static void face_normal(double n[3], const struct cage *cage, size_t f)
{
	const size_t count = sample_degree(cage, f);
	n[0] = n[1] = n[2] = 0;
	for (size_t i = 0; i < count; i++) {
		const double *p = cage->xyz + 3 * sample_corners(cage, f)[i],
			     *q = cage->xyz + 3 * sample_corners(cage, f)[(i + 1) % count];
		for (int k = 0; k < 3; k++)
			n[k] += p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
	}
	const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
	for (int k = 0; k < 3; k++)
		n[k] /= length > 0 ? length : 1;
}

/* Take the flattest edge away as long as it bends by less than the angle and the merged face stays flat. */
static void merge_flat(struct cage *cage, double angle_deg, double side)
{
	for (bool is_changed = true; is_changed;) {
		is_changed = false;
		double best = cos(angle_deg / 57.2957795);
		size_t best_face = 0, best_corner = 0;
		for (size_t f = 0; f < cage->face_count; f++) {
			const size_t n = sample_degree(cage, f);
			const idx_t *c = sample_corners(cage, f);
			double mine[3], other[3];
			face_normal(mine, cage, f);
			for (size_t i = 0; i < n; i++) {
				size_t face[2] = {0}, at[2] = {0};
				if (c[i] > c[(i + 1) % n] || !sample_faces_at(cage, c[i], c[(i + 1) % n], face, at))
					continue;
				face_normal(other, cage, face[1]);
				const double cosine = mine[0] * other[0] + mine[1] * other[1] + mine[2] * other[2];
				const size_t m = sample_degree(cage, face[1]);
				int common = 0;
				double off = 0;
				for (size_t j = 0; j < m; j++) {
					const idx_t v = sample_corners(cage, face[1])[j];
					double d = 0;
					for (int k = 0; k < 3; k++)
						d += mine[k] * (cage->xyz[3 * v + k] - cage->xyz[3 * c[i] + k]);
					off = fmax(off, fabs(d));
					for (size_t k = 0; k < n; k++)
						common += c[k] == v;
				}
				if (cosine > best && common == 2 && off < 0.02 * side && n + m < 14) {
					best = cosine;
					best_face = f;
					best_corner = i;
					is_changed = true;
				}
			}
		}
		if (is_changed)
			sample_merge(cage, best_face, best_corner);
	}
}

/* Drop vertices with two faces that lie on the straight line between their neighbours. */
static void drop_straight(struct cage *cage)
{
	idx_t *faces = mem_array(cage->vertex_count, sizeof *faces);
	for (size_t h = 0; h < cage->face_start[cage->face_count]; h++)
		faces[cage->face_corner[h]]++;
	for (size_t v = 0; v < cage->vertex_count; v++) {
		if (faces[v] != 2)
			continue;
		bool may_go = true;
		for (size_t f = 0; f < cage->face_count && may_go; f++) {
			const size_t n = sample_degree(cage, f);
			const idx_t *c = sample_corners(cage, f);
			for (size_t i = 0; i < n; i++) {
				if (c[i] != (idx_t)v)
					continue;
				double dot = 0, uu = 0, ww = 0;
				for (int k = 0; k < 3; k++) {
					const double u = cage->xyz[3 * c[i] + k] - cage->xyz[3 * c[(i + n - 1) % n] + k],
						     w = cage->xyz[3 * c[(i + 1) % n] + k] - cage->xyz[3 * c[i] + k];
					dot += u * w, uu += u * u, ww += w * w;
				}
				may_go = n > 3 && dot > 0.98 * sqrt(uu * ww);
			}
		}
		if (!may_go)
			continue;
		size_t kept = 0, next = 0;
		for (size_t f = 0; f < cage->face_count; f++) {
			for (; next < cage->face_start[f + 1]; next++)
				if (cage->face_corner[next] != (idx_t)v)
					cage->face_corner[kept++] = cage->face_corner[next];
			cage->face_start[f + 1] = kept;
		}
	}
	free(faces);
	sample_drop_faces(cage, (bool[4096]){false});
}

static int compare_doubles(const void *left, const void *right)
{
	const double a = *(const double *)left, b = *(const double *)right;
	return a < b ? -1 : a > b;
}

/* Coordinates on an axis that follow each other within reach become their mean. */
static void align(struct cage *cage, double reach)
{
	const size_t n = cage->vertex_count;
	double *value = mem_array(n, sizeof *value);
	for (int k = 0; k < 3; k++) {
		for (size_t v = 0; v < n; v++)
			value[v] = cage->xyz[3 * v + k];
		qsort(value, n, sizeof *value, compare_doubles);
		for (size_t i = 0, end; i < n; i = end) {
			double sum = value[i];
			for (end = i + 1; end < n && value[end] - value[i] < reach; end++)
				sum += value[end];
			for (size_t v = 0; v < n; v++)
				if (cage->xyz[3 * v + k] >= value[i] && cage->xyz[3 * v + k] <= value[end - 1])
					cage->xyz[3 * v + k] = sum / (double)(end - i);
		}
	}
	free(value);
}

static void write_cage(const struct cage *cage, const char *folder, const char *name, size_t number)
{
	char path[1000];
	snprintf(path, sizeof path, "%s/%s-%03zu.ply", folder, name, number);
	FILE *file = fopen(path, "wb");
	if (!file) {
		perror(path);
		exit(EX_SYSTEM);
	}
	struct ply ply;
	ply_init(&ply);
	cage_to_ply(&ply, cage);
	ply_write(file, &ply);
	ply_free(&ply);
	fclose(file);
}

static void finish(const struct simple *s, double side, const char *folder, const char *name, size_t number)
{
	for (int kind = 0; kind < 2; kind++) { /* less and more merged */
		struct cage cage = take_cage(s);
		merge_flat(&cage, kind ? 25 : 6, side);
		drop_straight(&cage);
		merge_flat(&cage, kind ? 25 : 6, side);
		align(&cage, sample_real(0.001, 0.012) * side);
		sample_tag(&cage, sample_real(22, 40), 0.01);
		write_cage(&cage, folder, name, 2 * number + (size_t)kind);
		cage_free(&cage);
	}
}

int main(int argc, char **argv)
{
	static const size_t goal[] = {150, 110, 80, 60, 42, 30};
	for (int i = 2; i < argc; i++) {
		struct fault fault = {0};
		struct input input;
		struct mesh mesh;
		if (!input_read(&input, argv[i], &fault) || !mesh_read(&mesh, &input, &fault)) {
			fprintf(stderr, "corpus: %s\n", fault.text);
			continue;
		}
		mesh_weld(&mesh, 0, NULL);
		struct simple s = {.vertex_count = mesh.vertex_count, .face_count = mesh.face_count, .xyz = mesh.xyz};
		if (s.face_count > FACE_LIMIT || mesh.face_start[s.face_count] != 3 * s.face_count) {
			fprintf(stderr, "corpus: %s: left out\n", argv[i]);
			continue;
		}
		char name[200];
		const char *base = strrchr(argv[i], '/') ? strrchr(argv[i], '/') + 1 : argv[i];
		snprintf(name, sizeof name, "%.*s", (int)strcspn(base, "."), base);
		sample_seed((uint64_t)i);
		const double side = mesh_bounds(s.xyz, s.vertex_count, NULL, NULL);
		s.quadric = mem_array(s.vertex_count, sizeof *s.quadric);
		s.corner = mem_array(s.face_count, sizeof *s.corner);
		s.ring = mem_array(s.vertex_count, sizeof *s.ring);
		s.version = mem_array(s.vertex_count, sizeof *s.version);
		struct heap heap = {0};
		for (size_t f = 0; f < s.face_count; f++) {
			double n[3];
			const double *p[3];
			for (int k = 0; k < 3; k++) {
				s.corner[f][k] = mesh.corner[3 * f + k];
				p[k] = s.xyz + 3 * (size_t)s.corner[f][k];
				ring_add(&s.ring[s.corner[f][k]], (idx_t)f);
			}
			const double area = normal_of(n, p[0], p[1], p[2]);
			for (int k = 0; k < 3; k++)
				add_plane(s.quadric[s.corner[f][k]], n, p[0], area + 1e-9 * side * side);
		}
		for (size_t v = 0; v < s.vertex_count; v++)
			s.alive_vertices += s.ring[v].count > 0;
		for (size_t f = 0; f < s.face_count; f++)
			for (int k = 0; k < 3; k++)
				if (s.corner[f][k] < s.corner[f][(k + 1) % 3])
					push_edge(&heap, &s, s.corner[f][k], s.corner[f][(k + 1) % 3]);
		size_t next = 0;
		while (heap.count > 0 && next < sizeof goal / sizeof *goal) {
			const struct candidate top = heap_pop(&heap);
			if (top.version_a != s.version[top.a] || top.version_b != s.version[top.b] || s.ring[top.a].count == 0 ||
			    s.ring[top.b].count == 0)
				continue;
			double place[3];
			best_place(place, &s, top.a, top.b);
			if (!may_collapse(&s, top.a, top.b, place))
				continue;
			collapse(&s, &heap, top.a, top.b, place);
			if (s.alive_vertices <= goal[next]) {
				finish(&s, side, argv[1], name, goal[next]);
				next++;
			}
		}
		for (size_t v = 0; v < s.vertex_count; v++)
			free(s.ring[v].face);
		free(s.quadric);
		free(s.corner);
		free(s.ring);
		free(s.version);
		free(heap.item);
		mesh_free(&mesh);
		input_free(&input);
	}
	return 0;
}
