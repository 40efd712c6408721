/// Every input that the fuzzer found worth keeping, without the fuzzer.

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/mesh_laws.hpp"

namespace meshmser {
namespace {

const std::filesystem::path kCorpus = std::filesystem::path(MESHMSER_SOURCE_DIR) / "tests" / "corpus" / "mesh_laws";

TEST(Corpus, KeepsTheLaws) {
  std::size_t num_inputs = 0;
  testing::MeshLawsCase reached;
  for (const auto& entry : std::filesystem::directory_iterator(kCorpus)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    EXPECT_EQ(testing::broken_law(bytes), "") << entry.path();
    const testing::MeshLawsCase here = testing::describe_case(bytes);
    reached.num_triangles = std::max(reached.num_triangles, here.num_triangles);
    reached.num_nodes = std::max(reached.num_nodes, here.num_nodes);
    reached.num_regions = std::max(reached.num_regions, here.num_regions);
    reached.num_loops = std::max(reached.num_loops, here.num_loops);
    ++num_inputs;
  }
  // An empty corpus, or one of empty meshes, tests nothing.
  EXPECT_GE(num_inputs, 20u) << kCorpus;
  EXPECT_GE(reached.num_triangles, 15u);
  EXPECT_GE(reached.num_nodes, 10u);
  EXPECT_GE(reached.num_regions, 4u);
  EXPECT_GE(reached.num_loops, 4u);
}

TEST(Corpus, AnyBytesAreAMesh) {
  EXPECT_EQ(testing::broken_law({}), "");
  EXPECT_EQ(testing::describe_case({}).num_triangles, 0u);
  const std::vector<std::uint8_t> ones(200, 1);
  EXPECT_EQ(testing::broken_law(ones), "");
}

}  // namespace
}  // namespace meshmser
