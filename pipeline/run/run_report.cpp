#include "pipeline/run/run_report.hpp"

#include <chrono>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>

namespace meshmser {
namespace {

using Json = nlohmann::ordered_json;

Json value_of(const ReportItem& item) {
  if (const auto* whole = std::get_if<std::int64_t>(&item.value)) return *whole;
  if (const auto* number = std::get_if<double>(&item.value)) {
    if (std::isfinite(*number)) return *number;
    return format_number(*number);
  }
  return std::get<std::string>(item.value);
}

const char* name_of(StageOutcome outcome) {
  switch (outcome) {
    case StageOutcome::kCached:
      return "cached";
    case StageOutcome::kRan:
      return "ran";
    case StageOutcome::kWillRun:
      return "will run";
    case StageOutcome::kMayRun:
      break;
  }
  return "may run";
}

std::string utc_now() {
  const std::time_t time = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  ::gmtime_r(&time, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace

std::string run_report(const Configuration& configuration, const RunResult& result,
                       const std::map<std::string, std::string>& digest_of_file, const Execution& execution) {
  Json report;
  report["meshmser"] = MESHMSER_VERSION;
  report["written"] = utc_now();
  report["config"] = configuration.path;
  report["units"] = configuration.units;
  report["threads"] = execution.threads;
  report["cache"] = result.cache.string();
  report["inputs"] = Json::array();
  for (const auto& [path, digest] : digest_of_file) report["inputs"].push_back({{"path", path}, {"sha256", digest}});
  report["stages"] = Json::array();
  for (std::size_t i = 0; i < result.stages.size(); ++i) {
    const StageRecord& record = result.stages[i];
    const StageEntry& entry = configuration.stages[i];
    Json stage;
    stage["name"] = record.name;
    stage["stage"] = record.stage;
    stage["version"] = entry.definition->info.version;
    stage["outcome"] = name_of(record.outcome);
    if (!record.reason.empty()) stage["reason"] = record.reason;
    stage["parameters"] = Json::object();
    for (const Parameter& parameter : entry.definition->parameters)
      stage["parameters"][parameter.name] = parameter.format(entry.parameters.get());
    stage["changed"] = Json::array();  // parameters that are not what they are by default
    for (const Parameter& parameter : entry.definition->parameters)
      if (parameter.format(entry.parameters.get()) != parameter.default_text)
        stage["changed"].push_back(parameter.name);
    stage["wall_seconds"] = record.wall_seconds;
    stage["cpu_seconds"] = record.cpu_seconds;
    stage["peak_bytes"] = record.peak_bytes;
    stage["report"] = Json::array();
    for (const ReportItem& item : record.report) {
      Json told{{"name", item.name}, {"value", value_of(item)}};
      if (!item.unit.empty()) told["unit"] = item.unit;
      stage["report"].push_back(std::move(told));
    }
    stage["warnings"] = record.warnings;
    stage["outputs"] = Json::array();
    for (const OutputRecord& output : record.outputs)
      stage["outputs"].push_back({{"port", output.port}, {"type", output.type}, {"sha256", output.digest}});
    stage["files"] = Json::array();
    for (const std::filesystem::path& file : record.files) stage["files"].push_back(file.string());
    report["stages"].push_back(std::move(stage));
  }
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace meshmser
