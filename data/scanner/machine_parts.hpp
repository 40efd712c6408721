#pragma once
#include "data/scanner/shapes.hpp"

namespace meshmser::scanner {

/// A pump-housing-like part, 80 x 60 x 40: base plate with a cut corner and four bores, hollow body, flange with six
/// bores, pipe, three ribs. Parameter: tolerance.
Shape make_pump(const ShapeParameters& parameters);

/// An angle bracket, 50 x 30 x 30: base and back plate, rib, counterbored hole, two bores, notch. Parameter: tolerance.
Shape make_bracket(const ShapeParameters& parameters);

}  // namespace meshmser::scanner
