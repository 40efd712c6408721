#include "stages/mesh/advancing_front.hpp"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/spatial_sort.h>

#include <list>
#include <numeric>
#include <utility>

namespace meshmser {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

/// A place for a front edge in the vertex that it leaves. Its serial number belongs to the place, not to what is stored
/// there: assignment does not copy it.
template <class Facet>
struct FrontEdge : std::pair<Facet, Facet> {
  using Base = std::pair<Facet, Facet>;
  std::uint64_t serial;

  static std::uint64_t next_serial() {
    static thread_local std::uint64_t serials = 0;
    return ++serials;
  }
  FrontEdge() : serial(next_serial()) {}
  FrontEdge(const Facet& inner, const Facet& outer) : Base(inner, outer), serial(next_serial()) {}
  FrontEdge(const FrontEdge& other) : Base(other), serial(next_serial()) {}
  FrontEdge& operator=(const FrontEdge& other) {
    Base::operator=(other);
    return *this;
  }
};

/// An entry of the front's queue: by value, then by serial number. CGAL's own vertex compares the pointers, so that
/// ties (an ear is the candidate of two edges, and all postponed edges share one value) depend on the allocator.
template <class Edge>
struct QueueEntry {
  double first;
  Edge* second;
  QueueEntry(double value, Edge* edge) : first(value), second(edge) {}
  bool operator<(const QueueEntry& other) const {
    if (first != other.first) return first < other.first;
    return second->serial < other.second->serial;
  }
};

/// The vertex that CGAL's reconstruction asks for (members are named as it names them), with an ordered queue.
template <class Base = CGAL::Triangulation_vertex_base_3<Kernel>>
struct FrontVertex : Base {
  template <class Tds>
  struct Rebind_TDS {
    using Other = FrontVertex<typename Base::template Rebind_TDS<Tds>::Other>;
  };
  using typename Base::Cell_handle;
  using typename Base::Vertex_handle;
  using Edge = CGAL::Triple<Cell_handle, int, int>;
  using Edge_incident_facet = std::pair<Edge, int>;
  using IO_edge_type = FrontEdge<Edge_incident_facet>;
  using criteria = double;
  using Radius_edge_type = std::pair<criteria, IO_edge_type>;
  using Border_elt = std::pair<Radius_edge_type, int>;
  using Next_border_elt = std::pair<Vertex_handle, Border_elt>;
  using Intern_successors_type = std::pair<Next_border_elt*, Next_border_elt*>;
  using Radius_ptr_type = QueueEntry<IO_edge_type>;
  using Edge_like = std::pair<Vertex_handle, Vertex_handle>;
  using Incidence_request_elt = std::pair<criteria, Edge_like>;
  using Incidence_request_type = std::list<Incidence_request_elt>;
  using Incidence_request_iterator = typename Incidence_request_type::iterator;

  std::size_t m_id = 0;
  int m_mark = -1;
  int m_post_mark = -1;
  Intern_successors_type* m_incident_border = nullptr;
  typename std::list<Vertex_handle>::iterator m_ie_first, m_ie_last;
  Incidence_request_iterator m_ir_first, m_ir_last;

  using Base::Base;

  std::size_t& id() { return m_id; }
  const std::size_t& id() const { return m_id; }

  void delete_border() { m_incident_border = nullptr; }
  Next_border_elt* first_incident() const { return m_incident_border ? m_incident_border->first : nullptr; }
  Next_border_elt* second_incident() const { return m_incident_border ? m_incident_border->second : nullptr; }
  Next_border_elt* next_on_border(int border) const {
    if (!m_incident_border) return nullptr;
    for (Next_border_elt* next : {m_incident_border->first, m_incident_border->second})
      if (next->first != nullptr && next->second.second == border) return next;
    return nullptr;
  }
  Next_border_elt* border_elt(Vertex_handle vertex) const {
    if (!m_incident_border) return nullptr;
    for (Next_border_elt* next : {m_incident_border->first, m_incident_border->second})
      if (next->first == vertex) return next;
    return nullptr;
  }
  bool is_border_edge(Vertex_handle vertex) const { return border_elt(vertex) != nullptr; }
  void set_next_border_elt(const Next_border_elt& element) {
    Next_border_elt* free_place =
        m_incident_border->first->first == nullptr ? m_incident_border->first : m_incident_border->second;
    *free_place = element;
  }

  bool is_on_border() const { return m_mark > 0; }
  bool not_interior() const { return m_mark != 0; }
  int number_of_incident_border() const { return m_mark; }
  bool is_exterior() const { return m_mark < 0; }
  void inc_mark() { m_mark = m_mark == -1 ? 1 : m_mark + 1; }
  void set_post_mark(int mark) { m_post_mark = mark; }
  bool is_post_marked(int mark) const { return m_post_mark == mark; }
};

using Structure =
    CGAL::Triangulation_data_structure_3<FrontVertex<>,
                                         CGAL::Advancing_front_surface_reconstruction_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, Structure>;

/// CGAL's usual priority of a facet, but infinite where an edge is too long. CGAL calls it all through the growth, so
/// it is also where the user's wish to stop is heard.
class BoundedPriority {
 public:
  BoundedPriority(double max_edge, std::int64_t num_points, const Execution& execution)
      : squared_max_edge_(max_edge * max_edge), num_points_(num_points), execution_(&execution) {}

  template <class Front, class Cell>
  double operator()(const Front& front, Cell& cell, const int& index) const {
    if (++calls_ % 4096 == 0) {
      execution_->report("grow the surface", std::min<std::int64_t>(front.number_of_facets() / 2, num_points_),
                         num_points_);
    }
    const Point& a = cell->vertex((index + 1) & 3)->point();
    const Point& b = cell->vertex((index + 2) & 3)->point();
    const Point& c = cell->vertex((index + 3) & 3)->point();
    if (CGAL::squared_distance(a, b) > squared_max_edge_ || CGAL::squared_distance(b, c) > squared_max_edge_ ||
        CGAL::squared_distance(c, a) > squared_max_edge_)
      return front.infinity();
    return front.smallest_radius_delaunay_sphere(cell, index);
  }

 private:
  double squared_max_edge_;
  std::int64_t num_points_;
  const Execution* execution_;
  mutable std::uint64_t calls_ = 0;
};

}  // namespace

std::vector<Triangle> advancing_front(const std::vector<Eigen::Vector3d>& positions, double max_edge,
                                      const Execution& execution) {
  std::vector<Triangle> triangles;
  if (positions.size() < 3) return triangles;
  const auto num_points = static_cast<std::int64_t>(positions.size());

  std::vector<Point> points;
  points.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::ptrdiff_t> order(positions.size());
  std::iota(order.begin(), order.end(), std::ptrdiff_t{0});
  CGAL::spatial_sort(order.begin(), order.end(), CGAL::Spatial_sort_traits_adapter_3<Kernel, Point*>(points.data()));
  Delaunay delaunay;
  Delaunay::Vertex_handle hint;
  for (std::size_t done = 0; done < order.size(); ++done) {
    if (done % 4096 == 0) execution.report("3D Delaunay triangulation", static_cast<std::int64_t>(done), num_points);
    const auto before = delaunay.number_of_vertices();
    const auto point = static_cast<std::size_t>(order[done]);
    hint = delaunay.insert(points[point], hint);
    if (delaunay.number_of_vertices() != before) hint->id() = point;
  }

  CGAL::Advancing_front_surface_reconstruction<Delaunay, BoundedPriority> front(
      delaunay, BoundedPriority(max_edge, num_points, execution));
  front.run();
  const auto& surface = front.triangulation_data_structure_2();
  for (auto face = surface.faces_begin(); face != surface.faces_end(); ++face) {
    if (!face->is_on_surface()) continue;
    Triangle t;
    for (int k = 0; k < 3; ++k)
      t[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(face->vertex(k)->vertex_3()->id());
    triangles.push_back(t);
  }
  sort_triangles(triangles);
  return triangles;
}

}  // namespace meshmser
