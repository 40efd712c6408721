#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace meshmser {

/// How a property was stored in the file it came from, so that it can be written back as it was.
enum class ValueType : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// A named value for each element (point or vertex), as a file carried it: intensity, colour channel, quality ...
struct Property {
  std::string name;
  ValueType type = ValueType::kFloat64;
  std::vector<double> values;  ///< one per element

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("name", self.name);
    field("type", self.type);
    field("values", self.values);
  }
};

}  // namespace meshmser
