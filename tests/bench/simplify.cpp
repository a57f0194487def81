/* simplify: edge-collapse simplification at many vertex counts in one run, the rival of make bench-peers.
 *
 * usage: simplify mesh prefix count...
 * Collapses with cost and placement of Lindstrom and Turk (Fast and memory efficient polygonal simplification, 1998), refusing
 * what turns a triangle over (CGAL's Bounded_normal_change), and writes prefix-COUNT.ply as soon as no more than COUNT vertices
 * are left, with the name of the count asked for. Counts go down; those above the mesh's own or below what can be reached give
 * no file. The files are cages whose edges are all sharp, which is the mesh itself. */
#include "tests/bench/soup.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <string>

using point = CGAL::Simple_cartesian<double>::Point_3;
using mesh_type = CGAL::Surface_mesh<point>;
namespace collapse = CGAL::Surface_mesh_simplification;

static void write_cage(const mesh_type &mesh, const std::string &path)
{
	std::FILE *file = std::fopen(path.c_str(), "w");
	if (!file) {
		std::perror(path.c_str());
		std::exit(EX_SYSTEM);
	}
	std::fprintf(file, "ply\nformat ascii 1.0\ncomment cagewright scheme quadtri\nelement vertex %zu\nproperty float x\n"
	             "property float y\nproperty float z\nelement face %zu\nproperty list uchar int vertex_indices\nelement edge %zu\n"
	             "property int vertex1\nproperty int vertex2\nproperty uchar sharp\nend_header\n",
	             size_t(mesh.number_of_vertices()), size_t(mesh.number_of_faces()), size_t(mesh.number_of_edges()));
	std::vector<int> number(mesh.number_of_vertices() + mesh.number_of_removed_vertices());
	int next = 0;
	for (const auto v : mesh.vertices()) {
		number[v] = next++;
		const point &p = mesh.point(v);
		std::fprintf(file, "%.9g %.9g %.9g\n", p.x(), p.y(), p.z());
	}
	for (const auto f : mesh.faces()) {
		const auto h = mesh.halfedge(f);
		std::fprintf(file, "3 %d %d %d\n", number[mesh.source(h)], number[mesh.target(h)], number[mesh.target(mesh.next(h))]);
	}
	for (const auto e : mesh.edges())
		std::fprintf(file, "%d %d 1\n", number[mesh.vertex(e, 0)], number[mesh.vertex(e, 1)]);
	if (std::ferror(file) | std::fclose(file)) {
		std::perror(path.c_str());
		std::exit(EX_SYSTEM);
	}
}

/* Asked before each collapse whether to go on: the moment to write what is there. */
struct snapshots {
	const mesh_type *mesh;
	const char *prefix;
	std::vector<size_t> *counts;	/* still to come, the next one last */

	template <class Cost, class Profile> bool operator()(const Cost &, const Profile &, size_t, size_t) const
	{
		return !write_due();
	}
	/* false when all are written */
	bool write_due() const
	{
		for (; !counts->empty() && mesh->number_of_vertices() <= counts->back(); counts->pop_back())
			write_cage(*mesh, std::string(prefix) + "-" + std::to_string(counts->back()) + ".ply");
		return !counts->empty();
	}
};

int main(int argc, char **argv)
{
	if (argc < 4) {
		std::fputs("usage: simplify mesh prefix count...\n", stderr);
		return EX_BAD_USAGE;
	}
	const soup<point> input = soup_read<point>("simplify", argv[1]);
	mesh_type mesh;
	for (const point &p : input.points)
		mesh.add_vertex(p);
	for (const auto &t : input.triangles)
		if (mesh.add_face(mesh_type::Vertex_index(t[0]), mesh_type::Vertex_index(t[1]), mesh_type::Vertex_index(t[2])) == mesh_type::null_face()) {
			std::fprintf(stderr, "simplify: %s: the triangles are no oriented manifold\n", argv[1]);
			return EX_BAD_INPUT;
		}
	for (const auto v : mesh.vertices())
		if (mesh.is_isolated(v))
			mesh.remove_vertex(v);
	mesh.collect_garbage();
	std::vector<size_t> counts;
	for (int i = argc - 1; i >= 3; i--) {
		const size_t count = std::strtoul(argv[i], nullptr, 10);
		if (count <= mesh.number_of_vertices())
			counts.push_back(count);
	}
	const snapshots watch = {&mesh, argv[2], &counts};
	const collapse::LindstromTurk_placement<mesh_type> placement;
	if (!counts.empty())
		collapse::edge_collapse(mesh, watch, CGAL::parameters::get_cost(collapse::LindstromTurk_cost<mesh_type>())
		                        .get_placement(collapse::Bounded_normal_change_placement<decltype(placement)>(placement)));
	watch.write_due();
	return EX_DONE;
}
