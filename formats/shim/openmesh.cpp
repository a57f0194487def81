/* OpenMesh behind C: connectivity and edge collapses. */
#ifndef NDEBUG
#define NDEBUG /* OpenMesh's own checks compare the names of types, as strings, at each access to a property: half the time */
#endif

#include "formats/shim/openmesh.h"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" /* OpenMesh's vectors have no initial value, and are copied so */
#endif

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModBaseT.hh>

#include <OpenMesh/Core/Geometry/QuadricT.hh> /* after the others: it does not include what it needs */

namespace
{

using namespace OpenMesh;

/* Whatever OpenMesh wants to tell goes nowhere: messages are the tools' business. */
void be_silent()
{
	omlog().disable();
	omout().disable();
	omerr().disable();
}

int refuse(char *message, size_t message_size, const char *text)
{
	if (message_size > 0)
		std::snprintf(message, message_size, "%s", text);
	return -1;
}

struct DoubleTraits : DefaultTraits {
	typedef Vec3d Point;
	typedef Vec3d Normal;
};
typedef PolyMesh_ArrayKernelT<DoubleTraits> Poly;

/* Triangles whose questions asked most are answered here, in line: the library's own answers look up properties by name. */
struct Tri : TriMesh_ArrayKernelT<DoubleTraits> {
	HalfedgeHandle next_outgoing(HalfedgeHandle h) const { return next_halfedge_handle(opposite_halfedge_handle(h)); }
	HalfedgeHandle find_halfedge(VertexHandle from, VertexHandle to) const
	{
		const HalfedgeHandle first = halfedge_handle(from);
		HalfedgeHandle h = first;
		if (h.is_valid())
			do {
				if (to_vertex_handle(h) == to)
					return h;
				h = next_outgoing(h);
			} while (h != first);
		return HalfedgeHandle();
	}
	/* May v0 go to v1 and leave a manifold? The link condition (Dey and others 1999), with borders. */
	bool is_collapse_ok(HalfedgeHandle v0v1)
	{
		const HalfedgeHandle v1v0 = opposite_halfedge_handle(v0v1);
		const VertexHandle v0 = to_vertex_handle(v1v0), v1 = to_vertex_handle(v0v1);
		if (status(edge_handle(v0v1)).deleted() || status(v0).deleted() || status(v1).deleted())
			return false;
		VertexHandle tip[2];
		int i = 0;
		for (auto side : {v0v1, v1v0}) {
			if (!is_boundary(side)) {
				const HalfedgeHandle h1 = next_halfedge_handle(side), h2 = next_halfedge_handle(h1);
				if (is_boundary(opposite_halfedge_handle(h1)) && is_boundary(opposite_halfedge_handle(h2)))
					return false;
				tip[i] = to_vertex_handle(h1);
			}
			i++;
		}
		if (tip[0] == tip[1])
			return false;
		if (mark_.size() != n_vertices())
			mark_.assign(n_vertices(), 0);
		if (++now_ == 0) {
			std::fill(mark_.begin(), mark_.end(), 0);
			now_ = 1;
		}
		HalfedgeHandle h = v1v0;
		do
			mark_[size_t(to_vertex_handle(h).idx())] = now_;
		while ((h = next_outgoing(h)) != v1v0);
		h = v0v1;
		do {
			const VertexHandle v = to_vertex_handle(h);
			if (mark_[size_t(v.idx())] == now_ && v != tip[0] && v != tip[1])
				return false;
		} while ((h = next_outgoing(h)) != v0v1);
		return is_boundary(v0v1) || is_boundary(v1v0) || !is_boundary(v0) || !is_boundary(v1);
	}

      private:
	std::vector<unsigned> mark_;
	unsigned now_ = 0;
};

/* Priority and limits of a collapse. Two quadrics a vertex (Garland and Heckbert 1997), both as weighted means so that
 * they are squared distances: to the planes of the triangles, weighted by area; and, for border and feature edges, to the planes
 * through the edge across its triangles, weighted by squared length, without which a border in a plane would cost nothing. */
template <class MeshT> class ModPlaneDistanceT : public Decimater::ModBaseT<MeshT>
{
      public:
	DECIMATING_MODULE(ModPlaneDistanceT, MeshT, PlaneDistance);
	explicit ModPlaneDistanceT(MeshT &mesh) : Base(mesh, false)
	{
		mesh.add_property(surface_);
		mesh.add_property(line_);
	}
	~ModPlaneDistanceT() override
	{
		Base::mesh().remove_property(surface_);
		Base::mesh().remove_property(line_);
	}
	void set_limits(double max_error, double least_cosine)
	{
		max_error_ = max_error;
		least_cosine_ = least_cosine;
	}
	void initialize() override
	{
		MeshT &mesh = Base::mesh();
		for (auto v : mesh.vertices())
			mesh.property(surface_, v) = mesh.property(line_, v) = Sum();
		for (auto f : mesh.faces()) {
			Vec3d n = area_vector(f);
			const double length = n.norm();
			if (!(length > 0))
				continue;
			n /= length;
			for (auto h : mesh.fh_range(f)) {
				const auto from = mesh.from_vertex_handle(h), to = mesh.to_vertex_handle(h);
				mesh.property(surface_, to).add(n, mesh.point(to), length / 2);
				if (!mesh.is_boundary(mesh.edge_handle(h)) && !mesh.status(mesh.edge_handle(h)).feature())
					continue;
				const Vec3d edge = mesh.point(to) - mesh.point(from);
				Vec3d across = edge % n;
				const double norm = across.norm();
				if (!(norm > 0))
					continue;
				across /= norm;
				mesh.property(line_, from).add(across, mesh.point(to), norm * norm);
				mesh.property(line_, to).add(across, mesh.point(to), norm * norm);
			}
		}
	}
	float collapse_priority(const CollapseInfo &ci) override
	{
		MeshT &mesh = Base::mesh();
		/* Along a chain only: the far end of a chain, where features meet or end, is locked by the caller. */
		const bool chain =
			mesh.status(mesh.edge_handle(ci.v0v1)).feature() || mesh.is_boundary(mesh.edge_handle(ci.v0v1));
		if ((mesh.status(ci.v0).feature() || mesh.is_boundary(ci.v0)) && !chain)
			return float(Base::ILLEGAL_COLLAPSE);
		/* A triangle that vanishes brings two of its edges together: no two chains may meet there, nor a chain cut its corner. */
		for (auto tip : {ci.vl, ci.vr})
			if (tip.is_valid() && is_chain(mesh.find_halfedge(ci.v0, tip)))
				return float(Base::ILLEGAL_COLLAPSE);
		auto out = ci.v0v1;
		while ((out = mesh.next_outgoing(out)) != ci.v0v1) {
			const auto f = mesh.face_handle(out);
			if (!f.is_valid() || f == ci.fl || f == ci.fr)
				continue;
			Vec3d corner[3], before, after;
			auto h = mesh.halfedge_handle(f);
			int moved = 0;
			for (int i = 0; i < 3; i++, h = mesh.next_halfedge_handle(h)) {
				corner[i] = mesh.point(mesh.to_vertex_handle(h));
				if (mesh.to_vertex_handle(h) == ci.v0)
					moved = i;
			}
			before = (corner[1] - corner[0]) % (corner[2] - corner[0]);
			corner[moved] = ci.p1;
			after = (corner[1] - corner[0]) % (corner[2] - corner[0]);
			const double scale = before.norm() * after.norm();
			/* No triangle may become a line: its edges would come to lie on each other. */
			double longest = 0;
			for (int k = 0; k < 3; k++)
				longest = std::max(longest, (corner[k] - corner[(k + 1) % 3]).sqrnorm());
			if (!(after.norm() > 1e-3 * longest) || (scale > 0 && (before | after) < least_cosine_ * scale))
				return float(Base::ILLEGAL_COLLAPSE);
		}
		Sum surface = mesh.property(surface_, ci.v0), line = mesh.property(line_, ci.v0);
		surface += mesh.property(surface_, ci.v1);
		line += mesh.property(line_, ci.v1);
		const double error = std::max(surface.mean(ci.p1), line.mean(ci.p1));
		if (!(error < max_error_))
			return float(Base::ILLEGAL_COLLAPSE);
		return float(std::min(error, double(FLT_MAX) / 2));
	}
	void postprocess_collapse(const CollapseInfo &ci) override
	{
		MeshT &mesh = Base::mesh();
		mesh.property(surface_, ci.v1) += mesh.property(surface_, ci.v0);
		mesh.property(line_, ci.v1) += mesh.property(line_, ci.v0);
	}

      private:
	struct Sum {
		Geometry::QuadricT<double> quadric;
		double weight = 0;
		Sum() { quadric.clear(); }
		void add(const Vec3d &n, const Vec3d &p, double w)
		{
			Geometry::QuadricT<double> q(n[0], n[1], n[2], -(n | p));
			q *= w;
			quadric += q;
			weight += w;
		}
		Sum &operator+=(const Sum &other)
		{
			quadric += other.quadric;
			weight += other.weight;
			return *this;
		}
		/* Rounding may take it below 0. */
		double mean(const Vec3d &p) const { return weight > 0 ? std::max(0.0, quadric(p) / weight) : 0; }
	};
	bool is_chain(HalfedgeHandle h)
	{
		const auto e = Base::mesh().edge_handle(h);
		return Base::mesh().status(e).feature() || Base::mesh().is_boundary(e);
	}
	Vec3d area_vector(FaceHandle f) const
	{
		Vec3d corner[3];
		int i = 0;
		for (auto v : const_cast<ModPlaneDistanceT *>(this)->mesh().fv_range(f))
			corner[i++] = const_cast<ModPlaneDistanceT *>(this)->mesh().point(v);
		return (corner[1] - corner[0]) % (corner[2] - corner[0]);
	}
	VPropHandleT<Sum> surface_, line_;
	double max_error_ = DBL_MAX, least_cosine_ = 0.5;
};

} // namespace

extern "C" int shim_twins(int32_t *twin, const int32_t *corner, const size_t *face_start, size_t face_count, size_t vertex_count,
			  char *message, size_t message_size)
{
	try {
		be_silent();
		Poly mesh;
		mesh.reserve(vertex_count, face_start[face_count], face_count);
		for (size_t v = 0; v < vertex_count; v++)
			mesh.new_vertex();
		std::vector<VertexHandle> loop;
		for (size_t f = 0; f < face_count; f++) {
			loop.clear();
			for (size_t h = face_start[f]; h < face_start[f + 1]; h++)
				loop.push_back(VertexHandle(corner[h]));
			if (!mesh.add_face(loop).is_valid())
				return refuse(message, message_size, "the faces do not make a manifold");
		}
		/* OpenMesh's half-edge handles to ours: those of a face are met in the order of its corners, from some start. */
		std::vector<int32_t> ours(mesh.n_halfedges(), -1);
		for (size_t f = 0; f < face_count; f++) {
			HalfedgeHandle h = mesh.halfedge_handle(FaceHandle(int(f)));
			const size_t count = face_start[f + 1] - face_start[f];
			for (size_t k = 0; k < count && mesh.from_vertex_handle(h).idx() != corner[face_start[f]]; k++)
				h = mesh.next_halfedge_handle(h);
			for (size_t k = 0; k < count; k++, h = mesh.next_halfedge_handle(h))
				ours[size_t(h.idx())] = int32_t(face_start[f] + k);
		}
		for (size_t i = 0; i < ours.size(); i++)
			if (ours[i] >= 0)
				twin[ours[i]] = ours[i ^ 1]; /* opposite half-edges are stored in pairs */
		return 0;
	} catch (const std::exception &error) {
		return refuse(message, message_size, error.what());
	} catch (...) {
		return refuse(message, message_size, "the mesh library failed");
	}
}

extern "C" long shim_simplify(int32_t *triangle, int32_t *origin, size_t triangle_count, const double *xyz, size_t vertex_count,
			      const unsigned char *locked, const int32_t *feature, size_t feature_count, double max_error,
			      size_t face_target, char *message, size_t message_size)
{
	try {
		be_silent();
		Tri mesh;
		Decimater::DecimaterT<Tri> decimater(mesh); /* requests the status attributes */
		for (size_t v = 0; v < vertex_count; v++)
			mesh.add_vertex(Vec3d(xyz[3 * v], xyz[3 * v + 1], xyz[3 * v + 2]));
		for (size_t t = 0; t < triangle_count; t++)
			if (!mesh.add_face(VertexHandle(triangle[3 * t]), VertexHandle(triangle[3 * t + 1]),
					   VertexHandle(triangle[3 * t + 2]))
				     .is_valid())
				return refuse(message, message_size, "the triangles do not make a manifold");
		std::vector<unsigned> chain(vertex_count, 0); /* feature and border edges at each vertex */
		for (size_t i = 0; i < feature_count; i++) {
			const HalfedgeHandle h =
				mesh.find_halfedge(VertexHandle(feature[2 * i]), VertexHandle(feature[2 * i + 1]));
			if (!h.is_valid())
				return refuse(message, message_size, "a feature edge is not in the mesh");
			mesh.status(mesh.edge_handle(h)).set_feature(true);
		}
		for (auto e : mesh.edges())
			if (mesh.status(e).feature() || mesh.is_boundary(e))
				for (auto v : {mesh.from_vertex_handle(mesh.halfedge_handle(e, 0)),
					       mesh.to_vertex_handle(mesh.halfedge_handle(e, 0))}) {
					chain[size_t(v.idx())]++;
					if (mesh.status(e).feature())
						mesh.status(v).set_feature(true);
				}
		/* Where chains meet, end or touch a border, a collapse along one of them would tear the others. */
		for (size_t v = 0; v < vertex_count; v++)
			if ((locked && locked[v]) || (chain[v] != 0 && chain[v] != 2))
				mesh.status(VertexHandle(int(v))).set_locked(true);
		ModPlaneDistanceT<Tri>::Handle handle;
		decimater.add(handle);
		decimater.module(handle).set_limits(max_error, std::cos(M_PI / 3));
		if (!decimater.initialize())
			return refuse(message, message_size, "the decimater cannot be set up");
		if (triangle_count > face_target)
			decimater.decimate_to_faces(0, face_target);
		long left = 0;
		for (auto f : mesh.all_faces()) {
			if (mesh.status(f).deleted())
				continue;
			if (origin)
				origin[left] = f.idx();
			int32_t *corner = triangle + 3 * left++;
			for (auto v : mesh.fv_range(f))
				*corner++ = v.idx();
		}
		return left;
	} catch (const std::exception &error) {
		return refuse(message, message_size, error.what());
	} catch (...) {
		return refuse(message, message_size, "the mesh library failed");
	}
}
