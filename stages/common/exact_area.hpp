#pragma once
/// Areas as whole numbers, so that sums do not depend on order (definitions 6).

#include <bit>
#include <cmath>
#include <cstdint>

namespace meshmser {

/// The exponent e for a set of `num_triangles` triangles the greatest of which has `greatest_area`: the sum of all stays
/// below 2^62 units of 2^-e. Independent of order.
inline std::int32_t area_exponent(std::int64_t num_triangles, double greatest_area) {
  if (!(greatest_area > 0)) return 0;
  int exponent = 0;
  std::frexp(greatest_area, &exponent);  // greatest_area < 2^exponent
  const auto count_bits = static_cast<std::int32_t>(std::bit_width(static_cast<std::uint64_t>(num_triangles)));
  // Rounding may lift the greatest area to 2^exponent itself, never beyond.
  return 61 - count_bits - exponent;
}

/// An area in units of 2^-e, rounded to nearest, ties to even. `area` >= 0, below 2^62 units.
inline std::int64_t area_in_units(double area, std::int32_t exponent) {
  double units = 0;
  if (exponent >= -1022 && exponent <= 1023)  // the power itself as a double, much faster than std::ldexp
    units = area * std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
  else
    units = std::ldexp(area, exponent);
  // Doubles from 2^52 on are whole; below, adding 2^52 rounds to nearest even.
  constexpr double kWhole = 4503599627370496.0;
  return static_cast<std::int64_t>(units < kWhole ? (units + kWhole) - kWhole : units);
}

}  // namespace meshmser
