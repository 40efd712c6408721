#pragma once
/// Puts finished files into the user's folder.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/cache/file_digests.hpp"
#include "pipeline/cache/file_system.hpp"

namespace meshmser {

/// Puts files into a folder, each written aside and renamed, never over a file that the run reads.
class FilePublisher {
 public:
  /// `inputs`: the files that must stay as they are.
  FilePublisher(FileSystem& disk, std::filesystem::path out, const std::vector<std::filesystem::path>& inputs);

  /// Copies `from` to `name` in the folder, unless a file with that content (SHA-256 `digest`) is there. Returns false,
  /// and leaves the folder as it was, where `from` has another content. Throws UsageError where an input is there.
  bool copy(const std::filesystem::path& from, const std::string& name, const std::string& digest,
            FileDigests& file_digests);
  /// Writes text to `name` in the folder; throws UsageError where an input is there.
  std::filesystem::path write(const std::string& name, std::string_view text);
  /// Throws UsageError where `name` in the folder is an input, under whatever path.
  std::filesystem::path place(const std::string& name);

 private:
  FileSystem& disk_;
  std::filesystem::path out_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::filesystem::path> inputs_;  ///< by device and inode
};

}  // namespace meshmser
