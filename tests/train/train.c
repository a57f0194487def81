/* Trains the tables of the FFX coder and writes formats/ffx_tables.c to stdout.
 *
 *	make build/train build/corpus build/descend
 *	mkdir cages searched
 *	build/corpus cages mesh.stl ...
 *	build/descend searched 0 (all in cages)
 *	build/train [--all] (all in searched and cages) [other cages.ply ...] > build/ffx_tables.c
 *	mv build/ffx_tables.c formats/ffx_tables.c
 *
 * The corpus: cages made by code (tests/fixtures/samplecages.h) and the cages given. Those with whole numbers for coordinates are
 * taken as they are, others on several grids; each from several start edges and by both methods. Searching and training take
 * turns, as a search knows the tables that are compiled in. Only counts, histograms and mixing weights of all cages together end
 * up in the tables: 57 kB. Parts to be measured later must not be among the meshes.
 *
 * 1. Counts of every context and residual class over the corpus, scaled down so that a stream's own statistics can take over.
 * 2. Mixing weights, learned over several passes on one half of the corpus with counts from the other half, and the other way
 *    round: weights learned on the counts' own cages would trust them too much.
 * 3. All counts together with the weights of both halves.
 * On stderr: bits a vertex on a third set that nothing is learned from, before and after; with --all its counts are used too, once
 * everything is settled. New tables are a new stream version (FFX_VERSION) once streams have been given away. */
#include <stdio.h>

#include "formats/ffx_payload.h"
#include "formats/mesh.h"
#include "tests/fixtures/samplecages.h"

#define MADE_CAGES 300
#define COUNT_CAP 30 /* observations that a context starts with at most */
#define HISTOGRAM_CAP 40
#define PASSES 7
#define GIVEN_TIMES 2

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

static void tables_load(struct ffx_model *model, const struct tables *tables)
{
	for (size_t i = 0; i < 2 * FFX_CONTEXTS; i++)
		model->count[i] = (uint16_t)(tables->count[i] * 4);
	for (size_t i = 0; i < FFX_WEIGHTS; i++)
		model->weight[i] = tables->weight[i] * 16;
	memcpy(model->histogram, tables->histogram, sizeof model->histogram);
	model->training = NULL;
}

/* As they are written out. */
struct packed {
	unsigned char context[2 * FFX_CONTEXTS];
	size_t context_size;
	signed char weight[FFX_WEIGHTS];
	unsigned char histogram[FFX_HISTOGRAMS * TABLE_CLASSES];
};

static double logit_of(double zero, double one)
{
	return log2((one + 0.4) / (zero + 0.4));
}

static unsigned pack_context(double zero, double one)
{
	unsigned best_code = 0;
	double best = HUGE_VAL;
	for (unsigned code = 1; code <= TABLE_LEVELS * TABLE_SHARES && zero + one > 0.2; code++) {
		uint16_t count[2];
		model_context_of(count, code);
		const double off = fabs(logit_of(zero, one) - logit_of(count[0] / 32.0, count[1] / 32.0)) +
				   0.2 * fabs(log2((zero + one) / ((count[0] + count[1]) / 32.0)));
		if (off < best) {
			best = off;
			best_code = code;
		}
	}
	return best_code;
}

static void pack(struct packed *packed, const struct tables *tables)
{
	packed->context_size = 0;
	for (size_t i = 0; i < FFX_CONTEXTS; i++) {
		const unsigned code = pack_context(tables->count[2 * i] / 8.0, tables->count[2 * i + 1] / 8.0);
		unsigned char *at = packed->context + packed->context_size;
		if (code > 0) {
			*at = (unsigned char)code;
			packed->context_size++;
		} else if (i > 0 && packed->context_size >= 2 && at[-2] == 0 && at[-1] < 255) {
			at[-1]++;
		} else {
			at[0] = 0;
			at[1] = 1;
			packed->context_size += 2;
		}
	}
	for (size_t i = 0; i < FFX_WEIGHTS; i++) {
		const double value = round(tables->weight[i] / 64.0);
		packed->weight[i] = (signed char)(value > 127 ? 127 : value < -127 ? -127 : value);
	}
	for (size_t i = 0; i < FFX_HISTOGRAMS; i++)
		for (size_t k = 0; k < TABLE_CLASSES; k++) {
			const double value = round(16 * log2(tables->histogram[i * HISTOGRAM_CLASSES + (k ? 2 * k - 1 : 0)]));
			packed->histogram[i * TABLE_CLASSES + k] = (unsigned char)(value > 255 ? 255 : value);
		}
}

static const enum ffx_method methods[2] = {FFX_FORWARD, FFX_FACE_FIXER};
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
	/* 6.1 to 8.4 bits, most of them between 6.7 and 7.8; one in six finer, up to 12 */
	return sample_chance(1.0 / 6) ? 76 + sample_random(68) : 50 + sample_random(18) + sample_random(18);
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

/* The grid of a cage whose coordinates are whole numbers already (tests/train/descend.c); FFX_GRID_CODES of others. */
static unsigned whole_grid(const struct cage *cage)
{
	const double side = mesh_bounds(cage->xyz, cage->vertex_count, NULL, NULL);
	for (size_t i = 0; i < 3 * cage->vertex_count; i++)
		if (cage->xyz[i] != floor(cage->xyz[i]))
			return FFX_GRID_CODES;
	const unsigned code = side < 60000 ? ffx_grid_code((int32_t)side) : FFX_GRID_CODES;
	return code < FFX_GRID_CODES && ffx_grid_steps(code) == (int32_t)side ? code : FFX_GRID_CODES;
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
		const unsigned whole = whole_grid(&cage);
		for (int k = 0; k < GIVEN_TIMES && (k == 0 || whole == FFX_GRID_CODES); k++)
			add_cage(&cage, (unsigned)i / 12 % 3, whole < FFX_GRID_CODES ? whole : random_code(),
				 true); /* variants of a part follow each other: keep them together */
	}
}

/* --- learning ------------------------------------------------------------------------------------------------------ */

/* Encode one item from a start edge chosen by pass; returns the report. */
static struct payload_report encode(struct ffx_model *model, const struct item *it, enum ffx_method method, unsigned pass)
{
	static struct forward forward;
	struct ffx_coder coder = {.model = model};
	range_encode(&coder.range);
	struct payload_report report;
	struct fault fault = {0};
	const idx_t root = (idx_t)((size_t)pass * 7919 % it->payload.surface.half_count);
	if (!payload_encode(&coder, &report, &it->payload, method, root, &forward, &fault)) {
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
			for (size_t m = 0; m < 2; m++) {
				tables_load(model, start);
				model->training = training;
				encode(model, &item[i], methods[m], pass);
			}
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
		for (size_t k = 1; k + 1 < HISTOGRAM_CLASSES; k += 2) /* a mirrored cage is as likely */
			n[k] = n[k + 1] = (n[k] + n[k + 1]) / 2;
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
		for (size_t m = 0; m < 2; m++) {
			tables_load(model, tables);
			memcpy(model->weight, weight, sizeof model->weight);
			model->training = scratch;
			const struct payload_report report = encode(model, &item[i], methods[m], pass);
			bits += total_bits(&report);
			memcpy(weight, model->weight, sizeof model->weight);
		}
	}
	free(model);
	free(scratch);
	return bits;
}

static void evaluate(const struct tables *tables, const struct packed *packed, const char *name)
{
	struct ffx_model *model = mem_array(1, sizeof *model);
	for (int n = 0; n < 4; n++) {
		const int given = n / 2;
		double c = 0, g = 0, f = 0, vertices = 0, raw = 0;
		for (size_t i = 0; i < item_count; i++) {
			if (item[i].set != 2 || item[i].is_given != given)
				continue;
			if (packed)
				model_unpack(model, packed->context, packed->weight, packed->histogram);
			else
				tables_load(model, tables);
			const struct payload_report report = encode(model, &item[i], methods[n % 2], 0);
			c += (double)report.cost_c / 4096;
			g += (double)report.cost_g / 4096;
			f += (double)report.cost_f / 4096;
			vertices += (double)item[i].ffx.vertex_count;
			raw += 3 * log2(ffx_grid_steps(item[i].ffx.grid_code) + 1) * (double)item[i].ffx.vertex_count;
		}
		if (vertices > 0)
			fprintf(stderr, "train: %s %s, %s: bits a vertex: C %.2f G %.2f (of %.1f) F %.2f, together %.2f\n", name,
				given ? "given" : "made", n % 2 ? "Face Fixer" : "forward", c / vertices, g / vertices,
				raw / vertices, f / vertices, (c + g + f) / vertices);
	}
	free(model);
}

/* --- output -------------------------------------------------------------------------------------------------------- */

static void print_array(const char *declaration, const void *from, size_t count, bool is_signed)
{
	printf("\nconst %s = {", declaration);
	int column = 200;
	for (size_t i = 0; i < count; i++) {
		char text[32];
		const int value = is_signed ? ((const signed char *)from)[i] : ((const unsigned char *)from)[i];
		const int length = snprintf(text, sizeof text, "%d,", value);
		if (column + length > 130) {
			printf("\n\t");
			column = 4;
		}
		fputs(text, stdout);
		column += length;
	}
	printf("\n};\n");
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
		tables->weight[i] = i < WEIGHT_EXPERT || i >= WEIGHT_ASK ? 1200 : i >= WEIGHT_SECOND ? 0 : 1000;
	for (size_t i = 0; i < FFX_HISTOGRAMS * HISTOGRAM_CLASSES; i++)
		tables->histogram[i] = 20;
	evaluate(tables, NULL, "untrained");
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
			const double bits = learn_weights(weight, &half[s], s ? 2 : 1, pass, 14 + (int)(pass / 2));
			fprintf(stderr, "train: pass %u half %u: %.0f bits\n", pass, s, bits);
		}
	count_set(training, is_final ? 7 : 3, tables);
	make_tables(tables, training);
	for (size_t i = 0; i < FFX_WEIGHTS; i++) {
		const double value = round(weight[i] / 16.0);
		tables->weight[i] = (short)(value > 32767 ? 32767 : value < -32768 ? -32768 : value);
	}
	evaluate(tables, NULL, "trained");
	struct packed *packed = mem_array(1, sizeof *packed);
	pack(packed, tables);
	evaluate(NULL, packed, "packed");
	fprintf(stderr, "train: %zu bytes of tables\n", packed->context_size + sizeof packed->weight + sizeof packed->histogram);
	printf("/* Initial counts, weights and histograms of FFX, written by tests/train/train.c. Do not edit. */\n#include "
	       "\"formats/ffx_model.h\"\n");
	print_array("unsigned char ffx_table_context[]", packed->context, packed->context_size, false);
	print_array("signed char ffx_table_weight[FFX_WEIGHTS]", packed->weight, FFX_WEIGHTS, true);
	print_array("unsigned char ffx_table_histogram[FFX_HISTOGRAMS * TABLE_CLASSES]", packed->histogram,
		    sizeof packed->histogram, false);
	return 0;
}
