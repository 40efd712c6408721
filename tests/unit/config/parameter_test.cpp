#include "pipeline/stage/parameter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/config/yaml.hpp"

namespace meshmser {
namespace {

// A value of type T bound from YAML; the messages where it cannot be.
template <class T>
std::string bound(const std::string& yaml, const std::string& units = "mm", Range bounds = {}) {
  std::vector<Diagnostic> problems;
  const ConfigValue value = read_yaml(yaml, "test", problems);
  T target{};
  ParameterType<T>::bind(value, {units, "/scans"}, bounds, target, problems);
  std::string messages;
  for (const Diagnostic& problem : problems) messages += problem.message;
  return problems.empty() ? ParameterType<T>::format(target) : "error: " + messages;
}

TEST(FormatNumber, IsShortAndReadsBackAsTheSame) {
  EXPECT_EQ(format_number(0), "0");
  EXPECT_EQ(format_number(-0.0), "0");
  EXPECT_EQ(format_number(100000), "100000");
  EXPECT_EQ(format_number(0.0004), "0.0004");
  EXPECT_EQ(format_number(0.1), "0.1");
  EXPECT_EQ(format_number(1e20), "1e+20");
  EXPECT_EQ(format_number(1e-9), "1e-09");
  std::mt19937_64 random(11);
  for (int i = 0; i < 100000; ++i) {
    const double value =
        std::ldexp(static_cast<double>(static_cast<std::int64_t>(random())), static_cast<int>(random() % 600) - 360);
    ASSERT_EQ(std::stod(format_number(value)), value);
  }
}

TEST(NearestName, ExplainsSlipsOnly) {
  const std::vector<std::string> known = {"neighbors", "radius", "steps"};
  EXPECT_EQ(nearest_name("neighbours", known), "neighbors");
  EXPECT_EQ(nearest_name("radios", known), "radius");
  EXPECT_EQ(nearest_name("step", known), "steps");
  EXPECT_EQ(nearest_name("viewpoint", known), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(Units, TheSameLengthIsTheSameText) {
  EXPECT_EQ(bound<Length>("400 um"), bound<Length>("0.4 mm"));
  EXPECT_EQ(bound<Length>("400 um"), "0.4 unit");
  // Every pair of metric units: a tenth of the larger, written in both.
  const std::vector<std::pair<std::string, double>> units = {{"km", 1e3},  {"m", 1},     {"dm", 1e-1}, {"cm", 1e-2},
                                                             {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}};
  for (const auto& [coordinates, unused] : units)
    for (const auto& [large, size] : units)
      for (const auto& [small, part] : units)
        if (size > part) {
          const std::string text = format_number(std::round(3 * size / part)) + " " + small;
          EXPECT_EQ(bound<Length>("3 " + large, coordinates), bound<Length>(text, coordinates)) << coordinates;
        }
}

TEST(Units, OfTheWrongKindAreRefused) {
  EXPECT_TRUE(bound<Length>("4").starts_with("error: '4' has no unit"));
  EXPECT_TRUE(bound<Length>("4 mm2").starts_with("error: unit 'mm2' does not fit"));
  EXPECT_TRUE(bound<Area>("4 mm").starts_with("error: unit 'mm' does not fit"));
  EXPECT_TRUE(bound<Angle>("4").starts_with("error: '4' has no unit"));
  EXPECT_TRUE(bound<Length>("4 mm", "unit").starts_with("error: unit 'mm' does not fit"));
  EXPECT_EQ(bound<Length>("4 unit", "unit"), "4 unit");
}

TEST(Shares, PercentAndFractionAreTheSame) {
  EXPECT_EQ(bound<Share>("2 %"), "0.02");
  EXPECT_EQ(bound<Share>("2%"), "0.02");
  EXPECT_EQ(bound<Share>("0.02"), "0.02");
  EXPECT_TRUE(bound<Share>("120 %", "mm", range(0, 1)).starts_with("error: '120 %' is out of range"));
}

TEST(Numbers, AreDecimalAndFinite) {
  EXPECT_EQ(bound<double>("+1.5"), "1.5");
  EXPECT_EQ(bound<double>("1e-3"), "0.001");
  for (const char* bad :
       {".nan", ".inf", "-.inf", "nan", "inf", "0x10", "1e999", "1_000", "1,5", "'1'", "[1]", "{}", "~"})
    EXPECT_TRUE(bound<double>(bad).starts_with("error: ")) << bad;
  EXPECT_EQ(bound<std::int32_t>("-12"), "-12");
  EXPECT_EQ(bound<std::int64_t>("9223372036854775807"), "9223372036854775807");
  for (const char* bad : {"2147483648", "010", "0x10", "1.0", "1e3", "one", "--1", ""})
    EXPECT_TRUE(bound<std::int32_t>(bad).starts_with("error: ")) << bad;
}

TEST(Words, StandBesideTheTypesOwnValues) {
  EXPECT_EQ(bound<std::optional<Length>>("none"), "none");
  EXPECT_EQ(bound<std::optional<Length>>("2 spacing"), "2 spacing");
  EXPECT_EQ(bound<AutoOr<Amount>>("auto"), "auto");
  EXPECT_EQ(bound<AutoOr<Amount>>("6 noise"), "6 noise");
  EXPECT_TRUE(bound<std::optional<Length>>("auto").starts_with("error: 'auto' is not a length"));
  EXPECT_TRUE(bound<bool>("yes").starts_with("error: 'yes' is not true or false"));
}

TEST(Text, IsQuotedWhereYamlWouldReadSomethingElse) {
  for (const std::string text : {"plain", "with space", "a: b",        "# no comment", "true",      "12",   "none",
                                 "",      "-x",         "quote \" \\", "two\nlines",   "tab\there", "{a}",  "*a",
                                 "&a",    "!t",         "käse",        "null",         "~",         "0x10", ".nan"}) {
    std::vector<Diagnostic> problems;
    const ConfigValue value = read_yaml("key: " + detail::quote(text), "test", problems);
    ASSERT_TRUE(problems.empty()) << text;
    std::string read;
    ParameterType<std::string>::bind(value.entries.at(0).second, {}, {}, read, problems);
    EXPECT_TRUE(problems.empty()) << text;
    EXPECT_EQ(read, text);
  }
}

TEST(Paths, AreRelativeToTheConfiguration) {
  std::vector<Diagnostic> problems;
  InputPath path;
  detail::bind(read_yaml("../a/b.ply", "test", problems), {"mm", "/scans/here"}, {}, path, problems);
  EXPECT_EQ(path.text, "../a/b.ply");
  EXPECT_EQ(path.resolved, "/scans/a/b.ply");
  detail::bind(read_yaml("/else/b.ply", "test", problems), {"mm", "/scans/here"}, {}, path, problems);
  EXPECT_EQ(path.resolved, "/else/b.ply");
  EXPECT_TRUE(problems.empty());
}

}  // namespace
}  // namespace meshmser
