#pragma once
/// How diagnostics are shown: place, message, the source line and a caret.

#include <string>
#include <vector>

#include "pipeline/stage/config_value.hpp"

namespace meshmser {

/// Sorts by place (a file's in order of lines, then those of arguments), drops repetitions.
void sort_diagnostics(std::vector<Diagnostic>& diagnostics);

/// One diagnostic a paragraph, without a newline at the end:
///   scan.yaml:7:15: unknown key 'neighbours' in stage 'orient', did you mean 'neighbors'?
///     - orient: {neighbours: 12}
///                ^
/// `source` is the text of the file; a diagnostic of an argument shows no line, since the argument is named whole.
std::string render_diagnostics(const std::vector<Diagnostic>& diagnostics, const std::string& source);

}  // namespace meshmser
