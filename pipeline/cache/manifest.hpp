#pragma once
#include <optional>
#include <string>

#include "pipeline/cache/cache.hpp"

namespace meshmser {

/// The text of manifest.json; its last field is the SHA-256 of the rest.
std::string manifest_text(const Entry& entry);

/// Reads it back; nothing where it is not whole or not of this version.
std::optional<Entry> parse_manifest(const std::string& text);

}  // namespace meshmser
