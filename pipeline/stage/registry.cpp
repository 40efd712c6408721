#include <algorithm>
#include <stdexcept>

#include "pipeline/stage/stage.hpp"

namespace meshmser {
namespace {

// A function's static, because stages register themselves before main in an unknown order of translation units.
std::vector<std::unique_ptr<StageDefinition>>& registry() {
  static std::vector<std::unique_ptr<StageDefinition>> stages;
  return stages;
}

template <std::size_t I>
using ArtifactType = std::remove_const_t<typename std::variant_alternative_t<I, Artifact>::element_type>;

template <std::size_t... I>
std::string_view name_of(std::size_t index, std::index_sequence<I...>) {
  constexpr std::string_view kNames[] = {kArtifactInfo<ArtifactType<I>>.name...};
  return kNames[index];
}

}  // namespace

std::string_view artifact_name(std::size_t index) {
  return name_of(index, std::make_index_sequence<std::variant_size_v<Artifact>>());
}

bool register_stage(StageDefinition definition) {
  if (find_stage(definition.info.name) != nullptr)
    throw std::logic_error("two stages are called '" + std::string(definition.info.name) + "'");
  registry().push_back(std::make_unique<StageDefinition>(std::move(definition)));
  return true;
}

std::vector<const StageDefinition*> all_stages() {
  std::vector<const StageDefinition*> stages;
  for (const auto& stage : registry()) stages.push_back(stage.get());
  std::sort(stages.begin(), stages.end(), [](const auto* a, const auto* b) { return a->info.name < b->info.name; });
  return stages;
}

const StageDefinition* find_stage(std::string_view name) {
  for (const auto& stage : registry())
    if (stage->info.name == name) return stage.get();
  return nullptr;
}

}  // namespace meshmser
