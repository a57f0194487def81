/* crossings: where two surfaces cross themselves.
 *
 * usage: crossings [-v] part other
 * Counts the pairs of triangles of each mesh that meet in more than a shared corner or edge, with exact predicates: triangles
 * that touch elsewhere and coplanar ones that overlap count as well. Prints key=value lines: a_ is part, b_ is other,
 * triangles without area are left out, _in_plane counts the pairs in one plane, which are folds within a flat patch and cannot be
 * seen, _share is the share of the area that takes part; b_new_pairs counts the pairs of other
 * that are farther than 1 % of the longest side from all pairs of part. -v prints each place where other crosses itself anew. */
#include "tests/bench/soup.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

using kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using point = kernel::Point_3;
using triangle_box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, size_t, CGAL::Box_intersection_d::ID_EXPLICIT>;
using pair_of = std::array<size_t, 2>;

struct surface {
	soup<point> mesh;
	std::vector<pair_of> pairs;	/* of triangles, the lower one first, sorted */
	size_t flat = 0;	/* triangles without area */
	double area = 0, crossing_area = 0;

	const point &corner(size_t t, int i) const { return mesh.points[mesh.triangles[t][i]]; }
	kernel::Triangle_3 triangle(size_t t) const { return {corner(t, 0), corner(t, 1), corner(t, 2)}; }
	CGAL::Bbox_3 box(size_t t) const { return triangle(t).bbox(); }
};

/* Do the triangles meet in more than what they share? */
static bool crosses(const surface &s, size_t a, size_t b)
{
	int own_a = 0, own_b = 0, shared = 0;	/* a corner of each that the other has not; how many both have */
	const auto &ta = s.mesh.triangles[a], &tb = s.mesh.triangles[b];
	for (int i = 0; i < 3; i++) {
		if (std::find(tb.begin(), tb.end(), ta[i]) == tb.end())
			own_a = i;
		else
			shared++;
		if (std::find(ta.begin(), ta.end(), tb[i]) == ta.end())
			own_b = i;
	}
	if (shared == 3)
		return true;
	if (shared == 2) {
		/* only when one is folded flat onto the other */
		const point &p = s.corner(a, (own_a + 1) % 3), &q = s.corner(a, (own_a + 2) % 3), &x = s.corner(a, own_a), &y = s.corner(b, own_b);
		return CGAL::coplanar(p, q, x, y) && CGAL::coplanar_orientation(p, q, x, y) == CGAL::POSITIVE;
	}
	if (shared == 0)
		return CGAL::do_intersect(s.triangle(a), s.triangle(b));
	/* one corner shared: the edge across from it meets the other triangle, in one or the other */
	for (own_a = 0; std::find(tb.begin(), tb.end(), ta[own_a]) == tb.end(); own_a++)
		;
	for (own_b = 0; std::find(ta.begin(), ta.end(), tb[own_b]) == ta.end(); own_b++)
		;
	return CGAL::do_intersect(s.triangle(a), kernel::Segment_3(s.corner(b, (own_b + 1) % 3), s.corner(b, (own_b + 2) % 3))) ||
	       CGAL::do_intersect(s.triangle(b), kernel::Segment_3(s.corner(a, (own_a + 1) % 3), s.corner(a, (own_a + 2) % 3)));
}

static surface examine(const char *path)
{
	surface s;
	s.mesh = soup_read<point>("crossings", path);
	std::vector<triangle_box> boxes;
	for (size_t t = 0; t < s.mesh.triangles.size(); t++) {
		if (CGAL::collinear(s.corner(t, 0), s.corner(t, 1), s.corner(t, 2))) {
			s.flat++;
			continue;
		}
		s.area += std::sqrt(s.triangle(t).squared_area());
		boxes.emplace_back(s.box(t), t);
	}
	CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const triangle_box &a, const triangle_box &b) {
		const size_t low = std::min(a.info(), b.info()), high = std::max(a.info(), b.info());
		if (crosses(s, low, high))
			s.pairs.push_back({low, high});
	});
	std::sort(s.pairs.begin(), s.pairs.end());
	std::vector<bool> is_in(s.mesh.triangles.size());
	for (const pair_of &p : s.pairs)
		for (size_t t : p)
			if (!is_in[t]) {
				is_in[t] = true;
				s.crossing_area += std::sqrt(s.triangle(t).squared_area());
			}
	return s;
}

static CGAL::Bbox_3 box_of_pair(const surface &s, size_t pair)
{
	return s.box(s.pairs[pair][0]) + s.box(s.pairs[pair][1]);
}

static CGAL::Bbox_3 grown(const CGAL::Bbox_3 &b, double by)
{
	return {b.xmin() - by, b.ymin() - by, b.zmin() - by, b.xmax() + by, b.ymax() + by, b.zmax() + by};
}

/* Which pairs of b are not near a pair of a. */
static std::vector<size_t> new_pairs(const surface &a, const surface &b)
{
	std::vector<triangle_box> old_boxes, boxes;
	for (size_t i = 0; i < a.pairs.size(); i++)
		old_boxes.emplace_back(grown(box_of_pair(a, i), 0.01 * a.mesh.side), i);
	for (size_t i = 0; i < b.pairs.size(); i++)
		boxes.emplace_back(box_of_pair(b, i), i);
	std::vector<bool> is_old(b.pairs.size());
	CGAL::box_intersection_d(old_boxes.begin(), old_boxes.end(), boxes.begin(), boxes.end(),
	                         [&](const triangle_box &, const triangle_box &of_b) { is_old[of_b.info()] = true; });
	std::vector<size_t> result;
	for (size_t i = 0; i < is_old.size(); i++)
		if (!is_old[i])
			result.push_back(i);
	return result;
}

/* Pairs that share a corner, through others too, are one place: print its centre, its size and what is there. */
static void print_places(const surface &s, const std::vector<size_t> &pairs)
{
	std::vector<idx_t> root(s.mesh.points.size());
	std::iota(root.begin(), root.end(), 0);
	const auto find = [&](idx_t v) {
		while (root[v] != v)
			v = root[v] = root[root[v]];
		return v;
	};
	for (size_t i : pairs) {
		const idx_t first = find(s.mesh.triangles[s.pairs[i][0]][0]);
		for (size_t t : s.pairs[i])
			for (idx_t v : s.mesh.triangles[t])
				root[find(v)] = first;
	}
	struct place {
		idx_t root;
		size_t pairs = 0;
		CGAL::Bbox_3 box;
	};
	std::vector<place> places;
	std::vector<int> place_of(root.size(), -1);
	for (size_t i : pairs) {
		const idx_t r = find(s.mesh.triangles[s.pairs[i][0]][0]);
		if (place_of[r] < 0) {
			place_of[r] = static_cast<int>(places.size());
			places.push_back({r, 0, {}});
		}
		places[place_of[r]].pairs++;
		places[place_of[r]].box += box_of_pair(s, i);
	}
	std::stable_sort(places.begin(), places.end(), [](const place &a, const place &b) { return a.pairs > b.pairs; });
	for (const place &p : places)
		std::printf("place=%.6g,%.6g,%.6g size=%.6g pairs=%zu\n", (p.box.xmin() + p.box.xmax()) / 2, (p.box.ymin() + p.box.ymax()) / 2,
		            (p.box.zmin() + p.box.zmax()) / 2, std::max({p.box.x_span(), p.box.y_span(), p.box.z_span()}), p.pairs);
}

/* Are the corners of each within 1e-5 of the longest side of the plane of the other? */
static bool is_in_plane(const surface &s, const pair_of &pair)
{
	for (int i = 0; i < 2; i++) {
		const kernel::Plane_3 plane = s.triangle(pair[i]).supporting_plane();
		for (int c = 0; c < 3; c++)
			if (CGAL::squared_distance(plane, s.corner(pair[1 - i], c)) > 1e-10 * s.mesh.side * s.mesh.side)
				return false;
	}
	return true;
}

static void print_surface(const char *name, const surface &s)
{
	const size_t in_plane = std::count_if(s.pairs.begin(), s.pairs.end(), [&](const pair_of &p) { return is_in_plane(s, p); });
	std::printf("%s_triangles=%zu\n%s_flat=%zu\n%s_pairs=%zu\n%s_in_plane=%zu\n%s_share=%.6g\n", name, s.mesh.triangles.size(), name,
	            s.flat, name, s.pairs.size(), name, in_plane, name, s.area > 0 ? s.crossing_area / s.area : 0);
}

int main(int argc, char **argv)
{
	const bool verbose = argc > 1 && std::strcmp(argv[1], "-v") == 0;
	if (argc - verbose != 3) {
		std::fputs("usage: crossings [-v] part other\n", stderr);
		return EX_BAD_USAGE;
	}
	const surface a = examine(argv[1 + verbose]), b = examine(argv[2 + verbose]);
	const std::vector<size_t> pairs = new_pairs(a, b);
	print_surface("a", a);
	print_surface("b", b);
	std::printf("b_new_pairs=%zu\n", pairs.size());
	if (verbose)
		print_places(b, pairs);
	return EX_DONE;
}
