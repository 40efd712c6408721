#pragma once
#include <cstdint>

namespace meshmser {

/// Wall time, processor time and peak memory from its construction on.
class Measure {
 public:
  Measure();
  double wall_seconds() const;
  /// User and system time of all threads of the process.
  double cpu_seconds() const;
  /// Greatest resident size since construction, in bytes; since the start of the process where the kernel does not let
  /// it be reset.
  std::int64_t peak_bytes() const;

 private:
  double wall_, cpu_;
};

}  // namespace meshmser
