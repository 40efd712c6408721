#pragma once
/// How well overlapping passes of a scanner lie on each other.

#include <cstdint>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// Two scans that cover the same surface somewhere.
struct PassPair {
  std::uint32_t first = 0, second = 0;  ///< scans, first < second
  std::int64_t num_samples = 0;         ///< places where both could be measured
  double median_distance = 0;           ///< along the normal, in coordinate units, the share of noise taken out
};

struct PassDistances {
  std::vector<PassPair> pairs;  ///< by first, second; only those with enough samples
  double median_distance = 0;   ///< over the samples of all pairs, the share of noise taken out
  std::int64_t num_samples = 0;
};

/// Measures registration. At about 20,000 points, the points within 4 h are split by scan; where the point's own scan
/// and another have at least eight each, on all sides of the point, one quadratic surface with a height of its own for
/// each scan is fitted along the common normal: the difference of the heights is the distance d, the residuals give its
/// standard error s. Noise alone makes the median of |d| positive, so that the result is
/// sqrt(max(0, median(|d|)^2 - (0.6745 median(s))^2)), 0.6745 being the median of |N(0, 1)|.
/// Nothing for a cloud of one scan. O(n log n); same for any number of threads.
PassDistances measure_pass_distances(const PointCloud& points, const Execution& execution = {});

}  // namespace meshmser
