#include "pipeline/cache/file_digests.hpp"

#include <fmt/format.h>

#include <chrono>

#include "pipeline/formats/digest.hpp"

namespace meshmser {
namespace {

// A file written again within the clock's step keeps its times; one that was touched so shortly before it was read is
// read again next time.
constexpr std::int64_t kClockStep = 1'000'000'000;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string text_of(const std::filesystem::path& path, const FileIdentity& id) {
  return fmt::format("{}\n{} {} {} {} {}\n", path.string(), id.device, id.inode, id.size, id.modified_ns,
                     id.changed_ns);
}

}  // namespace

std::string digest_of_file(FileSystem& disk, const std::filesystem::path& path) {
  const std::unique_ptr<ReadableFile> file = disk.open(path);
  if (!file) throw CacheError(path.string() + ": is not there");
  Sha256 digest;
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  for (std::uint64_t offset = 0; offset < file->size();) {
    const auto size = std::min<std::uint64_t>(buffer.size(), file->size() - offset);
    const std::span<std::byte> piece(buffer.data(), size);
    file->read(offset, piece);
    digest.update(piece);
    offset += size;
  }
  return digest.finish();
}

std::optional<std::string> FileDigests::digest(const std::filesystem::path& path) {
  const auto identity = disk_.identity(path);
  if (!identity || identity->folder) return std::nullopt;
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  const std::string head = text_of(whole, *identity);
  const std::filesystem::path memory = folder_ / (sha256(whole.string()) + ".txt");
  if (!folder_.empty())
    if (const auto text = disk_.read_text(memory); text && text->starts_with(head) && text->size() == head.size() + 64)
      return text->substr(head.size());
  const std::int64_t began = now_ns();
  std::string digest = digest_of_file(disk_, path);
  if (disk_.identity(path) != identity)
    throw CacheError(path.string() + ": was written while it was read; run again when it is finished");
  if (remember_ && !folder_.empty() && std::max(identity->modified_ns, identity->changed_ns) + kClockStep < began) {
    try {
      disk_.create_folders(folder_);
      disk_.write_atomically(memory, head + digest);
    } catch (const CacheError&) {  // a digest that is not remembered is computed again
    }
  }
  return digest;
}

}  // namespace meshmser
