#include "stages/common/surface.hpp"

#include <Eigen/Geometry>

#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {

std::vector<double> triangle_areas(std::span<const Eigen::Vector3d> positions,
                                   std::span<const std::array<std::int32_t, 3>> triangles, const Execution& execution) {
  std::vector<double> areas;
  reserve_on_large_pages(areas, triangles.size());
  areas.resize(triangles.size());
  parallel_chunks(static_cast<std::int64_t>(triangles.size()), 1 << 15, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
                      const Eigen::Vector3d& a = positions[static_cast<std::size_t>(triangles[t][0])];
                      const Eigen::Vector3d& b = positions[static_cast<std::size_t>(triangles[t][1])];
                      const Eigen::Vector3d& c = positions[static_cast<std::size_t>(triangles[t][2])];
                      areas[t] = 0.5 * (b - a).cross(c - a).norm();
                    }
                  });
  return areas;
}

}  // namespace meshmser
