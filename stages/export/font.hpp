#pragma once
#include <array>
#include <cstdint>

namespace meshmser {

/// The bitmap of a printable ASCII character: one byte a row from the top, bit 4 leftmost; seven rows above the
/// baseline and two for descenders. Characters outside 32 .. 126 get an empty box.
const std::array<std::uint8_t, 9>& glyph_of_character(char character);

}  // namespace meshmser
