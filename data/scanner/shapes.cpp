#include "data/scanner/shapes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "data/scanner/glyphs.hpp"
#include "data/scanner/machine_parts.hpp"
#include "data/scanner/solids.hpp"
#include "pipeline/execution/error.hpp"

namespace meshmser::scanner {
namespace {

constexpr double kPi = std::numbers::pi;

struct Entry {
  ShapeInfo info;
  Shape (*make)(const ShapeParameters&);
};

Shape make_plane(const ShapeParameters& p) {
  HeightField field;
  field.high = Eigen::Vector2d::Constant(p.at("size") / 2);
  field.low = -field.high;
  field.columns = field.rows = std::max(1, static_cast<int>(std::lround(p.at("size") / p.at("edge"))));
  field.height = [](double, double) { return 0.0; };
  field.face = [](double, double) { return 1; };
  if (p.at("thickness") > 0) field.floor = -p.at("thickness");
  return height_field(field, 2);
}

Shape make_sphere(const ShapeParameters& p) {
  return sphere(p.at("radius"), static_cast<int>(p.at("level")));
}

Shape make_torus(const ShapeParameters& p) {
  return torus(p.at("ring_radius"), p.at("tube_radius"), p.at("tolerance"));
}

Shape make_cylinder(const ShapeParameters& p) {
  const double r = p.at("radius"), z = p.at("height") / 2;
  return frustum({0, 0, -z}, {0, 0, z}, r, r, p.at("tolerance"), 1);
}

/// Pyramids side by side (the diamond pattern of Digne et al. 2010, Fig. 3): four facets each, ridges between them,
/// valleys between pyramids.
Shape make_diamond(const ShapeParameters& p) {
  const int cells = static_cast<int>(p.at("cells"));
  const double size = p.at("cell"), half = cells * size / 2, height = p.at("height");
  // Coordinates within the cell, -1 .. 1 from side to side.
  auto local = [=](double x) {
    const double at = (x + half) / size;
    return 2 * (at - std::clamp(std::floor(at), 0.0, cells - 1.0)) - 1;
  };
  HeightField field;
  field.low = Eigen::Vector2d::Constant(-half);
  field.high = -field.low;
  const int halves = std::max(1, static_cast<int>(std::lround(size / 2 / p.at("edge"))));
  field.columns = field.rows = 2 * halves * cells;  // so that ridges and valleys run along mesh edges
  field.height = [=](double x, double y) { return height * (1 - std::max(std::abs(local(x)), std::abs(local(y)))); };
  field.falls = [=](double x, double y) { return local(x) * local(y) < 0; };
  field.face = [=](double x, double y) {
    const auto index = [&](double at) {
      return std::clamp(static_cast<int>(std::floor((at + half) / size)), 0, cells - 1);
    };
    const double u = local(x), v = local(y);
    const int facet = std::abs(u) > std::abs(v) ? (u > 0 ? 0 : 2) : (v > 0 ? 1 : 3);
    return 1 + 4 * (index(y) * cells + index(x)) + facet;
  };
  if (p.at("thickness") > 0) field.floor = -p.at("thickness");
  return height_field(field, 1 + 4 * cells * cells);
}

/// Depth of a groove as a share of its greatest, at a distance from its middle line in half widths: a parabola whose
/// rim is rounded over `rounding` half widths.
double groove_profile(double distance, double rounding) {
  const double g = 1 - distance * distance;
  return (g + std::sqrt(g * g + rounding * rounding)) / (1 + std::sqrt(1 + rounding * rounding));
}

Shape make_tablet(const ShapeParameters& p) {
  const double size = p.at("size"), sign = p.at("glyph"), width = p.at("groove_width"), depth = p.at("groove_depth");
  const int count = static_cast<int>(p.at("glyphs"));
  const double pitch = size / count;
  // Distance to the nearest stroke of the sign in whose field the point lies.
  auto distance = [=](double x, double y) {
    const auto index = [&](double at) {
      return std::clamp(static_cast<int>(std::floor((at + size / 2) / pitch)), 0, count - 1);
    };
    const int i = index(x), j = index(y);
    const auto& glyph = glyphs()[static_cast<std::size_t>(j * count + i + j) % glyphs().size()];
    const Eigen::Vector2d centre((i + 0.5) * pitch - size / 2, (j + 0.5) * pitch - size / 2);
    return distance_to_glyph(glyph, (Eigen::Vector2d(x, y) - centre) / sign) * sign;
  };
  HeightField field;
  field.high = Eigen::Vector2d::Constant(size / 2);
  field.low = -field.high;
  field.columns = field.rows = std::max(1, static_cast<int>(std::lround(size / p.at("edge"))));
  const double bulge = p.at("bulge"), wave = p.at("waviness");
  field.height = [=](double x, double y) {
    const double u = 2 * x / size, v = 2 * y / size;
    const double hand_made =
        bulge * (1 - (u * u + v * v) / 2) + wave * std::sin(2.1 * u + 0.7) * std::cos(2.7 * v - 0.4);
    return hand_made - depth * groove_profile(2 * distance(x, y) / width, p.at("rounding"));
  };
  field.face = [=](double x, double y) { return 2 * distance(x, y) < width ? 1 : 2; };
  if (p.at("thickness") > 0) field.floor = -p.at("thickness");
  return height_field(field, 3);
}

/// A stamped potsherd: a piece of a bent shell with ridges (rings about a point on the left, lines on the right), a
/// rounded, broken edge that falls off more steeply than is scanned, and the roughness of fired clay.
Shape make_sherd(const ShapeParameters& p) {
  const double size = p.at("size"), bend = p.at("bend_radius"), width = p.at("line_width"), pitch = p.at("pitch"),
               relief = p.at("relief"), round = p.at("edge_rounding"), rough = p.at("roughness");
  // Distance from the broken edge, > 0 inside: six straight breaks, each a little wavy.
  const auto from_edge = [=](double x, double y) {
    static constexpr double kTurns[] = {0.1, 1.3, 2.2, 3.0, 4.4, 5.4}, kShares[] = {1, 0.92, 1.02, 0.95, 0.9, 1.04};
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 6; ++i) {
      const double c = std::cos(kTurns[i]), s = std::sin(kTurns[i]), along = (c * y - s * x) / size;
      const double wave = 0.012 * std::sin(23 * along + i) + 0.007 * std::sin(61 * along + 2 * i);
      least = std::min(least, size * (0.42 * kShares[i] + wave) - (c * x + s * y));
    }
    return least;
  };
  const auto to_line = [=](double x, double y) {
    const double rho = std::hypot(x + 0.22 * size, y + 0.08 * size), ring = std::max(1.0, std::round(rho / pitch));
    const double border = 0.04 * size;  // between rings and lines nothing is stamped
    if (x < border - width) return std::abs(rho - ring * pitch);
    if (x < border + width) return std::numeric_limits<double>::infinity();
    const double across = 0.5 * x + 0.866 * y;
    return std::abs(across - std::round(across / pitch) * pitch);
  };
  HeightField field;
  field.high = Eigen::Vector2d::Constant(0.52 * size);
  field.low = -field.high;
  field.columns = field.rows = std::max(1, static_cast<int>(std::lround(1.04 * size / p.at("edge"))));
  field.height = [=](double x, double y) {
    const double shell = bend > 0 ? std::sqrt(bend * bend - x * x) - bend - y * y / (8 * bend) : 0;
    // A stamp is not pressed in evenly.
    const double pressed = 0.8 + 0.2 * std::sin(4 * x / size + 1) * std::cos(5 * y / size);
    const double raised = relief * pressed * groove_profile(std::min(9.0, 2 * to_line(x, y) / width), 0.25);
    double clay = 0;
    for (int i = 1; i <= 6; ++i) {
      const double turn = 2.4 * i, wave = 0.5 + 0.22 * i;
      clay += std::sin(2 * kPi / wave * (std::cos(turn) * x + std::sin(turn) * y) + i * i);
    }
    // A quarter circle down to where it is too steep to be scanned, straight on from there.
    const double steepest = 80 * kPi / 180, inside = from_edge(x, y), down = round - inside;
    const double at_steepest = round * std::sin(steepest);
    const double fall = down <= 0 ? 0
                        : down <= at_steepest
                            ? round - std::sqrt(round * round - down * down)
                            : round * (1 - std::cos(steepest)) + (down - at_steepest) * std::tan(steepest);
    return shell + raised + rough * clay / std::sqrt(3.0) - fall;
  };
  field.face = [=](double x, double y) { return from_edge(x, y) > round && 2 * to_line(x, y) < width ? 1 : 2; };
  double lowest = 0;
  for (int i = 0; i <= field.rows; ++i)
    for (int j = 0; j <= field.columns; ++j)
      lowest = std::min(lowest, field.height(field.low.x() + (field.high.x() - field.low.x()) * j / field.columns,
                                             field.low.y() + (field.high.y() - field.low.y()) * i / field.rows));
  field.floor = lowest - 1;
  return height_field(field, 3);
}

Shape make_ribs(const ShapeParameters& p) {
  // Counter-clockwise from the lower left: floor, right wall, then the ribs from right to left, left wall.
  std::vector<double> widths;
  for (double width = p.at("thinnest"); static_cast<int>(widths.size()) < static_cast<int>(p.at("count"));
       width *= p.at("growth"))
    widths.push_back(width);
  const double gap = p.at("gap"), height = p.at("height"), base = p.at("base");
  double length = gap;
  for (double width : widths) length += width + gap;
  std::vector<Eigen::Vector2d> corners = {{0, -base}, {length, -base}, {length, 0}};
  std::vector<std::int32_t> faces = {1, 2};
  double x = length - gap;
  std::int32_t face = 4;
  for (auto width = widths.rbegin(); width != widths.rend(); ++width) {
    faces.push_back(3);
    corners.insert(corners.end(), {{x, 0}, {x, height}, {x - *width, height}, {x - *width, 0}});
    faces.insert(faces.end(), {face, face + 1, face + 2});
    face += 3;
    x -= *width + gap;
  }
  faces.push_back(3);
  corners.emplace_back(0, 0);
  faces.push_back(face);
  return extrusion(corners, faces, p.at("length"), face + 1);
}

Shape make_fillets(const ShapeParameters& p) {
  // Steps side by side whose upper edges are rounded by growing radii, and whose lower ones by the same: r, 2 r, 3 r
  // ...
  const int count = static_cast<int>(p.at("count"));
  const double land = p.at("land"), base = p.at("base"), rise = p.at("rise"), tolerance = p.at("tolerance");
  std::vector<Eigen::Vector2d> upper;       // from left to right
  std::vector<std::int32_t> face_of_piece;  // of the piece that begins at each point
  std::int32_t face = 1;
  double x = 0, z = 0;
  auto arc = [&](const Eigen::Vector2d& centre, double radius, double from, double to) {
    const int pieces = std::max(6, circle_segments(radius, tolerance) / 4);
    for (int i = 0; i < pieces; ++i) {
      const double angle = from + (to - from) * i / pieces;
      upper.emplace_back(centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle));
      face_of_piece.push_back(face);
    }
    ++face;
  };
  auto line_from = [&](double from_x, double from_z) {
    upper.emplace_back(from_x, from_z);
    face_of_piece.push_back(face++);
  };
  for (int step = 1; step <= count; ++step) {
    const double r = p.at("radius") * step;
    line_from(x, z);
    x += land;
    arc({x, z + r}, r, -kPi / 2, 0);  // valley
    line_from(x + r, z + r);
    z += rise + 2 * r;
    arc({x + 2 * r, z - r}, r, kPi, kPi / 2);  // ridge
    x += 2 * r;
  }
  line_from(x, z);
  x += land;
  std::vector<Eigen::Vector2d> corners = {{0, -base}, {x, -base}, {x, z}};
  std::vector<std::int32_t> faces = {face, face + 1};
  for (std::size_t i = upper.size(); i-- > 0;) {
    corners.push_back(upper[i]);
    faces.push_back(face_of_piece[i]);
  }
  faces.push_back(face + 2);
  return extrusion(corners, faces, p.at("length"), face + 3);
}

Shape make_shallow(const ShapeParameters& p) {
  // Strips that turn down by an angle and up again by the same; the angle grows from pair to pair.
  const int count = static_cast<int>(p.at("count"));
  const double strip = p.at("strip"), base = p.at("base");
  std::vector<Eigen::Vector2d> upper = {{0, 0}};
  for (int i = 0; i < count; ++i) {
    const double angle = (p.at("angle") + p.at("growth") * i) * kPi / 180, sign = i % 2 == 0 ? 1 : -1;
    upper.emplace_back(upper.back() + Eigen::Vector2d(strip, 0));
    upper.emplace_back(upper.back() + Eigen::Vector2d(strip * std::cos(angle), sign * strip * std::sin(angle)));
  }
  upper.emplace_back(upper.back() + Eigen::Vector2d(strip, 0));
  double lowest = 0;
  for (const Eigen::Vector2d& point : upper) lowest = std::min(lowest, point.y());
  const auto strips = static_cast<std::int32_t>(upper.size()) - 1;
  std::vector<Eigen::Vector2d> corners = {{0, lowest - base}, {upper.back().x(), lowest - base}};
  std::vector<std::int32_t> faces = {strips + 1, strips + 2};
  for (std::int32_t i = strips; i >= 0; --i) {
    corners.push_back(upper[static_cast<std::size_t>(i)]);
    faces.push_back(i > 0 ? i : strips + 3);
  }
  return extrusion(corners, faces, p.at("length"), strips + 4);
}

/// Appends an arc to a profile of (radius, z), its first point left out.
void append_arc(std::vector<Eigen::Vector2d>& profile, const Eigen::Vector2d& centre, double radius, double from,
                double to, int pieces) {
  for (int i = 1; i <= pieces; ++i) {
    const double angle = from + (to - from) * i / pieces;
    profile.emplace_back(centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle));
  }
}

Shape make_turned(const ShapeParameters& p) {
  // A knob: dome, groove, bulge, cone, tip; no flat face. Radii in units of a tenth of the height.
  const double u = p.at("height") / 10;
  std::vector<Eigen::Vector2d> profile = {{0, 0}};
  std::vector<std::size_t> ends;  // last piece of each face
  auto end_face = [&] { ends.push_back(profile.size() - 1); };
  append_arc(profile, {0, 3 * u}, 3 * u, -kPi / 2, -kPi / 12, 60);
  end_face();  // dome
  const double x = profile.back().x(), z = profile.back().y();
  append_arc(profile, {x, z + 0.8 * u}, 0.8 * u, -kPi / 2, -kPi * 3 / 2, 60);
  end_face();  // groove
  append_arc(profile, {x - 1.5 * u, z + 1.6 * u + 1.2 * u}, std::hypot(1.5 * u, 1.2 * u), -std::atan2(1.2, 1.5),
             std::atan2(1.2, 1.5), 50);
  end_face();  // bulge
  profile.emplace_back(1.3 * u, profile.back().y() + 2.2 * u);
  end_face();  // cone
  append_arc(profile, {0, profile.back().y()}, 1.3 * u, 0, kPi / 2, 50);
  end_face();  // tip
  profile.back().x() = 0;
  Turning turning;
  turning.profile = profile;
  turning.segments = circle_segments(3 * u, p.at("tolerance"));
  turning.face = [&](std::size_t piece, double, double) {
    return static_cast<std::int32_t>(std::upper_bound(ends.begin(), ends.end(), piece) - ends.begin()) + 1;
  };
  return turned_solid(turning);
}

Shape make_vase(const ShapeParameters& p) {
  const double height = p.at("height"), belly = p.at("radius"), wall = 0.07 * belly, relief = p.at("relief"),
               width = p.at("line_width");
  // Outer radius at a share of the height: foot, belly, neck, lip.
  auto outer = [=](double t) {
    return belly * (0.55 + 0.45 * std::sin(kPi * (0.12 + 1.05 * t)) + 0.18 * t * t * t * t);
  };
  const int rings = std::max(8, static_cast<int>(std::lround(height / p.at("edge"))));
  const int signs = static_cast<int>(p.at("glyphs"));
  Turning turning;
  turning.segments = std::max(24, static_cast<int>(std::lround(2 * kPi * belly / p.at("edge"))));
  turning.profile = {{0, 0}};
  for (int i = 0; i <= rings; ++i)
    turning.profile.emplace_back(outer(static_cast<double>(i) / rings), height * i / rings);
  const auto last_outer = static_cast<std::size_t>(rings) + 1;
  for (int i = rings; i > rings / 10; i -= 4)
    turning.profile.emplace_back(outer(static_cast<double>(i) / rings) - wall,
                                 height * i / rings - (i == rings ? 0 : wall / 8));
  turning.profile.emplace_back(0, turning.profile.back().y());
  // Distance, in millimetres on the belly, to the middle line of the relief: signs in a band, two rings around it.
  auto distance = [=](double angle, double z) {
    const double size = 2 * kPi * belly / signs * 0.8, at = angle / (2 * kPi) * signs;
    const int i = std::clamp(static_cast<int>(at), 0, signs - 1);
    const Eigen::Vector2d in_field((at - i - 0.5) * 2 * kPi * belly / signs, z - height * 0.5);
    const double sign =
        distance_to_glyph(glyphs()[static_cast<std::size_t>(i) % glyphs().size()], in_field / size) * size;
    return std::min({sign, std::abs(z - height * 0.5 - size * 0.72), std::abs(z - height * 0.5 + size * 0.72)});
  };
  turning.radius = [=, profile = turning.profile](std::size_t point, double angle) {
    const double raised = point >= 1 && point <= last_outer
                              ? relief * groove_profile(2 * distance(angle, profile[point].y()) / width, 0.25)
                              : 0;
    return profile[point].x() + raised;
  };
  turning.face = [=](std::size_t piece, double angle, double z) -> std::int32_t {
    if (piece == 0) return 3;           // foot
    if (piece == last_outer) return 4;  // lip
    if (piece > last_outer) return 5;   // inside
    return 2 * distance(angle, z) < width ? 1 : 2;
  };
  return turned_solid(turning);
}

/// A standing figure in low relief: rounded parts that rise out of a slab, each an elongated bump along a stroke.
struct FigurePart {
  Eigen::Vector2d from, to;  ///< in units of the figure's height, about its middle
  double radius, height;     ///< of the bump, in the same unit
};

Shape make_figurine(const ShapeParameters& p) {
  static const std::vector<FigurePart> parts = {{{0, 0.38}, {0, 0.34}, 0.085, 0.06},              // head
                                                {{-0.035, 0.385}, {-0.03, 0.385}, 0.014, 0.018},  // eyes
                                                {{0.03, 0.385}, {0.035, 0.385}, 0.014, 0.018},
                                                {{0, 0.375}, {0, 0.345}, 0.014, 0.03},        // nose
                                                {{-0.03, 0.31}, {0.03, 0.31}, 0.012, 0.016},  // mouth
                                                {{0, 0.18}, {0, 0.02}, 0.13, 0.055},          // trunk
                                                {{-0.17, 0.2}, {-0.24, 0.02}, 0.042, 0.04},   // arms
                                                {{-0.24, 0.02}, {-0.06, 0.06}, 0.036, 0.075},
                                                {{0.17, 0.2}, {0.26, 0.3}, 0.042, 0.04},
                                                {{0.26, 0.3}, {0.2, 0.44}, 0.036, 0.045},
                                                {{-0.08, -0.12}, {-0.12, -0.42}, 0.062, 0.05},  // legs
                                                {{0.08, -0.12}, {0.12, -0.42}, 0.062, 0.05},
                                                {{-0.16, -0.04}, {0.16, -0.04}, 0.03, 0.075}};  // belt
  const double height = p.at("height"), depth = p.at("relief") / 0.05;
  // Height of each part above the slab where it covers the point, the highest wins.
  auto highest = [=](double x, double y) {
    std::pair<double, int> best{0, 0};
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Eigen::Vector2d along = parts[i].to - parts[i].from, at = Eigen::Vector2d(x, y) / height;
      const double share = std::clamp((at - parts[i].from).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
      const double d = (parts[i].from + along * share - at).norm() / parts[i].radius;
      if (d >= 1) continue;
      // Small parts of the face lie on the head.
      const double base = i >= 1 && i <= 4 ? 0.048 : 0;
      best = std::max(best, {depth * (base + parts[i].height * std::sqrt(1 - d * d)), static_cast<int>(i) + 1});
    }
    return best;
  };
  HeightField field;
  field.high = Eigen::Vector2d(0.38, 0.56) * height;
  field.low = -field.high;
  field.columns = std::max(1, static_cast<int>(std::lround(0.76 * height / p.at("edge"))));
  field.rows = std::max(1, static_cast<int>(std::lround(1.12 * height / p.at("edge"))));
  const double hollow = 0.004 * height;
  field.height = [=](double x, double y) {
    return highest(x, y).first + hollow * std::sin(5 * x / height) * std::sin(4 * y / height + 1);
  };
  field.face = [=](double x, double y) { return highest(x, y).second + 1; };
  field.floor = -p.at("thickness");
  return height_field(field, static_cast<std::int32_t>(parts.size()) + 2);
}

const std::vector<Entry>& entries() {
  static const ShapeParameter tolerance{"tolerance", 0.002,
                                        "largest distance between the mesh and the true curved face"};
  static const std::vector<Entry> all = {
      {{"plane",
        "flat plate",
        {{"size", 40, "side"}, {"thickness", 3, "0: an open sheet"}, {"edge", 2, "side of a mesh cell"}},
        0.2,
        1,
        0},
       make_plane},
      {{"sphere",
        "ball",
        {{"radius", 10, "of the ball"}, {"level", 6, "times its mesh was refined, from 0"}},
        0.2,
        8,
        180},
       make_sphere},
      {{"cylinder",
        "cylinder with two discs",
        {{"radius", 8, "of the side"}, {"height", 30, "along z"}, tolerance},
        0.2,
        10,
        180},
       make_cylinder},
      {{"torus",
        "ring",
        {{"ring_radius", 15, "of the middle line"}, {"tube_radius", 5, "of the tube"}, tolerance},
        0.2,
        10,
        180},
       make_torus},
      {{"diamond",
        "pyramids side by side: facets between sharp edges",
        {{"cells", 4, "pyramids along a side"},
         {"cell", 10, "side of a pyramid"},
         {"height", 2.5, "of a pyramid"},
         {"thickness", 4, "of the slab below; 0: an open sheet"},
         {"edge", 1, "side of a mesh cell"}},
        0.2,
        3,
        40},
       make_diamond},
      {{"tablet",
        "slightly bulging tablet with engraved signs; face 1 is the groove, 2 the surface",
        {{"size", 30, "side"},
         {"glyphs", 5, "signs along a side"},
         {"glyph", 4.6, "size of a sign"},
         {"groove_width", 0.7, "of a stroke"},
         {"groove_depth", 0.2, "of a stroke"},
         {"rounding", 0.25, "of a groove's rim, in half widths"},
         {"bulge", 0.5, "height of the middle above the corners"},
         {"waviness", 0.1, "of the surface"},
         {"thickness", 6, "0: an open sheet"},
         {"edge", 0.06, "side of a mesh cell"}},
        0.17,
        3,
        25},
       make_tablet},
      {{"sherd",
        "stamped potsherd: ridges on a bent shell with a rounded, broken edge; face 1 is the ridges, 2 the rest",
        {{"size", 45, "side of the square that holds it"},
         {"bend_radius", 110, "of the vessel; 0: flat"},
         {"line_width", 2.2, "of a ridge"},
         {"pitch", 4.6, "between the middles of neighbouring ridges"},
         {"relief", 0.2, "height of a ridge where it is pressed most"},
         {"edge_rounding", 2, "radius of the broken edge"},
         {"roughness", 0.008, "of the clay: standard deviation, waves of 0.7 to 1.8 mm"},
         {"edge", 0.12, "side of a mesh cell"}},
        0.14,
        1,
        0},
       make_sherd},
      {{"pump", "pump housing: base plate, body, flange, pipe, ribs, bores", {tolerance}, 0.3, 19, 180}, make_pump},
      {{"bracket", "angle bracket: two plates, rib, countersunk bore, notch", {tolerance}, 0.25, 14, 180},
       make_bracket},
      {{"ribs",
        "ribs of growing width on a plate",
        {{"count", 5, "ribs"},
         {"thinnest", 0.6, "width of the first rib"},
         {"growth", 1.6, "of the width from rib to rib"},
         {"gap", 5, "between ribs"},
         {"height", 6, "of a rib"},
         {"base", 4, "thickness of the plate"},
         {"length", 30, "of a rib"}},
        0.2,
        10,
        75},
       make_ribs},
      {{"fillets",
        "steps with rounded edges; the radius grows from step to step",
        {{"count", 4, "steps"},
         {"radius", 1, "of the first fillet; the next ones are 2, 3 ... times as large"},
         {"rise", 2, "of the flat part of a step's wall"},
         {"land", 7, "depth of a step's flat part"},
         {"base", 4, "thickness below the first step"},
         {"length", 30, "of a step"},
         tolerance},
        0.2,
        10,
        75},
       make_fillets},
      {{"shallow",
        "strips that meet at shallow, growing angles",
        {{"count", 6, "angles"},
         {"angle", 4, "the first, in degrees"},
         {"growth", 4, "degrees from angle to angle"},
         {"strip", 6, "width of a strip"},
         {"base", 4, "thickness below the lowest strip"},
         {"length", 30, "of a strip"}},
        0.2,
        4,
        40},
       make_shallow},
      {{"turned", "turned knob with curved faces only", {{"height", 40, "along z"}, tolerance}, 0.2, 12, 180},
       make_turned},
      {{"vase",
        "vase with signs in relief; face 1 is the relief, 2 the body",
        {{"height", 80, "along z"},
         {"radius", 28, "about that of the belly"},
         {"relief", 0.5, "height of the relief"},
         {"line_width", 1.6, "of the relief's lines"},
         {"glyphs", 12, "signs around the belly"},
         {"edge", 0.2, "side of a mesh cell"}},
        0.4,
        12,
        110},
       make_vase},
      {{"figurine",
        "standing figure in low relief on a slab; face 1 is the slab's front",
        {{"height", 50, "of the figure"},
         {"relief", 2.5, "height of the trunk"},
         {"thickness", 5, "of the slab"},
         {"edge", 0.1, "side of a mesh cell"}},
        0.2,
        4,
        35},
       make_figurine}};
  return all;
}

const Entry& entry(const std::string& name) {
  for (const Entry& candidate : entries())
    if (candidate.info.name == name) return candidate;
  std::vector<std::string> names;
  for (const Entry& candidate : entries()) names.push_back(candidate.info.name);
  throw UsageError(fmt::format("unknown shape '{}'; known: {}", name, fmt::join(names, ", ")));
}

}  // namespace

const std::vector<ShapeInfo>& shape_catalogue() {
  static const std::vector<ShapeInfo> all = [] {
    std::vector<ShapeInfo> infos;
    for (const Entry& one : entries()) infos.push_back(one.info);
    return infos;
  }();
  return all;
}

const ShapeInfo& shape_info(const std::string& name) {
  return entry(name).info;
}

Shape make_shape(const std::string& name, const ShapeParameters& parameters) {
  const Entry& shape = entry(name);
  ShapeParameters values;
  for (const ShapeParameter& parameter : shape.info.parameters) values[parameter.name] = parameter.default_value;
  for (const auto& [parameter, value] : parameters) {
    const auto known = values.find(parameter);
    if (known == values.end()) {
      std::vector<std::string> names;
      for (const ShapeParameter& one : shape.info.parameters) names.push_back(one.name);
      throw UsageError(
          fmt::format("shape '{}' has no parameter '{}'; it has: {}", name, parameter, fmt::join(names, ", ")));
    }
    const bool may_be_zero = parameter == "thickness" || parameter == "bulge" || parameter == "waviness" ||
                             parameter == "growth" || parameter == "bend_radius" || parameter == "roughness" ||
                             parameter == "level" || parameter == "rounding";
    if (!std::isfinite(value) || value < 0 || (value == 0 && !may_be_zero))
      throw UsageError(fmt::format("shape '{}': {} = {:g} must be {}", name, parameter, value,
                                   may_be_zero ? "0 or more" : "above 0"));
    known->second = value;
  }
  Shape made = shape.make(values);
  renumber_faces(made);
  return made;
}

}  // namespace meshmser::scanner
