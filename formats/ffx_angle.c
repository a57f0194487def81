/* Angles in integers (see ffx_angle.h). */
#include "formats/ffx_angle.h"

#include <stdlib.h>

/* atan(i / 64) in 1/65536 of a turn */
static const uint16_t arc_table[65] = {0,    163,  326,  489,  651,  813,  975,  1136, 1297, 1457, 1617, 1775, 1933,
				       2090, 2246, 2401, 2555, 2708, 2860, 3010, 3159, 3307, 3453, 3599, 3742, 3884,
				       4025, 4164, 4302, 4438, 4572, 4705, 4836, 4966, 5094, 5220, 5344, 5467, 5589,
				       5708, 5826, 5943, 6058, 6171, 6282, 6392, 6500, 6607, 6712, 6815, 6917, 7018,
				       7117, 7214, 7310, 7405, 7498, 7589, 7679, 7768, 7856, 7942, 8026, 8110, 8192};

void vector_shrink(int64_t v[3])
{
	int64_t most = 0;
	for (int k = 0; k < 3; k++)
		most |= llabs(v[k]);
	if (most <= 32767)
		return;
	const int bits = 64 - 15 - __builtin_clzll((uint64_t)most);
	for (int k = 0; k < 3; k++)
		v[k] = v[k] < 0 ? -(-v[k] >> bits) : v[k] >> bits;
}

uint32_t root_of(uint64_t x)
{
	if (x == 0)
		return 0;
	/* Newton's steps from above fall until they reach it. */
	uint64_t root = (uint64_t)1 << (33 - __builtin_clzll(x) / 2 - 1);
	for (;;) {
		const uint64_t next = (root + x / root) / 2;
		if (next >= root)
			return (uint32_t)root;
		root = next;
	}
}

uint32_t vector_length(const int64_t v[3])
{
	return root_of((uint64_t)(v[0] * v[0]) + (uint64_t)(v[1] * v[1]) + (uint64_t)(v[2] * v[2]));
}

/* Angle of the point (x, y), y >= 0: 0 to half a turn. */
static int arc_of(int64_t y, int64_t x)
{
	const int64_t size = llabs(x);
	if (y == 0 && x == 0)
		return 0;
	const int64_t small = y < size ? y : size, large = y < size ? size : y;
	const int64_t ratio = (small * 16384 + large / 2) / large; /* 64 parts of 256 */
	const int i = (int)(ratio >> 8), part = (int)(ratio & 255);
	int angle = arc_table[i];
	if (part)
		angle += (arc_table[i + 1] - arc_table[i]) * part >> 8;
	if (y >= size)
		angle = 16384 - angle;
	if (x < 0)
		angle = 32768 - angle;
	return (angle + 8) >> 4;
}

int angle_between(const int64_t a[3], const int64_t b[3])
{
	int64_t u[3] = {a[0], a[1], a[2]}, v[3] = {b[0], b[1], b[2]}, cross[3];
	vector_shrink(u);
	vector_shrink(v);
	vector_cross(cross, u, v);
	const uint64_t square =
		(uint64_t)(cross[0] * cross[0]) + (uint64_t)(cross[1] * cross[1]) + (uint64_t)(cross[2] * cross[2]);
	/* Short ones get 8 bits behind the point. */
	const int fine = square >> 48 ? 0 : 8;
	return arc_of(root_of(square << 2 * fine), vector_dot(u, v) * ((int64_t)1 << fine));
}

int angle_bend(const int64_t left[3], const int64_t right[3], const int64_t edge[3])
{
	int64_t cross[3];
	vector_cross(cross, left, right);
	vector_shrink(cross);
	const int angle = angle_between(left, right);
	return vector_dot(cross, edge) < 0 ? -angle : angle;
}
