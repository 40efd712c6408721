#pragma once
#include <filesystem>
#include <string>

#include "pipeline/cache/file_system.hpp"

namespace meshmser {

/// SHA-256 of files, remembered as long as a file's identity (inode, size, times) stays what it was, so that unchanged
/// inputs are not read again.
class FileDigests {
 public:
  /// `folder`: where digests are remembered, one small file each; empty: nowhere.
  FileDigests(FileSystem& disk, std::filesystem::path folder) : disk_(disk), folder_(std::move(folder)) {}

  /// Digest of a file; nothing where there is none. Throws CacheError where it cannot be read or is written meanwhile.
  std::optional<std::string> digest(const std::filesystem::path& path);
  /// From now on nothing is written.
  void stop_remembering() { remember_ = false; }

 private:
  FileSystem& disk_;
  std::filesystem::path folder_;
  bool remember_ = true;
};

/// SHA-256 of a file's content.
std::string digest_of_file(FileSystem& disk, const std::filesystem::path& path);

}  // namespace meshmser
