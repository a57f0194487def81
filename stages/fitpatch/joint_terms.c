/* Samples of a cage in the making and their feet. */
#include "stages/fitpatch/joint_terms.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stages/geometry/vector.h"

/* Two creases that turn by more meet in a corner (the method's angle for nodes, section 4.1). */
static const double kink_deg = 45;

static int compare_pairs(const void *a, const void *b)
{
	const idx_t *x = a, *y = b;
	return x[0] != y[0] ? (x[0] > y[0]) - (x[0] < y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* A node with exactly two creases is a corner when the network says so, or when they meet in a kink: a junction with smooth
 * curves is said to be none, yet those that became creases may turn there. */
static void mark_corners(struct cage *cage, const struct draft *draft, const idx_t *number, const unsigned char *sharp_at)
{
	const struct network *network = &draft->network;
	double *direction = mem_array(3 * cage->vertex_count, sizeof *direction);
	unsigned char *met = mem_array(cage->vertex_count, 1);
	for (size_t k = 0; k < network->curve_count; k++) {
		const struct curve *curve = &network->curve[k];
		if (curve->kind == CURVE_SMOOTH || curve->closed)
			continue;
		for (int end = 0; end < 2; end++) {
			const idx_t node = network->point[curve->first + (end ? curve->count - 1 : 0)];
			const idx_t next = network->point[curve->first + (end ? curve->count - 2 : 1)], v = number[node];
			if (v == NO_INDEX || sharp_at[v] != 2 || draft->control.role[node] == POINT_CREASE)
				continue;
			double away[3];
			sub3(away, &draft->control.xyz[3 * (size_t)next], &draft->control.xyz[3 * (size_t)node]);
			if (draft->control.role[node] == POINT_CORNER)
				cage->corner[v] = 1;
			else if (met[v]++ == 0)
				copy3(&direction[3 * (size_t)v], away);
			else if (180 - angle3(away, &direction[3 * (size_t)v]) * DEGREES > kink_deg)
				cage->corner[v] = 1;
		}
	}
	free(direction), free(met);
}

void draft_cage(struct cage *cage, idx_t **vertex_of, const struct draft *draft)
{
	const struct polygons *polygons = &draft->polygons;
	*cage = (struct cage){.scheme = SCHEME_QUADTRI};
	idx_t *number = mem_array(draft->control.count, sizeof *number);
	memset(number, 0xff, draft->control.count * sizeof *number);
	const size_t corners = polygons->start[polygons->count];
	for (size_t h = 0; h < corners; h++)
		number[polygons->corner[h]] = 0;
	size_t vertices = 0;
	for (size_t i = 0; i < draft->control.count; i++)
		if (number[i] != NO_INDEX)
			number[i] = (idx_t)vertices++;
	cage->vertex_count = vertices;
	cage->xyz = mem_array(3 * vertices, sizeof *cage->xyz);
	cage->corner = mem_array(vertices, 1);
	for (size_t i = 0; i < draft->control.count; i++)
		if (number[i] != NO_INDEX)
			copy3(&cage->xyz[3 * (size_t)number[i]], &draft->control.xyz[3 * i]);
	cage->face_count = polygons->count;
	cage->face_start = mem_copy(polygons->start, polygons->count + 1, sizeof *polygons->start);
	cage->face_patch = mem_copy(polygons->patch, polygons->count, sizeof *polygons->patch);
	cage->face_corner = mem_array(corners, sizeof *cage->face_corner);
	/* Edges of the cage, to keep only creases that are edges. */
	idx_t *edge = mem_array(2 * corners, sizeof *edge);
	size_t h = 0;
	for (size_t f = 0; f < polygons->count; f++)
		for (size_t i = polygons->start[f]; i < polygons->start[f + 1]; i++, h++) {
			const idx_t a = number[polygons->corner[i]];
			const idx_t b = number[polygons->corner[i + 1 < polygons->start[f + 1] ? i + 1 : polygons->start[f]]];
			cage->face_corner[i] = a;
			edge[2 * h] = a < b ? a : b, edge[2 * h + 1] = a < b ? b : a;
		}
	qsort(edge, corners, 2 * sizeof *edge, compare_pairs);
	size_t sides = 0;
	for (size_t k = 0; k < draft->network.curve_count; k++)
		sides += draft->network.curve[k].count;
	cage->sharp = mem_array(2 * (sides + draft->seam_count), sizeof *cage->sharp);
	unsigned char *sharp_at = mem_array(vertices, 1);
	for (size_t k = 0; k < draft->network.curve_count; k++) {
		const struct curve *curve = &draft->network.curve[k];
		if (curve->kind == CURVE_SMOOTH)
			continue;
		const idx_t *point = &draft->network.point[curve->first];
		for (size_t i = 0; i + !curve->closed < curve->count; i++) {
			const idx_t a = number[point[i]], b = number[point[(i + 1) % curve->count]];
			if (a == NO_INDEX || b == NO_INDEX || a == b)
				continue;
			const idx_t pair[2] = {a < b ? a : b, a < b ? b : a};
			if (!bsearch(pair, edge, corners, 2 * sizeof *edge, compare_pairs))
				continue;
			if (sharp_at[a] < 3)
				sharp_at[a]++;
			if (sharp_at[b] < 3)
				sharp_at[b]++;
			if (curve->kind == CURVE_SHARP) {
				cage->sharp[2 * cage->sharp_count] = pair[0], cage->sharp[2 * cage->sharp_count + 1] = pair[1];
				cage->sharp_count++;
			}
		}
	}
	for (size_t i = 0; i < draft->seam_count; i++) {
		const idx_t a = number[draft->seam[3 * i]], b = number[draft->seam[3 * i + 1]], pair[2] = {a < b ? a : b, a < b ? b : a};
		if (a != NO_INDEX && b != NO_INDEX && bsearch(pair, edge, corners, 2 * sizeof *edge, compare_pairs)) {
			memcpy(&cage->sharp[2 * cage->sharp_count++], pair, sizeof pair);
			for (int k = 0; k < 2; k++)
				if (sharp_at[pair[k]] < 3)
					sharp_at[pair[k]]++;
		}
	}
	qsort(cage->sharp, cage->sharp_count, 2 * sizeof *cage->sharp, compare_pairs);
	mark_corners(cage, draft, number, sharp_at);
	free(edge), free(sharp_at);
	*vertex_of = number;
}

/* The patches around each refined vertex: the lowest two, and whether there are more. */
static void classify(struct terms *terms)
{
	const struct level *level = &terms->level;
	const size_t n = level->vertex_count;
	unsigned char *creases = mem_array(n, 1), *many = mem_array(n, 1);
	terms->kind = mem_array(n, 1);
	terms->patch = mem_array(n, sizeof *terms->patch);
	terms->patch2 = mem_array(n, sizeof *terms->patch2);
	for (size_t v = 0; v < n; v++)
		terms->patch[v] = terms->patch2[v] = NO_PATCH;
	/* Sum of the next vertices minus sum of the previous ones over the faces around: 0 for a closed fan, the difference of two
	 * different vertices at a border. */
	int64_t *open = mem_array(n, sizeof *open);
	for (size_t f = 0; f < level->face_count; f++) {
		const idx_t patch = terms->cage.face_patch[level->face_origin[f]];
		const size_t low = level->face_start[f], high = level->face_start[f + 1];
		for (size_t h = low; h < high; h++) {
			const idx_t v = level->face_corner[h], w = level->face_corner[h + 1 < high ? h + 1 : low];
			if (terms->patch[v] == NO_PATCH)
				terms->patch[v] = patch;
			else if (terms->patch[v] != patch && terms->patch2[v] == NO_PATCH)
				terms->patch2[v] = patch;
			else if (terms->patch[v] != patch && terms->patch2[v] != patch)
				many[v] = 1;
			open[v] += w, open[w] -= v;
			if (level->sharp[h]) { /* an inner crease is met from both sides */
				creases[v] = creases[v] < 200 ? creases[v] + 1 : creases[v];
				creases[w] = creases[w] < 200 ? creases[w] + 1 : creases[w];
			}
		}
	}
	for (size_t v = 0; v < n; v++) {
		const bool two = terms->patch2[v] != NO_PATCH;
		/* Where only smooth curves meet, the surface is as smooth as anywhere. */
		if (level->corner[v] || (many[v] && (creases[v] > 0 || open[v] != 0)) || (open[v] != 0 && two))
			terms->kind[v] = SAMPLE_NODE;
		else if (open[v] != 0 || (two && creases[v] >= 4))
			terms->kind[v] = SAMPLE_CURVE;
		else
			terms->kind[v] = SAMPLE_SURFACE;
		if (terms->kind[v] == SAMPLE_CURVE && !two)
			terms->patch2[v] = -1;
	}
	free(creases), free(many), free(open);
}

static void triangulate(struct terms *terms)
{
	const struct level *level = &terms->level;
	size_t count = 0;
	for (size_t f = 0; f < level->face_count; f++)
		count += level->face_start[f + 1] - level->face_start[f] - 2;
	terms->triangle = mem_array(3 * count, sizeof *terms->triangle);
	terms->triangle_patch = mem_array(count, sizeof *terms->triangle_patch);
	terms->triangle_face = mem_array(count, sizeof *terms->triangle_face);
	for (size_t f = 0; f < level->face_count; f++) {
		const size_t low = level->face_start[f], high = level->face_start[f + 1];
		for (size_t i = low + 1; i + 1 < high; i++) {
			idx_t *t = &terms->triangle[3 * terms->triangle_count];
			t[0] = level->face_corner[low], t[1] = level->face_corner[i], t[2] = level->face_corner[i + 1];
			terms->triangle_face[terms->triangle_count] = level->face_origin[f];
			terms->triangle_patch[terms->triangle_count++] = terms->cage.face_patch[level->face_origin[f]];
		}
	}
}

bool terms_make(struct terms *terms, const struct draft *draft, const struct dense *dense, int steps, bool with_rows, struct fault *fault)
{
	*terms = (struct terms){0};
	draft_cage(&terms->cage, &terms->vertex_of, draft);
	terms->control_of = mem_array(terms->cage.vertex_count, sizeof *terms->control_of);
	for (size_t i = 0; i < draft->control.count; i++)
		if (terms->vertex_of[i] != NO_INDEX)
			terms->control_of[terms->vertex_of[i]] = (idx_t)i;
	struct level base;
	if (!level_from_cage(&base, &terms->cage, fault)) {
		terms_free(terms);
		return false;
	}
	if (with_rows) {
		subdivide_operator(&terms->rows, &terms->level, &base, SCHEME_QUADTRI, steps, true);
	} else {
		level_refine(&terms->level, &base, SCHEME_QUADTRI, steps);
		level_to_limit(&terms->level, SCHEME_QUADTRI);
	}
	level_free(&base);
	if (with_rows)
		sparse_apply(terms->level.xyz, &terms->rows, terms->cage.xyz);
	classify(terms);
	triangulate(terms);
	terms->triangle_surface = mem_array(terms->triangle_count, sizeof *terms->triangle_surface);
	for (size_t t = 0; t < terms->triangle_count; t++)
		terms->triangle_surface[t] = dense->patch[terms->triangle_patch[t]].parent;
	terms->area = mem_array(terms->level.vertex_count, sizeof *terms->area);
	for (size_t t = 0; t < terms->triangle_count; t++) {
		const idx_t *v = &terms->triangle[3 * t];
		double doubled[3];
		area_vector3(doubled, &terms->level.xyz[3 * (size_t)v[0]], &terms->level.xyz[3 * (size_t)v[1]], &terms->level.xyz[3 * (size_t)v[2]]);
		for (int k = 0; k < 3; k++)
			terms->area[v[k]] += norm3(doubled) / 6;
	}
	return true;
}

void terms_free(struct terms *terms)
{
	cage_free(&terms->cage);
	level_free(&terms->level);
	sparse_free(&terms->rows);
	free(terms->vertex_of), free(terms->control_of), free(terms->kind), free(terms->patch), free(terms->patch2), free(terms->area);
	free(terms->triangle), free(terms->triangle_patch), free(terms->triangle_face), free(terms->triangle_surface);
	*terms = (struct terms){0};
}

/* Chains sorted by their pair of patches. */
struct chain_entry {
	idx_t low, high, chain;
};

/* A tree of boxes over the segments of a chain, in its order: node k of a chain has children 2 k + 1 and 2 k + 2; the leaves are
 * runs of segments. Walking it from the front visits few of them, since a chain is a curve. */
enum { RUN_SEGMENTS = 8 };

struct chain_box {
	double low[3], high[3];
};

struct chain_index {
	const struct border_network *border;
	const double *xyz;
	struct chain_entry *entry;
	size_t *box_start;      /* a chain: its first box; runs come last among them */
	size_t *run_count;      /* a chain: a power of two, runs behind the end are empty */
	struct chain_box *box;
};

static size_t segment_count(const struct border_chain *chain) { return chain->closed ? chain->count : chain->count - 1; }

static void make_boxes(struct chain_index *index)
{
	const struct border_network *border = index->border;
	index->box_start = mem_array(border->chain_count + 1, sizeof *index->box_start);
	index->run_count = mem_array(border->chain_count, sizeof *index->run_count);
	for (size_t c = 0; c < border->chain_count; c++) {
		size_t runs = 1;
		while (runs * RUN_SEGMENTS < segment_count(&border->chain[c]))
			runs *= 2;
		index->run_count[c] = runs;
		index->box_start[c + 1] = index->box_start[c] + 2 * runs - 1;
	}
	index->box = mem_array(index->box_start[border->chain_count], sizeof *index->box);
	for (size_t c = 0; c < border->chain_count; c++) {
		const struct border_chain *chain = &border->chain[c];
		const idx_t *vertex = &border->vertex[chain->first];
		const size_t runs = index->run_count[c], segments = segment_count(chain);
		struct chain_box *box = &index->box[index->box_start[c]];
		for (size_t b = 2 * runs - 1; b-- > 0;) {
			for (int k = 0; k < 3; k++)
				box[b].low[k] = INFINITY, box[b].high[k] = -INFINITY;
			const bool is_run = b + 1 >= runs;
			const size_t first = is_run ? RUN_SEGMENTS * (b + 1 - runs) : 0;
			for (size_t s = first; is_run && s < segments + 1 && s <= first + RUN_SEGMENTS && first < segments; s++)
				for (int k = 0; k < 3; k++) {
					const double x = index->xyz[3 * (size_t)vertex[s % chain->count] + (size_t)k];
					box[b].low[k] = fmin(box[b].low[k], x), box[b].high[k] = fmax(box[b].high[k], x);
				}
			for (size_t child = 2 * b + 1; !is_run && child <= 2 * b + 2; child++)
				for (int k = 0; k < 3; k++)
					box[b].low[k] = fmin(box[b].low[k], box[child].low[k]), box[b].high[k] = fmax(box[b].high[k], box[child].high[k]);
		}
	}
}

/* Infinite for the box of nothing. */
static double box_distance(const struct chain_box *box, const double p[3])
{
	double squared = 0;
	for (int k = 0; k < 3; k++) {
		const double out = fmax(fmax(box->low[k] - p[k], p[k] - box->high[k]), 0);
		squared += out * out;
	}
	return sqrt(squared);
}

static int compare_entries(const void *a, const void *b)
{
	const struct chain_entry *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	if (x->high != y->high)
		return x->high < y->high ? -1 : 1;
	return (x->chain > y->chain) - (x->chain < y->chain);
}

struct chain_index *chain_index_new(const struct border_network *border, const double *xyz)
{
	struct chain_index *index = mem_array(1, sizeof *index);
	*index = (struct chain_index){.border = border, .xyz = xyz, .entry = mem_array(border->chain_count, sizeof *index->entry)};
	for (size_t c = 0; c < border->chain_count; c++) {
		const struct border_chain *chain = &border->chain[c];
		index->entry[c] = (struct chain_entry){chain->left < chain->right ? chain->left : chain->right,
		                                       chain->left < chain->right ? chain->right : chain->left, (idx_t)c};
	}
	qsort(index->entry, border->chain_count, sizeof *index->entry, compare_entries);
	make_boxes(index);
	return index;
}

void chain_index_free(struct chain_index *index)
{
	if (index)
		free(index->entry), free(index->box_start), free(index->run_count), free(index->box);
	free(index);
}

/* Where the nearest point on some chains is so far. */
struct chain_foot {
	double distance, point[3], tangent[3];
};

static void search_run(struct chain_foot *best, const struct chain_index *index, const struct border_chain *chain, size_t run, const double p[3])
{
	const idx_t *vertex = &index->border->vertex[chain->first];
	const size_t segments = segment_count(chain);
	for (size_t s = RUN_SEGMENTS * run; s < RUN_SEGMENTS * (run + 1) && s < segments; s++) {
		const double *a = &index->xyz[3 * (size_t)vertex[s]], *b = &index->xyz[3 * (size_t)vertex[(s + 1) % chain->count]];
		double ab[3], ap[3], foot[3];
		sub3(ab, b, a);
		sub3(ap, p, a);
		const double squared = dot3(ab, ab);
		double t = squared > 0 ? dot3(ap, ab) / squared : 0;
		t = t < 0 ? 0 : t > 1 ? 1 : t;
		copy3(foot, a);
		add_scaled3(foot, t, ab);
		const double distance = distance3(foot, p);
		if (distance < best->distance) {
			best->distance = distance;
			copy3(best->point, foot);
			copy3(best->tangent, ab);
		}
	}
}

/* The nearer half first. */
static void search_chain(struct chain_foot *best, const struct chain_index *index, size_t c, const double p[3])
{
	const size_t runs = index->run_count[c];
	const struct chain_box *box = &index->box[index->box_start[c]];
	struct {
		size_t node;
		double distance;
	} stack[64]; /* one a level */
	size_t depth = 0;
	stack[depth].node = 0;
	stack[depth++].distance = box_distance(&box[0], p);
	while (depth > 0) {
		const size_t node = stack[--depth].node;
		if (!(stack[depth].distance < best->distance))
			continue;
		if (node + 1 >= runs) {
			search_run(best, index, &index->border->chain[c], node + 1 - runs, p);
			continue;
		}
		const double one = box_distance(&box[2 * node + 1], p), two = box_distance(&box[2 * node + 2], p);
		const size_t far = one <= two ? 2 : 1;
		stack[depth].node = 2 * node + far, stack[depth++].distance = one <= two ? two : one;
		stack[depth].node = 2 * node + 3 - far, stack[depth++].distance = one <= two ? one : two;
	}
}

bool chain_nearest(double point[3], double tangent[3], const struct chain_index *index, idx_t patch, idx_t patch2, const double p[3])
{
	const struct chain_entry want = {patch < patch2 ? patch : patch2, patch < patch2 ? patch2 : patch, -1};
	size_t low = 0, high = index->border->chain_count;
	while (low < high) {
		const size_t middle = (low + high) / 2;
		if (compare_entries(&index->entry[middle], &want) < 0)
			low = middle + 1;
		else
			high = middle;
	}
	struct chain_foot best = {.distance = INFINITY};
	for (size_t e = low; e < index->border->chain_count && index->entry[e].low == want.low && index->entry[e].high == want.high; e++)
		search_chain(&best, index, (size_t)index->entry[e].chain, p);
	copy3(point, best.point);
	copy3(tangent, best.tangent);
	return isfinite(best.distance) && normalise3(tangent) > 0;
}

struct foot terms_foot(const struct terms *terms, const struct target *target, size_t sample, idx_t hint[2])
{
	const double *p = &terms->level.xyz[3 * sample];
	const struct dense_patch *patch = target->dense->patch;
	const idx_t one = patch[terms->patch[sample]].parent, two = terms->patch2[sample] >= 0 ? patch[terms->patch2[sample]].parent : one;
	struct nearest_filter filter = {.label = target->surface, .only = one, .hint = hint[0]};
	struct foot foot = nearest_point(target->on_surface, p, INFINITY, &filter);
	hint[0] = foot.triangle + 1;
	if (two != one) {
		filter.only = two, filter.hint = hint[1];
		const struct foot other = nearest_point(target->on_surface, p, foot.distance, &filter);
		if (other.triangle != NO_INDEX)
			hint[1] = other.triangle + 1;
		if (foot.triangle == NO_INDEX || (other.triangle != NO_INDEX && other.distance < foot.distance))
			foot = other;
	}
	return foot;
}

void terms_feet_of_target(struct foot *feet, const struct terms *terms, const struct target *target, const struct nearest *nearest)
{
	const idx_t *surface = target->surface, *triangle = target->sample_triangle;
	const size_t n = target->sample_count;
	enum { RUN = 64 }; /* samples follow the triangles of the target: the one before is often close by */
#pragma omp parallel for schedule(dynamic, 1)
	for (size_t run = 0; run < (n + RUN - 1) / RUN; run++)
		for (size_t s = RUN * run; s < n && s < RUN * (run + 1); s++) {
			struct nearest_filter filter = {.label = terms->triangle_surface, .only = surface[triangle[s]], .hint = feet[s].triangle + 1};
			if (filter.hint == 0 && s > RUN * run)
				filter.hint = feet[s - 1].triangle + 1;
			feet[s] = nearest_point(nearest, &target->sample[3 * s], INFINITY, &filter);
		}
}
