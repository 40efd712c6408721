#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/artifacts/border_set.hpp"
#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/artifacts/segmentation.hpp"
#include "pipeline/artifacts/smoothed_points.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"
#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// Of the data in a page; raised where the program in it reads other data than before.
inline constexpr int kPageFormat = 2;

/// What the page shows; each may be null. They belong together: points and mesh of one run.
struct ReportContents {
  const PointCloud* points = nullptr;
  const PointNormals* normals = nullptr;
  const SmoothedPoints* smoothed = nullptr;
  std::vector<std::pair<std::string, const ScalarFields*>> scalars{};  ///< with the stage that made them
  const TriangleMesh* mesh = nullptr;
  const LevelSetTrees* trees = nullptr;
  const Segmentation* segmentation = nullptr;
  const BorderSet* borders = nullptr;
};

struct ReportOptions {
  std::string title{};
  std::string units = "unit";              ///< of the coordinates
  std::size_t max_triangles = 1000000;     ///< drawn; more are simplified for display
  std::size_t max_points = 150000;         ///< drawn; of more, every n-th
  std::size_t max_nodes = 150000;          ///< of each tree; the smallest beyond them are counted to their parents
  std::size_t max_border_edges = 1500000;  ///< of a kind of border; a kind with more is not drawn
  std::size_t max_bytes = 25000000;        ///< of the page; the mesh is simplified further until it fits
};

/// What became of it.
struct ReportSummary {
  std::int64_t num_triangles = 0;  ///< drawn
  std::int64_t num_bytes = 0;
};

/// Writes one HTML file that shows all of it without a network: geometry at 16 bits of the larger extent, simplified
/// where there is too much of it (the page says so), figures in full. Text of the user is stored as text only. Throws
/// CacheError where the file cannot be written, StageError where there is nothing to show. The same bytes for the same
/// contents.
ReportSummary write_report(const std::filesystem::path& path, const ReportContents& contents,
                           const ReportOptions& options = {}, const Execution& execution = {});

/// `text` as the inside of an HTML script element of JSON: no `<` is left, so no file name can end the element.
std::string json_for_html(std::string text);

}  // namespace meshmser
