/* libFuzzer target of the FFX decoder and of refining what it gives. The checksum is mended first, so that damage gets past it.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "formats/ffx.h"
#include "stages/geometry/subdivide.h"
#include "tests/unit/ffx_helpers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	unsigned char *bytes = mem_copy(data, size, 1);
	seal(bytes, size);
	struct ffx ffx;
	struct cage cage;
	struct level base, refined;
	struct fault fault = {0};
	if (ffx_decode(&ffx, bytes, size, "fuzz", &fault)) {
		ffx_to_cage(&cage, &ffx);
		if (level_from_cage(&base, &cage, &fault)) {
			level_refine(&refined, &base, cage.scheme, cage.face_count < 2000 ? 2 : 1);
			level_free(&refined);
			level_free(&base);
		}
		cage_free(&cage);
		ffx_free(&ffx);
	}
	free(bytes);
	return 0;
}
