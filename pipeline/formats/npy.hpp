#pragma once
/// NumPy's array file: a short text header, then the values as they lie in memory (NEP 1).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace meshmser {

/// Type and shape of an array of `rows` rows, each of `columns` values (0: the array has one dimension).
struct NpyShape {
  std::string type;  ///< "<f8", "<i4", "|u1" ...
  std::uint64_t rows = 0;
  std::uint64_t columns = 0;
  bool operator==(const NpyShape&) const = default;
};

/// NumPy's name of a number type; this machine is little-endian.
template <class T>
std::string npy_type() {
  static_assert(std::is_arithmetic_v<T>);
  const char kind = std::is_same_v<T, bool> ? 'b' : std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u';
  return std::string(sizeof(T) == 1 ? "|" : "<") + kind + std::to_string(sizeof(T));
}

/// The header before the values: version 1.0, padded so that the values begin at a multiple of 64 bytes.
std::string npy_header(const NpyShape& shape);

struct NpyHeader {
  NpyShape shape;
  std::uint64_t size = 0;  ///< bytes before the values
};

/// Longest header this program writes.
inline constexpr std::size_t kNpyHeaderLimit = 256;

/// Reads a header made by npy_header, or by NumPy in row order; nothing where it is none. `bytes`: the beginning of the
/// file, kNpyHeaderLimit bytes where the file has them.
std::optional<NpyHeader> parse_npy_header(std::span<const std::byte> bytes);

}  // namespace meshmser
