#include "pipeline/formats/npy.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>

namespace meshmser {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kMagic{"\x93NUMPY\x01\x00", 8};

// Takes `text` off the front of `from`.
bool take(std::string_view& from, std::string_view text) {
  if (!from.starts_with(text)) return false;
  from.remove_prefix(text.size());
  return true;
}

bool take_number(std::string_view& from, std::uint64_t& number) {
  const auto [end, error] = std::from_chars(from.data(), from.data() + from.size(), number);
  if (error != std::errc()) return false;
  from.remove_prefix(static_cast<std::size_t>(end - from.data()));
  return true;
}

}  // namespace

std::string npy_header(const NpyShape& shape) {
  const std::string size =
      shape.columns == 0 ? fmt::format("({},)", shape.rows) : fmt::format("({}, {})", shape.rows, shape.columns);
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", shape.type, size);
  const std::size_t before = kMagic.size() + 2;
  text.append(63 - (before + text.size()) % 64, ' ');
  text += '\n';
  std::string header(kMagic);
  header += static_cast<char>(text.size() & 255);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

std::optional<NpyHeader> parse_npy_header(std::span<const std::byte> bytes) {
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!take(text, kMagic) || text.size() < 2) return std::nullopt;
  const std::size_t length =
      static_cast<unsigned char>(text[0]) + 256 * static_cast<std::size_t>(static_cast<unsigned char>(text[1]));
  text.remove_prefix(2);
  if (text.size() < length) return std::nullopt;
  NpyHeader header;
  header.size = kMagic.size() + 2 + length;
  if (!take(text, "{'descr': '")) return std::nullopt;
  const std::size_t quote = text.find('\'');
  if (quote == std::string_view::npos) return std::nullopt;
  header.shape.type = text.substr(0, quote);
  text.remove_prefix(quote);
  if (!take(text, "', 'fortran_order': False, 'shape': (") || !take_number(text, header.shape.rows) || !take(text, ","))
    return std::nullopt;
  if (take(text, " ") && !take_number(text, header.shape.columns)) return std::nullopt;
  if (!take(text, ")")) return std::nullopt;
  return header;
}

}  // namespace meshmser
