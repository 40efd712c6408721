#include "stages/export/plan_files.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "pipeline/formats/output_file.hpp"

namespace meshmser {
namespace {

std::size_t at(std::int64_t index) {
  return static_cast<std::size_t>(index);
}

const Eigen::Vector3d& start_of(const TriangleMesh& mesh, std::int32_t h) {
  return mesh.positions[at(mesh.triangles[at(h / 3)][at(h % 3)])];
}

/// Edges of one kind one after the other on a loop; closed where they are all of it.
struct Run {
  std::int32_t owner = 0;
  EdgeKind kind = EdgeKind::kLevel;
  bool closed = false;
  std::vector<Eigen::Vector2d> points;
};

std::vector<Run> runs_of(const TriangleMesh& mesh, const BorderLoops& loops, const DrawingAxes& axes) {
  std::vector<Run> runs;
  for (std::size_t l = 0; l < loops.num_loops(); ++l) {
    const std::int64_t begin = loops.first_edge_of_loop[l], count = loops.first_edge_of_loop[l + 1] - begin;
    const auto kind = [&](std::int64_t i) { return loops.kinds[at(begin + i % count)]; };
    const auto point = [&](std::int64_t i) {
      const Eigen::Vector3d p = start_of(mesh, loops.half_edges[at(begin + i % count)]) + mesh.origin;
      return Eigen::Vector2d(p.dot(axes.right), p.dot(axes.up));
    };
    std::int64_t start = 0;  // where a run begins
    while (start < count && kind(start) == kind(start + count - 1)) ++start;
    const bool closed = start == count;
    if (closed) start = 0;
    for (std::int64_t i = 0; i < count;) {
      Run run{loops.owner_of_loop[l], kind(start + i), closed, {}};
      while (i < count && kind(start + i) == run.kind) run.points.push_back(point(start + i++));
      if (!closed) run.points.push_back(point(start + i));
      runs.push_back(std::move(run));
    }
  }
  return runs;
}

struct Unit {
  const char* name;
  double millimetres;
  std::int64_t dxf;  ///< $INSUNITS
};

/// 1 and no unit where the name is not known.
Unit unit_of(const std::string& name) {
  static constexpr Unit kUnits[] = {{"mm", 1, 4}, {"cm", 10, 5},      {"m", 1000, 6},
                                    {"in", 25.4, 1}, {"um", 0.001, 13}, {"ft", 304.8, 2}};
  for (const Unit& unit : kUnits)
    if (name == unit.name) return unit;
  return {"", 1, 0};
}

void pair_of_codes(OutputFile& file, std::int64_t code, std::string_view value) {
  file.number(code);
  file.character('\n');
  file.text(value);
  file.character('\n');
}

void pair_of_codes(OutputFile& file, std::int64_t code, double value) {
  file.number(code);
  file.character('\n');
  file.number(value);
  file.character('\n');
}

}  // namespace

DrawingAxes best_fitting_plane(const TriangleMesh& mesh, const BorderLoops& loops) {
  if (loops.half_edges.size() < 3) return {};
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), facing = mean;
  for (const std::int32_t h : loops.half_edges) {
    mean += start_of(mesh, h);
    const auto& t = mesh.triangles[at(h / 3)];
    const Eigen::Vector3d& a = mesh.positions[at(t[0])];
    facing += (mesh.positions[at(t[1])] - a).cross(mesh.positions[at(t[2])] - a);
  }
  mean /= static_cast<double>(loops.half_edges.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const std::int32_t h : loops.half_edges) {
    const Eigen::Vector3d d = start_of(mesh, h) - mean;
    spread += d * d.transpose();
  }
  Eigen::Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  if (normal.dot(facing) < 0) normal = -normal;
  const Eigen::Vector3d upward = std::abs(normal.y()) < 0.8 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  DrawingAxes axes;
  axes.up = (upward - normal * normal.dot(upward)).normalized();
  axes.right = axes.up.cross(normal);
  return axes;
}

void write_borders_svg(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops,
                       const DrawingAxes& axes, const std::string& units) {
  const std::vector<Run> runs = runs_of(mesh, loops, axes);
  const double scale = unit_of(units).millimetres;
  constexpr double kMargin = 2;  // so that no line is cut at the paper's edge
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(kInfinity, kInfinity), high = -low;
  for (const Run& run : runs)
    for (const Eigen::Vector2d& p : run.points) low = low.cwiseMin(scale * p), high = high.cwiseMax(scale * p);
  if (runs.empty()) low = high = Eigen::Vector2d::Zero();
  // A ten-thousandth of a millimetre is finer than any drawing.
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
  const double width = rounded(high.x() - low.x() + 2 * kMargin), height = rounded(high.y() - low.y() + 2 * kMargin);
  OutputFile file(path);
  file.text("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"");
  file.number(width);
  file.text("mm\" height=\"");
  file.number(height);
  file.text("mm\" viewBox=\"0 0 ");
  file.number(width);
  file.character(' ');
  file.number(height);
  file.text(
      "\">\n<style>path{fill:none;stroke:#101014;stroke-width:.2;stroke-linejoin:round}"
      ".hole{stroke:#7a28dc;stroke-dasharray:.8 .4}</style>\n");
  for (const Run& run : runs) {
    file.text(run.kind == EdgeKind::kHole ? "<path class=\"hole\" data-number=\"" : "<path class=\"level\" data-number=\"");
    file.number(std::int64_t{run.owner});
    file.text("\" d=\"");
    for (std::size_t i = 0; i < run.points.size(); ++i) {
      file.character(i == 0 ? 'M' : 'L');
      file.number(rounded(scale * run.points[i].x() - low.x() + kMargin));
      file.character(' ');
      file.number(rounded(high.y() - scale * run.points[i].y() + kMargin));
    }
    file.text(run.closed ? "Z\"/>\n" : "\"/>\n");
  }
  file.text("</svg>\n");
  file.finish();
}

void write_borders_dxf(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops,
                       const DrawingAxes& axes, const std::string& units) {
  OutputFile file(path);
  file.text("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n");
  file.number(unit_of(units).dxf);
  file.text("\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
  for (const Run& run : runs_of(mesh, loops, axes)) {
    const std::string layer = (run.kind == EdgeKind::kHole ? "HOLE_" : "LEVEL_") + std::to_string(run.owner);
    pair_of_codes(file, 0, "POLYLINE");
    pair_of_codes(file, 8, layer);
    file.text("66\n1\n10\n0\n20\n0\n30\n0\n70\n");
    file.text(run.closed ? "1\n" : "0\n");
    for (const Eigen::Vector2d& p : run.points) {
      pair_of_codes(file, 0, "VERTEX");
      pair_of_codes(file, 8, layer);
      pair_of_codes(file, 10, p.x());
      pair_of_codes(file, 20, p.y());
      pair_of_codes(file, 30, "0");
    }
    pair_of_codes(file, 0, "SEQEND");
    pair_of_codes(file, 8, layer);
  }
  file.text("0\nENDSEC\n0\nEOF\n");
  file.finish();
}

}  // namespace meshmser
