#pragma once
/// Commands of the program that need a stage's knowledge (init, render, why): the stage registers them, the command
/// line finds them here.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/stage/stage.hpp"

namespace meshmser {

/// A run that a command asks for.
struct RunRequest {
  std::string config_path;
  std::vector<std::string> set{};
  std::string out{}, cache{};  ///< folders; empty: as `meshmser run` chooses them
  std::string last_stage{};    ///< added at the end where the configuration has no stage of that kind
  bool quiet = false;          ///< tells only warnings
};

/// What a command may ask of the pipeline: a configuration's artifacts, taken from the cache or made.
class CommandHost {
 public:
  virtual ~CommandHost() = default;
  /// The last artifact of that type (artifact_index) that the configuration makes, running what is not in the cache;
  /// nothing where no stage of the configuration makes one. Runs no stage after the one that makes it.
  virtual std::optional<Artifact> artifact(const std::string& config_path, const std::vector<std::string>& set,
                                           std::size_t type) = 0;
  /// The parameters (of the stage's own type) of the last stage of that kind; nullptr: the configuration has none.
  virtual std::shared_ptr<const void> parameters(const std::string& config_path, const std::vector<std::string>& set,
                                                 const std::string& stage) = 0;
  /// Runs a configuration and tells of it as `meshmser run` does; the files that its stages of the kind `last_stage`
  /// published.
  virtual std::vector<std::filesystem::path> run(const RunRequest& request) = 0;
  /// The unit of the configuration's coordinates.
  virtual std::string units(const std::string& config_path) = 0;
  virtual const Execution& execution() const = 0;
};

struct CommandOption {
  std::string name;  ///< "--view"; a positional argument has no dashes and is upper case: "MESH"
  std::string description;
  bool required = false;
  bool repeated = false;
  bool flag = false;                      ///< takes no value
  bool optional_value = false;            ///< may stand without a value; then "" is given
  std::vector<std::string> choices = {};  ///< where not empty: the only values
};

/// --set and --cache, alike for all commands that read a configuration's results.
CommandOption set_option();
CommandOption cache_option();

/// The values given for each option, by name.
struct CommandArguments {
  std::vector<std::pair<std::string, std::vector<std::string>>> values;
  const std::vector<std::string>* find(const std::string& name) const {
    for (const auto& [key, given] : values)
      if (key == name && !given.empty()) return &given;
    return nullptr;
  }
  std::string get(const std::string& name, const std::string& otherwise = "") const {
    const auto* given = find(name);
    return given ? given->front() : otherwise;
  }
};

struct CommandDefinition {
  std::string name;
  std::string purpose;  ///< one sentence
  std::vector<CommandOption> options;
  /// Writes results to stdout, messages to stderr; returns the exit code; may throw Error.
  std::function<int(const CommandArguments&, CommandHost&)> run;
  std::string example = {};  ///< a command line that works; ends the help text
};

bool register_command(CommandDefinition definition);
/// All registered commands, by name.
std::vector<const CommandDefinition*> all_commands();

#define MESHMSER_COMMAND(Name, definition) \
  [[maybe_unused]] static const bool registered_command_##Name = ::meshmser::register_command(definition)

}  // namespace meshmser
