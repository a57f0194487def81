/* Any bytes as a mesh file of each name: refused with a message, or read and repaired to a manifold. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "formats/mesh.h"
#include "stages/geometry/repair.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static const char *const shown[] = {"x.stl", "x.off", "x.obj", "x.ply", "x.om"};
	unsigned char *bytes = mem_array(size + 1, 1); /* a final 0 behind the data, as input_read leaves it */
	memcpy(bytes, data, size);
	for (size_t i = 0; i < sizeof shown / sizeof *shown; i++) {
		const struct input input = {shown[i], bytes, size};
		struct fault fault = {0};
		struct mesh mesh;
		struct repair_report report = {0};
		if (mesh_read(&mesh, &input, &fault) && !repair_mesh(&mesh, &(struct repair_options){1e-6}, &report, &fault) &&
		    fault.code == EX_BUG)
			abort();
		repair_report_free(&report);
		mesh_free(&mesh);
	}
	free(bytes);
	return 0;
}
