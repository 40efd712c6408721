#pragma once
/// A stage's parameters, declared once: binding, cache key, help, JSON Schema, tables and random tests come of it.

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipeline/stage/config_value.hpp"
#include "pipeline/stage/quantities.hpp"

namespace meshmser {

/// What binding needs to know of the configuration around a value.
struct BindContext {
  std::string units = "unit";  ///< of the coordinates: mm, m, in ...; "unit" where they have none
  std::string base_directory;  ///< paths are relative to it
};

/// Bounds of a number (of a quantity's value, of each element of a list).
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();
  bool least_excluded = false;
};
inline Range range(double least, double greatest) {
  return {least, greatest, false};
}
inline Range at_least(double least) {
  return {least, std::numeric_limits<double>::infinity(), false};
}
inline Range more_than(double least) {
  return {least, std::numeric_limits<double>::infinity(), true};
}

enum class ParameterKind {
  kInteger,
  kNumber,
  kBoolean,
  kText,
  kChoice,
  kLength,
  kArea,
  kAmount,
  kAngle,
  kShare,
  kPath,
  kList,
  kMap
};

struct Parameter;

/// The type of a parameter, as help and schema tell it.
struct ParameterShape {
  ParameterKind kind = ParameterKind::kText;
  std::vector<std::string> choices{};                ///< of kChoice
  std::vector<std::string> words{};                  ///< words accepted beside the type's own values: none, auto
  std::shared_ptr<ParameterShape> element{};         ///< of kList
  std::optional<std::size_t> size{};                 ///< of kList: outright number of elements
  std::shared_ptr<std::vector<Parameter>> fields{};  ///< of kMap
};

/// One declared parameter. The closures work on a `Parameters` struct of the stage.
struct Parameter {
  std::string name;
  Range range;
  std::string unit;            ///< what the number counts: "points", "levels"; quantities carry their unit themselves
  std::string description;     ///< one sentence
  bool affects_result = true;  ///< false: not part of the cache key
  ParameterShape shape;
  /// Sets the member from what a configuration says; adds a diagnostic for each thing wrong and then leaves it as it
  /// was.
  std::function<void(const ConfigValue&, const BindContext&, void* parameters, std::vector<Diagnostic>&)> bind;
  /// The value as it could stand in a configuration, lengths in coordinate units as `0.4 unit`. Equal values, equal
  /// texts.
  std::function<std::string(const void* parameters)> format;
  /// Sets a random valid value.
  std::function<void(void* parameters, std::mt19937_64&)> randomize;
  std::string default_text;  ///< format() of the defaults
};

/// Names of an enum's values; specialise beside the enum:
/// template <> struct EnumNames<Polarity> { static constexpr std::pair<Polarity, const char*> values[] = {...}; };
template <class E>
struct EnumNames;

template <class T>
struct ParameterType;  // shape(), bind(), format(), randomize() of a member's type

/// Collects declarations.
class Schema {
 public:
  template <class P, class T>
  Parameter& parameter(std::string_view name, T P::*member, Range bounds, std::string_view unit,
                       std::string_view description) {
    Parameter p;
    p.name = name;
    p.range = bounds;
    p.unit = unit;
    p.description = description;
    p.shape = ParameterType<T>::shape();
    p.bind = [member, bounds](const ConfigValue& value, const BindContext& context, void* parameters,
                              std::vector<Diagnostic>& problems) {
      T bound{};
      const std::size_t before = problems.size();
      ParameterType<T>::bind(value, context, bounds, bound, problems);
      if (problems.size() == before) static_cast<P*>(parameters)->*member = std::move(bound);
    };
    p.format = [member](const void* parameters) {
      return ParameterType<T>::format(static_cast<const P*>(parameters)->*member);
    };
    p.randomize = [member, bounds](void* parameters, std::mt19937_64& random) {
      static_cast<P*>(parameters)->*member = ParameterType<T>::randomize(bounds, random);
    };
    const P defaults{};
    p.default_text = p.format(&defaults);
    parameters_.push_back(std::move(p));
    return parameters_.back();
  }
  template <class P, class T>
  Parameter& parameter(std::string_view name, T P::*member, std::string_view description) {
    return parameter(name, member, Range{}, "", description);
  }
  std::vector<Parameter>& parameters() { return parameters_; }

 private:
  std::vector<Parameter> parameters_;
};

/// Binds a map's entries to parameters: unknown keys (with the nearest known one) and wrong values are diagnostics.
/// `what` names the owner in messages, as "stage 'orient'".
void bind_map(const ConfigValue& map, const std::vector<Parameter>& parameters, const BindContext& context,
              const std::string& what, void* target, std::vector<Diagnostic>& problems);

/// The known name nearest to `word` within an edit distance that a slip of the finger explains; empty: none is near.
std::string nearest_name(const std::string& word, const std::vector<std::string>& known);

/// The value as it belongs into a cache key: format(), but of a path the file's name alone, so that a folder may move.
std::string key_text(const Parameter& parameter, const void* parameters);

/// Shortest text that reads back as the same double.
std::string format_number(double value);

namespace detail {
// Each adds a diagnostic and returns false where the value is not of the type or out of bounds.
bool bind_integer(const ConfigValue&, Range, std::int64_t least, std::int64_t greatest, std::int64_t&,
                  std::vector<Diagnostic>&);
bool bind_number(const ConfigValue&, Range, double&, std::vector<Diagnostic>&);
bool bind_boolean(const ConfigValue&, bool&, std::vector<Diagnostic>&);
bool bind_text(const ConfigValue&, std::string&, std::vector<Diagnostic>&);
bool bind_choice(const ConfigValue&, const std::vector<std::string>& choices, std::size_t& index,
                 std::vector<Diagnostic>&);
void bind(const ConfigValue&, const BindContext&, Range, Length&, std::vector<Diagnostic>&);
void bind(const ConfigValue&, const BindContext&, Range, Area&, std::vector<Diagnostic>&);
void bind(const ConfigValue&, const BindContext&, Range, Amount&, std::vector<Diagnostic>&);
void bind(const ConfigValue&, const BindContext&, Range, Angle&, std::vector<Diagnostic>&);
void bind(const ConfigValue&, const BindContext&, Range, Share&, std::vector<Diagnostic>&);
void bind(const ConfigValue&, const BindContext&, Range, InputPath&, std::vector<Diagnostic>&);
bool expect_list(const ConfigValue&, std::optional<std::size_t> size, std::vector<Diagnostic>&);
std::string format(const Length&);
std::string format(const Area&);
std::string format(const Amount&);
std::string format(const Angle&);
std::string format(const Share&);
std::string format(const InputPath&);
std::string quote(const std::string&);
double random_number(Range, std::mt19937_64&);
std::int64_t random_integer(Range, std::mt19937_64&);
bool is_word(const ConfigValue& value, const char* word);
}  // namespace detail

template <class T>
requires(std::is_integral_v<T> && !std::is_same_v<T, bool>) struct ParameterType<T> {
  static ParameterShape shape() { return {.kind = ParameterKind::kInteger}; }
  static void bind(const ConfigValue& value, const BindContext&, Range bounds, T& target,
                   std::vector<Diagnostic>& problems) {
    std::int64_t number = 0;
    constexpr bool kWide = sizeof(T) == 8;
    constexpr std::int64_t kLeast = static_cast<std::int64_t>(std::numeric_limits<T>::min());
    constexpr std::int64_t kGreatest =
        kWide ? std::numeric_limits<std::int64_t>::max() : static_cast<std::int64_t>(std::numeric_limits<T>::max());
    if (detail::bind_integer(value, bounds, kLeast, kGreatest, number, problems)) target = static_cast<T>(number);
  }
  static std::string format(const T& value) { return std::to_string(value); }
  static T randomize(Range bounds, std::mt19937_64& random) {
    return static_cast<T>(detail::random_integer(bounds, random));
  }
};

template <>
struct ParameterType<double> {
  static ParameterShape shape() { return {.kind = ParameterKind::kNumber}; }
  static void bind(const ConfigValue& value, const BindContext&, Range bounds, double& target,
                   std::vector<Diagnostic>& problems) {
    detail::bind_number(value, bounds, target, problems);
  }
  static std::string format(double value) { return format_number(value); }
  static double randomize(Range bounds, std::mt19937_64& random) { return detail::random_number(bounds, random); }
};

template <>
struct ParameterType<bool> {
  static ParameterShape shape() { return {.kind = ParameterKind::kBoolean}; }
  static void bind(const ConfigValue& value, const BindContext&, Range, bool& target,
                   std::vector<Diagnostic>& problems) {
    detail::bind_boolean(value, target, problems);
  }
  static std::string format(bool value) { return value ? "true" : "false"; }
  static bool randomize(Range, std::mt19937_64& random) { return random() % 2 == 0; }
};

template <>
struct ParameterType<std::string> {
  static ParameterShape shape() { return {.kind = ParameterKind::kText}; }
  static void bind(const ConfigValue& value, const BindContext&, Range, std::string& target,
                   std::vector<Diagnostic>& problems) {
    detail::bind_text(value, target, problems);
  }
  static std::string format(const std::string& value) { return detail::quote(value); }
  static std::string randomize(Range, std::mt19937_64& random) { return "name" + std::to_string(random() % 1000); }
};

template <class E>
requires std::is_enum_v<E>
struct ParameterType<E> {
  static std::vector<std::string> names() {
    std::vector<std::string> all;
    for (const auto& [value, name] : EnumNames<E>::values) all.emplace_back(name);
    return all;
  }
  static ParameterShape shape() { return {.kind = ParameterKind::kChoice, .choices = names()}; }
  static void bind(const ConfigValue& value, const BindContext&, Range, E& target, std::vector<Diagnostic>& problems) {
    std::size_t index = 0;
    if (detail::bind_choice(value, names(), index, problems)) target = std::begin(EnumNames<E>::values)[index].first;
  }
  static std::string format(const E& value) {
    for (const auto& [known, name] : EnumNames<E>::values)
      if (known == value) return name;
    return "?";
  }
  static E randomize(Range, std::mt19937_64& random) {
    return std::begin(EnumNames<E>::values)[random() % std::size(EnumNames<E>::values)].first;
  }
};

template <class Q, ParameterKind kKind>
struct QuantityType {
  static ParameterShape shape() { return {.kind = kKind}; }
  static void bind(const ConfigValue& value, const BindContext& context, Range bounds, Q& target,
                   std::vector<Diagnostic>& problems) {
    detail::bind(value, context, bounds, target, problems);
  }
  static std::string format(const Q& value) { return detail::format(value); }
  static Q randomize(Range bounds, std::mt19937_64& random) {
    Q quantity{};
    if constexpr (requires { quantity.degrees; })
      quantity.degrees = detail::random_number(bounds, random);
    else
      quantity.value = detail::random_number(bounds, random);
    if constexpr (requires { quantity.unit; }) quantity.unit = static_cast<decltype(quantity.unit)>(random() % 2);
    return quantity;
  }
};
template <>
struct ParameterType<Length> : QuantityType<Length, ParameterKind::kLength> {};
template <>
struct ParameterType<Area> : QuantityType<Area, ParameterKind::kArea> {};
template <>
struct ParameterType<Amount> : QuantityType<Amount, ParameterKind::kAmount> {};
template <>
struct ParameterType<Angle> : QuantityType<Angle, ParameterKind::kAngle> {};
template <>
struct ParameterType<Share> : QuantityType<Share, ParameterKind::kShare> {};

template <>
struct ParameterType<InputPath> {
  static ParameterShape shape() { return {.kind = ParameterKind::kPath}; }
  static void bind(const ConfigValue& value, const BindContext& context, Range bounds, InputPath& target,
                   std::vector<Diagnostic>& problems) {
    detail::bind(value, context, bounds, target, problems);
  }
  static std::string format(const InputPath& value) { return detail::format(value); }
  static InputPath randomize(Range, std::mt19937_64& random) {
    const std::string name = "scan" + std::to_string(random() % 1000) + ".ply";
    return {name, name};
  }
};

/// `none`, or a value.
template <class T>
struct ParameterType<std::optional<T>> {
  static ParameterShape shape() {
    ParameterShape inner = ParameterType<T>::shape();
    inner.words.insert(inner.words.begin(), "none");
    return inner;
  }
  static void bind(const ConfigValue& value, const BindContext& context, Range bounds, std::optional<T>& target,
                   std::vector<Diagnostic>& problems) {
    target.reset();
    if (detail::is_word(value, "none")) return;
    T inner{};
    ParameterType<T>::bind(value, context, bounds, inner, problems);
    target = std::move(inner);
  }
  static std::string format(const std::optional<T>& value) { return value ? ParameterType<T>::format(*value) : "none"; }
  static std::optional<T> randomize(Range bounds, std::mt19937_64& random) {
    if (random() % 4 == 0) return std::nullopt;
    return ParameterType<T>::randomize(bounds, random);
  }
};

template <class T>
struct ParameterType<AutoOr<T>> {
  static ParameterShape shape() {
    ParameterShape inner = ParameterType<T>::shape();
    inner.words.insert(inner.words.begin(), "auto");
    return inner;
  }
  static void bind(const ConfigValue& value, const BindContext& context, Range bounds, AutoOr<T>& target,
                   std::vector<Diagnostic>& problems) {
    target = AutoOr<T>();
    if (detail::is_word(value, "auto")) return;
    T inner{};
    ParameterType<T>::bind(value, context, bounds, inner, problems);
    target = AutoOr<T>(std::move(inner));
  }
  static std::string format(const AutoOr<T>& value) {
    return value.automatic ? "auto" : ParameterType<T>::format(value.value);
  }
  static AutoOr<T> randomize(Range bounds, std::mt19937_64& random) {
    if (random() % 4 == 0) return AutoOr<T>();
    return AutoOr<T>(ParameterType<T>::randomize(bounds, random));
  }
};

template <class T>
struct ParameterType<std::vector<T>> {
  static ParameterShape shape() {
    return {.kind = ParameterKind::kList, .element = std::make_shared<ParameterShape>(ParameterType<T>::shape())};
  }
  static void bind(const ConfigValue& value, const BindContext& context, Range bounds, std::vector<T>& target,
                   std::vector<Diagnostic>& problems) {
    if (!detail::expect_list(value, std::nullopt, problems)) return;
    for (const ConfigValue& item : value.items) {
      T element{};
      ParameterType<T>::bind(item, context, bounds, element, problems);
      target.push_back(std::move(element));
    }
  }
  static std::string format(const std::vector<T>& value) {
    std::string text = "[";
    for (std::size_t i = 0; i < value.size(); ++i) text += (i ? ", " : "") + ParameterType<T>::format(value[i]);
    return text + "]";
  }
  static std::vector<T> randomize(Range bounds, std::mt19937_64& random) {
    std::vector<T> values;
    for (std::size_t n = random() % 4; n > 0; --n) values.push_back(ParameterType<T>::randomize(bounds, random));
    return values;
  }
};

template <class T, std::size_t N>
struct ParameterType<std::array<T, N>> {
  static ParameterShape shape() {
    return {.kind = ParameterKind::kList,
            .element = std::make_shared<ParameterShape>(ParameterType<T>::shape()),
            .size = N};
  }
  static void bind(const ConfigValue& value, const BindContext& context, Range bounds, std::array<T, N>& target,
                   std::vector<Diagnostic>& problems) {
    if (!detail::expect_list(value, N, problems)) return;
    for (std::size_t i = 0; i < N; ++i) ParameterType<T>::bind(value.items[i], context, bounds, target[i], problems);
  }
  static std::string format(const std::array<T, N>& value) {
    return ParameterType<std::vector<T>>::format({value.begin(), value.end()});
  }
  static std::array<T, N> randomize(Range bounds, std::mt19937_64& random) {
    std::array<T, N> values;
    for (T& value : values) value = ParameterType<T>::randomize(bounds, random);
    return values;
  }
};

/// A map: a struct that declares its own parameters.
template <class T>
requires requires(Schema& schema) {
  T::declare(schema);
}
struct ParameterType<T> {
  static const std::vector<Parameter>& fields() {
    static const std::vector<Parameter> all = [] {
      Schema schema;
      T::declare(schema);
      return schema.parameters();
    }();
    return all;
  }
  static ParameterShape shape() {
    return {.kind = ParameterKind::kMap, .fields = std::make_shared<std::vector<Parameter>>(fields())};
  }
  static void bind(const ConfigValue& value, const BindContext& context, Range, T& target,
                   std::vector<Diagnostic>& problems) {
    bind_map(value, fields(), context, "this map", &target, problems);
  }
  static std::string format(const T& value) {
    std::string text = "{";
    for (const Parameter& field : fields())
      text += (text.size() > 1 ? ", " : "") + field.name + ": " + field.format(&value);
    return text + "}";
  }
  static T randomize(Range, std::mt19937_64& random) {
    T value{};
    for (const Parameter& field : fields()) field.randomize(&value, random);
    return value;
  }
};

}  // namespace meshmser
