#include "pipeline/run/show.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/formats/stored_artifact.hpp"
#include "pipeline/run/stage_runner.hpp"

namespace meshmser {
namespace {

// Sixteen bins as sixteen characters, the tallest highest.
std::string picture(const std::vector<std::uint64_t>& bins) {
  static constexpr const char* kHeights[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  const std::uint64_t tallest = std::max<std::uint64_t>(1, *std::max_element(bins.begin(), bins.end()));
  std::string text;
  // A bin that holds anything shows.
  for (const std::uint64_t bin : bins) text += kHeights[bin == 0 ? 0 : 1 + bin * 7 / tallest];
  return text;
}

std::string size_of(const FieldStatistics& field) {
  std::string text = std::to_string(field.shape.front());
  for (std::size_t i = 1; i < field.shape.size(); ++i) text += fmt::format(" x {}", field.shape[i]);
  return text + " " + field.type;
}

void tell(std::string& text, const FieldStatistics& field) {
  if (field.shape.empty()) {
    text += fmt::format("    {:<28} {}\n", field.name, field.text);
    return;
  }
  text += fmt::format("    {:<28} {}\n", field.name, size_of(field));
  if (field.shape.front() == 0) return;
  for (std::size_t c = 0; c < field.columns.size(); ++c) {
    const FieldStatistics::Column& column = field.columns[c];
    const std::string which = field.columns.size() == 1 ? "" : fmt::format("[{}]", c);
    if (column.histogram.empty()) {
      text += fmt::format("      {:<4} no finite value\n", which);
      continue;
    }
    text += fmt::format("      {:<4} min {:.6g}  max {:.6g}  mean {:.6g}  |{}|", which, column.least, column.greatest,
                        column.mean, picture(column.histogram));
    if (column.num_not_finite > 0) text += fmt::format("  not finite: {}", column.num_not_finite);
    text += '\n';
  }
}

std::string text_of(const ReportItem& item) {
  std::string text = std::visit(
      []<class T>(const T& value) {
        if constexpr (std::is_same_v<T, std::string>)
          return value;
        else
          return fmt::format("{}", value);
      },
      item.value);
  return item.unit.empty() ? text : text + " " + item.unit;
}

}  // namespace

std::string show(const Configuration& configuration, const std::string& stage, const RunOptions& options,
                 const Execution& execution, RunObserver& observer) {
  const std::size_t index = stage_index(configuration, stage, "show");
  Cache cache(options.cache.empty() ? default_cache_folder(configuration) : std::filesystem::path(options.cache));
  StageRunner stages(configuration, cache, std::vector<bool>(configuration.stages.size(), false), execution, observer);
  stages.judge(stages.with_dependencies(index));
  const StageRecord& record = stages.record(index);
  if (record.outcome != StageOutcome::kCached)
    throw CacheError(
        fmt::format("show: the result of '{}' is not in the cache ({}); run it first: meshmser run {} "
                    "--until {}",
                    stage, record.reason, configuration.path, stage));
  std::string text = fmt::format("{}\n", stage);
  for (const ReportItem& item : record.report) text += fmt::format("  {:<30} {}\n", item.name, text_of(item));
  for (const std::string& warning : record.warnings) text += fmt::format("  warning: {}\n", warning);
  for (const OutputRecord& output : record.outputs) {
    text += fmt::format("  {} ({}) in {}\n", output.port, output.type, output.folder.string());
    for (const FieldStatistics& field : field_statistics(stages.artifact(index, output.port))) tell(text, field);
    for (const std::string& name : stages.entry(index)->find(output.port)->user_files)
      text += fmt::format(
          "    {}\n", cache.user_file(*stages.entry(index), *stages.entry(index)->find(output.port), name).string());
  }
  return text;
}

}  // namespace meshmser
