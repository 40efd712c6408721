// Of every stage there is: each parameter that changes the result changes the key, and no other does.
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "pipeline/cache/cache_key.hpp"

namespace meshmser {
namespace {

TEST(CacheKeys, OfEveryStageFollowItsParameters) {
  ASSERT_GE(all_stages().size(), 8U);
  const auto seed = std::random_device()();
  std::mt19937_64 random(seed);
  for (const StageDefinition* stage : all_stages())
    for (const Parameter& parameter : stage->parameters) {
      const auto parameters = stage->make_parameters();
      std::map<std::string, std::string> text_of_key;
      for (int i = 0; i < 20; ++i) {
        const std::string key = make_cache_key(*stage, parameters.get(), "name", "mm", {}, {}).digest;
        const std::string text = parameter.affects_result ? key_text(parameter, parameters.get()) : "";
        const auto [known, is_new] = text_of_key.emplace(key, text);
        EXPECT_EQ(known->second, text) << stage->info.name << "." << parameter.name << ", seed " << seed;
        for (const auto& [other_key, other_text] : text_of_key)
          EXPECT_TRUE(other_key == key || other_text != text)
              << stage->info.name << "." << parameter.name << " changed the key, seed " << seed;
        parameter.randomize(parameters.get(), random);
      }
    }
}

}  // namespace
}  // namespace meshmser
