#include "stages/mesh/mesh_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <random>

#include "stages/common/mesh_topology.hpp"
#include "tests/unit/mesh/scattered_shapes.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

class MeshPoints : public testing::TestWithParam<MeshMethod> {
 protected:
  MeshedPoints mesh(const ScatteredShape& shape, double max_edge = 5) const {
    return mesh_points(shape.cloud, shape.normals, nullptr, {GetParam(), max_edge});
  }
};

/// What every mesh must be: a manifold whose normals agree with its triangles.
void expect_sound(const MeshedPoints& made, const ScatteredShape& shape, double max_edge = 5) {
  const TriangleMesh& mesh = made.mesh;
  const MeshTopology topology = describe_topology(mesh.triangles, mesh.num_vertices());
  ASSERT_EQ(topology.defect, "");
  EXPECT_EQ(topology.num_vertices, static_cast<std::int64_t>(mesh.num_vertices()));
  EXPECT_EQ(made.report.euler, topology.euler);
  ASSERT_EQ(mesh.normals.size(), mesh.num_vertices());
  ASSERT_EQ(mesh.turned_of_vertex.size(), mesh.num_vertices());
  ASSERT_EQ(mesh.point_of_vertex.size(), mesh.num_vertices());
  for (std::size_t v = 0; v < mesh.num_vertices(); ++v) {
    const auto p = static_cast<std::size_t>(mesh.point_of_vertex[v]);
    ASSERT_EQ(mesh.positions[v], shape.cloud.positions[p]);
    ASSERT_EQ(mesh.normals[v],
              mesh.turned_of_vertex[v] ? Vector3d(-shape.normals.normals[p]) : shape.normals.normals[p]);
  }
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_LE(
          (mesh.positions[static_cast<std::size_t>(t[k])] - mesh.positions[static_cast<std::size_t>(t[(k + 1) % 3])])
              .norm(),
          max_edge);
}

TEST_P(MeshPoints, PlaneIsADisk) {
  const ScatteredShape shape = scattered_plane(40, 0.35);
  const MeshedPoints made = mesh(shape);
  expect_sound(made, shape);
  EXPECT_EQ(made.report.euler, 1);
  EXPECT_EQ(made.report.num_components, 1);
  EXPECT_EQ(made.report.num_border_loops, 1);
  EXPECT_LE(made.report.unused_points, 2);
  EXPECT_EQ(made.report.orientation.turned_vertices, 0);
  for (const auto& t : made.mesh.triangles) {
    const auto p = [&](std::size_t k) { return made.mesh.positions[static_cast<std::size_t>(t[k])]; };
    EXPECT_GE((p(1) - p(0)).cross(p(2) - p(0)).z(), 0);
  }
}

TEST_P(MeshPoints, ExactGridIsADisk) {
  // Every square has two equally good diagonals, and all points lie in one plane.
  const ScatteredShape shape = scattered_plane(25, 0);
  const MeshedPoints made = mesh(shape);
  expect_sound(made, shape);
  EXPECT_EQ(made.report.euler, 1);
  EXPECT_EQ(made.report.num_border_loops, 1);
  EXPECT_EQ(made.report.num_border_edges, 96);
  EXPECT_EQ(made.mesh.num_triangles(), 2u * 24 * 24);
}

TEST_P(MeshPoints, HolesStayOpenAndIslandsApart) {
  const auto keep = [](double x, double y) {
    const auto in_disc = [&](double cx, double cy, double r) { return std::hypot(x - cx, y - cy) < r; };
    return !in_disc(20, 20, 6) && !in_disc(60, 25, 9) && !in_disc(30, 60, 7) && !(x > 74.5 && x < 81.5);
  };
  const ScatteredShape shape = scattered_plane(100, 0.3, keep);
  const MeshedPoints made = mesh(shape);
  expect_sound(made, shape);
  EXPECT_EQ(made.report.num_components, 2);
  EXPECT_EQ(made.report.num_border_loops, 3 + 2);
  EXPECT_EQ(made.report.euler, 2 - 3);
}

TEST_P(MeshPoints, SphereIsClosedAndFacesOutward) {
  const ScatteredShape shape = scattered_sphere(12);
  const MeshedPoints made = mesh(shape);
  expect_sound(made, shape);
  EXPECT_EQ(made.report.euler, 2);
  EXPECT_EQ(made.report.num_border_loops, 0);
  EXPECT_EQ(made.report.unused_points, 0);
  EXPECT_EQ(made.mesh.num_triangles(), 2 * shape.cloud.num_points() - 4);
  EXPECT_NEAR(signed_volume(made.mesh.positions, made.mesh.triangles), 4.0 / 3 * std::numbers::pi * 12 * 12 * 12, 100);
}

TEST_P(MeshPoints, TorusHasGenusOne) {
  const ScatteredShape shape = scattered_torus(20, 7);
  const MeshedPoints made = mesh(shape);
  expect_sound(made, shape);
  EXPECT_EQ(made.report.euler, 0);
  EXPECT_EQ(made.report.num_components, 1);
  EXPECT_EQ(made.report.num_border_loops, 0);
  EXPECT_GT(signed_volume(made.mesh.positions, made.mesh.triangles), 0);
}

TEST_P(MeshPoints, IsolatedPointsAreDroppedAndCounted) {
  ScatteredShape shape = scattered_plane(20, 0.3);
  shape.add({10, 10, 50}, {0, 0, 1});
  shape.add({-40, 10, 0}, {0, 0, 1});
  const std::int64_t before = mesh(scattered_plane(20, 0.3)).report.unused_points;
  const MeshedPoints made = mesh(shape);
  expect_sound(made, shape);
  EXPECT_EQ(made.report.unused_points, before + 2);
}

TEST_P(MeshPoints, RawEdgesAreBoundedToo) {
  ScatteredShape shape = scattered_plane(20, 0.3);
  SmoothedPoints smoothed;
  smoothed.positions = shape.cloud.positions;
  shape.cloud.positions[210].z() = 30;  // an outlier that smoothing pulled back
  const MeshedPoints made = mesh_points(shape.cloud, shape.normals, &smoothed, {GetParam(), 5});
  expect_sound(made, shape);
  EXPECT_GE(made.report.too_long, 3);
  EXPECT_EQ(std::count(made.mesh.point_of_vertex.begin(), made.mesh.point_of_vertex.end(), 210), 0);
}

/// The surface of a cube of points at whole numbers: nothing but ties.
ScatteredShape cube_of_ties(int side) {
  ScatteredShape shape;
  for (int x = 0; x <= side; ++x)
    for (int y = 0; y <= side; ++y)
      for (int z = 0; z <= side; ++z) {
        const auto out = [&](int i) { return i == 0 ? -1.0 : i == side ? 1.0 : 0.0; };
        const Vector3d normal(out(x), out(y), out(z));
        if (!normal.isZero(0)) shape.add(Vector3d(x, y, z), normal.normalized());
      }
  return shape.finish();
}

/// Leaves the heap full of gaps of many sizes, freed in random order: whatever is allocated next lies anywhere.
std::vector<std::unique_ptr<char[]>> scattered_heap(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::unique_ptr<char[]>> kept, freed;
  for (int i = 0; i < 60000; ++i) (i % 2 ? kept : freed).push_back(std::make_unique<char[]>(16 + random() % 400));
  std::shuffle(freed.begin(), freed.end(), random);
  for (auto& block : freed) block.reset();
  return kept;
}

TEST_P(MeshPoints, SameBytesAgainAndWithOtherThreads) {
  for (const ScatteredShape& shape : {scattered_torus(15, 6), cube_of_ties(14)}) {
    const MeshedPoints first = mesh(shape);
    for (const int threads : {1, 2, 7}) {
      const auto disturbance = scattered_heap(static_cast<std::uint32_t>(threads));
      Execution execution;
      execution.threads = threads;
      const MeshedPoints again = mesh_points(shape.cloud, shape.normals, nullptr, {GetParam(), 5}, execution);
      EXPECT_TRUE(again.mesh.triangles == first.mesh.triangles);
      EXPECT_EQ(again.mesh.point_of_vertex, first.mesh.point_of_vertex);
    }
  }
}

TEST_P(MeshPoints, StopsWhenAskedAtAnyTime) {
  const ScatteredShape shape = scattered_torus(20, 7);
  int reports = 0;
  Execution counting;
  counting.threads = 1;
  counting.progress = [&](std::string_view, std::int64_t, std::int64_t) { ++reports; };
  mesh_points(shape.cloud, shape.normals, nullptr, {GetParam(), 5}, counting);
  ASSERT_GE(reports, 3);
  for (int stop = 1; stop < reports; stop += std::max(1, reports / 20)) {
    std::atomic<bool> cancelled = false;
    int seen = 0;
    Execution execution;
    execution.threads = 1;
    execution.cancelled = &cancelled;
    execution.progress = [&](std::string_view, std::int64_t, std::int64_t) { cancelled = ++seen >= stop; };
    EXPECT_THROW(mesh_points(shape.cloud, shape.normals, nullptr, {GetParam(), 5}, execution), Cancelled) << stop;
  }
}

TEST_P(MeshPoints, CoincidentPointsAreUsedOnce) {
  ScatteredShape shape = scattered_plane(20, 0.3);
  shape.add(shape.cloud.positions[150], {0, 0, 1});
  const MeshedPoints made = mesh(shape);
  expect_sound(made, shape);
  EXPECT_EQ(made.report.euler, 1);
  EXPECT_EQ(std::count(made.mesh.point_of_vertex.begin(), made.mesh.point_of_vertex.end(), 150) +
                std::count(made.mesh.point_of_vertex.begin(), made.mesh.point_of_vertex.end(), 400),
            1);
}

TEST_P(MeshPoints, TellsWhatItCannotMesh) {
  const auto message = [&](const ScatteredShape& shape, double max_edge) -> std::string {
    try {
      mesh(shape, max_edge);
    } catch (const StageError& error) {
      return error.what();
    }
    return "no error";
  };
  ScatteredShape line;
  for (int i = 0; i < 30; ++i) line.add({1.0 * i, 0, 0}, {0, 0, 1});
  EXPECT_THAT(message(line.finish(), 5), testing::HasSubstr("no triangle among 30 points has edges of at most 5"));
  EXPECT_THAT(message(scattered_plane(10, 0.2), 0.1), testing::HasSubstr("no triangle"));
  EXPECT_THAT(message(scattered_plane(10, 0.2), 0), testing::HasSubstr("max_edge must be positive and finite"));
  EXPECT_THAT(message(scattered_plane(10, 0.2), std::numeric_limits<double>::quiet_NaN()),
              testing::HasSubstr("max_edge must be positive and finite"));
  ScatteredShape empty;
  EXPECT_THAT(message(empty.finish(), 5), testing::HasSubstr("no triangle among 0 points"));
  ScatteredShape shorter = scattered_plane(10, 0.2);
  shorter.normals.normals.pop_back();
  EXPECT_THAT(message(shorter, 5), testing::HasSubstr("99 normals do not belong to 100 points"));
  ScatteredShape broken = scattered_plane(10, 0.2);
  broken.normals.normals[7].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(broken, 5), testing::HasSubstr("the position or normal of point 7 is not finite"));
}

INSTANTIATE_TEST_SUITE_P(Methods, MeshPoints, testing::Values(MeshMethod::kAdvancingFront, MeshMethod::kLocalDelaunay),
                         [](const auto& param) {
                           return std::string(param.param == MeshMethod::kAdvancingFront ? "AdvancingFront"
                                                                                         : "LocalDelaunay");
                         });

// The votes on the sides.

struct Voted {
  MeshedPoints made;
  double volume;
};
Voted vote(const ScatteredShape& shape) {
  Voted voted{mesh_points(shape.cloud, shape.normals, nullptr, {MeshMethod::kAdvancingFront, 5}), 0};
  voted.volume = signed_volume(voted.made.mesh.positions, voted.made.mesh.triangles);
  return voted;
}

TEST(OrientationVote, TrustedNormalsOutvoteAFlippedPatch) {
  ScatteredShape shape = scattered_sphere(10);
  std::int64_t flipped = 0;
  for (std::size_t p = 0; p < shape.cloud.num_points(); ++p)
    if (shape.cloud.positions[p].x() > 6) {
      shape.normals.normals[p] *= -1;
      ++flipped;
    }
  const Voted voted = vote(shape);
  EXPECT_GT(voted.volume, 0);
  EXPECT_EQ(voted.made.report.orientation.by_vote, 1);
  EXPECT_EQ(voted.made.report.orientation.turned_vertices, flipped);
  EXPECT_EQ(voted.made.report.orientation.turned_components, 0);
  for (std::size_t v = 0; v < voted.made.mesh.num_vertices(); ++v) {
    EXPECT_EQ(voted.made.mesh.turned_of_vertex[v] != 0, voted.made.mesh.positions[v].x() > 6);
    EXPECT_GT(voted.made.mesh.normals[v].dot(voted.made.mesh.positions[v]), 0);
  }
}

TEST(OrientationVote, TrustedNormalsMayPointInward) {
  ScatteredShape shape = scattered_sphere(8);
  for (Vector3d& n : shape.normals.normals) n *= -1;
  const Voted voted = vote(shape);
  EXPECT_LT(voted.volume, 0);
  EXPECT_EQ(voted.made.report.orientation.turned_vertices, 0);
}

TEST(OrientationVote, VolumeDecidesWhereAllAreGuesses) {
  ScatteredShape shape = scattered_sphere(8);
  for (Vector3d& n : shape.normals.normals) n *= -1;
  shape.finish(SignSource::kGuess);
  const Voted voted = vote(shape);
  EXPECT_GT(voted.volume, 0);
  EXPECT_EQ(voted.made.report.orientation.by_volume, 1);
  EXPECT_EQ(voted.made.report.orientation.turned_vertices, static_cast<std::int64_t>(voted.made.mesh.num_vertices()));
  EXPECT_EQ(voted.made.report.orientation.turned_components, 1);
}

TEST(OrientationVote, OpenSheetOfGuessesKeepsItsGuess) {
  for (const double side : {1.0, -1.0}) {
    ScatteredShape shape = scattered_plane(20, 0.3);
    for (Vector3d& n : shape.normals.normals) n *= side;
    const MeshedPoints made = vote(shape.finish(SignSource::kGuess)).made;
    EXPECT_EQ(made.report.orientation.by_guess, 1);
    EXPECT_EQ(made.report.orientation.vertices_by_guess, static_cast<std::int64_t>(made.mesh.num_vertices()));
    EXPECT_EQ(made.report.orientation.turned_vertices, 0);
    const auto& t = made.mesh.triangles[0];
    const auto p = [&](std::size_t k) { return made.mesh.positions[static_cast<std::size_t>(t[k])]; };
    EXPECT_GT((p(1) - p(0)).cross(p(2) - p(0)).z() * side, 0);
  }
}

TEST(OrientationVote, EachComponentVotesForItself) {
  ScatteredShape shape;
  add_sphere(shape, 8, {0, 0, 0});
  const std::size_t first = shape.cloud.num_points();
  add_sphere(shape, 8, {40, 0, 0});
  shape.finish();
  for (std::size_t p = first; p < shape.cloud.num_points(); ++p) shape.normals.normals[p] *= -1;
  const Voted voted = vote(shape);
  EXPECT_EQ(voted.made.report.num_components, 2);
  EXPECT_EQ(voted.made.report.orientation.by_vote, 2);
  EXPECT_EQ(voted.made.report.orientation.turned_vertices, 0);
  EXPECT_NEAR(voted.volume, 0, 60);
}

TEST(OrientationVote, PointsWithoutNormalTakeTheTriangles) {
  ScatteredShape shape = scattered_sphere(8);
  for (std::size_t p = 0; p < shape.cloud.num_points(); p += 7) {
    shape.normals.normals[p].setZero();
    shape.normals.component_of_point[p] = -1;
  }
  const Voted voted = vote(shape);
  for (std::size_t v = 0; v < voted.made.mesh.num_vertices(); ++v) {
    EXPECT_EQ(voted.made.mesh.turned_of_vertex[v], 0);
    EXPECT_NEAR(voted.made.mesh.normals[v].norm(), 1, 1e-9);
    EXPECT_GT(voted.made.mesh.normals[v].dot(voted.made.mesh.positions[v].normalized()), 0.9);
  }
}

}  // namespace
}  // namespace meshmser
