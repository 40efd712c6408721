#pragma once
/// A set of small whole numbers that answers "the greatest member below": 64-ary, a bit a number, a bit a word above.

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace meshmser {

class LevelBitmap {
 public:
  /// Numbers 0 .. size - 1.
  explicit LevelBitmap(std::size_t size) {
    do {
      size = size / 64 + 1;
      layers_.emplace_back(size, 0);
    } while (size > 1);
  }

  void set(std::size_t i) {
    for (std::vector<std::uint64_t>& layer : layers_) {
      const std::uint64_t before = layer[i / 64];
      layer[i / 64] = before | std::uint64_t{1} << (i % 64);
      if (before != 0) return;
      i /= 64;
    }
  }

  void clear(std::size_t i) {
    for (std::vector<std::uint64_t>& layer : layers_) {
      if ((layer[i / 64] &= ~(std::uint64_t{1} << (i % 64))) != 0) return;
      i /= 64;
    }
  }

  /// The greatest member < i; 0 where there is none (0 itself is never a level).
  std::int32_t highest_below(std::int32_t number) const {
    auto i = static_cast<std::size_t>(number);
    for (std::size_t depth = 0; depth < layers_.size(); ++depth) {
      const std::uint64_t lower = layers_[depth][i / 64] & ((std::uint64_t{1} << (i % 64)) - 1);
      if (lower != 0) {
        i = i / 64 * 64 + static_cast<std::size_t>(std::bit_width(lower)) - 1;
        while (depth-- > 0) i = 64 * i + static_cast<std::size_t>(std::bit_width(layers_[depth][i])) - 1;
        return static_cast<std::int32_t>(i);
      }
      i /= 64;
    }
    return 0;
  }

 private:
  std::vector<std::vector<std::uint64_t>> layers_;
};

}  // namespace meshmser
