#include "pipeline/cache/cache.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <utility>

#include "pipeline/cache/manifest.hpp"
#include "pipeline/execution/jobs.hpp"
#include "pipeline/formats/digest.hpp"
#include "pipeline/formats/stored_artifact.hpp"

namespace meshmser {
namespace {

constexpr const char* kManifest = "manifest.json";
constexpr const char* kKeyText = "key.txt";
constexpr const char* kUserFiles = "files";
constexpr const char* kScratch = ".scratch";  // no port has such a name
// Backup programs leave out folders with this tag (bford.info/cachedir).
constexpr const char* kTag = "CACHEDIR.TAG";
constexpr const char* kTagText =
    "Signature: 8a477f597d28d172789f06886806bc55\n# This folder is a cache of meshmser and may be removed.\n";

std::string digest_of(std::span<const std::byte> first, std::span<const std::byte> second) {
  Sha256 digest;
  digest.update(first);
  digest.update(second);
  return digest.finish();
}

// Of an artifact's type and its files by name, size and content.
std::string content_digest(std::size_t type, const std::vector<EntryFile>& files, const std::string& prefix) {
  std::string text = fmt::format("{}\n", artifact_name(type));
  for (const EntryFile& file : files)
    text += fmt::format("{} {} {}\n", file.name.substr(prefix.size()), file.size, file.digest);
  return sha256(text);
}

// Reads the files of one artifact of an entry, each against the manifest.
class EntrySource : public StoredFileSource {
 public:
  EntrySource(FileSystem& disk, const std::filesystem::path& folder, const Entry& entry, const EntryOutput& output)
      : disk_(disk), folder_(folder), entry_(entry), prefix_(output.port + "/") {
    for (const EntryFile& file : output.files) files_[file.name.substr(prefix_.size())] = {&file, nullptr};
  }
  [[noreturn]] void damaged(const std::string& name, const std::string& what) const {
    throw EntryDamaged(entry_.stage, entry_.key, (folder_ / (prefix_ + name)).string() + ": " + what);
  }
  std::uint64_t size(const std::string& name) override { return open(name).size(); }
  void read(const std::string& name, std::uint64_t offset, std::span<std::byte> to) override {
    open(name).read(offset, to);
  }
  void check(const std::string& name, std::span<const std::byte> header, std::span<const std::byte> content) override {
    if (digest_of(header, content) != files_.at(name).first->digest) damaged(name, "its content has changed");
  }

 private:
  const ReadableFile& open(const std::string& name) {
    const std::lock_guard<std::mutex> guard(mutex_);
    const auto found = files_.find(name);
    if (found == files_.end()) damaged(name, "is not in the manifest");
    auto& [record, file] = found->second;
    if (!file) {
      file = disk_.open(folder_ / record->name);
      if (!file) damaged(name, "is missing");
      if (file->size() != record->size) damaged(name, "its size has changed");
    }
    return *file;
  }

  FileSystem& disk_;
  std::filesystem::path folder_;
  const Entry& entry_;
  std::string prefix_;
  std::mutex mutex_;
  std::map<std::string, std::pair<const EntryFile*, std::unique_ptr<ReadableFile>>> files_;
};

// A file name that any configuration's or stage's name makes, two names never the same.
std::string file_name_for(const std::string& name) {
  std::string safe;
  for (const char c : name) safe += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' ? c : '_';
  return safe.substr(0, 40) + "-" + sha256(name).substr(0, 16);
}

}  // namespace

// ---- Staging

Cache::Staging::Staging(FileSystem& disk, const std::filesystem::path& parent)
    : disk_(disk), folder_(parent / unique_name()), lock_path_(folder_.string() + ".lock") {
  disk_.create_folders(parent);
  // The lock is there before the folder, so that a folder without one is dead.
  lock_ = disk_.try_lock(lock_path_);
  if (!lock_) throw CacheError(lock_path_.string() + ": is locked by another process");
  disk_.create_folders(folder_);
}

Cache::Staging::~Staging() {
  try {
    disk_.remove(folder_);
    disk_.remove(lock_path_);
  } catch (const Error&) {  // the next process clears it
  }
}

// ---- Cache

Cache::Cache(std::filesystem::path folder, FileSystem& disk)
    : disk_(disk), folder_(std::move(folder)), file_digests_(disk, folder_ / "digests") {}

std::filesystem::path Cache::entry_folder(const std::string& stage, const std::string& key) const {
  return folder_ / "entries" / stage / key;
}

std::filesystem::path Cache::output_folder(const Entry& entry, const std::string& port) const {
  return entry_folder(entry.stage, entry.key) / port;
}

std::filesystem::path Cache::user_file(const Entry& entry, const EntryOutput& output, const std::string& name) const {
  return output_folder(entry, output.port) / kUserFiles / name;
}

std::optional<Entry> Cache::find(const std::string& stage, const std::string& key) {
  const std::filesystem::path folder = entry_folder(stage, key);
  const std::filesystem::path path = folder / kManifest;
  const auto text = disk_.read_text(path);
  if (!text) {
    if (!disk_.identity(folder)) return std::nullopt;
    throw EntryDamaged(stage, key, path.string() + ": is missing");
  }
  auto entry = parse_manifest(*text);
  if (!entry || entry->stage != stage || entry->key != key)
    throw EntryDamaged(stage, key, path.string() + ": is not what was written");
  disk_.touch(path);
  return entry;
}

Artifact Cache::load(const Entry& entry, const std::string& port, int threads) {
  const EntryOutput* output = entry.find(port);
  if (output == nullptr) throw EntryDamaged(entry.stage, entry.key, "output '" + port + "' is missing");
  EntrySource source(disk_, entry_folder(entry.stage, entry.key), entry, *output);
  try {
    return load_stored_artifact(output->type, source, output_folder(entry, port) / kUserFiles, threads);
  } catch (const EntryDamaged&) {
    throw;
  } catch (const CacheError& error) {
    throw EntryDamaged(entry.stage, entry.key, output_folder(entry, port).string() + ": " + error.what());
  }
}

std::unique_ptr<Cache::Staging> Cache::stage() {
  disk_.create_folders(folder_);
  if (!disk_.identity(folder_ / kTag)) disk_.write_atomically(folder_ / kTag, kTagText);
  if (!std::exchange(cleared_, true)) clear_dead_staging();
  auto staging = std::make_unique<Staging>(disk_, folder_ / "staging");
  disk_.create_folders(scratch_folder(*staging));
  return staging;
}

std::filesystem::path Cache::scratch_folder(const Staging& staging) {
  return staging.folder() / kScratch;
}

void Cache::store(Entry& entry, const std::string& key_text, const Outputs& artifacts, Staging& staging, bool& replaced,
                  int threads) {
  replaced = false;
  struct Job {
    EntryFile* record;
    const StoredFile* file;  ///< nullptr: written by the stage
  };
  const std::filesystem::path root = staging.folder();
  entry.outputs.clear();
  entry.outputs.resize(artifacts.items().size());
  std::vector<std::vector<StoredFile>> stored(entry.outputs.size());
  std::vector<Job> jobs;
  std::vector<std::filesystem::path> folders{root};
  for (std::size_t i = 0; i < entry.outputs.size(); ++i) {
    const auto& [port, artifact] = artifacts.items()[i];
    EntryOutput& output = entry.outputs[i];
    output.port = port;
    output.type = artifact.index();
    stored[i] = stored_files(artifact);
    folders.push_back(root / port);
    disk_.create_folders(folders.back());
    if (const auto* set = std::get_if<Shared<FileSet>>(&artifact)) {
      output.user_files = (*set)->names;
      folders.push_back(root / port / kUserFiles);
      if (!disk_.rename(scratch_folder(staging), folders.back()))
        throw CacheError((root / kScratch).string() + ": files of two outputs in one folder");
    }
    output.files.resize(stored[i].size() + output.user_files.size());
    for (std::size_t f = 0; f < output.files.size(); ++f) {
      const bool own = f < stored[i].size();
      output.files[f].name = own ? port + "/" + stored[i][f].name
                                 : port + "/" + kUserFiles + "/" + output.user_files[f - stored[i].size()];
      jobs.push_back({&output.files[f], own ? &stored[i][f] : nullptr});
    }
  }
  run_jobs(jobs.size(), threads, [&](std::size_t i) {
    EntryFile& record = *jobs[i].record;
    const std::filesystem::path path = root / record.name;
    if (const StoredFile* file = jobs[i].file) {
      const std::span<const std::byte> pieces[] = {as_bytes(file->header), file->content};
      record.size = pieces[0].size() + pieces[1].size();
      record.digest = digest_of(pieces[0], pieces[1]);
      disk_.write(path, pieces);
    } else {
      const auto identity = disk_.identity(path);
      if (!identity) throw CacheError(path.string() + ": the stage '" + entry.stage + "' did not write it");
      record.size = identity->size;
      record.digest = digest_of_file(disk_, path);
    }
    disk_.sync(path);
  });
  for (EntryOutput& output : entry.outputs)
    output.digest = content_digest(output.type, output.files, output.port + "/");

  disk_.remove(scratch_folder(staging));
  const auto write_text = [&](const char* name, const std::string& text) {
    const std::span<const std::byte> piece = as_bytes(text);
    disk_.write(root / name, {&piece, 1});
    disk_.sync(root / name);
  };
  write_text(kKeyText, key_text);
  write_text(kManifest, manifest_text(entry));
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) disk_.sync(*folder);

  const std::filesystem::path place = entry_folder(entry.stage, entry.key);
  disk_.create_folders(place.parent_path());
  // Others may put an entry there, or remove one, at any moment; no sane number of them does so this often.
  for (int attempt = 0; !disk_.rename(root, place); ++attempt) {
    if (attempt == 100) throw CacheError(place.string() + ": cannot be put in place; remove this folder");
    try {
      const auto other = find(entry.stage, entry.key);
      if (other && std::equal(other->outputs.begin(), other->outputs.end(), entry.outputs.begin(), entry.outputs.end(),
                              [](const auto& a, const auto& b) { return a.port == b.port && a.digest == b.digest; })) {
        entry.outputs = other->outputs;  // the times stay those of this run
        return;
      }
      replaced = replaced || other.has_value();
      if (other) remove(entry.stage, entry.key);
    } catch (const EntryDamaged&) {
      set_aside(entry.stage, entry.key);
    }
  }
  disk_.sync(place.parent_path());
}

void Cache::set_aside(const std::string& stage, const std::string& key) {
  disk_.create_folders(folder_ / "damaged");
  disk_.rename(entry_folder(stage, key), folder_ / "damaged" / fmt::format("{}-{}-{}", stage, key, unique_name()));
}

std::optional<std::string> Cache::last_key_text(const std::string& configuration, const std::string& stage_name) {
  return disk_.read_text(folder_ / "last" / file_name_for(configuration) / (file_name_for(stage_name) + ".txt"));
}

void Cache::remember_key_text(const std::string& configuration, const std::string& stage_name,
                              const std::string& text) {
  const std::filesystem::path folder = folder_ / "last" / file_name_for(configuration);
  const std::filesystem::path path = folder / (file_name_for(stage_name) + ".txt");
  if (disk_.read_text(path) == text) return;
  try {
    disk_.create_folders(folder);
    disk_.write_atomically(path, text);
  } catch (const CacheError&) {  // only a reason is lost by it, and a cache that cannot be written still serves
  }
}

// ---- Housekeeping

std::vector<EntryListing> Cache::list() {
  std::vector<EntryListing> all;
  const std::filesystem::path entries = folder_ / "entries";
  for (const std::string& stage : disk_.list(entries))
    for (const std::string& key : disk_.list(entries / stage)) {
      EntryListing listing{stage, key, 0, 0, entries / stage / key};
      if (const auto identity = disk_.identity(listing.folder / kManifest)) {
        listing.used_ns = identity->modified_ns;
        listing.size = identity->size;
      }
      if (const auto text = disk_.read_text(listing.folder / kManifest))
        if (const auto entry = parse_manifest(*text))
          for (const EntryOutput& output : entry->outputs)
            for (const EntryFile& file : output.files) listing.size += file.size;
      all.push_back(std::move(listing));
    }
  return all;
}

void Cache::verify(const std::string& stage, const std::string& key, int threads) {
  const std::filesystem::path folder = entry_folder(stage, key);
  const auto text = disk_.read_text(folder / kManifest);
  const auto entry = text ? parse_manifest(*text) : std::nullopt;
  if (!entry || entry->key != key)
    throw EntryDamaged(stage, key, (folder / kManifest).string() + ": is not what was written");
  std::vector<const EntryFile*> files;
  for (const EntryOutput& output : entry->outputs)
    for (const EntryFile& file : output.files) files.push_back(&file);
  run_jobs(files.size(), threads, [&](std::size_t i) {
    const std::filesystem::path path = folder / files[i]->name;
    const auto identity = disk_.identity(path);
    if (!identity) throw EntryDamaged(stage, key, path.string() + ": is missing");
    if (identity->size != files[i]->size) throw EntryDamaged(stage, key, path.string() + ": its size has changed");
    if (digest_of_file(disk_, path) != files[i]->digest)
      throw EntryDamaged(stage, key, path.string() + ": its content has changed");
  });
}

void Cache::remove(const std::string& stage, const std::string& key) {
  const Staging grave(disk_, folder_ / "staging");
  disk_.rename(entry_folder(stage, key), grave.folder());
}

void Cache::remove_rubbish() {
  disk_.remove(folder_ / "damaged");
  clear_dead_staging();
}

void Cache::clear_dead_staging() {
  const std::filesystem::path staging = folder_ / "staging";
  for (const std::string& name : disk_.list(staging)) {
    if (!name.ends_with(".lock")) continue;
    const auto lock = disk_.try_lock(staging / name);
    if (!lock) continue;  // its process is alive
    disk_.remove(staging / name.substr(0, name.size() - 5));
    disk_.remove(staging / name);
  }
}

void Cache::clear() {
  for (const EntryListing& entry : list()) remove(entry.stage, entry.key);
  remove_rubbish();
  for (const char* name : {"entries", "digests", "last"}) disk_.remove(folder_ / name);
}

GarbageReport collect_garbage(Cache& cache, const GarbageLimits& limits) {
  GarbageReport report;
  cache.remove_rubbish();
  std::vector<EntryListing> entries = cache.list();
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.used_ns > b.used_ns; });
  const std::int64_t now =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  for (const EntryListing& entry : entries) {
    const double age_days = static_cast<double>(now - entry.used_ns) / 86400e9;
    const bool old = limits.max_age_days && age_days > *limits.max_age_days;
    const bool large = limits.max_size && report.bytes_kept + entry.size > *limits.max_size;
    if (old || large) {
      cache.remove(entry.stage, entry.key);
      ++report.num_removed;
      report.bytes_removed += entry.size;
    } else {
      ++report.num_kept;
      report.bytes_kept += entry.size;
    }
  }
  return report;
}

}  // namespace meshmser
