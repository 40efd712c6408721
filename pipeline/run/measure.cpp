#include "pipeline/run/measure.hpp"

#include <sys/resource.h>

#include <chrono>
#include <fstream>
#include <string>

namespace meshmser {
namespace {

double wall_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

double cpu_now() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

Measure::Measure() : wall_(wall_now()), cpu_(cpu_now()) {
  // 5 resets the peak of the resident size (proc(5)).
  std::ofstream("/proc/self/clear_refs") << "5";
}

double Measure::wall_seconds() const {
  return wall_now() - wall_;
}

double Measure::cpu_seconds() const {
  return cpu_now() - cpu_;
}

std::int64_t Measure::peak_bytes() const {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stoll(line.substr(6)) * 1024;
  return 0;
}

}  // namespace meshmser
