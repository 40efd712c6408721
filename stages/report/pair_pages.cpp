#include "stages/report/pair_pages.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/execution/error.hpp"
#include "stages/report/block_writer.hpp"
#include "stages/report/page_template.hpp"
#include "stages/report/report.hpp"

namespace meshmser {
namespace {

using Json = nlohmann::ordered_json;

/// The data of a page.
struct Parts {
  Json header;
  std::string bytes;  ///< of all blocks
  std::string run;    ///< JSON, empty where the page was made outside a run
};

/// The inside of the last script element of that id: what is in it holds no `<`.
std::string_view element(std::string_view page, std::string_view type, std::string_view id) {
  const std::string begin = "<script type=\"" + std::string(type) + "\" id=\"" + std::string(id) + "\">";
  const std::size_t at = page.rfind(begin);
  if (at == std::string_view::npos) return {};
  const std::size_t from = at + begin.size(), end = page.find('<', from);
  return page.substr(from, end == std::string_view::npos ? 0 : end - from);
}

Parts parts_of(std::string_view page, const std::string& name) {
  Parts parts;
  const std::string_view header = element(page, "application/json", "header");
  parts.header = Json::parse(header, nullptr, false);
  if (!parts.header.is_object()) throw StageError(name + " is not the page of a run (report.html)");
  if (parts.header.value("page_format", 0) != kPageFormat)
    throw StageError(name + " was made by another version of meshmser; make it again with this one");
  parts.bytes = bytes_of_base64(element(page, "text/plain", "blocks"));
  parts.run = element(page, "application/json", "run");
  return parts;
}

bool starts_with_any(std::string_view name, const std::vector<std::string_view>& starts) {
  return std::any_of(starts.begin(), starts.end(), [&](std::string_view start) { return name.starts_with(start); });
}

/// Takes blocks whose names begin so out of a page; true where there were any.
bool drop(Json& header, const std::vector<std::string_view>& starts) {
  Json kept = Json::array();
  for (Json& block : header["blocks"])
    if (!starts_with_any(block["name"].get<std::string>(), starts)) kept.push_back(std::move(block));
  const bool any = kept.size() < header["blocks"].size();
  header["blocks"] = std::move(kept);
  return any;
}

bool drop_points(Json& header) {
  header.erase("every_point");
  return drop(header, {"points", "smoothed", "normals"});
}

/// All scalars but the first.
bool drop_scalars(Json& header) {
  const std::size_t count = header.contains("scalars") ? header["scalars"].size() : 0;
  if (count < 2) return false;
  for (std::size_t i = 1; i < count; ++i) drop(header, {"scalar" + std::to_string(i)});
  header["scalars"].erase(header["scalars"].begin() + 1, header["scalars"].end());
  return true;
}

/// The blocks that both pages still name, each content once, with the headers' offsets set to where it lies.
std::string joined_blocks(Parts& first, Parts& second) {
  std::string bytes;
  std::map<std::string_view, std::size_t> offset_of_content;
  for (Parts* page : {&first, &second})
    for (Json& block : page->header["blocks"]) {
      const auto offset = block.value("offset", std::size_t{0}), size = block.value("size", std::size_t{0});
      if (offset > page->bytes.size() || size > page->bytes.size() - offset)
        throw StageError("a page is damaged: it names data that it does not hold; make it again");
      const std::string_view content = std::string_view(page->bytes).substr(offset, size);
      const auto [place, added] = offset_of_content.try_emplace(content, bytes.size());
      if (added) bytes += content;
      block["placed"] = place->second;
    }
  return bytes;
}

std::string script(std::string_view type, std::string_view id, const std::string& content) {
  return "<script type=\"" + std::string(type) + "\" id=\"" + std::string(id) + "\">" + content + "</script>\n";
}

std::string text_of(Json header) {
  for (Json& block : header["blocks"]) {
    block["offset"] = block["placed"];
    block.erase("placed");
  }
  return json_for_html(header.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

std::string pair_pages(std::string_view first, std::string_view second, const std::array<std::string, 2>& names,
                       std::size_t max_bytes) {
  Parts here = parts_of(first, names[0]), there = parts_of(second, names[1]);
  for (const char* unused : {"trees", "outputs"}) there.header.erase(unused);
  drop_points(there.header);
  drop(there.header, {"rims", "upper_", "lower_", "interpolated"});
  std::vector<std::string> left_out;
  const auto leave_out = [&](const char* what, bool any) {
    if (any) left_out.emplace_back(what);
    return any;
  };
  for (int step = 0;; ++step) {
    const std::string bytes = joined_blocks(here, there);
    here.header["left_out"] = left_out;
    const std::string page =
        std::string(page_template()) + script("application/json", "header", text_of(here.header)) +
        script("text/plain", "blocks", base64(bytes)) +
        (here.run.empty() ? std::string() : script("application/json", "run", here.run)) +
        script("application/json", "other-header", text_of(there.header)) +
        (there.run.empty() ? std::string() : script("application/json", "other-run", there.run)) +
        script("application/json", "names", json_for_html(Json(names).dump(-1, ' ', false, Json::error_handler_t::replace)));
    if (page.size() <= max_bytes) return page;
    bool any = false;
    while (!any && step < 4) {
      if (step == 0) any = leave_out("points", drop_points(here.header));
      if (step == 1) any = leave_out("interpolated lines", drop(here.header, {"interpolated"}));
      if (step == 2) {
        const bool of_here = drop_scalars(here.header), of_there = drop_scalars(there.header);
        any = leave_out("further scalars", of_here || of_there);
      }
      if (step == 3) {
        const bool of_here = drop(here.header, {"region_borders"}), of_there = drop(there.header, {"region_borders"});
        any = leave_out("borders of regions", of_here || of_there);
      }
      if (!any) ++step;
    }
    if (!any)
      throw StageError("two such pages do not fit into one of " + std::to_string(max_bytes / 1000000) +
                       " MB; make them with fewer triangles, as --set report.max_triangles=300000");
  }
}

}  // namespace meshmser
