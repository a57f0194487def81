/* Any bytes as a dense mesh, a network and a cage: refused with a message, or taken and put back into the document. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "formats/cage.h"
#include "formats/dense.h"
#include "formats/network.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	unsigned char *bytes = mem_array(size + 1, 1);
	memcpy(bytes, data, size);
	const struct input input = {"x.ply", bytes, size};
	struct ply ply;
	struct fault fault[4] = {{0}};
	if (ply_read(&ply, &input, &fault[0])) {
		struct dense dense;
		struct network network;
		struct cage cage;
		if (dense_from_ply(&dense, &ply, false, input.shown, &fault[1])) {
			dense_to_ply(&ply, &dense);
			dense_free(&dense);
		}
		if (network_from_ply(&network, &ply, "vertex", input.shown, &fault[2])) {
			for (size_t c = 0; c < network.curve_count; c++)
				network_curve_edited(&network, &network.curve[c]);
			network_to_ply(&ply, &network, "vertex");
			network_free(&network);
		}
		if (cage_from_ply(&cage, &ply, input.shown, &fault[3])) {
			cage_to_ply(&ply, &cage);
			cage_free(&cage);
		}
		for (int f = 1; f < 4; f++)
			if (fault[f].code != EX_DONE && (fault[f].code != EX_BAD_INPUT || !fault[f].text[0]))
				abort();
		ply_free(&ply);
	}
	free(bytes);
	return 0;
}
