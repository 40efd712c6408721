#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace meshmser {

/// What turning the surface inside out does to a scalar: an odd one (H, height) changes its sign.
enum class Parity : std::uint8_t { kEven, kOdd };

/// A scalar over the points of a cloud; NaN where it is not defined.
struct ScalarField {
  std::string name;             ///< `mean_curvature`, `max_abs_curvature`, `crease`, `height` ...
  std::string unit;             ///< in coordinate units: "1/unit", "unit" or ""
  Parity parity = Parity::kEven;
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< standard deviation, sigma_S of definitions 5; NaN: unknown
  std::vector<double> values;   ///< #P

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("name", self.name);
    field("unit", self.unit);
    field("parity", self.parity);
    field("noise", self.noise);
    field("values", self.values);
  }
};

/// A scalar's unit for people: `1/unit` with millimetres is `1/mm`; as it is where the unit of the coordinates is not
/// known (empty or `unit`).
inline std::string unit_for_people(std::string scalar_unit, const std::string& unit_of_coordinates) {
  const std::size_t at = scalar_unit.find("unit");
  if (at != std::string::npos && !unit_of_coordinates.empty()) scalar_unit.replace(at, 4, unit_of_coordinates);
  return scalar_unit;
}

struct ScalarFields {
  std::vector<ScalarField> fields;
  double radius = 0;       ///< the scale at which they were measured, in coordinate units
  double line_width = 0;   ///< measured or given width of lines, in coordinate units; 0: not asked for

  const ScalarField* find(const std::string& name) const {
    for (const ScalarField& field : fields)
      if (field.name == name) return &field;
    return nullptr;
  }

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("fields", self.fields);
    field("radius", self.radius);
    field("line_width", self.line_width);
  }
};

}  // namespace meshmser
