#pragma once
/// Stages of one configuration, each taken from the cache or run, on demand.

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/cache/cache.hpp"
#include "pipeline/cache/cache_key.hpp"
#include "pipeline/config/plan.hpp"
#include "pipeline/run/runner.hpp"

namespace meshmser {

/// Index of the stage of that name; throws UsageError, with the nearest name, where there is none. `option`: who asks.
std::size_t stage_index(const Configuration& configuration, const std::string& name, const char* option);

/// Decides and runs. Every decision to run records its reason in the branch that takes it.
class StageRunner {
 public:
  /// `forced`: of each stage, whether it runs again even where it is cached.
  StageRunner(const Configuration& configuration, Cache& cache, std::vector<bool> forced, const Execution& execution,
              RunObserver& observer);

  const Plan& plan() const { return plan_; }
  /// Files that the configuration's stages read.
  std::vector<std::filesystem::path> input_files() const;
  /// SHA-256 of each input file read so far, by path.
  const std::map<std::string, std::string>& digest_of_file() const { return digest_of_file_; }

  /// Settles the stages: from the cache, else by running. `stages` are indices in ascending order that hold all they
  /// depend on. Artifacts that no later stage of them takes are freed.
  void settle(const std::vector<std::size_t>& stages);
  /// Settles a stage by running it, whether it is cached or not, with inputs from the cache alone. Throws CacheError
  /// that names the remedy where an input is not cached.
  void run_only(std::size_t stage);
  /// What settle would do; runs and writes nothing.
  void judge(const std::vector<std::size_t>& stages);

  /// Artifact of a settled stage, from memory or the cache.
  Artifact artifact(std::size_t stage, const std::string& port);
  const StageRecord& record(std::size_t stage) const { return states_[stage].record; }
  const std::optional<Entry>& entry(std::size_t stage) const { return states_[stage].entry; }
  /// Sets a damaged entry aside and says so; its stage, and those after it, are to be settled again.
  void mend(const EntryDamaged& damage);

  /// The stage and all it depends on, ascending.
  std::vector<std::size_t> with_dependencies(std::size_t stage) const;

 private:
  struct State {
    StageRecord record;
    bool settled = false;
    bool ran = false;  ///< in this process: a second settling finds it in the cache and keeps the record
    std::optional<Entry> entry;
    std::map<std::string, Artifact> artifacts;  ///< by port, those in memory
    std::vector<FileIdentity> file_identities;  ///< of the input files when the key was made
  };
  struct Keyed {
    CacheKey key;
    std::vector<KeyInput> inputs;
  };

  std::vector<KeyFile> key_files(std::size_t stage);
  /// The key, where all inputs are settled.
  Keyed key_of(std::size_t stage);
  std::optional<std::string> reason_to_run(std::size_t stage, const Keyed& keyed, std::optional<Entry>& found);
  /// What changed since last time beside files and inputs.
  std::vector<std::string> own_differences(std::size_t stage) const;
  std::string reason_of_miss(std::size_t stage, const Keyed& keyed);
  void settle_one(std::size_t stage);
  void take(std::size_t stage, Entry entry);
  void run(std::size_t stage, const Keyed& keyed, const std::string& reason);
  void check_files_unchanged(std::size_t stage) const;
  void free_artifacts(std::size_t done);

  const Configuration& configuration_;
  Cache& cache_;
  std::vector<bool> forced_;
  Execution execution_;
  RunObserver& observer_;
  Plan plan_;
  std::vector<State> states_;
  std::vector<std::size_t> wanted_;  ///< stages being settled
  std::map<std::string, std::string> digest_of_file_;
  std::set<std::string> damaged_keys_;
};

}  // namespace meshmser
