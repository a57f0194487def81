#include "stages/geometry/patchsummary.h"

#include <math.h>
#include <stdlib.h>

#include "stages/geometry/border.h"
#include "stages/geometry/primitive.h"
#include "stages/geometry/vector.h"
#include "stages/geometry/wedge.h"

bool patch_summarise(struct patch_summary *s, const struct dense *dense, struct fault *fault)
{
	*s = (struct patch_summary){.most_loops = NO_INDEX, .worst = NO_INDEX};
	struct half half;
	struct border_network border;
	if (!border_extract(&border, dense, BORDER_DEFAULTS, fault))
		return false;
	for (size_t i = 0; i < border.chain_count; i++)
		s->curves[border.chain[i].kind]++;
	s->nodes = border.node_count;
	border_free(&border);
	if (!half_build_triangles(&half, dense->triangle, dense->triangle_count, dense->vertex_count, fault))
		return false;
	struct patch_topology *topology = mem_array(dense->patch_count, sizeof *topology);
	patch_topologies(topology, dense->patch_count, dense->label, &half);
	half_free(&half);
	for (size_t p = 0; p < dense->patch_count; p++) {
		s->loops += topology[p].border_loops;
		s->closed += topology[p].border_loops == 0;
		s->handled += topology[p].genus > 0;
		s->genus += topology[p].genus > 0 ? topology[p].genus : 0;
		if (s->most_loops == NO_INDEX || topology[p].border_loops > s->most_loops_count) {
			s->most_loops = (idx_t)p;
			s->most_loops_count = topology[p].border_loops;
		}
	}
	free(topology);
	for (size_t c = 0; c < 3 * dense->triangle_count; c++) {
		const idx_t label = dense->label[c / 3];
		const struct dense_patch *patch = &dense->patch[label];
		if (patch->kind == PATCH_FREE)
			continue;
		const double *x = dense->xyz + 3 * (size_t)dense->triangle[c], distance = fabs(primitive_distance(patch, x));
		if (s->worst == NO_INDEX || distance > s->worst_distance) {
			s->worst = label;
			s->worst_distance = distance;
			copy3(s->worst_at, x);
		}
	}
	return true;
}
