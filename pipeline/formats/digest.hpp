#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace meshmser {

/// SHA-256 [FIPS 180-4] of bytes given piece by piece.
class Sha256 {
 public:
  Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  ~Sha256();
  void update(std::span<const std::byte> bytes);
  void update(std::string_view text) { update(std::as_bytes(std::span<const char>(text.data(), text.size()))); }
  /// 64 hexadecimal digits; to be called once.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

inline std::string sha256(std::string_view text) {
  Sha256 digest;
  digest.update(text);
  return digest.finish();
}

}  // namespace meshmser
