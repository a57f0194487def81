#include <math.h>
#include <string.h>

#include "formats/ffx.h"

#define BESIDE 1e-3 /* of a step: what is farther from the grid was moved by hand */

bool ffx_from_cage(struct ffx *ffx, const struct cage *cage, struct fault *fault)
{
	*ffx = (struct ffx){.scheme = cage->scheme, .has_frame = true, .vertex_count = cage->vertex_count, .face_count = cage->face_count};
	ffx->grid = mem_array(3 * cage->vertex_count, sizeof *ffx->grid);
	double low[3] = {0};
	for (size_t i = 0; i < 3 * cage->vertex_count; i++) {
		const double at = (cage->xyz[i] - cage->grid_origin[i % 3]) / cage->grid_step, whole = round(at);
		if (!(fabs(at - whole) <= BESIDE) || !(fabs(whole) < 1 << 30)) {
			ffx_free(ffx);
			return fault_set(fault, EX_BAD_INPUT, "vertex %zu is not on the grid", i / 3);
		}
		ffx->grid[i] = (int32_t)whole;
		low[i % 3] = i < 3 ? whole : fmin(low[i % 3], whole);
	}
	int32_t steps = 1;
	for (size_t i = 0; i < 3 * cage->vertex_count; i++) {
		ffx->grid[i] -= (int32_t)low[i % 3];
		steps = ffx->grid[i] > steps ? ffx->grid[i] : steps;
	}
	ffx->grid_code = ffx_grid_code(steps);
	for (int k = 0; k < 3; k++)
		low[k] = cage->grid_origin[k] + cage->grid_step * low[k];
	const int32_t room = ffx->grid_code < FFX_GRID_CODES ? ffx_grid_steps(ffx->grid_code) : 0;
	if (room == 0 || !ffx_frame_choose(&ffx->frame, low, cage->grid_step * room, room)) {
		ffx_free(ffx);
		return fault_set(fault, EX_BAD_INPUT, "a cage of %d steps of %g units at (%g %g %g) is beyond what a stream can hold", (int)steps,
		                 cage->grid_step, low[0], low[1], low[2]);
	}
	ffx->face_start = mem_copy(cage->face_start, cage->face_count + 1, sizeof *cage->face_start);
	ffx->face_corner = mem_copy(cage->face_corner, cage->face_start[cage->face_count], sizeof *cage->face_corner);
	ffx->sharp = mem_copy(cage->sharp, 2 * cage->sharp_count, sizeof *cage->sharp);
	ffx->sharp_count = cage->sharp_count;
	ffx->corner = cage->corner ? mem_copy(cage->corner, cage->vertex_count, 1) : mem_array(cage->vertex_count, 1);
	return true;
}
