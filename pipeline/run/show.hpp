#pragma once
#include <string>

#include "pipeline/run/runner.hpp"

namespace meshmser {

/// What `meshmser show` prints of a stage's cached result: its figures and warnings, and of each output where its files
/// lie, and of each field its size, least, greatest and mean value with a short histogram. Reads every artifact of the
/// stage. Throws CacheError that names the remedy where the result is not in the cache, UsageError for a stage that
/// does not exist.
std::string show(const Configuration& configuration, const std::string& stage, const RunOptions& options,
                 const Execution& execution, RunObserver& observer);

}  // namespace meshmser
