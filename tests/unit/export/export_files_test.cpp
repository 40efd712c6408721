#include "stages/export/export_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "pipeline/formats/geometry_file.hpp"
#include "stages/common/colours.hpp"
#include "stages/export/plan_files.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

const Property& property_of(const Geometry& g, const std::string& name) {
  for (const Property& property : g.properties)
    if (property.name == name) return property;
  throw std::runtime_error("no property " + name);
}

/// A strip of four triangles on six vertices far from zero.
TriangleMesh strip() {
  TriangleMesh mesh;
  mesh.origin = {1e6, 0, -2e5};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 2; ++j) mesh.positions.emplace_back(i * 0.1, j, 0.5);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}};
  mesh.point_of_vertex = {0, 1, 2, 3, 4, 5};
  mesh.normals.assign(6, Eigen::Vector3d::UnitZ());
  mesh.turned_of_vertex.assign(6, 0);
  return mesh;
}

TEST(ExportFiles, MostTrianglesAroundAVertexDecideItsLabel) {
  const TriangleMesh mesh = strip();
  const std::vector<std::int32_t> labels{0, 7, 7, 3};
  EXPECT_EQ(label_of_vertices(mesh, labels), (std::vector<std::int32_t>{0, 7, 7, 7, 3, 3}));
  EXPECT_EQ(label_of_points(7, mesh, labels), (std::vector<std::int32_t>{0, 7, 7, 7, 3, 3, -1}));
}

PointCloud cloud_with_drops() {
  PointCloud points;
  points.origin = {1000, 0, 0};
  points.positions = {{0.25, 0, 0}, {0.5, 0, 0}};
  points.raw_index_of_point = {3, 0};
  points.num_raw_points = 5;
  points.dropped_raw_index = {1, 2, 4};
  points.dropped_positions = {{0.5, 0, 0}, {9, 9, 9}, {std::nan(""), 0, 0}};
  points.drop_reasons = {DropReason::kDuplicate, DropReason::kOutlier, DropReason::kNonFinite};
  points.kept_point_of_dropped = {1, -1, -1};
  points.properties = {{"red", ValueType::kUint8, {200, 100}}, {"nx", ValueType::kFloat64, {0.1, 0.2}}};
  return points;
}

TEST(ExportFiles, PointsStandInRawOrderWithAllTheyHave) {
  TemporaryFolder folder;
  const PointCloud points = cloud_with_drops();
  PointNormals normals;
  normals.normals = {{1, 0, 0}, {0, 1, 0}};
  ScalarField curvature;
  curvature.name = "mean_curvature";
  curvature.values = {0.5, -0.25};
  const std::vector<std::int32_t> labels{4, 0};
  PointColumns columns;
  columns.normals = &normals;
  columns.scalars = {{"mean_curvature", &curvature}};
  columns.labels = labels;
  write_points_ply(folder.path() / "points.ply", points, columns);
  const Geometry g = read_geometry_file(folder.path() / "points.ply").at(0);
  ASSERT_EQ(g.num_vertices(), 5u);
  EXPECT_EQ(g.positions[0], Eigen::Vector3d(1000.5, 0, 0));
  EXPECT_EQ(g.positions[1], Eigen::Vector3d(1000.5, 0, 0));
  EXPECT_EQ(g.positions[2], Eigen::Vector3d(1009, 9, 9));
  EXPECT_EQ(g.positions[3], Eigen::Vector3d(1000.25, 0, 0));
  EXPECT_TRUE(std::isnan(g.positions[4].x()));
  const std::vector<double>& h = property_of(g, "mean_curvature").values;
  EXPECT_EQ(h[0], -0.25);
  EXPECT_EQ(h[1], -0.25);  // a duplicate bears what the point that stands for it does
  EXPECT_TRUE(std::isnan(h[2]) && std::isnan(h[4]));
  EXPECT_EQ(h[3], 0.5);
  EXPECT_EQ(property_of(g, "label").values, (std::vector<double>{0, 0, -1, 4, -1}));
  EXPECT_EQ(property_of(g, "red").values, (std::vector<double>{100, 100, 0, 200, 0}));
  EXPECT_EQ(property_of(g, "ny").values[0], 1);
  EXPECT_EQ(property_of(g, "file_nx").values[3], 0.1);
}

TEST(ExportFiles, CoordinatesLoseNothing) {
  TemporaryFolder folder;
  PointCloud points;
  points.origin = {4.5e6, 0, 0};
  points.positions = {{0.1, 0.2, 0.3}};
  points.raw_index_of_point = {0};
  points.num_raw_points = 1;
  write_points_ply(folder.path() / "points.ply", points, {});
  EXPECT_EQ(read_geometry_file(folder.path() / "points.ply").at(0).positions[0],
            Eigen::Vector3d(4.5e6 + 0.1, 0.2, 0.3));
}

TEST(ExportFiles, SegmentsBearLabelsColoursAndTheScalar) {
  TemporaryFolder folder;
  const TriangleMesh mesh = strip();
  const std::vector<std::int32_t> labels{0, 1, 1, 2};
  const std::vector<double> quality{0, 1, 2, 3, 4, std::nan("")};
  write_segments_ply(folder.path() / "segments.ply", mesh, {labels, quality});
  const Geometry g = read_geometry_file(folder.path() / "segments.ply").at(0);
  ASSERT_EQ(g.num_faces(), 4u);
  EXPECT_EQ(g.positions[5], Eigen::Vector3d(1e6 + 0.2, 1, -2e5 + 0.5));
  EXPECT_EQ(property_of(g, "quality").values[4], 4);
  EXPECT_TRUE(std::isnan(property_of(g, "quality").values[5]));
  const std::vector<Colour> colours = label_colours(mesh, labels);
  EXPECT_EQ(property_of(g, "red").values[5], colours[2][0]);
  EXPECT_EQ(property_of(g, "blue").values[0], colours[0][2]);
}

TEST(ExportFiles, BordersAreRowsOfRawCoordinates) {
  TemporaryFolder folder;
  const TriangleMesh mesh = strip();
  BorderLoops loops;
  loops.owner_of_loop = {2};
  loops.first_edge_of_loop = {0, 3};
  loops.half_edges = {3, 4, 5};  // triangle 1: 1 -> 2 -> 3 -> 1
  loops.kinds = {EdgeKind::kLevel, EdgeKind::kLevel, EdgeKind::kHole};
  loops.neighbours = {0, 5, -1};
  write_borders_csv(folder.path() / "borders.csv", mesh, loops);
  EXPECT_THAT(lines_of(folder.path() / "borders.csv"),
              ::testing::ElementsAre("region,loop,edge,x0,y0,z0,x1,y1,z1,kind,neighbour",
                                     "2,0,0,1e+06,1,-199999.5,1000000.1,0,-199999.5,level,0",
                                     "2,0,1,1000000.1,0,-199999.5,1000000.1,1,-199999.5,level,5",
                                     "2,0,2,1000000.1,1,-199999.5,1e+06,1,-199999.5,hole,-1"));
  write_borders_obj(folder.path() / "borders.obj", mesh, loops);
  EXPECT_THAT(lines_of(folder.path() / "borders.obj"),
              ::testing::ElementsAre("g region_2", "v 1e+06 1 -199999.5", "v 1000000.1 0 -199999.5",
                                     "v 1000000.1 1 -199999.5", "l 1 2 3 1"));
}

/// A flat square of two triangles, side 2, in a plane through `u` and `v`; its border has three level edges and one of
/// a hole.
std::pair<TriangleMesh, BorderLoops> square(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  TriangleMesh mesh;
  mesh.origin = {10, 20, 30};
  mesh.positions = {{0, 0, 0}, 2 * u, 2 * u + 2 * v, 2 * v};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  BorderLoops loops;
  loops.owner_of_loop = {7};
  loops.first_edge_of_loop = {0, 4};
  loops.half_edges = {0, 1, 4, 5};  // 0 -> 1 -> 2 -> 3 -> 0
  loops.kinds = {EdgeKind::kLevel, EdgeKind::kLevel, EdgeKind::kHole, EdgeKind::kLevel};
  loops.neighbours = {0, 0, -1, 0};
  return {mesh, loops};
}

TEST(PlanFiles, TheFittingPlaneFacesAsTheSurfaceDoes) {
  const double s = std::sqrt(0.5);
  const auto [mesh, loops] = square({s, 0, -s}, {0, 1, 0});
  const DrawingAxes axes = best_fitting_plane(mesh, loops);
  EXPECT_TRUE(axes.up.isApprox(Eigen::Vector3d::UnitY(), 1e-12)) << axes.up.transpose();
  EXPECT_TRUE(axes.right.isApprox(Eigen::Vector3d(s, 0, -s), 1e-12)) << axes.right.transpose();
  // Turned over, it is seen from the other side.
  const auto [back, back_loops] = square({0, 1, 0}, {s, 0, -s});
  EXPECT_TRUE(best_fitting_plane(back, back_loops).right.isApprox(Eigen::Vector3d(-s, 0, s), 1e-12));
}

TEST(PlanFiles, RunsOfOneKindArePathsToScale) {
  TemporaryFolder folder;
  const auto [mesh, loops] = square({1, 0, 0}, {0, 1, 0});
  write_borders_svg(folder.path() / "b.svg", mesh, loops, {}, "cm");
  // One unit is 10 mm; 2 mm of margin; y downward. The hole edge is a path of its own, the three others are one.
  EXPECT_THAT(lines_of(folder.path() / "b.svg"),
              ::testing::ElementsAre(
                  "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"24mm\" height=\"24mm\" viewBox=\"0 0 24 24\">",
                  ::testing::HasSubstr("<style>"),
                  "<path class=\"hole\" data-number=\"7\" d=\"M22 2L2 2\"/>",
                  "<path class=\"level\" data-number=\"7\" d=\"M2 2L2 22L22 22L22 2\"/>", "</svg>"));
  write_borders_dxf(folder.path() / "b.dxf", mesh, loops, {}, "cm");
  std::string dxf;
  for (const std::string& line : lines_of(folder.path() / "b.dxf")) dxf += line + " ";
  EXPECT_THAT(dxf, ::testing::HasSubstr("$INSUNITS 70 5 "));
  EXPECT_THAT(dxf, ::testing::HasSubstr("POLYLINE 8 HOLE_7 66 1 10 0 20 0 30 0 70 0 0 VERTEX 8 HOLE_7 10 12 20 22 30 0 "
                                        "0 VERTEX 8 HOLE_7 10 10 20 22 30 0 0 SEQEND 8 HOLE_7 "));
  EXPECT_THAT(dxf, ::testing::HasSubstr("VERTEX 8 LEVEL_7 10 10 20 20 30 0 0 VERTEX 8 LEVEL_7 10 12 20 20 30 0 "));
  EXPECT_THAT(dxf, ::testing::EndsWith("0 ENDSEC 0 EOF "));
}

TEST(ExportFiles, CurvesAreClosedLines) {
  TemporaryFolder folder;
  BorderCurves curves;
  curves.first_point_of_curve = {0, 2, 3};
  curves.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  write_curves_obj(folder.path() / "c.obj", {0.5, 0, 0}, curves, std::vector<std::int32_t>{1, 1});
  EXPECT_THAT(lines_of(folder.path() / "c.obj"),
              ::testing::ElementsAre("g region_1", "v 0.5 0 0", "v 1.5 0 0", "l 1 2 1", "v 2.5 0 0", "l 3 3"));
}

TEST(ExportFiles, TablesHaveARowEach) {
  TemporaryFolder folder;
  Segmentation segmentation;
  Region region;
  region.polarity = Polarity::kLower;
  region.node = 1;
  region.low_level = 2;
  region.high_level = 3;
  region.value = -0.1;
  region.num_triangles = 2;
  region.area = 1.5;
  region.stability = std::numeric_limits<double>::infinity();
  region.centroid = {1, 2, 3};
  region.level_length = 3;
  region.hole_length = 0.5;
  region.depth = 2;
  region.euler = -1;
  region.flatness = 0.25;
  region.box_min = {-1, -1, -1};
  region.box_max = {2, 1, 1};
  region.spread = {3, 2, 1};
  region.axis_1 = {1, 0, 0};
  region.axis_2 = {0, 1, 0};
  region.axis_3 = {0, 0, 1};
  region.best_fit = FittedShape::kSphere;
  region.plane_residual = 0.5;
  region.sphere_residual = 0.25;
  region.sphere_radius = -4;
  region.sphere_centre = {0, 0, 9};
  segmentation.regions = {region};
  segmentation.label_of_triangle = {0, 1, 1, 0};
  segmentation.region_of_label = {0, 1};
  segmentation.area_of_label = {2.5, 1.5};
  write_regions_csv(folder.path() / "regions.csv", segmentation, {10, 0, 0});
  const std::vector<std::string> rows = lines_of(folder.path() / "regions.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1],
            "1,lower,1,-1,2,3,-0.1,2,1.5,inf,0,0,3,0.5,0,0,0,0,11,2,3,0,0,0,2,-1,0.25,9,-1,-1,12,1,1,3,2,1,1,0,0,0,1,0,"
            "0,0,1,sphere,0.5,0.25,-4,10,0,9,nan,nan,nan,nan,nan,nan,nan,nan");
  EXPECT_EQ(std::count(rows[0].begin(), rows[0].end(), ','), std::count(rows[1].begin(), rows[1].end(), ','));
  // Every column stands in the page of the stage.
  std::ifstream page(std::string(MESHMSER_SOURCE_DIR) + "/stages/export/README.md");
  const std::string text((std::istreambuf_iterator<char>(page)), {});
  EXPECT_NE(text.find("`" + rows[0] + "`"), std::string::npos) << rows[0];
  write_labels_csv(folder.path() / "labels.csv", segmentation);
  EXPECT_THAT(lines_of(folder.path() / "labels.csv"),
              ::testing::ElementsAre("label,region,triangles,area", "1,1,2,1.5"));

  LevelSetTrees trees;
  trees.trees.resize(1);
  ComponentTree& tree = trees.trees[0];
  tree.polarity = Polarity::kLower;
  tree.levels = {-std::numeric_limits<double>::infinity(), 0.1, 0.3};
  tree.parent_of_node = {2, 2, -1};
  tree.hi_of_node = {2, 3, 1};
  tree.area_of_node = {3, 6, 16};
  tree.area_exponent_of_node = {2, 2, 2};
  write_tree_csv(folder.path() / "tree.csv", trees, &segmentation);
  EXPECT_THAT(lines_of(folder.path() / "tree.csv"),
              ::testing::ElementsAre("polarity,node,parent,level,high_level,value,high_value,area,region",
                                     "lower,0,2,2,2,-0.1,-0.1,0.75,0", "lower,1,2,2,3,-0.1,-0.3,1.5,1",
                                     "lower,2,-1,1,1,inf,inf,4,0"));
}

TEST(ExportFiles, AFullDiskIsACacheError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(write_points_ply("/dev/full", cloud_with_drops(), {}), CacheError);
  EXPECT_THROW(write_borders_csv("/nowhere/borders.csv", strip(), {}), CacheError);
}

}  // namespace
}  // namespace meshmser
