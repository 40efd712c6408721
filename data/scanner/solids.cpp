#include "data/scanner/solids.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace meshmser::scanner {
namespace {

void add_triangle(Shape& shape, std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t face) {
  shape.mesh.triangles.push_back({a, b, c});
  shape.face_of_triangle.push_back(face);
}

void add_quad(Shape& shape, std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d, std::int32_t face) {
  add_triangle(shape, a, b, c, face);
  add_triangle(shape, a, c, d, face);
}

std::int32_t add_vertex(Shape& shape, const Eigen::Vector3d& position) {
  shape.mesh.positions.push_back(position);
  return static_cast<std::int32_t>(shape.mesh.positions.size()) - 1;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Ear clipping of a simple polygon, inside on the left. Corners may lie on straight sides.
std::vector<std::array<std::int32_t, 3>> triangulate(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<std::int32_t> rest(corners.size());
  std::iota(rest.begin(), rest.end(), 0);
  std::vector<std::array<std::int32_t, 3>> triangles;
  auto at = [&](std::int32_t i) { return corners[static_cast<std::size_t>(i)]; };
  while (rest.size() > 3) {
    std::size_t best = rest.size();
    double best_area = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const std::int32_t a = rest[(i + rest.size() - 1) % rest.size()], b = rest[i], c = rest[(i + 1) % rest.size()];
      const double area = cross(at(b) - at(a), at(c) - at(a));
      if (area <= best_area) continue;
      const bool empty = std::none_of(rest.begin(), rest.end(), [&](std::int32_t p) {
        return p != a && p != b && p != c && cross(at(b) - at(a), at(p) - at(a)) >= 0 &&
               cross(at(c) - at(b), at(p) - at(b)) >= 0 && cross(at(a) - at(c), at(p) - at(c)) >= 0;
      });
      if (empty) {
        best = i;
        best_area = area;
      }
    }
    if (best == rest.size()) throw std::logic_error("triangulate: the polygon is not simple");
    triangles.push_back({rest[(best + rest.size() - 1) % rest.size()], rest[best], rest[(best + 1) % rest.size()]});
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(best));
  }
  triangles.push_back({rest[0], rest[1], rest[2]});
  return triangles;
}

}  // namespace

int circle_segments(double radius, double tolerance) {
  return std::max(24, static_cast<int>(std::ceil(std::numbers::pi / std::acos(1 - std::min(1.0, tolerance / radius)))));
}

Shape box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, std::int32_t first_face) {
  Shape shape;
  for (int i = 0; i < 8; ++i)
    add_vertex(shape, {i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  add_quad(shape, 0, 4, 6, 2, first_face);
  add_quad(shape, 1, 3, 7, 5, first_face + 1);
  add_quad(shape, 0, 1, 5, 4, first_face + 2);
  add_quad(shape, 2, 6, 7, 3, first_face + 3);
  add_quad(shape, 0, 2, 3, 1, first_face + 4);
  add_quad(shape, 4, 5, 7, 6, first_face + 5);
  return shape;
}

Shape frustum(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double from_radius, double to_radius,
              double tolerance, std::int32_t first_face) {
  Shape shape;
  const Eigen::Vector3d axis = (to - from).normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
  const int n = circle_segments(std::max(from_radius, to_radius), tolerance);
  for (int i = 0; i < n; ++i) {
    // An odd start keeps vertices off the planes of other solids.
    const double angle = 2 * std::numbers::pi * i / n + 0.1234;
    const Eigen::Vector3d outward = u * std::cos(angle) + v * std::sin(angle);
    add_vertex(shape, from + outward * from_radius);
    add_vertex(shape, to + outward * to_radius);
  }
  const std::int32_t from_centre = add_vertex(shape, from), to_centre = add_vertex(shape, to);
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t a = 2 * i, b = 2 * ((i + 1) % n);
    add_quad(shape, a, b, b + 1, a + 1, first_face);
    add_triangle(shape, from_centre, b, a, first_face + 1);
    add_triangle(shape, to_centre, a + 1, b + 1, first_face + 2);
  }
  return shape;
}

Shape prism(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& half_width, std::int32_t first_face) {
  Shape shape;
  const Eigen::Vector3d outward = (b - a).cross(c - a).dot(half_width) > 0 ? half_width : Eigen::Vector3d(-half_width);
  for (const Eigen::Vector3d& corner : {a, b, c}) {
    add_vertex(shape, corner - outward);
    add_vertex(shape, corner + outward);
  }
  add_triangle(shape, 0, 4, 2, first_face);
  add_triangle(shape, 1, 3, 5, first_face + 1);
  for (std::int32_t i = 0; i < 3; ++i) {
    const std::int32_t p = 2 * i, q = 2 * ((i + 1) % 3);
    add_quad(shape, p, q, q + 1, p + 1, first_face + 2 + i);
  }
  return shape;
}

Shape sphere(double radius, int level) {
  Shape shape;
  const double golden = (1 + std::sqrt(5.0)) / 2;
  for (double x : {-1.0, 1.0})
    for (double y : {-golden, golden})
      for (int axis = 0; axis < 3; ++axis) {
        Eigen::Vector3d corner = Eigen::Vector3d::Zero();
        corner[axis] = x;
        corner[(axis + 1) % 3] = y;
        add_vertex(shape, corner.normalized());
      }
  // The faces of the icosahedron: triples of corners that are neighbours of each other.
  const double edge = 2 / std::sqrt(1 + golden * golden);
  auto& p = shape.mesh.positions;
  auto adjacent = [&](std::size_t a, std::size_t b) { return std::abs((p[a] - p[b]).norm() - edge) < 1e-9; };
  for (std::size_t a = 0; a < 12; ++a)
    for (std::size_t b = a + 1; b < 12; ++b)
      for (std::size_t c = b + 1; c < 12; ++c) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(a, c)) continue;
        const bool outward = p[a].dot(p[b].cross(p[c])) > 0;
        add_triangle(shape, static_cast<std::int32_t>(a), static_cast<std::int32_t>(outward ? b : c),
                     static_cast<std::int32_t>(outward ? c : b), 1);
      }
  for (int step = 0; step < level; ++step) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middle_of_edge;
    auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto [entry, is_new] = middle_of_edge.try_emplace({std::min(a, b), std::max(a, b)}, 0);
      if (is_new)
        entry->second =
            add_vertex(shape, (p[static_cast<std::size_t>(a)] + p[static_cast<std::size_t>(b)]).normalized());
      return entry->second;
    };
    const auto coarse = std::move(shape.mesh.triangles);
    shape.mesh.triangles.clear();
    shape.face_of_triangle.clear();
    for (const auto& [a, b, c] : coarse) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      add_triangle(shape, a, ab, ca, 1);
      add_triangle(shape, b, bc, ab, 1);
      add_triangle(shape, c, ca, bc, 1);
      add_triangle(shape, ab, bc, ca, 1);
    }
  }
  for (Eigen::Vector3d& position : p) position *= radius;
  return shape;
}

Shape torus(double ring_radius, double tube_radius, double tolerance) {
  Shape shape;
  const int around = circle_segments(ring_radius + tube_radius, tolerance),
            across = circle_segments(tube_radius, tolerance);
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around, b = 2 * std::numbers::pi * j / across;
      const double r = ring_radius + tube_radius * std::cos(b);
      add_vertex(shape, {r * std::cos(a), r * std::sin(a), tube_radius * std::sin(b)});
    }
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const int k = (i + 1) % around, l = (j + 1) % across;
      add_quad(shape, i * across + j, k * across + j, k * across + l, i * across + l, 1);
    }
  return shape;
}

Shape height_field(const HeightField& field, std::int32_t first_wall_face) {
  Shape shape;
  const int nx = field.columns, ny = field.rows;
  const Eigen::Vector2d step((field.high.x() - field.low.x()) / nx, (field.high.y() - field.low.y()) / ny);
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const double x = field.low.x() + i * step.x(), y = field.low.y() + j * step.y();
      add_vertex(shape, {x, y, field.height(x, y)});
    }
  auto top = [&](int i, int j) { return j * (nx + 1) + i; };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const double x = field.low.x() + (i + 0.5) * step.x(), y = field.low.y() + (j + 0.5) * step.y();
      const bool falls = field.falls && field.falls(x, y);
      const std::int32_t a = top(i, j), b = top(i + 1, j), c = top(i + 1, j + 1), d = top(i, j + 1);
      // A centroid lies a sixth of a cell off the centre.
      const double dx = step.x() / 6, dy = step.y() / 6;
      if (falls) {
        add_triangle(shape, a, b, d, field.face(x - dx, y - dy));
        add_triangle(shape, b, c, d, field.face(x + dx, y + dy));
      } else {
        add_triangle(shape, a, b, c, field.face(x + dx, y - dy));
        add_triangle(shape, a, c, d, field.face(x - dx, y + dy));
      }
    }
  if (!field.floor) return shape;
  // The rim, counter-clockwise from (low x, low y); wall number of the side that begins at each rim vertex.
  std::vector<std::int32_t> rim, wall;
  for (int i = 0; i < nx; ++i) rim.push_back(top(i, 0)), wall.push_back(2);
  for (int j = 0; j < ny; ++j) rim.push_back(top(nx, j)), wall.push_back(1);
  for (int i = nx; i > 0; --i) rim.push_back(top(i, ny)), wall.push_back(3);
  for (int j = ny; j > 0; --j) rim.push_back(top(0, j)), wall.push_back(0);
  std::vector<std::int32_t> below;
  for (std::int32_t v : rim) {
    Eigen::Vector3d position = shape.mesh.positions[static_cast<std::size_t>(v)];
    position.z() = *field.floor;
    below.push_back(add_vertex(shape, position));
  }
  const Eigen::Vector2d middle = (field.low + field.high) / 2;
  const std::int32_t centre = add_vertex(shape, {middle.x(), middle.y(), *field.floor});
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const std::size_t next = (i + 1) % rim.size();
    add_quad(shape, below[i], below[next], rim[next], rim[i], first_wall_face + wall[i]);
    add_triangle(shape, centre, below[next], below[i], first_wall_face + 4);
  }
  return shape;
}

Shape extrusion(const std::vector<Eigen::Vector2d>& corners, const std::vector<std::int32_t>& face_of_side,
                double length, std::int32_t cap_face) {
  Shape shape;
  for (const Eigen::Vector2d& corner : corners) {
    add_vertex(shape, {corner.x(), 0, corner.y()});
    add_vertex(shape, {corner.x(), length, corner.y()});
  }
  const auto n = static_cast<std::int32_t>(corners.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t a = 2 * i, b = 2 * ((i + 1) % n);
    add_quad(shape, a, a + 1, b + 1, b, face_of_side[static_cast<std::size_t>(i)]);
  }
  // Left turns in (x, z) are counter-clockwise seen from low y.
  for (const auto& [a, b, c] : triangulate(corners)) {
    add_triangle(shape, 2 * a, 2 * b, 2 * c, cap_face);
    add_triangle(shape, 2 * a + 1, 2 * c + 1, 2 * b + 1, cap_face + 1);
  }
  return shape;
}

Shape turned_solid(const Turning& turning) {
  Shape shape;
  const std::size_t last = turning.profile.size() - 1;
  const int n = turning.segments;
  const std::int32_t bottom = add_vertex(shape, {0, 0, turning.profile.front().y()});
  const std::int32_t top = add_vertex(shape, {0, 0, turning.profile.back().y()});
  for (std::size_t point = 1; point < last; ++point)
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      const double radius = turning.radius ? turning.radius(point, angle) : turning.profile[point].x();
      add_vertex(shape, {radius * std::cos(angle), radius * std::sin(angle), turning.profile[point].y()});
    }
  auto ring = [&](std::size_t point, int i) { return 2 + static_cast<std::int32_t>(point - 1) * n + i % n; };
  auto add = [&](std::size_t piece, std::int32_t a, std::int32_t b, std::int32_t c, double angle) {
    const auto& p = shape.mesh.positions;
    const double z =
        (p[static_cast<std::size_t>(a)].z() + p[static_cast<std::size_t>(b)].z() + p[static_cast<std::size_t>(c)].z()) /
        3;
    add_triangle(shape, a, b, c, turning.face(piece, angle, z));
  };
  for (std::size_t piece = 0; piece < last; ++piece)
    for (int i = 0; i < n; ++i) {
      const double step = 2 * std::numbers::pi / n, angle = i * step;
      if (piece == 0) {
        add(piece, bottom, ring(1, i + 1), ring(1, i), angle + step / 2);
      } else if (piece == last - 1) {
        add(piece, top, ring(last - 1, i), ring(last - 1, i + 1), angle + step / 2);
      } else {
        add(piece, ring(piece, i), ring(piece, i + 1), ring(piece + 1, i + 1), angle + step * 2 / 3);
        add(piece, ring(piece, i), ring(piece + 1, i + 1), ring(piece + 1, i), angle + step / 3);
      }
    }
  return shape;
}

}  // namespace meshmser::scanner
