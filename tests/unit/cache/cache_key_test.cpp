// What the key depends on, and what it does not.
#include "pipeline/cache/cache_key.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace meshmser {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

struct Inner {
  InputPath path;
  double weight = 1;
  static void declare(Schema& s) {
    s.parameter("path", &Inner::path, "A file.");
    s.parameter("weight", &Inner::weight, "A weight.");
  }
};

struct KeyStage {
  static constexpr StageInfo info{"key_stage", 3, "Stands for any stage."};
  struct Parameters {
    int count = 12;
    double share = 0.5;
    std::string name = "none";
    Length radius{4, Length::Unit::kSpacing};
    InputPath path;
    std::vector<Inner> list;
    int chunk = 7;
  };
  static void declare(StageSchema& s) {
    using P = Parameters;
    s.parameter("count", &P::count, at_least(0), "points", "A count.");
    s.parameter("share", &P::share, "A share.");
    s.parameter("name", &P::name, "A name.");
    s.parameter("radius", &P::radius, "A length.");
    s.parameter("path", &P::path, "A file.");
    s.parameter("list", &P::list, "Files.");
    s.parameter("chunk", &P::chunk, "How the work is cut.").affects_result = false;
  }
  static Outputs run(const Parameters&, const Inputs&, RunContext&) { return {}; }
};

const StageDefinition& definition() {
  static const StageDefinition d = define_stage<KeyStage>();
  return d;
}

CacheKey key(const KeyStage::Parameters& p, const std::vector<KeyFile>& files = {{"a.ply", "11"}},
             const std::vector<KeyInput>& inputs = {{"cloud", "load", false, "point_cloud", "22"}}) {
  return make_cache_key(definition(), &p, "key_stage", "mm", files, inputs);
}

TEST(CacheKey, EachResultParameterChangesItAndNoOtherDoes) {
  std::mt19937_64 random(7);
  for (const Parameter& parameter : definition().parameters) {
    KeyStage::Parameters p;
    const CacheKey before = key(p);
    std::set<std::string> keys, texts;
    for (int i = 0; i < 50; ++i) {
      parameter.randomize(&p, random);
      keys.insert(key(p).digest);
      texts.insert(parameter.format(&p));
    }
    if (!parameter.affects_result)
      EXPECT_THAT(keys, ElementsAre(before.digest)) << parameter.name;
    else
      EXPECT_EQ(keys.size(), texts.size()) << parameter.name;
  }
}

TEST(CacheKey, FoldersOfPathsAreNotInIt) {
  KeyStage::Parameters here, there;
  here.path = {"here/scan.ply", "/home/a/here/scan.ply"};
  there.path = {"/tmp/there/scan.ply", "/tmp/there/scan.ply"};
  here.list = {{{"here/b.ply", "/home/a/here/b.ply"}, 1}};
  there.list = {{{"../b.ply", "/tmp/b.ply"}, 1}};
  EXPECT_EQ(key(here).text, key(there).text);
  EXPECT_THAT(key(here).text, HasSubstr("b.ply"));
  EXPECT_THAT(key(here).text, Not(HasSubstr("here")));
}

TEST(CacheKey, FieldsCannotRunIntoEachOther) {
  KeyStage::Parameters a, b;
  a.name = "x\"\nparameter \"radius\" \"9";
  b.name = "x";
  EXPECT_NE(key(a).text, key(b).text);
  const auto num_lines = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };
  EXPECT_EQ(num_lines(key(a).text), num_lines(key(b).text));
}

TEST(CacheKey, InputsCountByContentAndNamesWhereTheStageSeesThem) {
  const KeyStage::Parameters p;
  const auto with = [&](const std::string& stage, bool named, const std::string& digest) {
    return key(p, {}, {{"cloud", stage, named, "point_cloud", digest}}).digest;
  };
  EXPECT_EQ(with("load", false, "22"), with("load_2", false, "22"));
  EXPECT_NE(with("load", true, "22"), with("load_2", true, "22"));
  EXPECT_NE(with("load", false, "22"), with("load", false, "23"));
  EXPECT_NE(key(p, {{"a.ply", "11"}}).digest, key(p, {{"a.ply", "12"}}).digest);
}

TEST(CacheKey, TellsDifferences) {
  KeyStage::Parameters p, q;
  q.count = 20;
  q.radius = {3, Length::Unit::kSpacing};
  const std::vector<KeyInput> inputs{{"cloud", "load", false, "point_cloud", "23"}};
  EXPECT_THAT(explain_difference(key(p).text, key(q).text, "fine", {{"cloud", "load", false, "point_cloud", "22"}}),
              ElementsAre("fine.count 12 -> 20", "fine.radius 4 spacing -> 3 spacing"));
  p.radius = {1.5, Length::Unit::kCoordinate};
  EXPECT_THAT(explain_difference(key(q).text, key(p).text, "fine", inputs),
              ElementsAre("fine.count 20 -> 12", "fine.radius 3 spacing -> 1.5 mm"));
  EXPECT_THAT(explain_difference(key(p).text, key(p, {{"a.ply", "12"}}, inputs).text, "fine", inputs),
              ElementsAre("input file a.ply changed", "input cloud of stage load changed"));
  EXPECT_THAT(explain_difference(key(p).text, key(p).text, "fine", {{"cloud", "load", false, "point_cloud", "22"}}),
              IsEmpty());
  StageDefinition newer = definition();
  newer.info.version = 4;
  EXPECT_THAT(explain_difference(key(p).text, make_cache_key(newer, &p, "key_stage", "cm", {}, {}).text, "fine", {}),
              ElementsAre("stage version 3 -> 4", "units mm -> cm", "file a.ply is gone", "input cloud is gone"));
}

}  // namespace
}  // namespace meshmser
