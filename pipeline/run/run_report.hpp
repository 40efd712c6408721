#pragma once
#include <map>
#include <string>

#include "pipeline/run/runner.hpp"

namespace meshmser {

/// The text of run.json: configuration with all defaults, versions, SHA-256 of each input file (`digest_of_file`, by
/// path), and of each stage its times, figures, warnings and files. Numbers that JSON has no form for are text.
std::string run_report(const Configuration& configuration, const RunResult& result,
                       const std::map<std::string, std::string>& digest_of_file, const Execution& execution);

}  // namespace meshmser
