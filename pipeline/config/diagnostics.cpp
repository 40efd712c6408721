#include "pipeline/config/diagnostics.hpp"

#include <algorithm>
#include <string_view>
#include <tuple>

namespace meshmser {
namespace {

std::string_view line_of(std::string_view source, int line) {
  for (; line > 1; --line) {
    const std::size_t end = source.find('\n');
    if (end == std::string_view::npos) return {};
    source.remove_prefix(end + 1);
  }
  source = source.substr(0, source.find('\n'));
  if (!source.empty() && source.back() == '\r') source.remove_suffix(1);
  return source;
}

bool continues_character(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

// The line (or, where it is very long, the part around the column) and below it the caret. Columns count bytes; the
// caret stands under the character, so multi-byte characters before it take one place each and tabs stay tabs.
std::string excerpt(std::string_view line, int column) {
  constexpr std::size_t kBefore = 60, kWidth = 110;
  std::size_t at = std::min(static_cast<std::size_t>(std::max(column, 1) - 1), line.size());
  bool cut_front = false;
  if (line.size() > kWidth && at > kBefore) {
    std::size_t cut = at - kBefore;
    while (cut < at && continues_character(line[cut])) ++cut;
    line.remove_prefix(cut);
    at -= cut;
    cut_front = true;
  }
  bool cut_back = false;
  if (line.size() > kWidth) {
    std::size_t end = kWidth;
    while (end > at && continues_character(line[end])) --end;
    line = line.substr(0, end);
    cut_back = true;
  }
  std::string padding;
  for (const char c : line.substr(0, at))
    if (!continues_character(c)) padding += c == '\t' ? '\t' : ' ';
  const std::string front = cut_front ? "..." : "";
  return "  " + front + std::string(line) + (cut_back ? "..." : "") + "\n  " + (cut_front ? "   " : "") + padding + "^";
}

}  // namespace

void sort_diagnostics(std::vector<Diagnostic>& diagnostics) {
  const auto key = [](const Diagnostic& d) {
    return std::tuple(d.location.line == 0, d.location.line, d.location.column);
  };
  std::stable_sort(diagnostics.begin(), diagnostics.end(),
                   [&](const Diagnostic& a, const Diagnostic& b) { return key(a) < key(b); });
  const auto same = [&](const Diagnostic& a, const Diagnostic& b) {
    return key(a) == key(b) && a.location.file == b.location.file && a.message == b.message;
  };
  diagnostics.erase(std::unique(diagnostics.begin(), diagnostics.end(), same), diagnostics.end());
}

std::string render_diagnostics(const std::vector<Diagnostic>& diagnostics, const std::string& source) {
  std::string text;
  for (const auto& [location, message] : diagnostics) {
    if (!text.empty()) text += '\n';
    text += location.file;
    if (location.line > 0) text += ':' + std::to_string(location.line) + ':' + std::to_string(location.column);
    text += ": " + message;
    const std::string_view line = location.line > 0 ? line_of(source, location.line) : std::string_view();
    if (!line.empty()) text += '\n' + excerpt(line, location.column);
  }
  return text;
}

}  // namespace meshmser
