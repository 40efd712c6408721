#include "pipeline/config/configuration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "pipeline/config/plan.hpp"

namespace meshmser {
namespace {

const std::string kScan = MESHMSER_SOURCE_DIR "/data/demo/tablet.ply";

std::string with_load(const std::string& stages) {
  return "version: 1\nunits: mm\nstages:\n  - load: {path: " + kScan + "}\n" + stages;
}

// A parameter as text.
std::string value(const Configuration& configuration, const std::string& stage, const std::string& key) {
  for (const StageEntry& entry : configuration.stages)
    if (entry.name == stage)
      for (const Parameter& parameter : entry.definition->parameters)
        if (parameter.name == key) return parameter.format(entry.parameters.get());
  return "no " + stage + "." + key;
}

// What is plugged into a port, as "fine.scalars"; several with a space between.
std::string sources(const Configuration& configuration, const std::string& stage, const std::string& port) {
  const Plan plan = resolve_ports(configuration);
  std::string text;
  for (std::size_t i = 0; i < configuration.stages.size(); ++i)
    if (configuration.stages[i].name == stage)
      for (const PortBinding& binding : plan.stages[i].inputs)
        if (binding.port == port)
          for (const PortSource& source : binding.sources)
            text += (text.empty() ? "" : " ") + configuration.stages[source.stage].name + "." + source.port;
  return text;
}

const char* const kChain =
    "  - orient: {}\n  - curvature: {}\n  - mesh: {}\n  - tree: {}\n  - mser: {}\n  - borders: {}\n  - export: {}\n";

TEST(Configuration, EightNamesAndAPathAreEnough) {
  const Configuration configuration = parse_configuration(with_load(kChain), "scan.yaml");
  ASSERT_EQ(configuration.stages.size(), 8u);
  EXPECT_EQ(configuration.units, "mm");
  EXPECT_EQ(configuration.stages[1].name, "orient");
  EXPECT_EQ(configuration.stages[1].location.line, 5);
  EXPECT_EQ(configuration.stages[1].location.column, 5);
}

TEST(Configuration, StagesWithoutParametersMayStandWithNothing) {
  const Configuration configuration = parse_configuration(with_load("  - orient:\n  - mesh: ~\n"), "scan.yaml");
  EXPECT_EQ(configuration.stages.size(), 3u);
}

TEST(Configuration, PathsAreRelativeToTheFile) {
  const Configuration configuration = parse_configuration(
      "version: 1\nstages:\n  - load: {path: ../data/demo/tablet.ply}\n", MESHMSER_SOURCE_DIR "/configs/any.yaml");
  const auto files = configuration.stages[0].definition->files(configuration.stages[0].parameters.get());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0], std::filesystem::path(kScan));
}

TEST(Configuration, BlockAndFlowStyleAndAliasesSayTheSame) {
  const Configuration flow = parse_configuration(
      with_load("  - orient: {neighbors: 14}\n  - curvature: {radius: 4 spacing, steps: 3}\n"), "scan.yaml");
  const Configuration block = parse_configuration(
      with_load("  - orient:\n      neighbors: 14\n  - curvature: &first\n      radius: 4 spacing\n      steps: 3\n"),
      "scan.yaml");
  const Configuration alias =
      parse_configuration(with_load("  - orient: {neighbors: &n 14}\n  - curvature: {radius: &r 4 spacing, steps: 3}\n"
                                    "  - curvature: {name: again, radius: *r, steps: 3}\n"),
                          "scan.yaml");
  for (const char* key : {"radius", "steps"}) {
    EXPECT_EQ(value(flow, "curvature", key), value(block, "curvature", key));
    EXPECT_EQ(value(flow, "curvature", key), value(alias, "again", key));
  }
  EXPECT_EQ(value(flow, "curvature", "radius"), "4 spacing");
  EXPECT_EQ(value(block, "orient", "neighbors"), "14");
}

TEST(Configuration, LengthsAreConvertedToTheCoordinatesUnit) {
  const auto radius = [](const std::string& units, const std::string& text) {
    return value(parse_configuration("version: 1\nunits: " + units + "\nstages:\n  - load: {path: " + kScan +
                                         "}\n  - orient: {}\n  - curvature: {radius: " + text + "}\n",
                                     "scan.yaml"),
                 "curvature", "radius");
  };
  EXPECT_EQ(radius("mm", "400 um"), "0.4 unit");
  EXPECT_EQ(radius("mm", "0.4 mm"), "0.4 unit");
  EXPECT_EQ(radius("mm", "0.4mm"), "0.4 unit");
  EXPECT_EQ(radius("mm", "0.04 cm"), "0.4 unit");
  EXPECT_EQ(radius("mm", "0.4 unit"), "0.4 unit");
  EXPECT_EQ(radius("m", "0.4 mm"), "0.0004 unit");
  EXPECT_EQ(radius("in", "25.4 mm"), "1 unit");
  EXPECT_EQ(radius("mm", "1 in"), "25.4 unit");
  EXPECT_EQ(radius("mm", "+2.50e1 %diag"), "25 %diag");
}

TEST(Configuration, AreasAreConvertedBySquares) {
  const auto area = [](const std::string& text) {
    return value(parse_configuration(with_load("  - orient: {}\n  - mesh: {}\n  - curvature: {}\n  - tree: {}\n"
                                               "  - mser: {min_area: " +
                                               text + "}\n"),
                                     "scan.yaml"),
                 "mser", "min_area");
  };
  EXPECT_EQ(area("1 mm2"), "1 unit2");
  EXPECT_EQ(area("1 cm2"), "100 unit2");
  EXPECT_EQ(area("1000000 um2"), "1 unit2");
  EXPECT_EQ(area("200 spacing2"), "200 spacing2");
  EXPECT_EQ(area("0.1 %area"), "0.1 %area");
}

TEST(Overrides, ReplaceAddAndReachIntoMaps) {
  const std::string text = with_load("  - orient: {neighbors: 12}\n  - curvature:\n");
  const Configuration configuration =
      parse_configuration(text, "scan.yaml",
                          {"orient.neighbors=20", "curvature.steps=3", "curvature.radius=0.5 mm",
                           "load.crop={min: [0, 0, -9], max: [50, 50, 9]}", "load.crop.max=[60, 50, 9]"});
  EXPECT_EQ(value(configuration, "orient", "neighbors"), "20");
  EXPECT_EQ(value(configuration, "curvature", "steps"), "3");
  EXPECT_EQ(value(configuration, "curvature", "radius"), "0.5 unit");
  EXPECT_EQ(value(configuration, "load", "crop"), "{min: [0, 0, -9], max: [60, 50, 9]}");
}

TEST(Overrides, TheLastOneCountsAndNamesOfStagesAreUsed) {
  const std::string text =
      with_load("  - orient: {}\n  - curvature: {name: fine, steps: 2}\n  - curvature: {steps: 5}\n");
  const Configuration configuration =
      parse_configuration(text, "scan.yaml", {"fine.steps=3", "fine.steps=4", "curvature.steps=6"});
  EXPECT_EQ(value(configuration, "fine", "steps"), "4");
  EXPECT_EQ(value(configuration, "curvature", "steps"), "6");
}

TEST(Plan, TheNearestEarlierMakerIsTaken) {
  const Configuration configuration = parse_configuration(
      with_load("  - load: {name: second, path: " + kScan + "}\n  - orient: {}\n  - curvature: {}\n  - mesh: {}\n"),
      "scan.yaml");
  EXPECT_EQ(sources(configuration, "orient", "points"), "second.points");
  EXPECT_EQ(sources(configuration, "mesh", "normals"), "orient.normals");
}

TEST(Plan, InputsNamesAnotherMaker) {
  const Configuration configuration = parse_configuration(
      with_load("  - load: {name: second, path: " + kScan + "}\n  - orient: {inputs: {points: load}}\n"), "scan.yaml");
  EXPECT_EQ(sources(configuration, "orient", "points"), "load.points");
}

TEST(Plan, AScalarNamedWithItsStageNeedsThatStageAlone) {
  const std::string stages =
      "  - orient: {}\n  - curvature: {name: fine}\n  - curvature: {name: coarse}\n  - mesh: {}\n";
  const Configuration named =
      parse_configuration(with_load(stages + "  - tree: {scalar: fine.mean_curvature}\n"), "scan.yaml");
  EXPECT_EQ(sources(named, "tree", "scalars"), "fine.scalars");
  const Configuration all = parse_configuration(with_load(stages + "  - tree: {}\n"), "scan.yaml");
  EXPECT_EQ(sources(all, "tree", "scalars"), "fine.scalars coarse.scalars");
}

TEST(Plan, AnUnreadableInputIsAnInputErrorAfterEveryConfigError) {
  const std::string text = "version: 1\nstages:\n  - load: {path: not-there.ply}\n";
  EXPECT_THROW(parse_configuration(text, "scan.yaml"), InputError);
  EXPECT_THROW(parse_configuration(text + "  - orientt: {}\n", "scan.yaml"), ConfigError);
}

TEST(LoadConfiguration, AMissingFileAndAFolderAreNamed) {
  const auto message = [](const std::string& path) {
    try {
      load_configuration(path);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message("/not/there.yaml"), "/not/there.yaml: cannot be opened: No such file or directory");
  EXPECT_EQ(message("/tmp"), "/tmp: a folder, expected a configuration file");
  EXPECT_NE(message(kScan).find("no configuration is so large"), std::string::npos) << message(kScan);
}

}  // namespace
}  // namespace meshmser
