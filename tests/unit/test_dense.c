#include "tests/unit/helpers.h"

#include "formats/dense.h"

/* A square of two triangles, folded along the diagonal 0 2 by a sharp edge: vertices 0 and 2 have two wedges each. */
static struct dense folded_square(void)
{
	static const double xyz[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 1};
	static const idx_t triangle[6] = {0, 1, 2, 0, 2, 3}, triangle_wedge[6] = {0, 2, 3, 1, 4, 5};
	static const idx_t wedge_vertex[6] = {0, 0, 1, 2, 2, 3};
	static const struct dense_edge edge[5] = {{0, 2, -54.735610317245346, EDGE_SHARP}, {0, 1, 0, EDGE_BORDER},
	                                          {1, 2, 0, EDGE_BORDER}, {2, 3, 0, EDGE_BORDER}, {3, 0, 0, EDGE_CUT}};
	static const unsigned char quality[6] = {WEDGE_FLAT, WEDGE_GOOD, WEDGE_ISOTROPIC, WEDGE_SINGULAR, WEDGE_FLAT, WEDGE_FLAT};
	struct dense d = {.vertex_count = 4, .triangle_count = 2, .wedge_count = 6, .edge_count = 5};
	d.xyz = mem_copy(xyz, 12, sizeof *xyz);
	d.triangle = mem_copy(triangle, 6, sizeof *triangle);
	d.triangle_wedge = mem_copy(triangle_wedge, 6, sizeof *triangle_wedge);
	d.wedge_vertex = mem_copy(wedge_vertex, 6, sizeof *wedge_vertex);
	d.wedge_normal = mem_array(18, sizeof *d.wedge_normal);
	d.dmin = mem_array(18, sizeof *d.dmin);
	d.kmin = mem_array(6, sizeof *d.kmin);
	d.kmax = mem_array(6, sizeof *d.kmax);
	d.anisotropy = mem_array(6, sizeof *d.anisotropy);
	d.quality = mem_copy(quality, 6, 1);
	d.edge = mem_copy(edge, 5, sizeof *edge);
	for (int w = 0; w < 6; w++) {
		d.wedge_normal[3 * w + 2] = 1;
		d.dmin[3 * w] = 1;
		d.kmin[w] = -0.1 * w;
		d.kmax[w] = 1.0 / 3 * w;
		d.anisotropy[w] = 0.5;
	}
	return d;
}

static void add_labels(struct dense *d)
{
	static const struct dense_patch patch[2] = {
		{.kind = PATCH_CONE, .point = {1, 2, 3}, .axis = {0, 0, 1}, .radius2 = 30, .sign = -1, .area = 0.5, .residual = 1e-3, .parent = 7},
		{.kind = PATCH_TORUS, .point = {4, 5, 6}, .axis = {1, 0, 0}, .radius = 9, .radius2 = 2, .sign = 1, .area = 0.7, .parent = 1},
	};
	d->label = mem_array(2, sizeof *d->label);
	d->label[1] = 1;
	d->patch_count = 2;
	d->patch = mem_copy(patch, 2, sizeof *patch);
}

static void assert_same(const struct dense *a, const struct dense *b)
{
	assert_int_equal(a->vertex_count, b->vertex_count);
	assert_int_equal(a->triangle_count, b->triangle_count);
	assert_int_equal(a->wedge_count, b->wedge_count);
	assert_int_equal(a->edge_count, b->edge_count);
	assert_int_equal(a->patch_count, b->patch_count);
	assert_memory_equal(a->xyz, b->xyz, 3 * a->vertex_count * sizeof *a->xyz);
	assert_memory_equal(a->triangle, b->triangle, 3 * a->triangle_count * sizeof *a->triangle);
	assert_memory_equal(a->triangle_wedge, b->triangle_wedge, 3 * a->triangle_count * sizeof *a->triangle);
	assert_memory_equal(a->wedge_vertex, b->wedge_vertex, a->wedge_count * sizeof *a->wedge_vertex);
	assert_memory_equal(a->wedge_normal, b->wedge_normal, 3 * a->wedge_count * sizeof *a->wedge_normal);
	assert_memory_equal(a->kmin, b->kmin, a->wedge_count * sizeof *a->kmin);
	assert_memory_equal(a->kmax, b->kmax, a->wedge_count * sizeof *a->kmax);
	assert_memory_equal(a->dmin, b->dmin, 3 * a->wedge_count * sizeof *a->dmin);
	assert_memory_equal(a->anisotropy, b->anisotropy, a->wedge_count * sizeof *a->anisotropy);
	assert_memory_equal(a->quality, b->quality, a->wedge_count);
	for (size_t e = 0; e < a->edge_count; e++) {
		assert_int_equal(a->edge[e].vertex1, b->edge[e].vertex1);
		assert_int_equal(a->edge[e].vertex2, b->edge[e].vertex2);
		assert_int_equal(a->edge[e].kind, b->edge[e].kind);
		assert_true(a->edge[e].angle_deg == b->edge[e].angle_deg);
	}
	for (size_t p = 0; p < a->patch_count; p++) {
		const struct dense_patch *x = &a->patch[p], *y = &b->patch[p];
		assert_int_equal(x->kind, y->kind);
		assert_int_equal(x->parent, y->parent);
		assert_memory_equal(x->point, y->point, sizeof x->point);
		assert_memory_equal(x->axis, y->axis, sizeof x->axis);
		assert_true(x->radius == y->radius && x->radius2 == y->radius2 && x->sign == y->sign && x->area == y->area &&
		            x->residual == y->residual);
	}
	assert_true((a->label == NULL) == (b->label == NULL));
	if (a->label)
		assert_memory_equal(a->label, b->label, a->triangle_count * sizeof *a->label);
}

static void everything_comes_back(void **state)
{
	(void)state;
	for (int labelled = 0; labelled < 2; labelled++) {
		struct dense d = folded_square(), back;
		if (labelled)
			add_labels(&d);
		struct ply ply, again;
		ply_init(&ply);
		dense_to_ply(&ply, &d);
		for (int encoding = PLY_ASCII; encoding <= PLY_BINARY_BIG; encoding++) {
			/* through bytes, not only through the document */
			size_t size;
			ply.encoding = (enum ply_encoding)encoding;
			char *text = ply_text(&ply, &size);
			struct input input = input_of(text, size);
			struct fault fault = {0};
			assert_true(ply_read(&again, &input, &fault));
			assert_true(dense_from_ply(&back, &again, labelled, "t.ply", &fault));
			assert_same(&d, &back);
			dense_free(&back);
			ply_free(&again);
			input_free(&input);
			free(text);
		}
		ply_free(&ply);
		dense_free(&d);
	}
}

static void labels_leave_the_rest_alone(void **state)
{
	(void)state;
	struct dense d = folded_square(), back;
	struct fault fault = {0};
	struct ply ply;
	ply_init(&ply);
	dense_to_ply(&ply, &d);
	/* what another program added */
	ply_put_scalar(ply_element(&ply, "face"), "red", PLY_UINT8)[1] = 200;
	ply_put_scalar(ply_element(&ply, "vertex"), "colour", PLY_UINT8)[3] = 100;
	ply_put_scalar(ply_put_element(&ply, "camera", 1), "zoom", PLY_FLOAT64)[0] = 2.5;
	assert_false(dense_from_ply(&back, &ply, true, "t.ply", &fault));
	assert_string_equal(fault.text, "t.ply: there is no element 'patch'");
	add_labels(&d);
	dense_labels_to_ply(&ply, &d);
	assert_true(ply_column(ply_element(&ply, "face"), "red")->value[1] == 200);
	assert_true(ply_column(ply_element(&ply, "vertex"), "colour")->value[3] == 100);
	assert_true(ply_column(ply_element(&ply, "camera"), "zoom")->value[0] == 2.5);
	fault = (struct fault){0};
	assert_true(dense_from_ply(&back, &ply, true, "t.ply", &fault));
	assert_same(&d, &back);
	dense_free(&back);
	dense_free(&d);
	ply_free(&ply);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(everything_comes_back),
		cmocka_unit_test(labels_leave_the_rest_alone),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
