// Whatever happens to a run, the next one succeeds and gives what an undisturbed run gives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <random>
#include <set>
#include <sstream>

#include "pipeline/cache/cache.hpp"
#include "pipeline/run/runner.hpp"
#include "tests/support/fake_stages.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

class Silent : public RunObserver {
 public:
  void stage_started(const StageRecord&, std::size_t, std::size_t) override {}
  void progress(std::string_view, std::int64_t, std::int64_t) override {}
  void stage_finished(const StageRecord&, std::size_t, std::size_t) override {}
  void note(const std::string&) override {}
};

/// A disk whose calls fail from the n-th on: that one alone (it is full), or all (the power is gone). When the power is
/// gone, what was not synced is cut in half.
class FailingDisk : public FileSystem {
 public:
  FailingDisk(std::int64_t fail_at, bool power) : fail_at_(fail_at), power_(power) {}
  bool failed() const { return failed_; }
  void lose_unsynced() {
    for (const std::filesystem::path& path : unsynced_) {
      std::error_code gone;
      const auto size = std::filesystem::file_size(path, gone);
      if (!gone) std::filesystem::resize_file(path, size / 2);
    }
  }

  void create_folders(const std::filesystem::path& folder) override {
    count(folder);
    FileSystem::create_folders(folder);
  }
  void write(const std::filesystem::path& path, std::span<const std::span<const std::byte>> pieces) override {
    // A write fails half-way.
    unsynced_.insert(path);
    if (due()) {
      const std::span<const std::byte> half = pieces.front().first(pieces.front().size() / 2);
      FileSystem::write(path, {&half, 1});
    }
    count(path);
    FileSystem::write(path, pieces);
  }
  void sync(const std::filesystem::path& path) override {
    count(path);
    unsynced_.erase(path);
  }
  bool rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    count(from);
    if (!FileSystem::rename(from, to)) return false;
    std::set<std::filesystem::path> moved;
    for (const std::filesystem::path& path : unsynced_) {
      const std::string text = path.string(), start = from.string();
      const bool inside = text == start || text.starts_with(start + "/");
      moved.insert(inside ? std::filesystem::path(to.string() + text.substr(start.size())) : path);
    }
    unsynced_ = std::move(moved);
    return true;
  }
  void remove(const std::filesystem::path& path) override {
    count(path);
    FileSystem::remove(path);
  }
  void copy(const std::filesystem::path& from, const std::filesystem::path& to) override {
    unsynced_.insert(to);
    count(to);
    FileSystem::copy(from, to);
  }
  std::unique_ptr<ReadableFile> open(const std::filesystem::path& path) override {
    count(path);
    return FileSystem::open(path);
  }
  std::vector<std::string> list(const std::filesystem::path& folder) override {
    count(folder);
    return FileSystem::list(folder);
  }
  std::optional<FileIdentity> identity(const std::filesystem::path& path) override {
    count(path);
    return FileSystem::identity(path);
  }
  std::unique_ptr<FileLock> try_lock(const std::filesystem::path& path) override {
    count(path);
    return FileSystem::try_lock(path);
  }

 private:
  bool due() const { return calls_ + 1 == fail_at_; }
  void count(const std::filesystem::path& path) {
    ++calls_;
    if (calls_ == fail_at_ || (failed_ && power_)) {
      failed_ = true;
      throw CacheError(path.string() + ": no more");
    }
  }

  std::int64_t calls_ = 0, fail_at_;
  bool power_, failed_ = false;
  std::set<std::filesystem::path> unsynced_;
};

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class Faults : public testing::Test {
 protected:
  Faults() {
    folder_.write("numbers.txt", "1 2 3 4 5");
    folder_.write("config.yaml", fake::kConfiguration);
  }
  std::filesystem::path at(const std::string& name) const { return folder_.path() / name; }
  void go(const std::string& out, double factor = 1, FileSystem* disk = nullptr) {
    RunOptions options;
    options.out = at(out);
    options.disk = disk;
    Silent observer;
    run(load_configuration(at("config.yaml"), {"sum.factor=" + format_number(factor)}), options, {.threads = 1},
        observer);
  }
  void expect_right(const std::string& out, double factor) {
    EXPECT_EQ(text_of(at(out) / "sums.txt"), "sum " + std::to_string(static_cast<int>(15 * factor)) + "\n");
    EXPECT_EQ(text_of(at(out) / "more.csv"), "a,b\n1,2\n");
  }
  // Every entry of the cache is whole, and no unfinished folder is left but those of processes that live.
  void expect_whole_cache() {
    Cache cache(at(".meshmser-cache"));
    for (const EntryListing& entry : cache.list()) EXPECT_NO_THROW(cache.verify(entry.stage, entry.key));
    EXPECT_THAT(real_file_system().list(at(".meshmser-cache/staging")), testing::IsEmpty());
  }
  // Runs in a process of its own, which ends with the given code or by a signal.
  pid_t in_child(const std::string& out, double factor) {
    const pid_t child = ::fork();
    if (child != 0) return child;
    try {
      go(out, factor);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      ::_exit(1);
    }
    ::_exit(0);
  }

  TemporaryFolder folder_;
};

TEST_F(Faults, EachCallFailsInTurn) {
  for (const bool power : {false, true}) {
    bool failed = true;
    int count = 0;
    for (std::int64_t n = 1; failed; ++n, ++count) {
      std::filesystem::remove_all(at(".meshmser-cache"));
      std::filesystem::remove_all(at("out"));
      FailingDisk disk(n, power);
      try {
        go("out", 1, &disk);
      } catch (const Error&) {
        EXPECT_TRUE(disk.failed());
      }
      failed = disk.failed();
      if (power) disk.lose_unsynced();
      // A file that did get into the out folder is whole.
      EXPECT_THAT(text_of(at("out/sums.txt")), testing::AnyOf("", "sum 15\n"));
      EXPECT_THAT(text_of(at("out/more.csv")), testing::AnyOf("", "a,b\n1,2\n"));
      ASSERT_NO_THROW(go("out", 2)) << "after call " << n;
      expect_right("out", 2);
      ASSERT_NO_THROW(go("out", 1)) << "after call " << n;
      expect_right("out", 1);
      if (HasFailure()) FAIL() << "after call " << n << (power ? ", power lost" : "");
    }
    EXPECT_GT(count, 100);
    expect_whole_cache();
  }
}

TEST_F(Faults, KilledAtRandomAHundredTimes) {
  // Long enough to reach every part of a run: the time of an undisturbed one.
  const auto begin = std::chrono::steady_clock::now();
  go("out", 1);
  const auto whole = std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - begin);
  std::mt19937_64 random(20110603);
  int num_killed = 0;
  for (int i = 0; i < 100; ++i) {
    const double factor = 2 + i % 7;
    if (i % 5 == 0) std::filesystem::remove_all(at(".meshmser-cache"));
    const pid_t child = in_child("out", factor);
    ::usleep(static_cast<unsigned>(random() % static_cast<std::uint64_t>(whole.count() + 1)));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    num_killed += WIFSIGNALED(status) ? 1 : 0;
    ASSERT_NO_THROW(go("out", factor)) << "kill " << i;
    expect_right("out", factor);
    ASSERT_FALSE(HasFailure()) << "kill " << i;
  }
  EXPECT_GT(num_killed, 30);
  go("out", 100);
  expect_whole_cache();
}

TEST_F(Faults, ProcessesAtOnceShareACache) {
  for (int round = 0; round < 5; ++round) {
    std::filesystem::remove_all(at(".meshmser-cache"));
    std::vector<pid_t> children;
    for (int i = 0; i < 4; ++i) children.push_back(in_child("out" + std::to_string(i), 1 + i % 2));
    for (const pid_t child : children) {
      int status = 0;
      ::waitpid(child, &status, 0);
      EXPECT_EQ(status, 0);
    }
    for (int i = 0; i < 4; ++i) expect_right("out" + std::to_string(i), 1 + i % 2);
    expect_whole_cache();
  }
}

TEST_F(Faults, EntriesVanishUnderARun) {
  go("out", 1);
  Cache cache(at(".meshmser-cache"));
  fake::on_run = [&](const std::string& stage) {
    if (stage == "sum") collect_garbage(cache, {.max_age_days = {}, .max_size = 0});
  };
  go("out", 3);
  fake::on_run = [](const std::string&) {};
  expect_right("out", 3);
  go("out", 1);
  expect_right("out", 1);
}

}  // namespace
}  // namespace meshmser
