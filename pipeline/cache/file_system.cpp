#include "pipeline/cache/file_system.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

namespace meshmser {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* what, int error) {
  const char* remedy = error == ENOSPC || error == EDQUOT ? "free some space or choose another folder"
                                                          : "check the folder's permissions or choose another folder";
  throw CacheError(fmt::format("{}: cannot {}: {}; {}", path.string(), what, std::strerror(error), remedy));
}

class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags, const char* what) : Descriptor(path, flags) {
    if (number < 0) fail(path, what, errno);
  }
  Descriptor(const std::filesystem::path& path, int flags) {
    do number = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
    while (number < 0 && errno == EINTR);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
  void close(const std::filesystem::path& path) {
    const int closing = std::exchange(number, -1);
    if (::close(closing) != 0) fail(path, "be written", errno);
  }

  int number = -1;
};

class DiskFile : public ReadableFile {
 public:
  DiskFile(std::filesystem::path path, int flags) : path_(std::move(path)), descriptor_(path_, flags) {
    if (descriptor_.number < 0) return;
    struct ::stat status {};
    if (::fstat(descriptor_.number, &status) != 0) fail(path_, "be read", errno);
    size_ = static_cast<std::uint64_t>(status.st_size);
  }
  bool is_open() const { return descriptor_.number >= 0; }
  std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> to) const override {
    for (std::size_t done = 0; done < to.size();) {
      const ssize_t got =
          ::pread(descriptor_.number, to.data() + done, to.size() - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(path_, "be read", errno);
      if (got == 0) throw CacheError(path_.string() + ": ends before its time");
      done += static_cast<std::size_t>(got);
    }
  }

 private:
  std::filesystem::path path_;
  Descriptor descriptor_;
  std::uint64_t size_ = 0;
};

std::int64_t nanoseconds(const timespec& time) {
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

FileLock::~FileLock() {
  ::close(descriptor_);
}

void FileSystem::create_folders(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail(folder, "be made", error.value());
}

void FileSystem::write(const std::filesystem::path& path, std::span<const std::span<const std::byte>> pieces) {
  Descriptor file(path, O_WRONLY | O_CREAT | O_EXCL, "be made");
  for (const std::span<const std::byte> piece : pieces)
    for (std::size_t done = 0; done < piece.size();) {
      const ssize_t written = ::write(file.number, piece.data() + done, piece.size() - done);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail(path, "be written", errno);
      done += static_cast<std::size_t>(written);
    }
  file.close(path);
}

void FileSystem::sync(const std::filesystem::path& path) {
  const Descriptor file(path, O_RDONLY, "be opened");
  // A file system that knows no sync of folders (EINVAL) has nothing to lose by it.
  if (::fsync(file.number) != 0 && errno != EINVAL) fail(path, "be written to the disk", errno);
}

bool FileSystem::rename(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::rename(from.c_str(), to.c_str()) == 0) return true;
  if (errno == ENOTEMPTY || errno == EEXIST || errno == ENOENT) return false;
  fail(to, "be put in place", errno);
}

void FileSystem::remove(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove_all(path, error);
  if (error && error != std::errc::no_such_file_or_directory) fail(path, "be removed", error.value());
}

void FileSystem::copy(const std::filesystem::path& from, const std::filesystem::path& to) {
  const Descriptor source(from, O_RDONLY, "be read");
  Descriptor target(to, O_WRONLY | O_CREAT | O_EXCL, "be made");
  struct ::stat status {};
  if (::fstat(source.number, &status) != 0) fail(from, "be read", errno);
  auto left = static_cast<std::size_t>(status.st_size);
  bool in_kernel = true;
  std::vector<char> buffer;
  while (left > 0) {
    ssize_t done = in_kernel ? ::copy_file_range(source.number, nullptr, target.number, nullptr, left, 0) : -1;
    if (done < 0 && in_kernel && errno != EINTR) {
      in_kernel = false;  // not between these file systems: the offsets are where they were
      buffer.resize(std::size_t{1} << 20);
    }
    if (!in_kernel) {
      done = ::read(source.number, buffer.data(), std::min(left, buffer.size()));
      if (done < 0 && errno != EINTR) fail(from, "be read", errno);
      for (ssize_t put = 0; put < done;) {
        const ssize_t written = ::write(target.number, buffer.data() + put, static_cast<std::size_t>(done - put));
        if (written < 0 && errno != EINTR) fail(to, "be written", errno);
        put += std::max<ssize_t>(written, 0);
      }
    }
    if (done == 0) throw CacheError(from.string() + ": ends before its time");
    left -= static_cast<std::size_t>(std::max<ssize_t>(done, 0));
  }
  target.close(to);
}

std::unique_ptr<ReadableFile> FileSystem::open(const std::filesystem::path& path) {
  auto file = std::make_unique<DiskFile>(path, O_RDONLY);
  if (file->is_open()) return file;
  if (errno == ENOENT || errno == ENOTDIR) return nullptr;
  fail(path, "be read", errno);
}

std::vector<std::string> FileSystem::list(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  std::filesystem::directory_iterator entries(folder, error);
  for (; !error && entries != std::filesystem::directory_iterator(); entries.increment(error))
    names.push_back(entries->path().filename().string());
  if (error && error != std::errc::no_such_file_or_directory && error != std::errc::not_a_directory)
    fail(folder, "be listed", error.value());
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<FileIdentity> FileSystem::identity(const std::filesystem::path& path) {
  struct ::stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
    fail(path, "be read", errno);
  }
  return FileIdentity{status.st_dev,
                      status.st_ino,
                      static_cast<std::uint64_t>(status.st_size),
                      nanoseconds(status.st_mtim),
                      nanoseconds(status.st_ctim),
                      S_ISDIR(status.st_mode)};
}

void FileSystem::touch(const std::filesystem::path& path) {
  ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
}

std::unique_ptr<FileLock> FileSystem::try_lock(const std::filesystem::path& path) {
  for (;;) {
    Descriptor file(path, O_RDWR | O_CREAT, "be locked");
    if (::flock(file.number, LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) return nullptr;
      fail(path, "be locked", errno);
    }
    // Between opening and locking, another may have held the lock, and removed the file with it.
    struct ::stat locked {
    }, named{};
    if (::fstat(file.number, &locked) == 0 && ::stat(path.c_str(), &named) == 0 && locked.st_ino == named.st_ino)
      return std::make_unique<FileLock>(std::exchange(file.number, -1));
  }
}

std::optional<std::string> FileSystem::read_text(const std::filesystem::path& path) {
  const std::unique_ptr<ReadableFile> file = open(path);
  if (!file) return std::nullopt;
  std::string text(file->size(), '\0');
  file->read(0, std::as_writable_bytes(std::span<char>(text)));
  return text;
}

void FileSystem::write_atomically(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path aside = place_aside(path);
  const std::span<const std::byte> piece = as_bytes(text);
  try {
    write(aside, {&piece, 1});
    sync(aside);
    if (!rename(aside, path)) fail(path, "be put in place", EEXIST);
  } catch (const Error&) {
    try {
      remove(aside);
    } catch (const Error&) {  // the first failure is the one to tell
    }
    throw;
  }
}

std::filesystem::path place_aside(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.{}", path.filename().string(), unique_name());
}

std::string unique_name() {
  static std::atomic<unsigned> count{0};
  std::uint64_t random = 0;
  if (::getrandom(&random, sizeof random, 0) != sizeof random) throw CacheError("the system gives no random numbers");
  return fmt::format("{}-{:016x}-{}", ::getpid(), random, count.fetch_add(1));
}

FileSystem& real_file_system() {
  static FileSystem disk;
  return disk;
}

}  // namespace meshmser
