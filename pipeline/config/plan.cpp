#include "pipeline/config/plan.hpp"

#include <algorithm>
#include <string_view>

namespace meshmser {
namespace {

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(word, known);
  return nearest.empty() ? "" : ", did you mean '" + nearest + "'?";
}

/// Resolves the ports of one configuration, stage by stage.
class Planner {
 public:
  Planner(const Configuration& configuration, const std::vector<char>& unsure)
      : stages_(configuration.stages), unsure_(unsure) {}

  Plan run() {
    plan_.stages.resize(stages_.size());
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (stages_[i].definition == nullptr) {
        anything_before_ = true;
        continue;
      }
      plan_.stages[i].outputs = outputs_of(i);
      check_input_names(i);
      for (const InputPort& port : stages_[i].definition->inputs) plan_.stages[i].inputs.push_back(bind(i, port));
    }
    return std::move(plan_);
  }

 private:
  bool is_unsure(std::size_t stage) const { return stage < unsure_.size() && unsure_[stage] != 0; }

  std::vector<std::string> outputs_of(std::size_t stage) {
    const StageDefinition& definition = *stages_[stage].definition;
    std::vector<std::string> all;
    for (const OutputPort& port : definition.outputs) all.push_back(port.name);
    if (is_unsure(stage)) return all;
    try {
      return definition.made_outputs(stages_[stage].parameters.get());
    } catch (const InputError& error) {
      if (!plan_.input_problem) plan_.input_problem = error;
      return all;
    }
  }

  // The first port of that type that the stage will make.
  std::optional<PortSource> made_by(std::size_t stage, std::size_t type) const {
    if (stages_[stage].definition == nullptr) return std::nullopt;
    const std::vector<std::string>& made = plan_.stages[stage].outputs;
    for (const OutputPort& port : stages_[stage].definition->outputs)
      if (port.type == type && std::find(made.begin(), made.end(), port.name) != made.end())
        return PortSource{stage, port.name};
    return std::nullopt;
  }

  std::optional<std::size_t> index_of(std::string_view name) const {
    for (std::size_t i = 0; i < stages_.size(); ++i)
      if (stages_[i].name == name) return i;
    return std::nullopt;
  }

  void check_input_names(std::size_t stage) {
    const StageEntry& entry = stages_[stage];
    std::vector<std::string> ports;
    for (const InputPort& port : entry.definition->inputs) ports.push_back(port.name);
    for (std::size_t k = 0; k < entry.inputs.size(); ++k) {
      const std::string& port = entry.inputs[k].first;
      const auto known = std::find(ports.begin(), ports.end(), port);
      if (known == ports.end()) {
        std::string list;
        for (const std::string& name : ports) list += (list.empty() ? "" : ", ") + name;
        const std::string nearest = suggestion(port, ports);
        problem(entry.input_locations[k], "stage '" + entry.name + "' has no input '" + port + "'" +
                                              (!nearest.empty() ? nearest
                                               : list.empty()   ? "; it has none"
                                                                : "; its inputs are " + list));
        continue;
      }
      const bool takes_all =
          entry.definition->inputs[static_cast<std::size_t>(known - ports.begin())].need == Need::kAll;
      const bool repeated = k > 0 && entry.inputs[k - 1].first == port;
      if (repeated && !takes_all) problem(entry.input_locations[k], "input '" + port + "' takes one stage only");
    }
  }

  PortBinding bind(std::size_t stage, const InputPort& port) {
    const StageEntry& entry = stages_[stage];
    PortBinding binding{port.name, {}};
    bool named = false;
    for (std::size_t k = 0; k < entry.inputs.size(); ++k)
      if (entry.inputs[k].first == port.name) {
        named = true;
        if (const auto source = named_source(stage, port, k)) binding.sources.push_back(*source);
      }
    if (named) {
      std::sort(binding.sources.begin(), binding.sources.end(),
                [](const PortSource& a, const PortSource& b) { return a.stage < b.stage; });
      return binding;
    }
    for (std::size_t i = stage; i-- > 0;)
      if (const auto source = made_by(i, port.type)) {
        binding.sources.insert(binding.sources.begin(), *source);
        if (port.need != Need::kAll) break;
      }
    if (port.need == Need::kAll && !is_unsure(stage)) narrow(stage, binding);
    if (binding.sources.empty() && port.need == Need::kRequired && !anything_before_) report_missing(stage, port);
    return binding;
  }

  std::optional<PortSource> named_source(std::size_t stage, const InputPort& port, std::size_t k) {
    const StageEntry& entry = stages_[stage];
    const std::string& name = entry.inputs[k].second;
    const auto source = index_of(name);
    if (!source) {
      std::vector<std::string> earlier;
      for (std::size_t i = 0; i < stage; ++i) earlier.push_back(stages_[i].name);
      problem(entry.input_locations[k], "no stage is called '" + name + "'" + suggestion(name, earlier));
    } else if (*source >= stage) {
      problem(entry.input_locations[k], *source == stage ? "stage '" + name + "' cannot be its own input"
                                                         : "stage '" + name + "' stands after '" + entry.name +
                                                               "'; a stage is given what earlier ones made");
    } else if (const auto made = made_by(*source, port.type)) {
      return made;
    } else if (stages_[*source].definition != nullptr) {
      problem(entry.input_locations[k], "stage '" + name + "' makes no " + std::string(artifact_name(port.type)) +
                                            ", which input '" + port.name + "' of stage '" + entry.name + "' needs");
    }
    return std::nullopt;
  }

  // Leaves those of a kAll port's sources that the stage chooses.
  void narrow(std::size_t stage, PortBinding& binding) {
    const StageEntry& entry = stages_[stage];
    std::vector<std::string> available;
    for (const PortSource& source : binding.sources) available.push_back(stages_[source.stage].name);
    const std::vector<std::string> chosen = entry.definition->choose(entry.parameters.get(), binding.port, available);
    std::erase_if(binding.sources, [&](const PortSource& source) {
      return std::find(chosen.begin(), chosen.end(), stages_[source.stage].name) == chosen.end();
    });
    for (const std::string& name : chosen)
      if (std::find(available.begin(), available.end(), name) == available.end() && !anything_before_)
        problem(entry.location, "stage '" + entry.name + "' names stage '" + name + "', but no earlier one of that " +
                                    "name makes its input '" + binding.port + "'" + suggestion(name, available));
  }

  void report_missing(std::size_t stage, const InputPort& port) {
    const StageEntry& entry = stages_[stage];
    // Later stages that miss the same are not the cause.
    if (std::find(missing_.begin(), missing_.end(), port.type) != missing_.end()) return;
    missing_.push_back(port.type);
    std::string message = "no stage before '" + entry.name + "' makes its input '" + port.name + "' (" +
                          std::string(artifact_name(port.type)) + ")";
    for (std::size_t i = stage + 1; i < stages_.size(); ++i)
      if (made_by_kind(stages_[i].definition, port.type))
        return problem(entry.location, message + "; '" + stages_[i].name + "' stands after it");
    std::vector<const StageDefinition*> tried;
    for (std::size_t i = 0; i < stage; ++i)
      if (made_by_kind(stages_[i].definition, port.type)) {
        tried.push_back(stages_[i].definition);
        std::string files;
        for (const std::filesystem::path& file : stages_[i].definition->files(stages_[i].parameters.get()))
          files += (files.empty() ? " in " : ", ") + file.filename().string();
        message += (tried.size() == 1 ? ": '" : ", '") + stages_[i].name + "' finds none" + files;
      }
    std::string makers;
    for (const StageDefinition* definition : all_stages())
      if (definition != entry.definition && made_by_kind(definition, port.type) &&
          std::find(tried.begin(), tried.end(), definition) == tried.end()) {
        makers += makers.empty() ? "'" : " or '";
        makers.append(definition->info.name).append("'");
      }
    problem(entry.location, makers.empty() ? message : message + "; " + makers + " can");
  }

  static bool made_by_kind(const StageDefinition* definition, std::size_t type) {
    return definition != nullptr && std::any_of(definition->outputs.begin(), definition->outputs.end(),
                                                [&](const OutputPort& port) { return port.type == type; });
  }

  void problem(const Location& location, std::string message) {
    plan_.problems.push_back({location, std::move(message)});
  }

  const std::vector<StageEntry>& stages_;
  const std::vector<char>& unsure_;
  std::vector<std::size_t> missing_;  // types of artifacts that were told to be missing
  bool anything_before_ = false;      // a stage that is not known stands before and may make whatever is missing
  Plan plan_;
};

}  // namespace

Plan resolve_ports(const Configuration& configuration, const std::vector<char>& unsure) {
  return Planner(configuration, unsure).run();
}

}  // namespace meshmser
