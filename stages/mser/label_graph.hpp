#pragma once
/// Which labels share a border, and the joining of neighbours, weakest border first.

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// The common border of two labels: half-edges of the one whose twin is of the other, one of each twin pair, ascending.
struct CommonBorder {
  std::vector<std::int32_t> half_edges;
  double weakness = 0;       ///< what decides; the least is joined first
  std::int64_t version = 0;  ///< of the last measurement
};

/// Labels as nodes, common borders as edges; background (0) has none. A label that was joined to another is stood for
/// by the smaller of the two.
class LabelGraph {
 public:
  LabelGraph(const SurfaceView& surface, std::span<const std::int32_t> labels);

  std::int32_t num_labels() const { return static_cast<std::int32_t>(borders_.size()) - 1; }
  std::int32_t stands_for(std::int32_t label) const;

  /// Measures every border, then joins the labels of the weakest until none is weaker than `threshold`; the borders of
  /// a joined label are measured anew. `measure(a, b, border)`: weakness; called from several threads at the start,
  /// from one later. `join(a, b)`: label b is about to become part of a, a < b.
  void join_while_weak(double threshold,
                       const std::function<double(std::int32_t, std::int32_t, const CommonBorder&)>& measure,
                       const std::function<void(std::int32_t, std::int32_t)>& join, const Execution& execution);

  std::vector<std::int32_t> joined_labels(std::span<const std::int32_t> labels) const;

 private:
  std::vector<std::map<std::int32_t, CommonBorder>> borders_;  ///< of each label those with greater labels
  std::vector<std::int32_t> joined_;
};

}  // namespace meshmser
