#include "stages/export/render.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "pipeline/artifacts/scalar_fields.hpp"

namespace meshmser {
namespace {

/// A square of n x n cells of side 1 in the plane z = 0, facing +z.
TriangleMesh square(int n) {
  TriangleMesh mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) mesh.positions.emplace_back(x, y, 0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  return mesh;
}

/// Pixels whose colour is `colour` times one brightness, within 3.
int count_shaded(const Image& image, const Colour& colour) {
  int count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Colour seen = image.at(x, y);
      const double brightness = static_cast<double>(seen[0]) / colour[0];
      count += brightness > 0.4 && brightness < 0.999 && std::abs(seen[1] - colour[1] * brightness) < 3 &&
               std::abs(seen[2] - colour[2] * brightness) < 3;
    }
  return count;
}

int count_exact(const Image& image, const Colour& colour) {
  int count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) count += image.at(x, y) == colour;
  return count;
}

TEST(Render, LabelsFillTheirShareOfThePicture) {
  const TriangleMesh mesh = square(8);
  std::vector<std::int32_t> labels(mesh.num_triangles());
  for (std::size_t t = 0; t < labels.size(); ++t) labels[t] = t % 16 < 8 ? 1 : 2;
  RenderOptions options;
  options.panel_width = 400;
  options.panel_height = 400;
  const Image image = render_labels(mesh, labels, {}, options);
  const std::vector<Colour> colours = label_colours(mesh, labels);
  ASSERT_EQ(colours.size(), 3u);
  EXPECT_NE(colours[1], colours[2]);
  // 400 pixels less two margins of 24 and 44 for the scale bar leave a square of 308.
  EXPECT_NEAR(count_shaded(image, colours[1]), 308 * 154, 1200);
  EXPECT_NEAR(count_shaded(image, colours[2]), 308 * 154, 1200);
}

TEST(Render, SheetIsSeenAlongItsNormalWithYUp) {
  const TriangleMesh mesh = square(4);
  EXPECT_EQ(default_views(mesh), std::vector<std::string>{"best"});
  const View view = view_of_name("best", mesh);
  EXPECT_TRUE(view.direction.isApprox(-Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(view.up.isApprox(Eigen::Vector3d::UnitY()));
}

TEST(Render, BordersShowByKindAndOnlyInFront) {
  const TriangleMesh mesh = square(8);
  const std::vector<std::int32_t> labels(mesh.num_triangles(), 0);
  BorderLines lines;
  lines.segments.push_back({{1, 2, 0}, {7, 2, 0}, EdgeKind::kLevel});
  lines.segments.push_back({{1, 6, 0}, {7, 6, 0}, EdgeKind::kHole});
  RenderOptions options;
  options.panel_width = options.panel_height = 400;
  options.views = {"top"};
  const Image front = render_labels(mesh, labels, lines, options);
  const Image without = render_labels(mesh, labels, {}, options);
  // Six units of 38.5 pixels each; a line is one to two pixels wide. The legend adds one short stroke of each colour.
  EXPECT_GT(count_exact(front, kLevelEdgeColour) - count_exact(without, kLevelEdgeColour), 200);
  EXPECT_GT(count_exact(front, kHoleEdgeColour) - count_exact(without, kHoleEdgeColour), 200);

  for (auto& segment : lines.segments) segment.from.z() = segment.to.z() = -1;  // below the square
  const Image hidden = render_labels(mesh, labels, lines, options);
  EXPECT_LT(count_exact(hidden, kLevelEdgeColour), 150);
  EXPECT_LT(count_exact(hidden, kHoleEdgeColour), 150);
}

TEST(Render, LoopsAndCurvesBecomeSegments) {
  const TriangleMesh mesh = square(1);
  BorderLoops loops;
  loops.half_edges = {0, 4};
  loops.kinds = {EdgeKind::kHole, EdgeKind::kLevel};
  const BorderLines lines = BorderLines::of_loops(mesh, loops);
  ASSERT_EQ(lines.segments.size(), 2u);
  EXPECT_EQ(lines.segments[0].from, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(lines.segments[0].to, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(lines.segments[1].from, Eigen::Vector3d(1, 1, 0));
  EXPECT_EQ(lines.segments[1].to, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(lines.segments[1].kind, EdgeKind::kLevel);

  BorderCurves curves;
  curves.first_point_of_curve = {0, 3};
  curves.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  curves.kinds = {EdgeKind::kLevel, EdgeKind::kLevel, EdgeKind::kHole};
  const BorderLines closed = BorderLines::of_curves(curves);
  ASSERT_EQ(closed.segments.size(), 3u);
  EXPECT_EQ(closed.segments[2].from, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(closed.segments[2].to, Eigen::Vector3d(0, 0, 0));
}

TEST(Render, ScalarRunsFromBlueToRedAndNanIsGrey) {
  const TriangleMesh mesh = square(16);
  std::vector<double> values(mesh.num_vertices());
  for (std::size_t v = 0; v < values.size(); ++v) values[v] = mesh.positions[v].x() - 8;
  values[8 * 17 + 8] = std::nan("");
  RenderOptions options;
  options.panel_width = options.panel_height = 400;
  const Image image = render_scalar(mesh, values, "mean_curvature", "1/mm", {}, {}, options);
  const Colour left = image.at(60, 180), right = image.at(340, 180);
  EXPECT_GT(left[2], left[0] + 60);
  EXPECT_GT(right[0], right[2] + 60);
  EXPECT_GT(count_shaded(image, kUndefinedColour), 300);
}

TEST(Render, SameBytesForAnyNumberOfThreads) {
  const TriangleMesh mesh = square(20);
  std::vector<std::int32_t> labels(mesh.num_triangles());
  for (std::size_t t = 0; t < labels.size(); ++t) labels[t] = static_cast<std::int32_t>(t / 37);
  RenderOptions options;
  options.views = {"iso", "front"};
  options.panel_width = options.panel_height = 200;
  Execution one, seven;
  one.threads = 1;
  seven.threads = 7;
  EXPECT_EQ(render_labels(mesh, labels, {}, options, one).rgb, render_labels(mesh, labels, {}, options, seven).rgb);
}

TEST(Render, SeveralPicturesAreThoseOfEachAlone) {
  const TriangleMesh mesh = square(6);
  std::vector<std::int32_t> labels(mesh.num_triangles());
  for (std::size_t t = 0; t < labels.size(); ++t) labels[t] = static_cast<std::int32_t>(t % 3);
  std::vector<double> values(mesh.num_vertices());
  for (std::size_t v = 0; v < values.size(); ++v) values[v] = mesh.positions[v].x() - 2;
  RenderOptions options;
  options.views = {"top", "iso", "left"};
  options.panel_width = options.panel_height = 180;
  const std::vector<Picture> pictures = {picture_of_labels(mesh, labels, {}),
                                         picture_of_scalar(mesh, values, "s", "", {}), picture_of_shape(mesh, {})};
  const std::vector<Image> images = render(mesh, pictures, options);
  ASSERT_EQ(images.size(), 3u);
  EXPECT_EQ(images[0].rgb, render_labels(mesh, labels, {}, options).rgb);
  EXPECT_EQ(images[1].rgb, render_scalar(mesh, values, "s", "", {}, {}, options).rgb);
  EXPECT_EQ(images[2].rgb, render_shape(mesh, {}, options).rgb);
  EXPECT_NE(images[0].rgb, images[1].rgb);
}

TEST(Render, PngDecodesToThePicture) {
  const auto path = std::filesystem::path(testing::TempDir()) / "render_test.png";
  const Image image = render_shape(square(4), {});
  write_png(path, image);
  const Image again = read_png(path);
  EXPECT_EQ(again.width, image.width);
  EXPECT_EQ(again.height, image.height);
  EXPECT_EQ(again.rgb, image.rgb);
  std::filesystem::remove(path);
}

TEST(Render, ErrorsNameWhatIsWrong) {
  EXPECT_THROW(render_shape(TriangleMesh{}, {}), StageError);
  RenderOptions options;
  options.views = {"sideways"};
  try {
    render_shape(square(2), {}, options);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("unknown view 'sideways'; known: front"), std::string::npos);
  }
  EXPECT_THROW(write_png("/nowhere/picture.png", Image(2, 2, {0, 0, 0})), CacheError);
}

TEST(Render, UnitsAreForPeople) {
  EXPECT_EQ(unit_for_people("1/unit", "mm"), "1/mm");
  EXPECT_EQ(unit_for_people("unit", "m"), "m");
  EXPECT_EQ(unit_for_people("", "mm"), "");
  EXPECT_EQ(unit_for_people("1/unit", ""), "1/unit");
}

TEST(LabelColours, NeighboursDiffer) {
  const TriangleMesh mesh = square(12);
  std::vector<std::int32_t> labels(mesh.num_triangles());
  for (std::size_t t = 0; t < labels.size(); ++t) labels[t] = 1 + static_cast<std::int32_t>(t % 24 / 6 + 4 * (t / 72));
  const std::vector<Colour> colours = label_colours(mesh, labels);
  EXPECT_EQ(colours.at(0), kBackgroundLabelColour);
  for (std::size_t i = 1; i < labels.size(); ++i) {
    if (labels[i] == labels[i - 1] || i % 24 == 0) continue;
    EXPECT_NE(colours[static_cast<std::size_t>(labels[i])], colours[static_cast<std::size_t>(labels[i - 1])]);
  }
}

TEST(ColourMap, IsSymmetricAboutZeroOnlyWhereBothSignsOccur) {
  const std::vector<double> both = {-1, 0, 3}, positive = {1, 2, 5};
  const ColourMap diverging = ColourMap::of_values(both, 0), sequential = ColourMap::of_values(positive, 0);
  EXPECT_EQ(diverging.low, -3);
  EXPECT_EQ(diverging.high, 3);
  EXPECT_EQ(diverging(0), (Colour{247, 247, 247}));
  EXPECT_EQ(sequential.low, 1);
  EXPECT_EQ(sequential.high, 5);
  EXPECT_EQ(diverging(std::nan("")), kUndefinedColour);
}

}  // namespace
}  // namespace meshmser
