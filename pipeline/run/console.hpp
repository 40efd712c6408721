#pragma once
#include <cstdio>
#include <mutex>
#include <set>

#include "pipeline/run/runner.hpp"

namespace meshmser {

/// Tells a run on stderr: on a terminal one line that moves, with rate and time left; elsewhere plain lines. Each
/// stage ends with its wall time, processor time and peak memory. Quiet: warnings alone.
class ConsoleObserver : public RunObserver {
 public:
  explicit ConsoleObserver(bool quiet = false, std::FILE* stream = stderr);

  void stage_started(const StageRecord& stage, std::size_t index, std::size_t count) override;
  void progress(std::string_view what, std::int64_t done, std::int64_t total) override;
  void stage_finished(const StageRecord& stage, std::size_t index, std::size_t count) override;
  void note(const std::string& message) override;

 private:
  void line(const std::string& text);

  std::FILE* stream_;
  bool quiet_, terminal_;
  std::mutex mutex_;
  std::string stage_, what_;     ///< of the progress told last
  double began_ = 0, told_ = 0;  ///< times of the current `what_`: begin, last line
  std::set<std::string> told_warnings_;
  bool moving_ = false;  ///< the terminal's last line is a progress line
};

}  // namespace meshmser
