#pragma once
/// Results of stages on the disk, by key. See README.md for the folder's layout and what it survives.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/cache/file_digests.hpp"
#include "pipeline/cache/file_system.hpp"
#include "pipeline/stage/stage.hpp"

namespace meshmser {

/// A file of an entry, relative to the entry's folder.
struct EntryFile {
  std::string name;
  std::uint64_t size = 0;
  std::string digest;
};

/// An artifact of an entry.
struct EntryOutput {
  std::string port;
  std::size_t type = 0;  ///< artifact_index
  std::string digest;    ///< of its content
  std::vector<EntryFile> files;
  std::vector<std::string> user_files;  ///< of a FileSet: names, in the stage's order
};

/// What an entry tells of itself, without its artifacts.
struct Entry {
  std::string stage;  ///< of the definition
  std::string key;
  double wall_seconds = 0, cpu_seconds = 0;
  std::int64_t peak_bytes = 0;
  std::vector<std::string> warnings;
  std::vector<ReportItem> report;
  std::vector<EntryOutput> outputs;

  const EntryOutput* find(const std::string& port) const {
    for (const EntryOutput& output : outputs)
      if (output.port == port) return &output;
    return nullptr;
  }
};

/// An entry does not hold what its manifest says. It is to be set aside and made again.
struct EntryDamaged : CacheError {
  EntryDamaged(std::string stage_name, std::string entry_key, const std::string& what)
      : CacheError(what), stage(std::move(stage_name)), key(std::move(entry_key)) {}
  std::string stage, key;
};

/// An entry as `cache ls` tells it.
struct EntryListing {
  std::string stage, key;
  std::uint64_t size = 0;    ///< bytes of all files
  std::int64_t used_ns = 0;  ///< last use, nanoseconds since 1970
  std::filesystem::path folder;
};

class Cache {
 public:
  /// A folder being written, which dies with the process that writes it.
  class Staging {
   public:
    Staging(FileSystem& disk, const std::filesystem::path& parent);
    Staging(const Staging&) = delete;
    Staging& operator=(const Staging&) = delete;
    ~Staging();
    const std::filesystem::path& folder() const { return folder_; }

   private:
    FileSystem& disk_;
    std::filesystem::path folder_, lock_path_;
    std::unique_ptr<FileLock> lock_;
  };

  /// Touches nothing until something is to be written.
  explicit Cache(std::filesystem::path folder, FileSystem& disk = real_file_system());

  const std::filesystem::path& folder() const { return folder_; }
  FileSystem& disk() const { return disk_; }
  /// Digests of input files and published files, remembered in the cache.
  FileDigests& file_digests() { return file_digests_; }

  std::filesystem::path entry_folder(const std::string& stage, const std::string& key) const;
  std::filesystem::path output_folder(const Entry& entry, const std::string& port) const;

  /// The entry of a key, its manifest checked, its artifacts unread; nothing where there is none. Throws EntryDamaged.
  /// Marks it as used.
  std::optional<Entry> find(const std::string& stage, const std::string& key);
  /// Reads an artifact, each file against its checksum. Throws EntryDamaged.
  Artifact load(const Entry& entry, const std::string& port, int threads = 0);
  /// Where a file of a FileSet lies.
  std::filesystem::path user_file(const Entry& entry, const EntryOutput& output, const std::string& name) const;

  /// A new folder to write an entry in, with the scratch folder for a FileSet's files. Clears what dead processes left.
  std::unique_ptr<Staging> stage();
  static std::filesystem::path scratch_folder(const Staging& staging);
  /// Writes artifacts (FileSets' files lie in the scratch folder) and everything `entry` says beside its outputs, syncs
  /// and moves the folder into place; fills in entry.outputs. Where the key has an entry by now, of another process or
  /// of before: one with the same content is kept, and its times with it, while `entry` keeps its own; one with other
  /// content is replaced, which `replaced` tells.
  void store(Entry& entry, const std::string& key_text, const Outputs& artifacts, Staging& staging, bool& replaced,
             int threads = 0);
  /// Moves an entry to `damaged`; quiet where it is not there.
  void set_aside(const std::string& stage, const std::string& key);

  /// The text of the key a stage of a configuration had last; nothing where it never had one.
  std::optional<std::string> last_key_text(const std::string& configuration, const std::string& stage_name);
  void remember_key_text(const std::string& configuration, const std::string& stage_name, const std::string& text);

  /// All entries, by stage and key.
  std::vector<EntryListing> list();
  /// Reads every file of an entry against its checksum; throws EntryDamaged.
  void verify(const std::string& stage, const std::string& key, int threads = 0);
  /// Removes an entry, for readers at once and whole.
  void remove(const std::string& stage, const std::string& key);
  /// Removes damaged entries set aside before and what dead processes left.
  void remove_rubbish();
  /// Removes everything.
  void clear();

 private:
  void clear_dead_staging();

  FileSystem& disk_;
  std::filesystem::path folder_;
  FileDigests file_digests_;
  bool cleared_ = false;  ///< whether this object looked for what dead processes left
};

struct GarbageLimits {
  std::optional<double> max_age_days;     ///< since last use
  std::optional<std::uint64_t> max_size;  ///< of all entries together, in bytes; those used longest ago go first
};
struct GarbageReport {
  std::size_t num_removed = 0, num_kept = 0;
  std::uint64_t bytes_removed = 0, bytes_kept = 0;
};
/// Removes entries beyond the limits, and rubbish. Safe beside running processes: one that loses an entry makes it
/// again.
GarbageReport collect_garbage(Cache& cache, const GarbageLimits& limits);

}  // namespace meshmser
