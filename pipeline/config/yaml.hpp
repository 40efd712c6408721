#pragma once
/// YAML text to located values: the only place that knows yaml-cpp.

#include <string>
#include <vector>

#include "pipeline/stage/config_value.hpp"

namespace meshmser {

/// Most bytes, values (after aliases are copied in) and levels of nesting that a configuration may have.
inline constexpr std::size_t kMaxConfigBytes = 1 << 20;
inline constexpr std::size_t kMaxConfigValues = 20000;
inline constexpr int kMaxConfigDepth = 32;

/// Reads one YAML document. Anchors and aliases are copied in; repeated keys, keys that are no text, tags, an alias to
/// a value that holds it, a second document and too large a text are diagnostics, each at its place. After an error of
/// syntax nothing more is read. Linear in the text and in the copied values.
ConfigValue read_yaml(const std::string& text, const std::string& file, std::vector<Diagnostic>& problems);

/// The value of a `--set` argument: YAML in one line, every location being the argument itself (line 0).
ConfigValue read_argument_value(const std::string& text, const std::string& argument,
                                std::vector<Diagnostic>& problems);

}  // namespace meshmser
