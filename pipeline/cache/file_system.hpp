#pragma once
/// The few calls through which the cache touches the disk, so that a test can make any of them fail.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/execution/error.hpp"

namespace meshmser {

/// What tells that a file has not been written since it was looked at before.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;
  bool folder = false;
  bool operator==(const FileIdentity&) const = default;
};

/// A lock that ends with the process that holds it, however that ends.
class FileLock {
 public:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

 private:
  int descriptor_;
};

/// A file open for reading.
class ReadableFile {
 public:
  virtual ~ReadableFile() = default;
  virtual std::uint64_t size() const = 0;
  /// Fills `to` from `offset` on; throws CacheError where the file ends before.
  virtual void read(std::uint64_t offset, std::span<std::byte> to) const = 0;
};

/// The disk. Every call throws CacheError, naming the file and the reason, unless it says otherwise. A class derived
/// from it in tests makes chosen calls fail.
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  /// Makes a folder and those above it; no error where it is there.
  virtual void create_folders(const std::filesystem::path& folder);
  /// Writes a new file; an error where one is there. Not yet safe from a loss of power.
  virtual void write(const std::filesystem::path& path, std::span<const std::span<const std::byte>> pieces);
  /// Makes a file's content, or a folder's list of names, safe from a loss of power.
  virtual void sync(const std::filesystem::path& path);
  /// Moves a file over another, or a folder to a place that is free or an empty folder. Returns false where the place
  /// is taken by a folder that is not empty, or `from` is not there.
  virtual bool rename(const std::filesystem::path& from, const std::filesystem::path& to);
  /// Removes a file or a folder with all in it; no error where nothing is there.
  virtual void remove(const std::filesystem::path& path);
  /// Copies a file to a place that is free.
  virtual void copy(const std::filesystem::path& from, const std::filesystem::path& to);
  /// nullptr where there is no such file.
  virtual std::unique_ptr<ReadableFile> open(const std::filesystem::path& path);
  /// Names in a folder, sorted; empty where it is not there.
  virtual std::vector<std::string> list(const std::filesystem::path& folder);
  /// Nothing where there is no such file.
  virtual std::optional<FileIdentity> identity(const std::filesystem::path& path);
  /// Sets a file's time of modification to now; quiet where that fails.
  virtual void touch(const std::filesystem::path& path);
  /// Takes the lock of a file, which is made where it is not there; nullptr where another holds it.
  virtual std::unique_ptr<FileLock> try_lock(const std::filesystem::path& path);

  /// The whole of a small file as text; nothing where it is not there.
  std::optional<std::string> read_text(const std::filesystem::path& path);
  /// Writes a file aside, syncs it and moves it into place, so that whoever reads it finds the old or the new one.
  void write_atomically(const std::filesystem::path& path, std::string_view text);
};

/// A name that no other process and no other call gives, on this machine and on others that share the disk.
std::string unique_name();

/// A hidden name in the folder of `path` for what will be moved to it when it is whole.
std::filesystem::path place_aside(const std::filesystem::path& path);

/// The disk itself.
FileSystem& real_file_system();

inline std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span<const char>(text.data(), text.size()));
}

}  // namespace meshmser
