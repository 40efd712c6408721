#include "pipeline/stage/parameter.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace meshmser {
namespace {

// Set while key_text formats, whose paths may stand deep within lists and maps.
thread_local bool paths_as_names = false;

void problem(std::vector<Diagnostic>& problems, const ConfigValue& value, std::string message) {
  problems.push_back({value.location, std::move(message)});
}

std::string describe(const ConfigValue& value) {
  switch (value.kind) {
    case ConfigValue::Kind::kNull:
      return "nothing";
    case ConfigValue::Kind::kList:
      return "a list";
    case ConfigValue::Kind::kMap:
      return "a map";
    case ConfigValue::Kind::kScalar:
      break;
  }
  constexpr std::size_t kMost = 60;
  if (value.text.size() > kMost) return "'" + value.text.substr(0, kMost) + "...'";
  return "'" + value.text + "'";
}

std::string describe(Range bounds) {
  const bool below = std::isinf(bounds.least), above = std::isinf(bounds.greatest);
  if (below && above) return "any number";
  const std::string least = format_number(bounds.least), greatest = format_number(bounds.greatest);
  if (above) return (bounds.least_excluded ? "more than " : "at least ") + least;
  if (below) return "at most " + greatest;
  return bounds.least_excluded ? "more than " + least + " and at most " + greatest
                               : "from " + least + " to " + greatest;
}

bool in_range(const ConfigValue& value, double number, Range bounds, std::vector<Diagnostic>& problems) {
  const bool low = bounds.least_excluded ? number <= bounds.least : number < bounds.least;
  if (!low && number <= bounds.greatest) return true;
  problem(problems, value, describe(value) + " is out of range, expected " + describe(bounds));
  return false;
}

// Decimal notation only: no octal, no hexadecimal, no infinity, no NaN.
std::optional<double> read_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

// "0.4 mm", "0.4mm", "2 %": number and unit, the unit possibly empty.
bool split_quantity(std::string_view text, double& number, std::string& unit) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number)) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  unit = text;
  return true;
}

// In picometres, so that ratios of metric units are ratios of whole numbers: 400 um and 0.4 mm are the same length and
// the same cache key.
std::optional<double> picometres(std::string_view unit) {
  static constexpr std::pair<std::string_view, double> kUnits[] = {
      {"km", 1e15}, {"m", 1e12}, {"dm", 1e11},  {"cm", 1e10},   {"mm", 1e9},
      {"um", 1e6},  {"nm", 1e3}, {"in", 254e8}, {"ft", 3048e8},
  };
  for (const auto& [name, length] : kUnits)
    if (name == unit) return length;
  return std::nullopt;
}

// `number` `unit` in coordinate units; nothing where that is no unit of length or the coordinates have none.
std::optional<double> in_coordinates(double number, const std::string& unit, int power, const BindContext& context) {
  if (unit == "unit" || (!unit.empty() && unit == context.units)) return number;
  const auto from = picometres(unit), to = picometres(context.units);
  if (!from || !to) return std::nullopt;
  for (int i = 0; i < power; ++i) number = *from >= *to ? number * (*from / *to) : number / (*to / *from);
  return number;
}

struct Quantity {
  double number = 0;
  std::string unit;
};

// Number and unit, or a diagnostic that says what was expected.
std::optional<Quantity> read_quantity(const ConfigValue& value, const std::string& expected, Range bounds,
                                      std::vector<Diagnostic>& problems) {
  Quantity q;
  if (value.kind != ConfigValue::Kind::kScalar || value.quoted || !split_quantity(value.text, q.number, q.unit)) {
    problem(problems, value, describe(value) + " is not " + expected);
    return std::nullopt;
  }
  if (!in_range(value, q.number, bounds, problems)) return std::nullopt;
  return q;
}

void wrong_unit(const ConfigValue& value, const std::string& unit, const std::string& expected,
                std::vector<Diagnostic>& problems) {
  problem(problems, value,
          unit.empty() ? "'" + value.text + "' has no unit, expected " + expected
                       : "unit '" + unit + "' does not fit here, expected " + expected);
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearest_name(const std::string& word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(word, name);
    if (distance < least) {
      least = distance;
      nearest = name;
    }
  }
  return nearest;
}

std::string key_text(const Parameter& parameter, const void* parameters) {
  paths_as_names = true;
  std::string text = parameter.format(parameters);
  paths_as_names = false;
  return text;
}

std::string format_number(double value) {
  char buffer[48];
  const double size = std::abs(value);
  const bool plain = size == 0 || (size >= 1e-6 && size < 1e15);
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value == 0 ? 0.0 : value,
                                    plain ? std::chars_format::fixed : std::chars_format::general);
  return std::string(buffer, result.ptr);
}

void bind_map(const ConfigValue& map, const std::vector<Parameter>& parameters, const BindContext& context,
              const std::string& what, void* target, std::vector<Diagnostic>& problems) {
  if (map.kind == ConfigValue::Kind::kNull) return;
  if (map.kind != ConfigValue::Kind::kMap) {
    problem(problems, map, describe(map) + " is not a map of parameters, expected {key: value, ...}");
    return;
  }
  for (std::size_t i = 0; i < map.entries.size(); ++i) {
    const std::string& key = map.entries[i].first;
    const auto found =
        std::find_if(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.name == key; });
    if (found != parameters.end()) {
      found->bind(map.entries[i].second, context, target, problems);
      continue;
    }
    std::vector<std::string> names;
    for (const Parameter& p : parameters) names.push_back(p.name);
    const std::string nearest = nearest_name(key, names);
    problems.push_back({map.key_locations[i], "unknown key '" + key + "' in " + what +
                                                  (nearest.empty() ? "" : ", did you mean '" + nearest + "'?")});
  }
}

namespace detail {

bool is_word(const ConfigValue& value, const char* word) {
  return value.kind == ConfigValue::Kind::kScalar && !value.quoted && value.text == word;
}

bool bind_integer(const ConfigValue& value, Range bounds, std::int64_t least, std::int64_t greatest,
                  std::int64_t& number, std::vector<Diagnostic>& problems) {
  std::string_view text = value.text;
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const std::string_view digits = !text.empty() && text.front() == '-' ? text.substr(1) : text;
  const bool whole =
      !digits.empty() && std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (value.kind != ConfigValue::Kind::kScalar || value.quoted || !whole) {
    problem(problems, value, describe(value) + " is not a whole number");
    return false;
  }
  if (digits.size() > 1 && digits.front() == '0') {
    problem(problems, value,
            "'" + value.text + "' begins with 0; write a whole number in decimal without leading zeros");
    return false;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < least || number > greatest) {
    problem(problems, value, "'" + value.text + "' is too large a number");
    return false;
  }
  return in_range(value, static_cast<double>(number), bounds, problems);
}

bool bind_number(const ConfigValue& value, Range bounds, double& number, std::vector<Diagnostic>& problems) {
  const auto read = value.kind == ConfigValue::Kind::kScalar && !value.quoted ? read_number(value.text) : std::nullopt;
  if (!read) {
    problem(problems, value, describe(value) + " is not a finite number");
    return false;
  }
  if (!in_range(value, *read, bounds, problems)) return false;
  number = *read;
  return true;
}

bool bind_boolean(const ConfigValue& value, bool& target, std::vector<Diagnostic>& problems) {
  if (is_word(value, "true") || is_word(value, "false")) {
    target = value.text == "true";
    return true;
  }
  problem(problems, value, describe(value) + " is not true or false");
  return false;
}

bool bind_text(const ConfigValue& value, std::string& target, std::vector<Diagnostic>& problems) {
  if (value.kind != ConfigValue::Kind::kScalar) {
    problem(problems, value, describe(value) + " is not text");
    return false;
  }
  target = value.text;
  return true;
}

bool bind_choice(const ConfigValue& value, const std::vector<std::string>& choices, std::size_t& index,
                 std::vector<Diagnostic>& problems) {
  if (value.kind == ConfigValue::Kind::kScalar)
    for (index = 0; index < choices.size(); ++index)
      if (choices[index] == value.text) return true;
  std::string list;
  for (const std::string& choice : choices) list += (list.empty() ? "" : ", ") + choice;
  const std::string nearest = value.kind == ConfigValue::Kind::kScalar ? nearest_name(value.text, choices) : "";
  problem(problems, value,
          describe(value) + " is not one of " + list + (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
  return false;
}

bool expect_list(const ConfigValue& value, std::optional<std::size_t> size, std::vector<Diagnostic>& problems) {
  if (value.kind != ConfigValue::Kind::kList) {
    problem(problems, value,
            describe(value) + " is not " + (size ? "a list of " + std::to_string(*size) + " values" : "a list"));
    return false;
  }
  if (size && value.items.size() != *size) {
    problem(problems, value,
            "a list of " + std::to_string(value.items.size()) + " values, expected " + std::to_string(*size));
    return false;
  }
  return true;
}

void bind(const ConfigValue& value, const BindContext& context, Range bounds, Length& target,
          std::vector<Diagnostic>& problems) {
  const std::string expected = "a length such as '0.4 " + context.units + "', '3 spacing' or '0.5 %diag'";
  const auto q = read_quantity(value, expected, bounds, problems);
  if (!q) return;
  if (q->unit == "spacing")
    target = {q->number, Length::Unit::kSpacing};
  else if (q->unit == "%diag")
    target = {q->number, Length::Unit::kDiagonalPercent};
  else if (const auto length = in_coordinates(q->number, q->unit, 1, context))
    target = {*length, Length::Unit::kCoordinate};
  else
    wrong_unit(value, q->unit, expected, problems);
}

void bind(const ConfigValue& value, const BindContext& context, Range bounds, Area& target,
          std::vector<Diagnostic>& problems) {
  const std::string expected = "an area such as '1 " + context.units + "2', '200 spacing2' or '0.1 %area'";
  const auto q = read_quantity(value, expected, bounds, problems);
  if (!q) return;
  const bool squared = q->unit.size() > 1 && q->unit.back() == '2';
  const std::string side = squared ? q->unit.substr(0, q->unit.size() - 1) : "";
  if (q->unit == "spacing2")
    target = {q->number, Area::Unit::kSpacing2};
  else if (q->unit == "%area")
    target = {q->number, Area::Unit::kAreaPercent};
  else if (const auto area = in_coordinates(q->number, side, 2, context); area && squared)
    target = {*area, Area::Unit::kCoordinate2};
  else
    wrong_unit(value, q->unit, expected, problems);
}

void bind(const ConfigValue& value, const BindContext&, Range bounds, Amount& target,
          std::vector<Diagnostic>& problems) {
  const std::string expected = "an amount of the scalar such as '6 noise', or a plain number in the scalar's own unit";
  const auto q = read_quantity(value, expected, bounds, problems);
  if (!q) return;
  if (q->unit == "noise")
    target = {q->number, Amount::Unit::kNoise};
  else if (q->unit.empty())
    target = {q->number, Amount::Unit::kScalar};
  else
    wrong_unit(value, q->unit, expected, problems);
}

void bind(const ConfigValue& value, const BindContext&, Range bounds, Angle& target,
          std::vector<Diagnostic>& problems) {
  const std::string expected = "an angle such as '5 deg'";
  const auto q = read_quantity(value, expected, bounds, problems);
  if (!q) return;
  if (q->unit == "deg")
    target = {q->number};
  else
    wrong_unit(value, q->unit, expected, problems);
}

void bind(const ConfigValue& value, const BindContext&, Range bounds, Share& target,
          std::vector<Diagnostic>& problems) {
  const std::string expected = "a share such as '2 %' or '0.02'";
  const auto q = read_quantity(value, expected, Range{}, problems);
  if (!q) return;
  if (!q->unit.empty() && q->unit != "%") return wrong_unit(value, q->unit, expected, problems);
  const double share = q->unit == "%" ? q->number / 100 : q->number;
  if (in_range(value, share, bounds, problems)) target = {share};
}

void bind(const ConfigValue& value, const BindContext& context, Range, InputPath& target,
          std::vector<Diagnostic>& problems) {
  std::string text;
  if (!bind_text(value, text, problems)) return;
  if (text.empty()) return problem(problems, value, "the path of a file is missing");
  const std::filesystem::path path(text);
  const std::filesystem::path whole = path.is_absolute() ? path : std::filesystem::path(context.base_directory) / path;
  target = {text, whole.lexically_normal().string()};
}

std::string format(const Length& value) {
  static constexpr const char* kUnits[] = {" unit", " spacing", " %diag"};
  return format_number(value.value) + kUnits[static_cast<int>(value.unit)];
}
std::string format(const Area& value) {
  static constexpr const char* kUnits[] = {" unit2", " spacing2", " %area"};
  return format_number(value.value) + kUnits[static_cast<int>(value.unit)];
}
std::string format(const Amount& value) {
  return format_number(value.value) + (value.unit == Amount::Unit::kNoise ? " noise" : "");
}
std::string format(const Angle& value) {
  return format_number(value.degrees) + " deg";
}
std::string format(const Share& value) {
  return format_number(value.value);
}
std::string format(const InputPath& value) {
  return quote(paths_as_names ? std::filesystem::path(value.text).filename().string() : value.text);
}

std::string quote(const std::string& text) {
  static constexpr std::string_view kWords[] = {"true", "false", "null", "~", "none", "auto"};
  const bool plain = !text.empty() && text.find_first_of(":#{}[],&*!|>'\"%@`\\\n\t ") == std::string::npos &&
                     text.front() != '-' && text.front() != '?' && !read_number(text) &&
                     std::find(std::begin(kWords), std::end(kWords), text) == std::end(kWords);
  if (plain) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else if (c == '\t')
      quoted += "\\t";
    else
      quoted += c;
  }
  return quoted + "\"";
}

double random_number(Range bounds, std::mt19937_64& random) {
  const double least = std::max(bounds.least, -1000.0);
  const double greatest = std::isinf(bounds.greatest) ? least + 1000 : bounds.greatest;
  const double share = (static_cast<double>(random() % 1000) + 1) / 1001;  // never an end, which may be excluded
  return least + (greatest - least) * share;
}

std::int64_t random_integer(Range bounds, std::mt19937_64& random) {
  const auto least = static_cast<std::int64_t>(std::max(bounds.least, -1000.0)) + (bounds.least_excluded ? 1 : 0);
  const auto greatest = static_cast<std::int64_t>(std::min(bounds.greatest, static_cast<double>(least) + 1000.0));
  return least + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(greatest - least + 1));
}

}  // namespace detail
}  // namespace meshmser
