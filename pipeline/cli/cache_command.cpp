#include "pipeline/cache/cache.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "pipeline/cli/commands.hpp"
#include "pipeline/cli/common_options.hpp"
#include "pipeline/run/runner.hpp"

namespace meshmser {
namespace {

std::string size_text(std::uint64_t bytes) {
  constexpr const char* kUnits[] = {"B", "kB", "MB", "GB", "TB"};
  double size = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; size >= 1000 && unit + 1 < std::size(kUnits); ++unit) size /= 1000;
  return fmt::format("{:.{}f} {}", size, unit == 0 ? 0 : 1, kUnits[unit]);
}

// The number before a unit of `units`, times its factor.
double amount_of(const std::string& option, const std::string& text,
                 const std::vector<std::pair<std::string, double>>& units) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  std::string unit(end, text.data() + text.size());
  unit.erase(0, unit.find_first_not_of(' '));
  std::string known;
  for (const auto& [name, factor] : units) {
    if (error == std::errc() && std::isfinite(number) && number >= 0 && unit == name) return number * factor;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw UsageError(fmt::format("cache: {} '{}' is not a number with one of the units {}", option, text, known));
}

std::filesystem::path cache_folder(const CommandArguments& arguments) {
  if (arguments.find("--cache") != nullptr) return arguments.get("--cache");
  if (arguments.find("CONFIG") != nullptr) return default_cache_folder(load_configuration(arguments.get("CONFIG")));
  if (const char* named = std::getenv("MESHMSER_CACHE"); named != nullptr && *named != '\0') return named;
  throw UsageError("cache: which one? Give CONFIG, or --cache FOLDER, or set MESHMSER_CACHE");
}

int list(Cache& cache) {
  std::uint64_t sum = 0;
  const std::vector<EntryListing> entries = cache.list();
  for (const EntryListing& entry : entries) {
    const auto used = static_cast<std::time_t>(entry.used_ns / 1'000'000'000);
    fmt::print("{:<12} {}  {:>10}  {:%Y-%m-%d %H:%M}  {}\n", entry.stage, entry.key.substr(0, 12),
               size_text(entry.size), fmt::localtime(used), entry.folder.string());
    sum += entry.size;
  }
  fmt::print("{} entries, {}, in {}\n", entries.size(), size_text(sum), cache.folder().string());
  return 0;
}

// Damaged entries are set aside, so that the next run makes them again.
int verify(Cache& cache, const Execution& execution) {
  std::size_t damaged = 0;
  const std::vector<EntryListing> entries = cache.list();
  for (const EntryListing& entry : entries) {
    execution.check();
    try {
      cache.verify(entry.stage, entry.key, execution.threads);
    } catch (const EntryDamaged& error) {
      ++damaged;
      fmt::print("{} {}: {}; set aside\n", entry.stage, entry.key.substr(0, 12), error.what());
      cache.set_aside(entry.stage, entry.key);
    }
  }
  fmt::print("{} entries, {} damaged\n", entries.size(), damaged);
  return damaged == 0 ? 0 : static_cast<int>(ExitCode::kCache);
}

int collect(Cache& cache, const CommandArguments& arguments) {
  GarbageLimits limits;
  if (arguments.find("--older") != nullptr)
    limits.max_age_days =
        amount_of("--older", arguments.get("--older"), {{"d", 1}, {"h", 1.0 / 24}, {"w", 7}, {"min", 1.0 / 1440}});
  if (arguments.find("--max-size") != nullptr)
    limits.max_size = static_cast<std::uint64_t>(
        amount_of("--max-size", arguments.get("--max-size"), {{"GB", 1e9}, {"MB", 1e6}, {"kB", 1e3}, {"TB", 1e12}}));
  if (!limits.max_age_days && !limits.max_size) limits.max_age_days = 30;
  const GarbageReport report = collect_garbage(cache, limits);
  fmt::print("removed {} entries ({}), kept {} ({})\n", report.num_removed, size_text(report.bytes_removed),
             report.num_kept, size_text(report.bytes_kept));
  return 0;
}

int work_on_cache(const CommandArguments& arguments, CommandHost& host) {
  const std::string action = arguments.get("ACTION");
  if (action != "gc" && (arguments.find("--older") != nullptr || arguments.find("--max-size") != nullptr))
    throw UsageError("cache: --older and --max-size belong to gc");
  Cache cache(cache_folder(arguments));
  if (action == "ls") return list(cache);
  if (action == "verify") return verify(cache, host.execution());
  if (action == "gc") return collect(cache, arguments);
  cache.clear();
  return 0;
}

}  // namespace

CommandDefinition cache_command() {
  return {.name = "cache",
          .purpose = "Lists, verifies, tidies or empties the cache of a configuration.",
          .options = {{.name = "ACTION",
                       .description = "ls: the entries; verify: each file against its checksum; gc: removes what was "
                                      "not used for long; clear: removes all",
                       .required = true,
                       .choices = {"ls", "verify", "gc", "clear"}},
                      {"CONFIG", "a configuration (.yaml), whose cache is meant"},
                      cache_option(),
                      {"--older", "gc: entries not used for this long, as '30 d' (without --max-size: 30 d)"},
                      {"--max-size", "gc: what was used longest ago goes until the rest fits, as '2 GB'"}},
          .run = work_on_cache,
          .example = "meshmser cache gc configs/demo.yaml --max-size '2 GB'"};
}

}  // namespace meshmser
