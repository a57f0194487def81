/* Trains the tables of the FFX coder and writes formats/ffx_tables.c to stdout.
 *
 *	make build/train
 *	build/train [--all] [cage.ply ...] > build/ffx_tables.c && mv build/ffx_tables.c formats/ffx_tables.c
 *
 * The corpus: cages made by code (tests/fixtures/samplecages.h) and the cages given, each counted several times, on several grids
 *and from several start edges. Only counts, histograms and mixing weights of all of them together end up in the tables.
 *
 * 1. Counts of every context and residual class over the corpus, scaled down so that a stream's own statistics can take over.
 * 2. Mixing weights, learned over several passes on one half of the corpus with counts from the other half, and the other way
 *    round: weights learned on the counts' own cages would trust them too much.
 * 3. All counts together with the weights of both halves.
 * On stderr: bits a vertex on a third set that nothing is learned from, before and after; with --all its counts are used too,
 *once everything is settled. New tables are a new stream version (FFX_VERSION) once streams have been given away. */
#include <stdio.h>

#include "formats/ffx_payload.h"
#include "tests/fixtures/samplecages.h"

#define MADE_CAGES 900
#define COUNT_CAP 20 /* observations that a context starts with at most */
#define HISTOGRAM_CAP 16
#define PASSES 4
#define GIVEN_TIMES 4

struct item {
	struct ffx ffx;
	struct payload payload;
	unsigned set; /* 0, 1: training halves; 2: test */
	bool is_given;
};

struct tables {
	unsigned char count[2 * FFX_CONTEXTS];
	short weight[FFX_WEIGHTS];
	unsigned short histogram[FFX_HISTOGRAMS * HISTOGRAM_CLASSES];
};

static struct item *item;
static size_t item_count;

/* --- corpus ------------------------------------------------------------------------------------------------------- */

static void put_on_grid(struct ffx *ffx, const struct cage *cage, unsigned code)
{
	double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, side = 0;
	for (int pass = 0; pass < 2; pass++)
		for (size_t i = 0; i < 3 * cage->vertex_count; i++) {
			low[i % 3] = fmin(low[i % 3], cage->xyz[i]);
			if (pass == 1)
				side = fmax(side, cage->xyz[i] - low[i % 3]);
		}
	*ffx = (struct ffx){.scheme = cage->scheme,
			    .grid_code = code,
			    .vertex_count = cage->vertex_count,
			    .face_count = cage->face_count,
			    .sharp_count = cage->sharp_count};
	ffx->grid = mem_array(3 * cage->vertex_count, sizeof(int32_t));
	for (size_t i = 0; i < 3 * cage->vertex_count; i++)
		ffx->grid[i] = (int32_t)round((cage->xyz[i] - low[i % 3]) / side * ffx_grid_steps(code));
	ffx->face_corner = mem_copy(cage->face_corner, cage->face_start[cage->face_count], sizeof(idx_t));
	ffx->face_start = mem_copy(cage->face_start, cage->face_count + 1, sizeof(size_t));
	idx_t patches = 0; /* numbers that say nothing, one a face, are not learned */
	for (size_t f = 0; f < cage->face_count; f++)
		patches = cage->face_patch[f] >= patches ? cage->face_patch[f] + 1 : patches;
	if ((size_t)patches < cage->face_count * 3 / 4 && sample_chance(0.25))
		ffx->face_patch = mem_copy(cage->face_patch, cage->face_count, sizeof(idx_t));
	ffx->sharp = mem_copy(cage->sharp, 2 * cage->sharp_count, sizeof(idx_t));
	ffx->corner = mem_copy(cage->corner, cage->vertex_count, 1);
}

static void add_cage(const struct cage *cage, unsigned set, unsigned code, bool is_given)
{
	item = mem_resize(item, item_count + 1, sizeof *item);
	struct item *new = &item[item_count];
	put_on_grid(&new->ffx, cage, code);
	new->set = set;
	new->is_given = is_given;
	struct fault fault = {0};
	if (payload_prepare(&new->payload, &new->ffx, &fault))
		item_count++;
	else if (is_given)
		fprintf(stderr, "train: %s\n", fault.text);
}

static unsigned random_code(void)
{
	/* 6.5 to 11 bits, most of them between 7.5 and 9.5 */
	return 56 + sample_random(36) + sample_random(36);
}

static void make_cages(void)
{
	for (int i = 0; i < MADE_CAGES; i++) {
		sample_seed((uint64_t)i + 1);
		struct cage cage;
		switch (sample_random(8)) {
		case 0:
		case 1:
			cage = sample_random_turned();
			break;
		case 2:
			cage = sample_blocks(2 + (int)sample_random(3), 2 + (int)sample_random(2), 1 + (int)sample_random(2),
					     0.6);
			break;
		case 3:
		case 4:
			cage = sample_plate(1 + (int)sample_random(3), 1 + (int)sample_random(3), sample_real(0.1, 0.5), 0.4);
			break;
		case 5:
		case 6:
			cage = sample_extruded();
			break;
		default:
			cage = sample_torus(3 + (int)sample_random(6), 3 + (int)sample_random(4));
			break;
		}
		if (cage.face_count == 0) {
			cage_free(&cage);
			continue;
		}
		if (sample_chance(0.75)) {
			const uint32_t merges = (uint32_t)cage.face_count / (sample_chance(0.5) ? 2 : 4);
			sample_remesh(&cage, sample_random(merges + 1), sample_random((uint32_t)cage.face_count / 2 + 1));
		}
		sample_move(&cage, sample_chance(0.5) ? sample_real(0, 0.06) : 0, sample_chance(0.2));
		sample_tag(&cage, sample_real(20, 45), sample_chance(0.5) ? sample_real(0, 0.08) : 0);
		if (cage.vertex_count < 400)
			add_cage(&cage, (unsigned)i % 3, random_code(), false);
		cage_free(&cage);
	}
}

static void read_cages(int argc, char **argv)
{
	for (int i = 1; i < argc; i++) {
		if (strcmp(argv[i], "--all") == 0)
			continue;
		struct fault fault = {0};
		struct input input;
		struct ply ply;
		struct cage cage = {0};
		if (!input_read(&input, argv[i], &fault) || !ply_read(&ply, &input, &fault) ||
		    !cage_from_ply(&cage, &ply, argv[i], &fault)) {
			fprintf(stderr, "train: %s\n", fault.text);
			continue;
		}
		sample_seed((uint64_t)i);
		for (int k = 0; k < GIVEN_TIMES; k++)
			add_cage(&cage, (unsigned)i / 3 % 3, random_code(),
				 true); /* variants of a part follow each other: keep them together */
	}
}

/* --- learning ------------------------------------------------------------------------------------------------------ */

/* Encode one item from a start edge chosen by pass; returns the report. */
static struct payload_report encode(struct ffx_model *model, const struct item *it, unsigned pass)
{
	struct ffx_coder coder = {.model = model};
	range_encode(&coder.range);
	struct payload_report report;
	struct fault fault = {0};
	const idx_t root = (idx_t)((size_t)pass * 7919 % it->payload.surface.half_count);
	if (!payload_encode(&coder, &report, &it->payload, root, &fault)) {
		fprintf(stderr, "train: %s\n", fault.text);
		exit(EX_BUG);
	}
	free(coder.range.bytes);
	return report;
}

static void count_set(struct ffx_training *training, unsigned sets, const struct tables *start)
{
	struct ffx_model *model = mem_array(1, sizeof *model);
	memset(training, 0, sizeof *training);
	training->weight_shift = 20;
	for (size_t i = 0; i < item_count; i++)
		for (unsigned pass = 0; pass < 3 && sets >> item[i].set & 1; pass++) {
			model_load(model, start->count, start->weight, start->histogram);
			model->training = training;
			encode(model, &item[i], pass);
		}
	free(model);
}

/* Scale each pair of counts and each histogram down to its cap. */
static void make_tables(struct tables *tables, const struct ffx_training *training)
{
	for (size_t c = 0; c < FFX_CONTEXTS; c++) {
		const double n0 = (double)training->count[2 * c] / 3, n1 = (double)training->count[2 * c + 1] / 3;
		const double scale = n0 + n1 > COUNT_CAP ? COUNT_CAP / (n0 + n1) : 1;
		tables->count[2 * c] = (unsigned char)round(n0 * scale * 8);
		tables->count[2 * c + 1] = (unsigned char)round(n1 * scale * 8);
	}
	for (size_t h = 0; h < FFX_HISTOGRAMS; h++) {
		/* Histograms of neighbouring grids help each other where observations are few. */
		double sum = 0, n[HISTOGRAM_CLASSES];
		const size_t scale_class = h % SCALE_CLASSES;
		for (size_t k = 0; k < HISTOGRAM_CLASSES; k++) {
			n[k] = (double)training->histogram[h][k] / 3 + (k < 2 * 13 ? 0.05 : 0.005);
			if (scale_class > 0)
				n[k] += 0.1 * (double)training->histogram[h - 1][k < 3 ? k : k - 2] / 3;
			if (scale_class + 1 < SCALE_CLASSES)
				n[k] += 0.1 * (double)training->histogram[h + 1][k + 2 < HISTOGRAM_CLASSES && k > 0 ? k + 2 : k] /
					3;
			sum += n[k];
		}
		const double scale = sum > HISTOGRAM_CAP ? HISTOGRAM_CAP / sum : 1;
		for (size_t k = 0; k < HISTOGRAM_CLASSES; k++) {
			const double value = round(n[k] * scale * 64);
			tables->histogram[h * HISTOGRAM_CLASSES + k] = (unsigned short)(value < 1 ? 1 : value);
		}
	}
}

static double total_bits(const struct payload_report *report)
{
	return (double)(report->cost_c + report->cost_g + report->cost_f) / 4096;
}

/* One pass of weight learning over some sets; weights go on from *weight (1/65536). Returns bits. */
static double learn_weights(int32_t *weight, const struct tables *tables, unsigned sets, unsigned pass, int shift)
{
	struct ffx_model *model = mem_array(1, sizeof *model);
	struct ffx_training *scratch = mem_array(1, sizeof *scratch);
	scratch->weight_shift = shift;
	double bits = 0;
	for (size_t n = 0; n < item_count; n++) {
		const size_t i =
			(n * 7919 + pass * 104729) % item_count; /* mixed up, so that kinds of cages do not come in blocks */
		if (!(sets >> item[i].set & 1))
			continue;
		model_load(model, tables->count, tables->weight, tables->histogram);
		memcpy(model->weight, weight, sizeof model->weight);
		model->training = scratch;
		const struct payload_report report = encode(model, &item[i], pass);
		bits += total_bits(&report);
		memcpy(weight, model->weight, sizeof model->weight);
	}
	free(model);
	free(scratch);
	return bits;
}

static void evaluate(const struct tables *tables, const char *name)
{
	struct ffx_model *model = mem_array(1, sizeof *model);
	for (int given = 0; given < 2; given++) {
		double c = 0, g = 0, f = 0, vertices = 0, raw = 0;
		for (size_t i = 0; i < item_count; i++) {
			if (item[i].set != 2 || item[i].is_given != given)
				continue;
			model_load(model, tables->count, tables->weight, tables->histogram);
			const struct payload_report report = encode(model, &item[i], 0);
			c += (double)report.cost_c / 4096;
			g += (double)report.cost_g / 4096;
			f += (double)report.cost_f / 4096;
			vertices += (double)item[i].ffx.vertex_count;
			raw += 3 * log2(ffx_grid_steps(item[i].ffx.grid_code) + 1) * (double)item[i].ffx.vertex_count;
		}
		if (vertices > 0)
			fprintf(stderr, "train: %s %s: bits a vertex: C %.2f G %.2f (of %.1f) F %.2f, together %.2f\n", name,
				given ? "given" : "made", c / vertices, g / vertices, raw / vertices, f / vertices,
				(c + g + f) / vertices);
	}
	free(model);
}

/* --- output -------------------------------------------------------------------------------------------------------- */

static void print_array(const char *declaration, size_t count, long (*value)(const struct tables *, size_t),
			const struct tables *tables)
{
	printf("\nconst %s = {", declaration);
	int column = 200;
	for (size_t i = 0; i < count; i++) {
		char text[32];
		const int length = snprintf(text, sizeof text, "%ld,", value(tables, i));
		if (column + length > 130) {
			printf("\n\t");
			column = 4;
		}
		fputs(text, stdout);
		column += length;
	}
	printf("\n};\n");
}

static long count_value(const struct tables *tables, size_t i)
{
	return tables->count[i];
}
static long weight_value(const struct tables *tables, size_t i)
{
	return tables->weight[i];
}
static long histogram_value(const struct tables *tables, size_t i)
{
	return tables->histogram[i];
}

int main(int argc, char **argv)
{
	make_cages();
	read_cages(argc, argv);
	for (size_t i = 0; i < item_count; i++)
		item[i].payload.ffx = &item[i].ffx; /* the array moved while it grew */
	fprintf(stderr, "train: %zu cages\n", item_count);
	struct tables *tables = mem_array(1, sizeof *tables), *half = mem_array(2, sizeof *half);
	struct ffx_training *training = mem_array(1, sizeof *training);
	for (size_t i = 0; i < FFX_WEIGHTS; i++)
		tables->weight[i] = i < WEIGHT_EXPERT ? 1200 : 1000;
	for (size_t i = 0; i < FFX_HISTOGRAMS * HISTOGRAM_CLASSES; i++)
		tables->histogram[i] = 20;
	evaluate(tables, "untrained");
	/* Nothing is learned from set 2. */
	int32_t *weight = mem_array(FFX_WEIGHTS, sizeof *weight);
	for (size_t i = 0; i < FFX_WEIGHTS; i++)
		weight[i] = tables->weight[i] * 16;
	const bool is_final = argc > 1 && strcmp(argv[1], "--all") == 0;
	for (unsigned s = 0; s < 2; s++) {
		count_set(training, s ? 1u : 2u | (is_final ? 4u : 0), tables);
		half[s] = *tables;
		make_tables(&half[s], training);
	}
	for (unsigned pass = 0; pass < PASSES; pass++)
		for (unsigned s = 0; s < 2; s++) {
			const double bits = learn_weights(weight, &half[s], s ? 2 : 1, pass, 13 + (int)(pass < 3 ? pass / 2 : 2));
			fprintf(stderr, "train: pass %u half %u: %.0f bits\n", pass, s, bits);
		}
	count_set(training, is_final ? 7 : 3, tables);
	make_tables(tables, training);
	for (size_t i = 0; i < FFX_WEIGHTS; i++) {
		const double value = round(weight[i] / 16.0);
		tables->weight[i] = (short)(value > 32767 ? 32767 : value < -32768 ? -32768 : value);
	}
	evaluate(tables, "trained");
	printf("/* Initial counts, weights and histograms of FFX, written by tests/train/train.c. Do not edit. */\n#include "
	       "\"formats/ffx_model.h\"\n");
	print_array("unsigned char ffx_table_count[2 * FFX_CONTEXTS]", 2 * FFX_CONTEXTS, count_value, tables);
	print_array("short ffx_table_weight[FFX_WEIGHTS]", FFX_WEIGHTS, weight_value, tables);
	print_array("unsigned short ffx_table_histogram[FFX_HISTOGRAMS * HISTOGRAM_CLASSES]", FFX_HISTOGRAMS * HISTOGRAM_CLASSES,
		    histogram_value, tables);
	return 0;
}
