#include "pipeline/run/console.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>

namespace meshmser {
namespace {

constexpr double kTerminalPeriod = 0.1;  // s between two states of the moving line
constexpr double kPlainPeriod = 10;      // s between two plain lines, so that a log stays short

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string seconds(double value) {
  if (value < 100) return fmt::format("{:.2f} s", value);
  const auto whole = static_cast<std::int64_t>(value);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string bytes(std::int64_t value) {
  const double mib = static_cast<double>(value) / (1 << 20);
  return mib < 1024 ? fmt::format("{:.0f} MiB", mib) : fmt::format("{:.2f} GiB", mib / 1024);
}

std::string rate(double value) {
  if (value >= 1e6) return fmt::format("{:.1f} M/s", value / 1e6);
  if (value >= 1e3) return fmt::format("{:.1f} k/s", value / 1e3);
  return fmt::format("{:.1f}/s", value);
}

}  // namespace

ConsoleObserver::ConsoleObserver(bool quiet, std::FILE* stream)
    : stream_(stream), quiet_(quiet), terminal_(!quiet && ::isatty(::fileno(stream)) == 1) {}

void ConsoleObserver::line(const std::string& text) {
  fmt::print(stream_, "{}{}\n", moving_ ? "\r\033[K" : "", text);
  std::fflush(stream_);
  moving_ = false;
}

void ConsoleObserver::stage_started(const StageRecord& stage, std::size_t index, std::size_t count) {
  const std::lock_guard<std::mutex> guard(mutex_);
  stage_ = fmt::format("[{}/{}] {}", index + 1, count, stage.name);
  what_.clear();
  began_ = told_ = now();
  if (!quiet_) line(fmt::format("{}: runs ({})", stage_, stage.reason));
}

void ConsoleObserver::progress(std::string_view what, std::int64_t done, std::int64_t total) {
  if (quiet_) return;
  const std::unique_lock<std::mutex> guard(mutex_, std::try_to_lock);
  if (!guard.owns_lock()) return;  // another thread tells it; waiting would cost the stage its time
  const double time = now();
  if (what != what_) {
    what_ = what;
    began_ = time;
  }
  if (time - told_ < (terminal_ ? kTerminalPeriod : kPlainPeriod)) return;
  told_ = time;
  std::string text = fmt::format("{}: {}", stage_, what);
  const double elapsed = time - began_, speed = elapsed > 0 ? static_cast<double>(done) / elapsed : 0;
  if (total > 0) text += fmt::format(" {:.0f} %", 100.0 * static_cast<double>(done) / static_cast<double>(total));
  if (elapsed > 0.5 && speed > 0) {
    text += ", " + rate(speed);
    if (total > done) text += fmt::format(", {} left", seconds(static_cast<double>(total - done) / speed));
  }
  if (!terminal_) return line(text);
  fmt::print(stream_, "\r\033[K{}", text);
  std::fflush(stream_);
  moving_ = true;
}

void ConsoleObserver::stage_finished(const StageRecord& stage, std::size_t index, std::size_t count) {
  const std::lock_guard<std::mutex> guard(mutex_);
  const std::string prefix = fmt::format("[{}/{}] {}", index + 1, count, stage.name);
  if (!quiet_) switch (stage.outcome) {
      case StageOutcome::kRan:
        line(fmt::format("{}: {} wall, {} CPU, {} peak", prefix, seconds(stage.wall_seconds),
                         seconds(stage.cpu_seconds), bytes(stage.peak_bytes)));
        break;
      case StageOutcome::kCached:
        line(fmt::format("{}: cached", prefix));
        break;
      case StageOutcome::kWillRun:
        line(fmt::format("{}: would run ({})", prefix, stage.reason));
        break;
      case StageOutcome::kMayRun:
        line(fmt::format("{}: may run ({})", prefix, stage.reason));
        break;
    }
  // A command may ask for several artifacts and so meet the same stage again.
  for (const std::string& warning : stage.warnings)
    if (told_warnings_.insert(stage.name + ": " + warning).second)
      line(fmt::format("warning: {}: {}", stage.name, warning));
}

void ConsoleObserver::note(const std::string& message) {
  const std::lock_guard<std::mutex> guard(mutex_);
  line(message);
}

}  // namespace meshmser
