#include "pipeline/cache/file_publisher.hpp"

#include <fmt/format.h>

namespace meshmser {

FilePublisher::FilePublisher(FileSystem& disk, std::filesystem::path out,
                             const std::vector<std::filesystem::path>& inputs)
    : disk_(disk), out_(std::move(out)) {
  for (const std::filesystem::path& input : inputs)
    if (const auto identity = disk_.identity(input)) inputs_[{identity->device, identity->inode}] = input;
}

std::filesystem::path FilePublisher::place(const std::string& name) {
  const std::filesystem::path path = out_ / name;
  const auto there = disk_.identity(path);
  if (!there) return path;
  const auto input = inputs_.find({there->device, there->inode});
  if (input != inputs_.end())
    throw UsageError(fmt::format("{} is an input of this run ({}) and would be overwritten; choose another --out",
                                 path.string(), input->second.string()));
  if (there->folder)
    throw CacheError(fmt::format("{} is a folder where a file is to be written; choose another --out", path.string()));
  return path;
}

bool FilePublisher::copy(const std::filesystem::path& from, const std::string& name, const std::string& digest,
                         FileDigests& file_digests) {
  const std::filesystem::path path = place(name);
  if (file_digests.digest(path) == digest) return true;
  if (!disk_.identity(from)) return false;
  disk_.create_folders(path.parent_path());
  const std::filesystem::path aside = place_aside(path);
  try {
    disk_.copy(from, aside);
    if (digest_of_file(disk_, aside) != digest) {
      disk_.remove(aside);
      return false;
    }
    disk_.sync(aside);
    if (!disk_.rename(aside, path)) throw CacheError(path.string() + ": cannot be put in place; choose another --out");
  } catch (const Error&) {
    try {
      disk_.remove(aside);
    } catch (const Error&) {  // the first failure is the one to tell
    }
    throw;
  }
  return true;
}

std::filesystem::path FilePublisher::write(const std::string& name, std::string_view text) {
  const std::filesystem::path path = place(name);
  disk_.create_folders(path.parent_path());
  disk_.write_atomically(path, text);
  return path;
}

}  // namespace meshmser
