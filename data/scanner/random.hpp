#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

namespace meshmser::scanner {

/// Random numbers by position instead of by state: number n of stream s is always the same, whoever asks first.
/// splitmix64 [Steele, Lea, Flood 2014] as a hash.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream) : key_(mix(mix(seed) ^ (stream * 0x9e3779b97f4a7c15u))) {}

  std::uint64_t bits(std::uint64_t n) const { return mix(key_ + n * 0x9e3779b97f4a7c15u); }
  /// In (0, 1).
  double uniform(std::uint64_t n) const { return (static_cast<double>(bits(n) >> 11) + 0.5) * 0x1p-53; }
  /// Standard normal (Box and Muller); uses the numbers 2 n and 2 n + 1.
  double normal(std::uint64_t n) const {
    return std::sqrt(-2 * std::log(uniform(2 * n))) * std::cos(2 * std::numbers::pi * uniform(2 * n + 1));
  }

 private:
  static std::uint64_t mix(std::uint64_t x) {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9u;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  std::uint64_t key_;
};

}  // namespace meshmser::scanner
