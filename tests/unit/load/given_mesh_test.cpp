#include "stages/load/given_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "stages/load/load_scan.hpp"
#include "stages/load/polygon_cut.hpp"

namespace meshmser {
namespace {

using ::testing::HasSubstr;

PosedScan mesh_of(std::vector<Eigen::Vector3d> positions, const std::vector<std::vector<std::int32_t>>& faces) {
  PosedScan scan;
  scan.geometry.name = "mesh.off";
  scan.geometry.positions = std::move(positions);
  scan.geometry.first_corner_of_face.push_back(0);
  for (const auto& face : faces) {
    scan.geometry.corners.insert(scan.geometry.corners.end(), face.begin(), face.end());
    scan.geometry.first_corner_of_face.push_back(static_cast<std::int64_t>(scan.geometry.corners.size()));
  }
  return scan;
}

const std::vector<Eigen::Vector3d> kCube{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                         {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
const std::vector<std::vector<std::int32_t>> kCubeFaces{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// Straight from the definition: each directed edge once; around each vertex one fan.
void expect_manifold(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> directed;
  std::map<int, std::map<int, int>> next_around;  // vertex -> from -> to
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_TRUE(directed.insert({t[k], t[(k + 1) % 3]}).second) << "edge twice the same way";
      next_around[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
    }
  ASSERT_EQ(next_around.size(), mesh.num_vertices()) << "a vertex without triangles";
  for (const auto& [vertex, next] : next_around) {
    std::set<int> targets;
    for (const auto& [from, to] : next) targets.insert(to);
    int start = next.begin()->first;
    for (const auto& [from, to] : next)
      if (targets.count(from) == 0) start = from;
    std::size_t walked = 0;
    for (auto step = next.find(start); step != next.end() && walked < next.size(); step = next.find(step->second))
      ++walked;
    EXPECT_EQ(walked, next.size()) << "two fans at vertex " << vertex;
  }
}

TEST(GivenMesh, PolygonsAreCutAndNormalsPointOut) {
  const LoadedScan loaded = load_scan({mesh_of(kCube, kCubeFaces)});
  ASSERT_TRUE(loaded.mesh.has_value());
  EXPECT_EQ(loaded.mesh->num_triangles(), 12u);
  EXPECT_EQ(loaded.report.mesh.num_polygons_cut, 6);
  expect_manifold(*loaded.mesh);
  for (std::size_t v = 0; v < 8; ++v) {
    EXPECT_EQ(loaded.mesh->point_of_vertex[v], static_cast<std::int32_t>(v));
    // Weighted by angle a cube's corner looks along its diagonal however its faces are cut.
    const Eigen::Vector3d out = (loaded.mesh->positions[v] - Eigen::Vector3d(0.5, 0.5, 0.5)).normalized();
    EXPECT_LT((loaded.mesh->normals[v] - out).norm(), 1e-12);
    EXPECT_LT((loaded.normals->normals[v] - out).norm(), 1e-12);
  }
  ASSERT_EQ(loaded.normals->components.size(), 1u);
  EXPECT_EQ(loaded.normals->components[0].source, SignSource::kGiven);
  EXPECT_EQ(loaded.report.mesh.num_inside_out, 0);
}

TEST(GivenMesh, ClosedAndInsideOutIsCounted) {
  auto faces = kCubeFaces;
  for (auto& face : faces) std::reverse(face.begin(), face.end());
  EXPECT_EQ(load_scan({mesh_of(kCube, faces)}).report.mesh.num_inside_out, 1);
  LoadScanOptions turn;
  turn.turn_faces = true;
  EXPECT_EQ(load_scan({mesh_of(kCube, faces)}, turn).report.mesh.num_inside_out, 0);
}

TEST(GivenMesh, MergesTheCornersOfLooseFacets) {
  std::vector<Eigen::Vector3d> corners;
  std::vector<std::vector<std::int32_t>> faces;
  for (const auto& face : kCubeFaces)
    for (const auto& t : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      faces.emplace_back();
      for (const int k : t) {
        faces.back().push_back(static_cast<std::int32_t>(corners.size()));
        corners.push_back(kCube[static_cast<std::size_t>(face[static_cast<std::size_t>(k)])]);
      }
    }
  LoadScanOptions merge;
  merge.merge_vertices = MergeVertices::kYes;
  const LoadedScan joined = load_scan({mesh_of(corners, faces)}, merge);
  EXPECT_EQ(joined.points.num_points(), 8u);
  EXPECT_EQ(joined.mesh->num_vertices(), 8u);
  expect_manifold(*joined.mesh);
  const LoadedScan loose = load_scan({mesh_of(corners, faces)});
  EXPECT_EQ(loose.points.num_points(), 8u);
  EXPECT_EQ(loose.mesh->num_vertices(), 36u);
  EXPECT_EQ(loose.report.mesh.num_coincident_vertices, 28);
  expect_manifold(*loose.mesh);
}

std::string message_of(const PosedScan& scan, const LoadScanOptions& options = {}) {
  try {
    load_scan({scan}, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

const std::vector<Eigen::Vector3d> kPage{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
const std::vector<std::vector<std::int32_t>> kBook{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};

TEST(GivenMesh, NonManifoldEdgesAreNamed) {
  EXPECT_EQ(message_of(mesh_of(kPage, kBook)),
            "mesh.off: 1 non-manifold edge: vertices 0 and 1 (faces 0 1 2); an edge may have two triangles at most; "
            "mend the mesh, or set "
            "'repair: split' or 'repair: drop'");
}

TEST(GivenMesh, InconsistentEdgesAreNamed) {
  EXPECT_EQ(message_of(mesh_of(kCube, {{0, 3, 2}, {0, 1, 2}})),
            "mesh.off: 1 inconsistently oriented edge: vertices 0 and 2 (faces 0 1); the two triangles of an edge must "
            "turn the "
            "same way; mend the "
            "mesh, or set 'repair: split' or 'repair: drop'");
}

TEST(GivenMesh, FacesOfNonFiniteVerticesAreNamed) {
  auto broken = kCube;
  broken[6].x() = std::nan("");
  EXPECT_THAT(message_of(mesh_of(broken, kCubeFaces)),
              HasSubstr("mesh.off: face 1 has vertex 6, whose coordinates are not finite"));
}

TEST(GivenMesh, RepairSplitsAlongCrowdedEdges) {
  LoadScanOptions options;
  options.repair = MeshRepair::kSplit;
  const LoadedScan loaded = load_scan({mesh_of(kPage, kBook)}, options);
  EXPECT_EQ(loaded.mesh->num_triangles(), 3u);
  EXPECT_EQ(loaded.report.mesh.num_non_manifold_edges, 1);
  EXPECT_EQ(loaded.report.mesh.num_split_vertices, 4);
  expect_manifold(*loaded.mesh);
}

TEST(GivenMesh, RepairDropsTheSmallest) {
  LoadScanOptions options;
  options.repair = MeshRepair::kDrop;
  auto page = kPage;
  page[3] = {0, 0.5, 0};
  const LoadedScan loaded = load_scan({mesh_of(page, kBook)}, options);
  EXPECT_EQ(loaded.mesh->num_triangles(), 2u);
  EXPECT_EQ(loaded.report.mesh.num_dropped, 1);
  EXPECT_EQ(loaded.report.mesh.num_turned, 1);
  EXPECT_EQ(loaded.mesh->num_vertices(), 4u);
  EXPECT_EQ(loaded.report.mesh.num_unused_vertices, 1);
  expect_manifold(*loaded.mesh);
}

TEST(GivenMesh, RepairTurnsTheLesserPart) {
  auto faces = kCubeFaces;
  std::reverse(faces[2].begin(), faces[2].end());
  LoadScanOptions options;
  options.repair = MeshRepair::kSplit;
  const LoadedScan loaded = load_scan({mesh_of(kCube, faces)}, options);
  EXPECT_EQ(loaded.report.mesh.num_turned, 2);
  EXPECT_EQ(loaded.report.mesh.num_inside_out, 0);
  EXPECT_EQ(loaded.report.mesh.num_split_vertices, 0);
  expect_manifold(*loaded.mesh);
}

TEST(GivenMesh, RepairCutsAMoebiusStrip) {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::vector<std::int32_t>> faces;
  constexpr int kSteps = 12;
  for (int i = 0; i < kSteps; ++i)
    for (const double side : {-0.3, 0.3}) {
      const double angle = 2 * M_PI * i / kSteps;
      positions.emplace_back((1 + side * std::cos(angle / 2)) * std::cos(angle),
                             (1 + side * std::cos(angle / 2)) * std::sin(angle), side * std::sin(angle / 2));
    }
  for (int i = 0; i < kSteps; ++i) {
    const int a = 2 * i, b = 2 * i + 1, c = i + 1 < kSteps ? 2 * i + 2 : 1, d = i + 1 < kSteps ? 2 * i + 3 : 0;
    faces.push_back({a, b, d});
    faces.push_back({a, d, c});
  }
  EXPECT_THAT(message_of(mesh_of(positions, faces)), HasSubstr("inconsistently oriented"));
  LoadScanOptions options;
  options.repair = MeshRepair::kSplit;
  const LoadedScan loaded = load_scan({mesh_of(positions, faces)}, options);
  EXPECT_EQ(loaded.mesh->num_triangles(), 24u);
  EXPECT_EQ(loaded.report.mesh.num_split_vertices, 2);
  expect_manifold(*loaded.mesh);
}

TEST(GivenMesh, BowTiesGetAVertexEach) {
  const LoadedScan loaded =
      load_scan({mesh_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}})});
  EXPECT_EQ(loaded.mesh->num_vertices(), 6u);
  EXPECT_EQ(loaded.report.mesh.num_split_vertices, 1);
  expect_manifold(*loaded.mesh);
}

TEST(GivenMesh, AnyHeapOfTrianglesIsRepaired) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    std::vector<Eigen::Vector3d> positions;
    const int n = 4 + static_cast<int>(random() % 7);
    for (int i = 0; i < n; ++i) positions.emplace_back(random() % 5, random() % 5, random() % 5);
    std::vector<std::vector<std::int32_t>> faces;
    const int m = 1 + static_cast<int>(random() % 25);
    for (int i = 0; i < m; ++i)
      faces.push_back({static_cast<std::int32_t>(random() % n), static_cast<std::int32_t>(random() % n),
                       static_cast<std::int32_t>(random() % n)});
    faces.push_back({0, 1, 2});
    for (const MeshRepair repair : {MeshRepair::kSplit, MeshRepair::kDrop})
      for (const MergeVertices merge : {MergeVertices::kNo, MergeVertices::kYes}) {
        LoadScanOptions options;
        options.repair = repair;
        options.merge_vertices = merge;
        if (merge == MergeVertices::kYes &&
            (positions[0] == positions[1] || positions[1] == positions[2] || positions[0] == positions[2]))
          continue;
        SCOPED_TRACE(seed);
        const LoadedScan loaded = load_scan({mesh_of(positions, faces)}, options);
        expect_manifold(*loaded.mesh);
        const GivenMeshReport& report = loaded.report.mesh;
        EXPECT_EQ(static_cast<std::int64_t>(loaded.mesh->num_triangles()) + report.num_degenerate + report.num_dropped,
                  m + 1);
      }
  }
}

TEST(GivenMesh, CropDropsTriangles) {
  LoadScanOptions options;
  options.crop = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(2, 2, 0.5));
  const LoadedScan loaded = load_scan({mesh_of(kCube, kCubeFaces)}, options);
  EXPECT_EQ(loaded.mesh->num_triangles(), 2u);
  EXPECT_EQ(loaded.report.mesh.num_cropped, 10);
}

TEST(GivenMesh, PropertiesFollowTheirVertices) {
  PosedScan scan = mesh_of(kCube, kCubeFaces);
  scan.geometry.properties = {{"quality", ValueType::kFloat32, {0, 1, 2, 3, 4, 5, 6, 7}}};
  const LoadedScan loaded = load_scan({scan});
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_EQ(kCube[static_cast<std::size_t>(loaded.mesh->properties[0].values[v])], loaded.mesh->positions[v]);
}

TEST(PolygonCut, ConcavePolygonsStayInside) {
  // An arrow head: only the cut from the notch is inside.
  const std::vector<Eigen::Vector3d> arrow{{0, 0, 5}, {2, -2, 5}, {0, 3, 5}, {-2, -2, 5}};
  double area = 0;
  for (const auto& t : cut_polygon(arrow)) {
    const auto corner = [&](std::size_t k) { return arrow[static_cast<std::size_t>(t[k])]; };
    const double part = (corner(1) - corner(0)).cross(corner(2) - corner(0)).z() / 2;
    EXPECT_GT(part, 0);
    area += part;
  }
  EXPECT_DOUBLE_EQ(area, 6);
}

}  // namespace
}  // namespace meshmser
