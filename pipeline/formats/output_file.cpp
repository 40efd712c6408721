#include "pipeline/formats/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>

namespace meshmser {

OutputFile::OutputFile(const std::filesystem::path& path) : path_(path), buffer_(kBuffer, '\0') {
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot be created");
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFile::bytes(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size > 0) {
    if (used_ == kBuffer) flush();
    const std::size_t part = std::min(size, kBuffer - used_);
    std::memcpy(buffer_.data() + used_, from, part);
    used_ += part;
    from += part;
    size -= part;
  }
}

void OutputFile::flush() {
  for (std::size_t done = 0; done < used_;) {
    const ssize_t written = ::write(descriptor_, buffer_.data() + done, used_ - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot be written");
    done += static_cast<std::size_t>(written);
  }
  used_ = 0;
}

void OutputFile::finish() {
  flush();
  const int descriptor = descriptor_;
  descriptor_ = -1;
  if (::close(descriptor) != 0) fail("cannot be written");
}

void OutputFile::fail(const char* what) const {
  throw CacheError(
      fmt::format("{}: {}: {}; free some space or choose another folder", path_.string(), what, std::strerror(errno)));
}

}  // namespace meshmser
