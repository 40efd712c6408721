#include "stages/tree/levels.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>

#include "pipeline/execution/error.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

constexpr double kOutliers = 0.025;

/// The q-quantile by linear interpolation between order statistics; reorders `values`, which are not empty.
double quantile(std::vector<double>& values, double q) {
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(below);
  std::nth_element(values.begin(), nth, values.end());
  const double low = *nth;
  if (below + 1 >= values.size()) return low;
  const double high = *std::min_element(nth + 1, values.end());
  return low + (place - static_cast<double>(below)) * (high - low);
}

struct Range {
  double low, high;
};

/// The range of the signed scalar, by quantiles or outright; mirrored for the lower tree where outright.
Range level_range(std::vector<double> signed_values, const LevelParameters& p, bool lower) {
  const double outright_low = lower ? -p.high_value : p.low_value;
  const double outright_high = lower ? -p.low_value : p.high_value;
  Range range{outright_low, outright_high};
  if (!std::isnan(p.low_strength)) {
    const double strength = line_strength(signed_values);
    range = {p.low_strength * strength, p.high_strength * strength};
  }
  if (std::isnan(range.low)) range.low = quantile(signed_values, p.low_quantile);
  if (std::isnan(range.high)) range.high = quantile(signed_values, p.high_quantile);
  if (range.low > range.high)
    throw StageError("the range of the levels is empty: it would begin at " + std::to_string(range.low) +
                     " and end at " + std::to_string(range.high));
  return range;
}

std::vector<double> equal_steps(const Range& range, std::int32_t count) {
  std::vector<double> levels;
  for (std::int32_t k = 1; k < count; ++k)
    levels.push_back(k == count - 1 ? range.high : range.low + (range.high - range.low) * k / (count - 1));
  return levels;
}

std::vector<double> steps_of(const Range& range, double step) {
  if (!(step > 0)) throw StageError("levels by step need a step greater than 0");
  const double count = std::floor((range.high - range.low) / step) + 1;
  if (count > 1e6) {
    std::ostringstream text;
    text << "a step of " << step << " makes more than a million levels; enlarge it";
    throw StageError(text.str());
  }
  std::vector<double> levels;
  for (double k = 0; k < count; ++k) levels.push_back(range.low + k * step);
  return levels;
}

std::vector<double> noise_steps(const Range& range, const LevelParameters& p) {
  if (!(p.noise > 0) || !std::isfinite(p.noise))
    throw StageError("levels in units of noise need the scalar's noise: give `noise`, its standard deviation");
  const double unit = p.noise_constant * p.noise;
  auto forward = [&](double s) { return std::copysign(std::log1p(std::abs(s) / unit), s); };
  auto backward = [&](double f) { return std::copysign(std::expm1(std::abs(f)) * unit, f); };
  std::vector<double> levels = equal_steps({forward(range.low), forward(range.high)}, p.count);
  for (double& level : levels) level = backward(level);
  return levels;
}

/// Values at which 1 / (count - 1), 2 / (count - 1) ... of the weight within the range lies below.
std::vector<double> equal_area_steps(std::span<const double> signed_values, std::span<const double> weights,
                                     const Range& range, std::int32_t count) {
  if (weights.size() != signed_values.size()) throw StageError("levels of equal area need the area of each vertex");
  std::vector<std::pair<double, double>> sorted;
  for (std::size_t v = 0; v < signed_values.size(); ++v)
    if (signed_values[v] >= range.low && signed_values[v] <= range.high)
      sorted.emplace_back(signed_values[v], weights[v]);
  std::sort(sorted.begin(), sorted.end());
  long double total = 0;
  for (const auto& entry : sorted) total += entry.second;
  std::vector<double> levels;
  long double below = 0;
  std::int32_t k = 1;
  for (const auto& [value, weight] : sorted) {
    while (k < count - 1 && below * (count - 1) >= total * k) {
      levels.push_back(value);
      ++k;
    }
    below += weight;
  }
  levels.push_back(range.high);
  return levels;
}

}  // namespace

double line_strength(std::span<const double> values) {
  std::vector<double> positive;
  std::copy_if(values.begin(), values.end(), std::back_inserter(positive), [](double value) { return value > 0; });
  if (positive.empty()) return 0;
  std::sort(positive.begin(), positive.end());
  // What is left of a broken edge or a scratch may be ten times as strong as any line.
  const auto num_outliers = static_cast<std::size_t>(kOutliers * static_cast<double>(values.size()));
  const double most = positive[positive.size() - 1 - std::min(num_outliers, positive.size() - 1)];
  for (double& value : positive) value = std::min(value, most);
  long double total = 0, below = 0;
  for (const double value : positive) total += static_cast<long double>(value) * value;
  for (const double value : positive) {
    below += static_cast<long double>(value) * value;
    if (2 * below >= total) return value;
  }
  return 0;
}

std::vector<double> make_levels(std::span<const double> values, std::span<const double> weights,
                                const LevelParameters& p, bool lower) {
  const double minus_infinity = -std::numeric_limits<double>::infinity();
  std::vector<double> levels;
  if (p.rule == LevelRule::kList) {
    if (p.list.empty()) throw StageError("levels by list need a list that is not empty");
    for (const double level : p.list) levels.push_back(lower ? -level : level);
  } else if (p.rule == LevelRule::kEveryValue) {
    levels = rank_values(values, lower ? -1 : 1).levels;
  } else {
    if (p.count < 2) throw StageError("there must be at least 2 levels");
    levels.push_back(minus_infinity);
    std::vector<double> signed_values;
    signed_values.reserve(values.size());
    for (const double value : values) signed_values.push_back(lower ? -value : value);
    std::vector<double> finite;
    finite.reserve(values.size());
    std::copy_if(signed_values.begin(), signed_values.end(), std::back_inserter(finite),
                 [](double value) { return std::isfinite(value); });
    if (!finite.empty()) {
      const Range range = level_range(std::move(finite), p, lower);
      std::vector<double> above;
      switch (p.rule) {
        case LevelRule::kStep:
          above = steps_of(range, p.step);
          break;
        case LevelRule::kNoise:
          above = noise_steps(range, p);
          break;
        case LevelRule::kEqualArea:
          above = equal_area_steps(signed_values, weights, range, p.count);
          break;
        default:
          above = equal_steps(range, p.count);
      }
      levels.insert(levels.end(), above.begin(), above.end());
    }
  }
  if (p.delta_value > 0) {
    const std::size_t n = levels.size();
    for (std::size_t k = 0; k < n; ++k)
      if (std::isfinite(levels[k])) {
        levels.push_back(levels[k] - p.delta_value);
        levels.push_back(levels[k] + p.delta_value);
      }
  }
  for (double& level : levels) {
    if (std::isnan(level)) throw StageError("a level is not a number");
    level += 0.0;  // -0 and +0 are one level
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

std::vector<std::int32_t> levels_of_vertices(std::span<const double> values, std::span<const double> levels, int sign,
                                             const Execution& execution) {
  std::vector<std::int32_t> result;
  reserve_on_large_pages(result, values.size());
  result.resize(values.size());
  const auto first_finite = static_cast<std::size_t>(
      std::upper_bound(levels.begin(), levels.end(), -std::numeric_limits<double>::max()) - levels.begin());
  const std::span<const double> finite = levels.subspan(first_finite);
  const auto base = static_cast<std::int32_t>(first_finite);
  const auto n = static_cast<std::int32_t>(finite.size());
  if (n == 0) {
    for (std::size_t v = 0; v < values.size(); ++v) result[v] = std::isnan(values[v]) ? 0 : base;
    return result;
  }
  // A value's level lies between the numbers of levels in the cells before its own and up to its own. Both the value
  // and the levels find their cell by the same monotone expression, so that rounding cannot put them in the wrong
  // order.
  const double low = finite.front(), width = finite.back() - low;
  const std::int32_t cells = 4 * n;
  const double scale = width > 0 && std::isfinite(cells / width) ? cells / width : 0;
  const auto cell_of = [=](double value) {
    return static_cast<std::size_t>(std::min(std::max(0.0, (value - low) * scale), static_cast<double>(cells)));
  };
  std::vector<std::int32_t> levels_before(static_cast<std::size_t>(cells) + 2, 0);
  for (const double level : finite) ++levels_before[cell_of(level) + 1];
  std::partial_sum(levels_before.begin(), levels_before.end(), levels_before.begin());
  // Behind the last level there is one that no value reaches.
  std::vector<double> padded(finite.begin(), finite.end());
  padded.push_back(std::numeric_limits<double>::quiet_NaN());
  const double factor = sign < 0 ? -1 : 1;
  parallel_chunks(
      static_cast<std::int64_t>(values.size()), 1 << 15, "", execution, [&](std::int64_t begin, std::int64_t end) {
        for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v) {
          const double value = factor * values[v];
          const std::size_t cell = cell_of(value);
          const std::int32_t before = levels_before[cell], up_to = levels_before[cell + 1];
          // The number of levels <= value: all of earlier cells, none of later ones, and of its own mostly
          // one at most, which takes no branch.
          std::int32_t below = before + static_cast<std::int32_t>(padded[static_cast<std::size_t>(before)] <= value);
          if (up_to - before > 1)
            below = static_cast<std::int32_t>(std::upper_bound(padded.begin() + before, padded.begin() + up_to, value) -
                                              padded.begin());
          // Minus infinity itself is at no finite level; below every level there is none.
          result[v] = std::isnan(value) ? 0 : below + base;
        }
      });
  return result;
}

std::vector<std::int32_t> levels_of_triangles(std::span<const std::array<std::int32_t, 3>> triangles,
                                              std::span<const std::int32_t> level_of_vertex,
                                              std::span<const std::uint8_t> excluded, const Execution& execution) {
  std::vector<std::int32_t> result;
  reserve_on_large_pages(result, triangles.size());
  result.resize(triangles.size());
  parallel_chunks(static_cast<std::int64_t>(triangles.size()), 1 << 15, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
                      const auto& c = triangles[t];
                      const std::int32_t level = std::min({level_of_vertex[static_cast<std::size_t>(c[0])],
                                                           level_of_vertex[static_cast<std::size_t>(c[1])],
                                                           level_of_vertex[static_cast<std::size_t>(c[2])]});
                      result[t] = !excluded.empty() && excluded[t] != 0 ? 0 : level;
                    }
                  });
  return result;
}

RankedValues rank_values(std::span<const double> values, int sign, const Execution& execution) {
  // Bits of a double, made to ascend like the numbers: least significant digit first, 11 bits a pass, passes in which
  // all digits agree left out.
  struct Entry {
    std::uint64_t key;
    std::int32_t vertex;
  };
  constexpr int kBits = 11, kPasses = 6;
  constexpr std::size_t kDigits = std::size_t{1} << kBits;
  RankedValues result;
  result.level_of_vertex.assign(values.size(), 0);
  std::vector<Entry> entries, sorted;
  entries.reserve(values.size());
  std::vector<std::array<std::int32_t, kDigits>> histogram(kPasses);
  for (auto& digits : histogram) digits.fill(0);
  const double factor = sign < 0 ? -1 : 1;
  for (std::size_t v = 0; v < values.size(); ++v) {
    const double value = factor * values[v] + 0.0;  // -0 and +0 are equal values
    if (std::isnan(value)) continue;
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const std::uint64_t key = bits >> 63 ? ~bits : bits | std::uint64_t{1} << 63;
    entries.push_back({key, static_cast<std::int32_t>(v)});
    for (int pass = 0; pass < kPasses; ++pass)
      ++histogram[static_cast<std::size_t>(pass)][key >> (kBits * pass) & (kDigits - 1)];
  }
  sorted.resize(entries.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    execution.check();
    auto& digits = histogram[static_cast<std::size_t>(pass)];
    if (std::any_of(digits.begin(), digits.end(),
                    [&](std::int32_t count) { return static_cast<std::size_t>(count) == entries.size(); }))
      continue;
    std::int32_t sum = 0;
    for (std::int32_t& digit : digits) sum += std::exchange(digit, sum);
    for (const Entry& entry : entries)
      sorted[static_cast<std::size_t>(digits[entry.key >> (kBits * pass) & (kDigits - 1)]++)] = entry;
    entries.swap(sorted);
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i == 0 || entries[i].key != entries[i - 1].key) {
      const std::uint64_t key = entries[i].key;
      result.levels.push_back(std::bit_cast<double>(key >> 63 ? key & ~(std::uint64_t{1} << 63) : ~key));
    }
    result.level_of_vertex[static_cast<std::size_t>(entries[i].vertex)] =
        static_cast<std::int32_t>(result.levels.size());
  }
  return result;
}

}  // namespace meshmser
