#pragma once
/// Runs a configuration: each stage's result is taken from the cache or made, files are published, and why is told.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/config/configuration.hpp"

namespace meshmser {

class FileSystem;

struct RunOptions {
  std::string out{};    ///< folder of the results; empty: default_out_folder
  std::string cache{};  ///< folder of the cache; empty: default_cache_folder
  std::string until{};  ///< the last stage to run; empty: all
  std::string from{};   ///< this stage and all after it run again, cached or not; empty: none
  std::string only{};   ///< runs this stage alone, its inputs taken from the cache; empty: none
  bool force_all = false;
  std::vector<std::string> force{};  ///< stages to run again, cached or not
  bool dry_run = false;              ///< tells what would run, runs and writes nothing
  FileSystem* disk = nullptr;        ///< nullptr: the disk itself; tests give one that fails
};

/// `<name of the configuration>-out` in the current folder.
std::filesystem::path default_out_folder(const Configuration& configuration);
/// $MESHMSER_CACHE where it is set; else `.meshmser-cache` beside the configuration, so that it moves with it; where
/// that folder cannot be written, `meshmser` in $XDG_CACHE_HOME (~/.cache).
std::filesystem::path default_cache_folder(const Configuration& configuration);

enum class StageOutcome {
  kCached,   ///< taken from the cache
  kRan,      ///< made in this run
  kWillRun,  ///< dry run: would be made
  kMayRun,   ///< dry run: would be made unless the stages before it make again what they made before
};

/// An artifact a stage made.
struct OutputRecord {
  std::string port;
  std::string type;
  std::string digest;            ///< SHA-256 of its content
  std::filesystem::path folder;  ///< where its files lie in the cache
};

/// What became of one stage.
struct StageRecord {
  std::string name;   ///< in the configuration
  std::string stage;  ///< of the stage's definition
  StageOutcome outcome = StageOutcome::kCached;
  std::string reason;       ///< why it ran or will run, from a closed list; empty where cached
  std::string key;          ///< of its cache entry; empty where unknown
  double wall_seconds = 0;  ///< of the run that made the result
  double cpu_seconds = 0;
  std::int64_t peak_bytes = 0;  ///< greatest resident memory of the process while it ran
  std::vector<std::string> warnings;
  std::vector<ReportItem> report;
  std::vector<OutputRecord> outputs;
  std::vector<std::filesystem::path> files;  ///< published into the out folder
};

struct RunResult {
  std::vector<StageRecord> stages;  ///< in the order of the configuration
  std::filesystem::path out;
  std::filesystem::path cache;
};

/// Hears of a run while it goes on. Called from one thread at a time, but `progress` from any.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  virtual void stage_started(const StageRecord& stage, std::size_t index, std::size_t count) = 0;
  virtual void progress(std::string_view what, std::int64_t done, std::int64_t total) = 0;
  /// Ran, cached or (dry run) judged.
  virtual void stage_finished(const StageRecord& stage, std::size_t index, std::size_t count) = 0;
  /// A sentence on the run itself: a damaged entry set aside, what is cached after an interruption.
  virtual void note(const std::string& message) = 0;
};

/// Runs a configuration. Stages are taken in their order; a stage whose key is in the cache is not run, its artifacts
/// are read only where a later stage that must run takes them, and freed when no later stage can. Writes the FileSets'
/// files and run.json into the out folder, each aside and renamed; never over an input of the configuration.
/// Throws UsageError for a stage that does not exist, what stages throw, CacheError where the disk fails, Cancelled
/// (after a note on what is cached). Results do not depend on threads.
RunResult run(const Configuration& configuration, const RunOptions& options, const Execution& execution,
              RunObserver& observer);

/// The artifact of that type (artifact_index) that a configuration makes last, and the name of the stage that makes it;
/// nothing where no stage makes one. Runs what is not in the cache up to that stage, publishes no file.
std::optional<std::pair<std::string, Artifact>> make_artifact(const Configuration& configuration, std::size_t type,
                                                              const RunOptions& options, const Execution& execution,
                                                              RunObserver& observer);

}  // namespace meshmser
