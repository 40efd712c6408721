#include "data/scanner/solid_boolean.hpp"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Surface_mesh.h>

#include <stdexcept>

namespace meshmser::scanner {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Face = Mesh::Face_index;

constexpr const char* kFaceMap = "f:true_face";

std::int32_t& true_face(Mesh& mesh, Face face) {
  auto [map, found] = mesh.property_map<Face, std::int32_t>(kFaceMap);
  if (!found) throw std::logic_error("combine_solids: a mesh without true faces");
  return map[face];
}

/// Hands each triangle's true face on to the triangles it is cut into and to its copies.
struct FaceKeeper : CGAL::Polygon_mesh_processing::Corefinement::Default_visitor<Mesh> {
  std::int32_t face_being_cut = 0;
  void before_subface_creations(Face face, Mesh& mesh) { face_being_cut = true_face(mesh, face); }
  void after_subface_created(Face face, Mesh& mesh) { true_face(mesh, face) = face_being_cut; }
  void after_face_copy(Face from, const Mesh& source, Face to, Mesh& target) {
    true_face(target, to) = true_face(const_cast<Mesh&>(source), from);
  }
};

Mesh to_cgal(const Shape& shape) {
  Mesh mesh;
  auto face_map = mesh.add_property_map<Face, std::int32_t>(kFaceMap, 0).first;
  for (const Eigen::Vector3d& p : shape.mesh.positions) mesh.add_vertex(Kernel::Point_3(p.x(), p.y(), p.z()));
  using Vertex = Mesh::Vertex_index;
  for (std::size_t t = 0; t < shape.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = shape.mesh.triangles[t];
    const Face face = mesh.add_face(Vertex(static_cast<std::uint32_t>(a)), Vertex(static_cast<std::uint32_t>(b)),
                                    Vertex(static_cast<std::uint32_t>(c)));
    if (face == Mesh::null_face()) throw std::logic_error("combine_solids: a solid is not manifold");
    face_map[face] = shape.face_of_triangle[t];
  }
  return mesh;
}

Shape from_cgal(const Mesh& mesh) {
  Shape shape;
  std::vector<std::int32_t> position_of_vertex(mesh.num_vertices() + mesh.number_of_removed_vertices(), -1);
  for (Mesh::Vertex_index v : mesh.vertices()) {
    position_of_vertex[v] = static_cast<std::int32_t>(shape.mesh.positions.size());
    const Kernel::Point_3& p = mesh.point(v);
    shape.mesh.positions.emplace_back(CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z()));
  }
  const auto face_map = mesh.property_map<Face, std::int32_t>(kFaceMap).first;
  for (Face face : mesh.faces()) {
    std::array<std::int32_t, 3> triangle;
    std::size_t k = 0;
    for (Mesh::Vertex_index v : CGAL::vertices_around_face(mesh.halfedge(face), mesh))
      triangle[k++] = position_of_vertex[v];
    shape.mesh.triangles.push_back(triangle);
    shape.face_of_triangle.push_back(face_map[face]);
  }
  return shape;
}

/// Leaves the result in `one`.
enum class Operation { kUnite, kSubtract };
void apply(Operation operation, Mesh& one, Mesh two) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  const auto with_faces = CGAL::parameters::visitor(FaceKeeper());
  const bool done = operation == Operation::kUnite ? pmp::corefine_and_compute_union(one, two, one, with_faces)
                                                   : pmp::corefine_and_compute_difference(one, two, one, with_faces);
  if (!done) throw std::logic_error("combine_solids: the result is not a closed manifold surface");
}

}  // namespace

Shape combine_solids(const std::vector<Shape>& bodies, const std::vector<Shape>& cutters) {
  Mesh result = to_cgal(bodies.front());
  for (std::size_t i = 1; i < bodies.size(); ++i) apply(Operation::kUnite, result, to_cgal(bodies[i]));
  for (const Shape& cutter : cutters) apply(Operation::kSubtract, result, to_cgal(cutter));
  return from_cgal(result);
}

}  // namespace meshmser::scanner
