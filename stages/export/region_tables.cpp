#include <cmath>

#include "pipeline/formats/output_file.hpp"
#include "stages/export/export_files.hpp"

namespace meshmser {
namespace {

/// Comma-separated cells of one row after the other.
class Table {
 public:
  Table(const std::filesystem::path& path, std::string_view header) : file_(path) {
    file_.text(header);
    file_.character('\n');
  }
  template <class Value>
  Table& operator<<(const Value& value) {
    if (!first_) file_.character(',');
    first_ = false;
    if constexpr (std::is_convertible_v<Value, std::string_view>) {
      file_.text(value);
    } else if constexpr (std::is_floating_point_v<Value>) {
      file_.number(static_cast<double>(value));
    } else {
      file_.number(static_cast<std::int64_t>(value));
    }
    return *this;
  }
  Table& operator<<(const Eigen::Vector3d& v) { return *this << v.x() << v.y() << v.z(); }
  void end_row() {
    file_.character('\n');
    first_ = true;
  }
  void finish() { file_.finish(); }

 private:
  OutputFile file_;
  bool first_ = true;
};

}  // namespace

void write_regions_csv(const std::filesystem::path& path, const Segmentation& segmentation,
                       const Eigen::Vector3d& origin) {
  Table table(path,
              "label,polarity,node,parent,level,high_level,value,triangles,area,stability,persistence,contrast,border_"
              "length,hole_length,scalar_mean,scalar_min,scalar_max,scalar_deviation,x,y,z,nx,ny,nz,depth,euler,"
              "flatness,min_x,min_y,min_z,max_x,max_y,max_z,spread_1,spread_2,spread_3,axis_1_x,axis_1_y,axis_1_z,"
              "axis_2_x,axis_2_y,axis_2_z,axis_3_x,axis_3_y,axis_3_z,best_fit,plane_residual,sphere_residual,sphere_"
              "radius,sphere_x,sphere_y,sphere_z,cylinder_residual,cylinder_radius,cylinder_x,cylinder_y,cylinder_z,"
              "cylinder_axis_x,cylinder_axis_y,cylinder_axis_z");
  for (std::size_t i = 0; i < segmentation.regions.size(); ++i) {
    const Region& region = segmentation.regions[i];
    table << i + 1 << name_of(region.polarity) << region.node << region.parent << region.low_level << region.high_level
          << region.value << region.num_triangles << region.area << region.stability << region.persistence
          << region.contrast << region.level_length << region.hole_length << region.scalar_mean << region.scalar_min
          << region.scalar_max << region.scalar_deviation << Eigen::Vector3d(region.centroid + origin)
          << region.mean_normal << region.depth << region.euler << region.flatness
          << Eigen::Vector3d(region.box_min + origin) << Eigen::Vector3d(region.box_max + origin) << region.spread
          << region.axis_1 << region.axis_2 << region.axis_3 << name_of(region.best_fit) << region.plane_residual
          << region.sphere_residual << region.sphere_radius << Eigen::Vector3d(region.sphere_centre + origin)
          << region.cylinder_residual << region.cylinder_radius << Eigen::Vector3d(region.cylinder_point + origin)
          << region.cylinder_axis;
    table.end_row();
  }
  table.finish();
}

void write_labels_csv(const std::filesystem::path& path, const Segmentation& segmentation) {
  std::vector<std::int64_t> triangles(segmentation.region_of_label.size(), 0);
  for (const std::int32_t label : segmentation.label_of_triangle) ++triangles[static_cast<std::size_t>(label)];
  Table table(path, "label,region,triangles,area");
  for (std::size_t label = 1; label < segmentation.region_of_label.size(); ++label) {
    table << label << segmentation.region_of_label[label] << triangles[label] << segmentation.area_of_label[label];
    table.end_row();
  }
  table.finish();
}

void write_tree_csv(const std::filesystem::path& path, const LevelSetTrees& trees, const Segmentation* segmentation) {
  Table table(path, "polarity,node,parent,level,high_level,value,high_value,area,region");
  for (const ComponentTree& tree : trees.trees) {
    std::vector<std::int32_t> region_of_node(tree.num_nodes(), 0);
    if (segmentation != nullptr)
      for (std::size_t i = 0; i < segmentation->regions.size(); ++i)
        if (tree.has_side(segmentation->regions[i].polarity) && segmentation->regions[i].node >= 0)
          region_of_node[static_cast<std::size_t>(segmentation->regions[i].node)] = static_cast<std::int32_t>(i + 1);
    for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
      const auto node = static_cast<std::int32_t>(n);
      table << name_of(tree.side(node)) << n << tree.parent_of_node[n] << tree.lo(node) << tree.hi_of_node[n]
            << tree.value(node) << tree.value_of_level(tree.own_level(node))
            << std::ldexp(static_cast<double>(tree.area_of_node[n]), -tree.area_exponent_of_node[n])
            << region_of_node[n];
      table.end_row();
    }
  }
  table.finish();
}

}  // namespace meshmser
