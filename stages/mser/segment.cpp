#include "stages/mser/segment.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "stages/mser/border_contrast.hpp"
#include "stages/mser/describe_regions.hpp"
#include "stages/mser/fill_cut_triangles.hpp"
#include "stages/mser/fit_borders.hpp"
#include "stages/mser/grow.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/level_lines.hpp"
#include "stages/mser/meaningful.hpp"
#include "stages/mser/merge.hpp"
#include "stages/mser/patches.hpp"
#include "stages/mser/persistence.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

bool selects_by_maxima(const SegmentParameters& parameters) {
  return parameters.select == Select::kPersistence || parameters.select == Select::kStableBranch;
}

void check_for_shapes(const SegmentParameters& parameters) {
  if (parameters.delta_value > 0)
    throw StageError(
        "mser.delta_value: a tree of shapes counts level lines, whatever their step; give mser.delta, a "
        "number of them");
}

void check(const SegmentInputs& inputs, const SegmentParameters& parameters) {
  const std::size_t num_triangles = inputs.surface.triangles.size(), num_vertices = inputs.surface.positions.size();
  const auto expect = [](std::string_view what, std::size_t is, std::size_t expected) {
    if (is != expected)
      throw StageError(std::string(what) + " has " + std::to_string(is) + " entries; the mesh needs " +
                       std::to_string(expected));
  };
  const LevelSetTrees& level_sets = inputs.level_sets;
  expect("the adjacency", inputs.surface.twins.size(), 3 * num_triangles);
  expect("the scalar", level_sets.values.size(), num_vertices);
  if (!level_sets.excluded_of_triangle.empty())
    expect("the list of excluded triangles", level_sets.excluded_of_triangle.size(), num_triangles);
  for (const ComponentTree& tree : level_sets.trees) {
    expect("a tree's list of triangles", tree.node_of_triangle.size(), num_triangles);
    if (tree.polarity == Polarity::kShapes) check_for_shapes(parameters);
  }
  if (!inputs.strength.empty()) expect("the strength", inputs.strength.size(), num_vertices);
  if (!inputs.curvature.empty()) expect("the curvature", inputs.curvature.size(), num_vertices);
  if (parameters.grow == Grow::kWatershed && parameters.flood_by == FloodBy::kFacets) {
    expect("the list of normals", inputs.normals.size(), num_vertices);
    if (!(parameters.flood_width > 0)) throw StageError("flooding facets needs a width greater than 0");
  }
  if (parameters.select == Select::kMeaningful && !(parameters.independent > 0 && parameters.max_false_alarms > 0))
    throw StageError(
        "selecting meaningful lines needs a distance and a number of false alarms greater than 0; where points are too "
        "few to measure a spacing, give mser.independent as a length");
  if (parameters.merge == Merge::kTurning && !(parameters.turning_radius > 0))
    throw StageError("merging by turning needs a radius greater than 0");
  if (parameters.border == Border::kSides && !(parameters.side_radius > 0 && parameters.spacing > 0))
    throw StageError("borders by sides need a radius and a spacing greater than 0");
}

/// Applies filters one after the other to the selections of all trees and counts what each removes.
class Filtering {
 public:
  Filtering(std::vector<TreeSelection>& selections, std::vector<FilterCount>& counts, std::vector<NodeFates>* fates)
      : selections_(selections), counts_(counts), fates_(fates) {}

  /// `filter(tree index, selection)`: the nodes that stay.
  template <class Filter>
  void apply(std::string name, Filter filter) {
    FilterCount count{std::move(name), 0, 0};
    for (std::size_t i = 0; i < selections_.size(); ++i) {
      std::vector<std::int32_t>& selected = selections_[i].selected;
      count.seen += static_cast<std::int64_t>(selected.size());
      count.removed += static_cast<std::int64_t>(selected.size());
      std::vector<std::int32_t> kept = filter(i, selections_[i]);
      count.removed -= static_cast<std::int64_t>(kept.size());
      tell_removed(i, selected, kept);
      selected = std::move(kept);
    }
    counts_.push_back(std::move(count));
  }

 private:
  /// Of two ascending lists, those in the first only went by the filter at hand.
  void tell_removed(std::size_t i, std::span<const std::int32_t> seen, std::span<const std::int32_t> kept) {
    if (fates_ == nullptr) return;
    std::vector<std::int32_t> removed;
    std::set_difference(seen.begin(), seen.end(), kept.begin(), kept.end(), std::back_inserter(removed));
    for (const std::int32_t node : removed) {
      NodeFate& fate = (*fates_)[i][static_cast<std::size_t>(node)];
      if (fate.kind != NodeFate::Kind::kRegion) continue;  // the selection by maxima has told it already
      fate.kind = NodeFate::Kind::kFiltered;
      fate.filter = static_cast<std::int32_t>(counts_.size());
    }
  }

  std::vector<TreeSelection>& selections_;
  std::vector<FilterCount>& counts_;
  std::vector<NodeFates>* fates_;
};

/// Those of one tree, where somebody asks.
NodeFates* fates_of_tree(std::vector<NodeFates>* fates, std::size_t tree) {
  return fates == nullptr ? nullptr : &(*fates)[tree];
}

std::vector<std::int32_t> leaves_of(const Maxima& maxima) {
  std::vector<std::int32_t> leaves;
  for (std::size_t n = 0; n < maxima.top_of_leaf.size(); ++n)
    if (maxima.top_of_leaf[n] >= 0) leaves.push_back(static_cast<std::int32_t>(n));
  return leaves;
}

std::vector<std::int32_t> select_nodes(const SegmentInputs& inputs, const ComponentTree& tree,
                                       const TreeSelection& known, const SegmentParameters& parameters,
                                       NodeFates* fates) {
  if (selects_by_maxima(parameters)) return leaves_of(known.maxima);
  const std::vector<std::uint8_t> open = open_roots(tree, inputs.surface.twins, inputs.level_sets.excluded_of_triangle);
  if (parameters.select == Select::kLevel) return select_level(tree, parameters.level, open, fates);
  if (parameters.select == Select::kMeaningful)
    return select_meaningful(tree, known.log_false_alarms, std::log10(parameters.max_false_alarms), open, fates);
  if (parameters.select == Select::kMser)
    return select_mser(tree, known.changes, {parameters.delta, parameters.against}, open, fates);
  return select_length(tree, level_line_lengths(inputs.surface, tree), parameters.min_length, open, fates);
}

/// log_false_alarms of every tree.
void count_false_alarms(const SegmentInputs& inputs, std::span<const double> areas, double independent,
                        std::vector<TreeSelection>& selections, const Execution& execution) {
  const std::vector<ComponentTree>& trees = inputs.level_sets.trees;
  const std::vector<double> gradients = triangle_gradients(inputs.surface, inputs.level_sets.values, execution);
  const GradientShare share(gradients, areas);
  ChanceParameters chance{independent, 0};
  std::vector<std::vector<LevelLine>> lines;
  for (const ComponentTree& tree : trees) {
    lines.push_back(level_lines(inputs.surface, tree, gradients));
    chance.num_lines += static_cast<std::int64_t>(lines.back().size());
  }
  for (std::size_t i = 0; i < trees.size(); ++i)
    selections[i].log_false_alarms = log_false_alarms(trees[i].num_nodes(), lines[i], share, chance);
}

std::vector<TreeSelection> select_in_trees(const SegmentInputs& inputs, const SegmentParameters& parameters,
                                           std::span<const double> areas, std::vector<FilterCount>& counts,
                                           std::vector<NodeFates>* fates, const Execution& execution) {
  const std::vector<ComponentTree>& trees = inputs.level_sets.trees;
  std::vector<TreeSelection> selections(trees.size());
  const Significance significance{parameters.min_persistence, parameters.min_area};
  if (parameters.select == Select::kMeaningful)
    count_false_alarms(inputs, areas, parameters.independent, selections, execution);
  for (std::size_t i = 0; i < selections.size(); ++i) {
    selections[i].changes = parameters.delta_value > 0 ? change_of_nodes_by_value(trees[i], parameters.delta_value)
                                                       : change_of_nodes(trees[i], parameters.delta);
    selections[i].maxima = find_maxima(trees[i]);
    selections[i].selected = select_nodes(inputs, trees[i], selections[i], parameters, fates_of_tree(fates, i));
  }
  if (!selects_by_maxima(parameters)) return selections;
  Filtering(selections, counts, fates).apply("significance", [&](std::size_t i, const TreeSelection& of) {
    return parameters.select == Select::kPersistence
               ? select_persistence(trees[i], of.maxima, significance, fates_of_tree(fates, i))
               : select_stable_branch(trees[i], of.maxima, of.changes, significance, fates_of_tree(fates, i));
  });
  return selections;
}

void filter_selections(const SurfaceView& surface, const LevelSetTrees& level_sets,
                       std::span<const double> triangle_values, std::span<const double> areas,
                       const SegmentParameters& parameters, std::vector<TreeSelection>& selections,
                       std::vector<Contrasts>& contrasts, std::vector<FilterCount>& counts,
                       std::vector<NodeFates>* fates, const Execution& execution) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<ComponentTree>& trees = level_sets.trees;
  const bool by_maxima = selects_by_maxima(parameters);
  Filtering filtering(selections, counts, fates);
  if (!by_maxima && parameters.min_area > 0)
    filtering.apply("min_area", [&](std::size_t i, const TreeSelection& of) {
      return filter_area(trees[i], of.selected, parameters.min_area, kInfinity);
    });
  if (parameters.max_area < kInfinity)
    filtering.apply("max_area", [&](std::size_t i, const TreeSelection& of) {
      return filter_area(trees[i], of.selected, 0, parameters.max_area);
    });
  if (parameters.max_variation < kInfinity)
    filtering.apply("max_variation", [&](std::size_t i, const TreeSelection& of) {
      return filter_variation(trees[i], of.changes, of.selected, parameters.max_variation);
    });
  if (!by_maxima && parameters.min_persistence > 0)
    filtering.apply("min_persistence", [&](std::size_t, const TreeSelection& of) {
      return filter_persistence(of.maxima, of.selected, parameters.min_persistence);
    });
  const auto measure_contrasts = [&] {
    for (std::size_t i = 0; i < trees.size(); ++i) {
      contrasts[i].nodes = selections[i].selected;
      contrasts[i].values = border_contrasts(surface, trees[i], selections[i].selected, triangle_values, areas,
                                             parameters.band, execution);
    }
  };
  if (parameters.min_contrast > 0) {
    measure_contrasts();
    const double noise = std::isfinite(level_sets.noise) ? level_sets.noise : noise_of_values(surface, triangle_values);
    filtering.apply("min_contrast", [&](std::size_t i, const TreeSelection& of) {
      std::vector<std::int32_t> kept;
      for (const std::int32_t node : of.selected)
        if (trees[i].sign(node) * contrasts[i].of(node) >= parameters.min_contrast * noise) kept.push_back(node);
      return kept;
    });
  }
  if (parameters.min_diversity > 0)
    filtering.apply("min_diversity", [&](std::size_t i, const TreeSelection& of) {
      return filter_diversity(trees[i], of.changes, of.selected, parameters.min_diversity, fates_of_tree(fates, i));
    });
  if (parameters.nested != Nested::kKeep)
    filtering.apply("nested", [&](std::size_t i, const TreeSelection& of) {
      return filter_nested(trees[i], of.changes, of.selected, parameters.nested, fates_of_tree(fates, i));
    });
  if (parameters.min_contrast <= 0) measure_contrasts();
}

/// What is not a number belongs to excluded triangles only, and must not stand in the way of comparisons.
std::vector<double> finite(std::span<const double> values) {
  std::vector<double> result(values.size());
  std::transform(values.begin(), values.end(), result.begin(),
                 [](double value) { return std::isfinite(value) ? value : 0; });
  return result;
}

std::vector<double> magnitudes(std::span<const double> values) {
  std::vector<double> result = finite(values);
  for (double& value : result) value = std::abs(value);
  return result;
}

std::vector<std::int32_t> flood(const SegmentInputs& inputs, std::span<const std::int32_t> labels,
                                std::span<const double> strength, std::span<const double> curvature,
                                std::span<const double> areas, const SegmentParameters& parameters,
                                const Execution& execution) {
  const std::vector<std::uint8_t>& excluded = inputs.level_sets.excluded_of_triangle;
  switch (parameters.flood_by) {
    case FloodBy::kFacets:
      return flood_facets(inputs.surface, labels, curvature, inputs.normals, parameters.flood_width, excluded);
    case FloodBy::kLikeness:
      return flood_by_likeness(inputs.surface, labels,
                               triangle_means(inputs.surface, finite(inputs.level_sets.values), execution), areas,
                               excluded);
    case FloodBy::kStrength:
      break;
  }
  return flood_by_strength(inputs.surface, labels, strength, excluded, execution);
}

/// Whether labels of one patch each leave grow_and_merge as such: all but fitted borders only join what lies side by
/// side.
bool keeps_labels_whole(const SegmentParameters& parameters) {
  return parameters.border != Border::kSides;
}

/// Absorbs, floods and merges labels of one patch each, in any numbering.
std::vector<std::int32_t> grow_and_merge(const SegmentInputs& inputs, std::vector<std::int32_t> labels,
                                         std::span<const double> areas, const SegmentParameters& parameters,
                                         const Execution& execution) {
  const SurfaceView& surface = inputs.surface;
  const std::vector<double> strength =
      magnitudes(inputs.strength.empty() ? std::span<const double>(inputs.level_sets.values) : inputs.strength);
  const std::vector<double> curvature = magnitudes(inputs.curvature);
  if (parameters.grow == Grow::kWatershed)
    labels = flood(inputs, labels, strength, curvature, areas, parameters, execution);
  execution.check();
  // After the flood: a small seed may be all that a large facet has.
  if (parameters.grow != Grow::kNone && parameters.absorb_area > 0)
    labels = absorb_small_patches(surface, labels, areas, parameters.absorb_area, execution, true);
  const auto settle = [&] {
    if (parameters.border != Border::kSides) return;
    FitParameters fit;
    fit.spacing = parameters.spacing;
    fit.radius = parameters.side_radius;
    labels = fit_borders(surface, labels, areas, fit, execution);
    if (parameters.absorb_area > 0)
      labels = absorb_small_patches(surface, labels, areas, parameters.absorb_area, execution);
  };
  if (parameters.merge == Merge::kSaliency)
    labels = merge_by_saliency(surface, labels, strength, areas, parameters.saliency, execution);
  if (parameters.merge == Merge::kTurning) {
    TurningParameters turning;
    turning.threshold = parameters.turning;
    turning.radius = parameters.turning_radius;
    std::vector<double> bending;
    if (!curvature.empty()) bending = triangle_means(surface, curvature, execution);
    labels = merge_by_turning(surface, labels, bending, areas, turning, execution);
  }
  // After merging only: between two parts of one bent face no edge is to be found, and their border must not look for
  // one.
  settle();
  return labels;
}

/// For mesh and parameters that have been checked.
RegionSelection select_regions(const SegmentInputs& inputs, const SegmentParameters& parameters,
                               std::span<const double> areas, std::vector<NodeFates>* fates,
                               const Execution& execution) {
  const std::vector<ComponentTree>& trees = inputs.level_sets.trees;
  const std::vector<double> triangle_values = triangle_means(inputs.surface, inputs.level_sets.values, execution);
  if (fates != nullptr) {
    fates->clear();
    for (const ComponentTree& tree : trees) fates->emplace_back(tree.num_nodes());
  }
  RegionSelection result;
  execution.report("selecting regions", 0, 4);
  result.selections = select_in_trees(inputs, parameters, areas, result.filters, fates, execution);
  execution.report("filtering regions", 1, 4);
  result.contrasts.resize(trees.size());
  filter_selections(inputs.surface, inputs.level_sets, triangle_values, areas, parameters, result.selections,
                    result.contrasts, result.filters, fates, execution);

  std::vector<std::vector<std::int32_t>> selected;
  for (const TreeSelection& selection : result.selections) selected.push_back(selection.selected);
  result.regions = order_regions(trees, selected);
  if (parameters.keep_largest <= 0) return result;
  const auto seen = static_cast<std::int64_t>(result.regions.size());
  const std::int64_t kept = std::min(seen, parameters.keep_largest);
  if (fates != nullptr)
    for (std::size_t r = static_cast<std::size_t>(kept); r < result.regions.size(); ++r) {
      const SelectedNode& of = result.regions[r];
      tell_fate(fates_of_tree(fates, static_cast<std::size_t>(of.tree)), static_cast<std::size_t>(of.node),
                {NodeFate::Kind::kFiltered, static_cast<std::int32_t>(result.filters.size())});
    }
  result.regions.resize(static_cast<std::size_t>(kept));
  result.filters.push_back({"keep_largest", seen, seen - kept});
  return result;
}

}  // namespace

double Contrasts::of(std::int32_t node) const {
  const auto found = std::lower_bound(nodes.begin(), nodes.end(), node);
  if (found == nodes.end() || *found != node) return std::numeric_limits<double>::quiet_NaN();
  return values[static_cast<std::size_t>(found - nodes.begin())];
}

RegionSelection select_regions(const SegmentInputs& inputs, const SegmentParameters& parameters,
                               std::vector<NodeFates>* fates, const Execution& execution) {
  check(inputs, parameters);
  const std::vector<double> areas = triangle_areas(inputs.surface.positions, inputs.surface.triangles, execution);
  return select_regions(inputs, parameters, areas, fates, execution);
}

Segmentation segment(const SegmentInputs& inputs, const SegmentParameters& parameters, const Execution& execution,
                     bool record_fates) {
  check(inputs, parameters);
  const SurfaceView& surface = inputs.surface;
  const LevelSetTrees& level_sets = inputs.level_sets;
  const std::vector<ComponentTree>& trees = level_sets.trees;
  const std::vector<double> areas = triangle_areas(surface.positions, surface.triangles, execution);
  std::vector<NodeFates> fates;
  RegionSelection selection = select_regions(inputs, parameters, areas, record_fates ? &fates : nullptr, execution);
  const std::vector<SelectedNode>& regions = selection.regions;

  Segmentation segmentation;
  segmentation.filters = std::move(selection.filters);
  for (NodeFates& of_tree : fates) segmentation.fates.push_back({std::move(of_tree)});
  execution.report("describing regions", 2, 4);
  segmentation.regions =
      describe_regions(surface, trees, selection.selections, regions, level_sets.values, areas, execution);
  for (std::size_t r = 0; r < regions.size(); ++r)
    segmentation.regions[r].contrast =
        selection.contrasts[static_cast<std::size_t>(regions[r].tree)].of(regions[r].node);
  segmentation.region_of_triangle = label_triangles(trees, regions);
  if (trees.empty()) segmentation.region_of_triangle.assign(surface.triangles.size(), 0);

  execution.report("labelling triangles", 3, 4);
  Patches patches = split_patches(surface.twins, segmentation.region_of_triangle, areas, execution);
  if (parameters.grow != Grow::kNone || parameters.merge != Merge::kNone) {
    std::vector<std::int32_t> labels = patches.patch_of_triangle;
    if (parameters.grow == Grow::kLevel) {
      std::vector<LabelLevel> levels(1);
      for (std::size_t p = 1; p < patches.number_of_patch.size(); ++p) {
        const Region& region = segmentation.regions[static_cast<std::size_t>(patches.number_of_patch[p]) - 1];
        levels.push_back({region.value, region.polarity == Polarity::kUpper});
      }
      labels =
          fill_cut_triangles(surface, labels, levels, triangle_means(surface, finite(level_sets.values), execution),
                             level_sets.excluded_of_triangle);
    }
    const std::vector<std::int32_t> grown = grow_and_merge(inputs, std::move(labels), areas, parameters, execution);
    Patches final_patches =
        split_patches(surface.twins, grown, areas, execution, {.whole_numbers = keeps_labels_whole(parameters)});
    drop_whole_components(surface.twins, final_patches);
    for (std::int32_t& number : final_patches.number_of_patch)
      number = patches.number_of_patch[static_cast<std::size_t>(number)];
    patches = std::move(final_patches);
  }
  segmentation.label_of_triangle = std::move(patches.patch_of_triangle);
  segmentation.region_of_label = std::move(patches.number_of_patch);
  segmentation.area_of_label = std::move(patches.area_of_patch);
  execution.report("labelling triangles", 4, 4);
  return segmentation;
}

}  // namespace meshmser
