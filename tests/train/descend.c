/* Puts cages on a grid as a search for few bytes would: coordinates go one step up or down where that saves more than it moves.
 *
 *	build/descend FOLDER STEPS cage.ply ...     STEPS 0: another grid for each
 *
 * For the corpus of tests/train/train.c. Uses the tables that are compiled in, so that training and this can take turns. Writes
 * FOLDER/name.ply with whole numbers for coordinates, the longest side as long as its grid. */
#include <stdio.h>

#include "formats/ffx.h"
#include "formats/input.h"
#include "formats/mesh.h"
#include "formats/ply.h"
#include "tests/fixtures/samplecages.h"

#define BITS_PER_STEP2 5.0 /* what a squared step away from the exact place is worth */
#define VERTEX_LIMIT 120   /* larger cages are left out */
#define PASSES 2

static void descend(struct ffx *ffx, const double *exact, struct ffx_work *work)
{
	struct fault fault = {0};
	const int32_t steps = ffx_grid_steps(ffx->grid_code);
	double best = HUGE_VAL;
	size_t root = 0;
	for (size_t r = 0; r < 24; r++) {
		const size_t at = r * 2654435761u % ffx->face_start[ffx->face_count];
		const double cost = ffx_cost(work, ffx, at, NULL, &fault);
		if (cost < best) {
			best = cost;
			root = at;
		}
	}
	for (int pass = 0; pass < PASSES; pass++)
		for (size_t i = 0; i < 3 * ffx->vertex_count; i++) {
			const int32_t old = ffx->grid[i];
			for (int move = -1; move <= 1; move += 2) {
				const double far = exact[i] - old - move, was = exact[i] - ffx->grid[i];
				if (old + move < 0 || old + move > steps || fabs(far) > 1.2)
					continue;
				const int32_t now = ffx->grid[i];
				ffx->grid[i] = old + move;
				const double cost = ffx_cost(work, ffx, root, NULL, &fault);
				if (8 * (cost - best) + BITS_PER_STEP2 * (far * far - was * was) < 0)
					best = cost;
				else
					ffx->grid[i] = now;
			}
		}
}

int main(int argc, char **argv)
{
	struct ffx_work *work = ffx_work_new();
	for (int a = 3; a < argc; a++) {
		struct fault fault = {0};
		struct input input;
		struct ply ply;
		struct cage cage = {0};
		if (!input_read(&input, argv[a], &fault) || !ply_read(&ply, &input, &fault) ||
		    !cage_from_ply(&cage, &ply, argv[a], &fault)) {
			fprintf(stderr, "descend: %s\n", fault.text);
			continue;
		}
		if (cage.vertex_count > VERTEX_LIMIT)
			continue;
		sample_seed((uint64_t)a);
		const int32_t wanted = atoi(argv[2]);
		const unsigned code = wanted ? ffx_grid_code(wanted) : 50 + sample_random(18) + sample_random(18);
		const int32_t steps = ffx_grid_steps(code);
		double low[3];
		const double side = mesh_bounds(cage.xyz, cage.vertex_count, low, NULL);
		struct ffx ffx = {.scheme = cage.scheme,
				  .grid_code = code,
				  .vertex_count = cage.vertex_count,
				  .face_corner = cage.face_corner,
				  .face_start = cage.face_start,
				  .face_count = cage.face_count,
				  .sharp = cage.sharp,
				  .sharp_count = cage.sharp_count,
				  .corner = cage.corner};
		ffx.grid = mem_array(3 * cage.vertex_count, sizeof(int32_t));
		for (size_t i = 0; i < 3 * cage.vertex_count; i++) {
			cage.xyz[i] = (cage.xyz[i] - low[i % 3]) / side * steps;
			ffx.grid[i] = (int32_t)round(cage.xyz[i]);
		}
		if (ffx_cost(work, &ffx, 0, NULL, &fault) == HUGE_VAL)
			continue;
		descend(&ffx, cage.xyz, work);
		for (size_t i = 0; i < 3 * cage.vertex_count; i++)
			cage.xyz[i] = ffx.grid[i];
		char path[1000];
		snprintf(path, sizeof path, "%s/%s", argv[1], strrchr(argv[a], '/') ? strrchr(argv[a], '/') + 1 : argv[a]);
		FILE *file = fopen(path, "wb");
		if (!file) {
			perror(path);
			return EX_SYSTEM;
		}
		ply_init(&ply);
		cage_to_ply(&ply, &cage);
		ply_write(file, &ply);
		ply_free(&ply);
		fclose(file);
		free(ffx.grid);
		cage_free(&cage);
		input_free(&input);
	}
	ffx_work_free(work);
	return 0;
}
