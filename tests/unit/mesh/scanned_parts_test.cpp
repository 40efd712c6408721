/// From a virtual scan to the mesh, through load, orient and curvature: what the mesh of a known shape must be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data/scanner/shapes.hpp"
#include "data/scanner/virtual_scanner.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/mesh_topology.hpp"
#include "stages/curvature/curvature.hpp"
#include "stages/load/load_scan.hpp"
#include "stages/mesh/mesh_points.hpp"
#include "stages/orient/orient.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

struct Scanned {
  scanner::SimulatedScan scan;
  PointCloud cloud;
  PointNormals normals;
  Curvature curvature;

  MeshedPoints meshed(MeshMethod method) const {
    return mesh_points(cloud, normals, &curvature.smoothed, {method, 5 * cloud.spacing, 12});
  }
};

Scanned scanned(const std::string& name, const scanner::ShapeParameters& parameters, int views, double cone,
                scanner::ScanOptions options, std::int64_t num_points) {
  const scanner::Shape shape = scanner::make_shape(name, parameters);
  const scanner::Extent extent = scanner::extent_of(shape.mesh);
  const auto poses = scanner::poses_around(extent.centre, 6 * extent.radius, views, cone, Vector3d(0, 0, 1));
  options.spacing = scanner::spacing_for_points(shape, poses, options, num_points);
  Scanned result;
  result.scan = scanner::scan_shape(shape, poses, options);
  PosedScan raw;
  raw.geometry.positions = result.scan.points;
  result.cloud = load_scan({raw}).points;
  result.normals = orient(result.cloud, {}).normals;
  CurvatureOptions measured;
  measured.radius = 4 * result.cloud.spacing;
  result.curvature = measure_curvature(result.cloud, result.normals, measured);
  return result;
}

MeshTopology topology_of(const TriangleMesh& mesh) {
  return describe_topology(mesh.triangles, mesh.num_vertices());
}

// The two sheets of a plate 3 spacings thick, scanned from all around: 4 spacings of radius see both, and yet normals,
// curvature, smoothed positions and mesh of either are those of a plane.
TEST(ThinPlate, SheetsDoNotMix) {
  constexpr double kHalfSide = 10, kThickness = 0.42;
  for (const double noise : {0.05, 0.1}) {
    SCOPED_TRACE(testing::Message() << "noise " << noise);
    scanner::ScanOptions options;
    options.noise = noise;
    const Scanned s = scanned("plane", {{"size", 2 * kHalfSide}, {"thickness", kThickness}}, 14, 180, options, 40000);
    const double h = s.cloud.spacing, radius = 4 * h;
    ASSERT_NEAR(kThickness / h, 3, 0.3);  // and the noise .07 and .15 h
    double low = 1e9, high = -1e9;
    for (const Vector3d& p : s.cloud.positions) low = std::min(low, p.z()), high = std::max(high, p.z());
    const double middle = (low + high) / 2;
    const auto inside = [&](const Vector3d& p) {
      return std::max(std::abs(p.x()), std::abs(p.y())) < kHalfSide - 3 * radius;
    };
    const ScalarField& mean_curvature = *s.curvature.scalars.find("mean_curvature");
    double right = 0, seen = 0, total = 0, sum = 0, squares = 0, farthest = 0;
    for (std::size_t i = 0; i < s.cloud.num_points(); ++i) {
      const Vector3d truth =
          s.scan.true_normals[static_cast<std::size_t>(s.cloud.raw_index_of_point[i])].cast<double>();
      seen += 1;
      right += s.normals.normals[i].dot(truth) > 0;
      if (!inside(s.cloud.positions[i])) continue;
      const double value = mean_curvature.values[i];
      total += 1, sum += value, squares += value * value;
      const double z = s.curvature.smoothed.positions[i].z() - middle;
      farthest = std::max(farthest, std::abs(std::abs(z) - kThickness / 2));
      EXPECT_GT(z * truth.z(), 0);
    }
    EXPECT_GT(right / seen, 0.99);
    EXPECT_GT(total, 10000);
    EXPECT_NEAR(sum / total, 0, 0.1 * mean_curvature.noise);
    EXPECT_NEAR(std::sqrt(squares / total) / mean_curvature.noise, 1, 0.3);
    EXPECT_LT(farthest, 0.5 * h);
    for (const MeshMethod method : {MeshMethod::kLocalDelaunay, MeshMethod::kAdvancingFront}) {
      const MeshedPoints made = s.meshed(method);
      EXPECT_EQ(topology_of(made.mesh).defect, "");
      printf(" unused %ld vote %ld vol %ld guess %ld\n", (long)made.report.unused_points,
             (long)made.report.orientation.by_vote, (long)made.report.orientation.by_volume,
             (long)made.report.orientation.by_guess);
      const std::vector<std::int32_t> twins = twin_half_edges(made.mesh.triangles, made.mesh.num_vertices());
      double between = 0, turned = 0, open = 0;
      for (std::size_t f = 0; f < made.mesh.triangles.size(); ++f) {
        const auto& t = made.mesh.triangles[f];
        const auto corner = [&](int k) -> const Vector3d& {
          return made.mesh.positions[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
        };
        if (!inside(corner(0))) continue;
        const bool above = corner(0).z() > middle;
        between += above != (corner(1).z() > middle) || above != (corner(2).z() > middle);
        const double up = (corner(1) - corner(0)).cross(corner(2) - corner(0)).z();
        turned += (up > 0) != above;
        for (std::size_t k = 0; k < 3; ++k) open += twins[3 * f + k] < 0;
      }
      EXPECT_EQ(between, 0) << "method " << static_cast<int>(method);
      EXPECT_EQ(open, 0) << "method " << static_cast<int>(method);
      // Raw positions: a few triangles stand on edge in the noise.
      EXPECT_LT(turned, 0.002 * static_cast<double>(made.mesh.num_triangles())) << static_cast<int>(method);
    }
  }
}

struct Holed {
  const char* shape;
  scanner::ShapeParameters parameters;
  int views;
  double cone;
  int outer_rims;
};

class KnownHoles : public testing::TestWithParam<Holed> {};

// Four holes and the outer rims of an open sheet stay; every crack is closed.
TEST_P(KnownHoles, AreAllThatStaysOpen) {
  const Holed& c = GetParam();
  scanner::ScanOptions options;
  options.noise = 0.3;
  options.holes = 4;
  const Scanned s = scanned(c.shape, c.parameters, c.views, c.cone, options, 40000);
  // On an open sheet a hole may lie on the rim, and is then a part of it.
  const std::int64_t num_holes =
      c.outer_rims == 0
          ? 4
          : std::count_if(s.scan.holes.begin(), s.scan.holes.end(), [](const scanner::ScanHole& hole) {
              constexpr double kHalfSide = 20;
              return std::max(std::abs(hole.centre.x()), std::abs(hole.centre.y())) + hole.radius < kHalfSide;
            });
  ASSERT_EQ(s.scan.holes.size(), 4u);
  ASSERT_GE(num_holes, 2);
  for (const MeshMethod method : {MeshMethod::kLocalDelaunay, MeshMethod::kAdvancingFront}) {
    const MeshedPoints made = s.meshed(method);
    const MeshTopology topology = topology_of(made.mesh);
    EXPECT_EQ(topology.defect, "");
    EXPECT_EQ(topology.loops_longer_than(12), num_holes + c.outer_rims) << "method " << static_cast<int>(method);
    // None in the middle of a hole.
    for (const auto& t : made.mesh.triangles)
      for (const std::int32_t v : t)
        for (const scanner::ScanHole& hole : s.scan.holes) {
          const auto vertex = static_cast<std::size_t>(v);
          const Vector3d from_centre = made.mesh.positions[vertex] + made.mesh.origin - hole.centre;
          EXPECT_FALSE(from_centre.norm() < 0.6 * hole.radius && made.mesh.normals[vertex].dot(hole.normal) > 0.9);
        }
  }
}

INSTANTIATE_TEST_SUITE_P(Mesh, KnownHoles,
                         testing::Values(Holed{"sphere", {}, 8, 180, 0}, Holed{"torus", {}, 10, 180, 0},
                                         Holed{"bracket", {}, 14, 180, 0},
                                         Holed{"plane", {{"thickness", 0}}, 3, 20, 1}),
                         [](const auto& test) { return std::string(test.param.shape); });

class BothMethods : public testing::TestWithParam<const char*> {};

TEST_P(BothMethods, FindNearlyTheSameTriangles) {
  const auto& info = scanner::shape_info(GetParam());
  for (const double noise : {0.1, 0.3}) {
    scanner::ScanOptions options;
    options.noise = noise;
    options.holes = 4;
    const Scanned s = scanned(GetParam(), {}, info.views, info.cone, options, 40000);
    const MeshedPoints local = s.meshed(MeshMethod::kLocalDelaunay), front = s.meshed(MeshMethod::kAdvancingFront);
    EXPECT_GE(static_cast<double>(local.mesh.num_triangles()), 0.998 * static_cast<double>(front.mesh.num_triangles()))
        << "noise " << noise;
    EXPECT_EQ(topology_of(local.mesh).defect, "");
  }
}

INSTANTIATE_TEST_SUITE_P(Mesh, BothMethods, testing::Values("pump", "bracket", "diamond"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace meshmser
