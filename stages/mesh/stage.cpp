#include <Eigen/Core>
#include <cstdio>
#include <string>
#include <utility>

#include "pipeline/stage/stage.hpp"
#include "stages/mesh/mesh_points.hpp"

namespace meshmser {

template <>
struct EnumNames<MeshMethod> {
  static constexpr std::pair<MeshMethod, const char*> values[] = {{MeshMethod::kLocalDelaunay, "local_delaunay"},
                                                                  {MeshMethod::kAdvancingFront, "advancing_front"}};
};

namespace {

struct MeshParameters {
  MeshMethod method = MeshMethod::kLocalDelaunay;
  Length max_edge = spacings(5);
  int close_loops = 12;
};

double diagonal(const PointCloud& cloud) {
  if (cloud.positions.empty()) return 0;
  Eigen::Vector3d low = cloud.positions[0], high = low;
  for (const Eigen::Vector3d& p : cloud.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

std::string percent(std::int64_t part, std::int64_t whole) {
  const double share = whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0;
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", share);
  return text;
}

void tell(const MeshedPoints& made, const PointCloud& cloud, RunContext& context) {
  const MeshReport& r = made.report;
  const auto num_points = static_cast<std::int64_t>(cloud.num_points());
  const auto num_vertices = static_cast<std::int64_t>(made.mesh.num_vertices());
  const auto num_triangles = static_cast<std::int64_t>(made.mesh.num_triangles());
  context.report("num_vertices", num_vertices);
  context.report("num_triangles", num_triangles);
  context.report("num_components", r.num_components);
  context.report("num_border_loops", r.num_border_loops);
  context.report("num_border_edges", r.num_border_edges);
  context.report("euler_number", r.euler);
  context.report("num_unused_points", r.unused_points);
  context.report("num_split_vertices", r.split_vertices);
  context.report("num_too_long_triangles", r.too_long);
  context.report("num_triangles_between_sheets", r.between_sheets);
  context.report("num_loops_closed", r.loops.closed);
  context.report("num_loops_left_open", r.loops.left_open);
  context.report("num_inconsistent_triangles", r.repair.inconsistent + r.repair.third_on_edge + r.repair.degenerate);
  const OrientationReport& o = r.orientation;
  context.report("num_components_by_vote", o.by_vote);
  context.report("num_components_by_volume", o.by_volume);
  context.report("num_components_by_guess", o.by_guess + o.undecided);
  context.report("num_vertices_by_guess", o.vertices_by_guess);
  context.report("num_turned_vertices", o.turned_vertices);
  context.report("num_turned_components", o.turned_components);

  if (100 * r.unused_points > num_points)
    context.warn(std::to_string(r.unused_points) + " points (" + percent(r.unused_points, num_points) +
                 ") are in no triangle; where they are wanted, raise mesh.max_edge or check the normals");
  if (100 * r.too_long > num_triangles)
    context.warn(
        std::to_string(r.too_long) + " triangles (" + percent(r.too_long, num_triangles) +
        ") are left out because raw points that smoothing brought together lie farther apart than mesh.max_edge; "
        "passes may be misregistered");
  if (100 * o.turned_vertices > num_vertices)
    context.warn("the mesh turns the normals of " + std::to_string(o.turned_vertices) + " vertices (" +
                 percent(o.turned_vertices, num_vertices) +
                 ") that oppose the surface around them; the signs of H and height follow the mesh there");
}

struct MeshStage {
  static constexpr StageInfo info{"mesh", 2,
                                  "Connects the points to an oriented manifold mesh whose scanning holes stay open "
                                  "[Gopi 2000, Cohen-Steiner 2004]."};
  using Parameters = MeshParameters;

  static void declare(StageSchema& schema) {
    schema.parameter(
        "method", &Parameters::method,
        "local_delaunay: triangles that points agree on in their tangent planes, fast; advancing_front: CGAL's, "
        "for comparison.");
    schema.parameter("max_edge", &Parameters::max_edge, more_than(0), "",
                     "No longer edge is made, between smoothed or between raw points: wider gaps stay holes.");
    schema.parameter("close_loops", &Parameters::close_loops, range(0, 64), "edges",
                     "Cracks whose rim has at most so many edges are closed; 0: none.");
    schema.input<PointCloud>("points");
    schema.input<PointNormals>("normals");
    schema.input<SmoothedPoints>("smoothed", Need::kOptional);
    schema.output<TriangleMesh>("mesh");
  }

  static Outputs run(const Parameters& parameters, const Inputs& inputs, RunContext& context) {
    const auto& cloud = inputs.get<PointCloud>("points");
    MeshOptions options;
    options.method = parameters.method;
    options.max_edge = parameters.max_edge.resolve({cloud.spacing, diagonal(cloud), 0});
    options.close_loops = parameters.close_loops;
    MeshedPoints made = mesh_points(cloud, inputs.get<PointNormals>("normals"), inputs.find<SmoothedPoints>("smoothed"),
                                    options, context.execution());
    tell(made, cloud, context);
    Outputs outputs;
    outputs.set("mesh", std::move(made.mesh));
    return outputs;
  }
};
MESHMSER_STAGE(MeshStage);

}  // namespace
}  // namespace meshmser
