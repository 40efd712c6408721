#pragma once
#include <map>
#include <string>
#include <vector>

#include "data/scanner/shape.hpp"

namespace meshmser::scanner {

/// One number that a shape can be made with; lengths in the shape's own unit (millimetres).
struct ShapeParameter {
  std::string name;
  double default_value;
  std::string meaning;
};

/// Values by name; what is not given takes its default.
using ShapeParameters = std::map<std::string, double>;

/// What a built-in shape is, and how it is usually scanned.
struct ShapeInfo {
  std::string name, meaning;
  std::vector<ShapeParameter> parameters;
  double spacing;  ///< of one pass
  int views;
  double cone;  ///< degrees about +z from which it is seen; 180: from all around
};

/// All built-in shapes, in the order in which they are told to the user.
const std::vector<ShapeInfo>& shape_catalogue();

/// Throws UsageError, which names the known ones, when there is no such shape.
const ShapeInfo& shape_info(const std::string& name);

/// Makes a built-in shape with its true faces. Throws UsageError for an unknown shape or parameter, or a value that the
/// shape cannot have. Deterministic; at most a few seconds (pump and bracket), else a fraction of one.
Shape make_shape(const std::string& name, const ShapeParameters& parameters = {});

}  // namespace meshmser::scanner
