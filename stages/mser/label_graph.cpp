#include "stages/mser/label_graph.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <queue>
#include <set>
#include <tuple>

#include "stages/common/parallel.hpp"

namespace meshmser {

LabelGraph::LabelGraph(const SurfaceView& surface, std::span<const std::int32_t> labels) {
  const std::int32_t most = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end());
  borders_.resize(static_cast<std::size_t>(most) + 1);
  joined_.resize(borders_.size());
  std::iota(joined_.begin(), joined_.end(), 0);
  for (std::size_t h = 0; h < surface.twins.size(); ++h) {
    if (surface.twins[h] < 0) continue;
    const std::int32_t here = labels[h / 3], there = labels[static_cast<std::size_t>(surface.twins[h] / 3)];
    if (here != 0 && here < there)
      borders_[static_cast<std::size_t>(here)][there].half_edges.push_back(static_cast<std::int32_t>(h));
  }
}

std::int32_t LabelGraph::stands_for(std::int32_t label) const {
  while (joined_[static_cast<std::size_t>(label)] != label) label = joined_[static_cast<std::size_t>(label)];
  return label;
}

void LabelGraph::join_while_weak(double threshold,
                                 const std::function<double(std::int32_t, std::int32_t, const CommonBorder&)>& measure,
                                 const std::function<void(std::int32_t, std::int32_t)>& join,
                                 const Execution& execution) {
  struct Pair {
    std::int32_t a, b;
    CommonBorder* border;
  };
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < borders_.size(); ++a)
    for (auto& [b, border] : borders_[a]) pairs.push_back({static_cast<std::int32_t>(a), b, &border});
  parallel_chunks(static_cast<std::int64_t>(pairs.size()), 4, "comparing neighbours", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                      pairs[i].border->weakness = measure(pairs[i].a, pairs[i].b, *pairs[i].border);
                  });

  // Weakness, labels, version of the measurement; out of date where the border has been measured since.
  using Entry = std::tuple<double, std::int32_t, std::int32_t, std::int64_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> waiting;
  for (const Pair& pair : pairs)
    if (pair.border->weakness < threshold) waiting.emplace(pair.border->weakness, pair.a, pair.b, 0);
  // Neighbours of smaller label, kept as a superset.
  std::vector<std::set<std::int32_t>> below(borders_.size());
  for (const Pair& pair : pairs) below[static_cast<std::size_t>(pair.b)].insert(pair.a);
  std::int64_t version = 0;
  while (!waiting.empty()) {
    const auto [weakness, a, b, measured] = waiting.top();
    waiting.pop();
    auto& mine = borders_[static_cast<std::size_t>(a)];
    const auto entry = mine.find(b);
    if (entry == mine.end() || entry->second.version != measured) continue;
    execution.check();
    join(a, b);
    joined_[static_cast<std::size_t>(b)] = a;
    mine.erase(entry);
    // All borders of b become borders of a.
    // Clang before 16 cannot capture a structured binding by reference.
    const auto take = [&, a = a](std::int32_t other, CommonBorder&& border) {
      const std::int32_t low = std::min(a, other), high = std::max(a, other);
      std::vector<std::int32_t>& edges = borders_[static_cast<std::size_t>(low)][high].half_edges;
      std::vector<std::int32_t> both;
      std::merge(edges.begin(), edges.end(), border.half_edges.begin(), border.half_edges.end(),
                 std::back_inserter(both));
      edges = std::move(both);
      below[static_cast<std::size_t>(high)].insert(low);
    };
    for (auto& [other, border] : borders_[static_cast<std::size_t>(b)]) take(other, std::move(border));
    borders_[static_cast<std::size_t>(b)].clear();
    for (const std::int32_t other : below[static_cast<std::size_t>(b)]) {
      auto& theirs = borders_[static_cast<std::size_t>(other)];
      const auto found = theirs.find(b);
      if (found == theirs.end()) continue;
      CommonBorder border = std::move(found->second);
      theirs.erase(found);
      take(other, std::move(border));
    }
    below[static_cast<std::size_t>(b)].clear();
    // What a is has changed, so all of its borders are measured anew.
    ++version;
    const auto measure_again = [&](std::int32_t low, std::int32_t high, CommonBorder& border) {
      border.version = version;
      border.weakness = measure(low, high, border);
      if (border.weakness < threshold) waiting.emplace(border.weakness, low, high, version);
    };
    for (auto& [other, border] : mine) measure_again(a, other, border);
    for (const std::int32_t other : below[static_cast<std::size_t>(a)]) {
      auto& theirs = borders_[static_cast<std::size_t>(other)];
      const auto found = theirs.find(a);
      if (found != theirs.end()) measure_again(other, a, found->second);
    }
  }
}

std::vector<std::int32_t> LabelGraph::joined_labels(std::span<const std::int32_t> labels) const {
  std::vector<std::int32_t> joined(labels.size());
  for (std::size_t t = 0; t < labels.size(); ++t) joined[t] = stands_for(labels[t]);
  return joined;
}

}  // namespace meshmser
