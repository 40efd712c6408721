#include "stages/export/views.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "pipeline/execution/error.hpp"
#include "stages/export/drawing.hpp"

namespace meshmser {
namespace {

View make_view(const std::string& name, const Eigen::Vector3d& direction, const Eigen::Vector3d& upward) {
  const Eigen::Vector3d along = direction.normalized();
  return {name, along, (upward - along * along.dot(upward)).normalized()};
}

struct NamedView {
  const char* name;
  std::array<double, 3> direction, up;
};
constexpr std::array<NamedView, 9> kNamedViews = {{{"front", {0, 1, 0}, {0, 0, 1}},
                                                   {"back", {0, -1, 0}, {0, 0, 1}},
                                                   {"left", {1, 0, 0}, {0, 0, 1}},
                                                   {"right", {-1, 0, 0}, {0, 0, 1}},
                                                   {"top", {0, 0, -1}, {0, 1, 0}},
                                                   {"bottom", {0, 0, 1}, {0, 1, 0}},
                                                   {"iso", {-1, 1.2, -0.9}, {0, 0, 1}},
                                                   {"iso_back", {1, -1.2, -0.9}, {0, 0, 1}},
                                                   {"iso_below", {-1, 1.2, 0.9}, {0, 0, 1}}}};

}  // namespace

const std::vector<std::string>& view_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedView& view : kNamedViews) all.emplace_back(view.name);
    all.emplace_back("best");
    return all;
  }();
  return names;
}

void check_view_name(const std::string& name) {
  const std::vector<std::string>& known = view_names();
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw UsageError(fmt::format("render: unknown view '{}'; known: {}", name, fmt::join(known, ", ")));
}

View view_of_name(const std::string& name, const TriangleMesh& mesh) {
  if (name == "best") {
    const Eigen::Vector3d facing = facing_of_sheet(mesh);
    if (facing.isZero()) {
      View view = view_of_name("iso", mesh);
      view.name = name;
      return view;
    }
    // The scan's own y stays up, as in the scanner's picture; z where the sheet faces along y.
    return make_view(name, -facing, std::abs(facing.y()) < 0.8 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ());
  }
  for (const NamedView& view : kNamedViews)
    if (name == view.name)
      return make_view(name, {view.direction[0], view.direction[1], view.direction[2]},
                       {view.up[0], view.up[1], view.up[2]});
  check_view_name(name);
  throw std::logic_error("a known view without a direction");
}

std::vector<std::string> default_views(const TriangleMesh& mesh) {
  if (!facing_of_sheet(mesh).isZero()) return {"best"};
  return {"iso", "iso_back", "top", "iso_below"};
}

}  // namespace meshmser
