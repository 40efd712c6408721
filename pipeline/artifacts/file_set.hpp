#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace meshmser {

/// Finished files for the user. The stage writes them into the folder its context gives; the runner keeps that folder in
/// the cache and publishes the files into the output folder.
struct FileSet {
  std::filesystem::path folder;     ///< where the files lie; not part of the content
  std::vector<std::string> names;   ///< in the order to be told to the user, relative to the folder

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("names", self.names);
  }
};

}  // namespace meshmser
