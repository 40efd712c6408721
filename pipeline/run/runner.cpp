#include "pipeline/run/runner.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "pipeline/cache/file_publisher.hpp"
#include "pipeline/run/run_report.hpp"
#include "pipeline/run/stage_runner.hpp"

namespace meshmser {
namespace {

std::vector<bool> forced_stages(const Configuration& configuration, const RunOptions& options) {
  std::vector<bool> forced(configuration.stages.size(), options.force_all);
  for (const std::string& name : options.force) forced[stage_index(configuration, name, "--force")] = true;
  if (!options.from.empty())
    for (std::size_t i = stage_index(configuration, options.from, "--from"); i < forced.size(); ++i) forced[i] = true;
  return forced;
}

// Puts the files of a settled stage into the out folder; those of a stage with a name of its own into a folder of that
// name, so that two such stages do not write over each other.
std::vector<std::filesystem::path> publish(StageRunner& stages, std::size_t stage, const Configuration& configuration,
                                           Cache& cache, FilePublisher& publisher) {
  const StageEntry& named = configuration.stages[stage];
  const std::string folder = named.name == named.definition->info.name ? "" : named.name + "/";
  std::vector<std::filesystem::path> files;
  const Entry& entry = *stages.entry(stage);
  for (const EntryOutput& output : entry.outputs) {
    const std::size_t own = output.files.size() - output.user_files.size();
    for (std::size_t i = 0; i < output.user_files.size(); ++i) {
      const std::string name = folder + output.user_files[i];
      const std::filesystem::path from = cache.user_file(entry, output, output.user_files[i]);
      if (!publisher.copy(from, name, output.files[own + i].digest, cache.file_digests()))
        throw EntryDamaged(entry.stage, entry.key, from.string() + ": its content has changed");
      files.push_back(publisher.place(name));
    }
  }
  return files;
}

// A page tells of the whole run, which no stage knows: the run report goes behind it as the JSON of a script element.
// `<` is escaped, so that no name of a file can end that element.
void add_run_report(const std::filesystem::path& page, const std::string& report, FileSystem& disk,
                    FilePublisher& publisher, const std::filesystem::path& out) {
  std::string text = disk.read_text(page).value_or("");
  text += "<script type=\"application/json\" id=\"run\">";
  for (const char c : report)
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  text += "</script>\n";
  publisher.write(page.lexically_relative(out).string(), text);
}

}  // namespace

std::size_t stage_index(const Configuration& configuration, const std::string& name, const char* option) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < configuration.stages.size(); ++i) {
    if (configuration.stages[i].name == name) return i;
    names.push_back(configuration.stages[i].name);
  }
  const std::string nearest = nearest_name(name, names);
  throw UsageError(fmt::format("{}: {} has no stage '{}'{}", option, configuration.path, name,
                               nearest.empty() ? "" : ", did you mean '" + nearest + "'?"));
}

std::filesystem::path default_out_folder(const Configuration& configuration) {
  return std::filesystem::path(configuration.path).stem().string() + "-out";
}

std::filesystem::path default_cache_folder(const Configuration& configuration) {
  const auto variable = [](const char* name) -> std::filesystem::path {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  if (const auto named = variable("MESHMSER_CACHE"); !named.empty()) return named;
  const std::filesystem::path parent = std::filesystem::path(configuration.path).parent_path();
  const std::filesystem::path beside = (parent.empty() ? "." : parent) / ".meshmser-cache";
  if (::access(beside.c_str(), W_OK) == 0 || (errno == ENOENT && ::access(beside.parent_path().c_str(), W_OK) == 0))
    return beside;
  if (const auto caches = variable("XDG_CACHE_HOME"); !caches.empty()) return caches / "meshmser";
  if (const auto home = variable("HOME"); !home.empty()) return home / ".cache" / "meshmser";
  return beside;
}

RunResult run(const Configuration& configuration, const RunOptions& options, const Execution& execution,
              RunObserver& observer) {
  RunResult result;
  result.out = options.out.empty() ? default_out_folder(configuration) : std::filesystem::path(options.out);
  result.cache = options.cache.empty() ? default_cache_folder(configuration) : std::filesystem::path(options.cache);
  Cache cache(result.cache, options.disk != nullptr ? *options.disk : real_file_system());
  StageRunner stages(configuration, cache, forced_stages(configuration, options), execution, observer);
  std::vector<std::size_t> wanted(options.until.empty() ? configuration.stages.size()
                                                        : stage_index(configuration, options.until, "--until") + 1);
  std::iota(wanted.begin(), wanted.end(), std::size_t{0});
  if (!options.only.empty()) wanted = {stage_index(configuration, options.only, "--only")};

  const auto records = [&] {
    for (const std::size_t stage : wanted) result.stages.push_back(stages.record(stage));
    return result;
  };
  if (options.dry_run) {
    stages.judge(wanted);
    return records();
  }
  std::vector<std::filesystem::path> inputs = stages.input_files();
  inputs.emplace_back(configuration.path);
  FilePublisher publisher(cache.disk(), result.out, inputs);
  publisher.place("run.json");
  try {
    std::vector<std::vector<std::filesystem::path>> published;
    for (bool whole = false; !whole;) {
      if (options.only.empty())
        stages.settle(wanted);
      else
        stages.run_only(wanted.front());
      try {
        published.clear();
        for (const std::size_t stage : wanted)
          published.push_back(publish(stages, stage, configuration, cache, publisher));
        whole = true;
      } catch (const EntryDamaged& damage) {
        stages.mend(damage);
      }
    }
    records();
    for (std::size_t i = 0; i < wanted.size(); ++i) result.stages[i].files = std::move(published[i]);
  } catch (const Cancelled&) {
    std::string cached;
    for (const std::size_t stage : wanted)
      if (stages.entry(stage)) cached += (cached.empty() ? "" : ", ") + configuration.stages[stage].name;
    observer.note("interrupted; in the cache: " + (cached.empty() ? "nothing yet" : cached));
    throw;
  }
  if (options.only.empty()) {
    const std::string report = run_report(configuration, result, stages.digest_of_file(), execution);
    for (const StageRecord& stage : result.stages)
      for (const std::filesystem::path& file : stage.files)
        if (file.extension() == ".html") add_run_report(file, report, cache.disk(), publisher, result.out);
    publisher.write("run.json", report);
  }
  return result;
}

std::optional<std::pair<std::string, Artifact>> make_artifact(const Configuration& configuration, std::size_t type,
                                                              const RunOptions& options, const Execution& execution,
                                                              RunObserver& observer) {
  Cache cache(options.cache.empty() ? default_cache_folder(configuration) : std::filesystem::path(options.cache));
  StageRunner stages(configuration, cache, forced_stages(configuration, options), execution, observer);
  for (std::size_t i = configuration.stages.size(); i-- > 0;)
    for (const OutputPort& port : configuration.stages[i].definition->outputs) {
      const std::vector<std::string>& made = stages.plan().stages[i].outputs;
      if (port.type != type || std::find(made.begin(), made.end(), port.name) == made.end()) continue;
      const std::vector<std::size_t> wanted = stages.with_dependencies(i);
      for (;;) {
        stages.settle(wanted);
        try {
          return std::pair(configuration.stages[i].name, stages.artifact(i, port.name));
        } catch (const EntryDamaged& damage) {
          stages.mend(damage);
        }
      }
    }
  return std::nullopt;
}

}  // namespace meshmser
