#pragma once
/// What a configuration says, each piece with the place where it says so. No YAML here: pipeline/config makes these.

#include <string>
#include <utility>
#include <vector>

namespace meshmser {

/// Where something was said: a file's line and column from 1, or (line 0) a command-line argument, whose text is
/// `file`.
struct Location {
  std::string file;
  int line = 0;
  int column = 0;
};

struct ConfigValue {
  enum class Kind { kNull, kScalar, kList, kMap };
  Kind kind = Kind::kNull;
  std::string text;                                          ///< of a scalar, as written
  bool quoted = false;                                       ///< a quoted scalar is text, never a number or a word
  std::vector<ConfigValue> items;                            ///< of a list
  std::vector<std::pair<std::string, ConfigValue>> entries;  ///< of a map, in order, keys unique
  std::vector<Location> key_locations;                       ///< of a map, one per entry
  Location location;
};

/// One thing that is wrong, or deserves a warning, at one place.
struct Diagnostic {
  Location location;
  std::string message;
};

}  // namespace meshmser
