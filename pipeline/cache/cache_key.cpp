#include "pipeline/cache/cache_key.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "pipeline/formats/digest.hpp"

namespace meshmser {
namespace {

std::string quoted(const std::string& word) {
  std::string text = "\"";
  for (const char c : word) {
    if (c == '"' || c == '\\') text += '\\';
    if (c == '\n')
      text += "\\n";
    else
      text += c;
  }
  return text + "\"";
}

// A line "kind "name" value", taken apart again.
struct Line {
  std::string kind, name, value;
};

std::string take_quoted(const std::string& text, std::size_t& at) {
  std::string word;
  if (at >= text.size() || text[at] != '"') return word;
  for (++at; at < text.size() && text[at] != '"'; ++at) {
    if (text[at] == '\\' && at + 1 < text.size()) ++at;
    word += text[at];
  }
  at += 2;
  return word;
}

std::vector<Line> lines_of(const std::string& text) {
  std::vector<Line> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string row = text.substr(begin, end - begin);
    begin = end + 1;
    Line line;
    std::size_t at = std::min(row.find(' '), row.size());
    line.kind = row.substr(0, at);
    ++at;
    line.name = take_quoted(row, at);
    line.value = take_quoted(row, at);
    lines.push_back(std::move(line));
  }
  return lines;
}

// A value as the key holds it, with the name of the coordinates' unit: "2 unit2" is "2 mm2" to the user.
std::string with_unit(std::string value, const std::string& units) {
  constexpr std::string_view kUnit = " unit";
  for (std::size_t at = value.find(kUnit); at != std::string::npos; at = value.find(kUnit, at + 1)) {
    const std::size_t end = at + kUnit.size();
    const bool ends = end == value.size() || !std::isalnum(static_cast<unsigned char>(value[end])) ||
                      (value[end] == '2' && (end + 1 == value.size() || value[end + 1] == ']'));
    if (ends) value.replace(at + 1, kUnit.size() - 1, units);
  }
  return value;
}

}  // namespace

std::string build_mode() {
  std::string mode = "portable";
#ifdef MESHMSER_NATIVE_BUILD
  mode = "native " __VERSION__;
#ifdef __FMA__
  mode += " fma";
#endif
#ifdef __AVX2__
  mode += " avx2";
#endif
#ifdef __AVX512F__
  mode += " avx512";
#endif
#endif
  return mode;
}

CacheKey make_cache_key(const StageDefinition& definition, const void* parameters, const std::string& stage_name,
                        const std::string& units, const std::vector<KeyFile>& files,
                        const std::vector<KeyInput>& inputs) {
  CacheKey key;
  const auto line = [&](const char* kind, const std::string& name, const std::string& value) {
    key.text += fmt::format("{} {} {}\n", kind, quoted(name), quoted(value));
  };
  line("format", "cache key", "1");
  line("stage", std::string(definition.info.name), std::to_string(definition.info.version));
  line("build", "floating mode", build_mode());
  line("name", "stage", stage_name);
  line("name", "units", units);
  for (const Parameter& parameter : definition.parameters)
    if (parameter.affects_result) line("parameter", parameter.name, key_text(parameter, parameters));
  for (const KeyFile& file : files) line("file", file.name, file.digest);
  for (const KeyInput& input : inputs)
    line("input", input.name_matters ? input.port + " of " + input.stage : input.port, input.type + " " + input.digest);
  key.digest = sha256(key.text);
  return key;
}

std::vector<std::string> explain_difference(const std::string& before, const std::string& now,
                                            const std::string& stage_name, const std::vector<KeyInput>& inputs) {
  std::vector<std::string> reasons;
  // A file may stand twice under one name: the n-th is compared with the n-th.
  std::multimap<std::pair<std::string, std::string>, std::string> old;
  for (const Line& line : lines_of(before)) old.emplace(std::pair(line.kind, line.name), line.value);
  std::size_t input_index = 0;
  std::string units = "unit";
  for (const Line& line : lines_of(now)) {
    if (line.kind == "name" && line.name == "units") units = line.value;
    const KeyInput* input = line.kind == "input" ? &inputs.at(input_index++) : nullptr;
    const auto found = old.find({line.kind, line.name});
    const bool known = found != old.end();
    const std::string value = known ? found->second : "";
    if (known) old.erase(found);
    if (known && value == line.value) continue;
    if (line.kind == "stage" || line.kind == "format")
      reasons.push_back(known ? fmt::format("stage version {} -> {}", value, line.value)
                              : fmt::format("stage is now {}", line.name));
    else if (line.kind == "build")
      reasons.push_back(fmt::format("build {} -> {}", value, line.value));
    else if (line.kind == "name")
      reasons.push_back(fmt::format("{} {} -> {}", line.name, value, line.value));
    else if (line.kind == "parameter")
      reasons.push_back(known ? fmt::format("{}.{} {} -> {}", stage_name, line.name, with_unit(value, units),
                                            with_unit(line.value, units))
                              : fmt::format("{}.{} is new", stage_name, line.name));
    else if (line.kind == "file")
      reasons.push_back(fmt::format("input file {} {}", line.name, known ? "changed" : "is new"));
    else
      reasons.push_back(
          fmt::format("input {} of stage {} {}", input->port, input->stage, known ? "changed" : "is new"));
  }
  for (const auto& [what, value] : old) reasons.push_back(fmt::format("{} {} is gone", what.first, what.second));
  return reasons;
}

}  // namespace meshmser
