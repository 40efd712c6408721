#include "pipeline/config/configuration.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include "pipeline/config/diagnostics.hpp"
#include "pipeline/config/plan.hpp"
#include "pipeline/config/yaml.hpp"

namespace meshmser {
namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(word, known);
  return nearest.empty() ? "" : ", did you mean '" + nearest + "'?";
}

const ConfigValue* find_entry(const ConfigValue& map, std::string_view key) {
  for (const auto& [name, value] : map.entries)
    if (name == key) return &value;
  return nullptr;
}

bool is_name(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !text.empty() && is_letter(text.front()) && std::all_of(text.begin(), text.end(), [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

/// Binds one configuration; every problem is added to one list.
class Reader {
 public:
  explicit Reader(std::string path) { configuration_.path = std::move(path); }

  Configuration read(const std::string& text, const std::vector<std::string>& overrides) {
    ConfigValue root = read_yaml(text, configuration_.path, problems_);
    const bool is_map = root.kind == ConfigValue::Kind::kMap;
    if (is_map) {
      read_top(root);
      if (ConfigValue* stages = find_stages(root)) {
        outline(*stages);
        for (const std::string& argument : overrides) override_parameter(argument);
        for (Outline& stage : outlines_) bind(stage);
        check_names();
      }
    } else if (problems_.empty()) {
      const Location start{configuration_.path, 1, 1};
      problem(root.kind == ConfigValue::Kind::kNull ? start : root.location,
              "a configuration is a map with the keys version, units and stages");
    }
    Plan plan = plan_stages();
    problems_.insert(problems_.end(), plan.problems.begin(), plan.problems.end());
    if (!problems_.empty()) {
      sort_diagnostics(problems_);
      throw ConfigError(render_diagnostics(problems_, text));
    }
    if (plan.input_problem) throw *plan.input_problem;
    return std::move(configuration_);
  }

 private:
  // A stage of the file before its parameters are bound.
  struct Outline {
    const StageDefinition* definition = nullptr;
    std::string kind;  // the key, also where no stage is called so
    std::string name;
    Location location, name_location;
    ConfigValue given;  // the map without the reserved keys
    std::optional<ConfigValue> inputs;
    bool unsure = false;  // its parameters could not be bound
  };

  void problem(const Location& location, std::string message) { problems_.push_back({location, std::move(message)}); }

  void read_top(const ConfigValue& root) {
    static const std::vector<std::string> kKeys = {"version", "units", "stages"};
    for (std::size_t i = 0; i < root.entries.size(); ++i) {
      const std::string& key = root.entries[i].first;
      if (std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end()) continue;
      const bool is_stage = find_stage(key) != nullptr;
      problem(root.key_locations[i],
              "unknown key '" + key + "'" +
                  (is_stage ? "; it is a stage and belongs under 'stages:', as '- " + key + ": {...}'"
                            : ", a configuration has the keys version, units and stages" + suggestion(key, kKeys)));
    }
    const Location start{configuration_.path, 1, 1};
    if (const ConfigValue* version = find_entry(root, "version")) {
      if (version->kind != ConfigValue::Kind::kScalar || version->quoted || version->text != "1")
        problem(version->location, "this program reads configurations of 'version: 1'");
    } else {
      problem(start, "'version: 1' is missing");
    }
    if (find_entry(root, "stages") == nullptr) problem(start, "'stages:' is missing, the list of what is to be done");
    if (const ConfigValue* units = find_entry(root, "units")) read_units(*units);
  }

  void read_units(const ConfigValue& value) {
    static const std::vector<std::string> kUnits = {"mm", "um", "nm", "cm", "dm", "m", "km", "in", "ft", "unit"};
    configuration_.units = value.kind == ConfigValue::Kind::kScalar ? value.text : "";
    if (std::find(kUnits.begin(), kUnits.end(), configuration_.units) != kUnits.end()) return;
    problem(value.location, (value.kind == ConfigValue::Kind::kScalar ? "'" + value.text + "'" : std::string("this")) +
                                " is no unit of coordinates; known are " + listed(kUnits) +
                                " (unit: coordinates without a unit)");
    configuration_.units = "mm";  // so that one wrong word is one message
  }

  ConfigValue* find_stages(ConfigValue& root) {
    for (auto& [key, value] : root.entries)
      if (key == "stages") {
        if (value.kind == ConfigValue::Kind::kList && !value.items.empty()) return &value;
        problem(value.location, "'stages' must be a list of stages, as '- load: {path: scan.ply}'");
      }
    return nullptr;
  }

  void outline(ConfigValue& stages) {
    std::vector<std::string> known;
    for (const StageDefinition* stage : all_stages()) known.emplace_back(stage->info.name);
    for (ConfigValue& item : stages.items) {
      if (item.kind == ConfigValue::Kind::kScalar) {
        problem(item.location, find_stage(item.text) != nullptr
                                   ? "stage '" + item.text + "' stands without a map, write '" + item.text + ": {}'"
                                   : "'" + item.text + "' is not a stage, expected '- STAGE: {key: value, ...}'" +
                                         suggestion(item.text, known));
        continue_with_unknown(item.text, item.location);
        continue;
      }
      if (item.kind != ConfigValue::Kind::kMap || item.entries.empty()) {
        problem(item.location, "expected a stage, as '- load: {path: scan.ply}'");
        continue_with_unknown("", item.location);
        continue;
      }
      if (item.entries.size() > 1)
        problem(item.key_locations[1], "a second key '" + item.entries[1].first + "' in one entry of 'stages'; " +
                                           (find_stage(item.entries[1].first) != nullptr
                                                ? "each stage begins with its own '-'"
                                                : "parameters stand deeper than the stage's name or in its {}"));
      Outline stage;
      stage.kind = item.entries[0].first;
      stage.name = stage.kind;
      stage.location = item.key_locations[0];
      stage.name_location = stage.location;
      stage.definition = find_stage(stage.kind);
      stage.given = std::move(item.entries[0].second);
      if (stage.definition == nullptr) {
        const std::string nearest = suggestion(stage.kind, known);
        problem(stage.location,
                "unknown stage '" + stage.kind + "'" + (nearest.empty() ? "; stages are " + listed(known) : nearest));
      }
      take_reserved(stage);
      outlines_.push_back(std::move(stage));
    }
  }

  void continue_with_unknown(const std::string& kind, const Location& location) {
    Outline stage;
    stage.kind = kind;
    stage.name = kind;
    stage.definition = find_stage(kind);
    stage.location = stage.name_location = location;
    stage.unsure = true;
    outlines_.push_back(std::move(stage));
  }

  // Takes `name` and `inputs` out of the map.
  void take_reserved(Outline& stage) {
    ConfigValue& map = stage.given;
    if (map.kind != ConfigValue::Kind::kMap) return;
    ConfigValue rest = map;
    rest.entries.clear();
    rest.key_locations.clear();
    for (std::size_t i = 0; i < map.entries.size(); ++i) {
      auto& [key, value] = map.entries[i];
      if (key == "name") {
        if (value.kind == ConfigValue::Kind::kScalar && is_name(value.text)) {
          stage.name = value.text;
          stage.name_location = value.location;
        } else {
          problem(value.location, "the name of a stage is a letter and then letters, digits, '_' or '-'");
        }
      } else if (key == "inputs") {
        stage.inputs = std::move(value);
      } else {
        rest.entries.push_back(std::move(map.entries[i]));
        rest.key_locations.push_back(map.key_locations[i]);
      }
    }
    map = std::move(rest);
  }

  // --set stage.key=value, also stage.key.inner=value for a parameter that is a map.
  void override_parameter(const std::string& argument) {
    const Location location{"--set " + argument, 0, 0};
    const std::size_t equals = argument.find('=');
    const std::size_t dot = argument.substr(0, equals).find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 == equals)
      return problem(location, "expected stage.key=value");
    const std::string name = argument.substr(0, dot);
    std::vector<std::string> names;
    for (const Outline& stage : outlines_) names.push_back(stage.name);
    const auto stage =
        std::find_if(outlines_.begin(), outlines_.end(), [&](const Outline& s) { return s.name == name; });
    if (stage == outlines_.end())
      return problem(location,
                     "no stage of this configuration is called '" + name + "'" +
                         (nearest_name(name, names).empty() ? "; they are " + listed(names) : suggestion(name, names)));
    if (stage->definition == nullptr) return;
    const std::string keys = argument.substr(dot + 1, equals - dot - 1);
    if (keys == "name" || keys == "inputs") return problem(location, "'" + keys + "' can only be given in the file");
    const std::size_t before = problems_.size();
    ConfigValue value = read_argument_value(argument.substr(equals + 1), location.file, problems_);
    if (problems_.size() > before) return;
    if (stage->given.kind == ConfigValue::Kind::kNull) {
      stage->given.kind = ConfigValue::Kind::kMap;
      stage->given.location = location;
    }
    if (stage->given.kind == ConfigValue::Kind::kMap) put(stage->given, keys, std::move(value), location);
  }

  static void put(ConfigValue& map, const std::string& keys, ConfigValue value, const Location& location) {
    const std::size_t dot = keys.find('.');
    const std::string key = keys.substr(0, dot);
    auto entry = std::find_if(map.entries.begin(), map.entries.end(), [&](const auto& e) { return e.first == key; });
    if (entry == map.entries.end()) {
      map.entries.emplace_back(key, ConfigValue{});
      map.key_locations.push_back(location);
      entry = map.entries.end() - 1;
    }
    if (dot == std::string::npos) {
      map.key_locations[static_cast<std::size_t>(entry - map.entries.begin())] = location;
      entry->second = std::move(value);
      return;
    }
    if (entry->second.kind != ConfigValue::Kind::kMap) {
      entry->second = ConfigValue{};
      entry->second.kind = ConfigValue::Kind::kMap;
      entry->second.location = location;
    }
    put(entry->second, keys.substr(dot + 1), std::move(value), location);
  }

  void bind(Outline& stage) {
    StageEntry entry;
    entry.name = stage.name;
    entry.definition = stage.definition;
    entry.location = stage.location;
    if (stage.definition != nullptr) {
      entry.parameters = stage.definition->make_parameters();
      const std::size_t before = problems_.size();
      bind_parameters(stage, entry.parameters.get());
      if (problems_.size() > before) stage.unsure = true;
    }
    if (stage.inputs) read_inputs(*stage.inputs, entry);
    configuration_.stages.push_back(std::move(entry));
  }

  void bind_parameters(const Outline& stage, void* target) {
    const std::string base = std::filesystem::path(configuration_.path).parent_path().string();
    const BindContext context{configuration_.units, base};
    const std::size_t before = problems_.size();
    bind_map(stage.given, stage.definition->parameters, context, "stage '" + stage.kind + "'", target, problems_);
    if (problems_.size() > before) return;
    for (const auto& [key, message] : stage.definition->check(target)) {
      Location location = stage.location;
      for (std::size_t i = 0; i < stage.given.entries.size(); ++i)
        if (stage.given.entries[i].first == key) location = stage.given.entries[i].second.location;
      problem(location, stage.name + "." + key + ": " + message);
    }
  }

  // {port: stage, port: [stage, stage]}; whether they exist is for the plan to say.
  void read_inputs(const ConfigValue& map, StageEntry& entry) {
    if (map.kind != ConfigValue::Kind::kMap)
      return problem(map.location, "'inputs' is not a map, expected {input: stage, ...}");
    const auto add = [&](const std::string& port, const ConfigValue& value) {
      if (value.kind != ConfigValue::Kind::kScalar)
        return problem(value.location, "input '" + port + "' is given by a stage's name");
      entry.inputs.emplace_back(port, value.text);
      entry.input_locations.push_back(value.location);
    };
    for (const auto& [port, value] : map.entries) {
      if (value.kind == ConfigValue::Kind::kList)
        for (const ConfigValue& item : value.items) add(port, item);
      else
        add(port, value);
    }
  }

  void check_names() {
    for (std::size_t i = 0; i < outlines_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (outlines_[i].name == outlines_[j].name && !outlines_[i].name.empty()) {
          problem(outlines_[i].name_location,
                  "a second stage is called '" + outlines_[i].name + "' (the first in line " +
                      std::to_string(outlines_[j].name_location.line) + "); give one another name, as '- " +
                      outlines_[i].kind + ": {name: fine, ...}'");
          break;
        }
  }

  Plan plan_stages() const {
    std::vector<char> unsure;
    for (const Outline& stage : outlines_) unsure.push_back(stage.unsure);
    return resolve_ports(configuration_, unsure);
  }

  Configuration configuration_;
  std::vector<Diagnostic> problems_;
  std::vector<Outline> outlines_;
};

}  // namespace

Configuration parse_configuration(const std::string& text, const std::string& path,
                                  const std::vector<std::string>& overrides) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  return Reader(path).read(text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text, overrides);
}

Configuration load_configuration(const std::string& path, const std::vector<std::string>& overrides) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw ConfigError(path + ": a folder, expected a configuration file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw ConfigError(path + ": cannot be opened: " + std::strerror(errno));
  // One byte more than allowed is enough to see that it is too large.
  std::string text(kMaxConfigBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw ConfigError(path + ": cannot be read: " + std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_configuration(text, path, overrides);
}

}  // namespace meshmser
