/* deviate: two surfaces in, how far they are apart out, as key=value lines.
 *
 * Area-uniform samples of each surface, the nearest point of each on the other one, both ways (after Metro: Cignoni,
 * Rocchini and Scopigno 1998; the patch method's section 13.3). */
#include <math.h>
#include <stdlib.h>

#include "formats/mesh.h"
#include "stages/deviate/creases.h"
#include "stages/geometry/deviation.h"
#include "stages/geometry/trimesh.h"
#include "stages/tool/tool.h"

struct options {
	const char *path[2];
	struct deviation_options measure;
	double sharp_deg;              /* bending of what counts as a sharp edge */
	struct tool_length mean, max;  /* bounds; value 0: not asked for */
	struct tool_common common;
};

static const char usage[] =
	"usage: deviate [-qv] [--samples n] [--seed n] [--sharp degrees]\n"
	"               [--mean length] [--max length] [-o file] original other\n";

static struct options parse_options(int argc, char **argv)
{
	struct options opt = {.measure = DEVIATION_DEFAULTS, .sharp_deg = 40};
	int samples = (int)opt.measure.samples, seed = (int)opt.measure.seed;
	const struct tool_option table[] = {
		{"samples", 0, TOOL_INTEGER, &samples, 100, 100000000},
		{"seed", 0, TOOL_INTEGER, &seed, 0, 2147483646},
		{"sharp", 0, TOOL_NUMBER, &opt.sharp_deg, 0, 180},
		{"mean", 0, TOOL_LENGTH, &opt.mean, 0, 0},
		{"max", 0, TOOL_LENGTH, &opt.max, 0, 0},
		{0},
	};
	const int first = tool_options(argc, argv, usage, table, &opt.common, 2, 2);
	opt.path[0] = argv[first];
	opt.path[1] = argv[first + 1];
	opt.measure.samples = (size_t)samples;
	opt.measure.seed = (uint64_t)seed;
	return opt;
}

static void read_surface(struct trimesh *surface, const char *path)
{
	struct fault fault = {0};
	struct input input;
	struct mesh mesh;
	if (!input_read(&input, path, &fault) || !mesh_read(&mesh, &input, &fault) || !trimesh_from_mesh(surface, &mesh, input.shown, &fault))
		tool_fail(&fault);
	if (!(surface->area > 0) || !isfinite(surface->area))
		tool_die(EX_BAD_INPUT, "%s: a surface %s", input.shown, surface->area > 0 ? "with an area beyond all numbers" : "without area");
	input_free(&input);
}

static void print_surface(FILE *file, const char *name, const struct trimesh *surface)
{
	fprintf(file, "%s_vertices=%zu\n", name, surface->used_count);
	fprintf(file, "%s_faces=%zu\n", name, surface->mesh.face_count);
	fprintf(file, "%s_triangles=%zu\n", name, surface->triangle_count);
	fprintf(file, "%s_degenerate=%zu\n", name, surface->degenerate_count);
	fprintf(file, "%s_open_edges=%zu\n", name, surface->open_count);
	fprintf(file, "%s_nonmanifold_edges=%zu\n", name, surface->nonmanifold_count);
	fprintf(file, "%s_area=%.9g\n", name, surface->area);
	fprintf(file, "%s_volume=%.9g\n", name, surface->volume);
}

static void print_side(FILE *file, const char *name, const struct deviation_side *side, const struct deviation *deviation)
{
	const struct {
		const char *key;
		double value;
	} line[] = {{"mean", side->mean}, {"rms", side->rms}, {"p50", side->p50}, {"p95", side->p95}, {"p99", side->p99}, {"max", side->max}};
	for (size_t i = 0; i < sizeof line / sizeof *line; i++) {
		fprintf(file, "%s_%s_abs=%.9g\n", name, line[i].key, line[i].value);
		fprintf(file, "%s_%s_diag=%.9g\n", name, line[i].key, line[i].value / deviation->diagonal);
		fprintf(file, "%s_%s_side=%.9g\n", name, line[i].key, line[i].value / deviation->side);
	}
	fprintf(file, "%s_normal_mean_deg=%.6g\n", name, side->normal_mean_deg);
	fprintf(file, "%s_normal_rms_deg=%.6g\n", name, side->normal_rms_deg);
	fprintf(file, "%s_normal_p95_deg=%.6g\n", name, side->normal_p95_deg);
	fprintf(file, "%s_normal_max_deg=%.6g\n", name, side->normal_max_deg);
	fprintf(file, "%s_turned_share=%.6g\n", name, side->turned_share);
	fprintf(file, "%s_folded_share=%.6g\n", name, side->folded_share);
}

static void print_point(FILE *file, const char *name, const double point[3])
{
	fprintf(file, "%s=%.9g,%.9g,%.9g\n", name, point[0], point[1], point[2]);
}

static void print_creases(FILE *file, const struct trimesh surface[2], const struct options *opt, double side)
{
	static const char *const name[3] = {"ab", "ba", "sym"};
	/* A sharp edge that comes back a little blunter was found again all the same: what it is compared with may bend half as much. */
	struct creases creases[2], blunter[2];
	struct crease_distance distance[3];
	for (int i = 0; i < 2; i++) {
		creases_find(&creases[i], surface[i].mesh.xyz, surface[i].triangle, surface[i].triangle_count, opt->sharp_deg);
		creases_find(&blunter[i], surface[i].mesh.xyz, surface[i].triangle, surface[i].triangle_count, opt->sharp_deg / 2);
		fprintf(file, "%c_sharp_length=%.9g\n", "ab"[i], creases[i].length);
	}
	bool is_known[2];
	for (int i = 0; i < 2; i++) {
		is_known[i] = creases[i].count > 0 && blunter[1 - i].count > 0;
		if (is_known[i])
			creases_distance(&distance[i], surface[i].mesh.xyz, &creases[i], surface[1 - i].mesh.xyz, surface[1 - i].mesh.vertex_count,
			                 &blunter[1 - i], opt->measure.samples / 10);
	}
	if (is_known[0] && is_known[1]) {
		distance[2].mean = (distance[0].mean + distance[1].mean) / 2;
		distance[2].rms = hypot(distance[0].rms, distance[1].rms) / M_SQRT2;
		distance[2].p99 = fmax(distance[0].p99, distance[1].p99);
		distance[2].max = fmax(distance[0].max, distance[1].max);
	}
	for (int i = 0; i < 3; i++)
		if (i < 2 ? is_known[i] : is_known[0] && is_known[1]) {
			fprintf(file, "%s_sharp_mean_side=%.9g\n", name[i], distance[i].mean / side);
			fprintf(file, "%s_sharp_rms_side=%.9g\n", name[i], distance[i].rms / side);
			fprintf(file, "%s_sharp_p99_side=%.9g\n", name[i], distance[i].p99 / side);
			fprintf(file, "%s_sharp_max_side=%.9g\n", name[i], distance[i].max / side);
		}
	for (int i = 0; i < 2; i++) {
		if (is_known[i])
			print_point(file, i ? "ba_sharp_max_at" : "ab_sharp_max_at", distance[i].worst);
		creases_free(&creases[i]);
		creases_free(&blunter[i]);
	}
}

static bool exceeds(struct tool_length bound, double value, double side)
{
	return bound.value > 0 && value > tool_length_in_units(bound, side);
}

/* For people: the figures that say whether it is good, and where it is worst. */
static void report(const struct deviation *d, const struct trimesh surface[2], const struct options *opt)
{
	tool_say("mean distance %.4g, %.4g %% of the longest side; normals differ by %.3g degrees", d->both.mean, 100 * d->both.mean / d->side,
	         d->both.normal_mean_deg);
	for (int i = 0; i < 2; i++) {
		const struct deviation_side *s = i ? &d->ba : &d->ab;
		tool_say("farthest from the other one on %s: %.4g, %.4g %%, at %.6g %.6g %.6g", opt->path[i], s->max, 100 * s->max / d->side, s->worst[0],
		         s->worst[1], s->worst[2]);
	}
	tool_say("area %.4g and %.4g, volume %.4g and %.4g, open edges %zu and %zu", surface[0].area, surface[1].area, surface[0].volume, surface[1].volume,
	         surface[0].open_count, surface[1].open_count);
}

int main(int argc, char **argv)
{
	tool_init("deviate");
	const struct options opt = parse_options(argc, argv);
	struct trimesh surface[2];
	struct deviation_surface measured[2];
	for (int i = 0; i < 2; i++) {
		read_surface(&surface[i], opt.path[i]);
		measured[i] = (struct deviation_surface){surface[i].mesh.xyz, surface[i].mesh.vertex_count, surface[i].triangle,
		                                         surface[i].triangle_count};
	}
	struct fault fault = {0};
	struct deviation deviation;
	if (!deviation_measure(&deviation, &measured[0], &measured[1], &opt.measure, &fault))
		tool_fail(&fault);

	struct output output;
	if (!output_open(&output, opt.common.output, &fault))
		tool_fail(&fault);
	fprintf(output.file, "samples=%zu\nseed=%llu\n", opt.measure.samples, (unsigned long long)opt.measure.seed);
	fprintf(output.file, "bbox_diagonal=%.9g\nbbox_side=%.9g\n", deviation.diagonal, deviation.side);
	print_surface(output.file, "a", &surface[0]);
	print_surface(output.file, "b", &surface[1]);
	print_side(output.file, "ab", &deviation.ab, &deviation);
	print_side(output.file, "ba", &deviation.ba, &deviation);
	print_side(output.file, "sym", &deviation.both, &deviation);
	print_creases(output.file, surface, &opt, deviation.side);
	print_point(output.file, "ab_max_at", deviation.ab.worst);
	print_point(output.file, "ba_max_at", deviation.ba.worst);
	report(&deviation, surface, &opt);
	const bool is_over = exceeds(opt.mean, deviation.both.mean, deviation.side) || exceeds(opt.max, deviation.both.max, deviation.side);
	if (opt.mean.value > 0 || opt.max.value > 0)
		fprintf(output.file, "bounds=%s\n", is_over ? "exceeded" : "kept");
	if (!output_commit(&output, &fault))
		tool_fail(&fault);
	trimesh_free(&surface[0]);
	trimesh_free(&surface[1]);
	return is_over ? EX_NO : EX_DONE;
}
