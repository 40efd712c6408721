#include "stages/load/load_scan.hpp"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "stages/common/parallel.hpp"
#include "stages/load/canonical_order.hpp"

namespace meshmser {
namespace {

constexpr std::int64_t kMostPoints = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kGrain = 1 << 16;

std::size_t at(std::int64_t index) {
  return static_cast<std::size_t>(index);
}

/// All raw points, one file after the other.
struct RawPoints {
  std::vector<Eigen::Vector3d> positions;  // in the frame of the scan
  std::vector<std::uint32_t> scan;
  std::vector<Property> properties;
};

void turn_normals(Geometry& geometry, const Eigen::Matrix3d& rotation) {
  std::array<std::vector<double>*, 3> parts{};
  for (Property& property : geometry.properties)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (property.name == std::string("n") + "xyz"[axis]) parts[axis] = &property.values;
  if (std::find(parts.begin(), parts.end(), nullptr) != parts.end()) return;
  for (std::size_t i = 0; i < geometry.num_vertices(); ++i) {
    const Eigen::Vector3d turned = rotation * Eigen::Vector3d((*parts[0])[i], (*parts[1])[i], (*parts[2])[i]);
    for (std::size_t axis = 0; axis < 3; ++axis) (*parts[axis])[i] = turned[static_cast<Eigen::Index>(axis)];
  }
}

/// The properties of all scans under each other; where a scan lacks one, its values are NaN.
std::vector<Property> join_properties(std::vector<PosedScan>& scans, std::int64_t num_raw) {
  if (scans.size() == 1) return std::move(scans[0].geometry.properties);
  std::vector<Property> joined;
  std::int64_t begin = 0;
  for (PosedScan& scan : scans) {
    for (Property& property : scan.geometry.properties) {
      auto same =
          std::find_if(joined.begin(), joined.end(), [&](const Property& p) { return p.name == property.name; });
      if (same == joined.end()) {
        joined.push_back(
            {property.name, property.type, std::vector<double>(at(num_raw), std::numeric_limits<double>::quiet_NaN())});
        same = joined.end() - 1;
      } else if (same->type != property.type) {
        same->type = ValueType::kFloat64;
      }
      std::copy(property.values.begin(), property.values.end(), same->values.begin() + begin);
      property.values = {};
    }
    begin += static_cast<std::int64_t>(scan.geometry.num_vertices());
  }
  // A whole number has no NaN.
  for (Property& property : joined) {
    const bool missing = std::any_of(scans.begin(), scans.end(), [&](const PosedScan& scan) {
      return std::none_of(scan.geometry.properties.begin(), scan.geometry.properties.end(),
                          [&](const Property& p) { return p.name == property.name; });
    });
    if (missing && property.type != ValueType::kFloat32) property.type = ValueType::kFloat64;
  }
  return joined;
}

RawPoints join_points(std::vector<PosedScan>& scans, const Execution& execution) {
  RawPoints raw;
  std::int64_t num_raw = 0;
  for (const PosedScan& scan : scans) num_raw += static_cast<std::int64_t>(scan.geometry.num_vertices());
  if (num_raw > kMostPoints)
    throw InputError(fmt::format("{} points in all; at most {} are possible, load fewer files or crop them beforehand",
                                 num_raw, kMostPoints));
  raw.positions.resize(at(num_raw));
  raw.scan.resize(at(num_raw));
  std::int64_t begin = 0;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const Eigen::Isometry3d& pose = scans[s].world_from_file;
    const bool moved = !pose.matrix().isIdentity(0);
    if (moved) turn_normals(scans[s].geometry, pose.linear());
    const std::vector<Eigen::Vector3d>& from = scans[s].geometry.positions;
    parallel_chunks(static_cast<std::int64_t>(from.size()), kGrain, "", execution,
                    [&](std::int64_t first, std::int64_t last) {
                      for (std::int64_t i = first; i < last; ++i) {
                        // Adding zero turns -0 into 0: equal places get equal bytes.
                        raw.positions[at(begin + i)] =
                            ((moved ? Eigen::Vector3d(pose * from[at(i)]) : from[at(i)]).array() + 0.0).matrix();
                        raw.scan[at(begin + i)] = static_cast<std::uint32_t>(s);
                      }
                    });
    begin += static_cast<std::int64_t>(from.size());
  }
  raw.properties = join_properties(scans, num_raw);
  return raw;
}

struct Ranked {
  std::uint64_t code;
  std::int32_t raw;
};

/// Raw indices of the points in canonical order, duplicates side by side.
std::vector<Ranked> rank(const RawPoints& raw, const std::vector<std::int32_t>& alive, const MortonGrid& grid,
                         const Execution& execution) {
  std::vector<Ranked> order(alive.size());
  parallel_chunks(static_cast<std::int64_t>(alive.size()), kGrain, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    for (std::int64_t i = begin; i < end; ++i)
                      order[at(i)] = {grid.code(raw.positions[at(alive[at(i)])]), alive[at(i)]};
                  });
  execution.report("sort", 0, 0);
  auto before = [&raw](const Ranked& a, const Ranked& b) {
    if (a.code != b.code) return a.code < b.code;
    const Eigen::Vector3d &p = raw.positions[at(a.raw)], &q = raw.positions[at(b.raw)];
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] != q[axis]) return p[axis] < q[axis];
    if (raw.scan[at(a.raw)] != raw.scan[at(b.raw)]) return raw.scan[at(a.raw)] < raw.scan[at(b.raw)];
    for (const Property& property : raw.properties) {
      const double v = property.values[at(a.raw)], w = property.values[at(b.raw)];
      if (std::isnan(v) != std::isnan(w)) return std::isnan(w);
      if (v != w && !std::isnan(v)) return v < w;
    }
    return a.raw < b.raw;
  };
  on_threads(execution, [&] { tbb::parallel_sort(order.begin(), order.end(), before); });
  return order;
}

/// Zero, or on axes far from zero a whole multiple of a power of two: coordinates are then within a factor of two of
/// it, so that subtracting it is exact (Sterbenz 1974) and adding it back too.
Eigen::Vector3d choose_origin(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  constexpr double kFar = 16;
  const double extent = (high - low).maxCoeff();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = low[axis] + (high[axis] - low[axis]) / 2;
    if (std::abs(middle) <= kFar * extent || middle == 0) continue;
    const double unit = extent > 0 ? std::exp2(std::floor(std::log2(extent))) : 0;
    origin[axis] = unit > 0 && std::abs(middle) / unit < 0x1p52 ? std::round(middle / unit) * unit : middle;
  }
  return origin;
}

RawFaces join_faces(const std::vector<PosedScan>& scans, bool turned) {
  RawFaces faces;
  faces.first_corner_of_face.push_back(0);
  std::int64_t first_vertex = 0;
  for (const PosedScan& scan : scans) {
    const Geometry& g = scan.geometry;
    faces.first_face_of_file.push_back(static_cast<std::int64_t>(faces.first_corner_of_face.size()) - 1);
    faces.file_names.push_back(g.name);
    const std::int64_t offset = static_cast<std::int64_t>(faces.corners.size());
    for (std::size_t f = 0; f < g.num_faces(); ++f)
      faces.first_corner_of_face.push_back(offset + g.first_corner_of_face[f + 1]);
    for (const std::int32_t corner : g.corners) faces.corners.push_back(first_vertex + corner);
    first_vertex += static_cast<std::int64_t>(g.num_vertices());
  }
  if (turned)
    for (std::size_t f = 0; f + 1 < faces.first_corner_of_face.size(); ++f)
      std::reverse(faces.corners.begin() + faces.first_corner_of_face[f],
                   faces.corners.begin() + faces.first_corner_of_face[f + 1]);
  return faces;
}

/// Distance of neighbouring floats at the largest coordinate, where every coordinate of the files is a float; else 0.
double float_step(const std::vector<PosedScan>& scans) {
  float largest = 0;
  for (const PosedScan& scan : scans)
    for (const Eigen::Vector3d& p : scan.geometry.positions)
      for (int axis = 0; axis < 3; ++axis) {
        const auto rounded = static_cast<float>(p[axis]);
        if (static_cast<double>(rounded) != p[axis] && std::isfinite(p[axis])) return 0;
        if (std::isfinite(rounded)) largest = std::max(largest, std::abs(rounded));
      }
  return static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity())) -
         static_cast<double>(largest);
}

std::string names_of(const std::vector<PosedScan>& scans) {
  return scans.size() == 1 ? scans[0].geometry.name
                           : fmt::format("{} and {} more", scans[0].geometry.name, scans.size() - 1);
}

/// Where the scanner of each scan stood, in the frame of the scan. A scanner of which only the direction is known is
/// put a hundred times the scan's size away: rays are then parallel to a third of a degree.
void place_scanners(const std::vector<PosedScan>& scans, const RawPoints& raw, PointCloud& points) {
  constexpr double kFarAway = 100;
  std::size_t first = 0;
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const PosedScan& scan = scans[s];
    const std::size_t last = first + scan.geometry.num_vertices();
    const auto& position = scan.scanner_position ? scan.scanner_position : scan.geometry.scanner_position;
    if (position) {
      points.scans[s].scanner_position = scan.world_from_file * *position - points.origin;
    } else if (scan.geometry.view_direction) {
      Eigen::AlignedBox3d box;
      for (std::size_t i = first; i < last; ++i)
        if (raw.positions[i].allFinite()) box.extend(raw.positions[i]);
      if (!box.isEmpty())
        points.scans[s].scanner_position =
            box.center() - points.origin +
            scan.world_from_file.linear() * *scan.geometry.view_direction * (kFarAway * box.diagonal().norm());
    }
    first = last;
  }
}

}  // namespace

LoadedScan load_scan(std::vector<PosedScan> scans, const LoadScanOptions& options, const Execution& execution) {
  if (scans.empty()) throw InputError("no files to load; give 'path' or 'files'");
  LoadedScan loaded;
  LoadReport& report = loaded.report;
  std::size_t num_meshes = 0;
  for (const PosedScan& scan : scans) {
    num_meshes += scan.geometry.num_faces() > 0;
    report.num_skipped_lines += scan.geometry.num_skipped_lines;
    report.num_empty_cells += scan.geometry.num_empty_cells;
  }
  report.float_step = float_step(scans);
  const bool has_mesh = options.use_faces && num_meshes > 0;
  if (has_mesh && num_meshes < scans.size())
    throw StageError(
        fmt::format("{} of {} files have faces; load meshes and scans apart, or all as points with 'faces: ignore'",
                    num_meshes, scans.size()));
  if (has_mesh && options.outliers.method != OutlierMethod::kNone)
    throw StageError(fmt::format("{} has faces; 'outliers' is for points alone, leave it out or set 'faces: ignore'",
                                 names_of(scans)));

  const RawPoints raw = join_points(scans, execution);
  const auto num_raw = static_cast<std::int64_t>(raw.positions.size());
  PointCloud& points = loaded.points;
  points.num_raw_points = num_raw;
  for (const PosedScan& scan : scans)
    points.scans.push_back({scan.geometry.name, std::nullopt, static_cast<std::int64_t>(scan.geometry.num_vertices())});

  constexpr std::uint8_t kAlive = 255;
  std::vector<std::uint8_t> fate(at(num_raw), kAlive);  // a DropReason, or kAlive
  auto drop = [&](std::int64_t i, DropReason reason, std::int64_t& count) {
    fate[at(i)] = static_cast<std::uint8_t>(reason);
    ++count;
  };
  std::vector<std::int32_t> alive;
  alive.reserve(at(num_raw));
  Eigen::AlignedBox3d box;
  for (std::int64_t i = 0; i < num_raw; ++i) {
    const Eigen::Vector3d& p = raw.positions[at(i)];
    if (!p.allFinite()) {
      drop(i, DropReason::kNonFinite, report.num_non_finite);
    } else if (options.crop && !options.crop->contains(p)) {
      drop(i, DropReason::kCropped, report.num_cropped);
    } else {
      alive.push_back(static_cast<std::int32_t>(i));
      box.extend(p);
    }
  }
  if (alive.empty())
    throw InputError(fmt::format("{}: no points are left: {} not finite, {} outside 'crop'; check the file and the box",
                                 names_of(scans), report.num_non_finite, report.num_cropped));
  constexpr double kLargest = 1e100;  // its cube is still a double
  if (!(box.min().cwiseAbs().maxCoeff() < kLargest && box.max().cwiseAbs().maxCoeff() < kLargest))
    throw InputError(
        fmt::format("{}: a coordinate exceeds {:g}; is the file damaged, or are its columns in another order?",
                    names_of(scans), kLargest));

  MortonGrid grid;
  {
    std::vector<Eigen::Vector3d> corners{box.min(), box.max()};
    grid = morton_grid(corners);
  }
  std::vector<Ranked> order = rank(raw, alive, grid, execution);
  alive = {};

  // Duplicates: all but the first of equal positions.
  std::vector<std::pair<std::int32_t, std::int32_t>> duplicates;  // raw index, raw index of the point kept
  std::size_t num_kept = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (num_kept > 0 && raw.positions[at(order[i].raw)] == raw.positions[at(order[num_kept - 1].raw)]) {
      drop(order[i].raw, DropReason::kDuplicate, report.num_duplicates);
      duplicates.emplace_back(order[i].raw, order[num_kept - 1].raw);
    } else {
      order[num_kept++] = order[i];
    }
  }
  order.resize(num_kept);

  points.origin = choose_origin(box.min(), box.max());
  grid.corner -= points.origin;
  std::vector<std::uint64_t> codes(num_kept);
  points.positions.resize(num_kept);
  auto take_positions = [&] {
    for (std::size_t i = 0; i < order.size(); ++i) {
      codes[i] = order[i].code;
      points.positions[i] = raw.positions[at(order[i].raw)] - points.origin;
    }
  };
  take_positions();
  points.spacing =
      measure_spacing(MortonIndex(grid, codes, points.positions), static_cast<std::int64_t>(num_kept), execution);

  if (options.outliers.method != OutlierMethod::kNone) {
    const std::vector<std::uint8_t> outlier =
        find_outliers(points.positions, points.spacing, options.outliers, execution);
    num_kept = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (outlier[i] != 0) {
        drop(order[i].raw, DropReason::kOutlier, report.num_outliers);
      } else {
        order[num_kept++] = order[i];
      }
    }
    if (num_kept == 0)
      throw StageError(fmt::format("{}: 'outliers' took every point; loosen its parameters", names_of(scans)));
    order.resize(num_kept);
    codes.resize(num_kept);
    points.positions.resize(num_kept);
    take_positions();
    points.spacing =
        measure_spacing(MortonIndex(grid, codes, points.positions), static_cast<std::int64_t>(num_kept), execution);
  }

  points.raw_index_of_point.resize(num_kept);
  points.scan_of_point.resize(num_kept);
  std::vector<std::int32_t> point_of_raw(at(num_raw), -1);
  for (std::size_t i = 0; i < num_kept; ++i) {
    points.raw_index_of_point[i] = order[i].raw;
    points.scan_of_point[i] = raw.scan[at(order[i].raw)];
    point_of_raw[at(order[i].raw)] = static_cast<std::int32_t>(i);
  }
  for (const Property& property : raw.properties) {
    points.properties.push_back({property.name, property.type, std::vector<double>(num_kept)});
    std::vector<double>& values = points.properties.back().values;
    for (std::size_t i = 0; i < num_kept; ++i) values[i] = property.values[at(order[i].raw)];
  }
  for (const auto& [duplicate, kept] : duplicates) point_of_raw[at(duplicate)] = point_of_raw[at(kept)];
  for (std::int64_t i = 0; i < num_raw; ++i) {
    if (fate[at(i)] == kAlive) continue;
    points.dropped_raw_index.push_back(i);
    points.dropped_positions.push_back(raw.positions[at(i)] - points.origin);
    points.drop_reasons.push_back(static_cast<DropReason>(fate[at(i)]));
    points.kept_point_of_dropped.push_back(points.drop_reasons.back() == DropReason::kDuplicate ? point_of_raw[at(i)]
                                                                                                : -1);
  }
  place_scanners(scans, raw, points);

  if (has_mesh) {
    const bool loose =
        std::any_of(scans.begin(), scans.end(), [](const PosedScan& scan) { return scan.geometry.loose_facets; });
    const bool merge =
        options.merge_vertices == MergeVertices::kYes || (options.merge_vertices == MergeVertices::kAuto && loose);
    GivenMesh given =
        build_given_mesh(join_faces(scans, options.turn_faces), points, raw.properties, options.repair, merge);
    loaded.mesh = std::move(given.mesh);
    loaded.normals = std::move(given.normals);
    report.mesh = given.report;
  }
  return loaded;
}

}  // namespace meshmser
