#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace meshmser {

/// One array in the page's binary part.
struct Block {
  std::string name;
  std::string coding;       ///< delta16, delta32, index, plain8, float32
  std::int64_t count = 0;   ///< of values
  std::int64_t stride = 1;  ///< differences are taken from the value this many places before
  std::int64_t offset = 0;  ///< of its compressed bytes
  std::int64_t size = 0;    ///< their number
};

/// Arrays as compressed bytes that the page reads. Differences of neighbours, zigzag (0, -1, 1, -2 ...), least
/// significant bytes of all values first, then the next ones, each array by zlib. Throws StageError where zlib fails.
class BlockWriter {
 public:
  /// Values modulo 2^16.
  void add(std::string_view name, std::span<const std::uint16_t> values, std::int64_t stride = 1);
  void add(std::string_view name, std::span<const std::int32_t> values, std::int64_t stride = 1);
  void add(std::string_view name, std::span<const std::uint8_t> values);
  void add(std::string_view name, std::span<const float> values);
  /// Corners of triangles whose vertices are numbered in the order of their first use: how far below the next new
  /// number each is.
  void add_corners(std::string_view name, std::span<const std::int32_t> corners);

  const std::vector<Block>& blocks() const { return blocks_; }
  const std::string& bytes() const { return bytes_; }

 private:
  void compress(std::string_view name, const char* coding, std::size_t count, std::int64_t stride,
                const std::vector<std::uint8_t>& raw);

  std::vector<Block> blocks_;
  std::string bytes_;
};

/// Base64 of RFC 4648, with padding.
std::string base64(std::string_view bytes);
/// Its inverse; ends at what is no digit.
std::string bytes_of_base64(std::string_view text);

}  // namespace meshmser
