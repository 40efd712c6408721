#include "python/run.hpp"

#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <vector>

#include "pipeline/run/console.hpp"
#include "pipeline/run/runner.hpp"
#include "python/interruptible.hpp"

namespace meshmser::python {
namespace {

py::object value_of(const ReportItem& item) {
  return std::visit([](const auto& value) -> py::object { return py::cast(value); }, item.value);
}

const char* name_of(StageOutcome outcome) {
  return outcome == StageOutcome::kCached ? "cached" : "ran";
}

py::dict record_of(const StageRecord& stage) {
  py::dict record;
  record["name"] = stage.name;
  record["stage"] = stage.stage;
  record["outcome"] = name_of(stage.outcome);
  record["reason"] = stage.reason;
  record["wall_seconds"] = stage.wall_seconds;
  record["cpu_seconds"] = stage.cpu_seconds;
  record["peak_bytes"] = stage.peak_bytes;
  record["warnings"] = stage.warnings;
  py::dict report;
  for (const ReportItem& item : stage.report) report[py::str(item.name)] = value_of(item);
  record["report"] = report;
  py::dict outputs;
  for (const OutputRecord& output : stage.outputs) outputs[py::str(output.port)] = output.folder.string();
  record["outputs"] = outputs;
  std::vector<std::string> files;
  for (const auto& file : stage.files) files.push_back(file.string());
  record["files"] = files;
  return record;
}

py::tuple run_configuration(const std::string& path, const std::optional<std::string>& text,
                            const std::vector<std::string>& set, RunOptions options, int threads, bool quiet) {
  const RunResult result = interruptible(threads, [&](const Execution& execution) {
    const Configuration configuration = text ? parse_configuration(*text, path, set) : load_configuration(path, set);
    ConsoleObserver observer(quiet);
    return run(configuration, options, execution, observer);
  });
  py::list stages;
  for (const StageRecord& stage : result.stages) stages.append(record_of(stage));
  return py::make_tuple(stages, result.out.string(), result.cache.string());
}

}  // namespace

void declare_run(py::module_& module) {
  module.def("_run", [](const std::string& path, const std::optional<std::string>& text,
                        const std::vector<std::string>& set, const std::string& out, const std::string& cache,
                        const std::string& until, bool force, int threads, bool quiet) {
    RunOptions options;
    options.out = out;
    options.cache = cache;
    options.until = until;
    options.force_all = force;
    return run_configuration(path, text, set, std::move(options), threads, quiet);
  });
}

}  // namespace meshmser::python
