/* Any bytes as a heap of triangles on a few lattice points, some of them a hair away: whatever it is, a manifold or nothing is
 * left. */
#include <stdint.h>
#include <stdlib.h>

#include "stages/geometry/repair.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	const size_t vertices = size > 0 ? 3 + data[0] % 64u : 0;
	if (size < 4 + vertices || size > 4000)
		return 0;
	const size_t faces = (size - 1 - vertices) / 3;
	struct mesh mesh = {mem_array(3 * vertices, sizeof *mesh.xyz), vertices, mem_array(3 * faces, sizeof *mesh.corner),
			    mem_array(faces + 1, sizeof *mesh.face_start), faces};
	for (size_t v = 0; v < vertices; v++)
		for (size_t i = 0; i < 3; i++) /* 2 bits a coordinate, 2 for a distance below the tolerances */
			mesh.xyz[3 * v + i] = (data[1 + v] >> 2 * i & 3) + (i == data[1 + v] >> 6 ? 1e-8 : 0);
	for (size_t h = 0; h < 3 * faces; h++)
		mesh.corner[h] = (idx_t)(data[1 + vertices + h] % vertices);
	for (size_t f = 0; f <= faces; f++)
		mesh.face_start[f] = 3 * f;
	struct fault fault = {0};
	struct repair_report report;
	if (!repair_mesh(&mesh, &(struct repair_options){1e-6}, &report, &fault) && fault.code != EX_BAD_INPUT)
		abort();
	repair_report_free(&report);
	mesh_free(&mesh);
	return 0;
}
