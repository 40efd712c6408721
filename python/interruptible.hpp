#pragma once
/// Long work without Python's lock, which Ctrl-C ends.

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <future>
#include <optional>

#include "pipeline/execution/execution.hpp"

namespace meshmser::python {

namespace py = pybind11;

/// Calls work(execution) on a thread of its own and returns what it returns. Meanwhile other Python threads run, and
/// twenty times a second signals are looked at: an exception of a handler (KeyboardInterrupt) cancels the work, waits
/// for it, and is thrown. `work` must not touch Python objects.
template <class Work>
auto interruptible(int threads, Work work) {
  std::atomic<bool> cancelled{false};
  Execution execution;
  execution.threads = threads;
  execution.cancelled = &cancelled;
  std::optional<py::error_already_set> interruption;
  const py::gil_scoped_release unlocked;
  auto result = std::async(std::launch::async, [&] { return work(execution); });
  while (result.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
    const py::gil_scoped_acquire locked;
    if (!cancelled && PyErr_CheckSignals() != 0) {
      interruption.emplace();
      cancelled = true;
    }
  }
  if (interruption) {
    const py::gil_scoped_acquire locked;
    throw py::error_already_set(std::move(*interruption));
  }
  return result.get();
}

}  // namespace meshmser::python
