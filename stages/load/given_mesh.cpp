#include "stages/load/given_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/execution/error.hpp"
#include "stages/load/polygon_cut.hpp"

namespace meshmser {
namespace {

using Triangle = std::array<std::int32_t, 3>;

std::size_t at(std::int64_t index) {
  return static_cast<std::size_t>(index);
}
std::int32_t next_in_triangle(std::int32_t h) {
  return h % 3 == 2 ? h - 2 : h + 1;
}

/// Disjoint sets; the root of each is its least member.
class LeastRootSets {
 public:
  explicit LeastRootSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t root(std::int32_t i) {
    while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    parent_[at(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> parent_;
};

/// Half-edges of one undirected edge are consecutive; groups ascend by vertices, half-edges within by number.
struct EdgeGroups {
  std::vector<std::int32_t> half_edges;
  std::vector<std::int64_t> first;  // one more than groups
};

EdgeGroups group_edges(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed(3 * triangles.size());
  for (std::size_t h = 0; h < keyed.size(); ++h) {
    const Triangle& t = triangles[h / 3];
    const std::int32_t a = t[h % 3], b = t[(h + 1) % 3];
    keyed[h] = {static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint64_t>(std::max(a, b)),
                static_cast<std::int32_t>(h)};
  }
  std::sort(keyed.begin(), keyed.end());
  EdgeGroups groups;
  groups.half_edges.reserve(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    if (i == 0 || keyed[i].first != keyed[i - 1].first) groups.first.push_back(static_cast<std::int64_t>(i));
    groups.half_edges.push_back(keyed[i].second);
  }
  groups.first.push_back(static_cast<std::int64_t>(keyed.size()));
  return groups;
}

class Builder {
 public:
  Builder(const RawFaces& faces, const PointCloud& cloud, bool merge) : faces_(faces), cloud_(cloud), merge_(merge) {}

  GivenMesh build(const std::vector<Property>& raw_properties, MeshRepair repair) {
    map_raw_vertices();
    cut_faces();
    name_vertices();
    mend(repair);
    split_fans();
    fill_mesh(raw_properties);
    fill_normals();
    return std::move(result_);
  }

 private:
  /// Point of each raw vertex; -1 when it was dropped for another reason than being a duplicate.
  void map_raw_vertices() {
    point_of_raw_.assign(at(cloud_.num_raw_points), -1);
    reason_of_raw_.assign(at(cloud_.num_raw_points), DropReason::kDuplicate);
    for (std::size_t p = 0; p < cloud_.num_points(); ++p)
      point_of_raw_[at(cloud_.raw_index_of_point[p])] = static_cast<std::int32_t>(p);
    for (std::size_t d = 0; d < cloud_.dropped_raw_index.size(); ++d) {
      point_of_raw_[at(cloud_.dropped_raw_index[d])] = cloud_.kept_point_of_dropped[d];
      reason_of_raw_[at(cloud_.dropped_raw_index[d])] = cloud_.drop_reasons[d];
    }
  }

  std::size_t file_of_face(std::int64_t face) const {
    return at(std::upper_bound(faces_.first_face_of_file.begin(), faces_.first_face_of_file.end(), face) -
              faces_.first_face_of_file.begin() - 1);
  }
  std::string file_name(std::int64_t face) const { return faces_.file_names[file_of_face(face)]; }
  std::int64_t face_in_file(std::int64_t face) const { return face - faces_.first_face_of_file[file_of_face(face)]; }
  std::int64_t vertex_in_file(std::int64_t raw) const {
    for (const Scan& scan : cloud_.scans) {
      if (raw < scan.num_raw_points) break;
      raw -= scan.num_raw_points;
    }
    return raw;
  }

  /// Triangles of raw vertices, in the order of the faces.
  void cut_faces() {
    std::vector<Eigen::Vector3d> corners;
    for (std::size_t f = 0; f + 1 < faces_.first_corner_of_face.size(); ++f) {
      const std::int64_t begin = faces_.first_corner_of_face[f], end = faces_.first_corner_of_face[f + 1];
      bool cropped = false;
      for (std::int64_t c = begin; c < end; ++c) {
        const std::int64_t raw = faces_.corners[at(c)];
        if (point_of_raw_[at(raw)] >= 0) continue;
        if (reason_of_raw_[at(raw)] == DropReason::kNonFinite)
          throw InputError(fmt::format(
              "{}: face {} has vertex {}, whose coordinates are not finite; remove the face or mend the vertex",
              file_name(static_cast<std::int64_t>(f)), face_in_file(static_cast<std::int64_t>(f)),
              vertex_in_file(raw)));
        cropped = true;
      }
      if (cropped) {
        result_.report.num_cropped += end - begin - 2;
        continue;
      }
      if (end - begin == 3) {
        add_triangle(static_cast<std::int64_t>(f), begin, begin + 1, begin + 2);
        continue;
      }
      ++result_.report.num_polygons_cut;
      corners.clear();
      for (std::int64_t c = begin; c < end; ++c)
        corners.push_back(cloud_.positions[at(point_of_raw_[at(faces_.corners[at(c)])])]);
      for (const std::array<int, 3>& t : cut_polygon(corners))
        add_triangle(static_cast<std::int64_t>(f), begin + t[0], begin + t[1], begin + t[2]);
    }
  }

  void add_triangle(std::int64_t face, std::int64_t c0, std::int64_t c1, std::int64_t c2) {
    std::array<std::int32_t, 3> raw{};
    const std::array<std::int64_t, 3> c{c0, c1, c2};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t vertex = faces_.corners[at(c[k])];
      raw[k] = static_cast<std::int32_t>(merge_ ? cloud_.raw_index_of_point[at(point_of_raw_[at(vertex)])] : vertex);
    }
    if (raw[0] == raw[1] || raw[1] == raw[2] || raw[2] == raw[0]) {
      ++result_.report.num_degenerate;
      return;
    }
    triangles_.push_back(raw);
    face_of_triangle_.push_back(static_cast<std::int32_t>(face));
  }

  /// From raw indices to vertices 0 .. n - 1 by point, then raw index.
  void name_vertices() {
    if (triangles_.empty())
      throw InputError(fmt::format("{}: no face is left of {}: {} degenerate, {} outside 'crop'", faces_.file_names[0],
                                   faces_.first_corner_of_face.size() - 1, result_.report.num_degenerate,
                                   result_.report.num_cropped));
    if (triangles_.size() > at(std::numeric_limits<std::int32_t>::max() / 3))
      throw InputError(fmt::format("{}: {} triangles; at most {} are possible", faces_.file_names[0], triangles_.size(),
                                   std::numeric_limits<std::int32_t>::max() / 3));
    std::vector<std::int32_t> vertex_of_raw(at(cloud_.num_raw_points), -1);
    for (const Triangle& t : triangles_)
      for (const std::int32_t raw : t) vertex_of_raw[at(raw)] = 0;
    for (std::size_t raw = 0; raw < vertex_of_raw.size(); ++raw)
      if (vertex_of_raw[raw] == 0) raw_of_vertex_.push_back(static_cast<std::int32_t>(raw));
    std::sort(raw_of_vertex_.begin(), raw_of_vertex_.end(), [&](std::int32_t a, std::int32_t b) {
      return std::pair(point_of_raw_[at(a)], a) < std::pair(point_of_raw_[at(b)], b);
    });
    for (std::size_t v = 0; v < raw_of_vertex_.size(); ++v) {
      vertex_of_raw[at(raw_of_vertex_[v])] = static_cast<std::int32_t>(v);
      if (v > 0 && point_of_raw_[at(raw_of_vertex_[v])] == point_of_raw_[at(raw_of_vertex_[v - 1])])
        ++result_.report.num_coincident_vertices;
    }
    for (Triangle& t : triangles_)
      for (std::int32_t& corner : t) corner = vertex_of_raw[at(corner)];
  }

  Eigen::Vector3d position(std::int32_t vertex) const {
    return cloud_.positions[at(point_of_raw_[at(raw_of_vertex_[at(vertex)])])];
  }
  Eigen::Vector3d twice_area_vector(const Triangle& t) const {
    const Eigen::Vector3d a = position(t[0]);
    return (position(t[1]) - a).cross(position(t[2]) - a);
  }
  std::int32_t start_of(std::int32_t h) const { return triangles_[at(h / 3)][at(h % 3)]; }

  /// Finds what is not manifold or not consistent, and repairs or refuses it; fills twin_.
  void mend(MeshRepair repair) {
    EdgeGroups groups = group_edges(triangles_);
    std::vector<std::int64_t> crowded, disagreeing;
    for (std::size_t g = 0; g + 1 < groups.first.size(); ++g) {
      const std::int64_t size = groups.first[g + 1] - groups.first[g];
      const std::int32_t* h = &groups.half_edges[at(groups.first[g])];
      if (size > 2) crowded.push_back(static_cast<std::int64_t>(g));
      if (size == 2 && start_of(h[0]) == start_of(h[1])) disagreeing.push_back(static_cast<std::int64_t>(g));
    }
    result_.report.num_non_manifold_edges = static_cast<std::int64_t>(crowded.size());
    result_.report.num_inconsistent_edges = static_cast<std::int64_t>(disagreeing.size());
    if (repair == MeshRepair::kNone) {
      if (!crowded.empty()) refuse(groups, crowded, "non-manifold", "an edge may have two triangles at most");
      if (!disagreeing.empty())
        refuse(groups, disagreeing, "inconsistently oriented", "the two triangles of an edge must turn the same way");
    }
    if (repair == MeshRepair::kDrop && !crowded.empty()) {
      drop_smaller(groups, crowded);
      groups = group_edges(triangles_);
    }
    twin_.assign(3 * triangles_.size(), -1);
    for (std::size_t g = 0; g + 1 < groups.first.size(); ++g) {
      if (groups.first[g + 1] - groups.first[g] != 2) continue;
      const std::int32_t a = groups.half_edges[at(groups.first[g])], b = groups.half_edges[at(groups.first[g] + 1)];
      twin_[at(a)] = b;
      twin_[at(b)] = a;
    }
    if (!disagreeing.empty() || !crowded.empty()) turn_triangles();
  }

  [[noreturn]] void refuse(const EdgeGroups& groups, const std::vector<std::int64_t>& bad, const char* what,
                           const char* rule) const {
    constexpr std::size_t kNamed = 10;
    std::string list;
    for (std::size_t i = 0; i < std::min(bad.size(), kNamed); ++i) {
      const std::int64_t begin = groups.first[at(bad[i])], end = groups.first[at(bad[i]) + 1];
      const std::int32_t h = groups.half_edges[at(begin)];
      const std::int32_t a = start_of(h), b = start_of(next_in_triangle(h));
      list += fmt::format("{}vertices {} and {} (faces", i == 0 ? "" : ", ",
                          vertex_in_file(raw_of_vertex_[at(std::min(a, b))]),
                          vertex_in_file(raw_of_vertex_[at(std::max(a, b))]));
      for (std::int64_t k = begin; k < end; ++k)
        list += fmt::format(" {}", face_in_file(face_of_triangle_[at(groups.half_edges[at(k)] / 3)]));
      list += ")";
    }
    const std::int64_t first_face = face_of_triangle_[at(groups.half_edges[at(groups.first[at(bad[0])])] / 3)];
    throw InputError(fmt::format("{}: {} {} edge{}: {}{}; {}; mend the mesh, or set 'repair: split' or 'repair: drop'",
                                 file_name(first_face), bad.size(), what, bad.size() == 1 ? "" : "s", list,
                                 bad.size() > kNamed ? fmt::format(" and {} more", bad.size() - kNamed) : "", rule));
  }

  /// Keeps the two largest triangles of each crowded edge.
  void drop_smaller(const EdgeGroups& groups, const std::vector<std::int64_t>& crowded) {
    std::vector<std::uint8_t> dropped(triangles_.size(), 0);
    for (const std::int64_t g : crowded) {
      std::vector<std::pair<double, std::int32_t>> by_area;
      for (std::int64_t k = groups.first[at(g)]; k < groups.first[at(g) + 1]; ++k) {
        const std::int32_t t = groups.half_edges[at(k)] / 3;
        by_area.emplace_back(-twice_area_vector(triangles_[at(t)]).norm(), t);
      }
      std::sort(by_area.begin(), by_area.end());
      for (std::size_t i = 2; i < by_area.size(); ++i) dropped[at(by_area[i].second)] = 1;
    }
    std::size_t kept = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (dropped[t] != 0) {
        ++result_.report.num_dropped;
        continue;
      }
      triangles_[kept] = triangles_[t];
      face_of_triangle_[kept++] = face_of_triangle_[t];
    }
    triangles_.resize(kept);
    face_of_triangle_.resize(kept);
  }

  /// Turns triangles so that neighbours agree, the lesser area of each component; links between triangles that cannot
  /// agree (as on a Moebius strip) are cut.
  void turn_triangles() {
    std::vector<std::int8_t> turned(triangles_.size(), -1);
    std::vector<std::int32_t> queue;
    for (std::size_t seed = 0; seed < triangles_.size(); ++seed) {
      if (turned[seed] >= 0) continue;
      queue.assign(1, static_cast<std::int32_t>(seed));
      turned[seed] = 0;
      double area[2] = {0, 0};
      for (std::size_t head = 0; head < queue.size(); ++head) {
        const std::int32_t t = queue[head];
        area[turned[at(t)]] += twice_area_vector(triangles_[at(t)]).norm();
        for (std::int32_t h = 3 * t; h < 3 * t + 3; ++h) {
          const std::int32_t g = twin_[at(h)];
          if (g < 0) continue;
          const bool same = start_of(h) == start_of(g);
          const auto wanted = static_cast<std::int8_t>(turned[at(t)] ^ (same ? 1 : 0));
          if (turned[at(g / 3)] < 0) {
            turned[at(g / 3)] = wanted;
            queue.push_back(g / 3);
          } else if (turned[at(g / 3)] != wanted) {
            twin_[at(h)] = twin_[at(g)] = -1;
          }
        }
      }
      if (area[1] > area[0])
        for (const std::int32_t t : queue) turned[at(t)] ^= 1;
    }
    // Corners 1 and 2 change places: half-edge 3 t and 3 t + 2 change places, each now the other way round.
    auto moved = [&](std::int32_t h) {
      if (h < 0 || turned[at(h / 3)] == 0 || h % 3 == 1) return h;
      return h % 3 == 0 ? h + 2 : h - 2;
    };
    std::vector<std::int32_t> twin(twin_.size());
    for (std::size_t h = 0; h < twin_.size(); ++h) twin[at(moved(static_cast<std::int32_t>(h)))] = moved(twin_[h]);
    twin_ = std::move(twin);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (turned[t] == 0) continue;
      std::swap(triangles_[t][1], triangles_[t][2]);
      ++result_.report.num_turned;
    }
  }

  /// Gives each fan of triangles around a vertex a vertex of its own, next to the others in order.
  void split_fans() {
    LeastRootSets corners(3 * triangles_.size());
    for (std::size_t h = 0; h < twin_.size(); ++h) {
      const std::int32_t g = twin_[h];
      if (g < 0 || static_cast<std::size_t>(g) < h) continue;
      const auto half_edge = static_cast<std::int32_t>(h);
      corners.join(half_edge, next_in_triangle(g));
      corners.join(next_in_triangle(half_edge), g);
    }
    std::vector<std::pair<std::int32_t, std::int32_t>> fans;  // vertex, least corner
    for (std::int32_t c = 0; c < static_cast<std::int32_t>(3 * triangles_.size()); ++c)
      if (corners.root(c) == c) fans.emplace_back(start_of(c), c);
    std::sort(fans.begin(), fans.end());
    std::vector<std::int32_t> vertex_of_root(3 * triangles_.size(), -1), raw_of_vertex;
    for (std::size_t v = 0; v < fans.size(); ++v) {
      vertex_of_root[at(fans[v].second)] = static_cast<std::int32_t>(v);
      raw_of_vertex.push_back(raw_of_vertex_[at(fans[v].first)]);
      if (v > 0 && fans[v].first == fans[v - 1].first) ++result_.report.num_split_vertices;
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        triangles_[t][k] = vertex_of_root[at(corners.root(static_cast<std::int32_t>(3 * t + k)))];
    raw_of_vertex_ = std::move(raw_of_vertex);
  }

  void fill_mesh(const std::vector<Property>& raw_properties) {
    TriangleMesh& mesh = result_.mesh;
    mesh.origin = cloud_.origin;
    mesh.spacing = cloud_.spacing;
    const std::size_t n = raw_of_vertex_.size();
    for (const std::int32_t raw : raw_of_vertex_) {
      mesh.point_of_vertex.push_back(point_of_raw_[at(raw)]);
      mesh.positions.push_back(cloud_.positions[at(mesh.point_of_vertex.back())]);
    }
    mesh.triangles = triangles_;
    mesh.turned_of_vertex.assign(n, 0);
    for (const Property& property : raw_properties) {
      mesh.properties.push_back({property.name, property.type, std::vector<double>(n)});
      for (std::size_t v = 0; v < n; ++v) mesh.properties.back().values[v] = property.values[at(raw_of_vertex_[v])];
    }
    mesh.normals.assign(n, Eigen::Vector3d::Zero());
    for (const Triangle& t : mesh.triangles) {
      const Eigen::Vector3d normal = twice_area_vector(t).normalized();
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d a = mesh.positions[at(t[(k + 1) % 3])] - mesh.positions[at(t[k])];
        const Eigen::Vector3d b = mesh.positions[at(t[(k + 2) % 3])] - mesh.positions[at(t[k])];
        const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
        if (normal.allFinite()) mesh.normals[at(t[k])] += angle * normal;
      }
    }
  }

  void fill_normals() {
    TriangleMesh& mesh = result_.mesh;
    PointNormals& normals = result_.normals;
    const std::size_t num_points = cloud_.num_points();
    normals.normals.assign(num_points, Eigen::Vector3d::Zero());
    for (std::size_t v = 0; v < mesh.num_vertices(); ++v) {
      normals.normals[at(mesh.point_of_vertex[v])] += mesh.normals[v];
      if (mesh.normals[v].norm() > 0) mesh.normals[v].normalize();
    }
    for (Eigen::Vector3d& normal : normals.normals)
      if (normal.norm() > 0) normal.normalize();

    LeastRootSets sets(mesh.num_vertices());
    for (const Triangle& t : mesh.triangles) {
      sets.join(t[0], t[1]);
      sets.join(t[0], t[2]);
    }
    // Components of points: that of a point's first vertex. Closed ones enclose a signed volume.
    std::vector<std::int32_t> root_of_point(num_points, -1);
    std::vector<std::int64_t> size_of_root(mesh.num_vertices(), 0);
    for (std::size_t v = 0; v < mesh.num_vertices(); ++v) {
      std::int32_t& root = root_of_point[at(mesh.point_of_vertex[v])];
      if (root >= 0) continue;
      root = sets.root(static_cast<std::int32_t>(v));
      ++size_of_root[at(root)];
    }
    std::vector<std::int32_t> roots;
    for (std::size_t v = 0; v < mesh.num_vertices(); ++v)
      if (size_of_root[v] > 0) roots.push_back(static_cast<std::int32_t>(v));
    std::stable_sort(roots.begin(), roots.end(),
                     [&](std::int32_t a, std::int32_t b) { return size_of_root[at(a)] > size_of_root[at(b)]; });
    std::vector<std::int32_t> component_of_root(mesh.num_vertices(), -1);
    for (const std::int32_t root : roots) {
      component_of_root[at(root)] = static_cast<std::int32_t>(normals.components.size());
      normals.components.push_back({size_of_root[at(root)], SignSource::kGiven, 1.0, false});
    }
    normals.component_of_point.assign(num_points, -1);
    for (std::size_t p = 0; p < num_points; ++p) {
      if (root_of_point[p] < 0) {
        ++result_.report.num_unused_vertices;
      } else {
        normals.component_of_point[p] = component_of_root[at(root_of_point[p])];
      }
    }

    std::vector<double> volume(mesh.num_vertices(), 0);
    std::vector<std::uint8_t> open(mesh.num_vertices(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& corners = mesh.triangles[t];
      const std::int32_t root = sets.root(corners[0]);
      const Eigen::Vector3d base = mesh.positions[at(root)];
      volume[at(root)] +=
          (mesh.positions[at(corners[0])] - base)
              .dot((mesh.positions[at(corners[1])] - base).cross(mesh.positions[at(corners[2])] - base));
      for (std::size_t k = 0; k < 3; ++k)
        if (twin_[3 * t + k] < 0) open[at(root)] = 1;
    }
    for (std::size_t v = 0; v < mesh.num_vertices(); ++v)
      if (open[v] == 0 && volume[v] < 0) ++result_.report.num_inside_out;
  }

  const RawFaces& faces_;
  const PointCloud& cloud_;
  bool merge_;
  GivenMesh result_;
  std::vector<std::int32_t> point_of_raw_;
  std::vector<DropReason> reason_of_raw_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> face_of_triangle_, raw_of_vertex_, twin_;
};

}  // namespace

GivenMesh build_given_mesh(const RawFaces& faces, const PointCloud& cloud, const std::vector<Property>& raw_properties,
                           MeshRepair repair, bool merge) {
  return Builder(faces, cloud, merge).build(raw_properties, repair);
}

}  // namespace meshmser
