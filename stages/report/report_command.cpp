/// `meshmser report`: the page of a run, or one page of two.

#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "pipeline/formats/output_file.hpp"
#include "pipeline/stage/command.hpp"
#include "stages/report/pair_pages.hpp"

namespace meshmser {
namespace {

namespace fs = std::filesystem;

RunRequest request_of(const CommandArguments& arguments, const std::string& config) {
  RunRequest request{.config_path = config, .cache = arguments.get("--cache"), .last_stage = "report"};
  if (const auto* set = arguments.find("--set")) request.set = *set;
  request.quiet = arguments.find("--quiet") != nullptr;
  return request;
}

/// The page of a run's folder, a page itself, or that of a configuration, which is run.
fs::path page_of(const CommandArguments& arguments, const std::string& given, CommandHost& host) {
  if (fs::is_directory(given)) {
    const fs::path page = fs::path(given) / "report.html";
    if (!fs::exists(page))
      throw UsageError("report: " + given + " holds no report.html; make one with meshmser report CONFIG --out " +
                       given);
    return page;
  }
  if (fs::path(given).extension() == ".html") return given;
  const std::vector<fs::path> files = host.run(request_of(arguments, given));
  return files.back();
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw UsageError("report: cannot read " + path.string());
  std::ostringstream text;
  text << file.rdbuf();
  return std::move(text).str();
}

/// A path's last part, the folder's where it ends in a slash.
std::string short_name(const fs::path& path) {
  return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
}

int run_report(const CommandArguments& arguments, CommandHost& host) {
  const std::string first = arguments.get("CONFIG"), second = arguments.get("OTHER");
  if (second.empty()) {
    RunRequest request = request_of(arguments, first);
    request.out = arguments.get("--out");
    for (const fs::path& file : host.run(request)) std::printf("%s\n", file.c_str());
    return 0;
  }
  const fs::path pages[] = {page_of(arguments, first, host), page_of(arguments, second, host)};
  std::array<std::string, 2> names = {short_name(first), short_name(second)};
  if (names[0] == names[1]) names = {first, second};
  const std::string page = pair_pages(text_of(pages[0]), text_of(pages[1]), names);
  const fs::path out = fs::path(arguments.get("--out", ".")) / "comparison.html";
  fs::create_directories(out.parent_path());
  OutputFile file(out);
  file.text(page);
  file.finish();
  std::printf("%s\n", out.c_str());
  return 0;
}

CommandDefinition definition() {
  return {
      .name = "report",
      .purpose =
          "Runs a configuration, with the stage 'report' at its end where it has none, or puts two runs on "
          "one page beside each other. Prints the page.",
      .options = {{"CONFIG", "a configuration (.yaml); of two runs also a run's folder or its report.html", true},
                  {"OTHER", "the second of two runs: a configuration, a run's folder or its report.html"},
                  set_option(),
                  {"--out",
                   "folder of the results (without: CONFIG's name with -out); of two runs that of "
                   "comparison.html (without: the current one)"},
                  cache_option(),
                  {.name = "--quiet,-q", .description = "no progress: warnings, and the page it wrote", .flag = true}},
      .run = run_report,
      .example = "meshmser report configs/demo.yaml --out /tmp/demo"};
}

MESHMSER_COMMAND(report, definition());

}  // namespace
}  // namespace meshmser
