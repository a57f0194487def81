/* From border chains to a network of subdivision curves. */
#include "stages/fitcurves/netfit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/memory.h"
#include "stages/fitcurves/curvefit.h"
#include "stages/fitcurves/harmonise.h"
#include "stages/fitcurves/patchloops.h"
#include "stages/fitcurves/relax.h"
#include "stages/fitcurves/uncross.h"
#include "stages/geometry/nearest.h"
#include "stages/geometry/vector.h"

/* Cuts through one surface may be this many times as far off as other curves. */
#define CUT_SHARE 6

struct job {
	const struct dense *dense;
	const struct border_network *border;
	struct netfit_options options;
	double side;
	idx_t *node;             /* 2 a chain: the nodes at its ends (after contraction), NO_INDEX when closed */
	double *node_xyz;        /* 3 a node */
	bool *is_gone;           /* a chain: contracted */
	struct nearest *nearest; /* on dense, for relaxed borders; NULL when there are none */
	struct polyline *line;   /* a chain: what is fitted, drawn taut where it is relaxed */
	struct curvefit *fit;
	struct curvefit_options *limit;
	bool *is_relaxed;  /* loose borders */
	bool *is_smoothed; /* other jagged ones */
};

static double longest_side(const struct dense *dense)
{
	double side = 0;
	for (size_t k = 0; k < 3; k++) {
		double low = INFINITY, high = -INFINITY;
		for (size_t v = 0; v < dense->vertex_count; v++)
			low = fmin(low, dense->xyz[3 * v + k]), high = fmax(high, dense->xyz[3 * v + k]);
		side = fmax(side, high - low);
	}
	return side;
}

static double chain_length(const struct job *job, size_t c)
{
	const struct border_chain *chain = job->border->chain + c;
	const idx_t *v = job->border->vertex + chain->first;
	double length = 0;
	for (size_t i = 1; i < chain->count + chain->closed; i++)
		length += distance3(job->dense->xyz + 3 * (size_t)v[i - 1], job->dense->xyz + 3 * (size_t)v[i % chain->count]);
	return length;
}

/* --- contraction ------------------------------------------------------------------------------------------------- */

/* Passes of the contraction; what is left after them stays. */
#define MOST_PASSES 32

/* What the contraction looks at, as it was at the start of a pass. */
struct surroundings {
	struct patchloops loops;
	size_t *start;    /* node_count + 1 offsets into incident */
	size_t *incident; /* chains at each node; a chain from a node to itself twice */
	bool *touched;    /* a patch: beside or around a contraction of this pass, so that the loops are out of date there */
};

static void surroundings_init(struct surroundings *around, const struct job *job)
{
	const size_t n = job->border->chain_count, nodes = job->border->node_count;
	patchloops_init(&around->loops, job->border, job->node, job->is_gone, job->dense->patch_count);
	around->start = mem_array(nodes + 2, sizeof *around->start);
	around->incident = mem_array(2 * n, sizeof *around->incident);
	around->touched = mem_array(job->dense->patch_count, sizeof *around->touched);
	for (size_t i = 0; i < 2 * n; i++)
		if (!job->is_gone[i / 2] && job->node[i] != NO_INDEX)
			around->start[job->node[i] + 2]++;
	for (size_t v = 0; v < nodes; v++)
		around->start[v + 2] += around->start[v + 1];
	for (size_t i = 0; i < 2 * n; i++)
		if (!job->is_gone[i / 2] && job->node[i] != NO_INDEX)
			around->incident[around->start[job->node[i] + 1]++] = i / 2;
}

static void surroundings_free(struct surroundings *around)
{
	patchloops_free(&around->loops);
	free(around->start), free(around->incident), free(around->touched);
}

/* How often does the patch's border come to a node? */
static size_t visits(const struct job *job, const struct patchloops *loops, idx_t patch, idx_t node)
{
	size_t count = 0;
	for (size_t l = loops->first_loop[patch]; l < loops->first_loop[patch + 1]; l++)
		for (size_t s = loops->first_side[l]; s < loops->first_side[l + 1]; s++)
			count += job->node[2 * (size_t)loops->side[s].chain + loops->side[s].reversed] == node;
	return count;
}

/* May the chain's two nodes become one? Not when that would tie a knot into some patch: a patch beside the chain must
 * come to each node once and keep three sides, no other patch may know both nodes, no other chain join them. */
static bool may_contract(const struct job *job, const struct surroundings *around, size_t c)
{
	const struct patchloops *loops = &around->loops;
	const struct border_chain *chain = job->border->chain + c;
	const idx_t a = job->node[2 * c], b = job->node[2 * c + 1];
	if (chain->closed || a == b || chain->right < 0)
		return false;
	for (int end = 0; end < 2; end++) {
		const idx_t here = end ? b : a, there = end ? a : b;
		for (size_t i = around->start[here]; i < around->start[here + 1]; i++) {
			const size_t o = around->incident[i];
			const idx_t patch[2] = {job->border->chain[o].left, job->border->chain[o].right};
			if (o != c && (job->node[2 * o] == there || job->node[2 * o + 1] == there))
				return false;
			for (int k = 0; k < 2; k++) {
				if (patch[k] < 0 || around->touched[patch[k]])
					return false;
				if (patch[k] != chain->left && patch[k] != chain->right &&
				    visits(job, loops, patch[k], there) > 0)
					return false;
			}
		}
	}
	const idx_t beside[2] = {chain->left, chain->right};
	for (int k = 0; k < 2; k++) {
		if (visits(job, loops, beside[k], a) != 1 || visits(job, loops, beside[k], b) != 1)
			return false;
		for (size_t l = loops->first_loop[beside[k]]; l < loops->first_loop[beside[k] + 1]; l++) {
			bool here = false;
			for (size_t s = loops->first_side[l]; s < loops->first_side[l + 1]; s++)
				here |= loops->side[s].chain == (idx_t)c;
			if (here && loops->first_side[l + 1] - loops->first_side[l] < 4)
				return false;
		}
	}
	return true;
}

struct short_chain {
	double length;
	size_t chain;
};

static int compare_lengths(const void *a, const void *b)
{
	const struct short_chain *x = a, *y = b;
	if (x->length != y->length)
		return x->length < y->length ? -1 : 1;
	return (x->chain > y->chain) - (x->chain < y->chain);
}

/* In passes, each on the loops as the one before left them; within a pass no two contractions share a patch. The shortest goes
 * first: a longer one would move its nodes farther than the short neighbours reach, and fitpatch, which finds the chain of a curve
 * by its place, would take one for the other. */
static size_t contract_short(struct job *job)
{
	const size_t n = job->border->chain_count;
	size_t listed = 0, total = 0;
	struct short_chain *list = mem_array(n, sizeof *list);
	for (size_t c = 0; c < n; c++) {
		const double length = chain_length(job, c);
		if (length < job->options.max / 2)
			list[listed++] = (struct short_chain){length, c};
	}
	qsort(list, listed, sizeof *list, compare_lengths);
	size_t changed = listed;
	for (int pass = 0; pass < MOST_PASSES && changed > 0; pass++) {
		struct surroundings around;
		surroundings_init(&around, job);
		changed = 0;
		for (size_t k = 0; k < listed; k++) {
			const size_t c = list[k].chain;
			if (job->is_gone[c] || !may_contract(job, &around, c))
				continue;
			const idx_t a = job->node[2 * c], b = job->node[2 * c + 1];
			for (int end = 0; end < 2; end++) {
				const idx_t here = end ? b : a;
				for (size_t i = around.start[here]; i < around.start[here + 1]; i++) {
					const size_t o = around.incident[i];
					around.touched[job->border->chain[o].left] = around.touched[job->border->chain[o].right] =
						true;
					for (size_t j = 2 * o; j < 2 * o + 2; j++)
						if (job->node[j] == b)
							job->node[j] = a;
				}
			}
			for (size_t i = 0; i < 3; i++)
				job->node_xyz[3 * (size_t)a + i] =
					(job->node_xyz[3 * (size_t)a + i] + job->node_xyz[3 * (size_t)b + i]) / 2;
			job->is_gone[c] = true;
			changed++;
		}
		total += changed;
		surroundings_free(&around);
	}
	free(list);
	return total;
}

/* --- fits -------------------------------------------------------------------------------------------------------- */

/* Rounds of giving points to curves whose control polygons cut others. */
#define MOST_UNCROSS 12
/* Share of the local edge by which a curve may miss a border that has no place of its own. */
#define LOOSE_SHARE 0.25

/* The chain's vertices, its ends where the nodes are now. */
static double *chain_points(const struct job *job, size_t c)
{
	const struct border_chain *chain = job->border->chain + c;
	double *xyz = mem_array(3 * chain->count, sizeof *xyz);
	for (size_t i = 0; i < chain->count; i++)
		copy3(xyz + 3 * i, job->dense->xyz + 3 * (size_t)job->border->vertex[chain->first + i]);
	if (!chain->closed) {
		copy3(xyz, job->node_xyz + 3 * (size_t)job->node[2 * c]);
		copy3(xyz + 3 * (chain->count - 1), job->node_xyz + 3 * (size_t)job->node[2 * c + 1]);
	}
	return xyz;
}

/* Does the border part two pieces of one surface? */
static bool is_cut(const struct job *job, size_t c)
{
	const struct border_chain *chain = job->border->chain + c;
	const struct dense_patch *patch = job->dense->patch;
	return patch && chain->left >= 0 && chain->right >= 0 && patch[chain->left].parent == patch[chain->right].parent;
}

/* Is the border where it is only because triangles ended there? Between free-form patches or parts of one surface, and where it
 * zigzags; not when the mesh itself is creased or ends there. */
static bool is_loose(const struct job *job, size_t c, const struct polyline *plain)
{
	const struct border_chain *chain = job->border->chain + c;
	if (chain->kind != CURVE_SMOOTH || chain->count < 3)
		return false;
	const struct dense_patch *patch = job->dense->patch;
	if (!patch)
		return true;
	return patch[chain->left].parent == patch[chain->right].parent || patch[chain->left].kind == PATCH_FREE ||
	       patch[chain->right].kind == PATCH_FREE || polyline_is_jagged(plain);
}

/* Polylines of all chains; which ones are loose. */
static void make_lines(struct job *job)
{
	const size_t n = job->border->chain_count;
	bool any = false;
	for (size_t c = 0; c < n; c++) {
		if (job->is_gone[c])
			continue;
		double *xyz = chain_points(job, c);
		polyline_init(job->line + c, xyz, job->border->chain[c].count, job->border->chain[c].closed);
		free(xyz);
		job->is_relaxed[c] = is_loose(job, c, job->line + c);
		any |= job->is_relaxed[c];
	}
	if (any)
		job->nearest =
			nearest_new(job->dense->xyz, job->dense->vertex_count, job->dense->triangle, job->dense->triangle_count);
}

static void fit_chain(struct job *job, size_t c)
{
	const struct border_chain *chain = job->border->chain + c;
	struct polyline *line = job->line + c;
	job->limit[c] = (struct curvefit_options){.max = job->options.max, .mean = job->options.mean, .side = job->side};
	job->limit[c].least_points = chain->closed ? 3 : job->node[2 * c] == job->node[2 * c + 1] ? 4 : 2;
	if (line->length == 0) { /* all its vertices are in one place; later stages see points that coincide */
		curvefit_point(job->fit + c, line->xyz, job->limit[c].least_points, chain->closed);
		return;
	}
	if (job->is_relaxed[c]) {
		double *xyz = chain_points(job, c), *relaxed;
		const size_t count = relax_border(&relaxed, xyz, chain->count, chain->closed, job->dense, job->nearest,
						  chain->left, chain->right);
		/* A cut through one surface is best where it is simplest, and no crease with natural ends will come of it. */
		if (is_cut(job, c) && !chain->closed && job->node[2 * c] != job->node[2 * c + 1] &&
		    relax_straight(relaxed, count, job->dense, job->nearest, chain->left, chain->right)) {
			job->limit[c].max *= CUT_SHARE;
			job->limit[c].mean = job->limit[c].max / 2;
		}
		polyline_free(line);
		polyline_init(line, relaxed, count, chain->closed);
		for (size_t i = 0; i < line->segment_count; i++) /* edges were halved */
			line->slack[i] = fmax(line->slack[i], LOOSE_SHARE * 2 * (line->arc[i + 1] - line->arc[i]));
		free(xyz), free(relaxed);
	} else if (polyline_is_jagged(line)) {
		job->is_smoothed[c] = true;
		polyline_smooth(line);
	}
	curvefit_best(job->fit + c, line, job->limit[c]);
}

/* One more inner point. */
static void add_point(struct job *job, size_t c)
{
	if (job->line[c].length > 0)
		curvefit_raise(job->fit + c, job->line + c, job->limit[c], job->fit[c].count + 1);
}

/* --- rules ------------------------------------------------------------------------------------------------------- */

struct straight {
	idx_t low, high;
	size_t chain;
};

static int compare_straights(const void *a, const void *b)
{
	const struct straight *x = a, *y = b;
	if (x->low != y->low)
		return x->low < y->low ? -1 : 1;
	if (x->high != y->high)
		return x->high < y->high ? -1 : 1;
	return (x->chain > y->chain) - (x->chain < y->chain);
}

/* Of several curves without inner points between the same nodes all but the straightest get one. */
static size_t part_doubles(struct job *job)
{
	struct straight *list = mem_array(job->border->chain_count, sizeof *list);
	size_t count = 0, added = 0;
	for (size_t c = 0; c < job->border->chain_count; c++) {
		const idx_t a = job->node[2 * c], b = job->node[2 * c + 1];
		if (!job->is_gone[c] && !job->border->chain[c].closed && job->fit[c].count == 2)
			list[count++] = (struct straight){a < b ? a : b, a < b ? b : a, c};
	}
	qsort(list, count, sizeof *list, compare_straights);
	for (size_t i = 0, j; i < count; i = j) {
		size_t straightest = i;
		for (j = i; j < count && list[j].low == list[i].low && list[j].high == list[i].high; j++)
			if (job->fit[list[j].chain].error < job->fit[list[straightest].chain].error)
				straightest = j;
		for (size_t k = i; k < j; k++)
			if (k != straightest) {
				add_point(job, list[k].chain);
				added++;
			}
	}
	free(list);
	return added;
}

/* Every border loop of a patch has at least three vertices. */
static size_t widen_loops(struct job *job)
{
	struct patchloops loops;
	patchloops_init(&loops, job->border, job->node, job->is_gone, job->dense->patch_count);
	size_t added = 0;
	for (size_t l = 0; l < loops.loop_count; l++)
		for (;;) {
			size_t vertices = 0, longest = loops.first_side[l];
			for (size_t s = loops.first_side[l]; s < loops.first_side[l + 1]; s++) {
				const size_t c = (size_t)loops.side[s].chain;
				vertices += job->fit[c].count - !job->fit[c].closed;
				if (job->line[c].length > job->line[loops.side[longest].chain].length)
					longest = s;
			}
			const size_t c = (size_t)loops.side[longest].chain;
			if (vertices >= 3 || job->line[c].length == 0)
				break;
			add_point(job, c);
			added++;
		}
	patchloops_free(&loops);
	return added;
}

/* --- result ------------------------------------------------------------------------------------------------------ */

/* Largest distance both ways between the fitted points and the mesh edges themselves. */
static void measure(struct job *job, size_t c)
{
	if ((!job->is_relaxed[c] && !job->is_smoothed[c]) || job->line[c].length == 0)
		return;
	struct polyline plain;
	double *xyz = chain_points(job, c);
	polyline_init(&plain, xyz, job->border->chain[c].count, job->border->chain[c].closed);
	const double ratio = job->fit[c].ratio;
	/* Where the knots are on the zigzag: vertices keep their order, relaxed lines have a vertex more on each segment. */
	for (size_t i = 0; i < job->fit[c].count; i++)
		job->fit[c].arc[i] = polyline_carry(&plain, job->line + c, job->fit[c].arc[i]);
	curvefit_measure(job->fit + c, &plain, job->limit[c]);
	job->fit[c].ratio = ratio; /* of the line that was fitted, which is what can be asked for */
	polyline_free(&plain);
	free(xyz);
}

static void build(struct network *network, struct netfit_report *report, const struct job *job)
{
	const struct border_network *border = job->border;
	*network = (struct network){0};
	idx_t *place = mem_array(border->node_count, sizeof *place);
	for (size_t i = 0; i < border->node_count; i++)
		place[i] = NO_INDEX;
	for (size_t c = 0; c < border->chain_count; c++) {
		if (job->is_gone[c])
			continue;
		network->curve_count++;
		if (border->chain[c].closed) {
			network->point_count += job->fit[c].count;
			network->vertex_count += job->fit[c].count;
			continue;
		}
		place[job->node[2 * c]] = place[job->node[2 * c + 1]] = 0;
		const size_t inner = job->fit[c].count - 2;
		network->point_count += inner + 2;
		network->vertex_count += inner;
	}
	size_t nodes = 0;
	for (size_t i = 0; i < border->node_count; i++)
		if (place[i] != NO_INDEX)
			place[i] = (idx_t)nodes++;
	network->vertex_count += nodes;
	network->xyz = mem_array(3 * network->vertex_count, sizeof *network->xyz);
	network->kind = mem_array(network->vertex_count, 1);
	network->curve = mem_array(network->curve_count, sizeof *network->curve);
	network->point = mem_array(network->point_count, sizeof *network->point);
	for (size_t i = 0; i < border->node_count; i++)
		if (place[i] != NO_INDEX) {
			copy3(network->xyz + 3 * (size_t)place[i], job->node_xyz + 3 * i);
			network->kind[place[i]] = border->node_kind[i];
		}
	size_t vertex = nodes, point = 0, curve = 0;
	for (size_t c = 0; c < border->chain_count; c++) {
		if (job->is_gone[c])
			continue;
		const struct border_chain *chain = border->chain + c;
		const struct curvefit *fit = job->fit + c;
		struct curve *out = network->curve + curve++;
		*out = (struct curve){.left = chain->left,
				      .right = chain->right,
				      .kind = chain->kind,
				      .closed = chain->closed,
				      .first = point,
				      .error = fit->error};
		if (!chain->closed)
			network->point[point++] = place[job->node[2 * c]];
		for (size_t i = !chain->closed; i + !chain->closed < fit->count; i++) {
			copy3(network->xyz + 3 * vertex, fit->xyz + 3 * i);
			network->kind[vertex] = POINT_CREASE;
			network->point[point++] = (idx_t)vertex++;
		}
		if (!chain->closed)
			network->point[point++] = place[job->node[2 * c + 1]];
		out->count = point - out->first;
		out->length = network_curve_length(network, out);
		report->closed += chain->closed;
		report->straight += out->count == 2;
		report->relaxed += job->is_relaxed[c];
		report->smoothed += job->is_smoothed[c];
		report->error = fmax(report->error, fit->error);
		if (fit->ratio > 1) {
			report->missed++;
			report->worst = fmax(report->worst, fit->error);
		}
	}
	report->nodes = nodes;
	report->curves = network->curve_count;
	report->points = network->vertex_count;
	free(place);
}

void netfit(struct network *network, struct netfit_report *report, const struct dense *dense, const struct border_network *border,
	    struct netfit_options options)
{
	*report = (struct netfit_report){0};
	const size_t n = border->chain_count;
	struct job job = {.dense = dense, .border = border, .options = options, .side = longest_side(dense)};
	job.node = mem_array(2 * n, sizeof *job.node);
	job.node_xyz = mem_array(3 * border->node_count, sizeof *job.node_xyz);
	job.is_gone = mem_array(n, sizeof *job.is_gone);
	job.line = mem_array(n, sizeof *job.line);
	job.fit = mem_array(n, sizeof *job.fit);
	job.limit = mem_array(n, sizeof *job.limit);
	job.is_relaxed = mem_array(n, sizeof *job.is_relaxed);
	job.is_smoothed = mem_array(n, sizeof *job.is_smoothed);
	for (size_t i = 0; i < border->node_count; i++)
		copy3(job.node_xyz + 3 * i, dense->xyz + 3 * (size_t)border->node[i]);
	for (size_t c = 0; c < n; c++) {
		const struct border_chain *chain = border->chain + c;
		job.node[2 * c] = chain->closed ? NO_INDEX : border->node_of_vertex[border->vertex[chain->first]];
		job.node[2 * c + 1] =
			chain->closed ? NO_INDEX : border->node_of_vertex[border->vertex[chain->first + chain->count - 1]];
	}
	report->contracted = contract_short(&job);
	make_lines(&job);
#pragma omp parallel for schedule(dynamic)
	for (size_t c = 0; c < n; c++)
		if (!job.is_gone[c])
			fit_chain(&job, c);
	struct patchloops loops;
	patchloops_init(&loops, border, job.node, job.is_gone, dense->patch_count);
	size_t *class_size = mem_array(n, sizeof *class_size);
	for (size_t c = 0; c < n; c++)
		class_size[c] = 1;
	for (int round = 0; round < MOST_UNCROSS; round++) {
		if (!options.free_counts)
			report->harmonised += harmonise(job.fit, job.line, job.limit, border, &loops, dense->patch, class_size);
		size_t raised = 0;
		if (dense->patch)
			raised = uncross(job.fit, job.line, job.limit, border, job.is_gone, dense->patch, dense->patch_count,
					 class_size);
		report->uncrossed += raised;
		if (raised == 0)
			break;
	}
	free(class_size);
	patchloops_free(&loops);
	report->split = part_doubles(&job) + widen_loops(&job);
#pragma omp parallel for schedule(dynamic)
	for (size_t c = 0; c < n; c++)
		measure(&job, c);
	build(network, report, &job);
	for (size_t c = 0; c < n; c++) {
		polyline_free(job.line + c);
		curvefit_free(job.fit + c);
	}
	free(job.node), free(job.node_xyz), free(job.is_gone), free(job.line), free(job.fit), free(job.limit),
		free(job.is_relaxed), free(job.is_smoothed);
	nearest_free(job.nearest);
}
