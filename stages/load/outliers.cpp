#include "stages/load/outliers.hpp"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_types.h>

namespace meshmser {

std::vector<std::uint8_t> find_outliers(std::span<const Eigen::Vector3d> positions, double spacing,
                                        const OutlierOptions& options, const Execution& execution) {
  std::vector<std::uint8_t> outlier(positions.size(), 0);
  if (options.method == OutlierMethod::kNone || positions.empty()) return outlier;
  execution.report("outliers", 0, 0);
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(positions.size());
  for (const Eigen::Vector3d& p : positions)
    cloud->push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  pcl::Indices kept;
  if (options.method == OutlierMethod::kStatistical) {
    pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
    filter.setInputCloud(cloud);
    filter.setMeanK(options.neighbors);
    filter.setStddevMulThresh(options.deviations);
    filter.filter(kept);
  } else {
    pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter;
    filter.setInputCloud(cloud);
    filter.setRadiusSearch(options.radius_spacings * spacing);
    filter.setMinNeighborsInRadius(options.neighbors);
    filter.filter(kept);
  }
  outlier.assign(positions.size(), 1);
  for (const auto index : kept) outlier[static_cast<std::size_t>(index)] = 0;
  execution.check();
  return outlier;
}

}  // namespace meshmser
