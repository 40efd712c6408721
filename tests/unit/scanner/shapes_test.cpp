#include "data/scanner/shapes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "data/scanner/solid_boolean.hpp"
#include "data/scanner/solids.hpp"
#include "pipeline/execution/error.hpp"

namespace meshmser::scanner {
namespace {

/// How often each directed edge occurs.
std::map<std::pair<std::int32_t, std::int32_t>, int> directed_edges(const TriangleMesh& mesh) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
  for (const auto& triangle : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{triangle[k], triangle[(k + 1) % 3]}];
  return edges;
}

double signed_volume(const TriangleMesh& mesh) {
  double volume = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    volume += mesh.positions[static_cast<std::size_t>(a)].dot(
                  mesh.positions[static_cast<std::size_t>(b)].cross(mesh.positions[static_cast<std::size_t>(c)])) /
              6;
  return volume;
}

void expect_closed(const Shape& shape, const std::string& name) {
  EXPECT_EQ(shape.face_of_triangle.size(), shape.mesh.num_triangles()) << name;
  int wrong = 0;
  const auto edges = directed_edges(shape.mesh);
  for (const auto& [edge, count] : edges) {
    const auto twin = edges.find({edge.second, edge.first});
    wrong += count != 1 || twin == edges.end() || twin->second != 1;
  }
  EXPECT_EQ(wrong, 0) << name << ": edges not in exactly two triangles of opposite direction";
  EXPECT_GT(signed_volume(shape.mesh), 0) << name;
}

TEST(Shapes, EachIsClosedAndOutwardWithFacesFromOne) {
  for (const ShapeInfo& info : shape_catalogue()) {
    const Shape shape = make_shape(info.name);
    expect_closed(shape, info.name);
    const std::set<std::int32_t> faces(shape.face_of_triangle.begin(), shape.face_of_triangle.end());
    EXPECT_EQ(*faces.begin(), 1) << info.name;
    EXPECT_EQ(*faces.rbegin(), static_cast<std::int32_t>(faces.size())) << info.name;
  }
}

TEST(Shapes, VolumesAreThoseOfTheSolids) {
  EXPECT_NEAR(signed_volume(make_shape("plane").mesh), 40 * 40 * 3, 1e-6);
  EXPECT_NEAR(signed_volume(make_shape("sphere").mesh) / (4 / 3.0 * std::numbers::pi * 1000), 1, 1e-3);
  EXPECT_NEAR(signed_volume(make_shape("torus").mesh) / (2 * std::numbers::pi * std::numbers::pi * 15 * 25), 1, 2e-3);
  EXPECT_NEAR(signed_volume(make_shape("cylinder").mesh) / (std::numbers::pi * 64 * 30), 1, 1e-3);
  EXPECT_NEAR(signed_volume(make_shape("diamond").mesh), 16 * 100 * 2.5 / 3 + 1600 * 4, 1e-6);
}

TEST(Shapes, DiamondHasFourFacetsAPyramidWithTheirAngles) {
  const Shape shape = make_shape("diamond", {{"cells", 2}, {"thickness", 0}});
  const std::set<std::int32_t> faces(shape.face_of_triangle.begin(), shape.face_of_triangle.end());
  EXPECT_EQ(faces.size(), 16u);
  // Slope 1 : 2; valleys turn by 2 atan(1 / 2), ridges by acos(4 / 5).
  std::map<int, int> samples_of_angle;
  for (const EdgeSample& sample : true_edges(shape, 100))
    ++samples_of_angle[static_cast<int>(std::lround(sample.angle))];
  ASSERT_EQ(samples_of_angle.size(), 2u);
  EXPECT_EQ(samples_of_angle[37], 4 * 4 * 5);  // four ridges a pyramid, of five mesh edges each
  EXPECT_EQ(samples_of_angle[53], 4 * 10);     // four valleys of a pyramid's side
}

TEST(Shapes, TrueEdgesAreSampledAtTheStep) {
  const Shape shape = box({0, 0, 0}, {10, 10, 10}, 1);
  const auto samples = true_edges(shape, 0.3);
  EXPECT_EQ(samples.size(), 12u * 34u);
  for (const EdgeSample& sample : samples) {
    EXPECT_NEAR(sample.angle, 90, 1e-9);
    int on_wall = 0;
    for (int c = 0; c < 3; ++c) on_wall += sample.position[c] == 0 || sample.position[c] == 10;
    EXPECT_EQ(on_wall, 2);
  }
}

TEST(Shapes, FacesByAngleFindsTheFacesOfACylinderWithSplitVertices) {
  const Shape cylinder = make_shape("cylinder");
  Shape soup;
  for (const auto& triangle : cylinder.mesh.triangles) {
    const auto first = static_cast<std::int32_t>(soup.mesh.positions.size());
    for (std::int32_t v : triangle) soup.mesh.positions.push_back(cylinder.mesh.positions[static_cast<std::size_t>(v)]);
    soup.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const std::vector<std::int32_t> faces = faces_by_angle(soup.mesh, 30);
  std::map<std::int32_t, std::int32_t> face_of_true_face;
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const auto entry = face_of_true_face.try_emplace(cylinder.face_of_triangle[t], faces[t]).first;
    EXPECT_EQ(entry->second, faces[t]);
  }
  EXPECT_EQ(std::set<std::int32_t>(faces.begin(), faces.end()).size(), 3u);
}

TEST(Shapes, BooleanKeepsFacesAndVolume) {
  const Shape body = box({0, 0, 0}, {10, 10, 10}, 1), knob = box({4, 4, 9}, {6, 6, 12}, 11),
              pocket = box({1, 1, 8}, {3, 3, 11}, 21);
  const Shape part = combine_solids({body, knob}, {pocket});
  expect_closed(part, "part");
  EXPECT_NEAR(signed_volume(part.mesh), 1000 + 8 - 8, 1e-9);
  for (std::size_t t = 0; t < part.mesh.num_triangles(); ++t) {
    const std::int32_t face = part.face_of_triangle[t];
    for (std::int32_t v : part.mesh.triangles[t]) {
      const Eigen::Vector3d& p = part.mesh.positions[static_cast<std::size_t>(v)];
      if (face == 6) {
        EXPECT_EQ(p.z(), 10);
      }
      if (face == 16) {
        EXPECT_EQ(p.z(), 12);
      }
      if (face == 25) {
        EXPECT_EQ(p.z(), 8);
      }  // the pocket's floor
    }
  }
  const std::set<std::int32_t> faces(part.face_of_triangle.begin(), part.face_of_triangle.end());
  EXPECT_EQ(faces, (std::set<std::int32_t>{1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 16, 21, 22, 23, 24, 25}));
}

TEST(Shapes, TabletHasGroovesOfTheDepthAskedFor) {
  const Shape shape = make_shape("tablet", {{"bulge", 0}, {"waviness", 0}, {"edge", 0.1}});
  double lowest = 0;
  for (std::size_t t = 0; t < shape.mesh.num_triangles(); ++t)
    for (std::int32_t v : shape.mesh.triangles[t])
      if (shape.face_of_triangle[t] <= 2)
        lowest = std::min(lowest, shape.mesh.positions[static_cast<std::size_t>(v)].z());
  EXPECT_NEAR(lowest, -0.2, 0.002);
}

TEST(Shapes, ErrorsNameWhatIsKnown) {
  auto message = [](const std::string& name, const ShapeParameters& parameters) -> std::string {
    try {
      make_shape(name, parameters);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_NE(message("cube", {}).find("unknown shape 'cube'; known: plane, sphere"), std::string::npos);
  EXPECT_EQ(message("sphere", {{"size", 1}}), "shape 'sphere' has no parameter 'size'; it has: radius, level");
  EXPECT_EQ(message("sphere", {{"radius", -1}}), "shape 'sphere': radius = -1 must be above 0");
}

}  // namespace
}  // namespace meshmser::scanner
