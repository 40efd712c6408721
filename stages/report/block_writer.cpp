#include "stages/report/block_writer.hpp"

#include <zlib.h>

#include <array>
#include <bit>

#include "pipeline/execution/error.hpp"

namespace meshmser {
namespace {

constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Puts value i of `count` into the planes of bytes.
void put(std::vector<std::uint8_t>& planes, std::size_t i, std::size_t count, std::uint32_t value) {
  for (std::size_t place = i; place < planes.size(); place += count, value >>= 8)
    planes[place] = static_cast<std::uint8_t>(value);
}

std::uint32_t zigzag(std::int32_t difference) {
  return (static_cast<std::uint32_t>(difference) << 1) ^ static_cast<std::uint32_t>(difference >> 31);
}

}  // namespace

void BlockWriter::add(std::string_view name, std::span<const std::uint16_t> values, std::int64_t stride) {
  std::vector<std::uint8_t> planes(values.size() * 2);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto back = static_cast<std::size_t>(stride);
    const std::uint16_t before = i < back ? std::uint16_t{0} : values[i - back];
    const auto difference = static_cast<std::int16_t>(static_cast<std::uint16_t>(values[i] - before));
    put(planes, i, values.size(), zigzag(difference) & 0xffffU);
  }
  compress(name, "delta16", values.size(), stride, planes);
}

void BlockWriter::add(std::string_view name, std::span<const std::int32_t> values, std::int64_t stride) {
  std::vector<std::uint8_t> planes(values.size() * 4);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto back = static_cast<std::size_t>(stride);
    const std::uint32_t before = i < back ? 0U : static_cast<std::uint32_t>(values[i - back]);
    put(planes, i, values.size(), zigzag(static_cast<std::int32_t>(static_cast<std::uint32_t>(values[i]) - before)));
  }
  compress(name, "delta32", values.size(), stride, planes);
}

void BlockWriter::add(std::string_view name, std::span<const std::uint8_t> values) {
  compress(name, "plain8", values.size(), 1, {values.begin(), values.end()});
}

void BlockWriter::add(std::string_view name, std::span<const float> values) {
  std::vector<std::uint8_t> planes(values.size() * 4);
  for (std::size_t i = 0; i < values.size(); ++i)
    put(planes, i, values.size(), std::bit_cast<std::uint32_t>(values[i]));
  compress(name, "float32", values.size(), 1, planes);
}

void BlockWriter::add_corners(std::string_view name, std::span<const std::int32_t> corners) {
  std::vector<std::uint8_t> planes(corners.size() * 4);
  std::int32_t next = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    put(planes, i, corners.size(), static_cast<std::uint32_t>(next - corners[i]));
    if (corners[i] == next) ++next;
  }
  compress(name, "index", corners.size(), 1, planes);
}

void BlockWriter::compress(std::string_view name, const char* coding, std::size_t count, std::int64_t stride,
                           const std::vector<std::uint8_t>& raw) {
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  const std::size_t offset = bytes_.size();
  bytes_.resize(offset + size);
  // Level 5: a tenth larger than 9 and several times faster.
  if (compress2(reinterpret_cast<Bytef*>(bytes_.data() + offset), &size, raw.data(), static_cast<uLong>(raw.size()),
                5) != Z_OK)
    throw StageError("cannot compress '" + std::string(name) + "' for the page: zlib refused");
  bytes_.resize(offset + size);
  blocks_.push_back({std::string(name), coding, static_cast<std::int64_t>(count), stride,
                     static_cast<std::int64_t>(offset), static_cast<std::int64_t>(size)});
}

std::string base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

std::string bytes_of_base64(std::string_view text) {
  std::array<std::int8_t, 256> value;
  value.fill(-1);
  for (std::int8_t i = 0; i < 64; ++i) value[static_cast<std::uint8_t>(kDigits[i])] = i;
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    const std::int8_t digit = value[static_cast<std::uint8_t>(c)];
    if (digit < 0) break;
    group = group << 6 | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 255U);
  }
  return bytes;
}

}  // namespace meshmser
