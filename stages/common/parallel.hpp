#pragma once
/// Loops on several threads whose results do not depend on how many there are.

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <string_view>
#include <thread>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

inline int thread_count(const Execution& execution) {
  return execution.threads > 0 ? execution.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Calls body() where TBB's algorithms use as many threads as `execution` says.
template <class Body>
void on_threads(const Execution& execution, Body&& body) {
  const int threads = thread_count(execution);
  // More threads than cores are given when asked for: how else would a test see that results do not depend on them?
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(std::max(threads, thread_count({}))));
  tbb::task_arena arena(threads);
  arena.execute(body);
}

/// Calls body(begin, end) for consecutive chunks of 0 .. n, each of `grain` elements but the last, so that chunk
/// borders do not depend on the number of threads; reports progress as `what` and checks for cancellation at every
/// chunk.
template <class Body>
void parallel_chunks(std::int64_t n, std::int64_t grain, std::string_view what, const Execution& execution,
                     Body&& body) {
  const std::int64_t chunks = (n + grain - 1) / grain;
  std::atomic<std::int64_t> done{0};
  auto run = [&](std::int64_t chunk) {
    execution.check();
    const std::int64_t begin = chunk * grain, end = std::min(n, begin + grain);
    body(begin, end);
    const std::int64_t so_far = done.fetch_add(end - begin) + end - begin;
    if (execution.progress && !what.empty()) execution.progress(what, so_far, n);
  };
  const int threads = thread_count(execution);
  if (threads == 1 || chunks <= 1) {
    for (std::int64_t chunk = 0; chunk < chunks; ++chunk) run(chunk);
    return;
  }
  on_threads(execution, [&] {
    tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, chunks, 1),
                      [&](const tbb::blocked_range<std::int64_t>& range) {
                        for (std::int64_t chunk = range.begin(); chunk < range.end(); ++chunk) run(chunk);
                      });
  });
}

}  // namespace meshmser
