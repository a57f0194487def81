/* The uniform refiner of OpenSubdiv (Far), measured by decode beside ours. C++ because OpenSubdiv is. */
#include "tests/bench/decode_opensubdiv.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <ctime>
#include <memory>
#include <vector>

using namespace OpenSubdiv;

struct point {
	float x, y, z;
	void Clear() { x = y = z = 0; }
	void AddWithWeight(const point &p, float weight)
	{
		x += weight * p.x;
		y += weight * p.y;
		z += weight * p.z;
	}
};

static double now()
{
	timespec t;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
	return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double osd_refine(size_t *vertices, double sum[2], const struct osd_cage *cage, int level)
{
	const std::vector<float> sharpness(static_cast<size_t>(std::max(cage->sharp_count, cage->corner_count)), Sdc::Crease::SHARPNESS_INFINITE);
	const double before = now();
	Far::TopologyDescriptor descriptor;
	descriptor.numVertices = cage->vertex_count;
	descriptor.numFaces = cage->face_count;
	descriptor.numVertsPerFace = cage->face_degree;
	descriptor.vertIndicesPerFace = cage->face_vertex;
	descriptor.numCreases = cage->sharp_count;
	descriptor.creaseVertexIndexPairs = cage->sharp;
	descriptor.creaseWeights = sharpness.data();
	descriptor.numCorners = cage->corner_count;
	descriptor.cornerVertexIndices = cage->corner;
	descriptor.cornerWeights = sharpness.data();
	Sdc::Options options;
	options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
	using factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
	const std::unique_ptr<Far::TopologyRefiner> refiner(factory::Create(descriptor, factory::Options(Sdc::SCHEME_CATMARK, options)));
	if (!refiner)
		return -1;
	refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
	std::vector<point> points(static_cast<size_t>(refiner->GetNumVerticesTotal()));
	for (int v = 0; v < cage->vertex_count; v++)
		points[static_cast<size_t>(v)] = {cage->xyz[3 * v], cage->xyz[3 * v + 1], cage->xyz[3 * v + 2]};
	const Far::PrimvarRefiner interpolation(*refiner);
	point *from = points.data();
	for (int i = 1; i <= level; i++) {
		point *to = from + refiner->GetLevel(i - 1).GetNumVertices();
		interpolation.Interpolate(i, from, to);
		from = to;
	}
	const double seconds = now() - before;
	*vertices = static_cast<size_t>(refiner->GetLevel(level).GetNumVertices());
	sum[0] = sum[1] = 0;
	for (size_t v = 0; v < *vertices; v++)
		for (const double x : {from[v].x, from[v].y, from[v].z}) {
			sum[0] += x;
			sum[1] += x * x;
		}
	return seconds;
}
