#pragma once
/// Points as text, one a line: XYZ, TXT, CSV, ASC, PTS.

#include <string>
#include <vector>

#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

struct XyzOptions {
  /// Names of the columns, left to right; empty: from the header line, else x y z and then `column4`, `column5` ...
  /// `x`, `y` and `z` must be among them; a column named `_` is left out.
  std::vector<std::string> columns;
  bool decimal_comma = false;   ///< numbers are written `1,5`; columns are then separated by blanks or semicolons
  bool skip_bad_lines = false;  ///< leave out lines that are not points, and count them, instead of failing
};

/// Reads one point a line. Found by itself: the separator (blanks, comma or semicolon), the number of columns (that of
/// the first point), a header line with names, lines of comment (`#`, `//`, `%`, `!` in front) and empty ones anywhere,
/// a first line that holds only the number of points (PTS; the number is then checked), UTF-8 byte order marks,
/// CRLF and CR line ends. Seven unnamed columns of a `.pts` are x y z intensity red green blue, six x y z red green
/// blue, four x y z intensity. Throws InputError naming file:line. O(bytes).
Geometry read_xyz(const FileBytes& file, const XyzOptions& options = {});

}  // namespace meshmser
