#pragma once
/// Values with units as they stand in a configuration, resolved against a scan's own scale when a stage runs.

#include <string>
#include <utility>

namespace meshmser {

/// A scan's own scale, against which relative quantities are resolved.
struct Scale {
  double spacing = 0;   ///< h of definitions 1
  double diagonal = 0;  ///< of the bounding box
  double area = 0;      ///< of the whole surface, where known
};

/// A length: in coordinate units, in spacings, or in percent of the bounding box's diagonal.
struct Length {
  enum class Unit { kCoordinate, kSpacing, kDiagonalPercent };
  double value = 0;
  Unit unit = Unit::kSpacing;
  bool operator==(const Length&) const = default;
  double resolve(const Scale& scale) const {
    if (unit == Unit::kSpacing) return value * scale.spacing;
    return unit == Unit::kDiagonalPercent ? value / 100 * scale.diagonal : value;
  }
};
inline Length spacings(double value) {
  return {value, Length::Unit::kSpacing};
}

/// An area: in coordinate units squared, in spacings squared, or in percent of the whole surface.
struct Area {
  enum class Unit { kCoordinate2, kSpacing2, kAreaPercent };
  double value = 0;
  Unit unit = Unit::kSpacing2;
  bool operator==(const Area&) const = default;
  double resolve(const Scale& scale) const {
    if (unit == Unit::kSpacing2) return value * scale.spacing * scale.spacing;
    return unit == Unit::kAreaPercent ? value / 100 * scale.area : value;
  }
};
inline Area spacings2(double value) {
  return {value, Area::Unit::kSpacing2};
}

/// A difference of the scalar: in its own unit, or in multiples of its noise (definitions 8).
struct Amount {
  enum class Unit { kScalar, kNoise };
  double value = 0;
  Unit unit = Unit::kNoise;
  bool operator==(const Amount&) const = default;
  double resolve(double noise) const { return unit == Unit::kNoise ? value * noise : value; }
};
inline Amount noises(double value) {
  return {value, Amount::Unit::kNoise};
}

/// An angle in degrees (`5 deg`).
struct Angle {
  double degrees = 0;
  bool operator==(const Angle&) const = default;
};

/// A share of 1, written `2 %` or `0.02`.
struct Share {
  double value = 0;
  bool operator==(const Share&) const = default;
};

/// `auto`, or an outright value.
template <class T>
struct AutoOr {
  bool automatic = true;
  T value{};
  AutoOr() = default;
  AutoOr(T outright) : automatic(false), value(std::move(outright)) {}
  bool operator==(const AutoOr&) const = default;
};

/// A file to be read; relative to the configuration's folder. Its content, not its name, is part of a cache key.
struct InputPath {
  std::string text;      ///< as written
  std::string resolved;  ///< what to open
  bool operator==(const InputPath&) const = default;
};

}  // namespace meshmser
