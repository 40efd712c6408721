/// The corpus of configurations that must be refused, each with the whole of its message.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "pipeline/config/configuration.hpp"

namespace meshmser {
namespace {

const std::string kCorpus = MESHMSER_SOURCE_DIR "/tests/unit/config/bad_configs.txt";

struct Case {
  std::string title, text, expected;
  std::vector<std::string> overrides;
};

struct Corpus {
  std::string head;  ///< comment before the first case
  std::vector<Case> cases;
};

Corpus read_corpus() {
  std::ifstream file(kCorpus, std::ios::binary);
  Corpus corpus;
  bool expecting = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("%%% ")) {
      corpus.cases.push_back({line.substr(4), "", "", {}});
      expecting = false;
    } else if (corpus.cases.empty()) {
      corpus.head += line + "\n";
    } else if (line == "%expect") {
      expecting = true;
    } else if (line.starts_with("%set ")) {
      corpus.cases.back().overrides.push_back(line.substr(5));
    } else {
      (expecting ? corpus.cases.back().expected : corpus.cases.back().text) += line + "\n";
    }
  }
  return corpus;
}

// A configuration from load to `last`, a stage a line.
std::string preamble(const std::string& last) {
  std::string text = "version: 1\nunits: mm\nstages:\n  - load: {path: tablet.ply}\n";
  for (const char* stage : {"orient", "curvature", "mesh", "tree", "mser"}) {
    if (text.find("- " + last + ":") != std::string::npos) break;
    text += std::string("  - ") + stage + ": {}\n";
  }
  return text;
}

// \xNN to its byte; @STAGE in the first line to the preamble.
std::string configuration_text(const std::string& text) {
  const std::size_t end = text.find('\n');
  const std::string whole = text.starts_with("@") ? preamble(text.substr(1, end - 1)) + text.substr(end + 1) : text;
  std::string decoded;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole.compare(i, 2, "\\x") == 0 && i + 3 < whole.size()) {
      decoded += static_cast<char>(std::stoi(whole.substr(i + 2, 2), nullptr, 16));
      i += 3;
    } else {
      decoded += whole[i];
    }
  }
  return decoded;
}

std::string message_of(const Case& bad) {
  try {
    parse_configuration(configuration_text(bad.text), "scan.yaml", bad.overrides);
  } catch (const ConfigError& error) {
    return error.what() + std::string("\n");
  } catch (const Error& error) {
    return "not a ConfigError: " + std::string(error.what()) + "\n";
  }
  return "accepted\n";
}

TEST(BadConfigs, EachIsRefusedWithItsWholeMessage) {
  std::filesystem::current_path(MESHMSER_SOURCE_DIR "/data/demo");
  Corpus corpus = read_corpus();
  ASSERT_GE(corpus.cases.size(), 100u) << kCorpus;
  std::set<std::string> titles;
  for (Case& bad : corpus.cases) {
    EXPECT_TRUE(titles.insert(bad.title).second) << "two cases are called '" << bad.title << "'";
    const std::string message = message_of(bad);
    EXPECT_EQ(message, bad.expected) << bad.title << "\n" << bad.text;
    bad.expected = message;
  }
  if (std::getenv("MESHMSER_UPDATE_EXPECTED") == nullptr) return;
  std::ofstream file(kCorpus, std::ios::binary);
  file << corpus.head;
  for (const Case& bad : corpus.cases) {
    file << "%%% " << bad.title << "\n" << bad.text;
    for (const std::string& argument : bad.overrides) file << "%set " << argument << "\n";
    file << "%expect\n" << bad.expected;
  }
}

// Whatever is cut off or changed in a good configuration: read or refused, with the name of the file, never a crash.
TEST(BadConfigs, DamagedTextIsReadOrRefused) {
  std::filesystem::current_path(MESHMSER_SOURCE_DIR "/data/demo");
  const std::string good = preamble("load") +
                           "  - orient: {neighbors: 12}\n"
                           "  - curvature: &c {radius: 4 spacing, steps: 4}\n"
                           "  - curvature: {name: fine, radius: \"3 spacing\"}\n"
                           "  - mesh:\n      max_edge: 5 spacing\n"
                           "  - tree: {scalar: fine.mean_curvature, range: [2 %, 98 %]}  # comment\n";
  const std::string bytes = "{}[]:,&*!|>'\"%@`#-?~ \n\t0x\x7f\xff";
  int refused = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (std::size_t k = 0; k <= bytes.size(); ++k) {
      const std::string damaged =
          k == bytes.size() ? good.substr(0, i) : good.substr(0, i) + bytes[k] + good.substr(i + 1);
      try {
        parse_configuration(damaged, "scan.yaml");
      } catch (const ConfigError& error) {
        ++refused;
        EXPECT_TRUE(std::string(error.what()).starts_with("scan.yaml:")) << damaged << error.what();
      } catch (const InputError&) {
        ++refused;  // the path of the scan was damaged
      }
    }
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace meshmser
