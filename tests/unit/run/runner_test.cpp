// What runs, what is taken from the cache, and what is said about it, with stages that do next to nothing.
#include "pipeline/run/runner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <thread>

#include "pipeline/cache/cache.hpp"
#include "pipeline/run/show.hpp"
#include "tests/support/fake_stages.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class Silent : public RunObserver {
 public:
  std::vector<std::string> notes;
  void stage_started(const StageRecord&, std::size_t, std::size_t) override {}
  void progress(std::string_view, std::int64_t, std::int64_t) override {}
  void stage_finished(const StageRecord&, std::size_t, std::size_t) override {}
  void note(const std::string& message) override { notes.push_back(message); }
};

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class Runner : public testing::Test {
 protected:
  Runner() {
    folder_.write("work/numbers.txt", "1 2 3");
    folder_.write("work/config.yaml", fake::kConfiguration);
    fake::num_runs.clear();
    fake::on_run = [](const std::string&) {};
    root_ = folder_.path() / "work";
  }
  std::filesystem::path at(const std::string& name) const { return root_ / name; }
  RunResult go(const std::vector<std::string>& set = {}, RunOptions options = {}) {
    fake::num_runs.clear();
    observer_.notes.clear();
    if (options.out.empty()) options.out = at("out");
    return run(load_configuration(at("config.yaml"), set), options, {}, observer_);
  }
  // "stage" of a cached one, "stage: reason" of one that ran or will.
  static std::vector<std::string> told(const RunResult& result) {
    std::vector<std::string> all;
    for (const StageRecord& stage : result.stages)
      all.push_back(stage.reason.empty() ? stage.name : stage.name + ": " + stage.reason);
    return all;
  }
  // Turns one byte of a file of the cache that has this name.
  int damage(const std::string& name, bool truncate = false) {
    int count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(at(".meshmser-cache/entries")))
      if (entry.path().filename() == name) {
        std::string text = text_of(entry.path());
        if (truncate)
          text.pop_back();
        else
          text.back() = static_cast<char>(text.back() ^ 1);
        std::ofstream(entry.path(), std::ios::binary) << text;
        ++count;
      }
    return count;
  }

  TemporaryFolder folder_;
  std::filesystem::path root_;
  Silent observer_;
};

TEST_F(Runner, RunsOnceThenTakesFromTheCache) {
  EXPECT_THAT(told(go()), ElementsAre("numbers: never ran", "shift: never ran", "sum: never ran", "write: never ran"));
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 6\n");
  const RunResult again = go();
  EXPECT_THAT(told(again), ElementsAre("numbers", "shift", "sum", "write"));
  EXPECT_THAT(fake::num_runs, IsEmpty());
  EXPECT_THAT(again.stages.back().files, ElementsAre(at("out/sums.txt"), at("out/more.csv")));
}

TEST_F(Runner, ParameterRunsItsStageAndThoseItReaches) {
  go();
  EXPECT_THAT(told(go({"sum.factor=2"})),
              ElementsAre("numbers", "shift", "sum: sum.factor 1 -> 2", "write: input scalars of stage sum changed"));
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 12\n");
  EXPECT_THAT(told(go()), ElementsAre("numbers", "shift", "sum", "write"));
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 6\n");
}

TEST_F(Runner, EqualOutputStopsTheChange) {
  go();
  EXPECT_THAT(told(go({"shift.amount=0.2"})), ElementsAre("numbers", "shift: shift.amount 0.1 -> 0.2", "sum", "write"));
}

TEST_F(Runner, ParameterWithoutEffectRunsNothing) {
  go();
  EXPECT_THAT(told(go({"numbers.chunk=5"})), ElementsAre("numbers", "shift", "sum", "write"));
}

TEST_F(Runner, TouchingTheInputOrMovingTheFolderRunsNothing) {
  go();
  std::filesystem::last_write_time(at("numbers.txt"),
                                   std::filesystem::file_time_type::clock::now() + std::chrono::hours(1));
  EXPECT_THAT(told(go()), ElementsAre("numbers", "shift", "sum", "write"));
  std::filesystem::rename(root_, folder_.path() / "elsewhere");
  root_ = folder_.path() / "elsewhere";
  EXPECT_THAT(told(go()), ElementsAre("numbers", "shift", "sum", "write"));
}

TEST_F(Runner, ChangedInputRuns) {
  go();
  folder_.write("work/numbers.txt", "1 2 4");
  EXPECT_THAT(told(go()),
              ElementsAre("numbers: input file numbers.txt changed", "shift: input cloud of stage numbers changed",
                          "sum: input smoothed of stage shift changed", "write: input scalars of stage sum changed"));
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 7\n");
}

TEST_F(Runner, WarningsAndFiguresAreToldAgain) {
  const RunResult first = go(), second = go();
  ASSERT_THAT(first.stages[0].warnings, ElementsAre("there are few numbers"));
  EXPECT_EQ(second.stages[0].warnings, first.stages[0].warnings);
  ASSERT_EQ(second.stages[2].report.size(), 1U);
  EXPECT_EQ(std::get<double>(second.stages[2].report[0].value), 6);
  const std::string json = text_of(at("out/run.json"));
  EXPECT_THAT(json, HasSubstr("\"there are few numbers\""));
  EXPECT_THAT(json, HasSubstr("\"chunk\": \"1\""));
  EXPECT_THAT(json, HasSubstr("\"outcome\": \"cached\""));
}

TEST_F(Runner, UnreadDamageIsLeftAloneReadDamageIsMended) {
  go();
  ASSERT_EQ(damage("positions.npy"), 2);
  EXPECT_THAT(told(go()), ElementsAre("numbers", "shift", "sum", "write"));
  // sum reads what shift made, and shift then what numbers made: both are damaged.
  EXPECT_THAT(told(go({"sum.factor=3"})),
              ElementsAre("numbers: entry damaged", "shift: entry damaged", "sum: sum.factor 1 -> 3", testing::_));
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 18\n");
  EXPECT_THAT(observer_.notes, ElementsAre(HasSubstr("set aside"), HasSubstr("set aside")));
  EXPECT_THAT(told(go({"sum.factor=3"})), ElementsAre("numbers", "shift", "sum", "write"));
}

TEST_F(Runner, DamagedManifestsAndFilesAreMended) {
  for (const char* name : {"manifest.json", "artifact.json", "sums.txt"})
    for (const bool truncate : {false, true}) {
      go();
      std::filesystem::remove_all(at("out"));
      ASSERT_GT(damage(name, truncate), 0) << name;
      fake::num_runs.clear();
      go({}, {.from = "sum"});
      EXPECT_EQ(text_of(at("out/sums.txt")), "sum 6\n") << name;
      go();
      EXPECT_EQ(text_of(at("out/sums.txt")), "sum 6\n") << name;
    }
  go();
  std::filesystem::remove_all(at("out"));
  damage("sums.txt");
  EXPECT_THAT(told(go()), ElementsAre("numbers", "shift", "sum", "write: entry damaged"));
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 6\n");
}

TEST_F(Runner, ForcedRunTellsItsOwnTime) {
  go();
  fake::on_run = [](const std::string&) { std::this_thread::sleep_for(std::chrono::milliseconds(60)); };
  const RunResult forced = go({}, {.force = {"shift"}});
  EXPECT_GE(forced.stages[1].wall_seconds, 0.06);
  EXPECT_LT(forced.stages[2].wall_seconds, 0.06) << "that of the run that made the cached result";
}

TEST_F(Runner, UntilFromForceOnly) {
  EXPECT_THROW(go({}, {.only = "sum"}), CacheError);
  EXPECT_THAT(told(go({}, {.until = "shift"})), ElementsAre("numbers: never ran", "shift: never ran"));
  EXPECT_THAT(told(go({}, {.only = "sum"})), ElementsAre("sum: asked for alone"));
  EXPECT_THAT(fake::num_runs, ElementsAre(std::pair("sum", 1)));
  EXPECT_THAT(told(go({}, {.only = "sum"})), ElementsAre("sum: asked for alone"));
  EXPECT_THAT(told(go()), ElementsAre("numbers", "shift", "sum", "write: never ran"));
  EXPECT_THAT(told(go({}, {.from = "sum"})), ElementsAre("numbers", "shift", "sum: forced", "write: forced"));
  EXPECT_THAT(told(go({}, {.force = {"shift"}})), ElementsAre("numbers", "shift: forced", "sum", "write"));
  EXPECT_THAT(told(go({}, {.force_all = true})),
              ElementsAre("numbers: forced", "shift: forced", "sum: forced", "write: forced"));
  EXPECT_THAT(fake::num_runs, testing::SizeIs(4));
  try {
    go({}, {.until = "shfit"});
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'shift'?"));
  }
}

TEST_F(Runner, OnlyNamesTheRemedy) {
  try {
    go({}, {.only = "sum"});
    FAIL();
  } catch (const CacheError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'numbers', which 'sum' depends on, is not in the cache (never ran)"));
    EXPECT_THAT(error.what(), HasSubstr("--until numbers"));
  }
}

TEST_F(Runner, DryRunTellsAndWritesNothing) {
  EXPECT_THAT(
      told(go({}, {.dry_run = true})),
      ElementsAre("numbers: never ran", "shift: input cloud of stage numbers may change",
                  "sum: input smoothed of stage shift may change", "write: input scalars of stage sum may change"));
  EXPECT_THAT(fake::num_runs, IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(at(".meshmser-cache")));
  EXPECT_FALSE(std::filesystem::exists(at("out")));
  go();
  EXPECT_THAT(
      told(go({"sum.factor=2"}, {.dry_run = true})),
      ElementsAre("numbers", "shift", "sum: sum.factor 1 -> 2", "write: input scalars of stage sum may change"));
  EXPECT_THAT(told(go({"shift.amount=2", "sum.factor=2"}, {.dry_run = true})),
              ElementsAre("numbers", "shift: shift.amount 0.1 -> 2",
                          "sum: sum.factor 1 -> 2; input smoothed of stage shift may change",
                          "write: input scalars of stage sum may change"));
  damage("manifest.json");
  EXPECT_EQ(told(go({}, {.dry_run = true})).front(), "numbers: entry damaged");
}

TEST_F(Runner, InputIsNeverOverwritten) {
  std::filesystem::create_directories(at("out"));
  std::filesystem::create_hard_link(at("numbers.txt"), at("out/sums.txt"));
  EXPECT_THROW(go(), UsageError);
  EXPECT_THROW(go({"write.file=config.yaml"}, {.out = root_}), UsageError);
  EXPECT_THROW(go({"write.file=numbers.txt"}, {.out = root_}), UsageError);
  EXPECT_EQ(text_of(at("numbers.txt")), "1 2 3");
  EXPECT_EQ(text_of(at("config.yaml")), fake::kConfiguration);
}

TEST_F(Runner, StageTwiceUnderTwoNames) {
  folder_.write("work/config.yaml",
                "version: 1\nunits: mm\nstages:\n  - numbers: {path: numbers.txt}\n  - shift: {}\n"
                "  - sum: {name: one}\n  - sum: {name: two, factor: 2}\n  - write: {name: all}\n");
  go();
  EXPECT_EQ(text_of(at("out/all/sums.txt")), "one 6\ntwo 12\n");
  folder_.write("work/config.yaml",
                "version: 1\nunits: mm\nstages:\n  - numbers: {path: numbers.txt}\n  - shift: {}\n"
                "  - sum: {name: first}\n  - sum: {name: two, factor: 2}\n  - write: {name: all}\n");
  go();
  EXPECT_EQ(text_of(at("out/all/sums.txt")), "first 6\ntwo 12\n");
}

TEST_F(Runner, FailureAndInterruptionKeepWhatIsDone) {
  EXPECT_THROW(go({"sum.fail=true"}), StageError);
  EXPECT_THAT(told(go()), ElementsAre("numbers", "shift", "sum: never ran", "write: never ran"));
  fake::on_run = [](const std::string& stage) {
    if (stage == "sum") throw Cancelled();
  };
  EXPECT_THROW(go({"shift.amount=1"}), Cancelled);
  EXPECT_THAT(observer_.notes, ElementsAre("interrupted; in the cache: numbers, shift"));
  fake::on_run = [](const std::string&) {};
  EXPECT_EQ(told(go({"shift.amount=1"}))[1], "shift");
}

TEST_F(Runner, InputWrittenWhileReadIsRefused) {
  fake::on_run = [&](const std::string& stage) {
    if (stage == "numbers") folder_.write("work/numbers.txt", "9");
  };
  EXPECT_THROW(go(), InputError);
  fake::on_run = [](const std::string&) {};
  go();
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 9\n");
}

TEST_F(Runner, ResultThatDiffersFromTheCachedOneIsTold) {
  go();
  fake::salt = "another";
  go({}, {.force_all = true});
  fake::salt.clear();
  EXPECT_THAT(observer_.notes, ElementsAre(HasSubstr("write: made another result than before")));
  EXPECT_EQ(text_of(at("out/more.csv")), "a,b\n1,2\nanother");
}

TEST_F(Runner, ArtifactsOfACommandComeFromTheCache) {
  RunOptions options;
  const Configuration configuration = load_configuration(at("config.yaml"));
  const auto made = make_artifact(configuration, artifact_index<ScalarFields>(), options, {}, observer_);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->first, "sum");
  EXPECT_EQ(std::get<Shared<ScalarFields>>(made->second)->fields[0].values[0], 6);
  EXPECT_FALSE(fake::num_runs.contains("write"));
  EXPECT_FALSE(make_artifact(configuration, artifact_index<TriangleMesh>(), options, {}, observer_));
}

TEST_F(Runner, ShowTellsFieldsOrTheRemedy) {
  const Configuration configuration = load_configuration(at("config.yaml"));
  EXPECT_THROW(show(configuration, "sum", {}, {}, observer_), CacheError);
  go();
  const std::string text = show(configuration, "numbers", {}, {}, observer_);
  EXPECT_THAT(text, HasSubstr("num_points                     3\n"));
  EXPECT_THAT(text, HasSubstr("positions                    3 x 3 <f8"));
  EXPECT_THAT(text, HasSubstr("[0]  min 1  max 3  mean 2"));
  EXPECT_THAT(show(configuration, "write", {}, {}, observer_), HasSubstr("/files/sums.txt\n"));
}

TEST_F(Runner, CacheIsListedVerifiedCollectedAndCleared) {
  go();
  go({"sum.factor=2"});
  Cache cache(at(".meshmser-cache"));
  ASSERT_EQ(cache.list().size(), 6U);
  for (const EntryListing& entry : cache.list()) EXPECT_NO_THROW(cache.verify(entry.stage, entry.key));
  damage("positions.npy");
  int num_damaged = 0;
  for (const EntryListing& entry : cache.list()) try {
      cache.verify(entry.stage, entry.key);
    } catch (const EntryDamaged&) {
      ++num_damaged;
    }
  EXPECT_EQ(num_damaged, 2);
  EXPECT_EQ(collect_garbage(cache, {.max_age_days = 1, .max_size = {}}).num_removed, 0U);
  std::uint64_t half = 0;
  for (const EntryListing& entry : cache.list()) half += entry.size / 2;
  const GarbageReport report = collect_garbage(cache, {.max_age_days = {}, .max_size = half});
  EXPECT_GT(report.num_removed, 0U);
  EXPECT_LE(report.bytes_kept, half);
  EXPECT_EQ(cache.list().size(), report.num_kept);
  go();
  EXPECT_EQ(text_of(at("out/sums.txt")), "sum 6\n");
  cache.clear();
  EXPECT_THAT(cache.list(), IsEmpty());
  EXPECT_THAT(told(go()), ElementsAre("numbers: never ran", testing::_, testing::_, testing::_));
}

}  // namespace
}  // namespace meshmser
