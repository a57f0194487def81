/* Cages under edits: connectivity, and each move on polygons whose result can be told by hand. */
#include "tests/unit/polish_rig.h"

#include "stages/polish/moves.h"

/* --- the sketch ------------------------------------------------------------------------------------------------------------ */

static void test_cube(void **state)
{
	(void)state;
	struct sketch s = rig_cube(false);
	rig_check(&s);
	assert_int_equal(sketch_edge_count(&s), 12);
	assert_int_equal(rig_euler(&s), 2);
	const struct sketch_star star = sketch_star(&s, 3);
	assert_int_equal(star.valence, 3);
	assert_int_equal(star.sharp, 0);
	assert_false(star.on_border);
	const idx_t h = sketch_half(&s, 2, 6);
	assert_int_equal(s.face_corner[h], 2);
	assert_int_equal(sketch_head(&s, h), 6);
	assert_int_equal(sketch_next(&s, sketch_previous(&s, h)), h);
	assert_int_equal(sketch_half(&s, 0, 6), NO_INDEX); /* opposite ends of the cube */
	/* Turning visits each edge of a vertex once and comes back. */
	idx_t g = h;
	size_t turns = 0;
	do {
		assert_int_equal(s.face_corner[g], 2);
		g = sketch_turn(&s, g), turns++;
	} while (g != h);
	assert_int_equal(turns, 3);
	/* One ring around a vertex of a cube: its three faces; two rings: all. */
	const idx_t seed = 0;
	size_t count;
	idx_t *near = sketch_faces_near(&count, &s, &seed, 1, 1);
	assert_int_equal(count, 3);
	free(near);
	near = sketch_faces_near(&count, &s, &seed, 1, 2);
	assert_int_equal(count, 6);
	free(near);
	sketch_free(&s);
}

static void test_border(void **state)
{
	(void)state;
	struct sketch s = rig_quads(3, 3, false);
	rig_check(&s);
	size_t pieces, loops;
	rig_topology(&pieces, &loops, &s);
	assert_int_equal(pieces, 1);
	assert_int_equal(loops, 1);
	assert_int_equal(rig_euler(&s), 1); /* a disk */
	/* At the corner of the square two border edges and one face; beside it three edges, two of them on the border. */
	struct sketch_star star = sketch_star(&s, 0);
	assert_int_equal(star.valence, 2);
	assert_int_equal(star.sharp, 2);
	assert_true(star.on_border);
	star = sketch_star(&s, 1);
	assert_int_equal(star.valence, 3);
	assert_int_equal(star.sharp, 2);
	/* From the outgoing half-edge of a border vertex all others are reached. */
	assert_int_equal(s.twin[s.outgoing[1]], NO_INDEX);
	assert_false(sketch_is_corner(&s, 1));
	s.corner[1] = 1;
	assert_true(sketch_is_corner(&s, 1));
	sketch_free(&s);
}

/* Level 0 for the subdivision of the sketch is that of the cage. */
static void test_round_trip(void **state)
{
	(void)state;
	const double middle[3] = {10, -20, 0.5};
	struct cage cage = cage_make(house_xyz, 9, house_faces, SCHEME_CATMULLCLARK), back;
	cage_sharpen(&cage, (const int[]){4, 5, 5, 6, 6, 7, 7, 4, 0, 4, -1, -1});
	cage.corner[6] = 1; /* two creases: says something */
	cage.corner[4] = 1; /* three: says nothing, and is dropped */
	for (size_t f = 0; f < cage.face_count; f++)
		cage.face_patch[f] = (idx_t)(f / 3);
	struct sketch s;
	struct fault fault = {0};
	assert_true(sketch_from_cage(&s, &cage, middle, 4, &fault));
	rig_check(&s);
	for (size_t i = 0; i < 27; i++)
		assert_near(s.xyz[i], (house_xyz[i] - middle[i % 3]) / 4, 1e-15);
	struct level level = sketch_level(&s);
	struct level direct = level_make(&cage);
	assert_memory_equal(level.sharp, direct.sharp, cage.face_start[cage.face_count]);
	assert_memory_equal(level.corner, direct.corner, cage.vertex_count);
	free(level.corner), free(level.face_origin);
	level_free(&direct);
	sketch_to_cage(&back, &s, middle, 4);
	assert_int_equal(back.scheme, SCHEME_CATMULLCLARK);
	assert_int_equal(back.vertex_count, 9);
	assert_int_equal(back.face_count, cage.face_count);
	assert_memory_equal(back.face_start, cage.face_start, (cage.face_count + 1) * sizeof *cage.face_start);
	assert_memory_equal(back.face_corner, cage.face_corner, cage.face_start[cage.face_count] * sizeof *cage.face_corner);
	assert_memory_equal(back.face_patch, cage.face_patch, cage.face_count * sizeof *cage.face_patch);
	assert_int_equal(back.sharp_count, cage.sharp_count);
	assert_memory_equal(back.sharp, cage.sharp, 2 * cage.sharp_count * sizeof *cage.sharp);
	for (size_t i = 0; i < 27; i++)
		assert_near(back.xyz[i], house_xyz[i], 1e-14);
	for (size_t v = 0; v < 9; v++)
		assert_int_equal(back.corner[v], v == 6);
	assert_near(back.grid_step, 0, 0);
	cage_free(&back);
	cage_drop(&cage);
	sketch_free(&s);
}

static const double lens_xyz[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const int lens_faces[] = {0, 1, 2, 3, -1, 3, 2, 1, 0, -1, -2}, lens_rim[] = {0, 1, 1, 2, 2, 3, 0, 3, -1, -1};

/* Two faces back to back: each vertex has two edges, which only creases may leave so. */
static void test_two_edges(void **state)
{
	(void)state;
	struct cage cage = cage_make(lens_xyz, 4, lens_faces, SCHEME_QUADTRI);
	struct sketch s;
	struct fault fault = {0};
	assert_false(sketch_from_cage(&s, &cage, rig_zero, 1, &fault));
	assert_non_null(strstr(fault.text, "two edges that are not both creases"));
	cage_sharpen(&cage, lens_rim);
	assert_true(sketch_from_cage(&s, &cage, rig_zero, 1, &fault));
	rig_check(&s);
	sketch_free(&s);
	cage_drop(&cage);
}

/* --- single moves ------------------------------------------------------------------------------------------------------------ */

/* The invariants of a move that was done. */
static void check_move(const struct sketch *out, const struct move_trace *trace, const struct sketch *in)
{
	rig_check(out);
	assert_int_equal(rig_euler(out), rig_euler(in));
	size_t pieces[2], loops[2];
	rig_topology(&pieces[0], &loops[0], in), rig_topology(&pieces[1], &loops[1], out);
	assert_int_equal(pieces[0], pieces[1]);
	assert_int_equal(loops[0], loops[1]);
	/* Kept faces are the same polygons by the names of their vertices, with the same creases. */
	unsigned char *is_old = mem_array(out->face_count, 1);
	for (size_t f = 0; f < in->face_count; f++) {
		const idx_t g = trace->face[f];
		if (g == NO_INDEX)
			continue;
		assert_int_equal(is_old[g], 0);
		is_old[g] = 1;
		assert_int_equal(sketch_degree(out, g), sketch_degree(in, (idx_t)f));
		assert_int_equal(out->face_id[g], in->face_id[f]);
		assert_int_equal(out->face_patch[g], in->face_patch[f]);
		for (size_t i = 0; i < sketch_degree(in, (idx_t)f); i++)
			assert_int_equal(out->id[out->face_corner[out->face_start[g] + i]], in->id[in->face_corner[in->face_start[f] + i]]);
	}
	/* New ones have new names and a vertex that is said to be touched. */
	for (size_t f = 0; f < out->face_count; f++) {
		if (is_old[f])
			continue;
		assert_true(out->face_id[f] >= in->next_face_id);
		bool is_touched = false;
		for (size_t h = out->face_start[f]; h < out->face_start[f + 1]; h++)
			for (size_t i = 0; i < trace->touched_count; i++)
				is_touched = is_touched || trace->touched[i] == out->face_corner[h];
		assert_true(is_touched);
	}
	for (size_t i = 0; i < trace->touched_count; i++)
		assert_in_range(trace->touched[i], 0, out->vertex_count - 1);
	free(is_old);
}

static bool apply(struct sketch *out, const struct sketch *in, enum move_kind kind, idx_t a, idx_t b)
{
	idx_t *index = sketch_index(in);
	struct move_trace trace;
	const bool is_done = move_apply(out, &trace, in, index, (struct move){kind, a, b});
	free(index);
	if (is_done) {
		check_move(out, &trace, in);
		move_trace_free(&trace);
	}
	return is_done;
}

static void assert_counts(const struct sketch *s, size_t vertices, size_t edges, size_t faces)
{
	assert_int_equal(s->vertex_count, vertices);
	assert_int_equal(sketch_edge_count(s), edges);
	assert_int_equal(s->face_count, faces);
}

#define assert_refused(in, kind, a, b) assert_refused_at(in, kind, a, b, __FILE__, __LINE__)
static void assert_refused_at(const struct sketch *in, enum move_kind kind, idx_t a, idx_t b, const char *file, int line)
{
	struct sketch out;
	if (apply(&out, in, kind, a, b)) {
		print_error("the move was done\n");
		_fail(file, line);
	}
}
#define assert_face(in, ...) \
	assert_int_not_equal(rig_face((in), (const idx_t[]){__VA_ARGS__}, sizeof((const idx_t[]){__VA_ARGS__}) / sizeof(idx_t)), NO_INDEX)

static void test_merge(void **state)
{
	(void)state;
	/* Bottom and front of a smooth cube become one; the ends of their edge are left with two smooth edges and dissolve: a triangular prism. */
	struct sketch cube = rig_cube(false), s, t;
	assert_true(apply(&s, &cube, MOVE_MERGE, 0, 1));
	assert_counts(&s, 6, 9, 5);
	assert_face(&s, 3, 2, 5, 4);
	assert_face(&s, 2, 6, 5);
	assert_face(&s, 3, 4, 7);
	sketch_free(&s);
	sketch_free(&cube);
	/* With creases on all other edges these ends stay: an edge between two creases is a crease's vertex. */
	cube = rig_make(cube_xyz, 8, cube_faces, cube_edges + 2);
	assert_true(apply(&s, &cube, MOVE_MERGE, 1, 0));
	assert_counts(&s, 8, 11, 5);
	assert_face(&s, 0, 3, 2, 1, 5, 4);
	/* ... and the rest are creases, which do not merge. */
	assert_refused(&s, MOVE_MERGE, 1, 2);
	assert_refused(&s, MOVE_MERGE, 0, 1); /* no such edge any more */
	assert_refused(&s, MOVE_MERGE, 0, 6); /* never was one */
	sketch_free(&s);
	sketch_free(&cube);
	/* One crease more at an end: it would end in a vertex of two edges. */
	cube = rig_make(cube_xyz, 8, cube_faces, (const int[]){0, 3, -1, -1});
	assert_refused(&cube, MOVE_MERGE, 0, 1);
	sketch_free(&cube);
	/* A border has one face. */
	struct sketch square = rig_quads(3, 3, false);
	assert_refused(&square, MOVE_MERGE, 0, 1);
	assert_true(apply(&s, &square, MOVE_MERGE, 1, 5)); /* from the border inwards */
	assert_counts(&s, 16, 23, 8);
	/* Merged once more: still a disk. */
	assert_true(apply(&t, &s, MOVE_MERGE, 5, 9));
	assert_counts(&t, 15, 21, 7); /* vertex 5 had three smooth edges left, then two */
	sketch_free(&t), sketch_free(&s), sketch_free(&square);
	/* Triangles of a Loop cage stay triangles. */
	struct sketch loop = rig_sketch(cage_make(octahedron_xyz, 6, octahedron_faces, SCHEME_LOOP));
	assert_refused(&loop, MOVE_MERGE, 0, 2);
	sketch_free(&loop);
	/* A face of more than 40 corners is refused: a cap of 39 and a side of 4 would make 41. */
	for (int n = 38; n <= 39; n++) {
		struct sketch prism = rig_prism(n);
		/* one edge of the rim is smooth, those beside it are creases: the ends stay */
		const idx_t h = sketch_half(&prism, 0, 1), up[2] = {sketch_half(&prism, 0, (idx_t)n), sketch_half(&prism, 1, (idx_t)n + 1)};
		prism.sharp[h] = prism.sharp[prism.twin[h]] = 0;
		for (int i = 0; i < 2; i++)
			prism.sharp[up[i]] = prism.sharp[prism.twin[up[i]]] = 1;
		if (n == 38) {
			assert_true(apply(&s, &prism, MOVE_MERGE, 0, 1));
			sketch_free(&s);
		} else {
			assert_refused(&prism, MOVE_MERGE, 0, 1);
		}
		sketch_free(&prism);
	}
}

static void test_collapse(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(false), s;
	/* Two quads become triangles; the vertex that is left lies in the middle and keeps the name of the second end. */
	assert_true(apply(&s, &cube, MOVE_COLLAPSE, 0, 1));
	assert_counts(&s, 7, 11, 6);
	assert_face(&s, 1, 3, 2);
	assert_face(&s, 1, 5, 4);
	idx_t *index = sketch_index(&s);
	assert_int_equal(index[0], NO_INDEX);
	assert_near(s.xyz[3 * index[1]], 0, 1e-15);
	assert_near(s.xyz[3 * index[1] + 1], -0.5, 1e-15);
	free(index);
	sketch_free(&s);
	sketch_free(&cube);
	/* The triangle of a prism collapses, its third vertex is left with two edges and dissolves: a tetrahedron. */
	struct sketch prism = rig_make((const double[]){0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1}, 6,
	                               (const int[]){0, 2, 1, -1, 3, 4, 5, -1, 0, 1, 4, 3, -1, 1, 2, 5, 4, -1, 2, 0, 3, 5, -1, -2}, rig_no_pairs);
	assert_true(apply(&s, &prism, MOVE_COLLAPSE, 0, 1));
	assert_counts(&s, 4, 6, 4);
	/* ... which has nothing to give. */
	assert_refused(&s, MOVE_COLLAPSE, 1, 5);
	sketch_free(&s), sketch_free(&prism);
	/* An end on a crease keeps its place, a corner still more so. */
	cube = rig_make(cube_xyz, 8, cube_faces, (const int[]){0, 1, 1, 2, 2, 3, 0, 3, -1, -1});
	assert_true(apply(&s, &cube, MOVE_COLLAPSE, 6, 2));
	index = sketch_index(&s);
	for (int k = 0; k < 3; k++)
		assert_near(s.xyz[3 * index[2] + k], cube_xyz[6 + k], 0);
	free(index);
	sketch_free(&s);
	cube.corner[0] = 1;
	assert_true(apply(&s, &cube, MOVE_COLLAPSE, 0, 1));
	index = sketch_index(&s);
	for (int k = 0; k < 3; k++)
		assert_near(s.xyz[3 * index[1] + k], cube_xyz[k], 0);
	assert_int_equal(s.corner[index[1]], 1);
	/* The crease is one of three edges now. */
	size_t creases = 0;
	for (size_t h = 0; h < s.face_start[s.face_count]; h++)
		creases += s.sharp[h];
	assert_int_equal(creases, 6);
	free(index);
	sketch_free(&s), sketch_free(&cube);
	/* Two creases with a smooth edge between them would become one. */
	prism = rig_prism(6);
	assert_refused(&prism, MOVE_COLLAPSE, 0, 6);
	assert_true(apply(&s, &prism, MOVE_COLLAPSE, 0, 1));
	sketch_free(&s), sketch_free(&prism);
	/* Around the tube of this torus three edges run: with two the faces would lie on each other. */
	struct sketch torus = rig_quads(5, 3, true);
	assert_refused(&torus, MOVE_COLLAPSE, 0, 5);
	assert_true(apply(&s, &torus, MOVE_COLLAPSE, 0, 1));
	assert_counts(&s, 14, 29, 15);
	sketch_free(&s), sketch_free(&torus);
	/* A hole of three edges would close. */
	struct sketch cup = rig_make(octahedron_xyz, 6, (const int[]){0, 2, 4, -1, 2, 1, 4, -1, 1, 3, 4, -1, 3, 0, 4, -1, 2, 0, 5, -1, 1, 2, 5, -1, 3, 1, 5, -1, -2},
	                             rig_no_pairs);
	assert_refused(&cup, MOVE_COLLAPSE, 0, 3);
	assert_refused(&cup, MOVE_COLLAPSE, 3, 0);
	sketch_free(&cup);
}

static void test_remove(void **state)
{
	(void)state;
	struct sketch s, octahedron = rig_make(octahedron_xyz, 6, octahedron_faces, rig_no_pairs);
	assert_true(apply(&s, &octahedron, MOVE_REMOVE, 4, -1));
	assert_counts(&s, 5, 8, 5);
	assert_face(&s, 0, 2, 1, 3);
	sketch_free(&s), sketch_free(&octahedron);
	/* A corner of a smooth cube: its three neighbours are left with two edges. What is left is a tetrahedron. */
	struct sketch cube = rig_cube(false);
	assert_true(apply(&s, &cube, MOVE_REMOVE, 6, -1));
	assert_counts(&s, 4, 6, 4);
	assert_face(&s, 1, 3, 4);
	assert_refused(&s, MOVE_REMOVE, 6, -1); /* gone */
	sketch_free(&s), sketch_free(&cube);
	cube = rig_cube(true);
	assert_refused(&cube, MOVE_REMOVE, 6, -1);
	sketch_free(&cube);
	struct sketch square = rig_quads(2, 2, false);
	assert_refused(&square, MOVE_REMOVE, 1, -1);
	assert_true(apply(&s, &square, MOVE_REMOVE, 4, -1));
	assert_counts(&s, 8, 8, 1); /* the square's rim */
	sketch_free(&s), sketch_free(&square);
}

static void test_swap(void **state)
{
	(void)state;
	struct sketch s, t, octahedron = rig_make(octahedron_xyz, 6, octahedron_faces, rig_no_pairs);
	assert_true(apply(&s, &octahedron, MOVE_SWAP, 0, 2));
	assert_counts(&s, 6, 12, 8);
	assert_face(&s, 0, 5, 4);
	assert_face(&s, 2, 4, 5);
	/* The ends have three edges now, the other two five. Swapped again it is as before. */
	assert_int_equal(sketch_star(&s, 0).valence, 3);
	assert_int_equal(sketch_star(&s, 4).valence, 5);
	assert_true(apply(&t, &s, MOVE_SWAP, 4, 5));
	assert_face(&t, 0, 2, 4);
	assert_face(&t, 2, 0, 5);
	sketch_free(&t), sketch_free(&s), sketch_free(&octahedron);
	/* In a tetrahedron the other diagonal is an edge already. */
	struct sketch tetrahedron = rig_make(tetrahedron_xyz, 4, tetrahedron_faces, rig_no_pairs);
	assert_refused(&tetrahedron, MOVE_SWAP, 0, 1);
	sketch_free(&tetrahedron);
	/* Smooth vertices of a cube would be left with two edges. */
	struct sketch cube = rig_cube(false);
	assert_refused(&cube, MOVE_SWAP, 0, 1);
	sketch_free(&cube);
	/* Quads: the edge 5-6 of the torus has 1 2 and 9 10 on its sides, and both ends go one corner on. */
	struct sketch torus = rig_quads(4, 4, true);
	assert_true(apply(&s, &torus, MOVE_SWAP, 5, 6));
	assert_counts(&s, 16, 32, 16);
	assert_int_equal(sketch_half(&s, 5, 6), NO_INDEX);
	assert_int_not_equal(sketch_half(&s, 10, 1), NO_INDEX);
	sketch_free(&s);
	/* Creases stay where they are. */
	const idx_t h = sketch_half(&torus, 5, 6);
	torus.sharp[h] = torus.sharp[torus.twin[h]] = 1;
	assert_refused(&torus, MOVE_SWAP, 5, 6);
	sketch_free(&torus);
}

static void test_chord(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(true), s;
	assert_true(apply(&s, &cube, MOVE_CHORD, 0, 2));
	assert_counts(&s, 8, 13, 7);
	assert_face(&s, 0, 3, 2);
	assert_face(&s, 0, 2, 1);
	assert_int_equal(s.sharp[sketch_half(&s, 0, 2)], 0);
	assert_refused(&s, MOVE_CHORD, 0, 2);
	sketch_free(&s);
	assert_refused(&cube, MOVE_CHORD, 0, 1); /* neighbours */
	assert_refused(&cube, MOVE_CHORD, 0, 6); /* no face has both */
	sketch_free(&cube);
	/* Two faces back to back take one such edge together. */
	struct sketch lens = rig_make(lens_xyz, 4, lens_faces, lens_rim);
	assert_true(apply(&s, &lens, MOVE_CHORD, 0, 2));
	assert_refused(&s, MOVE_CHORD, 0, 2);
	sketch_free(&s), sketch_free(&lens);
	/* A cap of eight corners, from 0 to 3: four and six. */
	struct sketch prism = rig_prism(8);
	assert_true(apply(&s, &prism, MOVE_CHORD, 11, 8));
	assert_face(&s, 8, 9, 10, 11);
	assert_face(&s, 11, 12, 13, 14, 15, 8);
	sketch_free(&s), sketch_free(&prism);
}

static void test_split(void **state)
{
	(void)state;
	/* On a smooth edge the new vertex needs more than two edges: both faces are cut. */
	struct sketch cube = rig_cube(false), s;
	assert_true(apply(&s, &cube, MOVE_SPLIT, 0, 1));
	assert_counts(&s, 9, 15, 8);
	assert_int_equal(s.id[8], 8);
	assert_int_equal(s.next_id, 9);
	assert_int_equal(sketch_star(&s, 8).valence, 4);
	assert_near(s.xyz[24], 0, 1e-15), assert_near(s.xyz[25], -0.5, 1e-15), assert_near(s.xyz[26], -0.5, 1e-15);
	sketch_free(&s), sketch_free(&cube);
	/* On a crease it needs no more. */
	cube = rig_cube(true);
	assert_true(apply(&s, &cube, MOVE_SPLIT, 0, 1));
	assert_counts(&s, 9, 13, 6);
	assert_int_equal(sketch_star(&s, 8).sharp, 2);
	assert_face(&s, 0, 8, 1, 5, 4);
	sketch_free(&s), sketch_free(&cube);
	struct sketch square = rig_quads(2, 2, false);
	assert_true(apply(&s, &square, MOVE_SPLIT, 0, 1));
	assert_counts(&s, 10, 13, 4);
	sketch_free(&s);
	assert_true(apply(&s, &square, MOVE_SPLIT, 1, 0)); /* from the side without a face */
	assert_counts(&s, 10, 13, 4);
	sketch_free(&s);
	assert_refused(&square, MOVE_SPLIT, 0, 4); /* a diagonal */
	sketch_free(&square);
}

static void test_tags(void **state)
{
	(void)state;
	struct sketch cube = rig_cube(false), s, t;
	assert_true(apply(&s, &cube, MOVE_CREASE, 0, 1));
	assert_int_equal(s.sharp[sketch_half(&s, 0, 1)], 1);
	assert_int_equal(s.sharp[sketch_half(&s, 1, 0)], 1);
	assert_true(apply(&t, &s, MOVE_CREASE, 1, 0));
	assert_int_equal(t.sharp[sketch_half(&t, 0, 1)], 0);
	sketch_free(&t), sketch_free(&s);
	/* A vertex without or with one crease is no corner, and one with three is one by itself. */
	assert_refused(&cube, MOVE_CORNER, 0, -1);
	sketch_free(&cube);
	cube = rig_cube(true);
	assert_refused(&cube, MOVE_CORNER, 0, -1);
	sketch_free(&cube);
	struct sketch prism = rig_prism(6);
	assert_true(apply(&s, &prism, MOVE_CORNER, 3, -1));
	assert_int_equal(s.corner[3], 1);
	assert_true(apply(&t, &s, MOVE_CORNER, 3, -1));
	assert_int_equal(t.corner[3], 0);
	sketch_free(&t), sketch_free(&s), sketch_free(&prism);
	/* Borders are creases; and so are the edges of a vertex that has but two. */
	struct sketch square = rig_quads(2, 2, false), lens = rig_make(lens_xyz, 4, lens_faces, lens_rim);
	assert_refused(&square, MOVE_CREASE, 0, 1);
	assert_refused(&lens, MOVE_CREASE, 0, 1);
	sketch_free(&square), sketch_free(&lens);
}

/* --- many moves -------------------------------------------------------------------------------------------------------------- */

/* Numbers without a pattern that matters, always the same. */
static uint32_t lot(uint32_t *seed) { return (*seed = *seed * 1664525u + 1013904223u) >> 8; }

/* Two cubes side by side, one open, the other with creases. */
static struct sketch two_pieces(void)
{
	double xyz[48];
	int faces[64], k = 0;
	for (int i = 0; i < 24; i++)
		xyz[i] = cube_xyz[i], xyz[24 + i] = cube_xyz[i] + (i % 3 == 0 ? 3 : 0);
	for (int piece = 0; piece < 2; piece++)
		for (int i = piece ? 0 : 5; cube_faces[i] != -2; i++)
			faces[k++] = cube_faces[i] < 0 ? -1 : cube_faces[i] + 8 * piece;
	faces[k] = -2;
	return rig_make(xyz, 16, faces, (const int[]){8, 9, 9, 10, 10, 11, 8, 11, -1, -1});
}

/* Whatever the moves and their order: a manifold of the same topology that can be subdivided; a refused move leaves no trace; and all kinds
 * of moves are possible somewhere. */
static void test_any_moves(void **state)
{
	(void)state;
	size_t done[MOVE_KINDS] = {0}, refused = 0;
	for (int start = 0; start < 4; start++) {
		uint32_t seed = 77u + (uint32_t)start;
		struct sketch s = start == 0 ? rig_quads(6, 5, true) : start == 1 ? rig_quads(5, 5, false) : start == 2 ? two_pieces() : rig_prism(9);
		for (int i = 0; i < 1500; i++) {
			const idx_t h = (idx_t)(lot(&seed) % s.face_start[s.face_count]), f = s.face[h];
			const size_t far = lot(&seed) % sketch_degree(&s, f);
			enum move_kind kind = lot(&seed) % MOVE_KINDS;
			if (s.vertex_count < 14 && kind < MOVE_SWAP)
				kind = lot(&seed) % 2 ? MOVE_SPLIT : MOVE_CHORD; /* keep something to work on */
			const idx_t a = s.id[s.face_corner[h]];
			const idx_t b = kind == MOVE_REMOVE || kind == MOVE_CORNER ? -1
			                : kind == MOVE_CHORD                      ? s.id[s.face_corner[s.face_start[f] + far]]
			                                                          : s.id[sketch_head(&s, h)];
			struct sketch out;
			if (!apply(&out, &s, kind, a, b)) {
				refused++;
				continue;
			}
			done[kind]++;
			sketch_free(&s);
			s = out;
		}
		/* and it can be: subdivision of a manifold multiplies its faces. */
		struct rig_mesh fine = rig_dense(&s, 1);
		assert_true(fine.triangle_count >= 3 * s.face_count);
		for (size_t i = 0; i < 3 * fine.vertex_count; i++)
			assert_true(isfinite(fine.xyz[i]));
		rig_mesh_free(&fine);
		sketch_free(&s);
	}
	for (int kind = 0; kind < MOVE_KINDS; kind++)
		if (done[kind] < 10)
			fail_msg("only %zu moves of kind %d were possible", done[kind], kind);
	assert_true(refused > 100);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_cube),    cmocka_unit_test(test_border), cmocka_unit_test(test_round_trip), cmocka_unit_test(test_two_edges),
		cmocka_unit_test(test_merge),   cmocka_unit_test(test_collapse), cmocka_unit_test(test_remove),   cmocka_unit_test(test_swap),
		cmocka_unit_test(test_chord),   cmocka_unit_test(test_split),  cmocka_unit_test(test_tags),       cmocka_unit_test(test_any_moves),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
