/// What a user would pick instead for parting a machined part into facets, on the mesh that meshmser made of its scan:
/// PCL region growing on the points, CGAL region growing of planes on the mesh, CGAL sharp-edge detection.
///
///   part_rivals METHOD MESH.ply OUT.csv --spacing S [--smooth N] [--angle DEGREES] [--distance SPACINGS]
///
/// METHOD: pcl_region_growing, cgal_region_growing, cgal_sharp_edges. OUT has the columns of label_borders.csv.
/// Triangles that a method leaves without a region join the nearest region (breadth first), as its best case.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Shape_detection/Region_growing/Region_growing.h>
#include <CGAL/Shape_detection/Region_growing/Region_growing_on_polygon_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <deque>
#include <numbers>

#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/ply.hpp"
#include "stages/common/adjacency.hpp"

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Corners = std::array<std::int32_t, 3>;

struct Options {
  std::string method, mesh, out;
  double spacing = 0, angle = 0, distance = 1;
  int smooth = 0;
};

struct Mesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Corners> triangles;
  std::vector<std::int32_t> twins;
};

Mesh read(const std::string& path) {
  const meshmser::Geometry geometry = meshmser::read_ply(meshmser::read_file_bytes(path));
  Mesh mesh;
  mesh.positions = geometry.positions;
  for (std::size_t f = 0; f < geometry.num_faces(); ++f) {
    const std::int32_t* corners = geometry.corners.data() + geometry.first_corner_of_face[f];
    mesh.triangles.push_back({corners[0], corners[1], corners[2]});
  }
  mesh.twins = meshmser::twin_half_edges(mesh.triangles, mesh.positions.size());
  return mesh;
}

/// Every vertex to the mean of its neighbours, `steps` times: what a user does to a noisy mesh first.
std::vector<Eigen::Vector3d> smoothed(const Mesh& mesh, int steps) {
  std::vector<Eigen::Vector3d> positions = mesh.positions;
  for (int step = 0; step < steps; ++step) {
    std::vector<Eigen::Vector3d> sums(positions.size(), Eigen::Vector3d::Zero());
    std::vector<int> counts(positions.size(), 0);
    for (const Corners& t : mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto a = static_cast<std::size_t>(t[k]), b = static_cast<std::size_t>(t[(k + 1) % 3]);
        sums[a] += positions[b];
        sums[b] += positions[a];
        ++counts[a];
        ++counts[b];
      }
    for (std::size_t v = 0; v < positions.size(); ++v)
      if (counts[v] > 0) positions[v] = sums[v] / counts[v];
  }
  return positions;
}

SurfaceMesh surface_mesh(const Mesh& mesh, const std::vector<Eigen::Vector3d>& positions) {
  SurfaceMesh surface;
  for (const Eigen::Vector3d& p : positions) surface.add_vertex({p.x(), p.y(), p.z()});
  using Vertex = SurfaceMesh::Vertex_index;
  for (const Corners& t : mesh.triangles)
    if (!surface.add_face(Vertex(t[0]), Vertex(t[1]), Vertex(t[2])).is_valid())
      throw std::runtime_error("not a manifold mesh");
  return surface;
}

std::vector<int> labels_by_pcl(const Mesh& mesh, const std::vector<Eigen::Vector3d>& positions, const Options& o) {
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3d& p : positions) cloud->push_back({float(p.x()), float(p.y()), float(p.z())});
  auto normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
  auto search = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(search);
  estimation.setKSearch(50);
  estimation.compute(*normals);
  pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
  growing.setMinClusterSize(60);
  growing.setMaxClusterSize(std::numeric_limits<int>::max());
  growing.setSearchMethod(search);
  growing.setNumberOfNeighbours(30);
  growing.setInputCloud(cloud);
  growing.setInputNormals(normals);
  growing.setSmoothnessThreshold(float(o.angle * std::numbers::pi / 180));
  growing.setCurvatureThreshold(float(o.distance));  // of surface variation
  std::vector<pcl::PointIndices> clusters;
  growing.extract(clusters);
  std::vector<int> label_of_point(positions.size(), 0);
  for (std::size_t c = 0; c < clusters.size(); ++c)
    for (const int p : clusters[c].indices) label_of_point[static_cast<std::size_t>(p)] = int(c) + 1;
  std::vector<int> labels;
  for (const Corners& t : mesh.triangles) {
    const int a = label_of_point[std::size_t(t[0])], b = label_of_point[std::size_t(t[1])],
              c = label_of_point[std::size_t(t[2])];
    labels.push_back(b == c ? b : a);
  }
  return labels;
}

/// The faces around a face; beyond an open edge lies none.
struct RingOfFaces {
  CGAL::Shape_detection::Polygon_mesh::One_ring_neighbor_query<SurfaceMesh> query;
  std::size_t num_faces;

  void operator()(std::size_t face, std::vector<std::size_t>& neighbors) const {
    query(face, neighbors);
    std::erase_if(neighbors, [this](std::size_t neighbor) { return neighbor >= num_faces; });
  }
};

std::vector<int> labels_by_cgal(const SurfaceMesh& surface, const Options& o) {
  namespace Detection = CGAL::Shape_detection::Polygon_mesh;
  using Plane = Detection::Least_squares_plane_fit_region<Kernel, SurfaceMesh>;
  using Sorting = Detection::Least_squares_plane_fit_sorting<Kernel, SurfaceMesh, RingOfFaces>;
  RingOfFaces neighbors{Detection::One_ring_neighbor_query<SurfaceMesh>(surface), surface.number_of_faces()};
  Plane plane(surface, o.distance * o.spacing, o.angle, 100, surface.points());
  Sorting sorting(surface, neighbors, surface.points());
  sorting.sort();
  CGAL::Shape_detection::Region_growing<SurfaceMesh::Face_range, RingOfFaces, Plane, Sorting::Seed_map> growing(
      surface.faces(), neighbors, plane, sorting.seed_map());
  std::vector<std::vector<std::size_t>> regions;
  growing.detect(std::back_inserter(regions));
  std::vector<int> labels(surface.number_of_faces(), 0);
  for (std::size_t r = 0; r < regions.size(); ++r)
    for (const std::size_t f : regions[r]) labels[f] = int(r) + 1;
  return labels;
}

/// Half-edges of the mesh that CGAL calls sharp.
std::vector<char> sharp_by_cgal(const Mesh& mesh, SurfaceMesh& surface, const Options& o) {
  auto is_sharp = surface.add_property_map<SurfaceMesh::Edge_index, bool>("e:sharp", false).first;
  CGAL::Polygon_mesh_processing::detect_sharp_edges(surface, o.angle, is_sharp);
  std::vector<char> sharp(mesh.twins.size(), 0);
  for (std::size_t h = 0; h < sharp.size(); ++h) {
    const Corners& t = mesh.triangles[h / 3];
    const auto found = surface.halfedge(SurfaceMesh::Vertex_index(t[h % 3]), SurfaceMesh::Vertex_index(t[(h + 1) % 3]));
    sharp[h] = mesh.twins[h] >= 0 && is_sharp[surface.edge(found)];
  }
  return sharp;
}

void flood(const Mesh& mesh, std::vector<int>& labels) {
  std::deque<std::size_t> queue;
  for (std::size_t t = 0; t < labels.size(); ++t)
    if (labels[t] > 0) queue.push_back(t);
  for (; !queue.empty(); queue.pop_front())
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t twin = mesh.twins[3 * queue.front() + k];
      if (twin < 0 || labels[std::size_t(twin) / 3] > 0) continue;
      labels[std::size_t(twin) / 3] = labels[queue.front()];
      queue.push_back(std::size_t(twin) / 3);
    }
}

void write(const Mesh& mesh, const std::vector<char>& border, const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) throw std::runtime_error("cannot write " + path);
  std::fputs("region,loop,edge,x0,y0,z0,x1,y1,z1,kind,neighbour\n", file);
  for (std::size_t h = 0; h < border.size(); ++h) {
    if (!border[h]) continue;
    const Corners& t = mesh.triangles[h / 3];
    const Eigen::Vector3d &a = mesh.positions[std::size_t(t[h % 3])], &b = mesh.positions[std::size_t(t[(h + 1) % 3])];
    std::fprintf(file, "0,0,0,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,level,0\n", a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
  }
  std::fclose(file);
}

void compare(const Options& o) {
  const Mesh mesh = read(o.mesh);
  const std::vector<Eigen::Vector3d> positions = smoothed(mesh, o.smooth);
  std::vector<char> border(mesh.twins.size(), 0);
  if (o.method == "cgal_sharp_edges") {
    SurfaceMesh surface = surface_mesh(mesh, positions);
    border = sharp_by_cgal(mesh, surface, o);
  } else {
    std::vector<int> labels = o.method == "pcl_region_growing" ? labels_by_pcl(mesh, positions, o)
                                                               : labels_by_cgal(surface_mesh(mesh, positions), o);
    flood(mesh, labels);
    for (std::size_t h = 0; h < border.size(); ++h)
      border[h] = mesh.twins[h] >= 0 && labels[h / 3] != labels[std::size_t(mesh.twins[h]) / 3];
  }
  write(mesh, border, o.out);
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app("Other ways to part a scanned part into facets.");
  app.add_option("METHOD", o.method)
      ->required()
      ->check(CLI::IsMember({"pcl_region_growing", "cgal_region_growing", "cgal_sharp_edges"}));
  app.add_option("MESH", o.mesh)->required();
  app.add_option("OUT", o.out)->required();
  app.add_option("--spacing", o.spacing, "of the scan, in coordinate units")->required();
  app.add_option("--smooth", o.smooth, "Laplacian steps before");
  app.add_option("--angle", o.angle, "degrees")->required();
  app.add_option("--distance", o.distance, "from the plane in spacings; PCL: of surface variation");
  CLI11_PARSE(app, argc, argv);
  try {
    compare(o);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "part_rivals: %s\n", error.what());
    return 1;
  }
}
