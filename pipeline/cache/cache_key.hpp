#pragma once
/// What a stage's result depends on, as text that a person can read and compare.

#include <string>
#include <vector>

#include "pipeline/stage/stage.hpp"

namespace meshmser {

/// An artifact plugged into a port, by its content.
struct KeyInput {
  std::string port;
  std::string stage;          ///< name in the configuration of the stage that made it
  bool name_matters = false;  ///< of a port that takes all: the stage finds artifacts there by that name
  std::string type;
  std::string digest;
};

/// An input file, by its content.
struct KeyFile {
  std::string name;  ///< without folder
  std::string digest;
};

struct CacheKey {
  std::string text;
  std::string digest;  ///< SHA-256 of the text
};

/// The key of a stage: its name and version, the build's floating mode, its name in the configuration and the unit of
/// the coordinates (a stage sees both), every parameter that changes the result, files and inputs by content. One line
/// each, words quoted, so that no two different stages have the same text. No paths, times, hosts or threads.
CacheKey make_cache_key(const StageDefinition& definition, const void* parameters, const std::string& stage_name,
                        const std::string& units, const std::vector<KeyFile>& files,
                        const std::vector<KeyInput>& inputs);

/// What differs between the text of the key a stage had before and that it has now, in a user's words:
/// "orient.neighbors 12 -> 20", "input file tablet.ply changed", "input cloud of stage load changed", "stage version
/// 1 -> 2" ... ; empty: nothing does.
std::vector<std::string> explain_difference(const std::string& before, const std::string& now,
                                            const std::string& stage_name, const std::vector<KeyInput>& inputs);

/// The floating mode of this build: results of different modes are not mixed.
std::string build_mode();

}  // namespace meshmser
