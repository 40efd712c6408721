#pragma once
#include <atomic>

namespace meshmser {

/// From now on SIGINT and SIGTERM set the returned flag; where what runs does not look at the flag within .7 seconds,
/// the process ends with exit code 130 all the same (what is cached is complete, since entries are renamed into place).
const std::atomic<bool>& watch_for_interruption();

}  // namespace meshmser
