#include "pipeline/cache/manifest.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/formats/digest.hpp"

namespace meshmser {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kManifestVersion = 1;

std::string dump(const Json& json) {
  return json.dump(1, ' ', false, Json::error_handler_t::replace);
}

Json json_of(const ReportItem& item) {
  Json json{{"name", item.name}, {"unit", item.unit}};
  if (const auto* whole = std::get_if<std::int64_t>(&item.value))
    json["integer"] = *whole;
  else if (const auto* number = std::get_if<double>(&item.value))
    json["number"] = std::isfinite(*number) ? Json(*number) : Json(format_number(*number));
  else
    json["text"] = std::get<std::string>(item.value);
  return json;
}

ReportItem report_item(const Json& json) {
  ReportItem item{json.at("name"), std::int64_t{0}, json.at("unit")};
  if (json.contains("integer"))
    item.value = json["integer"].get<std::int64_t>();
  else if (json.contains("text"))
    item.value = json["text"].get<std::string>();
  else if (const Json& number = json.at("number"); number.is_number())
    item.value = number.get<double>();
  else
    item.value = std::stod(number.get<std::string>());  // inf, -inf, nan
  return item;
}

std::size_t type_of(const std::string& name) {
  for (std::size_t type = 0; type < std::variant_size_v<Artifact>; ++type)
    if (artifact_name(type) == name) return type;
  throw std::out_of_range("artifact type");
}

Entry entry_of(const Json& json) {
  Entry entry;
  entry.stage = json.at("stage");
  entry.key = json.at("key");
  entry.wall_seconds = json.at("wall_seconds");
  entry.cpu_seconds = json.at("cpu_seconds");
  entry.peak_bytes = json.at("peak_bytes");
  entry.warnings = json.at("warnings").get<std::vector<std::string>>();
  for (const Json& item : json.at("report")) entry.report.push_back(report_item(item));
  for (const Json& made : json.at("outputs")) {
    EntryOutput output{made.at("port"), type_of(made.at("type")), made.at("digest"), {}, {}};
    for (const Json& file : made.at("files"))
      output.files.push_back({file.at("name"), file.at("size").get<std::uint64_t>(), file.at("sha256")});
    output.user_files = made.at("user_files").get<std::vector<std::string>>();
    entry.outputs.push_back(std::move(output));
  }
  return entry;
}

}  // namespace

std::string manifest_text(const Entry& entry) {
  Json json;
  json["manifest_version"] = kManifestVersion;
  json["stage"] = entry.stage;
  json["key"] = entry.key;
  json["wall_seconds"] = entry.wall_seconds;
  json["cpu_seconds"] = entry.cpu_seconds;
  json["peak_bytes"] = entry.peak_bytes;
  json["warnings"] = entry.warnings;
  json["report"] = Json::array();
  for (const ReportItem& item : entry.report) json["report"].push_back(json_of(item));
  json["outputs"] = Json::array();
  for (const EntryOutput& output : entry.outputs) {
    Json made{{"port", output.port}, {"type", artifact_name(output.type)}, {"digest", output.digest}};
    made["files"] = Json::array();
    for (const EntryFile& file : output.files)
      made["files"].push_back({{"name", file.name}, {"size", file.size}, {"sha256", file.digest}});
    made["user_files"] = output.user_files;
    json["outputs"].push_back(std::move(made));
  }
  json["sha256"] = sha256(dump(json));
  return dump(json) + "\n";
}

std::optional<Entry> parse_manifest(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("sha256") || !json["sha256"].is_string()) return std::nullopt;
  const std::string digest = json["sha256"];
  json.erase("sha256");
  try {
    if (sha256(dump(json)) != digest || json.at("manifest_version") != kManifestVersion) return std::nullopt;
    return entry_of(json);
  } catch (const std::exception&) {  // of another program, or another version of this one
    return std::nullopt;
  }
}

}  // namespace meshmser
