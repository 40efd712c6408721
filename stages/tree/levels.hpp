#pragma once
/// Levels of a scalar and the triangles' levels in them (definitions 5), on plain arrays.

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// How h_2 < ... < h_n are laid; h_1 is minus infinity but for kList and kEveryValue.
enum class LevelRule {
  kLinear,      ///< equal steps over the range
  kStep,        ///< steps of a given size from the range's low end
  kList,        ///< as given
  kEqualArea,   ///< equal shares of the area between them, over the range
  kEveryValue,  ///< each distinct value
  kNoise        ///< equal steps of sign(S) log(1 + |S| / (c noise)) over the range
};

struct LevelParameters {
  LevelRule rule = LevelRule::kLinear;
  std::int32_t count = 64;     ///< n, with h_1; >= 2
  double low_quantile = 0.02;  ///< range between two quantiles over the vertices ...
  double high_quantile = 0.98;
  double low_value = std::numeric_limits<double>::quiet_NaN();  ///< ... or outright, in units of S, where not NaN
  double high_value = std::numeric_limits<double>::quiet_NaN();
  double low_strength = std::numeric_limits<double>::quiet_NaN();  ///< ... or as shares of line_strength, where not NaN
  double high_strength = std::numeric_limits<double>::quiet_NaN();
  double step = 0;                                          ///< kStep: in units of S
  std::vector<double> list{};                               ///< kList: in units of S, any order
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< kNoise: sigma_S, in units of S
  double noise_constant = 4;                                ///< kNoise: c
  double delta_value = 0;  ///< > 0: levels h_i - delta and h_i + delta are inserted as well
};

/// The levels h_1 < ... < h_n of a scalar.
///
/// `values`: #V, those not finite are left out; `weights`: #V areas of the vertices for kEqualArea, else may be empty.
/// For the lower tree pass `lower` = true with the *un-negated* values: the levels are those of -S, by the same rule;
/// a list, and a range given outright, are mirrored. Equal levels are merged, so that a constant scalar has one or two.
/// Throws StageError where the rule lacks what it needs (noise, step, list, range in order).
/// Time linear in #V, sorting for kEqualArea and kEveryValue.
std::vector<double> make_levels(std::span<const double> values, std::span<const double> weights,
                                const LevelParameters& parameters, bool lower);

/// The strength of lines in values of a signed scalar: the value above which half of the sum of S^2 over S > 0 lies, so
/// that ground about 0 counts little however wide it is. The highest 2.5 % of all values count as the lowest of them:
/// outliers. 0 where nothing is positive.
/// Values must be finite. Sorts the positive ones.
double line_strength(std::span<const double> values);

/// max{k : S >= h_k} of each vertex, 0 where there is none or S is NaN. `sign` +1 or -1 multiplies S first.
std::vector<std::int32_t> levels_of_vertices(std::span<const double> values, std::span<const double> levels, int sign,
                                             const Execution& execution = {});

/// The least level of each triangle's corners; 0 for a triangle with excluded[t] != 0. `excluded` may be empty.
std::vector<std::int32_t> levels_of_triangles(std::span<const std::array<std::int32_t, 3>> triangles,
                                              std::span<const std::int32_t> level_of_vertex,
                                              std::span<const std::uint8_t> excluded, const Execution& execution = {});

/// Every distinct value as a level: ranks of the vertices and the sorted values, in one radix sort.
struct RankedValues {
  std::vector<double> levels;                 ///< distinct values of sign * S, ascending
  std::vector<std::int32_t> level_of_vertex;  ///< #V; 0 where S is NaN
};
RankedValues rank_values(std::span<const double> values, int sign, const Execution& execution = {});

}  // namespace meshmser
