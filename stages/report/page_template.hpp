#pragma once
#include <string_view>

namespace meshmser {

/// The page without data, as built from stages/report/page: styles and program in one HTML text, to which data is
/// appended.
std::string_view page_template();

}  // namespace meshmser
