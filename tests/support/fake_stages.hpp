#pragma once
/// Four small stages with every kind of port use, for tests of what runs stages. To be included by one file a program.

#include <cmath>
#include <fstream>
#include <map>
#include <string>

#include "pipeline/stage/stage.hpp"

namespace meshmser::fake {

/// How often each stage ran, by its name in the configuration.
inline std::map<std::string, int> num_runs;
/// Goes into the files that `write` writes, behind the cache's back.
inline std::string salt;
/// Called when a stage runs.
inline std::function<void(const std::string& stage)> on_run = [](const std::string&) {};

inline void ran(const RunContext& context) {
  ++num_runs[context.stage_name()];
  on_run(context.stage_name());
}

/// Reads numbers.
struct Numbers {
  static constexpr StageInfo info{"numbers", 1, "Reads numbers."};
  struct Parameters {
    InputPath path;
    int chunk = 1;
  };
  static void declare(StageSchema& s) {
    s.parameter("path", &Parameters::path, "The file.");
    s.parameter("chunk", &Parameters::chunk, "Of no effect.").affects_result = false;
    s.output<PointCloud>("cloud");
  }
  static std::vector<std::filesystem::path> files(const Parameters& p) { return {p.path.resolved}; }
  static Outputs run(const Parameters& p, const Inputs&, RunContext& context) {
    ran(context);
    PointCloud cloud;
    std::ifstream file(p.path.resolved);
    for (double x = 0; file >> x;) cloud.positions.emplace_back(x, 0, 0);
    context.report("num_points", static_cast<std::int64_t>(cloud.num_points()));
    if (cloud.num_points() < 4) context.warn("there are few numbers");
    Outputs outputs;
    outputs.set("cloud", std::move(cloud));
    return outputs;
  }
};

/// Adds an amount to each number and rounds.
struct Shift {
  static constexpr StageInfo info{"shift", 1, "Adds to numbers, and rounds."};
  struct Parameters {
    double amount = 0.1;
  };
  static void declare(StageSchema& s) {
    s.parameter("amount", &Parameters::amount, "What is added.");
    s.input<PointCloud>("cloud");
    s.output<SmoothedPoints>("smoothed");
  }
  static Outputs run(const Parameters& p, const Inputs& inputs, RunContext& context) {
    ran(context);
    SmoothedPoints smoothed;
    for (const Eigen::Vector3d& x : inputs.get<PointCloud>("cloud").positions)
      smoothed.positions.emplace_back(std::round(x.x() + p.amount), 0, 0);
    Outputs outputs;
    outputs.set("smoothed", std::move(smoothed));
    return outputs;
  }
};

/// Sums, times a factor.
struct Sum {
  static constexpr StageInfo info{"sum", 1, "Sums numbers."};
  struct Parameters {
    double factor = 1;
    bool fail = false;
  };
  static void declare(StageSchema& s) {
    s.parameter("factor", &Parameters::factor, "Times the sum.");
    s.parameter("fail", &Parameters::fail, "Whether to fail.");
    s.input<SmoothedPoints>("smoothed");
    s.output<ScalarFields>("scalars");
  }
  static Outputs run(const Parameters& p, const Inputs& inputs, RunContext& context) {
    ran(context);
    if (p.fail) throw StageError("sum was asked to fail");
    ScalarFields fields;
    double sum = 0;
    for (const Eigen::Vector3d& x : inputs.get<SmoothedPoints>("smoothed").positions) sum += x.x();
    fields.fields = {{"sum", "", Parity::kEven, 0, {sum * p.factor}}};
    context.report("sum", sum * p.factor);
    Outputs outputs;
    outputs.set("scalars", std::move(fields));
    return outputs;
  }
};

/// Writes every sum into a file.
struct Write {
  static constexpr StageInfo info{"write", 1, "Writes sums."};
  struct Parameters {
    std::string file = "sums.txt";
  };
  static void declare(StageSchema& s) {
    s.parameter("file", &Parameters::file, "Name of the file.");
    s.input<ScalarFields>("scalars", Need::kAll);
    s.output<FileSet>("files");
  }
  static Outputs run(const Parameters& p, const Inputs& inputs, RunContext& context) {
    ran(context);
    FileSet set{context.scratch_folder(), {p.file, "more.csv"}};
    std::ofstream file(set.folder / p.file);
    for (const auto& [stage, fields] : inputs.all<ScalarFields>("scalars"))
      file << stage << " " << fields->fields.front().values.front() << "\n";
    std::ofstream(set.folder / "more.csv") << "a,b\n1,2\n" << salt;
    Outputs outputs;
    outputs.set("files", std::move(set));
    return outputs;
  }
};

MESHMSER_STAGE(Numbers);
MESHMSER_STAGE(Shift);
MESHMSER_STAGE(Sum);
MESHMSER_STAGE(Write);

/// Every stage once.
inline constexpr const char* kConfiguration = R"(version: 1
units: mm
stages:
  - numbers: {path: numbers.txt}
  - shift: {}
  - sum: {}
  - write: {}
)";

}  // namespace meshmser::fake
