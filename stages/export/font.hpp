#pragma once
#include <array>
#include <cstdint>

namespace meshmser {

/// The 5 x 7 bitmap of a printable ASCII character, one byte a row from the top, bit 4 leftmost. Descenders are drawn
/// within the seven rows. Characters outside 32 .. 126 get an empty box.
const std::array<std::uint8_t, 7>& glyph_of_character(char character);

}  // namespace meshmser
