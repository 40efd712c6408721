#include "data/scanner/machine_parts.hpp"

#include <cmath>
#include <numbers>

#include "data/scanner/solid_boolean.hpp"
#include "data/scanner/solids.hpp"

namespace meshmser::scanner {
namespace {

using Eigen::Vector3d;

// Solids overlap rather than touch, so that no two faces lie in one plane by chance.
constexpr double kPast = 1;

/// Gives each new solid its own face numbers.
class Workshop {
 public:
  explicit Workshop(double tolerance) : tolerance_(tolerance) {}
  Shape make_box(const Vector3d& low, const Vector3d& high) { return box(low, high, take()); }
  Shape make_cylinder(const Vector3d& from, const Vector3d& to, double radius) {
    return frustum(from, to, radius, radius, tolerance_, take());
  }
  Shape make_cone(const Vector3d& from, const Vector3d& to, double from_radius, double to_radius) {
    return frustum(from, to, from_radius, to_radius, tolerance_, take());
  }
  Shape make_prism(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& half_width) {
    return prism(a, b, c, half_width, take());
  }
  /// A polygon in x and z pulled along y, its middle at y = 0.
  Shape make_angle(const std::vector<Eigen::Vector2d>& corners, double length) {
    std::vector<std::int32_t> faces;
    for (std::size_t i = 0; i < corners.size(); ++i) faces.push_back(take());
    Shape shape = extrusion(corners, faces, length, take());
    for (Vector3d& position : shape.mesh.positions) position.y() -= length / 2;
    return shape;
  }

 private:
  std::int32_t take() {
    const std::int32_t first = next_;
    next_ += 8;
    return first;
  }
  double tolerance_;
  std::int32_t next_ = 1;
};

}  // namespace

Shape make_pump(const ShapeParameters& parameters) {
  Workshop make(parameters.at("tolerance"));
  std::vector<Shape> bodies, cutters;
  bodies.push_back(make.make_box({-40, -30, 0}, {40, 30, 6}));
  bodies.push_back(make.make_cylinder({0, 0, 3}, {0, 0, 37}, 16));                           // body
  bodies.push_back(make.make_cylinder({0, 0, 34}, {0, 0, 40}, 24));                          // flange
  bodies.push_back(make.make_cylinder({0, 0, 20}, {-34, 0, 20}, 9));                         // pipe
  bodies.push_back(make.make_box({13, -2.5, 4}, {25, 2.5, 22}));                             // square rib
  bodies.push_back(make.make_prism({-5, 28, 4.5}, {-5, 13, 4.5}, {-5, 13, 28}, {2, 0, 0}));  // sloping ribs
  bodies.push_back(make.make_prism({5, -13, 4.5}, {5, -28, 4.5}, {5, -13, 28}, {2, 0, 0}));
  cutters.push_back(make.make_cylinder({0, 0, -kPast}, {0, 0, 40 + kPast}, 12));  // main bore
  cutters.push_back(make.make_cylinder({0, 0, 36}, {0, 0, 40 + kPast}, 14.5));    // its seat
  cutters.push_back(make.make_cylinder({-6, 0, 20}, {-34 - kPast, 0, 20}, 6));    // pipe bore
  for (double x : {-32.0, 32.0})
    for (double y : {-22.0, 22.0}) cutters.push_back(make.make_cylinder({x, y, -kPast}, {x, y, 6 + kPast}, 4));
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi * (i + 0.5) / 3, x = 19.5 * std::cos(angle), y = 19.5 * std::sin(angle);
    cutters.push_back(make.make_cylinder({x, y, 34 - kPast}, {x, y, 40 + kPast}, 1.8));
  }
  cutters.push_back(
      make.make_prism({40 + kPast, -24.5, 3}, {34, -31.5, 3}, {40 + kPast, -31.5, 3}, {0, 0, -5}));  // cut corner
  cutters.push_back(make.make_box({-kPast - 40, -34, 3.5}, {-33, -27, 6 + kPast}));                  // step
  return combine_solids(bodies, cutters);
}

Shape make_bracket(const ShapeParameters& parameters) {
  Workshop make(parameters.at("tolerance"));
  std::vector<Shape> bodies, cutters;
  bodies.push_back(make.make_angle({{-25, 0}, {25, 0}, {25, 30}, {19, 30}, {19, 5}, {-25, 5}}, 30));
  bodies.push_back(make.make_prism({0, 0, 4}, {20, 0, 4}, {20, 0, 24}, {0, 2, 0}));  // rib
  cutters.push_back(make.make_cylinder({-13, 0, -kPast}, {-13, 0, 5 + kPast}, 5));   // bore
  cutters.push_back(make.make_cylinder({-13, 0, 3}, {-13, 0, 5 + kPast}, 8));        // its seat
  for (double y : {-9.0, 9.0}) {
    cutters.push_back(make.make_cylinder({19 - kPast, y, 20}, {25 + kPast, y, 20}, 3));
    cutters.push_back(make.make_cone({23, y, 20}, {25 + kPast, y, 20}, 2.5, 5.5));  // countersink
  }
  cutters.push_back(make.make_box({-25 - kPast, 11, 3}, {-17, 15 + kPast, 5 + kPast}));  // notch
  return combine_solids(bodies, cutters);
}

}  // namespace meshmser::scanner
