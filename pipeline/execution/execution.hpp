#pragma once
/// How an algorithm is run: threads, cancellation, progress. Std only, so that every algorithm is usable alone.

#include <atomic>
#include <cstdint>
#include <functional>
#include <string_view>

#include "pipeline/execution/error.hpp"

namespace meshmser {

/// Passed as the last argument of every algorithm that takes more than a moment. A default-made Execution uses every
/// core, is never cancelled and is silent. Results never depend on it.
struct Execution {
  int threads = 0;                                ///< 0: every core
  const std::atomic<bool>* cancelled = nullptr;   ///< set by another thread or a signal handler
  /// Called now and then from any thread: what is done, `done` of `total` (0: unknown) elements.
  std::function<void(std::string_view what, std::int64_t done, std::int64_t total)> progress = {};

  /// Throws Cancelled when the user asked to stop. Cheap: call it every few thousand elements.
  void check() const {
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) throw Cancelled();
  }
  /// Reports progress and checks for cancellation.
  void report(std::string_view what, std::int64_t done, std::int64_t total) const {
    check();
    if (progress) progress(what, done, total);
  }
};

}  // namespace meshmser
