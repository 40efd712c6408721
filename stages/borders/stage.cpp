#include "pipeline/stage/stage.hpp"

#include <Eigen/Geometry>
#include <numeric>
#include <optional>
#include <string>

#include "stages/borders/borders.hpp"
#include "stages/borders/curves.hpp"
#include "stages/common/adjacency.hpp"

namespace meshmser {
namespace {

struct BordersParameters {
  bool interpolate = false;
  std::optional<Length> smooth;
};

/// The tree a region is a node of.
const ComponentTree& tree_of(const LevelSetTrees& trees, const Region& region) {
  for (const ComponentTree& tree : trees.trees)
    if (tree.has_side(region.polarity)) return tree;
  throw StageError("a region belongs to a tree that is not there; run tree and mser again");
}

}  // namespace

struct BordersStage {
  static constexpr StageInfo info{
      "borders", 1,
      "Draws the closed borders of regions and labels, level and hole edges apart [Digne et "
      "al. 2010]."};
  using Parameters = BordersParameters;

  static void declare(StageSchema& s) {
    using P = Parameters;
    s.input<TriangleMesh>("mesh");
    s.input<LevelSetTrees>("trees");
    s.input<Segmentation>("segmentation");
    s.output<BorderSet>("borders");
    s.parameter("interpolate", &P::interpolate,
                "Also draws each region's border through the triangles, where the scalar equals its level.");
    s.parameter("smooth", &P::smooth, at_least(0), "",
                "Also draws the interpolated borders smooth, nowhere farther than this from where they were.");
  }

  static Outputs run(const Parameters& parameters, const Inputs& inputs, RunContext& context) {
    const Execution& execution = context.execution();
    const auto& mesh = inputs.get<TriangleMesh>("mesh");
    const auto& trees = inputs.get<LevelSetTrees>("trees");
    const auto& segmentation = inputs.get<Segmentation>("segmentation");
    std::vector<std::int32_t> twins = twin_half_edges(mesh.triangles, mesh.num_vertices(), execution);
    cut_out_triangles(twins, trees.excluded_of_triangle);
    const SurfaceView surface{mesh.positions, mesh.triangles, twins};

    BorderSet borders;
    borders.regions.first_edge_of_loop.push_back(0);
    std::vector<BorderRegion> regions;
    for (const Region& region : segmentation.regions) regions.push_back({&tree_of(trees, region), region.node});
    for (const ComponentTree& tree : trees.trees) {
      std::vector<std::int32_t> number_of_node(tree.num_nodes(), 0);
      for (std::size_t r = 0; r < regions.size(); ++r)
        if (regions[r].tree == &tree)
          number_of_node[static_cast<std::size_t>(regions[r].node)] = static_cast<std::int32_t>(r) + 1;
      borders.regions = merge_borders(
          borders.regions, extract_borders(surface, tree, number_of_node, segmentation.region_of_triangle, execution));
    }
    borders.labels = extract_label_borders(surface, segmentation.label_of_triangle, execution);
    if (parameters.interpolate || parameters.smooth)
      borders.interpolated = interpolate_borders(surface, trees.values, borders.regions, regions, execution);
    if (parameters.smooth) {
      Eigen::AlignedBox3d box;
      for (const Eigen::Vector3d& position : mesh.positions) box.extend(position);
      borders.smooth_tolerance =
          parameters.smooth->resolve({mesh.spacing, box.isEmpty() ? 0 : box.diagonal().norm(), 0});
      borders.smooth = smooth_curves(borders.interpolated, borders.smooth_tolerance, execution);
    }

    auto tell = [&](const BorderLoops& loops, const std::string& whose) {
      context.report("num_loops_of_" + whose, static_cast<std::int64_t>(loops.num_loops()));
      context.report("num_hole_loops_dropped_of_" + whose, loops.num_hole_loops_dropped);
      context.report("level_length_of_" + whose,
                     std::accumulate(loops.level_length_of_loop.begin(), loops.level_length_of_loop.end(), 0.0),
                     context.units());
      context.report("hole_length_of_" + whose,
                     std::accumulate(loops.hole_length_of_loop.begin(), loops.hole_length_of_loop.end(), 0.0),
                     context.units());
    };
    tell(borders.regions, "regions");
    tell(borders.labels, "labels");
    Outputs outputs;
    outputs.set("borders", std::move(borders));
    return outputs;
  }
};

namespace {
MESHMSER_STAGE(BordersStage);
}  // namespace

}  // namespace meshmser
