#include "pipeline/run/stage_runner.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/run/measure.hpp"

namespace meshmser {
namespace {

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text;
}

// A configuration is known by its file's name, so that it may move with its folder.
std::string configuration_name(const Configuration& configuration) {
  return std::filesystem::path(configuration.path).filename().string();
}

}  // namespace

StageRunner::StageRunner(const Configuration& configuration, Cache& cache, std::vector<bool> forced,
                         const Execution& execution, RunObserver& observer)
    : configuration_(configuration),
      cache_(cache),
      forced_(std::move(forced)),
      execution_(execution),
      observer_(observer),
      plan_(resolve_ports(configuration)),
      states_(configuration.stages.size()) {
  execution_.progress = [&observer](std::string_view what, std::int64_t done, std::int64_t total) {
    observer.progress(what, done, total);
  };
  for (std::size_t i = 0; i < states_.size(); ++i) {
    states_[i].record.name = configuration.stages[i].name;
    states_[i].record.stage = configuration.stages[i].definition->info.name;
  }
}

std::vector<std::filesystem::path> StageRunner::input_files() const {
  std::vector<std::filesystem::path> all;
  for (const StageEntry& stage : configuration_.stages) {
    const auto files = stage.definition->files(stage.parameters.get());
    all.insert(all.end(), files.begin(), files.end());
  }
  return all;
}

std::vector<std::size_t> StageRunner::with_dependencies(std::size_t stage) const {
  std::vector<bool> needed(states_.size(), false);
  needed[stage] = true;
  for (std::size_t i = stage + 1; i-- > 0;) {
    if (!needed[i]) continue;
    for (const PortBinding& binding : plan_.stages[i].inputs)
      for (const PortSource& source : binding.sources) needed[source.stage] = true;
  }
  std::vector<std::size_t> stages;
  for (std::size_t i = 0; i <= stage; ++i)
    if (needed[i]) stages.push_back(i);
  return stages;
}

// ---- Keys and reasons

std::vector<KeyFile> StageRunner::key_files(std::size_t stage) {
  const StageEntry& entry = configuration_.stages[stage];
  std::vector<KeyFile> files;
  states_[stage].file_identities.clear();
  for (const std::filesystem::path& path : entry.definition->files(entry.parameters.get())) {
    execution_.check();
    const auto identity = cache_.disk().identity(path);
    const auto digest = cache_.file_digests().digest(path);
    if (!identity || !digest) throw InputError(path.string() + ": no such file; check the path in the configuration");
    states_[stage].file_identities.push_back(*identity);
    digest_of_file_[path.string()] = *digest;
    files.push_back({path.filename().string(), *digest});
  }
  return files;
}

StageRunner::Keyed StageRunner::key_of(std::size_t stage) {
  const StageEntry& entry = configuration_.stages[stage];
  Keyed keyed;
  for (std::size_t p = 0; p < plan_.stages[stage].inputs.size(); ++p) {
    const PortBinding& binding = plan_.stages[stage].inputs[p];
    for (const PortSource& source : binding.sources) {
      const EntryOutput* output = states_[source.stage].entry->find(source.port);
      const std::string& name = configuration_.stages[source.stage].name;
      if (output == nullptr)
        throw StageError(fmt::format("stage '{}' did not make '{}', which '{}' takes", name, source.port, entry.name));
      keyed.inputs.push_back({binding.port, name, entry.definition->inputs[p].need == Need::kAll,
                              std::string(artifact_name(output->type)), output->digest});
    }
  }
  keyed.key = make_cache_key(*entry.definition, entry.parameters.get(), entry.name, configuration_.units,
                             key_files(stage), keyed.inputs);
  return keyed;
}

std::string StageRunner::reason_of_miss(std::size_t stage, const Keyed& keyed) {
  const std::string& name = configuration_.stages[stage].name;
  const auto last = cache_.last_key_text(configuration_name(configuration_), name);
  if (!last) return "never ran";
  const auto differences = explain_difference(*last, keyed.key.text, name, keyed.inputs);
  if (differences.empty()) return "no longer in the cache";
  return joined(differences);
}

std::vector<std::string> StageRunner::own_differences(std::size_t stage) const {
  const StageEntry& entry = configuration_.stages[stage];
  const auto last = cache_.last_key_text(configuration_name(configuration_), entry.name);
  if (!last) return {};
  const CacheKey now =
      make_cache_key(*entry.definition, entry.parameters.get(), entry.name, configuration_.units, {}, {});
  std::vector<std::string> reasons = explain_difference(*last, now.text, entry.name, {});
  // The key was made without files and inputs.
  std::erase_if(reasons, [](const std::string& reason) {
    return reason.ends_with(" is gone") && (reason.starts_with("input ") || reason.starts_with("file "));
  });
  return reasons;
}

std::optional<std::string> StageRunner::reason_to_run(std::size_t stage, const Keyed& keyed,
                                                      std::optional<Entry>& found) {
  if (forced_[stage] && !states_[stage].ran) return "forced";
  if (damaged_keys_.contains(keyed.key.digest) && !states_[stage].ran) return "entry damaged";
  found = cache_.find(states_[stage].record.stage, keyed.key.digest);
  if (found) return std::nullopt;
  return reason_of_miss(stage, keyed);
}

// ---- Settling

void StageRunner::settle(const std::vector<std::size_t>& stages) {
  wanted_ = stages;
  for (bool whole = false; !whole;) {
    whole = true;
    try {
      for (const std::size_t stage : stages) {
        execution_.check();
        if (!states_[stage].settled) settle_one(stage);
        free_artifacts(stage);
      }
    } catch (const EntryDamaged& damage) {
      mend(damage);
      whole = false;
    }
  }
}

void StageRunner::mend(const EntryDamaged& damage) {
  observer_.note(fmt::format("warning: {}; the entry is set aside and made again", damage.what()));
  cache_.set_aside(damage.stage, damage.key);
  damaged_keys_.insert(damage.key);
  for (State& state : states_)
    if (state.record.key == damage.key) state.ran = false;
  // Later stages have keys of its output: they are looked at again.
  bool after = false;
  for (State& state : states_) {
    after = after || state.record.key == damage.key;
    if (after) state.settled = false;
  }
}

void StageRunner::settle_one(std::size_t stage) {
  State& state = states_[stage];
  const Keyed keyed = key_of(stage);
  state.record.key = keyed.key.digest;
  std::optional<Entry> found;
  const auto reason = reason_to_run(stage, keyed, found);
  if (reason) {
    run(stage, keyed, *reason);
  } else {
    take(stage, std::move(*found));
  }
  cache_.remember_key_text(configuration_name(configuration_), configuration_.stages[stage].name, keyed.key.text);
  state.settled = true;
}

void StageRunner::take(std::size_t stage, Entry entry) {
  State& state = states_[stage];
  const bool told = state.ran;
  state.record.wall_seconds = entry.wall_seconds;
  state.record.cpu_seconds = entry.cpu_seconds;
  state.record.peak_bytes = entry.peak_bytes;
  state.record.warnings = entry.warnings;
  state.record.report = entry.report;
  state.record.outputs.clear();
  for (const EntryOutput& output : entry.outputs)
    state.record.outputs.push_back({output.port, std::string(artifact_name(output.type)), output.digest,
                                    cache_.output_folder(entry, output.port)});
  state.entry = std::move(entry);
  if (!told) {
    state.record.outcome = StageOutcome::kCached;
    state.record.reason.clear();
    observer_.stage_finished(state.record, stage, states_.size());
  }
}

void StageRunner::run(std::size_t stage, const Keyed& keyed, const std::string& reason) {
  const StageEntry& definition = configuration_.stages[stage];
  State& state = states_[stage];
  const auto fetch_inputs = [&] {
    Inputs inputs;
    for (const PortBinding& binding : plan_.stages[stage].inputs)
      for (const PortSource& source : binding.sources)
        inputs.add({binding.port, configuration_.stages[source.stage].name, artifact(source.stage, source.port)});
    return inputs;
  };
  state.record.outcome = StageOutcome::kRan;
  state.record.reason = reason;
  observer_.stage_started(state.record, stage, states_.size());
  const std::unique_ptr<Cache::Staging> staging = cache_.stage();
  RunContext context(execution_, Cache::scratch_folder(*staging), definition.name, configuration_.units);
  Entry entry;
  entry.stage = state.record.stage;
  entry.key = keyed.key.digest;
  const Measure measure;
  const Outputs outputs = definition.definition->run(definition.parameters.get(), fetch_inputs(), context);
  check_files_unchanged(stage);
  entry.warnings = context.warnings();
  entry.report = context.report_items();
  entry.wall_seconds = measure.wall_seconds();
  entry.cpu_seconds = measure.cpu_seconds();
  entry.peak_bytes = measure.peak_bytes();
  free_artifacts(stage);  // storing takes no more than the outputs
  bool replaced = false;
  cache_.store(entry, keyed.key.text, outputs, *staging, replaced, execution_.threads);
  if (replaced)
    observer_.note(fmt::format("warning: {}: made another result than before from the same inputs and parameters",
                               definition.name));
  state.artifacts.clear();
  for (const auto& [port, artifact] : outputs.items())
    if (!std::holds_alternative<Shared<FileSet>>(artifact)) state.artifacts.emplace(port, artifact);
  state.ran = true;
  take(stage, std::move(entry));
  observer_.stage_finished(state.record, stage, states_.size());
}

void StageRunner::check_files_unchanged(std::size_t stage) const {
  const StageEntry& entry = configuration_.stages[stage];
  const auto files = entry.definition->files(entry.parameters.get());
  const auto& before = states_[stage].file_identities;
  for (std::size_t i = 0; i < files.size(); ++i)
    if (i >= before.size() || cache_.disk().identity(files[i]) != before[i])
      throw InputError(files[i].string() + ": was written while it was read; run again when it is finished");
}

Artifact StageRunner::artifact(std::size_t stage, const std::string& port) {
  State& state = states_[stage];
  const auto found = state.artifacts.find(port);
  if (found != state.artifacts.end()) return found->second;
  Artifact loaded = cache_.load(*state.entry, port, execution_.threads);
  state.artifacts.emplace(port, loaded);
  return loaded;
}

void StageRunner::free_artifacts(std::size_t done) {
  std::vector<std::set<std::string>> needed(states_.size());
  for (const std::size_t stage : wanted_) {
    if (stage <= done) continue;
    for (const PortBinding& binding : plan_.stages[stage].inputs)
      for (const PortSource& source : binding.sources) needed[source.stage].insert(source.port);
  }
  for (std::size_t i = 0; i < states_.size(); ++i)
    std::erase_if(states_[i].artifacts, [&](const auto& item) { return !needed[i].contains(item.first); });
}

void StageRunner::run_only(std::size_t stage) {
  std::vector<std::size_t> before = with_dependencies(stage);
  before.pop_back();
  for (const std::size_t i : before) {
    const Keyed keyed = key_of(i);
    states_[i].record.key = keyed.key.digest;
    std::optional<Entry> found = cache_.find(states_[i].record.stage, keyed.key.digest);
    if (!found)
      throw CacheError(
          fmt::format("stage '{}', which '{}' depends on, is not in the cache ({}); run it first: "
                      "meshmser run {} --until {}",
                      configuration_.stages[i].name, configuration_.stages[stage].name, reason_of_miss(i, keyed),
                      configuration_.path, configuration_.stages[i].name));
    take(i, std::move(*found));
    states_[i].settled = true;
  }
  wanted_ = {stage};
  const Keyed keyed = key_of(stage);
  states_[stage].record.key = keyed.key.digest;
  run(stage, keyed, "asked for alone");
  cache_.remember_key_text(configuration_name(configuration_), configuration_.stages[stage].name, keyed.key.text);
  states_[stage].settled = true;
}

void StageRunner::judge(const std::vector<std::size_t>& stages) {
  cache_.file_digests().stop_remembering();
  for (const std::size_t stage : stages) {
    State& state = states_[stage];
    std::vector<std::string> open;  // inputs whose content is not known before their stage has run
    for (const PortBinding& binding : plan_.stages[stage].inputs)
      for (const PortSource& source : binding.sources)
        if (!states_[source.stage].entry)
          open.push_back(
              fmt::format("input {} of stage {} may change", binding.port, states_[source.stage].record.name));
    if (forced_[stage]) {
      state.record.outcome = StageOutcome::kWillRun;
      state.record.reason = "forced";
    } else if (!open.empty()) {
      state.record.outcome = StageOutcome::kMayRun;
      std::vector<std::string> reasons = own_differences(stage);
      reasons.insert(reasons.end(), open.begin(), open.end());
      state.record.reason = joined(reasons);
    } else {
      const Keyed keyed = key_of(stage);
      state.record.key = keyed.key.digest;
      std::optional<Entry> found;
      try {
        if (const auto reason = reason_to_run(stage, keyed, found)) {
          state.record.outcome = StageOutcome::kWillRun;
          state.record.reason = *reason;
        } else {
          take(stage, std::move(*found));
          continue;
        }
      } catch (const EntryDamaged&) {
        state.record.outcome = StageOutcome::kWillRun;
        state.record.reason = "entry damaged";
      }
    }
    observer_.stage_finished(state.record, stage, states_.size());
  }
}

}  // namespace meshmser
