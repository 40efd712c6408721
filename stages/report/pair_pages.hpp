#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace meshmser {

/// One page that shows two runs beside each other, from the pages of both: all of the first; of the second its mesh,
/// scalars, labels and borders. Arrays that both hold are stored once. Where it would exceed `max_bytes`, points,
/// further borders and scalars are left out, which the page says. `names`: what to call them. Throws StageError where a
/// text is no page of a run or one of another version, and where they do not fit.
std::string pair_pages(std::string_view first, std::string_view second, const std::array<std::string, 2>& names,
                       std::size_t max_bytes = 25000000);

}  // namespace meshmser
