/// libFuzzer's entry: any bytes as a small mesh; a broken law ends the program.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/fuzz/mesh_laws.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string broken = meshmser::testing::broken_law({data, size});
  if (broken.empty()) return 0;
  std::fprintf(stderr, "broken law: %s\n", broken.c_str());
  std::abort();
}
