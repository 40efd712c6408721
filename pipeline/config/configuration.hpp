#pragma once
/// A configuration, read and checked: what the runner works with.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/stage/config_value.hpp"
#include "pipeline/stage/stage.hpp"

namespace meshmser {

/// One entry of `stages`.
struct StageEntry {
  std::string name;  ///< the reserved key `name`, else the stage's own name
  const StageDefinition* definition = nullptr;
  std::shared_ptr<void> parameters;                         ///< of the stage's own type, bound and checked
  Location location;                                        ///< of the stage's key in the file
  std::vector<std::pair<std::string, std::string>> inputs;  ///< the reserved key `inputs`: port -> name of a stage
  std::vector<Location> input_locations;                    ///< one per pair of `inputs`
};

struct Configuration {
  std::string path;            ///< as given
  std::string units = "unit";  ///< of the coordinates
  std::vector<StageEntry> stages;
};

/// Reads a configuration and the arguments of --set (`stage.key=value`), binds every parameter and resolves every
/// port. Throws a ConfigError that holds every error of the whole file, rendered; where the configuration alone is
/// right, an InputError when a stage must look at the head of an input to know what it will make, and cannot.
Configuration load_configuration(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same from text; `path` names it in messages, and its folder is what relative paths begin at.
Configuration parse_configuration(const std::string& text, const std::string& path,
                                  const std::vector<std::string>& overrides = {});

}  // namespace meshmser
